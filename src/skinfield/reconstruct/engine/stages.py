"""Stages of a cycle: linear answers, idle tests, and answers that are searched."""

import numpy as np

from skinfield.errors import Ints
from skinfield.reconstruct.engine.patch_kinds import PatchGroup
from skinfield.reconstruct.engine.state import (
    COLD,
    CONTACTS,
    FEASIBLE,
    LINEAR,
    MASKED,
    PRODUCT,
    ROW,
    TEST,
    WARM,
)
from skinfield.reconstruct.engine.timing_model import NS
from skinfield.reconstruct.engine.workspace import ROUNDS, Clockwork

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


def refine_linearly(work: Clockwork, rung: int) -> Ints:
    """Finer linear answers where something touches, as far as time goes; returns these patches."""
    state = work.state
    hot = NOTHING if rung >= work.finest else touched(work)
    if not len(hot):
        return hot
    state.kind[:] = ROW
    state.excess[:] = state.energy * work.unresolved[state.group, np.maximum(state.at, 0)]
    chosen, target = work.plan(hot, work.left)
    for patch in chosen.tolist():
        rung = int(target[patch])
        if work.predict(ROW, int(state.group[patch]), rung) <= work.left:
            refine_one(work, patch, rung)
    return hot


def refine_one(work: Clockwork, patch: int, rung: int) -> None:
    """Linear answer of one patch on a finer rung."""
    state, group = work.state, work.groups[work.state.group[patch]]
    state.predicted[patch] += work.predict(ROW, group.index, rung)
    start = work.clock()
    group.answer_one(rung, patch - group.first, work.white[group.index])
    state.spent[patch] += work.log_step(ROW, group.index, patch, rung, start)
    state.rung[patch] = state.at[patch] = rung


FIRST = 0.25  # of the time, for the first idle test
Found = tuple[int, int, float, float, bool, int, float, float, int, int]  # as `cycle_kernel`
ENDED = 0.5  # of its time left: a search ended by itself, whatever gap rounding leaves it
PATIENCE = 20  # cycles after which a contact is served even if there is no time for it
SELDOM = 10  # cycles, at least, between two such
ROWS = 4  # patches with a contact, of one kind, from which one product for all is quicker


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


def time_to_start(work: Clockwork, hot: Ints) -> float:
    """What `start_linearly` will take, s, if no patch is searched beyond those that were."""
    state = work.state
    counts = np.bincount(state.group[hot[state.at[hot] < 0]], minlength=len(work.groups))
    few = counts < ROWS
    costs = np.where(few, work.costs[:, ROW, 0], work.costs[:, PRODUCT, 0])
    return float(costs[counts > 0].sum())


def first_tested(work: Clockwork) -> int:
    """Finest rung whose idle test takes little of the time: coarse cells overlook small touches."""
    return finest_within(work, FIRST * work.left, 0)


def finest_within(work: Clockwork, seconds: float, least: int) -> int:
    """Finest rung above `least` whose idle test takes no longer; else `least`."""
    costs = work.costs
    for rung in range(work.rungs - 1, least, -1):
        if costs[0, TEST, rung] <= seconds:
            return rung
    return least


LEAST, TURN = 60e-6, 150e-6  # s in which a search for contacts comes to something, and to an end


def find_contacts(work: Clockwork, hot: Ints) -> Ints:
    """Search the contacts of touched patches; returns them.

    Finer rungs are tested as soon as there is time: coarse cells overlook small touches.
    """
    while search_in_turn(work, hot):
        finer = finest_within(work, work.left, work.tested)
        if finer == work.tested:
            break
        hot = test_all(work, finer)
    start_linearly(work)
    return hot


def search_in_turn(work: Clockwork, hot: Ints) -> bool:
    """Search patches for contacts, each within its share of the time; whether that sufficed.

    What was searched longest ago comes first. A search goes on where the patch's last one ended, so
    that a short time, cycle after cycle, comes to the same as a long one.
    """
    state, waiting = work.state, len(hot)
    for patch in work.in_turn(hot).tolist():
        if state.answer[patch] == LINEAR:
            start = work.clock()
            left = (work.end - start) * NS
            if left < LEAST and state.age[patch] < PATIENCE:
                return False
            allowance = max(min(left, TURN), left / waiting, LEAST)
            find_contacts_of(work, patch, start, start + int(allowance / NS))
        waiting -= 1
    return True


def find_contacts_of(work: Clockwork, patch: int, start: int, deadline: int) -> None:
    """Search the contacts of one patch, by a deadline, on the finest rung it may have."""
    state, rung = work.state, int(work.tops[patch])
    group, place = work.places[patch]
    masked = not work.intake.all_valid and bool(state.invalid[patch])
    operator, data = group.search_of(rung, place, work.valid_rows[patch] if masked else None)
    data.noise[:] = work.deviation_rows[patch]
    solution = operator.solve(work.raw_rows[patch], data, deadline)
    if data.count or solution.in_time:  # else nothing is found yet: the linear answer stays
        state.answer[patch] = FEASIBLE if data.count < 0 else CONTACTS
        state.rung[patch] = state.at[patch] = rung
        state.gap[patch], state.iterations[patch] = solution.gap, solution.steps
        state.settled[patch] = solution.in_time
    kind = WARM if state.was_hot[patch] else COLD
    state.predicted[patch] += work.predict(kind, group.index, rung)
    state.spent[patch] += work.log_step(kind, group.index, patch, rung, start)


