"""Regions of a picture's peaks, compiled: it runs per reading, over every cell above the floor.

Cells are numbered by falling pressure while water falls; `wet` tells the number of each cell that
the water has left, -1 for the others, on a picture with a margin of one cell. A region is the part
`cells[starts[n]:starts[n + 1]]` of flat cells; regions come by falling peak. What is called for
each cell is written in place: a call with so many arrays takes longer than the work.
"""

import numpy as np
from numba import njit

from skinfield.errors import Floats, Ints

Work = tuple[Ints, Floats, Ints]  # see `room_for`
HILL, CELLS, SPARE, ABOVE, STARTS, REGIONS = range(6)  # rows of the second table of integers
SHORT = 12  # cells up to which sorting by insertion is quicker than by merging


@njit(cache=True, nogil=True)
def room_for(rows: int, columns: int) -> Work:
    """Where `find` works on pictures of a shape, again and again: it leaves `wet` dry.

    `wet`, then values and spare values, then tables of integers, each as long as there are cells.
    """
    wet = np.full((rows + 2) * (columns + 2), -1, np.int64)
    return wet, np.empty((2, rows * columns)), np.empty((6, rows * columns + 1), np.int64)


@njit(cache=True, nogil=True)
def stands_out(pressure: Floats, std: Floats, sigmas: float) -> bool:
    """Whether any cell is above `sigmas` of its noise; one pass, without a branch."""
    found = False
    for cell in range(len(pressure)):
        found |= pressure[cell] > sigmas * std[cell]
    return found


@njit(cache=True, nogil=True)
def highest_of(pressure: Floats) -> float:
    """Largest pressure; NaN if one is."""
    highest = float(pressure[0])
    for cell in range(len(pressure)):
        if not pressure[cell] <= highest:
            highest = float(pressure[cell])
            if highest != highest:
                return highest
    return highest


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def reaches(pressure: Floats, std: Floats, sigmas: float, least: float) -> bool:
    """Whether any cell is above its noise and above `least`."""
    found = False
    for cell in range(len(pressure)):
        found |= (pressure[cell] > sigmas * std[cell]) & (pressure[cell] > least)
    return found


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True, inline="always")
def place_of(cell: int, columns: int) -> int:
    """Where a cell stands on the picture with a margin."""
    return cell + columns + 3 + 2 * (cell // columns)


@njit(cache=True, nogil=True)
def gather(pressure: Floats, floor: float, above: Ints, cells: Ints, values: Floats) -> int:
    """List cells above the floor, rising, twice, and their pressure; how many there are."""
    count = 0
    for cell in range(len(pressure)):
        if pressure[cell] > floor:
            above[count], cells[count], values[count] = cell, cell, pressure[cell]
            count += 1
    return count


@njit(cache=True, nogil=True)
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
        values[:], cells[:] = spare_values[:count], spare[:count]
        width *= 2


@njit(cache=True, nogil=True, inline="always")
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


@njit(cache=True, nogil=True, inline="always")
def top_of(hill: Ints, number: int) -> int:
    """Peak of the hill that a wet cell belongs to."""
    while hill[number] != number:
        number = hill[number]
    return number


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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
