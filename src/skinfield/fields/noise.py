"""How the noise of the readings moves a pressure field."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError


class PressureError(Protocol):
    """How far a pressure may be off: deviation of each cell, and covariance of sums over cells."""

    @property
    def std(self) -> Floats:
        """Standard deviation of each cell, (K,) Pa."""
        ...

    @property
    def felt(self) -> int:
        """Number of cells whose deviation is not 0."""
        ...

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        ...


@dataclass(frozen=True, eq=False)
class PressureNoise:
    """Noise of a pressure that is linear in independent readings.

    Attributes
    ----------
    factor : (K, L) array, Pa
        Pressure per standard deviation of each reading.
    """

    factor: Floats

    @cached_property
    def std(self) -> Floats:
        """Standard deviation of each cell, (K,) Pa."""
        return np.asarray(np.sqrt(np.square(self.factor).sum(axis=1)))

    @cached_property
    def felt(self) -> int:
        """Number of cells that feel any noise."""
        return int(np.count_nonzero(self.std))

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        check_cells(cells, weights, len(self.factor))
        cells, weights = np.asarray(cells, np.int64), np.asarray(weights, np.float64)
        return np.asarray(compiled().of_factor(self._factor, cells, weights))

    @cached_property
    def single(self) -> NDArray[np.float32]:
        """`factor` in single precision, for loops that have half the time to read it."""
        return np.require(self.factor, np.float32, ("C", "W"))

    @cached_property
    def _factor(self) -> Floats:
        return np.ascontiguousarray(self.factor, dtype=np.float64)


@lru_cache(maxsize=1)
def compiled() -> Any:
    """The kernels, loaded when first needed, and all at once."""
    from skinfield.fields import covariance_kernel

    cell, one = np.zeros(1, np.int64), np.ones((1, 1))
    covariance_kernel.of_factor(one, cell, one)
    covariance_kernel.of_lattice(one, np.zeros((1, 2), np.int64), cell, one)
    return covariance_kernel


def check_cells(cells: NDArray[np.int64], weights: Floats, count: int) -> None:
    """Raise InputError unless weights (M, N) are of N cells out of `count`."""
    if weights.ndim != 2 or weights.shape[1:] != cells.shape:
        raise InputError(
            f"weights have shape {weights.shape}, expected (M, {cells.size}): one per cell and sum"
        )
    if len(cells) and not 0 <= cells.min() <= cells.max() < count:
        raise InputError(
            f"cells go from {cells.min()} to {cells.max()}, expected from 0 to {count - 1}"
        )
