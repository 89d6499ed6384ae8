"""Codec of iCub's skin messages on CAN: messages to blocks, and counts to messages."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import InputError, Ints, check_count, check_range, check_shape
from skinfield.signal import Blocks, CanDecoder, CanMessages, Port
from skinfield.signal.block import Octets
from skinfield.signal.boards import GAINS, GAINS_V2, PAD
from skinfield.wire.icub.commands import (
    BOARD_CHANNELS,
    BOARDS,
    TAXELS,
    TRIANGLES,
    BoardState,
    Firmware,
    MessageClass,
    SkinType,
    message_id,
    skin_type,
)

MESSAGES, PERIOD = 0, 2  # columns of what is learned of each board, as in `kernel`
BOTH = (MessageClass.ANALOG, MessageClass.SKIN)


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
    classes : iterable of MessageClass
        That carry readings: configured boards send class 4, others class 3. Default both.
    period : float, s
        Of the boards' readings, as they were told; what they really keep is learned.

    Notes
    -----
    Every message counts as one of RECEIVED, MALFORMED and FOREIGN. FOREIGN are other boards, other
    classes, extended identifiers, and the debug messages with identifier 0x100.

    A triangle sends head, tail, head, tail. While that order holds, nothing is counted. A part of
    the same kind and data again, of the same reading, is DUPLICATED and makes no block. Else two
    heads in a row are one LOST tail, two tails one LOST head; unless the missing part comes within
    the same reading after, which is SWAPPED. That a part is missing shows by the next reading of
    its triangle. A whole reading that is missing leaves no trace here, other than the age of its
    channels. How a reading is told from the next one, see `kernel`.
    """

    def __init__(
        self,
        boards: Iterable[tuple[int, int]],
        bus: int = 0,
        *,
        classes: Iterable[MessageClass] = BOTH,
        period: float = 0.05,
    ) -> None:
        self.boards = checked_boards(boards)
        check_range("period", period, 1e-4, 10.0, "seconds between two readings of a triangle")
        self._classes = sum(1 << int(MessageClass(each)) for each in set(classes))
        self._positions = np.full(BOARDS, -1, np.int64)
        for place, (its_bus, address) in enumerate(self.boards):
            if its_bus == bus:
                self._positions[address] = place
        self._state = np.zeros(BOARDS * TRIANGLES, np.uint8)
        self._events: Ints = np.zeros((3 * BOARDS * TRIANGLES, 2), np.int64)
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
                messages.ids, messages.lengths, messages.data, messages.stamp_ns, first, count,
                self._positions, self._classes, self._state, self._events, self._learned,
                self._newest, blocks.words, blocks.octets, blocks.end, channel, counters,
            )
        )  # fmt: skip


def checked_boards(boards: Iterable[tuple[int, int]]) -> tuple[tuple[int, int], ...]:
    """Pairs (bus, address) as a tuple.

    Raises
    ------
    InputError
        If there is none, one twice, or a number out of range.
    """
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


def port_of(name: str, boards: Iterable[tuple[int, int]]) -> Port:
    """Port of such boards: 192 channels each."""
    return Port(name, BOARD_CHANNELS * len(checked_boards(boards)))


PALM_PAD = 11
LAST_FINGERTIP = 4  # triangles 0 to 4 of an ergoCub's hand are its fingertips
NO_GAINS = (0,) * TAXELS
Shorts = NDArray[np.uint16]


def gains_of(kind: SkinType, triangle: int = 0) -> tuple[int, ...]:
    """Gains of the correction of drift, 128ths, per channel of a triangle of the board."""
    if kind == SkinType.ERGO_HAND:
        return GAINS_V2 if triangle > LAST_FINGERTIP else NO_GAINS
    known = {SkinType.COMPENSATED: GAINS, SkinType.COMPENSATED_V2: GAINS_V2}
    return known.get(kind, NO_GAINS)


