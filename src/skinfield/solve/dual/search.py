"""The search itself, compiled as one piece so that it can look at the clock between steps."""

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats
from skinfield.solve.dual import kernel
from skinfield.solve.dual.kernel import (
    COUNT,
    FACTORED,
    GAP,
    GIVEN,
    IDLE,
    OBJECTIVE,
    PASS_PACE,
    PRESSED,
    SPREAD_PACE,
    STEP_PACE,
    STEPS,
    UNSOLVED,
    dual_values,
    half_square,
    learn_pace,
    list_near,
    primal,
    relax_pace,
    see_all,
)
from skinfield.solve.dual.workspace import Memory, Packed, Problem, now_ns, unpacked

LOCAL = 0.5  # of the tolerance, to which the searched nodes are solved before all are seen
STRICTER = 0.1  # of that, wherever it did not do
PASSES = 24  # over all nodes, at most
PATIENCE = 10  # steps on the searched nodes, after which all are seen: some may be missing
SPARE_NS = 2000  # for the way back to the caller
WELL = 0.2  # of what was left before a step: if more is left after it, its system was too old
FEW = 64  # active nodes whose system is made anew as quickly as an old one needs a step more
POOR = 0.1  # of the objective: an answer so far from its dual value is no safe start
LARGEST = 1e30  # of half the squared readings, beyond which single precision overflows


@njit
def answer(given: Packed, readings: Floats, out: Floats, deadline: int) -> None:
    """Write into `out` (K,) the pressure of linearised `readings` (L,); deadline 0 is none.

    What it is worth is left in `measures`. Being late, or without time for a proof, ends the
    search: so time decides in its last turn alone.
    """
    problem, memory = unpacked(given)
    counts, measures = memory.counts, memory.measures
    counts[STEPS] = counts[PRESSED] = counts[IDLE] = 0
    best = take_in(problem, memory, readings)  # nothing pressed is an answer, too
    measures[GAP], measures[OBJECTIVE] = 0.0, best
    lower = begin(problem, memory, best)
    going = lower >= 0.0
    local, passes, before, due = LOCAL * problem.tolerance, 0, np.inf, PATIENCE
    while going:
        start = now_ns(memory.room)
        best, plain = primal(problem, memory, best)
        left = half_square(memory.ascent)
        solved = left <= max(local, problem.rounding) * plain
        measures[UNSOLVED] = left / plain
        active = kernel.take_active(memory.listed, counts[COUNT], memory.slack, memory.active)
        work = step_work(len(memory.target), counts[COUNT], active)
        proof = measures[PASS_PACE] * problem.rows.size  # ns, by its pace so far
        ending = start + time_to_end(problem, memory)
        provable = deadline == 0 or ending + proof <= deadline
        reserved = proof if counts[STEPS] > 0 else 0.0  # a first step goes before its proof
        until = ending + reserved + measures[STEP_PACE] * work
        late = deadline > 0 and until > deadline
        if not (solved or late) and counts[STEPS] < min(due, problem.most):
            newton(problem, memory, active, active < FEW or left > WELL * before)
            before = left
            counts[STEPS] += 1
            learn_pace(measures, STEP_PACE, now_ns(memory.room) - start, work)
            continue
        if late and not solved:  # else one slow step would keep all later ones from being tried
            relax_pace(measures, STEP_PACE)
        if not provable:
            relax_pace(measures, PASS_PACE)
            break
        proved, within = dual_values(problem, memory)
        lower, passes = max(lower, proved), passes + 1
        enough = best - within <= problem.tolerance * best
        if enough or late or counts[STEPS] >= problem.most or passes >= PASSES:
            break
        local *= STRICTER if solved else 1.0
        due = counts[STEPS] + PATIENCE
        counts[COUNT] = list_near(problem, memory)
    if going:
        measures[GAP] = min(max((best - lower) / best, 0.0), 1.0)
        measures[OBJECTIVE] = best
    write_out(problem, memory, out)


@inner
def take_in(problem: Problem, memory: Memory, readings: Floats) -> float:
    """Whiten the readings; half their square."""
    for taxel in range(len(readings)):
        weight = problem.whitening[taxel]
        memory.target[taxel] = readings[taxel] * weight if weight > 0.0 else 0.0
        if weight == 0.0:  # left out: stamps still hold what such a taxel sees
            memory.dual[taxel] = 0.0
    return half_square(memory.target)


@inner
def write_out(problem: Problem, memory: Memory, out: Floats) -> None:
    """Write into `out` (K,) the bumps of the best amounts."""
    start, many = now_ns(memory.room), memory.counts[PRESSED]
    shape = (problem.height, problem.width)
    kernel.spread_bumps(memory.pressed, memory.amounts, many, problem.bump, shape, out)
    work = len(out) + many * problem.bump.size
    learn_pace(memory.measures, SPREAD_PACE, now_ns(memory.room) - start, work)


