"""Managed streams of CAN buses: a decoder each, and supervision of boards.

A board calibrates anew each time that it is told, and then takes for its rest whatever presses it.
So one that goes on by itself after a pause is left alone. It is told its settings and to start

- when the stream opens, but for the stream of an engine that was started again;
- when it was silent for `SILENCE` or ten periods, whichever is longer: it may have booted again,
  been plugged in, or missed what it was told. Once more after 1 s, then after 2, 4, 8 and every
  10 s, as it must be left to finish;
- of an iCub, when its readings, which were of class 4, are of class 3: those of a board that nobody
  configured.

Not more than `AT_ONCE` messages are sent in one poll; what a bus does not take is sent later.
"""

from collections import deque
from collections.abc import Sequence
from time import time_ns

import numpy as np

from skinfield.errors import Ints
from skinfield.signal import Blocks, CanDecoder, CanMessages, Count, Port
from skinfield.wire.can.adapters import open_bus
from skinfield.wire.can.bus import Bus, BusSettings
from skinfield.wire.cyskin.board import start_messages, stop_messages
from skinfield.wire.cyskin.modules import CySkinBoard
from skinfield.wire.cyskin.wire import CySkinWire
from skinfield.wire.icub.commands import MessageClass, Transmit, host_message, message_id
from skinfield.wire.icub.configuration import ICubConfiguration
from skinfield.wire.sources.streams import LinkedStream

Message = tuple[int, bytes]  # identifier, data

SILENCE = 2.0  # s: longer than a busy computer keeps a board's messages back
FIRST_PAUSE, LAST_PAUSE = 1.0, 10.0  # s between attempts to wake a board
LOOK = 0.1  # s between two looks at who is silent
AT_ONCE = 8


class BoardSupervision:
    """The boards of one bus.

    Parameters
    ----------
    begin, end : sequence of (identifier, data)
        What all boards are told at first, and at last.
    each : sequence of sequences of (identifier, data)
        What each board is told again.
    numbers : sequence of int
        By which its messages are known, of each board.
    mask : int
        Bits of identifiers in which these are.
    period : float, s
        Of the readings.

    Attributes
    ----------
    heard_ns : (N,) int64 array, ns
        When a message of each of `numbers` came last.
    reconfigured : int
        Times that a board was told its settings after the first.
    """

    def __init__(
        self,
        begin: Sequence[Message],
        end: Sequence[Message],
        each: Sequence[Sequence[Message]],
        numbers: Sequence[int],
        mask: int,
        period: float,
    ) -> None:
        from skinfield.wire.sources.kernels import note_senders

        self._note = note_senders
        self._all, self._stop, self._each = tuple(begin), tuple(end), tuple(each)
        self._numbers: Ints = np.array(numbers, np.int64)
        self._mask = mask
        self._silence = round(1e9 * max(SILENCE, 10 * period))
        self.heard_ns: Ints = np.zeros(len(numbers), np.int64)
        self._due = [0] * len(each)
        self._pause = [FIRST_PAUSE] * len(each)
        self._queue: deque[Message] = deque()
        self._look = 0
        self.reconfigured = 0

    @property
    def waiting(self) -> int:
        """Messages that are to be sent still."""
        return len(self._queue)

    def begin(self, now_ns: int) -> None:
        """Tell all boards everything, as at the beginning."""
        self.resume(now_ns)
        self._queue.extend(self._all)

    def resume(self, now_ns: int) -> None:
        """Take it that all boards were told everything before, and still do it."""
        self._queue.clear()
        self.heard_ns[:] = now_ns  # from here on they may be silent
        for row in range(len(self._each)):
            self._was_heard(row)

    def _was_heard(self, row: int) -> None:
        self._due[row], self._pause[row] = 0, FIRST_PAUSE

    def heard(self, rows: CanMessages, count: int) -> None:
        """Note who sent."""
        self._note(rows.ids, rows.stamp_ns, count, self._mask, self._numbers, self.heard_ns)

    def _last_ns(self, row: int) -> int:
        """When a board sent last."""
        return int(self.heard_ns[row])

    def _forgot(self, row: int) -> bool:
        """Whether a board that sends is known to have forgotten its settings."""
        return False

    def attend(self, bus: Bus, now_ns: int, at_once: int = AT_ONCE) -> None:
        """Look who is silent, and send what is to be sent."""
        if now_ns < self._look - 2e9 * LOOK:  # the clock was set back
            np.minimum(self.heard_ns, now_ns, out=self.heard_ns)
            self._due, self._look = [0] * len(self._due), now_ns
        if now_ns >= self._look:
            self._look = now_ns + round(1e9 * LOOK)
            if not self._queue:
                for row in range(len(self._each)):
                    self._examine(row, now_ns)
        if self._queue:
            self._send(bus, at_once)

    def _examine(self, row: int, now_ns: int) -> None:
        if now_ns - self._last_ns(row) <= self._silence and not self._forgot(row):
            self._was_heard(row)
        elif now_ns >= self._due[row]:
            self._queue.extend(self._each[row])
            self._due[row] = now_ns + round(1e9 * self._pause[row])
            self._pause[row] = min(2 * self._pause[row], LAST_PAUSE)
            self.reconfigured += 1

    def _send(self, bus: Bus, at_once: int) -> None:
        for _ in range(min(at_once, len(self._queue))):
            if not bus.send(*self._queue[0]):
                return
            self._queue.popleft()

    def stop(self, bus: Bus) -> None:
        """Tell all boards to stop."""
        if bus.up:
            for identifier, data in self._stop:
                bus.send(identifier, data)


