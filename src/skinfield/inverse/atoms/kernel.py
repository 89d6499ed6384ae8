"""Readings of atoms and their derivatives, compiled: what a fit does most.

An atom has six parameters: x and y of its middle, ln(force/N), ln(radius/thickness), and the two
components of its half-length, all lengths in thicknesses. A half-length of 0 is a round contact;
else the contact is drawn out along a segment, a mixture of round ones.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from skinfield.errors import Floats
from skinfield.inverse.atoms.compiled import inner
from skinfield.inverse.atoms.table import DISTANCE_STEP, LOG_STEP, SIGHT, AtomTable

PARAMETERS = 6
NODE, WEIGHT = np.polynomial.legendre.leggauss(7)  # along the segment
WEIGHT = WEIGHT / 2.0


class Tables(NamedTuple):
    """An `AtomTable` as compiled functions take it.

    Its steps go along: what is compiled is kept on disk, and a constant would be kept with it.
    """

    coefficients: Floats
    strain: Floats
    curvature: Floats
    first_log: float
    log_step: float
    distance_step: float
    sight: float
    pad_radius: float


def tables_of(table: AtomTable) -> Tables:
    """Arrays of a table; one that is linear has ln s = 0 and no denominator."""
    strain = table.strain if not table.linear else np.zeros((0, 0))
    return Tables(
        table.coefficients,
        strain,
        table.curvature,
        table.first_log,
        LOG_STEP,
        DISTANCE_STEP,
        SIGHT,
        table.pad_diameter / 2 / table.thickness,
    )


@inner
def along(coefficients: Floats, place: float) -> tuple[float, float]:
    """Value and slope per node of a B-spline (N,) at a place inside."""
    at = int(place)
    t = place - at
    s = 1.0 - t
    c0, c1 = coefficients[at - 1], coefficients[at]
    c2, c3 = coefficients[at + 1], coefficients[at + 2]
    value = (
        c0 * s**3 + c1 * (3 * t**3 - 6 * t**2 + 4) + c2 * (3 * s**3 - 6 * s**2 + 4) + c3 * t**3
    ) / 6.0
    slope = (-c0 * s**2 + c1 * (3 * t**2 - 4 * t) + c2 * (4 * s - 3 * s**2) + c3 * t**2) / 2.0
    return value, slope


@inner
def _radial(
    grid: Floats, place: float, log_step: float, power: Floats, nodes: int, out: Floats
) -> None:
    """B-spline coefficients over distance alone of an atom of one radius and depth.

    Of the polynomial in u, of its slope by ln radius, and of that by u, into `out` (3, nodes);
    `grid` is the table (radii, terms, distances), `power` (2, terms) the powers of u and their
    slopes.
    """
    i = int(place)
    t = place - i
    s = 1.0 - t
    weight = np.empty((2, 4))
    weight[0, 0], weight[0, 3] = s * s * s / 6.0, t * t * t / 6.0
    weight[0, 1] = (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0
    weight[0, 2] = (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0
    weight[1, 0], weight[1, 3] = -0.5 * s * s, 0.5 * t * t
    weight[1, 1], weight[1, 2] = 1.5 * t * t - 2.0 * t, -1.5 * s * s + 2.0 * s
    out[:, :nodes] = 0.0
    for a in range(4):
        for k in range(power.shape[1]):
            row = grid[i - 1 + a, k]
            value = weight[0, a] * power[0, k]
            by_radius = weight[1, a] / log_step * power[0, k]
            by_u = weight[0, a] * power[1, k]
            for j in range(nodes):
                out[0, j] += value * row[j]
                out[1, j] += by_radius * row[j]
                out[2, j] += by_u * row[j]


@inner
def _look_up(radial: Floats, distance: float, last: int, found: Floats) -> None:
    """Value, slope by distance in nodes, and the other two slopes, at a distance in nodes."""
    j = int(distance)
    t = distance - j
    s = 1.0 - t
    first, second, third = abs(j - 1), min(j + 1, last), min(j + 2, last)
    w0, w3 = s * s * s / 6.0, t * t * t / 6.0
    w1 = (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0
    w2 = (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0
    d0, d1, d2, d3 = -0.5 * s * s, 1.5 * t * t - 2.0 * t, -1.5 * s * s + 2.0 * s, 0.5 * t * t
    c0, c1, c2, c3 = radial[0, first], radial[0, j], radial[0, second], radial[0, third]
    found[0] = w0 * c0 + w1 * c1 + w2 * c2 + w3 * c3
    found[1] = d0 * c0 + d1 * c1 + d2 * c2 + d3 * c3
    for k in range(1, 3):
        row = radial[k]
        found[k + 1] = w0 * row[first] + w1 * row[j] + w2 * row[second] + w3 * row[third]


@njit(cache=True, nogil=True)
def predict(
    atoms: Floats, family: Any, taxels: Floats, tables: Tables, out: Floats, jacobian: Floats
) -> None:
    """Write readings (L,) of atoms (N, 6) and derivatives (L, N, 6)."""
    out[:] = 0.0
    jacobian[:] = 0.0
    radial = np.empty((3, tables.coefficients.shape[3]))
    for n in range(atoms.shape[0]):
        _add_atom(n, atoms[n], family[n], taxels, tables, radial, out, jacobian)


@inner
def _depth(
    atom: Floats, family: int, slenderness: float, tables: Tables, power: Floats
) -> tuple[float, float, float, float]:
    """Factor of the table; strain u; slope of ln s by ln radius; how a longer contact is less deep.

    Writes the powers of u and their slopes into `power` (2, terms).
    """
    force, scale, scale_slope, u, thinning = np.exp(atom[2]), 1.0, 0.0, 0.0, 0.0
    if tables.strain.shape[0]:
        place = (atom[3] - tables.first_log) / tables.log_step
        value, slope = along(tables.strain[family], place)
        scale, scale_slope = np.exp(value), slope / tables.log_step
        thin = 4.0 * slenderness / np.pi  # area beside the round ends over theirs
        thinning = thin / (1.0 + thin)
        u = min(force * scale / (1.0 + thin), 0.95)
    power[0, 0], power[1, 0] = 1.0, 0.0
    for k in range(1, power.shape[1]):
        power[0, k] = power[0, k - 1] * u
        power[1, k] = k * power[0, k - 1]
    return force * scale / (1.0 - u), u, scale_slope, thinning


@inner
def _add_atom(
    n: int,
    atom: Floats,
    family: int,
    taxels: Floats,
    tables: Tables,
    radial: Floats,
    out: Floats,
    jacobian: Floats,
) -> None:
    """Add the readings of one atom, and their derivatives at [:, n]."""
    x, y, east, north = atom[0], atom[1], atom[4], atom[5]
    radius, half = np.exp(atom[3]), np.hypot(east, north)
    points = 1 if half == 0.0 else 7
    power = np.empty((2, tables.coefficients.shape[2]))
    gain, u, scale_slope, thinning = _depth(atom, family, half / radius, tables, power)
    place = (atom[3] - tables.first_log) / tables.log_step
    reach = radius + half + tables.pad_radius + tables.sight
    last = min(int((reach + half) / tables.distance_step) + 4, radial.shape[1]) - 1
    _radial(tables.coefficients[family], place, tables.log_step, power, last + 1, radial)
    found = np.empty(4)
    log_slope = scale_slope + thinning  # of u, by ln radius
    stretch = thinning / (half * half) if points > 1 else 0.0  # of u, by the half-length
    for taxel in range(taxels.shape[0]):
        away_x, away_y = taxels[taxel, 0] - x, taxels[taxel, 1] - y
        if away_x * away_x + away_y * away_y > reach * reach:
            continue
        for q in range(points):
            share = gain if points == 1 else gain * WEIGHT[q]
            node = 0.0 if points == 1 else NODE[q]
            rx, ry = away_x - node * east, away_y - node * north
            r = np.hypot(rx, ry)
            if r > (last - 2) * tables.distance_step:
                continue
            _look_up(radial, r / tables.distance_step, last, found)
            reading = share * found[0]
            slope = share * found[1] / tables.distance_step / max(r, 1e-9)
            by_u = u * (share * found[3] + reading / (1.0 - u))  # per d ln u
            out[taxel] += reading
            jacobian[taxel, n, 0] -= slope * rx
            jacobian[taxel, n, 1] -= slope * ry
            jacobian[taxel, n, 2] += reading + by_u
            jacobian[taxel, n, 3] += share * found[2] + reading * scale_slope + by_u * log_slope
            if points > 1:
                jacobian[taxel, n, 4] -= slope * rx * node + by_u * stretch * east
                jacobian[taxel, n, 5] -= slope * ry * node + by_u * stretch * north
