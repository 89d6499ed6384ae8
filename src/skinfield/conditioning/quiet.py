"""Where a recording stands still."""

import math
from dataclasses import dataclass

import numpy as np

from skinfield.conditioning.convention import Bools, Convention
from skinfield.conditioning.robust import deviation, median, recorded, whole_numbers
from skinfield.errors import Floats, InputError, check_positive

MOVING = 3.0
"""A taxel moves where its spread over a stretch is more than so many times its fast noise."""
LEAST_READINGS = 16
"""Readings in a stretch: below, spread and fast noise cannot be told apart."""


@dataclass(frozen=True, eq=False)
class QuietStretch:
    """The stillest stretch of a recording, and how still it is.

    Still means that nothing moves beyond the noise. It does not mean unloaded: a robot that stands
    still loads its feet without motion.

    Attributes
    ----------
    start, stop : int
        Readings, stop excluded.
    ratio : float
        Spread over fast noise, 95 % of the taxels below it: about 1 for noise alone.
    moving : (L,) bool array
        Taxels above `MOVING`.
    still : bool
        At most 2 % of the taxels (one of a small patch) move.
    hold : float
        Readings for which a port repeats one value; 1 where every reading is fresh.
    """

    start: int
    stop: int
    ratio: float
    moving: Bools
    still: bool
    hold: float

    @property
    def readings(self) -> slice:
        """The stretch, to index readings with."""
        return slice(self.start, self.stop)


def readings_per_value(counts: Floats) -> float:
    """Readings for which a port repeats one value, 1 where every reading is fresh.

    Loggers often read a port faster than the board sends. A noisy taxel changes with every value
    that is sent, so the most active tenth of the taxels tells; 10 at most, as quiet and coarsely
    quantised taxels look alike.
    """
    steps = np.diff(counts, axis=0)
    compared = np.maximum((~np.isnan(steps)).sum(axis=0), 1)
    changed = np.sort(np.sum(np.nan_to_num(steps) != 0, axis=0) / compared)
    share = float(changed[int(0.9 * (len(changed) - 1))])
    return float(np.clip(1.0 / share, 1.0, 10.0)) if share > 0 else 1.0


def fast_noise(counts: Floats, hold: float) -> Floats:
    """Standard deviation of what changes from value to value of (T, L) counts, (L,).

    From the median absolute difference of readings that lie a whole value apart, so that neither
    slow motion nor repeated readings enter; half a count at least, for quantised data. Where most
    readings are clamped to one value that median is 0, so the smaller nine tenths of the
    differences count by their mean square too: less than the median's figure on normal noise, and
    free of the few large ones of a touch.
    """
    lag = max(1, math.ceil(hold))
    difference = np.abs(counts[lag:] - counts[:-lag])
    usual = 1.4826 * median(difference)
    there = np.nan_to_num(difference, nan=np.inf)
    there = np.sort(there, axis=0)[: max(1, int(0.9 * len(there)))]
    finite = np.isfinite(there)
    square = np.sum(there**2, axis=0, where=finite) / np.maximum(finite.sum(axis=0), 1)
    spread = np.fmax(usual, np.sqrt(square)) / math.sqrt(2.0)
    return np.asarray(np.maximum(spread, 0.5) if whole_numbers(counts) else spread)


def judge(counts: Floats, start: int, stop: int, hold: float) -> QuietStretch:
    """How still readings `start` to `stop` are; taxels that rarely answer do not count."""
    window = counts[start:stop]
    present = (~np.isnan(window)).mean(axis=0) > 0.5
    ratio = np.zeros(counts.shape[1])
    if present.any():
        spread, fast = deviation(window[:, present]), fast_noise(window[:, present], hold)
        noiseless = np.where(spread > 0, np.inf, 0.0)
        ratio[present] = np.divide(spread, fast, out=noiseless, where=fast > 0)
    moving = ratio > MOVING
    allowed = max(1, int(0.02 * present.sum())) if present.sum() > 1 else 0
    still = bool(present.any() and moving.sum() <= allowed)
    typical = (
        float(np.percentile(ratio[present], 95, method="lower")) if present.any() else math.inf
    )
    return QuietStretch(start, stop, typical, moving, still, hold)


def quiet_stretch(
    counts: Floats, rate: float, *, seconds: float = 2.0, convention: Convention | None = None
) -> QuietStretch:
    """Find the stillest stretch of a recording.

    Parameters
    ----------
    counts : (T, L) array, counts
        NaN where a taxel did not answer.
    rate : float, 1/s
        Readings per second.
    seconds : float
        Length of the stretch; half of a recording that is shorter than twice that.
    convention : Convention, optional
        Tells which way pressure moves the counts: of several still stretches the least loaded one
        is then taken.

    Raises
    ------
    InputError
        If there are fewer than 16 readings, or no finite number.

    Notes
    -----
    Per taxel, the spread over the stretch is divided by the noise from one fresh value to the
    next (the square root of von Neumann's ratio, robustly): 1 for white noise, large for motion.
    """
    counts = recorded(counts)
    check_positive("rate", rate, "readings per second")
    check_positive("seconds", seconds, "the length of the stretch")
    if len(counts) < LEAST_READINGS:
        raise InputError(
            f"counts hold {len(counts)} readings, expected at least {LEAST_READINGS}: "
            "noise and motion cannot be told apart in fewer"
        )
    longest = max(LEAST_READINGS, len(counts) // 2)  # so that a press can lie outside
    length = int(np.clip(round(seconds * rate), LEAST_READINGS, longest))
    hold = readings_per_value(counts)
    starts = range(0, len(counts) - length + 1, max(1, length // 4))
    found = [judge(counts, start, start + length, hold) for start in starts]
    still = [stretch for stretch in found if stretch.still]
    if still and convention is not None:
        sign = convention.direction
        return min(still, key=lambda s: sign * float(np.nanmean(counts[s.readings])))
    return min(still or found, key=lambda s: (s.moving.sum(), s.ratio))
