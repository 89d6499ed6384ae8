"""CAN messages in bulk, as arrays that drivers fill and decoders read."""

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets
from skinfield.errors import Ints, check_count

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
