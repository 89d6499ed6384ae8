"""Level shifts of taxels that share a board, found and taken off reading by reading.

Where an insole's cable or connector is pressed, all taxels behind it read some counts less or more
from one reading to the next, by nearly the same number, and their noise changes: that is no
pressure. A press has another size on each taxel and leaves the noise as it was. A taxel's level and
the size of its shift are estimated together (Kalman filter of two states; Durbin and Koopman 2012,
Time Series Analysis by State Space Methods, chapter 4), so that what was learnt of a shift holds
when it comes again, and both are known better when it goes.
"""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats

WINDOW = 9  # readings, of which levels and noise are judged
BEFORE = 50  # readings, since which a level may have shifted
GROUP = 6  # taxels that shift together, at least
TOGETHER = 4  # readings, within which they do
NOISE_CHANGE = 2.5  # times as noisy is another noise
ALIKE = 0.25  # of the median shift: the spread of a group's
REPEATS = 2.5  # readings that tell as much as an independent one: boards measure less often
LEAST_NOISE = 0.005  # of the span
TRIGGER = 5.0  # deviations of the noise
BOUND = 2.0  # deviations, to which what is new counts (Huber)
SLOW, SLOWER = 100.0, 250.0  # readings, over which noise is averaged: usual, of a shifted taxel
FAR = 3.0  # spans from rest: such a reading is missing
HOLD = 50  # readings, for which an answer outlives a missing one
BEYOND = -0.5, 1.5  # spans, between which a level is answered


