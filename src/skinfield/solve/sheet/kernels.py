"""Kernels of a sheet, compiled: stamps, conjugate gradients, and the Gram matrix of neighbours.

All kernels work on taxels in the sheet's own order, strip by strip, and on arrays that the caller
keeps. Each compiles for float32 and float64.
"""

from typing import Any

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.solve.sheet.response import GROUP, LANES
from skinfield.solve.tiles_kernel import data, load, place, repeat, size_of

Array = NDArray[Any]
Parts = tuple[Array, Array, Array, Array, int, int]  # see `plan.parts_of`
FAST = {"reassoc", "contract", "nsz"}  # sums in any order, but NaN stays NaN
SAME = 1e-6  # cells between two taxels at one place


def _add_block(
    typing_context: Any,
    out: Any,
    start: Any,
    columns: Any,
    across: Any,
    first: Any,
    width: Any,
    down: Any,
    begin: Any,
    rows: Any,
) -> Any:
    """Add to a block of `LANES` columns and some rows of a flat field, from its cell `start` on.

    Numba reads the profiles again in every row, as it cannot know that field and profiles do not
    overlap in memory: here they are loaded once, into registers.

    out[start + columns * row + cell] += sum over part of down[begin + GROUP * row + part] *
    across[first + width * part + cell]. Nothing is checked: the block must lie in the field.
    """
    whole = types.intp
    signature = types.void(out, whole, whole, across, whole, whole, down, whole, whole)

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        start, columns, first, width, begin, rows = (given[i] for i in (1, 2, 4, 5, 7, 8))
        arrays = [(signature.args[i], given[i]) for i in (0, 3, 6)]
        field, profiles, heights = data(context, builder, arrays)
        profile = []
        for _ in range(GROUP):
            profile.append(load(builder, profiles, first, LANES))
            first = builder.add(first, width)
        with cgutils.for_range(builder, rows) as loop:
            to = builder.add(start, builder.mul(loop.index, columns))
            total = load(builder, field, to, LANES)
            at = builder.add(begin, builder.mul(loop.index, cgutils.intp_t(GROUP)))
            for part in range(GROUP):
                index = builder.add(at, cgutils.intp_t(part))
                height = repeat(builder, builder.load(builder.gep(heights, [index])), LANES)
                product = builder.fmul(height, profile[part], flags=("contract",))
                total = builder.fadd(total, product, flags=("contract",))
            where = place(builder, field, to, LANES)
            builder.store(total, where, align=size_of(field))
        return context.get_dummy_value()

    return signature, generate


add_block: Any = intrinsic(_add_block)


@inner(fastmath=FAST, inline="always")
def profiles_at(table: Array, offset: float, out: Array) -> None:
    """Profiles of a taxel at `offset` of a cell, 0 to 1, flat; linear in between."""
    place = offset * (table.shape[0] - 1)
    step = min(int(place), table.shape[0] - 2)
    share = out.dtype.type(place - step)
    low, high = table[step], table[step + 1]
    for index in range(len(out)):
        out[index] = low[index] + share * (high[index] - low[index])


