"""Response of taxels to touches that pass over them, beside that of their neighbours.

What neighbours read tells what a taxel should: the slope of its readings on the mean of theirs, as
far as they were touched on all sides of it. How healthy taxels differ in it is seen in the
recording itself, so no model of the layer is needed. Only touches that move tell: a hand that holds
on may have a gap between its fingers.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from skinfield.errors import Floats
from skinfield.signal.boards import Bools
from skinfield.signal.stationary import median, readings_per_value, whole_numbers
from skinfield.skin import Patch

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    Links = csr_array[np.float64]

MOST_READINGS = 4000  # that are looked at: of more, means of some in a row
SEGMENTS = 8  # of a recording, whose untouched readings tell the rest
PRESSED = 10.0  # deviations of a touch
LEAST_ALONE = 0.33  # part of the readings, in which nothing touches around a taxel
PASSING = 0.15  # part of the strongest load around a taxel, that tells from where it came
MOVED = 0.7  # cosine of neighbours' loads, down to which it falls as a load moves
FREEDOM = 5.0  # of Student's t, of the logarithm of responses
FEWEST = 8  # taxels that tell how healthy ones respond
ANSWERS, SURE, LEAST_READINGS = 0.3, 4.0, 3  # of a response, deviations; readings of one that is
STANDS_OUT = 6.0  # deviations, of two readings in a row that are no noise
ERRORS = 1.0  # standard errors, that a response may be larger


@dataclass(frozen=True, eq=False)
class TouchResponse:
    """What taxels read while touches pass over them.

    Attributes
    ----------
    height : (T, L) array, counts
        Change from rest, positive under pressure; 0 where a taxel did not answer.
    beside_touched : (T, L) bool array
        Whether a neighbour is touched.
    noise : (L,) array, counts
    usual : float, counts
        Deviation of the median taxel.
    links : (L, L) sparse array
        Ones at the neighbours of each taxel that tell of a load.
    plane : (L, 2) array, m
        Places.
    hold : float
        Readings for which one value is repeated.
    """

    height: Floats
    beside_touched: Bools
    noise: Floats
    usual: float
    links: "Links"
    plane: Floats
    hold: float

    @cached_property
    def around(self) -> Floats:
        """Mean (T, L) of what the neighbours of each taxel read."""
        return mean_around(self.links, self.height)

    @cached_property
    def loaded(self) -> Bools:
        """Taxels (L,) whose neighbours feel a touch some time."""
        return np.asarray((self.around > PRESSED * self.usual).any(axis=0))

    @cached_property
    def felt(self) -> Bools:
        """Taxels (L,) that some touch is read by, whether at their place or not."""
        return np.asarray((self.height > PRESSED * self.usual).any(axis=0))

    @cached_property
    def _power(self) -> Floats:
        return np.where(self.loaded, np.sum(self.around**2, axis=0), np.nan)

    @cached_property
    def balance(self) -> Floats:
        """How evenly (L,) the neighbours of a taxel were touched: 1 on all sides, 0 on one."""
        energy = np.sum(np.maximum(self.height, 0.0) ** 2, axis=0)
        ends = self.links.tocoo()
        way = self.plane[ends.col] - self.plane[ends.row]
        way /= np.maximum(np.linalg.norm(way, axis=1), 1e-300)[:, None]
        drawn, total = np.zeros(self.plane.shape), np.zeros(len(energy))
        np.add.at(drawn, ends.row, energy[ends.col, None] * way)
        np.add.at(total, ends.row, energy[ends.col])
        return np.asarray(1.0 - np.linalg.norm(drawn, axis=1) / np.maximum(total, 1e-300))

    @cached_property
    def response(self) -> Floats:
        """Slope (L,) of a taxel's readings on its neighbours'; NaN where none is touched."""
        return np.asarray(np.sum(self.around * self.height, axis=0) / self._power)

    @cached_property
    def usual_response(self) -> tuple[float, float]:
        """Logarithm of the median response, and its robust deviation; NaN where few tell."""
        told = np.log(self.response[np.nan_to_num(self.response) > 0.0])
        if len(told) < FEWEST:
            return float("nan"), float("nan")
        middle = float(np.median(told))
        return middle, 1.4826 * float(np.median(np.abs(told - middle)))

    @cached_property
    def relative(self) -> Floats:
        """Largest credible response (L,) of each taxel, 1: that of the median; NaN if none.

        To what touches it on all sides: a touch that stays beside a taxel is not on it.
        """
        error = self.noise * np.sqrt(self.hold / self._power)
        most = np.maximum(self.response, 0.0) + ERRORS * error
        return np.asarray(most / (np.exp(self.usual_response[0]) * np.maximum(self.balance, 1e-9)))

    def chance(self, taxel: int) -> float:
        """How often a healthy taxel responds as little as this one."""
        from scipy.stats import t

        spread = max(self.usual_response[1], 0.1)
        return float(t.cdf(np.log(max(self.relative[taxel], 1e-300)) / spread, FREEDOM))

    @cached_property
    def answers(self) -> Bools:
        """Taxels (L,) that were touched some time, whether something surrounded them or not.

        Some readings reach part of a usual response, or one does while a neighbour is touched, or
        some in a row stand out, as no jump does.
        """
        usual = np.exp(np.nan_to_num(self.usual_response[0])) * self.around.max(axis=0, initial=0.0)
        least = np.maximum(ANSWERS * usual, SURE * self.noise)
        least = np.where(self.loaded, np.maximum(least, PRESSED * self.usual), np.inf)
        reached = self.height > least
        often = (reached.sum(axis=0) >= LEAST_READINGS) | (reached & self.beside_touched).any(
            axis=0
        )
        held = self.height > np.maximum(STANDS_OUT * self.noise, PRESSED * self.usual)
        row, count = held, int(np.ceil(2.0 * self.hold))
        for _ in range(count - 1):
            row = row[:-1] & held[len(held) - len(row) + 1 :]
        return np.asarray(often | row.any(axis=0))

    def explained(self, taxel: int) -> float:
        """Part of what a taxel reads that its neighbours' readings add up to."""
        theirs, own = self.height[:, self.links[[taxel]].indices], self.height[:, taxel]
        fit = np.linalg.lstsq(theirs, own, rcond=None)[0]
        left = own - theirs @ fit
        return 1.0 - float(left @ left) / max(float(own @ own), 1e-300)

    def moved(self, taxel: int) -> bool:
        """Whether the load around a taxel came and went, from one side and then from another."""
        near = self.links[[taxel]].indices
        if (
            len(near) < 2
            or not self.loaded[taxel]
            or self.beside_touched[:, taxel].mean() > 1 - LEAST_ALONE
        ):
            return False
        loads = np.maximum(self.height[:, near], 0.0)
        total = loads.sum(axis=1)
        at = int(np.argmax(total))
        least = max(PASSING * total[at], PRESSED * self.usual * np.sqrt(len(near)))  # no noise
        there = total >= least
        size = np.linalg.norm(loads, axis=1)
        cosine = loads[there] @ loads[at] / np.maximum(size[there] * size[at], 1e-300)
        return bool(cosine.min(initial=1.0) < MOVED)


