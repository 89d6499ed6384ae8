"""State of each patch in a cycle, in arrays."""

from enum import IntEnum

import numpy as np

from skinfield.errors import Ints


class Answer(IntEnum):
    """How a patch was answered."""

    MISSING = 0  # no reading, or none that can be answered
    IDLE = 1  # nothing stands out of the noise on the finest rung: 0 is the answer
    LINEAR = 2  # of a linear solver; or, of an iterative one, its clipped start
    FEASIBLE = 3  # of an iterative solver, with its certificate
    CONTACTS = 4  # of a solver that finds contacts by itself, with the pressure below them


# as plain numbers: the members of an enumeration are slow to look up
MISSING, IDLE, LINEAR, FEASIBLE, CONTACTS = (int(each) for each in Answer)

NS = 1e-9


class EngineState:
    """Arrays (P,) over all patches, those of one kind side by side.

    Attributes
    ----------
    group : which kind the patch is of
    integers, numbers : (3, P) and (2, P) arrays, of which the others are rows; see `cycle_kernel`
    answer : of `Answer`
    rung : of the answer; -1 where there is none
    gap : relative, of the answer
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
