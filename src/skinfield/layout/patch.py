"""The taxels under one sheet of elastomer."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_finite, check_shape
from skinfield.layout.surface import Surface, surface_through

Ints = NDArray[np.int64]


def _column(values: ArrayLike | None, default: NDArray, dtype: type) -> NDArray:  # type: ignore[type-arg]
    return default if values is None else np.asarray(values, dtype=dtype)


@dataclass(frozen=True, eq=False)
class Patch:
    """The taxels under one elastomer sheet, reconstructed independently. A taxel is a row.

    Parameters
    ----------
    positions : (L, 3) or (L, 2) array, m
        Centres of the pads, in the patch's own frame; a third column of zeros is added to (L, 2).
    pad_diameter : float, m
        Of the round electrode of one taxel.
    normals : (L, 3) array, optional
        Outward, from the robot to whatever touches it; made unit length. Default +z.
    module : (L,) int array, optional
        Index of the board that carries the taxel. Default 0.
    uid : (L,) uint64 array, optional
        Identity of the taxel in its maker's numbering. Default the row.
    channel : (L,) int array, optional
        Column of the taxel in the readings of its port. Default the row.
    n_channels : int, optional
        Columns of the port, thermal and absent ones included. Default the largest channel + 1.
    name, link : str
        Of the patch, and of the robot's link that carries it.
    link_from_patch : (4, 4) array, optional
        Homogeneous pose of the patch in its link, m. Default the identity.
    """

    positions: Floats
    pad_diameter: float = 4e-3
    normals: Floats = field(default=None, kw_only=True)  # type: ignore[arg-type]
    module: Ints = field(default=None, kw_only=True)  # type: ignore[arg-type]
    uid: NDArray[np.uint64] = field(default=None, kw_only=True)  # type: ignore[arg-type]
    channel: Ints = field(default=None, kw_only=True)  # type: ignore[arg-type]
    n_channels: int = field(default=0, kw_only=True)
    name: str = field(default="patch", kw_only=True)
    link: str = field(default="", kw_only=True)
    link_from_patch: Floats = field(default=None, kw_only=True)  # type: ignore[arg-type]

    def __post_init__(self) -> None:
        positions = as_floats("positions", self.positions)
        if positions.ndim != 2 or positions.shape[1] not in (2, 3) or len(positions) == 0:
            raise InputError(
                f"positions has shape {positions.shape}, expected (taxels, 2) or (taxels, 3) "
                "with at least one taxel: one row of metres per taxel"
            )
        if positions.shape[1] == 2:
            positions = np.column_stack([positions, np.zeros(len(positions))])
        check_finite("positions", positions, "an absent taxel is left out, not marked by NaN")
        taxels = len(positions)
        rows = np.arange(taxels)
        up = np.broadcast_to([0.0, 0.0, 1.0], (taxels, 3))
        columns = {
            "positions": positions,
            "normals": _column(self.normals, up, np.float64),
            "module": _column(self.module, np.zeros(taxels, np.int64), np.int64),
            "uid": _column(self.uid, rows.astype(np.uint64), np.uint64),
            "channel": _column(self.channel, rows, np.int64),
            "link_from_patch": _column(self.link_from_patch, np.eye(4), np.float64),
        }
        for name in ("module", "uid", "channel"):
            check_shape(name, columns[name], (taxels,), "one per row of positions")
        check_shape("normals", columns["normals"], (taxels, 3), "one per row of positions")
        check_shape("link_from_patch", columns["link_from_patch"], (4, 4), "a homogeneous pose")
        length = np.linalg.norm(columns["normals"], axis=1, keepdims=True)
        if not (np.isfinite(length).all() and (length > 1e-9).all()):
            row = int(np.argmin(np.where(np.isfinite(length), length, -1.0)))
            raise InputError(
                f"normals[{row}] is {columns['normals'][row]}, expected a vector that points "
                "out of the skin: leave normals out to have them taken as +z"
            )
        columns["normals"] = columns["normals"] / length
        if not 0.0 < self.pad_diameter < 1.0:
            raise InputError(
                f"pad_diameter is {self.pad_diameter!r} m, expected a length above 0 and below 1: "
                "give it in metres, 4 mm is 4e-3"
            )
        highest = int(columns["channel"].max()) + 1
        if self.n_channels and self.n_channels < highest:
            raise InputError(
                f"n_channels is {self.n_channels}, expected at least {highest}: "
                "every channel must be a column of the port"
            )
        for name, value in columns.items():
            value = np.ascontiguousarray(value)
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        object.__setattr__(self, "n_channels", self.n_channels or highest)

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        width, height = (self.plane.max(axis=0) - self.plane.min(axis=0)) * 1e3
        return (
            f"Patch({self.name!r}, {len(self)} taxels, {len(np.unique(self.module))} modules, "
            f"{width:.1f} x {height:.1f} mm, {'flat' if self.surface.is_flat else 'curved'})"
        )

    @cached_property
    def surface(self) -> Surface:
        """The developed surface through the taxels: a plane of metres and the way back to 3D."""
        return surface_through(self.positions, self.normals)

    @property
    def plane(self) -> Floats:
        """Taxel centres in the patch's own plane, (L, 2) m."""
        return self.surface.plane

    @cached_property
    def pitch(self) -> float:
        """Median distance from a taxel to its nearest neighbour, m; the pad's diameter if alone."""
        from scipy.spatial import cKDTree

        distinct = np.unique(self.plane.round(9), axis=0)
        if len(distinct) < 2:
            return self.pad_diameter
        distance = np.asarray(cKDTree(distinct).query(distinct, k=2)[0])
        return float(np.median(distance[:, 1]))

    @cached_property
    def triangles(self) -> Ints:
        """Delaunay triangulation of the taxels in the patch's plane, (T, 3) rows of taxels."""
        from scipy.spatial import Delaunay

        distinct, first = np.unique(self.plane.round(9), axis=0, return_index=True)
        if len(distinct) < 3 or np.linalg.matrix_rank(distinct - distinct[0], tol=1e-9) < 2:
            return np.empty((0, 3), np.int64)
        return np.asarray(first[Delaunay(distinct).simplices], dtype=np.int64)

    @cached_property
    def neighbours(self) -> Ints:
        """Pairs (P, 2), rows of taxels joined by an edge of `triangles` of at most 2 pitches."""
        sides = self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        sides = np.unique(np.sort(sides, axis=1), axis=0)
        length = np.linalg.norm(np.diff(self.plane[sides], axis=1)[:, 0], axis=1)
        return np.asarray(sides[length <= 2.0 * self.pitch])

    def subset(self, rows: NDArray[np.bool_] | Ints) -> "Patch":
        """Patch of the chosen taxels (bool mask or rows); channels and uids stay theirs."""
        return replace(
            self,
            positions=self.positions[rows],
            normals=self.normals[rows],
            module=self.module[rows],
            uid=self.uid[rows],
            channel=self.channel[rows],
        )
