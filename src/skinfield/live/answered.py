"""What a replay gives of each cycle: its answer, or that it has none."""

from dataclasses import dataclass

import numpy as np

from skinfield.acquisition.recorded import Cycle as Recorded
from skinfield.live.slots import PATCH, Slot


@dataclass(frozen=True, eq=False)
class Answered:
    """One cycle, answered again.

    Attributes
    ----------
    recorded : Cycle
        As it was live.
    slot : Slot
        As it is now; overwritten by the next.
    fresh : bool
        Whether it had a new reading.
    same : bool
        Whether contacts and patches are the same, bit for bit.
    whole : bool
        Whether the slot has the pressure of all patches: those that had no reading since the
        replay began keep an answer of which the recording tells the contacts alone.
    """

    recorded: Recorded
    slot: Slot
    fresh: bool
    same: bool
    whole: bool


@dataclass(frozen=True, eq=False)
class Passed:
    """A cycle that could not be answered again.

    Attributes
    ----------
    recorded : Cycle
        As it was live.
    """

    recorded: Recorded


def is_unanswered(cycle: Recorded) -> bool:
    """Whether it is of an engine that was still starting, and told nothing."""
    rows = cycle.patches
    if rows.dtype != PATCH:
        return False
    return not rows["answered_ns"].any() and bool(np.isnan(rows["gap"]).all())
