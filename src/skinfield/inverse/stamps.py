"""A matrix between cells and taxels, kept where it is large: a window of cells for each taxel."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_finite, check_range, check_shape
from skinfield.layout import Grid

LEAST = 1e-5  # cut below which sums of squares are too coarse to choose a window by
UNIT = 8  # numbers: columns of a window are a multiple, where the grid has room
LINE = 64  # bytes of a cache line
DENSE_WINS = 0.4  # share of the dense numbers above which a dense product is quicker


@dataclass(frozen=True, eq=False)
class Stamps:
    r"""Matrix (K, L) that keeps a rectangular window of cells for each taxel.

    A taxel feels, and is explained by, few of the cells of a grid. A window is stored without gaps,
    row by row, so that its products run at the machine's vector rate on few bytes.

    Attributes
    ----------
    values : (S,) array
        Numbers of all windows, window after window, row after row.
    starts : (L,) int32 array
        Where each window begins in `values`.
    windows : (L, 4) int32 array
        First row, first column, rows and columns of each window.
    shape : (rows, columns)
        Of the grid.
    dropped : (K,) array
        Norm over the taxels, for each cell, of what the stamps lack of the matrix: what was cut
        and what was rounded to the type of `values`. By Cauchy and Schwarz, a product with any
        values x (L,) differs from the whole matrix's by no more than
        :math:`|(M x)_k - (S x)_k| \le \mathrm{dropped}_k |x|_2`, but for the rounding of the sums.
    """

    values: NDArray[Any]
    starts: NDArray[np.int32]
    windows: NDArray[np.int32]
    shape: tuple[int, int]
    dropped: Floats

    @classmethod
    def of(
        cls, matrix: ArrayLike, grid: Grid, cut: float = 1e-3, dtype: DTypeLike = np.float32
    ) -> "Stamps":
        """Choose the windows of a matrix and copy what they hold.

        Parameters
        ----------
        matrix : (K, L) array
            Any unit; a row for each cell of the grid.
        grid : Grid
            Of K cells.
        cut : float, dimensionless
            Root of the sum of squares that a column may lose, as part of the column's own: each
            window is the cheapest that loses no more. 0 loses nothing but zeros.
        dtype : numpy.float32 or numpy.float64
            Of what is kept.

        Raises
        ------
        InputError
            For a matrix of another grid or with numbers that are not finite, another `cut` or type.
        """
        matrix = as_floats("matrix", matrix)
        check_shape("matrix", matrix, (len(grid), None), "one row per cell of the grid")
        check_finite("matrix", matrix, "stamps are parts of a matrix of finite numbers")
        check_range("cut", cut, 0.0, 0.9, "part of a column's norm that may be lost")
        kind = _checked_type(dtype, matrix)
        windows = _windows(matrix, grid.shape, cut)
        starts = np.concatenate([[0], np.cumsum(windows[:, 2].astype(np.int64) * windows[:, 3])])
        if starts[-1] > np.iinfo(np.int32).max:
            raise InputError(
                f"matrix needs {starts[-1]} numbers at a cut of {cut}, expected fewer than 2^31: "
                "raise cut, or divide the patch"
            )
        values = _aligned(int(starts[-1]), kind)
        squares = np.zeros(grid.shape)
        for taxel, column in enumerate(matrix.T):
            picture = column.reshape(grid.shape)
            row, first, rows, columns = windows[taxel]
            inside = slice(row, row + rows), slice(first, first + columns)
            kept = values[starts[taxel] : starts[taxel + 1]].reshape(rows, columns)
            kept[:] = picture[inside]
            lost = picture.copy()
            lost[inside] -= kept
            squares += np.square(lost)
        dropped = np.sqrt(squares.ravel())
        begins = starts[:-1].astype(np.int32)
        for array in (values, begins, windows, dropped):
            array.setflags(write=False)
        return cls(values, begins, windows, grid.shape, dropped)

    @property
    def nbytes(self) -> int:
        """Bytes that a product reads of the matrix."""
        return int(self.values.nbytes)

    @property
    def share(self) -> float:
        """Numbers kept, as part of those of the whole matrix."""
        return float(self.values.size / max(len(self.dropped) * len(self.windows), 1))

    @property
    def pays(self) -> bool:
        """Whether a product is quicker than that of the whole matrix in the same type."""
        return self.share < DENSE_WINS

    def apply(self, values: NDArray[Any], out: NDArray[Any]) -> None:
        """Write matrix @ values into `out` (K,), or row by row of (P, L) into (P, K).

        Arrays are of the stamps' type and contiguous, or an InputError tells. Nothing is allocated.
        """
        kernel = self._kernel
        run = kernel.checked_apply if values.ndim == 1 else kernel.checked_apply_many
        self._run(run, values, out, (len(self.windows), len(self.dropped)))

    def adjoint(self, field: NDArray[Any], out: NDArray[Any]) -> None:
        """Write matrix.T @ field into `out` (L,), or row by row of (P, K) into (P, L).

        Arrays are of the stamps' type and contiguous, or an InputError tells. Nothing is allocated.
        """
        kernel = self._kernel
        run = kernel.checked_adjoint if field.ndim == 1 else kernel.checked_adjoint_many
        self._run(run, field, out, (len(self.dropped), len(self.windows)))

    def dense(self) -> NDArray[Any]:
        """The matrix (K, L) that the products are of."""
        whole = np.zeros((len(self.windows), *self.shape), self.values.dtype)
        for taxel, (row, column, rows, columns) in enumerate(self.windows):
            part = self.values[self.starts[taxel] :][: rows * columns].reshape(rows, columns)
            whole[taxel, row : row + rows, column : column + columns] = part
        return whole.reshape(len(whole), -1).T

    @cached_property
    def _kernel(self) -> ModuleType:
        from skinfield.inverse import stamps_kernel

        return stamps_kernel

    def _run(
        self,
        run: Callable[..., bool],
        given: NDArray[Any],
        out: NDArray[Any],
        sizes: tuple[int, int],
    ) -> None:
        try:
            if run(self.values, self.starts, self.windows, self.shape, given, out):
                return
        except self._kernel.TypingError:
            pass
        inner, outer = sizes
        raise InputError(
            f"product of {given.dtype} {given.shape} into {out.dtype} {out.shape}, expected "
            f"contiguous {self.values.dtype} arrays ({inner},) into ({outer},), or "
            f"(P, {inner}) into (P, {outer})"
        )


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


def _windows(matrix: Floats, shape: tuple[int, int], cut: float) -> NDArray[np.int32]:
    """Window of each column, (L, 4): a boundary box of what is not small, or the cheapest."""
    from skinfield.inverse.stamps_windows import window_of

    windows = np.zeros((matrix.shape[1], 4), np.int32)
    sums = np.empty((shape[0] + 1, shape[1] + 1))
    for window, column in zip(windows, matrix.T, strict=True):
        largest = np.abs(column).max()
        scaled = (column / largest if largest > 0.0 else column).reshape(shape)
        energy = np.square(scaled)
        if cut < LEAST:  # no number above the limit is cut: the rest is below cut in sum
            limit = cut * np.sqrt(energy.sum() / energy.size)
            energy = (np.abs(scaled) > limit).astype(float)
            window_of(energy / max(energy.sum(), 1.0), 0.5 / energy.size, UNIT, window, sums)
        else:
            lost = 0.999 * cut**2  # less than allowed by more than the sums are rounded
            window_of(energy / max(energy.sum(), 1.0), lost, UNIT, window, sums)
    return windows


def _aligned(size: int, kind: np.dtype[Any]) -> NDArray[Any]:
    """Zeros that begin at a cache line: blocks of a window seldom cross two."""
    room = np.zeros(size + LINE // kind.itemsize, kind)
    skip = -room.ctypes.data % LINE // kind.itemsize
    return room[skip : skip + size]
