"""Linear solvers: inverse, pseudo-inverse, Tikhonov regularisation and Gaussian fields.

A contact is no Gaussian field, and between taxels a thin skin is nearly blind: there a field solver
finds a part of the force, at the nearest taxel. The numbers are such that, on the hexagon of 72
taxels with 2 mm of incompressible silicone (100 kPa), at the quantity's typical noise, 1.645
standard deviations each way hold nine of ten forces, and the 90 % ellipse as many places, of 600
simulated presses (balls, flats, a cone, a bar; 0.1 to 3 N), counted once and written down here.

At other noises one number cannot do: docs/explanation/uncertainty.md has what then holds. On other
layouts and layers nothing was measured.

They do not shrink with the size of a contact. For stress they might: of flat ends over 4 to 64
taxel cells of a 16 x 16 skin (4 mm apart) `GaussianField` finds 88 to 98 % of the force. For
capacitance they must not: 81 to 92 % over 4 cells, 61 to 68 % over 13, 46 to 50 % over 28, and 28 %
over 64, as an incompressible layer hardly gives below the middle of a wide contact.
"""

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import BaseStress, LatticeConvolution, ObservationModel
from skinfield.elastic.lattice import lattice, mirrored
from skinfield.elastic.resample import resampling_matrix
from skinfield.errors import Floats, InputError, check_positive, check_range
from skinfield.estimate import ModelError, PressurePosterior
from skinfield.settings import Range, Section
from skinfield.skin import Grid
from skinfield.skin.geometry import nearest_distance
from skinfield.solve.gaussian_model import GaussianModel
from skinfield.solve.operator import LinearOperator, propagated_std


def sees_sum(matrix: Floats) -> bool:
    """Whether rows (L, K) see a uniform pressure; where no volume gives it cancels in each."""
    return bool(np.abs(matrix.sum(axis=1)).sum() > 0.5 * np.abs(matrix).sum())


class Errors(NamedTuple):
    """One standard deviation by what taxels read; for the gap that of the capacitance.

    Of the force as a part of it, of the place in pitches: (force, place).
    """

    stress: tuple[float, float]
    capacitance: tuple[float, float]

    def of(self, model: ObservationModel) -> ModelError:
        """For a model; none is known of a matrix that was built by hand."""
        if model.physics is None:
            return ModelError()
        read = isinstance(model.physics.quantity, BaseStress)
        force, place = self.stress if read else self.capacitance
        return ModelError(force=force, place=place * model.grid.patch.pitch)


GAUSSIAN_FIELD = Errors((1.2, 0.20), (1.4, 0.22))
NON_NEGATIVE = Errors((1.4, 0.13), (0.54, 0.14))
TIKHONOV = Errors((1.9, 0.13), (1.8, 0.14))
PSEUDO_INVERSE = Errors((2.2, 0.29), (2.6, 0.29))
RESAMPLED_PSEUDO_INVERSE = Errors((0.92, 0.29), (0.60, 0.37))
INVERSE = Errors((0.82, 0.29), (0.60, 0.44))


def resampled(model: ObservationModel) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """N virtual taxels, one below each node that lies inside the hull of the taxels.

    Nodes outside have none, so nothing is made up.

    Returns
    -------
    weights : (N, L) array
        From the readings of the taxels to those of the virtual taxels.
    matrix : (N, K) array, unit of the reading per Pa
        What the virtual taxels read of the pressure.
    inside : (K,) bool array
        Where the virtual taxels are.
    """
    matrix, inside = resampling_matrix(model.taxels, model.grid.plane)
    if not inside.any():
        raise InputError(
            f"none of the {len(model.grid)} nodes lies inside the hull of the {len(model.taxels)} "
            "taxels, expected some: use a finer grid or one that covers the taxels"
        )
    return matrix[inside].toarray(), model.virtual_matrix(model.grid.plane[inside]), inside


SINGULAR = 1e9  # condition number beyond which rounding alone is seen in the answer


@dataclass(frozen=True, kw_only=True)
class Inverse:
    """Inverse of a square matrix, eq. (12): as many forces as readings.

    Parameters
    ----------
    resample : bool
        Invert on virtual taxels below the nodes that lie inside the taxels' hull, with a force at
        each of them and none elsewhere, as the paper does (section III-B); else on the taxels
        themselves, which needs as many nodes as taxels.
    """

    resample: bool = True

    def prepare(self, model: ObservationModel) -> LinearOperator:
        """Invert once."""
        if self.resample:
            weights, virtual, inside = resampled(model)
            matrix = np.zeros((len(model.grid), len(model.taxels)))
            matrix[inside] = _solve(virtual[:, inside], weights)
        else:
            taxels, nodes = model.matrix.shape
            if taxels != nodes:
                raise InputError(
                    f"the matrix is ({taxels}, {nodes}), expected as many nodes as taxels: use "
                    "Inverse(resample=True), or PseudoInverse() for any number"
                )
            matrix = _solve(model.matrix, np.eye(taxels))
        std = propagated_std(matrix, model.noise_std)
        return LinearOperator(self, model, matrix, std, model_error=INVERSE.of(model))


