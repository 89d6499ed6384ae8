"""CySkin's boards, as far as bytes go: responses to the messages that they send."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition import CanMessages
from skinfield.acquisition.block import Octets
from skinfield.errors import InputError, Ints, check_count
from skinfield.protocols.cyskin.decoder import sensor_table
from skinfield.protocols.cyskin.modules import CySkinBoard, channels_of, checked_boards
from skinfield.protocols.cyskin.numbers import RESPONSES
from skinfield.protocols.cyskin.wire import CySkinWire


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
        from skinfield.protocols.cyskin.decode_kernel import ROOM

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
        from skinfield.protocols.cyskin.encode_kernel import encode_board

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
