"""What a Gaussian prior and the readings leave open of a pressure field."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, check_shape
from skinfield.fields.noise import check_cells, compiled

DENSE = 500  # cells up to which going over all pairs is quicker than a Fourier transform


@dataclass(frozen=True, eq=False)
class PressurePosterior:
    r"""Covariance of a pressure on a lattice, given the readings: prior less what they explain.

    .. math:: \mathrm{cov}(w_i \cdot p, w_j \cdot p) = w_i^T Q w_j - (F^T w_i) \cdot (F^T w_j)

    Q depends on the offset of two nodes alone, so the (K, K) matrix is never made: a region of N
    cells costs N² / 2 entries of a table, or one Fourier transform of its box if it is large.

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
    factor: Floats
    steps: NDArray[np.int64]

    def __post_init__(self) -> None:
        check_shape("steps", self.steps, (len(self.factor), 2), "row and column of each cell")

    @classmethod
    def of_lattice(cls, prior: Floats, factor: Floats) -> "PressurePosterior":
        """Of all nodes of the lattice that `prior` (rows, columns) covers, row by row."""
        steps = np.stack(np.divmod(np.arange(prior.size), prior.shape[1]), axis=1)
        return cls(prior, factor, steps)

    @cached_property
    def std(self) -> Floats:
        """Standard deviation of each cell, (K,) Pa."""
        explained = np.einsum("kl,kl->k", self.factor, self.factor)
        return np.asarray(np.sqrt(np.maximum(self.prior[0, 0] - explained, 0.0)))

    @cached_property
    def felt(self) -> int:
        """Number of cells of which anything is left open."""
        return int(np.count_nonzero(self.std))

    def on(self, nodes: NDArray[np.int64]) -> "PressurePosterior":
        """Of some of the cells, in their order."""
        return replace(self, factor=self.factor[nodes], steps=self.steps[nodes])

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        kernel = compiled()
        check_cells(cells, weights, len(self.factor))
        cells, weights = np.asarray(cells, np.int64), np.asarray(weights, np.float64)
        explained = kernel.of_factor(self._factor, cells, weights)
        if len(cells) <= DENSE:
            return np.asarray(kernel.of_lattice(*self._lattice, cells, weights) - explained)
        return np.asarray(self._prior_of_sums(self.steps[cells], weights) - explained)

    @cached_property
    def single(self) -> NDArray[np.float32]:
        """`factor` in single precision, for loops that have half the time to read it."""
        return np.require(self.factor, np.float32, ("C", "W"))

    @cached_property
    def _factor(self) -> Floats:
        return np.ascontiguousarray(self.factor, dtype=np.float64)

    @cached_property
    def _lattice(self) -> tuple[Floats, NDArray[np.int64]]:
        prior = np.ascontiguousarray(self.prior, dtype=np.float64)
        return prior, np.ascontiguousarray(self.steps, dtype=np.int64)

    def _prior_of_sums(self, steps: NDArray[np.int64], weights: Floats) -> Floats:
        """By Fourier transforms of the box that holds all."""
        from scipy.fft import irfft2, next_fast_len, rfft2

        steps = steps - steps.min(axis=0)
        box = steps.max(axis=0) + 1
        size = [next_fast_len(int(2 * n - 1), real=True) for n in box]
        pictures = np.zeros((len(weights), *size))
        for picture, weight in zip(pictures, weights, strict=True):
            np.add.at(picture, tuple(steps.T), weight)  # a cell may come more than once
        offset = [np.minimum(np.arange(n), n - np.arange(n)) for n in size]
        near = [np.where(o < n, o, 0) for o, n in zip(offset, box, strict=True)]  # others unused
        wrapped = self.prior[near[0][:, None], near[1][None]]
        smooth = irfft2(rfft2(pictures) * rfft2(wrapped), s=size)
        return np.asarray(np.einsum("irc,jrc->ij", pictures, smooth))
