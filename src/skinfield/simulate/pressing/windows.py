"""Windows of finer squares where bodies touch, and the displacements that loads on them cause."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import LatticeConvolution, Layer, Mechanics
from skinfield.elastic.contact import rim
from skinfield.elastic.lattice import (
    cached_indentation_kernel,
    cached_surface_kernel,
    interpolation,
)
from skinfield.errors import Floats
from skinfield.skin import Grid

ACROSS = 48  # squares across a contact
FINEST = 81  # squares along a cell
MOST = 100_000  # squares of all windows
APART = 4  # cells between windows: nearer ones are one


@dataclass(frozen=True)
class Window:
    """A rectangle of the grid's cells, each cut into split x split squares.

    Attributes
    ----------
    row, column : int
        Its first cell.
    rows, columns : int
        Cells along y and x.
    split : int
        Odd, so that the middle square of a cell has the cell's centre.
    """

    row: int
    column: int
    rows: int
    columns: int
    split: int = 1

    @property
    def shape(self) -> tuple[int, int]:
        """Squares along y and x."""
        return self.rows * self.split, self.columns * self.split

    @property
    def size(self) -> int:
        """Number of squares."""
        return self.shape[0] * self.shape[1]

    @property
    def end(self) -> tuple[int, int]:
        """Row and column behind its last cell."""
        return self.row + self.rows, self.column + self.columns

    @property
    def cells(self) -> tuple[slice, slice]:
        """Its cells in a picture (rows, columns) of the grid."""
        return slice(self.row, self.end[0]), slice(self.column, self.end[1])

    def steps(self) -> tuple[Floats, Floats]:
        """Centres of the squares along y and x, in cells from the grid's first node."""
        inside = [(np.arange(n) + 0.5) / self.split - 0.5 for n in self.shape]
        return inside[0] + self.row, inside[1] + self.column

    def means(self, values: Floats) -> Floats:
        """Mean over each cell, (..., rows, columns), of values on the squares."""
        return coarsened(values, self.split)

    def centres(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values on the squares in the middle of each cell, (..., rows, columns)."""
        middle, every = self.split // 2, self.split
        return values[..., middle::every, middle::every]

    def grown(self, margin: int, shape: tuple[int, int] | None = None) -> "Window":
        """With so many cells more on every side, as far as a grid of `shape` goes, if any."""
        low, high = np.array([self.row, self.column]) - margin, np.array(self.end) + margin
        if shape is not None:
            low, high = np.maximum(low, 0), np.minimum(high, shape)
        (row, column), (rows, columns) = low.tolist(), (high - low).tolist()
        return Window(row, column, rows, columns, self.split)

    def embedded(self, values: Floats, larger: "Window") -> Floats:
        """Values on the squares of a larger window of the same split, 0 beyond."""
        out = np.zeros((*values.shape[:-2], *larger.shape))
        top = (self.row - larger.row) * self.split
        left = (self.column - larger.column) * self.split
        out[..., top : top + self.shape[0], left : left + self.shape[1]] = values
        return out


def coarsened(values: Floats, factor: int) -> Floats:
    """Mean over blocks of factor x factor of the last two axes."""
    rows, columns = (n // factor for n in values.shape[-2:])
    blocks = values.reshape(*values.shape[:-2], rows, factor, columns, factor)
    return np.asarray(blocks.mean(axis=(-3, -1)))


def resplit(values: Floats, split: int, wanted: int) -> Floats:
    """Loads per area on squares of another split; both are powers of 3."""
    if split >= wanted:
        return coarsened(values, split // wanted)
    factor = wanted // split
    return np.repeat(np.repeat(values, factor, axis=-2), factor, axis=-1)


def touched(window: Window, mask: NDArray[np.bool_]) -> Window | None:
    """Smallest window of cells around a mask of squares; None around none."""
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) // window.split for axis in (1, 0))
    if not len(rows):
        return None
    top, left = int(rows[0]), int(columns[0])
    high, wide = int(rows[-1]) - top + 1, int(columns[-1]) - left + 1
    return Window(window.row + top, window.column + left, high, wide)


def width(mask: NDArray[np.bool_], coverage: Floats) -> float:
    """What a contact measures across, in squares: less than its extent if it is long or hollow.

    Eight times its area over the length of its border, which is twice the diameter of a disc, four
    times the width of a bar and of a ring.
    """
    extent = max(int(mask.any(axis=axis).sum()) for axis in (0, 1))
    area, border = float(coverage[mask].sum()), float(rim(mask).sum())
    return min(float(extent), max(8.0 * area / border, 0.1))


def merged(found: list[tuple[Window, float]]) -> list[tuple[Window, float]]:
    """Join windows that are less than `APART` cells from each other; the smaller width counts."""
    for (index, (one, width)), (other_index, (other, narrower)) in combinations(
        enumerate(found), 2
    ):
        first = np.minimum([one.row, one.column], [other.row, other.column])
        last = np.maximum(one.end, other.end)
        size = np.array([one.rows + other.rows, one.columns + other.columns])
        if (last - first - size).max() < APART:
            joined = Window(*first.tolist(), *(last - first).tolist())
            rest = [*found[:index], (joined, min(width, narrower)), *found[index + 1 :]]
            del rest[other_index]
            return merged(rest)
    return found


def cut(found: list[tuple[Window, float]]) -> list[Window]:
    """Split windows for `ACROSS` squares over each width, in cells, but `MOST` squares in all."""
    splits = []
    for _, width in found:
        split = 1
        while split * width < ACROSS and split < FINEST:
            split *= 3
        splits.append(split)
    cells = [window.rows * window.columns for window, _ in found]
    while True:
        sizes = [c * s**2 for c, s in zip(cells, splits, strict=True)]
        largest = int(np.argmax(sizes))
        if sum(sizes) <= MOST or splits[largest] == 1:
            break
        splits[largest] //= 3
    return [replace(window, split=s) for (window, _), s in zip(found, splits, strict=True)]


PAD = 3  # nodes around the grid, so that every cell has a full stencil of interpolation
POINT = 9  # a load far away is one on a square of a ninth of a cell


@dataclass(frozen=True, eq=False)
class Medium:
    """The grid on a medium, with responses between its cells and between windows.

    Within a window responses are exact for uniform squares. Between windows, and from a window to
    the grid's cells far from it, loads are carried to the cells' centres with all moments up to
    the fifth, convolved there, and interpolated likewise (Brandt and Lubrecht 1990).
    """

    grid: Grid
    layer: Layer
    mechanics: Mechanics

    @property
    def whole(self) -> Window:
        """All cells, uncut."""
        return Window(0, 0, *self.grid.shape)

    def axes(self, window: Window) -> tuple[Floats, Floats]:
        """Centres of a window's squares along y and x, m."""
        along, across = window.steps()
        pitch, origin = self.grid.pitch, self.grid.origin
        return origin[1] + along * pitch, origin[0] + across * pitch

    def side(self, window: Window) -> float:
        """Of the squares of a window, m."""
        return self.grid.pitch / window.split

    def near_kernel(self, window: Window) -> Floats:
        """Kernel of indentation per pressure on a window's squares."""
        return self._within(cached_indentation_kernel, window)

    def near_surface(self, window: Window) -> Floats:
        """Kernel (3, 3, ...) of displacement per traction on a window's squares."""
        return self._within(cached_surface_kernel, window)

    def _within(self, kernel: Callable[..., Floats], window: Window) -> Floats:
        side, (rows, columns) = self.side(window), window.shape
        return kernel(self.mechanics, self.layer, side, side, rows - 1, columns - 1)

    @cached_property
    def far_kernel(self) -> Floats:
        """Indentation at the padded grid's nodes per force at them, m/N."""
        return self._at_nodes(cached_indentation_kernel)

    @cached_property
    def far(self) -> LatticeConvolution:
        """Force at the padded grid's nodes, N, to indentation at them."""
        return LatticeConvolution(self.far_kernel)

    @cached_property
    def far_surface(self) -> Floats:
        """Kernel (3, 3, ...) of displacement per force at the padded grid's nodes."""
        return self._at_nodes(cached_surface_kernel)

    def _at_nodes(self, kernel: Callable[..., Floats]) -> Floats:
        pitch, (rows, columns) = self.grid.pitch, (n + 2 * PAD - 1 for n in self.grid.shape)
        point = pitch / POINT
        return kernel(self.mechanics, self.layer, point, pitch, rows, columns) / point**2

    def nodes(self, window: Window) -> tuple[slice, slice]:
        """The padded grid's nodes that a window's stencils use."""
        return (
            slice(window.row, window.row + window.rows + 2 * PAD),
            slice(window.column, window.column + window.columns + 2 * PAD),
        )

    def stencils(self, window: Window) -> tuple[Floats, Floats]:
        """Weights of those nodes for a window's squares, along y and x."""
        along, across = window.steps()
        return (
            interpolation(along - window.row + PAD, window.rows + 2 * PAD),
            interpolation(across - window.column + PAD, window.columns + 2 * PAD),
        )

    def carried(self, window: Window, loads: Floats) -> Floats:
        """Forces at the padded grid's nodes, N, that act as loads per area on the squares do."""
        along, across = self.stencils(window)
        out = np.zeros([n + 2 * PAD for n in self.grid.shape])
        out[self.nodes(window)] = along.T @ (loads * self.side(window) ** 2) @ across
        return out


TANGENTIAL = slice(2), slice(2)
LIFTED = slice(2, 3), slice(2)  # displacement along z by tangential traction
DRAGGED = slice(2), slice(2, 3)  # and along the plane by normal traction


class Yielding:
    """From loads per area on the squares of several windows, one after the other, to displacement.

    Pressure (1, N) Pa gives indentation (1, N) m; or, with `along`, traction (J, N) displacement
    (I, N) along those axes. What loads in each window do in all others is that of all at the nodes,
    less their own.

    Parameters
    ----------
    skin : Medium
    windows : list of Window
    along : pair of slices, optional
        Axes of displacement and of traction: I and J of x, y and z, such as `TANGENTIAL`.

    Attributes
    ----------
    own : (N,) array, m/Pa
        Displacement of each square along its own load.
    """

    def __init__(
        self, skin: Medium, windows: list[Window], along: tuple[slice, slice] | None = None
    ) -> None:
        self.skin, self.windows = skin, windows
        kernel_of = skin.near_kernel if along is None else skin.near_surface
        part = (None, None) if along is None else along
        near = [kernel_of(window)[part] for window in windows]
        self.near = [LatticeConvolution(kernel) for kernel in near]
        self.own = np.concatenate(
            [
                np.full(window.size, _middle(kernel, 1, 1)[0, 0])
                for window, kernel in zip(windows, near, strict=True)
            ]
        )
        ends = np.cumsum([0, *(window.size for window in windows)])
        self.parts = [slice(int(a), int(b)) for a, b in pairwise(ends)]
        self.far: list[tuple[LatticeConvolution, Floats, Floats]] = []
        if len(windows) > 1:
            kernel = (skin.far_kernel if along is None else skin.far_surface)[part]
            self.whole = LatticeConvolution(kernel)
            sizes = [(window.rows + 2 * PAD, window.columns + 2 * PAD) for window in windows]
            self.far = [
                (LatticeConvolution(_middle(kernel, *size)), *skin.stencils(window))
                for window, size in zip(windows, sizes, strict=True)
            ]

    def __call__(self, loads: Floats) -> Floats:
        """Displacement (I, N) m of loads (J, N) Pa."""
        pictures = self.pictures(loads)
        moved = [near(each, total=True) for near, each in zip(self.near, pictures, strict=True)]
        if self.far:
            moved = [a + b for a, b in zip(moved, self._by_others(pictures), strict=True)]
        return np.concatenate([each.reshape(len(each), -1) for each in moved], axis=1)

    def _by_others(self, pictures: list[Floats]) -> list[Floats]:
        """Displacement (I, rows, columns) m in each window by the loads in the others."""
        total = np.zeros((len(pictures[0]), *(n + 2 * PAD for n in self.skin.grid.shape)))
        forces = []
        for window, picture, (_, along, across) in zip(
            self.windows, pictures, self.far, strict=True
        ):
            forces.append(along.T @ (picture * self.skin.side(window) ** 2) @ across)
            total[:, *self.skin.nodes(window)] += forces[-1]
        every = self.whole(total, total=True)
        return [
            along @ (every[:, *self.skin.nodes(window)] - own(force, total=True)) @ across.T
            for window, force, (own, along, across) in zip(
                self.windows, forces, self.far, strict=True
            )
        ]

    def pictures(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        """Of values (..., N) those of each window, (..., rows, columns)."""
        return [
            values[..., part].reshape(*values.shape[:-1], *window.shape)
            for part, window in zip(self.parts, self.windows, strict=True)
        ]


def _middle(kernel: Floats, rows: int, columns: int) -> Floats:
    """Part of a kernel (..., 2 n - 1, 2 m - 1) for a lattice of fewer rows and columns."""
    row, column = (n // 2 for n in kernel.shape[-2:])
    return kernel[..., row - rows + 1 : row + rows, column - columns + 1 : column + columns]
