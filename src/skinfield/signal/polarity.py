"""Polarity of readings: whether pressure raises or lowers the counts of an unknown board."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.signal.boards import Bools

STANDS_OUT = 12.0  # deviations, of a reading that something presses
FEWEST = 3  # such readings, that tell a direction
MOST_OF_RANGE = 0.5  # of ΔC/C₀, that a guess of the gain lets the strongest reading be
IDLE = 0.05  # of the largest load: nothing presses
AGREES = 0.3  # correlation of counts and load, from which on the load tells the direction


@dataclass(frozen=True, eq=False)
class Polarity:
    """What presses in a log tell of its counts.

    Attributes
    ----------
    direction : int
        +1 where pressure raises counts, -1 where it lowers them, 0 where too little presses.
    rest, noise : (L,) arrays, counts
    pressed : (P,) int array
        Readings in which something presses.
    gain : float
        Guess of the counts per unit of ΔC/C₀, with the sign of the direction: what a count is where
        it grows as the capacitance does, so that the median rest is C₀; or twice the strongest
        change, where that would be more than half of C₀.
    """

    direction: int
    rest: Floats
    noise: Floats
    pressed: Ints
    gain: float


def find_polarity(counts: Floats, load: Floats | None = None) -> Polarity:
    """Direction, rest and noise of counts (T, L) of which most are untouched; NaN is missing.

    Of a press the most changed taxel tells the direction, as the rim beside it changes the other
    way, but less. A load (T,) that was measured beside them tells direction and rest even where
    most readings are of presses.
    """
    idle = None if load is None else idle_under(load)
    rest = _medians(counts if idle is None or not idle.any() else counts[idle])
    change = counts - rest
    steps = np.diff(counts, axis=0)
    # readings one after the other differ by √2 of the noise; whole counts by 1/√12 at least
    noise = np.maximum(1.4826 * _medians(np.abs(steps)) / 2**0.5, 12**-0.5)
    whole = np.all(np.isnan(counts) | (counts == np.rint(counts)))
    if not whole:
        spread = 1.4826 * _medians(np.abs(steps)) / 2**0.5
        known = spread[spread > 0.0]
        noise = np.where(spread > 0.0, spread, np.median(known) if len(known) else 1.0)
    over = np.nan_to_num(change) / np.nan_to_num(noise, nan=1.0)
    high, low = over.max(axis=1), over.min(axis=1)
    pressed = np.flatnonzero(np.maximum(high, -low) > STANDS_OUT)
    enough = len(pressed) >= FEWEST
    direction = int(np.sign(np.median((high + low)[pressed]))) if enough else 0
    if load is not None:
        direction = _direction_under(load, change) or direction
    strongest = float(np.nanmax(np.abs(change), initial=0.0))
    size = max(float(np.nanmedian(np.abs(rest))), strongest / MOST_OF_RANGE)
    return Polarity(direction, rest, noise, pressed, (direction or 1) * (size or 1.0))


def idle_under(load: Floats) -> Bools:
    """Readings in which a measured load (T,) is next to none."""
    size = np.abs(load)
    return np.asarray(size <= IDLE * np.nanmax(size, initial=0.0))


def _direction_under(load: Floats, change: Floats) -> int:
    """Sign by which counts follow a load (T,), whatever sign its sensor gives; 0 if none does."""
    size, most = np.abs(load), np.nansum(np.abs(change), axis=0).argmax()
    known = np.isfinite(size) & np.isfinite(change[:, most])
    pair = np.array([size[known], change[known, most]])
    if pair.shape[1] < FEWEST or not pair.std(axis=1).all():
        return 0
    agrees = float(np.corrcoef(pair)[0, 1])
    return int(np.sign(agrees)) if abs(agrees) > AGREES else 0


def _medians(values: Floats) -> Floats:
    """Median of each column of (T, L), NaN left out; NaN where that leaves none."""
    found = np.full(values.shape[1], np.nan)
    known = ~np.isnan(values).all(axis=0)
    found[known] = np.nanmedian(values[:, known], axis=0)
    return found


def presses_in(pressed: Ints, load: Floats, gap: int) -> list[int]:
    """The strongest reading of each press: readings `pressed` with less than `gap` between them."""
    if not len(pressed):
        return []
    ends = np.flatnonzero(np.diff(pressed) > gap) + 1
    return [int(each[np.argmax(load[each])]) for each in np.split(pressed, ends)]
