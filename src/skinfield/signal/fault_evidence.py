"""Evidence of faults in a recording: constancy, noise, answers to touch; each with a probability.

A probability is Bayes' rule: one taxel in a hundred is broken, and a healthy one does what was seen
as often as the other taxels of the recording tell.
"""

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.signal.boards import Bools, Convention
from skinfield.signal.calibration import Calibration
from skinfield.signal.noise import is_touched, usual_deviation
from skinfield.signal.stationary import (
    LEAST_READINGS,
    MOVING,
    deviation,
    fast_noise,
    level_and_noise,
    median,
    readings_per_value,
    whole_numbers,
)
from skinfield.signal.touch_response import TouchResponse, touch_response
from skinfield.skin import Patch

BROKEN = 0.01  # taxels, before anything is seen
CERTAIN = 0.9  # least probability of a verdict
RARE = BROKEN / (1.0 - BROKEN) * (1.0 - CERTAIN) / CERTAIN  # chance, at which it is reached
FEWEST_TAXELS = 5  # that tell how often a healthy one does what was seen
LEAST_CHANGES = 10  # that nearly all varying taxels must have shown before one without any is dead
# The same of steps, which are changes by two counts or more where all numbers are whole. A taxel
# whose noise is less than half a count holds one value for as long as its level lies in the middle
# of that count, and changes in every other reading where its level lies between two: neither how
# often others change by one count, nor how often it did before, says how often it should.
LEAST_STEPS = 3
STUCK_READINGS = 50  # least length of a final run of one value
STUCK_CHANGES = 20.0  # steps that a taxel would have shown in that run at its own earlier rate, and
# half of which it must have shown before
STUCK_LONGER = 3.0  # times its longest earlier run
TAXELS_DIFFER = 0.4  # at least, standard deviation of the logarithm of their noise, and as it ages
APART = 3.5  # of these deviations, that no healthy taxel is from the others: 4 times their noise
NINE_IN_TEN = 1.2816  # deviations, above which one in ten of a normal distribution lies
LOADED = 0.2  # part of its load by which a pressed taxel may change from reading to reading
CLIPPED = 0.1  # of all values are the lowest, from which on a board clips there
HALF = (0.5 - 0.5 / np.pi) ** -0.5  # deviations of a normal distribution in one of its upper half
FAR = 10.0  # usual deviations from rest
OF_VALUE = 0.05  # part of a value's height that is a load beside it
LEAST_BOARD = 3  # taxels of a board that is judged as one
EXPLAINED = 0.5  # part of what a taxel reads, that a sum of its neighbours does: it is with them
WEAK = 0.1  # part of a usual response, that a taxel without one does not reach


def probability(healthy: float) -> float:
    """That a taxel is broken, which a healthy one looks like so often."""
    return BROKEN / (BROKEN + (1.0 - BROKEN) * healthy)


def chance_of_none(shown: Ints, number: Ints, readings: int) -> float:
    """How often a taxel like the others shows nothing in so many readings.

    Parameters
    ----------
    shown, number : (K,) int arrays
        Readings in which each of the others shows something, of how many.
    readings : int

    Notes
    -----
    Shares are taken as of a beta distribution, by their mean and variance beside that of counting:
    E[(1 - share)^readings].
    """
    from scipy.special import betaln

    if len(shown) < FEWEST_TAXELS:
        return 1.0
    share = shown / number
    mean = float(np.clip(share.mean(), 1e-6, 1.0 - 1e-6))
    counting = mean * (1.0 - mean) * float(np.mean(1.0 / number))
    spread = max(float(share.var()) - counting, 1e-6 * mean * (1.0 - mean))
    both = max(mean * (1.0 - mean) / spread - 1.0, 1e-3)
    a, b = mean * both, (1.0 - mean) * both
    return float(np.exp(betaln(a, b + readings) - betaln(a, b)))


class Verdict(IntEnum):
    """What is wrong with a taxel over a recording."""

    OK = 0
    ABSENT = 1
    DEAD = 2
    STUCK = 3
    SATURATED = 4
    NOISY = 5
    FROZEN = 6
    TEMPERATURE = 7
    SWAPPED = 8
    LEFT_OUT = 9


class TaxelFault(NamedTuple):
    """Fault of taxels (K,), how sure it is, what shows it, of all or of each, and since when."""

    kind: Verdict
    taxels: Ints
    probability: float
    evidence: str
    since: int = 0


