"""What CySkin's boards send over CAN, as blocks of readings."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from skinfield.acquisition import Blocks, CanMessages, Count
from skinfield.acquisition.block import Octets
from skinfield.errors import InputError, Ints
from skinfield.protocols.cyskin.modules import (
    CySkinBoard,
    channels_of,
    checked_boards,
    uids_of,
)
from skinfield.protocols.cyskin.numbers import FIRST_COMMAND, MODULES
from skinfield.protocols.cyskin.wire import CySkinWire

REPLIES = 64  # that are kept between two calls of `replies`


@dataclass(frozen=True)
class Reply:
    """A packet of a board that is no sensor data.

    Attributes
    ----------
    board : int
        Its number.
    command : int
        One of `Command`, or one that is not known.
    data : bytes
    """

    board: int
    command: int
    data: bytes


@dataclass(frozen=True, eq=False)
class SensorTable:
    """Where each sensor that a board sends belongs.

    Attributes
    ----------
    numbers : (B,) int64 array
        Of the boards of one bus.
    channels : (S,) int64 array
        Of all their sensors, in the order of sending, board after board.
    begins : (B, 250) int64 array
        Index into `channels` of each module's first sensor, then one behind the last.
    counts : (B,) int64 array
        Modules of each board.
    """

    numbers: Ints
    channels: Ints
    begins: Ints
    counts: Ints


def sensor_table(boards: Iterable[CySkinBoard], bus: int) -> SensorTable:
    """Sensors of the boards of one bus; the channels are those of the whole port."""
    boards = checked_boards(boards)
    ours = [board for board in boards if board.bus == bus]
    begins = np.full((len(ours), MODULES + 2), -1, np.int64)
    channels = uids_of(boards)[1]
    at, row, sent = 0, 0, 0
    kept: list[Ints] = []
    for board in boards:
        sizes = [len(module.sensors) for module in board.modules]
        if board.bus == bus:
            begins[row, : len(sizes) + 1] = sent + np.cumsum([0, *sizes])
            kept.append(channels[at : at + sum(sizes)])
            row, sent = row + 1, sent + sum(sizes)
        at += sum(sizes)
    return SensorTable(
        numbers=np.array([board.number for board in ours], np.int64),
        channels=np.concatenate(kept) if kept else np.zeros(0, np.int64),
        begins=begins,
        counts=np.array([len(board.modules) for board in ours], np.int64),
    )


class CySkinDecoder:
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
      that another interrupts or that ends early, by as many messages as it still says it has; with
      `numbered` also packets whose numbers are missing;
    - `MALFORMED`: a wrong checksum, or more octets than it says;
    - `FOREIGN`: sensor data of a module or sensor that the board does not have, and packets that
      begin with a sequence number without `numbered`.

    A message that comes twice is `DUPLICATED` too: a first or last one that repeats the one before
    it, and a middle one without which length and checksum of its packet are right. One that comes
    after a later one spoils its packet, which shows as lost or malformed.
    """

    def __init__(
        self, boards: Iterable[CySkinBoard], bus: int = 0, *, wire: CySkinWire | None = None
    ) -> None:
        from skinfield.protocols.cyskin.decode_kernel import IDLE, ROOM

        self.boards = checked_boards(boards)
        self.wire = wire or CySkinWire()
        self.table = sensor_table(self.boards, bus)
        count = len(self.table.numbers)
        self._check = self.wire.checksum.numbers
        self._sums = self.wire.checksum.table
        self._packets: Octets = np.zeros((count, ROOM), np.uint8)
        self._used: Ints = np.full(count, IDLE, np.int64)
        self._done: Ints = np.zeros(count, np.int64)
        self._number: Ints = np.full(count, -1, np.int64)
        self._replies: Octets = np.zeros((REPLIES, ROOM), np.uint8)
        self._heads: Ints = np.zeros((REPLIES + 1, 2), np.int64)

    @property
    def channels(self) -> int:
        """Of the whole port: 12 per module."""
        return channels_of(self.boards)

    def reset(self) -> None:
        """Forget half packets, as after a break of the connection."""
        self._used[:] = self._number[:] = -1
        self._done[:] = 0

    def decode(
        self,
        messages: CanMessages,
        count: int,
        blocks: Blocks,
        channel: int,
        counters: Ints,
        first: int = 0,
    ) -> int:
        """Append the blocks of messages `first` to `count`; allocates nothing.

        Parameters
        ----------
        messages : CanMessages
        count : int
            Of its rows that hold messages.
        blocks : Blocks
        channel : int
            That the port's first channel has among all.
        counters : (len(Count),) int64 array
            Written in place.
        first : int
            First row to read.

        Returns
        -------
        int
            First row that did not fit into `blocks`; `count` if all did.
        """
        from skinfield.protocols.cyskin.decode_kernel import decode_messages

        if not 0 <= first <= count <= len(messages) or len(counters) < len(Count) or channel < 0:
            raise InputError(
                f"rows {first} to {count} of {len(messages)}, channel {channel} and "
                f"{len(counters)} counters, expected rows of the messages, a channel from 0 and "
                f"{len(Count)} counters: hand in those of the stream"
            )
        table, wire = self.table, self.wire
        return int(
            decode_messages(
                messages.ids, messages.lengths, messages.data, messages.stamp_ns, first, count,
                table.numbers, wire.extended, wire.big_endian, wire.numbered, self._check,
                self._sums, table.channels, table.begins, table.counts, self._packets, self._used,
                self._done, self._number, self._replies, self._heads, blocks.words, blocks.octets,
                blocks.end, channel, counters,
            )
        )  # fmt: skip

    def replies(self) -> list[Reply]:
        """Packets that were no sensor data since the last call, at most 64; for the start."""
        kept, replies = int(self._heads[REPLIES, 0]), []
        tail = int(self._check[1])
        for octets, (row, length) in zip(self._replies, self._heads[:kept].tolist(), strict=False):
            packet = octets[: length - tail].tobytes()
            at = 1 if packet[0] < FIRST_COMMAND else 0
            replies.append(Reply(int(self.table.numbers[row]), packet[at], packet[at + 2 :]))
        self._heads[REPLIES, 0] = 0
        return replies
