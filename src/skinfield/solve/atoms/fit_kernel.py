"""Least squares of atoms, compiled: costs and their refinement.

The cost is half the sum of squares of the whitened residuals and of the priors: for a ball, a
normal one on the logarithm of its radius of curvature, which force and contact radius give; for a
flat end or a ring, on that of its radius; and for all, on the half-length. An offset that all
taxels share is integrated out, as its prior is normal and it enters linearly.
"""

from typing import NamedTuple

import numpy as np

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.atom_readings import (
    PARAMETERS,
    TableRoom,
    add_atom,
    along,
    free_of,
    is_sheared,
    parameter_of,
)
from skinfield.solve.atoms.cholesky_kernel import factor, solve_factored
from skinfield.solve.atoms.table import Tables
from skinfield.solve.clock import now_ns


class Priors(NamedTuple):
    """What is known of contacts before any reading; lengths in thicknesses.

    `ball_log` and `ball_std` are of ln(radius of curvature/m), the others of ln(radius/thickness);
    `length_std` is of each component of the half-length, `shear_std` of each of the force along the
    skin over that into it.
    """

    ball_log: float
    ball_std: float
    flat_log: float
    flat_std: float
    ring_log: float
    ring_std: float
    length_std: float
    shear_std: float


class FitModel(NamedTuple):
    """All that needs no reading; lengths in thicknesses.

    Attributes
    ----------
    taxels : (L, 2) array
    tables : Tables
    priors : Priors
    places : (2, 2) array
        Lowest and highest x and y that atoms may have.
    """

    taxels: Floats
    tables: Tables
    priors: Priors
    places: Floats


# Rows of `FitMemory.taxels`.
READINGS, WHITE, LEFT, SCORED, DEVIATION, TRIED_WEIGHT, ROWS = 0, 1, 2, 3, 4, 5, 6
# Sets of atoms: the answer, one that is tried, the best of those, a step, a single atom.
NOW, TRIAL, BEST, STEP, ALONE, SETS = 0, 1, 2, 3, 4, 5
# Places of `FitMemory.sums`: of taxels that are not near, and of the offset that all share; and how
# long it takes, ns: a step, and the model error, per atom; what is left over scored, and searched;
# and templates around an atom listed, and some of their pairs compared.
REST_COST, REST_TOTAL, SHARED, PACE, INFERRING, SCORING, SEEDING, LISTING, SCANNING = range(9)
# Places of `FitMemory.marks`, the first two of which are the clock's. MOST: steps in all, and
# PAUSE: before a pause; 0 for any.
NEAR, SETTLED, STEPS, LATE, BEGAN, STEPPED, MOST, PAUSE = range(2, 10)


class FitMemory(NamedTuple):
    """What lasts from reading to reading, and room to work in, for M atoms at most.

    Attributes
    ----------
    taxels : (6, L) array
        Readings, one over their deviations, what is left of readings, what is scored; and, while
        the model error is inferred, deviations without it, and weights that are tried.
    atoms : (sets, M, 8) array
    family : (sets, M) int array
    counts : (sets,) int array
    costs : (sets,) array
        Half the whitened squares of residuals and priors.
    predicted : (sets, L) array
    gradient : (sets, 8 M) array
    hessian : (sets, 64 M M) array
        Of N atoms the first 64 N N numbers, (8 N, 8 N) row by row.
    jacobian : (8 M, L) array
        Of the taxels in `near`, one row per parameter.
    span : (M, 2) int array
        First of these that reads each atom, and the one after the last.
    listed : (4, L) array
        Of these, weights; and room.
    free : (8 M,) int array
        Parameters that move.
    steps : (3, 8 M) array
    system : (64 M M,) array
    near : (L,) int array
        Taxels that some atom may be read by.
    around : (M, 3) array
        Circles within which atoms are read by those alone.
    sums : (9,) array
    marks : (16,) int array
    room : TableRoom
    """

    taxels: Floats
    atoms: Floats
    family: Ints
    counts: Ints
    costs: Floats
    predicted: Floats
    gradient: Floats
    hessian: Floats
    jacobian: Floats
    span: Ints
    listed: Floats
    free: Ints
    steps: Floats
    system: Floats
    near: Ints
    around: Floats
    sums: Floats
    marks: Ints
    room: TableRoom

    @classmethod
    def of(cls, model: FitModel, most: int) -> "FitMemory":
        """Room for so many atoms."""
        taxels, size = len(model.taxels), PARAMETERS * most
        sums = np.zeros(SCANNING + 1)
        sums[PACE:] = FIRST_PACE
        sums[INFERRING:] *= 5.0
        return cls(
            taxels=np.zeros((ROWS, taxels)),
            atoms=np.zeros((SETS, most, PARAMETERS)),
            family=np.zeros((SETS, most), np.int64),
            counts=np.zeros(SETS, np.int64),
            costs=np.zeros(SETS),
            predicted=np.zeros((SETS, taxels)),
            gradient=np.zeros((SETS, size)),
            hessian=np.zeros((SETS, size * size)),
            jacobian=np.zeros((size, taxels)),
            span=np.zeros((most, 2), np.int64),
            listed=np.zeros((4, taxels)),
            free=np.zeros(size, np.int64),
            steps=np.zeros((3, size)),
            system=np.zeros(size * size),
            near=np.zeros(taxels, np.int64),
            around=np.zeros((most, 3)),
            sums=sums,
            marks=np.zeros(16, np.int64),
            room=TableRoom.of(model.tables),
        )


