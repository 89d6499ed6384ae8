"""Sparse matrix in tiles of 4 x 4 cells, between the cells of a grid and taxels."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_finite, check_range, check_shape

SIDE = 4  # cells of a tile
LINE = 64  # bytes of a cache line

Ints32 = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Tiles:
    r"""Matrix (K, L) of which each taxel keeps the tiles of 4 x 4 cells that matter.

    A taxel feels, and is explained by, few of the cells of a grid. Its tiles are stored whole, so
    that products run at the machine's vector rate on few bytes; see
    `skinfield.solve.tiles_kernel`, where the arrays are explained and whose functions compiled
    code may call itself.

    Attributes
    ----------
    values : (B, 16) array
        Numbers of all blocks: one tile of one taxel each. Tile by tile.
    taxels : (B,) int32 array
        Whose block it is.
    firsts : (T + 1,) int32 array
        Where the blocks of each tile begin.
    cells : (T,) int32 array
        First cell of each tile.
    shape : (rows, columns)
        Of the grid.
    count : int
        L.
    dropped : (K,) array
        Norm over the taxels, for each cell, of what the stamps lack of the matrix: what was cut
        and what was rounded to the type of `values`. By Cauchy and Schwarz, a product with any
        values x (L,) differs from the whole matrix's by no more than
        :math:`|(M x)_k - (S x)_k| \le \mathrm{dropped}_k |x|_2`, but for the rounding of the sums.
    """

    values: NDArray[Any]
    taxels: Ints32
    firsts: Ints32
    cells: Ints32
    shape: tuple[int, int]
    count: int
    dropped: Floats

    @classmethod
    def of(
        cls,
        matrix: ArrayLike,
        shape: tuple[int, int],
        cut: float = 1e-3,
        dtype: DTypeLike = np.float32,
    ) -> "Tiles":
        """Choose the tiles of a matrix and copy what they hold.

        Parameters
        ----------
        matrix : (K, L) array
            Any unit; a row for each cell.
        shape : (rows, columns)
            Of the K cells, at least 4 x 4.
        cut : float, dimensionless
            Root of the sum of squares that a column may lose, as part of the column's own: as
            many tiles as that allows are left out, the least first. 0 loses nothing but zeros.
        dtype : numpy.float32 or numpy.float64
            Of what is kept.

        Raises
        ------
        InputError
            For a matrix of another grid or with numbers that are not finite, a smaller grid,
            another `cut` or type.
        """
        matrix = as_floats("matrix", matrix)
        check_shape("matrix", matrix, (shape[0] * shape[1], None), "one row per cell of the grid")
        check_finite("matrix", matrix, "stamps are parts of a matrix of finite numbers")
        check_range("cut", cut, 0.0, 0.9, "part of a column's norm that may be lost")
        kind = _checked_type(dtype, matrix)
        members, own = _tiles(shape)
        blocks = np.where(own[..., None], matrix[members], 0.0)  # (T, 16, L)
        keep = _large(blocks, cut)
        tile, taxel = (side.astype(np.int32) for side in np.nonzero(keep))
        values = aligned_blocks(len(tile), kind)
        by_taxel = blocks.transpose(0, 2, 1)  # a view: (T, L, 16)
        values[:] = by_taxel[keep]
        cells, firsts = (
            members[:, 0].astype(np.int32),
            np.searchsorted(tile, np.arange(len(own) + 1)),
        )
        by_taxel[keep] -= values  # what the stamps lack is left
        dropped = np.empty(len(matrix))
        dropped[members[own]] = np.linalg.norm(blocks, axis=2)[own]
        arrays = values, taxel, firsts.astype(np.int32), cells
        for array in (*arrays, dropped):
            array.setflags(write=False)
        return cls(*arrays, shape, matrix.shape[1], dropped)

    @property
    def share(self) -> float:
        """Numbers kept, as part of those of the whole matrix."""
        return float(self.values.size / max(len(self.dropped) * self.count, 1))

    def apply(self, values: NDArray[Any], out: NDArray[Any]) -> None:
        """Write matrix @ values into `out` (K,), or row by row of (P, L) into (P, K).

        Arrays are of the stamps' type and contiguous, or an InputError tells. Nothing is allocated.
        """
        product, *tiles = self._product
        inner, outer, shape = (self.count,), (len(self.dropped),), values.shape
        whole = shape[:-1] + inner, shape[:-1] + outer  # what compiled code would go beyond
        try:  # it refuses other types itself
            if (shape, out.shape) == whole and len(shape) <= 2:
                product(*tiles, *((values, out) if len(shape) == 2 else (values[None], out[None])))
                return
        except Exception as error:
            from numba.core.errors import TypingError

            if not isinstance(error, TypingError):
                raise
        raise InputError(
            f"product of {values.dtype} {shape} into {out.dtype} {out.shape}, expected contiguous "
            f"{self.values.dtype} arrays {inner} into {outer}, or (P, {inner[0]}) into "
            f"(P, {outer[0]})"
        )

    @cached_property
    def _product(self) -> tuple[Any, ...]:
        """Compiled product, and what it takes beside the numbers."""
        from skinfield.solve.tiles_kernel import apply_tiles

        return apply_tiles, self.values, self.taxels, self.firsts, self.cells, self.shape[1]


def _tiles(shape: tuple[int, int]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Cells (T, 16) of all tiles, and which belong to it: the last ones of a row may overlap."""
    if min(shape) < SIDE:
        raise InputError(
            f"grid has {shape[0]} x {shape[1]} cells, expected {SIDE} x {SIDE} or more: a matrix "
            "of so few is quickest as it is"
        )
    tops, lefts = (np.minimum(np.arange(0, n, SIDE), n - SIDE) for n in shape)
    corners = (tops[:, None] * shape[1] + lefts).ravel()
    within = (np.arange(SIDE)[:, None] * shape[1] + np.arange(SIDE)).ravel()
    members = corners[:, None] + within
    _, first = np.unique(members, return_index=True)
    own = np.zeros(members.size, np.bool_)
    own[first] = True
    return members, own.reshape(members.shape)


