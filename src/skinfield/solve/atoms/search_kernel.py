"""Search for the atoms of a reading, compiled: one loop, each turn of which refines one set.

The answer of the reading before is refined first. Atoms that are not needed go, others are added
where the residual is most significant, and their shapes are compared by the marginal likelihood;
last, what the reading leaves open about each is explored. A stage says which set is refined next
and why, so that there is an answer whenever the time is up, and the next reading goes on with the
shapes that were not compared yet.
"""

import numpy as np

from skinfield.compiled import inner
from skinfield.errors import Floats
from skinfield.solve.atoms.alternatives_kernel import (
    A_RING,
    APART,
    BELIEVE,
    BETTER,
    CARRIED,
    COMPARED,
    COUNT,
    DONE,
    DUE,
    ENOUGH,
    FIRST_OPEN,
    FOUND,
    GREW,
    GROW,
    INDEX,
    JOIN,
    KIND,
    MOVE,
    NO_SHAPE,
    OF,
    OTHERS,
    PLACES_LEFT,
    PRUNE,
    REFINE,
    REFINED,
    RESUMED,
    RIVAL,
    RIVALS,
    SEED,
    SEEDS,
    SEEK,
    SHAPE,
    SHAPES,
    STAGE,
    TRIED,
    UNTIL,
    WALK,
    WITHOUT,
    SearchMemory,
    SearchRules,
    after_growth,
    append,
    best_seed,
    change_shape,
    clear_set,
    copy_others,
    evidence,
    few_best,
    mark_one,
    may_be_without,
    next_rival,
    next_shape,
    offset_of,
    score_left,
    seed_shapes,
    take_left,
    worth,
)
from skinfield.solve.atoms.atom_readings import PARAMETERS, is_long
from skinfield.solve.atoms.dictionary import Templates, find_starts
from skinfield.solve.atoms.fit_kernel import (
    ALONE,
    BEST,
    LATE,
    LEFT,
    NOW,
    PACE,
    PAUSE,
    READINGS,
    SCORED,
    SEEDING,
    SHARED,
    STEPPED,
    TRIAL,
    FitMemory,
    FitModel,
    copy_set,
    descend,
    is_late,
    is_short,
    take_pace,
)
from skinfield.solve.atoms.posterior_kernel import (
    BOTH,
    CERTAIN,
    FEW,
    KNOWN,
    MOST,
    PLACES,
    ROUGH,
    STEP_STD,
    SURE,
    UNKNOWN,
    WALK_GAIN,
    WALK_STEPS,
    WALKED,
    WIDE_STEP_STD,
    PosteriorMemory,
    combine,
    holds,
    keep_place,
    laplace,
    next_place,
    start_walk,
    was_there,
    widest_deviation,
)
from skinfield.solve.atoms.table import BALL, FLAT, RING
from skinfield.solve.clock import now_ns

BURST = 12  # steps of refinement of what is only tried
HEAT = 3  # of each seed, before the best go on
CLEAR = 4.0  # times the threshold that an atom far from others brings: it need not be tried without
TRIED_MOST = 2  # of the places for a new atom: these are refined together with the others
OFF_LATTICE = 2.0  # how much more than the best template an atom between the templates may gain
CLEARLY = 1.0  # ln odds by which another shape is chosen where that takes several readings
LONG = 60  # of what is taken
FOLLOWED = 3  # readings on which a set is refined: by then it is good enough
SETTLED_GAIN = 1e-3  # gain in cost of the last step


