"""What a Gaussian prior and the readings leave open of a pressure field."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, check_shape

DENSE = 160  # cells up to which a table of all pairs is quicker than a Fourier transform


@dataclass(frozen=True, eq=False)
class PressurePosterior:
    r"""Covariance of a pressure on a lattice, given the readings: prior less what they explain.

    .. math:: \mathrm{cov}(w_i \cdot p, w_j \cdot p) = w_i^T Q w_j - (F^T w_i) \cdot (F^T w_j)

    Q depends on the offset of two nodes alone, so the (K, K) matrix is never made: a region of N
    cells costs N² entries of a table, or one Fourier transform of its box if it is large.

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

    def on(self, nodes: NDArray[np.int64]) -> "PressurePosterior":
        """Of some of the cells, in their order."""
        return replace(self, factor=self.factor[nodes], steps=self.steps[nodes])

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        moved = weights @ self.factor[cells]
        return np.asarray(self._prior_of_sums(self.steps[cells], weights) - moved @ moved.T)

    def _prior_of_sums(self, steps: NDArray[np.int64], weights: Floats) -> Floats:
        if len(steps) <= DENSE:
            row, column = (np.abs(axis[:, None] - axis[None]) for axis in steps.T)
            return np.asarray(weights @ self.prior[row, column] @ weights.T)
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
