"""Contacts of atoms as rows of numbers, compiled: place, force, deviations, area and moments.

Atoms become what is drawn: in SI, at the posterior's mean, rings as rows of small balls. Those that
overlap are one contact. See `skinfield.estimate.live_contacts` for the rows.
"""

from typing import Any, NamedTuple

import numpy as np

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints
from skinfield.estimate.live_contacts_kernel import (
    FORCE_FORCE,
    X_FORCE,
    XX,
    XY,
    Y_FORCE,
    YY,
    lay_along,
    put_on,
    state_deviations,
)
from skinfield.estimate.row_contacts import SHAPES
from skinfield.solve.atoms.atom_readings import PARAMETERS, is_long, is_sheared
from skinfield.solve.atoms.fit_kernel import NOW, SHEAR_STD, FitMemory
from skinfield.solve.atoms.posterior_kernel import PosteriorMemory
from skinfield.solve.atoms.render_kernels import (
    TERMS,
    GridMesh,
    PressureTable,
    held,
    pressure_at,
    profile_spread,
    render,
)
from skinfield.solve.atoms.split_kernel import PairMemory, mix_covariance, rival_of
from skinfield.solve.atoms.strips_kernel import LONE, NONE, UNSURE, Strips
from skinfield.solve.atoms.table import BALL, FLAT, RIM, RING
from skinfield.solve.packed import PackedType, unpacking

PEARLS = 64  # small balls that all rings together become
FEWEST, MOST = 8, 32  # of one ring
SHARE = 0.5  # thicknesses between them
# What no residual shows, in thicknesses, and part of the force: the modulus, by 2 Shore A, pads
# that lie elsewhere, what is no perfect ball or flat end, line, or ring; and more per model error.
ROUND, LONG, ANNULAR = np.array([0.1, 0.09]), np.array([0.25, 0.15]), np.array([0.25, 0.25])
HIDDEN = np.array([3.0, 1.5])
OTHER, SPHERE, PLANE, SEGMENT = range(len(SHAPES))  # as `SHAPES` has them
SLIDES, UNEVEN = 0.08, 0.02  # part of a force along the skin, and of that into it, it is off by
LINE = 0.5  # half-length over radius from which an atom is drawn out, not round
AROUND = 16  # places around an atom, of which its border's share in that of its body is counted
FINE = 48  # places along the sides of a body of several atoms, of which its area is counted
OUTSIDE = 1.0 + 1e-6  # radii: just outside an atom
TIE = 1e-9  # as in `skinfield.estimate.ranking`: forces that differ by this part are equal


class Drawing(NamedTuple):
    """Atoms as they are drawn, N of W.

    Attributes
    ----------
    atoms : (W, 8) array
        Of x m, y m, force N, radius m, half-length m, angle rad and forces along the skin, N.
    family : (W,) int array
        Balls and flat ends.
    covariance : (W, 8, 8) array
        Of each alone; of a ring, at its first small ball.
    owner : (W,) int array
        Number of the body of each.
    order : (W,) int array
        Bodies by falling force.
    sums : (2, W) array
        Of bodies: their force, N, and their radius as a ring, m, else 0.
    errors : (3,) array
        Deviations of place, thicknesses, and of the force's logarithm, as the mechanics are not
        sure; and what the model is wrong by, part of what taxels read.
    by : (2, 8, 8) array
        Room.
    maybe : (W,) int array
        How many contacts may be in the place of each, or of it and another; 0 where that is sure.
    strip : (W,) int array
        Of each atom of the fit: see `strips_kernel`.
    drawn : (1,) int array
        N.
    """

    atoms: Floats
    family: Ints
    covariance: Floats
    owner: Ints
    order: Ints
    sums: Floats
    errors: Floats
    by: Floats
    maybe: Ints
    strip: Ints
    drawn: Ints

    @classmethod
    def of(cls, most: int) -> "Drawing":
        """Room for so many atoms, and the small balls of rings."""
        room = most + PEARLS
        return cls(
            np.zeros((room, PARAMETERS)),
            np.zeros(room, np.int64),
            np.zeros((room, PARAMETERS, PARAMETERS)),
            np.zeros(room, np.int64),
            np.zeros(room, np.int64),
            np.zeros((2, room)),
            np.zeros(3),
            np.zeros((2, PARAMETERS, PARAMETERS)),
            np.zeros(room, np.int64),
            np.full(room, LONE, np.int64),
            np.zeros(1, np.int64),
        )