@inner(_nrt=False)
def begin_walk(
    bank: Templates,
    memory: FitMemory,
    search: SearchMemory,
    post: PosteriorMemory,
    rules: SearchRules,
    noise: Floats,
) -> None:
    """Begin to explore what is open about an atom, by the row LEFT, which the others leave."""
    state, index = search.state, search.state[INDEX]
    own, family = memory.atoms[NOW, index], memory.family[NOW, index]
    for i in range(PARAMETERS):
        search.seeds[0, i] = own[i]
    few = state[PLACES_LEFT] == FEW
    both, count = family != RING and not few, 1
    wide = widest_deviation(post, WIDE_STEP_STD if few else STEP_STD)
    if both and wide > SURE and not is_long(own):
        score_left(memory, noise, 0.0)
        more = find_starts(bank, search.starts, memory.taxels[SCORED], rules.starts, 0.0)
        for seed in range(more):
            for i in range(PARAMETERS):
                search.seeds[seed + 1, i] = search.starts.starts[seed, i]
        count += more
    state[COUNT] = count
    post.walk[WALKED], post.walk[BOTH], post.walk[MOST] = 0, both, state[PLACES_LEFT]
    start_walk(post, search.seeds, count, BALL if both else family)
    search.known[1], memory.sums[SHARED] = memory.sums[SHARED], 0.0
    state[STAGE] = WALK


NOTHING = -1  # instead of the number of a set to refine


@inner(_nrt=False)
def begin(
    model: FitModel,
    bank: Templates,
    memory: FitMemory,
    search: SearchMemory,
    post: PosteriorMemory,
    rules: SearchRules,
    noise: Floats,
) -> int:
    """Prepare the set of the present stage; its number, or NOTHING where the stage is another."""
    state, count = search.state, memory.counts[NOW]
    stage, index = state[STAGE], state[INDEX]
    if stage == REFINE:
        if count:
            return NOW
        clear_set(memory, NOW)
        state[STAGE] = GROW
    elif stage == PRUNE:
        if index >= count:
            state[STAGE] = SHAPES if state[GREW] == ENOUGH else GROW
            if not count:
                clear_set(memory, NOW)
            return NOTHING
        if may_be_without(memory, search, index):
            if rules.drops:
                state[STAGE] = WITHOUT
            else:
                state[INDEX] += 1
            return NOTHING
        memory.counts[ALONE] = 0
        append(memory, ALONE, memory.atoms[NOW, index], memory.family[NOW, index])
        return ALONE
    elif stage == WITHOUT:
        mark_one(memory, search, index)
        copy_others(memory, search, NOW, TRIAL)
        if memory.counts[TRIAL]:
            return TRIAL
        clear_set(memory, TRIAL)
        conclude_without(memory, search, rules)
    elif stage == GROW:
        offset = offset_of(memory, NOW)
        take_left(memory, NOW, 0.0)
        score_left(memory, noise, offset)
        least, found = np.sqrt(2.0 * rules.threshold / OFF_LATTICE), 0
        if count < rules.most:
            found = find_starts(bank, search.starts, memory.taxels[SCORED], rules.starts, least)
        if not found:
            after_growth(search)
            return NOTHING
        for seed in range(found):
            for i in range(PARAMETERS):
                search.seeds[seed, i] = search.starts.starts[seed, i]
        state[COUNT], state[SEED], state[OF], state[RIVAL] = found, 0, BALL, 0
        state[FOUND], state[TRIED], state[KIND], state[STAGE] = 0, 0, NO_SHAPE, SEEDS
    elif stage == SEEDS:
        left, tried = 2 * state[COUNT] - state[SEED], min(state[SEED], state[COUNT])
        if state[KIND] == NO_SHAPE and tried and state[UNTIL] and not count:
            steps = 2 * HEAT * left
            if now_ns(memory.marks) + int(steps * memory.sums[PACE]) > state[UNTIL]:
                state[COUNT], state[STAGE] = tried, JOIN  # there is no time for all
                return NOTHING
        memory.counts[ALONE] = 0
        append(memory, ALONE, search.seeds[state[SEED] % state[COUNT]], state[OF])
        return ALONE
    elif stage == JOIN:
        chosen, last = best_seed(search, state[COUNT]), len(search.seeds) - 1
        copy_set(memory, NOW, TRIAL)
        append(memory, TRIAL, search.seeds[chosen], BALL)
        for i in range(PARAMETERS):
            search.seeds[last, i] = search.seeds[chosen, i]
        return TRIAL
    elif stage == RIVALS:
        state[STAGE] = OTHERS
        if not next_rival(memory, search):
            copy_set(memory, BEST, NOW)
            state[FOUND], state[RIVAL], state[GREW], state[STAGE] = 0, 0, 1, GROW
    elif stage == OTHERS:
        copy_others(memory, search, NOW, TRIAL)
        if state[KIND] > A_RING:
            change_shape(memory, search)
            state[STAGE] = SHAPE
            return TRIAL
        if memory.counts[TRIAL]:
            return TRIAL
        take_left(memory, TRIAL, 0.0)
        seed_shapes(memory, search)
    elif stage == SHAPE:
        copy_others(memory, search, NOW, TRIAL)
        append(memory, TRIAL, search.seeds[best_seed(search, state[COUNT])], state[OF])
        return TRIAL
    elif stage == SHAPES:
        if state[DUE] or count != state[COMPARED]:
            state[MOVE], state[DUE] = 0, 0
        state[COMPARED], state[STAGE] = count, OTHERS
        if not next_shape(memory, search, rules):
            state[STAGE] = DONE
    elif stage == BELIEVE:
        if state[TRIED] >= count:
            state[STAGE] = DONE
            return NOTHING
        state[INDEX] = index = (state[FIRST_OPEN] + state[TRIED]) % count
        state[TRIED] += 1
        few = was_there(memory, post, index) or rules.hurried
        if (post.known[index] == KNOWN and holds(memory, post, index)) or (few and state[GREW]):
            return NOTHING  # of atoms that were there, one is explored
        state[PLACES_LEFT] = FEW if few else PLACES
        laplace(model, memory, index, post.local)
        certain = widest_deviation(post, 1.0) < CERTAIN
        if certain or not few:
            curve(model, memory, post, index, KNOWN if certain else ROUGH)
        if certain:
            return NOTHING
        if few:
            state[GREW], state[FIRST_OPEN] = 1, index + 1
        mark_one(memory, search, index)
        copy_others(memory, search, NOW, TRIAL)
        if memory.counts[TRIAL]:
            state[STAGE] = APART
            return TRIAL
        take_left(memory, TRIAL, offset_of(memory, NOW))
        begin_walk(bank, memory, search, post, rules, noise)
    elif stage == APART:
        return TRIAL
    else:
        if next_place(model, memory, post, search.seeds):
            return ALONE
        if post.walk[BOTH]:
            post.walk[BOTH] = 0
            start_walk(post, search.seeds, state[COUNT], FLAT)
            return NOTHING
        memory.sums[SHARED] = search.known[1]
        combine(post, index, memory.family[NOW, index], search.seeds[0])
        for i in range(PARAMETERS):
            post.atoms[index, i] = search.seeds[0, i]
        post.family[index], post.known[index] = memory.family[NOW, index], KNOWN
        state[STAGE] = BELIEVE
    return NOTHING


