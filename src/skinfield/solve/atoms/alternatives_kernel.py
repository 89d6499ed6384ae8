"""Alternatives to a set of atoms, compiled: their evidence, places and shapes to try instead."""

from typing import NamedTuple

import numpy as np

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.atom_readings import PARAMETERS, is_long, is_sheared
from skinfield.solve.atoms.cholesky_kernel import factor
from skinfield.solve.atoms.dictionary import StartMemory, Templates
from skinfield.solve.atoms.fit_kernel import (
    ALONE,
    LEFT,
    NOW,
    READINGS,
    SCORED,
    SHARED,
    TRIAL,
    WHITE,
    FitMemory,
    FitModel,
    free_system,
)
from skinfield.solve.atoms.posterior_kernel import (
    RARER,
)
from skinfield.solve.atoms.table import BALL, FLAT, RING

LONGER = 5.0  # ln odds of a round contact over a drawn-out one
PUSHED = 2.0  # ln odds of a contact that only presses over one that pushes along the skin, too
FAINT_PUSH = 1e-3  # of the force, from which a push is sought
LOG_FORCES = np.log(1e4)  # width of what forces may be, on a logarithmic scale
LENGTHS = np.array([1.2, 3.0])  # half-lengths from which a drawn-out contact is sought, thicknesses
ANGLES = 4
RINGS = np.array([1.0, 1.8, 2.8])  # radii from which a ring is sought, in thicknesses
ODD = 1.0  # standard deviations of chi-squared, above which other shapes are tried
GAP = 3.5  # thicknesses between the rims of atoms that may be one body
BETTER = 0.01  # of cost or evidence: less is no reason, and no tie is left to rounding
FINALISTS = 3  # of the seeds, which are refined on
MANY = 12  # seeds of a shape at most

