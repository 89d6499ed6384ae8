"""Response of taxels to touches that pass over them, beside that of their neighbours.

What surrounds a taxel on all sides is on the taxel, too: the load that neighbours on every side of
it feel at once is the least to expect of it. How much more or less healthy taxels feel is seen in
the recording itself, so no model of the layer is needed. Only touches that move tell: a hand that
holds on may have a gap between its fingers.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats, Ints
from skinfield.signal.boards import Bools
from skinfield.signal.noise import TOUCHED, usual_deviation
from skinfield.signal.stationary import fast_noise, readings_per_value, whole_numbers
from skinfield.skin import Patch

MOST_READINGS = 4000  # that are looked at: of more, means of some in a row
SEGMENTS = 16  # of a recording, whose untouched readings tell the rest
DIRECTIONS, SECTOR = 12, np.deg2rad(75.0)  # sides of a taxel, and how wide each is either way
LEAST_SIDES = 0.75  # part of them, that have a neighbour
PRESSED = 10.0  # usual deviations, of a load that tells
FAINT = 0.02  # of the highest reading: no load below tells
STRONG = 0.7  # of the strongest load, in readings that tell
PASSING, MOVED = 0.3, 0.6  # part of it, down to which cosines of neighbours' loads fall as it moves
FREEDOM = 10.0  # of Student's t, of the logarithm of responses
FEWEST = 8  # taxels of a kind, that tell how healthy ones respond
ANSWERS, SURE, LEAST_READINGS = 0.3, 4.0, 3  # of a response, deviations; readings of one that is
ERRORS = 2.0  # standard errors, that a response may be larger


@dataclass(frozen=True, eq=False)
class TouchResponse:
    """What taxels read while touches pass over them.

    Attributes
    ----------
    height : (T, L) array, counts
        Change from rest, positive under pressure; 0 where a taxel did not answer.
    load : (T, L) array, counts
        That neighbours feel on all sides of a taxel, as far as there are any.
    inner : (L,) bool array
        Taxels with neighbours on all sides.
    noise : (L,) array, counts
    usual : float, counts
        Deviation of the median taxel.
    near : (L, N) int array
        Neighbours, the taxel itself where there are fewer.
    hold : float
        Readings for which one value is repeated.
    """

    height: Floats
    load: Floats
    inner: Bools
    noise: Floats
    usual: float
    near: Ints
    hold: float

    @cached_property
    def strongest(self) -> Floats:
        """Highest load (L,) on a taxel, 0 where none tells."""
        highest = self.load.max(axis=0, initial=0.0)
        least = max(PRESSED * self.usual, FAINT * float(self.height.max(initial=0.0)))
        return np.where(highest > least, highest, 0.0)

    @cached_property
    def strong(self) -> Bools:
        """Where (T, L) the load on a taxel is near its highest."""
        return np.asarray((self.load >= STRONG * self.strongest) & (self.strongest > 0.0))

    @cached_property
    def response(self) -> Floats:
        """Of taxel i to the load on taxel k, (L, L) by k and i: parts of the load; NaN if none."""
        from scipy.sparse import csr_array

        total = np.sum(self.load, axis=0, where=self.strong)
        told = np.asarray(csr_array(self.strong.T.astype(np.float64)) @ self.height)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(told / total[:, None])

    @cached_property
    def error(self) -> Floats:
        """Standard error of the responses to the load on a taxel, (L,) for a noise of 1."""
        number = np.maximum(self.strong.sum(axis=0) / self.hold, 1.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.sum(self.load, axis=0, where=self.strong) / self.strong.sum(axis=0)
            return np.asarray(1.0 / (np.sqrt(number) * mean))

    @cached_property
    def usual_response(self) -> tuple[Floats, Floats]:
        """Logarithm of the median response, and its robust deviation, (L,): of inner and others."""
        own = np.diag(self.response)
        middle, spread = np.full(len(own), np.nan), np.full(len(own), np.nan)
        for kind in (self.inner, ~self.inner):
            told = own[kind & (self.strongest > 0.0)]
            told = np.log(told[told > self.usual / PRESSED / max(self.height.max(), 1e-300)])
            if len(told) >= FEWEST:
                middle[kind] = np.median(told)
                spread[kind] = 1.4826 * np.median(np.abs(told - np.median(told)))
        return middle, spread

    def chance(self, load_on: Ints, taxel: Ints) -> Floats:
        """How often a healthy taxel responds as little as `taxel` to the load on `load_on`."""
        from scipy.stats import t

        middle, spread = self.usual_response
        told = self.response[load_on, taxel]
        most = np.maximum(told, 0.0) + ERRORS * self.error[load_on] * self.noise[taxel]
        with np.errstate(invalid="ignore", divide="ignore"):
            apart = (np.log(most) - middle[load_on]) / np.maximum(spread[load_on], 0.1)
        return np.where(np.isfinite(apart), t.cdf(apart, FREEDOM), 1.0)

    def relative(self, load_on: Ints, taxel: Ints) -> Floats:
        """Largest credible response of `taxel` to the load on `load_on`, 1: that of the median."""
        told = self.response[load_on, taxel]
        most = np.maximum(told, 0.0) + ERRORS * self.error[load_on] * self.noise[taxel]
        return np.asarray(most / np.exp(self.usual_response[0][load_on]))

    @cached_property
    def answers(self) -> Bools:
        """Taxels (L,) that were touched some time, whether something surrounded them or not."""
        middle = self.usual_response[0]
        usual = np.exp(np.where(np.isfinite(middle), middle, 0.0)) * self.strongest
        least = np.maximum(ANSWERS * usual, np.maximum(SURE * self.noise, PRESSED * self.usual))
        return np.asarray((self.height > least).sum(axis=0) >= LEAST_READINGS)

    def moved(self, taxel: int) -> bool:
        """Whether the load around a taxel came from one side, and then from another."""
        around = self.near[taxel][self.near[taxel] != taxel]
        if len(around) < 2 or not self.strongest[taxel]:
            return False
        loads = np.maximum(self.height[:, around], 0.0)
        total = loads.sum(axis=1)
        at = int(np.argmax(self.load[:, taxel]))
        there = total >= PASSING * total[at]
        size = np.linalg.norm(loads, axis=1)
        cosine = loads[there] @ loads[at] / np.maximum(size[there] * size[at], 1e-300)
        return bool(cosine.min(initial=1.0) < MOVED)


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
        Taxels that tell nothing of a load: absent, constant and noisy ones.
    """
    rounding = 12**-0.5 if whole_numbers(counts) else 0.0
    noise = np.maximum(np.nan_to_num(fast_noise(counts, readings_per_value(counts))), rounding)
    hold = readings_per_value(counts)
    counts, group = _shortened(counts)
    near = _near(patch)
    height = _heights(counts * (direction or _direction(counts[:, ~silent])), near, silent)
    height = np.nan_to_num(height)
    usual = usual_deviation(height[:, ~silent]) if (~silent).any() else 0.0
    load, inner = _load(np.where(silent, 0.0, np.maximum(height, 0.0)), patch, near, silent)
    usual = max(usual, rounding)
    return TouchResponse(
        height, load, inner, noise / np.sqrt(group), usual, near, max(hold / group, 1.0)
    )