def mean_around(links: "Links", height: Floats) -> Floats:
    """Mean (T, N) of the taxels that each of N rows links to; 0 where it links to none."""
    number = np.maximum(links.sum(axis=1), 1.0)
    return np.asarray((links @ height.T).T / number)


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
    signed = counts * (direction or _direction(counts[:, ~silent]))
    usual = max(float(np.median(noise[~silent])) if (~silent).any() else 0.0, rounding)
    links = _links(patch, silent)
    height, beside = _heights(signed, links, usual / np.sqrt(group))
    return TouchResponse(
        np.nan_to_num(height), beside, noise / np.sqrt(group), usual / np.sqrt(group), links,
        patch.plane, max(hold / group, 1.0),
    )  # fmt: skip


def _links(patch: Patch, silent: Bools) -> "Links":
    """Ones (L, L) at the neighbours of each taxel, silent ones left out."""
    from scipy.sparse import csr_array

    rows, near = np.concatenate([patch.neighbours, patch.neighbours[:, ::-1]]).T
    real = ~silent[near]
    return csr_array((np.ones(int(real.sum())), (rows[real], near[real])), shape=2 * (len(patch),))


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


def _heights(signed: Floats, links: "Links", usual: float) -> tuple[Floats, Bools]:
    """Change from rest (T, L), rest by the readings in which no neighbour is touched, as it drifts.

    And where one is, (T, L).

    A taxel that is touched all the time rests at its lowest readings.
    """
    gone = np.isnan(signed).all(axis=0)
    low = np.zeros(signed.shape[1])
    low[~gone] = np.nanpercentile(signed[:, ~gone], 20.0, axis=0)
    height = signed - low
    high = (np.nan_to_num(height) > PRESSED * usual).astype(np.float64)
    touched = np.asarray(links @ high.T).T > 0.0
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
