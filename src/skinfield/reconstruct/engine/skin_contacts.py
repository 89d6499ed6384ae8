"""Contacts of all patches of an engine's cycle, as rows of numbers."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Ints, check_shape
from skinfield.estimate.finder import GridLevel
from skinfield.estimate.live_contacts import CONTACT, LiveContacts
from skinfield.estimate.track_memory import TOP
from skinfield.estimate.tracker import Tracker
from skinfield.reconstruct.engine.engine import Engine
from skinfield.reconstruct.engine.results import grid_on
from skinfield.reconstruct.engine.state import CONTACTS, FEASIBLE, IDLE, LINEAR
from skinfield.reconstruct.plan import field_contacts


class SkinContacts:
    """The strongest contacts of each patch after each `Engine.run`, in rows that are handed in.

    Parameters
    ----------
    engine : Engine
    rows : int
        Contacts that are told of each patch, at most.
    tracker : Tracker, optional
        Whose settings count.
    ids : (1,) int64 array, optional
        See below; may lie where others see it.

    Attributes
    ----------
    patches : P of LiveContacts
        In the skin's order.
    followed : (P,) int64 array
        Not 0 where a patch has contacts that may come back: `find` is to be called for readings of
        it that nothing touches, too.
    ids : (1,) int64 array
        The last number that was given to a contact; they are unique over the skin.
    """

    def __init__(
        self,
        engine: Engine,
        *,
        rows: int = 8,
        tracker: Tracker | None = None,
        ids: Ints | None = None,
    ) -> None:
        self._engine = engine
        self._searched = 0 if engine.groups[0].rungs.linear else 1  # where their levels begin
        self.ids: Ints = np.zeros(1, np.int64) if ids is None else ids
        self.patches: list[LiveContacts] = []
        for index, patch in enumerate(engine.skin):
            levels = _levels(engine, patch.name)
            self.patches.append(
                LiveContacts(levels, patch=index, rows=rows, tracker=tracker, ids=self.ids)
            )
        words = np.stack([each.memory.words for each in self.patches])
        for each, its in zip(self.patches, words, strict=True):
            each.memory = each.memory._replace(words=its)
        self.followed: Ints = words[:, TOP]
        self._doubles = [np.zeros(side * side) for side in engine.rungs]
        self._shape = (len(self.patches), rows)
        self._shifts = [engine.results.shift_of(patch) for patch in range(len(self.patches))]
        self._run_in(rows)

    def __call__(self, stamp_ns: int, out: NDArray[np.void], counts: Ints) -> None:
        """Write the contacts of the last cycle.

        Parameters
        ----------
        stamp_ns : int, ns
            Of its readings.
        out : structured (P, N) array of `CONTACT`
        counts : (P,) int64 array
            Receives how many contacts each patch has, which may be more than rows; rows beyond keep
            what they had.
        """
        results = self._engine.results
        if out.shape != self._shape or counts.shape != self._shape[:1]:
            check_shape("out", out, self._shape, "rows of contacts for each patch")
            check_shape("counts", counts, self._shape[:1], "one per patch")
        counts[:] = 0
        missed = (results.answer == IDLE) & (self.followed > 0)
        for patch in ((results.answer >= LINEAR) | missed).nonzero()[0].tolist():
            counts[patch] = self.find(patch, stamp_ns, out[patch])

    def find(self, patch: int, stamp_ns: int, out: NDArray[np.void]) -> int:
        """Write the contacts of one patch that was answered in the last cycle; how many."""
        results = self._engine.results
        if results.answer[patch] < LINEAR:
            return self.patches[patch].take(out, 0, self._shifts[patch], stamp_ns, out)
        if results.answer[patch] == CONTACTS:
            found, shift = results.contacts_of(patch), self._shifts[patch]
            return self.patches[patch].take(*found, shift, stamp_ns, out)
        rung, pressure = int(results.rung[patch]), results.pressure_of(patch)
        if results.answer[patch] == FEASIBLE:
            white = results.whitened_of(patch)
            return self.patches[patch](self._searched + rung, pressure, stamp_ns, out, white)
        double = self._doubles[rung]
        np.copyto(double, pressure)
        return self.patches[patch](rung, double, stamp_ns, out)

    def count_in(self, ids: Ints) -> None:
        """Number contacts in this array (1,) from now on."""
        self.ids = ids
        for each in self.patches:
            each.memory = each.memory._replace(ids=ids)

    def reset(self) -> None:
        """Forget the contacts of before; numbers go on."""
        for each in self.patches:
            each.reset()

    def _run_in(self, rows: int) -> None:
        """So that the first contact is as fast as the next."""
        out = np.zeros(rows, CONTACT)
        for each in self.patches:
            for level, known in enumerate(each.levels):
                each(level, np.zeros(len(known.std)), 0, out)
            each.take(out, 0, np.zeros(2), 0, out)
            each.reset()


def _levels(engine: Engine, name: str) -> list[GridLevel]:
    """Of the rungs on which a patch may be answered: by linear answers, then by searches."""
    group, place = next(
        (group, place)
        for group in engine.groups
        for place, patch in enumerate(group.kind.patches)
        if patch.name == name
    )
    levels = []
    for rung, step in enumerate(group.rungs.steps):
        find = field_contacts(engine.finder, grid_on(group, place, rung))
        if group.rungs.linear or rung == 0:
            levels.append(find.level(step.start))
        if not group.rungs.linear:
            levels.append(find.level(step.operator))
    return levels
