"""What of a cycle depended on time, written down so that the same can be done again."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from skinfield.engine.state import MASKED, PRODUCT, ROW, TEST
from skinfield.errors import InputError, Ints

SEARCH = 3  # of one patch; the others are those of `Step`
ENTRIES = {PRODUCT: "linear answers", TEST: "idle test", ROW: "linear answer", SEARCH: "search"}
ENTRIES[MASKED] = "masked idle test"
COLUMNS = ("entry", "patch", "rung", "ending", "settled")
WIDTH = len(COLUMNS)


@dataclass(eq=False)
class Script:
    """Rows (N, 5) of what a cycle chose by the clock, in the order in which it was done.

    A row is one of

    - linear answers of all patches (entry 0) on a rung;
    - an idle test of all patches (entry 1) on a rung;
    - a finer linear answer (entry 2) of a patch on a rung;
    - a search (entry 3) of a patch on a rung: how it ended, as its operator codes it, and whether
      it was taken to have come to its end;
    - after an idle test, a patch some of whose taxels were left out and whose own test was on
      another rung (entry 5).

    Patches are counted in the engine's order; what a row does not need is -1.

    Parameters
    ----------
    most : int
        Rows that a cycle may have.

    Attributes
    ----------
    count : int
        Rows of the last cycle.
    """

    most: int
    count: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self._room: Ints = np.full((self.most, WIDTH), -1, dtype=np.int64)
        self._words = self._room.data.cast("B").cast("q")  # quicker to write one by one

    def add(self, entry: int, patch: int, rung: int, ending: int = -1, settled: int = -1) -> None:
        """Append a row."""
        words, at = self._words, WIDTH * self.count
        words[at], words[at + 1], words[at + 2] = entry, patch, rung
        words[at + 3], words[at + 4] = ending, settled
        self.count += 1

    @property
    def rows(self) -> Ints:
        """What was written, (N, 5): a view, which the next cycle overwrites."""
        return self._room[: self.count]


def checked_script(
    script: ArrayLike, patches: int, rungs: int, linear: bool, most: int
) -> list[list[int]]:
    """Rows of a script that a cycle of such an engine may have left.

    Raises
    ------
    InputError
        For any other.
    """
    rows = np.asarray(script)
    if rows.ndim != 2 or rows.shape[1:] != (WIDTH,) or rows.dtype.kind not in "iu":
        raise InputError(
            f"script has shape {rows.shape} of {rows.dtype}, expected (N, {WIDTH}) of int64: "
            "`engine.script` after the cycle that is to be repeated"
        )
    told: list[list[int]] = rows.tolist()
    allowed = (PRODUCT, ROW) if linear else (TEST, MASKED, SEARCH)
    for row, (entry, patch, rung, ending, settled) in enumerate(told):
        of_all = entry in (PRODUCT, TEST)
        known = entry in allowed and 0 <= rung < rungs and (of_all == (row == 0) or entry == TEST)
        known = known and (patch == -1 if of_all else 0 <= patch < patches)
        if entry == SEARCH:
            known = known and ending >= 0 and settled in (0, 1)
        if not known:
            raise InputError(
                f"script row {row} is {(entry, patch, rung, ending, settled)}, expected one of an "
                f"engine of {patches} patches and {rungs} rungs with the same kind of solver: the "
                "script is of another engine, or damaged"
            )
    if not 0 < len(told) <= most:
        raise InputError(f"script has {len(told)} rows, expected 1 to {most}: those of a cycle")
    return told
