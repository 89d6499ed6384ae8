"""Stages of a cycle: linear answers, idle tests, and answers that are searched."""

import numpy as np

from skinfield.errors import Ints
from skinfield.reconstruct.engine.patch_kinds import PatchGroup
from skinfield.reconstruct.engine.state import (
    CONTACTS,
    FEASIBLE,
    LINEAR,
    MASKED,
    PRODUCT,
    ROW,
    ROWS,
    SEARCH,
    TEST,
)
from skinfield.reconstruct.engine.timing_model import NS
from skinfield.reconstruct.engine.workspace import Clockwork

NOTHING: Ints = np.zeros(0, dtype=np.int64)
ACTIVE = 4.0  # deviations of an idle patch's energy above which something is taken to touch it


def fill_missing(work: Clockwork, group: PatchGroup, places: Ints) -> None:
    """Put what the others let expect in place of invalid readings, in units of the noise."""
    intake = work.intake
    valid = intake.views(intake.valid, group.first, group.count)
    white = work.white[group.index]
    for place in places:
        group.fill(white[place], valid[place])


def finest_for_all(work: Clockwork) -> int:
    """Finest rung whose linear answers of all patches will fit in the time that is left."""
    total = work.costs[:, PRODUCT, : work.top + 1].sum(axis=0)
    fitting = np.flatnonzero(total <= work.left)
    return int(fitting[-1]) if len(fitting) else 0


def answer_linearly(work: Clockwork, rung: int) -> None:
    """Linear answers of all patches on a rung."""
    state = work.state
    for group in work.groups if not work.intake.all_valid else ():
        invalid = np.flatnonzero(state.invalid[group.rows])
        fill_missing(work, group, invalid[work.intake.present[group.rows][invalid]])
    start = work.clock()  # how long a product takes is learnt without
    if work.atlases:
        work.answer_all(rung)
        work.log_step(PRODUCT, 0, -1, rung, start)
    else:
        for group in work.groups:
            start = work.clock()
            group.answer_all(rung, work.white[group.index])
            work.log_step(PRODUCT, group.index, -1, rung, start)
    present = work.intake.present
    work.kernel.take_answers(present, rung, state.integers, state.numbers, state.settled)


def touched(work: Clockwork) -> Ints:
    """Patches whose readings are too large for noise alone."""
    state = work.state
    for group in work.groups:
        white = work.white[group.index]
        np.einsum("pl,pl->p", white, white, out=state.energy[group.rows], casting="same_kind")
        state.energy[group.rows] *= 0.5
    taxels = np.asarray(work.intake.sizes)
    idle = 0.5 * taxels + ACTIVE * np.sqrt(0.5 * taxels)  # half of chi², with its variance 2 L
    return np.flatnonzero((state.answer == LINEAR) & (state.energy > idle))


def refine_linearly(work: Clockwork, rung: int) -> None:
    """Finer linear answers where something touches, each within its share of the time."""
    hot = NOTHING if rung >= work.finest else touched(work)
    waiting = len(hot)
    for patch in work.in_turn(hot).tolist():
        group, share = int(work.state.group[patch]), work.left
        if patch != work.foremost:
            share /= waiting
        for finer in range(int(work.tops[patch]), rung, -1):
            if work.predict(ROW, group, finer) <= share:
                refine_one(work, patch, finer)
                break
        waiting -= 1


def refine_one(work: Clockwork, patch: int, rung: int) -> None:
    """Linear answer of one patch on a finer rung."""
    state, group = work.state, work.groups[work.state.group[patch]]
    start = work.clock()
    group.answer_one(rung, patch - group.first, work.white[group.index])
    state.spent[patch] += work.log_step(ROW, group.index, patch, rung, start)
    state.rung[patch] = rung


FIRST = 0.25  # of the time, for the first idle test
PATIENCE = 20  # cycles after which a contact is searched even if there is no time for it
SELDOM = 10  # cycles, at least, between two such
LEAST, TURN = 60e-6, 150e-6  # s in which a search comes to something, and mostly to an end


def test_all(work: Clockwork, rung: int) -> Ints:
    """Test on a rung which patches are idle; returns the others, which have a contact."""
    start = work.clock()
    count = work.test_idle(rung)
    work.log_step(TEST, 0, -1, rung, start)
    work.tested = rung
    if count:
        test_masked(work, work.masked[:count], work.before[:count], rung)
    return work.touched()


def test_masked(work: Clockwork, patches: Ints, before: Ints, rung: int) -> None:
    """Test again patches that are idle by the lengths of whole rows, by those of valid taxels.

    A valid part is shorter, so that the same readings stand out more. Where time is short the first
    test is on the coarsest rung, and a finer one is left out: `before` is the rung of the last, or
    -1.
    """
    state, waiting = work.state, len(patches)
    for patch, last in zip(patches.tolist(), before.tolist(), strict=True):
        group, on, start = work.places[patch][0], rung, work.clock()
        if waiting * work.predict(MASKED, group.index, rung) > FIRST * work.left:
            on = max(last, 0)
        waiting -= 1
        state.rung[patch] = on
        if on == last:
            continue
        if not work.is_idle(patch, on):
            state.answer[patch], state.rung[patch], state.gap[patch] = LINEAR, -1, np.nan
        work.log_step(MASKED, group.index, patch, on, start)


