"""Regions of a picture's peaks, compiled: they are found per reading, over all cells.

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
    heights: Floats,
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

    `heights` (4,) are `sigmas`, `relative_height`, `prominence` and `edge`. The regions are left in
    `STARTS` and `REGIONS` of the tables.
    """
    sigmas, relative_height, prominence, edge = heights[0], heights[1], heights[2], heights[3]
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
