"""Faults over a recording that is too long to be looked at in one piece."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from skinfield.conditioning.convention import Bools
from skinfield.conditioning.faults import _MEANING, Faults, Verdict, rows_text

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
    stuck, since = _stuck(verdicts, decided)
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
    return Faults(verdict, first, bool(decided.any()), _sentences(verdict, decided))


def _stuck(verdicts: NDArray[np.int8], decided: Bools) -> tuple[Bools, NDArray[np.int64]]:
    """Taxels that never change again, and the stretch in which that begins."""
    count = len(verdicts)
    dead = (verdicts == Verdict.DEAD) & decided[:, None]
    silent = np.argmin(np.vstack([dead[::-1], np.zeros((1, dead.shape[1]), bool)]), axis=0)
    before = np.maximum(count - 1 - silent, 0)  # the last stretch with a change
    stops = verdicts[before, np.arange(verdicts.shape[1])] == Verdict.STUCK
    stuck = (silent < count) & (stops | (silent >= SILENT))
    return stuck, np.where(stops, before, np.minimum(before + 1, count - 1))


def _sentences(verdict: NDArray[np.int8], decided: Bools) -> tuple[str, ...]:
    said = []
    for kind, meaning in _MEANING.items():
        rows = np.flatnonzero(verdict == kind)
        if len(rows):
            said.append(f"{len(rows)} of {len(verdict)} taxels {meaning}: {rows_text(rows)}")
    if not decided.any():
        said.append("the taxels change too rarely to tell a dead one from a quiet one")
    return tuple(said)