class LevelTracker:
    """Levels of L taxels, causally; each reading is taken in once.

    Parameters
    ----------
    rest, span : (L,) array, counts
        Level at rest, and how far from there it goes under the highest pressure, with the sign of
        that.
    step : (L,) array, counts
        From a reading to one soon after, beyond which a change may be a shift.
    drive : (L,) array, counts² per reading
        Variance of the change of the level, as of a random walk.
    shift, shift_std : (L,) array, counts
        What is known of each taxel's shift; NaN of one that is not.
    bounded : bool
        Levels beyond rest, or far beyond the span, are none that a pressure gives.

    Attributes
    ----------
    shifted : (L,) bool array
        Taxels whose level is shifted now.
    """

    def __init__(
        self,
        rest: Floats,
        span: Floats,
        step: Floats,
        drive: Floats,
        shift: Floats,
        shift_std: Floats,
        bounded: bool = True,
    ) -> None:
        self._rest, self._span, self._step, self._drive = rest, span, step, drive
        self._bounds = BEYOND if bounded else (-np.inf, np.inf)
        self._shift = np.nan_to_num(shift)
        self._var_shift = np.where(np.isnan(shift), np.inf, np.square(shift_std))
        self._floor = np.square(LEAST_NOISE * span)
        self._noise = np.array(self._floor)  # variance of a reading, not shifted
        self._rough = np.array(self._floor)  # of a reading, shifted
        self._level, self._var, self._cov = np.array(rest), np.array(self._floor), 0.0 * rest
        self._recent = np.tile(rest, (2 * WINDOW, 1))
        self._levels, self._noises = np.tile(rest, (BEFORE, 1)), np.tile(self._floor, (BEFORE, 1))
        self._group = 0.0, 0.0, 0  # size and spread of the last shift, until which taxels join it
        self._fresh = np.zeros(len(rest), np.bool_)  # may be shifting still
        self._waits = np.zeros(len(rest), np.int64)  # readings since a change that is judged
        self._missing = np.zeros(len(rest), np.int64)
        self._taken = 0
        self.shifted: NDArray[np.bool_] = np.zeros(len(rest), np.bool_)

    def update(self, readings: Floats, shifted: NDArray[np.bool_] | None = None) -> Floats:
        """Levels (L,) by readings (L,), counts; NaN of a taxel that has not answered for long.

        Which taxels are shifted is found, unless `shifted` (L,) says so.
        """
        here, there = self._take_in(readings)
        if shifted is not None:
            self._waits[:] = 0
            self._cov = np.where(shifted & ~self.shifted, 0.0, self._cov)
            self.shifted = np.array(shifted)
        elif self._taken > 2 * BEFORE:  # by then noise is known
            self._wait(here, there)
            self._judge()
        self._var = self._var + self._drive
        direct = there & ~self.shifted & (self._waits == 0)
        self._measure(here, direct, self._noise)
        self._level = np.where(direct, here, self._level)
        if self._taken > WINDOW:
            share = 1.0 / min(SLOW, self._taken - WINDOW)
            spread = np.maximum(_noise(self._last(WINDOW)), self._floor)
            self._noise = np.where(
                direct, self._noise + share * (spread - self._noise), self._noise
            )
        if self.shifted.any():
            self._follow(here, self.shifted & there)
            if shifted is None:
                self._leave(here)
        self._levels[self._taken % BEFORE] = self._level
        self._noises[self._taken % BEFORE] = self._noise
        parts = (self._level - self._rest) / self._span
        away = (parts < self._bounds[0]) | (parts > self._bounds[1])
        answers = (direct | (self.shifted & there)) & ~away
        self._missing = np.where(answers, 0, self._missing + 1)
        return np.where(self._missing > HOLD, np.nan, self._level)

    def _take_in(self, readings: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Readings (L,), in the place of those missing what was expected; and which are there."""
        offset = np.where(self.shifted, self._shift, 0.0)
        known = np.where(np.isnan(readings), np.inf, readings)
        there = np.abs(known - offset - self._rest) <= FAR * np.abs(self._span)
        if self._taken == 0:
            self._level = np.where(there, known, self._rest)
            self._recent[:] = self._level
            self._missing[~there] = HOLD
        here = np.where(there, known, self._level + offset)
        self._recent[self._taken % len(self._recent)] = here
        self._taken += 1
        return here, there

    def _last(self, count: int) -> Floats:
        rows = (self._taken - 1 - np.arange(count)) % len(self._recent)
        return np.asarray(self._recent[rows])

    def _wait(self, here: Floats, there: NDArray[np.bool_]) -> None:
        """Wait where levels of several taxels change at once, until it is clear why."""
        limit = np.maximum(self._step, TRIGGER * np.sqrt(self._noise))
        starts = there & ~self.shifted & (np.abs(here - self._level) > limit)
        self._waits = np.where(self._waits > 0, self._waits + 1, np.where(starts, 1, 0))
        waiting = self._waits > 0
        if not waiting.any():
            return
        several = np.count_nonzero(waiting) >= GROUP
        tested = self._waits >= (WINDOW if several else TOGETHER)
        if tested.any():
            rough = np.sqrt(_noise(self._last(WINDOW)) / self._noise)[tested]
            if not several or np.median(rough) < NOISE_CHANGE:
                self._waits[tested] = 0  # pressed
        self._waits[self._waits >= BEFORE] = 0

    def _judge(self) -> None:
        """Shift those whose levels have changed alike since some readings ago, and whose noise."""
        if self._taken >= self._group[2]:
            self._fresh[:] = False
        row = self._taken % BEFORE  # the oldest
        before, noise = self._levels[row], self._noises[row]
        window = self._last(2 * WINDOW)
        limit = np.maximum(self._step, TRIGGER * np.sqrt(noise))
        can = ~self.shifted | self._fresh
        open_still = self._taken < self._group[2]
        if (
            not open_still
            and not (can & (np.abs(window.mean(axis=0) - before) > limit / 2.0)).any()
        ):
            return
        late, early = (np.median(half, axis=0) - before for half in np.split(window, 2))
        least = np.where(late * early > 0.0, np.minimum(np.abs(late), np.abs(early)), 0.0)
        past = window[: -(WINDOW // 2)]  # since then surely, where both halves have changed
        change, after = past.mean(axis=0) - before, _noise(past)
        error = np.sqrt(after * REPEATS / len(past))
        rough = can & (least > limit) & (after > NOISE_CHANGE**2 * noise)
        self._find_group(change[rough], error[rough])
        size, spread, until = self._group
        if self._taken < until:
            near = np.minimum(4.0 * np.hypot(spread, error), abs(size) / 2.0)
            joins = (
                can & (least > np.maximum(abs(size), limit) / 2.0) & (np.abs(change - size) < near)
            )
            self._shift_group(joins, change, error, after)

    def _find_group(self, change: Floats, error: Floats) -> None:
        """Size, spread and end of a shift, if changes of taxels whose noise changed are alike."""
        same = np.sign(change) == np.sign(np.sum(np.sign(change)))
        change, error = change[same], error[same]
        if len(change) < GROUP:
            return
        size, typical = float(np.median(change)), float(np.median(error))
        spread = 1.4826 * float(np.median(np.abs(change - size)))
        if spread < np.hypot(ALIKE * size, 1.5 * typical):
            spread = max(spread**2 - typical**2, (ALIKE / 4.0 * size) ** 2) ** 0.5
            until = self._group[2]
            ends = until if until > self._taken else self._taken + BEFORE - 2 * WINDOW
            self._group = size, spread, ends

    def _shift_group(
        self, which: NDArray[np.bool_], change: Floats, error: Floats, noise: Floats
    ) -> None:
        """Shift taxels, by what their levels have changed and the noise that they now have."""
        size, spread, _ = self._group
        row = self._taken % BEFORE
        unlike = np.square(self._shift - change) > 16.0 * (error**2 + self._var_shift)
        new = which & (np.isinf(self._var_shift) | unlike | self._fresh)
        self._fresh |= new
        self._shift[new], self._var_shift[new], self._cov[which] = size, spread**2, 0.0
        self._level[which] = self._levels[row][which]
        self._noise[which] = self._noises[row][which]
        self._var[which] = self._noise[which] + BEFORE * self._drive[which]
        self._rough[which] = np.maximum(noise, self._floor)[which]
        self._waits[which] = 0
        self.shifted |= which
        self._measure_shifted(change + self._level, which, error**2)

    def _measure(self, here: Floats, which: NDArray[np.bool_], noise: Floats) -> None:
        """Level by a reading that is not shifted; what it says of the shift that was."""
        gain = self._var / (self._var + noise)
        of_shift = self._cov / (self._var + noise)
        new = here - self._level
        self._level = np.where(which, self._level + gain * new, self._level)
        self._shift = np.where(which, self._shift + of_shift * new, self._shift)
        self._var_shift = np.where(which, self._var_shift - of_shift * self._cov, self._var_shift)
        self._cov = np.where(which, self._cov * (1.0 - gain), self._cov)
        self._var = np.where(which, self._var * (1.0 - gain), self._var)

    def _measure_shifted(self, here: Floats, which: NDArray[np.bool_], noise: Floats) -> None:
        """Level and shift by a reading of their sum."""
        for_level = (self._var + self._cov)[which]
        for_shift = (self._cov + self._var_shift)[which]
        total = for_level + for_shift + noise[which]
        bound = BOUND * np.sqrt(total)
        new = np.clip((here - self._level - self._shift)[which], -bound, bound)
        self._level[which] += for_level / total * new
        self._shift[which] += for_shift / total * new
        self._var[which] -= for_level**2 / total
        self._cov[which] -= for_level * for_shift / total
        self._var_shift[which] -= for_shift**2 / total

    def _follow(self, here: Floats, which: NDArray[np.bool_]) -> None:
        """Level of shifted taxels, as smooth as their noise wants it."""
        bound = 3.0 * np.sqrt(self._rough)
        new = np.clip(here - self._level - self._shift, -bound, bound)
        share = np.where(which, 1.0 / SLOWER, 0.0)
        self._rough = np.maximum(self._rough + share * (np.square(new) - self._rough), self._floor)
        self._measure_shifted(here, which, REPEATS * self._rough)

    def _leave(self, here: Floats) -> None:
        """Back to where a level was: by noise and level of the last readings."""
        window = self._last(2 * WINDOW)
        middle = window.mean(axis=0)
        before = self._levels[self._taken % BEFORE]  # the oldest
        nearer = np.abs(middle - before) < np.abs(middle - before - self._shift)
        quiet = NOISE_CHANGE**2 * _noise(window) < self._rough
        back = self.shifted & quiet & nearer
        if np.isfinite(self._bounds[0]):
            unloaded = (self._rest - self._level) * np.sign(self._span) > np.abs(self._shift) / 2.0
            back |= self.shifted & unloaded
        if back.any():
            self.shifted &= ~back
            self._level = np.where(back, before, self._level)
            self._measure(middle, back, self._noise)
            self._level = np.where(back, here, self._level)


def _noise(window: Floats) -> Floats:
    """Variance (L,) of readings (n, L) about a line in time."""
    time = np.arange(len(window)) - (len(window) - 1) / 2.0
    line = time @ window / np.sqrt(time @ time)
    return np.asarray(np.maximum(window.var(axis=0) - np.square(line) / len(window), 0.0))