@dataclass(frozen=True, eq=False)
class Evidence:
    """A recording as faults are looked for in it.

    Parameters
    ----------
    counts : (T, L) array, counts
    patch : Patch, optional
    convention : Convention, optional
    """

    counts: Floats
    patch: Patch | None
    convention: Convention | None

    @cached_property
    def absent(self) -> Bools:
        """Taxels (L,) that never answer."""
        return np.asarray(np.isnan(self.counts).all(axis=0))

    @cached_property
    def quiet(self) -> Bools:
        """Where (T, L) neither a taxel nor a neighbour is touched, as far as places tell."""
        if self.patch is None:
            return np.ones(self.counts.shape, np.bool_)
        apart = self.counts - median(self.counts)
        return ~is_touched(apart, usual_deviation(apart), self.patch.neighbours)

    @cached_property
    def changes(self) -> Bools:
        """Whether (T - 1, L) the value changes; never across NaN."""
        return np.asarray(self._step > 0.0)

    @cached_property
    def steps(self) -> Bools:
        """Whether (T - 1, L) the value changes by more than rounding makes it."""
        return np.asarray(self._step > (1.5 if whole_numbers(self.counts) else 0.0))

    @cached_property
    def _step(self) -> Floats:
        return np.abs(np.nan_to_num(np.diff(self.counts, axis=0)))

    @cached_property
    def varies(self) -> Bools:
        """Taxels (L,) whose value ever changes."""
        seen = ~np.isnan(self.counts)
        first = np.where(seen, self.counts, np.inf).min(axis=0)
        last = np.where(seen, self.counts, -np.inf).max(axis=0)
        return np.asarray(last > first)

    @cached_property
    def value(self) -> Floats:
        """Median (L,); NaN of an absent taxel."""
        return median(self.counts)

    @cached_property
    def lowest(self) -> float:
        """Where the board clips; NaN if it does not."""
        lowest = float(np.nanmin(self.counts))
        at = self.counts[:, self.varies] == lowest
        return lowest if at.size and at.mean() >= CLIPPED else float("nan")

    @cached_property
    def decided(self) -> bool:
        """Whether nearly all taxels change often enough to miss that of one."""
        constant = ~self.varies & ~self.absent
        if self.patch is None and constant.sum() > self.varies.sum():
            return False
        enough = (self.changes, LEAST_CHANGES), (self.steps, LEAST_STEPS)
        return all(self._nearly_all(seen, least) for seen, least in enough)

    def _nearly_all(self, seen: Bools, least: int) -> bool:
        """Whether nine in ten varying taxels show so many, for as long as they are not touched."""
        calm = self.quiet[1:] & self.quiet[:-1]
        judged = self.varies & (calm.sum(axis=0) >= min(LEAST_READINGS, len(calm)))
        number = (seen & calm).sum(axis=0)[judged]
        return bool(len(number) and np.percentile(number, 10) >= least)

    @cached_property
    def usual(self) -> float:
        """Deviation of the median taxel, in the quieter readings."""
        return usual_deviation(self.counts - self.value)

    @cached_property
    def rest(self) -> float:
        """What most taxels rest at."""
        if np.isfinite(self.lowest):
            return self.lowest
        known = np.nan if self.convention is None else self.convention.rest
        return float(known) if np.isfinite(known) else float(np.nanmedian(self.value))

    def far(self, value: Floats) -> Bools:
        """Whether values are farther from rest than taxels' rests are from each other."""
        apart = np.abs(self.value - self.rest)
        spread = 1.4826 * float(np.nanmedian(apart[self.varies])) if self.varies.any() else 0.0
        return np.asarray(np.abs(value - self.rest) > FAR * max(self.usual, spread, 0.1))

    @cached_property
    def touches(self) -> TouchResponse:
        """What taxels read while touches peak on others."""
        assert self.patch is not None
        noisy = too_noisy(self, None)
        direction = 0 if self.convention is None else self.convention.direction
        silent = self.absent | ~self.varies
        silent[[each for found in noisy for each in found.taxels]] = True
        return touch_response(self.counts, self.patch, self._known_noise(), direction, silent)

    @cached_property
    def noise(self) -> Floats:
        """Noise (L,) in the readings in which none is touched; NaN where too few are known."""
        enough = (self.quiet.sum(axis=0) >= LEAST_READINGS) | (self.patch is None)
        counts = np.where(self.quiet & enough, self.counts, np.nan)
        return np.where(enough, fast_noise(counts, readings_per_value(self.counts)), np.nan)

    def _known_noise(self) -> Floats:
        """The same before the board clips it, the median taxel's where too few are known."""
        clipped = HALF if np.isfinite(self.lowest) else 1.0
        known = np.isfinite(self.noise) & self.varies
        if not known.any():
            whole = fast_noise(self.counts, readings_per_value(self.counts))
            return np.nan_to_num(whole) * clipped
        return np.where(known, self.noise, float(np.median(self.noise[known]))) * clipped

    # ---- constant taxels

    def constant_chance(self, readings: int | None = None) -> float:
        """How often a healthy taxel repeats one value in so many readings; default all."""
        calm = self.quiet[1:] & self.quiet[:-1]
        away = calm & (self.counts[1:] != self.lowest)
        number = away.sum(axis=0)
        judged = self.varies & (number >= min(LEAST_CHANGES, len(calm)))
        shown = (self.changes & away).sum(axis=0)
        return chance_of_none(shown[judged], number[judged], (readings or len(self.counts)) - 1)

    def resting_chance(self, readings: int | None = None) -> float:
        """How often a healthy taxel is clipped in so many readings in a row; default all."""
        number = (self.quiet & ~np.isnan(self.counts)).sum(axis=0)
        judged = self.varies & (number >= min(LEAST_READINGS, len(self.counts)))
        above = self.quiet & (self.counts > self.lowest)
        last = len(self.counts) if readings is None else readings
        return chance_of_none(above.sum(axis=0)[judged], number[judged], last)

    def at_clamp(self, constant: Bools) -> Bools:
        """Constant taxels (L,) at a clamp: the convention's, or the highest that others reach."""
        top, values = np.nanmax(self.counts), np.nan_to_num(self.value, nan=-np.inf)
        reached = (self.counts == top).any(axis=0) & self.varies
        found = (values == top) & bool(reached.any() and self.patch is not None)
        if self.convention is not None:
            found |= self.convention.saturated(self.value)
        return np.asarray(constant & found)

    def pressed_around(self, counts: Floats | None = None) -> Bools:
        """Taxels (L,) beside one that is loaded in counts (L,), or usually; all without places."""
        if self.patch is None:
            return np.ones(len(self.value), np.bool_)
        apart = np.abs((self.value if counts is None else counts) - self.rest)
        load = np.where(self.varies & ~np.isnan(apart), apart, 0.0)
        least = np.maximum(FAR * self.usual, OF_VALUE * apart)
        beside = np.zeros(len(load), np.bool_)
        for one, other in (self.patch.neighbours.T, self.patch.neighbours.T[::-1]):
            np.logical_or.at(beside, one, load[other] > least[one])
        return beside


