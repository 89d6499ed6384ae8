"""Linear viscoelasticity: what turns the history of a load into the load of an elastic solution."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_positive,
    check_shape,
)

Branches = tuple[tuple[float, float], ...]


def lagged(
    time: ArrayLike, values: ArrayLike, time_constant: float, *, start: ArrayLike = 0.0
) -> Floats:
    """First-order lag z of a history: τ dz/dt = values - z.

    Exact for a history that is linear between its samples, at any spacing of these, so no error
    gathers; a step is two samples at one time.

    Parameters
    ----------
    time : (T,) array, s
        Never falls.
    values : (T,) or (T, ...) array
    time_constant : float, s
        τ; 0 for no lag.
    start : float or array of the shape of one row
        z at the first time. 0: at rest until then, so that a first value other than 0 is a step.

    Returns
    -------
    array of the shape of `values`

    Raises
    ------
    InputError
        If a time is not finite or falls, a value is not finite, or the lengths differ.
    """
    time, values = _history(time, values)
    if time_constant == 0.0:
        return values.copy()
    check_positive("time_constant", time_constant, "of the lag, in seconds")
    ahead = np.diff(time) / time_constant
    decay = np.exp(-ahead)
    ratio = np.divide(-np.expm1(-ahead), ahead, out=np.ones_like(ahead), where=ahead > 0)
    shape = (-1,) + (1,) * (values.ndim - 1)
    old, new = (ratio - decay).reshape(shape), (1.0 - ratio).reshape(shape)
    gain = old * values[:-1] + new * values[1:]
    out = np.empty_like(values)
    out[0] = start
    for sample, keep in enumerate(decay):
        out[sample + 1] = keep * out[sample] + gain[sample]
    return out


def _history(time: ArrayLike, values: ArrayLike) -> tuple[Floats, Floats]:
    time, values = as_floats("time", time), as_floats("values", values)
    check_shape("time", time, (None,), "one per sample, in seconds")
    if not len(time) or values.ndim == 0 or len(values) != len(time):
        raise InputError(
            f"values has shape {values.shape}, expected ({len(time)}, ...) with at least one row: "
            "one per sample of time"
        )
    check_finite("time", time, "every sample has its time")
    check_finite("values", values, "a gap in a history has to be filled before")
    if (np.diff(time) < 0).any():
        sample = int(np.argmax(np.diff(time) < 0)) + 1
        raise InputError(
            f"time[{sample}] is {time[sample]} s after {time[sample - 1]} s, expected times that "
            "never fall: sort the samples"
        )
    return time, values


class Viscoelastic(ABC):
    """A generalised Maxwell solid: E(t) = E₀ [1 - Σ fᵢ (1 - exp(-t/τᵢ))], Poisson's ratio fixed.

    E₀ is the instantaneous modulus and E∞ = E₀ (1 - Σ fᵢ) the relaxed one. A layer's
    `young_modulus` is taken as **relaxed**: it is measured slowly, and a load that stands for long
    then gives the elastic result.

    Notes
    -----
    As all moduli relax in proportion, a displacement field of the viscoelastic body under a load
    F(t) is that of the elastic one under another load, `effective_force` (correspondence
    principle; for contacts whose area grows, Lee and Radok, J. Appl. Mech. 27, 1960). This holds
    for any thickness and any indenter, during loading, hold and creep. Once the contact area
    shrinks it is an approximation (Ting, J. Appl. Mech. 33, 1966, has the exact way): an imprint
    that the indenter has left is taken for one that it still makes with a smaller force.
    """

    @property
    @abstractmethod
    def branches(self) -> Branches:
        """(fᵢ, τᵢ): part of E₀ that relaxes, and its relaxation time, s."""

    @property
    def relaxed_modulus_fraction(self) -> float:
        """E∞ / E₀."""
        return 1.0 - sum(part for part, _ in self.branches)

    @cached_property
    def retardation(self) -> Branches:
        """(cₖ, λₖ): E₀ J(t) = 1 + Σ cₖ (1 - exp(-t/λₖ)), J being the creep compliance; λ in s.

        From the eigenvalues of the internal strains under constant stress, which a scaling by
        √(fᵢ τᵢ) makes a symmetric problem. For one branch, c = f/(1 - f) and λ = τ/(1 - f).
        """
        if not self.branches:
            return ()
        part, time = np.array(self.branches, dtype=np.float64).T
        drive = np.sqrt(part / time)
        rates, modes = np.linalg.eigh(np.diag(1.0 / time) - np.outer(drive, drive))
        strength = (drive @ modes) ** 2 / rates
        return tuple(zip(strength.tolist(), (1.0 / rates).tolist(), strict=True))

    def relaxation(self, time: ArrayLike) -> Floats:
        """E(t) / E∞ at `time`, s, after a step of strain; E₀ / E∞ at 0, falling to 1."""
        return (1.0 - _gone(time, self.branches)) / self.relaxed_modulus_fraction

    def creep(self, time: ArrayLike) -> Floats:
        """E∞ J(t) at `time`, s, after a step of stress; E∞ / E₀ at 0, rising to 1."""
        return (1.0 + _gone(time, self.retardation)) * self.relaxed_modulus_fraction

    def effective_force(self, time: ArrayLike, force: ArrayLike) -> Floats:
        """Load at which the elastic solution, with E∞, has the displacements of this moment.

        ∫ E∞ J(t - s) dF(s), exact for a force that is linear between its samples.

        Parameters
        ----------
        time : (T,) array, s
            Never falls; two samples at one time are a step.
        force : (T,) or (T, ...) array, N
            Unloaded before the first time, so a first value other than 0 is a step.

        Returns
        -------
        array of the shape of `force`, N
            E∞/E₀ of a step at once, all of it in the end: never beyond the largest force so far,
            so elastic solutions up to that one are enough. With E₀ in the place of E∞, divide by
            `relaxed_modulus_fraction`.
        """
        time, force = _history(time, force)
        late = sum(part * lagged(time, force, tau) for part, tau in self.retardation)
        return (force + late) * self.relaxed_modulus_fraction

    def relaxing_force(self, time: ArrayLike, elastic_force: ArrayLike) -> Floats:
        """Force, N, while a depth is imposed: ∫ E(t - s)/E∞ dF∞(s).

        Parameters
        ----------
        time : (T,) array, s
        elastic_force : (T,) or (T, ...) array, N
            F∞, of the elastic solution with E∞ at the depth of each sample; linear between them.
            Exact while the contact area grows, as `effective_force` is.
        """
        time, elastic = _history(time, elastic_force)
        lost = sum(part * lagged(time, elastic, tau) for part, tau in self.branches)
        return (elastic - lost) / self.relaxed_modulus_fraction


@dataclass(frozen=True)
class StandardLinearSolid(Viscoelastic):
    """One relaxation time: E(t) = E∞ + (E₀ - E∞) exp(-t/τ).

    Parameters
    ----------
    relaxed_fraction : float
        E∞ / E₀, above 0 and up to 1. The default is assumed, typical of soft silicones.
    time_constant : float, s
        τ, of relaxation at constant strain; creep at constant load takes τ E₀ / E∞. Assumed.
    """

    relaxed_fraction: float = 0.85
    time_constant: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.relaxed_fraction <= 1.0:
            raise InputError(
                f"relaxed_fraction is {self.relaxed_fraction!r}, expected a number above 0 and up "
                "to 1: the relaxed modulus over the instantaneous one; 1 is an elastic solid"
            )
        check_positive("time_constant", self.time_constant, "of the relaxation, in seconds")

    @property
    def branches(self) -> Branches:
        """See `Viscoelastic.branches`."""
        part = 1.0 - self.relaxed_fraction
        return ((part, float(self.time_constant)),) if part > 0 else ()


@dataclass(frozen=True)
class PronySeries(Viscoelastic):
    """Several relaxation times.

    Parameters
    ----------
    terms : tuple of (float, float)
        (fᵢ, τᵢ): part of the instantaneous modulus that relaxes, all above 0 and below 1 in sum,
        and the time that it takes, s.
    """

    terms: Branches

    def __post_init__(self) -> None:
        terms = as_floats("terms", self.terms)
        check_shape("terms", terms, (None, 2), "(fraction, seconds) of each branch")
        check_finite("terms", terms, "each branch has a fraction and a time")
        if (terms <= 0).any() or not terms[:, 0].sum() < 1.0:
            raise InputError(
                f"terms is {self.terms!r}, expected fractions and times above 0, and fractions "
                f"that sum to less than 1, not {terms[:, 0].sum():g}: what is left is the relaxed "
                "modulus over the instantaneous one"
            )
        object.__setattr__(self, "terms", tuple((float(f), float(t)) for f, t in terms))

    @property
    def branches(self) -> Branches:
        """See `Viscoelastic.branches`."""
        return self.terms


def _gone(time: ArrayLike, branches: Branches) -> Floats:
    """Sum of part · (1 - exp(-t/τ)) over branches (part, τ)."""
    time = as_floats("time", time)
    if not (time >= 0).all():
        raise InputError(f"time is {time}, expected seconds from 0: nothing moves before the step")
    return np.asarray(sum(part * -np.expm1(-time / tau) for part, tau in branches))
