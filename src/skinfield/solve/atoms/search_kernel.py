"""Search for the atoms of a reading, compiled: what is tried, and what is taken.

The answer of the reading before is refined first. Then atoms are added where the residual is most
significant, those that are not needed go, and their shapes are compared by the marginal likelihood,
one alternative after the other, until the time is up: the next reading goes on with the next one.
"""

from typing import NamedTuple

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.dictionary import StartMemory, Templates, find_starts
from skinfield.solve.atoms.fit_kernel import (
    ALONE,
    BEST,
    LATE,
    LEFT,
    NOW,
    READINGS,
    SCORED,
    SETTLED,
    SHARED,
    STEPS,
    TRIAL,
    WHITE,
    FitMemory,
    FitModel,
    copy_set,
    descend,
    evaluate,
    factor,
    free_system,
    gather,
    is_late,
    is_long,
    reach_of,
)
from skinfield.solve.atoms.table import BALL, FLAT, RING

BURST = 12  # steps of refinement of what is only tried
LONG = 60  # of what is taken
SETTLED_GAIN = 1e-3  # gain in cost of the last step
RARER = np.array([0.0, 1.0, 2.0])  # ln odds of a ball over each family, before any reading
LONGER = 5.0  # ln odds of a round contact over a drawn-out one
LOG_FORCES = np.log(1e4)  # width of what forces may be, on a logarithmic scale
OFF_LATTICE = 2.0  # how much more than the best template an atom between the templates may gain
LENGTHS = np.array([1.2, 3.0])  # half-lengths from which a drawn-out contact is sought, thicknesses
ANGLES = 4
RINGS = np.array([1.0, 1.8, 2.8])  # radii from which a ring is sought, in thicknesses
TRIED = 2  # of the places for a new atom: these are refined together with the others
ODD = 1.0  # standard deviations of chi-squared, above which other shapes are tried
GAP = 3.5  # thicknesses between the rims of atoms that may be one body
BETTER = 0.01  # of cost or evidence: less is no reason, and no tie is left to rounding
CLEAR = 4.0  # times the threshold that an atom far from others brings: it need not be tried without
MANY = 12  # seeds of a shape at most
# Places of `SearchMemory.state`: next alternative, atoms of the last comparison, what was done.
MOVE, COMPARED = 0, 1


class SearchRules(NamedTuple):
    """What a search goes by.

    Attributes
    ----------
    threshold : float
        Gain in cost that a new contact must bring.
    most : int
        Atoms.
    starts : int
        Places from which each new one is sought.
    """

    threshold: float
    most: int
    starts: int


class SearchMemory(NamedTuple):
    """Room of a search beside that of the fit.

    Attributes
    ----------
    starts : StartMemory
    seeds : (MANY, 6) array
    costs : (MANY,) array
        Of the seeds.
    members : (M,) int array
        1 for the atoms in whose place another one is tried.
    owner : (M,) int array
        Number of the body that each atom belongs to.
    state : (4,) int array
    """

    starts: StartMemory
    seeds: Floats
    costs: Floats
    members: Ints
    owner: Ints
    state: Ints

    @classmethod
    def of(cls, bank: Templates, most: int, starts: int) -> "SearchMemory":
        """Room for so many atoms and starts."""
        seeds = max(MANY, starts)
        return cls(
            StartMemory.of(bank, starts),
            np.zeros((seeds, 6)),
            np.zeros(seeds),
            np.zeros(most, np.int64),
            np.zeros(most, np.int64),
            np.zeros(4, np.int64),
        )


@inner
def clear_set(memory: FitMemory, which: int) -> None:
    """Have a set be no contact at all."""
    memory.counts[which] = 0
    readings, white = memory.taxels[READINGS], memory.taxels[WHITE]
    squares, total = 0.0, 0.0
    for taxel in range(len(readings)):
        weight = white[taxel] * white[taxel]
        squares += readings[taxel] * readings[taxel] * weight
        total += readings[taxel] * weight
        memory.predicted[which, taxel] = 0.0
    memory.costs[which] = 0.5 * (squares - memory.sums[SHARED] * total * total)


