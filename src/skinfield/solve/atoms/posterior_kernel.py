"""Posterior of atoms, compiled: mean and covariance by exploring what fits about as well.

Between taxels the posterior of a contact is no ellipsoid but a curved valley, along which another
place is made up for by another force and radius. It is walked on a lattice of places: at each,
force and radius (and half-length) are refined and then integrated out by Laplace's approximation,
as in the nested approximations of Rue, Martino and Chopin (2009).
"""

from typing import NamedTuple

import numpy as np

from skinfield.compiled import inner, njit
from skinfield.errors import Floats, Ints
from skinfield.solve.atoms.dictionary import Templates, find_starts
from skinfield.solve.atoms.fit_kernel import (
    ALONE,
    LEFT,
    NOW,
    READINGS,
    SCORED,
    SHARED,
    WHITE,
    FitMemory,
    FitModel,
    descend,
    factor,
    is_late,
    is_long,
    solve_factored,
)
from skinfield.solve.atoms.search_kernel import (
    RARER,
    SearchMemory,
    append,
    copy_others,
    leave,
    mark_one,
    offset_of,
)
from skinfield.solve.atoms.fit_kernel import TRIAL
from skinfield.solve.atoms.table import BALL, FLAT, RING

REACH = 14  # steps of the lattice each way
SIDE = 2 * REACH + 1
STEPS = 4  # of refinement at each place
SETTLED_GAIN = 1e-2  # gain in cost of the last of them
DEEP = 6.0  # in cost: places that are worse than the best by more do not count
ROUND_OFF = 1e-9, 1e-12  # of a Hessian's diagonal, and beside it: what is added so that it inverts
SHORTEST, LONGEST = 0.004, 0.35  # thicknesses between them
LEAST = 1e-6  # of all weights: a family with less has no radius of its own
CERTAIN = 0.05  # thicknesses: deviation of the place up to which the minimum's curvature tells all
SURE = 0.15  # thicknesses: deviation up to which other minima are not looked for
PLACES = 100  # that are tried to tell how sure a contact is, for each family
FEW = 14  # for a contact that the reading before had, too
STEP_STD, WIDE_STEP_STD = 0.9, 1.2  # standard deviations between places, for many and for few
MOVED = 0.5  # standard deviations within which what was known of a contact still holds
CHANGED = 0.2  # of its force's logarithm, likewise
UNKNOWN, ROUGH, KNOWN = 0, 1, 2  # what is known of an atom


class PosteriorMemory(NamedTuple):
    """What is known of the atoms, and room for walks.

    Attributes
    ----------
    known : (M,) int array
        UNKNOWN, ROUGH or KNOWN; and the family of the atom then, in `family` (M,).
    atoms, offsets : (M, 6) arrays
        Where it was then, and from there to the posterior's mean.
    covariance : (M, 6, 6) array
    inverse : (36 M M,) array
    walked : (W, 6) array
        Atoms at the places of a walk; `families` (W,) and `weights` (W,), at first their logarithm.
    inner : (W, 6, 6) array
        Covariance of the parameters beside the place at each.
    queue : (SIDE SIDE, 3) int array
        Places of the lattice, and the atom, walked or a start, that they begin from.
    put : (SIDE, SIDE) int array
        Whether a place is in the queue.
    part : (8,) int array
        Numbers of parameters.
    small : (80,) array
    """

    known: Ints
    family: Ints
    atoms: Floats
    offsets: Floats
    covariance: Floats
    inverse: Floats
    walked: Floats
    families: Ints
    weights: Floats
    inner: Floats
    queue: Ints
    put: Ints
    part: Ints
    small: Floats

    @classmethod
    def of(cls, most: int) -> "PosteriorMemory":
        """Room for so many atoms."""
        places = 2 * PLACES
        return cls(
            np.zeros(most, np.int64),
            np.zeros(most, np.int64),
            np.zeros((most, 6)),
            np.zeros((most, 6)),
            np.zeros((most, 6, 6)),
            np.zeros(36 * most * most),
            np.zeros((places, 6)),
            np.zeros(places, np.int64),
            np.zeros(places),
            np.zeros((places, 6, 6)),
            np.zeros((SIDE * SIDE, 3), np.int64),
            np.zeros((SIDE, SIDE), np.int64),
            np.zeros(8, np.int64),
            np.zeros(80),
        )


