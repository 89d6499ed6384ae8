"""The bonded layer on a curved body: a rigid sphere or cylinder, recognised from the taxels."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skinfield.elastic.bonded_layer import BondedLayer
from skinfield.elastic.curved_series import FINE, cylinder_kernel, sphere_kernel
from skinfield.elastic.elastomer import Layer
from skinfield.errors import Floats, InputError, Ints, check_positive, check_shape, check_type
from skinfield.skin import Grid, Patch
from skinfield.skin.geometry import flat_frame
from skinfield.skin.quadrics import Quadrics

OFF = 0.1  # thicknesses: a taxel farther from a sphere or cylinder than that does not lie on it
LEAN = np.sin(np.radians(25.0))  # nor does one whose normal leans more than 25°
TRUST = 0.1  # of normals, which are estimates where nobody gave them
TIE = 0.02  # of those tolerances: shapes that fit no worse than that fit equally well
WIDE = 1000.0  # thicknesses: a body with a larger radius is flat to 1e-3
SHARPEST = 0.25  # thicknesses: the width of pieces of a cell at most
AROUND = 8  # pieces around a piece, among which those of another sheet are sought
ELSEWHERE = 4  # cells, in the plane, to what is another sheet


@dataclass(frozen=True)
class SphericalBase:
    """A rigid sphere under the layer.

    Parameters
    ----------
    centre : (3,) numbers, m
        In the patch's frame.
    radius : float, m
        On which the pads lie.
    """

    centre: tuple[float, float, float]
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", _three("centre", self.centre))
        check_positive("radius", self.radius, "of the sphere on which the pads lie, in metres")

    def upright(self, points: Floats) -> tuple[Floats, Floats]:
        """Height (N,) m of points (N, 3) m above the base, and the normals (N, 3) there."""
        return _lengths_and_directions(points - self.centre, self.radius)

    def area(self, height: float) -> float:
        """Area at a height in m above the base, over that of the base."""
        return (1.0 + height / self.radius) ** 2

    def kernel(
        self, layer: Layer, name: str, covered: bool, pad: float, step: float
    ) -> Callable[[Floats, Floats], tuple[Ints, Floats]]:
        """Response at a pad to a force on the surface above points of the base (N, 3) m.

        The function returns the rows of the points within reach, and their responses per h².
        """
        h = layer.thickness
        radius = self.radius / h
        spot = step / h / np.sqrt(np.pi)  # the disc of equal area
        nu = float(layer.poisson_ratio)
        table = sphere_kernel(name, round(radius, 9), nu, covered, round(pad / h, 9), spot)
        places = np.arange(len(table)) * FINE / (radius + 1.0)

        def at(taxel: Floats, points: Floats) -> tuple[Ints, Floats]:
            up = (taxel - self.centre) / np.linalg.norm(taxel - self.centre)
            cosine = (points - self.centre) @ (up / self.radius)
            near = np.flatnonzero(cosine > np.cos(min(places[-1], np.pi)) - 1e-12)
            angle = np.arccos(np.clip(cosine[near], -1.0, 1.0))
            return near, np.interp(angle, places, table)

        return at


@dataclass(frozen=True)
class CylindricalBase:
    """A rigid cylinder under the layer.

    Parameters
    ----------
    point : (3,) numbers, m
        Of the axis, in the patch's frame.
    axis : (3,) numbers
        Its direction; made unit length.
    radius : float, m
        On which the pads lie.
    """

    point: tuple[float, float, float]
    axis: tuple[float, float, float]
    radius: float

    def __post_init__(self) -> None:
        axis = np.array(_three("axis", self.axis))
        length = float(np.linalg.norm(axis))
        if not length > 1e-9:
            raise InputError(f"axis is {self.axis}, expected a direction: (0, 1, 0) is along y")
        axis = axis if abs(length - 1.0) < 1e-12 else axis / length  # so that a copy is equal
        object.__setattr__(self, "axis", tuple(axis.tolist()))
        object.__setattr__(self, "point", _three("point", self.point))
        check_positive("radius", self.radius, "of the cylinder on which the pads lie, in metres")

    def upright(self, points: Floats) -> tuple[Floats, Floats]:
        """See `SphericalBase.upright`."""
        from_point = points - self.point
        across = from_point - np.outer(from_point @ self.axis, self.axis)
        return _lengths_and_directions(across, self.radius)

    def area(self, height: float) -> float:
        """See `SphericalBase.area`."""
        return 1.0 + height / self.radius

    def kernel(
        self, layer: Layer, name: str, covered: bool, pad: float, step: float
    ) -> Callable[[Floats, Floats], tuple[Ints, Floats]]:
        """See `SphericalBase.kernel`."""
        from scipy.ndimage import map_coordinates

        h = layer.thickness
        radius = self.radius / h
        nu = float(layer.poisson_ratio)
        table = cylinder_kernel(name, round(radius, 9), nu, covered, round(pad / h, 9), step / h)
        rows, columns = table.shape

        def at(taxel: Floats, points: Floats) -> tuple[Ints, Floats]:
            frame = self._frame(taxel[None])
            angle, along = self._unrolled(frame, points)
            along -= float((taxel - self.point) @ self.axis)
            row, column = np.abs(angle) * ((radius + 1.0) / FINE), np.abs(along) / (h * FINE)
            near = np.flatnonzero((row <= rows - 1) & (column <= columns - 1))
            places = np.stack([row[near], column[near]])
            return near, map_coordinates(table, places, order=1)

        return at

    def _frame(self, points: Floats) -> Floats:
        """Frame (3, 3): towards the middle of points (N, 3) from the axis, and along the axis."""
        mean = self.upright(points)[1].mean(axis=0)
        first = mean - np.dot(mean, self.axis) * np.array(self.axis)
        length = float(np.linalg.norm(first))
        first = first / length if length > 1e-6 else flat_frame(np.array(self.axis))[:, 0]
        return np.column_stack([first, np.cross(self.axis, first), self.axis])

    def _unrolled(self, frame: Floats, points: Floats) -> tuple[Floats, Floats]:
        """Angle (N,) about the axis, -π to π, and place along it (N,) m."""
        x, y, along = ((points - self.point) @ frame).T
        return np.arctan2(y, x), along


Base = SphericalBase | CylindricalBase


@dataclass(frozen=True)
class CurvedLayer(BondedLayer):
    r"""Exact mechanics of a layer bonded to a rigid sphere or cylinder.

    What taxels read of a pressure on the outer surface, at R + h, is summed from closed series
    (`curved_series`), for any thickness, modulus and Poisson's ratio, the incompressible limit
    included: stress on the base, indentation, and capacitance through the field in the curved gap
    to first order in the indentation. A node of the grid stands for the surface above it, with its
    true area there: the model's own grid, `ObservationModel.grid`, has its nodes on the outer
    surface, above those of the grid that was handed in, and counts forces by the areas there. Pads
    are discs of the curved base.

    Parameters
    ----------
    inextensible_cover : bool
        As of `BondedLayer`.
    base : SphericalBase or CylindricalBase, optional
        What the pads lie on. Default the sphere or cylinder that fits the taxels' positions and
        normals best, if none is farther from it than a tenth of the thickness and no normal leans
        more than 25°. Taxels in a plane, or on a radius of 1000 thicknesses, have a flat layer.

    Notes
    -----
    Contacts are fitted by a flat layer in the developed plane, thinner and of another modulus, so
    that a press is read alike: see `Physics.flat`. The displacement is that of `BondedLayer`, whose
    methods are inherited.
    """

    base: Base | None = None

    def __post_init__(self) -> None:
        if self.base is not None:
            check_type("base", self.base, Base.__args__, "such as SphericalBase((0, 0, 0), 20e-3)")

    def base_of(self, patch: Patch, layer: Layer) -> Base | None:
        """What the patch's pads lie on; None for a plane.

        Raises
        ------
        InputError
            If neither a sphere nor a cylinder fits, both do, or the skin lies on their inside.
        """
        if self.base is not None:
            return self.base
        if patch.surface.is_flat:
            return None
        fitted = _fitted(patch.positions, patch.normals, layer.thickness, patch.name)
        return None if fitted.radius > WIDE * layer.thickness else fitted

    def outer(self, grid: Grid, layer: Layer) -> Grid:
        """The same nodes on the outer surface, with the areas there; a flat layer's as they are."""
        base = self.base_of(grid.patch, layer)
        if base is None:
            return grid
        return replace(grid, height=layer.thickness, spread=base.area(layer.thickness))

    def on_grid(
        self, name: str, layer: Layer, grid: Grid, taxels: Floats, pad_diameter: float
    ) -> Floats | None:
        """Readings of taxels per Pa on each node, (L, K); None where the layer is flat.

        Parameters
        ----------
        name : str
            "stress" in Pa, "indentation" in m, or "charge": indentation smoothed by the field.
        layer : Layer
        grid : Grid
        taxels : (L, 2) array, m
            In the patch's plane.
        pad_diameter : float, m
            0 for a point.
        """
        base = self.base_of(grid.patch, layer)
        if base is None:
            return None
        h, taller = layer.thickness, base.area(layer.thickness)
        points, areas, node = _pieces(grid, base, SHARPEST * h)
        step = float(np.sqrt(areas.mean() * taller))
        response = base.kernel(layer, name, self.inextensible_cover, pad_diameter / 2, step)
        positions = _on_base(base, grid.patch.surface.position_from_plane(taxels))
        out = np.zeros((len(taxels), len(grid)))
        for row, taxel in zip(out, positions, strict=True):
            near, value = response(taxel, points)
            row[:] = np.bincount(node[near], value * areas[near], minlength=len(grid))
        shear = layer.young_modulus / (2 * (1 + layer.poisson_ratio))
        return out * (taller / h**2 * (1.0 if name == "stress" else h / shear))


