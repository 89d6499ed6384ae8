"""Regions of a picture's peaks and sums over them, compiled: they run per reading, over every cell.

Cells are numbered by falling pressure while water falls; `wet` tells the number of each cell that
the water has left, -1 for the others, on a picture with a margin of one cell. A region is the part
`cells[starts[n]:starts[n + 1]]` of flat cells; regions come by falling peak. What is called for
each cell is written in place: a call with so many arrays takes longer than the work.
"""

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints

Work = tuple[Ints, Floats, Ints]  # see `room_for`
HILL, CELLS, SPARE, ABOVE, STARTS, REGIONS = range(6)  # rows of the second table of integers
TIE = 1e-9  # as in `skinfield.estimate.ranking`: forces that differ by this part are equal
SHORT = 12  # cells up to which sorting by insertion is quicker than by merging


@njit
def room_for(rows: int, columns: int) -> Work:
    """Where `find` works on pictures of a shape, again and again: it leaves `wet` dry.

    `wet`, then values and spare values, then tables of integers, each as long as there are cells.
    """
    wet = np.full((rows + 2) * (columns + 2), -1, np.int64)
    return wet, np.empty((2, rows * columns)), np.empty((6, rows * columns + 1), np.int64)


@inner
def comes_first(force: float, cell: int, other_force: float, other_cell: int) -> bool:
    """Whether a region is listed before another: by falling force, then by rising first cell."""
    if abs(force - other_force) <= TIE * abs(other_force):
        return cell < other_cell
    return force > other_force


@njit
def stands_out(pressure: Floats, std: Floats, sigmas: float) -> bool:
    """Whether any cell is above `sigmas` of its noise; one pass, without a branch."""
    found = False
    for cell in range(len(pressure)):
        found |= pressure[cell] > sigmas * std[cell]
    return found


@inner
def highest_of(pressure: Floats) -> float:
    """Largest pressure; NaN if one is."""
    highest = float(pressure[0])
    for cell in range(len(pressure)):
        if not pressure[cell] <= highest:
            highest = float(pressure[cell])
            if highest != highest:
                return highest
    return highest


