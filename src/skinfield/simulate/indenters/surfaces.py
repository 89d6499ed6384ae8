"""Bodies given by triangles or by heights on a lattice."""

from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from typing import Any, ClassVar

import numpy as np

from skinfield.errors import (
    Floats,
    InputError,
    Ints,
    as_floats,
    check_finite,
    check_positive,
    check_shape,
)
from skinfield.simulate.indenters.body import Indenter

RIM = 1e-9
"""Share of a triangle by which it reaches past its edges: rounding must not part neighbours."""


def lowest_over(vertices: Floats, faces: Ints, x: Floats, y: Floats) -> Floats:
    """Height of the lowest triangle over each place, exactly.

    Parameters
    ----------
    vertices, faces : (N, 3) array, m, and (M, 3) int array
    x, y : (K,) arrays, m

    Returns
    -------
    (K,) array, m
        Infinite where no triangle is. Triangles that stand upright cover nothing.
    """
    if not len(x):
        return np.empty(0)
    side = int(np.ceil(np.sqrt(len(x))))
    low = np.array([x.min(), y.min()])
    span = np.maximum(np.array([x.max(), y.max()]) - low, 1e-12)
    bin_of = np.minimum((np.stack([x, y], axis=1) - low) / span * side, side - 1).astype(np.int64)
    flat = bin_of[:, 1] * side + bin_of[:, 0]
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], np.arange(side * side + 1))
    found = np.full(len(x), np.inf)
    per_metre = side / span
    _compiled()(vertices, faces, x, y, order, starts, side, low, per_metre, RIM, found)
    return found


def _sweep(
    vertices: Floats,
    faces: Ints,
    x: Floats,
    y: Floats,
    order: Ints,
    starts: Ints,
    side: int,
    low: Floats,
    per_metre: Floats,
    rim: float,
    found: Floats,
) -> None:
    """Lower `found` to each triangle over the places in the bins that its box touches."""
    for face in range(len(faces)):
        a, b, c = vertices[faces[face, 0]], vertices[faces[face, 1]], vertices[faces[face, 2]]
        twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        longest = max(
            (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2,
            (c[0] - a[0]) ** 2 + (c[1] - a[1]) ** 2,
            (c[0] - b[0]) ** 2 + (c[1] - b[1]) ** 2,
        )
        if abs(twice) <= 1e-12 * longest:
            continue
        left = (min(a[0], b[0], c[0]) - low[0]) * per_metre[0] - 1e-6
        right = (max(a[0], b[0], c[0]) - low[0]) * per_metre[0] + 1e-6
        near = (min(a[1], b[1], c[1]) - low[1]) * per_metre[1] - 1e-6
        far = (max(a[1], b[1], c[1]) - low[1]) * per_metre[1] + 1e-6
        if right < 0 or far < 0 or left > side or near > side:
            continue
        for row in range(max(int(near), 0), min(int(far), side - 1) + 1):
            for column in range(max(int(left), 0), min(int(right), side - 1) + 1):
                index = row * side + column
                for slot in range(starts[index], starts[index + 1]):
                    place = order[slot]
                    dx, dy = x[place] - a[0], y[place] - a[1]
                    to_b = (dx * (c[1] - a[1]) - (c[0] - a[0]) * dy) / twice
                    to_c = ((b[0] - a[0]) * dy - dx * (b[1] - a[1])) / twice
                    if to_b >= -rim and to_c >= -rim and to_b + to_c <= 1.0 + rim:
                        height = a[2] + to_b * (b[2] - a[2]) + to_c * (c[2] - a[2])
                        found[place] = min(found[place], max(height, 0.0))


@lru_cache(maxsize=1)
def _compiled() -> Any:
    """`_sweep` as machine code: it runs over every triangle."""
    from skinfield.compiled import njit

    return njit(_sweep)


LEVEL = 1e-9
"""Metres within which vertices are equally low."""


def corners_of(vertices: Floats, faces: Ints) -> Floats:
    """Vertices (N, 3) that are corners of a face."""
    used = np.zeros(len(vertices), dtype=np.bool_)
    used[faces] = True
    return vertices[used]


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh(Indenter):
    """A body given by triangles; what it shows to the skin is the lowest of them at each place.

    Parameters
    ----------
    vertices : (N, 3) array, m
        In the body's own axes: z points away from the skin.
    faces : (M, 3) int array
        Rows of `vertices`. The sense of going around is of no matter, and the surface need not be
        closed.
    position, rotation, tilt, force, depth, shear
        See `Indenter`. Its reference point is the origin of `vertices`.
    """

    vertices: Floats
    faces: Ints
    kind: ClassVar[str] = "mesh"

    def __post_init__(self) -> None:
        super().__post_init__()
        vertices = as_floats("vertices", self.vertices)
        check_shape("vertices", vertices, (None, 3), "corners of the triangles in metres")
        faces = np.asarray(self.faces)
        check_shape("faces", faces, (None, 3), "three rows of vertices for each triangle")
        if not len(faces) or faces.dtype.kind not in "iu":
            raise InputError(
                f"faces holds {len(faces)} rows of {faces.dtype}, expected at least one row of "
                "integers: rows of vertices"
            )
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise InputError(
                f"faces holds rows {faces.min()} to {faces.max()} of vertices, expected 0 to "
                f"{len(vertices) - 1}: triangles must have corners that exist"
            )
        check_finite("vertices", corners_of(vertices, faces), "corners of triangles in metres")
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces.astype(np.int64))

    @cached_property
    def _tilted(self) -> Floats:
        """Vertices (N, 3) m of the tilted body, the lowest one at z = 0."""
        tilted = self.vertices @ self.own_from_body().T
        tilted[:, 2] -= tilted[self.faces, 2].min()
        return np.asarray(tilted)

    @property
    def lowest(self) -> tuple[float, float]:
        """See `Indenter.lowest`."""
        corners = corners_of(self._tilted, self.faces)
        right, ahead, _ = corners[corners[:, 2] <= LEVEL].mean(axis=0)
        return self.place(right, ahead)

    def height(self, x: Floats, y: Floats) -> Floats:
        """See `Indenter.height`."""
        right, ahead = self.own_plane(np.asarray(x), np.asarray(y))
        found = lowest_over(self._tilted, self.faces, right.ravel(), ahead.ravel())
        return found.reshape(right.shape)


