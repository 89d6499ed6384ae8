"""Sums over the cells of regions and along their borders, compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints

# Columns of the table of regions
TOTAL, PEAK, ROUNDING, MAJOR, MINOR, ANGLE = range(6)
CENTRE = 6  # two of them, in the plane, m
FORCE = 8  # three, N
MOMENT = 11  # three, N m, about REFERENCE until `set_places`
REFERENCE = 14  # three, m
WIDTH = 17
# Variance, in cells, of the count in a disc at random per side of its border: 0.4576 R over 8 R
# (Kendall, On the number of lattice points inside a random oval, Quart. J. Math. 19, 1948).
SIDE_VARIANCE = 0.0572


@njit(cache=True, nogil=True)
def sum_regions(
    pressure: Floats,
    positions: Floats,
    normals: Floats,
    origin: Floats,
    pitch: float,
    columns: int,
    starts: Ints,
    cells: Ints,
) -> Floats:
    """Table (R, WIDTH) of what regions amount to; ROUNDING is left to `borders`."""
    table = np.zeros((len(starts) - 1, WIDTH))
    for region in range(len(table)):
        mine, row = cells[starts[region] : starts[region + 1]], table[region]
        x0, y0 = mine[0] % columns, mine[0] // columns
        for cell in mine:
            weight = pressure[cell] * pitch**2
            row[TOTAL] += weight
            row[CENTRE] += weight * (cell % columns - x0)
            row[CENTRE + 1] += weight * (cell // columns - y0)
            row[PEAK] = max(row[PEAK], pressure[cell])
        middle = x0 + row[CENTRE] / row[TOTAL], y0 + row[CENTRE + 1] / row[TOTAL]
        add_loads(pressure, positions, normals, pitch, mine, row)
        set_ellipse(pressure, pitch, columns, mine, middle, row)
        row[CENTRE] = origin[0] + middle[0] * pitch
        row[CENTRE + 1] = origin[1] + middle[1] * pitch
    return table


@njit(cache=True, nogil=True)
def add_loads(
    pressure: Floats, positions: Floats, normals: Floats, pitch: float, cells: Ints, row: Floats
) -> None:
    """Add up the cells' forces, and their moments about the first of them."""
    x0, y0, z0 = positions[cells[0], 0], positions[cells[0], 1], positions[cells[0], 2]
    row[REFERENCE], row[REFERENCE + 1], row[REFERENCE + 2] = x0, y0, z0
    for cell in cells:
        weight = -(pressure[cell] * pitch**2)
        fx, fy, fz = weight * normals[cell, 0], weight * normals[cell, 1], weight * normals[cell, 2]
        x, y, z = positions[cell, 0] - x0, positions[cell, 1] - y0, positions[cell, 2] - z0
        row[FORCE] += fx
        row[FORCE + 1] += fy
        row[FORCE + 2] += fz
        row[MOMENT] += y * fz - z * fy
        row[MOMENT + 1] += z * fx - x * fz
        row[MOMENT + 2] += x * fy - y * fx


@njit(cache=True, nogil=True)
def set_places(table: Floats, places: Floats, normals: Floats) -> Ints:
    """Make the moments those about `places` (R, 3); rows by falling force along `normals` (R, 3).

    A single normal is that of all rows.
    """
    order, forces = np.arange(len(table)), np.empty(len(table))
    for region in range(len(table)):
        row, place, normal = table[region], places[region], normals[min(region, len(normals) - 1)]
        x = row[REFERENCE] - place[0]
        y = row[REFERENCE + 1] - place[1]
        z = row[REFERENCE + 2] - place[2]
        fx, fy, fz = row[FORCE], row[FORCE + 1], row[FORCE + 2]
        row[MOMENT] += y * fz - z * fy
        row[MOMENT + 1] += z * fx - x * fz
        row[MOMENT + 2] += x * fy - y * fx
        force, index = -(fx * normal[0] + fy * normal[1] + fz * normal[2]), region
        while index > 0 and forces[index - 1] < force:
            forces[index], order[index] = forces[index - 1], order[index - 1]
            index -= 1
        forces[index], order[index] = force, region
    return order


@njit(cache=True, nogil=True)
def set_ellipse(
    pressure: Floats,
    pitch: float,
    columns: int,
    cells: Ints,
    middle: tuple[float, float],
    row: Floats,
) -> None:
    """Semi-axes and angle of the uniform ellipse with the region's second moments."""
    xx, xy, yy = 0.0, 0.0, 0.0
    for cell in cells:
        x, y = cell % columns - middle[0], cell // columns - middle[1]
        xx += pressure[cell] * x * x
        xy += pressure[cell] * x * y
        yy += pressure[cell] * y * y
    share = pitch**4 / row[TOTAL]
    xx, xy, yy = xx * share + pitch**2 / 12, xy * share, yy * share + pitch**2 / 12
    half = np.hypot((xx - yy) / 2, xy)
    large = (xx + yy) / 2 + half
    row[MAJOR] = 2.0 * np.sqrt(large)
    row[MINOR] = 2.0 * np.sqrt((xx * yy - xy * xy) / large)
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    row[ANGLE] = angle if angle < np.pi / 2 else angle - np.pi


