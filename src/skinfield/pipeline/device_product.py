"""One matrix for many readings, on another device than the host."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import InputError, check_count, check_shape
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.batch import readings_per_product

CHUNK_BYTES = 1 << 26  # of a chunk's outputs on a device: copies longer than its calls
FREE_SHARE = 0.5  # of the device's free memory that a chunk may take
SLOTS = 2  # one chunk travels while the next is computed


class DeviceProduct:
    """A prepared matrix for many readings, on a device: in the place of a `BulkProduct`.

    Parameters
    ----------
    operator : (R, L) array
        Such as `Reconstructor.operator`, or rows of it: see `batch.rows_of`.
    backend : ArrayBackend
    precision : numpy.float32 or numpy.float64
        Of the product.
    chunk : int, optional
        Readings per product. Default by the free memory of the device.
    tf32 : bool
        Let a GPU round the factors to TF32's 10 bits, an error of about 1e-3 of the result.

    Raises
    ------
    InputError
        If the operator is no matrix.
    """

    def __init__(
        self,
        operator: ArrayLike,
        backend: ArrayBackend,
        precision: type[np.floating[Any]] = np.float32,
        chunk: int | None = None,
        tf32: bool = False,
    ) -> None:
        matrix = np.asarray(operator)
        check_shape("operator", matrix, (None, None), "a row per output, a column per taxel")
        self.rows, self.taxels = matrix.shape
        self.backend, self.tf32 = backend, tf32
        self.dtype = np.dtype(precision)
        with backend.computing():
            self._transposed = backend.send(np.ascontiguousarray(matrix.T, dtype=precision))
        size = (self.rows + self.taxels) * self.dtype.itemsize
        self.chunk = chunk_of(backend, size) if chunk is None else chunk
        check_count("chunk", self.chunk, 1, 1 << 24, "readings per product")

    def on_device(self, readings: NDArray[Any]) -> Any:
        """Products (T, R) with readings (T, L), linearised, all taxels valid; they stay there."""
        check_shape("readings", readings, (None, self.taxels), "one number per taxel")
        with self.backend.computing(self.tf32):
            sent = self.backend.send(np.ascontiguousarray(readings, dtype=self.dtype))
            return self.backend.namespace.matmul(sent, self._transposed)

    def chunks(self, readings: NDArray[Any]) -> Iterator[tuple[slice, NDArray[Any]]]:
        """Products with many readings, chunk by chunk, while the next one is computed.

        Parameters
        ----------
        readings : (T, L) array
            Linearised, all taxels valid: nothing is checked here but the shape.

        Yields
        ------
        part : slice
            Of the readings.
        products : (n, R) array
            On the host; valid until the next chunk is asked for.
        """
        check_shape("readings", readings, (None, self.taxels), "one number per taxel")
        before = None
        for number, first in enumerate(range(0, len(readings), self.chunk)):
            part = slice(first, min(first + self.chunk, len(readings)))
            end = self.backend.begin_fetch(self.on_device(readings[part]), number % SLOTS)
            if before is not None:
                yield before[0], before[1]()
            before = part, end
        if before is not None:
            yield before[0], before[1]()

    def fields(self, readings: NDArray[Any], out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Products with many readings, on the host.

        Parameters
        ----------
        readings : (T, L) array
            As for `chunks`, which spares a copy.
        out : (T, R) array of `dtype`, optional
            Where the products go.

        Returns
        -------
        (T, R) array
            `out`.
        """
        check_shape("readings", readings, (None, self.taxels), "one number per taxel")
        if out is None:
            out = np.empty((len(readings), self.rows), self.dtype)
        check_shape("out", out, (len(readings), self.rows), "a row per reading")
        for part, products in self.chunks(readings):
            out[part] = products
        return out


def chunk_of(backend: ArrayBackend, bytes_each: int) -> int:
    """Readings per chunk, of which each takes some bytes of the device."""
    if backend.is_host:
        return readings_per_product(bytes_each)
    free = backend.free_bytes()
    room = CHUNK_BYTES if free is None else min(CHUNK_BYTES, int(FREE_SHARE * free / SLOTS))
    if room < bytes_each:
        raise InputError(
            f"{backend.name} has {free} bytes free, expected {bytes_each * SLOTS / FREE_SHARE:.0f} "
            "or more for one reading: free some, or take a coarser grid"
        )
    return room // bytes_each
