"""How the noise of the readings moves a pressure field."""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats


class PressureError(Protocol):
    """How far a pressure may be off: deviation of each cell, and covariance of sums over cells."""

    @property
    def std(self) -> Floats:
        """Standard deviation of each cell, (K,) Pa."""
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

    def std_of_sum(self, cells: NDArray[np.int64]) -> float:
        """Standard deviation of the sum over some cells, Pa: cells share the readings' noise."""
        return float(np.linalg.norm(self.factor[cells].sum(axis=0)))

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        moved = weights @ self.factor[cells]
        return np.asarray(moved @ moved.T)