@inner(_nrt=False)
def curve(
    model: FitModel, memory: FitMemory, post: PosteriorMemory, index: int, known: int
) -> None:
    """Describe an atom by the curvature of the cost alone."""
    laplace(model, memory, index, post.local)
    for i in range(PARAMETERS):
        post.atoms[index, i] = memory.atoms[NOW, index, i]
        post.offsets[index, i] = 0.0
        for j in range(PARAMETERS):
            post.covariance[index, i, j] = post.local[i, j]
    post.family[index], post.known[index] = memory.family[NOW, index], known


@inner(_nrt=False)
def lay_open(model: FitModel, memory: FitMemory, post: PosteriorMemory) -> None:
    """Describe what is new about the atoms of NOW by the curvature of the cost alone."""
    count = memory.counts[NOW]
    for index in range(len(post.known)):
        if index >= count:
            post.known[index] = UNKNOWN
        elif not (holds(memory, post, index) or was_there(memory, post, index)):
            curve(model, memory, post, index, ROUGH)


@inner(_nrt=False)
def conclude_without(memory: FitMemory, search: SearchMemory, rules: SearchRules) -> None:
    """Take away an atom of NOW, which TRIAL lacks, if it does not bring enough."""
    state = search.state
    state[STAGE], state[INDEX] = PRUNE, state[INDEX] + 1
    if memory.costs[TRIAL] - memory.costs[NOW] < rules.threshold:
        copy_set(memory, TRIAL, NOW)
        state[INDEX] = 0


