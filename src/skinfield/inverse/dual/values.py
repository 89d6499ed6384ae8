"""Values of the two problems, primal and dual, and what they are computed from."""

import numpy as np
from numba import njit

from skinfield.errors import Floats
from skinfield.inverse.dual import kernel
from skinfield.inverse.dual.arrays import Memory, Problem
from skinfield.inverse.dual.clock import now_ns
from skinfield.inverse.stamps_kernel import stamp_apply

MARGIN = 0.5  # standard deviations below a node's own threshold at which it is searched
UNITS = 8  # of a number's last place in `rounding`
FASTER, SLOWER = 0.98, 1.3  # how far one measurement may move a pace: nearly the slowest counts
SMOOTH, SAFE = 0.1, 1.6  # of the mean of a pace, and times that is never gone below
IDLE, COUNT, STEPS, PRESSED, GIVEN, FACTORED, ENDING = range(7)  # of `counts`
GAP, OBJECTIVE, STEP_PACE, PASS_PACE, SPREAD_PACE, UNSOLVED = range(6)  # of `measures`; ns
TYPICAL = 6  # and on: what paces come to in the mean


@njit(cache=True, nogil=True)
def half_square(values: Floats) -> float:
    """Half the sum of squares."""
    total = 0.0
    for value in values:
        total += np.float64(value) * value
    return 0.5 * total


@njit(cache=True, nogil=True)
def see_all(problem: Problem, memory: Memory, values: Floats, least: float) -> None:
    """Write into `every` (K,) the products of all rows with `values`.

    Where they are below `least` times the row's norm, anything may be written that is below it,
    too, and not below the product: with stamps the bound of what they lack is added, and the
    product itself is computed only where that does not tell.
    """
    every, rows, norms = memory.every, problem.rows, problem.norms
    if len(problem.cells) == 0:
        kernel.correlate(rows, values, every)
        return
    stamp_apply(
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
            every[node] = kernel.product(rows[node], values)


@njit(cache=True, nogil=True)
def list_near(problem: Problem, memory: Memory) -> int:
    """List the nodes that `every` says may carry pressure; return how many."""
    found = 0
    every, norms = memory.every, problem.norms
    for node in range(len(every)):
        if every[node] > problem.least * norms[node] and problem.allowed[node]:
            memory.listed[found] = node
            found += 1
    return found


@njit(cache=True, nogil=True)
def primal(problem: Problem, memory: Memory, best: float) -> tuple[float, float]:
    """Objective of the best amounts so far, which are kept, and of those at the dual.

    The latter are also scaled as a whole to where the objective is lowest. `ascent` becomes the
    slope of the dual value, readings - predicted - dual.
    """
    count, slack, listed = memory.counts[COUNT], memory.slack, memory.listed
    kernel.project(problem.rows, listed, count, memory.dual, slack)
    square, cost = 0.0, 0.0
    for i in range(count):
        slack[i] -= problem.penalty[listed[i]]
        if slack[i] > 0.0:
            square += np.float64(slack[i]) * slack[i]
            cost += np.float64(slack[i]) * problem.penalty[listed[i]]
    kernel.predict(problem.rows, listed, count, slack, memory.predicted)
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


@njit(cache=True, nogil=True)
def keep(memory: Memory, factor: float) -> None:
    """Keep the amounts at the dual, scaled, as the best so far."""
    kept = 0
    for i in range(memory.counts[COUNT]):
        if memory.slack[i] > 0.0:
            memory.pressed[kept] = memory.listed[i]
            memory.amounts[kept] = factor * memory.slack[i]
            kept += 1
    memory.counts[PRESSED] = kept


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def learn_pace(measures: Floats, which: int, taken: int, work: float) -> None:
    """Take in another measurement of a pace: near the slowest, and in the mean without pauses."""
    last, mean = taken / work, TYPICAL + which - STEP_PACE
    if measures[which] == 0.0:
        measures[which] = measures[mean] = last
    measures[which] = min(max(last, FASTER * measures[which]), SLOWER * measures[which])
    measures[mean] += SMOOTH * (min(last, 2.0 * measures[mean]) - measures[mean])


@njit(cache=True, nogil=True)
def relax_pace(measures: Floats, which: int) -> None:
    """Let a pace come down to the mean, where it kept something from being tried."""
    mean = TYPICAL + which - STEP_PACE
    measures[which] = max(FASTER * measures[which], SAFE * measures[mean])
