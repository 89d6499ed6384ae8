"""Point forces and uniform squares on an elastic half-space: the mechanics of the paper.

The paper (Real-Time Reconstruction of Contact Shapes for Large Area Robot Skin, section III)
prints the formulas (8) to (26) for an incompressible elastomer; here they hold for every Poisson's
ratio. Coordinates: x, y in the surface, z out of the skin; offsets point from the force to the
place of observation; depth is positive into the skin. A pushing force is (0, 0, -1). `HalfSpace`
takes the half-space in place of the layer.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.elastic.cell_integrals import (
    integrate_over_cell,
    inverse_distance_integrals,
    matrices,
    mean_inverse,
    mean_inverse_distance,
    surface_tensor,
)
from skinfield.elastic.elastomer import Layer, in_thicknesses
from skinfield.elastic.hankel import RadialKernel, electrostatic, jinc
from skinfield.errors import Floats, InputError, as_floats, check_positive, check_shape


def traction_kernel(x: Floats, y: Floats, depth: float) -> Floats:
    r"""Traction on a plane inside the skin under a unit point force on its surface.

    Parameters
    ----------
    x, y : arrays of any one shape, m
        From the force to the place of observation.
    depth : float, m
        Of the plane below the surface, positive into the skin.

    Returns
    -------
    (3, 3, ...) array, 1/m²
        [i, j]: component i of what the skin above exerts on the plane, outward normal +z and
        tension positive, per component j of the force; a push gives a negative, compressive zz.

    Notes
    -----
    Eq. (8), (9) of the paper, Boussinesq's and Cerruti's stress: with R from the force to the
    taxel, :math:`R_z = -h`, :math:`t_{ij} = 3h R_i R_j / (2\pi R^5)`. It holds no elastic constant.
    Eq. (11) as printed keeps the force and a sum within the matrix element; zz is the element that
    (10) needs.
    """
    arm = np.stack([x, y, np.full(np.shape(x), -depth)])
    distance = np.sqrt(x**2 + y**2 + depth**2)
    return np.asarray(1.5 * depth / np.pi * arm[:, None] * arm[None] / distance**5)


def displacement_kernel(
    x: Floats, y: Floats, depth: float, young_modulus: float, poisson_ratio: float
) -> Floats:
    r"""Displacement inside the half-space under a unit point force on its surface.

    Parameters
    ----------
    x, y : arrays of any one shape, m
        From the force to the place of observation; infinite on the force itself.
    depth : float, m
        Below the surface, positive into the skin; 0 is the surface.
    young_modulus : float, Pa
    poisson_ratio : float

    Returns
    -------
    (3, 3, ...) array, m/N
        [i, j]: component i of the displacement per component j of the force.

    Notes
    -----
    Boussinesq's and Cerruti's solutions (Johnson, Contact Mechanics, eq. 3.18 and 3.75; Landau
    and Lifshitz, Theory of Elasticity, section 8). For :math:`\nu = 1/2` they are the paper's (15)
    and (16), :math:`3 / (4 \pi E) \; (\delta_{ij} / R + R_i R_j / R^3)`.
    """
    r = np.sqrt(x**2 + y**2 + depth**2)
    beside = r + depth
    slack = 1.0 - 2.0 * poisson_ratio  # 0 for an incompressible elastomer
    plane = np.stack([x, y])
    u = np.empty((3, 3, *np.shape(x)))
    u[:2, :2] = plane[:, None] * plane[None] * (1.0 / r**3 - slack / (r * beside**2))
    u[0, 0] += 1.0 / r + slack / beside
    u[1, 1] += 1.0 / r + slack / beside
    u[:2, 2] = plane * (slack / (r * beside) - depth / r**3)
    u[2, :2] = -plane * (slack / (r * beside) + depth / r**3)
    u[2, 2] = depth**2 / r**3 + 2.0 * (1.0 - poisson_ratio) / r
    return np.asarray((1.0 + poisson_ratio) / (2.0 * np.pi * young_modulus) * u)


def surface_displacement(offset: Floats, layer: Layer) -> Floats:
    r"""Effective displacement of the surface, the paper's (17), under a unit point force.

    Parameters
    ----------
    offset : (N, 2) array, m
        In the plane of the surface, from the force to the place of observation; none of them 0.
    layer : Layer

    Returns
    -------
    (N, 3, 3) array, m/N
        [n, i, j]: component i of the displacement per component j of the force.

    Notes
    -----
    The half-space does not know of the rigid base, so the paper takes its displacement relative to
    that at the base: :math:`\delta = u(0) - u(h)` ((17) is printed with its arguments swapped). For
    :math:`\nu = 1/2`, z into the skin as the paper has it, and :math:`r^2 = r_\perp^2 + h^2`:

    .. math::

        \delta^\perp &= \frac{3}{4\pi E} \left\{
        \frac{1}{r_\perp} \left[ F^\perp + \frac{r_\perp (F^\perp \cdot r_\perp)}{r_\perp^2} \right]
        - \frac1r \left[ \frac{F^n h\, r_\perp}{r^2} + F^\perp
        + \frac{r_\perp (F^\perp \cdot r_\perp)}{r^2} \right] \right\}

        \delta^n &= \frac{3}{4\pi E} \left\{ F^n \left[ \frac{1}{r_\perp}
        - \frac1r \left( 1 + \frac{h^2}{r^2} \right) \right]
        - \frac{h\, (r_\perp \cdot F^\perp)}{r^3} \right\}

    These are (18) and (19) corrected: (18) is printed with r for r_perp in its first bracket and a
    normal distance for r in its second, (19) holds u(h) alone and misses u(0).

    As a difference of two places it is not reciprocal: the parts that couple normal and tangential
    are odd in the offset and equal, where `BondedLayer` has them opposite.
    """
    offset = as_floats("offset", offset)
    check_shape("offset", offset, (None, 2), "one in-plane (x, y) per place of observation")
    rows = np.flatnonzero(~offset.any(axis=1))
    if len(rows):
        raise InputError(
            f"offset[{rows[0]}] is {offset[rows[0]]}, expected a place away from the force: on it "
            "the displacement is infinite, use coincident_displacement"
        )
    x, y = offset.T
    elastic = (layer.young_modulus, layer.poisson_ratio)
    above = displacement_kernel(x, y, 0.0, *elastic)
    return np.moveaxis(above - displacement_kernel(x, y, layer.thickness, *elastic), -1, 0)


def virtual_depth(cell_area: float) -> float:
    r"""Height z0 at which a point force replaces a cell's uniform pressure, m: eq. (20).

    :math:`z_0 = \sqrt{3 \Delta s / (2\pi)}`: the peak stress at depth z0 below the force is the
    mean pressure on the cell of area `cell_area` m².
    """
    check_positive("cell_area", cell_area, "the area in m² on which the force acts")
    return float(np.sqrt(1.5 * cell_area / np.pi))


def exact_psi(ratio: float) -> float:
    """The paper's Psi of (25) and (26) at `ratio` = h / z0: ratio / (4 (1 + ratio)), algebraic."""
    return ratio / (4.0 * (1.0 + ratio))