@inner
def offset_of(memory: FitMemory, which: int) -> float:
    """The offset shared by all taxels that is most probable with a set of atoms."""
    total, predicted = 0.0, memory.predicted[which]
    readings, white = memory.taxels[READINGS], memory.taxels[WHITE]
    for taxel in range(len(readings)):
        total += white[taxel] * white[taxel] * (readings[taxel] - predicted[taxel])
    return memory.sums[SHARED] * total


@inner
def misfit(memory: FitMemory, which: int) -> float:
    """By how many standard deviations the squares of the residuals exceed their number."""
    offset, squares, heard = offset_of(memory, which), 0.0, 0
    readings, white = memory.taxels[READINGS], memory.taxels[WHITE]
    for taxel in range(len(readings)):
        left = readings[taxel] - memory.predicted[which, taxel] - offset
        squares += (left * white[taxel]) ** 2
        heard += white[taxel] > 0.0
    return float((squares - heard) / np.sqrt(2.0 * max(heard, 1)))


@inner
def evidence(model: FitModel, memory: FitMemory, which: int) -> float:
    """Logarithm of the marginal likelihood, up to a constant, by Laplace's approximation.

    Places are uniform over the patch, the force's logarithm over `LOG_FORCES`; the other priors are
    those of the cost.
    """
    count = memory.counts[which]
    if not count:
        return float(-memory.costs[which])
    size, free, determinant = 6 * count, 4 * count, 0.0
    free_system(memory, which, 0, 0.0)
    if not factor(memory.system, size):
        return -np.inf
    for i in range(size):
        determinant += np.log(memory.system[i * size + i])  # 0 of what does not move
    wide = model.places[1, 0] - model.places[0, 0]
    high = model.places[1, 1] - model.places[0, 1]
    known, priors = -count * np.log(wide * high * LOG_FORCES), model.priors
    for n in range(count):
        family = memory.family[which, n]
        std = priors.ball_std if family == BALL else priors.flat_std
        if family == RING:
            std = priors.ring_std
        known -= np.log(std) + 0.5 * np.log(2 * np.pi) + RARER[family]
        if is_long(memory.atoms[which, n]):
            free += 2
            known -= 2 * np.log(priors.length_std) + np.log(2 * np.pi) + LONGER
    return float(-memory.costs[which] + known + 0.5 * free * np.log(2 * np.pi) - determinant)


@inner
def append(memory: FitMemory, which: int, atom: Floats, family: int) -> None:
    """Add an atom to a set; the cost becomes that of other atoms."""
    n = memory.counts[which]
    for i in range(6):
        memory.atoms[which, n, i] = atom[i]
    memory.family[which, n] = family
    memory.counts[which] = n + 1


@inner
def copy_others(memory: FitMemory, search: SearchMemory, source: int, target: int) -> None:
    """Have a set become the atoms of another one that are no members."""
    memory.counts[target] = 0
    for n in range(memory.counts[source]):
        if not search.members[n]:
            append(memory, target, memory.atoms[source, n], memory.family[source, n])


@inner
def leave(model: FitModel, memory: FitMemory, which: int) -> None:
    """Write what a set of atoms leaves to explain, but for a shared offset, into the row LEFT."""
    left = memory.taxels[LEFT]
    if memory.counts[which]:
        gather(model, memory, which, READINGS)
        memory.costs[which] = evaluate(model, memory, which, READINGS)
        for taxel in range(len(left)):
            left[taxel] = memory.taxels[READINGS, taxel] - memory.predicted[which, taxel]
    else:
        for taxel in range(len(left)):
            left[taxel] = memory.taxels[READINGS, taxel]


@inner
def settle(
    model: FitModel, memory: FitMemory, search: SearchMemory, count: int, family: int, deadline: int
) -> int:
    """Refine each of the seeds alone, in place, on the row LEFT; how many the time was enough for.

    One is refined in any case.
    """
    for seed in range(count):
        if seed and is_late(memory, deadline):
            return seed
        memory.counts[ALONE] = 0
        append(memory, ALONE, search.seeds[seed], family)
        descend(model, memory, ALONE, LEFT, 0, BURST, SETTLED_GAIN, deadline)
        search.costs[seed] = memory.costs[ALONE]
        for i in range(6):
            search.seeds[seed, i] = memory.atoms[ALONE, 0, i]
    return count


