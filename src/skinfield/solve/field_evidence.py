"""Evidence of a pressure field of unknown form, and of nothing but noise, in what taxels read.

That of a field is the mean over Gaussian priors of several length scales and amplitudes, in closed
form, each with the readings off by so many times their noise. What some of the taxels read has the
same priors: those of all taxels, less the rows and columns of the others.
"""

from dataclasses import dataclass
from functools import cached_property
from math import exp, log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, Ints
from skinfield.solve.idle_kernel import WideLoads
from skinfield.solve.linear import smoothed, taxel_distance

LENGTHS = (0.7, 2.0, 6.0)  # of a field's correlation, in distances of taxels
AMPLITUDES = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)  # root mean square of its readings, over noise
MISFITS = (1.0, 1.6, 2.5, 4.0, 9.0, 27.0)  # times the noise that readings may be off
SQUARES = np.repeat(np.square(AMPLITUDES), len(MISFITS))  # (C,), of each amplitude and misfit
NOISES = np.tile(np.square(MISFITS), len(AMPLITUDES))  # (C,)
FEW, MANY = 3, 20  # taxels left out of all, and one in so many: beyond, the rest is split anew
FAST = {"reassoc", "contract", "nsz"}  # sums in any order; infinities stay what they are


class FieldPriors(NamedTuple):
    """Gaussian priors of a field as N of L taxels read it: H lengths, C amplitudes and misfits.

    Of each length the covariance G of the whitened readings is Q T Q', with T tridiagonal and Q a
    product of reflections 1 - scale v v' (Golub and Van Loan, Matrix Computations, section 8.3.1).
    So all amplitudes a and misfits m share Q, and a² T + m² = M D M' is split in N steps each.

    An offset that taxels share adds o o' to the covariance. A taxel that is left out of those has
    an infinite noise, along the unit vector e. With U = [e ... o] of R columns, S = M^-1 Q' U,
    and J of zeros but for 1 where o is, the inverse of the covariance loses W W', where
    W = Q M'^-1 D^-1 S C'^-1 and C C' = S' D^-1 S + J (Woodbury's identity).

    Attributes
    ----------
    heard : (N,) int array
        Which of the L; with those that are left out by an infinite noise.
    white : (N,) array
        One over their noise; 0 of those that are left out.
    reflections : (H, N, N) array
        Row i holds v of the i-th reflection from column i + 1 on.
    scales : (H, N) array
    off_diagonal : (H, N) array
        Of T, beside its diagonal.
    precision : (H, N, C) array
        One over D.
    shared : (H, R, N, C) array
        D^-1 S C'^-1: the product with M^-1 Q' y is that of W with y.
    constant : (H, C) array
        Logarithm of the density at no readings.
    """

    heard: Ints
    white: Floats
    reflections: Floats
    scales: Floats
    off_diagonal: Floats
    precision: Floats
    shared: Floats
    constant: Floats


