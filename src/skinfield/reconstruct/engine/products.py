"""Linear maps for many patches of equal geometry: dense, or in tiles without what is negligible."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.skin import Grid
from skinfield.solve.tiles import Tiles

Singles = NDArray[np.float32]
FEW = 5  # patches up to which a product for each is quicker than one for all
CUT = 1e-3  # of each taxel's effect on the field: for answers
PROOF = 1e-4  # of each taxel's part in an idle test: its bound is then about 0.01 deviations
SMALL = 20_000  # entries below which calls cost more than numbers


@dataclass(frozen=True, eq=False)
class DenseProduct:
    """All K x L entries: one matrix product over the readings of all patches.

    Attributes
    ----------
    transposed : (L, K) float32 array
        In C order, so that the P rows of the readings stream over it.
    """

    transposed: Singles

    def apply(self, readings: Singles, out: Singles) -> None:
        """Write the products of `readings` (P, L) into `out` (P, K), any P; allocates nothing.

        Both in C order and in float32.
        """
        if len(readings) > FEW:
            np.dot(readings, self.transposed, out=out)
            return
        for reading, row in zip(readings, out, strict=True):
            np.dot(reading, self.transposed, out=row)


def product_of(matrix: NDArray[Any], grid: Grid, cut: float = CUT) -> DenseProduct | Tiles:
    """The quicker product of a matrix (K, L), by how much of it is large; K cells of a grid.

    `cut` is that of the tiles, as of `Tiles.of`; 0 keeps all that is not 0.
    """
    if matrix.size >= SMALL and min(grid.shape) >= 4:
        tiles = Tiles.of(matrix, grid.shape, cut)
        if tiles.share < 1.0:  # tiles at borders overlap
            return tiles
    return DenseProduct(np.ascontiguousarray(matrix.T, dtype=np.float32))
