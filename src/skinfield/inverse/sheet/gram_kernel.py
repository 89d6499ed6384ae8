"""Neighbours of taxels and what each reads of the other's pressure, compiled."""

import numpy as np
from numba import njit

from skinfield.inverse.sheet.kernels import FAST, Array, Parts, add_stamp


@njit(cache=True, nogil=True)
def nearest(place: Array, strip: Array, height: float, out: Array) -> None:
    """Distance from each taxel (L, 2) to the nearest other place, but no more than `height`.

    Taxels are ordered by strips of that height, within a strip by x; strip n holds the taxels
    strip[n] .. strip[n + 1].
    """
    out[:] = height
    for row in range(len(strip) - 1):
        for beside in range(max(row - 1, 0), row + 1):
            first = strip[beside]
            for taxel in range(strip[row], strip[row + 1]):
                x, y = place[taxel]
                end = min(taxel, strip[beside + 1])
                while first < end and place[first, 0] < x - height:
                    first += 1
                for other in range(first, end):
                    if place[other, 0] > x + height:
                        break
                    apart = np.hypot(place[other, 0] - x, place[other, 1] - y)
                    if apart > 0.0:
                        out[taxel] = min(out[taxel], apart)
                        out[other] = min(out[other], apart)


@njit(cache=True, nogil=True)
def earlier(
    place: Array, strip: Array, row: int, taxel: int, reach: float, first: Array, found: Array
) -> int:
    """Write the taxels before one of strip `row` that are within reach; returns their number.

    They are in that strip and in the len(first) - 1 before it; `first` holds where in each of
    these the search begins, which never goes back from one taxel of a strip to the next. Those
    that do not fit into `found` are counted only.
    """
    x, y = place[taxel]
    count = 0
    for back in range(min(len(first) - 1, row), -1, -1):
        end = taxel if back == 0 else strip[row - back + 1]
        at = first[back]
        while at < end and place[at, 0] < x - reach:
            at += 1
        first[back] = at
        for other in range(at, end):
            if place[other, 0] > x + reach:
                break
            if (place[other, 0] - x) ** 2 + (place[other, 1] - y) ** 2 <= reach * reach:
                if count < len(found):
                    found[count] = other
                count += 1
    return count


@njit(cache=True, nogil=True)
def count_pairs(place: Array, strip: Array, reach: float, back: int, count: Array) -> None:
    """Write how many earlier neighbours each taxel has, (L,), in its strip and `back` before."""
    first, none = np.empty(back + 1, np.int64), np.empty(0, np.int64)
    for row in range(len(strip) - 1):
        for step in range(min(back, row) + 1):
            first[step] = strip[row - step]
        for taxel in range(strip[row], strip[row + 1]):
            count[taxel] = earlier(place, strip, row, taxel, reach, first, none)


@njit(cache=True, nogil=True, fastmath=FAST)
def overlap(one: Array, other: Array, down: int, across: int) -> float:
    """Sum of products of two stamps, the other's corner `down` rows and `across` cells further."""
    first, last = max(0, across), min(one.shape[1], other.shape[1] + across)
    total = one.dtype.type(0.0)
    for row in range(max(0, down), min(one.shape[0], other.shape[0] + down)):
        mine, beside = one[row, first:last], other[row - down, first - across :]
        for cell in range(len(mine)):
            total += mine[cell] * beside[cell]
    return float(total)


@njit(cache=True, nogil=True, fastmath=FAST)
def fill_pairs(
    place: Array,
    cell: Array,
    offset: Array,
    strip: Array,
    reach: float,
    read: Parts,
    spread: Parts,
    first: Array,
    found: Array,
    ring: Array,
    start: Array,
    other_of: Array,
    value: Array,
    own: Array,
) -> None:
    """Write what each taxel reads of itself, (L,), and of its earlier neighbours.

    `read` and `spread` are what a taxel reads and the pressure that its reading makes; `first` and
    `found` are room for `earlier`, and `ring` (N, rows, width) for the last stamps, as many as all
    strips of a search hold.
    """
    ra, rd, rx, ry, rrows, rwidth = read
    sa, sd, sx, sy, srows, swidth = spread
    mine = np.empty((srows, swidth), ring.dtype)
    shift = (srows - rrows) // 2  # of the corners of one taxel's stamps
    for row in range(len(strip) - 1):
        for step in range(min(len(first) - 1, row) + 1):
            first[step] = strip[row - step]
        for taxel in range(strip[row], strip[row + 1]):
            mine[:] = 0.0
            add_stamp(1.0, sa, sd, sx, sy, srows, swidth, offset, taxel, 0, swidth, mine.ravel())
            here = ring[taxel % len(ring)]
            here[:] = 0.0
            add_stamp(1.0, ra, rd, rx, ry, rrows, rwidth, offset, taxel, 0, rwidth, here.ravel())
            own[taxel] = overlap(mine, here, shift, shift)
            count = earlier(place, strip, row, taxel, reach, first, found)
            for index in range(count):
                beside = found[index]
                down = cell[beside, 1] - cell[taxel, 1] + shift
                across = cell[beside, 0] - cell[taxel, 0] + shift
                entry = start[taxel] + index
                other_of[entry] = beside
                value[entry] = overlap(mine, ring[beside % len(ring)], down, across)


@njit(cache=True, nogil=True)
def scale_pairs(start: Array, other_of: Array, scale: Array, value: Array) -> None:
    """Multiply each pair's value by both taxels' scales."""
    for taxel in range(len(scale)):
        for entry in range(start[taxel], start[taxel + 1]):
            value[entry] *= scale[taxel] * scale[other_of[entry]]
