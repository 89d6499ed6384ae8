"""Minimum-norm pressure."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import check_positive
from skinfield.inverse.operator import InverseOperator, propagated_std
from skinfield.observation import ObservationModel


@dataclass(frozen=True, kw_only=True)
class Tikhonov:
    r"""Least squares with a penalty on the squared pressure.

    Parameters
    ----------
    snr : float, dimensionless
        Amplitude of the expected readings over their noise; lower is smoother.

    Notes
    -----
    .. math:: \min_p \|W (A p - y)\|^2 + \lambda^2 \|p\|^2, \quad
              \lambda^2 = \mathrm{tr}(W A A^T W) / (L\,\mathrm{snr}^2)

    with W = diag(1 / noise_std): the same snr suits every patch, grid and unit.
    """

    snr: float = 30.0

    def __post_init__(self) -> None:
        check_positive("snr", self.snr, "the penalty is proportional to 1 / snr**2")

    def prepare(self, model: ObservationModel) -> InverseOperator:
        """Solve the (L, L) normal equations: small, as taxels are fewer than nodes."""
        whitened = model.matrix / model.noise_std[:, None]
        gram = whitened @ whitened.T
        gram[np.diag_indices_from(gram)] += np.trace(gram) / (len(gram) * self.snr**2)
        matrix = np.linalg.solve(gram, whitened).T / model.noise_std
        return InverseOperator(matrix, propagated_std(matrix, model.noise_std))