@inner
def laplace(model: FitModel, memory: FitMemory, post: PosteriorMemory, index: int) -> None:
    """Write the covariance of one atom by the curvature of the cost, all others moving along.

    Places that no reading tells are even over the patch: their variance is its width squared / 12.
    """
    count = memory.counts[NOW]
    size, system, hessian = 6 * count, memory.system, memory.hessian[NOW]
    for i in range(size * size):
        system[i] = hessian[i]
    for i in range(size):
        n, k = i // 6, i % 6
        if k < 2:
            system[i * size + i] += 12.0 / (model.places[1, k] - model.places[0, k]) ** 2
        if k >= 4 and not is_long(memory.atoms[NOW, n]):
            for j in range(size):
                system[i * size + j] = 0.0
                system[j * size + i] = 0.0
            system[i * size + i] = 1.0
        else:
            system[i * size + i] = system[i * size + i] * (1.0 + ROUND_OFF[0]) + ROUND_OFF[1]
    covariance, right = post.covariance[index], memory.steps[1]
    if not factor(system, size):  # something moves no reading and has no prior
        for i in range(6):
            for j in range(6):
                covariance[i, j] = 0.0
        for i in range(2):
            covariance[i, i] = (model.places[1, i] - model.places[0, i]) ** 2 / 12.0
        covariance[2, 2] = covariance[3, 3] = 1.0
        return
    long = is_long(memory.atoms[NOW, index])
    for column in range(6):
        for i in range(size):
            right[i] = 0.0
        right[6 * index + column] = 1.0
        solve_factored(system, size, right[:size])
        for i in range(6):
            free = long or (i < 4 and column < 4)
            covariance[i, column] = right[6 * index + i] if free else 0.0


@inner
def _inverse(memory: FitMemory, post: PosteriorMemory, at: int) -> float:
    """Write the covariance beside the place of the atom that was refined alone.

    Returns half the logarithm of the determinant of its curvature; infinite if that is not
    positive.
    """
    free = 4 if is_long(memory.atoms[ALONE, 0]) else 2
    hessian, small, out = memory.hessian[ALONE], post.small, post.inner[at]
    right = small[40:46]
    for i in range(free):
        for j in range(free):
            small[i * free + j] = hessian[(i + 2) * 6 + j + 2]
        small[i * free + i] = small[i * free + i] * (1.0 + ROUND_OFF[0]) + ROUND_OFF[1]
    for i in range(6):
        for j in range(6):
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
            out[i + 2, column + 2] = right[i]
    return half


@inner
def _visit(post: PosteriorMemory, i: int, j: int, source: int, length: int) -> int:
    """Put a place at the end of the queue if it is new and near; the queue's length then."""
    if abs(i) > REACH or abs(j) > REACH or post.put[i + REACH, j + REACH]:
        return length
    post.put[i + REACH, j + REACH] = 1
    post.queue[length, 0], post.queue[length, 1], post.queue[length, 2] = i, j, source
    return length + 1


