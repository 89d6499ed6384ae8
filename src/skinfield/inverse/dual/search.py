"""The search itself, compiled as one piece so that it can look at the clock between steps."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.inverse.dual import kernel
from skinfield.inverse.dual.clock import now_ns

MARGIN = 0.5  # standard deviations below a node's own threshold at which it is searched
LOCAL = 0.25  # of the tolerance, to which the searched nodes are solved before all are seen
STRICTER = 0.1  # of that, wherever it did not do
PASSES = 12  # over all nodes, at most
FASTER, SLOWER = 0.98, 1.3  # how far one measurement may move a pace: nearly the slowest counts
SPARE_NS = 2000  # for the way back to the caller
WELL = 0.2  # of what was left before a step: if more is left after it, its system was too old
LARGEST = 1e30  # of half the squared readings, beyond which single precision overflows
IDLE, COUNT, STEPS, PRESSED, GIVEN, FACTORED = range(6)  # of `counts`
GAP, OBJECTIVE, STEP_PACE, PASS_PACE, SPREAD_PACE = range(5)  # of `measures`; ns per product


class Problem(NamedTuple):
    """What never changes; see `skinfield.inverse.non_negative`."""

    rows: Floats
    norms: Floats
    penalty: Floats
    bump: Floats
    whitening: Floats
    allowed: NDArray[np.bool_]
    threshold: float
    tolerance: float
    rounding: float
    most: int
    height: int
    width: int


class Memory(NamedTuple):
    """What lasts from reading to reading, and room to work in."""

    target: Floats
    dual: Floats
    predicted: Floats
    ascent: Floats
    step: Floats
    scratch: Floats
    listed: Ints
    slack: Floats
    turn: Floats
    every: Floats
    active: Ints
    factored: Ints
    lower: Floats
    pressed: Ints
    amounts: Floats
    counts: Ints
    measures: Floats
    room: Ints


@njit(cache=True, nogil=True)
def answer(problem: Problem, memory: Memory, readings: Floats, out: Floats, deadline: int) -> None:
    """Write into `out` (K,) the pressure of linearised `readings` (L,); deadline 0 is none."""
    counts, measures = memory.counts, memory.measures
    for taxel in range(len(readings)):
        weight = problem.whitening[taxel]
        memory.target[taxel] = readings[taxel] * weight if weight > 0.0 else 0.0
    search(problem, memory, deadline)
    start = now_ns(memory.room)
    shape = (problem.height, problem.width)
    kernel.spread_bumps(memory.pressed, memory.amounts, counts[PRESSED], problem.bump, shape, out)
    work = len(out) + counts[PRESSED] * problem.bump.size
    measures[SPREAD_PACE] = measured(measures[SPREAD_PACE], now_ns(memory.room) - start, work)


@njit(cache=True, nogil=True)
def search(problem: Problem, memory: Memory, deadline: int) -> None:
    """Leave the best amounts in `pressed` and `amounts`, and what they are worth in `measures`."""
    counts, measures = memory.counts, memory.measures
    counts[STEPS] = counts[PRESSED] = counts[IDLE] = 0
    best, lower = half_square(memory.target), 0.0  # nothing pressed is an answer, too
    measures[GAP], measures[OBJECTIVE] = 0.0, best
    if not best < LARGEST:  # nor if it is not a number
        memory.dual[:] = 0.0
        counts[COUNT] = counts[GIVEN] = 0
        measures[GAP] = 1.0
        return
    if not begin(problem, memory):
        counts[IDLE] = 1
        return
    local, passes, before = LOCAL * problem.tolerance, 0, np.inf
    while True:
        start = now_ns(memory.room)
        best, plain = primal(problem, memory, best)
        left = half_square(memory.ascent)
        solved = left <= max(local, problem.rounding) * plain
        active = kernel.take_active(memory.listed, counts[COUNT], memory.slack, memory.active)
        work = step_work(len(memory.target), counts[COUNT], active)
        proof, ending = time_to_prove(problem, memory), start + time_to_end(problem, memory)
        provable = deadline == 0 or ending + proof <= deadline
        until = ending + (proof if provable else 0.0) + measures[STEP_PACE] * work
        late = deadline > 0 and until > deadline
        if not (solved or late) and counts[STEPS] < problem.most:
            newton(problem, memory, active, left > WELL * before)
            before = left
            counts[STEPS] += 1
            taken = now_ns(memory.room) - start
            measures[STEP_PACE] = measured(measures[STEP_PACE], taken, work)
            continue
        if not provable:
            break
        proved, within = dual_values(problem, memory)
        lower, passes = max(lower, proved), passes + 1
        enough = best - within <= problem.tolerance * best
        if enough or late or counts[STEPS] >= problem.most or passes >= PASSES:
            break
        local *= STRICTER
        counts[COUNT] = list_near(problem, memory)
    measures[GAP] = min(max((best - lower) / best, 0.0), 1.0)
    measures[OBJECTIVE] = best


@njit(cache=True, nogil=True)
def begin(problem: Problem, memory: Memory) -> bool:
    """Choose where to start; False if the patch is idle, which is proved here."""
    if memory.counts[GIVEN] == 0 and stands_out(problem, memory):
        return True
    every, norms = memory.every, problem.norms
    kernel.correlate(problem.rows, memory.target, every)
    idle = True
    for node in range(len(every)):
        if every[node] > problem.threshold * norms[node]:
            idle = False
            break
    if idle:
        memory.dual[:] = memory.target
        memory.counts[COUNT] = memory.counts[GIVEN] = 0
        return False
    if memory.counts[GIVEN] == 0 or not given_is_better(problem, memory):
        start_along(problem, memory)
    memory.counts[GIVEN] = 0
    memory.counts[COUNT] = list_near(problem, memory)
    return True


@njit(cache=True, nogil=True)
def given_is_better(problem: Problem, memory: Memory) -> bool:
    """Whether the dual that was handed in is better than none; `every` is then of that one."""
    _, within = dual_values(problem, memory)
    if within > 0.0:
        return True
    kernel.correlate(problem.rows, memory.target, memory.every)
    return False


@njit(cache=True, nogil=True)
def start_along(problem: Problem, memory: Memory) -> None:
    """Start where the dual value is highest on the way from 0 to the readings themselves."""
    every, slack = memory.every, memory.slack
    square = 2.0 * half_square(memory.target)
    for node in range(len(every)):
        slack[node] = -problem.penalty[node]
    length = kernel.step_length(slack, every, len(every), square, square)
    for taxel in range(len(memory.target)):
        memory.dual[taxel] = length * memory.target[taxel]
    for node in range(len(every)):
        every[node] *= length


@njit(cache=True, nogil=True)
def stands_out(problem: Problem, memory: Memory) -> bool:
    """Whether a node that was searched before is too significant for an idle patch."""
    count, turn = memory.counts[COUNT], memory.turn
    kernel.project(problem.rows, memory.listed, count, memory.target, turn)
    highest = 0.0
    for i in range(count):
        highest = max(highest, turn[i] - problem.threshold * problem.norms[memory.listed[i]])
    return highest > 0.0


@njit(cache=True, nogil=True)
def list_near(problem: Problem, memory: Memory) -> int:
    """List the nodes that `every` says may carry pressure; return how many."""
    found = 0
    every, penalty, norms = memory.every, problem.penalty, problem.norms
    for node in range(len(every)):
        if every[node] > penalty[node] - MARGIN * norms[node] and problem.allowed[node]:
            memory.listed[found] = node
            found += 1
    return found


@njit(cache=True, nogil=True)
def half_square(values: Floats) -> float:
    """Half the sum of squares."""
    total = 0.0
    for value in values:
        total += np.float64(value) * value
    return 0.5 * total


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
    kernel.correlate(problem.rows, memory.dual, every)
    square, elsewhere = 0.0, 0.0
    for node in range(len(every)):
        over = np.float64(max(every[node] - penalty[node], 0.0))
        if problem.allowed[node]:
            square += over * over
        else:
            elsewhere += over * over
    own, product = half_square(memory.dual), 0.0
    for taxel in range(len(memory.target)):
        product += np.float64(memory.dual[taxel]) * memory.target[taxel]
    rounded = problem.rounding * np.sqrt(own * half_square(memory.target))
    within = product - own - 0.5 * square - rounded
    taken = now_ns(memory.room) - start
    measures = memory.measures
    measures[PASS_PACE] = measured(measures[PASS_PACE], taken, problem.rows.size)
    return within - 0.5 * elsewhere, within


@njit(cache=True, nogil=True)
def newton(problem: Problem, memory: Memory, active: int, anew: bool) -> None:
    """One semismooth Newton step from the dual, to where the dual value is highest along it.

    By the system of the active nodes of an earlier step, unless it should be made `anew`.
    """
    count, dual, step, turn = memory.counts[COUNT], memory.dual, memory.step, memory.turn
    rows, factored = problem.rows, memory.factored
    if anew or memory.counts[FACTORED] == 0:
        factored[:active] = memory.active[:active]
        kernel.factor(rows, factored, active, len(dual), memory.lower)
        memory.counts[FACTORED] = active
    n = memory.counts[FACTORED]
    kernel.newton_step(rows, factored, n, memory.ascent, memory.lower, memory.scratch, step)
    first, second = 0.0, 0.0
    for taxel in range(len(step)):
        first += step[taxel] * (memory.target[taxel] - dual[taxel])
        second += step[taxel] * step[taxel]
    kernel.project(problem.rows, memory.listed, count, step, turn)
    length = kernel.step_length(memory.slack, turn, count, first, second)
    for taxel in range(len(step)):
        dual[taxel] += length * step[taxel]


@njit(cache=True, nogil=True)
def step_work(taxels: int, count: int, active: int) -> float:
    """Products of a Newton step, about."""
    small, large = min(active, taxels), max(active, taxels)
    factor = 0.5 * small * small * large + small**3 / 6.0
    return 4000.0 + factor + (4.0 * count + 3.0 * active) * taxels


@njit(cache=True, nogil=True)
def time_to_prove(problem: Problem, memory: Memory) -> float:
    """Nanoseconds that a pass over all nodes takes, by its pace so far."""
    return float(memory.measures[PASS_PACE] * problem.rows.size)


@njit(cache=True, nogil=True)
def time_to_end(problem: Problem, memory: Memory) -> float:
    """Nanoseconds that writing the answer takes, by its pace so far."""
    size = len(memory.every) + memory.counts[PRESSED] * problem.bump.size
    return float(memory.measures[SPREAD_PACE] * size + SPARE_NS)


@njit(cache=True, nogil=True)
def measured(pace: float, taken: int, work: float) -> float:
    """Pace after another measurement."""
    last = taken / work
    return last if pace == 0.0 else min(max(last, FASTER * pace), SLOWER * pace)
