"""Regions of a picture's peaks, compiled: it runs per reading, over every cell above the floor.

A region is the part `cells[starts[n]:starts[n + 1]]` of flat cells; regions come by falling peak.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints

Regions = tuple[NDArray[np.int64], NDArray[np.int64]]  # starts (R + 1,), cells
SHORT = 12  # cells up to which sorting by insertion is quicker than by merging


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
) -> Regions:
    """Regions of the peaks that stand out of the noise and beside the highest; see `flood`."""
    least = relative_height * highest_of(pressure)
    found = False
    for cell in range(len(pressure)):
        found |= pressure[cell] > sigmas * std[cell] and pressure[cell] > least
    if not found:
        return np.zeros(1, np.int64), np.empty(0, np.int64)
    starts, cells = flood(pressure, std, columns, sigmas, prominence, edge * least, edge)
    count, end = 0, 0
    for region in range(len(starts) - 1):
        first, last = starts[region], starts[region + 1]
        found = False
        for cell in cells[first:last]:
            found |= pressure[cell] > sigmas * std[cell] and pressure[cell] > least
        if found:
            for index in range(first, last):
                cells[end] = cells[index]
                end += 1
            count += 1
            starts[count] = end
    return starts[: count + 1], cells[:end]


@njit(cache=True, nogil=True)
def flood(
    pressure: Floats,
    std: Floats,
    columns: int,
    sigmas: float,
    prominence: float,
    floor: float,
    edge: float,
) -> Regions:
    """Split the cells above `floor` into the regions of their peaks.

    Water falls from the highest cell; each cell joins the hill of its highest neighbour (eight of
    them). Where two hills meet, the lower one stays its own only if its peak stands out of the
    saddle by `prominence` of itself and by `sigmas` of its noise; else it is a shoulder of the
    higher. A region ends at `edge` of its own peak.
    """
    above = cells_above(pressure, floor)
    order = above.copy()
    sort_falling(order, pressure, np.empty_like(order))
    parent = np.full(len(pressure), -1, np.int64)
    for cell in order:
        hill = meet(pressure, std, columns, sigmas, prominence, parent, cell)
        parent[cell] = cell if hill < 0 else hill
    peaks = number_peaks(order, parent)
    return gather(pressure, edge, above, peaks, parent)


@njit(cache=True, nogil=True)
def cells_above(pressure: Floats, floor: float) -> Ints:
    """Flat cells above the floor, rising."""
    count = 0
    for cell in range(len(pressure)):
        count += pressure[cell] > floor
    above = np.empty(count, np.int64)
    count = 0
    for cell in range(len(pressure)):
        if pressure[cell] > floor:
            above[count] = cell
            count += 1
    return above


@njit(cache=True, nogil=True)
def sort_falling(order: Ints, values: Floats, spare: Ints) -> None:
    """Sort cells by falling value; of equal ones, those that came first stay first."""
    count = len(order)
    for first in range(0, count, SHORT):
        for index in range(first + 1, min(first + SHORT, count)):
            cell, place = order[index], index
            while place > first and values[order[place - 1]] < values[cell]:
                order[place] = order[place - 1]
                place -= 1
            order[place] = cell
    width = SHORT
    while width < count:
        for first in range(0, count, 2 * width):
            middle, last = min(first + width, count), min(first + 2 * width, count)
            left, right = first, middle
            for place in range(first, last):
                if left < middle and (right >= last or values[order[left]] >= values[order[right]]):
                    spare[place] = order[left]
                    left += 1
                else:
                    spare[place] = order[right]
                    right += 1
        order[:] = spare
        width *= 2


@njit(cache=True, nogil=True)
def meet(
    pressure: Floats,
    std: Floats,
    columns: int,
    sigmas: float,
    prominence: float,
    parent: Ints,
    cell: int,
) -> int:
    """Peak of the highest hill around a cell, -1 if there is none; the lower may join it there.

    They join the hill that the cell belongs to, so that a region hangs together.
    """
    row, column, rows = cell // columns, cell % columns, len(pressure) // columns
    top, bottom = max(row - 1, 0), min(row + 2, rows)
    left, right = max(column - 1, 0), min(column + 2, columns)
    best, several = -1, False
    for r in range(top, bottom):
        for other in range(r * columns + left, r * columns + right):
            hill = peak_of(parent, other)
            several |= hill >= 0 and best >= 0 and hill != best
            if hill >= 0 and (best < 0 or pressure[hill] > pressure[best]):
                best = hill
    if several:
        for r in range(top, bottom):
            for other in range(r * columns + left, r * columns + right):
                lower = peak_of(parent, other)
                if lower >= 0 and lower != best:
                    drop = max(prominence * pressure[lower], sigmas * std[lower])
                    if pressure[lower] - pressure[cell] < drop:
                        parent[lower] = best
    return best


@njit(cache=True, nogil=True)
def peak_of(parent: Ints, cell: int) -> int:
    """Peak of the hill that a cell belongs to, -1 if it is dry."""
    if parent[cell] < 0:
        return -1
    while parent[cell] != cell:
        cell = parent[cell]
    return cell


@njit(cache=True, nogil=True)
def number_peaks(order: Ints, parent: Ints) -> Ints:
    """Peaks of all hills, the highest first; `parent` becomes the hill's number of each cell."""
    peaks, count = np.empty(len(order), np.int64), 0
    for cell in order:
        parent[cell] = peak_of(parent, cell)
    for cell in order:
        if parent[cell] == cell:
            peaks[count] = cell
            count += 1
    number = np.empty_like(parent)
    for hill in range(count):
        number[peaks[hill]] = hill
    for cell in order:
        parent[cell] = number[parent[cell]]
    return peaks[:count]


@njit(cache=True, nogil=True)
def gather(pressure: Floats, edge: float, above: Ints, peaks: Ints, hill_of: Ints) -> Regions:
    """Cells of each hill down to `edge` of its peak."""
    starts = np.zeros(len(peaks) + 1, np.int64)
    for cell in above:
        if not pressure[cell] >= edge * pressure[peaks[hill_of[cell]]]:
            hill_of[cell] = -1
        else:
            starts[hill_of[cell] + 1] += 1
    for hill in range(len(peaks)):
        starts[hill + 1] += starts[hill]
    cells, place = np.empty(starts[-1], np.int64), starts.copy()
    for cell in above:
        hill = hill_of[cell]
        if hill >= 0:
            cells[place[hill]] = cell
            place[hill] += 1
    return starts, cells
