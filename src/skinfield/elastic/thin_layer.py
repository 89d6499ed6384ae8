"""Published and asymptotic formulas for indentation of a bonded layer, with measured ranges.

Each gives the force over that of the half-space at the same depth, as a function of

    reach = contact radius that the half-space has at that depth, over the thickness:
    sqrt(R depth)/h for a paraboloid, 2 depth/(pi slope h) for a cone, a/h for a flat end.

None is exact. `axisymmetric` is; how far it is from each formula was measured, and is kept beside
the formula as its `ranges`. Outside of them a formula refuses, unless told otherwise.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic.hankel import LayerTransfer, gauss_legendre
from skinfield.errors import Floats, InputError, as_floats, check_positive, check_range

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


def paraboloid_reach(radius: float, depth: float, thickness: float) -> float:
    """Reach of a paraboloid, sqrt(R depth)/h; of a sphere where it is shallow."""
    check_positive("depth", depth, "in metres")
    return float(np.sqrt(radius * depth) / thickness)


def cone_reach(slope: float, depth: float, thickness: float) -> float:
    """Reach of a cone, 2 depth/(pi slope h)."""
    check_positive("depth", depth, "in metres")
    return 2.0 * depth / (np.pi * slope * thickness)


def confined_modulus(poisson_ratio: float) -> float:
    """Modulus of a layer that cannot widen, over Young's: (1 - nu)/((1 + nu)(1 - 2 nu))."""
    check_range("poisson_ratio", poisson_ratio, 0.0, 0.4999, "an incompressible layer has none")
    nu = poisson_ratio
    return (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))


@lru_cache(maxsize=64)
def edge_length(poisson_ratio: float) -> float:
    r"""By how many thicknesses the edge of a wide flat end carries more than the limit says.

    The Wiener-Hopf factor of the layer's response at its edge gives :math:`\lambda =
    \frac{1}{\pi}\int_0^\infty \ln\frac{G(0)}{G(\alpha)}\frac{d\alpha}{\alpha^2}` with
    :math:`G = X(\alpha)/\alpha` for nu < 1/2 and :math:`X(\alpha)/\alpha^3` for nu = 1/2. The end
    acts as one of radius a + lambda h. Derived here; see the docs for the agreement.
    """
    nu = poisson_ratio
    check_range("poisson_ratio", nu, 0.0, 0.5, "0.5 is incompressible")
    power = 3 if nu == 0.5 else 1
    at_zero = 2.0 / 3.0 if nu == 0.5 else (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu) ** 2)
    level, share = gauss_legendre(np.log(1e-5), np.log(1e8), 300)
    alpha = np.exp(level)
    response = LayerTransfer(nu).normal(np.minimum(alpha, 40.0))  # 1 beyond, to all digits
    return float(share @ (np.log(at_zero / response * alpha**power) / alpha) / np.pi)


def _dimitriadis(reach: Floats, nu: float) -> Floats:
    alpha = -(1.2876 - 1.4678 * nu + 1.3442 * nu**2) / (1.0 - nu)
    beta = (0.6387 - 1.0277 * nu + 1.5164 * nu**2) / (1.0 - nu)
    third = -8.0 / np.pi**3 * (alpha**3 + 4.0 * np.pi**2 / 15.0 * beta)
    fourth = 16.0 * alpha / np.pi**4 * (alpha**3 + 3.0 * np.pi**2 / 5.0 * beta)
    second = 4.0 * alpha**2 / np.pi**2
    return 1.0 + reach * (
        -2.0 * alpha / np.pi + reach * (second + reach * (third + reach * fourth))
    )


def _series(*coefficients: float) -> Callable[[Floats, float], Floats]:
    def formula(reach: Floats, nu: float) -> Floats:
        return np.asarray(np.polynomial.polynomial.polyval(reach, np.array([1.0, *coefficients])))

    return formula


def _stiff(nu: float) -> float:
    """Confined modulus over the half-space's E*."""
    return confined_modulus(nu) * (1.0 - nu**2)


