"""Idle tests of many patches of equal geometry, by tiles of a matrix without what is negligible."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.solve.tiles import Tiles

Singles = NDArray[np.float32]
PROOF = 1e-4  # of each taxel's part in an idle test: its bound is then about 0.01 deviations
SCORES = 6  # patches whose products an idle test holds at once: `tiles_kernel.TOGETHER`


@dataclass(frozen=True, eq=False)
class IdleTest:
    """Test of all patches of a kind by tiles: what of their readings stands out of the noise.

    Attributes
    ----------
    tiles : Tiles
        Of rows of the length 1, one for each cell, for readings in units of their noise.
    dropped : (K,) float32 array
        How far each product may be off, as part of the norm of a patch's readings.
    threshold : float
        That no product of an idle patch exceeds.
    scores : (6, K) float32 array
        To work in.
    """

    tiles: Tiles
    dropped: Singles
    threshold: float
    scores: Singles

    @classmethod
    def of(cls, rows: NDArray[Any], shape: tuple[int, int], threshold: float) -> "IdleTest":
        """Test by rows (K, L) of a grid."""
        tiles = Tiles.of(rows, shape, PROOF)
        dropped = (tiles.dropped * (1.0 + 1e-6)).astype(np.float32)  # not less by its rounding
        return cls(tiles, dropped, threshold, np.zeros((SCORES, len(rows)), np.float32))

    def apply(self, white: Singles, idle: NDArray[np.bool_]) -> None:
        """Write into `idle` (P,) which of readings (P, L) without their offset are idle."""
        from skinfield.reconstruct.engine.idle_tests_kernel import idle_patches

        tiles = self.tiles
        where = tiles.values, tiles.taxels, tiles.firsts, tiles.cells, tiles.shape[1]
        idle_patches(*where, self.dropped, self.threshold, white, self.scores, idle)