class ICubSupervision(BoardSupervision):
    """Boards of an iCub, of bus `place` of their configuration, by their addresses and classes."""

    def __init__(self, configuration: ICubConfiguration, place: int) -> None:
        boards = [board for board in configuration.boards if board.bus == place]
        self._configured = [False] * len(boards)
        super().__init__(
            configuration.messages(place),
            configuration.stop_messages(place),
            [(*each.messages, host_message(each.address, Transmit(True))) for each in boards],
            [message_id(kind, each.address, 0) for kind in MessageClass for each in boards],
            ~0xF,  # all bits but the triangle's
            configuration.period,
        )

    def _classes_ns(self, row: int) -> tuple[int, int]:
        """When a board sent readings last as one that nobody configured, and as configured."""
        return int(self.heard_ns[row]), int(self.heard_ns[row + len(self._configured)])

    def _last_ns(self, row: int) -> int:
        return max(self._classes_ns(row))

    def _was_heard(self, row: int) -> None:
        super()._was_heard(row)
        plain, configured = self._classes_ns(row)
        if plain != configured:  # else it has not sent since all began
            self._configured[row] = configured > plain

    def _forgot(self, row: int) -> bool:
        plain, configured = self._classes_ns(row)
        return self._configured[row] and plain > configured


class CySkinSupervision(BoardSupervision):
    """Boards of CySkin on one bus."""

    def __init__(self, boards: Sequence[CySkinBoard], wire: CySkinWire, period_ms: int) -> None:
        super().__init__(
            start_messages(boards, wire, period_ms=period_ms),
            stop_messages(boards, wire),
            [start_messages([board], wire, period_ms=period_ms) for board in boards],
            [board.number for board in boards],
            wire.every_board,
            period_ms * 1e-3,
        )


ROOM = 2048  # messages of one poll of a bus: 0.2 s of a full bus of 1 Mbit/s
ROUNDS = 8  # of a poll, so that a flood cannot keep the cycle from its other work


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


class ManagedStream(CanStream):
    """See `CanStream`, and the module for when boards get messages.

    Parameters
    ----------
    ports : sequence of Port
    buses : sequence of BusSettings
        They are opened.
    decoders : sequence of CanDecoder
        One for each bus.
    supervisions : sequence of BoardSupervision
        One for each bus; empty if another host tells the boards what to do.

    Attributes
    ----------
    reconfigured : int
        Times that a board was told its settings after the first.

    Raises
    ------
    InputError
        If a bus cannot be used; see `open_bus`.
    """

    def __init__(
        self,
        ports: Sequence[Port],
        buses: Sequence[BusSettings],
        decoders: Sequence[CanDecoder],
        supervisions: Sequence[BoardSupervision],
    ) -> None:
        self._supervisions = tuple(supervisions)
        opened: list[Bus] = []
        try:
            for settings in buses:
                opened.append(open_bus(settings))
            super().__init__(ports, opened, decoders)
        except BaseException:
            for bus in opened:
                bus.close()
            raise
        self._begun = self._leaves = False
        for one in self._supervisions:
            one.begin(time_ns())

    @property
    def reconfigured(self) -> int:
        """See above."""
        return sum(one.reconfigured for one in self._supervisions)

    def resume(self) -> None:
        """See `Lasting`."""
        for one in self._supervisions:
            one.resume(time_ns())

    def leave(self) -> None:
        """See `Lasting`."""
        self._leaves = True

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        taken = super()._take(blocks, channel, now_ns)
        for one, bus in zip(self._supervisions, self.buses, strict=False):
            if bus.up:
                one.attend(bus, now_ns, AT_ONCE if self._begun else max(one.waiting, AT_ONCE))
        self._begun = True
        return taken

    def _heard(self, place: int, rows: CanMessages, count: int) -> None:
        if self._supervisions:
            self._supervisions[place].heard(rows, count)

    def _came_back(self, place: int, now_ns: int) -> None:
        if self._supervisions:
            supervisions = self._supervisions[place]
            (supervisions.begin if supervisions.waiting else supervisions.resume)(now_ns)

    def _stop(self) -> None:
        if not self._leaves:
            for one, bus in zip(self._supervisions, self.buses, strict=False):
                one.stop(bus)
