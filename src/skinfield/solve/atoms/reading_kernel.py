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
    ODD,
    SEEK,
    SearchRules,
    evidence,
    may_be_without,
)
from skinfield.solve.atoms.atom_readings import PARAMETERS, is_long
from skinfield.solve.atoms.count_kernel import (
    exchange,
    set_aside,
    settle,
    try_fewer,
    try_more,
)
from skinfield.solve.atoms.dictionary import best_score
from skinfield.solve.atoms.fit_kernel import (
    INFERRING,
    LATE,
    MOST,
    NOW,
    PACE,
    PAUSE,
    READINGS,
    SCORED,
    SCORING,
    STEPPED,
    STEPS,
    WHITE,
    is_late,
    is_short,
    nearly_slowest,
    take_pace,
)
from skinfield.solve.atoms.misfit_kernel import (
    explains,
    infer,
    learn,
    noise_scale,
    take_change,
    take_noise,
    take_offset,
    weigh,
)
from skinfield.solve.atoms.posterior_kernel import UNKNOWN
from skinfield.solve.atoms.reading_memory import (
    BEFORE,
    COMPARED,
    COMPARED_SPREAD,
    COMPARISON_FIRST,
    DRAWN,
    DROPPING,
    DUTIES,
    DUTY,
    ERROR_FIRST,
    EXPLAINED,
    FORMER_COUNT,
    GOES_ON,
    GRADUAL,
    HALFWAY,
    HOPELESS,
    IN_VAIN,
    INDEX,
    IS_STRONG,
    LAST_X,
    LAST_Y,
    LEAST_WORTH,
    MEAN_NOISE,
    MISFIT,
    OFFSET,
    ONLY,
    OPEN_FIRST,
    OPEN_FORCE,
    OPEN_HALFWAY,
    OPEN_PLACE,
    OTHER_TOTAL,
    OTHERS,
    REFINING,
    RESTED_SPREAD,
    RESTING,
    SCALE,
    SEARCHED_BY,
    SEEKING,
    SPLIT_NOISE,
    SPREAD,
    STAGE,
    STEPS_AT_ONCE,
    TOTAL,
    TURN,
    UNSURE_FORCE,
    UNSURE_PLACE,
    WEIGHED,
    Fit,
    forget,
    unpack_fit,
)
from skinfield.solve.atoms.rows_kernel import unpack_grid, write_rows
from skinfield.solve.atoms.search_kernel import (
    BURST,
    OFF_LATTICE,
    lay_open,
    search_atoms,
)
from skinfield.solve.atoms.strips_kernel import join_by_strips
from skinfield.solve.atoms.table import BALL
from skinfield.solve.clock import now_ns

COARSE = 0.1  # model error at which contacts are sought first, and at most
FINER = 0.25  # part of the inferred one, at which more of them are sought
FINER_GAIN = 0.5  # ln odds by which what that finds is chosen where it takes several readings
STRONG = 20.0  # deviations of a reading, from which the model may be what is wrong
LARGEST = 0.2  # model error, from which on contacts explain nothing
ROUNDS = 5  # of searches, until the noise is as what is left over
RISE, FALL = 1.5, 3.0  # of the readings' squares over the noise: then shapes are compared again
WORSE = 2.0  # times a model error, from which sets of atoms are compared at once
QUIETER = 2.0  # times the stated precision, from which the noise is less than was stated
REWEIGHED = 1.3  # times: a model error that differs by less is not weighed by again
FAINT = 4.0  # times what an atom must bring: below, it is looked at whether it does,
FAINTER = 0.7  # times what it was when it was looked at last
FEW_STEPS = 2  # of refinement, where other atoms are missed: these are sought
ENTRY = 4  # steps of each atom: less is no time to go on with a comparison
SLICE = 32  # steps of what may wait, in one reading, where the answer is as good as any
QUIETER_AGAIN = 0.7  # times the noise when it was looked at whether one is two: then it is again
MORE = 1.3  # times the score of what was sought in vain, from which it is sought again
FASTER = 0.98  # how far one answer may move what is known of what drawing takes, downwards
ELSEWHERE = 3.0  # thicknesses from one reading to the next: then it is another contact
OVERSHOOT = 0.25  # part of that by which work before it ends late at most


