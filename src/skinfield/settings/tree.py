"""Settings of a live skin: one tree of typed values, with their units in their names.

The same tree is a TOML file, the command line and the JSON in a recording: a field's name is its
key there, and its flag with dashes. Each value is checked when its section is made.
"""

import hmac
import ipaddress
import re
import secrets
from contextlib import suppress
from dataclasses import dataclass, field, fields
from functools import cache
from math import inf
from typing import Annotated, Any, Literal, NamedTuple, get_type_hints

from skinfield.errors import InputError, check_count, check_positive, check_range

LiveSolverName = Literal["gaussian", "nonnegative", "tikhonov", "pseudo-inverse", "inverse"]
SolverName = Literal[LiveSolverName, "contact"]
MechanicsName = Literal["layer", "covered-layer", "half-space"]
QuantityName = Literal["capacitance", "gap", "stress"]
PORT = 8700  # of the page, where it is free
FASTEST = 1e5  # cycles per second
SHORTEST_TOKEN = 8  # characters
_ROBOT = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


class SettingError(InputError):
    """A value of a setting that cannot be used.

    Parameters
    ----------
    name : str
        Of the field.
    text : str
        What is wrong, from the value on.
    """

    def __init__(self, name: str, text: str) -> None:
        super().__init__(f"{name} {text}")
        self.name, self.text = name, text


class Positive(NamedTuple):
    """A finite number above 0."""

    why: str

    def check(self, name: str, value: Any) -> None:
        """Raise InputError unless it is one."""
        check_positive(name, value, self.why)


class Range(NamedTuple):
    """A number, or a whole number, from `low` to `high`."""

    low: float
    high: float
    why: str

    def check(self, name: str, value: Any) -> None:
        """Raise InputError unless it is one."""
        if isinstance(self.low, int) and isinstance(self.high, int):
            check_count(name, value, self.low, self.high, self.why)
        else:
            check_range(name, value, self.low, self.high, self.why)


@cache
def _checks(section: Any) -> tuple[tuple[str, Positive | Range], ...]:
    hints = get_type_hints(section, include_extras=True)
    return tuple(
        (each.name, check)
        for each in fields(section)
        for check in getattr(hints[each.name], "__metadata__", ())
        if isinstance(check, Positive | Range)
    )


@dataclass(frozen=True, kw_only=True)
class Section:
    """Part of the settings; its values are checked as their annotations say."""

    def __post_init__(self) -> None:
        kind: Any = type(self)  # a class, which mypy takes for no Hashable here
        for name, check in _checks(kind):
            value = getattr(self, name)
            if value is None:
                continue
            try:
                check.check(name, value)
            except InputError as error:
                raise SettingError(name, str(error).removeprefix(f"{name} ")) from error
        self.check()

    def check(self) -> None:
        """Raise SettingError where values do not fit each other."""

    def wrong(self, name: str, expected: str) -> SettingError:
        """Error about a value."""
        return SettingError(name, f"is {getattr(self, name)!r}, expected {expected}")


@dataclass(frozen=True, kw_only=True)
class Elastomer(Section):
    """What is known of the elastomer; what is left out is the profile's.

    Parameters
    ----------
    profile : str
        Whose skin it is: generic, icub, cyskin, silicone-2mm, or a file (.toml); auto goes by the
        boards and the layout.
    thickness_mm : float, mm, optional
        Thickness of the elastomer, mm.
    modulus_kpa : float, kPa, optional
        Young's modulus, kPa.
    poisson : float, optional
        Poisson's ratio, 0 to 0.5.
    """

    profile: str = "auto"
    thickness_mm: Annotated[float | None, Positive("thickness of the elastomer")] = None
    modulus_kpa: Annotated[float | None, Positive("Young's modulus")] = None
    poisson: Annotated[float | None, Range(0.0, 0.5, "Poisson's ratio")] = None


@dataclass(frozen=True, kw_only=True)
class SkinSettings(Elastomer):
    """Where the taxels are, under what, and what a count means; see also `Elastomer`.

    Parameters
    ----------
    layout : str
        Layout file, or a generator by name.
    gain : float, optional
        Counts per unit of ΔC/C₀; negative where pressure lowers them.
    no_load : int, optional
        What an iCub byte rests at.
    """

    layout: str = "hexagon72"
    gain: float | None = None
    no_load: Annotated[int | None, Range(1, 255, "what an iCub byte rests at")] = None

    def check(self) -> None:
        """See `Section`."""
        if self.gain is not None and not (0 < abs(self.gain) < inf):
            raise self.wrong("gain", "counts per unit of ΔC/C₀, not 0")