FIRST_PACE = 2000.0  # ns: a step takes about so long per atom
FASTER, SLOWER = 0.98, 1.2  # how far one piece may move what is known of that: nearly the slowest
STALLED, SLIGHTLY = 2.0, 1.02  # times: that it took so long moves it by little
SHORTER = 0.995  # what is taken for that after the time was too short
FAST = {"reassoc", "contract", "nsz"}  # sums in any order; infinities stay what they are
ROAM = 2.0  # thicknesses that an atom may move, or grow, before other taxels are looked at
FEW = 24  # taxels: so few are looked at in any case


@inner(forceinline=True, _nrt=False)
def reach_of(atom: Floats, tables: Tables) -> float:
    """How far from its middle an atom is read, in thicknesses."""
    return float(np.exp(atom[3]) + np.hypot(atom[4], atom[5]) + tables.pad_radius + tables.sight)


@inner(_nrt=False)
def gather(model: FitModel, memory: FitMemory, which: int, row: int) -> None:
    """List the taxels near a set of atoms; what the others add to the cost of reading nothing."""
    count, atoms, near = memory.counts[which], memory.atoms[which], memory.near
    readings, white = memory.taxels[row], memory.taxels[WHITE]
    for n in range(count):
        around = memory.around[n]
        around[0], around[1] = atoms[n, 0], atoms[n, 1]
        around[2] = reach_of(atoms[n], model.tables) + ROAM
    listed, cost, total, taxels = 0, 0.0, 0.0, len(readings)
    for taxel in range(taxels):
        seen = taxels <= FEW
        for n in range(count):
            x, y = model.taxels[taxel, 0], model.taxels[taxel, 1]
            x, y, reach = x - memory.around[n, 0], y - memory.around[n, 1], memory.around[n, 2]
            seen = seen or x * x + y * y < reach * reach
        if seen:
            near[listed] = taxel
            listed += 1
        else:
            weight = white[taxel] * white[taxel]
            cost += 0.5 * readings[taxel] * readings[taxel] * weight
            total += readings[taxel] * weight
    memory.marks[NEAR] = listed
    memory.sums[REST_COST], memory.sums[REST_TOTAL] = cost, total


@inner(_nrt=False)
def roamed(model: FitModel, memory: FitMemory, which: int) -> bool:
    """Whether an atom may be read by taxels that are not listed."""
    if len(model.taxels) <= FEW:
        return False
    for n in range(memory.counts[which]):
        atom, around = memory.atoms[which, n], memory.around[n]
        off = np.hypot(atom[0] - around[0], atom[1] - around[1])
        if off + reach_of(atom, model.tables) > around[2]:
            return True
    return False


