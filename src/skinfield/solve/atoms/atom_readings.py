"""Readings of atoms, compiled, with their derivatives.

An atom has eight parameters: x and y of its middle, ln(force/N), ln(radius/thickness), the two
components of its half-length, and those of the force along the skin over the force into it; all
lengths in thicknesses. A half-length of 0 is a round contact; else the contact is drawn out along a
segment, a mixture of round ones. Where both components of the force along the skin are 0, it only
presses.
"""

from typing import Any, NamedTuple

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats
from skinfield.solve.atoms.table import Tables, cubic, cubic_slopes

PARAMETERS = 8
IN_GAP = 0.38  # of the strain at the axis: by so much less, in parts, a shear is read
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
    shear : (2, distances) array
        B-spline coefficients over distance of the shear's table, and of its slope by ln radius.
    """

    radial: Floats
    power: Floats
    weight: Floats
    shear: Floats

    @classmethod
    def of(cls, tables: Tables) -> "TableRoom":
        """Room for some tables."""
        terms, distances = tables.coefficients.shape[2:]
        shear = np.zeros((2, tables.shear.shape[2]))
        return cls(np.zeros((3, distances)), np.zeros((2, terms)), np.zeros((2, 4)), shear)


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
    w0, w1, w2, w3 = weight[0, 0], weight[0, 1], weight[0, 2], weight[0, 3]
    d0, d1 = weight[1, 0] / log_step, weight[1, 1] / log_step
    d2, d3 = weight[1, 2] / log_step, weight[1, 3] / log_step
    values, by_radius, by_u = out[0, :nodes], out[1, :nodes], out[2, :nodes]
    for k in range(power.shape[1]):
        a, b = grid[i - 1, k, :nodes], grid[i, k, :nodes]
        c, d = grid[i + 1, k, :nodes], grid[i + 2, k, :nodes]
        now, slope = power[0, k], power[1, k]
        for j in range(len(values)):
            value = w0 * a[j] + w1 * b[j] + w2 * c[j] + w3 * d[j]
            values[j] += now * value
            by_u[j] += slope * value
            by_radius[j] += now * (d0 * a[j] + d1 * b[j] + d2 * c[j] + d3 * d[j])


@inner(forceinline=True, _nrt=False)
def is_long(atom: Floats) -> bool:
    """Whether an atom is drawn out: else its half-length stays 0."""
    return bool(atom[4] != 0.0 or atom[5] != 0.0)


@inner(forceinline=True, _nrt=False)
def is_sheared(atom: Floats) -> bool:
    """Whether an atom pushes along the skin: else it stays without."""
    return bool(atom[6] != 0.0 or atom[7] != 0.0)


@inner(forceinline=True, _nrt=False)
def free_of(atom: Floats) -> int:
    """How many of an atom's parameters move."""
    return 4 + (2 if is_long(atom) else 0) + (2 if is_sheared(atom) else 0)


@inner(forceinline=True, _nrt=False)
def parameter_of(atom: Floats, k: int) -> int:
    """The k-th of an atom's parameters that move."""
    return k if k < 4 or is_long(atom) else k + 2


@inner(_nrt=False)
def _sheared_radial(
    grid: Floats, place: float, log_step: float, nodes: int, room: "TableRoom"
) -> None:
    """B-spline coefficients over distance of a shear below an atom of one radius; see `_radial`."""
    out, weight, i = room.shear, room.weight, int(place)
    for j in range(nodes):
        value, slope = 0.0, 0.0
        for k in range(4):
            value += weight[0, k] * grid[i - 1 + k, j]
            slope += weight[1, k] * grid[i - 1 + k, j]
        out[0, j], out[1, j] = value, slope / log_step


@inner(_nrt=False)
def _look_up_shear(radial: Floats, distance: float, last: int) -> tuple[float, float, float]:
    """Value, slope by distance in nodes, and slope by ln radius, at a distance in nodes."""
    j = int(distance)
    first, second, third = abs(j - 1), min(j + 1, last), min(j + 2, last)
    w0, w1, w2, w3 = cubic(distance - j)
    d0, d1, d2, d3 = cubic_slopes(distance - j)
    c0, c1, c2, c3 = radial[0, first], radial[0, j], radial[0, second], radial[0, third]
    value = w0 * c0 + w1 * c1 + w2 * c2 + w3 * c3
    slope = d0 * c0 + d1 * c1 + d2 * c2 + d3 * c3
    c0, c1, c2, c3 = radial[1, first], radial[1, j], radial[1, second], radial[1, third]
    return value, slope, w0 * c0 + w1 * c1 + w2 * c2 + w3 * c3


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


