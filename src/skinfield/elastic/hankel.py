r"""Transfer functions of a bonded elastic layer, and their inverse Hankel transforms as tables.

A layer 0 <= z <= h, fixed at z = 0, loaded by a traction t on z = h. With k the wave number,
alpha = k h, and the components along k (t_x), across it (t_y) and outwards (t_z), the general
solution of the equations of equilibrium (cosh and sinh of k z, times polynomials of first degree)
and the four boundary conditions give every response as a ratio with the denominator

.. math:: D = (3 - 4\nu)\cosh 2\alpha + 2\alpha^2 + 8\nu^2 - 12\nu + 5.

`LayerTransfer` and `CoveredTransfer` take arrays over alpha, are free of overflow and cancellation
for every alpha > 0 and 0 <= nu <= 1/2, and are scaled by exp(-2 alpha) above and below the bar.
`RadialKernel` brings a transform back to real space, as a table that costs one look-up.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import factorial

import numpy as np

from skinfield.errors import Floats

CLOSE = 0.5  # alpha below which differences of hyperbolic functions are summed as power series


def _series(alpha: Floats, first: int, coefficient: Callable[[int], float]) -> Floats:
    """Sum of coefficient(n) alpha^n over n = first, first + 2, ...; exact up to `CLOSE`."""
    small = np.minimum(alpha, CLOSE)
    terms = [coefficient(n) * small**n for n in range(first, first + 16, 2)]
    return np.asarray(sum(terms))


def _sinh_less_linear(alpha: Floats) -> Floats:
    """(sinh 2 alpha - 2 alpha) exp(-2 alpha)."""
    square = np.exp(-2 * alpha)
    series = _series(alpha, 3, lambda n: 2**n / factorial(n))
    return np.where(alpha < CLOSE, series * square, (1 - square**2) / 2 - 2 * alpha * square)


def _sinh_squared_less_square(alpha: Floats) -> Floats:
    """(sinh² alpha - alpha²) exp(-2 alpha)."""
    square = np.exp(-2 * alpha)
    series = _series(alpha, 4, lambda n: 2 ** (n - 1) / factorial(n))
    return np.where(alpha < CLOSE, series * square, (1 - square) ** 2 / 4 - alpha**2 * square)


def _cosh_less_sinh(alpha: Floats) -> Floats:
    """(alpha cosh alpha - sinh alpha) exp(-alpha)."""
    decay = np.exp(-alpha)
    series = _series(alpha, 3, lambda n: (n - 1) / factorial(n))
    closed = (alpha * (1 + decay**2) - (1 - decay**2)) / 2
    return np.where(alpha < CLOSE, series * decay, closed)


@dataclass(frozen=True)
class LayerTransfer:
    r"""Responses of the bonded layer to harmonic tractions.

    Displacements are :math:`2(1-\nu^2)/(Ek)` times `normal` and `tangential`,
    :math:`(1+\nu)/(Ek)` times `coupling` and :math:`2(1+\nu)/(Ek)` times `antiplane`; each tends
    to its half-space value 1, 1, -(1 - 2 nu), 1 as alpha grows, and `*_rest` is the difference,
    which falls as exp(-2 alpha). `base_*` are tractions on z = 0 per traction on z = h.
    """

    poisson_ratio: float

    def _terms(self, alpha: Floats) -> tuple[Floats, Floats, Floats]:
        nu, decay = self.poisson_ratio, np.exp(-alpha)
        constant = 2 * alpha**2 + 8 * nu**2 - 12 * nu + 5
        square = decay**2
        denominator = (3 - 4 * nu) * (1 + square**2) / 2 + constant * square
        return decay, constant, denominator

    def normal_rest(self, alpha: Floats) -> Floats:
        """Normal displacement per normal traction, less the half-space's 1."""
        decay, constant, denominator = self._terms(alpha)
        square = decay**2
        above = -(3 - 4 * self.poisson_ratio) * square - 2 * alpha - constant
        return np.asarray(above * square / denominator)

    def normal(self, alpha: Floats) -> Floats:
        """Normal displacement per normal traction; (2/3) alpha³ at small alpha for nu = 1/2."""
        nu = self.poisson_ratio
        decay, _, denominator = self._terms(alpha)
        above = (3 - 4 * nu) * _sinh_less_linear(alpha) + (2 - 4 * nu) * 2 * alpha * decay**2
        return np.asarray(above / denominator)

    def tangential_rest(self, alpha: Floats) -> Floats:
        """Displacement along k per traction along k, less the half-space's 1."""
        decay, constant, denominator = self._terms(alpha)
        square = decay**2
        above = -(3 - 4 * self.poisson_ratio) * square + 2 * alpha - constant
        return above * square / denominator

    def tangential(self, alpha: Floats) -> Floats:
        """Displacement along k per traction along k; alpha / (1 - nu) at small alpha."""
        decay, _, denominator = self._terms(alpha)
        above = -(3 - 4 * self.poisson_ratio) * np.expm1(-4 * alpha) / 2 + 2 * alpha * decay**2
        return np.asarray(above / denominator)

    def coupling_rest(self, alpha: Floats) -> Floats:
        """Tangential displacement per normal traction, plus the half-space's (1 - 2 nu)."""
        nu = self.poisson_ratio
        decay, _, denominator = self._terms(alpha)
        above = 4 * (1 - nu) * alpha**2 + 8 * (1 - 2 * nu) * (1 - nu) ** 2
        return above * decay**2 / denominator

    def coupling(self, alpha: Floats) -> Floats:
        """Tangential displacement per normal traction; -(1 - 4 nu) alpha² / (2 - 2 nu) at first."""
        nu = self.poisson_ratio
        decay, _, denominator = self._terms(alpha)
        above = -4 * (1 - nu) * (1 - 4 * nu) * (alpha * decay) ** 2
        above -= 2 * (3 - 4 * nu) * (1 - 2 * nu) * _sinh_squared_less_square(alpha)
        return np.asarray(above / denominator)

    def antiplane_rest(self, alpha: Floats) -> Floats:
        """Displacement across k per traction across k, tanh(alpha), less the half-space's 1."""
        square = np.exp(-2 * alpha)
        return np.asarray(-2 * square / (1 + square))

    def base_normal(self, alpha: Floats) -> Floats:
        """Normal traction on the base per normal traction; 1 at alpha = 0 (equilibrium)."""
        sinh, cosh = self._scaled_hyperbolic(alpha)
        return self._base(alpha, alpha * sinh + 2 * (1 - self.poisson_ratio) * cosh)

    def base_shear_from_normal(self, alpha: Floats) -> Floats:
        """Traction along k on the base per normal traction; nu alpha / (1 - nu) at first."""
        sinh, _ = self._scaled_hyperbolic(alpha)
        return self._base(alpha, _cosh_less_sinh(alpha) + 2 * self.poisson_ratio * sinh)

    def base_shear(self, alpha: Floats) -> Floats:
        """Traction along k on the base per traction along k; 1 at alpha = 0."""
        sinh, cosh = self._scaled_hyperbolic(alpha)
        return self._base(alpha, 2 * (1 - self.poisson_ratio) * cosh - alpha * sinh)

    def base_normal_from_shear(self, alpha: Floats) -> Floats:
        """Normal traction on the base per traction along k; -alpha at small alpha (moment)."""
        sinh, cosh = self._scaled_hyperbolic(alpha)
        return self._base(alpha, -alpha * cosh - (1 - 2 * self.poisson_ratio) * sinh)

    def base_antiplane(self, alpha: Floats) -> Floats:
        """Traction across k on the base per traction across k: 1 / cosh(alpha)."""
        return np.asarray(2 * np.exp(-alpha) / (1 + np.exp(-2 * alpha)))

    @staticmethod
    def _scaled_hyperbolic(alpha: Floats) -> tuple[Floats, Floats]:
        """The sinh and cosh of alpha, times exp(-alpha)."""
        return -np.expm1(-2 * alpha) / 2, (1 + np.exp(-2 * alpha)) / 2

    def _base(self, alpha: Floats, above: Floats) -> Floats:
        """A traction on the base: 4 (1 - nu) / D times `above`, which carries exp(-alpha)."""
        decay, _, denominator = self._terms(alpha)
        return np.asarray(4 * (1 - self.poisson_ratio) * above * decay / denominator)