@inner(_nrt=False)
def conclude(
    model: FitModel,
    bank: Templates,
    memory: FitMemory,
    search: SearchMemory,
    post: PosteriorMemory,
    rules: SearchRules,
    noise: Floats,
) -> None:
    """Draw the consequence of what was refined, and set the next stage."""
    state = search.state
    stage = state[STAGE]
    if stage == REFINE:
        state[STAGE], state[INDEX] = PRUNE, 0
    elif stage == PRUNE:
        if worth(memory) > CLEAR * rules.threshold:
            state[INDEX] += 1
        else:
            state[STAGE] = WITHOUT
    elif stage == WITHOUT:
        conclude_without(memory, search, rules)
    elif stage == SEEDS:
        seed, count = state[SEED] % state[COUNT], state[COUNT]
        search.costs[seed] = memory.costs[ALONE]
        for i in range(PARAMETERS):
            search.seeds[seed, i] = memory.atoms[ALONE, 0, i]
        better = not state[FOUND] or memory.costs[ALONE] < memory.costs[BEST]
        if better and state[KIND] == NO_SHAPE and not memory.counts[NOW]:
            copy_set(memory, ALONE, BEST)  # an answer, as the row LEFT is that of READINGS
            state[FOUND] = 1
        state[SEED] += 1
        if state[SEED] == count:
            search.known[2] = few_best(search, count)
        while (
            count <= state[SEED] < 2 * count and search.costs[state[SEED] - count] > search.known[2]
        ):
            state[SEED] += 1
        if state[SEED] >= 2 * count:
            state[STAGE] = JOIN if state[KIND] == NO_SHAPE else SHAPE
    elif stage == JOIN:
        if not state[TRIED] or memory.costs[TRIAL] < memory.costs[BEST] - BETTER:
            copy_set(memory, TRIAL, BEST)
            state[FOUND] = 1
        state[TRIED] += 1
        if state[TRIED] < min(TRIED_MOST, state[COUNT]):
            return
        if memory.costs[NOW] - memory.costs[BEST] >= rules.threshold:
            search.known[0] = evidence(model, memory, BEST)
            state[RIVAL], state[INDEX], state[KIND], state[STAGE] = 1, 0, 0, RIVALS
        else:
            state[FOUND] = 0
            after_growth(search)
    elif stage == OTHERS:
        take_left(memory, TRIAL, 0.0)
        seed_shapes(memory, search)
    elif stage == SHAPE:
        value = evidence(model, memory, TRIAL)
        if state[RIVAL]:
            if value > search.known[0] + BETTER:
                copy_set(memory, TRIAL, BEST)
                search.known[0] = value
            state[KIND], state[STAGE] = state[KIND] + 1, RIVALS
        else:
            state[MOVE], state[STAGE] = state[MOVE] + 1, SHAPES
            sliced = state[RESUMED] or memory.marks[PAUSE]  # readings may be others each time
            margin = CLEARLY if sliced else BETTER
            if value > evidence(model, memory, NOW) + margin:
                copy_set(memory, TRIAL, NOW)
                state[MOVE] = 0  # all anew: the order of the atoms is another one, too
                state[COMPARED] = memory.counts[NOW]
    elif stage == APART:
        take_left(memory, TRIAL, offset_of(memory, NOW))
        begin_walk(bank, memory, search, post, rules, noise)
    else:
        keep_place(memory, post)


