"""Cycles of an engine that is still starting."""

import numpy as np

from skinfield.engine.state import Answer
from skinfield.live.slots import Head, Slot


def say_nothing(slot: Slot, tracks: int) -> None:
    """Say that all patches are missing, and how many contacts were numbered so far."""
    slot.patches[:] = np.zeros((), slot.patches.dtype)
    slot.patches["answer"] = int(Answer.MISSING)
    slot.patches["gap"] = np.nan
    slot.patches["tracks"] = tracks
    slot.head[Head.FLAGS] = slot.head[Head.FRESH] = slot.head[Head.CONTACTS] = 0
    slot.head[Head.SCRIPT] = 0
    slot.values[:] = 0.0
    slot.valid[:] = 0
