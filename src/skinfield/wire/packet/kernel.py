"""Packets, compiled: checksums, finding them in bytes, following devices, decoding.

Of the ASCII digits 123456789 it is 0x29B1. `binascii.crc_hqx(data, 0xFFFF)` is the same sum.

Numbers are unwrapped to 64 bits, and each device has a table of the last `WINDOW` of them. A packet
that is further off than that is a late one, or the device began anew: the latter is believed when
the packet after it follows, or at once when it is a HELLO with the sequence number 0. Counts are
right in both cases; what a device sent before its first packet came through is not known.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Ints
from skinfield.signal.block import Octets, Words
from skinfield.signal.blocks_kernel import begin_block

BEGIN = 0xFFFF
S, F, VERSION = 0x53, 0x46, 1
HEADER_BYTES, CRC_BYTES, LONGEST_PAYLOAD = 24, 2, 4064
BYTES, SHORTS, FLOATS, STATUS, SIGNED = 1, 2, 3, 4, 5  # as `PacketKind`
# As `Kind` and `Status`; a plain number would be a type of its own to Numba.
BLOCK_STATUS: Any = np.int64(4)
BLOCK_FLOATS: Any = np.int64(3)
NO_STATUS: Any = np.int64(0)
MORE, NONE = 0, -1
WINDOW = 1024  # packets
FAR = 1 << 24  # packets ahead, beyond which a device is rather believed to have begun anew
LOST, DUPLICATED, SWAPPED = 2, 6, 7  # as `Count`
NEW, TWICE, LATE = 0, 1, 2

# columns of a device's state
OFFSET, CHANNELS, STARTED, NEWEST, FIRST, JUMP, OWED, RESTARTS = 0, 1, 2, 3, 4, 5, 6, 7
HELLO_TIME, TIME, MARKED = 8, 9, 10
COLUMNS = 11
NO_JUMP = -1

HELLO, COMMANDS = 16, 32  # as `PacketKind`
RECEIVED, READINGS, MALFORMED, FOREIGN, OCTETS = 0, 1, 4, 5, 10  # as `Count`
STATUS_BITS = 0x0F  # that `Status` knows
LATEST_NS = 1_000_000_000  # how far back a late packet's stamp is put at most

Into = tuple[Words, Octets, NDArray[np.float32], Words]  # words, octets, singles, end of `Blocks`
Devices = tuple[NDArray[np.int32], Ints, Ints, Octets]  # see `decode_packets`


def _tables() -> NDArray[np.uint16]:
    """What a byte contributes (8, 256), after which 0 to 7 others follow."""
    crc = np.arange(256, dtype=np.uint32) << 8
    for _ in range(8):
        crc = ((crc << 1) ^ np.where(crc & 0x8000, 0x1021, 0).astype(np.uint32)) & 0xFFFF
    rows = [crc]
    for _ in range(7):
        last = rows[-1]
        rows.append(((last << 8) ^ crc[last >> 8]) & 0xFFFF)
    return np.array(rows, np.uint16)


TABLES = _tables()


@njit
def crc_ccitt(octets: Octets, start: int, stop: int) -> int:
    """Sum of `octets[start:stop]`."""
    crc, at = np.uint32(BEGIN), start
    while at + 8 <= stop:
        crc = np.uint32(
            TABLES[7, octets[at] ^ (crc >> 8)]
            ^ TABLES[6, octets[at + 1] ^ (crc & 0xFF)]
            ^ TABLES[5, octets[at + 2]]
            ^ TABLES[4, octets[at + 3]]
            ^ TABLES[3, octets[at + 4]]
            ^ TABLES[2, octets[at + 5]]
            ^ TABLES[1, octets[at + 6]]
            ^ TABLES[0, octets[at + 7]]
        )
        at += 8
    while at < stop:
        crc = np.uint32(((crc << 8) & 0xFFFF) ^ TABLES[0, (crc >> 8) ^ octets[at]])
        at += 1
    return int(crc)


@inner
def u16(octets: Octets, at: int) -> int:
    """Little-endian, of two bytes."""
    return int(np.int64(octets[at]) | np.int64(octets[at + 1]) << 8)


@inner
def u32(octets: Octets, at: int) -> int:
    """Little-endian, of four bytes."""
    return u16(octets, at) | u16(octets, at + 2) << 16


@inner
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


@inner
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
    stated = stated_payload(int(np.int64(octets[at + 3])), u16(octets, at + 18))
    if length > LONGEST_PAYLOAD or (stated >= 0 and stated != length):
        return NONE
    end = at + HEADER_BYTES + length
    if end + CRC_BYTES > stop:
        return MORE
    if crc_ccitt(octets, at, end) != u16(octets, end):
        return NONE
    return int(end + CRC_BYTES - at)


@inner
def next_magic(octets: Octets, at: int, stop: int) -> int:
    """First byte from `at` on where a packet may begin; `stop` if there is none."""
    while at < stop:
        if octets[at] == S and (at + 1 == stop or octets[at + 1] == F):
            return at
        at += 1
    return stop


@inner
def track(row: Ints, window: Ints, sequence: int, time: int, hello: bool, counters: Ints) -> int:
    """Number one packet; NEW, TWICE or LATE.

    Parameters
    ----------
    row : (COLUMNS,) int64 array
        State of the device.
    window : (WINDOW,) int64 array
        Its last numbers.
    sequence, time : int
        As in the packet.
    hello : bool
        Whether it is a HELLO.
    counters : (len(Count),) int64 array
    """
    step = (sequence - row[NEWEST]) & 0xFFFFFFFF
    if step >= 1 << 31:
        step -= 1 << 32
    number = row[NEWEST] + step
    far = step <= -WINDOW or step > FAR
    known = not far and step <= 0 and window[number % WINDOW] == number
    first = hello and sequence == 0  # after the device's start
    restarted = first and (far or (known and time != row[HELLO_TIME]))
    if restarted or row[STARTED] == 0:
        row[RESTARTS] += row[STARTED]
        row[STARTED], row[HELLO_TIME] = 1, time if first else -1
        begin(row, window, sequence)
        return NEW
    if far:
        return track_far(row, window, sequence, number, counters)
    row[JUMP] = NO_JUMP
    if known:
        counters[DUPLICATED] += 1
        return TWICE
    window[number % WINDOW] = number
    if first:
        row[HELLO_TIME] = time
    if step > 0:
        counters[LOST] += step - 1
        row[NEWEST] = number
        return NEW
    counters[SWAPPED] += 1
    if number < row[FIRST]:  # from before the first that came: those between are missing
        counters[LOST] += row[FIRST] - number - 1
        row[FIRST] = number
    else:
        counters[LOST] -= 1
    return LATE


@inner
def begin(row: Ints, window: Ints, sequence: int) -> None:
    """Number packets anew, far above all before."""
    number = (((row[NEWEST] >> 32) + 2) << 32) + sequence
    row[NEWEST] = row[FIRST] = window[number % WINDOW] = number
    row[JUMP] = NO_JUMP


@inner
def track_far(row: Ints, window: Ints, sequence: int, number: int, counters: Ints) -> int:
    """A packet out of the window: late, until the one after it follows."""
    if row[JUMP] == sequence:
        counters[SWAPPED] -= 1
        counters[LOST] += row[OWED]
        begin(row, window, (sequence - 1) & 0xFFFFFFFF)
        row[NEWEST] += 1
        window[row[NEWEST] % WINDOW] = row[NEWEST]
        row[RESTARTS] += 1
        return NEW
    row[JUMP] = (sequence + 1) & 0xFFFFFFFF
    row[OWED] = 1 if row[FIRST] <= number < row[NEWEST] else 0
    counters[SWAPPED] += 1
    counters[LOST] -= row[OWED]
    return LATE


@inner
def take_packet(
    octets: Octets, at: int, into: Into, channel: int, now_ns: int, devices: Devices, counters: Ints
) -> None:
    """Take one whole packet, for whose blocks there is room."""
    slots, state, window, marks = devices
    kind, slot = int(np.int64(octets[at + 3])), slots[u16(octets, at + 4)]
    if slot < 0 or kind >= COMMANDS:
        counters[FOREIGN] += 1
        return
    counters[RECEIVED] += 1
    row, time = state[slot], u32(octets, at + 12)
    order = track(row, window[slot], u32(octets, at + 8), time, kind == HELLO, counters)
    if order == TWICE:
        return
    stamp = now_ns
    if order == LATE:
        stamp -= min(1000 * ((row[TIME] - time) & 0xFFFFFFFF), LATEST_NS)
    else:
        row[TIME] = time
    first, count = u16(octets, at + 16), u16(octets, at + 18)
    if stated_payload(kind, count) < 0:
        return
    if first + count > row[CHANNELS]:
        counters[FOREIGN] += 1
        counters[RECEIVED] -= 1
        return
    words, payloads, singles, end = into
    status, own, payload = octets[at + 23] & STATUS_BITS, row[OFFSET] + first, at + HEADER_BYTES
    if kind == STATUS:
        for i in range(count):
            marks[own + i] = 0
    else:
        counters[READINGS] += 1
        if status or row[MARKED]:
            note_status(into, stamp, channel, own, count, status, row, marks)
    form = BLOCK_FLOATS if kind == SIGNED else kind  # else as `Kind`
    to = begin_block(words, end, stamp, channel + own, count, form, status)
    if kind == SIGNED:
        for i in range(count):
            singles[(to >> 2) + i] = np.float32(np.int16(np.uint16(u16(octets, payload + 2 * i))))
        return
    for i in range(stated_payload(kind, count)):
        payloads[to + i] = octets[payload + i]


@inner
def note_status(
    into: Into,
    stamp: int,
    channel: int,
    own: int,
    count: int,
    status: int,
    row: Ints,
    marks: Octets,
) -> None:
    """Keep in mind what a packet of counts says beside them; take it back where it ceased."""
    if status:
        row[MARKED] = 1
        for i in range(count):
            marks[own + i] = 1
        return
    found = False
    for i in range(count):
        found |= marks[own + i] != 0
        marks[own + i] = 0
    if found:
        begin_block(into[0], into[3], stamp, channel + own, count, BLOCK_STATUS, NO_STATUS)


@njit
def decode_packets(
    datagrams: NDArray[np.uint8],
    lengths: Ints,
    stamps: Ints,
    first: int,
    last: int,
    whole: bool,
    torn: Ints,
    into: Into,
    channel: int,
    devices: Devices,
    counters: Ints,
) -> tuple[int, int]:
    """Take the packets of datagrams `first` to `last` (exclusive), or of a stream as one datagram.

    Parameters
    ----------
    datagrams : (N, L) uint8 array
    lengths : (N,) int64 array
    stamps : (N,) int64 array, ns
    whole : bool
        Whether each datagram is taken whole or not at all, and what is no whole packet in it is
        malformed. Otherwise a packet that is not whole, or has no room in the blocks, is left, and
        bytes are not counted.
    torn : (1,) int64 array
        1 while what is no packet goes on, which is counted once.
    into : arrays
        Of `Blocks`.
    channel : int
    devices : arrays
        Row of each device's state, or -1 (65536,); the states (D, COLUMNS); their last numbers
        (D, WINDOW); 1 where a packet of counts left a status behind (C,).
    counters : (len(Count),) int64 array

    Returns
    -------
    left, at : int
        First datagram that was left because the blocks might not hold it, and bytes of the last one
        that are done with.
    """
    at = 0
    for i in range(first, last):
        octets, stop, at = datagrams[i], max(0, min(lengths[i], datagrams.shape[1])), 0
        if whole:
            if is_full(into, stop):
                return i, 0
            torn[0] = 0
            counters[OCTETS] += stop
        while at < stop:
            size = packet_size(octets, at, stop)
            if size > 0:
                if is_full(into, size):
                    break
                take_packet(octets, at, into, channel, stamps[i], devices, counters)
                torn[0] = 0
                at += size
            elif size == MORE and not whole:
                break
            else:
                counters[MALFORMED] += 1 - torn[0]
                torn[0] = 1
                at = next_magic(octets, at + 1, stop)
    return last, at


@inner
def is_full(into: Into, size: int) -> bool:
    """Whether the blocks of `size` bytes of packets might have no room.

    A packet of n bytes becomes less than 3 n bytes of blocks: at most 54 of headers and filling,
    where it has 26 itself, and twice its payload with an eighth for status.
    """
    return bool(8 * (len(into[0]) - into[3][0]) < 3 * size)
