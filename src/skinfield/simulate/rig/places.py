"""Where a rig presses: poses of the indenter on the patch, as the three positioners set them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import (
    Floats,
    InputError,
    Ints,
    as_floats,
    check_finite,
    check_range,
    check_shape,
)
from skinfield.layout import Patch

TRIES = 10_000
NEXT = 1.1  # pitches between taxels that are next to each other


@dataclass(frozen=True)
class Pose:
    """Of the indenter on the patch: x and y in the patch's plane, m, and angle about z, rad.

    As the layer is the same everywhere, a press there is one at the origin with the taxels moved
    the other way.
    """

    x: float
    y: float
    angle: float = 0.0

    def taxels(self, plane: ArrayLike) -> Floats:
        """Taxels at (L, 2) m of the patch's plane as the indenter sees them, (L, 2) m."""
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        turn = np.array([[cos, -sin], [sin, cos]])
        return np.asarray((as_floats("plane", plane) - [self.x, self.y]) @ turn)


class Places(Protocol):
    """Anything that chooses poses on a patch."""

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """Where to press, in order."""
        ...


@dataclass(frozen=True, kw_only=True)
class At:
    """Given places.

    Parameters
    ----------
    positions : tuple of (x, y), m
        In the patch's plane.
    angle : float, rad
    """

    positions: tuple[tuple[float, float], ...]
    angle: float = 0.0

    def __post_init__(self) -> None:
        values = as_floats("positions", self.positions)
        check_shape("positions", values, (None, 2), "x and y of each place, in metres")
        check_finite("positions", values, "x and y of each place, in metres")
        if not len(values):
            raise InputError("positions is empty, expected at least one place")

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`."""
        return [Pose(x, y, self.angle) for x, y in self.positions]


@dataclass(frozen=True, kw_only=True)
class OverTaxels:
    """Over the middle of taxels: given rows, or the one nearest to the patch's middle."""

    taxels: tuple[int, ...] = ()
    angle: float = 0.0

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`."""
        groups = np.array(self.taxels, np.int64)[:, None]
        return _over_groups(patch, groups, np.arange(len(patch))[:, None], self.angle)


@dataclass(frozen=True, kw_only=True)
class BetweenTwo:
    """Half-way between two taxels: given pairs, or the neighbours nearest to the middle."""

    pairs: tuple[tuple[int, int], ...] = ()
    angle: float = 0.0

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`."""
        return _over_groups(
            patch, np.array(self.pairs, np.int64).reshape(-1, 2), patch.neighbours, self.angle
        )


@dataclass(frozen=True, kw_only=True)
class BetweenThree:
    """Amid three taxels: given triples, or the triangle nearest to the patch's middle."""

    triples: tuple[tuple[int, int, int], ...] = ()
    angle: float = 0.0

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`."""
        groups = np.array(self.triples, np.int64).reshape(-1, 3)
        return _over_groups(patch, groups, patch.triangles, self.angle)


@dataclass(frozen=True, kw_only=True)
class Random:
    """Drawn evenly from where taxels are.

    Parameters
    ----------
    count : int
    within : float, m
        Of the centre of some taxel.
    turned : bool
        At random angles too.
    """

    count: int = 10
    within: float = 3e-3
    turned: bool = False

    def __post_init__(self) -> None:
        _check_count("count", self.count)
        check_range("within", self.within, 1e-9, 1.0, "of the centre of some taxel, in metres")

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`."""
        plane = patch.plane
        low, high = plane.min(axis=0) - self.within, plane.max(axis=0) + self.within
        found: list[Pose] = []
        for _ in range(TRIES * self.count):
            place, turn = rng.uniform(low, high), float(rng.uniform(-np.pi, np.pi))
            if np.hypot(*(plane - place).T).min() <= self.within:
                found.append(Pose(float(place[0]), float(place[1]), turn if self.turned else 0.0))
                if len(found) == self.count:
                    return found
        raise InputError(
            f"within is {self.within:g} m, expected a wider distance: {TRIES} draws per place "
            f"found {len(found)} of {self.count} that near to a taxel"
        )


@dataclass(frozen=True, kw_only=True)
class Raster:
    """A lattice of `rows` by `columns` over the patch's middle; `step` in m, and an `angle`."""

    rows: int = 3
    columns: int = 3
    step: float = 5e-3
    angle: float = 0.0

    def __post_init__(self) -> None:
        _check_count("rows", self.rows)
        _check_count("columns", self.columns)
        check_range("step", self.step, 1e-9, 1.0, "between places, in metres")

    def poses(self, patch: Patch, rng: np.random.Generator) -> list[Pose]:
        """See `Places.poses`; row by row, to and fro, as a positioner goes."""
        middle = patch.plane.mean(axis=0)
        across = (np.arange(self.columns) - (self.columns - 1) / 2) * self.step + middle[0]
        along = (np.arange(self.rows) - (self.rows - 1) / 2) * self.step + middle[1]
        return [
            Pose(float(x), float(y), self.angle)
            for row, y in enumerate(along)
            for x in (across if row % 2 == 0 else across[::-1])
        ]


def _check_count(name: str, value: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise InputError(f"{name} is {value!r}, expected a whole number from 1 to 10000")
    check_range(name, value, 1, 10_000, "a whole number")


def _over_groups(patch: Patch, given: Ints, all_: Sequence[int] | Ints, angle: float) -> list[Pose]:
    """Poses in the middle of groups (N, G) of taxels, or of the most central of all groups."""
    if not len(given):
        groups = np.asarray(all_)
        if not len(groups):
            raise InputError(
                f"patch {patch.name!r} has no such taxels next to each other, expected some: "
                "name them, or choose other places"
            )
        groups = _close(patch, groups)
        middles = patch.plane[groups].mean(axis=1)
        far = np.hypot(*(middles - patch.plane.mean(axis=0)).T)
        given = groups[[int(np.argmin(np.round(far, 9)))]]
    if (given < 0).any() or (given >= len(patch)).any():
        raise InputError(
            f"taxels holds {given.tolist()}, expected rows from 0 to {len(patch) - 1} of patch "
            f"{patch.name!r}"
        )
    return [Pose(float(x), float(y), angle) for x, y in patch.plane[given].mean(axis=1)]


def _close(patch: Patch, groups: Ints) -> Ints:
    """Groups (N, G) of which all are a pitch from each other; all groups, where there is none."""
    corners = patch.plane[groups]
    wide = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=-1).max(axis=(1, 2))
    close = wide <= NEXT * patch.pitch
    return groups[close] if close.any() else groups
