"""One prepared linear map for many patches of equal geometry, applied to all of them at once."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats

Singles = NDArray[np.float32]
FEW = 5  # patches up to which a product for each is quicker than one for all


class SharedProduct(Protocol):
    """Map from the linearised readings of L taxels to K numbers, for P patches in one call."""

    @property
    def shape(self) -> tuple[int, int]:
        """(K, L)."""
        ...

    @property
    def nbytes(self) -> int:
        """Of what is read in each call."""
        ...

    def apply(self, readings: Singles, out: Singles) -> None:
        """Write the products of `readings` (P, L) into `out` (P, K), any P; allocates nothing.

        Both in C order and in float32.
        """
        ...


@dataclass(frozen=True, eq=False)
class DenseProduct:
    """All K x L entries: one matrix product over the readings of all patches.

    Attributes
    ----------
    transposed : (L, K) float32 array
        In C order, so that the P rows of the readings stream over it.
    """

    transposed: Singles

    @classmethod
    def of(cls, matrix: Floats | NDArray[Any]) -> "DenseProduct":
        """Of a matrix (K, L)."""
        return cls(np.ascontiguousarray(matrix.T, dtype=np.float32))

    @property
    def shape(self) -> tuple[int, int]:
        """(K, L)."""
        return self.transposed.shape[1], self.transposed.shape[0]

    @property
    def nbytes(self) -> int:
        """Of what is read in each call."""
        return int(self.transposed.nbytes)

    def apply(self, readings: Singles, out: Singles) -> None:
        """See `SharedProduct.apply`."""
        if len(readings) > FEW:
            np.dot(readings, self.transposed, out=out)
            return
        for reading, row in zip(readings, out, strict=True):
            np.dot(reading, self.transposed, out=row)
