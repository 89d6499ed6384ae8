"""Posterior of atoms, compiled: mean and covariance by exploring what fits about as well.

Between taxels the posterior of a contact is no ellipsoid but a curved valley, along which another
place is made up for by another force and radius. It is walked on a lattice of places: at each,
force and radius (and half-length) are refined and then integrated out by Laplace's approximation,
as in the nested approximations of Rue, Martino and Chopin (2009).
"""

from typing import NamedTuple

import numpy as np

from skinfield.compiled import inner
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.atom_readings import PARAMETERS, free_of, parameter_of
from skinfield.solve.atoms.cholesky_kernel import factor, solve_factored
from skinfield.solve.atoms.fit_kernel import (
    ALONE,
    NOW,
    FitMemory,
    FitModel,
    free_system,
)

RARER = np.array([0.0, 1.0, 2.0])  # ln odds of a ball over each family, before any reading
REACH = 14  # steps of the lattice each way
SIDE = 2 * REACH + 1
WALK_STEPS = 2  # of refinement at each place
WALK_GAIN = 1e-2  # gain in cost of the last of them
DEEP = 6.0  # in cost: places that are worse than the best by more do not count
ROUND_OFF = 1e-9, 1e-12  # of a Hessian's diagonal, and beside it: what is added so that it inverts
SHORTEST, LONGEST = 0.004, 0.35  # thicknesses between them
LEAST = 1e-6  # of all weights: a family with less has no radius of its own
CERTAIN = 0.05  # thicknesses: deviation of the place up to which the minimum's curvature tells all
SURE = 0.15  # thicknesses: deviation up to which other minima are not looked for
PLACES = 50  # that are tried to tell how sure a contact is, for each family
FEW = 9  # for a contact that the reading before had, too
STEP_STD, WIDE_STEP_STD = 1.1, 1.6  # standard deviations between places, for many and for few
MOVED = 0.5  # standard deviations within which what was known of a contact still holds
CHANGED = 0.2  # of its force's logarithm, likewise
UNKNOWN, ROUGH, KNOWN, STALE = 0, 1, 2, 3  # what is known of an atom; STALE: for another noise
NEAR = 1.0  # thicknesses: an atom of the same family that is nearer was there before
# Places of `PosteriorMemory.walk`: length of the queue, the next of it, atoms that were walked in
# all and before this family, the family, both families?, most places, the place that is refined.
QUEUED, NEXT, WALKED, FIRST, FAMILY, BOTH, MOST, CURRENT = range(8)
AXES, MEAN, BEST_COST = 60, 50, 70  # in `small`


class PosteriorMemory(NamedTuple):
    """What is known of the atoms, and room for walks.

    Attributes
    ----------
    known : (M,) int array
        UNKNOWN, ROUGH, KNOWN or STALE; and the family of the atom then, in `family` (M,).
    atoms, offsets : (M, 8) arrays
        Where it was then, and from there to the posterior's mean.
    covariance : (M, 8, 8) array
    local : (8, 8) array
        By the curvature of the cost alone, of the atom that is looked at.
    walked : (W, 8) array
        Atoms at the places of a walk; `families` (W,) and `weights` (W,), at first their logarithm.
    inner : (W, 8, 8) array
        Covariance of the parameters beside the place at each.
    queue : (SIDE SIDE, 3) int array
        Places of the lattice, and the atom, walked or a start, that they begin from.
    put : (SIDE, SIDE) int array
        Whether a place is in the queue.
    walk : (8,) int array
        See `QUEUED` and those after it.
    small : (80,) array
    """

    known: Ints
    family: Ints
    atoms: Floats
    offsets: Floats
    covariance: Floats
    local: Floats
    walked: Floats
    families: Ints
    weights: Floats
    inner: Floats
    queue: Ints
    put: Ints
    walk: Ints
    small: Floats

    @classmethod
    def of(cls, most: int) -> "PosteriorMemory":
        """Room for so many atoms."""
        places = 2 * PLACES
        return cls(
            np.zeros(most, np.int64),
            np.zeros(most, np.int64),
            np.zeros((most, PARAMETERS)),
            np.zeros((most, PARAMETERS)),
            np.zeros((most, PARAMETERS, PARAMETERS)),
            np.zeros((PARAMETERS, PARAMETERS)),
            np.zeros((places, PARAMETERS)),
            np.zeros(places, np.int64),
            np.zeros(places),
            np.zeros((places, PARAMETERS, PARAMETERS)),
            np.zeros((SIDE * SIDE, 3), np.int64),
            np.zeros((SIDE, SIDE), np.int64),
            np.zeros(8, np.int64),
            np.zeros(80),
        )