@inner
def best_seed(search: SearchMemory, count: int) -> int:
    """The seed of the least cost, the first of equal ones; it counts no more then."""
    best = 0
    for seed in range(1, count):
        if search.costs[seed] < search.costs[best] - BETTER:
            best = seed
    search.costs[best] = 1e300
    return best


@inner
def add_one(
    model: FitModel,
    bank: Templates,
    memory: FitMemory,
    search: SearchMemory,
    rules: SearchRules,
    noise: Floats,
    deadline: int,
) -> bool:
    """Make BEST the best set with one more ball than NOW; False where none could bring enough."""
    left, scored = memory.taxels[LEFT], memory.taxels[SCORED]
    offset = offset_of(memory, NOW)
    for taxel in range(len(left)):
        left[taxel] = memory.taxels[READINGS, taxel] - memory.predicted[NOW, taxel]
        heard = memory.taxels[WHITE, taxel] > 0.0
        scored[taxel] = (left[taxel] - offset) / noise[taxel] if heard else 0.0
    least = np.sqrt(2.0 * rules.threshold / OFF_LATTICE)
    count = find_starts(bank, search.starts, scored, rules.starts, least)
    if not count:
        return False
    for seed in range(count):
        for i in range(6):
            search.seeds[seed, i] = search.starts.starts[seed, i]
    count = settle(model, memory, search, count, BALL, deadline)
    for turn in range(min(TRIED, count)):
        chosen = best_seed(search, count)
        copy_set(memory, NOW, TRIAL)
        append(memory, TRIAL, search.seeds[chosen], BALL)
        descend(model, memory, TRIAL, READINGS, 0, LONG, SETTLED_GAIN, deadline)
        if turn == 0 or memory.costs[TRIAL] < memory.costs[BEST] - BETTER:
            copy_set(memory, TRIAL, BEST)
        if is_late(memory, deadline):
            break
    return True


@inner
def middle(memory: FitMemory, search: SearchMemory, which: int, atom: Floats) -> None:
    """Write one atom with the force of the members, amid them."""
    total = 0.0
    for i in range(6):
        atom[i] = 0.0
    for n in range(memory.counts[which]):
        if search.members[n]:
            force = np.exp(memory.atoms[which, n, 2])
            total += force
            for i in range(6):
                atom[i] += force * memory.atoms[which, n, i]
    for i in range(6):
        atom[i] /= total
    atom[2] = np.log(total)


LINE_BALL, LINE_FLAT, A_RING, SWAPPED, ROUND_BALL, ROUND_FLAT, PAIR, KINDS = 0, 1, 2, 3, 4, 5, 6, 7


