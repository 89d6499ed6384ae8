"""What iCub's boards send, as blocks of readings."""

from collections.abc import Iterable

import numpy as np

from skinfield.acquisition import Blocks, CanMessages, Count, Port
from skinfield.acquisition.block import Octets
from skinfield.errors import InputError, Ints, check_count, check_range
from skinfield.protocols.icub.numbers import BOARD_CHANNELS, BOARDS, TRIANGLES, MessageClass

MESSAGES, PERIOD = 0, 2  # columns of what is learned of each board, as in `order_kernel`
BOTH = (MessageClass.ANALOG, MessageClass.SKIN)


class ICubDecoder:
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
    channels. How a reading is told from the next one, see `order_kernel`.
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
        self._seen: Ints = np.zeros((3 * BOARDS * TRIANGLES, 2), np.int64)
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
        from skinfield.protocols.icub.decode_kernel import decode_messages

        if not 0 <= first <= count <= len(messages) or len(counters) < len(Count) or channel < 0:
            raise InputError(
                f"rows {first} to {count} of {len(messages)}, channel {channel} and "
                f"{len(counters)} counters, expected rows of the messages, a channel from 0 and "
                f"{len(Count)} counters: hand in those of the stream"
            )
        return int(
            decode_messages(
                messages.ids,
                messages.lengths,
                messages.data,
                messages.stamp_ns,
                first,
                count,
                self._positions,
                self._classes,
                self._state,
                self._seen,
                self._learned,
                self._newest,
                blocks.words,
                blocks.octets,
                blocks.end,
                channel,
                counters,
            )
        )


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