@inner(_nrt=False)
def laplace(model: FitModel, memory: FitMemory, index: int, covariance: Floats) -> None:
    """Write the covariance (8, 8) of an atom by the curvature of the cost, others moving along.

    Places that no reading tells are even over the patch: their variance is its width squared / 12.
    """
    size = free_system(memory, NOW, memory.hessian[NOW], 0, ROUND_OFF[0])
    system, free, right, own = memory.system, memory.free, memory.steps[1], size
    for i in range(size):
        axis = free[i] % PARAMETERS
        if axis < 2:
            system[i * size + i] += 12.0 / (model.places[1, axis] - model.places[0, axis]) ** 2
        own = min(own, i) if free[i] == PARAMETERS * index else own
    for i in range(PARAMETERS):
        for j in range(PARAMETERS):
            covariance[i, j] = 0.0
    if not factor(system, size):  # something moves no reading and has no prior
        for i in range(2):
            covariance[i, i] = (model.places[1, i] - model.places[0, i]) ** 2 / 12.0
        covariance[2, 2] = covariance[3, 3] = 1.0
        return
    atom = memory.atoms[NOW, index]
    parameters = free_of(atom)
    for column in range(parameters):
        for i in range(size):
            right[i] = 0.0
        right[own + column] = 1.0
        solve_factored(system, size, right)
        for i in range(parameters):
            covariance[parameter_of(atom, i), parameter_of(atom, column)] = right[own + i]


@inner(_nrt=False)
def _inverse(memory: FitMemory, post: PosteriorMemory, at: int) -> float:
    """Write the covariance beside the place of the atom that was refined alone.

    Returns half the logarithm of the determinant of its curvature; infinite if that is not
    positive.
    """
    atom = memory.atoms[ALONE, 0]
    free = free_of(atom) - 2
    hessian, small, out = memory.hessian[ALONE], post.small, post.inner[at]
    right = small[40:46]
    for i in range(free):
        for j in range(free):
            at_j = parameter_of(atom, j + 2)
            small[i * free + j] = hessian[parameter_of(atom, i + 2) * PARAMETERS + at_j]
        small[i * free + i] = small[i * free + i] * (1.0 + ROUND_OFF[0]) + ROUND_OFF[1]
    for i in range(PARAMETERS):
        for j in range(PARAMETERS):
            out[i, j] = 0.0
    if not factor(small, free):
        return np.inf
    half = 0.0
    for i in range(free):
        half += np.log(small[i * free + i])
    for column in range(free):
        for i in range(free):
            right[i] = 0.0
        right[column] = 1.0
        solve_factored(small, free, right[:free])
        for i in range(free):
            out[parameter_of(atom, i + 2), parameter_of(atom, column + 2)] = right[i]
    return half


@inner(_nrt=False)
def _visit(post: PosteriorMemory, i: int, j: int, source: int) -> None:
    """Put a place at the end of the queue if it is new and near."""
    if max(i, j) > REACH or min(i, j) < -REACH or post.put[i + REACH, j + REACH]:
        return
    length = post.walk[QUEUED]
    post.put[i + REACH, j + REACH] = 1
    post.queue[length, 0], post.queue[length, 1], post.queue[length, 2] = i, j, source
    post.walk[QUEUED] = length + 1


@inner(_nrt=False)
def widest_deviation(post: PosteriorMemory, step: float) -> float:
    """Largest deviation by `local` of a place, in thicknesses; writes the axes of a lattice."""
    covariance, axes = post.local, post.small
    a, b, c = covariance[0, 0], covariance[0, 1], covariance[1, 1]
    middle, spread = 0.5 * (a + c), np.hypot(0.5 * (a - c), b)
    wide, narrow = np.sqrt(max(middle + spread, 0.0)), np.sqrt(max(middle - spread, 0.0))
    angle = 0.5 * np.arctan2(2.0 * b, a - c)  # of the wider axis
    long = min(max(step * wide, SHORTEST), LONGEST)
    short = min(max(step * narrow, SHORTEST), LONGEST)
    axes[AXES], axes[AXES + 1] = -short * np.sin(angle), short * np.cos(angle)
    axes[AXES + 2], axes[AXES + 3] = long * np.cos(angle), long * np.sin(angle)
    return float(wide)


@inner(_nrt=False)
def start_walk(post: PosteriorMemory, seeds: Floats, count: int, family: int) -> None:
    """Begin a walk with a family: the queue holds the places of the first seeds (count, 8).

    The first of them is where the lattice of places has its origin.
    """
    walk, a, b = post.walk, post.small[AXES], post.small[AXES + 1]
    c, d = post.small[AXES + 2], post.small[AXES + 3]
    for i in range(SIDE):
        for j in range(SIDE):
            post.put[i, j] = 0
    walk[QUEUED], walk[NEXT], walk[FIRST], walk[FAMILY] = 0, 0, walk[WALKED], family
    post.small[BEST_COST] = np.inf
    determinant = a * d - b * c
    if determinant == 0.0:
        determinant = np.inf  # no lattice: all at its origin
    for seed in range(count):
        x, y = seeds[seed, 0] - seeds[0, 0], seeds[seed, 1] - seeds[0, 1]
        i, j = np.rint((x * d - y * c) / determinant), np.rint((y * a - x * b) / determinant)
        _visit(post, int(i), int(j), -1 - seed)


