"""Sources of boards: iCub's and CySkin's on CAN buses, and the shared memory of CySkin's tool.

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
from collections.abc import Iterable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from time import time_ns

import numpy as np

from skinfield.errors import InputError, Ints, check_count, check_type
from skinfield.signal import Blocks, Count, Port, counters
from skinfield.wire.can.adapters import open_bus
from skinfield.wire.can.bus import Bus, BusSettings
from skinfield.wire.can.messages import CanDecoder, CanMessages
from skinfield.wire.cyskin.board import start_messages, stop_messages
from skinfield.wire.cyskin.codec import CySkinDecoder
from skinfield.wire.cyskin.modules import CySkinBoard, checked_boards, port_of
from skinfield.wire.cyskin.shared_memory import HEADER_KEY, SharedMemoryReader
from skinfield.wire.cyskin.wire import CySkinWire
from skinfield.wire.icub.codec import ICubDecoder
from skinfield.wire.icub.commands import (
    BOARD_CHANNELS,
    BOARDS,
    Message,
    MessageClass,
    Transmit,
    host_message,
    message_id,
)
from skinfield.wire.icub.configuration import ICubConfiguration
from skinfield.wire.sources.streams import LinkedStream

SILENCE = 2.0  # s: longer than a busy computer keeps a board's messages back
FIRST_PAUSE, LAST_PAUSE = 1.0, 10.0  # s between attempts to wake a board
LOOK = 0.1  # s between two looks at who is silent
AT_ONCE = 8


class BoardSupervision:
    """The boards of one bus; without any, nothing is told.

    Parameters
    ----------
    begin, end : sequence of (identifier, data)
        What all boards are told at first, and at last.
    each : sequence of sequences of (identifier, data)
        What each board is told again.
    numbers : (K, B) sequence of sequences of int
        By which messages of each board are known; where there are several, the first are of one
        that nobody configured, the last of one that was.
    mask : int
        Bits of identifiers in which these are.
    period : float, s
        Of the readings.

    Attributes
    ----------
    heard_ns : (K, B) int64 array, ns
        When a message of each of `numbers` came last.
    reconfigured : int
        Times that a board was told its settings after the first.
    """

    def __init__(
        self,
        begin: Sequence[Message] = (),
        end: Sequence[Message] = (),
        each: Sequence[Sequence[Message]] = (),
        numbers: Sequence[Sequence[int]] = ((),),
        mask: int = 0,
        period: float = 1.0,
    ) -> None:
        from skinfield.wire.can.kernel import note_senders

        self._note = note_senders
        self._all, self._stop, self._each = tuple(begin), tuple(end), tuple(each)
        self._numbers: Ints = np.array(numbers, np.int64)
        self._mask = mask
        self._silence = round(1e9 * max(SILENCE, 10 * period))
        self.heard_ns: Ints = np.zeros_like(self._numbers)
        self._configured = [False] * len(each)
        self._queue: deque[Message] = deque()
        self._look = 0
        self.reconfigured = 0
        self.resume(0)

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
        self._due, self._pause = [0] * len(self._each), [FIRST_PAUSE] * len(self._each)

    def heard(self, rows: CanMessages, count: int) -> None:
        """Note who sent."""
        self._note(rows.ids, rows.stamp_ns, count, self._mask, self._numbers, self.heard_ns)

    def attend(self, bus: Bus, now_ns: int) -> None:
        """Look who is silent, and send what is to be sent."""
        if now_ns < self._look - 2e9 * LOOK:  # the clock was set back
            np.minimum(self.heard_ns, now_ns, out=self.heard_ns)
            self._due, self._look = [0] * len(self._due), now_ns
        if now_ns >= self._look:
            self._look = now_ns + round(1e9 * LOOK)
            if not self._queue:
                for row in range(len(self._each)):
                    self._examine(row, now_ns)
        for _ in range(min(AT_ONCE, len(self._queue))):
            if not bus.send(*self._queue[0]):
                break
            self._queue.popleft()

    def _examine(self, row: int, now_ns: int) -> None:
        plain, configured = int(self.heard_ns[0, row]), int(self.heard_ns[-1, row])
        silent = now_ns - max(plain, configured) > self._silence
        forgot = self._configured[row] and plain > configured
        if not silent and not forgot:
            self._due[row], self._pause[row] = 0, FIRST_PAUSE
            if plain != configured:  # else it has not sent since all began
                self._configured[row] = configured > plain
        elif now_ns >= self._due[row]:
            self._queue.extend(self._each[row])
            self._due[row] = now_ns + round(1e9 * self._pause[row])
            self._pause[row] = min(2 * self._pause[row], LAST_PAUSE)
            self.reconfigured += 1

    def stop(self, bus: Bus) -> None:
        """Tell all boards to stop."""
        if bus.up:
            for identifier, data in self._stop:
                bus.send(identifier, data)


def icub_supervision(configuration: ICubConfiguration, place: int) -> BoardSupervision:
    """Boards of an iCub, of bus `place` of their configuration, by their classes and addresses."""
    boards = [board for board in configuration.boards if board.bus == place]
    return BoardSupervision(
        configuration.messages(place),
        configuration.stop_messages(place),
        [(*each.messages, host_message(each.address, Transmit(True))) for each in boards],
        [[message_id(kind, each.address, 0) for each in boards] for kind in MessageClass],
        ~0xF,  # all bits but the triangle's
        configuration.period,
    )


def cyskin_supervision(
    boards: Sequence[CySkinBoard], wire: CySkinWire, period_ms: int
) -> BoardSupervision:
    """Boards of CySkin on one bus."""
    return BoardSupervision(
        start_messages(boards, wire, period_ms=period_ms),
        stop_messages(boards, wire),
        [start_messages([board], wire, period_ms=period_ms) for board in boards],
        [[board.number for board in boards]],
        wire.every_board,
        period_ms * 1e-3,
    )


ROOM = 2048  # messages of one poll of a bus: 0.2 s of a full bus of 1 Mbit/s
ROUNDS = 8  # of a poll, so that a flood cannot keep the cycle from its other work


class Line:
    """One bus of a stream, with the decoder of its messages and who attends to its boards.

    Parameters
    ----------
    settings : BusSettings
        Of the bus, which is opened.
    decoder : CanDecoder
    supervision : BoardSupervision
    """

    def __init__(
        self, settings: BusSettings, decoder: CanDecoder, supervision: BoardSupervision
    ) -> None:
        self.bus, self.decoder, self.supervision = open_bus(settings), decoder, supervision
        self.close = self.bus.close
        self._rows = CanMessages(ROOM)
        self._first = self._count = self._malformed = 0
        decoder.decode(self._rows, 0, Blocks(1024), 0, counters(), 0)  # compiles
        supervision.heard(self._rows, 0)

    def take(self, blocks: Blocks, channel: int, counts: Ints, now_ns: int) -> None:
        """Append the blocks of what has arrived, and count it."""
        bus = self.bus
        for _ in range(ROUNDS):
            if self._first == self._count:
                self._first, self._count = 0, bus.receive(self._rows)
                if not self._count:
                    break
                self.supervision.heard(self._rows, self._count)
            self._first = self.decoder.decode(
                self._rows, self._count, blocks, channel, counts, self._first
            )
            if self._first < self._count or self._count < ROOM:
                break  # the blocks are full, or the bus is empty
        malformed = bus.malformed + bus.errors
        counts[Count.MALFORMED] += malformed - self._malformed
        self._malformed = malformed
        if bus.up:
            self.supervision.attend(bus, now_ns)


LineParts = tuple[BusSettings, CanDecoder, BoardSupervision]


class ManagedStream(LinkedStream):
    """Buses, each with a decoder; see the module for when boards get messages.

    Parameters
    ----------
    ports : sequence of Port
    parts : iterable of (BusSettings, CanDecoder, BoardSupervision)
        Of each `Line`; all decode to the same ports.
    """

    def __init__(self, ports: Sequence[Port], parts: Iterable[LineParts]) -> None:
        self._leaves = False
        with ExitStack() as undo:
            self._lines = [undo.enter_context(closing(Line(*each))) for each in parts]
            undo.pop_all()
        self.buses = [line.bus for line in self._lines]
        super().__init__(ports, self.buses)
        for line in self._lines:
            line.supervision.begin(time_ns())

    @property
    def reconfigured(self) -> int:
        """Times that a board was told its settings after the first."""
        return sum(line.supervision.reconfigured for line in self._lines)

    def resume(self) -> None:
        """See `Lasting`."""
        for line in self._lines:
            line.supervision.resume(time_ns())

    def leave(self) -> None:
        """See `Lasting`."""
        self._leaves = True

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> None:
        for line in self._lines:
            line.take(blocks, channel, self.counters, now_ns)
        self.counters[Count.OVERFLOWED] = sum(bus.overflowed for bus in self.buses)

    def _went_down(self, place: int) -> None:
        self._lines[place].decoder.reset()

    def _came_back(self, place: int, now_ns: int) -> None:
        one = self._lines[place].supervision
        (one.begin if one.waiting else one.resume)(now_ns)

    def _stop(self) -> None:
        if not self._leaves:
            for line in self._lines:
                line.supervision.stop(line.bus)


NOWHERE = 255  # bus of boards that a port has room for and this device lacks


@dataclass(frozen=True)
class ICubCan:
    """Boards of an iCub on their buses, which are configured, started, and stopped at the end.

    Parameters
    ----------
    configuration : ICubConfiguration
        Of `wire.icub.load_configuration` (the robot's own files) or `configuration_for`.
    buses : tuple of BusSettings
        One for each bus of the configuration.
    configure : bool
        False only listens: another host tells the boards what to do.
    """

    configuration: ICubConfiguration
    buses: tuple[BusSettings, ...] = (BusSettings(),)
    configure: bool = True

    def __post_init__(self) -> None:
        check_type("configuration", self.configuration, ICubConfiguration, "of load_configuration")
        _check_buses(self.buses, len(self.configuration.buses))

    def open(self) -> ManagedStream:
        """Open the buses and tell the boards to send; see `open_bus` for what cannot be used."""
        configuration = self.configuration
        boards, ports = ports_of(configuration)
        return ManagedStream(ports, [
            (
                bus, ICubDecoder(boards, place, period=configuration.period),
                icub_supervision(configuration, place) if self.configure else BoardSupervision(),
            )
            for place, bus in enumerate(self.buses)
        ])  # fmt: skip


def _check_buses(buses: Sequence[BusSettings], needed: int) -> None:
    if len(buses) != needed:
        raise InputError(
            f"buses are {[bus.label for bus in buses]}, expected {needed}: the boards are on so "
            "many"
        )


Boards = tuple[tuple[int, int], ...]


def ports_of(configuration: ICubConfiguration) -> tuple[Boards, tuple[Port, ...]]:
    """Boards in the order of the ports' channels, and the ports.

    Without ports in the configuration there is one, of all its boards and of its name. Boards that
    no port takes are a port of their own, "... without a port". A run that ends within a board
    takes the whole of it: wrappers of boards that are not full count only the triangles there are.
    """
    addresses = configuration.addresses
    if not configuration.ports:
        return addresses, (Port(configuration.name, configuration.channels),)
    places: dict[str, dict[int, int]] = {}
    for run in configuration.ports:
        if any(first % BOARD_CHANNELS for first in (run.first, run.port_first)):
            raise InputError(
                f"port {run.port!r} takes channels from {run.first} on as its channels from "
                f"{run.port_first} on, expected multiples of {BOARD_CHANNELS}: where boards begin"
            )
        for step in range(-(-run.count // BOARD_CHANNELS)):
            place = run.port_first // BOARD_CHANNELS + step
            places.setdefault(run.port, {})[place] = run.first // BOARD_CHANNELS + step
    boards: list[tuple[int, int]] = []
    ports, missing = [], 0
    for name, taken in places.items():
        for place in range(max(taken) + 1):
            boards.append(addresses[taken[place]] if place in taken else (NOWHERE, missing))
            missing += place not in taken
        ports.append(Port(name, BOARD_CHANNELS * (max(taken) + 1)))
    rest = [pair for pair in addresses if pair not in boards]
    if rest:
        ports.append(Port(f"{configuration.name} without a port", BOARD_CHANNELS * len(rest)))
    if missing > BOARDS:
        raise InputError(
            f"ports of {configuration.name!r} have room for {missing} boards more than there are, "
            f"expected at most {BOARDS}: is this the wrapper of that skin?"
        )
    return (*boards, *rest), tuple(ports)


@dataclass(frozen=True)
class CySkinCan:
    """Boards of CySkin, in their application phase, which are started, and stopped at the end.

    All modules are one port of 12 channels each: `wire.cyskin.skin_on_boards` gives the skin
    on these channels.

    Parameters
    ----------
    boards : sequence of CySkinBoard
    buses : sequence of BusSettings
        One for each bus that the boards name.
    wire : CySkinWire
        What is not public of the protocol.
    period_ms : int, ms
        Between two readings.
    configure : bool
        False only listens: another host starts the boards.
    """

    boards: Sequence[CySkinBoard]
    buses: Sequence[BusSettings] = (BusSettings(),)
    wire: CySkinWire = field(default_factory=CySkinWire)
    period_ms: int = 50
    configure: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "boards", checked_boards(self.boards))
        object.__setattr__(self, "buses", tuple(self.buses))
        check_count("period_ms", self.period_ms, 1, 0xFFFF, "ms between two readings")
        _check_buses(self.buses, 1 + max(board.bus for board in self.boards))

    def open(self) -> ManagedStream:
        """Open the buses and start the boards; see `open_bus` for what cannot be used."""
        parts: list[LineParts] = []
        for place, bus in enumerate(self.buses):
            care, mine = BoardSupervision(), [each for each in self.boards if each.bus == place]
            if self.configure:
                care = cyskin_supervision(mine, self.wire, self.period_ms)
            parts.append((bus, CySkinDecoder(self.boards, place, wire=self.wire), care))
        return ManagedStream((port_of(self.boards),), parts)


@dataclass(frozen=True)
class CySkinSharedMemory:
    """What CySkin's own acquisition tool writes for other programs on the same machine.

    Parameters
    ----------
    boards : sequence of CySkinBoard
        Whose modules give each uid its channel.
    key : int
        Of the header; 450 is the tool's.
    """

    boards: Sequence[CySkinBoard]
    key: int = HEADER_KEY

    def __post_init__(self) -> None:
        object.__setattr__(self, "boards", checked_boards(self.boards))

    def open(self) -> "SharedMemoryStream":
        """Look for the memory; the stream is up once the tool has made it."""
        return SharedMemoryStream(self)


class SharedMemoryStream(LinkedStream):
    """See `skinfield.signal.Stream`."""

    def __init__(self, source: CySkinSharedMemory) -> None:
        self._reader = SharedMemoryReader(source.boards, source.key)
        super().__init__((port_of(source.boards),), (self._reader,))
        nothing = np.zeros(0, np.uint32)
        self._reader.put(nothing, Blocks(64), 0, self.counters, 0)  # compiles
        self._reader.reopen()

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> None:
        self._reader.read(blocks, channel, self.counters, now_ns)
