"""State of each patch in a cycle, in arrays."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from skinfield.errors import Ints


class Answer(IntEnum):
    """How a patch was answered."""

    MISSING = 0  # no reading, or none that can be answered
    IDLE = 1  # nothing stands out of the noise on the rung that is told: 0 is the answer
    LINEAR = 2  # of a linear solver; or, of an iterative one, its clipped start
    FEASIBLE = 3  # of an iterative solver, with its certificate
    CONTACTS = 4  # of a solver that finds contacts by itself, with the pressure below them


class Step(IntEnum):
    """Kinds of steps, by which their times are told apart; each on every rung."""

    PRODUCT = 0  # linear answer of all patches of a kind
    TEST = 1  # idle test of all patches of a kind
    ROW = 2  # linear answer of one patch
    SEARCH = 3  # of a patch
    MASKED = 4  # idle test of one patch some of whose taxels are left out


# as plain numbers: the members of an enumeration are slow to look up
MISSING, IDLE, LINEAR, FEASIBLE, CONTACTS = (int(each) for each in Answer)
PRODUCT, TEST, ROW, SEARCH, MASKED = (int(each) for each in Step)


ROWS = 4  # touched patches of one kind from which one linear product for all is quicker


class LoggedStep(NamedTuple):
    """Entry of the step log: one step that was taken.

    Attributes
    ----------
    step : int
        Of `Step`; see `kind`.
    group : int
    patch : int
        Row of the patch; -1 for a step of all patches of a kind.
    rung : int
    start, end : int, ns
        Of the engine's clock.
    """

    step: int
    group: int
    patch: int
    rung: int
    start: int
    end: int

    @property
    def kind(self) -> Step:
        """What kind of step it was."""
        return Step(self.step)


class EngineState:
    """Arrays (P,) over all patches, those of one kind side by side.

    Attributes
    ----------
    group : which kind the patch is of
    integers, numbers : (3, P) and (2, P) arrays, of which the others are rows; see `cycle_kernel`
    answer : of `Answer`
    rung : of the answer; -1 where there is none
    gap : relative, of the answer
    energy : half the squared readings, in units of their noise; of linear solvers
    iterations : of the last search
    settled : whether the last search came to its end
    age : cycles since a patch with a contact was searched
    invalid : taxels that were left out
    spent : s, of the steps for this patch alone
    unforced : cycles since a patch was last searched without the time for it (one number)
    """

    def __init__(self, group: Ints) -> None:
        self.group, patches = group, len(group)
        self.integers: Ints = np.zeros((3, patches), dtype=np.int64)
        self.answer, self.rung, self.iterations = self.integers
        self.numbers = np.zeros((2, patches))
        self.gap, self.spent = self.numbers
        self.energy = np.zeros(patches)
        self.age, self.invalid = np.zeros((2, patches), dtype=np.int64)
        self.settled = np.zeros(patches, dtype=np.bool_)
        self.reset()

    def copy(self) -> "EngineState":
        """What the next cycle changes, as it is now."""
        other = EngineState(self.group)
        other.integers[:], other.numbers[:], other.settled[:] = (
            self.integers,
            self.numbers,
            self.settled,
        )
        other.age[:], other.invalid[:] = self.age, self.invalid
        return other

    def reset(self) -> None:
        """Forget the cycles before; the arrays stay where they are."""
        self.settled[:] = False
        self.age[:] = self.invalid[:] = 0
        self.unforced = 0
        self.integers[:], self.numbers[:] = 0, 0.0
        self.rung[:], self.gap[:] = -1, np.nan
