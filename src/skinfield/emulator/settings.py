"""Settings of the virtual skin with its temperature and faults, as text and numbers."""

import math
import re
from dataclasses import dataclass, field
from typing import Annotated

from skinfield.elastic import Layer
from skinfield.errors import InputError, check_choice, check_type
from skinfield.settings.tree import Positive, Range, Section

ROOM = 25.0
NUMBER = r"[+-]?\d+(?:\.\d*)?"
PROFILE_PATTERN = re.compile(
    rf"(?P<start>{NUMBER})(?:(?P<how>\.\.|~)(?P<change>{NUMBER})@(?P<seconds>\d+(?:\.\d*)?)s)?"
)
PROFILE_SYNTAX = (
    "25 (constant, °C), 25..35@600s (to 35 °C in 600 s) or 25~3@300s (± 3 K with a period)"
)
KINDS = {
    "unplug": "triangle",  # a triangle, or a module of CySkin
    "reboot": "board",  # silent, then as after switching on
    "bus-off": "bus",  # the whole bus is gone
    "dead": "taxel",  # sends its count at rest
    "stuck": "taxel",  # keeps the count that it has
    "noisy": "taxel",  # ten times the noise
    "saturated": "taxel",  # at the clamp of full load
    "no-ack": "taxel",  # the converter does not answer
}
SECONDS = {"ms": 1e-3, "s": 1.0, "min": 60.0}
TIME = r"(?:\d+(?:\.\d*)?)(?:ms|s|min)"
FAULT_PATTERN = re.compile(rf"(?P<what>[^@+]*?)(?:@(?P<start>{TIME}))?(?:\+(?P<seconds>{TIME}))?")
FAULT_SYNTAX = (
    "WHAT[@START][+SECONDS] with times such as 10s, 250ms or 2min: 3@10s is number 3 from 10 s "
    "on, 3@10s+5s for 5 s"
)
FOREVER = 1e9  # s
HARDWARE = ("icub", "cyskin", "packet")
STREAMS = ("udp", "tcp", "serial")
PROBABILITY = Range(0.0, 1.0, "a probability per message; 0 is off")
Chance = Annotated[float, PROBABILITY]
Late = Annotated[float, Range(0.0, 60.0, "seconds; 0 is off")]


@dataclass(frozen=True)
class Temperature(Section):
    """Constant, rising once, or a sine.

    Parameters
    ----------
    start : float, °C
        When boards take their base.
    change : float, K
        Of a rise, or the amplitude of a sine.
    seconds : float, s
        Of a rise, or the period of a sine.
    sine : bool
    """

    start: Annotated[float, Range(-60.0, 150.0, "degrees Celsius")] = ROOM
    change: Annotated[float, Range(-200.0, 200.0, "kelvin")] = 0.0
    seconds: Annotated[float, Positive("of the rise, or of the sine's period")] = 1.0
    sine: bool = False

    def warmth(self, time: float) -> float:
        """K above 25 °C at a time, s, since the stream began."""
        part = min(max(time / self.seconds, 0.0), 1.0)
        if self.sine:
            part = math.sin(2.0 * math.pi * time / self.seconds)
        return self.start - ROOM + self.change * part


def temperature_from_text(text: str) -> Temperature:
    """Temperature from the words of a command line, see `PROFILE_SYNTAX`.

    Raises
    ------
    InputError
        For any other text.
    """
    found = PROFILE_PATTERN.fullmatch(text.strip())
    if found is None:
        raise InputError(f"temperature is {text!r}, expected {PROFILE_SYNTAX}")
    start = float(found["start"])
    if found["how"] is None:
        return Temperature(start)
    number, seconds = float(found["change"]), float(found["seconds"])
    sine = found["how"] == "~"
    return Temperature(start, number if sine else number - start, seconds, sine)


@dataclass(frozen=True)
class Fault(Section):
    """A fault that begins and, perhaps, ends.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    what : str
        Number of the triangle, board, bus or taxel; of several patches or boards ``board.triangle``
        and ``patch/taxel``. A run is ``3-7``, all are ``*``.
    start : float, s
        Since the stream began.
    seconds : float, s
        For how long; infinite: until it is cleared. Of a reboot, for how long the board is silent.
    """

    kind: str
    what: str = "0"
    start: Annotated[float, Range(0.0, 1e9, "seconds since the stream began")] = 0.0
    seconds: Annotated[float, Range(0.0, FOREVER, "for how long the fault lasts")] = FOREVER

    def check(self) -> None:
        """See `Section`."""
        check_choice("kind", self.kind, KINDS, "of a fault")
        check_type("what", self.what, str, "the number of what fails")

    @property
    def end(self) -> float:
        """When it ends, s since the stream began."""
        return self.start + self.seconds


