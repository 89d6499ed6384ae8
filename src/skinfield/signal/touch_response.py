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
from skinfield.signal.stationary import median, readings_per_value, whole_numbers
from skinfield.skin import Patch

MOST_READINGS = 4000  # that are looked at: of more, means of some in a row
SEGMENTS = 8  # of a recording, whose untouched readings tell the rest
DIRECTIONS, SECTOR = 12, np.deg2rad(75.0)  # sides of a taxel, and how wide each is either way
LEAST_SIDES = 0.75  # part of them, that have a neighbour
LOAD, PRESSED = 8.0, 10.0  # deviations, of each neighbour that feels a load, and of a touch
FAINT = 0.05  # of the highest reading: no load below tells
STRONG = 0.5  # of the strongest load, in readings that tell
LEAST_ALONE = 0.33  # part of the readings, in which nothing touches around a taxel
PASSING, MOVED = 0.15, 0.7  # part of it, down to which cosines of neighbours' loads fall as it moves
FREEDOM = 5.0  # of Student's t, of the logarithm of responses
FEWEST = 8  # taxels that tell how healthy ones respond
ANSWERS, SURE, LEAST_READINGS = 0.3, 4.0, 3  # of a response, deviations; readings of one that is
STANDS_OUT = 6.0  # deviations, of two readings in a row that are no noise
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
    beside : (T, L) bool array
        Whether a neighbour is touched.
    noise : (L,) array, counts
    usual : float, counts
        Deviation of the median taxel.
    near : (L, N) int array
        Neighbours, the taxel itself where there are fewer.
    hold : float
        Readings for which one value is repeated.
    silent : (L,) bool array
        Taxels that tell nothing of a load.
    """

    height: Floats
    load: Floats
    beside: Bools
    noise: Floats
    usual: float
    near: Ints
    hold: float
    silent: Bools

    @cached_property
    def strongest(self) -> Floats:
        """Highest load (L,) on a taxel, 0 where none tells."""
        highest = self.load.max(axis=0, initial=0.0)
        least = FAINT * float(self.height.max(initial=0.0))
        return np.where(highest > least, highest, 0.0)

    @cached_property
    def strong(self) -> Bools:
        """Where (T, L) the load on a taxel is near its highest."""
        return np.asarray((self.load >= STRONG * self.strongest) & (self.strongest > 0.0))

    @cached_property
    def response(self) -> Floats:
        """Of each taxel to the load on it, (L,): parts of the load; NaN if none."""
        total = np.sum(self.load, axis=0, where=self.strong)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(np.sum(self.height, axis=0, where=self.strong) / total)

    @cached_property
    def relative(self) -> Floats:
        """Largest credible response (L,) of each taxel, 1: that of the median; NaN if none."""
        number = np.maximum(self.strong.sum(axis=0), 1)
        load = np.sum(self.load, axis=0, where=self.strong) / number
        with np.errstate(invalid="ignore", divide="ignore"):
            error = self.noise / (np.sqrt(np.maximum(number / self.hold, 1.0)) * load)
            most = np.maximum(self.response, 0.0) + ERRORS * error
        return np.asarray(most / np.exp(self.usual_response[0]))

    @cached_property
    def usual_response(self) -> tuple[float, float]:
        """Logarithm of the median response, and its robust deviation; NaN where few tell."""
        own = self.response[self.strongest > 0.0]
        told = np.log(own[own > 0.0])
        if len(told) < FEWEST:
            return float("nan"), float("nan")
        middle = float(np.median(told))
        return middle, 1.4826 * float(np.median(np.abs(told - middle)))

    def chance(self, taxel: int) -> float:
        """How often a healthy taxel responds as little as this one to the passes over it."""
        from scipy.stats import t

        middle, spread = self.usual_response
        if not (np.isfinite(middle) and self.strongest[taxel]):
            return 1.0
        load, chance = self.load[:, taxel], 1.0
        rows = np.flatnonzero(self.strong[:, taxel])
        away = np.cumsum(load < PASSING * self.strongest[taxel])[rows]
        for each in np.split(rows, np.flatnonzero(np.diff(away)) + 1):
            error = self.noise[taxel] / np.sqrt(max(len(each) / self.hold, 1.0))
            most = max(float(self.height[each, taxel].mean()), 0.0) + ERRORS * error
            apart = (np.log(most / load[each].mean()) - middle) / max(spread, 0.1)
            chance *= float(t.cdf(apart, FREEDOM))
        return chance

    @cached_property
    def answers(self) -> Bools:
        """Taxels (L,) that were touched some time, whether something surrounded them or not.

        Some readings reach part of a usual response, or some in a row stand out, as no jump does.
        """
        usual = np.exp(np.nan_to_num(self.usual_response[0])) * self.strongest
        least = np.maximum(ANSWERS * usual, SURE * self.noise)
        least = np.where(usual > 0.0, np.maximum(least, PRESSED * self.usual), np.inf)
        often = (self.height > least).sum(axis=0) >= LEAST_READINGS
        often |= ((self.height > least) & self.beside).any(axis=0)
        held = self.height > np.maximum(STANDS_OUT * self.noise, PRESSED * self.usual)
        row, count = held, int(np.ceil(2.0 * self.hold))
        for _ in range(count - 1):
            row = row[:-1] & held[len(held) - len(row) + 1 :]
        return np.asarray(often | row.any(axis=0))

    @cached_property
    def felt(self) -> Bools:
        """Taxels (L,) that some touch is read by, whether at their place or not."""
        return np.asarray((self.height > PRESSED * self.usual).any(axis=0))

    def _around(self, taxel: int) -> Ints:
        return np.asarray(self.near[taxel][self.near[taxel] != taxel])

    def moved(self, taxel: int) -> bool:
        """Whether the load around a taxel came and went, from one side and then from another."""
        around = self._around(taxel)
        if len(around) < 2 or not self.strongest[taxel] or self.beside[:, taxel].mean() > 1.0 - LEAST_ALONE:
            return False
        loads = np.maximum(self.height[:, around], 0.0)
        total = loads.sum(axis=1)
        at = int(np.argmax(self.load[:, taxel]))
        least = max(PASSING * total[at], PRESSED * self.usual * np.sqrt(len(around)))
        there = total >= least
        size = np.linalg.norm(loads, axis=1)
        cosine = loads[there] @ loads[at] / np.maximum(size[there] * size[at], 1e-300)
        return bool(cosine.min(initial=1.0) < MOVED)


def touch_response(
    counts: Floats, patch: Patch, noise: Floats, direction: int, silent: Bools
) -> TouchResponse:
    """Look for touches in counts (T, L), and at what all taxels read meanwhile.

    Parameters
    ----------
    counts : (T, L) array, counts
        NaN where a taxel did not answer.
    patch : Patch
    noise : (L,) array, counts
        Of one reading.
    direction : int
        Sign of the change under pressure; 0 for that of the larger changes.
    silent : (L,) bool array
        Taxels that tell nothing of a load: absent, constant and noisy ones.
    """
    rounding = 12**-0.5 if whole_numbers(counts) else 0.0
    noise = np.maximum(noise, rounding)
    hold = readings_per_value(counts)
    counts, group = _shortened(counts)
    near = _near(patch)
    signed = counts * (direction or _direction(counts[:, ~silent]))
    usual = max(float(np.median(noise[~silent])) if (~silent).any() else 0.0, rounding)
    noise, usual, hold = noise / np.sqrt(group), usual / np.sqrt(group), max(hold / group, 1.0)
    height, beside = _heights(signed, near, silent, usual)
    height = np.nan_to_num(height)
    least = LOAD * np.maximum(noise, usual)  # no jump of noise
    felt = ~silent & (height > least)
    load = _load(np.where(felt, height, 0.0), patch, near, silent)
    return TouchResponse(height, load, beside, noise, usual, near, hold, silent)


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


def _heights(signed: Floats, near: Ints, silent: Bools, usual: float) -> tuple[Floats, Bools]:
    """Change from rest (T, L), rest by the readings in which no neighbour is touched, as it drifts.

    And where one is, (T, L).

    A taxel that is touched all the time rests at its lowest readings.
    """
    gone = np.isnan(signed).all(axis=0)
    low = np.zeros(signed.shape[1])
    low[~gone] = np.nanpercentile(signed[:, ~gone], 20.0, axis=0)
    height = signed - low
    high = np.where(silent, 0.0, np.nan_to_num(height))
    touched, rows = np.zeros(high.shape, np.bool_), np.arange(high.shape[1])
    for column in near.T:
        touched |= (high[:, column] > PRESSED * usual) & (column != rows)
    quiet = np.where(touched, np.nan, height)
    parts = np.array_split(np.arange(len(height)), min(SEGMENTS, max(len(height) // 16, 1)))
    levels = np.full((len(parts), height.shape[1]), np.nan)
    for row, part in enumerate(parts):
        enough = (~np.isnan(quiet[part])).sum(axis=0) > 2
        levels[row, enough] = median(quiet[part][:, enough])
    at, middles = np.arange(len(height)), np.array([part.mean() for part in parts])
    if len(parts) > 1:  # a drift goes on to both ends
        ends = 1.5 * levels[[0, -1]] - 0.5 * levels[[1, -2]]
        levels = np.vstack([ends[0], levels, ends[1]])
        middles = np.concatenate([at[:1], middles, at[-1:]])
    for taxel in np.flatnonzero(np.isfinite(levels).any(axis=0)):
        known = np.isfinite(levels[:, taxel])
        height[:, taxel] -= np.interp(at, middles[known], levels[known, taxel])
    return height, touched


def _load(height: Floats, patch: Patch, near: Ints, silent: Bools) -> Floats:
    """Load (T, L) that neighbours feel on all sides that have any.

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
    return np.where(told, load, 0.0)
