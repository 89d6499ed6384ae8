"""CySkin's CAN messages to blocks, compiled. Bounds are checked before anything is written."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets, Words
from skinfield.errors import Ints
from skinfield.protocols.cyskin.checksum_kernel import is_summed
from skinfield.protocols.cyskin.copies_kernel import drop_copies, is_copy
from skinfield.protocols.cyskin.runs_kernel import put_pairs, words_of_runs

RECEIVED, LOST, MALFORMED, FOREIGN, DUPLICATED, OCTETS = 0, 2, 4, 5, 6, 10  # as `Count`
EXTENDED, REMOTE_OR_ERROR = 0x80000000, 0x60000000
FIRST, MID, LAST, SINGLE = 1, 2, 4, 5  # as `Part`
SENSOR_DATA, FIRST_COMMAND = 0x43, 0x10
ROOM = 280  # octets of a packet: 1 of number, 2 of head, 255 of data, 2 of checksum, and copies
IDLE, SKIPPING = -1, -2  # instead of how many octets came
NONE, DONE, FULL = 0, 1, 2  # of a packet

Table = NDArray[np.int64]


@njit(cache=True, nogil=True)
def board_of(identifier: int, extended: bool, numbers: Ints) -> tuple[int, int]:
    """Row of the board that a message is of, or -1, and its part."""
    if (identifier & EXTENDED != 0) != extended or identifier & REMOTE_OR_ERROR:
        return -1, 0
    if extended:
        number, part = identifier & 0x03FFFFFF, (identifier >> 26) & 7
    else:
        number, part = identifier & 0xFF, (identifier >> 8) & 7
    for row in range(len(numbers)):
        if numbers[row] == number:
            return row, part
    return -1, 0


@njit(cache=True, nogil=True)
def decode_messages(
    ids: NDArray[np.uint32],
    lengths: Octets,
    data: Octets,
    stamps: Ints,
    first: int,
    count: int,
    numbers: Ints,
    extended: bool,
    big_endian: bool,
    numbered: bool,
    check: Table,
    table: Table,
    channels: Ints,
    begins: Ints,
    counts: Ints,
    packets: Octets,
    used: Ints,
    done: Ints,
    last_number: Ints,
    replies: Octets,
    reply_heads: Ints,
    words: Words,
    payloads: Octets,
    end: Words,
    channel: int,
    counters: Ints,
) -> int:
    """Append the blocks of messages `first` to `count`; the first that does not fit, or `count`.

    Parameters
    ----------
    ids, lengths, data, stamps : arrays
        Of `CanMessages`.
    numbers : (B,) int64 array
        Of the boards.
    check, table : arrays
        Of the checksum.
    channels : (S,) int64 array
        Of all sensors in the order of sending, board after board.
    begins : (B, 250) int64 array
        Index into `channels` of each module's first sensor, and one behind the last module's; -1
        of modules that are not there.
    counts : (B,) int64 array
        Modules of each board.
    packets : (B, ROOM) uint8 array
    used : (B,) int64 array
        Octets of the packet that is coming in, or IDLE, or SKIPPING.
    done : (B,) int64 array
        Octets of the packet that came before, which still stands in `packets`; 0 of none.
    last_number : (B,) int64 array
    replies : (R, ROOM) uint8 array
        Packets that are no sensor data, for whoever asked.
    reply_heads : (R + 1, 2) int64 array
        Board and octets of each; in the last row, first, how many.
    words, payloads, end : arrays
        Of `Blocks`.
    channel : int
    counters : (len(Count),) int64 array
    """
    for i in range(first, count):
        row, part = board_of(int(ids[i]), extended, numbers)
        length = min(int(lengths[i]), 8)
        if row >= 0 and part in (LAST, SINGLE):  # blocks must fit before anything is counted
            rest = 0 if part == SINGLE else max(used[row], 0)
            if end[0] + 3 * (rest + length) > len(words):
                return i
        counters[OCTETS] += length
        if row < 0:
            counters[FOREIGN] += 1
        elif part not in (FIRST, MID, LAST, SINGLE):
            counters[MALFORMED] += 1
        else:
            counters[RECEIVED] += 1
            if assemble(packets[row], used, done, row, part, data, i, length, counters):
                take_packet(
                    packets[row], used[row], row, stamps[i], big_endian, numbered, check, table,
                    channels, begins, counts, last_number, replies, reply_heads, words, payloads,
                    end, channel, counters,
                )  # fmt: skip
                used[row], done[row] = IDLE, used[row]
    return count


@njit(cache=True, nogil=True)
def assemble(
    packet: Octets,
    used: Ints,
    done: Ints,
    row: int,
    part: int,
    data: Octets,
    message: int,
    length: int,
    counters: Ints,
) -> bool:
    """Add a message to its board's packet; whether that is complete."""
    so_far = used[row]
    if is_copy(packet, so_far, done[row], part, data, message, length):
        counters[DUPLICATED] += 1
        return False
    if part in (FIRST, SINGLE):
        if so_far >= 0:
            counters[LOST] += missing(packet, so_far)
        so_far = 0
    elif so_far < 0:
        if so_far == IDLE:
            counters[LOST] += 1  # the message with which it began, at least
        used[row] = IDLE if part == LAST else SKIPPING
        return False
    done[row] = 0
    if so_far + length > ROOM:
        counters[MALFORMED] += 1
        used[row] = IDLE if part == LAST else SKIPPING
        return False
    for k in range(length):
        packet[so_far + k] = data[message, k]
    used[row] = so_far + length
    return part in (LAST, SINGLE)