@inner(_nrt=False)
def go_on(
    model: FitModel,
    memory: FitMemory,
    search: SearchMemory,
    post: PosteriorMemory,
    deadline: int,
) -> None:
    """Bring what was interrupted to new readings."""
    state = search.state
    stage = state[STAGE]
    if memory.counts[NOW]:  # by the weights of the search
        descend(model, memory, NOW, READINGS, 0, 1, SETTLED_GAIN, deadline)
    else:
        clear_set(memory, NOW)
    if state[FOUND]:
        descend(model, memory, BEST, READINGS, 0, 1, SETTLED_GAIN, deadline)
        if state[RIVAL]:
            search.known[0] = evidence(model, memory, BEST)
    if stage == REFINE:
        state[STAGE], state[INDEX], state[REFINED] = PRUNE, 0, NOTHING
    elif stage == SEEDS:
        if state[KIND] == NO_SHAPE:
            take_left(memory, NOW, 0.0)
        else:
            copy_others(memory, search, NOW, TRIAL)
            if memory.counts[TRIAL]:
                descend(model, memory, TRIAL, READINGS, 0, 0, SETTLED_GAIN, 0)
            take_left(memory, TRIAL, 0.0)
    elif stage == WALK:  # what it began with, stays
        search.known[1], memory.sums[SHARED] = memory.sums[SHARED], 0.0


@inner(_nrt=False)
def search_atoms(
    model: FitModel,
    bank: Templates,
    memory: FitMemory,
    search: SearchMemory,
    post: PosteriorMemory,
    rules: SearchRules,
    noise: Floats,
    shapes: bool,
    resume: bool,
    deadline: int,
) -> bool:
    """Find the atoms of the row READINGS, from those of NOW on.

    Where the time was up before all was tried, it may go on with other readings, to which NOW was
    moved; but not where what was found so far has become NOW.

    Parameters
    ----------
    model : FitModel
    bank : Templates
    memory : FitMemory
        With readings and weights; its set NOW becomes the answer.
    search : SearchMemory
    post : PosteriorMemory
        Becomes what is open about the atoms of the answer.
    rules : SearchRules
    noise : (L,) array
        By which the dictionary was whitened.
    shapes : bool
        Compare all shapes, also those of as many atoms as before.
    resume : bool
        Go on where the last search was interrupted.
    deadline : int, ns
        Of the clock; 0 for none.

    Returns
    -------
    bool
        Whether it may go on; False where it is done, too.
    """
    state = search.state
    state[UNTIL], state[RESUMED] = deadline, resume
    memory.marks[STEPPED] = 0
    if resume:
        state[CARRIED] += 1
        go_on(model, memory, search, post, deadline)
    else:
        state[STAGE] = REFINE if rules.purpose == SEEK else BELIEVE
        state[INDEX], state[GREW], state[FOUND], state[RIVAL] = 0, 0, 0, 0
        state[DUE], state[REFINED], state[TRIED], state[CARRIED] = shapes, NOTHING, 0, 0
    turns = 0
    while state[STAGE] != DONE:
        if turns and is_late(memory, NOW, deadline):  # one is taken in any case
            break
        memory.marks[LATE], turns = 0, turns + 1
        which, grows = state[REFINED], state[STAGE] == GROW
        if which == NOTHING:
            if grows and is_short(memory, SEEDING, 1, deadline):
                break
            which = begin(model, bank, memory, search, post, rules, noise)
            if grows:
                take_pace(memory, SEEDING, 1)
        if which == NOTHING:
            continue
        state[REFINED] = which
        stage = state[STAGE]
        row = LEFT if stage in (SEEDS, WALK) else READINGS
        held, steps, gain = 0, LONG, SETTLED_GAIN
        if stage in (REFINE, SEEDS):
            steps = HEAT if stage == SEEDS and state[SEED] < state[COUNT] else BURST
        elif stage in (PRUNE, APART, OTHERS):
            steps = 0  # what it is read as
        elif stage == WALK:
            held, steps, gain = 2, WALK_STEPS, WALK_GAIN
        descend(model, memory, which, row, held, steps, gain, deadline)
        if memory.marks[LATE]:
            if state[CARRIED] < FOLLOWED:
                break
            memory.marks[LATE] = 0  # it never settles, as the readings move
        state[REFINED], state[CARRIED] = NOTHING, 0
        conclude(model, bank, memory, search, post, rules, noise)
    if not memory.marks[LATE]:
        return False
    if state[STAGE] == WALK:
        memory.sums[SHARED] = search.known[1]
    if state[FOUND] and memory.costs[NOW] - memory.costs[BEST] >= rules.threshold:
        copy_set(memory, BEST, NOW)
        return False
    return True
