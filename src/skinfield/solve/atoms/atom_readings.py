"""Readings of atoms, compiled, with their derivatives.

An atom has six parameters: x and y of its middle, ln(force/N), ln(radius/thickness), and the two
components of its half-length, all lengths in thicknesses. A half-length of 0 is a round contact;
else the contact is drawn out along a segment, a mixture of round ones.
"""

from typing import Any, NamedTuple

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats
from skinfield.solve.atoms.table import Tables, cubic, cubic_slopes

PARAMETERS = 6
NODE, WEIGHT = np.polynomial.legendre.leggauss(7)  # along the segment
WEIGHT = WEIGHT / 2.0


@inner(_nrt=False)
def along(coefficients: Floats, place: float) -> tuple[float, float]:
    """Value and slope per node of a B-spline (N,) at a place inside."""
    at = int(place)
    b0, b1, b2, b3 = cubic(place - at)
    d0, d1, d2, d3 = cubic_slopes(place - at)
    c0, c1 = coefficients[at - 1], coefficients[at]
    c2, c3 = coefficients[at + 1], coefficients[at + 2]
    return b0 * c0 + b1 * c1 + b2 * c2 + b3 * c3, d0 * c0 + d1 * c1 + d2 * c2 + d3 * c3


class TableRoom(NamedTuple):
    """Scratch memory for the tables of one atom.

    Attributes
    ----------
    radial : (3, distances) array
        B-spline coefficients over distance alone.
    power : (2, terms) array
        Powers of the strain and their slopes.
    weight : (2, 4) array
    """

    radial: Floats
    power: Floats
    weight: Floats

    @classmethod
    def of(cls, tables: Tables) -> "TableRoom":
        """Room for some tables."""
        terms, distances = tables.coefficients.shape[2:]
        return cls(np.zeros((3, distances)), np.zeros((2, terms)), np.zeros((2, 4)))


@inner(_nrt=False)
def _radial(grid: Floats, place: float, log_step: float, nodes: int, room: "TableRoom") -> None:
    """B-spline coefficients over distance alone of an atom of one radius and depth.

    Of the polynomial in u, of its slope by ln radius, and of that by u, into `radial` of the room;
    `grid` is the table (radii, terms, distances).
    """
    out, power, weight = room.radial, room.power, room.weight
    i = int(place)
    weight[0, 0], weight[0, 1], weight[0, 2], weight[0, 3] = cubic(place - i)
    weight[1, 0], weight[1, 1], weight[1, 2], weight[1, 3] = cubic_slopes(place - i)
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


@inner(_nrt=False)
def _look_up(radial: Floats, distance: float, last: int) -> tuple[float, float, float, float]:
    """Value, slope by distance in nodes, and the other two slopes, at a distance in nodes."""
    j = int(distance)
    first, second, third = abs(j - 1), min(j + 1, last), min(j + 2, last)
    w0, w1, w2, w3 = cubic(distance - j)
    d0, d1, d2, d3 = cubic_slopes(distance - j)
    c0, c1, c2, c3 = radial[0, first], radial[0, j], radial[0, second], radial[0, third]
    value = w0 * c0 + w1 * c1 + w2 * c2 + w3 * c3
    slope = d0 * c0 + d1 * c1 + d2 * c2 + d3 * c3
    c0, c1, c2, c3 = radial[1, first], radial[1, j], radial[1, second], radial[1, third]
    by_radius = w0 * c0 + w1 * c1 + w2 * c2 + w3 * c3
    c0, c1, c2, c3 = radial[2, first], radial[2, j], radial[2, second], radial[2, third]
    return value, slope, by_radius, w0 * c0 + w1 * c1 + w2 * c2 + w3 * c3


@inner(_nrt=False)
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


@inner(_nrt=False)
def add_atom(
    n: int,
    count: int,
    atom: Floats,
    family: int,
    taxels: Floats,
    near: Any,
    tables: Tables,
    room: TableRoom,
    out: Floats,
    jacobian: Floats,
) -> None:
    """Add the readings of one atom of `count` at the listed taxels to `out` (L,).

    Its derivatives are added to `jacobian`, where those of the k-th listed taxel by the parameters
    of atom n begin at 6 (k `count` + n).
    """
    x, y, east, north = atom[0], atom[1], atom[4], atom[5]
    radius, half = np.exp(atom[3]), np.hypot(east, north)
    points = 1 if half == 0.0 else 7
    gain, u, scale_slope, thinning = _depth(atom, family, half / radius, tables, room.power)
    place = (atom[3] - tables.first_log) / tables.log_step
    reach = radius + half + tables.pad_radius + tables.sight
    last = min(int((reach + half) / tables.distance_step) + 4, room.radial.shape[1]) - 1
    _radial(tables.coefficients[family], place, tables.log_step, last + 1, room)
    log_slope = scale_slope + thinning  # of u, by ln radius
    stretch = thinning / (half * half) if points > 1 else 0.0  # of u, by the half-length
    for k in range(len(near)):
        taxel, base = near[k], 6 * (k * count + n)
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
            value, slope, by_radius, by_strain = _look_up(
                room.radial, r / tables.distance_step, last
            )
            reading = share * value
            slope *= share / tables.distance_step / max(r, 1e-9)
            by_u = u * (share * by_strain + reading / (1.0 - u))  # per d ln u
            out[taxel] += reading
            jacobian[base] -= slope * rx
            jacobian[base + 1] -= slope * ry
            jacobian[base + 2] += reading + by_u
            jacobian[base + 3] += share * by_radius + reading * scale_slope + by_u * log_slope
            if points > 1:
                jacobian[base + 4] -= slope * rx * node + by_u * stretch * east
                jacobian[base + 5] -= slope * ry * node + by_u * stretch * north


@njit
def predict(
    atoms: Floats, family: Any, taxels: Floats, tables: Tables, out: Floats, jacobian: Floats
) -> None:
    """Write readings (L,) of atoms (N, 6) and derivatives (L, N, 6)."""
    out[:] = 0.0
    flat, count, near = jacobian.reshape(-1), len(atoms), np.arange(len(taxels))
    flat[:] = 0.0
    room = TableRoom(
        np.empty((3, tables.coefficients.shape[3])),
        np.empty((2, tables.coefficients.shape[2])),
        np.empty((2, 4)),
    )
    for n in range(count):
        add_atom(n, count, atoms[n], family[n], taxels, near, tables, room, out, flat)
