"""A copy of a slot."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.ring.fields import LINE, Placed
from skinfield.ring.header import SLOT_GENERATION, SLOT_LOG_END


class Slot:
    """A copy of a slot; `RingReader.slot` makes one that can be filled again and again.

    Attributes
    ----------
    number : int
        0 as long as it is empty.
    generation : int
        Of the writer that made it.
    log_end : int, bytes
        Of the log when the slot was complete: what was appended before is at lower positions.
    arrays : dict of str to array
        By the fields' names; ``slot["name"]`` is short for them.
    octets : (slot_bytes,) uint8 array
        The same, as it lies in the ring.
    """

    def __init__(self, fields: tuple[Placed, ...], size: int) -> None:
        self.number = self.generation = self.log_end = 0
        room = np.zeros(size + LINE, np.uint8)
        start = -room.ctypes.data % LINE
        self.octets: NDArray[np.uint8] = room[start : start + size]
        self.arrays: dict[str, NDArray[Any]] = {
            placed.field.name: placed.view(self.octets, 0) for placed in fields
        }
        self._words = self.octets.data.cast("Q")

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def took(self, number: int) -> None:
        """Note which slot `octets` now are a whole copy of; 0 if of none."""
        self.number = number
        self.log_end = self._words[SLOT_LOG_END]
        self.generation = self._words[SLOT_GENERATION]
