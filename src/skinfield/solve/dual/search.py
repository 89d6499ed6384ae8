"""Search of the dual, compiled as one piece so that it can look at the clock between steps."""

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints
from skinfield.solve.clock import now_ns
from skinfield.solve.dual import problem as at
from skinfield.solve.dual.kernel import (
    FAST,
    add_rows,
    dot,
    excess,
    factor_rows,
    product,
    project,
    solve_factored,
    spread_bumps,
    step_length,
    take_out,
)
from skinfield.solve.dual.problem import DualProblem, Memory
from skinfield.solve.tiles_kernel import add_tile

LOCAL = 0.5  # of the tolerance, to which the searched nodes are solved before all are seen
STRICTER = 0.1  # of that, wherever it did not do
PASSES = 24  # over all nodes, at most
PATIENCE = 10  # steps on the searched nodes, after which all are seen: some may be missing
SPARE_NS = 2000  # for the way back to the caller
WELL = 0.2  # of what was left before a step: if more is left after it, its system was too old
FEW = 64  # active nodes whose system is made anew as quickly as an old one needs a step more
POOR = 0.1  # of the objective: an answer so far from its dual value is no safe start
LARGEST = 1e30  # of half the squared readings, beyond which single precision overflows
MARGIN = 0.5  # standard deviations below a node's own penalty at which it is searched
UNITS = 8  # of a number's last place in the rounding of a dual value
FASTER, SLOWER = 0.98, 1.3  # how far one measurement may move a pace: nearly the slowest counts
SMOOTH, SAFE = 0.1, 1.6  # of the mean of a pace, and times that is never gone below


@njit(fastmath=FAST)
def answer(
    problem: DualProblem, memory: Memory, readings: Floats, out: Floats, deadline: int
) -> None:
    """Write into `out` (K,) the pressure of linearised `readings` (L,); deadline 0 is none.

    What it is worth is left in `measures`. Being late, or without time for a proof, ends the
    search: so time decides in its last turn alone.
    """
    counts, measures, numbers = memory.lists[at.COUNTS], memory.measures, problem.numbers
    target, dual = memory.taxels[at.TARGET], memory.taxels[at.DUAL]
    ascent = memory.taxels[at.ASCENT]
    width, rows, highest, shared = len(target), problem.rows.size, 0.0, 0.0
    for taxel in range(len(readings)):
        weight, reading = problem.whitening[taxel], readings[taxel]
        if weight == 0.0:  # left out: stamps still hold what such a taxel sees
            dual[taxel] = 0.0
            continue
        shared += problem.root[taxel] * weight * reading
        highest = max(highest, abs(reading))
    for taxel in range(len(readings)):
        weight = problem.whitening[taxel]
        white = weight * readings[taxel] - shared * problem.root[taxel]
        target[taxel] = white if weight > 0.0 else 0.0
    best = 0.5 * dot(target, target)  # nothing pressed is an answer, too
    scale = np.sqrt(1.0 + (numbers[at.MISFIT] * highest) ** 2) if best < LARGEST else 1.0
    for taxel in range(width):
        target[taxel] /= scale
    best /= scale * scale
    counts[at.STEPS] = counts[at.PRESSING] = counts[at.IDLE] = 0
    measures[at.GAP], measures[at.OBJECTIVE] = 0.0, best
    lower = begin(problem, memory, best, scale)
    going, tolerance, most = lower >= 0.0, numbers[at.TOLERANCE], int(numbers[at.MOST])
    local, passes, before, due = LOCAL * tolerance, 0, np.inf, PATIENCE
    while going:
        start = now_ns(counts)
        best, plain, active = primal(problem, memory, best)
        left = 0.5 * dot(ascent, ascent)
        solved = left <= max(local, numbers[at.ROUNDING]) * plain
        measures[at.UNSOLVED] = left / plain
        small, large = (active, width) if active < width else (width, active)
        work = 4000.0 + 0.5 * small * small * large + small * small * small / 6.0  # of a step
        work += (4.0 * counts[at.SEARCHED] + 3.0 * active) * width
        proof = measures[at.PASS_PACE] * rows  # ns, by its pace so far
        spread = len(out) + counts[at.PRESSING] * problem.bump.size
        ending = start + measures[at.SPREAD_PACE] * spread + SPARE_NS
        provable = deadline == 0 or ending + proof <= deadline
        reserved = proof if counts[at.STEPS] > 0 else 0.0  # a first step goes before its proof
        late = deadline > 0 and ending + reserved + measures[at.STEP_PACE] * work > deadline
        if not (solved or late) and counts[at.STEPS] < min(due, most):
            newton(problem, memory, active, active < FEW or left > WELL * before)
            before = left
            counts[at.STEPS] += 1
            learn_pace(measures, at.STEP_PACE, now_ns(counts) - start, work)
            continue
        if late and not solved:  # else one slow step would keep all later ones from being tried
            relax_pace(measures, at.STEP_PACE)
        if not provable:
            relax_pace(measures, at.PASS_PACE)
            break
        proved = dual_value(problem, memory)
        lower, passes = max(lower, proved), passes + 1
        enough = best - proved <= tolerance * best
        if enough or late or counts[at.STEPS] >= most or passes >= PASSES:
            break
        local *= STRICTER if solved else 1.0
        due = counts[at.STEPS] + PATIENCE
        list_near(problem, memory)
    if going:
        measures[at.GAP] = min(max((best - lower) / best, 0.0), 1.0)
        measures[at.OBJECTIVE] = best
    start, pressing = now_ns(counts), counts[at.PRESSING]
    pressed, amounts = memory.lists[at.PRESSED], memory.nodes[at.AMOUNT]
    spread_bumps(pressed, amounts, pressing, problem.bump, int(numbers[at.WIDTH]), out)
    if scale != 1.0:
        for node in range(len(out)):
            out[node] *= scale
    work = float(len(out) + pressing * problem.bump.size)
    learn_pace(measures, at.SPREAD_PACE, now_ns(counts) - start, work)