def spend(work: Clockwork, hot: Ints) -> Ints:
    """Spend the time that is left where it gains most; returns the patches with a contact.

    Contacts first. When all of them are settled on the finest rung, the idle test is made on
    finer rungs as well, where what was too fine for the coarse one shows. A contact that was not
    searched gets a linear answer in the end.
    """
    if work.finds_contacts:
        return find_contacts(work, hot)
    serve_longest_waiting(work, hot)
    for _ in range(ROUNDS):
        served, settled = serve(work, hot) if len(hot) else (0, True)
        if not (settled if served else is_settled(work, hot)):
            if not served:
                break
            continue
        finer = finest_within(work, work.left, work.tested)
        if finer == work.tested:
            break
        hot = test_all(work, finer)
    start_linearly(work)
    return hot


def serve_longest_waiting(work: Clockwork, hot: Ints) -> None:
    """Search the contact that waited longest, if that is too long, whether there is time or not.

    On the coarsest rung, and so seldom that most cycles stay within their budget.
    """
    state = work.state
    if work.waited < PATIENCE or state.unforced < SELDOM or not len(hot):
        return
    patch = int(hot[state.age[hot].argmax()])
    if state.age[patch] < PATIENCE or patch in work.plan(hot, work.left)[0]:
        return
    cost = float(work.costs[state.group[patch], state.kind[patch], 0])
    now = work.clock()
    allowance = max((work.end - now) * NS, 2.0 * cost)
    take_in(work, [search(work, patch, 0, cost, allowance, now)], hot)
    state.unforced = 0


def is_settled(work: Clockwork, hot: Ints) -> bool:
    """Whether all contacts are solved on the finest rung that they may have."""
    state = work.state
    if not len(hot):
        return True
    return bool(work.kernel.all_settled(hot, state.settled, state.integers, work.tops))


def serve(work: Clockwork, hot: Ints) -> tuple[int, bool]:
    """Search the patches that a plan chooses, each within what the others leave it.

    Returns how many, and whether all contacts are then solved on the finest rung.
    """
    state, found, now, reserve = work.state, [], work.clock(), 0.0
    left = (work.end - now) * NS
    chosen, target = work.plan(hot, left)
    if len(chosen) < len(hot):
        reserve = time_to_start(work, hot)
        chosen, target = work.plan(hot, left - reserve)
    patches, planned = chosen.tolist(), work.planned
    rungs = target[chosen].tolist()
    costs = [
        float(planned[state.group[patch], state.kind[patch], rung])
        for patch, rung in zip(patches, rungs, strict=True)
    ]
    committed = reserve + sum(costs)
    for patch, rung, cost in zip(patches, rungs, costs, strict=True):
        committed -= cost
        allowance = (work.end - now) * NS - committed  # what is planned for the others is theirs
        if cost > allowance:
            rung, cost = cheaper(work, patch, rung, allowance)
            if cost > allowance:
                continue
        found.append(search(work, patch, rung, cost, allowance, now))
        now = found[-1][-1]  # what a search takes begins where the one before ended
    return len(found), take_in(work, found, hot) if found else False


def cheaper(work: Clockwork, patch: int, rung: int, allowance: float) -> tuple[int, float]:
    """Rung that fits, from the one that was planned downwards, and its cost."""
    state = work.state
    costs = work.planned[state.group[patch], state.kind[patch]]
    while costs[rung] > allowance and rung > max(state.at[patch], 0):
        rung -= 1
    return rung, float(costs[rung])


def search(
    work: Clockwork, patch: int, rung: int, cost: float, allowance: float, start: int
) -> Found:
    """Search one patch on a rung from where its last search ended, on whichever rung that was."""
    group, place = work.places[patch]
    masked = not work.intake.all_valid and bool(work.state.invalid[patch])
    operator, data = group.search_of(rung, place, work.valid_rows[patch] if masked else None)
    deadline = start + int(allowance / NS)
    solution = operator.solve(work.raw_rows[patch], data, deadline)
    end, gap = work.clock(), solution.gap
    settled = not gap > operator.problem.tolerance or (deadline - end) * NS > ENDED * allowance
    missing = 0.0 if settled else solution.objective * gap
    return patch, rung, gap, missing, settled, solution.steps, cost, 0.0, start, end


def take_in(work: Clockwork, found: list[Found], hot: Ints) -> bool:
    """Learn from searches, each of another patch, and keep their answers where they are better.

    Whether all contacts are then solved on the finest rung.
    """
    start = work.clock()
    settled = work.searched(found, hot)
    work.times.after.observe(0, (work.clock() - start) * NS / len(found))
    return settled
