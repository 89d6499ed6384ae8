"""CySkin's packets, compiled: checksums, runs of sensors, copies, decoding."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Ints
from skinfield.signal.block import Octets, Words
from skinfield.signal.blocks_kernel import begin_block

SUM, UNCHECKED = 0, 2
HOW, WIDTH, BEGIN, FINAL, REFLECTED, HIGH_FIRST = 0, 1, 2, 3, 4, 5  # of `numbers`

Table = NDArray[np.int64]
SHORTS: Any = np.int64(2)  # as `Kind`; a plain number would be a type of its own to Numba
NO_STATUS: Any = np.int64(0)
READINGS = 1  # as `Count`

RECEIVED, LOST, MALFORMED, FOREIGN, DUPLICATED, OCTETS = 0, 2, 4, 5, 6, 10  # as `Count`
EXTENDED, REMOTE_OR_ERROR = 0x80000000, 0x60000000
FIRST, MID, LAST, SINGLE = 1, 2, 4, 5  # as `Part`
SENSOR_DATA, FIRST_COMMAND = 0x43, 0x10
Messages = tuple[NDArray[np.uint32], Octets, Octets, Ints]  # ids, lengths, data, stamps
Into = tuple[Words, Octets, Words]  # words, octets, end of `Blocks`
Sensors = tuple[Ints, Ints, Ints]  # channels, begins, counts: see `decode_messages`
Check = tuple[Table, Table]  # numbers and table of a checksum
Packets = tuple[Octets, Ints, Ints]  # packets, used, previous: see `decode_messages`
ROOM = 280  # octets of a packet: 2 of head, 255 of data, 2 of checksum, and some too many
IDLE, SKIPPING = -1, -2  # instead of how many octets came


@njit
def summed(octets: Octets, start: int, stop: int, check: Check) -> int:
    """Checksum of `octets[start:stop]` as a number, in the order of its octets on the wire.

    Parameters
    ----------
    octets : (L,) uint8 array
    check : (6,) and (256,) int64 arrays
        Of `wire.Crc`.
    """
    numbers, table = check
    how, width, crc = numbers[HOW], numbers[WIDTH], numbers[BEGIN]
    if how == UNCHECKED:
        return 0
    if how == SUM:
        total = 0
        for i in range(start, stop):
            total += int(octets[i])
        return -total & 0xFF if numbers[FINAL] else total & 0xFF
    mask, left, right, top = (1 << (8 * width)) - 1, 8, 0, 8 * width - 8
    if numbers[REFLECTED]:
        left, right, top = 0, 8, 0
    for i in range(start, stop):
        octet = int(octets[i])
        crc = (((crc << left) >> right) & mask) ^ table[((crc >> top) ^ octet) & 0xFF]
    crc ^= numbers[FINAL]
    if width == 2 and numbers[HIGH_FIRST]:
        crc = ((crc & 0xFF) << 8) | (crc >> 8)
    return int(crc)


@inner
def is_summed(octets: Octets, start: int, stop: int, check: Check) -> bool:
    """Whether the checksum behind `octets[start:stop]` is right."""
    crc = summed(octets, start, stop, check)
    right = True
    for i in range(check[0][WIDTH]):
        right = right and octets[stop + i] == (crc >> (8 * i)) & 0xFF
    return bool(right or check[0][HOW] == UNCHECKED)


@njit
def put_pairs(
    into: Into,
    stamp_ns: int,
    channel: int,
    channels: Ints,
    start: int,
    stop: int,
    octets: Octets,
    at: int,
    big_endian: bool,
    counters: Ints,
) -> None:
    """Append responses of two octets each, from `octets[at]` on; there is room.

    Parameters
    ----------
    into : arrays
        Of `Blocks`.
    channel : int
        Of the port's first sensor.
    channels : (S,) int64 array
        Of all sensors of a board, in the order of sending.
    start, stop : int
        Which sensors the responses are of.
    """
    words, payloads, end = into
    high, low = (0, 1) if big_endian else (1, 0)
    while start < stop:
        after = start + 1
        while after < stop and channels[after] == channels[after - 1] + 1:
            after += 1
        count = after - start
        to = begin_block(words, end, stamp_ns, channel + channels[start], count, SHORTS, NO_STATUS)
        for i in range(count):
            payloads[to + 2 * i] = octets[at + 2 * i + low]
            payloads[to + 2 * i + 1] = octets[at + 2 * i + high]
        counters[READINGS] += 1
        at += 2 * count
        start = after


@inner
def is_copy(
    packet: Octets, so_far: int, previous: int, part: int, data: Octets, message: int, length: int
) -> bool:
    """Whether a first or last message is the one before it, once more."""
    if part == FIRST and so_far == length:
        at = 0
    elif part == LAST and so_far == IDLE and previous > 8 and length == ((previous - 1) & 7) + 1:
        at = previous - length
    else:
        return False
    same = True
    for k in range(length):
        same = same and packet[at + k] == data[message, k]
    return same


@inner
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


@njit
def decode_messages(
    messages: Messages,
    first: int,
    count: int,
    numbers: Ints,
    extended: bool,
    big_endian: bool,
    check: Check,
    sensors: Sensors,
    packets: Packets,
    into: Into,
    channel: int,
    counters: Ints,
) -> int:
    """Append the blocks of messages `first` to `count`; the first that does not fit, or `count`.

    Parameters
    ----------
    messages : arrays
        Identifiers, lengths, data, stamps of `CanMessages`.
    numbers : (B,) int64 array
        Of the boards.
    check : arrays
        Of the checksum.
    sensors : arrays
        Channels of all sensors in the order of sending, board after board (S,); index into these of
        each module's first sensor, and one behind the last module's, -1 of modules that are not
        there (B, 250); modules of each board (B,).
    packets : arrays
        The packet of each board (B, ROOM); octets of it that came in, or IDLE, or SKIPPING (B,);
        octets of the packet before, which still stands there, 0 of none (B,).
    into : arrays
        Of `Blocks`.
    channel : int
    counters : (len(Count),) int64 array
    """
    (ids, lengths, data, stamps), (octets, used, previous) = messages, packets
    for i in range(first, count):
        row, part = board_of(int(ids[i]), extended, numbers)
        length = min(int(lengths[i]), 8)
        if row >= 0 and part in (LAST, SINGLE):  # blocks must fit before anything is counted
            rest = 0 if part == SINGLE else max(used[row], 0)
            if into[2][0] + 3 * (rest + length) > len(into[0]):
                return i
        counters[OCTETS] += length
        if row < 0:
            counters[FOREIGN] += 1
        elif part not in (FIRST, MID, LAST, SINGLE):
            counters[MALFORMED] += 1
        else:
            counters[RECEIVED] += 1
            if assemble(packets, row, part, data, i, length, counters):
                packet = octets[row]
                whole = is_good(packet, used[row], check, counters)
                if whole and packet[0] == SENSOR_DATA:
                    take_responses(
                        packet, row, stamps[i], big_endian, sensors, into, channel, counters
                    )
                used[row], previous[row] = IDLE, used[row]
    return count


@inner
def assemble(
    packets: Packets, row: int, part: int, data: Octets, message: int, length: int, counters: Ints
) -> bool:
    """Add a message to its board's packet; whether that is complete."""
    octets, used, previous = packets
    packet, so_far = octets[row], used[row]
    if is_copy(packet, so_far, previous[row], part, data, message, length):
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
    previous[row] = 0
    if so_far + length > ROOM:
        counters[MALFORMED] += 1
        used[row] = IDLE if part == LAST else SKIPPING
        return False
    for k in range(length):
        packet[so_far + k] = data[message, k]
    used[row] = so_far + length
    return part in (LAST, SINGLE)