@inner(_nrt=False)
def add_prior(
    n: int, atom: Floats, family: int, model: FitModel, gradient: Floats, hessian: Floats, size: int
) -> float:
    """Cost of the n-th atom's prior; adds to the gradient (size,) and the Hessian (size size,)."""
    tables, priors, first = model.tables, model.priors, PARAMETERS * n
    if family == 0:
        place = (atom[3] - tables.first_log) / tables.log_step
        value, slope = along(tables.curvature, place)
        slope /= tables.log_step
        off = (value - atom[2] - priors.ball_log) / priors.ball_std
        by_force, by_radius = -1.0 / priors.ball_std, slope / priors.ball_std
    else:
        middle, std = priors.flat_log, priors.flat_std
        if family == 2:
            middle, std = priors.ring_log, priors.ring_std
        off = (atom[3] - middle) / std
        by_force, by_radius = 0.0, 1.0 / std
    force, radius = first + 2, first + 3
    gradient[force] += off * by_force
    gradient[radius] += off * by_radius
    hessian[force * size + force] += by_force * by_force
    hessian[force * size + radius] += by_force * by_radius
    hessian[radius * size + force] += by_force * by_radius
    hessian[radius * size + radius] += by_radius * by_radius
    cost = 0.5 * off * off
    weight = 1.0 / (priors.length_std * priors.length_std)
    for k in range(4, 6):
        gradient[first + k] += atom[k] * weight
        hessian[(first + k) * size + first + k] += weight
        cost += 0.5 * atom[k] * atom[k] * weight
    if is_sheared(atom):
        weight = 1.0 / (priors.shear_std * priors.shear_std)
        for k in range(6, 8):
            gradient[first + k] += atom[k] * weight
            hessian[(first + k) * size + first + k] += weight
            cost += 0.5 * atom[k] * atom[k] * weight
    return float(cost)


@inner(fastmath=FAST, _nrt=False)
def four_products(rows: Floats, weighted: Floats, out: Floats) -> None:
    """Write the products of the first four rows (4, N) with some numbers (N,)."""
    one, two, three, four = rows[0], rows[1], rows[2], rows[3]
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    for k in range(len(weighted)):
        a += one[k] * weighted[k]
        b += two[k] * weighted[k]
        c += three[k] * weighted[k]
        d += four[k] * weighted[k]
    out[0], out[1], out[2], out[3] = a, b, c, d


@inner(fastmath=FAST, _nrt=False)
def product(one: Floats, other: Floats) -> float:
    """Sum of the products of two vectors (N,)."""
    total = 0.0
    for k in range(len(one)):
        total += one[k] * other[k]
    return total


@inner(fastmath=FAST, _nrt=False)
def take_weighted(one: Floats, weight: Floats, out: Floats) -> float:
    """Write weighted numbers (N,); their sum."""
    total = 0.0
    for k in range(len(out)):
        out[k] = one[k] * weight[k]
        total += out[k]
    return total


@inner(_nrt=False)
def take_squares(memory: FitMemory, which: int, matrix: Floats, sums: Floats) -> None:
    """Write J' W J of a set, its lower triangle, with the weights of the listed taxels.

    J are the slopes by all parameters of what the taxels read, and `sums` (8 N,) the 1' W J.
    """
    count, jacobian, span = memory.counts[which], memory.jacobian, memory.span
    size = PARAMETERS * count
    for i in range(size * size):
        matrix[i] = 0.0
    for n in range(count):
        first, after = span[n, 0], max(span[n, 1], span[n, 0])
        weight, weighted = memory.listed[0, first:after], memory.listed[3, first:after]
        for i in range(PARAMETERS * n, PARAMETERS * n + PARAMETERS):
            sums[i] = 0.0
        for each in range(free_of(memory.atoms[which, n])):
            i = PARAMETERS * n + parameter_of(memory.atoms[which, n], each)
            sums[i] = take_weighted(jacobian[i, first:after], weight, weighted)
            for m in range(n + 1):
                low, high = max(first, span[m, 0]), min(after, span[m, 1])
                if low >= high:
                    continue
                its = memory.listed[3, low:high]
                column = PARAMETERS * m
                at = i * size + column
                four_products(jacobian[column : column + 4, low:high], its, matrix[at : at + 4])
                for other in range(4, free_of(memory.atoms[which, m])):
                    k = parameter_of(memory.atoms[which, m], other)
                    matrix[at + k] = product(jacobian[column + k, low:high], its)


