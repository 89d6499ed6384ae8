"""Contacts of all patches, cycle after cycle, with numbers that last."""

import numpy as np

from skinfield.engine import Engine, SkinContacts
from skinfield.errors import Ints
from skinfield.live.slots import Slot


class Touches(SkinContacts):
    """The contacts of every patch, which can go on from what was published of them.

    Parameters
    ----------
    engine : Engine
    rows : int
        Contacts per patch, at most.
    tracks : (1,) int64 array
        Contacts numbered so far.
    """

    def __init__(self, engine: Engine, rows: int, tracks: Ints) -> None:
        super().__init__(engine, rows=rows, ids=tracks)

    def resume(self, kept: Slot) -> None:
        """Go on from the contacts of a cycle as it was published, and know nothing else.

        A replay that begins in the middle has no more than that.
        """
        self.reset()
        for row, contacts, memory in zip(kept.patches, kept.contacts, self.memory, strict=True):
            count = int(row["contacts"])
            told = contacts[:count]
            for name in ("track", "x", "y"):
                memory[name][:count] = told[name]
            memory["last_ns"][:count] = row["stamp_ns"]
            ages = np.rint(told["age"] * 1e9).astype(np.int64)
            memory["first_ns"][:count] = row["stamp_ns"] - ages