def fitted_psi(ratio: float) -> float:
    """Psi as the authors' group fitted it, (0.2431 ratio - 0.1814) / ratio; negative below 0.75."""
    return (0.2431 * ratio - 0.1814) / ratio


def coincident_displacement(layer: Layer, cell_area: float, psi: float | None = None) -> Floats:
    r"""Effective displacement of the surface where the unit point force itself acts.

    Parameters
    ----------
    layer : Layer
    cell_area : float, m²
        On which the force acts.
    psi : float, optional
        Value of Psi; None takes `exact_psi`, 0.25 is the paper's.

    Returns
    -------
    (3, 3) array, m/N
        Diagonal: two equal tangential terms and the normal one, twice as large.

    Notes
    -----
    Eq. (25) and (26): the elastomer is taken to begin z0 below the force, and the work of the force
    to be the energy (21) stored in the slab from z0 to z0 + h,

    .. math::

        \delta^\perp = \frac{9}{4\pi E z_0} \Psi(h/z_0) F^\perp, \qquad
        \delta^n = \frac{9}{2\pi E z_0} \Psi(h/z_0) F^n.

    That energy is the difference of the work W(z) done on the planes at z0 and z0 + h, and W falls
    as 1/z, so :math:`\Psi(x) = x / (4(1+x))` exactly: no logarithm. For other Poisson's ratios (23)
    gives the same with both terms times :math:`(1+\nu)(2-\nu) / 2.25`.
    """
    depth, nu = virtual_depth(cell_area), layer.poisson_ratio
    value = exact_psi(layer.thickness / depth) if psi is None else psi
    normal = 2.0 * (1.0 + nu) * (2.0 - nu) / (np.pi * layer.young_modulus * depth) * value
    return np.diag([normal / 2.0, normal / 2.0, normal])


CUTOFF = 46.0  # every transform below falls as exp(-alpha)
NEAR = 32.0  # thicknesses that tables span; beyond, a pad is a ring

Radial = Callable[[Floats], Floats]


