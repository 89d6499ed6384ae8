"""Virtual taxels below the nodes of a grid: the paper's section III-B."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError
from skinfield.observation import ObservationModel
from skinfield.observation.resample import resampling_matrix


@dataclass(frozen=True, eq=False)
class VirtualTaxels:
    """N virtual taxels, one below each node that lies inside the hull of the taxels.

    Attributes
    ----------
    weights : (N, L) array
        From the readings of the taxels to those of the virtual taxels.
    matrix : (N, K) array, unit of the reading per Pa
        What the virtual taxels read of the pressure.
    nodes : (K,) bool array
        Where the virtual taxels are.
    """

    weights: Floats
    matrix: Floats
    nodes: NDArray[np.bool_]


def resampled(model: ObservationModel) -> VirtualTaxels:
    """Resample a model; nodes outside the hull have no virtual taxel, so nothing is made up."""
    result = resampling_matrix(model.taxels, model.grid.plane)
    inside = result.inside
    if not inside.any():
        raise InputError(
            f"none of the {len(model.grid)} nodes lies inside the hull of the {len(model.taxels)} "
            "taxels, expected some: use a finer grid or one that covers the taxels"
        )
    weights = np.asarray(result.matrix[inside].toarray())
    return VirtualTaxels(weights, model.virtual_matrix(model.grid.plane[inside]), inside)
