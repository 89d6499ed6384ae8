"""What a sheet does per reading and per taxel, compiled.

All kernels work on taxels in the sheet's own order, strip by strip, and on arrays that the caller
keeps. Each compiles for float32 and float64.
"""

from typing import Any

from numba import njit
from numpy.typing import NDArray

from skinfield.inverse.sheet.lanes import add_block
from skinfield.inverse.sheet.stamps import GROUP, LANES

Array = NDArray[Any]
Parts = tuple[Array, Array, Array, Array, int, int]  # see `gram.parts_of`
FAST = {"reassoc", "contract", "nsz"}  # sums in any order, but NaN stays NaN


@njit(cache=True, nogil=True, fastmath=FAST, inline="always")
def profiles_at(table: Array, offset: float, out: Array) -> None:
    """Profiles of a taxel at `offset` of a cell, 0 to 1, flat; linear in between."""
    place = offset * (table.shape[0] - 1)
    step = min(int(place), table.shape[0] - 2)
    share = out.dtype.type(place - step)
    low, high = table[step], table[step + 1]
    for index in range(len(out)):
        out[index] = low[index] + share * (high[index] - low[index])


@njit(cache=True, nogil=True, fastmath=FAST, inline="always")
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


@njit(cache=True, nogil=True, fastmath=FAST)
def add_stamps(
    values: Array,
    corner: Array,
    offset: Array,
    stamp: Parts,
    columns: int,
    out: Array,
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


@njit(cache=True, nogil=True, fastmath=FAST)
def read_stamps(
    field: Array,
    corner: Array,
    offset: Array,
    stamp: Parts,
    columns: int,
    out: Array,
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


@njit(cache=True, nogil=True, fastmath=FAST)
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


@njit(cache=True, nogil=True, fastmath=FAST)
def residual_of(target: Array, moved: Array, valid: Array, out: Array) -> float:
    """Write target - moved where valid, else 0; returns the square of its norm."""
    square = 0.0
    for row in range(len(out)):
        out[row] = valid[row] * (target[row] - moved[row])
        square += out[row] * out[row]
    return square


@njit(cache=True, nogil=True, fastmath=FAST)
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


@njit(cache=True, nogil=True, fastmath=FAST)
def turn(keep: float, residual: Array, way: Array, copy: Array) -> None:
    """The next way, the residual and `keep` of the way before, and a copy of it."""
    share = way.dtype.type(keep)
    for row in range(len(way)):
        way[row] = copy[row] = residual[row] + share * way[row]


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def give_out(answer: Array, gain: Array, out: Array) -> None:
    """Values of the taxels' stamps."""
    for row in range(len(out)):
        out[row] = answer[row] * gain[row]
