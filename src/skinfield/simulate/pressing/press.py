"""A press on the skin with everything known: the truth that reconstructions are judged against."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, check_choice, check_positive
from skinfield.layout import Grid, Patch
from skinfield.mechanics import BondedLayer, Layer, Mechanics
from skinfield.observation.electrostatics import capacitance_change
from skinfield.simulate.indenters import Indenter
from skinfield.simulate.pressing import deformed, readout
from skinfield.simulate.pressing.laid import Settled
from skinfield.simulate.pressing.outline import outlines
from skinfield.simulate.pressing.plane import Skin
from skinfield.simulate.pressing.settle import settle
from skinfield.simulate.pressing.shear import add_shear, bare
from skinfield.simulate.pressing.touch import Touch, resultants

MOST_CELLS = 4_000_000


@dataclass(frozen=True, eq=False)
class Press:
    """Indenters at rest on the skin.

    The contact is solved on finer squares than the grid's cells, in windows around it; fields on
    the grid are means (tractions) or values at the centres (displacement, gap), and all readouts
    come from the fine solution.

    Attributes
    ----------
    grid : Grid
        Square cells of the plane.
    layer : Layer
    mechanics : Mechanics
    indenters : tuple of Indenter
    approach : (bodies,) array, m
        Depth of each indenter's lowest point below the undeformed surface.
    translation : (bodies, 2) array, m
        Of each indenter along the plane, by shear.
    touches : tuple of Touch
        The solution, window by window.
    residual : float
        Certificate of the normal contact, see `mechanics.contact.Contact`: the largest relative
        error of "no gap under pressure", "no overlap elsewhere", "no work through the gap" and of
        the given forces.
    shear_residual : float
        Of the tangential stage, see `mechanics.friction.Shear`; 0 without shear.
    slipping_share : float
        Part of the touching squares at Coulomb's limit; 0 without friction limit.
    """

    grid: Grid
    layer: Layer
    mechanics: Mechanics
    indenters: tuple[Indenter, ...]
    approach: Floats
    translation: Floats
    touches: tuple[Touch, ...]
    residual: float
    shear_residual: float = 0.0
    slipping_share: float = 0.0

    @cached_property
    def _skin(self) -> Skin:
        return Skin(self.grid, self.layer, self.mechanics)

    @cached_property
    def traction(self) -> Floats:
        """Mean on each cell, on the skin, (K, 3) Pa; a push has negative z."""
        out = np.zeros((3, *self.grid.shape))
        for touch in self.touches:
            out[:, *touch.window.cells] = touch.window.means(touch.traction)
        return np.asarray(np.moveaxis(out, 0, -1).reshape(-1, 3) + 0.0)

    @property
    def pressure(self) -> Floats:
        """Mean on each cell, (K,) Pa."""
        return np.maximum(-self.traction[:, 2], 0.0)

    @cached_property
    def _resultants(self) -> tuple[Floats, Floats]:
        return resultants(self._skin, self.touches, len(self.indenters))

    @property
    def forces(self) -> Floats:
        """Normal force of each indenter into the skin, (bodies,) N."""
        return np.asarray(0.0 - self._resultants[0][:, 2])

    @property
    def force(self) -> float:
        """Total normal force into the skin, N."""
        return float(self.forces.sum())

    @property
    def force_vectors(self) -> Floats:
        """Force of each indenter on the skin, (bodies, 3) N; z is negative."""
        return self._resultants[0]

    @property
    def moments(self) -> Floats:
        """Moment of each indenter's force on the skin about the plane's origin, (bodies, 3) N m."""
        return self._resultants[1]

    @property
    def moment(self) -> Floats:
        """Of all forces on the skin about the plane's origin, (3,) N m."""
        return np.asarray(self.moments.sum(axis=0))

    @property
    def contact(self) -> NDArray[np.bool_]:
        """Cells whose centre touches, (K,); others touch in part where `pressure` is above 0."""
        out = np.zeros(self.grid.shape, dtype=bool)
        for touch in self.touches:
            out[touch.window.cells] = touch.window.centres(touch.touching)
        return out.ravel()

    @property
    def contact_area(self) -> float:
        """Of what touches, m², counted in parts of the fine squares."""
        return sum(touch.area(self._skin.side(touch.window)) for touch in self.touches)

    @property
    def outline(self) -> list[Floats]:
        """Closed polygons (N, 2) m around what touches, anticlockwise; holes run clockwise."""
        return [
            polygon
            for touch in self.touches
            for polygon in outlines(touch.share, *self._skin.axes(touch.window))
        ]

    @cached_property
    def _above(self) -> Floats:
        """Height of the nearest body above the undeformed surface, (K,) m; negative below it."""
        x, y = self.grid.plane.T
        above = [
            np.asarray(indenter.height(x, y)) - depth
            for indenter, depth in zip(self.indenters, self.approach, strict=True)
        ]
        return np.asarray(np.min(above, axis=0))

    @cached_property
    def _sunk(self) -> Floats:
        """Indentation (K,) m by the normal contact: that of the body where it touches.

        There the two agree to the residual, but for squares that a sharp edge crosses: of those the
        solution knows the covered part.
        """
        sunk = deformed.indentation(self._skin, self.touches).ravel()
        known = self.contact & np.isfinite(self._above)
        return np.where(known, -self._above, sunk)

    @cached_property
    def displacement(self) -> Floats:
        """Of the surface at the cells' centres, (K, 3) m; negative z is into the skin."""
        out = deformed.sheared(self._skin, self.touches)
        out[2] -= self._sunk.reshape(self.grid.shape)
        return np.asarray(np.moveaxis(out, 0, -1).reshape(-1, 3))

    @cached_property
    def gap(self) -> Floats:
        """Between surface and the nearest body at the cells' centres, (K,) m; infinite under none.

        0 where it touches. Of the normal contact: what shear adds to the indentation is not in it.
        """
        return self._above + self._sunk

    def base_stress(self, positions: ArrayLike, pad_diameter: float) -> Floats:
        """Mean normal stress (L,) Pa below pads at (L, 2) or (L, 3) m of the plane."""
        places = readout.points_of(positions, pad_diameter)
        return readout.base_stress(self._skin, self.touches, places, pad_diameter)

    def base_traction(self, positions: ArrayLike, pad_diameter: float = 0.0) -> Floats:
        """Mean traction (L, 3) Pa that the skin exerts on the base's plane, outward normal +z.

        Compression has negative z.
        """
        places = readout.points_of(positions, pad_diameter)
        return readout.base_traction(self._skin, self.touches, places, pad_diameter)

    def gap_change(self, positions: ArrayLike, pad_diameter: float) -> Floats:
        """Mean indentation (L,) m above pads at (L, 2) or (L, 3) m of the plane."""
        places = readout.points_of(positions, pad_diameter)
        return readout.gap_change(self._skin, self.touches, places, pad_diameter)

    def capacitance(
        self, positions: ArrayLike, pad_diameter: float, order: int | None = None
    ) -> Floats:
        """ΔC/C₀ (L,) of pads at (L, 2) or (L, 3) m: of the field in the deformed gap.

        With an `order` of 1, 2 or 3 that of the series in the strain, see
        `skinfield.observation.electrostatics`, which falls short where the press is deep.
        """
        places = readout.points_of(positions, pad_diameter)
        strain = deformed.gap_strain(self._skin, self.touches, places, pad_diameter)
        return capacitance_change(strain, self.layer.thickness, places, pad_diameter, order)

    def readings(self, positions: ArrayLike, pad_diameter: float, quantity: str) -> Floats:
        """Noise-free readings (L,) as "capacitance", "gap" or "stress", in the quantity's unit."""
        if quantity == "capacitance":
            return self.capacitance(positions, pad_diameter)
        if quantity == "gap":
            return self.gap_change(positions, pad_diameter) / self.layer.thickness
        check_choice("quantity", quantity, ("capacitance", "gap", "stress"), "what taxels read")
        return self.base_stress(positions, pad_diameter)


