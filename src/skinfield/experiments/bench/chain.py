"""A run of readings through one contender, with a deadline for each."""

import time
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.bench.contenders import Answer, Contender
from skinfield.experiments.bench.scene import LEAD


@dataclass(frozen=True, eq=False)
class Chain:
    """What T readings took and brought, in order.

    Attributes
    ----------
    seconds : (T,) array
        Of each call.
    answers : list of T Answer
    """

    seconds: Floats
    answers: list[Answer]


def run_chain(
    contender: Contender, readings: Floats, deadline: float | None, *, cold: bool, lead: int = LEAD
) -> Chain:
    """Answer all readings in order; the first `lead` do not count.

    Parameters
    ----------
    contender : Contender
    readings : (lead + T, L) array
    deadline : float, s, or None
        For each reading, from its own start.
    cold : bool
        Forget the reading before, each time; else start from it.
    lead : int
    """
    contender.reset()
    room = None if deadline is None else round(deadline * 1e9)
    spent, answers = np.empty(len(readings)), []
    for index, reading in enumerate(readings):
        if cold:
            contender.reset()
        start = time.perf_counter_ns()
        contender.answer(reading, None if room is None else start + room)
        spent[index] = time.perf_counter_ns() - start
        if index >= lead:
            answers.append(contender.last())
    return Chain(spent[lead:] * 1e-9, answers)
