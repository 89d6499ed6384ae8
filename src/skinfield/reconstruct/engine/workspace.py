"""Workspace of a cycle: what its steps share, arrays, costs, the clock and the log."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from skinfield.errors import Ints
from skinfield.reconstruct.engine.intake import EngineReadings
from skinfield.reconstruct.engine.patch_kinds import PatchGroup
from skinfield.reconstruct.engine.state import IDLE, LINEAR, NS, EngineState


class Clockwork:
    """Prepared arrays of an engine, and where a cycle stands.

    Parameters
    ----------
    groups : sequence of PatchGroup
    intake : EngineReadings
    clock : function that returns ns

    Attributes
    ----------
    finds_contacts : bool
        Whether searches find contacts by themselves.
    places : P pairs
        Group of each patch, and its place there.
    raw_rows, valid_rows : sequences of P arrays (L,)
        Each patch's part of what was taken in.
    fits, wide : (P,) int arrays
        Addresses of what finds contacts, and tests whether there are any.
    by_field : set of int
        Patches that were answered by a field where contacts are found.
    costs : (G,) array, s
        What coarse linear answers of each kind of patch take, as it was measured.
    end : int, ns
        When the cycle must be over.
    top : int
        Finest rung of answers, but for a patch that is preferred.
    tops : (P,) array
        Finest rung of each patch.
    foremost : int
        Patch that is preferred; -1: none.
    reserve : float, s
        What linear answers take of all patches that were last put in the order of their turns.
    """

    def __init__(
        self,
        groups: Sequence[PatchGroup],
        intake: EngineReadings,
        clock: Callable[[], int],
    ) -> None:
        from skinfield.reconstruct.engine import cycle_kernel

        self.groups, self.intake, self.clock = groups, intake, clock
        self.kernel: Any = cycle_kernel
        counts, first = [group.count for group in groups], groups[0].rungs
        self.state = state = EngineState(np.repeat(np.arange(len(counts)), counts))
        self.rungs, self.linear = len(first.steps), first.linear
        self.finds_contacts = groups[0].finds_contacts
        self.fits, self.wide = self._addresses()
        self.by_field: set[int] = set()
        self.costs, self.reserve = np.zeros(len(groups)), 0.0
        self.places = [(group, place) for group in groups for place in range(group.count)]
        self.white = [intake.views(intake.white, group.first, group.count) for group in groups]
        self._level = np.zeros_like(intake.white)
        parts = ((group.first, group.count) for group in groups)
        self._levels = [intake.views(self._level, *part) for part in parts]
        rows = [intake.rows_of(patch) for patch in range(len(self.places))]
        self.raw_rows = [intake.raw_of(patch) for patch in range(len(self.places))]
        self.valid_rows = [intake.valid[each] for each in rows]
        self.starts: Ints = np.array(intake.starts, dtype=np.int64)
        self._opened = (
            *(intake.given, intake.wanted, intake.places),
            *((float(intake.quantity.lowest), float(intake.quantity.highest)), intake.how),
            *(intake.per_noise, intake.valid, self.starts, first.start.gaussian is not None),
            *(intake.linear, intake.white, intake.present),
            *(state.invalid, state.integers, state.numbers, state.settled),
        )
        patches, self.end, self.waited = len(self.places), 0, 0
        self.hot = np.zeros(patches, dtype=np.int64)
        self._order, self.tops = np.zeros((2, patches), dtype=np.int64)
        self._idle = np.zeros(patches, np.bool_)
        self.prefer(self.rungs - 1, -1)

    def _addresses(self) -> Ints:
        """Of the fits of all patches, and of the wide loads beside them, (2, P)."""
        fits, wide = list[int](), list[int]()
        for group in self.groups if self.finds_contacts else ():
            fits += [each.fit.packed.address for each in group.data[0]]
            wide += [group.operators[0].wide.address] * group.count
        return np.array([fits, wide], np.int64)

    def prefer(self, top: int, first: int) -> None:
        """Answer on rungs up to `top`; patch `first` on all of them, before others; -1: none."""
        self.top, self.tops[:], self.foremost = top, top, first
        if first >= 0:
            self.tops[first] = self.rungs - 1

    def open(self) -> None:
        """Linearise and whiten what was taken in, and forget the answers of the cycle before."""
        intake = self.intake
        if intake.how > 1:
            intake.linearise()
        intake.all_valid = self.kernel.open_cycle(*self._opened)

    def waits(self) -> bool:
        """Have only those patches be answered that more time for the same readings is for."""
        state = self.state
        np.greater_equal(state.answer, LINEAR, out=self._idle)
        np.greater(self._idle, state.settled, out=self._idle)
        if not self._idle.any():
            return False
        np.copyto(self.intake.present, self._idle)
        return True

    def close(self) -> None:
        """Remember which patches wait for a search."""
        state = self.state
        self.waited = self.kernel.close_cycle(not self.linear, state.integers, state.age)
        state.unforced += 1

    def reset(self) -> None:
        """Forget the readings before."""
        self.state.reset()
        self.waited = 0
        for group in self.groups:
            group.reset()

    @property
    def left(self) -> float:
        """Time until the end, s."""
        return (self.end - self.clock()) * NS

    def test_idle(self) -> None:
        """Sort patches by an idle test on the finest rung: see `sort_idle`."""
        state, intake, rung = self.state, self.intake, self.rungs - 1
        if self.finds_contacts:
            noise = intake.deviation, intake.noise_std
            taken = intake.given, intake.places, *noise, intake.valid, self.starts
            out = intake.present, state.integers, state.numbers
            self.kernel.test_contacts(self.fits, self.wide, *taken, rung, *out)
            for patch in [each for each in self.by_field if state.answer[each] == IDLE]:
                group, place = self.places[patch]
                group.last[place].rest()
                self.by_field.discard(patch)
            return
        for group, white, level in zip(self.groups, self.white, self._levels, strict=True):
            if group.idle_test is not None:
                group.without_offset(white, *group.idle_offset, level)
                group.idle_test.apply(level, self._idle[group.rows])
        known = intake.present, state.invalid, state.integers, state.numbers
        self.kernel.sort_idle(self._idle, rung, *known)

    def touched(self) -> Ints:
        """Patches with a contact: a view, until this is asked again."""
        return self.hot[: self.kernel.list_touched(self.state.integers, self.hot)]

    def since(self, start: int) -> float:
        """Time since a start, ns; s."""
        return (self.clock() - start) * NS

    def in_turn(self, hot: Ints) -> Ints:
        """Patches with a contact in the order of their turns: a view, until this is asked again."""
        state, where = self.state, (self.costs, self._order)
        self.reserve = self.kernel.list_turns(hot, state.age, self.foremost, state.group, *where)
        return self._order[: len(hot)]