@inner
def explore(
    model: FitModel,
    memory: FitMemory,
    search: SearchMemory,
    post: PosteriorMemory,
    seeds: int,
    family: int,
    axes: Floats,
    most: int,
    first: int,
    deadline: int,
) -> int:
    """Walk over places from the search's first seeds while the cost stays near the least.

    Parameters
    ----------
    seeds : int
        How many; the first is where the lattice of places has its origin.
    family : int
        Of the atom.
    axes : (2, 2) array
        Steps of the lattice.
    most : int
        Places that are kept.
    first : int
        Row of the first of them.

    Returns
    -------
    int
        Row after the last.
    """
    x, y = search.seeds[0, 0], search.seeds[0, 1]
    for i in range(SIDE):
        for j in range(SIDE):
            post.put[i, j] = 0
    determinant, length = axes[0, 0] * axes[1, 1] - axes[0, 1] * axes[1, 0], 0
    for seed in range(seeds):
        off_x, off_y = search.seeds[seed, 0] - x, search.seeds[seed, 1] - y
        i = round((off_x * axes[1, 1] - off_y * axes[1, 0]) / determinant)
        j = round((off_y * axes[0, 0] - off_x * axes[0, 1]) / determinant)
        length = _visit(post, int(i), int(j), -1 - seed, length)
    best, at, place = np.inf, first, 0
    while place < length and at < first + most:
        if at > first and is_late(memory, deadline):
            break
        i, j, source = post.queue[place, 0], post.queue[place, 1], post.queue[place, 2]
        place += 1
        begin = search.seeds[-1 - source] if source < 0 else post.walked[source]
        memory.counts[ALONE] = 0
        append(memory, ALONE, begin, family)
        atom = memory.atoms[ALONE, 0]
        atom[0] = x + i * axes[0, 0] + j * axes[1, 0]
        atom[1] = y + i * axes[0, 1] + j * axes[1, 1]
        inside = True
        for axis in range(2):
            inside = inside and model.places[0, axis] <= atom[axis] <= model.places[1, axis]
        if not inside:
            continue
        descend(model, memory, ALONE, LEFT, 2, STEPS, SETTLED_GAIN, 0)
        cost = memory.costs[ALONE]
        if cost > best + DEEP:
            continue
        best = min(best, cost)
        for k in range(6):
            post.walked[at, k] = atom[k]
        post.families[at] = family
        post.weights[at] = -cost - _inverse(memory, post, at) - RARER[family]
        for way in range(9):
            length = _visit(post, i + way // 3 - 1, j + way % 3 - 1, at, length)
        at += 1
    return at


@inner
def _combine(post: PosteriorMemory, index: int, family: int, count: int, atom: Floats) -> bool:
    """Write mean and covariance of a walk; False if nothing of it counts."""
    highest = -np.inf
    for at in range(count):
        highest = max(highest, post.weights[at])
    if not highest > -np.inf:
        return False
    total, same = 0.0, 0.0
    for at in range(count):
        post.weights[at] = np.exp(post.weights[at] - highest)
        total += post.weights[at]
    covariance, offset, mean = post.covariance[index], post.offsets[index], post.small[50:56]
    for i in range(6):
        mean[i] = 0.0
        offset[i] = 0.0
        for j in range(6):
            covariance[i, j] = 0.0
    for at in range(count):
        weight = post.weights[at] / total
        own = post.families[at] == family
        same += weight if own else 0.0
        for i in range(6):
            mean[i] += weight * post.walked[at, i]
            offset[i] += weight * post.walked[at, i] if own else 0.0
    for at in range(count):
        weight = post.weights[at] / total
        for i in range(6):
            for j in range(6):
                off = (post.walked[at, i] - mean[i]) * (post.walked[at, j] - mean[j])
                covariance[i, j] += weight * (off + post.inner[at, i, j])
    for i in range(6):  # of place and force whatever presses, else if it is of the same family
        value = mean[i]
        if i >= 3 and same > LEAST:
            value = offset[i] / same
        offset[i] = value - atom[i]
    return True


@inner
def believe(
    model: FitModel,
    bank: Templates,
    memory: FitMemory,
    search: SearchMemory,
    post: PosteriorMemory,
    noise: Floats,
    index: int,
    places: int,
    starts: int,
    step: float,
    deadline: int,
) -> None:
    """Write what the reading leaves open about one atom, the others being where they are.

    At most so many `places` are tried for each family, `step` standard deviations apart. Further
    minima are sought from so many `starts`; with 0 of them the other family is not tried, either.
    """
    own, family = memory.atoms[NOW, index], memory.family[NOW, index]
    for i in range(6):
        post.atoms[index, i] = own[i]
        post.offsets[index, i] = 0.0
    post.family[index], post.known[index] = family, KNOWN
    laplace(model, memory, post, index)
    a, b, c = (
        post.covariance[index, 0, 0],
        post.covariance[index, 0, 1],
        post.covariance[index, 1, 1],
    )
    middle, spread = 0.5 * (a + c), np.hypot(0.5 * (a - c), b)
    large, small = max(middle + spread, 0.0), max(middle - spread, 0.0)
    widest = np.sqrt(large)
    if widest < CERTAIN:
        return
    if is_late(memory, deadline):
        post.known[index] = ROUGH
        return
    angle = 0.5 * np.arctan2(2.0 * b, a - c)  # of the wider axis
    axes = post.small[60:64].reshape((2, 2))
    long = min(max(step * widest, SHORTEST), LONGEST)
    short = min(max(step * np.sqrt(small), SHORTEST), LONGEST)
    axes[0, 0], axes[0, 1] = -short * np.sin(angle), short * np.cos(angle)
    axes[1, 0], axes[1, 1] = long * np.cos(angle), long * np.sin(angle)
    mark_one(memory, search, index)
    copy_others(memory, search, NOW, TRIAL)
    offset, left = offset_of(memory, NOW), memory.taxels[LEFT]
    leave(model, memory, TRIAL)
    for taxel in range(len(left)):
        left[taxel] -= offset
    shared, memory.sums[SHARED] = memory.sums[SHARED], 0.0
    for i in range(6):
        search.seeds[0, i] = own[i]
    seeds, both = 1, starts > 0 and family != RING
    if both and widest > SURE and not is_long(own):
        scored = memory.taxels[SCORED]
        for taxel in range(len(left)):
            heard = memory.taxels[WHITE, taxel] > 0.0
            scored[taxel] = left[taxel] / noise[taxel] if heard else 0.0
        more = find_starts(bank, search.starts, scored, starts, 0.0)
        for seed in range(min(more, len(search.seeds) - 1)):
            for i in range(6):
                search.seeds[seed + 1, i] = search.starts.starts[seed, i]
            seeds += 1
    walked = 0
    kinds = 2 if both else 1
    for kind in range(kinds):
        tried = (BALL, FLAT)[kind] if both else family
        walked = explore(
            model, memory, search, post, seeds, tried, axes, places, walked, deadline
        )
    memory.sums[SHARED] = shared
    if is_late(memory, deadline):
        post.known[index] = ROUGH
        for i in range(6):
            post.offsets[index, i] = 0.0
        return
    _combine(post, index, family, walked, own)


@inner
def holds(memory: FitMemory, post: PosteriorMemory, index: int) -> bool:
    """Whether an atom is still about where it was when its covariance was found."""
    if post.known[index] == UNKNOWN or post.family[index] != memory.family[NOW, index]:
        return False
    for axis in range(2):
        off = memory.atoms[NOW, index, axis] - post.atoms[index, axis]
        if not abs(off) < MOVED * np.sqrt(post.covariance[index, axis, axis]):
            return False
    return bool(abs(memory.atoms[NOW, index, 2] - post.atoms[index, 2]) < CHANGED)


@njit
def believe_all(
    model: FitModel,
    bank: Templates,
    memory: FitMemory,
    search: SearchMemory,
    post: PosteriorMemory,
    noise: Floats,
    same: bool,
    starts: int,
    deadline: int,
) -> None:
    """Write mean and covariance of all atoms of NOW, but where those before still hold.

    Parameters
    ----------
    same : bool
        Whether the atoms are those of the reading before.
    starts : int
        Places from which further minima are sought.
    """
    for index in range(memory.counts[NOW]):
        before = post.known[index] if same else UNKNOWN
        if before == KNOWN and holds(memory, post, index):
            continue
        few = before == KNOWN
        believe(
            model, bank, memory, search, post, noise, index,
            FEW if few else PLACES, 0 if few else starts,
            WIDE_STEP_STD if few else STEP_STD, deadline,
        )
    for index in range(memory.counts[NOW], len(post.known)):
        post.known[index] = UNKNOWN
