"""Stages of a cycle: linear answers, idle tests, and answers that are searched."""

import numpy as np

from skinfield.errors import Ints
from skinfield.reconstruct.engine.patch_kinds import PatchGroup
from skinfield.reconstruct.engine.state import (
    CONTACTS,
    FEASIBLE,
    IDLE,
    LINEAR,
    NS,
)
from skinfield.reconstruct.engine.workspace import Clockwork


def fill_missing(work: Clockwork, group: PatchGroup, places: Ints) -> None:
    """Put what the others let expect in place of invalid readings, in units of the noise."""
    intake = work.intake
    valid = intake.views(intake.valid, group.first, group.count)
    white = work.white[group.index]
    for place in places:
        group.fill(white[place], valid[place])


def answer_linearly(work: Clockwork) -> None:
    """Linear answers of all patches on the finest rung that they may have."""
    state, rung = work.state, work.top
    for group in work.groups:
        if not work.intake.all_valid:
            invalid = np.flatnonzero(state.invalid[group.rows])
            fill_missing(work, group, invalid[work.intake.present[group.rows][invalid]])
        group.answer_all(rung, work.white[group.index])
    present = work.intake.present
    work.kernel.take_answers(present, rung, state.integers, state.numbers, state.settled)


PATIENCE = 20  # cycles after which a contact is searched even if there is no time for it
SELDOM = 10  # cycles, at least, between two such
LEAST, TURN = 60e-6, 150e-6  # s in which a search comes to something, and mostly to an end


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
        group.answer_all(0, white)
        np.maximum(field, 0.0, out=field)
    state.rung[rest] = 0


def spend(work: Clockwork) -> None:
    """Search the touched patches, and answer those linearly whose turn does not come."""
    search_in_turn(work, work.touched())
    start_linearly(work)


def search_in_turn(work: Clockwork, hot: Ints) -> None:
    """Search touched patches, each within its share of the time.

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
                return
            share = left if patch == work.foremost else left / waiting
            allowance = max(min(left, TURN), share, LEAST)
            search(work, patch, start, start + int(allowance / NS))
        waiting -= 1


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
    if getattr(data, "idle", False):
        state.answer[patch], state.rung[patch], state.gap[patch] = IDLE, rung, 0.0
    elif solution.gap < 1.0 if is_field else data.count or solution.in_time:
        state.answer[patch] = FEASIBLE if is_field else CONTACTS
        state.rung[patch] = rung
        state.gap[patch], state.iterations[patch] = solution.gap, solution.steps
        state.settled[patch] = (
            solution.gap <= operator.problem.tolerance
            if is_field
            else solution.in_time and data.settled
        )  # else nothing is found yet: the linear answer stays
    state.spent[patch] += work.since(start)
