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

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic.hankel import jinc
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
    elastic: System, potential: System, radius: float, steps: int, falls: float, covered: bool
) -> Responses:
    z, w = _carried(elastic, radius, steps)
    if covered:  # the cover takes what shear it needs to hold the surface sideways
        taken = np.linalg.solve(z[:, 1:, 1:], z[:, 1:, :1])
        z, w = (each[:, :1, :1] - each[:, :1, 1:] @ taken for each in (z, w))
    far, near = _carried(potential, radius, steps)
    weaker = (radius / (radius + 1.0)) ** falls  # the field at the surface over that on the base
    charge = z[:, 0, 0] * weaker * near[:, 0, 0] / far[:, 0, 0]
    return Responses(w[:, 0, 0], z[:, 0, 0], charge)


def _in_groups(wave: Floats, of: Callable[[Ints, int], Responses]) -> Responses:
    """Responses of all harmonics, those of like wave number with as many steps."""
    out = np.empty((3, len(wave)))
    order = np.asarray(np.argsort(wave), dtype=np.int64)
    for rows in np.array_split(order, min(len(order), 8)):
        steps = max(24, int(np.ceil(wave[rows].max() / STEP)))
        out[:, rows] = of(rows, steps)
    return Responses(*out)


def sphere_responses(
    order: ArrayLike, radius: float, nu: float, covered: bool = False
) -> Responses:
    """Responses of Legendre polynomials.

    Parameters
    ----------
    order : (N,) array
        n >= 0.
    radius : float
        Of the base, in thicknesses.
    nu : float
        Poisson's ratio, 0 to 0.5.
    covered : bool
        Whether an inextensible cover holds the surface sideways.
    """
    order = np.asarray(order, dtype=np.float64)

    def of(rows: Ints, steps: int) -> Responses:
        n = order[rows]
        potential = _laplace(lambda r: n * (n + 1) / r**2, 2.0)
        return _responses(_sphere(n, nu), potential, radius, steps, 2.0, covered)

    return _in_groups((order + 0.5) / radius, of)


def cylinder_responses(
    m: ArrayLike, k: ArrayLike, radius: float, nu: float, covered: bool = False
) -> Responses:
    """Responses of cos mφ cos kz, as `sphere_responses`; m and k (N,), k per thickness."""
    m, k = (np.asarray(each, dtype=np.float64) for each in (m, k))

    def of(rows: Ints, steps: int) -> Responses:
        around, along = m[rows], k[rows]
        potential = _laplace(lambda r: (around / r) ** 2 + along**2, 1.0)
        return _responses(_cylinder(around, along, nu), potential, radius, steps, 1.0, covered)

    return _in_groups(np.hypot(m / radius, k), of)


def _samples() -> Floats:
    """Wave numbers from 0 to the cutoff, close at the beginning."""
    return np.asarray(CUTOFF * np.sinh(np.linspace(0.0, 6.0, SAMPLES)) / np.sinh(6.0))


@lru_cache(maxsize=32)
def legendre_series(radius: float, nu: float, covered: bool = False) -> Responses:
    """Responses of n = 0, 1, 2 ... up to the cutoff; kept. Of very many, some are interpolated."""
    from scipy.interpolate import CubicSpline

    outer = radius + 1.0
    every = np.arange(int(CUTOFF * outer) + 1.0)
    if len(every) <= EVERY:
        return sphere_responses(every, radius, nu, covered)
    some = np.unique(np.concatenate([np.arange(8.0), _samples() * outer]))
    known = sphere_responses(some, radius, nu, covered)
    return Responses(*(CubicSpline(some, each)(every) for each in known))


@lru_cache(maxsize=8)
def fourier_samples(radius: float, nu: float, covered: bool = False) -> tuple[Floats, Responses]:
    """Responses (S, S) by wave numbers (S,) around (at the outer radius) and along; kept."""
    waves = _samples()
    around, along = (each.ravel() for each in np.meshgrid(waves, waves, indexing="ij"))
    flat = cylinder_responses(around * (radius + 1.0), along, radius, nu, covered)
    return waves, Responses(*(each.reshape(SAMPLES, SAMPLES) for each in flat))


REACH = 24.0  # thicknesses beyond which kernels are zero; they fall as exp(-0.74 r/h)
FINE = 0.02  # thicknesses between the places of a table
PERIOD = 56.0  # of a cylinder that is unrolled because it is wide


