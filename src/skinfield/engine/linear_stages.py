"""Steps of a cycle whose answers are linear."""

import numpy as np

from skinfield.engine.clockwork import Clockwork
from skinfield.engine.group import Group
from skinfield.engine.state import LINEAR, PRODUCT, ROW
from skinfield.errors import Ints

NOTHING: Ints = np.zeros(0, dtype=np.int64)
ACTIVE = 4.0  # deviations of an idle patch's energy above which something is taken to touch it


def fill_missing(work: Clockwork, group: Group, places: Ints) -> None:
    """Put what the others let expect in place of invalid readings, in units of the noise."""
    intake = work.intake
    valid = intake.views(intake.valid, group.first, group.count)
    white = work.white[group.index]
    for place in places:
        group.filler.fill(white[place], valid[place])


def finest_for_all(work: Clockwork) -> int:
    """Finest rung whose linear answers of all patches will fit in the time that is left."""
    total = work.costs[:, PRODUCT, : work.top + 1].sum(axis=0)
    fitting = np.flatnonzero(total <= work.left)
    return int(fitting[-1]) if len(fitting) else 0


def answer_linearly(work: Clockwork, rung: int) -> None:
    """Linear answers of all patches on a rung."""
    state = work.state
    work.script.add(PRODUCT, -1, rung)
    for group in work.groups if not work.intake.all_valid else ():
        invalid = np.flatnonzero(state.invalid[group.rows])
        fill_missing(work, group, invalid[work.intake.present[group.rows][invalid]])
    start = work.clock()  # how long a product takes is learnt without
    if work.answers:
        work.answer_all(rung)
        work.done(PRODUCT, 0, -1, rung, start)
    else:
        for group in work.groups:
            start = work.clock()
            group.answer_all(rung, work.white[group.index])
            work.done(PRODUCT, group.index, -1, rung, start)
    present = work.intake.present
    work.kernel.answered(present, rung, state.integers, state.numbers, state.settled)


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


def with_more_to_gain(work: Clockwork, rung: int) -> Ints:
    """Patches that are touched, unless all are answered on the finest rung that they may have."""
    return NOTHING if rung >= work.finest else touched(work)


def refine_linearly(work: Clockwork, rung: int) -> Ints:
    """Finer linear answers where something touches, as far as time goes; returns these patches."""
    state, hot = work.state, with_more_to_gain(work, rung)
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
    work.script.add(ROW, patch, rung)
    state.predicted[patch] += work.predict(ROW, group.index, rung)
    start = work.clock()
    group.answer_one(rung, patch - group.first, work.white[group.index])
    state.spent[patch] += work.done(ROW, group.index, patch, rung, start)
    state.rung[patch] = state.at[patch] = rung
