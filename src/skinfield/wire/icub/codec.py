"""Codec of iCub's skin messages on CAN: messages to blocks, and counts to messages."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, Ints, check_count, check_range
from skinfield.signal import Blocks, Status
from skinfield.signal.block import Octets
from skinfield.wire.can.messages import CanDecoder, CanMessages
from skinfield.wire.icub.commands import (
    BOARD_CHANNELS,
    BOARDS,
    TAXELS,
    TRIANGLES,
    BoardState,
    Firmware,
    SkinType,
    message_id,
)

MESSAGES, PERIOD = 0, 2  # columns of what is learned of each board, as in `kernel`
HEAD, TAIL = 0x40, 0xC0  # first octets of a triangle's two messages
HEAD_TAXELS = 7  # in the first of them
UNPLUGGED = 0xFFFF  # what all converters of a triangle read that is not there


class ICubDecoder(CanDecoder):
    """Decoder of the messages of one bus; a port of several buses has one for each.

    Each message of a triangle becomes a block of its counts, and a tail with diagnostics one of
    status too. Taxel i of triangle t of the board at place b of `boards` is channel
    192 b + 12 t + i of the port.

    Parameters
    ----------
    boards : sequence of (bus, address)
        Of the whole port, in the order of its channels; those of other buses keep their places.
    bus : int
        Whose messages this decoder reads.
    period : float, s
        Of the boards' readings, as they were told; what they really keep is learned.

    Notes
    -----
    Every message counts as one of RECEIVED, MALFORMED and FOREIGN. FOREIGN are other boards, other
    classes, extended identifiers, and the debug messages with identifier 0x100.

    A triangle sends head, tail, head, tail. While that order holds, nothing is counted. A part of
    the same kind and data once more, of the same reading, is DUPLICATED and makes no block. Else
    two heads in a row are one LOST tail, two tails one LOST head. That a part is missing shows by
    the next reading of its triangle. A whole reading that is missing leaves no trace here, other
    than the age of its channels. How a reading is told from the next one, see `kernel`.
    """

    def __init__(
        self, boards: Iterable[tuple[int, int]], bus: int = 0, *, period: float = 0.05
    ) -> None:
        self.boards = checked_boards(boards)
        check_range("period", period, 1e-4, 10.0, "seconds between two readings of a triangle")
        self._positions = np.full(BOARDS, -1, np.int64)
        for place, (its_bus, address) in enumerate(self.boards):
            if its_bus == bus:
                self._positions[address] = place
        self._state = np.zeros(BOARDS * TRIANGLES, np.uint8)
        self._events: Ints = np.zeros((2 * BOARDS * TRIANGLES, 2), np.int64)
        self._learned: Ints = np.zeros((BOARDS, 3), np.int64)
        self._learned[:, PERIOD] = round(period * 1e9)
        self._newest: Octets = np.zeros((2 * BOARDS * TRIANGLES, 8), np.uint8)

    @property
    def channels(self) -> int:
        """Of the whole port: 192 per board."""
        return BOARD_CHANNELS * len(self.boards)

    @property
    def periods(self) -> dict[int, float]:
        """Between two readings, s, by the addresses of the boards that sent on this bus."""
        heard = np.flatnonzero(self._learned[:, MESSAGES])
        return {int(board): float(self._learned[board, PERIOD]) * 1e-9 for board in heard}

    def reset(self) -> None:
        """Forget what came last, as after a break of the connection; not what was learned."""
        self._state[:] = 0
        self._newest[:] = 0

    def _decode(
        self,
        messages: CanMessages,
        first: int,
        count: int,
        blocks: Blocks,
        channel: int,
        counters: Ints,
    ) -> int:
        from skinfield.wire.icub.kernel import decode_messages

        return int(
            decode_messages(
                (messages.ids, messages.lengths, messages.data, messages.stamp_ns), first, count,
                self._positions, (self._state, self._events, self._learned), self._newest,
                (blocks.words, blocks.octets, blocks.end), channel, counters,
            )
        )  # fmt: skip


def checked_boards(boards: Iterable[tuple[int, int]]) -> tuple[tuple[int, int], ...]:
    """Pairs (bus, address) as a tuple."""
    pairs = tuple((bus, address) for bus, address in boards)
    for bus, address in pairs:
        check_count("bus", bus, 0, 255, "index into the buses of the source")
        check_count("address", address, 0, BOARDS - 1, "of a board on its bus")
    if not pairs or len(set(pairs)) < len(pairs):
        raise InputError(
            f"boards are {list(pairs)}, expected one or more, each (bus, address) once: the order "
            "is that of the port's channels"
        )
    return pairs


GAINS = (70, 96, 83, 38, 38, 70, 0, 45, 77, 164, 0, 77)
"""Of the firmware, skin type 0, per channel of a triangle: 128ths of the drift of its pad."""
GAINS_V2 = (58, 91, 39, 23, 35, 90, 0, 38, 68, 115, 0, 86)
"""Of the firmware, skin type 8: pads of the second generation."""
PAD = 6  # channel of the pad that the firmware goes by
PALM_PAD = 11
LAST_FINGERTIP = 4  # triangles 0 to 4 of an ergoCub's hand are its fingertips
NO_GAINS = (0,) * TAXELS
Shorts = NDArray[np.uint16]


def gains_of(kind: int, triangle: int = 0) -> tuple[int, ...]:
    """Gains of the correction of drift, 128ths, per channel of a triangle of the board."""
    if kind == SkinType.COMPENSATED:
        return GAINS
    newer = kind == SkinType.ERGO_HAND and triangle > LAST_FINGERTIP
    return GAINS_V2 if newer or kind == SkinType.COMPENSATED_V2 else NO_GAINS


class ICubEncoder:
    """Triangles of one bus: their counts to messages, for boards in software.

    Counts become bytes as in `mtb3/main_V3.c` and mtb4's `embot_app_application_theSkin.cpp` of
    robotology/icub-firmware, in whole numbers without overflow.

    Parameters
    ----------
    triangles : sequence of (board, triangle)
        Addresses, in the order in which they are sent.
    state : BoardState, optional
        Of all boards, until `follow` says otherwise; all triangles are sent until then.

    Attributes
    ----------
    raw, base : (T, 12) uint16 arrays, converter counts
        What the converters read, and read at the last calibration; the caller writes them.
    sends : (T,) bool array
        Which triangles `encode` sends; the caller writes it.
    """

    def __init__(
        self, triangles: Iterable[tuple[int, int]], state: BoardState | None = None
    ) -> None:
        self.triangles = tuple((board, triangle) for board, triangle in triangles)
        if not self.triangles or len(set(self.triangles)) < len(self.triangles):
            raise InputError(
                f"triangles are {list(self.triangles)}, expected one or more, each (board, "
                "triangle) once"
            )
        count = len(self.triangles)
        self.raw: Shorts = np.full((count, TAXELS), 0x8000, np.uint16)
        self.base: Shorts = self.raw.copy()
        self.sends: NDArray[np.bool_] = np.ones(count, np.bool_)
        self._ids: NDArray[np.uint32] = np.zeros(count, np.uint32)
        self._no_load: Ints = np.zeros((count, 1), np.int64)
        self._shift: Ints = np.zeros((count, 1), np.int64)
        self._gains: Ints = np.zeros((count, TAXELS), np.int64)
        self._pad: Ints = np.zeros((count, 1), np.int64)
        self._negated_first: NDArray[np.bool_] = np.zeros((count, 1), np.bool_)
        for row in range(count):
            self._configure(row, state or BoardState())

    def _configure(self, row: int, state: BoardState) -> None:
        board, triangle = self.triangles[row]
        self._ids[row] = message_id(state.message_class, board, triangle)
        self._no_load[row], self._shift[row] = state.no_load, state.triangles[triangle].shift
        self._gains[row] = gains_of(state.kind, triangle)
        self._pad[row] = PALM_PAD if state.kind == SkinType.PALM else PAD
        self._negated_first[row] = state.firmware == Firmware.MTB4

    def follow(self, board: int, state: BoardState) -> None:
        """Set the triangles of a board as its state says, and which of them it sends."""
        for row, (its_board, triangle) in enumerate(self.triangles):
            if its_board == board:
                self._configure(row, state)
                self.sends[row] = state.sending and state.triangles[triangle].enabled

    def encode(self, messages: CanMessages, first: int, stamp_ns: int) -> int:
        """Write head and tail of each triangle that sends from row `first` on; the row behind."""
        check_count("first", first, 0, len(messages), "row of the messages")
        rows = np.flatnonzero(self.sends)
        end = first + 2 * len(rows)
        if end > len(messages):
            raise InputError(
                f"messages have {len(messages)} rows, expected {end}: two for each triangle "
                "behind those before"
            )
        messages.ids[first:end] = np.repeat(self._ids[rows], 2)
        messages.lengths[first:end], messages.stamp_ns[first:end] = 8, stamp_ns
        messages.data[first:end] = self._data(rows).reshape(-1, 8)
        return end

    def _data(self, rows: Ints) -> Octets:
        """Octets (R, 16) of head and tail of some triangles."""
        raw, base = self.raw[rows].astype(np.int64), self.base[rows].astype(np.int64)
        no_load, shift = self._no_load[rows], self._shift[rows]
        away = raw - base
        warmth = np.take_along_axis(away, self._pad[rows], axis=1)
        product = (np.abs(warmth) >> 2) * self._gains[rows]
        colder = np.where(self._negated_first[rows], -product >> 5, -(product >> 5))
        value = away - np.where(warmth < 0, colder, product >> 5)
        low, high = (no_load - 255) << shift, no_load << shift
        counts = np.where(value <= low, 255, np.where(value >= high, 0, no_load - (value >> shift)))
        beyond = ((value <= 2 * low) | (value >= 2 * high)) @ (1 << np.arange(TAXELS))
        errors = np.where(((raw == 0) & (base != 0)).any(axis=1), int(Status.NO_ACK), 0)
        errors[(raw == UNPLUGGED).all(axis=1)] = int(Status.NOT_CONNECTED)
        data: Octets = np.empty((len(rows), 16), np.uint8)
        data[:, 0], data[:, 8] = HEAD, TAIL
        data[:, 1:8], data[:, 9:14] = counts[:, :HEAD_TAXELS], counts[:, HEAD_TAXELS:]
        data[:, 14], data[:, 15] = beyond >> 4, (beyond & 15) << 4 | errors
        return data
