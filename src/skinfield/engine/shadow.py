"""An engine's double, to keep its code and its matrices at hand between readings.

What a processor has not used for some milliseconds it fetches anew, which takes longer than a cycle
itself. The double runs the same code over the same prepared arrays, and answers into others.
"""

from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.engine.clockwork import Clockwork
from skinfield.engine.cost import CostModel
from skinfield.engine.group import Group
from skinfield.engine.intake import Intake
from skinfield.engine.measure import rehearsed_cycle
from skinfield.engine.results import Results
from skinfield.engine.state import State
from skinfield.errors import Floats

if TYPE_CHECKING:
    from skinfield.engine.engine import Engine

CHANGES = (1.0, 0.9, 1.05, 0.95)  # of the rehearsed touch, so that each has something to search


class Shadow:
    """The double of an engine, which answers rehearsed touches.

    Parameters
    ----------
    engine : Engine
    """

    def __init__(self, engine: "Engine") -> None:
        work = _double_of(engine._work)
        self._double = copy(engine)
        self._double.groups, self._double._work = list(work.groups), work
        self._double._around = CostModel(engine._around.steps.copy())
        rows = [work.intake.names.index(name) for name in engine.names]
        self._double.results = Results(work, rows)
        touch = rehearsed_cycle(work)
        flat: Floats = np.concatenate([touch[name] for name in engine.names])
        self._readings = [change * flat for change in CHANGES]
        self._valid = np.ones(len(flat), np.bool_)
        self._next, self._engine = 0, engine
        self._octets = [each.reshape(-1).view(np.uint8) for each in _arrays_of(engine._work)]

    def run(self, budget: float | None) -> None:
        """Answer a rehearsed cycle, then touch what the engine itself will need."""
        self._next = (self._next + 1) % len(self._readings)
        self._double.run(self._readings[self._next], self._valid, budget=budget)
        work = self._engine._work
        for octets in self._octets:
            work.kernel.touch(octets)
        used = [last for group in work.groups for last in group._last if last is not None]
        for each in (self._engine, work, work.state, work.intake, work.times, *used):
            if hasattr(each, "__dict__"):
                list(vars(each).values())  # counting references touches objects
        for last in used:
            for room in getattr(last, "rooms", ()):
                work.kernel.touch(room)


def _arrays_of(work: Clockwork) -> list[NDArray[Any]]:
    """Small arrays of all patches."""
    state, intake = work.state, work.intake
    return [
        state.integers,
        state.numbers,
        state.age,
        intake.given,
        intake.straight,
        intake.linear,
        intake.white,
        work.times.both,
        work.planned,
    ]


def _double_of(work: Clockwork) -> Clockwork:
    double = copy(work)
    double.groups = [_double_group(group) for group in work.groups]
    double.places = [(group, place) for group in double.groups for place in range(group.count)]
    double.intake, double.state = _double_intake(work.intake), State(work.state.group)
    double.answers, double.log = [], []
    for rung, (atlas, field) in enumerate(work.answers):
        room, at = np.zeros_like(field), 0
        for group in double.groups:
            size = group.fields[rung].size
            group.fields[rung] = room[at : at + size].reshape(group.count, -1)
            at += size
        double.answers.append((atlas, room))
    double.renew(work)
    return double


def _double_group(group: Group) -> Group:
    """With the same matrices; of the searches only that of the first patch has its own memory."""
    double = copy(group)
    double.fields = [np.zeros_like(each) for each in group.fields]
    double.feasible = [np.zeros_like(each) for each in group.feasible]
    double.rows_of_feasible = [list(fields) for fields in double.feasible]
    double.searches = [[twins[0].twin(), *twins[1:]] for twins in group.searches]
    double.duals = np.zeros_like(group.duals)
    double._last = [None] * group.count
    return double


def _double_intake(intake: Intake) -> Intake:
    double = copy(intake)
    for name in ("raw", "linear", "straight", "given", "white", "valid", "present", "_asked"):
        setattr(double, name, getattr(intake, name).copy())
    return double