class RowGrid(NamedTuple):
    """Grid on which contacts stand.

    Attributes
    ----------
    mesh : GridMesh
    positions, normals : (K, 3) arrays
    surface : PressureTable
    thickness : float, m
    spread : float
        See `Grid.spread`: of so much more surface, the same force is less pressure.
    """

    mesh: GridMesh
    positions: Floats
    normals: Floats
    surface: PressureTable
    thickness: float
    spread: float


def smallest_grid() -> RowGrid:
    """Of no size: what kinds of arrays it has."""
    surface, places = PressureTable(np.zeros((2, 1, 1)), 0.0, 0.0), np.zeros((1, 3))
    return RowGrid(GridMesh(0.0, 0.0, 0.0, 1, 1), places, places, surface, 0.0, 1.0)


GRID = PackedType(smallest_grid())
unpack_grid = unpacking(GRID)


@inner(_nrt=False)
def transform(covariance: Floats, by: Floats, room: Floats, out: Floats) -> None:
    """Write by covariance by^T, all (8, 8)."""
    for i in range(PARAMETERS):
        for j in range(PARAMETERS):
            total = 0.0
            for k in range(PARAMETERS):
                total += by[i, k] * covariance[k, j]
            room[i, j] = total
    for i in range(PARAMETERS):
        for j in range(PARAMETERS):
            total = 0.0
            for k in range(PARAMETERS):
                total += room[i, k] * by[j, k]
            out[i, j] = total


