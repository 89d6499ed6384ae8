"""From tractions on the squares of several windows to displacements there, as linear maps."""

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.mechanics import LatticeConvolution
from skinfield.mechanics.lattice import kept_indentation_kernel
from skinfield.simulate.pressing.plane import PAD, Skin
from skinfield.simulate.pressing.window import Window


class Others:
    """What loads in each of several windows do in all others: all at the nodes, less their own.

    Parameters
    ----------
    skin : Skin
    windows : list of Window
        None for a single one.
    kernel : (..., 2 n - 1, 2 m - 1) array
        Response at the padded grid's nodes per force.
    """

    def __init__(self, skin: Skin, windows: list[Window], kernel: Floats) -> None:
        self.skin, self.windows = skin, windows
        self.stencils = [skin.stencils(window) for window in windows]
        self.shape = [n + 2 * PAD for n in skin.grid.shape]
        self.whole = LatticeConvolution(kernel)
        middle = [n // 2 for n in kernel.shape[-2:]]
        self.own = []
        for window in windows:
            rows, columns = window.rows + 2 * PAD, window.columns + 2 * PAD
            part = kernel[
                ...,
                middle[0] - rows + 1 : middle[0] + rows,
                middle[1] - columns + 1 : middle[1] + columns,
            ]
            self.own.append(LatticeConvolution(part))

    def __call__(self, pictures: list[Floats]) -> list[Floats]:
        """Response (..., rows, columns) in each window to loads per area in the others."""
        total = np.zeros(self.shape)
        forces = []
        for window, picture, (along, across) in zip(
            self.windows, pictures, self.stencils, strict=True
        ):
            force = along.T @ (picture * self.skin.side(window) ** 2) @ across
            total[self.skin.nodes(window)] += force
            forces.append(force)
        every = self.whole(total)
        return [
            along @ (every[..., *self.skin.nodes(window)] - own(force)) @ across.T
            for window, force, own, (along, across) in zip(
                self.windows, forces, self.own, self.stencils, strict=True
            )
        ]


class Indenting:
    """From pressure on the squares of several windows, one after the other, to indentation."""

    def __init__(self, skin: Skin, windows: list[Window]) -> None:
        self.skin, self.windows = skin, windows
        self.near = [skin.near(window) for window in windows]
        self.others = Others(skin, windows, skin.far_kernel) if len(windows) > 1 else None
        ends = np.cumsum([0, *(window.size for window in windows)])
        self.parts = [slice(int(a), int(b)) for a, b in pairwise(ends)]

    def __call__(self, pressure: Floats) -> Floats:
        """Indentation (N,) m of a pressure (N,) Pa."""
        pictures = self.pictures(pressure)
        moved = [near(picture) for near, picture in zip(self.near, pictures, strict=True)]
        if self.others is not None:
            moved = [a + b for a, b in zip(moved, self.others(pictures), strict=True)]
        return np.concatenate([part.ravel() for part in moved])

    def pictures(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        """Of each window, (rows, columns)."""
        return [
            values[part].reshape(window.shape)
            for part, window in zip(self.parts, self.windows, strict=True)
        ]

    def own(self) -> Floats:
        """Indentation (N,) m of each square per Pa on itself."""
        out = np.empty(self.parts[-1].stop)
        for part, window in zip(self.parts, self.windows, strict=True):
            side = self.skin.side(window)
            kernel = kept_indentation_kernel(self.skin.mechanics, self.skin.layer, side, side, 0, 0)
            out[part] = kernel[0, 0]
        return out


class Sliding:
    """From tangential traction (2, N) on the squares of windows to displacement (2, N) there."""

    def __init__(self, skin: Skin, windows: list[Window]) -> None:
        self.skin = skin
        self.indenting = Indenting(skin, windows)
        kernels = [skin.near_surface(window) for window in windows]
        self.near = [LatticeConvolution(kernel[:2, :2]) for kernel in kernels]
        self.others = (
            [Others(skin, windows, skin.far_surface[:2, j]) for j in (0, 1)]
            if len(windows) > 1
            else []
        )
        self.own = np.concatenate(
            [
                np.full(window.size, kernel[0, 0, window.shape[0] - 1, window.shape[1] - 1])
                for window, kernel in zip(windows, kernels, strict=True)
            ]
        )

    def __call__(self, traction: Floats) -> Floats:
        """Displacement (2, N) m of a traction (2, N) Pa."""
        pictures = [self.indenting.pictures(component) for component in traction]
        moved = [
            near.total(np.stack(part)) for near, *part in zip(self.near, *pictures, strict=True)
        ]
        for others, part in zip(self.others, pictures, strict=False):
            moved = [a + b for a, b in zip(moved, others(part), strict=True)]
        return np.concatenate([part.reshape(2, -1) for part in moved], axis=1)