# ---- faults, each with what shows it


def constant_taxels(seen: Evidence) -> list[TaxelFault]:
    """Taxels that repeat one value: dead near their rest, stuck far from it, or saturated."""
    found = []
    constant = ~seen.varies & ~seen.absent
    clamped, far = seen.at_clamp(constant), seen.far(seen.value)
    resting, pressed = seen.value == seen.lowest, seen.pressed_around()
    chances = seen.constant_chance() if constant.any() else 1.0
    rests = seen.resting_chance() if (constant & resting).any() else 1.0
    for taxel in np.flatnonzero(constant):
        number = int((~np.isnan(seen.counts[:, taxel])).sum())
        held = f"{seen.value[taxel]:g} in all {number} readings"
        if clamped[taxel] and pressed[taxel]:
            kind, p, why = Verdict.SATURATED, 1.0, f"at {held}"
        elif clamped[taxel]:
            kind, p = Verdict.STUCK, probability(min(chances, BROKEN**2))
            why = f"at the clamp {held}, nothing pressing beside it"
        elif resting[taxel]:
            kind, p = Verdict.DEAD, probability(rests)
            why = f"at {held}, where others like it rise now and then"
        elif seen.decided or np.isfinite(seen.lowest):
            kind, p = Verdict.STUCK if far[taxel] else Verdict.DEAD, probability(chances)
            why = f"repeats {held}, where noise should change it"
            why += f"; most rest at {seen.rest:g}" if far[taxel] else ""
        else:
            continue
        found.append(TaxelFault(kind, np.array([taxel]), p, why))
    return found


