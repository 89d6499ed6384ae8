"""CAN messages in bulk: arrays that drivers fill, and what decodes them to blocks."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, Ints, check_count
from skinfield.signal.block import Octets
from skinfield.signal.blocks import Blocks
from skinfield.signal.source import Count

EXTENDED = 0x80000000  # bits of `ids`, as in Linux's struct can_frame
REMOTE = 0x40000000
ERROR = 0x20000000


class CanMessages:
    """Room for messages of one poll of one bus; nothing is allocated after the beginning.

    Parameters
    ----------
    room : int
        Messages.

    Attributes
    ----------
    ids : (N,) uint32 array
        Identifier of 11 or 29 bits; with `EXTENDED`, `REMOTE`, `ERROR` where set.
    lengths : (N,) uint8 array
        Octets of data, 0 to 8.
    data : (N, 8) uint8 array
    stamp_ns : (N,) int64 array, ns
        Since the epoch, when the host took the message in; the kernel's where it offers one.
    """

    def __init__(self, room: int = 4096) -> None:
        check_count("room", room, 1, 1 << 24, "messages of one poll")
        self.ids: NDArray[np.uint32] = np.zeros(room, np.uint32)
        self.lengths: Octets = np.zeros(room, np.uint8)
        self.data: Octets = np.zeros((room, 8), np.uint8)
        self.stamp_ns: Ints = np.zeros(room, np.int64)

    def __len__(self) -> int:
        return len(self.ids)

    def put(self, row: int, identifier: int, data: bytes) -> None:
        """Write one message.

        Raises
        ------
        InputError
            If the data is longer than 8 octets.
        """
        if len(data) > 8:
            raise InputError(f"data has {len(data)} octets, expected up to 8: classic CAN")
        self.ids[row], self.lengths[row], self.stamp_ns[row] = identifier, len(data), 0
        self.data[row] = np.frombuffer(data.ljust(8, b"\0"), np.uint8)

    def check_rows(self, count: int) -> None:
        """Raise InputError unless the first `count` rows are there."""
        if not 0 <= count <= len(self):
            raise InputError(
                f"rows 0 to {count} are asked for, expected some of 0 to {len(self)}: the room of "
                "these messages"
            )


class CanDecoder:
    """Decoder of the messages of one bus; boards of every kind have their own."""

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
        if not 0 <= first <= count <= len(messages) or len(counters) < len(Count) or channel < 0:
            raise InputError(
                f"rows {first} to {count} of {len(messages)}, channel {channel} and "
                f"{len(counters)} counters, expected rows of the messages, a channel from 0 and "
                f"{len(Count)} counters: hand in those of the stream"
            )
        return self._decode(messages, first, count, blocks, channel, counters)

    def reset(self) -> None:
        """Forget what came before, as after a break of the connection."""
        raise NotImplementedError

    def _decode(
        self,
        messages: CanMessages,
        first: int,
        count: int,
        blocks: Blocks,
        channel: int,
        counters: Ints,
    ) -> int:
        raise NotImplementedError
