"""Steps of the search for a pressure that is nowhere negative, compiled.

All work on arrays that the caller keeps. `rows` (K, L) is what each node does to the whitened
readings, `table` (2 n - 1, 2 n - 1) the precision of the prior by offset in rows and columns from
1 - n to n - 1, beyond which it is 0.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats

Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
FAST = {"reassoc", "contract", "nsz"}  # sums in any order, but NaN stays NaN
HALVINGS = 3  # of a step that bends at 0, before single nodes are exchanged
DESCENT = 1e-4  # of what the slope promises, which a step must bring


@njit(cache=True, nogil=True, fastmath=FAST)
def correlate(rows: Floats, target: Floats, out: Floats) -> None:
    """Each node's signature times the whitened readings, (K,)."""
    for node in range(rows.shape[0]):
        total = 0.0
        for taxel in range(rows.shape[1]):
            total += rows[node, taxel] * target[taxel]
        out[node] = total


@njit(cache=True, nogil=True)
def highest_ratio(values: Floats, scale: Floats) -> float:
    """Largest of values / scale where the scale is not 0."""
    highest = 0.0
    for node in range(len(values)):
        if scale[node] > 0.0 and values[node] > highest * scale[node]:
            highest = values[node] / scale[node]
    return highest


@njit(cache=True, nogil=True, fastmath=FAST)
def slope_of(
    rows: Floats,
    correlated: Floats,
    penalty: Floats,
    table: Floats,
    shape: tuple[int, int],
    pressure: Floats,
    predicted: Floats,
    slope: Floats,
) -> float:
    """Write slope (K,) of the objective and predicted readings (L,); return p . (H p).

    H p is what the prior's precision and the taxels make of the pressure; the slope is
    H p - correlated + penalty.
    """
    predicted[:] = 0.0
    for node in range(len(pressure)):
        if pressure[node] > 0.0:
            for taxel in range(rows.shape[1]):
                predicted[taxel] += pressure[node] * rows[node, taxel]
    for node in range(len(pressure)):
        total = 0.0
        for taxel in range(rows.shape[1]):
            total += rows[node, taxel] * predicted[taxel]
        slope[node] = total
    height, width = shape
    reach = len(table) // 2
    for node in range(len(pressure)):
        if pressure[node] > 0.0:
            row, column = node // width, node % width
            first, last = max(column - reach, 0), min(column + reach + 1, width)
            for r in range(max(row - reach, 0), min(row + reach + 1, height)):
                entries = table[r - row + reach, first - column + reach :]
                part = slope[r * width + first : r * width + last]
                for c in range(len(part)):
                    part[c] += pressure[node] * entries[c]
    curved = 0.0
    for node in range(len(pressure)):
        curved += pressure[node] * slope[node]
        slope[node] += penalty[node] - correlated[node]
    return curved


@njit(cache=True, nogil=True, fastmath=FAST)
def gap_of(slope: Floats, pressure: Floats, std: Floats, stiffest: float) -> float:
    """How far the objective is above its minimum at most: duality gap (see `NonNegative`)."""
    slack, square, spread = 0.0, 0.0, 0.0
    for node in range(len(slope)):
        if slope[node] >= 0.0:
            slack += slope[node] * pressure[node]
        else:
            square += slope[node] * slope[node]
            spread -= slope[node] * std[node]
    return slack + 0.5 * min(square * stiffest, spread * spread)


@njit(cache=True, nogil=True)
def choose_many(
    slope: Floats,
    pressure: Floats,
    scale: Floats,
    shape: tuple[int, int],
    part: float,
    chosen: Flags,
) -> None:
    """Mark the nodes that may move: all pressed ones, and the steepest of those that should rise.

    Of the latter, each that is steeper than its eight neighbours or than `part` of the steepest of
    all; so that the set grows from many places at once but stays near the support.
    """
    height, width = shape
    worst = 0.0
    for node in range(len(slope)):
        if pressure[node] <= 0.0:
            worst = min(worst, slope[node] * scale[node])
    for node in range(len(slope)):
        steep = slope[node] * scale[node]
        chosen[node] = pressure[node] > 0.0 or steep < min(part * worst, 0.0)
        if chosen[node] or steep >= 0.0:
            continue
        chosen[node] = True
        row, column = node // width, node % width
        for r in range(max(row - 1, 0), min(row + 2, height)):
            for c in range(max(column - 1, 0), min(column + 2, width)):
                other = r * width + c
                if pressure[other] <= 0.0 and slope[other] * scale[other] < steep:
                    chosen[node] = False


@njit(cache=True, nogil=True)
def choose_few(
    slope: Floats, pressure: Floats, scale: Floats, one_more: bool, chosen: Flags
) -> None:
    """Mark all pressed nodes, and with `one_more` the steepest of those that should rise."""
    worst = -1
    for node in range(len(slope)):
        chosen[node] = pressure[node] > 0.0
        if chosen[node] or not one_more or slope[node] >= 0.0:
            continue
        if worst < 0 or slope[node] * scale[node] < slope[worst] * scale[worst]:
            worst = node
    if worst >= 0:
        chosen[worst] = True


