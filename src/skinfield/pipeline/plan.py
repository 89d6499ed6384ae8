"""Everything about a patch that needs no reading."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.fields import PressureNoise
from skinfield.inverse import Solver
from skinfield.observation import Deformation, ObservationModel


@dataclass(frozen=True, eq=False)
class Plan:
    """Prepared reconstruction from the taxels that are valid.

    Attributes
    ----------
    operator : (4 K, L') array, Fortran order
        From linearised readings to pressure (K), then displacement x (K), y (K), z (K).
    explained : (L', L') array
        From linearised readings to what the pressure predicts of them.
    noise : PressureNoise
    pressure_std : (K,) array, Pa
        As the solver states it.
    valid : (L,) bool array
        Which taxels it uses.
    """

    operator: NDArray[Any]
    explained: Floats
    noise: PressureNoise
    pressure_std: Floats
    valid: NDArray[np.bool_]


def make_plan(
    model: ObservationModel,
    deformation: Deformation,
    solver: Solver,
    valid: NDArray[np.bool_],
    nodes: Ints,
    dtype: type[np.floating[Any]],
) -> Plan:
    """Fold resampling, inversion and displacement into one matrix, for some nodes of the model."""
    part = model if valid.all() else model.subset(valid)
    inverse = solver.prepare(part)
    displacement = deformation(inverse.matrix.T)[:, nodes]  # (L', K, 3)
    pressure = inverse.matrix[nodes]
    blocks = [pressure, *np.moveaxis(displacement, (2, 1, 0), (0, 1, 2))]
    return Plan(
        operator=np.asfortranarray(np.concatenate(blocks), dtype=dtype),
        explained=part.matrix @ inverse.matrix,
        noise=PressureNoise(pressure * part.noise_std),
        pressure_std=inverse.pressure_std[nodes],
        valid=valid,
    )