@inner(inline="always")
def begin(problem: DualProblem, memory: Memory, best: float, scale: float) -> float:
    """Choose where to start; returns a dual value, or -1 if there is nothing to search.

    That is where the patch is idle, which is proved by the noise without the model's error, `scale`
    times less, and where `best`, half the squared readings, is no number to search with.
    """
    counts, target, dual = memory.lists[at.COUNTS], memory.taxels[at.TARGET], memory.taxels[at.DUAL]
    every, norms = memory.nodes[at.EVERY], problem.nodes[at.NORM]
    usable, threshold = best < LARGEST, problem.numbers[at.THRESHOLD] / scale
    if usable and counts[at.STARTED] == 0 and goes_on(problem, memory, threshold):
        return 0.0
    idle = usable
    if usable:
        see_all(problem, memory, target, threshold)
        for node in range(len(every)):
            if every[node] > threshold * norms[node]:
                idle = False
                break
    if idle or not usable:
        for taxel in range(len(dual)):
            dual[taxel] = target[taxel] if idle else 0.0
        memory.measures[at.GAP] = 0.0 if idle else 1.0
        counts[at.SEARCHED] = counts[at.STARTED] = 0
        counts[at.IDLE] = 1 if idle else 0
        return -1.0
    lower, started = 0.0, counts[at.STARTED] != 0
    counts[at.STARTED] = 0
    if started and not dual_value(problem, memory) > 0.0:  # no better than none
        see_all(problem, memory, target, threshold)
        started = False
    if not started:
        every_node = memory.lists[at.ALL]
        length, lower = best_along(problem, memory, every_node, len(every), every)
        for taxel in range(len(target)):
            dual[taxel] = length * target[taxel]
        for node in range(len(every)):
            every[node] *= length
    list_near(problem, memory)
    return lower


@inner(inline="always")
def goes_on(problem: DualProblem, memory: Memory, threshold: float) -> bool:
    """Whether to start from the dual of the reading before.

    Not where none of the nodes that were searched then is too significant for an idle patch, nor
    after a poor answer unless, as far as these tell, it is better than the way to the readings.
    """
    listed, count = memory.lists[at.LISTED], memory.lists[at.COUNTS, at.SEARCHED]
    target, dual = memory.taxels[at.TARGET], memory.taxels[at.DUAL]
    norms, slack, turn = problem.nodes[at.NORM], memory.nodes[at.SLACK], memory.nodes[at.TURN]
    penalty = problem.numbers[at.PENALTY]
    project(problem.rows, listed, count, target, turn)
    significant = False
    for i in range(count):
        if turn[i] > threshold * norms[listed[i]]:
            significant = True
    if not significant or memory.measures[at.UNSOLVED] < POOR:
        return significant
    along = best_along(problem, memory, listed, count, turn)[1]
    project(problem.rows, listed, count, dual, slack)
    before = dot(dual, target) - 0.5 * dot(dual, dual)
    return before - excess(norms, listed, count, penalty, slack, 1.0) > along