def _large(blocks: Floats, cut: float) -> NDArray[np.bool_]:
    """Which blocks (T, 16, L) are kept, (T, L)."""
    largest = np.abs(blocks).max(axis=(0, 1), initial=0.0)
    scaled = blocks / np.where(largest > 0.0, largest, 1.0)  # squares neither vanish nor overflow
    energy = np.square(scaled).sum(axis=1)
    rank = np.argsort(energy, axis=0, kind="stable")
    lost = np.cumsum(np.take_along_axis(energy, rank, axis=0), axis=0)
    keep = np.empty(energy.shape, np.bool_)
    np.put_along_axis(keep, rank, lost > cut**2 * lost[-1:], axis=0)
    keep &= energy > 0.0
    return keep


def _checked_type(dtype: DTypeLike, matrix: Floats) -> np.dtype[Any]:
    kind = np.dtype(dtype)
    if kind not in (np.dtype(np.float32), np.dtype(np.float64)):
        raise InputError(f"dtype is {dtype!r}, expected numpy.float32 or numpy.float64")
    largest, limit = float(np.abs(matrix).max(initial=0.0)), float(np.finfo(kind).max)
    if largest > limit:
        raise InputError(
            f"matrix holds {largest:.3g}, expected no number above {limit:.3g}: "
            f"too large for {kind}"
        )
    return kind


def aligned_blocks(blocks: int, kind: np.dtype[Any]) -> NDArray[Any]:
    """Room that begins at a cache line, so that no float32 block crosses two."""
    room = np.zeros(blocks * SIDE**2 + LINE // kind.itemsize, kind)
    skip = -room.ctypes.data % LINE // kind.itemsize
    return room[skip : skip + blocks * SIDE**2].reshape(blocks, SIDE**2)
