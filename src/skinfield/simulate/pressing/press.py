"""Press on the skin with everything known: the truth that reconstructions are judged against."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import BondedLayer, Layer, Mechanics
from skinfield.elastic.electrostatics import capacitance_change
from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_choice,
    check_positive,
    check_shape,
)
from skinfield.simulate.indenters.body import Indenter
from skinfield.simulate.indenters.shapes import Cone, Cylinder, Ring, Sphere
from skinfield.simulate.pressing import readout
from skinfield.simulate.pressing.contact import Settled, settle
from skinfield.simulate.pressing.imposed import are_soft, impose
from skinfield.simulate.pressing.readout import Around
from skinfield.simulate.pressing.tractions import Rubbed, Traction, bare, follow, resultants, rub
from skinfield.simulate.pressing.windows import Medium
from skinfield.skin import Grid, Patch

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
    touches : tuple of Traction
        The solution, window by window.
    residual : float
        Certificate of the normal contact, see `elastic.contact.Contact`: the largest relative
        error of "no gap under pressure", "no overlap elsewhere", "no work through the gap" and of
        the given forces.
    shear_residual : float
        Of the tangential tractions, see `elastic.contact.Shear`; 0 without shear.
    slipping_share : float
        Part of the touching squares at Coulomb's limit; 0 without friction limit.
    """

    grid: Grid
    layer: Layer
    mechanics: Mechanics
    indenters: tuple[Indenter, ...]
    approach: Floats
    translation: Floats
    touches: tuple[Traction, ...]
    residual: float
    shear_residual: float = 0.0
    slipping_share: float = 0.0

    @cached_property
    def _skin(self) -> Medium:
        return Medium(self.grid, self.layer, self.mechanics)

    @cached_property
    def traction(self) -> Floats:
        """Mean on each cell, on the skin, (K, 3) Pa; a push has negative z."""
        out = readout.cell_traction(self._skin, self.touches)
        return np.asarray(np.moveaxis(out, 0, -1).reshape(-1, 3) + 0.0)

    @property
    def pressure(self) -> Floats:
        """Mean on each cell, (K,) Pa."""
        return np.maximum(-self.traction[:, 2], 0.0)

    @property
    def pressure_by_body(self) -> Floats:
        """Mean pressure (bodies, K) Pa on each cell by each indenter; their sum is `pressure`."""
        return readout.pressure_by_body(self._skin, self.touches, len(self.indenters))

    @property
    def base_stress_below_cells(self) -> Floats:
        """Normal stress (K,) Pa below the cells' centres: for maps, faster than `base_stress`."""
        return readout.base_stress_below_cells(self._skin, self.touches)

    @cached_property
    def _resultants(self) -> tuple[Floats, Floats]:
        return resultants(self._skin, self.touches, len(self.indenters))

    @property
    def forces(self) -> Floats:
        """Normal force of each indenter into the skin, (bodies,) N."""
        return np.asarray(0.0 - self._resultants[0][:, 2])

    @property
    def shears(self) -> Floats:
        """Tangential force of each indenter on the skin, (bodies, 2) N."""
        return self._resultants[0][:, :2]

    @property
    def force(self) -> float:
        """Total normal force into the skin, N."""
        return float(self.forces.sum())

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
        from contourpy import contour_generator

        found = []
        for touch in self.touches:
            (y, x), side = self._skin.axes(touch.window), self._skin.side(touch.window)
            lines = contour_generator(z=np.pad(touch.share, 1)).lines(0.5)
            found += [[x[0], y[0]] + side * (np.asarray(line) - 1.0) for line in lines]
        return found

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
        """Indentation (K,) m: that of the body where it touches.

        There the two agree to the residual, but for squares that a sharp edge crosses: of those the
        solution knows the covered part.
        """
        sunk = readout.indentation(self._skin, self.touches).ravel() - self._along[2].ravel()
        known = self.contact & np.isfinite(self._above)
        return np.where(known, -self._above, sunk)

    @cached_property
    def _along(self) -> Floats:
        """See `readout.sheared`."""
        return readout.sheared(self._skin, self.touches)

    @cached_property
    def displacement(self) -> Floats:
        """Of the surface at the cells' centres, (K, 3) m; negative z is into the skin."""
        out = self._along.copy()
        out[2] = -self._sunk.reshape(self.grid.shape)
        return np.asarray(np.moveaxis(out, 0, -1).reshape(-1, 3))

    @cached_property
    def gap(self) -> Floats:
        """Between surface and the nearest body at the cells' centres, (K,) m; infinite under none.

        0 where it touches.
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
        `skinfield.elastic.electrostatics`, which falls short where the press is deep.
        """
        places = readout.points_of(positions, pad_diameter)
        strain = readout.gap_strain(self._skin, self.touches, places, pad_diameter)
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
    """Press rigid indenters into the skin and solve for the tractions below them; or soft fingers.

    Linear elastic, unilateral: pressure only where there is touch. Bodies are pressed on without
    friction; then those with a shear are pushed along the plane, without turning, by one step in
    which everything that touches sticks, or slips at Coulomb's limit, and pressure and touch follow
    the surface that this moves. Fingers, which come alone, impose their pressure.

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
        Coulomb's coefficient, for the shear; without it all that touches sticks. A body slides
        whose shear is friction times its force.

    Returns
    -------
    Press

    Raises
    ------
    InputError
        For indenters that cover no cell, lie behind others, touch the border of `extent`, sink as
        deep as the layer is thick, or have more shear than friction holds.
    """
    if not isinstance(indenters, Sequence):
        raise InputError(f"indenters is {indenters!r}, expected a list of them, if only of one")
    if not indenters:
        raise InputError("indenters is empty, expected at least one: nothing would press")
    skin = skin_of(layer, extent, cell, mechanics)
    if are_soft(indenters):
        return _softly(skin, indenters)
    return pressed(settle(skin, indenters), indenters, friction)


