"""Temperature of the surroundings over time."""

import math
import re
from dataclasses import dataclass

from skinfield.errors import InputError, check_positive, check_range

ROOM = 25.0
NUMBER = r"[+-]?\d+(?:\.\d*)?"
PATTERN = re.compile(
    rf"(?P<start>{NUMBER})(?:(?P<how>\.\.|~)(?P<change>{NUMBER})@(?P<seconds>\d+(?:\.\d*)?)s)?"
)
SYNTAX = "25 (constant, °C), 25..35@600s (to 35 °C in 600 s) or 25~3@300s (± 3 K with a period)"


@dataclass(frozen=True)
class Temperature:
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

    start: float = ROOM
    change: float = 0.0
    seconds: float = 1.0
    sine: bool = False

    def __post_init__(self) -> None:
        check_range("start", self.start, -60.0, 150.0, "degrees Celsius")
        check_range("change", self.change, -200.0, 200.0, "kelvin")
        check_positive("seconds", self.seconds, "of the rise, or of the sine's period")

    def warmth(self, time: float) -> float:
        """K above 25 °C at a time, s, since the stream began."""
        above = self.start - ROOM
        if not self.change:
            return above
        if self.sine:
            return above + self.change * math.sin(2.0 * math.pi * time / self.seconds)
        return above + self.change * min(max(time / self.seconds, 0.0), 1.0)


def temperature_from_text(text: str) -> Temperature:
    """Temperature from the words of a command line, see `SYNTAX`.

    Raises
    ------
    InputError
        For any other text.
    """
    found = PATTERN.fullmatch(text.strip())
    if found is None:
        raise InputError(f"temperature is {text!r}, expected {SYNTAX}")
    start = float(found["start"])
    if found["how"] is None:
        return Temperature(start)
    number, seconds = float(found["change"]), float(found["seconds"])
    sine = found["how"] == "~"
    return Temperature(start, number if sine else number - start, seconds, sine)
