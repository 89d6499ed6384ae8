"""Publisher to ROS 2 as rmw_zenoh does it: no ROS is needed here; with its settings."""

import itertools
import os
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from typing import Any

from skinfield.bridges.child import say_ready
from skinfield.bridges.ros2.messages import LOOKS, SAID, Channel, Speaker, Talker
from skinfield.bridges.ros2.rmw_zenoh import DOMAINS, NO_HASH, Node, Publication, attachment
from skinfield.bridges.zenoh.session import ZenohSettings, load_zenoh, open_session
from skinfield.errors import InputError, check_choice, check_count, check_range
from skinfield.files.ros.kinds import RosbagKinds
from skinfield.files.ros.messages import Outgoing
from skinfield.files.ros.names import Topics, check_prefix, token_of
from skinfield.loop.client import connect

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
        if self.distribution is None:
            here = os.environ.get("ROS_DISTRO")
            made = HUMBLE if here == HUMBLE else USUAL_DISTRIBUTION
            object.__setattr__(self, "distribution", made)
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


def _domain_here() -> int:
    text = os.environ.get("ROS_DOMAIN_ID", "") or "0"
    if not (text.isascii() and text.isdigit()):
        raise InputError(f"ROS_DOMAIN_ID is {text!r}, expected a whole number from 0 to 232")
    return int(text)


class Ros2Publisher:
    """Declares a node and all its topics, and sends messages.

    Parameters
    ----------
    session : zenoh.Session
    node : Node
    channels : sequence of Channel
    kinds : RosbagKinds
    hashed : bool
        Whether the types' hashes are in the keys; Humble has none.
    ends : ExitStack
        Where everything is undeclared.
    """

    def __init__(
        self,
        session: Any,
        node: Node,
        channels: list[Channel],
        kinds: RosbagKinds,
        hashed: bool,
        ends: ExitStack,
    ) -> None:
        zenoh = load_zenoh()
        self._kinds = kinds
        self._outlets: dict[str, tuple[Publication, Any, Iterator[int]]] = {}
        self._token(session, node.token, ends)
        for number, channel in enumerate(channels, 1):
            told = kinds.hash_of(channel.kind) if hashed else NO_HASH
            each = Publication(node, number, channel.topic, channel.kind, told, channel.depth)
            outlet = session.declare_publisher(
                each.key,
                congestion_control=zenoh.CongestionControl.DROP,  # nobody is waited for
                reliability=zenoh.Reliability.RELIABLE,
            )
            ends.callback(outlet.undeclare)
            self._token(session, each.token, ends)
            self._outlets[channel.topic] = each, outlet, itertools.count(1)

    def _token(self, session: Any, key: str, ends: ExitStack) -> None:
        ends.callback(session.liveliness().declare_token(key).undeclare)

    def send(self, out: Outgoing) -> None:
        """Send a message to whoever listens."""
        publication, outlet, numbers = self._outlets[out.topic]
        outlet.put(
            self._kinds.bytes_of(out.kind, out.message),
            attachment=attachment(next(numbers), time.time_ns(), publication.gid),
        )


def serve(name: str, settings: RosSettings, stop: threading.Event) -> None:
    """Publish a running skin until told to stop; see `skinfield.bridges.child`."""
    with ExitStack() as ends:
        live = ends.enter_context(connect(name, timeout=10.0))
        kinds = RosbagKinds()
        speaker = Speaker(live.skin, kinds, Topics.of(live.skin, settings.prefix))
        session = ends.enter_context(open_session(settings.meeting))
        who = token_of(f"skinfield_{name}")
        node = Node(who, str(session.zid()), settings.domain or 0, settings.namespace)
        channels = [each for each in speaker.channels() if settings.rates[each.what] > 0]
        publisher = Ros2Publisher(session, node, channels, kinds, settings.hashed, ends)
        say_ready(
            node=node.name,
            domain=node.domain,
            distribution=settings.distribution,
            prefix=settings.prefix,
            topics=len(channels),
            connect=list(settings.meeting.connect),
            listen=list(settings.meeting.listen),
        )
        talker = Talker(live, speaker, settings.rates, publisher.send)
        while not stop.wait(talker.wait()):
            talker.step(LOOKS)
