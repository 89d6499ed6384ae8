"""From a fine grid to a coarse one over the same patch: averages over cells, so force is kept."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.fields import PressurePosterior
from skinfield.layout import Grid


@dataclass(frozen=True, eq=False)
class Restriction:
    r"""Pressure on coarse cells as the average of what lies on fine cells below.

    .. math:: p_c = \sum_f \frac{|c \cap f|}{|c|} \, p_f

    Coarse cells that hold all fine ones conserve the force: the sum of pressure times cell area.
    The area of an intersection is a product of two lengths, so two small matrices do it.

    Attributes
    ----------
    down : (coarse rows, fine rows) array
    across : (coarse columns, fine columns) array
        Parts of a coarse cell's side that each fine cell covers.
    """

    down: Floats
    across: Floats

    @classmethod
    def between(cls, fine: Grid, coarse: Grid) -> "Restriction":
        """Of two grids in one plane."""
        parts = [
            _parts(fine.origin[axis], fine.pitch, count, coarse.origin[axis], coarse.pitch, wanted)
            for axis, count, wanted in zip(
                (1, 0), fine.shape, coarse.shape, strict=True
            )  # rows lie along y
        ]
        return cls(*parts)

    def __call__(self, fields: Floats) -> Floats:
        """Fields (..., K fine) on the coarse cells, (..., K coarse)."""
        pictures = fields.reshape(*fields.shape[:-1], self.down.shape[1], self.across.shape[1])
        coarse = self.down @ pictures @ self.across.T
        return np.asarray(coarse.reshape(*fields.shape[:-1], -1))

    def transposed(self, weights: Floats) -> Floats:
        """Weights (..., K coarse) of a sum, as those of fine cells, (..., K fine)."""
        pictures = weights.reshape(*weights.shape[:-1], len(self.down), len(self.across))
        fine = self.down.T @ pictures @ self.across
        return np.asarray(fine.reshape(*weights.shape[:-1], -1))


@dataclass(frozen=True, eq=False)
class RestrictedPosterior:
    """Covariance of coarse cells, exactly: that of the sums of fine cells that they are.

    Attributes
    ----------
    fine : PressurePosterior
    restriction : Restriction
    cells : (K,) int array
        Which of the coarse cells, by their numbers on the coarse grid.
    """

    fine: PressurePosterior
    restriction: Restriction
    cells: NDArray[np.int64]

    def on(self, nodes: NDArray[np.int64]) -> "RestrictedPosterior":
        """Of some of the cells, in their order."""
        return replace(self, cells=self.cells[nodes])

    @cached_property
    def std(self) -> Floats:
        """Standard deviation of each coarse cell, (K,) Pa."""
        each, one = np.arange(len(self.cells))[:, None], np.ones((1, 1))
        variance = [self.covariance_of_sums(cell, one)[0, 0] for cell in each]
        return np.sqrt(np.maximum(variance, 0.0))

    @cached_property
    def felt(self) -> int:
        """Number of cells of which anything is left open."""
        return int(np.count_nonzero(self.std))

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        restriction = self.restriction
        places, count = self.cells[cells], len(restriction.down) * len(restriction.across)
        sums = [np.bincount(places, weight, count) for weight in weights]  # cells may come again
        coarse = np.asarray(sums, dtype=np.float64)
        fine = restriction.transposed(coarse)
        used = np.flatnonzero(fine.any(axis=0))
        return self.fine.covariance_of_sums(used, fine[:, used])


def _parts(fine: float, step: float, count: int, coarse: float, side: float, wanted: int) -> Floats:
    """Parts of coarse cells of one axis that fine cells cover, (wanted, count)."""
    low = fine + (np.arange(count) - 0.5) * step
    start = coarse + (np.arange(wanted) - 0.5) * side
    last = np.minimum(low + step, (start + side)[:, None])
    return np.asarray(np.maximum(last - np.maximum(low, start[:, None]), 0.0) / side)
