"""What a virtual skin is made of, as text and numbers, so that another process can be told."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from skinfield.errors import (
    InputError,
    check_choice,
    check_count,
    check_positive,
    check_range,
    check_type,
)
from skinfield.mechanics import Layer
from skinfield.virtual.faults import Fault, fault_from_text
from skinfield.virtual.temperature import Temperature

HARDWARE = ("icub", "cyskin", "packet", "yarp")
CAN_BUSES = ("udp_multicast", "udp", "socketcan")
STREAMS = ("udp", "tcp", "serial")


@dataclass(frozen=True, kw_only=True)
class Wires:
    """What happens to messages on their way.

    Parameters
    ----------
    lose, duplicate, swap : float
        Probability, per message. A swapped message comes after the one that follows it.
    delay : float, s
        From the conversion of a reading to its sending.
    jitter : float, s
        Mean of an exponentially distributed further delay of each board's reading; readings of a
        board never overtake each other by it.
    """

    lose: float = 0.0
    duplicate: float = 0.0
    swap: float = 0.0
    delay: float = 0.0
    jitter: float = 20e-6

    def __post_init__(self) -> None:
        for name in ("lose", "duplicate", "swap"):
            check_range(name, getattr(self, name), 0.0, 1.0, "a probability per message; 0 is off")
        for name in ("delay", "jitter"):
            check_range(name, getattr(self, name), 0.0, 60.0, "seconds; 0 is off")


@dataclass(frozen=True, kw_only=True)
class VirtualSettings:
    """Settings of a `VirtualSkin`; all of them are text, numbers and tables, see `to_json`.

    Parameters
    ----------
    hardware : "icub", "cyskin", "packet" or "yarp"
        Whose boards it plays; "yarp": an iCub's ports behind them.
    skin : str
        Layout file, folder, or generator by name such as ``"hexagon72"``.
    bus : str
        For iCub and CySkin: `udp_multicast`, `udp`, `socketcan` or an interface of python-can. For
        packets: `udp`, `tcp` or `serial` (a pseudo-terminal). For yarp: `tcp`.
    channels : tuple of str
        Where. For `udp_multicast`: ``"239.74.163.2:43113"``, group and port; for `udp` and `tcp`:
        ``"127.0.0.1:0"``, where it is reached (port 0: any that is free); for `socketcan`:
        ``can0``; for `serial`: a path for a link to the pseudo-terminal. As many as buses.
    rate : float, 1/s, optional
        Readings of each board. Default what the host asks for, or the board's own.
    at_once : bool
        Stream without waiting for a host to start it.
    scene : str
        One of `scenes.SCENES`, or the path of a scene's file.
    lead_in : float, s
        Without a press, after the stream began, so that a host can take its baseline.
    layer : Layer
        Elastomer that is pressed.
    noise : float
        Times that of real boards, see `electronics_of`. 0: none.
    common_noise : float, counts
        Of white noise that the taxels of one converter share.
    gain_spread, converter_gain_spread : float
        Of the logarithm of gains, per taxel and shared by a converter.
    temperature : Temperature
        Of the surroundings over time.
    pads : bool
        Whether an iCub's thermal pads feel the warmth as the taxels do.
    mtb3 : bool
        Boards of iCub's older generation, which round negative drifts otherwise.
    spread : bool
        Boards send one after the other over the period, not all at its start.
    wires : Wires
    faults : tuple of Fault
        With their times.
    seed : int
    control : str
        Address of the control socket, ``"127.0.0.1:0"``; empty for none.
    truth : str
        File for the truth; empty for none.
    duration : float, s, optional
        After which it ends.
    priority : int
        Of SCHED_FIFO, where that is permitted: readings are on time beside other work. 0: not
        asked for.
    """

    hardware: str = "icub"
    skin: str = "hexagon72"
    bus: str = "udp_multicast"
    channels: tuple[str, ...] = ()
    rate: float | None = None
    at_once: bool = False
    scene: str = "press"
    lead_in: float = 3.0
    layer: Layer = field(default_factory=Layer)
    noise: float = 0.3
    common_noise: float = 0.0
    gain_spread: float = 0.0
    converter_gain_spread: float = 0.0
    temperature: Temperature = field(default_factory=Temperature)
    pads: bool = True
    mtb3: bool = False
    spread: bool = False
    wires: Wires = field(default_factory=Wires)
    faults: tuple[Fault, ...] = ()
    seed: int = 0
    control: str = "127.0.0.1:0"
    truth: str = ""
    duration: float | None = None
    priority: int = 0

    def __post_init__(self) -> None:
        check_choice("hardware", self.hardware, HARDWARE, "whose boards it plays")
        if self.hardware == "packet":
            check_choice("bus", self.bus, STREAMS, "what packets travel by")
        if self.hardware == "yarp":
            check_choice("bus", self.bus, ("tcp",), "what ports of YARP are reached by")
        for name in ("skin", "bus", "scene", "control", "truth"):
            check_type(name, getattr(self, name), str, "text")
        object.__setattr__(self, "channels", tuple(self.channels))
        object.__setattr__(
            self,
            "faults",
            tuple(f if isinstance(f, Fault) else fault_from_text(f) for f in self.faults),
        )
        if self.rate is not None:
            check_range("rate", self.rate, 0.01, 20e3, "readings per second")
        if self.duration is not None:
            check_positive("duration", self.duration, "in seconds")
        check_range("lead_in", self.lead_in, 0.0, 1e6, "seconds; 0 is off")
        check_range("noise", self.noise, 0.0, 1e3, "times that of real boards; 0 is off")
        check_range("common_noise", self.common_noise, 0.0, 1e6, "counts; 0 is off")
        for name in ("gain_spread", "converter_gain_spread"):
            check_range(name, getattr(self, name), 0.0, 3.0, "of a logarithm; 0.1 is about 10 %")
        check_count("priority", self.priority, 0, 99, "of SCHED_FIFO; 0 is not asked for")
        check_count("seed", self.seed, 0, 1 << 63, "of all that is random")

    def to_json(self) -> str:
        """As one line of JSON; `settings_from_json` reads it."""
        return json.dumps(asdict(self))


def settings_from_json(text: str) -> VirtualSettings:
    """Settings from `VirtualSettings.to_json`.

    Raises
    ------
    InputError
        If it is none, or a value cannot be used.
    """
    try:
        given = json.loads(text)
    except ValueError as error:
        raise InputError(f"settings are no JSON: {error}") from error
    return settings_from(given)


def settings_from(given: Any) -> VirtualSettings:
    """Settings from a mapping of their names, the smaller ones as mappings of theirs."""
    nested = {"layer": Layer, "temperature": Temperature, "wires": Wires}
    values = dict(_known(given, VirtualSettings))
    for name, kind in nested.items():
        if name in values:
            values[name] = kind(**_known(values[name], kind))
    if "channels" in values:
        values["channels"] = tuple(str(each) for each in values["channels"])
    if "faults" in values:
        values["faults"] = tuple(
            fault_from_text(each) if isinstance(each, str) else Fault(**_known(each, Fault))
            for each in values["faults"]
        )
    try:
        return VirtualSettings(**values)
    except TypeError as error:
        raise InputError(f"settings {given!r:.200} cannot be used: {error}") from error


def _known(given: Any, kind: type) -> Mapping[str, Any]:
    names = [each.name for each in fields(kind)]
    if not isinstance(given, Mapping):
        raise InputError(
            f"{kind.__name__} is {given!r:.80}, expected a table of {', '.join(names)}"
        )
    unknown = sorted(set(given) - set(names))
    if unknown:
        raise InputError(f"{unknown[0]!r} is no setting, expected one of {', '.join(names)}")
    return given
