"""Parts of the search for a non-negative field in its dual, compiled.

All in whitened units, as in `NonNegative`: rows (K, W) are what each node's bump does to the
taxels, W their number filled up with zeros, dual (W,) the multipliers r, and a node's amount is
z = max(0, row . r - penalty). Nodes that are searched stand first in `listed`.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints

FAST = {"reassoc", "contract", "arcp", "nsz"}  # sums in any order; infinities stay what they are
BISECTIONS = 10  # of the step's length, to a thousandth
LEAST = 1e-6  # squared pivot: all are 1 or more but for rounding

Flags = NDArray[np.bool_]


@njit(cache=True, nogil=True, fastmath=FAST)
def correlate(rows: Floats, values: Floats, out: Floats) -> None:
    """Write into `out` (K,) the product of each row with `values` (W,)."""
    width, nodes, zero = len(values), len(rows), rows.dtype.type(0)
    even = nodes - nodes % 4
    for node in range(0, even, 4):  # four at a time: a value is loaded once for all
        first, second, third, fourth = zero, zero, zero, zero
        for taxel in range(width):
            value = values[taxel]
            first += rows[node, taxel] * value
            second += rows[node + 1, taxel] * value
            third += rows[node + 2, taxel] * value
            fourth += rows[node + 3, taxel] * value
        out[node], out[node + 1], out[node + 2], out[node + 3] = first, second, third, fourth
    for node in range(even, nodes):
        out[node] = product(rows[node], values)


@njit(cache=True, nogil=True, fastmath=FAST)
def product(row: Floats, values: Floats) -> float:
    """Sum of the products of two rows."""
    total = row.dtype.type(0)
    for taxel in range(len(values)):
        total += row[taxel] * values[taxel]
    return total


@njit(cache=True, nogil=True, fastmath=FAST)
def project(rows: Floats, listed: Ints, count: int, values: Floats, out: Floats) -> None:
    """Write into `out` (count,) the product of each listed row with `values` (W,)."""
    width, zero = len(values), rows.dtype.type(0)
    even = count - count % 4
    for i in range(0, even, 4):
        a, b, c, d = rows[listed[i]], rows[listed[i + 1]], rows[listed[i + 2]], rows[listed[i + 3]]
        first, second, third, fourth = zero, zero, zero, zero
        for taxel in range(width):
            value = values[taxel]
            first += a[taxel] * value
            second += b[taxel] * value
            third += c[taxel] * value
            fourth += d[taxel] * value
        out[i], out[i + 1], out[i + 2], out[i + 3] = first, second, third, fourth
    for i in range(even, count):
        out[i] = product(rows[listed[i]], values)


@njit(cache=True, nogil=True, fastmath=FAST)
def predict(rows: Floats, listed: Ints, count: int, slack: Floats, out: Floats) -> None:
    """Write into `out` (W,) the readings of the amounts."""
    width = len(out)
    out[:] = 0.0
    for i in range(count):
        amount = slack[i]
        if amount > 0.0:
            row = rows[listed[i]]
            for taxel in range(width):
                out[taxel] += amount * row[taxel]


@njit(cache=True, nogil=True)
def take_active(listed: Ints, count: int, slack: Floats, active: Ints) -> int:
    """List the nodes with an amount above 0; return how many."""
    found = 0
    for i in range(count):
        if slack[i] > 0.0:
            active[found] = listed[i]
            found += 1
    return found


@njit(cache=True, nogil=True, fastmath=FAST)
def factor_nodes(rows: Floats, active: Ints, count: int, lower: Floats) -> None:
    """Cholesky factor of 1 + B_A B_A' by nodes (B_A the active rows), into `lower`."""
    for i in range(count):
        project(rows, active, i + 1, rows[active[i]], lower[i])
        lower[i, i] += 1.0
        reduce_row(lower, i)


@njit(cache=True, nogil=True, fastmath=FAST)
def reduce_row(lower: Floats, i: int) -> None:
    """Turn row i of a positive definite matrix into that of its Cholesky factor.

    On the diagonal stand the reciprocals.
    """
    row, even = lower[i], i - i % 4
    for j in range(0, even, 4):
        a, b, c, d = lower[j], lower[j + 1], lower[j + 2], lower[j + 3]
        first, second, third, fourth = row[j], row[j + 1], row[j + 2], row[j + 3]
        for k in range(j):
            done = row[k]
            first -= done * a[k]
            second -= done * b[k]
            third -= done * c[k]
            fourth -= done * d[k]
        first *= a[j]
        second = (second - first * b[j]) * b[j + 1]
        third = (third - first * c[j] - second * c[j + 1]) * c[j + 2]
        fourth = (fourth - first * d[j] - second * d[j + 1] - third * d[j + 2]) * d[j + 3]
        row[j], row[j + 1], row[j + 2], row[j + 3] = first, second, third, fourth
    for j in range(even, i):
        above, total = lower[j], row[j]
        for k in range(j):
            total -= row[k] * above[k]
        row[j] = total * above[j]
    total = row[i]
    for k in range(i):
        total -= row[k] * row[k]
    row[i] = 1.0 / np.sqrt(max(total, LEAST))


