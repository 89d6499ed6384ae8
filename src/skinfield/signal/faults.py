"""Faults of taxels: which cannot be trusted, why, how surely; and what the user says to it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_type
from skinfield.signal import fault_evidence as evidence
from skinfield.signal.boards import Bools, Convention
from skinfield.signal.calibration import Calibration
from skinfield.signal.fault_evidence import CERTAIN, Evidence, TaxelFault, Verdict
from skinfield.signal.stationary import recorded
from skinfield.signal.swapped import swapped_taxels
from skinfield.skin import Patch

_MEANING = {
    Verdict.ABSENT: "never answer",
    Verdict.DEAD: "never change while the others do, or feel no touch",
    Verdict.STUCK: "stop changing while the others go on, or hold a value far from rest",
    Verdict.SATURATED: "are at a clamp in more than half of the readings",
    Verdict.NOISY: "are far noisier than they should be",
    Verdict.FROZEN: "are frozen with their whole board",
    Verdict.TEMPERATURE: "follow the temperature, not touch",
    Verdict.SWAPPED: "answer at each other's places",
    Verdict.LEFT_OUT: "are left out as asked",
}
_HELD = (
    Verdict.DEAD,
    Verdict.STUCK,
    Verdict.FROZEN,
    Verdict.ABSENT,
)  # of a taxel that may be still
_BY_TOUCH = (Verdict.DEAD, Verdict.STUCK, Verdict.TEMPERATURE)
SATURATED_SHARE = 0.5  # of its readings


@dataclass(frozen=True, eq=False)
class Faults:
    """Verdict per taxel.

    Attributes
    ----------
    verdict : (L,) int8 array
        Of `Verdict`.
    probability : (L,) array
        That the verdict is right; 0 where there is no fault.
    evidence : tuple of L str
        What shows it, in words; "" where there is no fault.
    since : (L,) int array
        First reading of the fault: 0 for all but stuck and frozen taxels; -1 where there is none.
    decided : bool
        False where the recording is too short or too smooth to tell a dead taxel from a quiet one.
    sentences : tuple of str
        What was found, for people.
    varies, answers : (L,) bool arrays
        Taxels whose value changes, and those seen to feel a touch.
    """

    verdict: NDArray[np.int8]
    probability: Floats
    evidence: tuple[str, ...]
    since: NDArray[np.int64]
    decided: bool
    sentences: tuple[str, ...]
    varies: Bools
    answers: Bools

    @property
    def usable(self) -> Bools:
        """Taxels to keep, (L,): those without a fault, and saturated ones.

        A saturated taxel lives: its readings at the clamp are invalid, the others are not.
        """
        return np.isin(self.verdict, (Verdict.OK, Verdict.SATURATED))

    def chosen(self, keep: Iterable[int] = (), without: Iterable[int] = ()) -> "Faults":
        """Verdicts where the user knows better.

        Parameters
        ----------
        keep : iterable of int
            Rows of taxels that are used whatever was found.
        without : iterable of int
            Rows of taxels that are left out.

        Raises
        ------
        InputError
            If a taxel does not exist, or is in both.
        """
        kept, out = chosen_rows(keep, without, len(self.verdict))
        if not len(kept) and not len(out):
            return self
        verdict, since, probability = (
            self.verdict.copy(),
            self.since.copy(),
            self.probability.copy(),
        )
        words, said = list(self.evidence), []
        if len(overruled := kept[verdict[kept] != Verdict.OK]):
            said.append(f"kept as asked, whatever is said of them: {rows_text(overruled)}")
        verdict[kept], probability[kept], since[kept] = Verdict.OK, 0.0, -1
        verdict[out], probability[out], since[out] = Verdict.LEFT_OUT, 1.0, 0
        for row in kept:
            words[row] = f"kept as asked; {words[row]}" if words[row] else ""
        for row in out:
            words[row] = "left out as asked"
        if len(out):
            said.append(f"left out as asked: {rows_text(out)}")
        return replace(
            self, verdict=verdict, probability=probability, since=since, evidence=tuple(words),
            sentences=(*self.sentences, *said),
        )  # fmt: skip


def chosen_rows(
    keep: Iterable[int], without: Iterable[int], taxels: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows to keep and to leave out; InputError where there is no such taxel, or one is in both."""
    kept, out = taxel_rows("keep", keep, taxels), taxel_rows("without", without, taxels)
    if len(both := np.intersect1d(kept, out)):
        raise InputError(
            f"keep and without both name taxels {rows_text(both)}, expected each in one"
        )
    return kept, out


def taxel_rows(name: str, rows: Iterable[int], taxels: int) -> NDArray[np.int64]:
    """Rows in ascending order, each once; InputError where there is no such taxel."""
    found = np.array(sorted(set(rows)), np.int64)
    if len(found) and not (found[0] >= 0 and found[-1] < taxels):
        wrong = found[(found < 0) | (found >= taxels)]
        raise InputError(
            f"{name} names taxels {rows_text(wrong)}, expected rows of the patch, 0 to {taxels - 1}"
        )
    return found


