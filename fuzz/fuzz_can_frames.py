"""CAN messages as struct can_frame, and control messages of datagrams: any octets."""

import numpy as np

from skinfield.wire.can.adapters import structs_of
from skinfield.wire.can.kernel import CONTROL, messages_of_structs, take_headers
from skinfield.wire.can.messages import ERROR, EXTENDED, REMOTE, CanMessages

INTERPRETED = True
DATAGRAMS, ROOM = 3, 16


def packed(*identifiers: int) -> bytes:
    """A datagram of messages without data."""
    rows = CanMessages(len(identifiers))
    rows.ids[:] = identifiers
    return structs_of(rows, len(rows))


SEEDS = [
    packed(0x4D5, 0x1234 | EXTENDED),
    packed(7 | REMOTE, ERROR | 4, 0x800),
    (20).to_bytes(8, "little") + b"\x01\0\0\0\x28\0\0\0\x05\0\0\0\0\0\0\0",
    (32).to_bytes(8, "little") + b"\x01\0\0\0\x23\0\0\0" + bytes(16),
]


def one_input(data: bytes) -> None:
    """Read it as datagrams, in pieces of a few rows, and as control messages."""
    size = len(data)
    stride = -(-max(size, 1) // 4) * 4
    octets = np.zeros((DATAGRAMS, stride), np.uint8)
    octets[:, :size] = np.frombuffer(data, np.uint8)
    rows, counts, cursor = CanMessages(ROOM), np.zeros(2, np.int64), np.zeros(2, np.int64)
    taken = 0
    while cursor[0] < DATAGRAMS:
        last = messages_of_structs(
            octets.reshape(-1), octets.reshape(-1).view(np.uint32), stride,
            np.full(DATAGRAMS, size, np.int64), np.arange(DATAGRAMS), DATAGRAMS, cursor, 0,
            rows.ids, rows.lengths, rows.data, rows.stamp_ns, counts,
        )  # fmt: skip
        taken += last
        for row in range(last):
            identifier = int(rows.ids[row])
            assert identifier & 0x1FFFFFFF <= (0x1FFFFFFF if identifier & EXTENDED else 0x7FF)
            assert not identifier & ERROR
            assert rows.lengths[row] <= 8
    whole = size // 16 if size % 16 == 0 else 1
    assert taken + counts.sum() == DATAGRAMS * whole
    control = np.zeros(DATAGRAMS * CONTROL, np.uint8)
    control.reshape(DATAGRAMS, CONTROL)[:, : min(size, CONTROL)] = octets[:, : min(size, CONTROL)]
    headers = np.full((DATAGRAMS, 8), min(size, CONTROL), np.int64)
    take_headers(
        headers, control.view(np.uint32), DATAGRAMS, 1, np.zeros(DATAGRAMS, np.int64),
        np.zeros(DATAGRAMS, np.int64), np.zeros(2, np.int64),
    )  # fmt: skip