@dataclass(frozen=True)
class CoveredTransfer:
    """The same layer under a cover that stretches nowhere (a conductive fabric), nu = any.

    The cover holds the surface's tangential displacement at zero by whatever shear it takes, so
    only a normal traction moves anything.
    """

    poisson_ratio: float

    @property
    def _free(self) -> LayerTransfer:
        return LayerTransfer(self.poisson_ratio)

    @property
    def half_space_factor(self) -> float:
        """Limit of `normal` at large alpha: the half-space under an inextensible cover."""
        nu = self.poisson_ratio
        return 1 - ((1 - 2 * nu) / (2 * (1 - nu))) ** 2

    def _shear_taken(self, alpha: Floats) -> Floats:
        """Traction along k that the cover exerts per normal traction, with opposite sign."""
        free = self._free
        return free.coupling(alpha) / (2 * (1 - self.poisson_ratio) * free.tangential(alpha))

    def normal_rest(self, alpha: Floats) -> Floats:
        """Normal displacement per normal traction, less `half_space_factor`."""
        nu = self.poisson_ratio
        held = self._shear_taken(alpha) * self._free.coupling(alpha) / (2 * (1 - nu))
        return np.asarray(self._free.normal_rest(alpha) - held + (1 - self.half_space_factor))

    def normal(self, alpha: Floats) -> Floats:
        """Normal displacement per normal traction; alpha³/6 at small alpha for nu = 1/2."""
        nu = self.poisson_ratio
        held = self._shear_taken(alpha) * self._free.coupling(alpha) / (2 * (1 - nu))
        return self._free.normal(alpha) - held

    def base_normal(self, alpha: Floats) -> Floats:
        """Normal traction on the base per normal traction."""
        free, taken = self._free, self._shear_taken(alpha)
        return free.base_normal(alpha) - free.base_normal_from_shear(alpha) * taken

    def base_shear_from_normal(self, alpha: Floats) -> Floats:
        """Traction along k on the base per normal traction."""
        free, taken = self._free, self._shear_taken(alpha)
        return free.base_shear_from_normal(alpha) - free.base_shear(alpha) * taken


