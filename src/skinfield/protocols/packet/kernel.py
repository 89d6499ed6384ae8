"""Packets to blocks, compiled. Bounds are checked before anything is read or written."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets, Words
from skinfield.acquisition.kernel import begin_block
from skinfield.errors import Ints
from skinfield.protocols.packet.scan import (
    BLOCK_FLOATS,
    BLOCK_STATUS,
    HEADER_BYTES,
    MORE,
    SIGNED,
    STATUS,
    next_magic,
    packet_size,
    stated_payload,
    u16,
    u32,
    words_needed,
)
from skinfield.protocols.packet.tracking import (
    CHANNELS,
    HELLO_LENGTH,
    HELLOS,
    LATE,
    MARKED,
    OFFSET,
    PACKETS,
    READING,
    TIME,
    TWICE,
    Row,
    track,
)

HELLO, COMMANDS = 16, 32  # as `PacketKind`
RECEIVED, READINGS, MALFORMED, FOREIGN, OCTETS = 0, 1, 4, 5, 10  # as `Count`
STATUS_BITS = 0x0F  # that `Status` knows
LAST_FLAG = 1  # as `PacketFlag`
LATEST_NS = 1_000_000_000  # how far back a late packet's stamp is put at most

Table = NDArray[np.int64]


@njit(cache=True, nogil=True)
def decode_run(
    octets: Octets,
    start: int,
    stop: int,
    final: bool,
    torn: Ints,
    words: Words,
    payloads: Octets,
    singles: NDArray[np.float32],
    end: Words,
    channel: int,
    now_ns: int,
    slots: NDArray[np.int32],
    state: Table,
    seen: Table,
    marks: Octets,
    hellos: Octets,
    counters: Ints,
) -> tuple[int, int]:
    """Take the packets in `octets[start:stop]`.

    Parameters
    ----------
    octets : (L,) uint8 array
    final : bool
        Whether nothing follows: what is not whole then is malformed. Otherwise it is left.
    torn : (1,) int64 array
        1 while what is no packet goes on, which is counted once.
    words, payloads, singles, end : arrays
        Of `Blocks`.
    channel : int
    now_ns : int, ns
    slots : (65536,) int32 array
        Row of `state` for each device, or -1.
    state : (D, COLUMNS) int64 array
    seen : (D, WINDOW) int64 array
    marks : (C,) uint8 array
        1 where a packet of counts left a status behind.
    hellos : (D, H) uint8 array
    counters : (len(Count),) int64 array

    Returns
    -------
    at, packets : int
        Behind the last byte that is done with, and packets. Where `words` has no more room, all
        from `at` on is as if it had not come yet.
    """
    at, packets = start, 0
    while at < stop:
        size = packet_size(octets, at, stop)
        if size > 0:
            if end[0] + words_needed(octets, at) > len(words):
                break
            take_packet(
                octets, at, words, payloads, singles, end, channel, now_ns, slots, state, seen,
                marks, hellos, counters,
            )  # fmt: skip
            torn[0] = 0
            at += size
            packets += 1
        elif size == MORE and not final:
            break
        else:
            counters[MALFORMED] += 1 - torn[0]
            torn[0] = 1
            at = next_magic(octets, at + 1, stop)
    return at, packets


@njit(cache=True, nogil=True)
def take_packet(
    octets: Octets,
    at: int,
    words: Words,
    payloads: Octets,
    singles: NDArray[np.float32],
    end: Words,
    channel: int,
    now_ns: int,
    slots: NDArray[np.int32],
    state: Table,
    seen: Table,
    marks: Octets,
    hellos: Octets,
    counters: Ints,
) -> None:
    """Take one whole packet, for whose blocks there is room."""
    kind, slot = int(octets[at + 3]), slots[u16(octets, at + 4)]
    if slot < 0 or kind >= COMMANDS:
        counters[FOREIGN] += 1
        return
    counters[RECEIVED] += 1
    row, time = state[slot], u32(octets, at + 12)
    order = track(row, seen[slot], u32(octets, at + 8), time, kind == HELLO, counters)
    if order == TWICE:
        return
    row[PACKETS] += 1
    stamp = now_ns
    if order == LATE:
        stamp -= min(1000 * ((row[TIME] - time) & 0xFFFFFFFF), LATEST_NS)
    else:
        row[TIME] = time
        if octets[at + 22] & LAST_FLAG:
            row[READING] = u16(octets, at + 20)
    if kind == HELLO:
        take_hello(octets, at, row, hellos[slot])
    first, count = u16(octets, at + 16), u16(octets, at + 18)
    if stated_payload(kind, count) < 0:
        return
    if first + count > row[CHANNELS]:
        counters[FOREIGN] += 1
        counters[RECEIVED] -= 1
        return
    take_counts(octets, at, words, payloads, singles, end, stamp, channel, row, marks, counters)


@njit(cache=True, nogil=True)
def take_counts(
    octets: Octets,
    at: int,
    words: Words,
    payloads: Octets,
    singles: NDArray[np.float32],
    end: Words,
    stamp: int,
    channel: int,
    row: Row,
    marks: Octets,
    counters: Ints,
) -> None:
    """Append the blocks of a packet of counts or of status, whose bounds were checked."""
    kind, first, count = int(octets[at + 3]), u16(octets, at + 16), u16(octets, at + 18)
    status, own, payload = octets[at + 23] & STATUS_BITS, row[OFFSET] + first, at + HEADER_BYTES
    if kind == STATUS:
        to = begin_block(words, end, stamp, channel + own, count, BLOCK_STATUS, status)
        for i in range((count + 7) >> 3):
            payloads[to + i] = octets[payload + i]
        for i in range(count):
            marks[own + i] = 0
        return
    if status or row[MARKED]:
        note_status(words, end, stamp, channel, own, count, status, row, marks)
    counters[READINGS] += 1
    to = begin_block(
        words, end, stamp, channel + own, count, BLOCK_FLOATS if kind == SIGNED else kind, status
    )
    if kind == SIGNED:
        for i in range(count):
            singles[(to >> 2) + i] = np.float32(np.int16(np.uint16(u16(octets, payload + 2 * i))))
        return
    for i in range(stated_payload(kind, count)):
        payloads[to + i] = octets[payload + i]


@njit(cache=True, nogil=True)
def note_status(
    words: Words,
    end: Words,
    stamp: int,
    channel: int,
    own: int,
    count: int,
    status: int,
    row: Row,
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
        begin_block(words, end, stamp, channel + own, count, BLOCK_STATUS, 0)


@njit(cache=True, nogil=True)
def take_hello(octets: Octets, at: int, row: Row, hello: Octets) -> None:
    """Keep the newest HELLO of a device."""
    length = min(u16(octets, at + 6), len(hello))
    for i in range(length):
        hello[i] = octets[at + HEADER_BYTES + i]
    row[HELLOS] += 1
    row[HELLO_LENGTH] = length


@njit(cache=True, nogil=True)
def decode_datagrams(
    datagrams: NDArray[np.uint8],
    lengths: NDArray[np.int64],
    stamps: Ints,
    first: int,
    last: int,
    words: Words,
    payloads: Octets,
    singles: NDArray[np.float32],
    end: Words,
    channel: int,
    slots: NDArray[np.int32],
    state: Table,
    seen: Table,
    marks: Octets,
    hellos: Octets,
    counters: Ints,
    torn: Ints,
) -> int:
    """Take datagrams `first` to `last`, each whole or not at all; the first that was left."""
    room = datagrams.shape[1]
    for i in range(first, last):
        length = max(0, min(int(lengths[i]), room))
        # A packet of n bytes becomes less than 3 n bytes of blocks: at most 54 of headers and
        # filling, where it has 26 itself, and twice its payload with an eighth for status.
        if 8 * (len(words) - end[0]) < 3 * length:
            return i
        torn[0] = 0
        counters[OCTETS] += length
        # A plain 0 and True are types of their own to Numba, which would compile all once more.
        start, final = int(np.int64(0)), length >= 0
        decode_run(
            datagrams[i], start, length, final, torn, words, payloads, singles, end, channel,
            stamps[i], slots, state, seen, marks, hellos, counters,
        )  # fmt: skip
    return last
