"""The plain inverse of the paper."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.inverse.model_errors import INVERSE
from skinfield.inverse.operator import InverseOperator, propagated_std
from skinfield.inverse.resampled import resampled
from skinfield.observation import ObservationModel

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

    def prepare(self, model: ObservationModel) -> InverseOperator:
        """Invert once."""
        if self.resample:
            virtual = resampled(model)
            matrix = np.zeros((len(model.grid), len(model.taxels)))
            matrix[virtual.nodes] = _solve(virtual.matrix[:, virtual.nodes], virtual.weights)
        else:
            taxels, nodes = model.matrix.shape
            if taxels != nodes:
                raise InputError(
                    f"the matrix is ({taxels}, {nodes}), expected as many nodes as taxels: use "
                    "Inverse(resample=True), or PseudoInverse() for any number"
                )
            matrix = _solve(model.matrix, np.eye(taxels))
        std = propagated_std(matrix, model.noise_std)
        return InverseOperator(matrix, std, model_error=INVERSE.of(model))


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