def press(
    layer: Layer,
    indenters: Sequence[Indenter],
    extent: float = 60e-3,
    cell: float = 0.5e-3,
    mechanics: Mechanics | None = None,
    friction: float | None = None,
) -> Press:
    """Press rigid indenters into the skin and solve for the tractions below them.

    Linear elastic, unilateral: pressure only where there is touch. The normal contact is
    frictionless; where an indenter has a shear, tangential tractions follow in a second stage in
    which everything that touches sticks, or slips at Coulomb's limit.

    Parameters
    ----------
    layer : Layer
    indenters : sequence of Indenter
        Each with its own place and its force or depth; they must not overlap. One with a depth
        that the surface stays clear of, next to a deeper one, does not touch: its force is 0.
    extent : float, m
        Side of the square around the origin in which touch is possible.
    cell : float, m
        Side of a cell of the grid on which fields are given. Contacts are solved on finer squares:
        a third, ninth, 27th or 81st, some 50 or more to each contact.
    mechanics : Mechanics, optional
        Default `BondedLayer()`. `HalfSpace` is the paper's difference of two depths; an elastic
        half-space is a thick layer: the base takes some 0.7 a/h of the depth, a the contact radius.
    friction : float, optional
        Coulomb's coefficient, for the shear; without it all that touches sticks.

    Returns
    -------
    Press

    Raises
    ------
    InputError
        For indenters that cover no cell, lie behind others, touch the border of `extent`, sink as
        deep as the layer is thick, or would slide.
    """
    check_positive("extent", extent, "side of the square of skin, in metres")
    check_positive("cell", cell, "side of a cell, in metres")
    if not isinstance(indenters, Sequence):
        raise InputError(f"indenters is {indenters!r}, expected a list of them, if only of one")
    if not indenters:
        raise InputError("indenters is empty, expected at least one: nothing would press")
    skin = skin_of(layer, extent, cell, BondedLayer() if mechanics is None else mechanics)
    return pressed(settle(skin, indenters), indenters, friction)


def skin_of(layer: Layer, extent: float, cell: float, mechanics: Mechanics) -> Skin:
    """Grid of square cells around the origin on a medium."""
    count = int(np.ceil(extent / cell - 1e-9))
    if count**2 > MOST_CELLS:
        raise InputError(
            f"cell is {cell:g} m, expected {extent / MOST_CELLS**0.5:.2g} m or more in an extent "
            f"of {extent:g} m: touches are solved on finer squares by themselves"
        )
    origin = np.full(2, -(count - 1) / 2 * cell)
    return Skin(Grid(Patch(np.zeros((1, 2))), (count, count), cell, origin), layer, mechanics)


def pressed(settled: Settled, indenters: Sequence[Indenter], friction: float | None) -> Press:
    """A press from its normal contact, with the tangential stage where there is shear."""
    touches, sheared = bare(settled), None
    if any(any(indenter.shear) for indenter in indenters):
        touches, sheared = add_shear(settled, touches, indenters, friction)
    skin = settled.laid.skin
    return Press(
        skin.grid,
        skin.layer,
        skin.mechanics,
        tuple(indenters),
        settled.contact.approach,
        np.zeros((len(indenters), 2)) if sheared is None else sheared.translation,
        touches,
        settled.contact.residual,
        0.0 if sheared is None else sheared.residual,
        0.0 if sheared is None else sheared.slipping_share,
    )
