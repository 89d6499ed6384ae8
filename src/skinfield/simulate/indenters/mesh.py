"""A body given by triangles."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from skinfield.errors import Floats, InputError, Ints, as_floats, check_finite, check_shape
from skinfield.simulate.indenters.body import Body
from skinfield.simulate.indenters.envelope import lowest_over

LEVEL = 1e-9
"""Metres within which vertices are equally low."""


def corners_of(vertices: Floats, faces: Ints) -> Floats:
    """Vertices (N, 3) that are corners of a face."""
    used = np.zeros(len(vertices), dtype=np.bool_)
    used[faces] = True
    return vertices[used]


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh(Body):
    """A body given by triangles; what it shows to the skin is the lowest of them at each place.

    Parameters
    ----------
    vertices : (N, 3) array, m
        In the body's own axes: z points away from the skin.
    faces : (M, 3) int array
        Rows of `vertices`. The sense of going around is of no matter, and the surface need not be
        closed.
    position, rotation, tilt, force, depth, shear
        See `Body`. Its reference point is the origin of `vertices`.
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
