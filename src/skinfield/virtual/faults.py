"""Faults of boards and taxels: which, from when, for how long."""

import math
import re
from dataclasses import dataclass

from skinfield.errors import InputError, check_choice, check_range

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
PATTERN = re.compile(rf"(?P<what>[^@+]*?)(?:@(?P<start>{TIME}))?(?:\+(?P<seconds>{TIME}))?")
SYNTAX = (
    "WHAT[@START][+SECONDS] with times such as 10s, 250ms or 2min: 3@10s is number 3 from 10 s "
    "on, 3@10s+5s for 5 s"
)
FOREVER = math.inf


@dataclass(frozen=True)
class Fault:
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
    start: float = 0.0
    seconds: float = FOREVER

    def __post_init__(self) -> None:
        check_choice("kind", self.kind, KINDS, "of a fault")
        check_range("start", self.start, 0.0, 1e9, "seconds since the stream began")
        check_range("seconds", self.seconds, 0.0, FOREVER, "for how long the fault lasts")
        if not isinstance(self.what, str) or len(self.what) > 100:
            raise InputError(f"what is {self.what!r:.120}, expected the number of what fails")

    @property
    def end(self) -> float:
        """When it ends, s since the stream began."""
        return self.start + self.seconds


def fault_from_text(text: str) -> Fault:
    """Fault from ``"unplug 3@10s+5s"``.

    Raises
    ------
    InputError
        For any other text.
    """
    kind, _, rest = str(text).strip().partition(" ")
    return fault_of(kind, rest)


def fault_of(kind: str, text: str) -> Fault:
    """Fault of a kind from what stands behind its flag, see `SYNTAX`."""
    found = PATTERN.fullmatch(text.strip())
    if found is None:
        raise InputError(f"{kind} is {text!r}, expected {SYNTAX}")
    start = _seconds(found["start"]) if found["start"] else 0.0
    lasting = _seconds(found["seconds"]) if found["seconds"] else FOREVER
    if kind == "reboot" and lasting == FOREVER:
        lasting = 2.0
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