@njit(cache=True, nogil=True)
def list_chosen(chosen: Flags, free: Ints, count: int) -> tuple[int, int]:
    """Bring the list of `count` free nodes up to date; return its length and how many first stay.

    Nodes that stay keep their order and new ones come last, so that the factor's first rows hold,
    and those that stay for long come to stand first. Clears the marks.
    """
    kept, same = 0, 0
    for i in range(count):
        if chosen[free[i]]:
            chosen[free[i]] = False
            same += same == i
            free[kept] = free[i]
            kept += 1
    for node in range(len(chosen)):
        if chosen[node]:
            chosen[node] = False
            free[kept] = node
            kept += 1
    return kept, same


@njit(cache=True, nogil=True, fastmath=FAST)
def factor(
    rows: Floats, table: Floats, width: int, free: Ints, done: int, count: int, lower: Floats
) -> bool:
    """Cholesky factor of the free nodes' part of H, into `lower` (at least count, count).

    The first `done` rows are there already. Returns whether H is positive definite to rounding.
    """
    reach = len(table) // 2
    for i in range(done, count):
        row, column = free[i] // width, free[i] % width
        mine, solved = rows[free[i]], lower[i]
        for j in range(i + 1):
            other = rows[free[j]]
            total = 0.0
            for taxel in range(len(mine)):
                total += mine[taxel] * other[taxel]
            down, aside = free[j] // width - row, free[j] % width - column
            if abs(down) <= reach and abs(aside) <= reach:
                total += table[down + reach, aside + reach]
            solved[j] = total
        for j in range(i + 1):
            above = lower[j]
            total = 0.0
            for k in range(j):
                total += solved[k] * above[k]
            if j < i:
                solved[j] = (solved[j] - total) / above[j]
            elif solved[i] > total:
                solved[i] = np.sqrt(solved[i] - total)
            else:
                return False
    return True


@njit(cache=True, nogil=True, fastmath=FAST)
def newton_step(lower: Floats, slope: Floats, free: Ints, count: int, step: Floats) -> None:
    """Solve H step = -slope on the free nodes by the factor; `step` is (count,) of them."""
    for i in range(count):
        total = -slope[free[i]]
        for k in range(i):
            total -= lower[i, k] * step[k]
        step[i] = total / lower[i, i]
    for i in range(count - 1, -1, -1):
        step[i] /= lower[i, i]
        for k in range(i):
            step[k] -= lower[i, k] * step[i]


@njit(cache=True, nogil=True, fastmath=FAST)
def change_of(lower: Floats, slope: Floats, free: Ints, count: int, moved: Floats) -> float:
    """How the objective changes, slope . d + |lower^T d|^2 / 2: exactly, as it is quadratic."""
    first, second = 0.0, 0.0
    for i in range(count):
        first += slope[free[i]] * moved[i]
    for k in range(count):
        total = 0.0
        for i in range(k, count):
            total += lower[i, k] * moved[i]
        second += total * total
    return first + 0.5 * second


@njit(cache=True, nogil=True, fastmath=FAST)
def move_clipped(
    lower: Floats,
    slope: Floats,
    free: Ints,
    count: int,
    step: Floats,
    moved: Floats,
    pressure: Floats,
) -> tuple[float, bool]:
    """Go along the step, clipped at 0, as far as the objective falls by enough.

    Returns its change, 0 where a few halvings did not help, and whether the whole step was gone.
    """
    length = 1.0
    for _ in range(HALVINGS + 1):
        promised, whole = 0.0, length == 1.0
        for i in range(count):
            at = pressure[free[i]]
            to = at + length * step[i]
            whole = whole and to >= 0.0
            moved[i] = max(to, 0.0) - at
            promised += slope[free[i]] * moved[i]
        change = change_of(lower, slope, free, count, moved)
        if change < DESCENT * promised:
            for i in range(count):
                pressure[free[i]] = max(pressure[free[i]] + length * step[i], 0.0)
            return change, whole
        length *= 0.5
    return 0.0, False


@njit(cache=True, nogil=True)
def move_straight(
    lower: Floats,
    slope: Floats,
    free: Ints,
    count: int,
    step: Floats,
    moved: Floats,
    pressure: Floats,
) -> tuple[float, bool]:
    """Go along the step until the first pressure is 0; returns as `move_clipped`."""
    length, first = 1.0, -1
    for i in range(count):
        if pressure[free[i]] + length * step[i] < 0.0:
            length, first = -pressure[free[i]] / step[i], i
    for i in range(count):
        moved[i] = length * step[i]
    change = change_of(lower, slope, free, count, moved)
    for i in range(count):
        pressure[free[i]] = 0.0 if i == first else max(pressure[free[i]] + moved[i], 0.0)
    return change, first < 0
