"""CAN messages in msgpack, and control messages of datagrams: any octets, read within bounds."""

import numpy as np

from skinfield.acquisition import CanMessages
from skinfield.acquisition.can import ERROR, EXTENDED, REMOTE
from skinfield.sources.buses.can_map_kernel import unpack_messages
from skinfield.sources.buses.can_pack_kernel import ENCODED, pack_messages
from skinfield.sources.buses.datagram_kernel import take_control
from skinfield.sources.buses.msgpack_kernel import behind

INTERPRETED = True
ROWS = 3


def packed(identifier: int, data: bytes) -> bytes:
    """A datagram as skinfield and python-can write it."""
    rows = CanMessages(1)
    rows.ids[0], rows.lengths[0] = identifier, len(data)
    rows.data[0, : len(data)] = np.frombuffer(data, np.uint8)
    octets, lengths, seconds = np.zeros(ENCODED, np.uint8), np.zeros(1, np.int64), np.zeros(1)
    pack_messages(
        rows.ids, rows.lengths, rows.data, rows.stamp_ns, 0, 1, octets, ENCODED, lengths, seconds,
        seconds.view(np.int64),
    )  # fmt: skip
    return octets[: lengths[0]].tobytes()


SEEDS = [
    packed(0x4D5, bytes(8)),
    packed(0x1234 | EXTENDED, b"abc"),
    packed(7 | REMOTE, b""),
    b"\x82\xaearbitration_id\x07\xa4data\x93\x01\x02\x03",
    b"\xdf\xff\xff\xff\xff\xdd\xff\xff\xff\xff",
    (20).to_bytes(8, "little") + b"\x01\0\0\0\x28\0\0\0\x05\0\0\0\0\0\0\0",
]


def one_input(data: bytes) -> None:
    """Read it as a datagram, in the last row of its batch, and as control messages."""
    size = len(data)
    octets = np.zeros((ROWS, size), np.uint8)
    octets[:] = np.frombuffer(data, np.uint8)
    rows, counts = CanMessages(ROWS), np.zeros(2, np.int64)
    last = unpack_messages(
        octets.reshape(-1), size, np.full(ROWS, size, np.int64), np.arange(ROWS),
        np.zeros((ROWS, 32), np.uint8), np.zeros(32, np.uint8), ROWS, 0, rows.ids, rows.lengths,
        rows.data, rows.stamp_ns, counts,
    )  # fmt: skip
    assert last + counts.sum() == (ROWS if size else 0)
    for row in range(last):
        identifier = int(rows.ids[row])
        longest = 0x1FFFFFFF if identifier & EXTENDED else 0x7FF
        assert identifier & 0x1FFFFFFF <= longest
        assert not identifier & ERROR
        assert rows.lengths[row] <= 8
    flat = octets[-1]
    assert -1 <= behind(flat, 0, size) <= size
    take_control(flat, 0, size, 1, np.zeros(2, np.int64))
