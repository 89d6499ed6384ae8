"""Point forces on an elastic half-space: the mechanics of the paper, eq. (8) to (26).

The paper (Real-Time Reconstruction of Contact Shapes for Large Area Robot Skin, section III)
prints the formulas for an incompressible elastomer; here they hold for every Poisson's ratio.
Coordinates: x, y in the surface, z out of the skin; offsets point from the force to the place of
observation; depth is positive into the skin. A pushing force is (0, 0, -1).
"""

import numpy as np

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_positive,
    check_range,
    check_shape,
)
from skinfield.mechanics.elastomer import Layer


def traction_kernel(x: Floats, y: Floats, depth: float) -> Floats:
    """`base_traction` for arrays x and y of any one shape: (3, 3, ...)."""
    arm = np.stack([x, y, np.full(np.shape(x), -depth)])
    distance = np.sqrt(x**2 + y**2 + depth**2)
    return np.asarray(1.5 * depth / np.pi * arm[:, None] * arm[None] / distance**5)


def base_traction(offset: Floats, depth: float) -> Floats:
    r"""Traction on a plane inside the skin under a unit point force on its surface.

    Parameters
    ----------
    offset : (N, 2) array, m
        In the plane of the surface, from the force to each taxel.
    depth : float, m
        Of the plane below the surface, positive into the skin.

    Returns
    -------
    (N, 3, 3) array, 1/m²
        [n, i, j]: component i of what the skin above exerts on the plane, outward normal +z and
        tension positive, per component j of the force; a push gives a negative, compressive zz.

    Notes
    -----
    Eq. (8), (9) of the paper, Boussinesq's and Cerruti's stress: with R from the force to the
    taxel, :math:`R_z = -h`,

    .. math:: t_{ij} = \frac{3h}{2\pi} \frac{R_i R_j}{R^5}.

    It holds no elastic constant. Eq. (11) as printed keeps the force and a sum within the matrix
    element; this is the element that (10) needs.
    """
    offset = _checked(offset)
    check_positive("depth", depth, "the stress is singular on the loaded surface")
    return np.moveaxis(traction_kernel(offset[:, 0], offset[:, 1], depth), -1, 0)


def normal_stress(offset: Floats, depth: float) -> Floats:
    r"""Normal stress on a plane inside the skin under a unit pressing point force.

    Parameters
    ----------
    offset, depth
        See `base_traction`.

    Returns
    -------
    (N,) array, Pa/N
        Positive in compression. The paper's element of (10), eq. (11) in its correct form
        :math:`c_{lk} = 3h^3 / (2\pi (r_\perp^2 + h^2)^{5/2})`.
    """
    offset = _checked(offset)
    check_positive("depth", depth, "the stress is singular on the loaded surface")
    square = np.sum(offset**2, axis=1) + depth**2
    return np.asarray(1.5 * depth**3 / (np.pi * square**2.5))


def displacement_kernel(
    x: Floats, y: Floats, depth: float, young_modulus: float, poisson_ratio: float
) -> Floats:
    """`displacement` for arrays x and y of any one shape: (3, 3, ...)."""
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


def displacement(
    offset: Floats, depth: float, young_modulus: float, poisson_ratio: float
) -> Floats:
    r"""Displacement inside the half-space under a unit point force on its surface.

    Parameters
    ----------
    offset : (N, 2) array, m
        In the plane of the surface, from the force to the place of observation.
    depth : float, m
        Below the surface, positive into the skin; 0 is the surface.
    young_modulus : float, Pa
    poisson_ratio : float

    Returns
    -------
    (N, 3, 3) array, m/N
        [n, i, j]: component i of the displacement per component j of the force.

    Raises
    ------
    InputError
        On the force itself, where the displacement is infinite.

    Notes
    -----
    Boussinesq's and Cerruti's solutions (Johnson, Contact Mechanics, eq. 3.18 and 3.75; Landau
    and Lifshitz, Theory of Elasticity, section 8). For :math:`\nu = 1/2` they are the paper's (15)
    and (16), :math:`3 / (4 \pi E) \; (\delta_{ij} / R + R_i R_j / R^3)`.
    """
    offset = _checked(offset)
    check_range("depth", depth, 0.0, np.inf, "counted positive into the skin")
    check_positive("young_modulus", young_modulus, "the elastomer's stiffness in Pa")
    check_range("poisson_ratio", poisson_ratio, 0.0, 0.5, "0.5 is incompressible")
    if depth == 0.0:
        _check_apart(offset)
    u = displacement_kernel(offset[:, 0], offset[:, 1], depth, young_modulus, poisson_ratio)
    return np.moveaxis(u, -1, 0)


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
    offset = _checked(offset)
    _check_apart(offset)
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


def _checked(offset: Floats) -> Floats:
    offset = as_floats("offset", offset)
    check_shape("offset", offset, (None, 2), "one in-plane (x, y) per place of observation")
    check_finite("offset", offset, "a place that is not there has no displacement")
    return offset


def _check_apart(offset: Floats) -> None:
    rows = np.flatnonzero(~offset.any(axis=1))
    if len(rows):
        raise InputError(
            f"offset[{rows[0]}] is {offset[rows[0]]}, expected a place away from the force: on it "
            "the displacement is infinite, use coincident_displacement"
        )