def start_linearly(work: Clockwork) -> None:
    """Clipped linear answers on the coarsest rung for patches with a contact and no search."""
    state = work.state
    rest = (state.answer == LINEAR).nonzero()[0]
    if not len(rest):
        return
    for group in work.groups:
        places = rest[(rest >= group.first) & (rest < group.rows.stop)] - group.first
        if not len(places):
            continue
        white, field = work.white[group.index], group.fields[0]
        fill_missing(work, group, places[state.invalid[places + group.first] > 0])
        start = work.clock()
        if len(places) < ROWS:
            for place in places.tolist():
                group.answer_one(0, place, white)
                np.maximum(field[place], 0.0, out=field[place])
            work.log_step(ROW, group.index, -1, 0, start)
        else:
            group.answer_all(0, white)
            np.maximum(field, 0.0, out=field)
            work.log_step(PRODUCT, group.index, -1, 0, start)
    state.rung[rest] = 0


def first_tested(work: Clockwork) -> int:
    """Finest rung whose idle test takes little of the time: coarse cells overlook small touches.

    Where contacts are found, the test is the same on all.
    """
    if work.finds_contacts:
        return work.rungs - 1
    return finest_within(work, FIRST * work.left, 0)


def finest_within(work: Clockwork, seconds: float, least: int) -> int:
    """Finest rung above `least` whose idle test takes no longer; else `least`."""
    costs = work.costs
    for rung in range(work.rungs - 1, least, -1):
        if costs[0, TEST, rung] <= seconds:
            return rung
    return least


def spend(work: Clockwork, hot: Ints) -> None:
    """Search the touched patches, and answer those linearly whose turn does not come.

    Finer rungs are tested as soon as there is time: coarse cells overlook small touches.
    """
    while search_in_turn(work, hot):
        finer = finest_within(work, work.left, work.tested)
        if finer == work.tested:
            break
        hot = test_all(work, finer)
    start_linearly(work)


def search_in_turn(work: Clockwork, hot: Ints) -> bool:
    """Search touched patches, each within its share of the time; whether that sufficed.

    What was searched longest ago comes first. A search goes on where the patch's last one ended, so
    that a short time, cycle after cycle, comes to the same as a long one.
    """
    state, waiting = work.state, len(hot)
    order, reserve = work.in_turn(hot), int(work.reserve / NS)
    for patch in order.tolist():
        if state.answer[patch] == LINEAR:
            start = work.clock()
            left = (work.end - reserve - start) * NS
            if left < LEAST:
                search_longest_waiting(work, hot)
                return False
            share = left if patch == work.foremost else left / waiting
            allowance = max(min(left, TURN), share, LEAST)
            search(work, patch, start, start + int(allowance / NS))
        waiting -= 1
    return True


def search_longest_waiting(work: Clockwork, hot: Ints) -> None:
    """Search the patch that waited longest, if that is too long, though there is no time for it.

    So seldom that most cycles stay within their budget.
    """
    state = work.state
    if work.waited < PATIENCE or state.unforced < SELDOM:
        return
    patch = int(hot[state.age[hot].argmax()])
    if state.age[patch] >= PATIENCE and state.answer[patch] == LINEAR:
        start, state.unforced = work.clock(), 0
        search(work, patch, start, start + int(TURN / NS))


def search(work: Clockwork, patch: int, start: int, deadline: int) -> None:
    """Search one patch, by a deadline, on the finest rung it may have."""
    state, rung = work.state, int(work.tops[patch])
    group, place = work.places[patch]
    masked = not work.intake.all_valid and bool(state.invalid[patch])
    operator, data = group.search_of(rung, place, work.valid_rows[patch] if masked else None)
    known = {"touched": True} if work.finds_contacts else {}
    solution = operator.solve(work.raw_rows[patch], data, deadline, **known)
    is_field = data.count < 0
    if is_field and work.finds_contacts:
        work.by_field.add(patch)
    if solution.gap < 1.0 if is_field else data.count or solution.in_time:
        state.answer[patch] = FEASIBLE if is_field else CONTACTS
        state.rung[patch] = rung
        state.gap[patch], state.iterations[patch] = solution.gap, solution.steps
        state.settled[patch] = (
            solution.gap <= operator.problem.tolerance if is_field else solution.in_time
        )  # else nothing is found yet: the linear answer stays
    state.spent[patch] += work.log_step(SEARCH, group.index, patch, rung, start)
