"""Evidence of a pressure field of unknown form, and of nothing but noise, in what taxels read.

That of a field is the mean over Gaussian priors of several length scales and amplitudes, in closed
form, each with the readings off by so many times their noise. What some of the taxels read has the
same priors: those of all taxels, less the rows and columns of the others.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, Ints
from skinfield.solve.linear import smoothed, taxel_distance

LENGTHS = (0.7, 2.0, 6.0)  # of a field's correlation, in distances of taxels
AMPLITUDES = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)  # root mean square of its readings, over noise
MISFITS = (1.0, 1.6, 2.5, 4.0, 9.0, 27.0)  # times the noise that readings may be off
SQUARES = np.repeat(np.square(AMPLITUDES), len(MISFITS))  # (C,), of each amplitude and misfit
NOISES = np.tile(np.square(MISFITS), len(AMPLITUDES))  # (C,)
FAST = {"reassoc", "contract", "nsz"}  # sums in any order; infinities stay what they are


class FieldPriors(NamedTuple):
    """Gaussian priors of a field as N of L taxels read it: H lengths, C amplitudes and misfits.

    Of each length the covariance G of the whitened readings is Q T Q', with T tridiagonal and Q a
    product of reflections 1 - scale v v' (Golub and Van Loan, Matrix Computations, section 8.3.1).
    So all amplitudes a and misfits m share Q, and a² T + m² = M D M' is split in N steps each.

    Attributes
    ----------
    heard : (N,) int array
        Which of the L.
    white : (N,) array
        One over their noise.
    reflections : (H, N, N) array
        Row i holds v of the i-th reflection from column i + 1 on.
    scales : (H, N) array
    off_diagonal : (H, N) array
        T beside its diagonal.
    precision : (H, N, C) array
        One over D.
    shared : (H, N, C) array
        That times the solution of M z = Q' o, with o an offset of one standard deviation that all
        taxels share, whitened.
    gain : (H, C) array
        Share of the squared product with `shared` that the offset takes.
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
    gain: Floats
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
        return self.priors(np.ones(len(self.white), np.bool_))

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
        """Priors of what the `valid` taxels (L,) read."""
        from scipy.linalg import lapack

        heard = np.flatnonzero(valid)
        count, lengths, each = len(heard), len(self.grams), len(SQUARES)
        made = FieldPriors(
            heard=heard,
            white=self.white[heard],
            reflections=np.empty((lengths, count, count)),
            scales=np.zeros((lengths, count)),
            off_diagonal=np.zeros((lengths, count)),
            precision=np.empty((lengths, count, each)),
            shared=np.empty((lengths, count, each)),
            gain=np.empty((lengths, each)),
            constant=np.empty((lengths, each)),
        )
        diagonal = np.zeros((lengths, count))
        take_heard(self.grams, heard, made.reflections)
        size = max(int(lapack.dsytrd_lwork(count, lower=1)[0]), 1) if count else 1
        for h in range(lengths if count else 0):
            matrix = made.reflections[h].T  # in LAPACK's order; overwritten
            _, diagonal[h], off_diagonal, scales, _ = lapack.dsytrd(
                matrix, lower=1, lwork=size, overwrite_a=1
            )
            made.off_diagonal[h, : count - 1], made.scales[h, : count - 1] = off_diagonal, scales
        split(made, diagonal, self.offset[heard], SQUARES, NOISES)
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
    priors: FieldPriors, diagonal: Floats, offset: Floats, squares: Floats, noises: Floats
) -> None:
    """Split a² T + m² for all priors, T with the diagonals (H, N); see `FieldPriors`."""
    taxels, each = len(offset), len(squares)
    known = -0.5 * taxels * np.log(2.0 * np.pi)
    for i in range(taxels):
        known += np.log(priors.white[i])
    turned, pivots = np.empty(taxels), np.empty(each)
    solved, product = np.empty(each), np.empty(each)
    for h in range(len(priors.gain)):
        gain, constant = priors.gain[h], priors.constant[h]
        for i in range(taxels):
            turned[i] = offset[i]
        reflect(priors.reflections[h], priors.scales[h], turned)
        for c in range(each):
            solved[c], product[c], gain[c], constant[c] = 0.0, 1.0, 1.0, known
        for i in range(taxels):
            middle, value = diagonal[h, i], turned[i]
            off_diagonal = priors.off_diagonal[h, i - 1] if i else 0.0
            precision, shared = priors.precision[h, i], priors.shared[h, i]
            before = priors.precision[h, i - 1 if i else 0]
            for c in range(each):
                step = squares[c] * off_diagonal * before[c] if i else 0.0
                pivots[c] = squares[c] * middle + noises[c] - step * squares[c] * off_diagonal
                solved[c] = value - step * solved[c]
                precision[c] = 1.0 / pivots[c]
                shared[c] = solved[c] * precision[c]
                gain[c] += solved[c] * shared[c]
                product[c] *= pivots[c]
            if i % FACTORS == FACTORS - 1 or i == taxels - 1:
                for c in range(each):
                    constant[c] -= 0.5 * np.log(product[c])
                    product[c] = 1.0
        for c in range(each):
            constant[c] -= 0.5 * np.log(gain[c])
            gain[c] = 1.0 / gain[c]


@njit(fastmath=FAST)
def field_evidence(
    priors: FieldPriors, squares: Floats, readings: Floats, along: Floats, sums: Floats
) -> float:
    """Logarithm of the density of readings (L,) of a field: mean over the priors.

    `squares` are `SQUARES`; `along` (N or more) and `sums` (3, C) are room.
    """
    taxels, each, total, highest = len(priors.heard), len(squares), 0.0, -1e308
    turned, solved, left, product = along[:taxels], sums[0], sums[1], sums[2]
    for h in range(len(priors.gain)):
        for i in range(taxels):
            turned[i] = readings[priors.heard[i]] * priors.white[i]
        reflect(priors.reflections[h], priors.scales[h], turned)
        for c in range(each):
            solved[c], left[c], product[c] = 0.0, 0.0, 0.0
        for i in range(taxels):
            value, off_diagonal = turned[i], priors.off_diagonal[h, i - 1] if i else 0.0
            precision, shared = priors.precision[h, i], priors.shared[h, i]
            before = priors.precision[h, i - 1 if i else 0]
            for c in range(each):
                solved[c] = value - squares[c] * off_diagonal * before[c] * solved[c]
                left[c] += solved[c] * solved[c] * precision[c]
                product[c] += solved[c] * shared[c]
        for c in range(each):
            taken = priors.gain[h, c] * product[c] * product[c]
            density = priors.constant[h, c] - 0.5 * (left[c] - taken)
            if density > highest:
                total = total * np.exp(highest - density) + 1.0
                highest = density
            else:
                total += np.exp(density - highest)
    return float(highest + np.log(total / (len(priors.gain) * each)))


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
    misfit = np.array(MISFITS)
    gains = 0.5 * squares * (1.0 - misfit**-2.0) - max(freedom, 1) * np.log(misfit)
    return float(np.logaddexp.reduce(gains) - np.log(len(misfit)))
