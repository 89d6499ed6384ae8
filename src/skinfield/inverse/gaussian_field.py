"""Posterior mean and deviation of a pressure that is smooth."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, check_positive
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
        length = self.length_scale or PITCHES * taxel_distance(model.taxels, model.grid.pitch)
        cross = smoothed(model.grid, model.matrix, length).T  # Q A^T per q, (K, L)
        white = 1.0 / model.noise_std
        gram = (model.matrix @ cross) * np.outer(white, white)
        variance = self.snr**2 * len(gram) / np.trace(gram)
        gram = gram * variance + np.eye(len(gram))
        cross = variance * cross * white
        whitened = np.linalg.solve(gram, cross.T).T
        explained = np.einsum("kl,kl->k", whitened, cross)
        std = np.sqrt(np.maximum(variance - explained, 0.0))
        return InverseOperator(whitened * white, std)


def taxel_distance(taxels: Floats, alone: float) -> float:
    """Median distance of a taxel to the nearest other, m; `alone` if there is none."""
    from scipy.spatial import cKDTree

    distinct = np.unique(taxels.round(9), axis=0)
    if len(distinct) < 2:
        return alone
    distance = np.asarray(cKDTree(distinct).query(distinct, k=2)[0])
    return float(np.median(distance[:, 1]))


def smoothed(grid: Grid, rows: Floats, length: float) -> Floats:
    """Rows (L, K) times the Matérn-3/2 correlation of the nodes, by convolution: (L, K)."""
    height, width = grid.shape
    x, y = lattice(height - 1, width - 1, grid.pitch).T
    scaled = np.sqrt(3.0) * np.hypot(x, y) / length
    correlation = (1 + scaled) * np.exp(-scaled)
    smooth = LatticeConvolution(mirrored(correlation.reshape(height, width)))
    return np.stack([smooth(row.reshape(height, width)).ravel() for row in rows])