def _near(patch: Patch) -> Ints:
    """Neighbours (L, N) of each taxel; itself where it has fewer."""
    pairs = np.concatenate([patch.neighbours, patch.neighbours[:, ::-1]])
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    turn = np.arange(len(pairs)) - np.searchsorted(pairs[:, 0], pairs[:, 0])
    near = np.tile(np.arange(len(patch)), (int(turn.max(initial=-1)) + 1, 1)).T
    near[pairs[:, 0], turn] = pairs[:, 1]
    return near


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
    counts = counts[:, ~np.isnan(counts).all(axis=0)]
    if not counts.size:
        return 1
    cubes = np.nansum((counts - np.nanmedian(counts, axis=0)) ** 3, axis=0)
    return 1 if cubes.sum() >= 0.0 else -1


def _heights(signed: Floats, near: Ints, silent: Bools) -> Floats:
    """Change from rest (T, L), rest by the readings in which no neighbour is touched, as it drifts.

    A taxel that is touched all the time rests at its lowest readings.
    """
    gone = np.isnan(signed).all(axis=0)
    low = np.zeros(signed.shape[1])
    low[~gone] = np.nanpercentile(signed[:, ~gone], 20.0, axis=0)
    height = signed - low
    usual = usual_deviation(height[:, ~silent]) if (~silent).any() else 0.0
    high = np.where(silent, 0.0, np.nan_to_num(height))
    touched = high > PRESSED * usual
    for column in near.T:
        touched |= high[:, column] > TOUCHED * usual
    quiet = np.where(touched, np.nan, height)
    parts = np.array_split(np.arange(len(height)), min(SEGMENTS, max(len(height) // 16, 1)))
    levels = np.full((len(parts), height.shape[1]), np.nan)
    for row, part in enumerate(parts):
        number = (~np.isnan(quiet[part])).sum(axis=0)
        enough = number > 2
        levels[row, enough] = np.nansum(quiet[part][:, enough], axis=0) / number[enough]
    at, middles = np.arange(len(height)), np.array([part.mean() for part in parts])
    for taxel in np.flatnonzero(np.isfinite(levels).any(axis=0)):
        known = np.isfinite(levels[:, taxel])
        height[:, taxel] -= np.interp(at, middles[known], levels[known, taxel])
    return height


def _load(height: Floats, patch: Patch, near: Ints, silent: Bools) -> tuple[Floats, Bools]:
    """Load (T, L) that neighbours feel on all sides that have any; taxels (L,) with all sides.

    0 where all neighbours lie on one side.
    """
    plane, rows = patch.plane, np.arange(len(patch))
    way = plane[near] - plane[:, None]
    angle = np.arctan2(way[..., 1], way[..., 0])
    real = (near != rows[:, None]) & ~silent[near]
    load, sides = np.full(height.shape, np.inf), np.zeros(len(rows), np.int64)
    for side in 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
        there = real & (np.cos(angle - side) >= np.cos(SECTOR))
        highest = np.zeros_like(height)
        for column in np.flatnonzero(there.any(axis=0)):
            its = there[:, column]
            highest[:, its] = np.maximum(highest[:, its], height[:, near[its, column]])
        any_ = there.any(axis=1)
        sides += any_
        load[:, any_] = np.minimum(load[:, any_], highest[:, any_])
    told = sides >= LEAST_SIDES * DIRECTIONS
    return np.where(told, load, 0.0), sides == DIRECTIONS