@inner(_nrt=False)
def search_by(fit: Fit, purpose: int, resume: bool, deadline: int) -> bool:
    """Search with the present weights; whether it may go on later."""
    own, hurried, drops = fit.rules, fit.own.marks[DUTY] > 0, fit.own.marks[FORMER_COUNT] == 0
    rules = SearchRules(own.threshold, own.most, own.starts, purpose, hurried, drops)
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
        if is_short(memory, INFERRING, max(memory.counts[NOW], 1), deadline):
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
                marks[INDEX] = 0
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
            margin = FINER_GAIN if resume else BETTER
            if not search_round(fit, own.numbers[SEARCHED_BY], common, resume, deadline):
                if memory.marks[STEPS] >= memory.marks[MOST] > 0:
                    infer(fit, common)
                    if own.numbers[TOTAL] > own.numbers[OTHER_TOTAL] + FINER_GAIN:
                        marks[STAGE] = SEEKING  # from here on it is the answer
                        return
                marks[HALFWAY] = 2 - marks[HALFWAY]
                exchange(fit)
            elif not own.numbers[TOTAL] > own.numbers[OTHER_TOTAL] + margin:
                exchange(fit)
                marks[STAGE], marks[INDEX] = DROPPING, 0
        elif stage == DROPPING:
            try_fewer(fit, common, deadline)
        else:
            try_more(fit, common, deadline)


@inner(_nrt=False)
def least_worth(fit: Fit) -> float:
    """About what an atom of NOW saves in cost, at least: by the curvature along its force."""
    memory, size, least = fit.memory, PARAMETERS * fit.memory.counts[NOW], np.inf
    for n in range(memory.counts[NOW]):
        force = PARAMETERS * n + 2
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
    fit.own.marks[FORMER_COUNT] = fit.memory.counts[NOW]
    fit.own.marks[STAGE], fit.own.marks[HALFWAY], fit.own.marks[OPEN_HALFWAY] = SEEKING, 0, 0
    fit.own.numbers[SEARCHED_BY], fit.own.marks[OTHERS] = error, 0
    fit.own.marks[GRADUAL] = 0


@inner(_nrt=False)
def begin_afresh(fit: Fit) -> None:
    """Have atoms be sought from none, as those of NOW need a large model error to explain it all.

    Once that is large, few atoms explain any readings, such as two small ones a sole that presses
    ever more.
    """
    set_aside(fit)
    others = fit.own.marks[OTHERS]
    fit.memory.counts[NOW] = 0
    begin_comparison(fit, COARSE if fit.own.marks[IS_STRONG] else FINER * COARSE, False)
    fit.own.marks[OTHERS] = others  # the answer, should the time be up