def frozen_boards(seen: Evidence, broken: Bools, since: Ints) -> list[TaxelFault]:
    """Boards of which all taxels repeat their values, since a reading, while those of others vary.

    Parameters
    ----------
    seen : Evidence
    broken : (L,) bool array
        Taxels found dead or stuck by themselves.
    since : (L,) int array
        From when on.
    """
    found: list[TaxelFault] = []
    if seen.patch is None:
        return found
    boards = np.unique(seen.patch.module)
    constant = ~seen.varies & ~seen.absent
    for board in boards if len(boards) > 1 else ():
        rows = np.flatnonzero((seen.patch.module == board) & ~seen.absent)
        still = broken[rows] | constant[rows]
        others = seen.varies & (seen.patch.module != board)
        if len(rows) < LEAST_BOARD or not still.all() or not others.any():
            continue
        chance = seen.constant_chance()
        if np.isfinite(seen.lowest) and (seen.value[rows] == seen.lowest).all():
            chance = seen.resting_chance()
        known = seen.decided or np.isfinite(seen.lowest)
        p = probability(chance ** (len(rows) / 2.0)) if known else 0.0  # not independent
        p = max(p, probability(BROKEN**2) if broken[rows].any() else 0.0)
        first = int(since[rows].max())
        when = "since the start" if first == 0 else f"since reading {first}"
        values = np.unique(seen.counts[-1, rows][~np.isnan(seen.counts[-1, rows])])
        at = f" at {values[0]:g}" if len(values) == 1 else ""
        why = f"frozen{at} {when}, with all {len(rows)} taxels of board {board}"
        why = f"{why}: board not seen, check wiring"
        found.append(TaxelFault(Verdict.FROZEN, rows, p, why, first))
    return found


def stopped_taxels(seen: Evidence) -> list[TaxelFault]:
    """Taxels whose final run of one value their own past makes incredible.

    The others must go on meanwhile. Healthy ones of a board that clips at rest hold that value.
    """
    run, now, number = _final_run(seen.counts), seen.counts[-1], len(seen.counts)
    held = np.zeros(len(run), np.bool_)
    if seen.convention is not None:
        held |= seen.convention.saturated(now)
    for end in (float(np.nanmin(seen.counts)), float(np.nanmax(seen.counts))):
        if end != seen.lowest:  # the board clips there what is pressed
            several = ((seen.counts == end).any(axis=0) & seen.varies).sum() > 1
            held |= (now == end) & (several | (seen.pressed_around(now) & (seen.patch is not None)))
    for row in np.flatnonzero((now == seen.lowest) & (run >= STUCK_READINGS)):
        held[row] |= probability(seen.resting_chance(int(run[row]))) < CERTAIN
    found = []
    for taxel in np.flatnonzero((run >= LEAST_READINGS) & ~held & seen.varies).tolist():
        first = number - int(run[taxel])
        if seen.changes[first:].any(axis=0).mean() > 0.5 and _stopped(seen, taxel, first):
            why = f"repeats {now[taxel]:g} to the end, while the others go on"
            p = probability(BROKEN**2)
            found.append(TaxelFault(Verdict.STUCK, np.array([taxel]), p, why, first))
    return found


def _stopped(seen: Evidence, taxel: int, first: int) -> bool:
    """Whether a taxel that repeats one value from a reading on should have changed."""
    run = len(seen.counts) - first
    steps = seen.steps[:first, taxel]
    judged = (seen.quiet[1:] & seen.quiet[:-1])[:first, taxel]
    if judged.sum() < LEAST_READINGS:
        judged = np.ones_like(judged)
    if not steps.any() or run < STUCK_LONGER * _longest(steps):
        return False
    number, missed = int(steps[judged].sum()), steps[judged].mean() * run
    if run >= STUCK_READINGS and number >= STUCK_CHANGES / 2 and missed >= STUCK_CHANGES:
        return True
    rare = probability(seen.constant_chance(run)) >= CERTAIN
    return bool(seen.decided and number >= LEAST_STEPS and rare)


def _longest(steps: Bools) -> int:
    """Readings of the longest run without a step, before the last one."""
    return int(np.max(np.diff(np.flatnonzero(steps), prepend=-1)))


def _final_run(counts: Floats) -> NDArray[np.int64]:
    """Readings at the end that hold one value, per taxel; 0 where the last is NaN."""
    same = counts[::-1] == counts[-1]
    run = np.where(same.all(axis=0), len(counts), np.argmin(same, axis=0))
    return np.asarray(run, dtype=np.int64)