class ICubEncoder:
    """Triangles of one bus: their counts to messages, in one compiled call that allocates nothing.

    Parameters
    ----------
    triangles : sequence of (board, triangle)
        Addresses, in the order in which they are sent.
    firmware : Firmware
        Generation of the boards.
    message_class : MessageClass
    no_load, shift : int
        Byte at rest, and bits that are dropped, of all triangles until `configure` says otherwise.
    kind : SkinType

    Attributes
    ----------
    raw, base : (T, 12) uint16 arrays, converter counts
        What the converters read, and read at the last calibration; the caller writes them.
    sends : (T,) bool array
        Which triangles `encode` sends; the caller writes it.
    """

    def __init__(
        self,
        triangles: Iterable[tuple[int, int]],
        *,
        firmware: Firmware = Firmware.MTB4,
        message_class: MessageClass = MessageClass.SKIN,
        no_load: int = 240,
        shift: int = 2,
        kind: SkinType = SkinType.COMPENSATED,
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
        self._no_load: Ints = np.zeros(count, np.int64)
        self._shift: Ints = np.zeros(count, np.int64)
        self._gains: Ints = np.zeros((count, TAXELS), np.int64)
        self._pad: Ints = np.zeros(count, np.int64)
        self._raw_test: NDArray[np.bool_] = np.zeros(count, np.bool_)
        self._ids: NDArray[np.uint32] = np.zeros(count, np.uint32)
        self._negated_first: NDArray[np.bool_] = np.full(count, firmware == Firmware.MTB4)
        for row in range(count):
            self.configure(
                row, message_class=message_class, no_load=no_load, shift=shift, kind=kind
            )

    def __len__(self) -> int:
        return len(self.triangles)

    def configure(
        self,
        row: int,
        *,
        message_class: MessageClass,
        no_load: int,
        shift: int,
        kind: SkinType,
    ) -> None:
        """Set how triangle `row` of `triangles` is sent from now on.

        Raises
        ------
        InputError
            If `no_load` is no byte, `shift` is not 0 to 15, or `kind` is unknown.
        """
        check_count("row", row, 0, len(self) - 1, "index into triangles")
        check_count("no_load", no_load, 0, 255, "the byte of an unloaded taxel, 240 on most robots")
        check_count("shift", shift, 0, 15, "bits that the board drops, 2 on most robots")
        kind = skin_type(kind)
        board, triangle = self.triangles[row]
        self._ids[row] = message_id(message_class, board, triangle)
        self._no_load[row], self._shift[row] = no_load, shift
        self._gains[row] = gains_of(kind, triangle)
        self._raw_test[row] = kind == SkinType.RAW_TEST
        self._pad[row] = PALM_PAD if kind == SkinType.PALM else PAD

    def follow(self, board: int, state: BoardState) -> None:
        """Set the triangles of a board as its state says, and which of them it sends."""
        for row, (its_board, triangle) in enumerate(self.triangles):
            if its_board == board:
                settings = state.triangles[triangle]
                self.configure(
                    row,
                    message_class=state.message_class,
                    no_load=state.no_load,
                    shift=settings.shift,
                    kind=state.kind,
                )
                self._negated_first[row] = state.firmware == Firmware.MTB4
                self.sends[row] = state.sending and settings.enabled

    def encode(self, messages: CanMessages, first: int, stamp_ns: int) -> int:
        """Write head and tail of each triangle that sends from row `first` on.

        Returns
        -------
        int
            The row behind the last one.

        Raises
        ------
        InputError
            If `messages` has too few rows.
        """
        from skinfield.wire.icub.kernel import encode_messages

        check_count("first", first, 0, len(messages), "row of the messages")
        end = encode_messages(
            self.raw, self.base, self.sends, self._no_load, self._shift, self._gains, self._pad,
            self._negated_first, self._raw_test, self._ids, messages.ids, messages.lengths,
            messages.data, messages.stamp_ns, first, stamp_ns,
        )  # fmt: skip
        if end < 0:
            raise InputError(
                f"messages have {len(messages)} rows, expected {first + 2 * len(self)}: two for "
                "each triangle behind those before"
            )
        return int(end)


def triangle_payloads(
    raw: ArrayLike,
    base: ArrayLike,
    *,
    firmware: Firmware = Firmware.MTB4,
    no_load: int = 240,
    shift: int = 2,
    kind: SkinType = SkinType.COMPENSATED,
) -> tuple[bytes, bytes]:
    """Head and tail of one triangle; for tests and tools, not for the loop.

    Parameters
    ----------
    raw, base : (12,) arrays, converter counts
        0 to 65535.
    """
    encoder = ICubEncoder([(0, 0)], firmware=firmware, no_load=no_load, shift=shift, kind=kind)
    for name, values, into in (("raw", raw, encoder.raw), ("base", base, encoder.base)):
        array = np.asarray(values)
        check_shape(name, array, (TAXELS,), "one converter count for each channel")
        if array.dtype.kind not in "iu" or (array < 0).any() or (array > 0xFFFF).any():
            raise InputError(f"{name} is {array}, expected whole numbers from 0 to 65535")
        into[0] = array
    messages = CanMessages(2)
    encoder.encode(messages, 0, 0)
    return messages.data[0].tobytes(), messages.data[1].tobytes()
