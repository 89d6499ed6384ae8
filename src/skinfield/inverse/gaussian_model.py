"""A Gaussian prior seen by taxels, of which any may be missing."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.fields import PressurePosterior
from skinfield.inverse.taxel_sets import TaxelSets


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
    snr : float
    """

    turned: Floats
    spectrum: Floats
    vectors: Floats
    power: Floats
    prior: PressurePosterior
    noise_std: Floats
    snr: float

    @classmethod
    def of(
        cls,
        cross: Floats,
        gram: Floats,
        correlation: Floats,
        noise_std: Floats,
        snr: float,
    ) -> "GaussianModel":
        """Split G.

        Parameters
        ----------
        cross : (K, L) array, 1/Pa
            Q Aᵀ, of whitened readings.
        gram : (L, L) array, 1/Pa²
            G = A Q Aᵀ, of whitened readings.
        correlation : (rows, columns) array
            Q of two nodes by their offset.
        noise_std : (L,) array, unit of the reading
        snr : float
        """
        spectrum, vectors = np.linalg.eigh(gram)
        prior = PressurePosterior.of_lattice(correlation, np.zeros((correlation.size, 0)))
        power = np.diagonal(gram).copy()
        spectrum = np.maximum(spectrum, 0.0)
        return cls(cross @ vectors, spectrum, vectors, power, prior, noise_std, snr)

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