@inner(_nrt=False)
def find_contacts(fit: Fit, readings: Floats, valid: NDArray[np.bool_], deadline: int) -> int:
    """Find the contacts of readings (L,), 0 where not `valid` (L,), by a deadline in ns, or 0.

    The set NOW becomes the answer, with what is open about it in `post`. Returns the time at which
    the search for it ended.
    """
    own, memory, marks, numbers = fit.own, fit.memory, fit.own.marks, fit.own.numbers
    pressed = memory.marks[LATE] and memory.counts[NOW]
    marks[DUTY] = (marks[DUTY] + 1) % DUTIES if pressed else 0
    memory.marks[LATE] = memory.marks[STEPS] = memory.marks[STEPPED] = 0
    common = fit.rules.common_mode * take_noise(fit, valid)
    if not fit.rules.warm:
        memory.counts[NOW] = 0
        forget(own, fit.rules.model_error)
    take_change(fit, readings)
    energy, highest = 0.0, 0.0
    for taxel in range(len(readings)):
        memory.taxels[READINGS, taxel] = readings[taxel]
        over = readings[taxel] / own.heard[taxel]
        energy += over * over
        highest = max(highest, abs(over))
    marks[IS_STRONG] = highest > STRONG
    if memory.counts[NOW]:
        follow(fit, energy, common, deadline)
    else:
        numbers[SCALE], numbers[COMPARED], numbers[IN_VAIN] = 1.0, energy, 0.0
        for index in range(len(fit.post.known)):
            fit.post.known[index] = UNKNOWN
        begin_comparison(fit, COARSE if marks[IS_STRONG] else FINER * COARSE, False)
        if is_late(memory, NOW, deadline):
            settle(fit, numbers[SPREAD], common, BURST, 0)
    gradual = marks[GRADUAL] or marks[STAGE] == RESTING
    numbers[BEFORE] = energy
    ended = now_ns(memory.marks)
    later = marks[GRADUAL] and marks[DUTY] == OPEN_FIRST
    if marks[STAGE] != RESTING and marks[GRADUAL] and marks[DUTY] == ERROR_FIRST:
        later = is_short(memory, PACE, ENTRY * memory.counts[NOW], deadline)
    if marks[STAGE] != RESTING and not (later or memory.marks[LATE]):
        ended = take_turn(fit, common, deadline)
    if not memory.marks[LATE]:
        steps = SLICE if gradual else marks[STEPS_AT_ONCE]
        memory.marks[PAUSE] = memory.marks[STEPS] + steps if steps else 0
        marks[OPEN_HALFWAY] = search_by(fit, EXPLORE, marks[OPEN_HALFWAY] == 1, deadline)
        if memory.marks[STEPS] >= memory.marks[PAUSE] > 0:
            memory.marks[LATE] = 0
        memory.marks[PAUSE] = 0
        ended = now_ns(memory.marks)
    lay_open(fit.model, memory, fit.post)
    marks[EXPLAINED] = explains(fit) and numbers[MISFIT] < LARGEST
    fit.search.known[0] = evidence(fit.model, memory, NOW)
    return ended


@inner(_nrt=False)
def take_turn(fit: Fit, common: float, deadline: int) -> int:
    """Go on with a comparison, and return to the answer, by the weights that it goes by.

    Returns the time at which the comparison was interrupted or at its end.
    """
    memory, marks, numbers = fit.memory, fit.own.marks, fit.own.numbers
    steps = SLICE if marks[GRADUAL] else marks[STEPS_AT_ONCE]
    memory.marks[PAUSE] = memory.marks[STEPS] + steps if steps else 0
    compare(fit, common, deadline)
    ended = now_ns(memory.marks)
    paused = marks[GRADUAL] and memory.marks[STEPS] >= memory.marks[PAUSE] > 0
    memory.marks[PAUSE] = 0
    resting = marks[STAGE] == RESTING
    memory.marks[LATE] = not (resting or paused)
    if resting:
        marks[GRADUAL] = 0
        marks[TURN], numbers[IN_VAIN], numbers[COMPARED_SPREAD] = 0, -1.0, -1.0
        if memory.counts[NOW] and not is_short(memory, INFERRING, memory.counts[NOW], deadline):
            infer(fit, common)
            learn(fit)
            numbers[COMPARED_SPREAD] = numbers[SPREAD]
        marks[HOPELESS] = not explains(fit)
    if memory.marks[LATE]:
        settle(fit, numbers[SPREAD], common, 0, 0)
    else:
        settle(fit, numbers[SPREAD], common, BURST, deadline)
        ended = now_ns(memory.marks)
    if memory.marks[STEPS] >= memory.marks[MOST] > 0:
        infer(fit, common)
    elif memory.marks[LATE] and not marks[GRADUAL]:
        numbers[TOTAL] = evidence(fit.model, memory, NOW)
    return ended


