"""Settings of bridges: which there are, and how they meet others."""

import re
from dataclasses import dataclass
from typing import Annotated

from skinfield.settings import Range, Section, SettingError, pair_from_text

_ROBOT = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


@dataclass(frozen=True, kw_only=True)
class ZenohAddresses(Section):
    """How to meet others over zenoh.

    Parameters
    ----------
    zenoh : bool
        Publish estimates and contacts over zenoh, or look for them, see docs/how-to/zenoh.md.
    zenoh_listen : tuple of str
        Where others may connect, such as tcp/0.0.0.0:7447; again for more. Without any address,
        only programs on this machine take part.
    zenoh_connect : tuple of str
        Others to connect to, such as tcp/robot:7447; again for more.
    zenoh_config : str, optional
        Settings of zenoh (JSON5): certificates, access control, see docs/how-to/zenoh.md.
    """

    zenoh: bool = False
    zenoh_listen: tuple[str, ...] = ()
    zenoh_connect: tuple[str, ...] = ()
    zenoh_config: str | None = None

    @property
    def addressed(self) -> bool:
        """Whether anything says where to meet others."""
        return bool(self.zenoh_listen or self.zenoh_connect or self.zenoh_config)


@dataclass(frozen=True, kw_only=True)
class BridgeSettings(ZenohAddresses):
    """Where estimates go besides: to zenoh, ROS 2, YARP; see also `ZenohAddresses`.

    Parameters
    ----------
    robot : str
        Name of the whole robot, in keys and topics.
    ros2 : bool
        Publish as rmw_zenoh does, see docs/how-to/ros2.md.
    ros_rate : tuple of str
        With ros2, such as wrench=500: most messages a second of contacts, frames, wrench,
        contact_wrench, taxels or diagnostics; 0: none. Again for more.
    ros_domain : int, optional
        With ros2. Default $ROS_DOMAIN_ID, or 0.
    yarp : bool
        Publish skin_events as YARP does.
    yarp_name_server : str, optional
        Address of YARP's name server; default localhost:10000.
    """

    robot: str = "robot"
    ros2: bool = False
    ros_rate: tuple[str, ...] = ()
    ros_domain: Annotated[int | None, Range(0, 232, "the ROS_DOMAIN_ID")] = None
    yarp: bool = False
    yarp_name_server: str | None = None

    def check(self) -> None:
        """See `Section`."""
        if self.addressed and not (self.zenoh or self.ros2):
            raise SettingError(
                "zenoh", "is off and addresses of it were given, expected zenoh or ros2 with them"
            )
        for name in ("ros_domain", "ros_rate"):
            if getattr(self, name) not in (None, ()) and not self.ros2:
                raise SettingError(name, "was given, expected ros2 with it")
        if self.yarp_name_server is not None and not self.yarp:
            raise SettingError("yarp_name_server", "was given, expected yarp with it")
        if not _ROBOT.fullmatch(self.robot):
            raise self.wrong("robot", "letters, digits, '_', '-' and '.', at most 64")
        self.ros_rates  # noqa: B018 - refuses what is no WHAT=HZ

    @property
    def ros_rates(self) -> dict[str, float]:
        """Most messages a second, by what they hold."""
        found = {}
        for text in self.ros_rate:
            what, rate = pair_from_text("ros_rate", text, "wrench=500")
            try:
                found[what] = float(rate)
            except ValueError as error:
                raise SettingError(
                    "ros_rate", f"is {text!r}, expected such as wrench=500: messages a second"
                ) from error
        return found
