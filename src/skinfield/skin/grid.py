"""The nodes where the answer lives."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import index
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_positive,
    check_shape,
)
from skinfield.plot import number
from skinfield.skin.patch import Patch

SAME = 1e-6  # of the pitch: nodes on two patches of one surface
COVER = 2.5  # pitches from the nearest taxel up to which a node counts as measured


@dataclass(frozen=True, eq=False, repr=False)
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
    height : float, m
        Of the nodes above the pads: on curved skin the outer surface, where pressure acts, is
        elsewhere than the pads, and larger.
    spread : float
        Area at that height over that of the pads' own surface.
    """

    patch: Patch
    shape: tuple[int, int]
    pitch: float
    origin: Floats = field(default_factory=lambda: np.zeros(2))
    height: float = 0.0
    spread: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", _shape(self.shape))
        check_positive("pitch", self.pitch, "the side of a cell, in metres")
        origin = np.array(_corner("origin", self.origin))
        origin.setflags(write=False)
        object.__setattr__(self, "origin", origin)

    @classmethod
    def square(cls, patch: Patch, nodes: int = 40) -> "Grid":
        """`nodes` x `nodes` over the patch's bounding square, first and last node on its sides.

        The square has the longer side of the taxels' bounding box and the same middle. Where the
        plane had to be cut, as that of a sleeve, it is wider by a pitch of the taxels, so that the
        seam is covered.
        """
        nodes, _ = _shape((nodes, nodes))
        if nodes < 2:
            raise InputError(f"nodes is {nodes!r}, expected 2 or more: nodes lie on the border")
        low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
        side = max(float((high - low).max()), patch.pad_diameter)
        side += patch.pitch if patch.surface.severed else 0.0
        return cls(patch, (nodes, nodes), side / (nodes - 1), (low + high - side) / 2)

    @classmethod
    def window(cls, patch: Patch, low: ArrayLike, high: ArrayLike, pitch: float) -> "Grid":
        """Cells of side `pitch` m that fill the rectangle `low` .. `high` (2,) m of the plane.

        Their number is rounded, and they share the rectangle's middle.
        """
        low, high = _corner("low", low), _corner("high", high)
        check_positive("pitch", pitch, "the side of a cell, in metres")
        if not (high > low).all():
            raise InputError(f"high is {high}, expected above low = {low} in both coordinates")
        count = np.maximum(np.round((high - low) / pitch).astype(int), 1)
        origin = (low + high) / 2 - (count - 1) * pitch / 2
        return cls(patch, (int(count[1]), int(count[0])), pitch, origin)

    def on(self, patch: Patch) -> "Grid":
        """Grid whose nodes stand at the same places on another patch of the same surface.

        Raises
        ------
        InputError
            If the other patch has another surface, so that the nodes would stand elsewhere.
        """
        if patch is self.patch:
            return self
        moved = replace(self, patch=patch)
        apart = float(np.abs(moved.positions - self.positions).max())
        if apart > SAME * self.pitch:
            raise InputError(
                f"grid lies on patch {self.patch.name!r}, whose surface is up to "
                f"{apart * 1e3:.3g} mm from that of {patch.name!r}, expected the same surface: "
                "make the grid from the patch that is reconstructed"
            )
        return moved

    def __repr__(self) -> str:
        rows, columns = self.shape
        pitch = number(self.pitch * 1e3)
        return f"Grid({self.patch.name!r}, {columns} x {rows} nodes, pitch {pitch} mm)"

    def __getstate__(self) -> dict[str, Any]:
        """Fields, for copies and pickles: what is worked out from them stays behind."""
        return {name: vars(self)[name] for name in self.__dataclass_fields__}

    def __setstate__(self, state: dict[str, Any]) -> None:
        state["origin"].setflags(write=False)
        vars(self).update(state)

    def __len__(self) -> int:
        return self.shape[0] * self.shape[1]

    @property
    def cell_area(self) -> float:
        """Area of one cell at the nodes' height, m²; the same for all."""
        return self.pitch**2 * self.spread

    @cached_property
    def plane(self) -> Floats:
        """Nodes in the patch's developed plane, (K, 2) m."""
        rows, columns = np.divmod(np.arange(len(self)), self.shape[1])
        return _read_only(self.origin + np.column_stack([columns, rows]) * self.pitch)

    @cached_property
    def positions(self) -> Floats:
        """Nodes in the patch's frame, (K, 3) m."""
        pads = self.patch.surface.position_from_plane(self.plane)
        return _read_only(pads + self.height * self.normals if self.height else pads)

    @cached_property
    def frames(self) -> Floats:
        """Local frames of the nodes, (K, 3, 3): columns are two tangents and the outward normal."""
        return _read_only(self.patch.surface.frame_from_plane(self.plane))

    @property
    def normals(self) -> Floats:
        """Outward normals at the nodes, (K, 3)."""
        return self.frames[:, :, 2]

    @cached_property
    def covered(self) -> NDArray[np.bool_]:
        """Nodes where something is measured, (K,).

        They lie inside the convex hull of the taxels and no more than 2.5 taxel pitches from one:
        the holes and bays of a real skin, and the gaps between its parts, are not covered.
        """
        from scipy.spatial import cKDTree

        from skinfield.skin.geometry import inside_hull

        taxels = self.patch.plane
        near = np.asarray(cKDTree(taxels).query(self.plane)[0]) <= COVER * self.patch.pitch
        own = self.patch.surface.held(self.plane, self.pitch) > 0.5  # once, across a seam
        return inside_hull(taxels, self.plane) & near & own


def _read_only(array: Floats) -> Floats:
    if array.flags.writeable:
        array.setflags(write=False)
    return array


def _corner(name: str, values: ArrayLike) -> Floats:
    corner = as_floats(name, values)
    check_shape(name, corner, (2,), "x and y in the patch's plane, in metres")
    check_finite(name, corner, "x and y in the patch's plane, in metres")
    return corner


def _shape(shape: tuple[int, int]) -> tuple[int, int]:
    try:
        rows, columns = (index(n) for n in shape)
    except (TypeError, ValueError):
        raise InputError(f"shape is {shape!r}, expected (rows, columns), whole numbers") from None
    if rows < 1 or columns < 1:
        raise InputError(f"shape is {shape!r}, expected at least one row and one column")
    return rows, columns