def _three(name: str, values: Any) -> tuple[float, float, float]:
    array = np.asarray(values, dtype=np.float64)
    check_shape(name, array, (3,), "x, y and z in the patch's frame")
    if not np.isfinite(array).all():
        raise InputError(f"{name} is {values}, expected finite numbers: x, y and z")
    x, y, z = array.tolist()
    return x, y, z


def _lengths_and_directions(vectors: Floats, radius: float) -> tuple[Floats, Floats]:
    length = np.linalg.norm(vectors, axis=1)
    return length - radius, vectors / np.maximum(length, 1e-12)[:, None]


def _on_base(base: Base, points: Floats) -> Floats:
    """Points (N, 3) m moved along the normals onto the base."""
    height, normal = base.upright(points)
    return np.asarray(points - height[:, None] * normal)


def _pieces(grid: Grid, base: Base, largest: float) -> tuple[Floats, Floats, Ints]:
    """Pieces of a grid's cells, no wider than `largest` m: middles (M, 3) m, areas, and nodes (M,).

    Middles and areas are on the base. What is no place of its own, beyond the cut of a cylinder,
    has no area; where the plane of another body was cut and overlaps itself, its sheets share it.
    """
    parts = max(1, int(np.ceil(grid.pitch / largest)))
    step, (rows, columns) = grid.pitch / parts, grid.shape
    shape = rows * parts, columns * parts
    origin = grid.origin - (grid.pitch + step) / 2  # a ring more, for slopes at the border
    ring = Grid(grid.patch, (shape[0] + 2, shape[1] + 2), step, origin)
    lattice = _on_base(base, ring.positions).reshape(*ring.shape, 3)
    along, across = lattice[1:-1, 2:] - lattice[1:-1, :-2], lattice[2:, 1:-1] - lattice[:-2, 1:-1]
    areas = np.linalg.norm(np.cross(along, across), axis=-1).ravel() / 4
    row, column = (each.ravel() // parts for each in np.indices(shape))
    middles = lattice[1:-1, 1:-1].reshape(-1, 3)
    node = np.asarray(row * columns + column, dtype=np.int64)
    surface = grid.patch.surface
    if isinstance(surface.shape, Quadrics):
        return middles, areas / _sheets(middles, node, along, across, columns), node
    inner = ring.plane.reshape(*ring.shape, 2)[1:-1, 1:-1].reshape(-1, 2)
    return middles, areas * surface.held(inner, step), node


def _sheets(middles: Floats, node: Ints, along: Floats, across: Floats, columns: int) -> Floats:
    """How many cells elsewhere in the plane hold the middle of each piece, and its own: (M,)."""
    from scipy.spatial import cKDTree

    near = min(AROUND, len(middles))
    other = np.reshape(cKDTree(middles).query(middles, k=near)[1], (len(middles), near))
    lattice = np.stack(np.divmod(node, columns))
    apart = np.abs(lattice[:, other] - lattice[:, :, None]).max(axis=0)
    piece, which = np.nonzero(apart > ELSEWHERE)
    cell = other[piece, which]
    a, b = (side.reshape(-1, 3)[cell] / 2 for side in (along, across))
    offset = middles[piece] - middles[cell]
    aa, ab, bb, pa, pb = (
        np.einsum("ni,ni->n", *two) for two in ((a, a), (a, b), (b, b), (a, offset), (b, offset))
    )
    area = np.maximum(aa * bb - ab**2, 1e-30)
    inside = np.maximum(np.abs(bb * pa - ab * pb), np.abs(aa * pb - ab * pa)) <= area / 2
    return np.asarray(1.0 + np.bincount(piece[inside], minlength=len(middles)))


def _fitted(positions: Floats, normals: Floats, thickness: float, name: str) -> Base:
    """The sphere or the cylinder through taxels (L, 3) m with normals (L, 3)."""
    kinds = {
        "sphere": _sphere_through(positions, normals, thickness),
        "cylinder": _cylinder_through(positions, normals, thickness),
    }
    misfits, words = {}, []
    for kind, (fit, radius) in kinds.items():
        height, upright = fit.upright(positions)
        off = float(np.abs(height).max())
        lean = float(np.linalg.norm(np.cross(upright, normals), axis=1).max())
        inward = radius < 0 or float(np.sum(upright * normals, axis=1).min()) < 0
        misfits[kind] = np.inf if inward else max(off / (OFF * thickness), lean / LEAN)
        side = ", on its inside" if inward else ""
        words.append(
            f"a {kind} of radius {fit.radius * 1e3:.3g} mm by {off * 1e3:.2g} mm and "
            f"{np.degrees(np.arcsin(min(lean, 1.0))):.2g}°{side}"
        )
    best = min(misfits, key=lambda kind: misfits[kind])
    expected = f"within {OFF * thickness * 1e3:.2g} mm and 25°, normals outwards"
    remedy = "hand in mechanics=CurvedLayer(base=SphericalBase(...) or CylindricalBase(...))"
    if not misfits[best] <= 1.0:
        raise InputError(
            f"taxels of {name!r} are off {words[0]}, and off {words[1]}, expected {expected}: "
            f"{remedy} if it is one of them, or BondedLayer() to take the skin for flat"
        )
    if max(misfits.values()) <= misfits[best] + TIE:
        raise InputError(
            f"taxels of {name!r} lie on a sphere and on a cylinder as well, as those of one row "
            f"do, expected a patch that tells which: {remedy}"
        )
    return kinds[best][0]


def _refined(
    start: Floats, make: Callable[[Floats], Base], positions: Floats, normals: Floats, unit: float
) -> Base:
    """Least squares of heights, and of the normals' lean over a tenth of the thickness `unit` m."""
    from scipy.optimize import least_squares

    def misfit(x: Floats) -> Floats:
        height, upright = make(x).upright(positions)
        return np.concatenate([height / unit, TRUST * (upright - normals).ravel()])

    return make(np.asarray(least_squares(misfit, start, x_scale=np.maximum(abs(start), unit)).x))


def _sphere_through(positions: Floats, normals: Floats, unit: float) -> tuple[Base, float]:
    """Sphere, and its radius by the normals alone, negative on the inside of one."""
    middle, mean = positions.mean(axis=0), normals.mean(axis=0)
    spread = max(float(np.sum((normals - mean) ** 2)), 1e-12)
    radius = float(np.sum((positions - middle) * (normals - mean))) / spread

    def make(x: Floats) -> Base:
        return SphericalBase((x[0], x[1], x[2]), abs(float(x[3])))

    start = np.array([*(middle - radius * mean), abs(radius)])
    return _refined(start, make, positions, normals, unit), radius


def _cylinder_through(positions: Floats, normals: Floats, unit: float) -> tuple[Base, float]:
    """Cylinder, and its radius by the normals alone, negative on the inside of one."""
    padded = np.pad(normals, ((0, max(0, 3 - len(normals))), (0, 0)))
    axis = np.linalg.svd(padded)[2][2]
    sides = flat_frame(axis)
    flat, across = positions @ sides[:, :2], normals @ sides[:, :2]
    middle, mean = flat.mean(axis=0), across.mean(axis=0)
    spread = max(float(np.sum((across - mean) ** 2)), 1e-12)
    radius = float(np.sum((flat - middle) * (across - mean))) / spread

    def make(x: Floats) -> Base:
        """Of the axis' foot in its first direction's plane, its slopes, and the radius."""
        foot, along = sides[:, :2] @ x[:2], axis + sides[:, :2] @ x[2:4]
        return CylindricalBase(tuple(foot.tolist()), tuple(along.tolist()), abs(float(x[4])))

    start = np.array([*(middle - radius * mean), 0.0, 0.0, abs(radius)])
    return _refined(start, make, positions, normals, unit), radius
