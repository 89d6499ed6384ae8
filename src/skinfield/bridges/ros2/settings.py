"""What of a skin goes to ROS 2, where and how often."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from skinfield.bridges.ros2.messages import SAID
from skinfield.bridges.ros2.rmw_zenoh import DOMAINS
from skinfield.bridges.zenoh.session import ZenohSettings
from skinfield.errors import InputError, check_choice, check_count, check_range, check_type
from skinfield.sinks.ros.names import check_prefix, token_of

ROUTER = "tcp/localhost:7447"  # of rmw_zenohd, where rmw_zenoh's nodes meet
HERE = "tcp/localhost:0"
RATES = dict.fromkeys(SAID, 100.0) | {"taxels": 20.0, "diagnostics": 1.0}
FASTEST = 10_000.0  # 1/s
USUAL = "robot"  # a robot that was not named
HUMBLE, USUAL_DISTRIBUTION = "humble", "jazzy"
DISTRIBUTIONS = (HUMBLE, USUAL_DISTRIBUTION, "kilted", "lyrical", "rolling")


@dataclass(frozen=True, kw_only=True)
class RosSettings:
    """What is published, where and how often.

    Parameters
    ----------
    robot : str
        Its name comes before topics: `/left_arm/skin/...`; for "robot", just `/skin/...`.
    domain : int, optional
        Default the environment's ROS_DOMAIN_ID, else 0.
    distribution : str, optional
        Of ROS 2: "humble", which knows no hashes of types, or a later one. Default the
        environment's ROS_DISTRO.
    rates : dict of str to float, 1/s
        Most messages a second of each of `contacts`, `frames`, `contact_wrench`, `wrench`,
        `taxels`, `diagnostics`; 0: none. What is not given is as in `RATES`.
    session : ZenohSettings
        Without addresses, the router of ROS 2 on this machine.
    """

    robot: str = USUAL
    domain: int | None = None
    distribution: str | None = None
    rates: Mapping[str, float] = field(default_factory=dict)
    session: ZenohSettings = field(default_factory=ZenohSettings)

    def __post_init__(self) -> None:
        check_type("robot", self.robot, str, "a name such as left_arm")
        check_type("rates", self.rates, Mapping, "messages a second by what is published")
        if self.distribution is None:
            here = os.environ.get("ROS_DISTRO")
            made = HUMBLE if here == HUMBLE else USUAL_DISTRIBUTION
            object.__setattr__(self, "distribution", made)
        check_type("distribution", self.distribution, str, "a name such as jazzy")
        check_choice("distribution", str(self.distribution), DISTRIBUTIONS, "that of ROS 2")
        for what, rate in self.rates.items():
            check_choice("rates", what, SAID, "what is published")
            check_range(f"rates[{what!r}]", rate, 0.0, FASTEST, "messages a second")
        object.__setattr__(self, "rates", RATES | dict(self.rates))
        if self.domain is None:
            object.__setattr__(self, "domain", _domain_here())
        check_count("domain", self.domain or 0, 0, DOMAINS, "the ROS_DOMAIN_ID")
        check_prefix(self.prefix)

    @property
    def hashed(self) -> bool:
        """Whether keys have the hashes of types."""
        return self.distribution != HUMBLE

    @property
    def namespace(self) -> str:
        """Of the node: that of the robot, "" if it was not named."""
        return "" if self.robot == USUAL else f"/{token_of(self.robot, 'robot')}"

    @property
    def prefix(self) -> str:
        """Before the skin's topics."""
        return f"{self.namespace}/skin"

    @property
    def meeting(self) -> ZenohSettings:
        """The session's settings, as rmw_zenoh's own where nothing is said."""
        if not self.session.local:
            return self.session
        return replace(self.session, listen=(HERE,), connect=(ROUTER,))

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "RosSettings":
        """Settings of a JSON object.

        Raises
        ------
        InputError
            If it has others, or one is meaningless.
        """
        names = tuple(cls.__dataclass_fields__)
        strange = sorted(set(plain) - set(names))
        if strange:
            raise InputError(f"settings have {strange[0]!r}, expected some of {', '.join(names)}")
        values: dict[str, Any] = dict(plain)
        values["session"] = ZenohSettings.from_plain(values.get("session", {}))
        return cls(**values)


def _domain_here() -> int:
    text = os.environ.get("ROS_DOMAIN_ID", "") or "0"
    if not (text.isascii() and text.isdigit()):
        raise InputError(f"ROS_DOMAIN_ID is {text!r}, expected a whole number from 0 to 232")
    return int(text)