@inner(_nrt=False)
def take_slopes(model: FitModel, memory: FitMemory, which: int) -> None:
    """Write what a set of atoms is read as, and its slopes at the listed taxels."""
    predicted, near = memory.predicted[which], memory.near[: memory.marks[NEAR]]
    for taxel in range(len(predicted)):
        predicted[taxel] = 0.0
    for n in range(memory.counts[which]):
        memory.span[n, 0], memory.span[n, 1] = add_atom(
            n,
            memory.atoms[which, n],
            memory.family[which, n],
            model.taxels,
            near,
            model.tables,
            memory.room,
            predicted,
            memory.jacobian,
        )


@inner(_nrt=False)
def evaluate(model: FitModel, memory: FitMemory, which: int, row: int) -> float:
    """Cost of a set of atoms for a row of readings; its gradient and Hessian are written."""
    count = memory.counts[which]
    size, listed, shared = PARAMETERS * count, memory.listed, memory.sums[SHARED]
    gradient, hessian, sums = memory.gradient[which], memory.hessian[which], memory.steps[2]
    readings, white, predicted = memory.taxels[row], memory.taxels[WHITE], memory.predicted[which]
    take_slopes(model, memory, which)
    cost, total = memory.sums[REST_COST], memory.sums[REST_TOTAL]
    for k in range(memory.marks[NEAR]):
        taxel = memory.near[k]
        weight, residual = white[taxel] * white[taxel], readings[taxel] - predicted[taxel]
        listed[0, k], listed[1, k] = weight, weight * residual
        cost += 0.5 * residual * listed[1, k]
        total += listed[1, k]
    take_squares(memory, which, hessian, sums)
    cost -= 0.5 * shared * total * total
    for n in range(count):
        first, after = memory.span[n, 0], max(memory.span[n, 1], memory.span[n, 0])
        weighted = listed[1, first:after]
        for i in range(PARAMETERS * n, PARAMETERS * n + PARAMETERS):
            gradient[i] = 0.0
        for each in range(free_of(memory.atoms[which, n])):
            i = PARAMETERS * n + parameter_of(memory.atoms[which, n], each)
            slope = product(memory.jacobian[i, first:after], weighted)
            gradient[i] = shared * sums[i] * total - slope
            for j in range(i + 1):
                value = hessian[i * size + j] - shared * sums[i] * sums[j]
                hessian[i * size + j] = value
                hessian[j * size + i] = value
    for n in range(count):
        atom, family = memory.atoms[which, n], memory.family[which, n]
        cost += add_prior(n, atom, family, model, gradient, hessian, size)
    return float(cost)


LOWEST_LOG, HIGHEST_LOG = np.log(0.18), np.log(7.0)  # of radius/thickness
DEEPEST, ROUND = 0.93, 1e-6  # strain of the gap at the axis; half-length of what is round
SHEAR_STD = 0.35  # of each component of the force along the skin over that into it
STEEPEST = 1.5  # force along the skin over that into it
RISE, FALL = 4.0, 0.2  # of the damping, after a step that failed, and at least where one did not
FIRST_DAMPING, CAREFUL = 1e-3, 0.03  # and at least after a step that failed
FORESEEN = 0.3  # of the gain of the last step: less is not worth one
LONGEST_STEP = 1.0  # of any parameter: thicknesses, or e-foldings