@inner(_nrt=False)
def next_place(model: FitModel, memory: FitMemory, post: PosteriorMemory, seeds: Floats) -> bool:
    """Make ALONE the atom at the next place of a walk; False where there is none."""
    walk, atom, axes = post.walk, memory.atoms[ALONE, 0], post.small
    while walk[NEXT] < walk[QUEUED] and walk[WALKED] < walk[FIRST] + walk[MOST]:
        walk[CURRENT] = walk[NEXT]
        i, j, source = (
            post.queue[walk[NEXT], 0],
            post.queue[walk[NEXT], 1],
            post.queue[walk[NEXT], 2],
        )
        walk[NEXT] += 1
        x = seeds[0, 0] + i * axes[AXES] + j * axes[AXES + 2]
        y = seeds[0, 1] + i * axes[AXES + 1] + j * axes[AXES + 3]
        if not (model.places[0, 0] <= x <= model.places[1, 0]):
            continue
        if not (model.places[0, 1] <= y <= model.places[1, 1]):
            continue
        begin = seeds[-1 - source] if source < 0 else post.walked[source]
        memory.counts[ALONE], memory.family[ALONE, 0] = 1, walk[FAMILY]
        for k in range(PARAMETERS):
            atom[k] = begin[k]
        atom[0], atom[1] = x, y
        return True
    return False


@inner(_nrt=False)
def keep_place(memory: FitMemory, post: PosteriorMemory) -> None:
    """Keep the refined ALONE if it fits about as well as the best, and queue what is beside it."""
    walk, cost = post.walk, memory.costs[ALONE]
    if cost > post.small[BEST_COST] + DEEP:
        return
    post.small[BEST_COST] = min(post.small[BEST_COST], cost)
    at, place = walk[WALKED], walk[CURRENT]
    for k in range(PARAMETERS):
        post.walked[at, k] = memory.atoms[ALONE, 0, k]
    post.families[at] = walk[FAMILY]
    post.weights[at] = -cost - _inverse(memory, post, at) - RARER[walk[FAMILY]]
    i, j = post.queue[place, 0], post.queue[place, 1]
    for way in range(9):
        _visit(post, i + way // 3 - 1, j + way % 3 - 1, at)
    walk[WALKED] = at + 1


@inner(_nrt=False)
def combine(post: PosteriorMemory, index: int, family: int, atom: Floats) -> None:
    """Write mean and covariance of a walk from an atom (8,) on, if anything of it counts."""
    highest, count = -np.inf, post.walk[WALKED]
    for at in range(count):
        highest = max(highest, post.weights[at])
    if not highest > -np.inf:
        return
    total, same = 0.0, 0.0
    for at in range(count):
        post.weights[at] = np.exp(post.weights[at] - highest)
        total += post.weights[at]
    covariance, offset, mean = (
        post.covariance[index],
        post.offsets[index],
        post.small[MEAN : MEAN + PARAMETERS],
    )
    for i in range(PARAMETERS):
        mean[i] = 0.0
        offset[i] = 0.0
        for j in range(PARAMETERS):
            covariance[i, j] = 0.0
    for at in range(count):
        weight = post.weights[at] / total
        own = post.families[at] == family
        same += weight if own else 0.0
        for i in range(PARAMETERS):
            mean[i] += weight * post.walked[at, i]
            offset[i] += weight * post.walked[at, i] if own else 0.0
    for at in range(count):
        weight = post.weights[at] / total
        for i in range(PARAMETERS):
            for j in range(PARAMETERS):
                off = (post.walked[at, i] - mean[i]) * (post.walked[at, j] - mean[j])
                covariance[i, j] += weight * (off + post.inner[at, i, j])
    for i in range(PARAMETERS):  # place and force whatever presses, else of the same family
        value = mean[i]
        if i >= 3 and same > LEAST:
            value = offset[i] / same
        offset[i] = value - atom[i]


@inner(_nrt=False)
def holds(memory: FitMemory, post: PosteriorMemory, index: int) -> bool:
    """Whether an atom is still about where it was when its covariance was found."""
    if post.known[index] not in (ROUGH, KNOWN) or post.family[index] != memory.family[NOW, index]:
        return False
    for axis in range(2):
        off = memory.atoms[NOW, index, axis] - post.atoms[index, axis]
        if not abs(off) < MOVED * np.sqrt(post.covariance[index, axis, axis]):
            return False
    return bool(abs(memory.atoms[NOW, index, 2] - post.atoms[index, 2]) < CHANGED)


@inner(_nrt=False)
def was_there(memory: FitMemory, post: PosteriorMemory, index: int) -> bool:
    """Whether an atom of the same family was known about there."""
    if post.known[index] < KNOWN or post.family[index] != memory.family[NOW, index]:
        return False
    x = memory.atoms[NOW, index, 0] - post.atoms[index, 0]
    y = memory.atoms[NOW, index, 1] - post.atoms[index, 1]
    return bool(np.hypot(x, y) < NEAR)
