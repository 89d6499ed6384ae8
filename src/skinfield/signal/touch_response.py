"""Response of taxels to touches that peak on their neighbours.

A touch moves over a skin, or comes down here and there. In the readings in which it is highest on
one taxel, that taxel's neighbours feel it as well, more or less. How often healthy ones do not is
seen in the recording itself, so no model of the layer is needed. One that never does, while touches
pass over it, has failed; one that does so at the place of another is swapped with it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.signal.boards import Bools
from skinfield.signal.noise import TOUCHED, usual_deviation
from skinfield.signal.stationary import fast_noise, readings_per_value, whole_numbers
from skinfield.skin import Patch

MOST_READINGS = 4000  # that are looked at: of more, means of some in a row
SEGMENTS = 16  # of a recording, whose untouched readings tell the rest
PEAK, SURE = 10.0, 6.0  # usual deviations, and a taxel's own, of a peak
SUPPORT, LEAST_SUPPORT = 4.0, 2  # deviations; neighbours of a peak that feel it, too: no jump
FAINT = 0.02  # of the highest reading: no peak below
FELT, SIGNIFICANT = 0.05, 3.0  # part of the peak, and standard errors, of a response
SAME = 0.6  # part of its own peak that a taxel shows in another's, if both are of one touch
LEAST_PEAK = 2  # readings


@dataclass(frozen=True, eq=False)
class TouchResponse:
    """What taxels read while touches peak on other taxels.

    Attributes
    ----------
    adjacent : (L, L) bool array
        Neighbours.
    level : (L,) array, counts
        Mean height of the peaks on a taxel; NaN without one.
    response : (L, L) array, counts
        Row p: mean heights of all taxels in the readings with a peak on p; NaN without one.
    error : (L, L) array, counts
        Standard errors of these, by the taxels' noise.
    """

    adjacent: Bools
    level: Floats
    response: Floats
    error: Floats

    @cached_property
    def peaked(self) -> Bools:
        """Taxels (L,) on which some touch was highest."""
        return np.isfinite(self.level)

    @cached_property
    def felt(self) -> Bools:
        """Whether (L, L) a taxel, by column, responds to the peaks on another, by row."""
        with np.errstate(invalid="ignore"):
            least = np.maximum(FELT * self.level[:, None], SIGNIFICANT * self.error)
            return np.asarray(self.response >= least)

    @cached_property
    def around(self) -> Bools:
        """Whether (L, L) a touch peaked on a taxel, by row, that is a neighbour, by column."""
        return np.asarray(
            self.adjacent & self.peaked[:, None] & np.isfinite(self.response), dtype=np.bool_
        )

    @cached_property
    def answers(self) -> Bools:
        """Taxels (L,) that respond to a touch on a neighbour."""
        return np.asarray((self.around & self.felt).any(axis=0))

    @cached_property
    def miss_rate(self) -> float:
        """How often a taxel that answers at all does not feel a touch that peaks on a neighbour."""
        tried = self.around & self.answers
        missed = tried & ~self.felt
        return float((missed.sum() + 1.0) / (tried.sum() + 2.0))

    def distinct(self, rows: Ints) -> int:
        """How many of the taxels `rows` were peaks of touches that differ from each other.

        Two peaks that stand side by side all the time, as under a hand that holds on, are of one.
        """
        chosen: list[int] = []
        for row in rows[np.argsort(-self.level[rows])]:
            share = np.fmax(
                self.response[row, chosen] / self.level[chosen],
                self.response[chosen, row] / self.level[row],
            )
            if not (share >= SAME).any():
                chosen.append(int(row))
        return len(chosen)


def touch_response(counts: Floats, patch: Patch, direction: int, silent: Bools) -> TouchResponse:
    """Look for touches in counts (T, L), and at what all taxels read meanwhile.

    Parameters
    ----------
    counts : (T, L) array, counts
        NaN where a taxel did not answer.
    patch : Patch
    direction : int
        Sign of the change under pressure; 0 for that of the larger changes.
    silent : (L,) bool array
        Taxels without a peak: absent, constant and noisy ones.
    """
    from scipy.sparse import csr_array

    taxels = len(patch)
    adjacent = np.zeros((taxels, taxels), np.bool_)
    adjacent[tuple(patch.neighbours.T)] = True
    adjacent |= adjacent.T
    noise = np.nan_to_num(fast_noise(counts, readings_per_value(counts)))
    rounding = 12**-0.5 if whole_numbers(counts) else 0.0
    hold = readings_per_value(counts)
    counts, group = _shortened(counts)
    height = _heights(counts * (direction or _direction(counts[:, ~silent])), patch, silent)
    there = ~np.isnan(height)
    height = np.where(there, height, 0.0)
    usual = usual_deviation(height[:, ~silent]) if (~silent).any() else 0.0
    own = np.maximum(noise / np.sqrt(group), max(usual, rounding))
    peaks = _peaks(np.where(silent, 0.0, height), own, usual, patch.neighbours)
    rows = csr_array(peaks.T.astype(np.float64))
    number = np.asarray(rows @ there.astype(np.float64))
    with np.errstate(invalid="ignore", divide="ignore"):
        response = np.asarray(rows @ height) / number
        response[(peaks.sum(axis=0) < LEAST_PEAK)] = np.nan
        fresh = np.maximum(number * group / hold, 1.0)
        error = np.maximum(noise, rounding) / np.sqrt(fresh)
    return TouchResponse(adjacent, np.diag(response).copy(), response, error)


def _shortened(counts: Floats) -> tuple[Floats, int]:
    """Means of so many readings in a row that there are not too many."""
    group = -(-len(counts) // MOST_READINGS)
    if group == 1:
        return counts, 1
    counts = counts[: len(counts) // group * group].reshape(-1, group, counts.shape[1])
    number = (~np.isnan(counts)).sum(axis=1)
    total = np.nansum(counts, axis=1)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan), group


def _direction(counts: Floats) -> int:
    """Sign of the larger changes: touches go far to one side of the rest."""
    if not counts.size or np.isnan(counts).all(axis=0).all():
        return 1
    counts = counts[:, ~np.isnan(counts).all(axis=0)]
    middle = np.nanmedian(counts, axis=0)
    cubes = np.nansum((counts - middle) ** 3, axis=0)
    return 1 if cubes.sum() >= 0.0 else -1


def _heights(signed: Floats, patch: Patch, silent: Bools) -> Floats:
    """Change from rest (T, L), rest by the readings in which no neighbour is touched, as it drifts.

    A taxel that is touched all the time rests at its lowest readings.
    """
    gone = np.isnan(signed).all(axis=0)
    low = np.zeros(signed.shape[1])
    low[~gone] = np.nanpercentile(signed[:, ~gone], 20.0, axis=0)
    height = signed - low
    usual = usual_deviation(height[:, ~silent]) if (~silent).any() else 0.0
    high = np.nan_to_num(np.where(silent, 0.0, height))
    touched = _highest_around(high, patch.neighbours) > TOUCHED * usual
    touched |= high > max(TOUCHED, PEAK) * usual
    quiet = np.where(touched, np.nan, height)
    middles, levels = [], []
    for part in np.array_split(np.arange(len(height)), min(SEGMENTS, max(len(height) // 16, 1))):
        number = (~np.isnan(quiet[part])).sum(axis=0)
        levels.append(np.where(number > 2, np.nansum(quiet[part], axis=0) / (number + 1e-9), np.nan))
        middles.append(part.mean())
    at, table = np.arange(len(height)), np.array(levels)
    for taxel in np.flatnonzero(np.isfinite(table).any(axis=0)):
        known = np.isfinite(table[:, taxel])
        height[:, taxel] -= np.interp(at, np.array(middles)[known], table[known, taxel])
    return height


def _highest_around(height: Floats, neighbours: Ints) -> Floats:
    """Highest neighbour of each taxel in each reading (T, L); 0 at least."""
    found = np.zeros_like(height.T)
    for one, other in _rounds(neighbours, height.shape[1]):
        found[one] = np.maximum(found[one], height.T[other])
    return found.T


def _rounds(neighbours: Ints, taxels: int) -> list[tuple[Ints, Ints]]:
    """Pairs in both orders, in rounds in which no taxel is the first of two pairs."""
    both = np.concatenate([neighbours, neighbours[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    first = np.searchsorted(both[:, 0], np.arange(taxels))
    turn = np.arange(len(both)) - first[both[:, 0]]
    return [tuple(both[turn == k].T) for k in range(int(turn.max()) + 1 if len(both) else 0)]


def _peaks(height: Floats, own: Floats, usual: float, neighbours: Ints) -> NDArray[np.bool_]:
    """Where (T, L) a touch is highest: above its neighbours, of which some feel it, too."""
    least = np.maximum(np.maximum(PEAK * usual, SURE * own), FAINT * float(height.max(initial=0.0)))
    felt = (height > SUPPORT * own).T
    support = np.zeros(felt.shape, np.int8)
    for one, other in _rounds(neighbours, height.shape[1]):
        support[one] += felt[other]
    highest = height >= _highest_around(height, neighbours)
    return np.asarray(highest & (height > least) & (support.T >= LEAST_SUPPORT))