@njit
def find(
    pressure: Floats,
    std: Floats,
    columns: int,
    sigmas: float,
    relative_height: float,
    prominence: float,
    edge: float,
) -> tuple[Ints, Ints]:
    """Regions of the peaks that stand out of the noise and beside the highest: starts, cells."""
    least = relative_height * highest_of(pressure)
    if not reaches(pressure, std, sigmas, least):
        return np.zeros(1, np.int64), np.empty(0, np.int64)
    work = room_for(len(pressure) // columns, columns)
    count = flood(pressure, std, columns, sigmas, prominence, edge * least, edge, work)
    count = keep_high(pressure, std, sigmas, least, count, work)
    starts, cells = work[2][STARTS], work[2][REGIONS]
    return starts[: count + 1].copy(), cells[: starts[count]].copy()


@inner
def reaches(pressure: Floats, std: Floats, sigmas: float, least: float) -> bool:
    """Whether any cell is above its noise and above `least`."""
    found = False
    for cell in range(len(pressure)):
        found |= (pressure[cell] > sigmas * std[cell]) & (pressure[cell] > least)
    return found


@inner
def keep_high(
    pressure: Floats, std: Floats, sigmas: float, least: float, count: int, work: Work
) -> int:
    """Drop the regions of which no cell is above its noise and above `least`; how many stay."""
    starts, cells = work[2][STARTS], work[2][REGIONS]
    kept, end = 0, 0
    for region in range(count):
        first, last = starts[region], starts[region + 1]
        found = False
        for cell in cells[first:last]:
            found |= (pressure[cell] > sigmas * std[cell]) & (pressure[cell] > least)
        if found:
            for index in range(first, last):
                cells[end] = cells[index]
                end += 1
            kept += 1
            starts[kept] = end
    return kept


@njit
def flood(
    pressure: Floats,
    std: Floats,
    columns: int,
    sigmas: float,
    prominence: float,
    floor: float,
    edge: float,
    work: Work,
) -> int:
    """Split the cells above `floor` into the regions of their peaks; how many there are.

    Water falls from the highest cell; each cell joins the hill of its highest neighbour (eight of
    them). Where hills meet, a lower one stays its own only if its peak stands out of the saddle by
    `prominence` of itself and by `sigmas` of its noise; else it is a shoulder of the highest, which
    the saddle belongs to, so that a region hangs together. It ends at `edge` of its own peak.
    """
    wet, values, tables = work
    hill, cells = tables[HILL], tables[CELLS]
    count = gather(pressure, floor, tables[ABOVE], cells, values[0])
    sort_falling(values[0, :count], cells[:count], values[1], tables[SPARE])
    for number in range(count):
        place = place_of(cells[number], columns)
        best = meet(
            values[0], std, cells, sigmas, prominence, columns + 2, wet, hill, place, number
        )
        hill[number] = number if best < 0 else best
        wet[place] = number
    for number in range(count):
        hill[number] = top_of(hill, number)
    hills = number_hills(hill, tables[SPARE], count)
    divide(pressure, edge, columns, count, hills, work)
    for number in range(count):
        wet[place_of(cells[number], columns)] = -1
    return hills


@inner(inline="always")
def place_of(cell: int, columns: int) -> int:
    """Where a cell stands on the picture with a margin."""
    return cell + columns + 3 + 2 * (cell // columns)


@inner
def gather(pressure: Floats, floor: float, above: Ints, cells: Ints, values: Floats) -> int:
    """List cells above the floor, rising, twice, and their pressure; how many there are."""
    count = 0
    for cell in range(len(pressure)):
        if pressure[cell] > floor:
            above[count], cells[count], values[count] = cell, cell, pressure[cell]
            count += 1
    return count


@njit
def sort_falling(values: Floats, cells: Ints, spare_values: Floats, spare: Ints) -> None:
    """Sort cells by falling value; of equal ones, those that came first stay first."""
    count = len(cells)
    for first in range(0, count, SHORT):
        for index in range(first + 1, min(first + SHORT, count)):
            value, cell, place = values[index], cells[index], index
            while place > first and values[place - 1] < value:
                values[place], cells[place] = values[place - 1], cells[place - 1]
                place -= 1
            values[place], cells[place] = value, cell
    width = SHORT
    while width < count:
        for first in range(0, count, 2 * width):
            middle, last = min(first + width, count), min(first + 2 * width, count)
            left, right = first, middle
            for place in range(first, last):
                if left < middle and (right >= last or values[left] >= values[right]):
                    spare_values[place], spare[place] = values[left], cells[left]
                    left += 1
                else:
                    spare_values[place], spare[place] = values[right], cells[right]
                    right += 1
        for place in range(count):
            values[place], cells[place] = spare_values[place], spare[place]
        width *= 2


@inner(inline="always")
def meet(
    values: Floats,
    std: Floats,
    cells: Ints,
    sigmas: float,
    prominence: float,
    stride: int,
    wet: Ints,
    hill: Ints,
    place: int,
    number: int,
) -> int:
    """Number of the highest peak around a cell, -1 if there is none; lower hills may join it."""
    best, several = -1, False
    for down in range(-stride, stride + 1, stride):
        for other in range(place + down - 1, place + down + 2):
            if wet[other] >= 0:
                peak = top_of(hill, wet[other])
                several |= best >= 0 and peak != best
                if best < 0 or values[peak] > values[best]:
                    best = peak
    if several:
        for down in range(-stride, stride + 1, stride):
            for other in range(place + down - 1, place + down + 2):
                if wet[other] >= 0:
                    lower = top_of(hill, wet[other])
                    drop = max(prominence * values[lower], sigmas * std[cells[lower]])
                    if lower != best and values[lower] - values[number] < drop:
                        hill[lower] = best
    return best


@inner(inline="always")
def top_of(hill: Ints, number: int) -> int:
    """Peak of the hill that a wet cell belongs to."""
    while hill[number] != number:
        number = hill[number]
    return number


@inner
def number_hills(hill: Ints, index_of: Ints, count: int) -> int:
    """Replace peaks by their index, the highest first; how many there are."""
    hills = 0
    for number in range(count):
        if hill[number] == number:
            index_of[number] = hills
            hills += 1
    for number in range(count):
        hill[number] = index_of[hill[number]]
    return hills


@inner
def divide(pressure: Floats, edge: float, columns: int, count: int, hills: int, work: Work) -> None:
    """List the cells of each hill, rising, down to `edge` of its peak."""
    wet, values, tables = work
    hill, starts, peak_of = tables[HILL], tables[STARTS], tables[SPARE]
    starts[: hills + 1] = 0
    peak_of[:hills] = -1
    for number in range(count):
        mine = hill[number]
        if peak_of[mine] < 0:
            peak_of[mine] = number
        if values[0, number] >= edge * values[0, peak_of[mine]]:
            starts[mine + 1] += 1
        else:
            hill[number] = -1
    for index in range(hills):
        starts[index + 1] += starts[index]
        peak_of[index] = starts[index]  # from here on, where its next cell is listed
    for cell in tables[ABOVE][:count]:
        mine = hill[wet[place_of(cell, columns)]]
        if mine >= 0:
            tables[REGIONS][peak_of[mine]] = cell
            peak_of[mine] += 1


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


@njit
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


@inner
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


@njit
def set_places(table: Floats, places: Floats, normals: Floats, firsts: Ints) -> Ints:
    """Make the moments those about `places` (R, 3); rows by falling force along `normals` (R, 3).

    A single normal is that of all rows. Of equal forces, the one with the smaller of `firsts` (R,)
    comes first.
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
        while index > 0 and comes_first(
            force, firsts[region], forces[index - 1], firsts[order[index - 1]]
        ):
            forces[index], order[index] = forces[index - 1], order[index - 1]
            index -= 1
        forces[index], order[index] = force, region
    return order


@inner
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


@njit
def borders(
    pressure: Floats,
    columns: int,
    cell_area: float,
    edge: float,
    starts: Ints,
    cells: Ints,
    table: Floats,
) -> tuple[Ints, Ints, Floats]:
    r"""How the area of each region moves with the pressure of cells, m²/Pa, to first order.

    The region ends where the pressure falls to `edge` of its peak, so by the implicit function
    theorem its border moves outwards by (dp - edge dp_peak) / \|grad p\|. The border is summed over
    the sides of cells at which it is crossed; each stands for a length pitch \|d_x p\| / \|grad p\|
    of it (pitch \|d_y p\| / \|grad p\| for a side along x).

    Returns starts (R + 1,), cells and weights, the peak of each region last, which may be one of
    the others too; sets ROUNDING, one standard deviation of an area counted in whole cells.
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


@inner(inline="always")
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


@inner(inline="always")
def slope_at(pressure: Floats, cell: int, step: int, place: int, count: int) -> float:
    """Change of the pressure per cell along a line of `count`; one-sided at its ends."""
    before, after = place > 0, place < count - 1
    rise = pressure[cell + after * step] - pressure[cell - before * step]
    return float(rise / (1.0 + (before & after)))


@njit
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


@njit
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
