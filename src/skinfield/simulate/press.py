"""A press on the skin with everything known: the truth that reconstructions are judged against."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_choice, check_positive
from skinfield.layout import Grid, Patch
from skinfield.mechanics import (
    BondedLayer,
    LatticeConvolution,
    Layer,
    Mechanics,
    indentation_kernel,
)
from skinfield.observation.electrostatics import capacitance_change, gap_strain
from skinfield.simulate.indenters import Indenter
from skinfield.simulate.unilateral import solve_contact


@dataclass(frozen=True, eq=False)
class Press:
    """Indenters at rest on the skin.

    Attributes
    ----------
    grid : Grid
        Square cells of the plane, finer than those of a reconstruction.
    layer : Layer
    mechanics : Mechanics
    indenters : tuple of Indenter
    pressure : (K,) array, Pa
    approach : (bodies,) array, m
        Depth of each indenter's lowest point below the undeformed surface.
    """

    grid: Grid
    layer: Layer
    mechanics: Mechanics
    indenters: tuple[Indenter, ...]
    pressure: Floats
    approach: Floats

    @property
    def force(self) -> float:
        """Total into the skin, N."""
        return float(self.pressure.sum() * self.grid.cell_area)

    @property
    def contact(self) -> NDArray[np.bool_]:
        """Cells that touch, (K,)."""
        return self.pressure > 0

    @property
    def contact_area(self) -> float:
        """Of the cells that touch, m²."""
        return float(np.count_nonzero(self.contact) * self.grid.cell_area)

    @property
    def displacement(self) -> Floats:
        """Of the surface at the cells' centres, (K, 3) m; negative z is into the skin."""
        from skinfield.observation import Deformation

        return Deformation(self.grid, self.layer, self.mechanics)(self.pressure)

    def base_stress(self, positions: ArrayLike, pad_diameter: float) -> Floats:
        """Mean normal stress (L,) Pa below pads at (L, 2) or (L, 3) m of the plane."""
        offsets, pressure, shape = self._loaded(positions)
        per_cell = self.mechanics.base_stress(self.layer, offsets, self.grid.pitch, pad_diameter)
        return per_cell.reshape(shape) @ pressure

    def gap_change(self, positions: ArrayLike, pad_diameter: float) -> Floats:
        """Mean indentation (L,) m above pads at (L, 2) or (L, 3) m of the plane."""
        offsets, pressure, shape = self._loaded(positions)
        per_cell = self.mechanics.indentation(self.layer, offsets, self.grid.pitch, pad_diameter)
        return per_cell.reshape(shape) @ pressure

    def capacitance(self, positions: ArrayLike, pad_diameter: float, order: int = 3) -> Floats:
        """ΔC/C₀ (L,) of pads at (L, 2) or (L, 3) m, with the series to the given order."""
        taxels = as_floats("positions", positions)[:, :2]
        strain = gap_strain(self.mechanics, self.layer, self.grid, self.pressure, taxels)
        return capacitance_change(strain, self.layer.thickness, taxels, pad_diameter, order)

    def readings(self, positions: ArrayLike, pad_diameter: float, quantity: str) -> Floats:
        """Noise-free readings (L,) as "capacitance", "gap" or "stress", in the quantity's unit."""
        if quantity == "capacitance":
            return self.capacitance(positions, pad_diameter)
        if quantity == "gap":
            return self.gap_change(positions, pad_diameter) / self.layer.thickness
        check_choice("quantity", quantity, ("capacitance", "gap", "stress"), "what taxels read")
        return self.base_stress(positions, pad_diameter)

    def _loaded(self, positions: ArrayLike) -> tuple[Floats, Floats, tuple[int, int]]:
        taxels = as_floats("positions", positions)[:, :2]
        nodes = self.grid.plane[self.contact]
        offsets = (taxels[:, None] - nodes[None]).reshape(-1, 2)
        return offsets, self.pressure[self.contact], (len(taxels), len(nodes))


def press(
    layer: Layer,
    indenters: Sequence[Indenter],
    extent: float = 60e-3,
    cell: float = 0.5e-3,
    mechanics: Mechanics | None = None,
) -> Press:
    """Press rigid indenters into the skin and solve for the pressure below them.

    Frictionless, linear elastic, unilateral: pressure only where there is touch.

    Parameters
    ----------
    layer : Layer
    indenters : sequence of Indenter
        Each with its own place and force; they must not overlap.
    extent : float, m
        Side of the square around the origin in which touch is possible.
    cell : float, m
        Side of a cell; a tenth of the contact's width gives the force distribution to 1 %.
    mechanics : Mechanics, optional
        Default `BondedLayer()`.
    """
    check_positive("extent", extent, "side of the square of skin, in metres")
    check_positive("cell", cell, "side of a cell, in metres")
    if not indenters:
        raise InputError("indenters is empty, expected at least one: nothing would press")
    mechanics = BondedLayer() if mechanics is None else mechanics
    count = int(np.ceil(extent / cell))
    origin = np.full(2, -(count - 1) / 2 * cell)
    grid = Grid(Patch(np.zeros((1, 2))), (count, count), cell, origin)
    x, y = grid.plane.T.reshape(2, count, count)
    each = np.stack([indenter.height(x, y) for indenter in indenters])
    bodies = each.argmin(axis=0)
    _check_places(indenters, each, bodies, extent, cell)
    kernel = indentation_kernel(mechanics, layer, cell, cell, count - 1, count - 1)
    forces = np.array([indenter.force for indenter in indenters]) / grid.cell_area
    start = np.zeros((count, count))
    for body, force in enumerate(forces):
        near = np.isfinite(each[body]) & (bodies == body)
        guess = near & (each[body] <= max(0.1 * layer.thickness, float(each[body][near].min())))
        start[guess] = force / guess.sum()
    pressure, approach = solve_contact(
        LatticeConvolution(kernel), each.min(axis=0), bodies, start, forces
    )
    _check_depth(indenters, approach, layer)
    return Press(grid, layer, mechanics, tuple(indenters), pressure.ravel(), approach)


def _check_places(
    indenters: Sequence[Indenter],
    heights: Floats,
    bodies: NDArray[np.int64],
    extent: float,
    cell: float,
) -> None:
    """Each indenter must have cells (rows, columns), and be the lowest on some of them."""
    for index, indenter in enumerate(indenters):
        under = np.isfinite(heights[index])
        if not under.any():
            raise InputError(
                f"indenters[{index}] at {indenter.position} m covers no cell, expected it "
                f"within {extent / 2:g} m of the origin and wider than {cell:g} m"
            )
        if not under[bodies == index].any():
            raise InputError(
                f"indenters[{index}] at {indenter.position} m lies behind the others, "
                "expected them apart: each must be the lowest somewhere"
            )


def _check_depth(indenters: Sequence[Indenter], approach: Floats, layer: Layer) -> None:
    deepest = int(approach.argmax())
    if approach[deepest] >= layer.thickness:
        raise InputError(
            f"indenters[{deepest}] with {indenters[deepest].force:g} N sinks "
            f"{approach[deepest] * 1e3:.3g} mm into a layer of {layer.thickness * 1e3:g} mm, "
            "expected less than its thickness: press lighter, or with a wider body"
        )
