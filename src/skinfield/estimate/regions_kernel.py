"""Regions of a picture's peaks and sums over them, compiled: they run per reading, over all cells.

Cells are numbered by falling pressure while water falls; `wet` tells the number of each cell that
the water has left, -1 for the others, on a picture with a margin of one cell. A region is the part
`cells[starts[n]:starts[n + 1]]` of flat cells; regions come by falling peak. What is called for
each cell is written in place: a call with so many arrays takes longer than the work.
"""

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints

Work = tuple[Ints, Floats, Ints]  # see `room_for`
HILL, CELLS, SPARE, ABOVE, STARTS, REGIONS = range(6)  # rows of the second table of integers
SHORT = 12  # cells up to which sorting by insertion is quicker than by merging


def room_for(cells: int, columns: int) -> Work:
    """Where `find` works on pictures of a shape, again and again: it leaves `wet` dry.

    `wet`, then values and spare values, then tables of integers, each as long as there are cells.
    """
    wet = np.full((cells // columns + 2) * (columns + 2), -1, np.int64)
    return wet, np.empty((2, cells)), np.empty((6, cells + 1), np.int64)


@njit
def find(
    pressure: Floats,
    std: Floats,
    columns: int,
    sigmas: float,
    relative_height: float,
    prominence: float,
    edge: float,
    wet: Ints,
    values: Floats,
    tables: Ints,
) -> int:
    """Regions of the peaks that stand out of the noise and beside the highest; how many there are.

    Water falls from the highest cell; each cell joins the hill of its highest neighbour (eight of
    them). Where hills meet, a lower one stays its own only if its peak stands out of the saddle by
    `prominence` of itself and by `sigmas` of its noise; else it is a shoulder of the highest, which
    the saddle belongs to, so that a region hangs together. It ends at `edge` of its own peak, and
    counts if one of its cells is above `relative_height` of the highest and above its noise.

    They are left in `STARTS` and `REGIONS` of the tables.
    """
    highest, broken = pressure[0], False
    for value in pressure:
        highest, broken = max(highest, value), broken | (value != value)
    least = relative_height * highest
    if broken or not reaches(pressure, std, sigmas, least):
        return 0
    hill, cells, above, count = tables[HILL], tables[CELLS], tables[ABOVE], 0
    for cell in range(len(pressure)):
        if pressure[cell] > edge * least:
            above[count], cells[count], values[0, count] = cell, cell, pressure[cell]
            count += 1
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
    found = number_regions(values[0, :count], std, sigmas, least, edge, tables)
    next_place = tables[SPARE]
    for cell in above[:count]:
        place = place_of(cell, columns)
        peak = hill[wet[place]]
        if peak >= 0 and next_place[peak] >= 0:
            tables[REGIONS, next_place[peak]] = cell
            next_place[peak] += 1
        wet[place] = -1
    return found


@njit
def stands_out(pressure: Floats, std: Floats, sigmas: float) -> bool:
    """Whether any cell is above its noise; one pass, without a branch."""
    found = False
    for cell in range(len(pressure)):
        found |= pressure[cell] > sigmas * std[cell]
    return found


@inner
def reaches(pressure: Floats, std: Floats, sigmas: float, least: float) -> bool:
    """Whether any cell is above its noise and above `least`.

    The noise is only read where the pressure is that high: elsewhere it need not be at hand.
    """
    for cell in range(len(pressure)):
        if pressure[cell] > least and pressure[cell] > sigmas * std[cell]:
            return True
    return False


@inner(inline="always")
def place_of(cell: int, columns: int) -> int:
    """Where a cell stands on the picture with a margin."""
    return cell + columns + 3 + 2 * (cell // columns)


@inner
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
def number_regions(
    values: Floats, std: Floats, sigmas: float, least: float, edge: float, tables: Ints
) -> int:
    """Set where each region begins, in `STARTS` and for its peak in `SPARE`; how many there are.

    `SPARE` is -1 for peaks whose regions do not count, `HILL` for cells below the edge.
    """
    hill, cells, starts = tables[HILL], tables[CELLS], tables[STARTS]
    begin, sizes = tables[SPARE], tables[REGIONS]
    for number in range(len(values)):
        begin[number], sizes[number] = -1, 0
    for number in range(len(values)):
        peak, value = hill[number], values[number]
        if value >= edge * values[peak]:
            sizes[peak] += 1
            if value > least and value > sigmas * std[cells[number]]:
                begin[peak] = 0
        else:
            hill[number] = -1
    count, starts[0] = 0, 0
    for number in range(len(values)):
        if begin[number] == 0:
            begin[number] = starts[count]
            starts[count + 1] = starts[count] + sizes[number]
            count += 1
    return count


# Columns of the table of what regions amount to; after them the semi-axes, the angle and the peak
CENTRE, TOTAL, FORCE, MOMENT, AXES, ANGLE, PEAK, WIDTH = 0, 2, 3, 6, 9, 11, 12, 13
LOADS = 12  # sums over a region
SIDES = ((0, 1), (0, -1), (1, 0), (-1, 0))  # rows and columns from a cell to those beside it


@njit
def sum_regions(
    pressure: Floats, loads: Floats, cell_area: float, starts: Ints, cells: Ints
) -> Floats:
    """Table (R, WIDTH) of what regions amount to, moments about the origin; `loads` (K, LOADS)."""
    table, sums = np.zeros((len(starts) - 1, WIDTH)), np.empty(LOADS)
    for region in range(len(table)):
        row, sums[:] = table[region], 0.0
        for cell in cells[starts[region] : starts[region + 1]]:
            row[PEAK] = max(row[PEAK], pressure[cell])
            for column in range(LOADS):
                sums[column] += pressure[cell] * loads[cell, column]
        row[:AXES], total, own = sums[:AXES], sums[TOTAL], cell_area / 12
        x, y = sums[CENTRE] / total, sums[CENTRE + 1] / total
        row[CENTRE], row[CENTRE + 1] = x, y
        xx = sums[AXES] / total - x * x + own
        xy = sums[AXES + 1] / total - x * y
        yy = sums[AXES + 2] / total - y * y + own
        large = (xx + yy) / 2 + np.hypot((xx - yy) / 2, xy)
        row[AXES] = 2.0 * np.sqrt(large)
        row[AXES + 1] = 2.0 * np.sqrt((xx * yy - xy * xy) / large)
        angle = 0.5 * np.arctan2(2 * xy, xx - yy)
        row[ANGLE] = angle if angle < np.pi / 2 else angle - np.pi
    return table


@njit
def move_moments(table: Floats, places: Floats, normals: Floats) -> Floats:
    """Make moments those about `places` (R, 3); forces into the skin along `normals`, (R,) N.

    A single normal is that of all.
    """
    along = np.zeros(len(table))
    for region in range(len(table)):
        row, place, normal = table[region], places[region], normals[min(region, len(normals) - 1)]
        for axis in range(3):
            after, last = (axis + 1) % 3, (axis + 2) % 3
            row[MOMENT + axis] -= (
                place[after] * row[FORCE + last] - place[last] * row[FORCE + after]
            )
            along[region] -= row[FORCE + axis] * normal[axis]
    return along


@njit
def place_moves(
    loads: Floats, cell_area: float, cells: Ints, x: float, y: float, total: float
) -> Floats:
    """Weights (3, N), per Pa, that make a region's place x, y m and its force N of its cells."""
    moves = np.empty((3, len(cells)))
    for index in range(len(cells)):
        load = loads[cells[index]]
        moves[0, index] = (load[CENTRE] - cell_area * x) / total
        moves[1, index] = (load[CENTRE + 1] - cell_area * y) / total
        moves[2, index] = load[TOTAL]
    return moves


@njit
def area_moves(pressure: Floats, columns: int, edge: float, cells: Ints) -> tuple[Floats, int]:
    r"""How the area of a region moves with the pressure of cells, (K,) cells/Pa, to first order.

    The region ends where the pressure falls to `edge` of its peak, so by the implicit function
    theorem its border moves outwards by (dp - edge dp_peak) / \|grad p\|. The border is summed over
    the sides of cells at which it is crossed; each stands for a length pitch \|d_x p\| / \|grad p\|
    of it (pitch \|d_y p\| / \|grad p\| for a side along x). Also returns how many sides it has.
    """
    rows, peak, sides, total = len(pressure) // columns, cells[0], 0, 0.0
    inside, moves = np.zeros(len(pressure), np.bool_), np.zeros(len(pressure))
    for cell in cells:
        inside[cell] = True
        if pressure[cell] > pressure[peak]:
            peak = cell
    level = edge * pressure[peak]
    for cell in cells:
        row, column = cell // columns, cell % columns
        for down, right in SIDES:
            r, c = row + down, column + right
            on, beside = 0 <= r < rows and 0 <= c < columns, r * columns + c
            if on and inside[beside]:
                continue
            sides += 1
            if not (on and pressure[beside] < level < pressure[cell]):
                continue
            across = pressure[cell] - pressure[beside]
            if down == 0:
                along = slope_at(pressure, cell, columns, row, rows)
                along += slope_at(pressure, beside, columns, r, rows)
            else:
                along = slope_at(pressure, cell, 1, column, columns)
                along += slope_at(pressure, beside, 1, c, columns)
            share = (pressure[cell] - level) / across  # of the way to the cell beside
            per_pascal = across / (across * across + 0.25 * along * along)
            moves[cell] += per_pascal * (1.0 - share)
            moves[beside] += per_pascal * share
            total += per_pascal
    moves[peak] -= edge * total
    return moves, sides


@inner
def slope_at(pressure: Floats, cell: int, step: int, place: int, count: int) -> float:
    """Change of the pressure per cell along a line of `count`; one-sided at its ends."""
    before, after = place > 0, place < count - 1
    rise = pressure[cell + after * step] - pressure[cell - before * step]
    return float(rise / (1.0 + (before & after)))


@njit
def border(cells: Ints, rows: int, columns: int) -> Ints:
    """Corners (N, 2) of the way around a connected region, closed: columns and rows.

    It begins at the lower left one of the first cell of `cells`, which are sorted and connected by
    sides or corners; the region lies to its left, and holes are not walked around. Where two cells
    touch at a corner only, it turns right, into the other: such cells are neighbours.
    """
    inside = np.zeros((rows + 2, columns + 2), np.bool_)
    for cell in cells:
        inside[cell // columns + 1, cell % columns + 1] = True
    way, count = np.empty((4 * len(cells) + 1, 2), np.int64), 1
    x, y, dx, dy = cells[0] % columns, cells[0] // columns, 1, 0
    way[0, 0], way[0, 1] = x, y
    while count == 1 or x != way[0, 0] or y != way[0, 1]:
        x, y = x + dx, y + dy
        way[count, 0], way[count, 1] = x, y
        count += 1
        if inside[y + (dy - dx + 1) // 2, x + (dx + dy + 1) // 2]:  # on the right
            dx, dy = dy, -dx
        elif not inside[y + (dy + dx + 1) // 2, x + (dx - dy + 1) // 2]:
            dx, dy = -dy, dx
    return way[:count]
