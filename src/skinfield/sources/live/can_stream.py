"""Decoders of CAN messages on their buses, several at once."""

from collections.abc import Sequence
from typing import Protocol

from skinfield.acquisition import Blocks, CanMessages, Count, Port
from skinfield.errors import Ints
from skinfield.sources.buses import Bus
from skinfield.sources.live.link import LinkedStream

ROOM = 2048  # messages of one poll of a bus: 0.2 s of a full bus of 1 Mbit/s
ROUNDS = 8  # of a poll, so that a flood cannot keep the cycle from its other work


class CanDecoder(Protocol):
    """Blocks from the messages of one bus."""

    def decode(
        self,
        messages: CanMessages,
        count: int,
        blocks: Blocks,
        channel: int,
        counters: Ints,
        first: int = 0,
    ) -> int:
        """Append the blocks of rows `first` to `count`; the first row that did not fit."""
        ...

    def reset(self) -> None:
        """Forget what came before."""
        ...


class CanStream(LinkedStream):
    """Buses, each with the decoder of its messages.

    Parameters
    ----------
    ports : sequence of Port
    buses : sequence of Bus
    decoders : sequence of CanDecoder
        One for each bus; all decode to the same ports.
    """

    def __init__(
        self, ports: Sequence[Port], buses: Sequence[Bus], decoders: Sequence[CanDecoder]
    ) -> None:
        super().__init__(ports, buses)
        self.buses = tuple(buses)
        self._decoders = tuple(decoders)
        self._rows = tuple(CanMessages(ROOM) for _ in buses)
        self._first, self._count = [0] * len(self.buses), [0] * len(self.buses)
        self._overflowed, self._malformed = [0] * len(self.buses), [0] * len(self.buses)
        self._warm()

    def _warm(self) -> None:
        """Compile before the first message."""
        blocks = Blocks(1024)
        for rows, decoder in zip(self._rows, self._decoders, strict=True):
            decoder.decode(rows, 0, blocks, 0, self.counters, 0)
            self._heard(0, rows, 0)

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        taken = 0
        for place, bus in enumerate(self.buses):
            taken += self._take_bus(place, bus, blocks, channel)
        return taken

    def _take_bus(self, place: int, bus: Bus, blocks: Blocks, channel: int) -> int:
        rows, decoder = self._rows[place], self._decoders[place]
        first, count, taken = self._first[place], self._count[place], 0
        for _ in range(ROUNDS):
            if first == count:
                first, count = 0, bus.receive(rows)
                if not count:
                    break
                self._heard(place, rows, count)
            done = decoder.decode(rows, count, blocks, channel, self.counters, first)
            taken, first = taken + done - first, done
            if first < count or count < len(rows):
                break  # the blocks are full, or the bus is empty
        self._first[place], self._count[place] = first, count
        self._overflowed[place] = self._count_since(
            Count.OVERFLOWED, bus.overflowed, self._overflowed[place]
        )
        self._malformed[place] = self._count_since(
            Count.MALFORMED, bus.malformed + bus.errors, self._malformed[place]
        )
        return taken

    def _heard(self, place: int, rows: CanMessages, count: int) -> None:
        """Look at messages that a bus brought, before they are decoded."""

    def _went_down(self, place: int) -> None:
        self._decoders[place].reset()