_CONE = np.pi / 2.0  # depth/(slope h) per reach
_PUNCH_HALF = 3.0 * np.pi / 64.0
_NOWHERE = (np.inf, np.inf)
DIMITRIADIS = Correction(
    "Dimitriadis 2002",
    "paraboloid",
    "E. K. Dimitriadis et al., Biophys. J. 82 (2002) 2798, bonded layer",
    (0.0, 0.5),
    _dimitriadis,
    (
        *up_to(0.0, (0.546, 0.479), (0.903, 0.749)),
        *up_to(0.3, (0.272, 0.251), (0.651, 0.551)),
        *up_to(0.4, (0.247, 0.228), (0.576, 0.486)),
        *up_to(0.45, (0.232, 0.214), (0.525, 0.442)),
        *up_to(0.5, (0.210, 0.194), (0.459, 0.388)),
    ),
)
DIMITRIADIS_PRINTED = Correction(
    "Dimitriadis 2002, as printed",
    "paraboloid",
    "the same, eq. (12), with coefficients for nu = 1/2",
    (0.5, 0.5),
    _series(1.133, 1.283, 0.769, 0.0975),
    up_to(0.5, (0.212, 0.195), (0.473, 0.398)),
)
_GARCIA = "P. D. Garcia and R. Garcia, Biophys. J. 114 (2018) 2923"
GARCIA_PARABOLOID = Correction(
    "Garcia 2018, paraboloid",
    "paraboloid",
    _GARCIA,
    (0.5, 0.5),
    _series(1.133, 1.497, 1.469, 0.755),
    up_to(0.5, (0.671, 0.535), (1.007, 0.752)),
)
GARCIA_CONE = Correction(
    "Garcia 2018, cone",
    "cone",
    _GARCIA,
    (0.5, 0.5),
    _series(0.721 * _CONE, 0.650 * _CONE**2, 0.491 * _CONE**3, 0.225 * _CONE**4),
    up_to(0.5, (0.902, 0.614), (1.190, 0.767)),
)
GARCIA_PUNCH = Correction(
    "Garcia 2018, flat end",
    "flat end",
    _GARCIA,
    (0.5, 0.5),
    _series(1.133, 1.283, 0.598, -0.291),
    up_to(0.5, (0.620, 0.620), (1.930, 1.930)),
)
_FOUNDATION = (
    "thin compressible layer, p = M w/h: K. L. Johnson, Contact Mechanics (1985), chapter 5"
)
FOUNDATION_PARABOLOID = Correction(
    "elastic foundation, paraboloid",
    "paraboloid",
    _FOUNDATION,
    (0.0, 0.45),
    lambda x, nu: 3.0 * np.pi / 4.0 * _stiff(nu) * x,
    (
        *from_on(0.0, (2.852, 2.144), (1.476, 1.165)),
        *from_on(0.1, (3.544, 2.635), (1.593, 1.247)),
        *from_on(0.2, (3.367, 2.502), (1.484, 1.163)),
        *from_on(0.3, (3.114, 2.3), (0.9279, 0.7529)),
        *from_on(0.4, (15.34, 10.8), (6.131, 4.324)),
        *from_on(0.45, (28.82, 20.04), (12.39, 8.49)),
    ),
)
FOUNDATION_CONE = Correction(
    "elastic foundation, cone",
    "cone",
    _FOUNDATION,
    (0.0, 0.45),
    lambda x, nu: np.pi**3 / 12.0 * _stiff(nu) * x,
    (
        *from_on(0.0, (2.304, 1.585), (1.275, 0.9308)),
        *from_on(0.1, (2.972, 2.01), (1.375, 0.9923)),
        *from_on(0.2, (2.828, 1.912), (1.274, 0.9213)),
        *from_on(0.3, (3.591, 2.371), (0.8074, 0.6122)),
        *from_on(0.4, (13.85, 8.763), (5.804, 3.668)),
        *from_on(0.45, (25.71, 16.05), (11.46, 7.019)),
    ),
)
FOUNDATION_PUNCH = Correction(
    "elastic foundation with its edge, flat end",
    "flat end",
    _FOUNDATION + "; `edge_length`",
    (0.0, 0.45),
    lambda x, nu: np.pi / 2.0 * _stiff(nu) * (x + edge_length(nu)) ** 2 / x,
    (
        *from_on(0.0, (1.098, 1.098), (0.1381, 0.1381)),
        *from_on(0.1, (0.7235, 0.7235), (0.1712, 0.1712)),
        *from_on(0.2, (0.632, 0.632), (0.1597, 0.1597)),
        *from_on(0.3, (1.495, 1.495), (0.6891, 0.6891)),
        *from_on(0.4, (3.491, 3.491), (1.97, 1.97)),
        *from_on(0.45, (5.852, 5.852), (3.562, 3.562)),
    ),
)
_SQUEEZE = "thin incompressible layer, w = -(h³/E) Laplacian p: Johnson (1985), chapter 5"
SQUEEZE_PARABOLOID = Correction(
    "squeezed film, paraboloid",
    "paraboloid",
    _SQUEEZE,
    (0.5, 0.5),
    lambda x, nu: 3.0 * np.pi / 8.0 * x**3,
    from_on(0.5, _NOWHERE, (17.93, 9.608)),
)
SQUEEZE_CONE = Correction(
    "squeezed film, cone",
    "cone",
    _SQUEEZE,
    (0.5, 0.5),
    lambda x, nu: 729.0 * np.pi**2 / 15360.0 * (_CONE * x) ** 3,
    from_on(0.5, _NOWHERE, (16.54, 7.577)),
)
SQUEEZE_PUNCH = Correction(
    "squeezed film with its edge, flat end",
    "flat end",
    _SQUEEZE + "; `edge_length`",
    (0.5, 0.5),
    lambda x, nu: _PUNCH_HALF * (x + edge_length(0.5)) ** 4 / x,
    from_on(0.5, (6.994, 6.994), (3.491, 3.491)),
)
CORRECTIONS = (
    DIMITRIADIS,
    DIMITRIADIS_PRINTED,
    GARCIA_PARABOLOID,
    GARCIA_CONE,
    GARCIA_PUNCH,
    FOUNDATION_PARABOLOID,
    FOUNDATION_CONE,
    FOUNDATION_PUNCH,
    SQUEEZE_PARABOLOID,
    SQUEEZE_CONE,
    SQUEEZE_PUNCH,
)