@dataclass(frozen=True)
class HalfSpace:
    """The paper's mechanics: point forces on a half-space whose plane at depth h is the base.

    The half-space does not feel the rigid robot below, so its stress of the same pressure is 13 to
    23 % off for real contacts, and its displacement is only made to vanish at the base by
    subtraction, eq. (17). `BondedLayer` has the same methods and is exact; this one is for
    comparison with the paper. Any Poisson's ratio from 0 to 0.5.

    Parameters
    ----------
    point_forces : bool
        Whether the load of a cell acts as one force at its centre, as in the paper; otherwise as a
        uniform traction on the square.
    psi : float, function of h / z0, or None
        The function Psi of (25) and (26) where a point force meets its own displacement: None for
        its exact value, 0.25 for the paper's, `half_space.fitted_psi` for the authors' group's.
        Uniform cells need none.
    capped : bool
        Whether a row of the displacement of a point force gives way to the coincident one where
        its diagonal exceeds that, as in the authors' group's program.
    """

    point_forces: bool = True
    psi: float | Callable[[float], float] | None = None
    capped: bool = False

    def reach(self, layer: Layer) -> float:
        """Distance in m beyond which responses may be neglected: none, they fall as powers."""
        return float("inf")

    def base_stress(
        self, layer: Layer, offset: Floats, cell: float, pad_diameter: float = 0.0
    ) -> Floats:
        """See `Mechanics.base_stress`."""
        offset, cell, pad = in_thicknesses(layer, offset, cell, pad_diameter)
        return self._spread(_stress(pad), offset, cell)

    def base_traction(
        self, layer: Layer, offset: Floats, cell: float, pad_diameter: float = 0.0
    ) -> Floats:
        """See `Mechanics.base_traction`."""
        offset, cell, pad = in_thicknesses(layer, offset, cell, pad_diameter)
        total = np.zeros((len(offset), 3, 3))
        for ring, weight in zip(*_disc_rule(pad), strict=True):
            around = (offset[None] + ring[:, None]).reshape(-1, 2)
            traction = self._spread_tensor(lambda x, y: traction_kernel(x, y, 1.0), around, cell)
            total += weight * traction.reshape(len(ring), -1, 3, 3).mean(axis=0)
        return total

    def surface_displacement(self, layer: Layer, offset: Floats, cell: float) -> Floats:
        """See `Mechanics.surface_displacement`; effective, eq. (17)."""
        elastic = (layer.young_modulus, layer.poisson_ratio)
        if self.point_forces:
            in_thicknesses(layer, offset, cell, 0.0)
            return cell**2 * self._of_point_forces(layer, np.asarray(offset, np.float64), cell)
        scaled, side, _ = in_thicknesses(layer, offset, cell, 0.0)
        over = inverse_distance_integrals(scaled, side)
        above = matrices(surface_tensor(layer.poisson_ratio, over)) / layer.young_modulus
        below = self._spread_tensor(
            lambda x, y: displacement_kernel(x, y, 1.0, *elastic), scaled, side
        )
        return layer.thickness * (above - below)

    def indentation(
        self,
        layer: Layer,
        offset: Floats,
        cell: float,
        pad_diameter: float = 0.0,
        electrostatic: bool = False,
    ) -> Floats:
        """See `Mechanics.indentation`; effective, eq. (17)."""
        nu, h = layer.poisson_ratio, layer.thickness
        metres, (offset, cell, pad) = cell, in_thicknesses(layer, offset, cell, pad_diameter)
        scale = 2.0 * (1.0 - nu**2) * h / layer.young_modulus
        if electrostatic:
            return scale * self._spread(_smoothed_gap(nu, pad), offset, cell)
        if self.point_forces and pad == 0.0:
            return self.surface_displacement(layer, offset * h, metres)[:, 2, 2]
        if self.point_forces:
            above = cell**2 * mean_inverse(np.hypot(*offset.T), pad)
        else:
            above = mean_inverse_distance(offset, cell, pad)
        sunk = self._spread(_depth(nu, pad), offset, cell)
        return scale * (above / (2.0 * np.pi) - sunk)

    def lift(self, layer: Layer, offset: Floats, cell: float, pad_diameter: float = 0.0) -> Floats:
        """See `Mechanics.lift`; effective, eq. (17). Of a pad by the rule of degree 5 on a disc."""
        angle = np.arange(6) * np.pi / 3  # Stroud's S2 5-1
        ring = np.column_stack([np.cos(angle), np.sin(angle)]) * pad_diameter * np.sqrt(1 / 6)
        places = np.concatenate([np.zeros((1, 2)), ring]) if pad_diameter else np.zeros((1, 2))
        weights = [0.25, *[0.125] * 6] if pad_diameter else [1.0]
        return np.asarray(
            sum(
                weight * self.surface_displacement(layer, offset + place, cell)[:, 2, :2]
                for place, weight in zip(places, weights, strict=True)
            )
        )

    def _of_point_forces(self, layer: Layer, offset: Floats, cell: float) -> Floats:
        """Effective displacement, m/N, with the coincident terms at and, if asked, near zero."""
        psi = self.psi
        if callable(psi):
            psi = psi(layer.thickness / virtual_depth(cell**2))
        own = coincident_displacement(layer, cell**2, psi)
        apart = np.hypot(*offset.T) > 1e-9 * cell
        delta = np.empty((len(offset), 3, 3))
        delta[apart] = surface_displacement(offset[apart], layer)
        delta[~apart] = own
        if self.capped:
            over = np.abs(np.einsum("nii->ni", delta)) > np.abs(np.diag(own))
            delta = np.where(over[:, :, None], own, delta)
        return delta

    def _spread(self, kernel: Radial, offset: Floats, cell: float) -> Floats:
        """Response to a cell: the kernel of a point force, times the area or integrated."""
        return self._spread_tensor(lambda x, y: kernel(np.hypot(x, y)), offset, cell)

    def _spread_tensor(
        self, kernel: Callable[[Floats, Floats], Floats], offset: Floats, cell: float
    ) -> Floats:
        if self.point_forces:
            return np.moveaxis(cell**2 * kernel(*offset.T), -1, 0)
        total = integrate_over_cell(kernel, offset, cell, depth=1.0, reach=np.inf)
        return np.moveaxis(total, -1, 0)