@inner(_nrt=False)
def may_gain(fit: Fit) -> bool:
    """Whether other sets of atoms may be more probable than NOW, by what it leaves over.

    Not where that is as little as the noise, all are balls, and no two of them may be one.
    """
    memory, own, count = fit.memory, fit.own, fit.memory.counts[NOW]
    for n in range(count):
        plain = memory.family[NOW, n] == BALL and not is_long(memory.atoms[NOW, n])
        if not plain or may_be_without(memory, fit.search, n):
            return True
    squares, heard = 0.0, 0
    for taxel in range(len(own.heard)):
        left = memory.taxels[READINGS, taxel] - memory.predicted[NOW, taxel] - own.numbers[OFFSET]
        over = left / own.heard[taxel]
        squares += over * over
        heard += own.heard[taxel] < np.inf
    return bool(squares > heard + ODD * np.sqrt(2.0 * heard))


@inner(_nrt=False)
def follow(fit: Fit, energy: float, common: float, deadline: int) -> None:
    """Move the atoms of the reading before, and see whether others are to be compared."""
    memory, marks, numbers = fit.memory, fit.own.marks, fit.own.numbers
    lost = not (marks[EXPLAINED] or marks[HOPELESS])
    few = lost and (not deadline or marks[DUTY] == COMPARISON_FIRST)
    settle(fit, numbers[SPREAD], common, FEW_STEPS if few else BURST, deadline)
    explained = explains(fit)
    marks[HOPELESS] = marks[HOPELESS] and not explained
    if marks[STAGE] == RESTING and not (explained or marks[HOPELESS]):
        numbers[SCALE] *= noise_scale(fit)
        begin_comparison(fit, numbers[MISFIT], False)
        return
    if memory.marks[LATE]:
        return
    if marks[STAGE] == RESTING:  # else there may be touches among what is left over
        scale = noise_scale(fit)
        like = numbers[BEFORE] / FALL < energy < numbers[BEFORE] * RISE
        if not numbers[COMPARED] / FALL < energy < numbers[COMPARED] * RISE:
            numbers[COMPARED], numbers[IN_VAIN] = energy, 0.0
            if numbers[MISFIT] > COARSE:
                begin_afresh(fit)
            elif not (like and explained) or may_gain(fit):
                begin_comparison(fit, numbers[MISFIT], False)
                marks[GRADUAL] = like and explained
        quiet = scale < 1.0 and numbers[SCALE] <= 1.0
        numbers[SCALE] *= scale
        if scale != 1.0 and not quiet:
            begin_comparison(fit, numbers[MISFIT], False)
            return
    elif marks[GRADUAL] and not explained:
        begin_comparison(fit, numbers[MISFIT], False)
    count = memory.counts[NOW]
    if (marks[DUTY] != ERROR_FIRST and explained) or (
        marks[STAGE] == SEEKING and not marks[GRADUAL]
    ):
        return
    if is_short(memory, INFERRING, count, deadline):
        return
    infer(fit, common)
    take_pace(memory, INFERRING, count)
    if numbers[COMPARED_SPREAD] < 0.0:
        numbers[COMPARED_SPREAD] = numbers[SPREAD]
    if numbers[SPREAD] > WORSE * numbers[COMPARED_SPREAD]:  # or the atoms are wrong
        numbers[COMPARED_SPREAD] = numbers[SPREAD]
        begin_comparison(fit, numbers[MISFIT], False)
        return
    if marks[STAGE] != RESTING or is_short(memory, SCORING, 1, deadline):
        return
    spread, weighed = numbers[SPREAD], numbers[WEIGHED]
    if not weighed < REWEIGHED * spread < REWEIGHED * REWEIGHED * weighed:
        settle(fit, numbers[SPREAD], common, BURST, deadline)
        if is_short(memory, SCORING, 1, deadline):
            return
    take_offset(fit)
    score, worth = score_of_left(fit), least_worth(fit)
    take_pace(memory, SCORING, 1)
    if numbers[IN_VAIN] < 0.0:  # as sets of atoms were just compared
        numbers[IN_VAIN], numbers[LEAST_WORTH] = score, worth
    least = np.sqrt(2.0 * fit.rules.threshold / OFF_LATTICE)
    faint = worth < min(FAINT * fit.rules.threshold, FAINTER * numbers[LEAST_WORTH])
    if faint or score > max(least, MORE * numbers[IN_VAIN]):
        begin_comparison(fit, numbers[MISFIT], True)
        marks[GRADUAL] = explained and score < np.sqrt(2.0 * fit.rules.threshold)
        return
    if numbers[MEAN_NOISE] < QUIETER_AGAIN * numbers[SPLIT_NOISE]:  # more readings in an average
        begin_comparison(fit, numbers[MISFIT], True)
        marks[STAGE], marks[GRADUAL] = DROPPING, explained
        marks[INDEX] = 0
    else:
        learn(fit)  # as nothing else is missed, which would be model error
        numbers[IN_VAIN] = min(numbers[IN_VAIN], score)
        numbers[LEAST_WORTH] = max(numbers[LEAST_WORTH], worth)


