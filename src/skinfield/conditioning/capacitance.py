"""A taxel as a parallel-plate capacitor: gap, capacitance and their changes, both ways."""

import math

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_positive, check_range
from skinfield.mechanics import Layer

VACUUM_PERMITTIVITY = 8.8541878128e-12
"""F/m, CODATA 2018."""


def _above(name: str, values: ArrayLike, low: float, why: str) -> Floats:
    """Float array above `low`; NaN passes, as it marks a taxel that is already invalid."""
    array = as_floats(name, values)
    bad = np.argwhere(~((array > low) & (array < np.inf) | np.isnan(array)))
    if len(bad):
        where = tuple(int(i) for i in bad[0])
        raise InputError(
            f"{name}{list(where) if where else ''} is {array[where]}, expected a finite number "
            f"above {low:g} ({len(bad)} of {array.size} are not): {why}"
        )
    return array


def pad_area(diameter: float) -> float:
    """Area of a round pad, m², of `diameter`, m."""
    check_positive("diameter", diameter, "the electrode's diameter in metres, 4 mm is 4e-3")
    return math.pi * diameter**2 / 4.0


def _permittivity_times_area(area: float, relative_permittivity: float) -> float:
    check_positive("area", area, "of the pad in m², pad_area(4e-3) is 1.2566e-5")
    check_range("relative_permittivity", relative_permittivity, 1.0, 1e4, "vacuum has 1")
    return VACUUM_PERMITTIVITY * relative_permittivity * area


def capacitance_from_gap(gap: ArrayLike, *, area: float, relative_permittivity: float) -> Floats:
    """Capacitance, F, of plates of `area`, m², at a distance `gap`, m: eq. (1) of the paper.

    C = ε₀ εᵣ A / h. Plates that stay parallel, no fringe: a round 4 mm pad over 2 mm of silicone
    (εᵣ = 3) has 0.167 pF. NaN stays NaN.

    Raises
    ------
    InputError
        If a gap is zero, negative or infinite.
    """
    gap = _above("gap", gap, 0.0, "the distance of the two electrodes in metres")
    return np.asarray(_permittivity_times_area(area, relative_permittivity) / gap)


def gap_from_capacitance(
    capacitance: ArrayLike, *, area: float, relative_permittivity: float
) -> Floats:
    """Distance of the plates, m, from their capacitance, F: eq. (1) read backwards."""
    capacitance = _above("capacitance", capacitance, 0.0, "of the pad alone, in farads")
    return np.asarray(_permittivity_times_area(area, relative_permittivity) / capacitance)


def capacitance_change_from_gap(
    gap: ArrayLike, rest_gap: float, *, area: float, relative_permittivity: float
) -> Floats:
    """Capacitance in contact less that at rest, F: eq. (2), ε₀ εᵣ A (hₙ - hₚ) / (hₙ hₚ).

    Parameters
    ----------
    gap : array, m
        The paper's hₚ, in contact.
    rest_gap : float, m
        The paper's hₙ.
    area, relative_permittivity
        As in `capacitance_from_gap`.
    """
    check_positive("rest_gap", rest_gap, "the thickness of the elastomer at rest, in metres")
    gap = _above("gap", gap, 0.0, "the distance of the two electrodes in metres")
    scale = _permittivity_times_area(area, relative_permittivity)
    return np.asarray(scale * (rest_gap - gap) / (rest_gap * gap))


def gap_from_capacitance_change(
    change: ArrayLike, rest_gap: float, *, area: float, relative_permittivity: float
) -> Floats:
    """Gap in contact, m, from the change of capacitance, F: eq. (2) read backwards.

    Raises
    ------
    InputError
        If a change takes away all of the capacitance at rest, which no gap does.
    """
    check_positive("rest_gap", rest_gap, "the thickness of the elastomer at rest, in metres")
    scale = _permittivity_times_area(area, relative_permittivity)
    low = -scale / rest_gap
    change = _above("change", change, low, "a pad cannot lose more than it has at rest")
    return np.asarray(scale * rest_gap / (scale + change * rest_gap))


def relative_capacitance_from_strain(strain: ArrayLike) -> Floats:
    """Relative change of capacitance, ΔC/C₀, from the gap strain v = indentation / thickness.

    C/C₀ = 1 / (1 - v), from eq. (1) and (2). It holds for a gap that is uniform over the pad and
    around it; under a contact narrower than the pad and its gap it is 10-35 % off, and the
    electrostatic observation model is the right one.

    Raises
    ------
    InputError
        If a strain is 1 or more: the electrodes would touch.
    """
    strain = as_floats("strain", strain)
    room = _above("1 - strain", 1.0 - strain, 0.0, "at a gap strain of 1 the electrodes touch")
    return np.asarray(strain / room)


def strain_from_relative_capacitance(relative_capacitance: ArrayLike) -> Floats:
    """Gap strain v = indentation / thickness from ΔC/C₀: v = c / (1 + c).

    Raises
    ------
    InputError
        If ΔC/C₀ is -1 or less: no gap takes away all capacitance.
    """
    change = _above(
        "relative_capacitance", relative_capacitance, -1.0, "a pad cannot lose all capacitance"
    )
    return np.asarray(change / (1.0 + change))


def rest_capacitance(layer: Layer, pad_diameter: float) -> float:
    """Capacitance at rest, F, of a round pad under `layer`, eq. (1) without fringe."""
    return float(
        capacitance_from_gap(
            layer.thickness,
            area=pad_area(pad_diameter),
            relative_permittivity=layer.relative_permittivity,
        )
    )
