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
def count_pairs(place: Array, strip: Array, reach: float, start: Array) -> None:
    """Write where each taxel's earlier neighbours begin, (L + 1,); strips are `reach` high."""
    start[0] = 0
    for row in range(len(strip) - 1):
        first = strip[max(row - 1, 0)]
        own = strip[row]
        for taxel in range(strip[row], strip[row + 1]):
            x, y = place[taxel]
            while first < strip[row] and place[first, 0] < x - reach:
                first += 1
            while own < taxel and place[own, 0] < x - reach:
                own += 1
            count = 0
            for other in range(first, strip[row]):
                if place[other, 0] > x + reach:
                    break
                apart = (place[other, 0] - x) ** 2 + (place[other, 1] - y) ** 2
                count += apart <= reach * reach
            for other in range(own, taxel):
                apart = (place[other, 0] - x) ** 2 + (place[other, 1] - y) ** 2
                count += apart <= reach * reach
            start[taxel + 1] = start[taxel] + count


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
    ring: Array,
    start: Array,
    other_of: Array,
    value: Array,
    own: Array,
) -> None:
    """Write what each taxel reads of itself, (L,), and of its earlier neighbours.

    `read` and `spread` are what a taxel reads and the pressure that its reading makes, `ring` the
    stamps of two strips, (2, most taxels, rows, width).
    """
    ra, rd, rx, ry, rrows, rwidth = read
    sa, sd, sx, sy, srows, swidth = spread
    mine = np.empty((srows, swidth), ring.dtype)
    shift = (srows - rrows) // 2  # of the corners of one taxel's stamps
    for row in range(len(strip) - 1):
        before = strip[max(row - 1, 0)]
        near = strip[row]
        here, above = ring[row % 2], ring[(row + 1) % 2]
        for taxel in range(strip[row], strip[row + 1]):
            mine[:] = 0.0
            add_stamp(1.0, sa, sd, sx, sy, srows, swidth, offset, taxel, 0, swidth, mine.ravel())
            here[taxel - strip[row]] = 0.0
            to = here[taxel - strip[row]].ravel()
            add_stamp(1.0, ra, rd, rx, ry, rrows, rwidth, offset, taxel, 0, rwidth, to)
            own[taxel] = overlap(mine, here[taxel - strip[row]], shift, shift)
            x, y = place[taxel]
            while before < strip[row] and place[before, 0] < x - reach:
                before += 1
            while near < taxel and place[near, 0] < x - reach:
                near += 1
            entry = start[taxel]
            for beside in range(before, strip[row]):
                if place[beside, 0] > x + reach:
                    break
                apart = (place[beside, 0] - x) ** 2 + (place[beside, 1] - y) ** 2
                if apart <= reach * reach:
                    down = cell[beside, 1] - cell[taxel, 1] + shift
                    across = cell[beside, 0] - cell[taxel, 0] + shift
                    stamp = above[beside - strip[row - 1]]
                    other_of[entry] = beside
                    value[entry] = overlap(mine, stamp, down, across)
                    entry += 1
            for beside in range(near, taxel):
                apart = (place[beside, 0] - x) ** 2 + (place[beside, 1] - y) ** 2
                if apart <= reach * reach:
                    down = cell[beside, 1] - cell[taxel, 1] + shift
                    across = cell[beside, 0] - cell[taxel, 0] + shift
                    other_of[entry] = beside
                    value[entry] = overlap(mine, here[beside - strip[row]], down, across)
                    entry += 1


@njit(cache=True, nogil=True)
def scale_pairs(start: Array, other_of: Array, scale: Array, value: Array) -> None:
    """Multiply each pair's value by both taxels' scales."""
    for taxel in range(len(scale)):
        for entry in range(start[taxel], start[taxel + 1]):
            value[entry] *= scale[taxel] * scale[other_of[entry]]
