"""Uncertainty of pressure and contacts: noise, posterior and model errors of a patch."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_range, check_shape
from skinfield.settings import Range, Section

ANGLES = 32  # at which an ellipse is seen in a quarter turn


def normal_interval(value: float, std: float, level: float) -> tuple[float, float]:
    """Middle `level` of a normal distribution."""
    from scipy.special import ndtri

    half = float(ndtri((1.0 + _checked(level)) / 2)) * std
    return value - half, value + half


def normal_radius(covariance: Floats, level: float) -> float:
    """Radius of the circle that holds a share `level` of a normal distribution in the plane.

    With e = r (a cos t, b sin t), r²/2 exponential and t uniform, a circle of radius R holds the
    mean over t of 1 - exp(-R² / 2 (a² cos² t + b² sin² t)).
    """
    _checked(level)
    small, large = np.maximum(np.linalg.eigvalsh(covariance), 0.0)
    turn = (np.arange(ANGLES) + 0.5) * np.pi / 2 / ANGLES
    seen = large * np.cos(turn) ** 2 + small * np.sin(turn) ** 2
    if not large > 0.0:
        return 0.0
    widest = float(np.sqrt(-2.0 * large * np.log1p(-level)))  # of a round one that is as wide
    from scipy.optimize import brentq

    def lacking(radius: float) -> float:
        return level - float(np.mean(-np.expm1(-(radius**2) / (2 * seen))))

    return float(brentq(lacking, 0.0, widest * (1.0 + 1e-9), xtol=1e-15 * widest))


def _checked(level: float) -> float:
    check_range("level", level, 1e-3, 1 - 1e-6, "the chance that the truth lies inside")
    return level


ENOUGH = 1e3  # a deviation beyond is no statement


@dataclass(frozen=True, kw_only=True)
class ModelError(Section):
    """Deviations of a contact's answer that are there without noise; independent of each other.

    Parameters
    ----------
    force : float
        One standard deviation, part of the contact's normal force.
    place : float, m
        One standard deviation along each tangent.
    """

    force: Annotated[float, Range(0.0, ENOUGH, "one standard deviation")] = 0.0
    place: Annotated[float, Range(0.0, ENOUGH, "one standard deviation")] = 0.0

    def covariance(self, force: float) -> Floats:
        """Of x m, y m and the normal force N of a contact with this force: (3, 3)."""
        covariance = np.zeros((3, 3))
        covariance[0, 0] = covariance[1, 1] = self.place**2
        covariance[2, 2] = (self.force * force) ** 2
        return covariance


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
class FactoredError:
    """What noise and posterior of a pressure share: a factor of a covariance, and its squares."""

    factor: Floats

    @cached_property
    def std(self) -> Floats:
        """Standard deviation of each cell, (K,) Pa."""
        return np.asarray(np.sqrt(np.square(self.factor).sum(axis=1)))

    @cached_property
    def felt(self) -> int:
        """Number of cells whose deviation is not 0."""
        return int(np.count_nonzero(self.std))

    @cached_property
    def single(self) -> NDArray[np.float32]:
        """`factor` in single precision, for loops that have half the time to read it."""
        return np.require(self.factor, np.float32, ("C", "W"))

    def explained(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of sums with weights (M, N) of rows `cells` of the factor."""
        check_cells(cells, weights, len(self.factor))
        moved = weights @ self.factor[cells]
        return np.asarray(moved @ moved.T, np.float64)


class PressureNoise(FactoredError):
    """Noise of a pressure that is linear in independent readings.

    Attributes
    ----------
    factor : (K, L) array, Pa
        Pressure per standard deviation of each reading.
    """

    def on(self, nodes: NDArray[np.int64]) -> "PressureNoise":
        """Of some of the cells, in their order."""
        return PressureNoise(self.factor[nodes])

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        return self.explained(cells, weights)


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


@dataclass(frozen=True, eq=False, kw_only=True)
class PressurePosterior(FactoredError):
    r"""Covariance of a pressure on a lattice, given the readings: prior less what they explain.

    .. math:: \mathrm{cov}(w_i \cdot p, w_j \cdot p) = w_i^T Q w_j - (F^T w_i) \cdot (F^T w_j)

    Q depends on the offset of two nodes alone, so the (K, K) matrix is never made: a region of N
    cells costs N² entries of a table.

    Attributes
    ----------
    prior : (rows, columns) array, Pa²
        Covariance of two nodes by their offset along y and x, in pitches.
    factor : (K, L) array, Pa
        F: what the readings explain of the covariance is F Fᵀ.
    steps : (K, 2) int array
        Row and column of each cell.
    """

    prior: Floats
    steps: NDArray[np.int64]

    def __post_init__(self) -> None:
        check_shape("steps", self.steps, (len(self.factor), 2), "row and column of each cell")

    @classmethod
    def of_lattice(cls, prior: Floats, factor: Floats) -> "PressurePosterior":
        """Of all nodes of the lattice that `prior` (rows, columns) covers, row by row."""
        steps = np.stack(np.divmod(np.arange(prior.size), prior.shape[1]), axis=1)
        return cls(prior=prior, factor=factor, steps=steps)

    @cached_property
    def std(self) -> Floats:
        """Standard deviation of each cell, (K,) Pa."""
        explained = np.einsum("kl,kl->k", self.factor, self.factor)
        return np.asarray(np.sqrt(np.maximum(self.prior[0, 0] - explained, 0.0)))

    def on(self, nodes: NDArray[np.int64]) -> "PressurePosterior":
        """Of some of the cells, in their order."""
        return replace(self, factor=self.factor[nodes], steps=self.steps[nodes])

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        explained = self.explained(cells, weights)
        down, right = (np.abs(axis[:, None] - axis) for axis in self.steps[cells].T)
        return np.asarray(weights @ self.prior[down, right] @ weights.T - explained)
