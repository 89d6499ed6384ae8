"""Truth and estimate on one lattice, so that they can be compared: force is conserved."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from skinfield.errors import Floats
from skinfield.layout import Grid

STEP = 0.5e-3  # m: side of the lattice's cells
BLUR = 2e-3  # m: standard deviation of the Gaussian, below which taxels see next to nothing
FINE = 6  # parts of a step: wider ones beat against the lattice, by 6 % where they are halves
MARGIN = 3  # standard deviations around what is compared


@dataclass(frozen=True)
class Lattice:
    """Regular points of the plane, at whole multiples of `step`.

    Parameters
    ----------
    first : (column, row)
        Of the first point, in steps from the plane's origin.
    shape : (rows, columns)
    step : float, m
    """

    first: tuple[int, int]
    shape: tuple[int, int]
    step: float = STEP

    @classmethod
    def around(cls, low: Floats, high: Floats, step: float = STEP) -> "Lattice":
        """Lattice over the rectangle from `low` to `high` (2,) m and a margin for the blur."""
        margin = MARGIN * BLUR + 2 * step
        start = np.floor((low - margin) / step).astype(int)
        stop = np.ceil((high + margin) / step).astype(int)
        columns, rows = (stop - start + 1).tolist()
        return cls((int(start[0]), int(start[1])), (rows, columns), step)

    def deposit(self, plane: Floats, values: Floats, cell: float) -> Floats:
        """Pressure (rows, columns) Pa of cells at (K, 2) m with `values` (K,) Pa.

        Each cell is split into squares of a sixth of a step at most; the force of each is shared
        among the four points around it in bilinear proportion. Force and first moment stay.
        """
        parts = _parts(cell, self.step)
        offsets = (np.arange(parts) - (parts - 1) / 2) * (cell / parts)
        force = values * (cell / self.step / parts) ** 2
        total = np.zeros(self.shape)
        for right in offsets:
            for up in offsets:
                total += self._shared(plane + np.array([right, up]), force)
        return total

    def _shared(self, points: Floats, force: Floats) -> Floats:
        rows, columns = self.shape
        place = points / self.step - self.first
        whole = np.floor(place).astype(np.int64)
        x, y = (place - whole).T
        corner = whole[:, 1] * columns + whole[:, 0]
        total = np.zeros(rows * columns)
        for shift, weight in (
            (0, (1 - x) * (1 - y)),
            (1, x * (1 - y)),
            (columns, (1 - x) * y),
            (columns + 1, x * y),
        ):
            total += np.bincount(corner + shift, weight * force, rows * columns)
        return total.reshape(rows, columns)

    def blurred(self, values: Floats) -> Floats:
        """Values (..., rows, columns) after a Gaussian of standard deviation `BLUR`."""
        rows, columns = self.shape
        return np.asarray(_gaussian(rows, self.step) @ values @ _gaussian(columns, self.step))


@dataclass(frozen=True)
class Spread:
    """The pressure of a grid's cells on a lattice, as `Lattice.deposit` has it, by two matrices."""

    lattice: Lattice
    shape: tuple[int, int]
    pitch: float
    origin: tuple[float, float]

    @classmethod
    def of(cls, grid: Grid, lattice: Lattice) -> "Spread":
        """Of a grid of an estimate."""
        x, y = (float(value) for value in grid.origin)
        return _kept(cls(lattice, grid.shape, grid.pitch, (x, y)))

    @cached_property
    def sides(self) -> tuple[Floats, Floats]:
        """Matrices along y (rows, grid rows) and x (columns, grid columns)."""
        lattice = self.lattice
        return (
            _along(self.origin[1], self.shape[0], self.pitch, lattice, 1),
            _along(self.origin[0], self.shape[1], self.pitch, lattice, 0),
        )

    @cached_property
    def blurred_sides(self) -> tuple[Floats, Floats]:
        """The same, with the blur in them."""
        step = self.lattice.step
        along_y, along_x = self.sides
        return _gaussian(len(along_y), step) @ along_y, _gaussian(len(along_x), step) @ along_x

    def __call__(self, pressure: Floats, blur: bool = False) -> Floats:
        """Pressure (K,) Pa of the grid's cells on the lattice, (rows, columns) Pa."""
        along_y, along_x = self.blurred_sides if blur else self.sides
        return np.asarray(along_y @ pressure.reshape(self.shape) @ along_x.T)


@lru_cache(maxsize=64)
def _kept(spread: Spread) -> Spread:
    """One object for equal spreads: its matrices are made once."""
    return spread


def _parts(cell: float, step: float) -> int:
    return max(int(np.ceil(FINE * cell / step - 1e-9)), 1)


def _along(origin: float, count: int, pitch: float, lattice: Lattice, axis: int) -> Floats:
    """Shares (lattice points, cells) of each cell's pressure along one axis."""
    parts = _parts(pitch, lattice.step)
    offsets = (np.arange(parts) - (parts - 1) / 2) * (pitch / parts)
    place = (origin + np.arange(count)[:, None] * pitch + offsets) / lattice.step
    points = np.arange(lattice.shape[1 - axis]) + lattice.first[axis]
    near = np.maximum(1 - np.abs(points[:, None, None] - place[None]), 0.0)
    return np.asarray(near.sum(axis=2) * (pitch / lattice.step / parts))


@lru_cache(maxsize=64)
def _gaussian(count: int, step: float) -> Floats:
    """Matrix (count, count) of a Gaussian whose rows sum to 1 away from the ends."""
    apart = (np.arange(count)[:, None] - np.arange(count)) * step / BLUR
    near = np.exp(-(apart**2) / 2)
    near[np.abs(apart) > 2 * MARGIN] = 0.0
    whole = np.exp(-((np.arange(-50, 51) * step / BLUR) ** 2) / 2).sum()
    return np.asarray(near / whole)