@inner
def best_along(
    problem: DualProblem, memory: Memory, listed: Ints, count: int, seen: Floats
) -> tuple[float, float]:
    """Share of the readings at which the dual value of listed nodes is highest, and that value.

    `seen` (count,) is what they see of the readings. 0 is a dual value, too.
    """
    norms, slack, target = problem.nodes[at.NORM], memory.nodes[at.SLACK], memory.taxels[at.TARGET]
    square, penalty = dot(target, target), problem.numbers[at.PENALTY]
    for i in range(count):
        slack[i] = -penalty * norms[listed[i]]
    length = step_length(slack, seen, count, square, square)
    value = length * (1.0 - 0.5 * length - problem.numbers[at.ROUNDING]) * square
    return length, max(value - excess(norms, listed, count, penalty, seen, length), 0.0)


@inner
def see_all(problem: DualProblem, memory: Memory, values: Floats, least: float) -> None:
    """Write into row `EVERY` (K,) the products of all rows with `values`.

    Where they are below `least` times the row's norm, anything may be written that is below it,
    too, and not below the product: with stamps the bound of what they lack is added, and the
    product itself is computed only where that does not tell.
    """
    every, rows = memory.nodes[at.EVERY], problem.rows
    stamps, places, blocks = problem.stamps, problem.places, len(problem.stamps)
    if blocks == 0:
        project(rows, memory.lists[at.ALL], len(every), values, every)
        return
    tiles = (len(places) - blocks - 1) // 2
    sizes, flat = (int(problem.numbers[at.WIDTH]), 0, 0), memory.taxels[at.SCRATCH]
    take_out(problem.root, values, flat)  # stamps are of the rows before that
    for node in range(len(every)):
        every[node] = 0.0
    for tile in range(blocks, blocks + tiles):
        cell, begin, end = places[tile + tiles + 1], places[tile], places[tile + 1]
        add_tile(stamps, places, flat, every, 0, cell, begin, end, sizes)
    size = np.sqrt(dot(flat, flat))
    for node in range(len(every)):
        every[node] += problem.nodes[at.DROPPED, node] * size
        if every[node] > least * problem.nodes[at.NORM, node]:
            every[node] = product(rows[node], values)


@inner(inline="always")
def list_near(problem: DualProblem, memory: Memory) -> None:
    """List the nodes that row `EVERY` says may carry pressure."""
    count, every, listed = 0, memory.nodes[at.EVERY], memory.lists[at.LISTED]
    least = problem.numbers[at.PENALTY] - MARGIN
    for node in range(len(every)):
        if every[node] > least * problem.nodes[at.NORM, node]:
            listed[count] = node
            count += 1
    memory.lists[at.COUNTS, at.SEARCHED] = count


@inner(inline="always")
def primal(problem: DualProblem, memory: Memory, best: float) -> tuple[float, float, int]:
    """Objective of the best amounts so far, of those at the dual, and how many of these are not 0.

    The latter are also scaled as a whole to where the objective is lowest, and kept if they are
    the best then. Row `ASCENT` becomes the slope of the dual value, readings - predicted - dual.
    """
    lists, counts, slack = memory.lists, memory.lists[at.COUNTS], memory.nodes[at.SLACK]
    listed, active, count = lists[at.LISTED], 0, counts[at.SEARCHED]
    target, dual = memory.taxels[at.TARGET], memory.taxels[at.DUAL]
    predicted, ascent = memory.taxels[at.PREDICTED], memory.taxels[at.ASCENT]
    penalty, norms = problem.numbers[at.PENALTY], problem.nodes[at.NORM]
    project(problem.rows, listed, count, dual, slack)
    square, cost = 0.0, 0.0
    for i in range(count):
        slack[i] -= penalty * norms[listed[i]]
        if slack[i] > 0.0:
            lists[at.ACTIVE, active] = listed[i]
            active += 1
            square += np.float64(slack[i]) * slack[i]
            cost += slack[i] * penalty * norms[listed[i]]
    for taxel in range(len(predicted)):
        predicted[taxel] = 0.0
    add_rows(problem.rows, listed, count, slack, 0.0, 1.0, predicted)
    gain, curve, left = -cost, square, 0.0
    for taxel in range(len(target)):
        there, read = np.float64(predicted[taxel]), np.float64(target[taxel])
        ascent[taxel] = read - there - dual[taxel]
        gain += there * read
        curve += there * there
        left += (read - there) * (read - there)
    factor = max(gain, 0.0) / curve if curve > 0.0 else 0.0
    scaled = 0.5 * dot(target, target) - 0.5 * max(gain, 0.0) * factor
    if scaled < best:
        best, counts[at.PRESSING], active = scaled, active, 0
        for i in range(count):
            if slack[i] > 0.0:
                lists[at.PRESSED, active] = listed[i]
                memory.nodes[at.AMOUNT, active] = factor * slack[i]
                active += 1
    return best, 0.5 * left + 0.5 * square + cost, active