@dataclass(frozen=True, eq=False)
class PadKernel:
    """A radial kernel averaged over a pad: a table near by, a closed form on a ring far away.

    Far away a smoothing shows its second moment alone, and so acts as the mean over a ring of
    radius `spread`.
    """

    table: RadialKernel
    closed: Radial
    spread: float

    def __call__(self, rho: Floats) -> Floats:
        """Evaluate at rho >= 0 thicknesses, any shape."""
        near = rho < self.table.reach
        out = np.empty(np.shape(rho))
        out[near] = self.table(rho[near])
        angle = np.arange(8) * np.pi / 4
        far = rho[~near, None]
        ring = np.hypot(far + self.spread * np.cos(angle), self.spread * np.sin(angle))
        out[~near] = self.closed(ring).mean(axis=-1)
        return out


@lru_cache(maxsize=32)
def _stress(pad: float) -> Radial:
    """Normal stress per force at the base; transform alpha (1 + alpha) exp(-alpha)."""
    closed: Radial = lambda rho: 1.5 / np.pi / (rho**2 + 1.0) ** 2.5  # noqa: E731
    if pad == 0.0:
        return closed
    return _averaged(lambda a: a * (1.0 + a) * np.exp(-a), closed, pad, pad / np.sqrt(2.0))


@lru_cache(maxsize=32)
def _depth(nu: float, pad: float) -> Radial:
    """Displacement at the base over 2 (1 - nu²) / E; transform (1 + beta alpha) exp(-alpha)."""
    beta = 0.5 / (1.0 - nu)

    def closed(rho: Floats) -> Floats:
        r = np.hypot(rho, 1.0)
        return np.asarray((1.0 / r + beta / r**3) / (2.0 * np.pi))

    if pad == 0.0:
        return closed
    return _averaged(lambda a: (1.0 + beta * a) * np.exp(-a), closed, pad, pad / np.sqrt(2.0))


@lru_cache(maxsize=32)
def _smoothed_gap(nu: float, pad: float) -> Radial:
    """Effective indentation over 2 (1 - nu²) / E, smoothed by the electric field."""
    beta = 0.5 / (1.0 - nu)

    def transform(a: Floats) -> Floats:
        return np.asarray((-np.expm1(-a) - beta * a * np.exp(-a)) * electrostatic(a))

    def closed(rho: Floats) -> Floats:
        r = np.hypot(rho, 1.0)
        return np.asarray((1.0 / rho - 1.0 / r - beta / r**3) / (2.0 * np.pi))

    # Second moments add: a²/2 of the pad, 2/3 of alpha / sinh(alpha) = 1 - alpha²/6 + ...
    return _averaged(transform, closed, pad, np.sqrt(pad**2 / 2.0 + 2.0 / 3.0))


def _averaged(transform: Radial, closed: Radial, pad: float, spread: float) -> PadKernel:
    def smoothed(alpha: Floats) -> Floats:
        return np.asarray(transform(alpha) * jinc(alpha, pad) / (2.0 * np.pi))

    return PadKernel(RadialKernel(smoothed, 0, CUTOFF, NEAR + 4.0 * pad, pad), closed, spread)


def _disc_rule(radius: float) -> tuple[Floats, Floats]:
    """Rings of points (R, A, 2) and their weights (R,) that average over a disc."""
    if radius == 0.0:
        return np.zeros((1, 1, 2)), np.ones(1)
    count = int(np.ceil(8 + 10 * radius))
    node, weight = np.polynomial.legendre.leggauss(count)
    r, angle = radius * np.sqrt((node + 1.0) / 2.0), np.arange(2 * count) * np.pi / count
    return np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))], axis=-1), weight / 2.0