def skin_of(layer: Layer, extent: float, cell: float, mechanics: Mechanics | None) -> Medium:
    """Grid of square cells around the origin on a medium; see `press`."""
    check_positive("extent", extent, "side of the square of skin, in metres")
    check_positive("cell", cell, "side of a cell, in metres")
    count = int(np.ceil(extent / cell - 1e-9))
    if count**2 > MOST_CELLS:
        raise InputError(
            f"cell is {cell:g} m, expected {extent / MOST_CELLS**0.5:.2g} m or more in an extent "
            f"of {extent:g} m: touches are solved on finer squares by themselves"
        )
    origin = np.full(2, -(count - 1) / 2 * cell)
    grid = Grid(Patch(np.zeros((1, 2))), (count, count), cell, origin)
    return Medium(grid, layer, BondedLayer() if mechanics is None else mechanics)


def _softly(skin: Medium, fingers: Sequence[Indenter]) -> Press:
    """A press by fingers, whose pressure is known."""
    touch, approach = impose(skin, fingers)
    still = np.zeros((len(fingers), 2))
    return Press(
        skin.grid, skin.layer, skin.mechanics, tuple(fingers), approach, still, (touch,), 0.0
    )


def pressed(settled: Settled, indenters: Sequence[Indenter], friction: float | None) -> Press:
    """A press from its normal contact, with friction where there is shear."""
    if any(any(indenter.shear) for indenter in indenters):
        return _sheared(rub(settled, indenters, friction), indenters)
    return _unsheared(settled, indenters)


def _unsheared(settled: Settled, indenters: Sequence[Indenter]) -> Press:
    skin, contact, touches = settled.coverings.skin, settled.contact, bare(settled)
    medium, still = (skin.grid, skin.layer, skin.mechanics), np.zeros((len(indenters), 2))
    return Press(*medium, tuple(indenters), contact.approach, still, touches, contact.residual)


def _sheared(rubbed: Rubbed, indenters: Sequence[Indenter]) -> Press:
    shear, contact = rubbed.shear, rubbed.settled.contact
    area = rubbed.settled.coverings.area
    return replace(
        _unsheared(rubbed.settled, indenters),
        translation=shear.translation,
        touches=rubbed.touches,
        shear_residual=shear.residual,
        slipping_share=float(area[shear.slipping].sum() / area[contact.pressure > 0].sum()),
    )


def press_path(
    layer: Layer,
    path: Sequence[Sequence[Indenter]],
    extent: float = 60e-3,
    cell: float = 0.5e-3,
    mechanics: Mechanics | None = None,
    friction: float | None = None,
) -> list[Press]:
    """Press along a path of loads and places, with friction from the first touch on.

    Friction resists what the pressure moves along the plane, too, so even a body that is pressed
    straight down sinks less than in `press`; loads may turn and fall. Places that move without
    shear are those of a body that rolls.

    Parameters
    ----------
    layer : Layer
    path : sequence of sequences of Indenter
        The same bodies in each step, whose sizes decide how well the path is followed: ten or so
        from the first touch to the full load.
    extent, cell, mechanics, friction
        See `press`.

    Returns
    -------
    list of Press
        One per step; `Press.translation` is that of the step alone.
    """
    if not len(path) or len({len(step) for step in path}) > 1:
        raise InputError(f"path is {path!r}, expected one step or more, of the same bodies each")
    skin = skin_of(layer, extent, cell, mechanics)
    states = [settle(skin, step) for step in path]
    followed = follow(states, path, friction)
    return [_sheared(each, step) for each, step in zip(followed, path, strict=True)]