@inner
def missing(packet: Octets, so_far: int) -> int:
    """Messages that a packet still lacks, by the size that it states; at least 1."""
    if so_far < 2:
        return 1
    return int(max(1, (3 + int(packet[1]) - so_far + 7) >> 3))


@inner
def is_good(packet: Octets, length: int, check: Check, counters: Ints) -> bool:
    """Whether a packet is whole, its checksum right, and its command one that is known."""
    tail = check[0][WIDTH]
    if length >= 1 and packet[0] < FIRST_COMMAND:
        counters[FOREIGN] += 1
        return False
    if length < 2 + tail:
        counters[MALFORMED] += 1
        return False
    extra = length - (2 + int(packet[1]) + tail)
    if extra < 0:
        counters[LOST] += (7 - extra) >> 3
        return False
    if extra > 0 or not is_summed(packet, 0, length - tail, check):
        counters[MALFORMED] += 1
        return False
    return True


@inner
def take_responses(
    packet: Octets,
    row: int,
    stamp_ns: int,
    big_endian: bool,
    sensors: Sensors,
    into: Into,
    channel: int,
    counters: Ints,
) -> None:
    """Append what sensor data brings: module, first sensor, responses.

    Data of a module or sensor that the board has not is foreign: nothing of it is taken, as it
    would land on other taxels.
    """
    channels, begins, counts = sensors
    size = int(packet[1])
    if size < 2 or size & 1:
        counters[MALFORMED] += 1
        return
    module, sensor, responses = int(packet[2]), int(packet[3]), (size - 2) >> 1
    if module >= counts[row]:
        counters[FOREIGN] += 1
        return
    start = begins[row, module] + sensor
    if start >= begins[row, module + 1] or start + responses > begins[row, counts[row]]:
        counters[FOREIGN] += 1
        return
    stop = start + responses
    put_pairs(into, stamp_ns, channel, channels, start, stop, packet, 4, big_endian, counters)
