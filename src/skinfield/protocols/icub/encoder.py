"""iCub's boards, down to their bits: converter counts to the messages that they send."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.acquisition import CanMessages
from skinfield.conditioning.firmware import GAINS, GAINS_V2, PAD
from skinfield.errors import InputError, Ints, check_count, check_shape
from skinfield.protocols.icub.board import BoardState
from skinfield.protocols.icub.numbers import (
    TAXELS,
    Firmware,
    MessageClass,
    SkinType,
    message_id,
    skin_type,
)

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
        from skinfield.protocols.icub.encode_kernel import encode_messages

        check_count("first", first, 0, len(messages), "row of the messages")
        end = encode_messages(
            self.raw,
            self.base,
            self.sends,
            self._no_load,
            self._shift,
            self._gains,
            self._pad,
            self._negated_first,
            self._raw_test,
            self._ids,
            messages.ids,
            messages.lengths,
            messages.data,
            messages.stamp_ns,
            first,
            stamp_ns,
        )
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