@dataclass(frozen=True, eq=False)
class FieldCovariance:
    """Covariance of a field as L taxels read it, by which any of them have their priors.

    Attributes
    ----------
    grams : (H, L, L) array
        Of the whitened readings, by length; their diagonals have the mean 1.
    white : (L,) array
        One over the noise.
    offset : (L,) array
        Deviation of an offset that all taxels share, in the noise of each.
    """

    grams: Floats
    white: Floats
    offset: Floats

    @cached_property
    def whole(self) -> FieldPriors:
        """Priors of what all taxels read."""
        return self._split(np.arange(len(self.white)))

    @classmethod
    def of(cls, model: ObservationModel, common: float) -> "FieldCovariance":
        """Of a model, with the standard deviation `common` of an offset, in that of the noise."""
        distance = taxel_distance(model.taxels, model.grid.pitch)
        white, grams = 1.0 / model.noise_std, []
        for length in LENGTHS:
            gram = smoothed(model.grid, model.matrix, length * distance) @ model.matrix.T
            gram *= np.outer(white, white)
            grams.append(gram * (len(white) / np.trace(gram)))
        return cls(np.array(grams), white, common * float(model.noise_std.mean()) * white)

    def priors(self, valid: NDArray[np.bool_]) -> FieldPriors:
        """Priors of what the `valid` taxels (L,) read: from those of all where few are not."""
        missing = np.flatnonzero(~valid)
        if not 0 < len(missing) <= FEW + len(valid) // MANY:
            return self.whole if valid.all() else self._split(np.flatnonzero(valid))
        columns = np.zeros((len(missing) + 1, len(valid)))
        columns[np.arange(len(missing)), missing] = 1.0
        columns[-1] = self.offset
        return corrected(self.whole._replace(white=self.white * valid), columns)

    def wide(self, most: float) -> WideLoads:
        """Smooth ways to be read, by which it may be `most` times, in logarithms, as probable."""
        return WideLoads.of(self.grams[1:], self.offset, np.array(AMPLITUDES), most)

    @property
    def room(self) -> tuple[Floats, Floats]:
        """For `field_evidence`."""
        taxels = len(self.white)
        return np.zeros(taxels), np.zeros((4 + FEW + taxels // MANY, len(SQUARES)))

    def _split(self, heard: Ints) -> FieldPriors:
        """Priors of what some taxels (N,) read, from their rows and columns."""
        from scipy.linalg import lapack

        count, lengths, each = len(heard), len(self.grams), len(SQUARES)
        made = FieldPriors(
            heard=heard,
            white=self.white[heard],
            reflections=np.empty((lengths, count, count)),
            scales=np.zeros((lengths, count)),
            off_diagonal=np.zeros((lengths, count)),
            precision=np.empty((lengths, count, each)),
            shared=np.empty((0, 0, 0, 0)),
            constant=np.empty((0, 0)),
        )
        diagonal = np.zeros((lengths, count))
        take_heard(self.grams, heard, made.reflections)
        size = max(int(lapack.dsytrd_lwork(count, lower=1)[0]), 1) if count else 1
        for h in range(lengths if count else 0):
            matrix = made.reflections[h].T  # in LAPACK's order; overwritten
            _, diagonal[h], beside, scales, _ = lapack.dsytrd(
                matrix, lower=1, lwork=size, overwrite_a=1
            )
            made.off_diagonal[h, : count - 1], made.scales[h, : count - 1] = beside, scales
        split(diagonal, made.off_diagonal, SQUARES, NOISES, made.precision)
        return corrected(made, self.offset[None, heard])


def corrected(priors: FieldPriors, columns: Floats) -> FieldPriors:
    """Priors with what columns U' (R, N) change, the last of them the offset."""
    lengths, count, each = priors.precision.shape
    shared = np.empty((lengths, len(columns), count, each))
    made = priors._replace(shared=shared, constant=np.empty((lengths, each)))
    correct(made, columns.copy(), SQUARES)
    return made


@njit
def take_heard(grams: Floats, heard: Ints, out: Floats) -> None:
    """Write into `out` (H, N, N) rows and columns of the heard taxels of `grams` (H, L, L)."""
    for h in range(len(grams)):
        for i in range(len(heard)):
            row = grams[h, heard[i]]
            for j in range(len(heard)):
                out[h, i, j] = row[heard[j]]


@inner(fastmath=FAST)
def reflect(vectors: Floats, scales: Floats, values: Floats) -> None:
    """Turn values (N,) by reflections: v of the i-th stands in row i from column i + 1 on."""
    for i in range(len(values) - 1):
        vector, rest, total = vectors[i, i + 2 :], values[i + 2 :], values[i + 1]
        for j in range(len(rest)):
            total += vector[j] * rest[j]
        total *= scales[i]
        values[i + 1] -= total
        for j in range(len(rest)):
            rest[j] -= total * vector[j]


FACTORS = 16  # whose product is in range: each is from 1 to 1e5 times the number of taxels


@njit(fastmath=FAST)
def split(
    diagonal: Floats, beside: Floats, squares: Floats, noises: Floats, precision: Floats
) -> None:
    """Write into `precision` (H, N, C) 1 / D of a² T + m²; see `FieldPriors`."""
    for h in range(len(diagonal)):
        for i in range(diagonal.shape[1]):
            out, middle, before = precision[h, i], diagonal[h, i], precision[h, max(i - 1, 0)]
            for c in range(len(squares)):
                out[c] = squares[c] * middle + noises[c]
            aside = beside[h, i - 1] if i else 0.0
            for c in range(len(squares) if i else 0):
                step = squares[c] * aside
                out[c] -= step * step * before[c]
            for c in range(len(squares)):
                out[c] = 1.0 / out[c]


@inner(fastmath=FAST)
def add_product(one: Floats, other: Floats, weight: Floats, out: Floats) -> None:
    """Add to `out` (C,) the product of three."""
    for c in range(len(out)):
        out[c] += one[c] * other[c] * weight[c]


@inner(fastmath=FAST)
def take_product(one: Floats, other: Floats, out: Floats) -> None:
    """Take from `out` (C,) the product of two."""
    for c in range(len(out)):
        out[c] -= one[c] * other[c]


@inner(fastmath=FAST)
def substitute(
    value: float, aside: float, squares: Floats, before: Floats, last: Floats, out: Floats
) -> None:
    """Write into `out` (C,) the next number of M^-1 Q' u, `last` the one before."""
    for c in range(len(out)):
        out[c] = value - squares[c] * aside * before[c] * last[c]


@njit(fastmath=FAST)
def correct(priors: FieldPriors, columns: Floats, squares: Floats) -> None:
    """Write `shared` and `constant` of priors for columns U' (R, N), which are overwritten."""
    lengths, count, each = priors.precision.shape
    rank, plain = len(columns), columns.copy()
    core, known, product = np.empty((rank, rank, each)), 0.0, np.empty(each)
    for white in priors.white:
        known += np.log(white) - 0.5 * np.log(2.0 * np.pi) if white > 0.0 else 0.0
    for h in range(lengths):
        shared, precision, constant = priors.shared[h], priors.precision[h], priors.constant[h]
        for r in range(rank):
            for i in range(count):
                columns[r, i] = plain[r, i]
            reflect(priors.reflections[h], priors.scales[h], columns[r])
            for t in range(r + 1):
                core[r, t] = 1.0 if r == t == rank - 1 else 0.0
        for c in range(each):
            constant[c], product[c] = known, 1.0
        for i in range(count):
            aside = priors.off_diagonal[h, i - 1] if i else 0.0
            for c in range(each):
                product[c] *= precision[i, c]
            if i % FACTORS == FACTORS - 1 or i == count - 1:
                for c in range(each):
                    constant[c] += 0.5 * np.log(product[c])
                    product[c] = 1.0
            for r in range(rank):
                last = shared[r, max(i - 1, 0)] if i else product
                substitute(
                    columns[r, i], aside, squares, precision[max(i - 1, 0)], last, shared[r, i]
                )
                for t in range(r + 1):
                    add_product(shared[r, i], shared[t, i], precision[i], core[r, t])
        for r in range(rank):
            for t in range(r + 1):
                for m in range(t):
                    take_product(core[r, m], core[t, m], core[r, t])
                for c in range(each):
                    core[r, t, c] = (
                        np.sqrt(core[r, t, c]) if r == t else core[r, t, c] / core[t, t, c]
                    )
            for c in range(each):
                constant[c] -= np.log(core[r, r, c])
        for r in range(rank):
            for i in range(count):
                row = shared[r, i]
                for c in range(each):
                    row[c] *= precision[i, c]
                for t in range(r):
                    take_product(core[r, t], shared[t, i], row)
                for c in range(each):
                    row[c] /= core[r, r, c]


@njit(fastmath=FAST)
def field_evidence(
    priors: FieldPriors, squares: Floats, readings: Floats, along: Floats, sums: Floats
) -> float:
    """Logarithm of the density of readings (L,) of a field: mean over the priors.

    `squares` are `SQUARES`; `along` (N or more) and `sums` (4 + R or more, C) are room. Taxels that
    are left out read 0.
    """
    count, each, total, highest = len(priors.heard), len(squares), 0.0, -1e308
    turned, solved, last, left = along[:count], sums[0], sums[1], sums[2]
    rank = priors.shared.shape[1]
    for h in range(len(priors.constant)):
        for i in range(count):
            turned[i] = readings[priors.heard[i]] * priors.white[i]
        reflect(priors.reflections[h], priors.scales[h], turned)
        for c in range(each):
            left[c], last[c] = 0.0, 0.0
        for r in range(rank):
            for c in range(each):
                sums[3 + r, c] = 0.0
        for i in range(count):
            aside, precision = priors.off_diagonal[h, i - 1] if i else 0.0, priors.precision[h, i]
            before = priors.precision[h, max(i - 1, 0)]
            substitute(turned[i], aside, squares, before, last, solved)
            add_product(solved, solved, precision, left)
            for r in range(rank):
                take_product(solved, priors.shared[h, r, i], sums[3 + r])
            solved, last = last, solved
        for r in range(rank):
            take_product(sums[3 + r], sums[3 + r], left)
        for c in range(each):
            density = priors.constant[h, c] - 0.5 * left[c]
            if density > highest:
                total = total * np.exp(highest - density) + 1.0
                highest = density
            else:
                total += np.exp(density - highest)
    return float(highest + np.log(total / (len(priors.constant) * each)))


def noise_density(white: Floats, shared: float, common: float) -> float:
    """Logarithm of the density at 0 of noise and an offset that all taxels share.

    Parameters
    ----------
    white : (L,) array
        One over the deviations; 0 of taxels that are not heard.
    shared, common : float
        Variance of the offset after readings, and its standard deviation before.
    """
    heard = white[white > 0.0]
    known = np.log(heard).sum() - 0.5 * len(heard) * np.log(2 * np.pi)
    return float(known + (0.5 * np.log(shared) - np.log(common) if shared > 0.0 else 0.0))


def misfit_gain(squares: float, freedom: int) -> float:
    """What a mean over the misfits adds to the logarithm of a density without any.

    Parameters
    ----------
    squares : float
        Of what is left over, over the noise.
    freedom : int
        Taxels less the numbers that were fitted to them.
    """
    gains = [0.5 * squares * (1.0 - m**-2.0) - max(freedom, 1) * log(m) for m in MISFITS]
    highest = max(gains)
    return float(highest + log(sum(exp(gain - highest) for gain in gains) / len(gains)))