@inner(heavy=True, _nrt=False)
def add_atom(
    n: int,
    atom: Floats,
    family: int,
    taxels: Floats,
    near: Any,
    tables: Tables,
    room: TableRoom,
    out: Floats,
    jacobian: Floats,
) -> tuple[int, int]:
    """Add the readings of the n-th atom at the listed taxels to `out` (L,).

    Its derivatives at these are written to rows 8 n to 8 n + 7 of `jacobian`, one per parameter.
    Returns the first of the listed taxels that reads it, and the one after the last.
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
    stretch = thinning / half / half if points > 1 else 0.0  # of u, by the half-length
    nodes, square, deeper = 1.0 / tables.distance_step, reach * reach, u / (1.0 - u)
    farthest, first, after = (last - 2) * tables.distance_step, len(near), 0
    row, sheared = (
        jacobian[PARAMETERS * n : PARAMETERS * n + PARAMETERS, : len(near)],
        is_sheared(atom),
    )
    for i in range(PARAMETERS):
        row[i] = 0.0
    push = np.exp(atom[2]) * (1.0 - IN_GAP * u)  # of what a shear is read as
    fall, tx, ty = np.exp(atom[2]) * IN_GAP * u, atom[6], atom[7]
    if sheared:
        _sheared_radial(tables.shear[family], place, tables.log_step, last + 1, room)
    for k in range(len(near)):
        taxel = near[k]
        away_x, away_y = taxels[taxel, 0] - x, taxels[taxel, 1] - y
        if away_x * away_x + away_y * away_y > square:
            continue
        first, after = min(first, k), k + 1
        for q in range(points):
            share = gain if points == 1 else gain * WEIGHT[q]
            node = 0.0 if points == 1 else NODE[q]
            rx, ry = away_x - node * east, away_y - node * north
            r = np.sqrt(rx * rx + ry * ry)
            if r > farthest:
                continue
            value, slope, by_radius, by_strain = _look_up(room.radial, r * nodes, last)
            reading = share * value
            slope *= share * nodes / max(r, 1e-9)
            by_u = u * share * by_strain + reading * deeper  # per d ln u
            out[taxel] += reading
            row[0, k] -= slope * rx
            row[1, k] -= slope * ry
            row[2, k] += reading + by_u
            row[3, k] += share * by_radius + reading * scale_slope + by_u * log_slope
            if points > 1:
                row[4, k] -= slope * rx * node + by_u * stretch * east
                row[5, k] -= slope * ry * node + by_u * stretch * north
            if sheared:
                weight = 1.0 if points == 1 else WEIGHT[q]
                value, slope, by_radius = _look_up_shear(room.shear, r * nodes, last)
                along_it = weight * (tx * rx + ty * ry)
                steep = along_it * slope * nodes / max(r, 1e-9)
                by_x, by_y = weight * tx * value + steep * rx, weight * ty * value + steep * ry
                reading = along_it * value
                out[taxel] += push * reading
                row[0, k] -= push * by_x
                row[1, k] -= push * by_y
                row[2, k] += (push - fall) * reading
                row[3, k] += push * along_it * by_radius - fall * log_slope * reading
                if points > 1:
                    row[4, k] -= push * by_x * node - fall * stretch * east * reading
                    row[5, k] -= push * by_y * node - fall * stretch * north * reading
                row[6, k] += push * weight * rx * value
                row[7, k] += push * weight * ry * value
    return first, after


@njit
def predict(
    atoms: Floats, family: Any, taxels: Floats, tables: Tables, out: Floats, jacobian: Floats
) -> None:
    """Write readings (L,) of atoms (N, 8) and derivatives (N, 8, L)."""
    out[:] = 0.0
    rows, near = jacobian.reshape(-1, len(taxels)), np.arange(len(taxels))
    room = TableRoom(
        np.empty((3, tables.coefficients.shape[3])),
        np.empty((2, tables.coefficients.shape[2])),
        np.empty((2, 4)),
        np.empty((2, tables.shear.shape[2])),
    )
    for n in range(len(atoms)):
        add_atom(n, atoms[n], family[n], taxels, near, tables, room, out, rows)
