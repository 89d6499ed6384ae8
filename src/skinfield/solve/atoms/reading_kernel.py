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
    clear_set,
    evidence,
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
    COMPARED,
    DRAWN,
    DROPPING,
    EXPLAINED,
    HALFWAY,
    IN_VAIN,
    INDEX,
    IS_STRONG,
    LEAST_WORTH,
    MISFIT,
    OFFSET,
    ONLY,
    OPEN_HALFWAY,
    OTHER_SCALE,
    OTHER_TOTAL,
    OTHERS,
    REFINING,
    RESTING,
    SCALE,
    SEARCHED_BY,
    SEEKING,
    SPREAD,
    STAGE,
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
    SETTLED_GAIN,
    lay_open,
    search_atoms,
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
                marks[STAGE], marks[INDEX] = DROPPING, 0
        else:
            if not resume and (memory.counts[NOW] < 2 or marks[INDEX] >= memory.counts[NOW]):
                marks[STAGE], marks[HALFWAY] = RESTING, 0
                return
            if resume:
                exchange(fit)
            else:
                set_aside(fit)
                memory.counts[NOW] -= 1
                for n in range(marks[INDEX], memory.counts[NOW]):
                    memory.family[NOW, n] = memory.family[NOW, n + 1]
                    for i in range(6):
                        memory.atoms[NOW, n, i] = memory.atoms[NOW, n + 1, i]
            settle(fit, own.numbers[MISFIT], common, deadline)
            marks[HALFWAY] = memory.marks[LATE]
            if memory.marks[LATE]:
                exchange(fit)
                return
            infer(fit, common)
            if not own.numbers[TOTAL] > own.numbers[OTHER_TOTAL] + BETTER:
                exchange(fit)
                marks[INDEX] += 1


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
    errors = fit.drawing.errors
    errors[0], errors[1] = own.numbers[UNSURE_PLACE], own.numbers[UNSURE_FORCE]
    errors[2] = own.numbers[SPREAD]
    count = write_rows(grid, memory, fit.post, at_mean, fit.drawing, pressure, rows)
    took = now_ns(memory.marks) - ended
    before = own.numbers[DRAWN]
    own.numbers[DRAWN] = min(max(took, FASTER * before), SLOWER * before)
    return count