@dataclass(frozen=True, kw_only=True)
class SourceSettings(Section):
    """Where readings come from; without hardware, a virtual skin that is started for it.

    Parameters
    ----------
    hardware : str, optional
        Whose boards: icub, yarp, cyskin, packet. Without it a virtual skin is started.
    bus : str, optional
        How it is connected: udp (CAN in UDP), socketcan, serial ...
    channel : tuple of str
        Of the bus: can0, an address and port, a device; again for several buses.
    options : tuple of str
        A setting of the source, such as config=robot.xml; again for more.
    scene : str
        What presses the virtual skin.
    virtual_rate_hz : float, 1/s
        Readings of the virtual skin per second.
    seed : int
        Of the virtual skin's noise.
    """

    hardware: str | None = None
    bus: str | None = None
    channel: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    scene: str = "press"
    virtual_rate_hz: Annotated[float, Positive("readings per second")] = 100.0
    seed: Annotated[int, Range(0, 1 << 63, "of the virtual skin's noise")] = 0

    def check(self) -> None:
        """See `Section`."""
        self.named_options  # noqa: B018 - refuses what is no KEY=VALUE

    @property
    def named_options(self) -> dict[str, str]:
        """Further settings of the source, by name."""
        return dict(pair_from_text("options", text, "config=robot.xml") for text in self.options)


@dataclass(frozen=True, kw_only=True)
class ModelSettings(Section):
    """What a taxel reads of a traction, and how that is inverted.

    Parameters
    ----------
    solver : str, optional
        How readings become pressure; contact fits the fewest contacts instead. Default gaussian.
    mechanics : str, optional
        Model of the elastomer; the paper's is the half-space. Default the profile's.
    quantity : str, optional
        What a taxel reads. Default what the recording's unit says, else capacitance.
    grid : int, optional
        Nodes on a side of the finest grid. Default by pitch and extent of the patch.
    """

    solver: SolverName | None = None
    mechanics: MechanicsName | None = None
    quantity: QuantityName | None = None
    grid: Annotated[int | None, Range(4, 1000, "4 nodes on a side or more")] = None


@dataclass(frozen=True, kw_only=True)
class LiveModelSettings(ModelSettings):
    """The same of a live skin, whose contacts are fitted beside the solver; see `ModelSettings`.

    Parameters
    ----------
    solver : str, optional
        How readings become pressure. Default nonnegative.
    """

    solver: LiveSolverName | None = None


@dataclass(frozen=True, kw_only=True)
class LoopSettings(Section):
    """When cycles are, what they publish, and what is asked of the system.

    Parameters
    ----------
    name : str
        By which other programs find it.
    rate_hz : float, 1/s
        Cycles per second.
    events : bool
        A cycle when readings arrive, at no rate.
    deadline_us : float, µs, optional
        Time for the reconstruction in each cycle, µs.
    late_after_ms : float, ms, optional
        When an estimate counts as late, ms; by default after one period.
    threshold_n : float, N
        Contacts of a smaller force are not published, N.
    smoothing_ms : float, ms
        Time constant of a low-pass of what each taxel reads, ms; 0: none.
    tare_s : float, s
        Time of an untouched skin at the start, for its baseline, s.
    fit : bool
        Fit contacts beside the engine: surer places and forces, some 10 ms later.
    priority : int
        Of SCHED_FIFO, where it is granted; 0: not asked for.
    cpu : int, optional
        Processor to pin the engine to. Default an isolated one.
    """

    name: str = "skin"
    rate_hz: Annotated[
        float, Positive("cycles per second; or events: a cycle when readings arrive")
    ] = 1000.0
    events: bool = False
    deadline_us: Annotated[float | None, Positive("microseconds")] = None
    late_after_ms: Annotated[float | None, Positive("milliseconds")] = None
    threshold_n: Annotated[float, Range(0.0, 5.0, "N, of contacts")] = 0.0
    smoothing_ms: Annotated[float, Range(0.0, 1000.0, "ms; 0: none")] = 0.0
    tare_s: Annotated[float, Positive("seconds of an untouched skin")] = 1.0
    fit: bool = True
    priority: Annotated[int, Range(0, 99, "of SCHED_FIFO; 0: not asked for")] = 80
    cpu: Annotated[int | None, Range(0, 1 << 16, "number of a processor")] = None

    def check(self) -> None:
        """See `Section`."""
        if self.rate_hz > FASTEST:
            raise self.wrong("rate_hz", f"{FASTEST:g} cycles per second at most")
        period = 1e6 / self.rate_hz
        if self.deadline_us is not None and not self.events and self.deadline_us >= period:
            raise self.wrong(
                "deadline_us",
                f"less than the period of {period:g} µs at {self.rate_hz:g} cycles per second: "
                "taking in readings needs time too",
            )