def parts_of(press: Press) -> list[dict[str, Any]]:
    """Part of each indenter of a press, in order: a row with the unit in each key's name.

    ``number`` from 1, ``body`` in words, ``force_N`` into the skin, ``depth_m`` of its lowest point
    below the undeformed surface, ``x_m`` and ``y_m`` of the centre of its pressure in the plane,
    NaN where it does not touch, ``area_m2`` that it touches, and ``peak_Pa``, the largest mean
    pressure of a cell: below a sharp edge it grows without bound as cells shrink.
    """
    pressure = press.pressure_by_body
    parts = []
    for index, indenter in enumerate(press.indenters):
        force, moment = float(press.forces[index]), press.moments[index]
        # A force -F along z at (x, y) has the moment (-y F, x F).
        centre = np.array([moment[1], -moment[0]]) / force if force > 0 else np.full(2, np.nan)
        area = sum(
            float(touch.share[touch.body == index].sum())
            * (press.grid.pitch / touch.window.split) ** 2
            for touch in press.touches
        )
        parts.append(
            {
                "number": index + 1,
                "body": indenter.kind,
                "force_N": force,
                "depth_m": float(press.approach[index]),
                "x_m": float(centre[0]),
                "y_m": float(centre[1]),
                "area_m2": area,
                "peak_Pa": float(pressure[index].max()),
            }
        )
    return parts


def arrays_of(press: Press, patch: Patch | None = None) -> dict[str, Any]:
    """All that is known of a press as arrays by name, in SI units, for a file.

    Of the cells: `x` (columns,), `y` (rows,) m; `pressure` (rows, columns) Pa; `traction`
    (rows, columns, 3) Pa and `displacement` (rows, columns, 3) m, z outward; `gap` (rows, columns)
    m between surface and body, infinite under none; `contact` (rows, columns); `base_stress`
    (rows, columns) Pa. Of the indenters: `kind`, `position` (bodies, 2) m, `depth` (bodies,) m,
    `forces` (bodies,) N, `centres` of pressure (bodies, 2) m, `areas` (bodies,) m². Of all:
    `force` N, `moment` (3,) N m about the origin, `contact_area` m², `residual`. Of the layer:
    `thickness` m, `young_modulus` Pa, `poisson_ratio`. Of the taxels of a patch: `pad_position`
    (L, 2) m, `pad_diameter` m, `pad_stress` (L,) Pa, `pad_gap_change` (L,) m, `pad_capacitance`
    (L,) ΔC/C₀.
    """
    shape, parts = press.grid.shape, parts_of(press)
    plane = press.grid.plane.reshape(*shape, 2)
    found = {
        "x": plane[0, :, 0],
        "y": plane[:, 0, 1],
        "pressure": press.pressure.reshape(shape),
        "traction": press.traction.reshape(*shape, 3),
        "displacement": press.displacement.reshape(*shape, 3),
        "gap": press.gap.reshape(shape),
        "contact": press.contact.reshape(shape),
        "base_stress": press.base_stress_below_cells.reshape(shape),
        "kind": np.array([body.kind for body in press.indenters]),
        "position": np.array([body.position for body in press.indenters]),
        "depth": press.approach,
        "forces": press.forces,
        "centres": np.array([[part["x_m"], part["y_m"]] for part in parts]),
        "areas": np.array([part["area_m2"] for part in parts]),
        "force": press.force,
        "moment": press.moment,
        "contact_area": press.contact_area,
        "residual": press.residual,
        "thickness": press.layer.thickness,
        "young_modulus": press.layer.young_modulus,
        "poisson_ratio": press.layer.poisson_ratio,
    }
    if patch is not None:
        places, diameter = patch.plane, patch.pad_diameter
        found |= {
            "pad_position": places,
            "pad_diameter": diameter,
            "pad_stress": press.base_stress(places, diameter),
            "pad_gap_change": press.gap_change(places, diameter),
            "pad_capacitance": press.capacitance(places, diameter),
        }
    return found


def press_ladder(
    layer: Layer,
    indenter: Indenter,
    forces: ArrayLike | Sequence[float],
    extent: float = 60e-3,
    cell: float = 0.5e-3,
    mechanics: Mechanics | None = None,
) -> list[Press]:
    """Press one body with each of several forces: as `press` for each, in less time.

    Parameters
    ----------
    layer : Layer
    indenter : Indenter
        Its own force or depth is ignored, its shear is not.
    forces : (N,) floats, N
        In any order. They are solved from the smallest, each from the one before.
    extent, cell, mechanics
        See `press`.

    Returns
    -------
    list of Press
        In the order of the forces.

    Raises
    ------
    InputError
        For a force that is not above 0, or that pushes the body through the layer.
    """
    found = dict(ladder_steps(layer, indenter, forces, extent, cell, mechanics))
    return [found[index] for index in range(len(found))]


