"""Gaussian prior seen by taxels, of which any may be missing: posteriors of sets of taxels."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.estimate import PressurePosterior

CANCELLED = 1e-4  # of a variance, below which the difference of two is computed cell by cell


@dataclass(frozen=True, eq=False)
class TaxelSet:
    r"""Posterior of a set of the L taxels of a `GaussianModel`.

    Leaving the taxels I out of H = (q G + 1)⁻¹ leaves, by the inverse of a block matrix (Golub and
    Van Loan, Matrix Computations, section 2.1.4), :math:`H - H_{:I} H_{II}^{-1} H_{I:}`, whose
    rows and columns of I are 0. Along the vectors V this is diag(d) - Bᵀ B with d = 1 / (q g + 1)
    and as many rows of B as taxels are missing. The noise of an offset o that taxels share adds
    o oᵀ to 1, which takes one more row: :math:`H o / \sqrt{1 + o^T H o}`.

    Attributes
    ----------
    model : GaussianModel
    valid : (L,) bool array
    variance : float, Pa²
        q.
    retained : (L,) array
        d.
    lost : (M, L) array
        B.
    """

    model: "GaussianModel"
    valid: NDArray[np.bool_]
    variance: float
    retained: Floats
    lost: Floats

    @classmethod
    def of(cls, model: "GaussianModel", valid: NDArray[np.bool_]) -> "TaxelSet":
        """Of a mask (L,), True for one taxel or more."""
        variance = model.variance(valid)
        kept = 1.0 / (variance * model.spectrum + 1.0)
        rows = model.vectors[~valid] * kept
        lost = np.linalg.solve(np.linalg.cholesky(rows @ model.vectors[~valid].T), rows)
        if model.offset.any():
            along = (valid * model.offset) @ model.vectors
            seen = kept * along - (lost @ along) @ lost  # V' H o
            lost = np.vstack([lost, seen / np.sqrt(1.0 + along @ seen)])
        return cls(model, valid, variance, kept, lost)

    def filled(self, readings: Floats) -> Floats:
        """Linearised readings (T, L) from which the operator of all taxels gives the set's answer.

        Where the prior's amplitude is the same, missing readings become what the others predict.
        What stands in place of missing readings must be finite; it does not count.
        """
        model, every = self.model, np.ones(len(self.valid), np.bool_)
        whole = model.variance(every)
        along = np.where(self.valid, readings / model.noise_std, 0.0) @ model.vectors
        weights = self.retained * along - (along @ self.lost.T) @ self.lost
        weights *= self.variance / whole
        offset = weights @ (model.offset @ model.vectors)
        filled = (weights * (whole * model.spectrum + 1.0)) @ model.vectors.T
        return np.asarray((filled + np.outer(offset, model.offset)) * model.noise_std)

    @cached_property
    def stds(self) -> tuple[Floats, Floats]:
        """Standard deviations of each cell, (K,) Pa: of the posterior, and by the noise alone."""
        model, lost = self.model, self.lost
        first, second = lost @ model.turned.T, (lost * self.retained) @ model.turned.T
        explained = model.squared @ self.retained - np.square(first).sum(axis=0)
        whole = model.squared @ np.square(self.retained)
        less = 2.0 * second - (lost @ lost.T) @ first
        moved = whole - (first * less).sum(axis=0)
        cells = np.flatnonzero(moved < CANCELLED * whole)  # anew, without a difference of squares
        along = model.turned[cells]
        left = along * self.retained - (along @ lost.T) @ lost
        moved[cells] = np.square(left).sum(axis=1)
        posterior = self.variance * (model.prior.prior[0, 0] - self.variance * explained)
        return np.sqrt(np.maximum(posterior, 0.0)), self.variance * np.sqrt(moved)


@dataclass(frozen=True, eq=False)
class SetError:
    """How far the pressure of a set of taxels may be off; see `estimate.PressureError`.

    Attributes
    ----------
    taxels : TaxelSet
    of_noise : bool
        By the readings' noise alone; else of the posterior.
    """

    taxels: TaxelSet
    of_noise: bool

    @property
    def std(self) -> Floats:
        """Standard deviation of each cell, (K,) Pa."""
        return self.taxels.stds[self.of_noise]

    @cached_property
    def felt(self) -> int:
        """Number of cells that feel any noise."""
        return int(np.count_nonzero(self.std))

    def on(self, nodes: NDArray[np.int64]) -> "SetError":
        """Of some of the nodes, in their order."""
        return replace(self, taxels=replace(self.taxels, model=self.taxels.model.on(nodes)))

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        taxels, model = self.taxels, self.taxels.model
        along = weights @ model.turned[cells]
        left = along * taxels.retained - (along @ taxels.lost.T) @ taxels.lost
        if self.of_noise:
            return np.asarray(taxels.variance**2 * (left @ left.T))
        prior = model.prior.covariance_of_sums(cells, weights)
        return np.asarray(taxels.variance * prior - taxels.variance**2 * (left @ along.T))


@dataclass(frozen=True, eq=False)
class GaussianModel:
    r"""Prior of a pressure, scaled to what its taxels read, and all that no set of them changes.

    With readings y of the noise 1 (whitened) and the prior q Q, where q gives the readings of
    the L taxels `snr` times the noise's power, the posterior of a set of them needs
    :math:`(q G + 1)^{-1}` of these taxels alone. G = V diag(g) Vᵀ is split once; a set then costs
    its number of missing taxels (see `TaxelSet`). Q stays that of all taxels: where its length
    follows from their distance, a taxel that is silent does not make the pressure smoother.

    Attributes
    ----------
    turned : (K, L) array, 1/Pa
        Q Aᵀ V: covariance of the pressure with the whitened readings, along V, per q.
    spectrum : (L,) array, 1/Pa²
        g.
    vectors : (L, L) array
        V.
    power : (L,) array, 1/Pa²
        Diagonal of G.
    prior : PressurePosterior
        Q alone, of no readings.
    noise_std : (L,) array, unit of the reading
    offset : (L,) array
        o: deviation of an offset that all taxels share, in units of their noise.
    snr : float
    """

    turned: Floats
    spectrum: Floats
    vectors: Floats
    power: Floats
    prior: PressurePosterior
    noise_std: Floats
    offset: Floats
    snr: float

    @classmethod
    def of(
        cls,
        cross: Floats,
        gram: Floats,
        correlation: Floats,
        noise_std: Floats,
        offset: Floats,
        snr: float,
    ) -> "GaussianModel":
        """Split G (L, L), 1/Pa², A Q Aᵀ of whitened readings; the rest is that of the attributes.

        `cross` (K, L), 1/Pa, is Q Aᵀ of these, `correlation` (rows, columns) Q by what two nodes
        lie apart.
        """
        spectrum, vectors = np.linalg.eigh(gram)
        prior = PressurePosterior.of_lattice(correlation, np.zeros((correlation.size, 0)))
        power = np.diagonal(gram).copy()
        spectrum = np.maximum(spectrum, 0.0)
        return cls(cross @ vectors, spectrum, vectors, power, prior, noise_std, offset, snr)

    def on(self, nodes: NDArray[np.int64]) -> "GaussianModel":
        """The pressure of some of the nodes, in their order."""
        return replace(self, turned=self.turned[nodes], prior=self.prior.on(nodes))

    @cached_property
    def squared(self) -> Floats:
        """Squares of `turned`, (K, L)."""
        return np.square(self.turned)

    def variance(self, valid: NDArray[np.bool_]) -> float:
        """Amplitude q of the prior for a set of taxels (L,), Pa²."""
        return float(self.snr**2 * valid.sum() / (valid @ self.power))