@dataclass(frozen=True, kw_only=True)
class PageSettings(Section):
    """Where the page is served, and to whom.

    Parameters
    ----------
    host : str
        Address of this machine to serve the page on; 0.0.0.0 lets others open it.
    port : int, optional
        Of the page; 0 lets the system choose. Default 8700, or another that is free.
    token : str
        That the page's address must hold, `/?token=...`: needed with another host.
    browser : bool
        Open the page in a browser.

    Raises
    ------
    InputError
        If others could reach it, and there is no token of 8 characters or more.
    """

    host: str = "127.0.0.1"
    port: Annotated[int | None, Range(0, 65535, "0 lets the system choose")] = None
    token: str = ""
    browser: bool = True

    def check(self) -> None:
        """See `Section`."""
        if self.host == "localhost":  # else two addresses, with a port of its own each
            object.__setattr__(self, "host", "127.0.0.1")
        if not self.is_here and len(self.token) < SHORTEST_TOKEN:
            raise SettingError(
                "host",
                f"is {self.host!r}, which others can reach, and token has {len(self.token)} "
                f"characters, expected {SHORTEST_TOKEN} or more: whoever opens the page can "
                f"press, tare and record. For example --token {secrets.token_hex(12)}",
            )

    @property
    def is_here(self) -> bool:
        """Whether only this machine can reach it."""
        with suppress(ValueError):
            return ipaddress.ip_address(self.host.strip("[]")).is_loopback
        return False

    def allows(self, token: str) -> bool:
        """Whether this is the token, if one is asked for."""
        return not self.token or hmac.compare_digest(token.encode(), self.token.encode())


@dataclass(frozen=True, kw_only=True)
class ZenohAddresses(Section):
    """How to meet others over zenoh.

    Parameters
    ----------
    zenoh : bool
        Publish estimates and contacts over zenoh, or look for them, see docs/zenoh.md.
    zenoh_listen : tuple of str
        Where others may connect, such as tcp/0.0.0.0:7447; again for more. Without any address,
        only programs on this machine take part.
    zenoh_connect : tuple of str
        Others to connect to, such as tcp/robot:7447; again for more.
    zenoh_config : str, optional
        Settings of zenoh (JSON5): certificates, access control, see docs/zenoh.md.
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
        Publish as rmw_zenoh does, see docs/ros2.md.
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


@dataclass(frozen=True, kw_only=True)
class RecordSettings(Section):
    """Into which file the skin is recorded.

    Parameters
    ----------
    into : str, optional
        Record into this MCAP file.
    """

    into: str | None = None


@dataclass(frozen=True, kw_only=True)
class Settings(Section):
    """All settings of a live skin, section by section."""

    skin: SkinSettings = field(default_factory=SkinSettings)
    source: SourceSettings = field(default_factory=SourceSettings)
    model: LiveModelSettings = field(default_factory=LiveModelSettings)
    loop: LoopSettings = field(default_factory=LoopSettings)
    page: PageSettings = field(default_factory=PageSettings)
    bridges: BridgeSettings = field(default_factory=BridgeSettings)
    record: RecordSettings = field(default_factory=RecordSettings)


def pair_from_text(name: str, text: str, example: str) -> tuple[str, str]:
    """Key and value of "key=value"."""
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise SettingError(name, f"is {text!r}, expected KEY=VALUE, such as {example}")
    return key, value
