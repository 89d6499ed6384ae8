"""What taxels read of a small round touch anywhere on the patch: the shapes that are looked for."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats, InputError, as_floats, check_positive, check_shape
from skinfield.layout import Grid, Patch
from skinfield.mechanics import Layer, Mechanics
from skinfield.observation import Quantity

RADII = (0.5, 1.0, 1.75)  # of a touch, in thicknesses
FINENESS = 4.0  # places per pad radius and thickness together, over which readings change
CELLS = 8  # of the lattice that carries a touch, per radius
SAMPLES = 10  # along a cell's side, for the part of the touch that it carries
NEAR, NEAR_STEP, FAR_STEPS = 6.0, 0.05, 60  # thicknesses, and distances beyond them
MOST_VALUES = 200_000_000  # of the table: 1.6 GB


@dataclass(frozen=True, eq=False)
class Templates:
    """Readings of touches of 1 N with Hertz's pressure, of S radii at each of P places.

    Attributes
    ----------
    places : (P, 2) array, m
        In the patch's plane.
    spacing : float, m
        Between neighbouring places.
    radii : (S,) array, m
    readings : (S * P, L) array, unit of the reading per N
        Row `size * P + place`; the linear part, as light touches are.
    """

    places: Floats
    spacing: float
    radii: Floats
    readings: Floats


def round_touches(
    patch: Patch,
    layer: Layer,
    mechanics: Mechanics,
    quantity: Quantity,
    radii: Sequence[float] | None = None,
    spacing: float | None = None,
) -> Templates:
    """Templates on a square lattice of places where the patch feels anything.

    The skin is taken as flat around each touch, and the medium as the same in all directions, so
    that a reading depends on the distance from touch to taxel alone.

    Parameters
    ----------
    radii : sequence of float, m, optional
        Of the touches. Default 0.5, 1 and 1.75 thicknesses.
    spacing : float, m, optional
        Between places. Default a quarter of pad radius and thickness together.
    """
    default = np.multiply(RADII, layer.thickness)
    sizes = default if radii is None else as_floats("radii", radii)
    check_shape("radii", sizes, (None,), "radii of touches, in metres")
    if not len(sizes):
        raise InputError("radii is empty, expected at least one: no touch would be looked for")
    for radius in sizes:
        check_positive("radii", float(radius), "radii of touches, in metres")
    if spacing is None:
        spacing = (patch.pad_diameter / 2 + layer.thickness) / FINENESS
    check_positive("spacing", spacing, "between the places that are tried, in metres")
    places = _places(patch, spacing, len(sizes))
    distance = np.linalg.norm(places[:, None] - patch.plane, axis=2)
    pad = patch.pad_diameter
    shapes = [
        _profile(layer, mechanics, quantity, radius, pad, distance) for radius in sizes.tolist()
    ]
    return Templates(places, spacing, sizes, np.concatenate(shapes))


def _places(patch: Patch, spacing: float, sizes: int) -> Floats:
    """Nodes (P, 2) m of a lattice over the patch: where it measures, or next to a taxel."""
    from scipy.spatial import cKDTree

    margin = max(patch.pad_diameter, patch.pitch) / 2
    low, high = patch.plane.min(axis=0) - margin, patch.plane.max(axis=0) + margin
    wanted = float(np.prod((high - low) / spacing + 1)) * sizes * len(patch)
    if wanted > MOST_VALUES:
        enough = spacing * float(np.sqrt(wanted / MOST_VALUES))
        raise InputError(
            f"spacing is {spacing:.3g} m, expected {enough:.2g} m or more on this patch: the "
            f"table would hold {wanted:.1e} values; split the patch, or look at fewer places"
        )
    grid = Grid.window(patch, low, high, spacing)
    near = np.asarray(cKDTree(patch.plane).query(grid.plane)[0]) <= margin
    return grid.plane[grid.covered | near]


def _profile(
    layer: Layer,
    mechanics: Mechanics,
    quantity: Quantity,
    radius: float,
    pad_diameter: float,
    distance: Floats,
) -> Floats:
    """Readings of taxels at `distance` (...) m from one touch of 1 N, interpolated."""
    from scipy.interpolate import CubicSpline

    h = layer.thickness
    near, far = (NEAR + radius / h) * h + pad_diameter, float(distance.max())
    knots = np.arange(0.0, near + NEAR_STEP * h, NEAR_STEP * h)
    if far > knots[-1]:
        knots = np.concatenate([knots, np.geomspace(knots[-1], far, FAR_STEPS)[1:]])
    line = np.column_stack([knots, np.zeros_like(knots)])
    grid, pressure = _disc(radius)
    matrix = quantity.matrix(mechanics, layer, grid, line, pad_diameter)
    return np.asarray(CubicSpline(knots, matrix @ pressure)(distance))


def _disc(radius: float) -> tuple[Grid, Floats]:
    """Hertz's pressure of 1 N on a lattice around the origin: its cells, and (K,) Pa on them."""
    side = radius / (CELLS + 0.5)  # an odd number of cells across
    grid = Grid(Patch(np.zeros((1, 2))), (2 * CELLS + 1,) * 2, side, np.full(2, -CELLS * side))
    within = ((np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5) * side
    x, y = (grid.plane[:, axis, None] + within for axis in (0, 1))
    square = 1.0 - (x[:, :, None] ** 2 + y[:, None, :] ** 2) / radius**2
    pressure = np.sqrt(np.maximum(square, 0.0)).mean(axis=(1, 2))
    return grid, pressure / (pressure.sum() * grid.cell_area)
