"""Responses of sensors to CAN messages, compiled: for a skin in software."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets
from skinfield.errors import Ints
from skinfield.protocols.cyskin.checksum_kernel import summed

FIRST, MID, LAST, SINGLE = 1, 2, 4, 5  # as `Part`
SENSOR_DATA = 0x43
EXTENDED = 0x80000000
FULL = -1

Table = NDArray[np.int64]


@njit(cache=True, nogil=True)
def encode_board(
    counts: NDArray[np.uint16],
    number: int,
    channels: Ints,
    begins: Ints,
    modules: int,
    per_packet: int,
    extended: bool,
    big_endian: bool,
    sequence: int,
    check: Table,
    table: Table,
    packet: Octets,
    ids: NDArray[np.uint32],
    lengths: Octets,
    data: Octets,
    stamps: Ints,
    first: int,
    stamp_ns: int,
) -> tuple[int, int]:
    """Write one reading of one board as messages from row `first` on.

    Parameters
    ----------
    counts : (C,) uint16 array
        Of all channels of the port.
    channels, begins, modules : arrays, int
        As in `SensorTable`, of this board.
    per_packet : int
        Responses in a packet at most.
    sequence : int
        Number of the first packet, or -1 for none.
    packet : (ROOM,) uint8 array
        Scratch.

    Returns
    -------
    row, sequence : int
        Behind the last message, or FULL; number of the next packet.
    """
    at, end, module = begins[0], begins[modules], 0
    while at < end:
        while begins[module + 1] <= at:
            module += 1
        some = min(per_packet, end - at)
        length = fill(
            packet, counts, channels, at, some, module, at - begins[module], big_endian, sequence,
            check, table,
        )  # fmt: skip
        first = split(packet, length, number, extended, ids, lengths, data, stamps, first, stamp_ns)
        if first < 0:
            return FULL, sequence
        if sequence >= 0:
            sequence = (sequence + 1) & 15
        at += some
    return first, sequence


@njit(cache=True, nogil=True)
def fill(
    packet: Octets,
    counts: NDArray[np.uint16],
    channels: Ints,
    at: int,
    some: int,
    module: int,
    sensor: int,
    big_endian: bool,
    sequence: int,
    check: Table,
    table: Table,
) -> int:
    """Write one packet of sensor data; its octets."""
    head = 0
    if sequence >= 0:
        packet[0], head = sequence, 1
    packet[head], packet[head + 1] = SENSOR_DATA, 2 + 2 * some
    packet[head + 2], packet[head + 3] = module, sensor
    to = head + 4
    for k in range(some):
        count = int(counts[channels[at + k]])
        high, low = count >> 8, count & 0xFF
        packet[to] = high if big_endian else low
        packet[to + 1] = low if big_endian else high
        to += 2
    crc = summed(packet, 0, to, check, table)
    for k in range(check[1]):
        packet[to + k] = (crc >> (8 * k)) & 0xFF
    return int(to + check[1])


@njit(cache=True, nogil=True)
def split(
    packet: Octets,
    length: int,
    number: int,
    extended: bool,
    ids: NDArray[np.uint32],
    lengths: Octets,
    data: Octets,
    stamps: Ints,
    row: int,
    stamp_ns: int,
) -> int:
    """Write a packet as messages from `row` on; the row behind them, or FULL."""
    if row + ((length + 7) >> 3) > len(ids):
        return FULL
    for at in range(0, length, 8):
        part = FIRST if at == 0 else MID
        if at + 8 >= length:
            part = LAST if at else SINGLE
        ids[row] = (EXTENDED | part << 26 | number) if extended else (part << 8 | number)
        lengths[row] = min(8, length - at)
        for k in range(8):
            data[row, k] = packet[at + k] if at + k < length else 0
        stamps[row] = stamp_ns
        row += 1
    return row