DEGREE = 12  # of the polynomial on one panel
PANEL = 0.25  # width of a panel; kernels are analytic within 1 (the layer's depth) of the real axis
CHUNK = 1 << 14  # points per pass, so that its few arrays stay in cache


def bessel(order: int, x: Floats) -> Floats:
    """Bessel function J0, J1 or J2; the recurrence is ten times faster than the general routine."""
    from scipy.special import j0, j1

    if order < 2:
        return np.asarray((j0, j1)[order](x))
    safe, quarter = np.maximum(x, 1.0), np.minimum(x, 1.0) ** 2 / 4
    series = np.zeros_like(quarter)
    for n in range(8, -1, -1):  # of J2, where the recurrence cancels
        series = 1 / (factorial(n) * factorial(n + 2)) - quarter * series
    return np.where(x < 1.0, quarter * series, 2 * j1(safe) / safe - j0(safe))


@lru_cache(maxsize=64)
def gauss_legendre(low: float, high: float, panels: int, order: int = 20) -> tuple[Floats, Floats]:
    """Nodes and weights of a composite Gauss-Legendre rule on [low, high]."""
    node, weight = np.polynomial.legendre.leggauss(order)
    edge = np.linspace(low, high, panels + 1)
    half = np.diff(edge)[:, None] / 2
    nodes = (edge[:-1, None] + half) + half * node
    return nodes.ravel(), (half * weight).ravel()


