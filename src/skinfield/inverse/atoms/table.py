r"""What a pad reads of a round contact, as a table that is smooth in everything a fit moves.

A reading at the distance r of a contact of radius a that is pressed with the force F is

.. math:: F\,s(a)\,\frac{\sum_k u^k\,C_k(r, \ln a)}{1 - u}, \quad u = F\,s(a),

for a pad that reads the capacitance: s is the strain of the gap where it is highest, per newton,
and the denominator what a uniform gap would have. A quantity that is linear in the force is
:math:`F\,C_0(r, \ln a)`. The tables :math:`C_k` are cubic B-splines over r and ln a.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.errors import Floats
from skinfield.inverse.atoms.profiles import (
    BALL,
    FAMILIES,
    curvature_force,
    edges_of,
    load_quadrature,
    unit_indentation,
)
from skinfield.layout import Grid, Patch
from skinfield.observation import Capacitance, Physics

LOG_STEP = 0.25  # of ln(a/h)
SMALLEST, LARGEST = 0.18, 7.0  # radii a fit may try, in thicknesses: smaller ones look the same
MARGIN = 3  # nodes beyond: where a B-spline feels the end of its data
DISTANCE_STEP = 0.125  # of r/h
SIGHT = 6.0  # thicknesses beyond the rims of pad and contact, where all readings are below 1e-3
CELL = 0.02  # thicknesses: side of the square that stands for a point load
SHARE = 0.25  # thicknesses between the points of a ring
STRAINS = (0.03, 0.15, 0.34, 0.56, 0.76, 0.9)  # of the gap, at its narrowest
SHARP = 0.5  # thicknesses: balls that touch within less need nodes at their rim
DEGREE = 4  # of the polynomial over these


@dataclass(frozen=True, eq=False)
class AtomTable:
    """Readings of round contacts; lengths in thicknesses.

    Attributes
    ----------
    coefficients : (families, radii, terms, distances) array
        Of the B-splines, in the reading's unit per newton, or per strain of the gap.
    strain : (families, radii) array, 1/N
        B-spline coefficients of ln s; empty for a linear quantity.
    curvature : (radii,) array
        B-spline coefficients of ln(F R), N m, of a ball of radius of curvature R.
    first_log : float
        ln(a/h) of the first node.
    thickness, pad_diameter : float, m
    """

    coefficients: Floats
    strain: Floats
    curvature: Floats
    first_log: float
    thickness: float
    pad_diameter: float

    @property
    def linear(self) -> bool:
        """Whether readings are proportional to the force."""
        return not self.strain.size


def log_radii() -> Floats:
    """Nodes of ln(a/h)."""
    first = np.log(SMALLEST) - MARGIN * LOG_STEP
    count = int(np.ceil((np.log(LARGEST) - np.log(SMALLEST)) / LOG_STEP)) + 2 * MARGIN + 1
    return np.asarray(first + LOG_STEP * np.arange(count))


@lru_cache(maxsize=8)
def atom_table(physics: Physics) -> AtomTable:
    """Tabulate, once for all taxels of a patch."""
    h = physics.layer.thickness
    logs = log_radii()
    furthest = np.exp(logs[-1]) + physics.pad_diameter / 2 / h + SIGHT
    distances = np.arange(0.0, furthest, DISTANCE_STEP)
    nonlinear = isinstance(physics.quantity, Capacitance) and physics.quantity.order != 1
    make = _nonlinear if nonlinear else _linear
    values, strain = make(physics, np.exp(logs) * h, distances * h)
    curvature = [np.log(curvature_force(physics.layer, a)) for a in np.exp(logs) * h]
    return AtomTable(
        coefficients=_splines(values, (1, 3)),
        strain=_splines(np.log(strain), (1,)) if nonlinear else strain,
        curvature=_splines(np.array(curvature), (0,)),
        first_log=float(logs[0]),
        thickness=h,
        pad_diameter=physics.pad_diameter,
    )


def _splines(values: Floats, axes: tuple[int, ...]) -> Floats:
    """Coefficients of cubic B-splines through values, of the same shape."""
    from scipy.ndimage import spline_filter1d

    for axis in axes:
        values = spline_filter1d(values, 3, axis=axis, mode="mirror")
    return np.ascontiguousarray(values)


def _linear(physics: Physics, radii: Floats, distances: Floats) -> tuple[Floats, Floats]:
    """Readings per newton (families, radii, 1, distances), by rings of point loads."""
    from scipy.interpolate import CubicSpline

    h = physics.layer.thickness
    mesh = np.arange(0.0, distances[-1] + radii[-1] + h, CELL * h)
    point = CubicSpline(mesh, _point_response(physics, mesh), bc_type="clamped")
    out = np.empty((len(FAMILIES), len(radii), 1, len(distances)))
    for family in FAMILIES:
        for index, radius in enumerate(radii):
            rings, forces = load_quadrature(physics.layer, physics.mechanics, family, radius)
            out[family, index, 0] = sum(
                force * _around(point, distances, ring, SHARE * h)
                for ring, force in zip(rings, forces, strict=True)
            )
    return out, np.empty((0, 0))


def _around(
    point: Callable[[Floats], Floats], distances: Floats, ring: float, share: float
) -> Floats:
    """Mean response at some distances from the axis of a ring."""
    count = 8 + int(np.ceil(np.pi * ring / share))
    cosine = np.cos((np.arange(count) + 0.5) * np.pi / count)
    square = distances[:, None] ** 2 + ring**2 - 2 * ring * distances[:, None] * cosine
    return np.asarray(point(np.sqrt(np.maximum(square, 0.0))).mean(axis=1))


def _point_response(physics: Physics, distances: Floats) -> Floats:
    """What the quantity's own linear map has for 1 N on a point, at some distances."""
    cell = CELL * physics.layer.thickness
    pad = Patch(np.zeros((1, 2)), pad_diameter=physics.pad_diameter)
    grid = Grid(pad, (1, 1), cell, np.zeros(2))
    taxels = np.column_stack([distances, np.zeros_like(distances)])
    matrix = physics.quantity.matrix(
        physics.mechanics, physics.layer, grid, taxels, physics.pad_diameter
    )
    return np.asarray(matrix[:, 0] / cell**2)


def _nonlinear(physics: Physics, radii: Floats, distances: Floats) -> tuple[Floats, Floats]:
    """Polynomials in the strain at the axis (families, radii, terms, distances), strain per N."""
    from skinfield.observation.round_gap import RoundGap

    layer, h = physics.layer, physics.layer.thickness
    pad = physics.pad_diameter if getattr(physics.quantity, "pad_averaged", True) else 0.0
    depths = np.array(STRAINS)
    powers = np.vander(depths, DEGREE + 1, increasing=True)
    fit = np.linalg.pinv(powers)
    out = np.empty((len(FAMILIES), len(radii), DEGREE + 1, len(distances)))
    strain = np.empty((len(FAMILIES), len(radii)))
    smooth = RoundGap.of(pad / h, distances / h)
    for family in FAMILIES:
        for index, radius in enumerate(radii):
            gap = smooth
            if family != BALL or radius < SHARP * h:
                gap = RoundGap.of(pad / h, distances / h, edges_of(layer, family, radius) / h)
            each = unit_indentation(layer, physics.mechanics, family, radius, gap.nodes * h) / h
            strain[family, index] = top = each.max()
            readings = gap.readings(depths[:, None] * (each / top))
            reduced = readings * ((1 - depths) / depths)[:, None]
            out[family, index] = fit @ reduced
    return out, strain