def fault_from_text(text: str) -> Fault:
    """Fault from ``"unplug 3@10s+5s"``: its kind, and what stands in `FAULT_SYNTAX`.

    Raises
    ------
    InputError
        For any other text.
    """
    kind, _, rest = text.strip().partition(" ")
    found = FAULT_PATTERN.fullmatch(rest.strip())
    if found is None:
        raise InputError(f"{kind} is {rest!r}, expected {FAULT_SYNTAX}")
    start = _seconds(found["start"]) if found["start"] else 0.0
    lasting = 2.0 if kind == "reboot" else FOREVER
    if found["seconds"]:
        lasting = _seconds(found["seconds"])
    return Fault(kind, found["what"].strip() or "0", start, lasting)


def _seconds(text: str) -> float:
    number = text.rstrip("mins")
    return float(number) * SECONDS[text[len(number) :]]


def numbers_of(text: str, count: int, name: str) -> list[int]:
    """Whole numbers below `count` from ``"3"``, ``"3-7"`` or ``"*"``.

    Raises
    ------
    InputError
        If it is none of them.
    """
    low, dash, high = text.strip().partition("-")
    if text.strip() == "*":
        return list(range(count))
    digits = low.isdecimal() and (high.isdecimal() or not dash) and len(text) < 20
    first, last = (int(low), int(high if dash else low)) if digits else (1, 0)
    if not digits or not first <= last < count:
        raise InputError(
            f"{name} is {text!r}, expected a number from 0 to {count - 1}, a run such as 3-7, or *"
        )
    return list(range(first, last + 1))


@dataclass(frozen=True, kw_only=True)
class Wires(Section):
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

    lose: Chance = 0.0
    duplicate: Chance = 0.0
    swap: Chance = 0.0
    delay: Late = 0.0
    jitter: Late = 20e-6


@dataclass(frozen=True, kw_only=True)
class VirtualSettings(Section):
    """Settings of a `VirtualSkin`; text, numbers and tables, which another process can be sent.

    Parameters
    ----------
    hardware : "icub", "cyskin" or "packet"
        Whose boards it plays.
    skin : str
        Layout file, folder, or generator by name such as ``"hexagon72"``.
    bus : str
        For iCub and CySkin: `udp`, `socketcan` or an interface of python-can. For packets: `udp`,
        `tcp` or `serial` (a pseudo-terminal).
    channels : tuple of str
        Where. For `udp` and `tcp`: ``"127.0.0.1:0"``, where it is reached (port 0: any that is
        free); for `socketcan`: ``can0``; for `udp_multicast`: ``"239.74.163.2:43113"``, group and
        port; for `serial`: a path for a link to the pseudo-terminal. As many as buses.
    port : int
        Of the first CAN bus over `udp` where no channels are named, the next ones follow; 0: any
        that are free.
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
        Times that of real boards. 0: none.
    common_noise : float, counts
        Of white noise that the taxels of one converter share.
    gain_spread : float
        Of the logarithm of the taxels' gains.
    temperature : Temperature
        Of the surroundings over time.
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
    bus: str = "udp"
    channels: tuple[str, ...] = ()
    port: Annotated[int, Range(0, 65000, "of UDP; 0 takes those that are free")] = 0
    rate: Annotated[float | None, Range(0.01, 20e3, "readings per second")] = None
    at_once: bool = False
    scene: str = "press"
    lead_in: Annotated[float, Range(0.0, 1e6, "seconds; 0 is off")] = 3.0
    layer: Layer = field(default_factory=Layer)
    noise: Annotated[float, Range(0.0, 1e3, "times that of real boards; 0 is off")] = 0.3
    common_noise: Annotated[float, Range(0.0, 1e6, "counts; 0 is off")] = 0.0
    gain_spread: Annotated[float, Range(0.0, 3.0, "of a logarithm; 0.1 is about 10 %")] = 0.0
    temperature: Temperature = field(default_factory=Temperature)
    mtb3: bool = False
    spread: bool = False
    wires: Wires = field(default_factory=Wires)
    faults: tuple[Fault, ...] = ()
    seed: Annotated[int, Range(0, 1 << 63, "of all that is random")] = 0
    control: str = "127.0.0.1:0"
    truth: str = ""
    duration: Annotated[float | None, Positive("in seconds")] = None
    priority: Annotated[int, Range(0, 99, "of SCHED_FIFO; 0 is not asked for")] = 0

    def check(self) -> None:
        """See `Section`."""
        check_choice("hardware", self.hardware, HARDWARE, "whose boards it plays")
        if self.hardware == "packet":
            check_choice("bus", self.bus, STREAMS, "what packets travel by")
        for name in ("skin", "bus", "scene", "control", "truth"):
            check_type(name, getattr(self, name), str, "text")
