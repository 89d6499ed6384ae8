"""The cells of a press on a medium, and what loads on them and on windows do."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats
from skinfield.layout import Grid
from skinfield.mechanics import LatticeConvolution, Layer, Mechanics
from skinfield.mechanics.lattice import (
    interpolation,
    kept_indentation_kernel,
    kept_surface_kernel,
)
from skinfield.simulate.pressing.window import Window

PAD = 3  # nodes around the grid, so that every cell has a full stencil of interpolation
POINT = 9  # a load far away is one on a square of a ninth of a cell


@dataclass(frozen=True, eq=False)
class Skin:
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

    def near(self, window: Window) -> LatticeConvolution:
        """Pressure on a window's squares to indentation there."""
        side = self.side(window)
        rows, columns = window.shape
        kernel = kept_indentation_kernel(
            self.mechanics, self.layer, side, side, rows - 1, columns - 1
        )
        return LatticeConvolution(kernel)

    def near_surface(self, window: Window) -> Floats:
        """Kernel (3, 3, ...) of displacement per traction on a window's squares."""
        side = self.side(window)
        rows, columns = window.shape
        return kept_surface_kernel(self.mechanics, self.layer, side, side, rows - 1, columns - 1)

    @cached_property
    def far_kernel(self) -> Floats:
        """Indentation at the padded grid's nodes per force at them, m/N."""
        point = self.grid.pitch / POINT
        rows, columns = (n + 2 * PAD for n in self.grid.shape)
        kernel = kept_indentation_kernel(
            self.mechanics, self.layer, point, self.grid.pitch, rows - 1, columns - 1
        )
        return np.asarray(kernel / point**2)

    @cached_property
    def far(self) -> LatticeConvolution:
        """Force at the padded grid's nodes, N, to indentation at them."""
        return LatticeConvolution(self.far_kernel)

    @cached_property
    def far_surface(self) -> Floats:
        """Kernel (3, 3, ...) of displacement per force at the padded grid's nodes."""
        point = self.grid.pitch / POINT
        rows, columns = (n + 2 * PAD for n in self.grid.shape)
        kernel = kept_surface_kernel(
            self.mechanics, self.layer, point, self.grid.pitch, rows - 1, columns - 1
        )
        return np.asarray(kernel / point**2)

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