@njit(cache=True, nogil=True)
def borders(
    pressure: Floats,
    columns: int,
    cell_area: float,
    edge: float,
    starts: Ints,
    cells: Ints,
    table: Floats,
) -> tuple[Ints, Ints, Floats]:
    """How the area of each region moves with the pressure of cells; see `area_moves`.

    Returns starts (R + 1,), cells and weights, the peak of each region last; sets ROUNDING.
    """
    most = 8 * len(cells) + len(table)
    around, weights = np.empty(most, np.int64), np.empty(most)
    ends = np.zeros(len(starts), np.int64)
    owner, moves = np.full(len(pressure), -1, np.int64), np.zeros(len(pressure))
    for region in range(len(table)):
        for cell in cells[starts[region] : starts[region + 1]]:
            owner[cell] = region
    end = 0
    for region in range(len(table)):
        mine = cells[starts[region] : starts[region + 1]]
        level = edge * table[region, PEAK]
        first, sides, total, peak = end, 0, 0.0, mine[0]
        for cell in mine:
            count, end = sides_of(
                pressure, columns, cell_area, owner, cell, level, moves, around, end
            )
            sides += count
            if pressure[cell] > pressure[peak]:
                peak = cell
        for index in range(first, end):
            weights[index] = moves[around[index]]
            total += weights[index]
            moves[around[index]] = 0.0
        around[end], weights[end] = peak, -edge * total
        end += 1
        ends[region + 1] = end
        table[region, ROUNDING] = cell_area * np.sqrt(SIDE_VARIANCE * sides)
    return ends, around[:end], weights[:end]


@njit(cache=True, nogil=True, inline="always")
def sides_of(
    pressure: Floats,
    columns: int,
    cell_area: float,
    owner: Ints,
    cell: int,
    level: float,
    moves: Floats,
    around: Ints,
    end: int,
) -> tuple[int, int]:
    """Sides of a cell that lie on its region's border; adds what crosses them to `moves`.

    `around` lists the cells of which `moves` is not 0, up to the end that is returned.
    """
    rows, sides = len(pressure) // columns, 0
    row, column = cell // columns, cell % columns
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        r, c = row + down, column + right
        if r < 0 or r >= rows or c < 0 or c >= columns:
            sides += 1
            continue
        beside = r * columns + c
        if owner[beside] == owner[cell]:
            continue
        sides += 1
        if not (pressure[beside] < level < pressure[cell]):
            continue
        across = pressure[cell] - pressure[beside]
        along = 0.0
        if down == 0 and rows > 1:
            along = slope_at(pressure, cell, columns, row, rows)
            along += slope_at(pressure, beside, columns, r, rows)
        elif down != 0 and columns > 1:
            along = slope_at(pressure, cell, 1, column, columns)
            along += slope_at(pressure, beside, 1, c, columns)
        along *= 0.5
        share = (pressure[cell] - level) / across  # of the way to the cell beside
        per_pascal = cell_area * across / (across * across + along * along)
        for at, part in ((cell, 1.0 - share), (beside, share)):
            if moves[at] == 0.0:
                around[end] = at
                end += 1
            moves[at] += per_pascal * part
    return sides, end


@njit(cache=True, nogil=True, inline="always")
def slope_at(pressure: Floats, cell: int, step: int, place: int, count: int) -> float:
    """Change of the pressure per cell along a line of `count`; one-sided at its ends."""
    before, after = place > 0, place < count - 1
    rise = pressure[cell + after * step] - pressure[cell - before * step]
    return float(rise / (1.0 + (before & after)))


@njit(cache=True, nogil=True)
def first_moments(
    cells: Ints, columns: int, pitch: float, origin: tuple[float, float], row: Floats
) -> NDArray[np.float64]:
    """Weights (3, N), per Pa, that make a region's x m, y m and normal force N of its cells."""
    weights = np.empty((3, len(cells)))
    for index, cell in enumerate(cells):
        x = origin[0] + (cell % columns) * pitch - row[CENTRE]
        y = origin[1] + (cell // columns) * pitch - row[CENTRE + 1]
        weights[0, index] = x / row[TOTAL] * pitch**2
        weights[1, index] = y / row[TOTAL] * pitch**2
        weights[2, index] = pitch**2
    return weights


@njit(cache=True, nogil=True)
def walk_around(cells: Ints, rows: int, columns: int) -> Ints:
    """Corners (column, row) of the way around a region, from the lower left one of a lowest cell.

    The region stays on the left. Where two cells touch at a corner only, the way turns right, into
    the other: such cells are neighbours.
    """
    inside = np.zeros((rows, columns), np.bool_)
    for cell in cells:
        inside[cell // columns, cell % columns] = True
    row, column = cells[0] // columns, cells[0] % columns
    way = np.empty((4 * len(cells) + 1, 2), np.int64)
    x, y, dx, dy = column, row, 1, 0
    way[0, 0], way[0, 1] = x, y
    length = 0
    while length == 0 or x != column or y != row:
        x, y, length = x + dx, y + dy, length + 1
        way[length, 0], way[length, 1] = x, y
        right_x, right_y = x + (dx + dy - 1) // 2, y + (dy - dx - 1) // 2
        left_x, left_y = x + (dx - dy - 1) // 2, y + (dy + dx - 1) // 2
        if 0 <= right_x < columns and 0 <= right_y < rows and inside[right_y, right_x]:
            dx, dy = dy, -dx
        elif not (0 <= left_x < columns and 0 <= left_y < rows and inside[left_y, left_x]):
            dx, dy = -dy, dx
    return way[: length + 1]
