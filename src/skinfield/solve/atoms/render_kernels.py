r"""Rendering of atoms, compiled: mean pressure on cells.

A row of `atoms` (N, 6) has x m, y m, force N, radius m, half-length m, angle rad. The contact is
drawn out along a segment where the half-length is not 0: a mixture of round ones.

With t² = 1 - r²/a², the pressure of 1 N on a round one is

.. math:: p = \frac{1}{\pi a^2} \sum_{j=0}^{J-1} c_j\, t^{2j \pm 1},

plus for a ball, minus for a flat end; J = 1 are Hertz and Boussinesq, and more terms the exact
solution on a layer.
"""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.elastic import Layer, Mechanics
from skinfield.errors import Floats
from skinfield.skin import Grid
from skinfield.solve.atoms.table import BALL, FLAT, cubic, log_radii, splines, unit_pressure

LOG_STEP = 0.2  # of ln(a/h)
SMALLEST, LARGEST = 0.15, 8.0  # radii in thicknesses that are rendered as they are
LOGS = log_radii(SMALLEST, LARGEST, LOG_STEP)  # nodes of ln(a/h)
TERMS = 8  # of the pressure
STEEPEST = 0.5  # change of a cell's share at most, to put the centre of pressure right
FEWEST, MOST = 5, 15  # round atoms along a segment
SHARP, OUTER, INNER = 8, 6, 3  # Gauss-Legendre nodes across a row of cells: of a flat end; of a
OUT = 0.8  # ball, beyond so many radii from its middle, where chords shorten quickly, and within