@inner(_nrt=False)
def hold(model: FitModel, atoms: Floats, family: Ints, count: int) -> None:
    """Bring atoms back to the patch and what is tabulated; what shrank to no length is round."""
    tables, places = model.tables, model.places
    for n in range(count):
        half = np.hypot(atoms[n, 4], atoms[n, 5])
        if half < ROUND:
            atoms[n, 4] = atoms[n, 5] = half = 0.0
        for axis in range(2):
            atoms[n, axis] = min(max(atoms[n, axis], places[0, axis]), places[1, axis])
        atoms[n, 3] = min(max(atoms[n, 3], LOWEST_LOG), HIGHEST_LOG)
        atoms[n, 2] = min(max(atoms[n, 2], -20.0), 12.0)
        ratio = np.hypot(atoms[n, 6], atoms[n, 7])
        if ratio > STEEPEST:
            atoms[n, 6], atoms[n, 7] = (
                atoms[n, 6] * STEEPEST / ratio,
                atoms[n, 7] * STEEPEST / ratio,
            )
        if tables.strain.shape[0]:
            place = (atoms[n, 3] - tables.first_log) / tables.log_step
            scale = along(tables.strain[family[n]], place)[0]
            thin = 1.0 + 4.0 * half / (np.pi * np.exp(atoms[n, 3]))
            atoms[n, 2] = min(atoms[n, 2], np.log(DEEPEST * thin) - scale)


@inner(_nrt=False)
def free_system(memory: FitMemory, which: int, hessian: Floats, held: int, damping: float) -> int:
    """Write a damped Hessian, of what moves, into `system`, its lower triangle; of what size.

    Of every atom the first `held` parameters do not move, nor the half-length of round ones,
    nor the shear of those without; `free` lists the others.
    """
    size, count, free = 0, memory.counts[which], memory.free
    system = memory.system
    for n in range(count):
        for k in range(held, free_of(memory.atoms[which, n])):
            free[size] = PARAMETERS * n + parameter_of(memory.atoms[which, n], k)
            size += 1
    for i in range(size):
        for j in range(i + 1):
            system[i * size + j] = hessian[free[i] * PARAMETERS * count + free[j]]
        system[i * size + i] += damping * system[i * size + i] + 1e-9
    return size


@inner(_nrt=False)
def damped_step(memory: FitMemory, which: int, held: int, damping: float) -> bool:
    """Write Levenberg's step into `steps[0]`; False where there is none."""
    size = free_system(memory, which, memory.hessian[which], held, damping)
    step, right = memory.steps[0], memory.steps[1]
    for i in range(size):
        right[i] = -memory.gradient[which, memory.free[i]]
    if not factor(memory.system, size):
        return False
    solve_factored(memory.system, size, right)
    for i in range(PARAMETERS * memory.counts[which]):
        step[i] = 0.0
    for i in range(size):
        step[memory.free[i]] = right[i]
    return True


@inner(_nrt=False)
def copy_set(memory: FitMemory, source: int, target: int) -> None:
    """Have a set become another one, with all that is known of it."""
    count = memory.counts[source]
    size = PARAMETERS * count
    memory.counts[target], memory.costs[target] = count, memory.costs[source]
    for n in range(count):
        memory.family[target, n] = memory.family[source, n]
        for i in range(PARAMETERS):
            memory.atoms[target, n, i] = memory.atoms[source, n, i]
    for taxel in range(memory.predicted.shape[1]):
        memory.predicted[target, taxel] = memory.predicted[source, taxel]
    for i in range(size):
        memory.gradient[target, i] = memory.gradient[source, i]
    for i in range(size * size):
        memory.hessian[target, i] = memory.hessian[source, i]


@inner(_nrt=False)
def nearly_slowest(known: float, took: float, faster: float) -> float:
    """What is known of how long something takes, after it took so long once more.

    Where it took several times as long, the machine did something else meanwhile.
    """
    most = SLOWER if took < STALLED * known else SLIGHTLY
    return min(max(took, faster * known), most * known)


@inner(_nrt=False)
def take_pace(memory: FitMemory, piece: int, times: int) -> None:
    """Learn how long a piece of work takes, so many times, that began at BEGAN and ends now."""
    now = now_ns(memory.marks)
    took = (now - memory.marks[BEGAN]) / times
    memory.sums[piece] = nearly_slowest(memory.sums[piece], took, FASTER)
    memory.marks[BEGAN], memory.marks[STEPPED] = now, 0


