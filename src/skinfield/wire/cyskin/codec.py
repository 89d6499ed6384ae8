"""Codec of CySkin's sensor data, over CAN and EtherCAT.

Of EtherCAT there is no transport: hand in the octets of a slave's process data.

A slave sends three segments of 1280 octets, one in each cycle, which follow one another here. Its
messages, as `msg_struct.h` and `ecatHandler.cpp` have them:

====== ===== ===================================================================
offset bytes message of data
====== ===== ===================================================================
0      1     2
1      1     type of sensor
2      2     octets of the whole message, big-endian
4      1     module, from 0 on, among those of the first message
5      1     first sensor of it
6      2     responses, big-endian, running on across modules
====== ===== ===================================================================

The first message, once after the start: 1, 0xAA, length, then little-endian the number of the board
(4), its modules (1), and for each of them the 11 octets of `ModuleDetails`.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from struct import pack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import InputError, Ints, check_count, check_shape
from skinfield.signal import Blocks, CanDecoder, CanMessages, Count
from skinfield.signal.block import Octets
from skinfield.wire.cyskin.board import DETAILS, ModuleDetails
from skinfield.wire.cyskin.modules import (
    FIRST_COMMAND,
    MODULES,
    RESPONSES,
    CySkinBoard,
    channels_of,
    checked_boards,
    uids_of,
)
from skinfield.wire.cyskin.wire import CySkinWire

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
    parts: list[Ints] = []
    for board in boards:
        sizes = [len(module.sensors) for module in board.modules]
        if board.bus == bus:
            begins[row, : len(sizes) + 1] = sent + np.cumsum([0, *sizes])
            parts.append(channels[at : at + sum(sizes)])
            row, sent = row + 1, sent + sum(sizes)
        at += sum(sizes)
    return SensorTable(
        numbers=np.array([board.number for board in ours], np.int64),
        channels=np.concatenate(parts) if parts else np.zeros(0, np.int64),
        begins=begins,
        counts=np.array([len(board.modules) for board in ours], np.int64),
    )


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
        from skinfield.wire.cyskin.kernel import IDLE, ROOM

        self.boards = checked_boards(boards)
        self.wire = wire or CySkinWire()
        self.table = sensor_table(self.boards, bus)
        count = len(self.table.numbers)
        self._check = self.wire.checksum.numbers
        self._sums = self.wire.checksum.table
        self._packets: Octets = np.zeros((count, ROOM), np.uint8)
        self._used: Ints = np.full(count, IDLE, np.int64)
        self._previous: Ints = np.zeros(count, np.int64)
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
                messages.ids, messages.lengths, messages.data, messages.stamp_ns, first, count,
                table.numbers, wire.extended, wire.big_endian, wire.numbered, self._check,
                self._sums, table.channels, table.begins, table.counts, self._packets, self._used,
                self._previous, self._number, self._replies, self._heads, blocks.words,
                blocks.octets, blocks.end, channel, counters,
            )
        )  # fmt: skip

    def replies(self) -> list[Reply]:
        """Packets that were no sensor data since the last call, at most 64; for the start."""
        parts, replies = int(self._heads[REPLIES, 0]), []
        tail = int(self._check[1])
        for octets, (row, length) in zip(self._replies, self._heads[:parts].tolist(), strict=False):
            packet = octets[: length - tail].tobytes()
            at = 1 if packet[0] < FIRST_COMMAND else 0
            replies.append(Reply(int(self.table.numbers[row]), packet[at], packet[at + 2 :]))
        self._heads[REPLIES, 0] = 0
        return replies


class CySkinEncoder:
    """Boards of one bus: their responses to messages, compiled, without allocating.

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
        from skinfield.wire.cyskin.kernel import ROOM

        check_count("per_packet", per_packet, 1, RESPONSES, "responses in a packet")
        self.boards = checked_boards(boards)
        self.wire, self.per_packet = wire or CySkinWire(), per_packet
        self.table = sensor_table(self.boards, bus)
        count = len(self.table.numbers)
        self.counts: NDArray[np.uint16] = np.zeros(channels_of(self.boards), np.uint16)
        self.sends: NDArray[np.bool_] = np.ones(count, np.bool_)
        self._sequence: Ints = np.full(count, 0 if self.wire.numbered else -1, np.int64)
        self._check, self._sums = self.wire.checksum.numbers, self.wire.checksum.table
        self._packet: Octets = np.zeros(ROOM, np.uint8)

    @property
    def messages_per_reading(self) -> int:
        """CAN messages of one reading of all boards of the bus."""
        fixed = 4 + int(self.wire.numbered) + int(self._check[1])  # octets beside the responses
        total = 0
        for row, count in enumerate(self.table.counts):
            sensors = int(self.table.begins[row, count] - self.table.begins[row, 0])
            whole, rest = divmod(sensors, self.per_packet)
            for packets, responses in ((whole, self.per_packet), (bool(rest), rest)):
                total += packets * -(-(fixed + 2 * responses) // 8)
        return total

    def encode(self, messages: CanMessages, first: int, stamp_ns: int) -> int:
        """Write one reading of each board that sends, from row `first` on.

        Returns
        -------
        int
            The row behind the last one.

        Raises
        ------
        InputError
            If `messages` has too few rows.
        """
        from skinfield.wire.cyskin.kernel import encode_board

        check_count("first", first, 0, len(messages), "row of the messages")
        table, row = self.table, first
        for board, number in enumerate(table.numbers):
            if not self.sends[board]:
                continue
            row, self._sequence[board] = encode_board(
                self.counts, number, table.channels, table.begins[board], table.counts[board],
                self.per_packet, self.wire.extended, self.wire.big_endian, self._sequence[board],
                self._check, self._sums, self._packet, messages.ids, messages.lengths,
                messages.data, messages.stamp_ns, row, stamp_ns,
            )  # fmt: skip
            if row < 0:
                raise InputError(
                    f"messages have {len(messages)} rows, expected "
                    f"{first + self.messages_per_reading}: a whole reading behind those before"
                )
        return row


SEGMENT = 1280  # octets
SEGMENTS = 3
PROCESS = SEGMENT * SEGMENTS
INIT, DATA, INIT_MARK = 1, 2, 0xAA
HEAD = 9  # octets before the modules of the first message


def board_from_init(octets: bytes, bus: int = 0) -> CySkinBoard:
    """Board and modules that a slave's first message tells.

    Raises
    ------
    InputError
        If it is no such message, or shorter than its modules.
    """
    if len(octets) < HEAD or octets[0] != INIT or octets[1] != INIT_MARK:
        raise InputError(
            f"process data begin with {octets[:HEAD].hex(' ')}, expected 01 aa: the first message "
            "of a slave"
        )
    number, count = int.from_bytes(octets[4:8], "little"), octets[8]
    if count > MODULES or len(octets) < HEAD + DETAILS * count:
        raise InputError(
            f"{len(octets)} octets say that {count} modules follow, expected at most {MODULES} "
            f"and {DETAILS} octets for each"
        )
    modules = []
    for i in range(count):
        at = HEAD + DETAILS * i
        modules.append(ModuleDetails.from_data(octets[at : at + DETAILS], "little").module)
    return CySkinBoard(number, tuple(modules), bus)


def init_from_board(board: CySkinBoard) -> bytes:
    """First message of a slave, as `board_from_init` reads it."""
    details = [
        ModuleDetails(index=i, sui=m.sui, sensors=len(m.sensors), uncut=m.uncut).data("little")
        for i, m in enumerate(board.modules)
    ]
    length = HEAD + DETAILS * len(details)
    head = bytes([INIT, INIT_MARK]) + length.to_bytes(2, "big")
    return head + pack("<IB", board.number, len(details)) + b"".join(details)


def data_from_responses(module: int, sensor: int, responses: ArrayLike) -> bytes:
    """Message of data.

    Parameters
    ----------
    module, sensor : int
        Of the first response.
    responses : (n,) array
        Whole numbers from 0 to 65535.

    Raises
    ------
    InputError
        If they do not fit into the three segments.
    """
    values = np.asarray(responses, ">u2")
    length = 6 + 2 * len(values)
    if length > PROCESS:
        raise InputError(f"{len(values)} responses, expected at most {(PROCESS - 6) // 2}")
    head = bytes([DATA, 0]) + length.to_bytes(2, "big") + bytes([module, sensor])
    return head + values.tobytes()


class CySkinEtherCat:
    """Process data of slaves to blocks; the same channels as `CySkinDecoder`.

    A slave has no number for its reading: hand in what is new. Nothing tells what was lost.

    Parameters
    ----------
    boards : sequence of CySkinBoard
        In the order of the slaves.
    """

    def __init__(self, boards: Iterable[CySkinBoard]) -> None:
        self.boards = checked_boards(CySkinBoard(board.number, board.modules) for board in boards)
        self.table = sensor_table(self.boards, 0)

    @property
    def channels(self) -> int:
        """Of the port: 12 per module."""
        return channels_of(self.boards)

    def decode(
        self,
        octets: Octets,
        slave: int,
        blocks: Blocks,
        channel: int,
        counters: Ints,
        now_ns: int,
    ) -> bool:
        """Append what one slave's segments hold.

        Parameters
        ----------
        octets : (3840,) uint8 array
            Its three segments, one after the other.
        slave : int
            Index into `boards`.
        blocks, channel, counters
            As for `CySkinDecoder.decode`.
        now_ns : int, ns

        Returns
        -------
        bool
            False if the blocks have no room; then nothing changed.
        """
        from skinfield.wire.cyskin.kernel import take_responses

        check_shape("octets", octets, (PROCESS,), "three segments of 1280 octets")
        length = int(octets[2]) << 8 | int(octets[3])
        if octets[0] != DATA or not 6 <= length <= PROCESS:
            counters[Count.MALFORMED] += 1
            return True
        table = self.table
        taken = take_responses(
            octets, 4, length - 4, slave, now_ns, True, table.channels, table.begins,
            table.counts, blocks.words, blocks.octets, blocks.end, channel, counters,
        )  # fmt: skip
        if taken:
            counters[Count.RECEIVED] += 1
            counters[Count.BYTES] += length
        return bool(taken)
