"""Contacts as rows of numbers, compiled, without allocating anything."""

from typing import Any

from numba import njit

from skinfield.contacts.flood_kernel import (
    REGIONS,
    STARTS,
    Work,
    flood,
    highest_of,
    keep_high,
    reaches,
)
from skinfield.errors import Floats


@njit(cache=True, nogil=True)
def tabulate(
    pressure: Floats,
    std: Floats,
    columns: int,
    origin: Floats,
    pitch: float,
    heights: tuple[float, float, float, float],
    work: Work,
    out: Any,
) -> int:
    """Write the strongest contacts into `out`, by falling force; returns how many there are.

    `heights` are the finder's: sigmas, relative_height, prominence, edge.
    """
    sigmas, relative_height, prominence, edge = heights
    least = relative_height * highest_of(pressure)
    if not reaches(pressure, std, sigmas, least):
        return 0
    count = flood(pressure, std, columns, sigmas, prominence, edge * least, edge, work)
    count = keep_high(pressure, std, sigmas, least, count, work)
    starts, cells = work[2][STARTS], work[2][REGIONS]
    for region in range(count):
        total, x, y, peak = 0.0, 0.0, 0.0, 0.0
        for cell in cells[starts[region] : starts[region + 1]]:
            value, row = pressure[cell], cell // columns
            total += value
            x += value * (cell - row * columns)
            y += value * row
            peak = max(peak, value)
        force, place = total * pitch * pitch, min(region, len(out))
        while place > 0 and out[place - 1].normal_force < force:
            if place < len(out):
                out[place] = out[place - 1]
            place -= 1
        if place < len(out):
            out[place].x = origin[0] + x / total * pitch
            out[place].y = origin[1] + y / total * pitch
            out[place].normal_force = force
            out[place].area = (starts[region + 1] - starts[region]) * pitch * pitch
            out[place].peak_pressure = peak
            out[place].cells = starts[region + 1] - starts[region]
    return count
