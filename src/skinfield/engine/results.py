"""Answers of a cycle as arrays that stay where they are, for loops that allocate nothing."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.engine.clockwork import Clockwork
from skinfield.engine.group import Group
from skinfield.engine.state import FEASIBLE, LINEAR
from skinfield.errors import Floats, Ints


class Results:
    """Arrays (P,) over the patches in the skin's order, overwritten by each `Engine.run`.

    Parameters
    ----------
    work : Clockwork
    rows : sequence of int
        Of each patch, in the skin's order, among those of `work`.

    Attributes
    ----------
    answer : int64 array
        Of `Answer`: 0 missing, 1 idle, 2 linear, 3 non-negative.
    rung : int64 array
        Of the answer, counted from the coarsest; -1 where there is none.
    gap : array
        Relative; NaN where none is known.
    iterations : int64 array
    invalid : int64 array
        Taxels that were left out.
    age : int64 array
        Cycles since a touched patch was last searched.
    """

    def __init__(self, work: Clockwork, rows: Sequence[int]) -> None:
        self._work, self._rows = work, list(rows)
        self._order = None if self._rows == sorted(self._rows) else np.array(self._rows)
        self._copied: list[tuple[NDArray[Any], NDArray[Any]]] = []
        state = work.state
        self.answer: Ints = self._in_order(state.answer)
        self.rung: Ints = self._in_order(state.rung)
        self.gap: Floats = self._in_order(state.gap)
        self.iterations: Ints = self._in_order(state.iterations)
        self.invalid: Ints = self._in_order(state.invalid)
        self.age: Ints = self._in_order(state.age)
        self._fields = [self._fields_of(row) for row in self._rows]
        self._whites = [work.intake.white[work.intake.rows_of(row)] for row in self._rows]

    def _in_order(self, array: NDArray[Any]) -> NDArray[Any]:
        """The array itself, or room for its numbers in the skin's order."""
        if self._order is None:
            return array
        self._copied.append((array, array.copy()))
        return self._copied[-1][1]

    def update(self) -> None:
        """Bring the answers into the skin's order, where the engine has another."""
        if self._order is not None:
            for source, target in self._copied:
                np.take(source, self._order, out=target, mode="clip")

    def pressure_of(self, patch: int) -> NDArray[Any]:
        """Pressure (K,) of a patch, counted in the skin's order: a view. 0 where it is missing.

        Of a linear answer in float32, else in float64.
        """
        row = self._rows[patch]
        linear, feasible, nothing = self._fields[patch]
        answer, rung = self._work.state.answer[row], int(self._work.state.rung[row])
        fields = linear if answer == LINEAR else feasible if answer == FEASIBLE else nothing
        return fields[rung]

    def whitened_of(self, patch: int) -> NDArray[Any]:
        """Readings (L,) of a patch in units of their noise, 0 where not valid: a view."""
        return self._whites[patch]

    def row_of(self, patch: int) -> int:
        """Where a patch, counted in the skin's order, stands among those of the engine's work."""
        return self._rows[patch]

    def _fields_of(
        self, row: int
    ) -> tuple[list[NDArray[Any]], list[NDArray[Any]], list[NDArray[Any]]]:
        """Of a patch on each rung: where linear and searched answers are written, and zeros."""
        group: Group = self._work.places[row][0]
        place = row - group.first
        zeros: list[NDArray[Any]] = [np.zeros(each.shape[1]) for each in group.fields]
        for each in zeros:
            each.setflags(write=False)
        linear = [each[place] for each in group.fields]
        return linear, [each[place] for each in group.feasible], zeros