def ladder_steps(
    layer: Layer,
    indenter: Indenter,
    forces: ArrayLike | Sequence[float],
    extent: float = 60e-3,
    cell: float = 0.5e-3,
    mechanics: Mechanics | None = None,
) -> Iterator[tuple[int, Press]]:
    """Presses of `press_ladder` one by one as they are solved, each with its place in `forces`."""
    loads = as_floats("forces", forces)
    check_shape("forces", loads, (None,), "one press per force, in newtons")
    skin = skin_of(layer, extent, cell, mechanics)
    before: Settled | None = None
    for index in np.argsort(loads, kind="stable"):
        body = replace(indenter, force=float(loads[index]), depth=None)
        if are_soft([body]):
            yield int(index), _softly(skin, [body])
            continue
        before = settle(skin, [body], before)
        yield int(index), pressed(before, [body], None)


Readings = Callable[[Floats], Floats]
SPACING = 0.1e-3  # m: between the distances at which a round press is read
HARMONICS = 4  # of the angle, of a round press that is pushed: they fall tenfold each
REACH = 14.0  # thicknesses beyond the press where every reading is below 1e-4 of the highest
WIDE = 8.0  # thicknesses around any other press that a table covers


def is_round(press: Press) -> bool:
    """Whether a press is the same all around the origin, but for a push along the plane."""
    body = press.indenters[0]
    return (
        len(press.indenters) == 1
        and isinstance(body, Sphere | Cylinder | Cone | Ring)
        and tuple(body.position) == (0.0, 0.0)
        and (isinstance(body, Sphere) or tuple(body.tilt) == (0.0, 0.0))
    )


def readings_anywhere(
    press: Press, pad_diameter: float, quantity: str, spacing: float | None = None
) -> Readings:
    """Function from points (N, 2) m to the readings (N,) of taxels there, without noise.

    Of a round press, cubic splines over the distance: thousands of taxels cost next to nothing.

    Parameters
    ----------
    press : Press
    pad_diameter : float, m
    quantity : "capacitance", "gap" or "stress"
    spacing : float, m, optional
        Of any other press, a bicubic spline over a table of points so far from each other; it is 0
        beyond eight thicknesses around the press. Without it, every call computes its readings.
    """
    if is_round(press):
        return readings_around(press, pad_diameter, quantity)
    if spacing is not None:
        check_positive("spacing", spacing, "between the points of the table, in metres")
        return _by_table(press, pad_diameter, quantity, spacing)
    return lambda points: press.readings(points, pad_diameter, quantity)


def readings_around(press: Press, pad_diameter: float, quantity: str) -> Around:
    """Readings of taxels around a round press at the origin, by distance and angle.

    Parameters
    ----------
    press : Press
        See `is_round`. With a shear, the angle counts from its direction.
    pad_diameter : float, m
    quantity : "capacitance", "gap" or "stress"
    """
    if not is_round(press):
        raise InputError(
            f"the press is of {press.indenters!r}, expected one upright sphere, cylinder, cone or "
            "ring at the origin: others are not the same all around"
        )
    along = press.indenters[0].shear
    return Around.of(
        lambda points: press.readings(points, pad_diameter, quantity),
        np.arange(0.0, _reach(press, pad_diameter, REACH) + SPACING, SPACING),
        float(np.arctan2(along[1], along[0])),
        HARMONICS if any(along) else 1,
    )


def _by_table(press: Press, pad_diameter: float, quantity: str, spacing: float) -> Readings:
    from scipy.interpolate import RectBivariateSpline

    half = int(np.ceil(_reach(press, pad_diameter, WIDE) / spacing))
    axis = np.arange(-half, half + 1) * spacing
    x, y = np.meshgrid(axis, axis, indexing="ij")
    values = press.readings(np.column_stack([x.ravel(), y.ravel()]), pad_diameter, quantity)
    spline = RectBivariateSpline(axis, axis, values.reshape(x.shape))

    def readings(points: Floats) -> Floats:
        inside = (np.abs(points) <= axis[-1]).all(axis=1)
        return np.where(inside, spline.ev(points[:, 0], points[:, 1]), 0.0)

    return readings


def _reach(press: Press, pad_diameter: float, thicknesses: float) -> float:
    loaded = float(np.abs(press.grid.plane[press.pressure > 0]).max(initial=0.0))
    return loaded + pad_diameter + thicknesses * press.layer.thickness
