r"""Harmonic responses of an elastic layer bonded to a rigid sphere or a rigid cylinder.

The layer fills R <= r <= b = R + h. A load on r = b is a sum of harmonics: Legendre polynomials
:math:`P_n(\cos\gamma)` on the sphere, :math:`\cos m\varphi \cos kz` on the cylinder. Displacement u
and traction t on the spheres, or cylinders, of radius r then obey a linear system

.. math:: u' = A u + B t, \qquad t' = C u + D t,

whose coefficients hold ν/(1 - ν), (1 - 2ν)/(1 - ν) and 1/(1 - ν) alone, so that nothing is
singular for ν = 1/2 [1]_. With u = Z t and t(R) = W t(r),

.. math:: Z' = A Z + B - Z C Z - Z D, \quad W' = -W (C Z + D), \quad Z(R) = 0,\ W(R) = 1,

which stays bounded for every wave number, unlike u and t themselves [2]_. Lengths are in
thicknesses, stresses in shear moduli; n and m need not be whole numbers.

References
----------
.. [1] S. G. Lekhnitskii, Theory of Elasticity of an Anisotropic Body, 1963: equilibrium and
   Hooke's law in spherical and cylindrical coordinates.
.. [2] U. M. Ascher, R. M. M. Mattheij, R. D. Russell, Numerical Solution of Boundary Value Problems
   for Ordinary Differential Equations, 1995, section 4.5: invariant imbedding.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from skinfield.errors import Floats, Ints

CUTOFF = 64.0  # of wave number times thickness; finer detail is lost in pads and cells
STEP = 0.25  # of the integration, per wave number
EVERY = 1024  # harmonics of a sphere up to which each is computed; of more, some
SAMPLES = 60  # of a wave number from 0 to the cutoff, close at its beginning


class Responses(NamedTuple):
    """What a unit pressure of each harmonic on the outer surface does.

    Attributes
    ----------
    stress : array
        -σ_rr on the base, per pressure.
    indentation : array
        -u_r of the outer surface, times the shear modulus, in thicknesses.
    charge : array
        The same as the field between base and surface smooths it: change of the charge density on
        the base, relative, of the first order in the indentation.
    """

    stress: Floats
    indentation: Floats
    charge: Floats


Blocks = tuple[Floats, Floats, Floats, Floats]
System = Callable[[float], Blocks]


def _carried(system: System, inner: float, steps: int) -> tuple[Floats, Floats]:
    """Compliance Z (N, s, s) of the outer surface and W (N, s, s), by Runge-Kutta's method."""

    def slopes(at: Blocks, z: Floats, w: Floats) -> tuple[Floats, Floats]:
        a, b, c, d = at
        inwards = c @ z + d
        return a @ z + b - z @ inwards, -w @ inwards

    at = system(inner)
    z = np.zeros_like(at[0])
    w = z + np.eye(z.shape[-1])
    step = 1.0 / steps
    for i in range(steps):
        middle, end = system(inner + (i + 0.5) * step), system(inner + (i + 1) * step)
        z1, w1 = slopes(at, z, w)
        z2, w2 = slopes(middle, z + step / 2 * z1, w + step / 2 * w1)
        z3, w3 = slopes(middle, z + step / 2 * z2, w + step / 2 * w2)
        z4, w4 = slopes(end, z + step * z3, w + step * w3)
        z = z + step / 6 * (z1 + 2 * (z2 + z3) + z4)
        w = w + step / 6 * (w1 + 2 * (w2 + w3) + w4)
        at = end
    return z, w


def _matrices(rows: Sequence[Sequence[Floats | float]]) -> Floats:
    """Matrices (N, s, s) of entries that are numbers or arrays (N,)."""
    table = np.broadcast_arrays(*(entry for row in rows for entry in row))
    return np.stack(table, axis=-1).reshape(*table[0].shape, len(rows), len(rows))


def _constants(nu: float) -> tuple[float, float]:
    """ν/(1 - ν), and the shear modulus over that of compression between plates."""
    return nu / (1 - nu), (1 - 2 * nu) / (2 * (1 - nu))


def _sphere(order: Floats, nu: float) -> System:
    """Of u_r P_n, u_θ dP_n/dθ and the tractions σ_rr P_n, σ_rθ dP_n/dθ."""
    c, g = _constants(nu)
    square, nil = order * (order + 1), np.zeros_like(order)

    def at(r: float) -> Blocks:
        a = _matrices([[-2 * c / r, c * square / r], [-1 / r + nil, 1 / r]])
        b = _matrices([[g + nil, 0.0], [0.0, 1.0]])
        stiff = (4 * c + 2) / r**2
        lower = [-stiff + nil, 2 * (square - 1) / r**2 + 2 * c * square / r**2]
        c_ = _matrices([[2 * stiff + nil, -stiff * square], lower])
        d = _matrices([[2 * (c - 1) / r + nil, square / r], [-c / r, -3 / r]])
        return a, b, c_, d

    return at


