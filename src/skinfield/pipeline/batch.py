"""Many readings at once: one matrix product per chunk, whose outputs stay in the cache."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import InputError, check_choice, check_count, check_shape
from skinfield.layout import Grid

CHUNK = 512  # readings per product at most
FEWEST = 64  # of fewer the calls tell
CACHED = 4 << 20  # bytes: outputs of more leave the cache before anybody has looked at them
OUTPUTS = {  # numbers per node; in the patch's frame, signs as in `Estimate`
    "pressure": 1,
    "indentation": 1,
    "displacement": 3,
}


class BulkProduct:
    """A prepared matrix for many readings.

    Parameters
    ----------
    operator : (R, L) array
        Such as `Reconstructor.operator`, or rows of it: see `rows_of`.
    precision : numpy.float32 or numpy.float64
        Of the product. A sum of L products in single precision is off by about 1e-6 of the
        largest of them, far below the noise of any skin.
    chunk : int
        Readings per product.

    Raises
    ------
    InputError
        If the operator is no matrix.

    Notes
    -----
    Run it on one thread of the BLAS (``OPENBLAS_NUM_THREADS=1``): a chunk is too small to share.
    More cores are used by more processes, as `skinfield reconstruct` does.
    """

    def __init__(
        self,
        operator: ArrayLike,
        precision: type[np.floating[Any]] = np.float32,
        chunk: int = CHUNK,
    ) -> None:
        matrix = np.asarray(operator)
        check_shape("operator", matrix, (None, None), "a row per output, a column per taxel")
        check_count("chunk", chunk, 1, 1 << 20, "readings per product")
        self.rows, self.taxels = matrix.shape
        self.chunk = chunk
        self._transposed = np.ascontiguousarray(matrix.T, dtype=precision)
        self._cast = np.empty((chunk, self.taxels), precision)

    @property
    def dtype(self) -> np.dtype[Any]:
        """Of what it writes."""
        return np.dtype(self._transposed.dtype)

    def fields(self, readings: NDArray[Any], out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Products with many readings.

        Parameters
        ----------
        readings : (T, L) array
            Linearised, all taxels valid: nothing is checked here but the shape.
        out : (T, R) array of `dtype`, C order, optional
            Where the products go; with it, nothing is allocated.

        Returns
        -------
        (T, R) array
            `out`.
        """
        check_shape("readings", readings, (None, self.taxels), "one number per taxel")
        if out is None:
            out = np.empty((len(readings), self.rows), self.dtype)
        for first in range(0, len(readings), self.chunk):
            part = readings[first : first + self.chunk]
            cast = self._cast[: len(part)]
            np.copyto(cast, part, casting="same_kind")
            np.dot(cast, self._transposed, out=out[first : first + len(part)])
        return out


def readings_per_product(row_bytes: int) -> int:
    """Readings whose outputs of so many bytes each stay in the cache: a power of two."""
    fitting = max(CACHED // max(row_bytes, 1), 1)
    return min(CHUNK, max(FEWEST, 1 << fitting.bit_length() - 1))


def rows_of(operator: NDArray[Any], grid: Grid, outputs: Iterable[str]) -> NDArray[Any]:
    """Rows that give the chosen outputs, one after the other.

    Parameters
    ----------
    operator : (4 K, L) array
        Of a `Reconstructor`: pressure, then displacement x, y, z.
    grid : Grid
        Of the reconstructor: K nodes.
    outputs : iterable of str
        Of `OUTPUTS`: pressure (K) Pa; indentation (K) m, the displacement into the skin along its
        normal; displacement (3 K) m, the three components of a node together.

    Returns
    -------
    (R, L) array
    """
    nodes = len(grid)
    check_shape("operator", operator, (4 * nodes, None), "pressure and displacement of each node")
    moved = operator[nodes:].reshape(3, nodes, -1)
    made = []
    for name in checked_outputs(outputs):
        if name == "pressure":
            made.append(operator[:nodes])
        elif name == "indentation":
            made.append(-np.einsum("ckl,kc->kl", moved, grid.normals))
        else:
            made.append(moved.transpose(1, 0, 2).reshape(3 * nodes, -1))
    return np.concatenate(made)


def checked_outputs(outputs: Iterable[str]) -> tuple[str, ...]:
    """The names as a tuple; raises InputError for one that is none, twice there, or for none."""
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    for name in names:
        check_choice("outputs", name, OUTPUTS, "a field that a reading is turned into")
    if not names or len(set(names)) < len(names):
        raise InputError(f"outputs is {names!r}, expected one name or more, each once")
    return names