@inner(_nrt=False)
def is_short(memory: FitMemory, piece: int, times: int, deadline: int) -> bool:
    """Whether a piece of work, so many times, may end after a time of the clock, 0 for none.

    How long it takes is learnt from those before: nearly the slowest of late. What never fits is
    tried all the same one day.
    """
    if memory.marks[LATE]:
        return True
    memory.marks[BEGAN], memory.marks[STEPPED] = now_ns(memory.marks), 0
    if deadline and memory.marks[BEGAN] + int(memory.sums[piece] * times) > deadline:
        memory.marks[LATE] = 1
        memory.sums[piece] *= SHORTER
    return bool(memory.marks[LATE])


@inner(_nrt=False)
def is_late(memory: FitMemory, which: int, deadline: int) -> bool:
    """Whether a step of a set may end after a time of the clock, or is one too many."""
    steps = memory.marks[STEPS]
    if steps >= memory.marks[MOST] > 0 or steps >= memory.marks[PAUSE] > 0:
        memory.marks[LATE] = 1
        return True
    if deadline == 0:
        return False
    times = max(memory.counts[which], 1)
    if memory.marks[STEPPED]:
        take_pace(memory, PACE, times)
    return is_short(memory, PACE, times, deadline)


@inner(_nrt=False)
def descend(
    model: FitModel,
    memory: FitMemory,
    which: int,
    row: int,
    held: int,
    steps: int,
    tolerance: float,
    deadline: int,
) -> None:
    """Move a set to the next minimum of its cost, by one of Levenberg's steps or till a deadline.

    Parameters
    ----------
    which : int
        Set of atoms.
    row : int
        Of the readings that it shall explain.
    held : int
        Parameters of each atom, the first ones, that do not move.
    steps : int
        That are tried at most.
    tolerance : float
        Gain of the last one.
    deadline : int, ns
    """
    count, step = memory.counts[which], memory.steps[0]
    size, atoms, family = PARAMETERS * count, memory.atoms[which], memory.family[which]
    hold(model, atoms, family, count)
    gather(model, memory, which, row)
    memory.costs[which] = evaluate(model, memory, which, row)
    memory.counts[STEP] = count
    for n in range(count):
        memory.family[STEP, n] = family[n]
    damping, rise = FIRST_DAMPING, RISE
    memory.marks[SETTLED] = memory.marks[STEPPED] = 0
    if deadline:
        memory.marks[BEGAN] = now_ns(memory.marks)
    for taken in range(steps):
        if taken and is_late(memory, which, deadline):
            return
        memory.marks[STEPPED] = 1
        if not damped_step(memory, which, held, damping):
            damping, rise = damping * rise, 2.0 * rise
            if damping > 1e8:
                break
            continue
        longest, downhill, held_back = 1e-300, 0.0, 0.0
        for i in range(size):
            longest = max(longest, abs(step[i]))
            downhill -= memory.gradient[which, i] * step[i]
            held_back += memory.hessian[which, i * size + i] * step[i] * step[i]
        share = min(1.0, LONGEST_STEP / longest)
        expected = share * (downhill - 0.5 * share * (downhill - damping * held_back))
        if expected < FORESEEN * tolerance and damping <= FIRST_DAMPING:
            break
        for n in range(count):
            for i in range(PARAMETERS):
                memory.atoms[STEP, n, i] = atoms[n, i] + share * step[PARAMETERS * n + i]
        hold(model, memory.atoms[STEP], family, count)
        memory.marks[STEPS] += 1
        if roamed(model, memory, STEP):
            gather(model, memory, STEP, row)
        memory.costs[STEP] = evaluate(model, memory, STEP, row)
        gain = memory.costs[which] - memory.costs[STEP]
        if gain > 0.0:
            copy_set(memory, STEP, which)
            off = 2.0 * gain / expected - 1.0 if expected > 0.0 else 1.0
            damping, rise = max(damping * max(1.0 - off * off * off, FALL), 1e-9), RISE
        else:
            damping, rise = max(damping * rise, CAREFUL), 2.0 * rise
        if 0.0 < gain < tolerance or (gain <= 0.0 and (longest < 1e-6 or damping > 1e8)):
            break
    memory.marks[SETTLED] = 1
