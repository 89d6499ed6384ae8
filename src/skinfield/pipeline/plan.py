"""Everything about a patch that needs no reading."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
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
    predict : (L', K) array
        From pressure back to readings.
    noise : PressureNoise
    pressure_std : (K,) array, Pa
        As the solver states it.
    valid : (L,) bool array
        Which taxels it uses.
    """

    operator: NDArray[Any]
    predict: Floats
    noise: PressureNoise
    pressure_std: Floats
    valid: NDArray[np.bool_]


def make_plan(
    model: ObservationModel,
    deformation: Deformation,
    solver: Solver,
    valid: NDArray[np.bool_],
    dtype: type[np.floating[Any]],
) -> Plan:
    """Fold resampling, inversion and displacement into one matrix."""
    part = model if valid.all() else model.subset(valid)
    inverse = solver.prepare(part)
    displacement = deformation(inverse.matrix.T)  # (L', K, 3)
    blocks = [inverse.matrix, *np.moveaxis(displacement, (2, 1, 0), (0, 1, 2))]
    operator = np.asfortranarray(np.concatenate(blocks), dtype=dtype)
    noise = PressureNoise(inverse.matrix * part.noise_std)
    return Plan(operator, part.matrix, noise, inverse.pressure_std, valid)
