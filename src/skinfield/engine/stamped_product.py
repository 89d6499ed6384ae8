"""A product that leaves out what is far below the error of its answer: for large patches."""

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from skinfield.engine.products import DenseProduct, SharedProduct, Singles
from skinfield.errors import Floats
from skinfield.inverse.stamps import Stamps
from skinfield.layout import Grid

CUT = 1e-3  # of each taxel's effect on the field: for answers
PROOF = 1e-4  # of each taxel's part in the idle test: its slack is then about 0.01 deviations
SMALL = 20_000  # entries below which calls cost more than numbers


@dataclass(frozen=True, eq=False)
class StampedProduct:
    r"""Tiles of cells that each taxel matters for: see `Stamps`.

    On a part of an iCub, 250 to 680 taxels on 40 x 40 cells, that is about a fifth of the entries
    of a linear answer at `CUT`, and a tenth of those of an idle test at `PROOF`.

    Attributes
    ----------
    stamps : Stamps
        In float32.
    slack : float
        How far an output may be from that of the whole matrix, as part of the readings' norm:
        :math:`|y_k - (M x)_k| \le \mathrm{slack} \, |x|_2` for all k. An idle test whose outputs
        stay so far below their threshold is proven for the whole matrix.
    """

    stamps: Stamps
    slack: float

    @classmethod
    def of(cls, matrix: Floats | NDArray[Any], grid: Grid, cut: float = CUT) -> "StampedProduct":
        """Of a matrix (K, L) whose rows are the cells of a grid; `cut` as of `Stamps.of`."""
        stamps = Stamps.of(matrix, grid, cut)
        return cls(stamps, float(stamps.dropped.max()))

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


def slack_of(product: SharedProduct) -> float:
    """By how much of the readings' norm an output may differ from that of the whole matrix."""
    return product.slack if isinstance(product, StampedProduct) else 0.0
