"""Linear maps for many patches of equal geometry: dense, or in tiles without what is negligible."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.skin import Grid
from skinfield.solve.tiles import Tiles

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


CUT = 1e-3  # of each taxel's effect on the field: for answers
PROOF = 1e-4  # of each taxel's part in an idle test: its bound is then about 0.01 deviations
SMALL = 20_000  # entries below which calls cost more than numbers


@dataclass(frozen=True, eq=False)
class TiledProduct:
    """Tiles of cells that each taxel matters for: see `Tiles`.

    Attributes
    ----------
    stamps : Tiles
        In float32. Their `dropped` bounds how far an answer may be off.
    """

    stamps: Tiles

    @classmethod
    def of(cls, matrix: Floats | NDArray[Any], grid: Grid, cut: float = CUT) -> "TiledProduct":
        """Of a matrix (K, L) whose rows are the cells of a grid; `cut` as of `Tiles.of`."""
        return cls(Tiles.of(matrix, grid, cut))

    @property
    def shape(self) -> tuple[int, int]:
        """(K, L)."""
        return len(self.stamps.dropped), len(self.stamps.begins) - 1

    @property
    def nbytes(self) -> int:
        """Of what is read in each call."""
        return self.stamps.nbytes

    def apply(self, readings: Singles, out: Singles) -> None:
        """See `SharedProduct.apply`."""
        self.stamps.apply(readings, out)


def product_of(
    matrix: Floats | NDArray[Any], grid: Grid, cut: float = CUT
) -> DenseProduct | TiledProduct:
    """The quicker product of a matrix (K, L), by how much of it is large.

    Parameters
    ----------
    matrix : (K, L) array
    grid : Grid
        Of K cells.
    cut : float
        Of a stamped product, as of `Tiles.of`; 0 keeps all that is not 0.
    """
    if matrix.size >= SMALL and min(grid.shape) >= 4:
        stamped = TiledProduct.of(matrix, grid, cut)
        if stamped.stamps.pays:
            return stamped
    return DenseProduct.of(matrix)
