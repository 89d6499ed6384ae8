"""Settings of the virtual skin with its temperature and faults, as text and numbers."""

import math
import re
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Annotated, Literal, get_args

from skinfield.elastic import Layer
from skinfield.errors import InputError, check_choice, check_type
from skinfield.settings import Positive, Range, Section, SettingError

if TYPE_CHECKING:
    from skinfield.simulate.habits import Habits

HabitsName = Literal["none", "real"]  # of `simulate.habits.HABITS`, which takes long to load
NO_HABITS: HabitsName = "none"
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
LESS_NOISE = 0.3  # of that of real boards, so that light touches show
WARMEST = 10.0  # K: where surroundings that warm up stay
BOARDS = ("icub", "cyskin", "packet")
STREAMS = ("udp", "tcp", "serial")
PROBABILITY = Range(0.0, 1.0, "a probability per message; 0 is off")
Chance = Annotated[float, PROBABILITY]


@dataclass(frozen=True)
class TemperatureSettings(Section):
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


@cache
def temperature_from_text(text: str) -> TemperatureSettings:
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
        return TemperatureSettings(start)
    number, seconds = float(found["change"]), float(found["seconds"])
    sine = found["how"] == "~"
    return TemperatureSettings(start, number if sine else number - start, seconds, sine)


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
    lose : float
        Share of messages that is lost, 0 to 1.
    duplicate : float
        Share that is sent twice.
    swap : float
        Share that follows the next one.
    delay_ms : float, ms
        From conversion to sending, ms.
    jitter_us : float, µs
        Mean random delay, µs; readings of a board never overtake each other by it.
    """

    lose: Chance = 0.0
    duplicate: Chance = 0.0
    swap: Chance = 0.0
    delay_ms: Annotated[float, Range(0.0, 6e4, "ms; 0: none")] = 0.0
    jitter_us: Annotated[float, Range(0.0, 6e7, "µs; 0: none")] = 20.0


@dataclass(frozen=True, kw_only=True)
class EmulatedBoards(Section):
    """Which boards are played, where, what presses them, and what fails.

    Parameters
    ----------
    hardware : "icub", "cyskin" or "packet"
        Whose boards.
    skin : str
        Layout file, folder, or a generator by name.
    bus : str
        For iCub and CySkin udp, socketcan or an interface of python-can; for packets udp, tcp or
        serial (a pseudo-terminal).
    channels : tuple of str
        Address on the bus, such as can0 or 127.0.0.1:0, where port 0 is any that is free; once for
        each bus.
    rate : float, 1/s, optional
        Readings of each board per second; default as the host asks, else the board's.
    at_once : bool
        Stream before a host says so.
    spread : bool
        Boards send one after the other.
    scene : str
        What presses: idle, press, slide, two-balls, tap, random, or a file.
    lead_in : float, s
        Without a press, after the first reading, s.
    duration : float, s, optional
        Seconds; default until Ctrl-C.
    seed : int
        Of what is random.
    priority : int
        Of SCHED_FIFO, 1 to 99, where permitted.
    control : str
        Address for presses and faults from outside; empty for none.
    fault : tuple of str
        What fails, such as "unplug 3@10s+5s"; again for more.
    truth : str
        File for what pressed, JSON lines.
    habits : str
        Of the skin: none, or real, of which docs/explanation/electronics.md has a table.
    noise_scale : float, optional
        Times the noise of a real skin; 0: none. Default 0.3, with habits 1.
    common_noise : float, counts
        Noise shared by a converter's taxels, counts.
    gain_spread : float
        Of the logarithm of gains, 0.1: 10 %.
    temperature : str, °C
        °C: 25, 25..35@600s (rises in 600 s), 25~3@300s (± 3 K, period 300 s).
    mtb3 : bool
        iCub's older boards: drift rounds otherwise.
    """

    hardware: Literal["icub", "cyskin", "packet"] = "icub"
    skin: str = "hexagon72"
    bus: str = "udp"
    channels: tuple[str, ...] = ()
    rate: Annotated[float | None, Range(0.01, 20e3, "readings per second")] = None
    at_once: bool = False
    spread: bool = False
    scene: str = "press"
    lead_in: Annotated[float, Range(0.0, 1e6, "seconds; 0: none")] = 3.0
    duration: Annotated[float | None, Positive("seconds")] = None
    seed: Annotated[int, Range(0, 1 << 63, "of what is random")] = 0
    priority: Annotated[int, Range(0, 99, "of SCHED_FIFO; 0: not asked for")] = 0
    control: str = "127.0.0.1:0"
    fault: tuple[str, ...] = ()
    truth: str = ""
    habits: HabitsName = NO_HABITS
    noise_scale: Annotated[float | None, Range(0.0, 1e3, "times that of real boards; 0: none")] = (
        None
    )
    common_noise: Annotated[float, Range(0.0, 1e6, "counts; 0: none")] = 0.0
    gain_spread: Annotated[float, Range(0.0, 3.0, "of a logarithm; 0.1: 10 %")] = 0.0
    temperature: str = "25"
    mtb3: bool = False

    def check(self) -> None:
        """See `Section`."""
        check_choice("hardware", self.hardware, BOARDS, "whose boards it plays")
        check_choice("habits", self.habits, get_args(HabitsName), "of skins")
        if self.hardware == "packet":
            check_choice("bus", self.bus, STREAMS, "what packets travel by")
        for name in ("skin", "bus", "scene", "control", "truth"):
            check_type(name, getattr(self, name), str, "text")
        for name, texts, read in (
            ("fault", self.fault, fault_from_text),
            ("temperature", (self.temperature,), temperature_from_text),
        ):
            for text in texts:
                try:
                    read(text)
                except InputError as error:
                    raise SettingError(name, f"is {text!r}: {error}") from error

    @property
    def faults(self) -> tuple[Fault, ...]:
        """What fails, and when."""
        return tuple(map(fault_from_text, self.fault))

    @property
    def its_habits(self) -> "Habits":
        """What comes on top of a skin as it is stated."""
        from skinfield.simulate.habits import habits_by_name

        return habits_by_name(self.habits)

    @property
    def noise_times(self) -> float:
        """Times the noise of a real skin."""
        usual = LESS_NOISE if self.habits == NO_HABITS else 1.0
        return usual if self.noise_scale is None else self.noise_scale

    @property
    def surroundings(self) -> TemperatureSettings:
        """How warm it is, and when; where nothing is said, as warming as the habits have it."""
        stated = temperature_from_text(self.temperature)
        if stated != TemperatureSettings() or self.habits == NO_HABITS:
            return stated
        warming = self.its_habits.warming
        return TemperatureSettings(change=WARMEST, seconds=WARMEST / warming)


@dataclass(frozen=True, kw_only=True)
class VirtualSettings(EmulatedBoards):
    """Settings of a `VirtualSkin`; text, numbers and tables, which another process can be sent.

    Parameters
    ----------
    port : int
        Of the first CAN bus over `udp` where no channels are named, the next ones follow; 0: any
        that are free.
    layer : Layer
        Elastomer that is pressed.
    wires : Wires
    """

    port: Annotated[int, Range(0, 65000, "of UDP; 0 takes those that are free")] = 0
    layer: Layer = field(default_factory=Layer)
    wires: Wires = field(default_factory=Wires)