@dataclass(frozen=True, kw_only=True, eq=False)
class HeightMap(Indenter):
    """A body given by its height on a lattice, linear between the samples along x and along y.

    A sample stands for the square of one pixel around it. Where a sample is NaN or infinite there
    is no body, and its neighbours are taken at their own heights up to the border. Upright, the
    sides are vertical; tilted, the map is a thin sheet that leans, without sides.

    Parameters
    ----------
    heights : (rows, columns) array, m
        Lower surface; rows go up along y and columns along x. Only differences count.
    pixel : float, m
        Distance between samples.
    position, rotation, tilt, force, depth, shear
        See `Indenter`. Its reference point is the middle of the map at its lowest height.
    """

    heights: Floats
    pixel: float
    kind: ClassVar[str] = "height map"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_positive("pixel", self.pixel, "distance between samples, in metres")
        heights = as_floats("heights", self.heights)
        check_shape("heights", heights, (None, None), "rows along y, columns along x")
        there = np.isfinite(heights)
        if not there.any():
            raise InputError(
                f"heights holds {heights.size} samples, none of them finite, expected at least "
                "one: NaN and infinity stand for no body"
            )
        level = np.where(there, heights - heights[there].min(), np.inf)
        object.__setattr__(self, "heights", level)

    @property
    def lowest(self) -> tuple[float, float]:
        """See `Indenter.lowest`."""
        if self.tilt != (0.0, 0.0):
            return self._sheet.lowest
        row, column = np.nonzero(self.heights <= LEVEL)
        rows, columns = self.heights.shape
        right = (column.mean() - (columns - 1) / 2) * self.pixel
        return self.place(right, (row.mean() - (rows - 1) / 2) * self.pixel)

    def height(self, x: Floats, y: Floats) -> Floats:
        """See `Indenter.height`."""
        if self.tilt != (0.0, 0.0):
            return self._sheet.height(x, y)
        right, ahead = self.own_plane(np.asarray(x), np.asarray(y))
        rows, columns = self.heights.shape
        return self.between(
            ahead / self.pixel + (rows - 1) / 2, right / self.pixel + (columns - 1) / 2
        )

    def between(self, row: Floats, column: Floats) -> Floats:
        """Heights, m, at places counted in samples: 0 is the first one's middle."""
        place = np.floor(np.stack([row, column]) + 0.5).astype(np.int64)
        last = np.array(self.heights.shape).reshape(2, *[1] * row.ndim) - 1
        inside = np.clip(place, 0, last)
        there = (place == inside).all(axis=0) & np.isfinite(self.heights[tuple(inside)])
        return np.where(there, self._mean(row, column), np.inf)

    def _mean(self, row: Floats, column: Floats) -> Floats:
        """Of the samples around such places that are there, bilinear; NaN where none is."""
        from scipy.ndimage import map_coordinates

        there = np.isfinite(self.heights)
        total, share = (
            map_coordinates(values, [row, column], order=1, mode="nearest")
            for values in (np.where(there, self.heights, 0.0), there.astype(np.float64))
        )
        mean = np.full(row.shape, np.nan)
        return np.asarray(np.divide(total, share, out=mean, where=share > 0.0))

    @cached_property
    def _sheet(self) -> Mesh:
        """The surface as triangles: eight for each pixel, around its middle."""
        rows, columns = self.heights.shape
        there = np.isfinite(self.heights)
        row, column = np.mgrid[0 : 2 * rows + 1, 0 : 2 * columns + 1] / 2 - 0.5
        z = self._mean(row, column)  # the same from each pixel that meets there
        x = (column - (columns - 1) / 2) * self.pixel
        y = (row - (rows - 1) / 2) * self.pixel
        index = np.arange(row.size).reshape(row.shape)
        quads = np.repeat(np.repeat(there, 2, axis=0), 2, axis=1)
        a, b = index[:-1, :-1][quads], index[:-1, 1:][quads]
        c, d = index[1:, 1:][quads], index[1:, :-1][quads]
        faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
        vertices = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
        pose: dict[str, Any] = {item.name: getattr(self, item.name) for item in fields(Indenter)}
        return Mesh(vertices=vertices, faces=faces, **pose)
