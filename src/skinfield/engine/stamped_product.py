"""A product that leaves out what is far below the error of its answer: for large patches."""

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from skinfield.engine.products import DenseProduct, Singles
from skinfield.errors import Floats
from skinfield.inverse.stamps import Stamps
from skinfield.layout import Grid

CUT = 1e-3  # of each taxel's effect on the field: for answers
PROOF = 1e-4  # of each taxel's part in an idle test: its bound is then about 0.01 deviations
SMALL = 20_000  # entries below which calls cost more than numbers


@dataclass(frozen=True, eq=False)
class StampedProduct:
    """Tiles of cells that each taxel matters for: see `Stamps`.

    Attributes
    ----------
    stamps : Stamps
        In float32. Their `dropped` bounds how far an answer may be off.
    """

    stamps: Stamps

    @classmethod
    def of(cls, matrix: Floats | NDArray[Any], grid: Grid, cut: float = CUT) -> "StampedProduct":
        """Of a matrix (K, L) whose rows are the cells of a grid; `cut` as of `Stamps.of`."""
        return cls(Stamps.of(matrix, grid, cut))

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
) -> DenseProduct | StampedProduct:
    """The quicker product of a matrix (K, L), by how much of it is large.

    Parameters
    ----------
    matrix : (K, L) array
    grid : Grid
        Of K cells.
    cut : float
        Of a stamped product, as of `Stamps.of`; 0 keeps all that is not 0.
    """
    if matrix.size >= SMALL and min(grid.shape) >= 4:
        stamped = StampedProduct.of(matrix, grid, cut)
        if stamped.stamps.pays:
            return stamped
    return DenseProduct.of(matrix)