def find_faults(
    counts: Floats,
    patch: Patch | None = None,
    convention: Convention | None = None,
    *,
    calibration: Calibration | None = None,
    keep: Iterable[int] = (),
    without: Iterable[int] = (),
) -> Faults:
    """Judge each taxel over a recording.

    Parameters
    ----------
    counts : (T, L) array, counts
        NaN where a taxel did not answer.
    patch : Patch, optional
        Of the taxels: noise is then judged where no neighbour is touched, and taxels by the touches
        that their neighbours feel, boards as a whole.
    convention : Convention, optional
        Knows clamps, rest and the direction of a touch; without it no taxel is found saturated by
        itself.
    calibration : Calibration, optional
        Its noise is what a taxel should have; without it, the median taxel's.
    keep, without : iterable of int
        Rows of taxels to use, or not, whatever is found: see `Faults.chosen`.

    Raises
    ------
    InputError
        If there is no number, or the width is not that of the patch or the calibration.
    """
    counts = recorded(counts)
    taxels = counts.shape[1]
    if patch is not None:
        check_type("patch", patch, Patch, "such as layouts.hexagon72()")
    if patch is not None and len(patch) != taxels:
        raise InputError(
            f"counts has {taxels} columns, expected {len(patch)} as patch {patch.name!r} has: pick "
            "the taxels of the port with files.recordings.readings_for"
        )
    if calibration is not None and len(calibration) != taxels:
        raise InputError(
            f"counts has {taxels} columns, expected {len(calibration)} as the calibration of "
            f"{calibration.patch_name!r} has: pick the taxels of the port with "
            "files.recordings.readings_for"
        )
    seen = Evidence(counts, patch, convention)
    record = _Record(taxels)
    answers = _judged(seen, calibration, record)
    clamped = np.zeros(counts.shape, bool) if convention is None else convention.saturated(counts)
    sentences = _sentences(record, counts, clamped, seen.decided)
    verdict, since = record.verdict, record.since
    found = Faults(
        verdict, record.probability, tuple(record.evidence), since, seen.decided, sentences,
        seen.varies, answers,
    )  # fmt: skip
    return found.chosen(keep, without)


class _Record:
    """Verdicts as they are found; the later of two stands, if it is not only for free taxels."""

    def __init__(self, taxels: int) -> None:
        self.verdict = np.zeros(taxels, np.int8)
        self.probability = np.zeros(taxels)
        self.evidence = [""] * taxels
        self.since = np.full(taxels, -1, np.int64)

    def put(self, found: Iterable[TaxelFault], free: bool = False) -> None:
        """Take in what is certain enough."""
        for each in found:
            if each.probability < CERTAIN:
                continue
            rows = each.taxels[self.verdict[each.taxels] == Verdict.OK] if free else each.taxels
            self.verdict[rows] = each.kind
            self.probability[rows] = each.probability
            self.since[rows] = each.since
            for taxel in rows:
                self.evidence[taxel] = each.evidence


def _judged(seen: Evidence, calibration: Calibration | None, record: _Record) -> Bools:
    """Put all verdicts into a record; taxels (L,) that feel a touch."""
    counts, taxels = seen.counts, seen.counts.shape[1]
    record.put(evidence.too_noisy(seen, calibration))
    stopped = evidence.stopped_taxels(seen)
    record.put(stopped)
    constant = evidence.constant_taxels(seen)
    record.put(constant)
    answers = np.zeros(taxels, np.bool_)
    if seen.patch is not None:
        answers = seen.touches.answers
        record.put(swapped_taxels(seen), free=True)
        record.put(evidence.unresponsive_taxels(seen), free=True)
    still = ~seen.varies
    still[[int(taxel) for each in stopped for taxel in each.taxels]] = True
    broken = np.isin(record.verdict, (Verdict.DEAD, Verdict.STUCK)) & still
    record.put(evidence.frozen_boards(seen, broken, np.maximum(record.since, 0)))
    record.put(each for each in constant if each.kind == Verdict.SATURATED)
    if seen.convention is not None:
        often = seen.convention.saturated(counts).mean(axis=0)
        for taxel in np.flatnonzero((often > SATURATED_SHARE) & seen.varies):
            why = f"at a clamp in {often[taxel]:.0%} of {len(counts)} readings"
            record.put([TaxelFault(Verdict.SATURATED, np.array([taxel]), 1.0, why)])
    none = np.flatnonzero(seen.absent)
    why = f"no answer in {len(counts)} readings: not connected, or of another port"
    record.put([TaxelFault(Verdict.ABSENT, none, 1.0, why)])
    return answers


def _sentences(record: _Record, counts: Floats, clamped: Bools, decided: bool) -> tuple[str, ...]:
    found = _kinds(record.verdict, record.since, record.evidence)
    touched = np.flatnonzero(clamped.any(axis=0) & (record.verdict != Verdict.SATURATED))
    touched = touched[~clamped[:, touched].all(axis=0)]
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


