r"""Exact indentation of the bonded layer by a body of revolution, without friction.

With E* = E/(1 - nu²) and the pressure's Hankel transform written as

.. math:: \hat p(k) = 2 E^* \int_0^a \varphi(t) \cos(kt)\, dt

there is no pressure outside a, and the surface follows the body inside if (Lebedev and Ufliand
1958; Hayes, Keer, Herrmann and Mockros 1972)

.. math:: \varphi(x) - \frac{2}{\pi}\int_0^a \varphi(t) \int_0^\infty [1 - X(kh)]
          \cos kx \cos kt \, dk\, dt = \delta - g(x),

X the layer's normal response relative to the half-space's (`LayerTransfer.normal`) and g the
body's `springs`. On the half-space X = 1 and phi is the answer itself. The kernel is analytic, so
Gauss-Legendre nodes converge geometrically. Nothing here is shared with the lattice solver but X.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Protocol

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic.elastomer import Layer
from skinfield.elastic.hankel import CoveredTransfer, LayerTransfer, bessel, gauss_legendre
from skinfield.errors import Floats, InputError, as_floats, check_positive
from skinfield.settings import Positive, Section


class Profile(Protocol):
    r"""A rigid body of revolution with its tip down.

    An elastic half-space under it acts as a row of independent springs that are pressed by the
    plane profile :math:`g(x) = x \int_0^x f'(r) / \sqrt{x^2 - r^2}\, dr` (Sneddon 1965; Popov,
    Contact Mechanics and Friction, method of dimensionality reduction).
    """

    @property
    def reach(self) -> float:
        """Radius in m up to which the surface is given; infinite if everywhere."""
        ...

    @property
    def kink(self) -> float:
        """Radius in m beyond which `springs` is another analytic function; 0 if none."""
        ...

    def height(self, r: Floats) -> Floats:
        """Height f in m of the surface above its lowest point at the distance r in m."""
        ...

    def springs(self, x: Floats) -> Floats:
        """The function g above, m."""
        ...

    def springs_slope(self, x: Floats) -> Floats:
        """Derivative of `springs`."""
        ...


@dataclass(frozen=True, kw_only=True)
class Paraboloid(Section):
    """f = r²/(2R), which a sphere is close to its tip; Hertz's body.

    Parameters
    ----------
    radius : float, m
        Of curvature at the tip, R.
    """

    radius: Annotated[float, Positive("of curvature at the tip, in metres")]
    reach = float("inf")
    kink = 0.0

    def height(self, r: Floats) -> Floats:
        """See `Profile.height`."""
        return r**2 / (2.0 * self.radius)

    def springs(self, x: Floats) -> Floats:
        """See `Profile.springs`."""
        return x**2 / self.radius

    def springs_slope(self, x: Floats) -> Floats:
        """See `Profile.springs_slope`."""
        return 2.0 * x / self.radius


@dataclass(frozen=True, kw_only=True)
class Ball(Section):
    """A true sphere, f = R - sqrt(R² - r²), touched below its equator.

    Parameters
    ----------
    radius : float, m
    """

    radius: Annotated[float, Positive("of the sphere, in metres")]
    kink = 0.0

    @property
    def reach(self) -> float:
        """The equator, m."""
        return self.radius

    def height(self, r: Floats) -> Floats:
        """See `Profile.height`; infinite beyond the equator."""
        inside = r <= self.radius
        root = np.sqrt(np.where(inside, self.radius**2 - r**2, 0.0))
        return np.where(inside, self.radius - root, np.inf)

    def springs(self, x: Floats) -> Floats:
        """See `Profile.springs`."""
        return np.asarray(x * np.arctanh(x / self.radius))

    def springs_slope(self, x: Floats) -> Floats:
        """See `Profile.springs_slope`."""
        return np.asarray(np.arctanh(x / self.radius) + x * self.radius / (self.radius**2 - x**2))


def kink_of(profile: Profile | None) -> float:
    """Its kink, m; None is a flat end, which has none."""
    return 0.0 if profile is None else profile.kink


def springs_of(profile: Profile | None, x: Floats) -> Floats:
    """Its `springs`, m; None is a flat end."""
    return np.zeros_like(x) if profile is None else profile.springs(x)


def height_of(profile: Profile | None, r: Floats) -> Floats:
    """Its `height`, m; None is a flat end."""
    return np.zeros_like(r) if profile is None else profile.height(r)


CUTOFF = 26.0  # of k h: 1 - X falls as exp(-2 k h)
WIDEST = 60.0  # contact radius over thickness that the nodes are chosen for
PANELS = 20  # of 20 wave numbers each, more if the contact is wide
NODES = 64  # of the integrals over the contact that give pressure and displacement


@dataclass(frozen=True, eq=False)
class Indentation:
    """A body of revolution at rest on the layer.

    Attributes
    ----------
    layer : Layer
    profile : Profile or None
        None is a flat end with a sharp edge.
    contact_radius : float, m
    depth : float, m
        Of the body's lowest point below the undeformed surface.
    force : float, N
    """

    layer: Layer
    profile: Profile | None
    contact_radius: float
    depth: float
    force: float
    _wave: Floats = field(repr=False)
    _missing: Floats = field(repr=False)  # share of each wave number times 1 - X
    _spectrum: Floats = field(repr=False)  # integral of phi cos(kx)

    @property
    def modulus(self) -> float:
        """E* = E/(1 - nu²), Pa."""
        return self.layer.young_modulus / (1.0 - self.layer.poisson_ratio**2)

    @property
    def mean_pressure(self) -> float:
        """Over the contact, Pa."""
        return self.force / (np.pi * self.contact_radius**2)

    @cached_property
    def _base(self) -> np.polynomial.Chebyshev:
        """What the rigid base adds to phi, an analytic function of x."""
        a = self.contact_radius
        degree = 24 + int(8 * a / self.layer.thickness)

        def added(x: Floats) -> Floats:
            return np.asarray(
                2 / np.pi * np.cos(np.outer(x, self._wave)) @ (self._missing * self._spectrum)
            )

        return np.polynomial.Chebyshev.interpolate(added, degree, domain=[0.0, a])

    def springs(self, x: ArrayLike) -> Floats:
        """The function phi, m, at 0 <= x <= contact radius."""
        x = as_floats("x", x)
        return self.depth - springs_of(self.profile, x) + self._base(x)

    def _slope(self, x: Floats) -> Floats:
        own = 0.0 if self.profile is None else self.profile.springs_slope(x)
        return np.asarray(self._base.deriv()(x) - own)

    def pressure(self, r: ArrayLike) -> Floats:
        r"""Contact pressure, Pa, at the distances r in m; zero outside the contact.

        Abel's inversion :math:`\frac{E^*}{\pi}\left[\frac{\varphi(a)}{\sqrt{a^2 - r^2}} -
        \int_r^a \frac{\varphi'(x)}{\sqrt{x^2 - r^2}} dx\right]`. Infinite at the edge of a flat
        end and at the tip of a cone.
        """
        r = as_floats("r", r)
        a = self.contact_radius
        inside = np.abs(r) < a
        near = np.maximum(np.abs(np.where(inside, r, 0.0)), 1e-9 * a)
        within = -self._integral(near)
        if self.profile is None:
            within = within + self.springs([a]) / np.sqrt(a**2 - near**2)
        elif self.profile.springs_slope(np.zeros(1))[0] > 0.0:
            within = np.where(r == 0.0, np.inf, within)
        edge = np.inf if self.profile is None else 0.0
        return np.where(inside, self.modulus / np.pi * within, np.where(np.abs(r) == a, edge, 0.0))

    def _integral(self, r: Floats) -> Floats:
        """Integral of phi' / sqrt(x² - r²) from r to a, with x = r cosh(w), for r of any shape."""
        a, (u, weight) = self.contact_radius, _unit_rule(NODES)
        turn = np.arccosh(np.maximum(kink_of(self.profile) / r, 1.0))[..., None]
        end = np.arccosh(a / r)[..., None]
        near = np.maximum(turn, end - 3.0)  # most of x is in the last e-foldings of w
        total = self._slope(r[..., None] * np.cosh(turn * u)) @ weight * turn[..., 0]
        # Behind a kink phi' starts as a square root, which the substitution u² takes away.
        for start, wide in ((turn, near - turn), (near, end - near)):
            x = np.minimum(r[..., None] * np.cosh(start + wide * u**2), a)
            total = total + self._slope(x) @ (2.0 * u * weight) * wide[..., 0]
        return np.asarray(total)

    def indentation(self, r: ArrayLike) -> Floats:
        """Displacement of the surface into the skin, m, at the distances r in m, anywhere."""
        r = np.abs(as_floats("r", r))
        a = self.contact_radius
        flat = r.ravel()
        outside = flat > a
        out = self.depth - height_of(self.profile, np.minimum(flat, a))
        if outside.any():
            waves = bessel(0, np.outer(flat[outside], self._wave))
            rest = waves @ (self._missing * self._spectrum)
            out[outside] = 2.0 / np.pi * (self._over_contact(flat[outside]) - rest)
        return np.asarray(out.reshape(r.shape))

    def covered_indentation(self, r: ArrayLike) -> Floats:
        """What the same pressure does to the layer under an inextensible cover, m, as above.

        The pressure is that of the free layer: below a cover, the body itself presses a little
        otherwise.
        """
        r = np.abs(as_floats("r", r))
        h, nu = self.layer.thickness, self.layer.poisson_ratio
        covered, free = CoveredTransfer(nu), LayerTransfer(nu)
        share = gauss_legendre(0.0, CUTOFF / h, _panels(self.contact_radius, h))[1]
        alpha = self._wave * h
        factor = covered.half_space_factor
        rest = covered.normal_rest(alpha) - factor * free.normal_rest(alpha)
        waves = bessel(0, np.outer(r.ravel(), self._wave))
        more = 2.0 / np.pi * waves @ (share * rest * self._spectrum)
        return np.asarray(factor * self.indentation(r) + more.reshape(r.shape))

    def _over_contact(self, r: Floats) -> Floats:
        """Integral of phi / sqrt(r² - x²) over the contact for r beyond it, with x = r sin(w)."""
        a, (u, weight) = self.contact_radius, _unit_rule(NODES)
        turn, end = np.arcsin(kink_of(self.profile) / r)[:, None], np.arcsin(a / r)[:, None]
        wide = end - turn
        before = self.springs(r[:, None] * np.sin(turn * u)) @ weight * turn[:, 0]
        beyond = self.springs(np.minimum(r[:, None] * np.sin(turn + wide * u**2), a))
        return np.asarray(before + beyond @ (2.0 * u * weight) * wide[:, 0])

    def base_stress(self, r: ArrayLike) -> Floats:
        """Normal stress on the layer's base, Pa, positive in compression, at r in m."""
        r = np.abs(as_floats("r", r))
        h = self.layer.thickness
        transfer = LayerTransfer(self.layer.poisson_ratio)
        nodes, share = gauss_legendre(0.0, 46.0 / h, 2 * PANELS + int(5 * self.contact_radius / h))
        x, weight = _rule(self.contact_radius, h, self.profile)
        hankel = np.cos(np.outer(nodes, x)) @ (weight * self.springs(x))
        across = share * nodes * transfer.base_normal(nodes * h) * hankel
        sums = bessel(0, np.outer(r.ravel(), nodes)) @ across
        return np.asarray((self.modulus / np.pi * sums).reshape(r.shape))


def indent_to_radius(layer: Layer, profile: Profile | None, contact_radius: float) -> Indentation:
    """The body pressed until the contact has the given radius; a flat end to a unit depth of 1 m.

    Nine digits; fewer for a ball near its equator, whose pressure has five at 0.99 of its radius.

    Parameters
    ----------
    layer : Layer
        Any Poisson's ratio; a thickness of many contact radii is the half-space.
    profile : Profile or None
        None is a flat end with a sharp edge, whose response is proportional to its depth.
    contact_radius : float, m

    Raises
    ------
    InputError
        If the contact is wider than the body, narrower than its flat part, or above 60
        thicknesses.
    """
    return _solve(layer, profile, contact_radius, 1.0)


def indent_by_force(layer: Layer, profile: Profile, force: float) -> Indentation:
    """The body pressed with a force in N; see `indent_to_radius`."""
    check_positive("force", force, "into the skin, in newtons")
    return _search(layer, profile, force)


def punch(
    layer: Layer, radius: float, *, depth: float | None = None, force: float | None = None
) -> Indentation:
    """A flat end with a sharp edge, pressed to a depth in m or with a force in N."""
    if (depth is None) == (force is None):
        raise InputError(f"depth is {depth!r} and force {force!r}, expected exactly one of them")
    unit = _solve(layer, None, radius, 1.0)
    if force is not None:
        check_positive("force", force, "into the skin, in newtons")
        depth = force / unit.force
    check_positive("depth", depth or 0.0, "of the flat end, in metres")
    return _solve(layer, None, radius, depth or 0.0)


def kappa(a_over_h: float, poisson_ratio: float) -> float:
    """Hayes' factor F (1 - nu²)/(2 E a w) of a flat end on the layer; 1 on the half-space."""
    state = _solve(Layer(1.0, 1.0, poisson_ratio), None, a_over_h, 1.0)
    return state.force / (2.0 * state.modulus * a_over_h)


def _panels(a: float, h: float) -> int:
    """Of wave numbers."""
    return PANELS + int(3 * a / h)


def _unit_rule(count: int) -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes and weights on [0, 1]."""
    node, weight = np.polynomial.legendre.leggauss(count)
    return (node + 1.0) / 2.0, weight / 2.0


def _rule(a: float, h: float, profile: Profile | None) -> tuple[Floats, Floats]:
    """Nodes and weights over the contact that resolve the layer's kernel and the body's kink."""
    kink = kink_of(profile)
    u, weight = _unit_rule(24 + int(6 * a / h))
    if kink == 0.0:
        return a * u, a * weight
    behind, share = kink + (a - kink) * u**2, 2.0 * (a - kink) * u * weight
    return np.hstack([kink * u, behind]), np.hstack([kink * weight, share])


def _solve(layer: Layer, profile: Profile | None, a: float, depth: float) -> Indentation:
    """Solve the integral equation; the depth is the given one for a flat end alone."""
    _check_radius(layer, profile, a)
    h = layer.thickness
    t, weight = _rule(a, h, profile)
    wave, share = gauss_legendre(0.0, CUTOFF / h, _panels(a, h))
    missing = -share * LayerTransfer(layer.poisson_ratio).normal_rest(wave * h)
    cosine = np.cos(np.outer(t, wave))
    kernel = 2.0 / np.pi * (cosine * missing) @ cosine.T * weight
    right = np.column_stack([np.ones(len(t)), springs_of(profile, t)])
    flat, body = np.linalg.solve(np.eye(len(t)) - kernel, right).T
    if profile is not None:
        across = 2.0 / np.pi * (np.cos(a * wave) * missing) @ cosine.T * weight
        edge = float(profile.springs(np.array([a]))[0] + across @ body)
        depth = edge / float(1.0 + across @ flat)
    phi = depth * flat - body
    modulus = layer.young_modulus / (1.0 - layer.poisson_ratio**2)
    force = 2.0 * modulus * float(weight @ phi)
    spectrum = (weight * phi) @ cosine
    return Indentation(layer, profile, a, depth, force, wave, missing, spectrum)


def _check_radius(layer: Layer, profile: Profile | None, a: float) -> None:
    check_positive("contact_radius", a, "in metres")
    if profile is not None and not profile.kink < a < profile.reach:
        raise InputError(
            f"contact_radius is {a!r} m, expected above {profile.kink:g} and below "
            f"{profile.reach:g} m, where {profile!r} has its surface"
        )
    if a > WIDEST * layer.thickness:
        raise InputError(
            f"contact_radius is {a!r} m on a layer of {layer.thickness!r} m, expected at most "
            f"{WIDEST:g} thicknesses: the layer is then far from a half-space everywhere"
        )


def _search(layer: Layer, profile: Profile, force: float) -> Indentation:
    """The state that has the force, which rises with the contact's radius."""
    from scipy.optimize import brentq

    kink = profile.kink
    widest = min(WIDEST * layer.thickness, profile.reach)
    _check_radius(layer, profile, max(0.5 * (kink + widest), kink * (1.0 + 1e-12)))
    last = float(np.log((widest - kink) * (1.0 - 1e-12)))

    def excess(level: float) -> float:  # of ln(a - kink), in which the force is gentle
        state = _solve(layer, profile, kink + float(np.exp(level)), 1.0)
        return float(np.log(state.force / force))

    low = min(float(np.log(0.1 * layer.thickness)), last - 1.0)
    high = min(low + 1.0, last)
    while excess(low) > 0.0:
        high, low = low, low - 2.0
        if low < last - 50.0:
            raise InputError(f"the force is {force!r} N, expected more: no contact is left")
    while excess(high) < 0.0:
        if high == last:
            raise InputError(
                f"the force is {force!r} N, expected less: {profile!r} would touch "
                f"beyond its own size or beyond {WIDEST:g} thicknesses of {layer.thickness!r} m"
            )
        low, high = high, min(high + 1.0, last)
    level = brentq(excess, low, high, xtol=1e-14, rtol=1e-14)
    return _solve(layer, profile, kink + float(np.exp(level)), 1.0)
