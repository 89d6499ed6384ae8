"""Parallel-plate capacitor of a taxel: its capacitance at rest, and the gap's strain from ΔC/C₀."""

import math

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic import Layer
from skinfield.errors import Floats, InputError, as_floats, check_positive

VACUUM_PERMITTIVITY = 8.8541878128e-12
"""F/m, CODATA 2018."""


def rest_capacitance(layer: Layer, pad_diameter: float) -> float:
    """Capacitance at rest, F, of a round pad of `pad_diameter`, m: eq. (1) of the paper.

    C = ε₀ εᵣ A / h, without fringe: a 4 mm pad under 2 mm of silicone (εᵣ = 3) has 0.167 pF.
    """
    check_positive("pad_diameter", pad_diameter, "in metres, 4 mm is 4e-3")
    area = math.pi * pad_diameter**2 / 4.0
    return VACUUM_PERMITTIVITY * layer.relative_permittivity * area / layer.thickness


def strain_from_relative_capacitance(relative_capacitance: ArrayLike) -> Floats:
    """Gap strain v = indentation / thickness from c = ΔC/C₀: v = c / (1 + c).

    C/C₀ = 1 / (1 - v), from eq. (1) and (2). It holds for a gap that is uniform over the pad and
    around it; under a contact narrower than the pad and its gap it is 10-35 % off, and the
    electrostatic observation model is the right one. NaN stays NaN.

    Raises
    ------
    InputError
        If ΔC/C₀ is -1 or less: no gap takes away all capacitance.
    """
    change = as_floats("relative_capacitance", relative_capacitance)
    bad = np.argwhere((change <= -1.0) | np.isinf(change))
    if len(bad):
        where = tuple(int(i) for i in bad[0])
        raise InputError(
            f"relative_capacitance{list(where) if where else ''} is {change[where]}, expected a "
            f"finite number above -1 ({len(bad)} of {change.size} are not): a pad cannot lose all "
            "capacitance"
        )
    return np.asarray(change / (1.0 + change))
