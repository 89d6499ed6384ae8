"""Number of contacts, compiled: whether fewer, or two in the place of one, are more probable.

A set of atoms is compared with the answer, which is kept aside: without each atom, with two that
are close as one, and with pairs in the place of each.
"""

import numpy as np

from skinfield.compiled import inner
from skinfield.solve.atoms.alternatives_kernel import (
    BETTER,
    apart,
    clear_set,
    copy_others,
    mark_one,
    take_left,
)
from skinfield.solve.atoms.atom_readings import PARAMETERS
from skinfield.solve.atoms.fit_kernel import (
    LATE,
    LISTING,
    NOW,
    READINGS,
    SCANNING,
    STEPS,
    TRIAL,
    descend,
    is_late,
    is_short,
    take_pace,
)
from skinfield.solve.atoms.misfit_kernel import infer, weigh
from skinfield.solve.atoms.reading_memory import (
    DROPPING,
    FORMER_COUNT,
    HALFWAY,
    INDEX,
    MEAN_NOISE,
    MISFIT,
    OFFSET,
    ONLY,
    OTHER_MISFIT,
    OTHER_SCALE,
    OTHER_TOTAL,
    OTHERS,
    RESTING,
    SCALE,
    SPLIT_NOISE,
    SPLITTING,
    SPREAD,
    STAGE,
    TOTAL,
    TURN,
    Fit,
)
from skinfield.solve.atoms.search_kernel import BURST, SETTLED_GAIN
from skinfield.solve.atoms.split_kernel import (
    FOUND,
    LISTED,
    MAYBE,
    PAIRS,
    SCANNED,
    add_rival,
    are_known,
    are_two,
    choose_pairs,
    forget_rivals,
    leave_out,
    list_templates,
    nearest_to,
    put_pair,
    scan_pairs,
    state_rivals,
    take_spread,
    unite,
)

CLEARLY = 6.0  # ln odds by which fewer are more probable than those that the reading before had
SETTLINGS = 2  # of two in the place of one: each by the model error that the one before infers
FAR = 8.0  # ln odds against two after the first of these, beyond which there is no second
SCANNED_AT_ONCE = 8  # templates


@inner(_nrt=False)
def set_aside(fit: Fit) -> None:
    """Keep the answer while others are compared."""
    own, memory = fit.own, fit.memory
    own.marks[OTHERS] = memory.counts[NOW]
    for n in range(memory.counts[NOW]):
        own.family[n] = memory.family[NOW, n]
        for i in range(PARAMETERS):
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
        for i in range(PARAMETERS):
            atom = memory.atoms[NOW, n, i]
            memory.atoms[NOW, n, i] = own.atoms[n, i]
            own.atoms[n, i] = atom
    memory.counts[NOW], own.marks[OTHERS] = own.marks[OTHERS], memory.counts[NOW]
    for k in range(4):
        value = own.numbers[NUMBERS[k]]
        own.numbers[NUMBERS[k]] = own.numbers[OTHER_SCALE + k]
        own.numbers[OTHER_SCALE + k] = value


@inner(_nrt=False)
def settle(fit: Fit, error: float, common: float, steps: int, deadline: int) -> None:
    """Move the atoms of NOW to the minimum, weighed by a model error, by so many steps at most."""
    weigh(fit, error, common)
    memory = fit.memory
    if memory.counts[NOW]:
        descend(fit.model, memory, NOW, READINGS, 0, steps, SETTLED_GAIN, deadline)
    else:
        clear_set(memory, NOW)


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
    settle(fit, own.numbers[MISFIT], common, BURST, deadline)
    marks[HALFWAY] = memory.marks[LATE]
    if memory.marks[LATE]:
        exchange(fit)
        return
    infer(fit, common)
    odds = own.numbers[OTHER_TOTAL] - own.numbers[TOTAL]
    likely = odds < MAYBE  # and not so as a worse model leaves atoms little to explain
    if likely and own.numbers[MISFIT] > own.numbers[OTHER_MISFIT]:
        likely = are_known(fit.model, memory, fit.post.local)
    fewer = likely and odds < -BETTER
    if fewer and odds >= -CLEARLY and memory.counts[NOW] < marks[FORMER_COUNT]:
        exchange(fit)
        settle(fit, own.numbers[MISFIT], common, 0, 0)
        fewer = not are_known(fit.model, memory, fit.post.local)
        exchange(fit)
        settle(fit, own.numbers[MISFIT], common, 0, 0)
    if fewer:
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
        if is_late(memory, NOW, deadline) or is_short(memory, LISTING, 1, deadline):
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
        take_pace(memory, LISTING, 1)
    while pairs.state[SCANNED] < pairs.state[LISTED]:
        if is_late(memory, NOW, deadline) or is_short(memory, SCANNING, 1, deadline):
            return
        scan_pairs(fit.bank, pairs, SCANNED_AT_ONCE)
        take_pace(memory, SCANNING, 1)
        memory.marks[STEPS] += 1
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
            marks[STAGE] = RESTING
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
        settle(fit, own.numbers[MISFIT], common, BURST, deadline)
        marks[HALFWAY] = memory.marks[LATE]
        if memory.marks[LATE]:
            exchange(fit)
            return
        infer(fit, common)
        marks[TURN] += 1
        if own.numbers[TOTAL] < own.numbers[OTHER_TOTAL] - FAR:
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