@inner
def dual_value(problem: DualProblem, memory: Memory) -> float:
    """What no answer's objective is below, by a pass over all nodes."""
    counts, numbers, every = memory.lists[at.COUNTS], problem.numbers, memory.nodes[at.EVERY]
    start, target, dual = now_ns(counts), memory.taxels[at.TARGET], memory.taxels[at.DUAL]
    penalty, rounding = numbers[at.PENALTY], numbers[at.ROUNDING]
    see_all(problem, memory, dual, penalty - MARGIN)
    square, spread, pressed = 0.0, 0.0, 0
    for node in range(len(every)):
        norm = np.float64(problem.nodes[at.NORM, node])
        over = every[node] - penalty * norm
        if over > 0.0:
            square += over * over
            spread += over * norm
            pressed += 1
    own = 0.5 * dot(dual, dual)
    rounded = rounding * np.sqrt(own * 0.5 * dot(target, target))
    # and what the objective may be off, as readings are predicted by a sum over pressed nodes
    rounded += rounding / UNITS * np.sqrt(2.0 * own * pressed) * spread
    learn_pace(memory.measures, at.PASS_PACE, now_ns(counts) - start, float(problem.rows.size))
    return float(dot(dual, target) - own - 0.5 * square - rounded)


@inner(inline="always")
def newton(problem: DualProblem, memory: Memory, active: int, anew: bool) -> None:
    """One semismooth Newton step from the dual, to where the dual value is highest along it.

    The step solves (1 + B' B) step = ascent, with the active rows B of now, or of an earlier step
    unless the system should be made `anew`. By nodes, (1 + B' B)^-1 = 1 - B' (1 + B B')^-1 B.
    """
    counts, lists, rows = memory.lists[at.COUNTS], memory.lists, problem.rows
    listed, factored = lists[at.LISTED], lists[at.FACTORED]
    target, dual = memory.taxels[at.TARGET], memory.taxels[at.DUAL]
    ascent = memory.taxels[at.ASCENT]
    step, scratch = memory.taxels[at.STEP], memory.taxels[at.SCRATCH]
    lower = memory.taxels[at.LOWER :]
    turn, width, count = memory.nodes[at.TURN], len(dual), counts[at.SEARCHED]
    if anew or counts[at.FACTORS] == 0:
        for place in range(active):
            factored[place] = lists[at.ACTIVE, place]
        factor_rows(rows, factored, active, width, lower)
        counts[at.FACTORS] = active
    size = counts[at.FACTORS]
    for taxel in range(width):
        step[taxel] = ascent[taxel]
    if size >= width:
        solve_factored(lower, width, step)
    else:
        project(rows, factored, size, ascent, scratch)
        solve_factored(lower, size, scratch)
        add_rows(rows, factored, size, scratch, -np.inf, -1.0, step)
    first, second = 0.0, 0.0
    for taxel in range(width):
        first += step[taxel] * (target[taxel] - dual[taxel])
        second += step[taxel] * step[taxel]
    project(rows, listed, count, step, turn)
    length = step_length(memory.nodes[at.SLACK], turn, count, first, second)
    for taxel in range(width):
        dual[taxel] += length * step[taxel]


@inner
def learn_pace(measures: Floats, which: int, taken: int, work: float) -> None:
    """Take in another measurement of a pace: near the slowest, and in the mean without pauses."""
    last, mean = taken / work, at.TYPICAL + which - at.STEP_PACE
    if measures[which] == 0.0:
        measures[which] = measures[mean] = last
    measures[which] = min(max(last, FASTER * measures[which]), SLOWER * measures[which])
    measures[mean] += SMOOTH * (min(last, 2.0 * measures[mean]) - measures[mean])


@inner
def relax_pace(measures: Floats, which: int) -> None:
    """Let a pace come down to the mean, where it kept something from being tried."""
    mean = at.TYPICAL + which - at.STEP_PACE
    measures[which] = max(FASTER * measures[which], SAFE * measures[mean])
