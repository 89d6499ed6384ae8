"""Contacts of all patches, cycle after cycle, with numbers that last."""

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts import LiveContacts, level_of
from skinfield.engine import Engine
from skinfield.engine.answers import grid_on
from skinfield.errors import Floats, Ints
from skinfield.layout import Skin
from skinfield.live.slots import Slot
from skinfield.pipeline.ladder_estimate import linear_beliefs, searched_beliefs


class Touches:
    """The contacts of every patch.

    Parameters
    ----------
    skin : Skin
    engine : Engine
    rows : int
        Contacts per patch, at most.
    tracks : (1,) int64 array
        Contacts numbered so far.
    """

    def __init__(self, skin: Skin, engine: Engine, rows: int, tracks: Ints) -> None:
        self._found: list[LiveContacts] = []
        place_of = {
            patch.name: (group, place)
            for group in engine.groups
            for place, patch in enumerate(group.kind.patches)
        }
        for number, patch in enumerate(skin):
            group, place = place_of[patch.name]
            levels = []
            for rung, step in enumerate(group.rungs.steps):
                grid = grid_on(group, place, rung)
                linear = linear_beliefs(step)
                searched = linear if step.operator is None else searched_beliefs(step)
                levels += [
                    level_of(grid, each.noise, each.posterior, each.model_error, engine.finder)
                    for each in (linear, searched)
                ]
            self._found.append(LiveContacts(levels, patch=number, rows=rows, ids=tracks))
        self._rooms = [np.zeros(side**2) for side in engine.rungs]

    def find(
        self,
        patch: int,
        rung: int,
        searched: bool,
        pressure: NDArray[np.floating],
        stamp_ns: int,
        out: NDArray[np.void],
    ) -> int:
        """Write the contacts of a patch's field into `out`; how many there are."""
        room: Floats = self._rooms[rung]
        np.copyto(room, pressure)
        return self._found[patch](2 * rung + searched, room, stamp_ns, out)

    def resume(self, kept: Slot) -> None:
        """Go on from the contacts of a cycle as it was published, and know nothing else.

        A replay that begins in the middle has no more than that.
        """
        for row, contacts, its in zip(kept.patches, kept.contacts, self._found, strict=True):
            memory, count = its.memory, int(row["contacts"])
            memory[:] = np.zeros((), memory.dtype)
            told = contacts[:count]
            for name in ("track", "x", "y"):
                memory[name][:count] = told[name]
            memory["last_ns"][:count] = row["stamp_ns"]
            ages = np.rint(told["age"] * 1e9).astype(np.int64)
            memory["first_ns"][:count] = row["stamp_ns"] - ages
