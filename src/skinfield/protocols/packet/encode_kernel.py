"""Readings to packets, compiled: for a skin in software at full speed."""

from numba import njit

from skinfield.acquisition.block import Octets
from skinfield.errors import Ints
from skinfield.protocols.packet.crc import crc_ccitt
from skinfield.protocols.packet.scan import CRC_BYTES, HEADER_BYTES, VERSION, F, S

LAST_FLAG = 1  # as `PacketFlag`


@njit(cache=True, nogil=True)
def encode_reading(
    values: Octets,
    width: int,
    count: int,
    kind: int,
    device: int,
    first: int,
    per_packet: int,
    sequence: int,
    reading: int,
    time: int,
    status: int,
    out: Octets,
    offsets: Ints,
) -> int:
    """Write one reading as packets, one after the other; how many, or -1 without room.

    Parameters
    ----------
    values : (width * count,) uint8 array
        Little-endian numbers.
    out : (B,) uint8 array
    offsets : (P + 1,) int64 array
        Packet i is written to `out[offsets[i]:offsets[i + 1]]`.
    """
    packets = max(1, -(-count // per_packet))
    if packets * (HEADER_BYTES + CRC_BYTES) + width * count > len(out) or packets >= len(offsets):
        return -1
    at, offsets[0] = 0, 0
    for i in range(packets):
        begin = i * per_packet
        some = min(per_packet, count - begin)
        end = at + HEADER_BYTES + width * some
        out[at], out[at + 1], out[at + 2], out[at + 3] = S, F, VERSION, kind
        _put(out, at + 4, device, 2)
        _put(out, at + 6, width * some, 2)
        _put(out, at + 8, sequence + i, 4)
        _put(out, at + 12, time, 4)
        _put(out, at + 16, first + begin, 2)
        _put(out, at + 18, some, 2)
        _put(out, at + 20, reading, 2)
        out[at + 22] = LAST_FLAG if i == packets - 1 else 0
        out[at + 23] = status
        for j in range(width * some):
            out[at + HEADER_BYTES + j] = values[width * begin + j]
        _put(out, end, crc_ccitt(out, at, end), 2)
        at = end + CRC_BYTES
        offsets[i + 1] = at
    return packets


@njit(cache=True, nogil=True)
def _put(out: Octets, at: int, number: int, count: int) -> None:
    for i in range(count):
        out[at + i] = (number >> (8 * i)) & 0xFF