def too_noisy(seen: Evidence, calibration: Calibration | None) -> list[TaxelFault]:
    """Taxels far noisier than theirs, or than any of a skin whose taxels differ as they do.

    Where none is touched, as far as that is known: what wavers with its neighbours is no noise.
    """
    from scipy.stats import norm

    noise, hold = seen.noise, readings_per_value(seen.counts)
    told = (np.nan_to_num(noise) > 0.0) & seen.varies
    spread, than = TAXELS_DIFFER, "its calibration says"
    if calibration is not None:
        middle = np.log(np.where(calibration.alive, calibration.noise_std, np.inf))
    elif told.any():
        level, spreads = level_and_noise(np.log(noise[told])[:, None])
        middle = np.full(len(noise), level[0])
        wide = float(np.quantile(np.log(noise[told]), 0.9) - level[0]) / NINE_IN_TEN
        spread, than = max(float(spreads[0]), wide, spread), "that of the median taxel"
        told &= noise >= LOADED * _standing_load(seen, np.where(seen.quiet, seen.counts, np.nan))

    found = []
    for taxel in np.flatnonzero(told).tolist():
        limit = np.exp(middle[taxel] + APART * spread)
        if noise[taxel] > limit and (own := _own_noise(seen, taxel, hold)) > limit:
            own = min(own, noise[taxel])
            p = probability(float(norm.sf((np.log(own) - middle[taxel]) / spread)))
            times = own / np.exp(middle[taxel])
            why = f"noise of {noise[taxel]:.3g} counts, {times:.0f} times {than}"
            found.append(TaxelFault(Verdict.NOISY, np.array([taxel]), p, why))
    return found


def _own_noise(seen: Evidence, taxel: int, hold: float) -> float:
    """Noise of a taxel without what its neighbours show as well, counts."""
    if seen.patch is None:
        return float("inf")
    pairs = seen.patch.neighbours
    around = np.concatenate([pairs[pairs[:, 0] == taxel, 1], pairs[pairs[:, 1] == taxel, 0]])
    around = around[seen.varies[around]]
    lag = int(np.ceil(hold))
    changes = seen.counts[lag:] - seen.counts[:-lag]
    changes = changes[~np.isnan(changes[:, [taxel, *around]]).any(axis=1)]
    if not len(around) or len(changes) < 2 * LEAST_READINGS:
        return float("inf")
    theirs, own = changes[:, around], changes[:, taxel]
    shared = np.linalg.lstsq(theirs, own, rcond=None)[0]
    left = own - theirs @ shared
    freedom = np.sqrt(len(own) / max(len(own) - len(around), 1))
    size = np.sqrt(float(left @ left) / max(float(own @ own), 1e-300)) * freedom
    return float(size * fast_noise(seen.counts[:, [taxel]], hold)[0])


def _standing_load(seen: Evidence, counts: Floats) -> Floats:
    """Median change (L,) from the board's rest if it clips there, else the largest that comes."""
    there = ~np.isnan(counts).all(axis=0)
    load = np.zeros(len(seen.value))
    if np.isfinite(seen.lowest):
        load[there] = np.nanmedian(counts[:, there], axis=0) - seen.lowest
    elif there.any():
        low, high = np.nanpercentile(counts[:, there], [5.0, 95.0], axis=0)
        load[there] = high - low
    return load


def unresponsive_taxels(seen: Evidence) -> list[TaxelFault]:
    """Taxels that no touch around them moves: dead, stuck far from rest, or led by warmth."""
    found = []
    touches = seen.touches
    least = touches.relative
    far, slow = seen.far(seen.value), _drifts(seen)
    for taxel in np.flatnonzero((least < WEAK) & ~touches.answers & ~seen.absent).tolist():
        if not touches.moved(taxel) or touches.explained(taxel) > EXPLAINED:
            continue
        kind = Verdict.DEAD
        why = (
            f"touches that pass over it move it by less than {least[taxel]:.1%} of what others feel"
        )
        if slow[taxel]:
            kind, why = Verdict.TEMPERATURE, f"drifts slowly, as with warmth; {why}"
        elif far[taxel]:
            at = f"holds {seen.value[taxel]:g}, most rest at {seen.rest:g}"
            kind, why = Verdict.STUCK, f"{at}; {why}"
        found.append(TaxelFault(kind, np.array([taxel]), probability(touches.chance(taxel)), why))
    return found


def _drifts(seen: Evidence) -> Bools:
    """Taxels (L,) that move far more slowly than their noise."""
    fast = fast_noise(seen.counts, readings_per_value(seen.counts))
    with np.errstate(invalid="ignore"):
        return np.asarray(deviation(seen.counts) > MOVING * fast)
