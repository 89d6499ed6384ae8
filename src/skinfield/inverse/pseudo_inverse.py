"""The generalised inverse of the paper."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import check_range
from skinfield.inverse.model_errors import PSEUDO_INVERSE, RESAMPLED_PSEUDO_INVERSE
from skinfield.inverse.operator import InverseOperator, propagated_std
from skinfield.inverse.resampled import resampled
from skinfield.observation import ObservationModel


@dataclass(frozen=True, kw_only=True)
class PseudoInverse:
    """Moore-Penrose inverse, eq. (13): the smallest pressure that explains the readings.

    Parameters
    ----------
    rcond : float, dimensionless
        Singular values below `rcond` times the largest count as zero.
    resample : bool
        First interpolate the readings onto virtual taxels below the nodes, as the paper does
        (section III-B); else invert on the taxels themselves.
    """

    rcond: float = 1e-6
    resample: bool = False

    def __post_init__(self) -> None:
        check_range("rcond", self.rcond, 0.0, 1.0, "relative to the largest singular value")

    def prepare(self, model: ObservationModel) -> InverseOperator:
        """Invert once."""
        if self.resample:
            virtual = resampled(model)
            inverse = np.linalg.pinv(virtual.matrix, rcond=self.rcond)
            matrix = np.asarray(inverse @ virtual.weights, dtype=np.float64)
        else:
            inverse = np.linalg.pinv(model.matrix, rcond=self.rcond)
            matrix = np.asarray(inverse, dtype=np.float64)
        std = propagated_std(matrix, model.noise_std)
        known = RESAMPLED_PSEUDO_INVERSE if self.resample else PSEUDO_INVERSE
        return InverseOperator(matrix, std, model_error=known.of(model))