# Stages: the answer of the reading before; what each of its atoms is worth, and the set without it;
# places for a new one, each of them alone, and the best with the others; shapes that would do as
# well as one more; the atoms beside a shape that is tried, and all with it; shapes of the answer;
# what is open about each atom, and the places of a walk.
(
    REFINE,
    PRUNE,
    WITHOUT,
    GROW,
    SEEDS,
    JOIN,
    RIVALS,
    OTHERS,
    SHAPE,
    SHAPES,
    BELIEVE,
    APART,
    WALK,
    DONE,
) = range(14)
# Places of `SearchMemory.state`: next alternative, atoms at the last comparison, and of this search
# the stage, an atom and a shape of it, the seed, how many and of which family, places that were
# tried, whether atoms were added, whether a rival of theirs is sought, whether BEST is a better set
# than NOW, whether all shapes are due, places of a walk, when the time is up, the set that was
# being refined then, or -1, the atom that is explored first; on how
# many readings the set was refined so far; and whether the search went on from another reading.
(
    MOVE,
    COMPARED,
    STAGE,
    INDEX,
    KIND,
    SEED,
    COUNT,
    OF,
    TRIED,
    GREW,
    RIVAL,
    FOUND,
    DUE,
    PLACES_LEFT,
    UNTIL,
    REFINED,
    FIRST_OPEN,
    CARRIED,
    RESUMED,
) = range(19)


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
    purpose : int
        SEEK atoms, or EXPLORE what is open about those of NOW.
    hurried : bool
        Explore few places of each.
    drops : bool
        Take away atoms that others may take the place of, by what each brings.
    """

    threshold: float
    most: int
    starts: int
    purpose: int
    hurried: bool
    drops: bool


SEEK, EXPLORE = 0, 1


class SearchMemory(NamedTuple):
    """Room of a search beside that of the fit.

    Attributes
    ----------
    starts : StartMemory
    seeds : (S, 8) array
        The last row is the place of a new atom.
    costs : (S,) array
        Of the seeds.
    members : (M,) int array
        1 for the atoms in whose place another one is tried.
    owner : (M,) int array
        Number of the body that each atom belongs to.
    known : (3,) array
        Evidence of BEST, at the end of NOW; the variance of the shared offset; and the cost up to
        which seeds are refined on.
    state : (19,) int array
    """

    starts: StartMemory
    seeds: Floats
    costs: Floats
    members: Ints
    owner: Ints
    known: Floats
    state: Ints

    @classmethod
    def of(cls, bank: Templates, most: int, starts: int, taxels: int) -> "SearchMemory":
        """Room for so many atoms and starts."""
        seeds = max(MANY, starts) + 2
        return cls(
            StartMemory.of(bank, starts, taxels),
            np.zeros((seeds, PARAMETERS)),
            np.zeros(seeds),
            np.zeros(most, np.int64),
            np.zeros(most, np.int64),
            np.zeros(3),
            np.zeros(RESUMED + 1, np.int64),
        )


@inner(_nrt=False)
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


@inner(_nrt=False)
def offset_of(memory: FitMemory, which: int) -> float:
    """The offset shared by all taxels that is most probable with a set of atoms."""
    total, predicted = 0.0, memory.predicted[which]
    readings, white = memory.taxels[READINGS], memory.taxels[WHITE]
    for taxel in range(len(readings)):
        total += white[taxel] * white[taxel] * (readings[taxel] - predicted[taxel])
    return float(memory.sums[SHARED] * total)


@inner(_nrt=False)
def misfit(memory: FitMemory, which: int) -> float:
    """By how many standard deviations the squares of the residuals exceed their number."""
    offset, squares, heard = offset_of(memory, which), 0.0, 0
    readings, white = memory.taxels[READINGS], memory.taxels[WHITE]
    for taxel in range(len(readings)):
        left = readings[taxel] - memory.predicted[which, taxel] - offset
        squares += (left * white[taxel]) ** 2
        heard += white[taxel] > 0.0
    return float((squares - heard) / np.sqrt(2.0 * max(heard, 1)))


@inner(_nrt=False)
def prior_evidence(model: FitModel, memory: FitMemory, which: int) -> float:
    """What the priors' normalisation adds to the evidence of a set, with the 2π of Laplace's.

    Places are uniform over the patch, the force's logarithm over `LOG_FORCES`; the other priors are
    those of the cost.
    """
    count = memory.counts[which]
    free = 4 * count
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
        if is_sheared(memory.atoms[which, n]):
            free += 2
            known -= 2 * np.log(priors.shear_std) + np.log(2 * np.pi) + PUSHED
    return float(known + 0.5 * free * np.log(2 * np.pi))


@inner(_nrt=False)
def evidence(model: FitModel, memory: FitMemory, which: int) -> float:
    """Logarithm of the marginal likelihood, up to a constant, by Laplace's approximation.

    For the present weights of the taxels.
    """
    count = memory.counts[which]
    if not count:
        return float(-memory.costs[which])
    size, determinant = free_system(memory, which, memory.hessian[which], 0, 0.0), 0.0
    if not factor(memory.system, size):
        return -np.inf
    for i in range(size):
        determinant += np.log(memory.system[i * size + i])
    return float(prior_evidence(model, memory, which) - memory.costs[which] - determinant)


@inner(_nrt=False)
def append(memory: FitMemory, which: int, atom: Floats, family: int) -> None:
    """Add an atom to a set; the cost becomes that of other atoms."""
    n = memory.counts[which]
    for i in range(PARAMETERS):
        memory.atoms[which, n, i] = atom[i]
    memory.family[which, n] = family
    memory.counts[which] = n + 1


@inner(_nrt=False)
def copy_others(memory: FitMemory, search: SearchMemory, source: int, target: int) -> None:
    """Have a set become the atoms of another one that are no members."""
    memory.counts[target] = 0
    for n in range(memory.counts[source]):
        if not search.members[n]:
            append(memory, target, memory.atoms[source, n], memory.family[source, n])


@inner(_nrt=False)
def best_seed(search: SearchMemory, count: int) -> int:
    """The seed of the least cost, the first of equal ones; it counts no more then."""
    best = 0
    for seed in range(1, count):
        if search.costs[seed] < search.costs[best] - BETTER:
            best = seed
    search.costs[best] = 1e300
    return best


@inner(_nrt=False)
def few_best(search: SearchMemory, count: int) -> float:
    """Cost up to which seeds are the best few."""
    least = -np.inf
    for _ in range(min(FINALISTS, count)):
        above = np.inf
        for seed in range(count):
            if least < search.costs[seed] < above:
                above = search.costs[seed]
        least = above
    return float(least)


@inner(_nrt=False)
def middle(memory: FitMemory, search: SearchMemory, which: int, atom: Floats) -> None:
    """Write one atom with the force of the members, amid them."""
    total = 0.0
    for i in range(PARAMETERS):
        atom[i] = 0.0
    for n in range(memory.counts[which]):
        if search.members[n]:
            force = np.exp(memory.atoms[which, n, 2])
            total += force
            for i in range(PARAMETERS):
                atom[i] += force * memory.atoms[which, n, i]
    for i in range(PARAMETERS):
        atom[i] /= total
    atom[2] = np.log(total)


LINE_BALL, LINE_FLAT, A_RING, SHEARED, SWAPPED, ROUND_BALL, ROUND_FLAT, PAIR, PLAIN, KINDS = range(
    10
)
NO_SHAPE = -1
ENOUGH = 2  # of `GREW`: atoms were added, and no more are


@inner(_nrt=False)
def mark_one(memory: FitMemory, search: SearchMemory, index: int) -> None:
    """Have one atom of NOW be the only member."""
    for n in range(memory.counts[NOW]):
        search.members[n] = n == index


@inner(_nrt=False)
def apart(memory: FitMemory, which: int, one: int, other: int) -> float:
    """Distance of the rims of two atoms, in thicknesses."""
    a, b = memory.atoms[which, one], memory.atoms[which, other]
    rims = np.exp(a[3]) + np.hypot(a[4], a[5]) + np.exp(b[3]) + np.hypot(b[4], b[5])
    return float(np.hypot(a[0] - b[0], a[1] - b[1]) - rims)


@inner(_nrt=False)
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


@inner(_nrt=False)
def applies(memory: FitMemory, index: int, kind: int, odd: bool) -> bool:
    """Whether a shape is an alternative to that of an atom of NOW."""
    long, ring = is_long(memory.atoms[NOW, index]), memory.family[NOW, index] == RING
    sheared = is_sheared(memory.atoms[NOW, index])
    if kind == SHEARED:
        return bool(odd and not sheared and memory.room.shear.shape[1] > 0)
    if kind == PLAIN:
        return sheared
    if kind <= A_RING:
        return bool(odd and not long and not ring)
    if kind == SWAPPED:
        return not ring
    if kind == PAIR:
        return bool(long)
    return bool(long or ring)


@inner(_nrt=False)
def take_left(memory: FitMemory, which: int, offset: float) -> None:
    """Write what a set of atoms and an offset leave to explain into the row LEFT."""
    left = memory.taxels[LEFT]
    for taxel in range(len(left)):
        left[taxel] = memory.taxels[READINGS, taxel] - offset
        if memory.counts[which]:
            left[taxel] -= memory.predicted[which, taxel]


@inner(_nrt=False)
def score_left(memory: FitMemory, noise: Floats, offset: float) -> None:
    """Whiten the row LEFT, without an offset, for the dictionary."""
    scored, left = memory.taxels[SCORED], memory.taxels[LEFT]
    for taxel in range(len(left)):
        heard = memory.taxels[WHITE, taxel] > 0.0
        scored[taxel] = (left[taxel] - offset) / noise[taxel] if heard else 0.0


@inner(_nrt=False)
def worth(memory: FitMemory) -> float:
    """Cost that ALONE, an atom of NOW, saves where the others stay; less where they may move."""
    readings, white = memory.taxels[READINGS], memory.taxels[WHITE]
    squares, total, other = 0.0, 0.0, 0.0
    for taxel in range(len(readings)):
        weight, its = white[taxel] * white[taxel], memory.predicted[ALONE, taxel]
        left = readings[taxel] - memory.predicted[NOW, taxel]
        squares += weight * its * (2.0 * left + its)
        total += weight * left
        other += weight * (left + its)
    return float(0.5 * (squares - memory.sums[SHARED] * (other * other - total * total)))


@inner(_nrt=False)
def seed_shapes(memory: FitMemory, search: SearchMemory) -> None:
    """Write the seeds of the shape that is tried in the place of the members."""
    seeds, kind = search.seeds, search.state[KIND]
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
    search.state[COUNT], search.state[SEED] = count, 0
    search.state[OF] = RING if kind == A_RING else FLAT if kind == LINE_FLAT else BALL
    search.state[STAGE] = SEEDS


@inner(_nrt=False)
def change_shape(memory: FitMemory, search: SearchMemory) -> None:
    """Add to TRIAL the one member of NOW in another shape that has no seeds."""
    n, kind = 0, search.state[KIND]
    while not search.members[n]:
        n += 1
    atom, family = memory.atoms[NOW, n], memory.family[NOW, n]
    if kind == SHEARED:
        amid, members = search.seeds[0], 0
        middle(memory, search, NOW, amid)
        for other in range(memory.counts[NOW]):
            members += search.members[other]
        if members > 1:
            amid[4], amid[5] = 0.0, 0.0
        if not is_sheared(amid):
            amid[6] = FAINT_PUSH
        append(memory, TRIAL, amid, family if members == 1 else BALL)
    elif kind == PLAIN:
        append(memory, TRIAL, atom, family)
        its = memory.atoms[TRIAL, memory.counts[TRIAL] - 1]
        its[6], its[7] = 0.0, 0.0
    elif kind == SWAPPED:
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


@inner(_nrt=False)
def after_growth(search: SearchMemory) -> None:
    """Go on where no atom is to be added."""
    state = search.state
    state[STAGE] = SHAPES
    if state[GREW]:
        state[GREW], state[DUE] = ENOUGH, 1
        state[INDEX], state[STAGE] = 0, PRUNE


@inner(_nrt=False)
def may_be_without(memory: FitMemory, search: SearchMemory, index: int) -> bool:
    """Whether others may take the place of an atom of NOW: then it is tried without."""
    for other in range(memory.counts[NOW]):
        if other != index and apart(memory, NOW, index, other) < GAP:
            return True
    return False


@inner(_nrt=False)
def next_rival(memory: FitMemory, search: SearchMemory) -> bool:
    """Set the next shape of an atom of NOW that may do as well as the new atom; False if none."""
    state, new = search.state, search.seeds[len(search.seeds) - 1]
    while state[INDEX] < memory.counts[NOW]:
        atom = memory.atoms[NOW, state[INDEX]]
        off = np.hypot(atom[0] - new[0], atom[1] - new[1]) - np.exp(atom[3]) - np.exp(new[3])
        plain = not is_long(atom) and memory.family[NOW, state[INDEX]] != RING
        if off < GAP and plain and state[KIND] <= A_RING:
            mark_one(memory, search, state[INDEX])
            return True
        if off < GAP and state[KIND] <= SHEARED and applies(memory, state[INDEX], SHEARED, True):
            state[KIND] = SHEARED
            mark_one(memory, search, state[INDEX])
            return True
        state[INDEX], state[KIND] = state[INDEX] + 1, 0
    return False


@inner(_nrt=False)
def next_shape(memory: FitMemory, search: SearchMemory, rules: SearchRules) -> bool:
    """Set the next alternative to the shapes of NOW; False if all were tried.

    First those of each atom, in the order of their numbers, then one body in the place of several.
    """
    state, count = search.state, memory.counts[NOW]
    odd, known = False, False
    while state[MOVE] < 2 * count * KINDS:
        index, kind = state[MOVE] // KINDS, state[MOVE] % KINDS
        state[KIND] = kind
        if index < count:
            if not known:
                odd, known = misfit(memory, NOW) > ODD, True
            mark_one(memory, search, index)
            if applies(memory, index, kind, odd) and (kind != PAIR or count < rules.most):
                return True
        elif kind <= (SHEARED if memory.room.shear.shape[1] else A_RING):
            bodies(memory, search)
            members = 0
            for n in range(count):
                search.members[n] = search.owner[n] == index - count
                members += search.members[n]
            if members > 1:
                return True
        state[MOVE] += 1
    return False