@inner
def begin(problem: Problem, memory: Memory, best: float) -> float:
    """Choose where to start; returns a dual value, or -1 if there is nothing to search.

    That is where the patch is idle, which is proved, and where `best`, half the squared readings,
    is no number to search with.
    """
    if not best < LARGEST:
        memory.dual[:] = 0.0
        memory.counts[COUNT] = memory.counts[GIVEN] = 0
        memory.measures[GAP] = 1.0
        return -1.0
    kept = memory.counts[GIVEN] == 0 and stands_out(problem, memory)
    if kept and (memory.measures[UNSOLVED] < POOR or still_best(problem, memory)):
        return 0.0
    every, norms, lower = memory.every, problem.norms, 0.0
    see_all(problem, memory, memory.target, problem.threshold)
    idle = True
    for node in range(len(every)):
        if every[node] > problem.threshold * norms[node]:
            idle = False
            break
    if idle:
        for taxel in range(len(memory.dual)):
            memory.dual[taxel] = memory.target[taxel]
        memory.counts[COUNT] = memory.counts[GIVEN] = 0
        memory.counts[IDLE] = 1
        return -1.0
    better = False  # than none: the dual that was handed in
    if memory.counts[GIVEN] != 0:
        better = dual_values(problem, memory)[1] > 0.0
        if not better:
            see_all(problem, memory, memory.target, problem.threshold)
    if not better:
        lower = start_along(problem, memory)
    memory.counts[GIVEN] = 0
    memory.counts[COUNT] = list_near(problem, memory)
    return lower


@inner
def start_along(problem: Problem, memory: Memory) -> float:
    """Start where the dual value is highest on the way from 0 to the readings; returns it."""
    every, slack = memory.every, memory.slack
    square = 2.0 * half_square(memory.target)
    for node in range(len(every)):
        slack[node] = -problem.penalty[node]
    length = kernel.step_length(slack, every, len(every), square, square)
    for taxel in range(len(memory.target)):
        memory.dual[taxel] = length * memory.target[taxel]
    total = 0.0
    for node in range(len(every)):
        every[node] *= length
        over = np.float64(max(every[node] - problem.penalty[node], 0.0))
        total += over * over
    value = length * (1.0 - 0.5 * length - problem.rounding) * square
    return max(value - 0.5 * total, 0.0)


@inner
def stands_out(problem: Problem, memory: Memory) -> bool:
    """Whether a node that was searched before is too significant for an idle patch."""
    count, turn = memory.counts[COUNT], memory.turn
    kernel.project(problem.rows, memory.listed, count, memory.target, turn)
    highest = 0.0
    for i in range(count):
        highest = max(highest, turn[i] - problem.threshold * problem.norms[memory.listed[i]])
    return highest > 0.0


@inner
def still_best(problem: Problem, memory: Memory) -> bool:
    """Whether the dual of the reading before is better than the way from 0 to the readings.

    As far as the nodes that were searched tell, whose product with the readings is in `turn`.
    """
    count, slack = memory.counts[COUNT], memory.slack
    square = 2.0 * half_square(memory.target)
    for i in range(count):
        slack[i] = -problem.penalty[memory.listed[i]]
    length = kernel.step_length(slack, memory.turn, count, square, square)
    along = length * square - 0.5 * length * length * square
    along -= excess(problem, memory, memory.turn, length)
    kernel.project(problem.rows, memory.listed, count, memory.dual, slack)
    product = 0.0
    for taxel in range(len(memory.target)):
        product += np.float64(memory.dual[taxel]) * memory.target[taxel]
    before = product - half_square(memory.dual) - excess(problem, memory, slack, 1.0)
    return before > along


@inner
def excess(problem: Problem, memory: Memory, seen: Floats, length: float) -> float:
    """Half the squared amounts of the searched nodes, from `length` times what they see."""
    total = 0.0
    for i in range(memory.counts[COUNT]):
        over = max(length * seen[i] - problem.penalty[memory.listed[i]], 0.0)
        total += over * over
    return 0.5 * total


@inner
def newton(problem: Problem, memory: Memory, active: int, anew: bool) -> None:
    """One semismooth Newton step from the dual, to where the dual value is highest along it.

    By the system of the active nodes of an earlier step, unless it should be made `anew`.
    """
    count, dual, step, turn = memory.counts[COUNT], memory.dual, memory.step, memory.turn
    rows, factored = problem.rows, memory.factored
    if anew or memory.counts[FACTORED] == 0:
        for place in range(active):
            factored[place] = memory.active[place]
        if active < len(dual):
            kernel.factor_nodes(rows, factored, active, memory.lower)
        else:
            kernel.factor_taxels(rows, factored, active, len(dual), memory.lower)
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


@inner
def step_work(taxels: int, count: int, active: int) -> float:
    """Products of a Newton step, about."""
    small, large = min(active, taxels), max(active, taxels)
    factor = 0.5 * small * small * large + small**3 / 6.0
    return 4000.0 + factor + (4.0 * count + 3.0 * active) * taxels


@inner
def time_to_end(problem: Problem, memory: Memory) -> float:
    """Nanoseconds that writing the answer takes, by its pace so far."""
    size = len(memory.every) + memory.counts[PRESSED] * problem.bump.size
    return float(memory.measures[SPREAD_PACE] * size + SPARE_NS)
