"""One press in time: down, in, hold, out, and on to the next place."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, check_positive, check_range

LONGEST = 3600.0  # s, of one part of a press


@dataclass(frozen=True, kw_only=True)
class Profile:
    """Durations of the parts of a press, and how load rises and falls in it.

    Parameters
    ----------
    rest : float, s
        Nothing touches, before the first press and after the last: baselines are taken there.
    approach : float, s
        From the clearance down to the surface.
    ramp : float, s
        From touch to full load.
    hold : float, s
    release : float, s
        From full load to none.
    pause : float, s
        Up to the clearance again, while the positioners move to the next place.
    smooth : bool
        Load follows a quintic without jumps of speed or acceleration; else straight lines, a
        trapezoid.
    clearance : float, m
        Height above the surface between presses.
    """

    rest: float = 2.5
    approach: float = 0.5
    ramp: float = 0.5
    hold: float = 2.0
    release: float = 0.5
    pause: float = 0.5
    smooth: bool = True
    clearance: float = 5e-3

    def __post_init__(self) -> None:
        for name in ("rest", "approach", "hold", "pause"):
            check_range(name, getattr(self, name), 0.0, LONGEST, "in seconds")
        for name in ("ramp", "release"):
            check_positive(name, getattr(self, name), "in seconds; load cannot jump")
            check_range(name, getattr(self, name), 0.0, LONGEST, "in seconds")
        check_range("clearance", self.clearance, 0.0, 1.0, "in metres")

    @property
    def period(self) -> float:
        """From the start of one press to that of the next, s."""
        return self.approach + self.ramp + self.hold + self.release + self.pause

    def duration(self, presses: int) -> float:
        """Of a recording of some presses, s."""
        return 2 * self.rest + presses * self.period

    def starts(self, presses: int) -> Floats:
        """When each press begins to come down, (presses,) s."""
        return np.asarray(self.rest + self.period * np.arange(presses), dtype=np.float64)

    def load(self, time: Floats) -> Floats:
        """Load at times (T,) s after the start of a press, as a part of the full one."""
        touch = self.approach
        full, over = touch + self.ramp, touch + self.ramp + self.hold
        times = [touch, full, over, over + self.release]
        return self._shaped(np.interp(time, times, [0.0, 1.0, 1.0, 0.0]))

    def height(self, time: Floats) -> Floats:
        """Of the indenter above the surface where it does not press, (T,) m; 0 where it does."""
        touch, off = self.approach, self.period - self.pause
        times = [0.0, touch, off, self.period]
        return self.clearance * self._shaped(np.interp(time, times, [1.0, 0.0, 0.0, 1.0]))

    def _shaped(self, part: Floats) -> Floats:
        return part**3 * (10.0 - 15.0 * part + 6.0 * part**2) if self.smooth else part