@inner(_nrt=False)
def draw_atom(
    memory: FitMemory,
    post: PosteriorMemory,
    pairs: PairMemory,
    index: int,
    thickness: float,
    at_mean: bool,
    drawing: Drawing,
    place: int,
) -> None:
    """Draw one atom of NOW into a place."""
    atom, mean = drawing.atoms[place], memory.atoms[NOW, index]
    long, ring = is_long(mean), memory.family[NOW, index] == RING
    by, room = drawing.by[0], drawing.by[1]
    for i in range(PARAMETERS):
        atom[i] = mean[i] + (post.offsets[index, i] if at_mean else 0.0)
        for j in range(PARAMETERS):
            by[i, j] = 0.0
    east, north = atom[4], atom[5]
    half, angle = np.hypot(east, north), np.arctan2(north, east)
    atom[0], atom[1] = atom[0] * thickness, atom[1] * thickness
    atom[2], atom[3] = np.exp(atom[2]), np.exp(atom[3]) * thickness
    atom[4], atom[5] = half * thickness, angle
    by[0, 0], by[1, 1], by[2, 2], by[3, 3] = thickness, thickness, atom[2], atom[3]
    for k in range(6, 8):  # forces along the skin
        by[k, 2], by[k, k] = atom[2] * atom[k], atom[2]
        atom[k] *= atom[2]
    if half > 0.0:
        by[4, 4], by[4, 5] = thickness * np.cos(angle), thickness * np.sin(angle)
        by[5, 4], by[5, 5] = -np.sin(angle) / half, np.cos(angle) / half
    covariance = drawing.covariance[place]
    error, errors = ANNULAR if ring else LONG if long else ROUND, drawing.errors
    for i in range(PARAMETERS):
        for j in range(PARAMETERS):
            covariance[i, j] = post.covariance[index, i, j]
    drawing.maybe[place] = rival_of(memory, pairs, index)
    if drawing.maybe[place]:
        mix_covariance(pairs, index, covariance)
    for i in range(4):
        unsure = errors[i // 2] ** 2 + (HIDDEN[i // 2] * errors[2]) ** 2
        covariance[i, i] += error[i // 2] ** 2 + unsure
    for k in range(6, 8):
        own = SLIDES * SLIDES * (atom[6] ** 2 + atom[7] ** 2) / atom[2] ** 2 + UNEVEN * UNEVEN
        covariance[k, k] += own if is_sheared(mean) else SHEAR_STD * SHEAR_STD
    transform(covariance, by, room, covariance)
    drawing.family[place] = memory.family[NOW, index]


@inner(_nrt=False)
def draw(
    memory: FitMemory,
    post: PosteriorMemory,
    pairs: PairMemory,
    strips: Strips,
    thickness: float,
    at_mean: bool,
    drawing: Drawing,
) -> int:
    """Draw the atoms of NOW and number their bodies; how many atoms are drawn."""
    count = 0
    for rings in range(2):
        for index in range(memory.counts[NOW]):
            strip, room = drawing.strip[index], len(drawing.atoms) - count
            is_ring = memory.family[NOW, index] == RING
            if strip == NONE or is_ring != (rings == 1) or (is_ring and room <= FEWEST):
                continue
            first = count
            if is_ring:
                count = draw_ring(memory, post, pairs, index, thickness, at_mean, drawing, count)
            else:
                draw_atom(memory, post, pairs, index, thickness, at_mean, drawing, count)
                if strip == LONE:
                    join(drawing, count)
                else:
                    drawing.owner[count] = count
                count += 1
            if strip != LONE:
                join_strip(drawing, strip, first, count)
    for strip in range(strips.counts[0]):
        count += divide(drawing, strips, strip, thickness, count)
    return count


@inner(_nrt=False)
def divide(drawing: Drawing, strips: Strips, strip: int, thickness: float, count: int) -> int:
    """Draw a part of an atom for a strip that has none; 1 if there is one, else 0.

    The parts are as strong as what is read in the strips, and as unsure as a strip is wide.
    """
    parent, nearest = -1, np.inf
    x, y = thickness * strips.middle[strip, 0], thickness * strips.middle[strip, 1]
    for n in range(count):
        if drawing.order[n] == strip:
            return 0
        apart = np.hypot(drawing.atoms[n, 0] - x, drawing.atoms[n, 1] - y) - drawing.atoms[n, 3]
        if apart < nearest:
            parent, nearest = n, apart
    if parent < 0 or count == len(drawing.atoms):
        return 0
    own, half = strips.middle[drawing.order[parent], 2], thickness * strips.half
    share = strips.middle[strip, 2] / (strips.middle[strip, 2] + own)
    for i in range(PARAMETERS):
        drawing.atoms[count, i] = drawing.atoms[parent, i]
    drawing.atoms[count, 0], drawing.atoms[count, 1] = x, y
    for k in (2, 6, 7):
        drawing.atoms[count, k] = share * drawing.atoms[parent, k]
        drawing.atoms[parent, k] *= 1.0 - share
    drawing.atoms[count, 3] = min(drawing.atoms[parent, 3], half)
    drawing.atoms[count, 4], drawing.maybe[count], drawing.order[count] = 0.0, 0, strip
    drawing.family[count], drawing.owner[count] = drawing.family[parent], count
    drawing.sums[1, count] = 0.0
    for i in range(PARAMETERS):
        for j in range(PARAMETERS):
            known = drawing.covariance[parent, i, j]
            drawing.covariance[count, i, j] = known if i == j else 0.0
            for k in (i, j):
                drawing.covariance[parent, i, j] *= 1.0 - share if k == 2 else 1.0
    drawing.covariance[count, 2, 2] *= share * share
    for i in range(2):
        drawing.covariance[count, i, i] += half * half / 3.0
    return 1


@inner(_nrt=False)
def join(drawing: Drawing, place: int) -> None:
    """Number the body of an atom, after those before: the lowest of those that it overlaps."""
    drawing.owner[place], drawing.sums[1, place] = place, 0.0
    for other in range(place):
        one, its = drawing.atoms[place], drawing.atoms[other]
        if square_apart(one, its) < (one[3] + its[3]) ** 2:
            unite(drawing, place, other, place + 1)


@inner(_nrt=False)
def unite(drawing: Drawing, place: int, other: int, count: int) -> None:
    """Make one body of those of two atoms, of `count`."""
    first, second = drawing.owner[place], drawing.owner[other]
    for k in range(count):
        if drawing.owner[k] == first or drawing.owner[k] == second:
            drawing.owner[k] = min(first, second)


@inner(_nrt=False)
def join_strip(drawing: Drawing, strip: int, first: int, count: int) -> None:
    """Make the atoms from `first` to `count` one body with those of their strip before."""
    for place in range(first, count):
        drawing.order[place], drawing.sums[1, place] = strip, 0.0  # no ring
        for i in range(PARAMETERS if place > first else 0):
            for j in range(PARAMETERS):
                drawing.covariance[place, i, j] = 0.0  # of all small balls, at the first
    for other in range(first):
        if drawing.order[other] == strip:
            unite(drawing, first, other, count)


@inner(_nrt=False)
def draw_ring(
    memory: FitMemory,
    post: PosteriorMemory,
    pairs: PairMemory,
    index: int,
    thickness: float,
    at_mean: bool,
    drawing: Drawing,
    first: int,
) -> int:
    """Draw a ring as small balls from a place on; the place after the last."""
    draw_atom(memory, post, pairs, index, thickness, at_mean, drawing, first)
    x, y, force = drawing.atoms[first, 0], drawing.atoms[first, 1], drawing.atoms[first, 2]
    radius = drawing.sums[1, first] = drawing.atoms[first, 3]
    shear_x, shear_y = drawing.atoms[first, 6], drawing.atoms[first, 7]
    number = min(max(int(np.ceil(2 * np.pi * radius / (SHARE * thickness))), FEWEST), MOST)
    number = min(number, len(drawing.atoms) - first)
    for pearl in range(number):
        place, turn = first + pearl, 2 * np.pi * pearl / number
        atom = drawing.atoms[place]
        atom[0], atom[1] = x + radius * np.cos(turn), y + radius * np.sin(turn)
        atom[2], atom[3], atom[4], atom[5] = force / number, RIM * thickness, 0.0, 0.0
        atom[6], atom[7] = shear_x / number, shear_y / number
        drawing.family[place], drawing.owner[place] = BALL, first
    return first + number


@inner(_nrt=False)
def square_apart(one: Floats, other: Floats) -> float:
    """Squared distance in m² of the segments of two atoms."""
    east, north = one[4] * np.cos(one[5]), one[4] * np.sin(one[5])
    its_east, its_north = other[4] * np.cos(other[5]), other[4] * np.sin(other[5])
    x, y = other[0] - one[0], other[1] - one[1]
    cross = east * its_north - north * its_east
    if cross != 0.0:
        along, its_along = (x * its_north - y * its_east) / cross, (x * north - y * east) / cross
        if abs(along) <= 1.0 and abs(its_along) <= 1.0:
            return 0.0
    nearest = np.inf
    for side in (-1.0, 1.0):  # else an end is nearest
        away = square_from(x + side * its_east, y + side * its_north, east, north)
        back = square_from(side * east - x, side * north - y, its_east, its_north)
        nearest = min(nearest, away, back)
    return nearest


@inner(_nrt=False)
def square_from(x: float, y: float, east: float, north: float) -> float:
    """Squared distance of a point from a segment to both sides of the origin."""
    square = east * east + north * north
    share = min(max((x * east + y * north) / square, -1.0), 1.0) if square > 0.0 else 0.0
    return float((x - share * east) ** 2 + (y - share * north) ** 2)


@inner(_nrt=False)
def is_inside(drawing: Drawing, count: int, body: int, x: float, y: float) -> bool:
    """Whether a place lies in an atom of a body."""
    for n in range(count):
        atom = drawing.atoms[n]
        if drawing.owner[n] != body:
            continue
        away_x, away_y = x - atom[0], y - atom[1]
        if atom[4] > 0.0:
            east, north = np.cos(atom[5]), np.sin(atom[5])
            along = min(max(away_x * east + away_y * north, -atom[4]), atom[4])
            away_x, away_y = away_x - along * east, away_y - along * north
        if away_x * away_x + away_y * away_y <= atom[3] * atom[3]:
            return True
    return False


@inner(_nrt=False)
def free_border(drawing: Drawing, count: int, body: int, n: int) -> float:
    """Share of an atom's border that lies in no other atom of its body."""
    atom, free = drawing.atoms[n], 0
    for k in range(AROUND):
        turn = 2.0 * np.pi * (k + 0.5) / AROUND
        along, across = atom[3] * OUTSIDE * np.cos(turn), atom[3] * OUTSIDE * np.sin(turn)
        along += atom[4] if along > 0.0 else -atom[4]
        east, north = np.cos(atom[5]), np.sin(atom[5])
        x, y = atom[0] + east * along - north * across, atom[1] + north * along + east * across
        free += not is_inside(drawing, count, body, x, y)
    return free / AROUND


@inner(_nrt=False)
def write_covariance(drawing: Drawing, count: int, body: int, row: Any) -> None:
    """Write the covariance of a body's place and force, and the deviation of its area.

    Atoms are independent; the small balls of a ring move as one.
    """
    total, ring, variance, out = row["normal_force"], drawing.sums[1, body], 0.0, row["covariance"]
    sheared, shear = row["shear_covariance"], row["shear"]
    for number in range(len(out)):
        out[number] = 0.0
    for axis in range(3):
        sheared[axis] = shear[axis] = 0.0
    for n in range(count):
        if drawing.owner[n] == body:
            shear[0], shear[1] = shear[0] + drawing.atoms[n, 6], shear[1] + drawing.atoms[n, 7]
    for n in range(body, body + 1 if ring > 0.0 else count):
        if drawing.owner[n] != body:
            continue
        atom, known = drawing.atoms[n], drawing.covariance[n]
        share, off_x, off_y = (
            atom[2] / total,
            (atom[0] - row["x"]) / total,
            (atom[1] - row["y"]) / total,
        )
        wider, longer = 2.0 * np.pi * atom[3] + 4.0 * atom[4], 4.0 * atom[3]  # m² per m
        if ring > 0.0:
            share, off_x, off_y, wider, longer = 1.0, 0.0, 0.0, row["area"] / ring, 0.0
        elif row["shape"] == OTHER:
            free = free_border(drawing, count, body, n)
            wider, longer = free * wider, free * longer
        force, x_force, y_force = known[2, 2], share * known[0, 2], share * known[1, 2]
        out[XX] += share * share * known[0, 0] + off_x * (off_x * force + 2.0 * x_force)
        out[YY] += share * share * known[1, 1] + off_y * (off_y * force + 2.0 * y_force)
        out[XY] += share * share * known[0, 1] + off_x * off_y * force
        out[XY] += off_x * y_force + off_y * x_force
        out[X_FORCE] += x_force + off_x * force
        out[Y_FORCE] += y_force + off_y * force
        out[FORCE_FORCE] += force
        sheared[0], sheared[1] = sheared[0] + known[6, 6], sheared[1] + known[6, 7]
        sheared[2] += known[7, 7]
        variance += wider * wider * known[3, 3] + longer * longer * known[4, 4]
        variance += 2.0 * wider * longer * known[3, 4]
    row["area_std"] = np.sqrt(max(variance, 0.0))
    state_deviations(row)


@inner
def describe_body(
    grid: RowGrid, drawing: Drawing, count: int, body: int, pressure: Floats, row: Any
) -> None:
    """Write the row of one body but for its track."""
    total, members = drawing.sums[0, body], 0
    low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
    x, y, area, peak = 0.0, 0.0, 0.0, 0.0
    for n in range(count):
        atom = drawing.atoms[n]
        if drawing.owner[n] != body:
            continue
        share = atom[2] / total
        x, y, members = x + share * atom[0], y + share * atom[1], members + 1
        wide = abs(atom[4] * np.cos(atom[5])) + atom[3]
        high = abs(atom[4] * np.sin(atom[5])) + atom[3]
        low_x, high_x = min(low_x, atom[0] - wide), max(high_x, atom[0] + wide)
        low_y, high_y = min(low_y, atom[1] - high), max(high_y, atom[1] + high)
        here = pressure_at(
            drawing.atoms[:count], drawing.family[:count], grid.surface, atom[0], atom[1]
        )
        here /= grid.spread
        area, peak = np.pi * atom[3] ** 2 + 4.0 * atom[3] * atom[4], max(peak, here)
    if members > 1:
        inside = 0
        for i in range(FINE):
            for j in range(FINE):
                u, v = (i + 0.5) / FINE, (j + 0.5) / FINE
                at_x, at_y = low_x + u * (high_x - low_x), low_y + v * (high_y - low_y)
                inside += is_inside(drawing, count, body, at_x, at_y)
        area = (high_x - low_x) * (high_y - low_y) * inside / FINE**2
    row["shape"], row["maybe"], row["radius"] = OTHER, 0, np.sqrt(area / np.pi)
    if members == 1:
        atom = drawing.atoms[body]
        row["maybe"] = drawing.maybe[body]
        row["shape"], row["radius"] = PLANE if drawing.family[body] == FLAT else SPHERE, atom[3]
        if atom[4] > LINE * atom[3]:
            row["shape"], row["radius"] = SEGMENT, np.sqrt(area / np.pi)
    row["area"], row["normal_force"], row["x"], row["y"] = area, total, x, y
    write_covariance(drawing, count, body, row)
    row["area"], row["area_std"] = row["area"] * grid.spread, row["area_std"] * grid.spread
    row["radius"] *= np.sqrt(grid.spread)
    spread(grid, drawing, count, body, pressure, (low_y, high_y), peak, row)
    if members > 1 and drawing.errors[2] > UNSURE:
        widen(drawing.errors[2], row)
    stand(grid, row)


@inner
def widen(error: float, row: Any) -> None:
    """Add to the covariance of a body of several atoms what all of them are wrong by together."""
    covariance, moments = row["covariance"], row["moments"]
    covariance[XX] += error * error * moments[0]
    covariance[YY] += error * error * moments[1]
    covariance[XY] += error * error * moments[2]
    covariance[FORCE_FORCE] += (HIDDEN[1] * error * row["normal_force"]) ** 2
    state_deviations(row)


@inner
def spread(
    grid: RowGrid,
    drawing: Drawing,
    count: int,
    body: int,
    pressure: Floats,
    heights: tuple[float, float],
    peak: float,
    row: Any,
) -> None:
    """Write the cells of a body, their peak, and the second moments of its pressure."""
    mesh, cells, moments, terms = grid.mesh, 0, row["moments"], np.empty(TERMS)
    low = max(int(np.ceil((heights[0] - mesh.y) / mesh.pitch)), 0)
    high = min(int(np.floor((heights[1] - mesh.y) / mesh.pitch)), mesh.rows - 1)
    for i in range(low, high + 1):
        for j in range(mesh.columns):
            x, y = mesh.x + j * mesh.pitch, mesh.y + i * mesh.pitch
            if not is_inside(drawing, count, body, x, y):
                continue
            cells, peak = cells + 1, max(peak, pressure[i * mesh.columns + j])
    moments[0], moments[1], moments[2] = 0.0, 0.0, 0.0
    for n in range(count):
        if drawing.owner[n] != body:
            continue
        atom, share = drawing.atoms[n], drawing.atoms[n, 2] / row["normal_force"]
        x, y = atom[0] - row["x"], atom[1] - row["y"]
        own = profile_spread(drawing.family[n], held(atom[3], grid.surface), grid.surface, terms)
        square = atom[4] * atom[4] / 3.0  # of even points on a segment
        east, north = np.cos(atom[5]), np.sin(atom[5])
        moments[0] += share * (own + square * east * east + x * x)
        moments[1] += share * (own + square * north * north + y * y)
        moments[2] += share * (square * east * north + x * y)
    row["cells"], row["peak_pressure"] = max(cells, 1), peak


@inner(_nrt=False)
def stand(grid: RowGrid, row: Any) -> None:
    """Write the place and the outward normal on the skin, between four nodes."""
    mesh = grid.mesh
    x, y = (row["x"] - mesh.x) / mesh.pitch, (row["y"] - mesh.y) / mesh.pitch
    put_on(row, x, y, grid.positions, grid.normals, mesh.columns)
    lay_along(row, x, y, grid.positions, mesh.columns)


@inner
def write_rows(
    grid: RowGrid,
    memory: FitMemory,
    post: PosteriorMemory,
    pairs: PairMemory,
    strips: Strips,
    at_mean: bool,
    drawing: Drawing,
    pressure: Floats,
    rows: Any,
) -> int:
    """Write the pressure (K,), Pa, and the contacts of NOW, by falling force; how many there are.

    Rows beyond their number keep what they had; where there are more contacts, the strongest count.
    """
    count = drawing.drawn[0] = draw(memory, post, pairs, strips, grid.thickness, at_mean, drawing)
    return write_bodies(grid, drawing, count, pressure, rows)


@inner
def write_bodies(grid: RowGrid, drawing: Drawing, count: int, pressure: Floats, rows: Any) -> int:
    """Write the pressure and the contacts of drawn atoms; see `write_rows`."""
    render(drawing.atoms[:count], drawing.family[:count], grid.surface, grid.mesh, pressure)
    pressure /= grid.spread
    found, forces, order = 0, drawing.sums[0], drawing.order
    for n in range(count):
        forces[n] = 0.0
    for n in range(count):
        forces[drawing.owner[n]] += drawing.atoms[n, 2]
    for n in range(count):
        if drawing.owner[n] != n:
            continue
        place = found
        while place > 0 and forces[order[place - 1]] < forces[n] * (1.0 - TIE):
            order[place] = order[place - 1]
            place -= 1
        order[place] = n
        found += 1
    for place in range(min(found, len(rows))):
        describe_body(grid, drawing, count, order[place], pressure, rows[place])
    return min(found, len(rows))
