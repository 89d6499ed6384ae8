"""Radial kernels in real space from their Hankel transforms, as tables that cost one look-up."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import factorial

import numpy as np

from skinfield.errors import Floats

DEGREE = 12  # of the polynomial on one panel
PANEL = 0.25  # width of a panel; kernels are analytic within 1 (the layer's depth) of the real axis
CHUNK = 1 << 14  # points per pass, so that its few arrays stay in cache


def bessel(order: int, x: Floats) -> Floats:
    """Bessel function J0, J1 or J2; the recurrence is ten times faster than the general routine."""
    from scipy.special import j0, j1

    if order == 0:
        return np.asarray(j0(x))
    if order == 1:
        return np.asarray(j1(x))
    safe, quarter = np.maximum(x, 1.0), np.minimum(x, 1.0) ** 2 / 4
    series = np.zeros_like(quarter)
    for n in range(8, -1, -1):  # of J2, where the recurrence cancels
        series = 1 / (factorial(n) * factorial(n + 2)) - quarter * series
    return np.where(x < 1.0, quarter * series, 2 * j1(safe) / safe - j0(safe))


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