@inner(fastmath=FAST, inline="always")
def add_stamp(
    value: float,
    across: Array,
    down: Array,
    along_x: Array,
    along_y: Array,
    rows: int,
    width: int,
    offset: Array,
    taxel: int,
    corner: int,
    columns: int,
    out: Array,
) -> None:
    """Add a taxel's stamp times a value to a flat field, from its cell `corner` on.

    The stamp is handed over in parts, as a tuple of arrays costs more than the sum.
    """
    profiles_at(across, offset[taxel, 0], along_x)
    profiles_at(down, offset[taxel, 1], along_y)
    factor = out.dtype.type(value)
    for index in range(len(along_y)):
        along_y[index] *= factor
    for part in range(0, len(along_x) // width, GROUP):
        for cell in range(0, width, LANES):
            first = part * width + cell
            add_block(
                out, corner + cell, columns, along_x, first, width, along_y, part * rows, rows
            )


@njit(fastmath=FAST)
def add_stamps(
    values: Array, corner: Array, offset: Array, stamp: Parts, columns: int, out: Array
) -> None:
    """Set a flat field to the sum of all taxels' stamps, each times its value.

    `corner` (L,) is the index of a stamp's first cell, `offset` (L, 2) the taxel's in its cell.
    """
    out[:] = 0.0
    a, d, x, y, rows, width = stamp
    for taxel in range(len(values)):
        value, to = values[taxel], corner[taxel]
        if value != 0.0:
            add_stamp(value, a, d, x, y, rows, width, offset, taxel, to, columns, out)


@njit(fastmath=FAST)
def read_stamps(
    field: Array, corner: Array, offset: Array, stamp: Parts, columns: int, out: Array
) -> None:
    """Each taxel's stamp times a flat field, summed: the transpose of `add_stamps`."""
    across, down, along_x, along_y, rows, width = stamp
    for taxel in range(len(out)):
        profiles_at(across, offset[taxel, 0], along_x)
        profiles_at(down, offset[taxel, 1], along_y)
        total = 0.0
        for part in range(len(along_x) // width):
            profile = along_x[part * width : (part + 1) * width]
            first = part // GROUP * GROUP * rows + part % GROUP
            for row in range(rows):
                start = corner[taxel] + row * columns
                line = field[start : start + width]
                of_row = out.dtype.type(0.0)
                for cell in range(width):
                    of_row += profile[cell] * line[cell]
                total += along_y[first + GROUP * row] * of_row
        out[taxel] = total


@njit(fastmath=FAST)
def multiply(start: Array, other: Array, value: Array, vector: Array, out: Array) -> float:
    """Write M v over v in `out`, for symmetric M with a diagonal of ones; returns v . M v.

    What lies below the diagonal is stored by rows, in groups of `GROUP` entries: rows of nearly the
    same length, which a processor foresees. Half the matrix is less to read than all of it.
    """
    curved = 0.0
    for row in range(len(vector)):
        mine = vector[row]
        total = out.dtype.type(0.0)
        for first in range(start[row], start[row + 1], GROUP):
            for step in range(GROUP):
                beside, share = other[first + step], value[first + step]
                total += share * vector[beside]
                out[beside] += share * mine
        out[row] += total
        curved += mine * (mine + 2.0 * total)
    return curved


@njit(fastmath=FAST)
def descend(
    length: float, way: Array, moved: Array, valid: Array, answer: Array, residual: Array
) -> float:
    """Go `length` along `way`; returns the square of the norm of the residual there."""
    step = answer.dtype.type(length)
    square = 0.0
    for row in range(len(answer)):
        answer[row] += step * way[row]
        residual[row] -= step * valid[row] * moved[row]
        square += residual[row] * residual[row]
    return square


@njit(fastmath=FAST)
def turn(keep: float, residual: Array, way: Array, copy: Array) -> None:
    """The next way, the residual and `keep` of the way before, and a copy of it."""
    share = way.dtype.type(keep)
    for row in range(len(way)):
        way[row] = copy[row] = residual[row] + share * way[row]


@njit
def take_in(
    readings: Array, order: Array, scale: Array, target: Array, valid: Array, answer: Array
) -> float:
    """Readings in the sheet's order, scaled; 0 where one is NaN, and so is the answer there.

    Returns the square of the target's norm.
    """
    square = 0.0
    for row in range(len(target)):
        reading = readings[order[row]]
        good = reading == reading
        valid[row] = 1.0 if good else 0.0
        target[row] = reading * scale[row] if good else 0.0
        if not good:
            answer[row] = 0.0
        square += target[row] * target[row]
    return square


@njit
def earlier(
    place: Array, strip: Array, row: int, taxel: int, reach: float, first: Array, found: Array
) -> int:
    """Write the taxels before one of strip `row` that are within reach; returns their number.

    They are in that strip and in the len(first) - 1 before it; `first` holds where in each of
    these the search begins, which never goes back from one taxel of a strip to the next.
    """
    x, y = place[taxel]
    count = 0
    for back in range(min(len(first) - 1, row), -1, -1):
        end = taxel if back == 0 else strip[row - back + 1]
        at = strip[row - back] if taxel == strip[row] else first[back]
        while at < end and place[at, 0] < x - reach:
            at += 1
        first[back] = at
        for other in range(at, end):
            if place[other, 0] > x + reach:
                break
            if (place[other, 0] - x) ** 2 + (place[other, 1] - y) ** 2 <= reach * reach:
                found[count] = other
                count += 1
    return count


@njit
def search(place: Array, strip: Array, reach: float, back: int) -> tuple[Array, Array]:
    """Number of each taxel's earlier neighbours and distance to the nearest of all, both (L,).

    In its strip and `back` before; the distance is that to another place, at most `reach`.
    """
    count, nearest = np.empty(len(place), np.int64), np.full(len(place), reach)
    first, found = np.empty(back + 1, np.int64), np.empty(len(place), np.int64)
    for row in range(len(strip) - 1):
        for taxel in range(strip[row], strip[row + 1]):
            count[taxel] = earlier(place, strip, row, taxel, reach, first, found)
            for other in found[: count[taxel]]:
                x, y = place[taxel, 0] - place[other, 0], place[taxel, 1] - place[other, 1]
                apart = np.sqrt(x * x + y * y)
                if apart > SAME:
                    nearest[taxel] = min(nearest[taxel], apart)
                    nearest[other] = min(nearest[other], apart)
    return count, nearest


@njit(fastmath=FAST)
def overlap(one: Array, other: Array, columns: int, down: int, across: int) -> float:
    """Sum of products of two stamps, the other's corner `down` rows and `across` cells further.

    Both flat, rows of `columns` cells that end in so many zeros that no row meets another's next.
    """
    first, last = max(0, down), min(len(one), len(other) + down * columns) // columns
    begin = first * columns + max(0, across)
    end = max(begin, last * columns + min(0, across))
    mine, beside = one[begin:end], other[begin - down * columns - across :]
    total = one.dtype.type(0.0)
    for cell in range(len(mine)):
        total += mine[cell] * beside[cell]
    return float(total)


@njit(fastmath=FAST)
def fill_pairs(
    place: Array,
    offset: Array,
    strip: Array,
    reach: float,
    back: int,
    read: Parts,
    spread: Parts,
    room: int,
    start: Array,
    other_of: Array,
    value: Array,
    own: Array,
) -> None:
    """Write what each taxel reads of itself, (L,), and of its earlier neighbours.

    `read` and `spread` are what a taxel reads and the pressure that its reading makes; `room` is
    the number of taxels that `back` strips and one hold.
    """
    ra, rd, rx, ry, rrows, rwidth = read
    sa, sd, sx, sy, srows, swidth = spread
    shift = (srows - rrows) // 2  # of the corners of one taxel's stamps
    columns = swidth + shift + int(reach) + 1
    mine = np.empty(srows * columns, value.dtype)
    ring = np.empty((room, rrows * columns), value.dtype)  # the last stamps
    first, found = np.empty(back + 1, np.int64), np.empty(room, np.int64)
    for row in range(len(strip) - 1):
        for taxel in range(strip[row], strip[row + 1]):
            mine[:] = 0.0
            add_stamp(1.0, sa, sd, sx, sy, srows, swidth, offset, taxel, 0, columns, mine)
            here = ring[taxel % room]
            here[:] = 0.0
            add_stamp(1.0, ra, rd, rx, ry, rrows, rwidth, offset, taxel, 0, columns, here)
            own[taxel] = overlap(mine, here, columns, shift, shift)
            for index in range(earlier(place, strip, row, taxel, reach, first, found)):
                beside = found[index]
                down = int(place[beside, 1]) - int(place[taxel, 1]) + shift
                across = int(place[beside, 0]) - int(place[taxel, 0]) + shift
                entry = start[taxel] + index
                other_of[entry] = beside
                value[entry] = overlap(mine, ring[beside % room], columns, down, across)
