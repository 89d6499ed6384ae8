"""Gaussian prior seen by taxels, of which any may be missing: posteriors of sets of taxels."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.estimate import PressurePosterior

CANCELLED = 1e-4  # of a variance, below which the difference of two is computed cell by cell


@dataclass(frozen=True, eq=False)
class TaxelSets:
    r"""Posteriors of P sets of the L taxels of a `GaussianModel`.

    Leaving the taxels I out of H = (q G + 1)⁻¹ leaves, by the inverse of a block matrix (Golub and
    Van Loan, Matrix Computations, section 2.1.4), :math:`H - H_{:I} H_{II}^{-1} H_{I:}`, whose
    rows and columns of I are 0. Along the vectors V this is diag(d) - Bᵀ B with d = 1 / (q g + 1)
    and as many rows of B as taxels are missing. The noise of an offset o that taxels share adds
    o oᵀ to 1, which takes one more row: :math:`H o / \sqrt{1 + o^T H o}`.

    Attributes
    ----------
    model : GaussianModel
    valid : (P, L) bool array
    variance : (P,) array, Pa²
        q.
    retained : (P, L) array
        d.
    lost : (P, M, L) array
        B; M is the largest number of missing taxels, and one more where they share an offset. The
        rows beyond a set's own are 0.
    """

    model: "GaussianModel"
    valid: NDArray[np.bool_]
    variance: Floats
    retained: Floats
    lost: Floats

    @classmethod
    def of(cls, model: "GaussianModel", valid: NDArray[np.bool_]) -> "TaxelSets":
        """See `GaussianModel.sets`."""
        variance = model.variance(valid)
        kept = 1.0 / (variance[:, None] * model.spectrum + 1.0)
        most = int((~valid).sum(axis=1).max(initial=0))
        taxel = np.argsort(valid, axis=1, kind="stable")[:, :most]  # the missing ones first
        missing = ~np.take_along_axis(valid, taxel, axis=1)
        rows = model.vectors[taxel] * missing[..., None]
        block = (rows * kept[:, None]) @ rows.transpose(0, 2, 1)
        corner = np.arange(most)
        block[:, corner, corner] += ~missing
        lower = np.linalg.cholesky(block)
        lost = np.linalg.solve(lower, rows * kept[:, None])
        if model.offset.any():
            along = (valid * model.offset) @ model.vectors
            less = (lost @ along[..., None])[..., 0]
            seen = kept * along - np.einsum("pml,pm->pl", lost, less)  # V' H o
            size = np.sqrt(1.0 + np.einsum("pl,pl->p", along, seen))
            lost = np.concatenate([lost, (seen / size[:, None])[:, None]], axis=1)
        return cls(model, valid, variance, kept, lost)

    def weights(self, readings: Floats, which: NDArray[np.int64]) -> Floats:
        """Vᵀ (q G + 1)⁻¹ y of linearised readings (T, L), each of the set `which` (T,): (T, L).

        What stands in place of missing readings must be finite; it does not count.
        """
        whitened = np.where(self.valid[which], readings / self.model.noise_std, 0.0)
        along = whitened @ self.model.vectors
        lost = self.lost[which]
        told = np.einsum("tml,tl->tm", lost, along)
        return np.asarray(self.retained[which] * along - np.einsum("tml,tm->tl", lost, told))

    def filled(self, readings: Floats, which: NDArray[np.int64]) -> Floats:
        """Readings of all taxels from which the operator of all of them gives a set's answer.

        Where the prior's amplitude is the same, missing readings become what the others predict.
        """
        model = self.model
        whole = float(model.variance(np.ones((1, len(model.power)), np.bool_))[0])
        share = (self.variance[which] / whole)[:, None]
        weights = self.weights(readings, which) * share
        along = weights * (whole * model.spectrum + 1.0)
        offset = weights @ (model.offset @ model.vectors)
        filled = along @ model.vectors.T + np.outer(offset, model.offset)
        return np.asarray(filled * model.noise_std)

    @cached_property
    def stds(self) -> tuple[Floats, Floats]:
        """Standard deviations of each cell: of the posterior, and of the readings' noise.

        Returns
        -------
        posterior, noise : (P, K) arrays, Pa
        """
        model, scale = self.model, self.variance[:, None]
        count, most, taxels = self.lost.shape
        rows = np.concatenate([self.lost, self.lost * self.retained[:, None]], axis=1)
        told = (rows.reshape(-1, taxels) @ model.turned.T).reshape(count, 2 * most, -1)
        first, second = told[:, :most], told[:, most:]
        explained = self.retained @ model.squared.T - np.einsum("pmk,pmk->pk", first, first)
        across = self.lost @ self.lost.transpose(0, 2, 1)
        whole = np.square(self.retained) @ model.squared.T
        less = 2.0 * second - across @ first
        moved = whole - np.einsum("pmk,pmk->pk", first, less)
        self._mend(moved, whole)
        open_still = model.prior.prior[0, 0] - scale * explained
        posterior = np.sqrt(np.maximum(scale * open_still, 0.0))
        return posterior, scale * np.sqrt(moved)

    def _mend(self, moved: Floats, whole: Floats) -> None:
        """Compute anew, without the difference of squares, what is left of a variance (P, K)."""
        which, cell = np.nonzero(moved < CANCELLED * whole)
        along = self.model.turned[cell]
        lost = self.lost[which]
        told = np.einsum("nml,nl->nm", lost, along)
        left = along * self.retained[which] - np.einsum("nml,nm->nl", lost, told)
        moved[which, cell] = np.einsum("nl,nl->n", left, left)

    @property
    def errors(self) -> "list[tuple[SetError, SetError]]":
        """Posterior of each set's pressure, and its error by the readings' noise alone."""
        count = range(len(self.valid))
        return [(SetError(self, which, False), SetError(self, which, True)) for which in count]


@dataclass(frozen=True, eq=False)
class SetError:
    """How far the pressure of a set of taxels may be off; see `estimate.PressureError`.

    Attributes
    ----------
    sets : TaxelSets
    which : int
    of_noise : bool
        By the readings' noise alone; else of the posterior.
    """

    sets: TaxelSets
    which: int
    of_noise: bool

    @property
    def std(self) -> Floats:
        """Standard deviation of each cell, (K,) Pa."""
        return np.asarray(self.sets.stds[self.of_noise][self.which])

    @cached_property
    def felt(self) -> int:
        """Number of cells that feel any noise."""
        return int(np.count_nonzero(self.std))

    def on(self, nodes: NDArray[np.int64]) -> "SetError":
        """Of some of the nodes, in their order."""
        return replace(self, sets=replace(self.sets, model=self.sets.model.on(nodes)))

    def covariance_of_sums(self, cells: NDArray[np.int64], weights: Floats) -> Floats:
        """Covariance (M, M) of M weighted sums over some cells; weights (M, cells), times Pa."""
        sets, model = self.sets, self.sets.model
        kept, lost = sets.retained[self.which], sets.lost[self.which]
        variance = float(sets.variance[self.which])
        along = weights @ model.turned[cells]
        left = along * kept - (along @ lost.T) @ lost
        if self.of_noise:
            return np.asarray(variance**2 * (left @ left.T))
        prior = model.prior.covariance_of_sums(cells, weights)
        return np.asarray(variance * prior - variance**2 * (left @ along.T))


@dataclass(frozen=True, eq=False)
class GaussianModel:
    r"""Prior of a pressure, scaled to what its taxels read, and all that no set of them changes.

    With readings y of the noise 1 (whitened) and the prior q Q, where q gives the readings of
    the L taxels `snr` times the noise's power, the posterior of a set of them needs
    :math:`(q G + 1)^{-1}` of these taxels alone. G = V diag(g) Vᵀ is split once; a set then costs
    its number of missing taxels (see `TaxelSets`). Q stays that of all taxels: where its length
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

    def variance(self, valid: NDArray[np.bool_]) -> Floats:
        """Amplitude q of the prior for sets of taxels (P, L): (P,) Pa²."""
        return np.asarray(self.snr**2 * valid.sum(axis=1) / (valid @ self.power))

    def sets(self, valid: NDArray[np.bool_]) -> TaxelSets:
        """Posteriors of P sets of taxels, by masks (P, L), each of at least one taxel."""
        return TaxelSets.of(self, valid)
