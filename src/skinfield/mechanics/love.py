"""Closed forms for a uniformly loaded rectangle on an elastic half-space.

All vectors point from the loaded place to the place of observation; z points out of the skin.
"""

from typing import NamedTuple

import numpy as np

from skinfield.errors import (
    Floats,
    as_floats,
    check_finite,
    check_positive,
    check_range,
    check_shape,
)

Sides = float | tuple[float, float]


class RectangleIntegrals(NamedTuple):
    """Integrals over a rectangle of the kernels of the half-space's surface; each (N,), m."""

    inverse: Floats  # of 1/r
    xx: Floats  # of x²/r³
    xy: Floats  # of xy/r³
    yy: Floats  # of y²/r³
    x: Floats  # of x/r²
    y: Floats  # of y/r²


def corners(offset: Floats, cell: Sides) -> tuple[Floats, Floats, Floats]:
    """Vectors from the four corners of a rectangle, and the signs of a double integral.

    Parameters
    ----------
    offset : (N, 2) array, m
        From the rectangle's centre to the point of observation.
    cell : float or (float, float), m
        Side of a square, or both sides of a rectangle.

    Returns
    -------
    x, y, sign : (4, N), (4, N) and (4, 1) array
        The integral over the rectangle is the sum of sign * antiderivative(x, y).
    """
    width, height = cell if isinstance(cell, tuple) else (cell, cell)
    check_positive("cell", width, "the loaded rectangle's side along x, in metres")
    check_positive("cell", height, "the loaded rectangle's side along y, in metres")
    offset = as_floats("offset", offset)
    check_shape("offset", offset, (None, 2), "one in-plane (x, y) per point of observation")
    check_finite("offset", offset, "a point without a place has no displacement")
    half = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]) * np.array([width, height]) / 2.0
    x, y = np.moveaxis(offset[None] + half[:, None], -1, 0)
    return x, y, np.array([[1.0], [-1.0], [-1.0], [1.0]])


def length_asinh(length: Floats, other: Floats, depth: float = 0.0) -> Floats:
    """`length` * asinh(`other` / hypot(`length`, `depth`)), with its limit 0 at `length` = 0."""
    below = np.hypot(length, depth) if depth else np.abs(length)
    return length * np.arcsinh(other / np.where(below == 0.0, 1.0, below))


def inverse_distance_integrals(offset: Floats, cell: Sides) -> RectangleIntegrals:
    r"""Integrals of 1/r, x²/r³, xy/r³, y²/r³, x/r², y/r² over a loaded rectangle.

    Parameters
    ----------
    offset : (N, 2) array, m
        From the rectangle's centre to the point of observation, inside or outside of it.
    cell : float or (float, float), m
        Side of a square, or both sides of a rectangle.

    Returns
    -------
    RectangleIntegrals
        A tuple of six (N,) arrays, m. Exact at the centre, on edges and on corners.

    Notes
    -----
    Antiderivatives, summed over the corners with alternating signs (for 1/r: Love, 1929):

    .. math::

        \frac1r &: x\,\mathrm{asinh}\frac{y}{|x|} + y\,\mathrm{asinh}\frac{x}{|y|}, \quad
        \frac{x^2}{r^3} : y\,\mathrm{asinh}\frac{x}{|y|}, \quad
        \frac{xy}{r^3} : -r, \quad
        \frac{x}{r^2} : \tfrac12 y \ln r^2 + x \arctan\frac yx
    """
    x, y, sign = corners(offset, cell)
    square = x**2 + y**2
    # The unit of the logarithm cancels in the sum; near 1 it costs the fewest digits.
    log = 0.5 * np.log(np.where(square == 0.0, 1.0, square) / square.max(axis=0))
    over_x, over_y = length_asinh(x, y), length_asinh(y, x)
    angle_x = np.abs(x) * np.arctan2(y, np.abs(x))
    angle_y = np.abs(y) * np.arctan2(x, np.abs(y))

    def total(antiderivative: Floats) -> Floats:
        return np.asarray(np.sum(sign * antiderivative, axis=0))

    xx, yy = total(over_y), total(over_x)
    return RectangleIntegrals(
        inverse=xx + yy,
        xx=xx,
        xy=total(-np.sqrt(square)),
        yy=yy,
        x=total(y * log + angle_x),
        y=total(x * log + angle_y),
    )