def _solve(square: Floats, right: Floats) -> Floats:
    from scipy.linalg import lapack

    factors, pivots, _ = lapack.dgetrf(square)
    reciprocal, _ = lapack.dgecon(factors, float(np.abs(square).sum(axis=0).max()))
    if not reciprocal > 1 / SINGULAR:
        condition = 1 / max(reciprocal, 1e-99)
        raise InputError(
            f"the {len(square)} x {len(square)} matrix has condition {condition:.1e}, expected "
            f"below {SINGULAR:.0e}: taxels so far below nodes so close cannot tell them apart; "
            "use a coarser grid, or Tikhonov()"
        )
    solution, _ = lapack.dgetrs(factors, pivots, right)
    return np.asarray(solution, dtype=np.float64)


@dataclass(frozen=True, kw_only=True)
class PseudoInverse(Section):
    """Moore-Penrose inverse, eq. (13): the smallest pressure that explains the readings.

    Parameters
    ----------
    rcond : float, dimensionless
        Singular values below `rcond` times the largest count as zero.
    resample : bool
        First interpolate the readings onto virtual taxels below the nodes, as the paper does
        (section III-B); else invert on the taxels themselves.
    """

    rcond: Annotated[float, Range(0.0, 1.0, "relative to the largest singular value")] = 1e-6
    resample: bool = False

    def prepare(self, model: ObservationModel) -> LinearOperator:
        """Invert once."""
        if self.resample:
            weights, virtual, _ = resampled(model)
            matrix, known = self._inverse(virtual) @ weights, RESAMPLED_PSEUDO_INVERSE
        else:
            matrix, known = self._inverse(model.matrix), PSEUDO_INVERSE
        std = propagated_std(matrix, model.noise_std)
        return LinearOperator(self, model, matrix, std, model_error=known.of(model))

    def _inverse(self, matrix: Floats) -> Floats:
        return np.asarray(np.linalg.pinv(matrix, rcond=self.rcond), dtype=np.float64)


@dataclass(frozen=True, kw_only=True)
class Tikhonov:
    r"""Least squares with a penalty on the squared pressure.

    Parameters
    ----------
    snr : float, dimensionless
        Amplitude of the expected readings over their noise; lower is smoother.
    common_mode : float, optional
        As that of `GaussianField`: Wᵀ W below becomes the inverse covariance of noise and offset.

    Notes
    -----
    .. math:: \min_p \|W (A p - y)\|^2 + \lambda^2 \|p\|^2, \quad
              \lambda^2 = \mathrm{tr}(W A A^T W) / (L\,\mathrm{snr}^2)

    with W = diag(1 / noise_std): the same snr suits every patch, grid and unit. The answer is the
    posterior mean of cells that are independent, each with the variance 1/lambda² (Bishop, Pattern
    Recognition and Machine Learning, section 3.3); `pressure_std` is that posterior's.
    """

    snr: float = 30.0
    common_mode: float | None = None

    def __post_init__(self) -> None:
        check_positive("snr", self.snr, "the penalty is proportional to 1 / snr**2")
        check_common(self.common_mode)

    def prepare(self, model: ObservationModel) -> LinearOperator:
        """Solve the (L, L) normal equations: small, as taxels are fewer than nodes."""
        white = np.zeros(model.grid.shape)
        white[0, 0] = 1.0
        return _conditioned(self, model, model.matrix, white, TIKHONOV)


COMMON = 5.0  # standard deviations of the noise


def check_common(common_mode: float | None) -> None:
    """Raise InputError for no deviation of an offset that taxels may share."""
    if common_mode is not None:
        check_range("common_mode", common_mode, 0.0, 1e3, "in standard deviations of the noise")


def shared_offset(common_mode: float | None, model: ObservationModel) -> Floats:
    """Deviation of the offset that all taxels share, in the noise of each, (L,)."""
    if common_mode is None:
        common_mode = 0.0 if sees_sum(model.matrix) else COMMON
    return np.asarray(common_mode * float(np.median(model.noise_std)) / model.noise_std)