def _soft(wave: Floats) -> Floats:
    """A window that keeps the sum from ringing: 1 up to half the cutoff, then down to 0 (Hann).

    Lanczos's factor would take 0.2 % from waves of 2 per thickness.
    """
    return np.asarray(np.cos(np.pi / 2 * np.clip(2 * wave / CUTOFF - 1.0, 0.0, 1.0)) ** 2)


def _caps(degrees: int, angle: float) -> Floats:
    """Mean of P_n(cos γ) over a cap of half the angle's opening, n = 0 .. degrees - 1."""
    n = np.arange(1.0, degrees)
    values = np.array([*_legendre(degrees + 1, np.array([np.cos(angle)]))])[:, 0]
    means = (values[:-2] - values[2:]) / ((2 * n + 1) * (2 * np.sin(angle / 2) ** 2))
    return np.concatenate([[1.0], means])


def _legendre(degrees: int, x: Floats) -> Iterator[Floats]:
    """Yield P_0(x) .. P_(degrees - 1)(x), by their recurrence."""
    before, value = np.zeros_like(x), np.ones_like(x)
    for n in range(degrees):
        yield value
        before, value = value, ((2 * n + 1) * x * value - n * before) / (n + 1)


@lru_cache(maxsize=64)
def sphere_kernel(
    name: str, radius: float, nu: float, covered: bool, pad: float, spot: float
) -> Floats:
    """Response to a unit force on a sphere by the angle between pad and force, every `FINE` / b.

    Parameters
    ----------
    name : str
        Of one of `Responses`.
    radius, nu, covered
        See `sphere_responses`.
    pad, spot : float, thicknesses
        Radius along the base of the disc over which the answer is averaged, and along the surface
        of that on which the force stands; 0 is a point.

    Returns
    -------
    (P,) array, per squared thickness; the last is 0.
    """
    outer = radius + 1.0
    response = getattr(legendre_series(radius, nu, covered), name)
    n = np.arange(len(response))
    weight = response * (2 * n + 1) / (4 * np.pi * outer**2) * _soft(n / outer)
    for opening in (pad / radius, spot / outer):
        weight = weight * _caps(len(n), opening) if opening > 0.0 else weight
    angle = np.arange(int(min(REACH, np.pi * outer) / FINE) + 2) * FINE / outer
    x = np.cos(np.minimum(angle, np.pi))
    table: Floats = np.zeros_like(x)
    for factor, polynomial in zip(weight, _legendre(len(n), x), strict=True):
        table += factor * polynomial
    if angle[-1] < np.pi:
        table[-1] = 0.0
    table.setflags(write=False)
    return table


@lru_cache(maxsize=16)
def cylinder_kernel(
    name: str, radius: float, nu: float, covered: bool, pad: float, spot: float
) -> Floats:
    """Response to a unit force on a cylinder, by the way around (at b) and along it.

    Parameters
    ----------
    name, radius, nu, covered, pad
        See `sphere_kernel`; the disc is one of the base unrolled.
    spot : float, thicknesses
        Side along the surface of the square on which the force stands.

    Returns
    -------
    (P, Q) array, per squared thickness
        Every `FINE` thicknesses around, up to half the turn or the reach, and along.
    """
    from scipy.interpolate import RectBivariateSpline

    outer = radius + 1.0
    samples, responses = fourier_samples(radius, nu, covered)
    spline = RectBivariateSpline(samples, samples, getattr(responses, name))
    turn = min(2 * np.pi * outer, PERIOD)
    along = np.arange(0.0, CUTOFF, 2 * np.pi / PERIOD)
    around = np.arange(0.0, CUTOFF, 2 * np.pi / turn)
    waves = np.asarray(spline(around, along)) * _soft(around)[:, None] * _soft(along)
    if pad > 0.0:
        waves = waves * jinc(np.hypot(around[:, None] * (outer / radius), along), pad)
    sides = (
        np.sinc(wave * spot / (2 * np.pi)) * np.where(wave > 0.0, 2.0, 1.0)
        for wave in (around, along)
    )
    waves = waves * np.outer(*sides)
    half = min(REACH, turn / 2)
    steps = tuple(np.arange(int(end / FINE) + 2) * FINE for end in (half, REACH))
    cosines = np.cos(np.outer(steps[0], around)), np.cos(np.outer(along, steps[1]))
    table: Floats = np.asarray(cosines[0] @ waves @ cosines[1] / (turn * PERIOD))
    if half == REACH:
        table[-1] = 0.0
    table[:, -1] = 0.0
    table.setflags(write=False)
    return table