def _kinds(verdict: NDArray[np.int8], since: NDArray[np.int64], words: Sequence[str]) -> list[str]:
    """A sentence on the taxels of each kind of fault, with what shows the first."""
    found = []
    for kind, meaning in _MEANING.items():
        rows = np.flatnonzero(verdict == kind)
        if not len(rows):
            continue
        first = since[rows].min()
        start = f", the first from reading {first}" if first > 0 else ""
        text = f"{len(rows)} of {len(verdict)} taxels {meaning}{start}: {rows_text(rows)}"
        if kind not in (Verdict.ABSENT, Verdict.SATURATED):
            text += f" ({rows[0]}: {words[rows[0]]})"
        found.append(text)
    return found


def rows_text(rows: NDArray[np.int64]) -> str:
    """Rows in ascending order as text with ranges: 0, 4-7, 9."""
    pieces = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
    return ", ".join(f"{p[0]}-{p[-1]}" if len(p) > 1 else f"{p[0]}" for p in pieces)


SILENT = 2  # stretches at the end without any change, after which a taxel is taken as stuck


def merged_faults(found: Sequence[Faults], lengths: Sequence[int]) -> Faults:
    """Verdict over consecutive stretches of one recording.

    A taxel is absent, frozen or dead if it is so in all of them; noisy or saturated if so in more
    than half, swapped if so in more than half of those in which it feels a touch; stuck if it stops
    changing in one and never changes again, or does not change in the last two; and what touches
    tell of one else holds unless it feels a touch in another. One stretch is returned as it is.

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
    varies = np.array([each.varies for each in found])
    decided = np.array([each.decided for each in found])
    told = np.array([each.answers for each in found])
    answers = np.asarray(told.any(axis=0))
    verdict = np.zeros(verdicts.shape[1], np.int8)
    for kind in (Verdict.NOISY, Verdict.SATURATED):
        verdict[(verdicts == kind).mean(axis=0) > 0.5] = kind
    for kind in _BY_TOUCH:
        verdict[((verdicts == kind) & varies).any(axis=0) & ~answers & (verdict == 0)] = kind
    crossed = (verdicts == Verdict.SWAPPED).sum(axis=0)
    verdict[(crossed > 0.5 * told.sum(axis=0)) & (crossed > 0) & (verdict == 0)] = Verdict.SWAPPED
    stuck, since = _stuck_for_good(verdicts, varies, decided)
    verdict[stuck] = Verdict.STUCK
    still = np.isin(verdicts, _HELD) & ~varies
    if decided.any():
        whole = still[decided].all(axis=0)
        for kind in _HELD[:3]:  # the one that was found most often
            often = (verdicts[decided] == kind).mean(axis=0) > 0.5
            verdict[whole & often] = kind
    verdict[(verdicts == Verdict.ABSENT).all(axis=0)] = Verdict.ABSENT
    begin = np.concatenate([[0], np.cumsum(lengths)])
    at = begin[since] + np.array(
        [max(int(found[b].since[taxel]), 0) for taxel, b in enumerate(since)], np.int64
    )
    first = np.where(verdict == Verdict.OK, -1, np.where(stuck & (verdict == Verdict.STUCK), at, 0))
    words, sure = _evidence_of(found, verdict)
    sentences = _kinds(verdict, first, words)
    if not decided.any():
        sentences.append("the taxels change too rarely to tell a dead one from a quiet one")
    return Faults(
        verdict, sure, tuple(words), first, bool(decided.any()), tuple(sentences),
        np.asarray(varies.any(axis=0)), answers,
    )  # fmt: skip


def _evidence_of(found: Sequence[Faults], verdict: NDArray[np.int8]) -> tuple[list[str], Floats]:
    """Words and probability (L,) of verdicts, from the last stretch that says the same, or any."""
    words, sure = [""] * len(verdict), np.zeros(len(verdict))
    for each in found:
        for taxel in np.flatnonzero((verdict != Verdict.OK) & (each.verdict != Verdict.OK)):
            if each.verdict[taxel] == verdict[taxel] or not words[taxel]:
                words[taxel], sure[taxel] = each.evidence[taxel], each.probability[taxel]
    return words, sure


def _stuck_for_good(
    verdicts: NDArray[np.int8], varies: Bools, decided: Bools
) -> tuple[Bools, NDArray[np.int64]]:
    """Taxels that never change again, and the stretch in which that begins."""
    count = len(verdicts)
    kinds = (Verdict.DEAD, Verdict.STUCK, Verdict.FROZEN)
    dead = np.isin(verdicts, kinds) & ~varies & decided[:, None]
    silent = np.argmin(np.vstack([dead[::-1], np.zeros((1, dead.shape[1]), bool)]), axis=0)
    before = np.maximum(count - 1 - silent, 0)  # the last stretch with a change
    taxels = np.arange(verdicts.shape[1])
    stops = np.isin(verdicts[before, taxels], kinds) & varies[before, taxels]
    stuck = (silent < count) & (stops | (silent >= SILENT))
    return stuck, np.where(stops, before, np.minimum(before + 1, count - 1))