def _along() -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes and weights, those of n points in row n, weights adding up to 1."""
    node, weight = np.zeros((MOST + 1, MOST)), np.zeros((MOST + 1, MOST))
    for count in range(1, MOST + 1):
        x, w = np.polynomial.legendre.leggauss(count)
        node[count, :count], weight[count, :count] = x, w / 2.0
    return node, weight


NODE, WEIGHT = _along()


class PressureTable(NamedTuple):
    """Cubic B-splines over ln(a/h), the nodes `LOG_STEP` apart.

    Attributes
    ----------
    pressure : (2, radii, TERMS) array
        The coefficients c of balls and of flat ends.
    first_log : float
        ln(a/h) of the first node.
    thickness : float, m
    """

    pressure: Floats
    first_log: float
    thickness: float


@lru_cache(maxsize=8)
def pressure_table(layer: Layer, mechanics: Mechanics) -> PressureTable:
    """Tabulate, once for each layer."""
    radii = layer.thickness * np.exp(LOGS)
    terms = [
        [_pressure_terms(layer, mechanics, family, a) for a in radii] for family in (BALL, FLAT)
    ]
    return PressureTable(splines(np.array(terms), (1,)), float(LOGS[0]), layer.thickness)


def _pressure_terms(layer: Layer, mechanics: Mechanics, family: int, a: float) -> Floats:
    """Coefficients c (TERMS,) that add up to 1 N."""
    t = 0.5 - 0.5 * np.cos((np.arange(4 * TERMS) + 0.5) * np.pi / (4 * TERMS))
    weight = t if family == FLAT else np.ones_like(t)  # bounded: the edge of a flat end is not
    each = unit_pressure(layer, mechanics, family, a, a * np.sqrt(1.0 - t**2)) * (np.pi * a**2)
    power = 2.0 * np.arange(TERMS) + (1.0 if family == BALL else -1.0)  # of t
    terms = np.linalg.lstsq(t[:, None] ** power * weight[:, None], each * weight, rcond=None)[0]
    return np.asarray(terms / (terms @ (2.0 / (power + 2.0))))


class GridMesh(NamedTuple):
    """A `Grid` as compiled functions take it."""

    x: float
    y: float
    pitch: float
    rows: int
    columns: int


def mesh_of(grid: Grid) -> GridMesh:
    """Where the cells are."""
    return GridMesh(float(grid.origin[0]), float(grid.origin[1]), grid.pitch, *grid.shape)


@inner
def held(radius: float, surface: PressureTable) -> float:
    """The radius, brought to where it is tabulated."""
    return min(max(radius, SMALLEST * surface.thickness), LARGEST * surface.thickness)


@inner
def points_along(radius: float, half: float) -> int:
    """How many round atoms make up one: dense enough that they overlap."""
    if half <= 0.0:
        return 1
    return min(max(int(np.ceil(3.0 + 2.0 * half / radius)), FEWEST), MOST)


@inner
def blend(radius: float, surface: PressureTable) -> tuple[int, float, float, float, float]:
    """First of four nodes over ln(radius), and the cubic B-splines of each."""
    place = (np.log(radius / surface.thickness) - surface.first_log) / LOG_STEP
    at = int(place)
    b0, b1, b2, b3 = cubic(place - at)
    return at - 1, b0, b1, b2, b3


@inner
def pressure_terms(radius: float, family: int, surface: PressureTable, terms: Floats) -> None:
    """Coefficients of the pressure of 1 N, times pi a², into `terms` (TERMS,)."""
    at, b0, b1, b2, b3 = blend(radius, surface)
    table = surface.pressure[family]
    for j in range(TERMS):
        terms[j] = b0 * table[at, j] + b1 * table[at + 1, j]
        terms[j] += b2 * table[at + 2, j] + b3 * table[at + 3, j]


@inner
def _chord(square: float, family: int, terms: Floats, chord: Floats) -> float:
    r"""Prepare integrals of the pressure along a chord of half-length s.

    With q = s² - x², I_e = :math:`\int_0^x q^e dx` is (x q^e + 2e s² I_(e-1)) / (2e + 1): the sum
    of terms is c I_(-1/2) + x sqrt(q) times a polynomial in q; returns c, and writes the
    polynomial's coefficients into `chord`.
    """
    carried = 0.0
    exponent = TERMS - 0.5 - family
    for j in range(TERMS - 1, family - 1, -1):
        carried += terms[j]
        chord[j - family] = carried / (2.0 * exponent + 1.0)
        carried = chord[j - family] * 2.0 * exponent * square
        exponent -= 1.0
    return carried + (terms[0] if family == 1 else 0.0)


@inner
def _add_round(
    x: float,
    y: float,
    radius: float,
    share: float,
    family: int,
    terms: Floats,
    chord: Floats,
    mesh: GridMesh,
    box: Any,
    cells: Floats,
) -> None:
    """Add a round atom's force per cell to the cells of a box (first row, column, rows, columns).

    Along x each chord is integrated in closed form, so that its parts add up exactly; across, by a
    rule that is off by 2e-3 of the highest at most.
    """
    pitch = mesh.pitch / radius
    low_x = (mesh.x + (box[1] - 0.5) * mesh.pitch - x) / radius
    low_y = (mesh.y + (box[0] - 0.5) * mesh.pitch - y) / radius
    for row in range(box[2]):
        low, high = max(low_y + row * pitch, -1.0), min(low_y + (row + 1) * pitch, 1.0)
        if high <= low:
            continue
        count = SHARP if family == FLAT else OUTER if max(-low, high) > OUT else INNER
        for q in range(count):
            place = (low + high) / 2.0 + (high - low) / 2.0 * NODE[count, q]
            square = 1.0 - place * place
            half = np.sqrt(square)
            weight = share * WEIGHT[count, q] * (high - low) / np.pi
            whole = _chord(square, family, terms, chord)
            before = -whole * np.pi / 2.0
            for column in range(max(int((-half - low_x) / pitch), 0), box[3]):
                edge = low_x + (column + 1) * pitch
                now = whole * np.pi / 2.0
                if edge < half:
                    left = square - edge * edge
                    total = 0.0
                    for j in range(TERMS - 1 - family, -1, -1):
                        total = total * left + chord[j]
                    root = np.sqrt(left)
                    now = whole * np.arctan2(edge, root) + edge * root * total
                cells[row * box[3] + column] += weight * (now - before)
                before = now
                if edge >= half:
                    break


@inner
def _centre(x: float, y: float, mesh: GridMesh, box: Any, cells: Floats, moments: Floats) -> float:
    """Tilt of the shares (2,), per pitch, and their centre (2,), pitches from the box's first cell.

    A mean over cells moves the centre of pressure a little; the tilt brings it back to x and y.
    Returns the sum of the shares.
    """
    moments[:] = 0.0
    total, mean_x, mean_y = 0.0, 0.0, 0.0
    for row in range(box[2]):
        for column in range(box[3]):
            share = cells[row * box[3] + column]
            total += share
            mean_x += share * column
            mean_y += share * row
    if total <= 0.0:
        return 1.0
    mean_x /= total
    mean_y /= total
    xx, xy, yy = 0.0, 0.0, 0.0
    for row in range(box[2]):
        for column in range(box[3]):
            share = cells[row * box[3] + column] / total
            xx += share * (column - mean_x) ** 2
            xy += share * (column - mean_x) * (row - mean_y)
            yy += share * (row - mean_y) ** 2
    away_x = (x - mesh.x) / mesh.pitch - box[1] - mean_x
    away_y = (y - mesh.y) / mesh.pitch - box[0] - mean_y
    det = xx * yy - xy * xy
    if det > 0.01 * xx * yy and min(xx, yy) > 1e-6:
        tilt_x, tilt_y = (yy * away_x - xy * away_y) / det, (xx * away_y - xy * away_x) / det
    else:
        tilt_x = away_x / xx if xx > 1e-6 else 0.0
        tilt_y = away_y / yy if yy > 1e-6 else 0.0
    far_x, far_y = max(mean_x, box[3] - 1 - mean_x), max(mean_y, box[2] - 1 - mean_y)
    steep = abs(tilt_x) * far_x + abs(tilt_y) * far_y
    shrink = min(1.0, STEEPEST / steep) if steep > 0.0 else 0.0
    moments[0], moments[1] = shrink * tilt_x, shrink * tilt_y
    moments[2], moments[3] = mean_x, mean_y
    return total


@inner
def box_of(atom: Floats, radius: float, mesh: GridMesh, box: Any) -> bool:
    """First row and column, and rows and columns, that an atom covers; False if all are off."""
    wide = abs(atom[4] * np.cos(atom[5])) + radius
    high = abs(atom[4] * np.sin(atom[5])) + radius
    box[1] = int(np.floor((atom[0] - wide - mesh.x) / mesh.pitch + 0.5))
    box[0] = int(np.floor((atom[1] - high - mesh.y) / mesh.pitch + 0.5))
    box[3] = int(np.floor((atom[0] + wide - mesh.x) / mesh.pitch + 0.5)) - box[1] + 1
    box[2] = int(np.floor((atom[1] + high - mesh.y) / mesh.pitch + 0.5)) - box[0] + 1
    return bool(
        box[0] < mesh.rows and box[1] < mesh.columns and box[0] + box[2] > 0 and box[1] + box[3] > 0
    )


@inner
def add_pressure(
    atom: Floats, family: int, surface: PressureTable, mesh: GridMesh, out: Floats, box: Any
) -> bool:
    """Add an atom's mean pressure on each cell, (K,) Pa. False if it lies off the grid.

    `box` (4,) int becomes the cells it covers, also those off the grid.
    """
    radius = held(atom[3], surface)
    if not box_of(atom, radius, mesh, box):
        return False
    terms, chord, moments = np.empty(TERMS), np.empty(TERMS), np.empty(4)
    cells = np.empty(box[2] * box[3])
    cells[:] = 0.0
    pressure_terms(radius, family, surface, terms)
    count = points_along(radius, atom[4])
    east, north = atom[4] * np.cos(atom[5]), atom[4] * np.sin(atom[5])
    for q in range(count):
        node = NODE[count, q]
        x, y = atom[0] + node * east, atom[1] + node * north
        _add_round(x, y, radius, WEIGHT[count, q], family, terms, chord, mesh, box, cells)
    total = _centre(atom[0], atom[1], mesh, box, cells, moments)
    scale = atom[2] / (mesh.pitch * mesh.pitch * total)
    for row in range(max(0, -box[0]), min(box[2], mesh.rows - box[0])):
        for column in range(max(0, -box[1]), min(box[3], mesh.columns - box[1])):
            tilt = moments[0] * (column - moments[2]) + moments[1] * (row - moments[3])
            k = (box[0] + row) * mesh.columns + box[1] + column
            out[k] += scale * (1.0 + tilt) * cells[row * box[3] + column]
    return True


@inner
def pressure_at(atoms: Floats, family: Any, surface: PressureTable, x: float, y: float) -> float:
    """Pressure of atoms at a place, Pa; at the edge of a flat end that of its middle."""
    total, terms = 0.0, np.empty(TERMS)
    for n in range(len(atoms)):
        radius = held(atoms[n, 3], surface)
        pressure_terms(radius, family[n], surface, terms)
        count = points_along(radius, atoms[n, 4])
        east, north = atoms[n, 4] * np.cos(atoms[n, 5]), atoms[n, 4] * np.sin(atoms[n, 5])
        for q in range(count):
            away_x = x - atoms[n, 0] - NODE[count, q] * east
            away_y = y - atoms[n, 1] - NODE[count, q] * north
            square = 1.0 - (away_x * away_x + away_y * away_y) / (radius * radius)
            if square <= 0.0:
                continue
            value = 0.0
            for j in range(TERMS - 1, -1, -1):
                value = value * square + terms[j]
            root = np.sqrt(square)
            value = value / max(root, 0.5) if family[n] == FLAT else value * root
            total += WEIGHT[count, q] * atoms[n, 2] * value / (np.pi * radius * radius)
    return total


@njit
def render(
    atoms: Floats, family: Any, surface: PressureTable, mesh: GridMesh, out: Floats
) -> float:
    """Write the mean pressure of atoms on each cell, (K,) Pa; returns the peak of it, Pa.

    It is the highest on an atom's middle or on a cell: at the edge of a flat end there is none.
    """
    out[:] = 0.0
    box = np.empty(4, np.int64)
    for n in range(len(atoms)):
        add_pressure(atoms[n], family[n], surface, mesh, out, box)
    peak = 0.0
    for k in range(len(out)):
        peak = max(peak, out[k])
    for n in range(len(atoms)):
        peak = max(peak, pressure_at(atoms, family, surface, atoms[n, 0], atoms[n, 1]))
    return peak


@inner(_nrt=False)
def profile_spread(family: int, radius: float, surface: PressureTable, terms: Floats) -> float:
    r"""Second moment along x of a round atom's pressure over its force, m².

    With t² = 1 - r²/a² it is :math:`a^2 \sum_j c_j (1/(e_j+2) - 1/(e_j+4))`, e the powers of t.
    """
    pressure_terms(radius, family, surface, terms)
    total = 0.0
    for j in range(len(terms)):
        power = 2.0 * j + (1.0 if family == BALL else -1.0)
        total += terms[j] * (1.0 / (power + 2.0) - 1.0 / (power + 4.0))
    return radius * radius * total
