"""A formula for indentation of a bonded layer, with the range in which it was found to hold."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_range

ERRORS = (0.01, 0.05)  # relative, of the force; for each there is a range


@dataclass(frozen=True)
class Range:
    """Where a formula is within an error of the exact force.

    Attributes
    ----------
    poisson_ratio, error : float
    a_over_h : (low, high)
        Of the true contact radius; measured from 0.02 to 30, beyond which a limit holds on.
    reach : (low, high)
        The same ends as the formula's argument.
    """

    poisson_ratio: float
    error: float
    a_over_h: tuple[float, float]
    reach: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Correction:
    """Force on the layer over force on the half-space at the same depth.

    Attributes
    ----------
    name : str
    body : str
        "paraboloid", "cone" or "flat end".
    source : str
    poisson_ratios : (low, high)
        For which the formula is given.
    formula : function of reach (array) and Poisson's ratio
        Unchecked.
    ranges : tuple of Range
        Measured; those of a Poisson's ratio that was not are the narrower of its neighbours'.
    """

    name: str
    body: str
    source: str
    poisson_ratios: tuple[float, float]
    formula: Callable[[Floats, float], Floats]
    ranges: tuple[Range, ...]

    def __call__(
        self,
        reach: ArrayLike,
        poisson_ratio: float = 0.5,
        *,
        error: float = 0.05,
        beyond_range: bool = False,
    ) -> Floats:
        """Evaluate the formula where it holds.

        Parameters
        ----------
        reach : array
            See `thin_layer`.
        poisson_ratio : float
        error : 0.01 or 0.05
            Which must not be exceeded.
        beyond_range : bool
            Evaluate all the same.

        Raises
        ------
        InputError
            Outside the range, which is told, or for another Poisson's ratio.
        """
        reach = as_floats("reach", reach)
        check_range("poisson_ratio", poisson_ratio, *self.poisson_ratios, f"of {self.name}")
        if not beyond_range:
            low, high = self.valid_reach(poisson_ratio, error)
            wrong = ~((reach >= low) & (reach <= high))
            if wrong.any():
                raise InputError(
                    f"reach is {reach[wrong].ravel()[0]:.4g}, expected {low:.4g} to {high:.4g}, "
                    f"where {self.name} is within {error:.0%} for a Poisson's ratio of "
                    f"{poisson_ratio:g}: use `axisymmetric`, or beyond_range=True"
                )
        return self.formula(reach, poisson_ratio)

    def valid_reach(self, poisson_ratio: float, error: float = 0.05) -> tuple[float, float]:
        """Lowest and highest reach where the error is kept; InputError if it is nowhere."""
        return self._common("reach", poisson_ratio, error)

    def valid_a_over_h(self, poisson_ratio: float, error: float = 0.05) -> tuple[float, float]:
        """The same, of the true contact radius over the thickness."""
        return self._common("a_over_h", poisson_ratio, error)

    def _common(self, name: str, nu: float, error: float) -> tuple[float, float]:
        if error not in ERRORS:
            raise InputError(f"error is {error!r}, expected one of {ERRORS}: those were measured")
        known = sorted({each.poisson_ratio for each in self.ranges})
        below = max((each for each in known if each <= nu + 1e-9), default=known[0])
        above = min((each for each in known if each >= nu - 1e-9), default=known[-1])
        parts = [
            getattr(each, name)
            for each in self.ranges
            if each.error == error and each.poisson_ratio in (below, above)
        ]
        low, high = max(part[0] for part in parts), min(part[1] for part in parts)
        if low >= high:
            raise InputError(
                f"{self.name} is nowhere within {error:.0%} for a Poisson's ratio of {nu:g}: use "
                "`axisymmetric`"
            )
        return low, high


def up_to(nu: float, one: tuple[float, float], five: tuple[float, float]) -> tuple[Range, ...]:
    """Ranges from zero to (a/h, reach), at 1 % and 5 %."""
    return tuple(
        Range(nu, error, (0.0, end[0]), (0.0, end[1]))
        for error, end in zip(ERRORS, (one, five), strict=True)
    )


def from_on(nu: float, one: tuple[float, float], five: tuple[float, float]) -> tuple[Range, ...]:
    """Ranges from (a/h, reach) on, at 1 % and 5 %; infinite where it was not reached."""
    return tuple(
        Range(nu, error, (start[0], np.inf), (start[1], np.inf))
        for error, start in zip(ERRORS, (one, five), strict=True)
    )
