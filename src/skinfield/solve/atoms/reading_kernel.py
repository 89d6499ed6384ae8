"""Contact fit of a reading, compiled: from what the taxels read to contacts, any time.

A reading first moves the atoms of the reading before: that is an answer. Then the model error is
inferred, and what is open about each atom. Where readings have changed, other sets of atoms are
compared: more of them, in other shapes, by a better model, without each. That goes on reading by
reading, in pieces, for as long as the time allows, from where it was interrupted.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Floats
from skinfield.solve.atoms.alternatives_kernel import (
    BETTER,
    EXPLORE,
    SEEK,
    SearchRules,
    apart,
    clear_set,
    copy_others,
    evidence,
    mark_one,
    take_left,
)
from skinfield.solve.atoms.dictionary import best_score
from skinfield.solve.atoms.fit_kernel import (
    LATE,
    MOST,
    NOW,
    READINGS,
    SCORED,
    STEPPED,
    STEPS,
    TRIAL,
    WHITE,
    descend,
    is_late,
    is_short,
)
from skinfield.solve.atoms.misfit_kernel import (
    explains,
    infer,
    learn,
    noise_scale,
    take_noise,
    take_offset,
    weigh,
)
from skinfield.solve.atoms.posterior_kernel import UNKNOWN
from skinfield.solve.atoms.reading_memory import (
    BEFORE,
    COMPARED,
    DRAWN,
    DROPPING,
    EXPLAINED,
    HALFWAY,
    IN_VAIN,
    INDEX,
    IS_STRONG,
    LEAST_WORTH,
    MEAN_NOISE,
    MISFIT,
    OFFSET,
    ONLY,
    OPEN_HALFWAY,
    OTHER_MISFIT,
    OTHER_SCALE,
    OTHER_TOTAL,
    OTHERS,
    REFINING,
    RESTING,
    SCALE,
    SEARCHED_BY,
    SEEKING,
    SINCE,
    SPLIT_NOISE,
    SPLITTING,
    SPREAD,
    STAGE,
    TOTAL,
    TURN,
    WEIGHED,
    Fit,
    forget,
    unpack_fit,
)
from skinfield.solve.atoms.rows_kernel import unpack_grid, write_rows
from skinfield.solve.atoms.search_kernel import (
    BURST,
    OFF_LATTICE,
    SETTLED_GAIN,
    lay_open,
    search_atoms,
)
from skinfield.solve.atoms.split_kernel import (
    FOUND,
    MAYBE,
    PAIRS,
    add_rival,
    are_known,
    are_two,
    choose_pairs,
    forget_rivals,
    keep_former,
    leave_out,
    list_templates,
    nearest_to,
    put_pair,
    scan_pairs,
    state_rivals,
    take_former,
    take_spread,
    unite,
)
from skinfield.solve.clock import now_ns

COARSE = 0.1  # model error at which contacts are sought first, and at most
FINER = 0.25  # part of the inferred one, at which more of them are sought
STRONG = 20.0  # deviations of a reading, from which the model may be what is wrong
LARGEST = 0.2  # model error, from which on contacts explain nothing
ROUNDS = 5  # of searches, until the noise is as what is left over
RISE, FALL = 1.5, 3.0  # of the readings' squares over the noise: then shapes are compared again
QUIETER = 2.0  # times the stated precision, from which the noise is less than was stated
REWEIGHED = 1.3  # times: a model error that differs by less is not weighed by again
FAINT = 4.0  # times what an atom must bring: below, it is looked at whether it does,
FAINTER, FAINTEST = 0.7, 2.0  # times what it was when it was looked at last; and always below
INFERRING, SCORING = 5.0, 3.0  # steps: the model error, and what is left over, take as long
LISTING, SCANNING, SCANNED_AT_ONCE = 10.0, 1.0, 8  # steps, and templates: of pairs in its place
AGAIN = 16  # readings, after which it is looked again whether one is two, or two are one
QUIETER_AGAIN = 0.7  # times the noise then, likewise: averages are of more readings
FORMER = -1  # instead of the number of an atom: all those of the reading before
CLEARLY = 6.0  # ln odds by which fewer are more probable than those that the reading before had
SETTLINGS = 2  # of two in the place of one: each by the model error that the one before infers
HOPELESS = 8.0  # ln odds against two after the first of these, beyond which there is no second
MORE = 1.3  # times the score of what was sought in vain, from which it is sought again
FASTER, SLOWER = 0.98, 1.3  # how far one answer may move what is known of that


@inner(_nrt=False)
def set_aside(fit: Fit) -> None:
    """Keep the answer while others are compared."""
    own, memory = fit.own, fit.memory
    own.marks[OTHERS] = memory.counts[NOW]
    for n in range(memory.counts[NOW]):
        own.family[n] = memory.family[NOW, n]
        for i in range(6):
            own.atoms[n, i] = memory.atoms[NOW, n, i]
    for k in range(4):
        own.numbers[OTHER_SCALE + k] = own.numbers[NUMBERS[k]]


NUMBERS = (SCALE, MISFIT, SPREAD, TOTAL)


@inner(_nrt=False)
def exchange(fit: Fit) -> None:
    """Have NOW be the set that is kept aside, and the other way round."""
    own, memory = fit.own, fit.memory
    count = max(own.marks[OTHERS], memory.counts[NOW])
    for n in range(count):
        memory.family[NOW, n], own.family[n] = own.family[n], memory.family[NOW, n]
        for i in range(6):
            atom = memory.atoms[NOW, n, i]
            memory.atoms[NOW, n, i] = own.atoms[n, i]
            own.atoms[n, i] = atom
    memory.counts[NOW], own.marks[OTHERS] = own.marks[OTHERS], memory.counts[NOW]
    for k in range(4):
        value = own.numbers[NUMBERS[k]]
        own.numbers[NUMBERS[k]] = own.numbers[OTHER_SCALE + k]
        own.numbers[OTHER_SCALE + k] = value


@inner(_nrt=False)
def search_by(fit: Fit, purpose: int, resume: bool, deadline: int) -> bool:
    """Search with the present weights; whether it may go on later."""
    rules = SearchRules(fit.rules.threshold, fit.rules.most, fit.rules.starts, purpose)
    return search_atoms(
        fit.model,
        fit.bank,
        fit.memory,
        fit.search,
        fit.post,
        rules,
        fit.own.heard,
        fit.own.marks[ONLY] < 0,
        resume,
        deadline,
    )


@inner(_nrt=False)
def search_round(fit: Fit, error: float, common: float, resume: bool, deadline: int) -> bool:
    """Search with a model error, and infer noise and error by what is found; False if not done."""
    own, memory = fit.own, fit.memory
    while True:
        weigh(fit, min(error, COARSE), common)
        own.marks[HALFWAY] = search_by(fit, SEEK, resume, deadline)
        if memory.marks[LATE]:
            return False
        resume = False
        step = noise_scale(fit)
        own.marks[TURN] += 1
        if step == 1.0 or own.marks[TURN] >= ROUNDS:
            infer(fit, common)
            return True
        if not (step < 1.0 and own.numbers[SCALE] <= 1.0):
            if own.marks[STAGE] == SEEKING:
                set_aside(fit)  # an answer, should the time be up
            memory.counts[NOW] = 0
        own.numbers[SCALE] *= step


@inner(_nrt=False)
def compare(fit: Fit, common: float, deadline: int) -> None:
    """Go on with the comparison of other sets of atoms, until the time is up."""
    own, memory, marks = fit.own, fit.memory, fit.own.marks
    while marks[STAGE] != RESTING and not memory.marks[LATE]:
        resume = marks[HALFWAY] == 1
        stage = marks[STAGE]
        if stage == SEEKING:
            if not resume:
                marks[TURN] = 0
            if search_round(fit, own.numbers[SEARCHED_BY], common, resume, deadline):
                marks[STAGE] = REFINING if marks[IS_STRONG] else DROPPING
                marks[INDEX] = FORMER
                if marks[ONLY] == memory.counts[NOW]:
                    marks[STAGE] = RESTING
                marks[ONLY] = -1
            elif not memory.counts[NOW] and marks[OTHERS]:
                exchange(fit)
                marks[HALFWAY] = 0
        elif stage == REFINING:
            if marks[HALFWAY]:
                exchange(fit)
            else:
                marks[TURN] = 0
                set_aside(fit)
                own.numbers[SEARCHED_BY] = FINER * min(own.numbers[MISFIT], COARSE)
            if not search_round(fit, own.numbers[SEARCHED_BY], common, resume, deadline):
                if memory.marks[STEPS] >= memory.marks[MOST] > 0:
                    infer(fit, common)
                    if own.numbers[TOTAL] > own.numbers[OTHER_TOTAL] + BETTER:
                        marks[STAGE] = SEEKING  # from here on it is the answer
                        return
                marks[HALFWAY] = 2 - marks[HALFWAY]
                exchange(fit)
            elif not own.numbers[TOTAL] > own.numbers[OTHER_TOTAL] + BETTER:
                exchange(fit)
                marks[STAGE], marks[INDEX] = DROPPING, FORMER
        elif stage == DROPPING:
            if marks[INDEX] == FORMER:
                try_former(fit, common, deadline)
            else:
                try_fewer(fit, common, deadline)
        else:
            try_more(fit, common, deadline)


@inner(_nrt=False)
def try_former(fit: Fit, common: float, deadline: int) -> None:
    """Go on with close atoms of the reading before, unless fewer are clearly more probable."""
    own, memory, marks, pairs = fit.own, fit.memory, fit.own.marks, fit.pairs
    if marks[HALFWAY]:
        exchange(fit)
    elif not 0 < memory.counts[NOW] < marks[BEFORE]:
        marks[INDEX] = 0
        return
    else:
        set_aside(fit)
        if not take_former(memory, pairs, marks[BEFORE]):
            exchange(fit)
            marks[INDEX] = 0
            return
    settle(fit, own.numbers[MISFIT], common, deadline)
    marks[HALFWAY] = memory.marks[LATE]
    if memory.marks[LATE]:
        exchange(fit)
        return
    infer(fit, common)
    marks[INDEX] = 0
    less = own.numbers[OTHER_TOTAL] - own.numbers[TOTAL]
    if not (less < CLEARLY and are_known(fit.model, memory, fit.post.local)):
        exchange(fit)


@inner(_nrt=False)
def try_fewer(fit: Fit, common: float, deadline: int) -> None:
    """Compare the answer with the next set of one atom less: without it, or two as one."""
    own, memory, marks, pairs = fit.own, fit.memory, fit.own.marks, fit.pairs
    index, count = marks[INDEX] // 2, memory.counts[NOW]
    other = -1 if marks[HALFWAY] or index >= count else nearest_to(memory, index)
    if marks[HALFWAY]:
        exchange(fit)
    else:
        if not marks[INDEX]:
            forget_rivals(pairs)
        if count < 2 or index >= count:
            marks[STAGE], marks[INDEX], pairs.state[FOUND] = SPLITTING, 0, 0
            return
        if (marks[INDEX] % 2 and other < index) or other < 0 <= marks[ONLY]:
            marks[INDEX] += 1
            return
        set_aside(fit)
        if marks[INDEX] % 2:
            unite(memory, index, other)
            index = other
        leave_out(memory, index)
    settle(fit, own.numbers[MISFIT], common, deadline)
    marks[HALFWAY] = memory.marks[LATE]
    if memory.marks[LATE]:
        exchange(fit)
        return
    infer(fit, common)
    odds = own.numbers[OTHER_TOTAL] - own.numbers[TOTAL]
    likely = odds < MAYBE  # and not so as a worse model leaves atoms little to explain
    if likely and own.numbers[MISFIT] > own.numbers[OTHER_MISFIT]:
        likely = are_known(fit.model, memory, fit.post.local)
    if likely and odds < -(CLEARLY if memory.counts[NOW] < marks[BEFORE] else BETTER):
        marks[INDEX] = 0
        return
    index, united = marks[INDEX] // 2, marks[INDEX] % 2
    marks[INDEX] += 1
    exchange(fit)
    other = nearest_to(memory, index)
    if not likely or other < 0 or apart(memory, NOW, index, other) < 0.0:
        return
    rival = index if united else other - (other > index)
    exchange(fit)
    take_spread(fit.model, memory, pairs, rival, rival, fit.post.local)
    exchange(fit)
    one, atom, its = own.atoms[rival], memory.atoms[NOW, index], memory.atoms[NOW, other]
    share = 1.0 / (1.0 + np.exp(its[2] - atom[2]))
    add_rival(pairs, index, atom, odds, 1, one, one, share)
    add_rival(pairs, other, its, odds, 1, one, one, 1.0 - share)


@inner(_nrt=False)
def propose_pairs(fit: Fit, index: int, common: float, deadline: int) -> None:
    """Find pairs that may be in the place of an atom of NOW; FOUND is -1 until it is done."""
    memory, search, pairs = fit.memory, fit.search, fit.pairs
    state = pairs.state
    if state[FOUND] >= 0:
        if is_short(memory, LISTING, deadline):
            return
        weigh(fit, min(fit.own.numbers[MISFIT], fit.rules.model_error), common)
        mark_one(memory, search, index)
        copy_others(memory, search, NOW, TRIAL)
        if memory.counts[TRIAL]:
            descend(fit.model, memory, TRIAL, READINGS, 0, 0, SETTLED_GAIN, 0)
        take_left(memory, TRIAL, fit.own.numbers[OFFSET])
        descend(fit.model, memory, NOW, READINGS, 0, 0, SETTLED_GAIN, 0)
        list_templates(fit.model, fit.bank, memory, pairs, index)
        state[FOUND] = -1
    while scan_pairs(fit.bank, pairs, SCANNED_AT_ONCE):
        if is_short(memory, SCANNING, deadline):
            return
    choose_pairs(fit.bank, pairs)


@inner(_nrt=False)
def try_more(fit: Fit, common: float, deadline: int) -> None:
    """Compare the answer with the next set of two atoms in the place of one."""
    own, memory, marks, pairs = fit.own, fit.memory, fit.own.marks, fit.pairs
    index, turn = marks[INDEX] // PAIRS, marks[INDEX] % PAIRS
    if marks[HALFWAY]:
        exchange(fit)
    else:
        count = memory.counts[NOW]
        if index >= count or count >= fit.rules.most:
            state_rivals(memory, pairs)
            marks[STAGE], marks[SINCE] = RESTING, 0
            own.numbers[SPLIT_NOISE] = own.numbers[MEAN_NOISE]
            return
        if not turn:
            propose_pairs(fit, index, common, deadline)
            if memory.marks[LATE]:
                return
        if turn >= pairs.state[FOUND]:
            marks[INDEX] = PAIRS * (index + 1)
            return
        set_aside(fit)
        put_pair(memory, pairs, index, turn)
        marks[TURN] = 0
        own.numbers[MISFIT] = min(own.numbers[MISFIT], fit.rules.model_error)
    last = memory.counts[NOW] - 1
    while marks[TURN] < SETTLINGS:
        settle(fit, own.numbers[MISFIT], common, deadline)
        marks[HALFWAY] = memory.marks[LATE]
        if memory.marks[LATE]:
            exchange(fit)
            return
        infer(fit, common)
        marks[TURN] += 1
        if own.numbers[TOTAL] < own.numbers[OTHER_TOTAL] - HOPELESS:
            break
    odds = own.numbers[OTHER_TOTAL] - own.numbers[TOTAL]
    two = odds < MAYBE and are_two(fit.model, memory, index, last, fit.post.local)
    if two and odds < -BETTER:
        marks[STAGE], marks[INDEX] = DROPPING, 0
        return
    if two:
        take_spread(fit.model, memory, pairs, index, last, fit.post.local)
    exchange(fit)
    marks[INDEX] += 1
    if two:
        first, second = own.atoms[index], own.atoms[last]
        add_rival(pairs, index, memory.atoms[NOW, index], odds, 2, first, second, 1.0)


@inner(_nrt=False)
def settle(fit: Fit, error: float, common: float, deadline: int) -> None:
    """Move the atoms of NOW to the minimum, weighed by a model error."""
    weigh(fit, error, common)
    memory = fit.memory
    if memory.counts[NOW]:
        descend(fit.model, memory, NOW, READINGS, 0, BURST, SETTLED_GAIN, deadline)
    else:
        clear_set(memory, NOW)


@inner(_nrt=False)
def least_worth(fit: Fit) -> float:
    """About what an atom of NOW saves in cost, at least: by the curvature along its force."""
    memory, size, least = fit.memory, 6 * fit.memory.counts[NOW], np.inf
    for n in range(memory.counts[NOW]):
        force = 6 * n + 2
        least = min(least, 0.5 * memory.hessian[NOW, force * size + force])
    return least


@inner(_nrt=False)
def score_of_left(fit: Fit) -> float:
    """Highest agreement of what is left over with a contact, in deviations."""
    memory = fit.memory
    scored, white, predicted = memory.taxels[SCORED], memory.taxels[WHITE], memory.predicted[NOW]
    for taxel in range(len(scored)):
        left = memory.taxels[READINGS, taxel] - predicted[taxel] - fit.own.numbers[OFFSET]
        scored[taxel] = left * white[taxel]
    return best_score(fit.bank, fit.search.starts, scored)


@inner(_nrt=False)
def begin_comparison(fit: Fit, error: float, only: bool) -> None:
    """Have all be compared anew, from the atoms of NOW on; `only` more or fewer of them."""
    fit.own.marks[ONLY] = fit.memory.counts[NOW] if only else -1
    keep_former(fit.memory, fit.pairs)
    fit.own.marks[BEFORE] = fit.memory.counts[NOW]
    fit.own.marks[STAGE], fit.own.marks[HALFWAY], fit.own.marks[OPEN_HALFWAY] = SEEKING, 0, 0
    fit.own.numbers[SEARCHED_BY], fit.own.marks[OTHERS] = error, 0


@inner(_nrt=False)
def find_contacts(fit: Fit, readings: Floats, valid: NDArray[np.bool_], deadline: int) -> int:
    """Find the contacts of readings (L,), 0 where not `valid` (L,), by a deadline in ns, or 0.

    The set NOW becomes the answer, with what is open about it in `post`. Returns the time at which
    the search for it ended.
    """
    own, memory, marks, numbers = fit.own, fit.memory, fit.own.marks, fit.own.numbers
    memory.marks[LATE] = memory.marks[STEPS] = memory.marks[STEPPED] = 0
    common = fit.rules.common_mode * take_noise(fit, valid)
    energy, highest = 0.0, 0.0
    for taxel in range(len(readings)):
        memory.taxels[READINGS, taxel] = readings[taxel]
        over = readings[taxel] / own.heard[taxel]
        energy += over * over
        highest = max(highest, abs(over))
    marks[IS_STRONG] = highest > STRONG
    if not fit.rules.warm:
        memory.counts[NOW] = 0
        forget(own, fit.rules.model_error)
    if memory.counts[NOW]:
        follow(fit, energy, common, deadline)
    else:
        numbers[SCALE], numbers[COMPARED], numbers[IN_VAIN] = 1.0, energy, 0.0
        for index in range(len(fit.post.known)):
            fit.post.known[index] = UNKNOWN
        begin_comparison(fit, COARSE if marks[IS_STRONG] else FINER * COARSE, False)
        if is_late(memory, NOW, deadline):
            settle(fit, numbers[SPREAD], common, 0)
    ended = now_ns(memory.marks)
    if marks[STAGE] != RESTING and not memory.marks[LATE]:
        compare(fit, common, deadline)
        ended = now_ns(memory.marks)
        if marks[STAGE] == RESTING and memory.counts[NOW]:
            infer(fit, common)
            learn(fit)
            numbers[IN_VAIN] = -1.0
        memory.marks[LATE] = marks[STAGE] != RESTING
        settle(fit, numbers[SPREAD], common, 1 if memory.marks[LATE] else deadline)
        if memory.marks[STEPS] >= memory.marks[MOST] > 0:
            infer(fit, common)
        elif memory.marks[LATE]:
            numbers[TOTAL] = evidence(fit.model, memory, NOW)
    if not memory.marks[LATE]:
        marks[OPEN_HALFWAY] = search_by(fit, EXPLORE, marks[OPEN_HALFWAY] == 1, deadline)
        ended = now_ns(memory.marks)
    lay_open(fit.model, memory, fit.post)
    marks[EXPLAINED] = explains(fit) and numbers[MISFIT] < LARGEST
    fit.search.known[0] = evidence(fit.model, memory, NOW)
    return ended


@inner(_nrt=False)
def follow(fit: Fit, energy: float, common: float, deadline: int) -> None:
    """Move the atoms of the reading before, and see whether others are to be compared."""
    memory, marks, numbers = fit.memory, fit.own.marks, fit.own.numbers
    settle(fit, numbers[SPREAD], common, deadline)
    if memory.marks[LATE]:
        return
    before, scale = numbers[COMPARED], 1.0
    if marks[STAGE] == RESTING:  # else there may be touches among what is left over
        scale = noise_scale(fit)
    if not before / FALL < energy < before * RISE:
        numbers[COMPARED], numbers[IN_VAIN] = energy, 0.0
        begin_comparison(fit, numbers[MISFIT], False)
    if scale < 1.0 and numbers[SCALE] <= 1.0:
        numbers[SCALE] *= scale
    elif scale != 1.0:
        numbers[SCALE] *= scale
        memory.counts[NOW] = 0
        begin_comparison(fit, numbers[MISFIT], False)
        return
    if marks[STAGE] == SEEKING or is_short(memory, INFERRING, deadline):
        return
    infer(fit, common)
    learn(fit)
    if marks[STAGE] != RESTING or is_short(memory, SCORING, deadline):
        return
    ratio = numbers[SPREAD] / numbers[WEIGHED]
    if not 1.0 / REWEIGHED < ratio < REWEIGHED:
        settle(fit, numbers[SPREAD], common, deadline)
        if memory.marks[LATE]:
            return
    take_offset(fit)
    score, worth = score_of_left(fit), least_worth(fit)
    if numbers[IN_VAIN] < 0.0:  # as sets of atoms were just compared
        numbers[IN_VAIN], numbers[LEAST_WORTH] = score, worth
    least = np.sqrt(2.0 * fit.rules.threshold / OFF_LATTICE)
    known = max(FAINTER * numbers[LEAST_WORTH], FAINTEST * fit.rules.threshold)
    faint = worth < min(FAINT * fit.rules.threshold, known)
    if faint or score > max(least, MORE * numbers[IN_VAIN]):
        begin_comparison(fit, numbers[MISFIT], True)
        return
    marks[SINCE] += 1
    if marks[SINCE] >= AGAIN or numbers[MEAN_NOISE] < QUIETER_AGAIN * numbers[SPLIT_NOISE]:
        begin_comparison(fit, numbers[MISFIT], True)
        marks[STAGE], marks[INDEX] = DROPPING, 0
    else:
        numbers[IN_VAIN] = min(numbers[IN_VAIN], score)
        numbers[LEAST_WORTH] = max(numbers[LEAST_WORTH], worth)


@njit
def answer_reading(
    fit_address: int,
    grid_address: int,
    pressure: Floats,
    rows: Any,
    readings: Floats,
    valid: NDArray[np.bool_],
    deadline: int,
) -> int:
    """Write pressure (K,), Pa, and the rows of the contacts of a reading; how many there are.

    Parameters
    ----------
    fit_address, grid_address : int
        Of a `Fit` and a `RowGrid`, packed.
    pressure : (K,) array, Pa
    rows : array of CONTACT
    readings : (L,) array, in the quantity's unit
    valid : (L,) bool array
    deadline : int, ns
        Of the clock; 0 for none.
    """
    fit, grid = unpack_fit(fit_address), unpack_grid(grid_address)
    own, memory = fit.own, fit.memory
    end = deadline - int(own.numbers[DRAWN]) if deadline else 0
    ended = find_contacts(fit, readings, valid, max(end, 1) if deadline else 0)
    highest, lowest = 0.0, np.inf
    for taxel in range(len(readings)):
        highest = max(highest, memory.taxels[WHITE, taxel])
        lowest = min(lowest, own.heard[taxel])
    at_mean = not highest * lowest > QUIETER
    error = own.numbers[SPREAD]
    count = write_rows(
        grid, memory, fit.post, fit.pairs, at_mean, error, fit.drawing, pressure, rows
    )
    took = now_ns(memory.marks) - ended
    before = own.numbers[DRAWN]
    own.numbers[DRAWN] = min(max(took, FASTER * before), SLOWER * before)
    return count