@inner
def try_shape(
    model: FitModel, memory: FitMemory, search: SearchMemory, kind: int, deadline: int
) -> bool:
    """Make TRIAL the set NOW with another shape in the place of its members; False if too late."""
    copy_others(memory, search, NOW, TRIAL)
    if kind <= A_RING:
        leave(model, memory, TRIAL)
        seeds, family = search.seeds, RING if kind == A_RING else BALL
        if kind == LINE_FLAT:
            family = FLAT
        middle(memory, search, NOW, seeds[0])
        count = len(RINGS) if kind == A_RING else len(LENGTHS) * ANGLES
        for seed in range(count - 1, -1, -1):
            for i in range(4):
                seeds[seed, i] = seeds[0, i]
            if kind == A_RING:
                seeds[seed, 3], seeds[seed, 4], seeds[seed, 5] = np.log(RINGS[seed]), 0.0, 0.0
            else:
                length, angle = LENGTHS[seed // ANGLES], (seed % ANGLES) * np.pi / ANGLES
                seeds[seed, 3] = min(seeds[seed, 3], 0.0)
                seeds[seed, 4], seeds[seed, 5] = length * np.cos(angle), length * np.sin(angle)
        count = settle(model, memory, search, count, family, deadline)
        copy_others(memory, search, NOW, TRIAL)
        append(memory, TRIAL, seeds[best_seed(search, count)], family)
    else:
        n = 0
        while not search.members[n]:
            n += 1
        atom, family = memory.atoms[NOW, n], memory.family[NOW, n]
        if kind == SWAPPED:
            append(memory, TRIAL, atom, BALL + FLAT - family)
        elif kind == PAIR:
            for side in (0.7, -0.7):
                append(memory, TRIAL, atom, BALL)
                its = memory.atoms[TRIAL, memory.counts[TRIAL] - 1]
                its[0] += side * its[4]
                its[1] += side * its[5]
                its[2] -= np.log(2.0)
                its[4], its[5] = 0.0, 0.0
        else:
            append(memory, TRIAL, atom, BALL if kind == ROUND_BALL else FLAT)
            its = memory.atoms[TRIAL, memory.counts[TRIAL] - 1]
            its[4], its[5] = 0.0, 0.0
    descend(model, memory, TRIAL, READINGS, 0, LONG, SETTLED_GAIN, deadline)
    return memory.marks[SETTLED] == 1


@inner
def mark_one(memory: FitMemory, search: SearchMemory, index: int) -> None:
    """Have one atom of NOW be the only member."""
    for n in range(memory.counts[NOW]):
        search.members[n] = n == index


@inner
def apart(memory: FitMemory, which: int, one: int, other: int) -> float:
    """Distance of the rims of two atoms, in thicknesses."""
    a, b = memory.atoms[which, one], memory.atoms[which, other]
    rims = np.exp(a[3]) + np.hypot(a[4], a[5]) + np.exp(b[3]) + np.hypot(b[4], b[5])
    return float(np.hypot(a[0] - b[0], a[1] - b[1]) - rims)


@inner
def grow(
    model: FitModel,
    bank: Templates,
    memory: FitMemory,
    search: SearchMemory,
    rules: SearchRules,
    noise: Floats,
    deadline: int,
) -> bool:
    """Make NOW one with one more ball, or with another shape, whichever is more probable, if any.

    Other shapes are tried of those atoms that the new one is near to.
    """
    before = memory.counts[NOW]
    if not add_one(model, bank, memory, search, rules, noise, deadline):
        return False
    if not memory.costs[NOW] - memory.costs[BEST] >= rules.threshold:
        return False
    known = evidence(model, memory, BEST)
    last = memory.counts[BEST] - 1
    for index in range(before):
        if is_long(memory.atoms[NOW, index]) or memory.family[NOW, index] == RING:
            continue
        if memory.counts[BEST] == before + 1 and apart(memory, BEST, index, last) > GAP:
            continue
        for kind in range(A_RING + 1):
            mark_one(memory, search, index)
            if is_late(memory, deadline) or not try_shape(model, memory, search, kind, deadline):
                break
            value = evidence(model, memory, TRIAL)
            if value > known + BETTER:
                copy_set(memory, TRIAL, BEST)
                known = value
    copy_set(memory, BEST, NOW)
    return True


@inner
def worth(memory: FitMemory, model: FitModel, index: int) -> float:
    """Cost that one atom of NOW saves where the others stay; it is less where they may move."""
    memory.counts[ALONE] = 0
    append(memory, ALONE, memory.atoms[NOW, index], memory.family[NOW, index])
    gather(model, memory, ALONE, LEFT)
    evaluate(model, memory, ALONE, LEFT)
    readings, white = memory.taxels[READINGS], memory.taxels[WHITE]
    squares, total, other = 0.0, 0.0, 0.0
    for taxel in range(len(readings)):
        weight, its = white[taxel] * white[taxel], memory.predicted[ALONE, taxel]
        left = readings[taxel] - memory.predicted[NOW, taxel]
        squares += weight * its * (2.0 * left + its)
        total += weight * left
        other += weight * (left + its)
    return 0.5 * (squares - memory.sums[SHARED] * (other * other - total * total))


@inner
def prune(
    model: FitModel,
    memory: FitMemory,
    search: SearchMemory,
    rules: SearchRules,
    thorough: bool,
    deadline: int,
) -> None:
    """Take away the atoms of NOW that the reading does not need.

    With `thorough`, those that others could replace are tried without, too.
    """
    index = 0
    while index < memory.counts[NOW] and not is_late(memory, deadline):
        near = memory.counts[NOW] > 1 and thorough
        if near:
            near = False
            for other in range(memory.counts[NOW]):
                near = near or (other != index and apart(memory, NOW, index, other) < GAP)
        if not near and worth(memory, model, index) > CLEAR * rules.threshold:
            index += 1
            continue
        mark_one(memory, search, index)
        copy_others(memory, search, NOW, TRIAL)
        if memory.counts[TRIAL]:
            descend(model, memory, TRIAL, READINGS, 0, LONG, SETTLED_GAIN, deadline)
        else:
            clear_set(memory, TRIAL)
        if memory.costs[TRIAL] - memory.costs[NOW] < rules.threshold:
            copy_set(memory, TRIAL, NOW)
            index = 0
        else:
            index += 1


@inner
def bodies(memory: FitMemory, search: SearchMemory) -> None:
    """Number the bodies of NOW: atoms whose rims are near, directly or through others."""
    for i in range(memory.counts[NOW]):
        search.owner[i] = i
        for j in range(i):
            if apart(memory, NOW, i, j) < GAP:
                old, new = search.owner[i], search.owner[j]
                for k in range(i + 1):
                    if search.owner[k] == old:
                        search.owner[k] = new


@inner
def applies(memory: FitMemory, index: int, kind: int, odd: bool) -> bool:
    """Whether a shape is an alternative to that of an atom of NOW."""
    long, ring = is_long(memory.atoms[NOW, index]), memory.family[NOW, index] == RING
    if kind <= A_RING:
        return bool(odd and not long and not ring)
    if kind == SWAPPED:
        return not ring
    if kind == PAIR:
        return bool(long)
    return bool(long or ring)


@inner
def compare_shapes(
    model: FitModel,
    memory: FitMemory,
    search: SearchMemory,
    rules: SearchRules,
    deadline: int,
) -> bool:
    """Try the alternatives that are left, each in its turn; whether all were tried.

    First those of each atom, in the order of `KINDS`, then one body in the place of several.
    """
    state = search.state
    odd, known = misfit(memory, NOW) > ODD, evidence(model, memory, NOW)
    while True:
        count = memory.counts[NOW]
        index, kind = state[MOVE] // KINDS, state[MOVE] % KINDS
        if index >= 2 * count:
            return True
        mark_one(memory, search, index)
        due = index < count and applies(memory, index, kind, odd)
        if due and kind == PAIR:
            due = count < rules.most
        if index >= count and kind <= A_RING:
            bodies(memory, search)
            members = 0
            for n in range(count):
                search.members[n] = search.owner[n] == index - count
                members += search.members[n]
            due = members > 1
        if due:
            if is_late(memory, deadline) or not try_shape(model, memory, search, kind, deadline):
                return False
            value = evidence(model, memory, TRIAL)
            if value > known + BETTER:
                copy_set(memory, TRIAL, NOW)
                odd, known = misfit(memory, NOW) > ODD, value
                state[MOVE] = 0  # all anew: the order of the atoms is another one, too
                continue
        state[MOVE] += 1


@njit
def search_atoms(
    model: FitModel,
    bank: Templates,
    memory: FitMemory,
    search: SearchMemory,
    rules: SearchRules,
    noise: Floats,
    shapes: bool,
    deadline: int,
) -> bool:
    """Find the atoms of the row READINGS, from those of NOW on; whether all was tried.

    Parameters
    ----------
    model : FitModel
    bank : Templates
    memory : FitMemory
        With readings and weights; its set NOW becomes the answer.
    search : SearchMemory
    rules : SearchRules
    noise : (L,) array
        By which the dictionary was whitened.
    shapes : bool
        Whether to compare all shapes anew.
    deadline : int, ns
        Of the clock; 0 for none.
    """
    memory.marks[LATE] = memory.marks[STEPS] = 0
    before = memory.counts[NOW]
    if before:
        descend(model, memory, NOW, READINGS, 0, BURST, SETTLED_GAIN, deadline)
        prune(model, memory, search, rules, shapes, deadline)
    else:
        clear_set(memory, NOW)
    if not memory.counts[NOW]:
        clear_set(memory, NOW)
    grew = False
    while memory.counts[NOW] < rules.most and not is_late(memory, deadline):
        if not grow(model, bank, memory, search, rules, noise, deadline):
            break
        grew = True
    if grew:
        prune(model, memory, search, rules, True, deadline)
    if shapes or grew or memory.counts[NOW] != search.state[COMPARED]:
        search.state[MOVE] = 0
    search.state[COMPARED] = memory.counts[NOW]
    done = compare_shapes(model, memory, search, rules, deadline)
    search.state[COMPARED] = memory.counts[NOW]
    return done and memory.marks[LATE] == 0
