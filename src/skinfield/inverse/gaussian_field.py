"""Posterior mean and deviation of a pressure that is smooth."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, check_positive
from skinfield.fields import PressurePosterior
from skinfield.inverse.gaussian_model import GaussianModel
from skinfield.inverse.model_errors import GAUSSIAN_FIELD
from skinfield.inverse.operator import InverseOperator
from skinfield.layout import Grid
from skinfield.mechanics import LatticeConvolution
from skinfield.mechanics.lattice import lattice, mirrored
from skinfield.observation import ObservationModel

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

    Notes
    -----
    With the covariance :math:`Q_{ij} = q (1 + \sqrt3 d/\ell) e^{-\sqrt3 d/\ell}`, noise
    :math:`\Sigma` and readings y = A p + noise, the posterior has

    .. math:: \hat p = Q A^T (A Q A^T + \Sigma)^{-1} y, \quad
              \mathrm{cov} = Q - Q A^T (A Q A^T + \Sigma)^{-1} A Q.

    q is such that the prior's readings have, over the taxels, `snr` times the noise's power:
    tr(W A Q A^T W) = L snr². `pressure_std` is the posterior's, so between taxels, where a thin
    skin is nearly blind, it says so.
    """

    snr: float = 10.0
    length_scale: float | None = None

    def __post_init__(self) -> None:
        check_positive("snr", self.snr, "the prior's variance is proportional to snr**2")
        if self.length_scale is not None:
            check_positive("length_scale", self.length_scale, "in metres")

    def prepare(self, model: ObservationModel) -> InverseOperator:
        """Condition the field on the taxels, once."""
        from scipy.linalg import solve_triangular

        length = self.length_scale or PITCHES * taxel_distance(model.taxels, model.grid.pitch)
        white = 1.0 / model.noise_std
        cross = smoothed(model.grid, model.matrix, length).T * white  # Q A^T per q, (K, L)
        gram = (model.matrix @ cross) * white[:, None]
        variance = self.snr**2 * len(gram) / np.trace(gram)
        lower = np.linalg.cholesky(gram * variance + np.eye(len(gram)))
        factor = solve_triangular(lower, variance * cross.T, lower=True)
        matrix = solve_triangular(lower, factor, lower=True, trans=1).T * white
        near = correlation(model.grid, length)
        posterior = PressurePosterior.of_lattice(variance * near, np.ascontiguousarray(factor.T))
        known = GaussianModel.of(cross, gram, near, model.noise_std, self.snr)
        return InverseOperator(matrix, posterior.std, posterior, GAUSSIAN_FIELD.of(model), known)


def taxel_distance(taxels: Floats, alone: float) -> float:
    """Median distance of a taxel to the nearest other, m; `alone` if there is none."""
    from scipy.spatial import cKDTree

    distinct = np.unique(taxels.round(9), axis=0)
    if len(distinct) < 2:
        return alone
    distance = np.asarray(cKDTree(distinct).query(distinct, k=2)[0])
    return float(np.median(distance[:, 1]))


def correlation(grid: Grid, length: float) -> Floats:
    """Matérn-3/2 correlation of two nodes by their offset in rows and columns: (rows, columns)."""
    height, width = grid.shape
    x, y = lattice(height - 1, width - 1, grid.pitch).T
    scaled = np.sqrt(3.0) * np.hypot(x, y) / length
    return np.asarray(((1 + scaled) * np.exp(-scaled)).reshape(height, width))


def smoothed(grid: Grid, rows: Floats, length: float) -> Floats:
    """Rows (L, K) times the Matérn-3/2 correlation of the nodes, by convolution: (L, K)."""
    height, width = grid.shape
    smooth = LatticeConvolution(mirrored(correlation(grid, length)))
    return np.stack([smooth(row.reshape(height, width)).ravel() for row in rows])
