"""Patches of triangular modules."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_positive,
    check_shape,
)
from skinfield.layout.generators.templates import (
    ICUB_TRIANGLE,
    PAPER_TRIANGLE,
    TEN_PAD_TRIANGLE,
    ModuleTemplate,
)
from skinfield.layout.patch import Patch

MAX_MODULES = 16  # of the reference skin: four I²C buses of four modules at one microcontroller
RADIUS72 = 33.464e-3 / 3**0.5  # from the middle of hexagon72 to its modules


def triangle_modules(
    template: ModuleTemplate,
    centroids: ArrayLike,
    rotations: ArrayLike,
    *,
    name: str = "triangles",
    max_modules: int = MAX_MODULES,
) -> Patch:
    """Flat patch of modules, each laid at its own centroid, turned by its own angle.

    Module m hangs on bus m // 4. Taxel t of module m has channel m * n_channels + channels[t] and
    uid m << 4 | channels[t] + 1, the numbering of CySkin, whose sensor 0 is a thermometer.

    Parameters
    ----------
    template : ModuleTemplate
    centroids : (M, 2) array, m
    rotations : (M,) array, rad
        Counter-clockwise.
    name : str
        Of the patch.
    max_modules : int
        What the electronics carry: 16 for the reference skin.

    Raises
    ------
    InputError
        When there are more than `max_modules` modules, or none.
    """
    centroids, rotations = as_floats("centroids", centroids), as_floats("rotations", rotations)
    check_shape("centroids", centroids, (None, 2), "x and y of each module, in metres")
    check_shape("rotations", rotations, (len(centroids),), "one angle per module, in radians")
    check_finite("centroids", centroids, "each module has a place")
    check_finite("rotations", rotations, "each module has an angle")
    modules = len(centroids)
    if not 1 <= modules <= max_modules:
        raise InputError(
            f"centroids has {modules} modules, expected 1 to {max_modules}: one microcontroller "
            "carries four I²C buses of four modules; split the skin into more patches, or raise "
            "max_modules where your electronics carry more"
        )
    cosine, sine = np.cos(rotations), np.sin(rotations)
    turn = np.stack([np.stack([cosine, -sine], axis=1), np.stack([sine, cosine], axis=1)], axis=1)
    positions = centroids[:, None] + np.einsum("mij,tj->mti", turn, np.array(template.taxels))
    channel = np.array(template.channels)
    module = np.repeat(np.arange(modules), len(channel))
    return Patch(
        positions.reshape(-1, 2),
        template.pad_diameter,
        module=module,
        uid=(module << 4 | np.tile(channel + 1, modules)).astype(np.uint64),
        channel=module * template.n_channels + np.tile(channel, modules),
        n_channels=modules * template.n_channels,
        name=name,
    )


def triangle_lattice(
    cells: int | Sequence[tuple[int, int]] = 6,
    side: float = 30e-3,
    *,
    template: ModuleTemplate = ICUB_TRIANGLE,
    name: str = "triangles",
    max_modules: int = MAX_MODULES,
) -> Patch:
    """Flat patch of modules that fill cells of a lattice of triangles.

    Cell (column, row) is the triangle between x = (column - 1) side / 2 and (column + 1) side / 2
    in the strip between y = row h and (row + 1) h, h = √3/2 side. It stands on its base where
    column + row is odd, and hangs from it where even, so that six cells meet at the origin.

    Parameters
    ----------
    cells : int or sequence of (column, row)
        Which; a number takes those nearest to the origin: 6 make a hexagon.
    side : float, m
        Of a cell.
    template : ModuleTemplate
        What fills each cell, turned so that its corners fall on the cell's.
    name, max_modules
        See `triangle_modules`.
    """
    check_positive("side", side, "of a triangle of the lattice, in metres")
    places = _nearest_cells(cells) if isinstance(cells, int) else _checked_cells(cells)
    stands = (places.sum(axis=1) % 2).astype(bool)
    height = side * 0.75**0.5
    y = (places[:, 1] + np.where(stands, 1 / 3, 2 / 3)) * height
    rotations = np.where(stands == (template.apex == 1), 0.0, np.pi)
    centroids = np.column_stack([places[:, 0] * side / 2, y])
    return triangle_modules(template, centroids, rotations, name=name, max_modules=max_modules)


def hexagon72() -> Patch:
    """The patch of the paper: a hexagon of 6 modules of 12 taxels, 54 x 50 mm, pads of 4 mm.

    As its makers calibrated it, about the middle of the hexagon and seen from outside, z up.
    """
    bearings = np.radians([90.0, -30.0, -90.0, -150.0, 150.0, 30.0])
    rotations = np.radians([0.0, -120.0, -60.0, 0.0, -60.0, -60.0])
    return triangle_modules(PAPER_TRIANGLE, _ring(RADIUS72, bearings), rotations, name="hexagon72")


def icub_hexagon() -> Patch:
    """Hexagon of six 12-taxel triangles of the iCub, corners in the middle, pitch 5.0 mm."""
    bearings = np.radians(30.0 + 60.0 * np.arange(6))
    centroids = _ring(ICUB_TRIANGLE.side / 3**0.5, bearings)
    return triangle_modules(ICUB_TRIANGLE, centroids, bearings + np.pi / 2, name="icub_hexagon")


def icub_triangle() -> Patch:
    """One 12-taxel triangle of the iCub, corner at +y."""
    return triangle_modules(ICUB_TRIANGLE, [[0.0, 0.0]], [0.0], name="icub_triangle")


def ten_pad_triangle() -> Patch:
    """One triangle of the newer iCub boards: 10 taxels on 12 channels, pitch 6.43 mm."""
    return triangle_modules(TEN_PAD_TRIANGLE, [[0.0, 0.0]], [0.0], name="ten_pad_triangle")


def _ring(radius: float, bearings: Floats) -> Floats:
    return radius * np.column_stack([np.cos(bearings), np.sin(bearings)])


def _checked_cells(cells: Sequence[tuple[int, int]]) -> Floats:
    places = as_floats("cells", cells)
    check_shape("cells", places, (None, 2), "(column, row) of each module")
    if (places != np.round(places)).any():
        raise InputError(f"cells is {cells!r}, expected whole numbers (column, row)")
    if len(np.unique(places, axis=0)) < len(places):
        raise InputError(f"cells is {cells!r}, expected each cell once: modules cannot overlap")
    return places


def _nearest_cells(count: int) -> Floats:
    """`count` cells nearest to the origin, counter-clockwise from +x among those as near."""
    reach = int(abs(count) ** 0.5) + 3
    lattice = np.meshgrid(np.arange(-2 * reach, 2 * reach + 1), np.arange(-reach, reach))
    column, row = (axis.ravel() for axis in lattice)
    x = column / 2
    y = (row + np.where((column + row) % 2 == 1, 1 / 3, 2 / 3)) * 0.75**0.5
    distance = np.round(np.hypot(x, y), 9)
    order = np.lexsort([np.mod(np.arctan2(y, x), 2 * np.pi), distance])
    return np.column_stack([column, row])[order[: max(count, 0)]].astype(np.float64)
