"""Messages on their way: lost, doubled, swapped, each counted."""

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition import CanMessages
from skinfield.errors import Floats, Ints
from skinfield.sources.buses import Bus
from skinfield.virtual.settings import Wires

NONE_KEPT = -2
FAULTS = ("lost", "duplicated", "swapped")


class Fates:
    """Draws what happens to each message of one bus.

    Attributes
    ----------
    chances : (3,) array
        Of being lost, doubled, swapped; may be written at any time.
    counts : (3,) int64 array
        How many were.
    order : (N,) int64 array
        See `draw`.
    """

    def __init__(self, room: int, wires: Wires, rng: np.random.Generator) -> None:
        self.chances: Floats = np.array([wires.lose, wires.duplicate, wires.swap])
        self.counts: Ints = np.zeros(len(FAULTS), np.int64)
        self.order: Ints = np.zeros(2 * room + 2, np.int64)
        self._state: NDArray[np.uint64] = rng.integers(0, 1 << 63, 1, np.uint64)
        self.kept: Ints = np.full(1, NONE_KEPT, np.int64)
        self.draw(0)  # compiles

    def draw(self, count: int) -> int:
        """Put the order of `count` messages into `order`; how many go out."""
        from skinfield.virtual.delivery_kernel import fates

        return int(fates(count, self.chances, self._state, self.kept, self.order, self.counts))

    @property
    def idle(self) -> bool:
        """Whether nothing can happen to the next messages."""
        return not self.chances.any() and int(self.kept[0]) == NONE_KEPT


def chances_of(fates: Fates) -> dict[str, float]:
    """Probabilities by their names."""
    lose, duplicate, swap = (float(each) for each in fates.chances)
    return {"lose": lose, "duplicate": duplicate, "swap": swap}


class CanWire:
    """One CAN bus as the boards see it.

    Attributes
    ----------
    sent, refused, withheld : int
        Messages that went out, that the system did not take, and that met a bus that was off.
    """

    def __init__(self, bus: Bus, room: int, wires: Wires, rng: np.random.Generator) -> None:
        self.bus, self.fates = bus, Fates(room, wires, rng)
        self.made = CanMessages(room)
        self._out = CanMessages(2 * room + 2)
        self._kept = CanMessages(1)
        self.sent = self.refused = self.withheld = 0
        self.off = False
        self._gather(0)  # compiles

    def send(self, count: int) -> None:
        """Send the first `count` of `made`."""
        if self.off:
            self.withheld += count
            return
        if self.fates.idle:
            self._send(self.made, count)
            return
        going = self.fates.draw(count)
        self._gather(going)
        kept = int(self.fates.kept[0])
        if kept >= 0:
            self._kept.ids[0] = self.made.ids[kept]
            self._kept.lengths[0] = self.made.lengths[kept]
            self._kept.data[0] = self.made.data[kept]
            self.fates.kept[0] = -1
        self._send(self._out, going)

    def _send(self, messages: CanMessages, count: int) -> None:
        if not self.bus.up and not self.bus.reopen():
            self.refused += count
            return
        taken = self.bus.send_many(messages, count)
        self.sent += taken
        self.refused += count - taken

    def _gather(self, count: int) -> None:
        from skinfield.virtual.delivery_kernel import gather

        made, kept, out = self.made, self._kept, self._out
        gather(
            self.fates.order, count, made.ids, made.lengths, made.data, kept.ids, kept.lengths,
            kept.data, out.ids, out.lengths, out.data,
        )  # fmt: skip

    def close(self) -> None:
        """Send what was kept back, which then is not swapped, and close the bus."""
        if self.fates.kept[0] == -1 and not self.off:
            self._send(self._kept, 1)
        self.bus.close()