@dataclass(frozen=True, eq=False)
class RadialKernel:
    r"""The function :math:`K_n(\rho)/\rho^n`, :math:`K_n = \int_0^\infty f(a) J_n(a\rho)\,da`.

    Lengths are in units of the layer's thickness. Tabulated as polynomials on short panels,
    interpolated at Chebyshev points (error near 1e-14 of the peak), zero beyond `reach`.

    Parameters
    ----------
    transform : function of alpha
        f, an array over alpha > 0 that has decayed below 1e-17 at `cutoff`.
    order : 0, 1 or 2
        n of the Bessel function.
    cutoff : float
        End of the integral.
    reach : float
        Where the kernel is taken as zero.
    width : float
        Radius of the disc over which the transform averages: it oscillates that much faster.
    """

    transform: Callable[[Floats], Floats]
    order: int
    cutoff: float
    reach: float
    width: float = 0.0

    @cached_property
    def coefficients(self) -> Floats:
        """Of the powers of x, which runs from -1 to 1 on each panel; (DEGREE + 1, panels)."""
        panels = int(np.ceil(self.reach / PANEL))
        node = np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
        rho = (np.arange(panels)[:, None] + (node + 1) / 2) * PANEL
        values = self.quadrature(rho.ravel()).reshape(panels, DEGREE + 1)
        # Powers are safe here: on panels this short their terms fall sixteenfold per degree.
        return np.linalg.solve(np.vander(node, increasing=True), values.T)

    def quadrature(self, rho: Floats) -> Floats:
        """The kernel at rho > 0 (N,) by direct quadrature of the transform."""
        out = np.empty(len(rho))
        for start in range(0, len(rho), 128):
            part = rho[start : start + 128]
            half_waves = self.cutoff * (float(part.max()) + self.width) / np.pi
            alpha, weight = gauss_legendre(0.0, self.cutoff, panels=int(16 + half_waves / 8))
            values = bessel(self.order, np.outer(part, alpha)) @ (weight * self.transform(alpha))
            out[start : start + 128] = values / part**self.order
        return out

    def __call__(self, rho: Floats) -> Floats:
        """Evaluate at rho >= 0, any shape."""
        flat = np.ravel(rho)
        out = np.zeros(flat.shape)
        table = self.coefficients
        for start in range(0, len(flat), CHUNK):
            part = flat[start : start + CHUNK]
            scaled = part / PANEL
            panel = np.minimum(scaled.astype(np.int64), table.shape[1] - 1)
            x = 2 * (scaled - panel) - 1
            value = table[DEGREE][panel]
            for row in table[DEGREE - 1 :: -1]:  # Horner's scheme
                value *= x
                value += row[panel]
            out[start : start + CHUNK] = np.where(part < self.reach, value, 0.0)
        return out.reshape(np.shape(rho))


def jinc(alpha: Floats, radius: float) -> Floats:
    """Hankel transform of the average over a disc: 2 J1(x)/x with x = alpha * radius."""
    from scipy.special import j1

    x = np.maximum(alpha * radius, 1e-9)
    return np.asarray(2 * j1(x) / x)


def electrostatic(alpha: Floats) -> Floats:
    """Smoothing of the gap's change by the field lines between the plates: alpha / sinh(alpha).

    A grounded plate that moves by w changes the charge density on the guarded plate, a gap h away,
    by w smoothed with k h / sinh(k h): first-order perturbation of Laplace's equation.
    """
    decay = np.exp(-alpha)
    return np.where(
        alpha < 1e-8, 1.0, 2 * alpha * decay / np.maximum(-np.expm1(-2 * alpha), 1e-300)
    )
