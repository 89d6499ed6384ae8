"""Products, factors and steps of the dual search, compiled.

Rows (K, W) are what each node's bump does to the taxels. Nodes of a list that are counted stand
first in it. Loops over elements compile in a tenth of the time of array expressions.
"""

import numpy as np

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints

FAST = {"reassoc", "contract", "arcp", "nsz"}  # sums in any order; infinities stay what they are
BISECTIONS = 10  # of the step's length, to a thousandth
LEAST = 1e-6  # squared pivot: all are 1 or more but for rounding


@inner
def dot(one: Floats, other: Floats) -> float:
    """Sum of the products of two vectors, in double precision."""
    total = 0.0
    for i in range(len(one)):
        total += np.float64(one[i]) * other[i]
    return total


@inner(fastmath=FAST)
def project(rows: Floats, listed: Ints, count: int, values: Floats, out: Floats) -> None:
    """Write into `out` (count,) the product of each listed row with `values` (W,)."""
    width, last, zero = len(values), count - 1, rows.dtype.type(0)
    for i in range(0, count, 4):  # four at a time: a value is loaded once for all
        j, k = i + 1 if i < last else last, i + 2 if i + 2 < count else last
        m = i + 3 if i + 3 < count else last
        a, b, c, d = rows[listed[i]], rows[listed[j]], rows[listed[k]], rows[listed[m]]
        first, second, third, fourth = zero, zero, zero, zero
        for taxel in range(width):
            value = values[taxel]
            first += a[taxel] * value
            second += b[taxel] * value
            third += c[taxel] * value
            fourth += d[taxel] * value
        out[i], out[j], out[k], out[m] = first, second, third, fourth


@inner
def take_out(root: Floats, values: Floats, out: Floats) -> None:
    """Write into `out` (W,) the product of 1 - s s' with `values`; both may be one array."""
    along = dot(root, values)
    for taxel in range(len(values)):
        out[taxel] = values[taxel] - along * root[taxel]


@inner(fastmath=FAST)
def product(row: Floats, values: Floats) -> float:
    """Sum of the products of two rows, in their own precision."""
    total = row.dtype.type(0)
    for taxel in range(len(values)):
        total += row[taxel] * values[taxel]
    return total


@inner(fastmath=FAST)
def add_rows(
    rows: Floats, listed: Ints, count: int, factors: Floats, least: float, sign: float, out: Floats
) -> None:
    """Add to `out` (W,) each listed row times the sign and its factor, if that exceeds `least`."""
    width = len(out)
    for i in range(count):
        if factors[i] > least:
            row, factor = rows[listed[i]], out.dtype.type(sign * factors[i])
            for taxel in range(width):
                out[taxel] += factor * row[taxel]


@inner(fastmath=FAST, inline="always")
def factor_rows(rows: Floats, active: Ints, count: int, width: int, lower: Floats) -> None:
    """Cholesky factor, into `lower`, of 1 + B B' by nodes (B the active rows), or 1 + B' B.

    The latter, by taxels, is the smaller one where no fewer nodes are active than there are taxels.
    """
    if count < width:
        for i in range(count):
            project(rows, active, i + 1, rows[active[i]], lower[i])
            lower[i, i] += 1.0
            reduce_row(lower, i)
        return
    for i in range(width):
        line = lower[i]
        for j in range(i):
            line[j] = 0.0
        line[i] = 1.0
    for k in range(0, count, 4):
        left, last = count - k, count - 1
        a, b = rows[active[k]], rows[active[k + 1 if left > 1 else last]]
        c, d = rows[active[k + 2 if left > 2 else last]], rows[active[k + 3 if left > 3 else last]]
        for i in range(width):
            line, first, zero = lower[i], a[i], rows.dtype.type(0)
            second, third = b[i] if left > 1 else zero, c[i] if left > 2 else zero
            fourth = d[i] if left > 3 else zero
            for j in range(i + 1):
                line[j] += first * a[j] + second * b[j] + third * c[j] + fourth * d[j]
    for i in range(width):
        reduce_row(lower, i)


@inner(fastmath=FAST)
def reduce_row(lower: Floats, i: int) -> None:
    """Turn row i of a positive definite matrix into that of its Cholesky factor.

    On the diagonal stand the reciprocals.
    """
    row, even = lower[i], i - i % 4
    for j in range(0, even, 4):
        a, b, c, d = lower[j], lower[j + 1], lower[j + 2], lower[j + 3]
        first, second, third, fourth = row[j], row[j + 1], row[j + 2], row[j + 3]
        for k in range(j):
            known = row[k]
            first -= known * a[k]
            second -= known * b[k]
            third -= known * c[k]
            fourth -= known * d[k]
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


@inner(fastmath=FAST)
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


@inner(fastmath=FAST)
def step_length(slack: Floats, turn: Floats, count: int, first: float, second: float) -> float:
    """Length up to 1 along a step where the dual value is highest.

    It is piecewise quadratic there with a slope that falls: first - second t, less the sum of the
    amounts at t, each times its change by the step.
    """
    low, high, length = 0.0, 1.0, 1.0
    for trial in range(BISECTIONS + 1):
        slope = first - second * length
        for i in range(count):
            amount = slack[i] + length * turn[i]
            slope -= amount * turn[i] if amount > 0.0 else 0.0
        if slope > 0.0:
            low = length
        else:
            high = length
        if trial == 0 and slope >= 0.0:
            return 1.0
        length = 0.5 * (low + high)
    return length


@inner
def excess(
    norms: Floats, listed: Ints, count: int, penalty: float, seen: Floats, length: float
) -> float:
    """Half the squared amounts of listed nodes, by `length` times what they see (count,)."""
    total = 0.0
    for i in range(count):
        over = length * seen[i] - penalty * norms[listed[i]]
        total += over * over if over > 0.0 else 0.0
    return 0.5 * total


@inner(fastmath=FAST, inline="always")
def spread_bumps(
    listed: Ints, amount: Floats, count: int, bump: Floats, width: int, out: Floats
) -> None:
    """Write into `out` (K,) the sum of the nodes' bumps, on a grid of so many columns."""
    reach, height = len(bump) // 2, len(out) // width
    for node in range(len(out)):
        out[node] = 0.0
    for i in range(count):
        if amount[i] <= 0.0:
            continue
        row, column = listed[i] // width, listed[i] % width
        left, right = max(column - reach, 0), min(column + reach + 1, width)
        for r in range(max(row - reach, 0), min(row + reach + 1, height)):
            part, first = bump[r - row + reach], r * width
            for c in range(left, right):
                out[first + c] += amount[i] * part[c - column + reach]
