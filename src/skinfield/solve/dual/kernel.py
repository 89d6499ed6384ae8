"""Dual of the non-negative problem, compiled: values, gradients, and steps of the search.

All in whitened units, as in `NonNegative`: rows (K, W) are what each node's bump does to the
taxels, W their number filled up with zeros, dual (W,) the multipliers r, and a node's amount is
z = max(0, row . r - penalty). Nodes that are searched stand first in `listed`.
"""

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints
from skinfield.solve.dual.workspace import Memory, Problem, now_ns
from skinfield.solve.tiles_kernel import apply_tiles

FAST = {"reassoc", "contract", "arcp", "nsz"}  # sums in any order; infinities stay what they are
BISECTIONS = 10  # of the step's length, to a thousandth
LEAST = 1e-6  # squared pivot: all are 1 or more but for rounding

Flags = NDArray[np.bool_]


@inner(fastmath=FAST)
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


@inner(fastmath=FAST)
def product(row: Floats, values: Floats) -> float:
    """Sum of the products of two rows."""
    total = row.dtype.type(0)
    for taxel in range(len(values)):
        total += row[taxel] * values[taxel]
    return total


@inner(fastmath=FAST)
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


@inner(fastmath=FAST)
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


@inner
def take_active(listed: Ints, count: int, slack: Floats, active: Ints) -> int:
    """List the nodes with an amount above 0; return how many."""
    found = 0
    for i in range(count):
        if slack[i] > 0.0:
            active[found] = listed[i]
            found += 1
    return found


@inner(fastmath=FAST)
def factor_nodes(rows: Floats, active: Ints, count: int, lower: Floats) -> None:
    """Cholesky factor of 1 + B_A B_A' by nodes (B_A the active rows), into `lower`."""
    for i in range(count):
        project(rows, active, i + 1, rows[active[i]], lower[i])
        lower[i, i] += 1.0
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


@inner(fastmath=FAST)
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
def newton_step(
    rows: Floats,
    active: Ints,
    count: int,
    ascent: Floats,
    lower: Floats,
    scratch: Floats,
    step: Floats,
) -> None:
    """Write into `step` (W,) the solution of (1 + B_A' B_A) step = ascent, by its factor.

    That is of `factor_nodes` where fewer nodes are active than there are taxels, and of
    `factor_taxels` elsewhere. By nodes: (1 + B_A' B_A)^-1 = 1 - B_A' (1 + B_A B_A')^-1 B_A.
    """
    width = len(ascent)
    for taxel in range(len(step)):  # a loop compiles in a tenth of the time of a copy
        step[taxel] = ascent[taxel]
    if count >= width:
        solve_factored(lower, width, step)
        return
    project(rows, active, count, ascent, scratch)
    solve_factored(lower, count, scratch)
    for i in range(count):
        row, amount = rows[active[i]], scratch[i]
        for taxel in range(width):
            step[taxel] -= amount * row[taxel]


@inner(fastmath=FAST)
def bent(slack: Floats, turn: Floats, count: int, length: float) -> float:
    """Sum of the amounts at `length` along a step, each times its change by the step."""
    total = 0.0
    for i in range(count):
        total += max(slack[i] + length * turn[i], 0.0) * turn[i]
    return total


@inner
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


@inner(fastmath=FAST)
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


MARGIN = 0.5  # standard deviations below a node's own threshold at which it is searched
UNITS = 8  # of a number's last place in `rounding`
FASTER, SLOWER = 0.98, 1.3  # how far one measurement may move a pace: nearly the slowest counts
SMOOTH, SAFE = 0.1, 1.6  # of the mean of a pace, and times that is never gone below
IDLE, COUNT, STEPS, PRESSED, GIVEN, FACTORED = range(6)  # of `counts`
GAP, OBJECTIVE, STEP_PACE, PASS_PACE, SPREAD_PACE, UNSOLVED = range(6)  # of `measures`; ns
TYPICAL = 6  # and on: what paces come to in the mean


@inner
def half_square(values: Floats) -> float:
    """Half the sum of squares."""
    total = 0.0
    for value in values:
        total += np.float64(value) * value
    return 0.5 * total


@inner
def see_all(problem: Problem, memory: Memory, values: Floats, least: float) -> None:
    """Write into `every` (K,) the products of all rows with `values`.

    Where they are below `least` times the row's norm, anything may be written that is below it,
    too, and not below the product: with stamps the bound of what they lack is added, and the
    product itself is computed only where that does not tell.
    """
    every, rows, norms = memory.every, problem.rows, problem.norms
    if len(problem.cells) == 0:
        correlate(rows, values, every)
        return
    apply_tiles(
        problem.stamps,
        problem.taxels,
        problem.firsts,
        problem.cells,
        problem.width,
        values,
        every,
    )
    size = every.dtype.type(np.sqrt(2.0 * half_square(values)))
    for node in range(len(every)):
        every[node] += problem.dropped[node] * size
        if every[node] > least * norms[node]:
            every[node] = product(rows[node], values)