def _conditioned(
    solver: Any, model: ObservationModel, cross: Floats, near: Floats, known: Errors
) -> LinearOperator:
    """Posterior of a Gaussian field given the taxels.

    `cross` (L, K) is A Q, `near` (rows, columns) Q by the offset of two nodes, both per variance.
    """
    from scipy.linalg import solve_triangular

    white, snr = 1.0 / model.noise_std, solver.snr
    cross = cross.T * white
    gram = (model.matrix @ cross) * white[:, None]
    variance = snr**2 * len(gram) / np.trace(gram)
    offset = shared_offset(solver.common_mode, model)
    noise = np.eye(len(gram)) + np.outer(offset, offset)
    lower = np.linalg.cholesky(gram * variance + noise)
    factor = solve_triangular(lower, variance * cross.T, lower=True)
    matrix = solve_triangular(lower, factor, lower=True, trans=1).T * white
    posterior = PressurePosterior.of_lattice(variance * near, np.ascontiguousarray(factor.T))
    gaussian = GaussianModel.of(cross, gram, near, model.noise_std, offset, snr)
    parts = matrix, posterior.std, posterior, known.of(model), gaussian
    return LinearOperator(solver, model, *parts)


PITCHES = 0.25  # of the taxels, per length scale: between presses on a taxel and beside


@dataclass(frozen=True, kw_only=True)
class GaussianField:
    r"""Posterior of a Gaussian random field given the readings.

    Parameters
    ----------
    snr : float, dimensionless
        Amplitude of the expected readings over their noise; lower is smoother.
    length_scale : float, m, optional
        Of the Matérn-3/2 covariance. Default a quarter of the distance of neighbouring taxels.
    common_mode : float, optional
        Standard deviation of an offset that all taxels share, such as a drift, in those of the
        noise; it is integrated out. Default 5; 0 where the sum of the pressure is seen (stress, or
        a Poisson's ratio well below 0.5): part of a press would be taken for an offset.

    Notes
    -----
    With the covariance :math:`Q_{ij} = q (1 + \sqrt3 d/\ell) e^{-\sqrt3 d/\ell}`, that of noise
    and offset :math:`\Sigma = \mathrm{diag}(\sigma^2) + c^2 1 1^T`, and readings y = A p + both,
    the posterior has

    .. math:: \hat p = Q A^T (A Q A^T + \Sigma)^{-1} y, \quad
              \mathrm{cov} = Q - Q A^T (A Q A^T + \Sigma)^{-1} A Q.

    q is such that the prior's readings have, over the taxels, `snr` times the noise's power:
    tr(W A Q A^T W) = L snr², W = diag(1 / σ). `pressure_std` is the posterior's, so between taxels,
    where a thin skin is nearly blind, it says so.
    """

    snr: float = 10.0
    length_scale: float | None = None
    common_mode: float | None = None

    def __post_init__(self) -> None:
        check_positive("snr", self.snr, "the prior's variance is proportional to snr**2")
        check_common(self.common_mode)
        if self.length_scale is not None:
            check_positive("length_scale", self.length_scale, "in metres")

    def prepare(self, model: ObservationModel) -> LinearOperator:
        """Condition the field on the taxels, once."""
        length = self.length_scale or PITCHES * taxel_distance(model.taxels, model.grid.pitch)
        cross, near = smoothed(model.grid, model.matrix, length), correlation(model.grid, length)
        return _conditioned(self, model, cross, near, GAUSSIAN_FIELD)


def taxel_distance(taxels: Floats, alone: float) -> float:
    """Median distance of a taxel to the nearest other, m; `alone` if there is none."""
    distance = float(np.median(nearest_distance(np.unique(taxels.round(9), axis=0))))
    return distance if np.isfinite(distance) else alone


def correlation(grid: Grid, length: float) -> Floats:
    """Matérn-3/2 correlation of two nodes by their offset in rows and columns: (rows, columns)."""
    height, width = grid.shape
    x, y = lattice(height - 1, width - 1, grid.pitch).T
    scaled = np.sqrt(3.0) * np.hypot(x, y) / length
    return np.asarray(((1 + scaled) * np.exp(-scaled)).reshape(height, width))


def smoothed(grid: Grid, rows: Floats, length: float) -> Floats:
    """Rows (L, K) times the Matérn-3/2 correlation of the nodes, by convolution: (L, K)."""
    return convolved(rows, mirrored(correlation(grid, length)), grid)


def convolved(rows: Floats, table: Floats, grid: Grid) -> Floats:
    """Rows (L, K) convolved with a table (2 rows - 1, 2 columns - 1) by offset: (L, K)."""
    convolution = LatticeConvolution(table)
    return np.stack([convolution(row.reshape(grid.shape)).ravel() for row in rows])
