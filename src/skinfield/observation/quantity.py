"""What a taxel reads, as an object: the stress below it, the gap above it, or its capacitance."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skinfield.errors import Floats, check_choice
from skinfield.layout import Grid
from skinfield.mechanics import Layer, Mechanics


class Quantity(Protocol):
    """A linear map from pressure to readings, and what undoes the reading's known nonlinearity."""

    @property
    def symbol(self) -> str:
        """As it stands on the axis of a figure."""
        ...

    @property
    def unit(self) -> str:
        """Of a reading; "1" for a ratio."""
        ...

    @property
    def typical_noise(self) -> float:
        """Standard deviation of one reading where nobody has measured it, in `unit`."""
        ...

    @property
    def lowest(self) -> float:
        """No reading can be as low as this, in `unit`; minus infinity where any can."""
        ...

    def matrix(
        self, mechanics: Mechanics, layer: Layer, grid: Grid, taxels: Floats, pad_diameter: float
    ) -> Floats:
        """Readings of taxels at (L, 2) m of the plane per Pa on each node: (L, K)."""
        ...

    def linearise(self, readings: Floats, out: Floats) -> Floats:
        """Readings of a linear sensor: `readings` themselves, or written into `out`."""
        ...


def _offsets(grid: Grid, taxels: Floats) -> Floats:
    return (taxels[:, None, :] - grid.plane[None, :, :]).reshape(-1, 2)


@dataclass(frozen=True)
class BaseStress:
    """Normal stress on the base in Pa: what the paper takes a taxel to measure.

    Parameters
    ----------
    pad_averaged : bool
        Average over the pad; else the stress at its centre, as in the paper.
    """

    pad_averaged: bool = True

    symbol = "stress"
    unit = "Pa"
    typical_noise = 400.0
    lowest = -np.inf

    def matrix(
        self, mechanics: Mechanics, layer: Layer, grid: Grid, taxels: Floats, pad_diameter: float
    ) -> Floats:
        """See `Quantity.matrix`; Pa per Pa."""
        pad = pad_diameter if self.pad_averaged else 0.0
        stress = mechanics.base_stress(layer, _offsets(grid, taxels), grid.pitch, pad)
        return stress.reshape(len(taxels), len(grid))

    def linearise(self, readings: Floats, out: Floats) -> Floats:
        """`readings`: stress is linear in the load at small strain."""
        return readings


@dataclass(frozen=True)
class Gap:
    """Mean indentation over the pad divided by the thickness: the strain of the gap.

    With a Poisson's ratio of 0.5 it is blind to uniform pressure and negative beside a contact.

    Parameters
    ----------
    pad_averaged : bool
        Average over the pad; else the indentation above its centre.
    """

    pad_averaged: bool = True

    symbol = "indentation / thickness"
    unit = "1"
    typical_noise = 0.002
    lowest = -np.inf

    def matrix(
        self, mechanics: Mechanics, layer: Layer, grid: Grid, taxels: Floats, pad_diameter: float
    ) -> Floats:
        """See `Quantity.matrix`; 1/Pa."""
        pad = pad_diameter if self.pad_averaged else 0.0
        inwards = mechanics.indentation(layer, _offsets(grid, taxels), grid.pitch, pad)
        return inwards.reshape(len(taxels), len(grid)) / layer.thickness

    def linearise(self, readings: Floats, out: Floats) -> Floats:
        """`readings`: the gap is linear in the load at small strain."""
        return readings


@dataclass(frozen=True)
class Capacitance:
    r"""Relative change of capacitance, :math:`\Delta C / C_0`, of a pad under a ground plane.

    The field lines between the electrodes smooth the indentation w by
    :math:`\hat S = kh/\sinh kh`; to first order the reading is the pad's mean of S w/h, and
    `forward` has the field in the deformed gap. Without `pad_averaged` it is S w/h above the
    centre.

    Parameters
    ----------
    order : None, 1, 2 or 3
        None for the field in the deformed gap itself, or the terms of the series in the strain
        that `forward` sums instead. The series falls short where the surface comes down by more
        than some tenths of the thickness, but has an answer for a surface of any steepness.
    pad_averaged : bool
        Average over the pad; else the density of charge at its centre.
    """

    order: int | None = None
    pad_averaged: bool = True

    symbol = "ΔC/C₀"
    unit = "1"
    typical_noise = 0.002
    lowest = -1.0  # a pad cannot lose all its capacitance

    def __post_init__(self) -> None:
        if self.order is not None:
            why = "terms of the series, or None for the field in the deformed gap"
            check_choice("order", str(self.order), ("1", "2", "3"), why)

    def matrix(
        self, mechanics: Mechanics, layer: Layer, grid: Grid, taxels: Floats, pad_diameter: float
    ) -> Floats:
        """See `Quantity.matrix`; 1/Pa, the series' first term."""
        pad = pad_diameter if self.pad_averaged else 0.0
        offsets = _offsets(grid, taxels)
        inwards = mechanics.indentation(layer, offsets, grid.pitch, pad, electrostatic=True)
        return inwards.reshape(len(taxels), len(grid)) / layer.thickness

    def linearise(self, readings: Floats, out: Floats) -> Floats:
        """Strain c / (1 + c), exact for a uniform gap, C/C0 = 1/(1 - w/h); order 1: `readings`.

        The rest of the nonlinearity depends on the shape of the indentation and stays an error of
        every linear solver.
        """
        if self.order == 1:
            return readings
        np.add(readings, 1.0, out=out)
        return np.divide(readings, out, out=out)

    def forward(
        self,
        mechanics: Mechanics,
        layer: Layer,
        grid: Grid,
        pressure: Floats,
        taxels: Floats,
        pad_diameter: float,
    ) -> Floats:
        """Reading of each taxel, nonlinear in the pressure.

        Parameters
        ----------
        pressure : (K,) array, Pa
        taxels : (L, 2) array, m
            In the plane.

        Returns
        -------
        (L,) array, ΔC/C₀
        """
        from skinfield.observation.electrostatics import capacitance_change, gap_strain

        pad = pad_diameter if self.pad_averaged else 0.0
        strain = gap_strain(mechanics, layer, grid, pressure, taxels, pad)
        return capacitance_change(strain, layer.thickness, taxels, pad, self.order)
