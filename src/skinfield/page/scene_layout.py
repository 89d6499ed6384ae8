"""Scene layout of the page: where the patches of all engines stand in its picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.page.source import DataSource
from skinfield.page.wire import packed
from skinfield.skin import Grid, Patch

APART = 0.25  # of the size of what stands before: between links, whose places are not known
FINE = 60  # nodes along the sides, to find a place on a curved patch


@dataclass(frozen=True, eq=False)
class PlacedPatch:
    """One patch in the picture.

    Attributes
    ----------
    source : DataSource
        Whose patch it is.
    place : int
        Among that source's patches.
    patch : Patch
    pose : (4, 4) array
        From the patch's frame to that of the picture.
    """

    source: DataSource
    place: int
    patch: Patch
    pose: Floats

    def in_scene(self, points: Floats) -> Floats:
        """Points (N, 3) of the patch's frame, in the picture."""
        return np.asarray(points @ self.pose[:3, :3].T + self.pose[:3, 3])

    def turned(self, vectors: Floats) -> Floats:
        """Directions (N, 3) of the patch's frame, in the picture."""
        return np.asarray(vectors @ self.pose[:3, :3].T)

    @cached_property
    def _fine(self) -> Grid:
        return Grid.square(self.patch, FINE)

    def plane_of(self, point: Floats) -> tuple[float, float]:
        """Place in the patch's plane, m, of a point of the picture on or near its surface.

        From the nearest node of a fine grid along its tangents: exact where the patch is flat,
        and off by the third power of half a cell over the square of the radius where it is curved.
        """
        own = (np.asarray(point) - self.pose[:3, 3]) @ self.pose[:3, :3]
        grid = self._fine
        node = int(((grid.positions - own) ** 2).sum(axis=1).argmin())
        along = (own - grid.positions[node]) @ grid.frames[node][:, :2]
        x, y = grid.plane[node] + along
        return float(x), float(y)

    def along_of(self, vector: Floats, x: float, y: float) -> tuple[float, float]:
        """Parts along the plane's x and y, at a place of it, of a vector (3,) of the picture."""
        frame = self.patch.surface.frame_from_plane(np.array([[x, y]]))[0]
        along, across = (vector @ self.pose[:3, :3]) @ frame[:, :2]
        return float(along), float(across)


class SceneLayout:
    """All patches of some sources, counted through.

    Patches of one link stand as they are on it. Links of which the page knows no more, and engines
    that are no neighbours, stand side by side.
    """

    def __init__(self, sources: Sequence[DataSource]) -> None:
        self.sources = tuple(sources)
        groups: dict[tuple[int, str], list[tuple[int, Patch]]] = {}
        for number, source in enumerate(sources):
            for place, patch in enumerate(source.skin):
                groups.setdefault((number, patch.link), []).append((place, patch))
        self.placed: list[PlacedPatch] = []
        edge = 0.0
        for (number, _), members in groups.items():
            poses = [(patch.positions, patch.link_from_patch) for _, patch in members]
            points = np.concatenate([at @ pose[:3, :3].T + pose[:3, 3] for at, pose in poses])
            low, high = points.min(axis=0), points.max(axis=0)
            size = float((high - low).max())
            shift = -(low + high) / 2.0
            shift[0] = edge - low[0]
            edge += float(high[0] - low[0]) + APART * size
            for place, patch in members:
                pose = np.array(patch.link_from_patch)
                pose[:3, 3] += shift
                self.placed.append(PlacedPatch(sources[number], place, patch, pose))
        order = {id(source): number for number, source in enumerate(sources)}
        self.placed.sort(key=lambda each: (order[id(each.source)], each.place))

    def __len__(self) -> int:
        return len(self.placed)

    def __getitem__(self, number: Any) -> PlacedPatch:
        if type(number) is not int or not 0 <= number < len(self):
            raise InputError(f"patch is {number!r}, expected 0 to {len(self) - 1}")
        return self.placed[number]

    @property
    def name(self) -> str:
        """Of all of it, for people."""
        if len(self.sources) > 1:
            return f"{len(self.sources)} skins"
        return self.sources[0].skin.name if self.sources else ""

    @cached_property
    def size(self) -> float:
        """Diagonal of everything, m."""
        if not self.placed:
            return 0.0
        points = np.concatenate([each.in_scene(each.patch.positions) for each in self.placed])
        return float(np.linalg.norm(np.ptp(points, axis=0)))

    def describe(self) -> list[dict[str, Any]]:
        """The patches, for the page; of several engines with the engines' names."""
        several = len(self.sources) > 1
        return [
            {
                "i": number,
                "name": f"{each.source.name}/{each.patch.name}" if several else each.patch.name,
                "engine": each.source.name,
                "link": each.patch.link,
                "taxels": len(each.patch),
                "flat": bool(each.patch.surface.is_flat),
                "side": float(np.ptp(each.patch.plane, axis=0).max()),
                "pitch": float(each.patch.pitch),
            }
            for number, each in enumerate(self.placed)
        ]

    def geometry(self, number: int, rung: int, first: bool) -> bytes:
        """Message with the nodes of a patch's grid, and with its taxels where it is the first."""
        each = self[number]
        grid = Grid.square(each.patch, rung)
        arrays = [
            ("positions", each.in_scene(grid.positions).astype("<f4").ravel()),
            ("normals", each.turned(grid.normals).astype("<f4").ravel()),
            ("plane", grid.plane.astype("<f4").ravel()),
            ("covered", grid.covered.astype("<u1")),
        ]
        if first:
            arrays += [
                ("taxels", each.in_scene(each.patch.positions).astype("<f4").ravel()),
                ("taxel_normals", each.turned(each.patch.normals).astype("<f4").ravel()),
            ]
        rows, columns = grid.shape
        head = {"kind": "geometry", "patch": number, "rung": rung, "rows": rows}
        return packed({**head, "columns": columns}, arrays)
