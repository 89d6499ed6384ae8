"""Idle test of a patch, compiled: whether anything stands out of the noise of what it reads.

A contact stands out of the templates of single contacts; a load as wide as a palm of the smoothest
ways in which a field is read; anything else of the sum of squares. What passes all three is a
reading of noise and of an offset that all taxels share: no contact is sought in it, and no field.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats
from skinfield.solve.atoms.dictionary import find_starts
from skinfield.solve.atoms.fit_kernel import LATE, NOW, SCORED
from skinfield.solve.atoms.reading_memory import (
    EXPLAINED,
    HALFWAY,
    OFFSET,
    OPEN_HALFWAY,
    RESTING,
    SCALE,
    STAGE,
    Fit,
    unpack_fit,
)
from skinfield.solve.packed import PackedType, unpacking

SHARE = 0.9  # of what a contact must bring: so much the best template does, where there is one
LEAST = 0.5  # variance of a way in which a field is read, over that of the mean taxel


class WideLoads(NamedTuple):
    r"""Smooth ways in which taxels read a field, for H lengths of its correlation.

    In units of the noise, readings of a field of the amplitude a have the covariance a² G + 1.
    With z the parts of the readings along the eigenvectors of G, of eigenvalue g, its evidence
    over that of noise is :math:`\sum_r z_r^2 a^2 g_r / (a^2 g_r + 1) / 2 - \ln(a^2 g_r + 1) / 2`.

    Attributes
    ----------
    modes : (R, L) float32 array
        Eigenvectors, length after length.
    firsts : (H + 1,) int array
        First mode of each length.
    gains : (R, A) array
        What weighs the squares, for each amplitude.
    costs : (H, A) array
    most : float
        Evidence of a field beyond which it may be one.
    """

    modes: NDArray[np.float32]
    firsts: NDArray[np.int64]
    gains: Floats
    costs: Floats
    most: float

    @classmethod
    def of(cls, grams: Floats, offset: Floats, amplitudes: Floats, most: float) -> "WideLoads":
        """Those of covariances `grams` (H, L, L), beside an `offset` (L,) that all taxels share.

        What that explains, no field need explain.
        """
        own = np.eye(len(offset)) - np.outer(offset, offset) / (1.0 + offset @ offset)
        modes, gains, costs, squares = [], [], [], np.square(amplitudes)
        for gram in grams:
            variances, vectors = np.linalg.eigh(own @ gram @ own)
            kept = variances > LEAST
            share = variances[kept, None] * squares
            modes.append(vectors.T[kept])
            gains.append(0.5 * share / (1.0 + share))
            costs.append(0.5 * np.log1p(share).sum(axis=0))
        firsts = np.cumsum([0, *(len(each) for each in modes)])
        joined = np.ascontiguousarray(np.concatenate(modes), dtype=np.float32)
        return cls(joined, firsts, np.concatenate(gains), np.array(costs), float(most))


NONE = np.zeros((1, 1))
WIDE = PackedType(WideLoads(NONE.astype(np.float32), np.zeros(1, np.int64), NONE, NONE, 0.0))
unpack_wide = unpacking(WIDE)


@inner(fastmath={"reassoc", "contract", "nsz"}, _nrt=False)
def may_be_wide(wide: WideLoads, left: NDArray[np.float32], sums: Floats) -> bool:
    """Whether a field may explain whitened readings (L,) better than noise; `sums` (A,) is room."""
    for length in range(len(wide.costs)):
        costs = wide.costs[length]
        for a in range(len(costs)):
            sums[a] = -costs[a]
        for r in range(wide.firsts[length], wide.firsts[length + 1]):
            mode, gains, part = wide.modes[r], wide.gains[r], np.float32(0.0)
            for taxel in range(len(left)):
                part += mode[taxel] * left[taxel]
            square = float(part) * float(part)
            for a in range(len(costs)):
                sums[a] += gains[a] * square
        for a in range(len(costs)):
            if not sums[a] <= wide.most:
                return True
    return False


@inner(_nrt=False)
def rests(
    fit: Fit, wide: WideLoads, readings: Floats, deviation: Floats, valid: NDArray[np.bool_]
) -> bool:
    """Whether readings (L,) of some deviation (L,) are idle; the fit then has no contact.

    Of those that are `valid` (L,). What else it knows of the skin, it goes on to know.
    """
    own, memory, scored = fit.own, fit.memory, fit.memory.taxels[SCORED]
    weights, total, squares, noise, heard = 0.0, 0.0, 0.0, 0.0, 0
    for taxel in range(len(readings)):
        scored[taxel] = 0.0
        if valid[taxel]:
            white = 1.0 / deviation[taxel]
            scored[taxel] = readings[taxel] * white
            weights += white * white
            total += scored[taxel] * white
            squares += scored[taxel] * scored[taxel]
            noise += deviation[taxel]
            heard += 1
    common = (fit.rules.common_mode * noise / max(heard, 1)) ** 2
    offset = common / (1.0 + common * weights) * total
    squares -= offset * total
    if not squares <= fit.near.limits[heard]:
        return False
    for taxel in range(len(readings)):
        if valid[taxel]:
            scored[taxel] -= offset / deviation[taxel]
    least = np.sqrt(2.0 * SHARE * fit.rules.threshold)
    if find_starts(fit.bank, fit.search.starts, scored, 1, least):
        return False
    if may_be_wide(wide, fit.search.starts.single[0], memory.steps[0]):
        return False
    memory.counts[NOW] = fit.drawing.drawn[0] = memory.marks[LATE] = 0
    for taxel in range(len(readings)):
        memory.predicted[NOW, taxel] = 0.0
    own.marks[STAGE], own.marks[HALFWAY], own.marks[OPEN_HALFWAY] = RESTING, 0, 0
    own.marks[EXPLAINED], own.numbers[SCALE], own.numbers[OFFSET] = 1, 1.0, offset
    fit.search.known[0] = -0.5 * squares
    return True


@njit
def reading_rests(
    fit_address: int, wide_address: int, readings: Floats, valid: NDArray[np.bool_]
) -> bool:
    """See `rests`; of a `Fit` and a `WideLoads`, packed."""
    fit, wide = unpack_fit(fit_address), unpack_wide(wide_address)
    return bool(rests(fit, wide, readings, fit.own.noise, valid))