@inner(_nrt=False)
def see_what_goes_on(fit: Fit, held: bool) -> None:
    """See whether a contact goes on; of one that does not, the mechanics are open."""
    own, memory, count = fit.own, fit.memory, fit.memory.counts[NOW]
    numbers, goes_on = own.numbers, False
    for n in range(count):
        atom = memory.atoms[NOW, n]
        apart = np.hypot(atom[0] - numbers[LAST_X], atom[1] - numbers[LAST_Y])
        goes_on = goes_on or (held and apart < ELSEWHERE)
    own.marks[GOES_ON] = goes_on
    if count:
        numbers[LAST_X], numbers[LAST_Y] = memory.atoms[NOW, 0, 0], memory.atoms[NOW, 0, 1]
        if not goes_on:
            numbers[UNSURE_PLACE], numbers[UNSURE_FORCE] = numbers[OPEN_PLACE], numbers[OPEN_FORCE]


@njit
def infer_evidence(fit_address: int) -> None:
    """Infer the model error and the evidence of the answer of an interrupted search."""
    fit = unpack_fit(fit_address)
    infer(fit, fit.rules.common_mode * fit.own.numbers[MEAN_NOISE])


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
    held = memory.counts[NOW] > 0
    ended = find_contacts(fit, readings, valid, max(end, 1) if deadline else 0)
    see_what_goes_on(fit, held)
    highest, lowest = 0.0, np.inf
    for taxel in range(len(readings)):
        highest = max(highest, memory.taxels[WHITE, taxel])
        lowest = min(lowest, own.heard[taxel])
    at_mean = not highest * lowest > QUIETER
    errors, offset = fit.drawing.errors, own.numbers[OFFSET]
    errors[0], errors[1] = own.numbers[UNSURE_PLACE], own.numbers[UNSURE_FORCE]
    errors[2] = own.numbers[SPREAD]
    if not deadline or own.marks[STAGE] == RESTING:  # else what is not found yet is in it, too
        own.numbers[RESTED_SPREAD] = own.numbers[SPREAD]
    error = own.numbers[RESTED_SPREAD]
    join_by_strips(
        fit.model.taxels, memory, offset, own.heard, error, fit.strips, fit.drawing.strip
    )
    count = write_rows(
        grid, memory, fit.post, fit.pairs, fit.strips, at_mean, fit.drawing, pressure, rows
    )
    took, known = now_ns(memory.marks) - ended, own.numbers[DRAWN]
    if end:
        took += min(max(ended - end, 0), int(OVERSHOOT * known))
    own.numbers[DRAWN] = nearly_slowest(known, float(took), FASTER)
    return count
