"""Linear viscoelasticity: what turns the history of a load into the load of an elastic solution."""

from dataclasses import dataclass

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


@dataclass(frozen=True)
class StandardLinearSolid:
    """One relaxation time: E(t) = E∞ + (E₀ - E∞) exp(-t/τ), Poisson's ratio fixed.

    E₀ is the instantaneous modulus and E∞ the relaxed one. A layer's `young_modulus` is taken as
    **relaxed**: it is measured slowly, and a load that stands for long then gives the elastic
    result.

    Parameters
    ----------
    relaxed_fraction : float
        E∞ / E₀, above 0 and up to 1. The default is assumed, typical of soft silicones.
    time_constant : float, s
        τ, of relaxation at constant strain; creep at constant load takes τ E₀ / E∞. Assumed.

    Notes
    -----
    As all moduli relax in proportion, a displacement field of the viscoelastic body under a load
    F(t) is that of the elastic one under another load, `effective_force` (correspondence
    principle; for contacts whose area grows, Lee and Radok, J. Appl. Mech. 27, 1960). This holds
    for any thickness and any indenter, during loading, hold and creep. Once the contact area
    shrinks it is an approximation (Ting, J. Appl. Mech. 33, 1966, has the exact way): an imprint
    that the indenter has left is taken for one that it still makes with a smaller force.
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
    def retardation_time(self) -> float:
        """τ E₀ / E∞, s: of creep at constant load, E∞ J(t) = 1 - (1 - E∞/E₀) exp(-t/·)."""
        return self.time_constant / self.relaxed_fraction

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
            `relaxed_fraction`.
        """
        time, force = _history(time, force)
        late = lagged(time, force, self.retardation_time)
        return self.relaxed_fraction * force + (1.0 - self.relaxed_fraction) * late

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
        lost = (1.0 - self.relaxed_fraction) * lagged(time, elastic, self.time_constant)
        return (elastic - lost) / self.relaxed_fraction
