"""Where packets begin and end in bytes, compiled. The layout is that of `layout`."""

from numba import njit

from skinfield.acquisition.block import Octets
from skinfield.acquisition.kernel import payload_words
from skinfield.protocols.packet.crc import crc_ccitt

S, F, VERSION = 0x53, 0x46, 1
HEADER_BYTES, CRC_BYTES, LONGEST_PAYLOAD = 24, 2, 4064
BYTES, SHORTS, FLOATS, STATUS, SIGNED = 1, 2, 3, 4, 5  # as `PacketKind`
BLOCK_STATUS, BLOCK_FLOATS = 4, 3  # as `Kind`
MORE, NONE = 0, -1


@njit(cache=True, nogil=True)
def u16(octets: Octets, at: int) -> int:
    """Little-endian, of two bytes."""
    return int(octets[at]) | int(octets[at + 1]) << 8


@njit(cache=True, nogil=True)
def u32(octets: Octets, at: int) -> int:
    """Little-endian, of four bytes."""
    return u16(octets, at) | u16(octets, at + 2) << 16


@njit(cache=True, nogil=True)
def stated_payload(kind: int, count: int) -> int:
    """Bytes of payload that kind and count ask for; -1 where they leave it open."""
    if kind == BYTES:
        return count
    if kind in (SHORTS, SIGNED):
        return 2 * count
    if kind == FLOATS:
        return 4 * count
    if kind == STATUS:
        return (count + 7) >> 3
    return -1


@njit(cache=True, nogil=True)
def packet_size(octets: Octets, at: int, stop: int) -> int:
    """Bytes of the packet at `at`; MORE if it may be one that is not whole yet; else NONE."""
    room = stop - at
    if octets[at] != S:
        return NONE
    if room >= 2 and octets[at + 1] != F:
        return NONE
    if room >= 3 and octets[at + 2] != VERSION:
        return NONE
    if room < HEADER_BYTES:
        return MORE
    length = u16(octets, at + 6)
    stated = stated_payload(int(octets[at + 3]), u16(octets, at + 18))
    if length > LONGEST_PAYLOAD or (stated >= 0 and stated != length):
        return NONE
    end = at + HEADER_BYTES + length
    if end + CRC_BYTES > stop:
        return MORE
    if crc_ccitt(octets, at, end) != u16(octets, end):
        return NONE
    return int(end + CRC_BYTES - at)


@njit(cache=True, nogil=True)
def next_magic(octets: Octets, at: int, stop: int) -> int:
    """First byte from `at` on where a packet may begin; `stop` if there is none."""
    while at < stop:
        if octets[at] == S and (at + 1 == stop or octets[at + 1] == F):
            return at
        at += 1
    return stop


@njit(cache=True, nogil=True)
def words_needed(octets: Octets, at: int) -> int:
    """Words of blocks that a packet may become, at most."""
    kind, count = int(octets[at + 3]), u16(octets, at + 18)
    if stated_payload(kind, count) < 0:
        return 0
    clearing = 2 + payload_words(BLOCK_STATUS, count)
    if kind == STATUS:
        return clearing
    return clearing + 2 + payload_words(BLOCK_FLOATS if kind == SIGNED else kind, count)