@njit(cache=True, nogil=True)
def missing(packet: Octets, so_far: int) -> int:
    """Messages that a packet still lacks, by the size that it states; at least 1."""
    if so_far < 2:
        return 1
    return int(max(1, (3 + int(packet[1]) - so_far + 7) >> 3))


@njit(cache=True, nogil=True)
def take_packet(
    packet: Octets,
    length: int,
    row: int,
    stamp_ns: int,
    big_endian: bool,
    numbered: bool,
    check: Table,
    table: Table,
    channels: Ints,
    begins: Ints,
    counts: Ints,
    last_number: Ints,
    replies: Octets,
    reply_heads: Ints,
    words: Words,
    payloads: Octets,
    end: Words,
    channel: int,
    counters: Ints,
) -> None:
    """Take a whole packet, for whose blocks there is room."""
    head, tail = 0, check[1]
    if length >= 1 and packet[0] < FIRST_COMMAND:
        if not numbered:
            counters[FOREIGN] += 1
            return
        head = 1
    if length < head + 2 + tail:
        counters[MALFORMED] += 1
        return
    stated = head + 2 + int(packet[head + 1]) + tail
    if stated > length:
        counters[LOST] += (stated - length + 7) >> 3
        return
    extra = length - stated
    if extra > 0 and extra & 7 == 0 and drop_copies(packet, length, stated, tail, check, table):
        counters[DUPLICATED] += extra >> 3
        length = stated
    if stated < length or not is_summed(packet, 0, length - tail, check, table):
        counters[MALFORMED] += 1
        return
    if head:
        follow_number(row, int(packet[0]), last_number, counters)
    if packet[head] != SENSOR_DATA:
        keep_reply(packet, length, row, replies, reply_heads)
        return
    take_responses(
        packet, head + 2, int(packet[head + 1]), row, stamp_ns, big_endian, channels, begins,
        counts, words, payloads, end, channel, counters,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def follow_number(row: int, number: int, last_number: Ints, counters: Ints) -> None:
    """Count the packets that are missing between the last number and this."""
    if last_number[row] >= 0:
        counters[LOST] += (number - last_number[row] - 1) & 15
    last_number[row] = number


@njit(cache=True, nogil=True)
def keep_reply(packet: Octets, length: int, row: int, replies: Octets, reply_heads: Ints) -> None:
    """Keep an answer while there is room."""
    kept = reply_heads[len(replies), 0]
    if kept >= len(replies):
        return
    for k in range(length):
        replies[kept, k] = packet[k]
    reply_heads[kept, 0], reply_heads[kept, 1] = row, length
    reply_heads[len(replies), 0] = kept + 1


@njit(cache=True, nogil=True)
def take_responses(
    octets: Octets,
    at: int,
    size: int,
    row: int,
    stamp_ns: int,
    big_endian: bool,
    channels: Ints,
    begins: Ints,
    counts: Ints,
    words: Words,
    payloads: Octets,
    end: Words,
    channel: int,
    counters: Ints,
) -> bool:
    """Append what sensor data brings: module, first sensor, responses; False, and nothing, if full.

    Data of a module or sensor that the board has not is foreign: nothing of it is taken, as it
    would land on other taxels.
    """
    if size < 2 or size & 1:
        counters[MALFORMED] += 1
        return True
    module, sensor, responses = int(octets[at]), int(octets[at + 1]), (size - 2) >> 1
    if module >= counts[row]:
        counters[FOREIGN] += 1
        return True
    start = begins[row, module] + sensor
    if start >= begins[row, module + 1] or start + responses > begins[row, counts[row]]:
        counters[FOREIGN] += 1
        return True
    stop = start + responses
    if end[0] + words_of_runs(channels, start, stop) > len(words):
        return False
    return put_pairs(
        words, payloads, end, stamp_ns, channel, channels, start, stop, octets, at + 2, big_endian,
        counters,
    )  # fmt: skip
