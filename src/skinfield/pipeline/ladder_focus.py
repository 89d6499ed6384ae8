"""A window of a patch in which a finer rung is looked at than around it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, Ints, as_floats, check_finite, check_shape
from skinfield.layout import Grid


@dataclass(frozen=True, eq=False)
class Window:
    """Rectangle of nodes of a fine grid.

    Attributes
    ----------
    fine : Grid
    rows, columns : slice
        Nodes inside.
    """

    fine: Grid
    rows: slice
    columns: slice

    @classmethod
    def between(cls, fine: Grid, low: ArrayLike, high: ArrayLike) -> "Window":
        """Nodes from `low` to `high` (2,) m of the patch's plane.

        Raises
        ------
        InputError
            If a corner is no place, or the rectangle holds no node.
        """
        corners = []
        for name, values in (("low", low), ("high", high)):
            corner = as_floats(name, values)
            check_shape(name, corner, (2,), "x and y in the patch's plane, in metres")
            check_finite(name, corner, "a corner of what to look at, in metres")
            corners.append(np.clip((corner - fine.origin) / fine.pitch, -1.0, max(fine.shape)))
        first = np.maximum(np.ceil(corners[0] - 1e-9), 0).astype(int)
        last = np.minimum(np.floor(corners[1] + 1e-9), np.array(fine.shape[::-1]) - 1).astype(int)
        if (last < first).any():
            raise InputError(
                f"the window from {np.asarray(low).tolist()} to {np.asarray(high).tolist()} m "
                f"holds no node of the {fine.shape[0]} x {fine.shape[1]} grid, expected low below "
                "high, on the patch, in metres"
            )
        columns, rows = (slice(int(a), int(b) + 1) for a, b in zip(first, last, strict=True))
        return cls(fine, rows, columns)

    @cached_property
    def nodes(self) -> Ints:
        """Of the fine grid, inside, (N,)."""
        every = np.arange(len(self.fine)).reshape(self.fine.shape)
        return np.ascontiguousarray(every[self.rows, self.columns].ravel())

    @cached_property
    def grid(self) -> Grid:
        """These nodes as a grid."""
        shape = self.rows.stop - self.rows.start, self.columns.stop - self.columns.start
        corner = np.array([self.columns.start, self.rows.start])
        return Grid(
            self.fine.patch, shape, self.fine.pitch, self.fine.origin + corner * self.fine.pitch
        )

    def candidates(self, around: int) -> NDArray[np.bool_]:
        """All nodes inside, and outside one of `around` x `around`: (K,) of the fine grid."""
        rows, columns = self.fine.shape
        seldom = max(around, 1)
        start = seldom // 2
        mask = np.zeros((rows, columns), np.bool_)
        mask[start::seldom, start::seldom] = True
        mask[self.rows, self.columns] = True
        return mask.ravel()


def box_of_contact(grid: Grid, pressure: Floats, edge: float) -> tuple[Floats, Floats] | None:
    """Corners (2,), (2,) m of what exceeds `edge` of the highest pressure; None where none does."""
    peak = float(pressure.max(initial=0.0))
    if not peak > 0.0:
        return None
    inside = grid.plane[pressure > edge * peak]
    return inside.min(axis=0) - grid.pitch / 2, inside.max(axis=0) + grid.pitch / 2
