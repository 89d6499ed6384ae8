"""Codec of CySkin's sensor data over CAN: messages to blocks, and counts to messages."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, Ints, check_count
from skinfield.signal import Blocks
from skinfield.signal.block import Octets
from skinfield.wire.can.messages import CanDecoder, CanMessages
from skinfield.wire.cyskin.modules import (
    MODULES,
    RESPONSES,
    SENSORS,
    Command,
    CySkinBoard,
    channels_of,
    checked_boards,
)
from skinfield.wire.cyskin.wire import CySkinWire


class SensorTable:
    """Where each sensor that the boards of one bus send belongs.

    Parameters
    ----------
    boards : sequence of CySkinBoard
        Of the whole port, whose channels these are.
    bus : int

    Attributes
    ----------
    numbers : (B,) int64 array
        Of the boards of the bus.
    channels : (S,) int64 array
        Of all their sensors, in the order of sending, board after board.
    begins : (B, 250) int64 array
        Index into `channels` of each module's first sensor, then one behind the last.
    counts : (B,) int64 array
        Modules of each board.
    """

    def __init__(self, boards: Sequence[CySkinBoard], bus: int) -> None:
        ours = [board for board in boards if board.bus == bus]
        self.begins: Ints = np.full((len(ours), MODULES + 2), -1, np.int64)
        channels: list[int] = []
        for row, board in enumerate(ours):
            first = channels_of(boards[: boards.index(board)])
            for place, module in enumerate(board.modules):
                self.begins[row, place] = len(channels)
                channels += [first + SENSORS * place + sensor for sensor in module.sensors]
            self.begins[row, len(board.modules)] = len(channels)
        self.numbers: Ints = np.array([board.number for board in ours], np.int64)
        self.channels: Ints = np.array(channels, np.int64)
        self.counts: Ints = np.array([len(board.modules) for board in ours], np.int64)


class CySkinDecoder(CanDecoder):
    """Decoder of the messages of one bus; a port of several buses has one for each.

    Sensor s of module m, counted over all `boards`, is channel 12 m + s of the port. What a packet
    of sensor data brings becomes one block of SHORTS for each run of channels without a gap.

    Parameters
    ----------
    boards : sequence of CySkinBoard
        Of the whole port, in the order of its channels; those of other buses keep their places.
    bus : int
        Whose messages this decoder reads.
    wire : CySkinWire
        What is not public, see there.

    Notes
    -----
    A message is one of `RECEIVED`, `FOREIGN` (of no board of ours) and `MALFORMED` (neither first,
    nor middle, nor last). Beside that a packet may be

    - `LOST`: a middle or last message without a first, counted once until the next first; a packet
      that another interrupts or that ends early, by as many messages as it still says it has;
    - `MALFORMED`: a wrong checksum, or more octets than it says;
    - `FOREIGN`: sensor data of a module or sensor that the board does not have, and packets that
      begin with a sequence number.

    A first or last message that repeats the one before it is `DUPLICATED` too. A middle one that
    comes twice, and any that comes after a later one, spoils its packet, which shows as lost or
    malformed.
    """

    def __init__(
        self, boards: Iterable[CySkinBoard], bus: int = 0, *, wire: CySkinWire | None = None
    ) -> None:
        from skinfield.wire.cyskin.kernel import IDLE, ROOM

        self.boards = checked_boards(boards)
        self.wire = wire or CySkinWire()
        self.table = SensorTable(self.boards, bus)
        count = len(self.table.numbers)
        self._check = self.wire.checksum.numbers, self.wire.checksum.table
        self._packets: Octets = np.zeros((count, ROOM), np.uint8)
        self._used: Ints = np.full(count, IDLE, np.int64)
        self._previous: Ints = np.zeros(count, np.int64)

    @property
    def channels(self) -> int:
        """Of the whole port: 12 per module."""
        return channels_of(self.boards)

    def reset(self) -> None:
        """Forget half packets, as after a break of the connection."""
        self._used[:] = -1
        self._previous[:] = 0

    def _decode(
        self,
        messages: CanMessages,
        first: int,
        count: int,
        blocks: Blocks,
        channel: int,
        counters: Ints,
    ) -> int:
        from skinfield.wire.cyskin.kernel import decode_messages

        table, wire = self.table, self.wire
        return int(
            decode_messages(
                (messages.ids, messages.lengths, messages.data, messages.stamp_ns), first, count,
                table.numbers, wire.extended, wire.big_endian, self._check,
                (table.channels, table.begins, table.counts),
                (self._packets, self._used, self._previous),
                (blocks.words, blocks.octets, blocks.end), channel, counters,
            )
        )  # fmt: skip


class CySkinEncoder:
    """Boards of one bus: their responses to messages, in plain Python: for boards in software.

    Parameters
    ----------
    boards : sequence of CySkinBoard
        Of the whole port.
    bus : int
        Whose boards send.
    wire : CySkinWire
    per_packet : int
        Responses in a packet at most, 1 to 126; what real boards take is not public.

    Attributes
    ----------
    counts : (C,) uint16 array
        Responses of all channels of the port; the caller writes them.
    sends : (B,) bool array
        Which boards of the bus `encode` sends; the caller writes it.
    """

    def __init__(
        self,
        boards: Iterable[CySkinBoard],
        bus: int = 0,
        *,
        wire: CySkinWire | None = None,
        per_packet: int = RESPONSES,
    ) -> None:
        check_count("per_packet", per_packet, 1, RESPONSES, "responses in a packet")
        self.boards = checked_boards(boards)
        self.wire, self.per_packet = wire or CySkinWire(), per_packet
        self.table = SensorTable(self.boards, bus)
        count = len(self.table.numbers)
        self.counts: NDArray[np.uint16] = np.zeros(channels_of(self.boards), np.uint16)
        self.sends: NDArray[np.bool_] = np.ones(count, np.bool_)

    @property
    def messages_per_reading(self) -> int:
        """CAN messages of one reading of all boards of the bus."""
        fixed = 2 + self.wire.checksum.octets  # octets of a packet before and behind its data
        boards = range(len(self.table.numbers))
        return sum(-(-(fixed + len(d)) // 8) for each in boards for d in self._readings(each))

    def encode(self, messages: CanMessages, first: int, stamp_ns: int) -> int:
        """Write one reading of each board that sends, from row `first` on; the row behind."""
        check_count("first", first, 0, len(messages), "row of the messages")
        row = first
        for board in np.flatnonzero(self.sends).tolist():
            number = int(self.table.numbers[board])
            for data in self._readings(board):
                packet = self.wire.packet(Command.SENSOR_DATA, data)
                for identifier, part in self.wire.messages(number, packet):
                    if row == len(messages):
                        raise InputError(
                            f"messages have {len(messages)} rows, expected "
                            f"{first + self.messages_per_reading}: a whole reading behind those "
                            "before"
                        )
                    messages.put(row, identifier, part)
                    messages.stamp_ns[row] = stamp_ns
                    row += 1
        return row

    def _readings(self, board: int) -> Iterator[bytes]:
        """Module, first sensor and responses of each packet of a board."""
        begins = self.table.begins[board, : self.table.counts[board] + 1]
        form = ">u2" if self.wire.big_endian else "<u2"
        for at in range(int(begins[0]), int(begins[-1]), self.per_packet):
            module = int(np.searchsorted(begins, at, "right")) - 1
            channels = self.table.channels[at : min(at + self.per_packet, int(begins[-1]))]
            responses = self.counts[channels].astype(form).tobytes()
            yield bytes([module, at - int(begins[module])]) + responses
