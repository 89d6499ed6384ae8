"""Parallel-plate capacitor of a taxel: gap, capacitance, changes and counts, both ways."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic import Layer
from skinfield.errors import Floats, InputError, as_floats, check_positive, check_range
from skinfield.signal.boards import Bools

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


@dataclass(frozen=True, kw_only=True)
class CapacitanceConverter:
    """A linear capacitance-to-digital converter with a range, a step and a clamp at both ends.

    The default is the paper's: 4 to 30 pF in steps of 0.32 pF. Those figures cannot describe the
    change of the paper's own pad: a 4 mm pad over 2 mm of silicone has 0.167 pF in all, half a
    step, so its pressure would have to more than double its capacitance to move one count
    (`relative_step` says so in numbers). Real boards resolve femtofarads. Give the real step
    where it is known, and the capacitance of tracks and neighbours that the pad rides on.

    Parameters
    ----------
    low, high : float, F
        Input capacitance at the first and the last count.
    step : float, F
        Change of the input that moves one count.
    parasitic : float, F
        Input capacitance that is not the pad's, and does not change with pressure.
    """

    low: float = 4e-12
    high: float = 30e-12
    step: float = 0.32e-12
    parasitic: float = 10e-12

    def __post_init__(self) -> None:
        check_positive("step", self.step, "in farads, 0.32 pF is 0.32e-12")
        check_range("parasitic", self.parasitic, 0.0, 1e-6, "in farads, 10 pF is 10e-12")
        if not 0.0 <= self.low < self.low + self.step <= self.high < 1e-6:
            raise InputError(
                f"low is {self.low!r} F and high {self.high!r} F, expected 0 <= low < high with at "
                f"least one step of {self.step!r} F between them: give farads, 4 pF is 4e-12"
            )

    @property
    def lowest(self) -> float:
        """First count."""
        return 0.0

    @property
    def highest(self) -> float:
        """Last count: whole steps between `low` and `high`."""
        return float(np.floor((self.high - self.low) / self.step + 1e-9))

    @property
    def rest(self) -> float:
        """NaN: it depends on the pad and on its calibration."""
        return float("nan")

    @property
    def direction(self) -> int:
        """+1: pressure raises the capacitance and the count."""
        return 1

    def saturated(self, counts: Floats) -> Bools:
        """Where a count is the first or the last."""
        return np.asarray((counts <= self.lowest) | (counts >= self.highest))

    def counts_from_capacitance(self, capacitance: ArrayLike) -> Floats:
        """Counts, whole numbers, of pads of `capacitance`, F; clamped to the range.

        NaN stays NaN. Ask `saturated(counts)` where the clamp was met.
        """
        total = as_floats("capacitance", capacitance) + self.parasitic
        return np.clip(np.rint((total - self.low) / self.step), self.lowest, self.highest)

    def capacitance_from_counts(self, counts: ArrayLike) -> Floats:
        """Capacitance of the pads, F, from counts: the middle of the step, ± half a step.

        At a clamp it is only a bound: ask `saturated(counts)`.
        """
        return as_floats("counts", counts) * self.step + self.low - self.parasitic

    def gain(self, rest_capacitance: float) -> float:
        """Counts per unit of ΔC/C₀ of a pad of `rest_capacitance`, F."""
        check_positive("rest_capacitance", rest_capacitance, "C₀ of the pad in farads")
        return rest_capacitance / self.step

    def relative_step(self, rest_capacitance: float) -> float:
        """Change of ΔC/C₀ that moves one count, for a pad of `rest_capacitance`, F."""
        return 1.0 / self.gain(rest_capacitance)
