"""The nodes where the answer lives."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_positive, check_shape
from skinfield.layout.patch import Patch


@dataclass(frozen=True, eq=False)
class Grid:
    """Square cells on a patch: K = rows x columns nodes, each the centre of one cell.

    Node k = row * columns + column lies at `origin` + (column, row) * `pitch` in the patch's
    developed plane, so `values.reshape(grid.shape)` is a picture with y upwards.

    Parameters
    ----------
    patch : Patch
        Whose surface carries the nodes.
    shape : (rows, columns)
        Number of nodes along the plane's second and first axis.
    pitch : float, m
        Side of a cell.
    origin : (2,) array, m
        Node 0 in the patch's plane.
    """

    patch: Patch
    shape: tuple[int, int]
    pitch: float
    origin: Floats = field(default_factory=lambda: np.zeros(2))

    def __post_init__(self) -> None:
        rows, columns = self.shape
        if not (rows >= 1 and columns >= 1):
            raise InputError(f"shape is {self.shape!r}, expected at least one row and one column")
        check_positive("pitch", self.pitch, "the side of a cell, in metres")
        origin = as_floats("origin", self.origin)
        check_shape("origin", origin, (2,), "x and y of node 0 in the patch's plane")
        object.__setattr__(self, "origin", origin)
        object.__setattr__(self, "shape", (int(rows), int(columns)))

    @classmethod
    def square(cls, patch: Patch, nodes: int = 40) -> "Grid":
        """`nodes` x `nodes` over the patch's bounding square, first and last node on its sides."""
        if nodes < 2:
            raise InputError(f"nodes is {nodes!r}, expected 2 or more: nodes lie on the border")
        low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
        side = max(float((high - low).max()), patch.pad_diameter)
        return cls(patch, (nodes, nodes), side / (nodes - 1), (low + high - side) / 2)

    @classmethod
    def window(cls, patch: Patch, low: ArrayLike, high: ArrayLike, pitch: float) -> "Grid":
        """Nodes of the given pitch that fill the rectangle `low` .. `high` (2,) m of the plane."""
        low, high = as_floats("low", low), as_floats("high", high)
        check_shape("low", low, (2,), "a corner in the patch's plane")
        check_shape("high", high, (2,), "a corner in the patch's plane")
        check_positive("pitch", pitch, "the side of a cell, in metres")
        if not (high > low).all():
            raise InputError(f"high is {high}, expected above low = {low} in both coordinates")
        count = np.maximum(np.round((high - low) / pitch).astype(int), 1)
        origin = (low + high) / 2 - (count - 1) * pitch / 2
        return cls(patch, (int(count[1]), int(count[0])), pitch, origin)

    def __len__(self) -> int:
        return self.shape[0] * self.shape[1]

    @property
    def cell_area(self) -> float:
        """Area of one cell, m²; the same for all."""
        return self.pitch**2

    @cached_property
    def plane(self) -> Floats:
        """Nodes in the patch's developed plane, (K, 2) m."""
        rows, columns = np.divmod(np.arange(len(self)), self.shape[1])
        return self.origin + np.column_stack([columns, rows]) * self.pitch

    @cached_property
    def positions(self) -> Floats:
        """Nodes in the patch's frame, (K, 3) m."""
        return self.patch.surface.position_from_plane(self.plane)

    @cached_property
    def frames(self) -> Floats:
        """Local frames of the nodes, (K, 3, 3): columns are two tangents and the outward normal."""
        return self.patch.surface.frame_from_plane(self.plane)

    @property
    def normals(self) -> Floats:
        """Outward normals at the nodes, (K, 3)."""
        return self.frames[:, :, 2]

    @cached_property
    def covered(self) -> NDArray[np.bool_]:
        """Nodes inside the convex hull of the taxels, (K,); outside, nothing is measured."""
        from skinfield.layout.hull import inside_hull

        return inside_hull(self.patch.plane, self.plane)