@inner
def list_near(problem: Problem, memory: Memory) -> int:
    """List the nodes that `every` says may carry pressure; return how many."""
    found = 0
    every, norms = memory.every, problem.norms
    for node in range(len(every)):
        if every[node] > problem.least * norms[node] and problem.allowed[node]:
            memory.listed[found] = node
            found += 1
    return found


@inner
def primal(problem: Problem, memory: Memory, best: float) -> tuple[float, float]:
    """Objective of the best amounts so far, which are kept, and of those at the dual.

    The latter are also scaled as a whole to where the objective is lowest. `ascent` becomes the
    slope of the dual value, readings - predicted - dual.
    """
    count, slack, listed = memory.counts[COUNT], memory.slack, memory.listed
    project(problem.rows, listed, count, memory.dual, slack)
    square, cost = 0.0, 0.0
    for i in range(count):
        slack[i] -= problem.penalty[listed[i]]
        if slack[i] > 0.0:
            square += np.float64(slack[i]) * slack[i]
            cost += np.float64(slack[i]) * problem.penalty[listed[i]]
    predict(problem.rows, listed, count, slack, memory.predicted)
    gain, curve, left = -cost, square, 0.0
    for taxel in range(len(memory.target)):
        there, read = np.float64(memory.predicted[taxel]), np.float64(memory.target[taxel])
        memory.ascent[taxel] = read - there - memory.dual[taxel]
        gain += there * read
        curve += there * there
        left += (read - there) * (read - there)
    factor = max(gain, 0.0) / curve if curve > 0.0 else 0.0
    scaled = half_square(memory.target) - 0.5 * max(gain, 0.0) * factor
    if scaled < best:
        keep(memory, factor)
        best = scaled
    return best, 0.5 * left + 0.5 * square + cost


@inner
def keep(memory: Memory, factor: float) -> None:
    """Keep the amounts at the dual, scaled, as the best so far."""
    kept = 0
    for i in range(memory.counts[COUNT]):
        if memory.slack[i] > 0.0:
            memory.pressed[kept] = memory.listed[i]
            memory.amounts[kept] = factor * memory.slack[i]
            kept += 1
    memory.counts[PRESSED] = kept


@inner
def dual_values(problem: Problem, memory: Memory) -> tuple[float, float]:
    """What no answer's objective is below, by a pass over all nodes; and none of those allowed."""
    start = now_ns(memory.room)
    every, penalty = memory.every, problem.penalty
    see_all(problem, memory, memory.dual, problem.least)
    square, elsewhere, spread, pressed = 0.0, 0.0, 0.0, 0
    for node in range(len(every)):
        over = np.float64(max(every[node] - penalty[node], 0.0))
        if problem.allowed[node]:
            square += over * over
            spread += over * problem.norms[node]
            pressed += 1 if over > 0.0 else 0
        else:
            elsewhere += over * over
    own, product = half_square(memory.dual), 0.0
    for taxel in range(len(memory.target)):
        product += np.float64(memory.dual[taxel]) * memory.target[taxel]
    rounded = problem.rounding * np.sqrt(own * half_square(memory.target))
    # and what the objective may be off, as readings are predicted by a sum over pressed nodes
    rounded += problem.rounding / UNITS * np.sqrt(2.0 * own * pressed) * spread
    within = product - own - 0.5 * square - rounded
    taken = now_ns(memory.room) - start
    learn_pace(memory.measures, PASS_PACE, taken, problem.rows.size)
    return within - 0.5 * elsewhere, within


@inner
def learn_pace(measures: Floats, which: int, taken: int, work: float) -> None:
    """Take in another measurement of a pace: near the slowest, and in the mean without pauses."""
    last, mean = taken / work, TYPICAL + which - STEP_PACE
    if measures[which] == 0.0:
        measures[which] = measures[mean] = last
    measures[which] = min(max(last, FASTER * measures[which]), SLOWER * measures[which])
    measures[mean] += SMOOTH * (min(last, 2.0 * measures[mean]) - measures[mean])


@inner
def relax_pace(measures: Floats, which: int) -> None:
    """Let a pace come down to the mean, where it kept something from being tried."""
    mean = TYPICAL + which - STEP_PACE
    measures[which] = max(FASTER * measures[which], SAFE * measures[mean])
