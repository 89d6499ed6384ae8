"""Faults of taxels: absent, dead, stuck, saturated, noisy."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError
from skinfield.signal.boards import Bools, Convention
from skinfield.signal.calibration import Calibration
from skinfield.signal.noise import is_touched, usual_deviation
from skinfield.signal.stationary import (
    LEAST_READINGS,
    fast_noise,
    median,
    readings_per_value,
    recorded,
    whole_numbers,
)
from skinfield.skin import Patch


class Verdict(IntEnum):
    """What is wrong with a taxel over a recording."""

    OK = 0
    ABSENT = 1
    DEAD = 2
    STUCK = 3
    SATURATED = 4
    NOISY = 5


_MEANING = {
    Verdict.ABSENT: "never answer",
    Verdict.DEAD: "never change while the others do",
    Verdict.STUCK: "stop changing while the others go on",
    Verdict.SATURATED: "are at a clamp in more than half of the readings",
    Verdict.NOISY: "are far noisier than they should be",
}


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
TOO_NOISY = 5.0  # times the noise of its calibration, or else of the median taxel
SATURATED_SHARE = 0.5  # of its readings
APART = 4.5  # deviations of the logarithm of taxels' noise, that none is from the others


@dataclass(frozen=True, eq=False)
class Faults:
    """Verdict per taxel.

    Attributes
    ----------
    verdict : (L,) int8 array
        Of `Verdict`.
    since : (L,) int array
        First reading of the fault: 0 for all but stuck taxels; -1 where there is none.
    decided : bool
        False where the recording is too short or too smooth to tell a dead taxel from a quiet one.
    sentences : tuple of str
        What was found, for people.
    """

    verdict: NDArray[np.int8]
    since: NDArray[np.int64]
    decided: bool
    sentences: tuple[str, ...]

    @property
    def usable(self) -> Bools:
        """Taxels to keep, (L,): all but absent, dead, stuck and noisy ones.

        A saturated taxel lives: its readings at the clamp are invalid, the others are not.
        """
        return np.isin(self.verdict, (Verdict.OK, Verdict.SATURATED))


def find_faults(
    counts: Floats,
    patch: Patch | None = None,
    convention: Convention | None = None,
    *,
    calibration: Calibration | None = None,
) -> Faults:
    """Judge each taxel over a recording.

    Parameters
    ----------
    counts : (T, L) array, counts
        NaN where a taxel did not answer.
    patch : Patch, optional
        Of the taxels: noise is then judged where no neighbour is touched.
    convention : Convention, optional
        Knows the clamps; without it no taxel is found saturated.
    calibration : Calibration, optional
        Its noise is what a taxel should have; without it, the median taxel's.

    Raises
    ------
    InputError
        If there is no number, or the width is not that of the calibration.
    """
    counts = recorded(counts)
    taxels = counts.shape[1]
    if calibration is not None and len(calibration) != taxels:
        raise InputError(
            f"counts has {taxels} columns, expected {len(calibration)} as the calibration of "
            f"{calibration.patch_name!r} has: pick the taxels of the port with "
            "files.recordings.readings_for"
        )
    clamped = np.zeros(counts.shape, bool) if convention is None else convention.saturated(counts)
    absent = np.isnan(counts).all(axis=0)
    step = np.abs(np.nan_to_num(np.diff(counts, axis=0)))  # never across NaN
    changed, stepped = step > 0.0, step > (1.5 if whole_numbers(counts) else 0.0)
    varying = np.asarray(changed.any(axis=0))
    decided = _enough(changed, varying, LEAST_CHANGES)
    decided = decided and _enough(stepped, varying, LEAST_STEPS)
    run = _final_run(counts)
    verdict = np.zeros(taxels, np.int8)
    verdict[_too_noisy(counts, patch, calibration) & varying] = Verdict.NOISY
    verdict[_stuck(changed, stepped, run, clamped[-1]) & varying] = Verdict.STUCK
    if decided:
        verdict[~varying] = Verdict.DEAD
    verdict[clamped.mean(axis=0) > SATURATED_SHARE] = Verdict.SATURATED
    verdict[absent] = Verdict.ABSENT
    since = np.where(verdict == Verdict.OK, -1, 0)
    since = np.where(verdict == Verdict.STUCK, len(counts) - run, since)
    sentences = _sentences(verdict, since, counts, clamped, decided)
    return Faults(verdict, since, decided, sentences)


def _enough(seen: Bools, varying: Bools, least: int) -> bool:
    """Whether nine in ten varying taxels show at least so many of what was seen (T - 1, L)."""
    count = seen.sum(axis=0)[varying]
    return bool(len(count) and np.percentile(count, 10) >= least)


def _final_run(counts: Floats) -> NDArray[np.int64]:
    """Readings at the end that hold one value, per taxel; 0 where the last is NaN."""
    same = counts[::-1] == counts[-1]
    run = np.where(same.all(axis=0), len(counts), np.argmin(same, axis=0))
    return np.asarray(run, dtype=np.int64)


def _stuck(changed: Bools, stepped: Bools, run: NDArray[np.int64], clamped_now: Bools) -> Bools:
    """Final runs that a taxel's own past, and the others' present, make incredible."""
    stuck = np.zeros(len(run), bool)
    for taxel in np.flatnonzero((run >= STUCK_READINGS) & ~clamped_now):
        before = stepped[: len(stepped) + 1 - run[taxel], taxel]
        if before.sum() < STUCK_CHANGES / 2:
            continue
        at = np.flatnonzero(before)
        longest = int(np.max(np.diff(at, prepend=-1)))
        missed = before.mean() * run[taxel]
        others = changed[len(changed) + 1 - run[taxel] :].any(axis=0).mean()
        stuck[taxel] = (
            missed >= STUCK_CHANGES and run[taxel] >= STUCK_LONGER * longest and others > 0.5
        )
    return stuck


def _too_noisy(counts: Floats, patch: Patch | None, calibration: Calibration | None) -> Bools:
    """Taxels far noisier than theirs, or than any of a skin whose taxels differ as they do."""
    hold = readings_per_value(counts)
    if patch is not None:
        apart = counts - median(counts)
        usual = usual_deviation(apart)
        touched = is_touched(apart, usual, patch.neighbours)
        touched[:, (~touched).sum(axis=0) < LEAST_READINGS] = True  # too few to judge by
        counts = np.where(touched, np.nan, counts)
    noise = fast_noise(counts, hold)
    if calibration is not None:
        expected = np.where(calibration.alive, calibration.noise_std, np.inf)
        return np.asarray((noise > TOO_NOISY * expected) & (expected > 0))
    varied = noise[noise > 0.0]
    if not len(varied):
        return np.zeros(len(noise), bool)
    middle = np.median(np.log(varied))
    spread = 1.4826 * float(np.median(np.abs(np.log(varied) - middle)))
    return np.asarray(noise > np.exp(middle + max(np.log(TOO_NOISY), APART * spread)))


def _sentences(
    verdict: NDArray[np.int8],
    since: NDArray[np.int64],
    counts: Floats,
    clamped: Bools,
    decided: bool,
) -> tuple[str, ...]:
    found = _kinds(verdict, since)
    touched = np.flatnonzero(clamped.any(axis=0) & (verdict != Verdict.SATURATED))
    if len(touched):
        most = int(clamped.sum(axis=0)[touched].max())
        found.append(
            f"{len(touched)} taxels reach a clamp in up to {most} of {len(counts)} readings, "
            f"invalid only there: {rows_text(touched)}"
        )
    if not decided:
        found.append(
            f"in {len(counts)} readings the taxels change too rarely to tell a dead one from a "
            "quiet one: a frozen port, a recording without noise or with less than a count of it, "
            "or too short a one"
        )
    return tuple(found)


def _kinds(verdict: NDArray[np.int8], since: NDArray[np.int64] | None = None) -> list[str]:
    """A sentence on the taxels of each kind of fault."""
    found = []
    for kind, meaning in _MEANING.items():
        rows = np.flatnonzero(verdict == kind)
        if len(rows):
            start = ""
            if since is not None and kind == Verdict.STUCK:
                start = f", the first from reading {since[rows].min()}"
            text = rows_text(rows)
            found.append(f"{len(rows)} of {len(verdict)} taxels {meaning}{start}: {text}")
    return found


def rows_text(rows: NDArray[np.int64]) -> str:
    """Rows in ascending order as text with ranges: 0, 4-7, 9."""
    pieces = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
    return ", ".join(f"{p[0]}-{p[-1]}" if len(p) > 1 else f"{p[0]}" for p in pieces)


SILENT = 2  # stretches at the end without any change, after which a taxel is taken as stuck


def merged_faults(found: Sequence[Faults], lengths: Sequence[int]) -> Faults:
    """Verdict over consecutive stretches of one recording.

    A taxel is absent or dead if it is so in all of them; noisy or saturated if so in more than
    half; stuck if it stops changing in one and never changes again, or does not change in the last
    two. One stretch is returned as it is.

    Parameters
    ----------
    found : sequence of B Faults
        Of `find_faults`, in order.
    lengths : sequence of B int
        Readings of each stretch.
    """
    if len(found) == 1:
        return found[0]
    verdicts = np.array([each.verdict for each in found])
    decided = np.array([each.decided for each in found])
    verdict = np.zeros(verdicts.shape[1], np.int8)
    for kind in (Verdict.NOISY, Verdict.SATURATED):
        verdict[(verdicts == kind).mean(axis=0) > 0.5] = kind
    stuck, since = _stuck_for_good(verdicts, decided)
    verdict[stuck] = Verdict.STUCK
    still = (verdicts == Verdict.DEAD) | (verdicts == Verdict.ABSENT)
    if decided.any():
        verdict[still[decided].all(axis=0)] = Verdict.DEAD
    verdict[(verdicts == Verdict.ABSENT).all(axis=0)] = Verdict.ABSENT
    begin = np.concatenate([[0], np.cumsum(lengths)])
    at = begin[since] + np.array(
        [max(int(found[b].since[taxel]), 0) for taxel, b in enumerate(since)], np.int64
    )
    first = np.where(verdict == Verdict.STUCK, at, np.where(verdict == Verdict.OK, -1, 0))
    sentences = _kinds(verdict)
    if not decided.any():
        sentences.append("the taxels change too rarely to tell a dead one from a quiet one")
    return Faults(verdict, first, bool(decided.any()), tuple(sentences))


def _stuck_for_good(verdicts: NDArray[np.int8], decided: Bools) -> tuple[Bools, NDArray[np.int64]]:
    """Taxels that never change again, and the stretch in which that begins."""
    count = len(verdicts)
    dead = (verdicts == Verdict.DEAD) & decided[:, None]
    silent = np.argmin(np.vstack([dead[::-1], np.zeros((1, dead.shape[1]), bool)]), axis=0)
    before = np.maximum(count - 1 - silent, 0)  # the last stretch with a change
    stops = verdicts[before, np.arange(verdicts.shape[1])] == Verdict.STUCK
    stuck = (silent < count) & (stops | (silent >= SILENT))
    return stuck, np.where(stops, before, np.minimum(before + 1, count - 1))
