"""What a sheet does per reading and per taxel, compiled.

All kernels work on taxels in the sheet's own order, strip by strip, and on arrays that the caller
keeps. Each compiles for float32 and float64.
"""

from typing import Any

from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]
FAST = {"reassoc", "contract", "nsz"}  # sums in any order, but NaN stays NaN


@njit(cache=True, nogil=True, fastmath=FAST)
def profiles_at(table: Array, offset: float, out: Array) -> None:
    """Profiles (rank, width) of a taxel at `offset` of a cell, 0 to 1; linear in between."""
    place = offset * (table.shape[0] - 1)
    step = min(int(place), table.shape[0] - 2)
    share = out.dtype.type(place - step)
    below, above = table[step], table[step + 1]
    for part in range(table.shape[1]):
        low, high, line = below[part], above[part], out[part]
        for cell in range(len(line)):
            line[cell] = low[cell] + share * (high[cell] - low[cell])


@njit(cache=True, nogil=True, fastmath=FAST)
def add_stamps(
    values: Array,
    corner: Array,
    offset: Array,
    table: Array,
    sign: Array,
    work: Array,
    columns: int,
    out: Array,
) -> None:
    """Set a field, flat, to the sum of all taxels' stamps, each times its value.

    A stamp is the sum over parts of sign * (profile along y) * (profile along x); their number is a
    multiple of 4. `corner` (L,) is the flat index of a stamp's first cell, `offset` (L, 2) the
    taxel's place in its cell, `work` (2, parts, width).
    """
    out[:] = 0.0
    across, down = work[0], work[1]
    width = table.shape[2]
    for taxel in range(len(values)):
        value = values[taxel]
        if value == 0.0:
            continue
        profiles_at(table, offset[taxel, 0], across)
        profiles_at(table, offset[taxel, 1], down)
        for part in range(0, table.shape[1], 4):
            first, second = sign[part] * value, sign[part + 1] * value
            third, fourth = sign[part + 2] * value, sign[part + 3] * value
            one, two, three, four = (
                across[part],
                across[part + 1],
                across[part + 2],
                across[part + 3],
            )
            for row in range(width):
                a = first * down[part, row]
                b = second * down[part + 1, row]
                c = third * down[part + 2, row]
                d = fourth * down[part + 3, row]
                start = corner[taxel] + row * columns
                line = out[start : start + width]
                for cell in range(width):
                    line[cell] += a * one[cell] + b * two[cell] + c * three[cell] + d * four[cell]


@njit(cache=True, nogil=True, fastmath=FAST)
def read_stamps(
    field: Array,
    corner: Array,
    offset: Array,
    table: Array,
    sign: Array,
    work: Array,
    columns: int,
    out: Array,
) -> None:
    """Each taxel's stamp times a flat field, summed: the transpose of `add_stamps`."""
    across, down = work[0], work[1]
    width = table.shape[2]
    for taxel in range(len(out)):
        profiles_at(table, offset[taxel, 0], across)
        profiles_at(table, offset[taxel, 1], down)
        total = 0.0
        for part in range(table.shape[1]):
            profile = across[part]
            of_part = 0.0
            for row in range(width):
                start = corner[taxel] + row * columns
                line = field[start : start + width]
                of_row = out.dtype.type(0.0)
                for cell in range(width):
                    of_row += profile[cell] * line[cell]
                of_part += down[part, row] * of_row
            total += sign[part] * of_part
        out[taxel] = total


@njit(cache=True, nogil=True, fastmath=FAST)
def multiply(start: Array, other: Array, value: Array, vector: Array, out: Array) -> float:
    """Write M v for symmetric M with a diagonal of ones, below which it is stored by rows.

    Returns v . M v.
    """
    for row in range(len(vector)):
        out[row] = vector[row]
    curved = 0.0
    for row in range(len(vector)):
        mine = vector[row]
        total = out.dtype.type(0.0)
        for entry in range(start[row], start[row + 1]):
            beside = other[entry]
            total += value[entry] * vector[beside]
            out[beside] += value[entry] * mine
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
def turn(keep: float, residual: Array, way: Array) -> None:
    """The next way: the residual and `keep` of the way before."""
    share = way.dtype.type(keep)
    for row in range(len(way)):
        way[row] = residual[row] + share * way[row]


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