def _cylinder(m: Floats, k: Floats, nu: float) -> System:
    """Of u_r cos cos, u_φ sin cos, u_z cos sin of mφ and kz, and the tractions likewise."""
    c, g = _constants(nu)
    nil = np.zeros_like(m)

    def at(r: float) -> Blocks:
        q = m / r
        a = _matrices([[-c / r + nil, -c * q, -c * k], [q, 1 / r, 0.0], [k, 0.0, 0.0]])
        b = _matrices([[g + nil, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        both = (2 * c + 1) * q * k
        hoop = (2 * c + 2) / r
        c_ = _matrices(
            [
                [hoop / r + nil, hoop * q, 2 * c * k / r],
                [hoop * q, (2 * c + 2) * q**2 + k**2, both],
                [2 * c * k / r, both, (2 * c + 2) * k**2 + q**2],
            ]
        )
        d = _matrices([[(c - 1) / r + nil, -q, -k], [c * q, -2 / r, 0.0], [c * k, 0.0, -1 / r]])
        return a, b, c_, d

    return at


def _laplace(square: Callable[[float], Floats], falls: float) -> System:
    """Of a potential and its slope; `square` is the squared wave number at a radius."""

    def at(r: float) -> Blocks:
        wave = square(r)[:, None, None]
        nil = np.zeros_like(wave)
        return nil, nil + 1.0, wave, nil - falls / r

    return at


def _responses(
    elastic: System, potential: System, radius: float, steps: int, falls: float
) -> Responses:
    z, w = _carried(elastic, radius, steps)
    far, near = _carried(potential, radius, steps)
    weaker = (radius / (radius + 1.0)) ** falls  # the field at the surface over that on the base
    indentation = z[:, 0, 0]
    charge = indentation * weaker * near[:, 0, 0] / far[:, 0, 0]
    return Responses(w[:, 0, 0], indentation, charge)


def _in_groups(wave: Floats, of: Callable[[Ints, int], Responses]) -> Responses:
    """Responses of all harmonics, those of like wave number with as many steps."""
    out = np.empty((3, len(wave)))
    order = np.asarray(np.argsort(wave), dtype=np.int64)
    for rows in np.array_split(order, min(len(order), 8)):
        steps = max(24, int(np.ceil(wave[rows].max() / STEP)))
        out[:, rows] = of(rows, steps)
    return Responses(*out)


def sphere_responses(order: Floats, radius: float, nu: float) -> Responses:
    """Responses of Legendre polynomials.

    Parameters
    ----------
    order : (N,) array
        n >= 0.
    radius : float
        Of the base, in thicknesses.
    nu : float
        Poisson's ratio, 0 to 0.5.
    """
    order = np.asarray(order, dtype=np.float64)

    def of(rows: Ints, steps: int) -> Responses:
        n = order[rows]
        potential = _laplace(lambda r: n * (n + 1) / r**2, 2.0)
        return _responses(_sphere(n, nu), potential, radius, steps, 2.0)

    return _in_groups((order + 0.5) / radius, of)


def cylinder_responses(m: Floats, k: Floats, radius: float, nu: float) -> Responses:
    """Responses of cos mφ cos kz, as `sphere_responses`; m and k (N,), k per thickness."""
    m, k = (np.asarray(each, dtype=np.float64) for each in (m, k))

    def of(rows: Ints, steps: int) -> Responses:
        around, along = m[rows], k[rows]
        potential = _laplace(lambda r: (around / r) ** 2 + along**2, 1.0)
        return _responses(_cylinder(around, along, nu), potential, radius, steps, 1.0)

    return _in_groups(np.hypot(m / radius, k), of)


def _samples() -> Floats:
    """Wave numbers from 0 to the cutoff, close at the beginning."""
    return np.asarray(CUTOFF * np.sinh(np.linspace(0.0, 6.0, SAMPLES)) / np.sinh(6.0))


@lru_cache(maxsize=32)
def legendre_series(radius: float, nu: float) -> Responses:
    """Responses of n = 0, 1, 2 ... up to the cutoff; kept. Of very many, some are interpolated."""
    from scipy.interpolate import CubicSpline

    outer = radius + 1.0
    every = np.arange(int(CUTOFF * outer) + 1.0)
    if len(every) <= EVERY:
        return sphere_responses(every, radius, nu)
    some = np.unique(np.concatenate([np.arange(8.0), _samples() * outer]))
    known = sphere_responses(some, radius, nu)
    return Responses(*(CubicSpline(some, each)(every) for each in known))


@lru_cache(maxsize=8)
def fourier_samples(radius: float, nu: float) -> tuple[Floats, Responses]:
    """Responses (S, S) by wave numbers (S,) around (at the outer radius) and along; kept."""
    waves = _samples()
    around, along = (each.ravel() for each in np.meshgrid(waves, waves, indexing="ij"))
    flat = cylinder_responses(around * (radius + 1.0), along, radius, nu)
    return waves, Responses(*(each.reshape(SAMPLES, SAMPLES) for each in flat))