@njit(cache=True, nogil=True, fastmath=FAST)
def factor_taxels(rows: Floats, active: Ints, count: int, width: int, lower: Floats) -> None:
    """Cholesky factor of 1 + B_A' B_A by taxels, into `lower`: for more nodes than taxels."""
    lower[:width, :width] = 0.0
    for i in range(width):
        lower[i, i] = 1.0
    even = count - count % 4
    for k in range(0, even, 4):
        a, b, c, d = rows[active[k]], rows[active[k + 1]], rows[active[k + 2]], rows[active[k + 3]]
        for i in range(width):
            line, first, second, third, fourth = lower[i], a[i], b[i], c[i], d[i]
            for j in range(i + 1):
                line[j] += first * a[j] + second * b[j] + third * c[j] + fourth * d[j]
    for k in range(even, count):
        a = rows[active[k]]
        for i in range(width):
            line, first = lower[i], a[i]
            for j in range(i + 1):
                line[j] += first * a[j]
    for i in range(width):
        reduce_row(lower, i)


@njit(cache=True, nogil=True, fastmath=FAST)
def solve_factored(lower: Floats, count: int, values: Floats) -> None:
    """Solve in place by a Cholesky factor with the reciprocals on its diagonal."""
    for i in range(count):
        total, row = values[i], lower[i]
        for k in range(i):
            total -= row[k] * values[k]
        values[i] = total * row[i]
    for i in range(count - 1, -1, -1):
        row = lower[i]
        solved = values[i] * row[i]
        values[i] = solved
        for k in range(i):
            values[k] -= row[k] * solved


@njit(cache=True, nogil=True, fastmath=FAST)
def factor(rows: Floats, active: Ints, count: int, width: int, lower: Floats) -> None:
    """Factor 1 + B_A' B_A, or 1 + B_A B_A' where fewer nodes are active than there are taxels."""
    if count < width:
        factor_nodes(rows, active, count, lower)
    else:
        factor_taxels(rows, active, count, width, lower)


@njit(cache=True, nogil=True, fastmath=FAST)
def newton_step(
    rows: Floats,
    active: Ints,
    count: int,
    ascent: Floats,
    lower: Floats,
    scratch: Floats,
    step: Floats,
) -> None:
    """Write into `step` (W,) the solution of (1 + B_A' B_A) step = ascent, by its `factor`.

    By nodes: (1 + B_A' B_A)^-1 = 1 - B_A' (1 + B_A B_A')^-1 B_A.
    """
    width = len(ascent)
    step[:] = ascent
    if count >= width:
        solve_factored(lower, width, step)
        return
    project(rows, active, count, ascent, scratch)
    solve_factored(lower, count, scratch)
    for i in range(count):
        row, amount = rows[active[i]], scratch[i]
        for taxel in range(width):
            step[taxel] -= amount * row[taxel]


@njit(cache=True, nogil=True, fastmath=FAST)
def bent(slack: Floats, turn: Floats, count: int, length: float) -> float:
    """Sum of the amounts at `length` along a step, each times its change by the step."""
    total = 0.0
    for i in range(count):
        total += max(slack[i] + length * turn[i], 0.0) * turn[i]
    return total


@njit(cache=True, nogil=True)
def step_length(slack: Floats, turn: Floats, count: int, first: float, second: float) -> float:
    """Length up to 1 along a step where the dual value is highest.

    It is piecewise quadratic there with the slope first - second t - bent(t), which falls.
    """
    if first - second - bent(slack, turn, count, 1.0) >= 0.0:
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if first - second * middle - bent(slack, turn, count, middle) > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@njit(cache=True, nogil=True, fastmath=FAST)
def spread_bumps(
    listed: Ints, amount: Floats, count: int, bump: Floats, shape: tuple[int, int], out: Floats
) -> None:
    """Write into `out` (K,) the sum of the nodes' bumps."""
    height, width = shape
    reach = len(bump) // 2
    out[:] = 0.0
    picture = out.reshape((height, width))
    for i in range(count):
        if amount[i] <= 0.0:
            continue
        row, column = listed[i] // width, listed[i] % width
        left, right = max(column - reach, 0), min(column + reach + 1, width)
        for r in range(max(row - reach, 0), min(row + reach + 1, height)):
            line, part = picture[r], bump[r - row + reach]
            for c in range(left, right):
                line[c] += amount[i] * part[c - column + reach]
