"""Minimum-norm pressure."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import check_positive
from skinfield.fields import PressurePosterior
from skinfield.inverse.gaussian_model import GaussianModel
from skinfield.inverse.model_errors import TIKHONOV
from skinfield.inverse.operator import InverseOperator
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

    with W = diag(1 / noise_std): the same snr suits every patch, grid and unit. The answer is the
    posterior mean of cells that are independent, each with the variance 1/lambda² (Bishop, Pattern
    Recognition and Machine Learning, section 3.3); `pressure_std` is that posterior's.
    """

    snr: float = 30.0

    def __post_init__(self) -> None:
        check_positive("snr", self.snr, "the penalty is proportional to 1 / snr**2")

    def prepare(self, model: ObservationModel) -> InverseOperator:
        """Solve the (L, L) normal equations: small, as taxels are fewer than nodes."""
        from scipy.linalg import solve_triangular

        whitened = model.matrix / model.noise_std[:, None]
        gram = whitened @ whitened.T
        white = np.zeros(model.grid.shape)
        white[0, 0] = 1.0
        known = GaussianModel.of(whitened.T, gram, white, model.noise_std, self.snr)
        penalty = float(np.trace(gram)) / (len(gram) * self.snr**2)
        gram[np.diag_indices_from(gram)] += penalty
        lower = np.linalg.cholesky(gram)
        factor = solve_triangular(lower, whitened, lower=True)
        matrix = solve_triangular(lower, factor, lower=True, trans=1).T / model.noise_std
        factor = np.ascontiguousarray(factor.T) / np.sqrt(penalty)
        posterior = PressurePosterior.of_lattice(white / penalty, factor)
        return InverseOperator(matrix, posterior.std, posterior, TIKHONOV.of(model), known)