def rectangle_displacement(
    offset: Floats, cell: Sides, young_modulus: float, poisson_ratio: float
) -> Floats:
    r"""Displacement of the half-space's surface under unit traction on a rectangle.

    Parameters
    ----------
    offset : (N, 2) array, m
        From the rectangle's centre to the point of observation.
    cell : float or (float, float), m
        Side of a square, or both sides of a rectangle.
    young_modulus : float, Pa
    poisson_ratio : float

    Returns
    -------
    (N, 3, 3) array, m/Pa
        Component i of the displacement per component j of the traction, z outwards.

    Notes
    -----
    Boussinesq's and Cerruti's point solutions (Johnson, Contact Mechanics, 3.2 and 3.6),
    integrated. With tangential components i, j:

    .. math::

        u_{ij} = \frac{1+\nu}{\pi E} \int \frac{(1-\nu)\delta_{ij}}{r} + \frac{\nu x_i x_j}{r^3},
        \quad u_{zz} = \frac{1-\nu^2}{\pi E} \int \frac1r, \quad
        u_{iz} = -u_{zi} = \frac{(1+\nu)(1-2\nu)}{2 \pi E} \int \frac{x_i}{r^2}
    """
    check_positive("young_modulus", young_modulus, "the elastomer's stiffness in Pa")
    over = inverse_distance_integrals(offset, cell)
    nu = poisson_ratio
    scale = (1.0 + nu) / (np.pi * young_modulus)
    u = np.empty((len(over.inverse), 3, 3))
    u[:, 0, 0] = (1.0 - nu) * over.inverse + nu * over.xx
    u[:, 1, 1] = (1.0 - nu) * over.inverse + nu * over.yy
    u[:, 0, 1] = u[:, 1, 0] = nu * over.xy
    u[:, 2, 2] = (1.0 - nu) * over.inverse
    u[:, 0, 2] = (0.5 - nu) * over.x
    u[:, 1, 2] = (0.5 - nu) * over.y
    u[:, 2, :2] = -u[:, :2, 2]
    return np.asarray(scale * u)


def rectangle_stress(offset: Floats, cell: Sides, depth: float) -> Floats:
    r"""Normal stress on a plane inside the half-space under unit pressure on a rectangle.

    Parameters
    ----------
    offset : (N, 2) array, m
        From the rectangle's centre to the point below which the stress is wanted.
    cell : float or (float, float), m
        Side of a square, or both sides of a rectangle.
    depth : float, m
        Of the plane below the surface, positive into the skin.

    Returns
    -------
    (N,) array, Pa/Pa
        Positive in compression; independent of the elastic constants.

    Notes
    -----
    Integral of eq. (9) of the paper for a normal force. Antiderivative, with
    :math:`R^2 = x^2 + y^2 + z^2` (Love, 1929):

    .. math::

        \frac{1}{2\pi} \left[ \arctan\frac{xy}{zR}
        + \frac{xyz}{R} \left( \frac{1}{x^2+z^2} + \frac{1}{y^2+z^2} \right) \right]
    """
    check_positive("depth", depth, "on the surface itself the stress is the pressure")
    x, y, sign = corners(offset, cell)
    product, radius = x * y, np.sqrt(x**2 + y**2 + depth**2)
    ratio = 1.0 / (x**2 + depth**2) + 1.0 / (y**2 + depth**2)
    stress = np.arctan(product / (depth * radius)) + product * depth / radius * ratio
    return np.asarray(np.sum(sign * stress, axis=0) / (2.0 * np.pi))


def rectangle_normal_displacement(
    offset: Floats, cell: Sides, depth: float, young_modulus: float, poisson_ratio: float
) -> Floats:
    r"""Normal displacement inside the half-space under unit normal traction on a rectangle.

    Parameters
    ----------
    offset, cell
        See `rectangle_displacement`.
    depth : float, m
        Of the plane of observation below the surface, positive into the skin; 0 is the surface.
    young_modulus : float, Pa
    poisson_ratio : float

    Returns
    -------
    (N,) array, m/Pa

    Notes
    -----
    Integral of :math:`\frac{1+\nu}{2\pi E} [2(1-\nu)/R + z^2/R^3]` (Love, 1929). Antiderivatives:

    .. math::

        \frac1R : x\,\mathrm{asinh}\frac{y}{\sqrt{x^2+z^2}}
        + y\,\mathrm{asinh}\frac{x}{\sqrt{y^2+z^2}} - z \arctan\frac{xy}{zR}, \quad
        \frac{z^2}{R^3} : z \arctan\frac{xy}{zR}
    """
    check_range("depth", depth, 0.0, np.inf, "counted positive into the skin")
    check_positive("young_modulus", young_modulus, "the elastomer's stiffness in Pa")
    x, y, sign = corners(offset, cell)
    product = x * y
    radius = np.sqrt(x**2 + y**2 + depth**2)
    angle = depth * np.sign(product) * np.arctan2(np.abs(product), depth * radius)
    inverse = length_asinh(x, y, depth) + length_asinh(y, x, depth) - angle
    scale = (1.0 + poisson_ratio) / (2.0 * np.pi * young_modulus)
    kernel = 2.0 * (1.0 - poisson_ratio) * inverse + angle
    return np.asarray(scale * np.sum(sign * kernel, axis=0))
