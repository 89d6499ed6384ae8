"""Datagrams of a CAN bus, compiled: headers, the struct can_frame in them, and who sent them.

On 64-bit little-endian Linux struct mmsghdr is 8 words: address, its length, iovec, its count,
control, its length, flags, length of the datagram. struct can_frame is 16 bytes: 4 of identifier
with flags, length, 3 of padding, 8 of data.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.errors import Ints
from skinfield.signal.block import Octets

Words32 = NDArray[np.uint32]
NAME_LENGTH, CONTROL_LENGTH, FLAGS, LENGTH = 1, 5, 6, 7  # words of a header
TRUNCATED = 0x20  # MSG_TRUNC
SOCKET_LEVEL, STAMP, DROPPED = 1, 35, 40  # SOL_SOCKET, SCM_TIMESTAMPNS, SO_RXQ_OVFL
NAME = 32  # bytes for any address of IPv4 and IPv6
CONTROL = 64  # bytes for the control messages of a datagram: a stamp takes 32, drops 24
CONTROL_HEADER = 16  # bytes of struct cmsghdr
TOO_LONG = -1  # as the length of a datagram that was cut
DROPS_COUNTED, DROPS = 0, 1  # of `drops`: the socket's own 32-bit count, ours
STRUCT = 16  # bytes of struct can_frame; CAN FD's is longer, and not asked for
EXTENDED, ERROR = 0x80000000, 0x20000000
NOT_STANDARD = 0x1FFFF800  # bits of an identifier that one of 11 bits lacks
MALFORMED, ERRORS = 0, 1  # of `counts`


@njit
def take_headers(
    headers: Ints,
    control: Words32,
    count: int,
    now_ns: int,
    lengths: Ints,
    stamp_ns: Ints,
    drops: Ints,
) -> None:
    """Read what came with `count` datagrams and make their headers ready for the next call.

    Parameters
    ----------
    headers : (N, 8) int64 array
    control : (N * CONTROL / 4,) uint32 array
    now_ns : int, ns
        Stamp of datagrams without one.
    lengths, stamp_ns : (N,) int64 arrays
        Written; a datagram that was cut has length `TOO_LONG`.
    drops : (2,) int64 array
        Written: see `DROPS`.
    """
    for i in range(count):
        length = headers[i, LENGTH] & 0xFFFFFFFF
        lengths[i] = TOO_LONG if headers[i, FLAGS] & TRUNCATED else length
        stamp_ns[i] = now_ns
        at = i * CONTROL
        end = at + min(max(headers[i, CONTROL_LENGTH], 0), CONTROL)
        while at + CONTROL_HEADER <= end:
            word = at >> 2
            size: Any = np.int64(control[word])
            level, kind, data = control[word + 2], control[word + 3], word + CONTROL_HEADER // 4
            if size < CONTROL_HEADER or at + size > end:
                break
            if level == SOCKET_LEVEL and kind == STAMP and size >= CONTROL_HEADER + 16:
                seconds = np.int64(control[data]) | (np.int64(control[data + 1]) << 32)
                stamp_ns[i] = seconds * 1_000_000_000 + np.int64(control[data + 2])
            elif level == SOCKET_LEVEL and kind == DROPPED and size >= CONTROL_HEADER + 4:
                counted = np.int64(control[data])
                drops[DROPS] += (counted - drops[DROPS_COUNTED]) & 0xFFFFFFFF
                drops[DROPS_COUNTED] = counted
            at += (size + 7) & ~7
        headers[i, NAME_LENGTH], headers[i, CONTROL_LENGTH] = NAME, CONTROL
        headers[i, FLAGS] = 0


@njit
def messages_of_structs(
    octets: Octets,
    words: Words32,
    stride: int,
    lengths: Ints,
    stamps: Ints,
    count: int,
    cursor: Ints,
    first: int,
    ids: Words32,
    sizes: Octets,
    data: Octets,
    stamp_ns: Ints,
    counts: Ints,
) -> int:
    """Read structs of `count` datagrams into the arrays of `CanMessages` from row `first` on.

    Parameters
    ----------
    octets, words : arrays
        The datagrams, `stride` bytes apart, as uint8 and as uint32: the same memory.
    lengths, stamps : (N,) int64 arrays
        Bytes and stamp of each datagram.
    cursor : (2,) int64 array
        Datagram and byte in it that are read next; written.
    counts : (2,) int64 array
        Written: see `MALFORMED` and `ERRORS`. A datagram of no whole number of structs is
        malformed as a whole; an empty one only announces its sender.

    Returns
    -------
    int
        First row that is free now.
    """
    while cursor[0] < count and first < len(ids):
        datagram = cursor[0]
        if lengths[datagram] % STRUCT:
            counts[MALFORMED] += 1
            cursor[0], cursor[1] = datagram + 1, 0
            continue
        if cursor[1] >= lengths[datagram]:
            cursor[0], cursor[1] = datagram + 1, 0
            continue
        at = datagram * stride + cursor[1]
        cursor[1] += STRUCT
        identifier, size = words[at >> 2], octets[at + 4]
        if size <= 8 and identifier & ERROR:  # its identifier has bits of its own
            counts[ERRORS] += 1
        elif size > 8 or (identifier & EXTENDED == 0 and identifier & NOT_STANDARD != 0):
            counts[MALFORMED] += 1
        else:
            ids[first], sizes[first], stamp_ns[first] = identifier, size, stamps[datagram]
            for j in range(8):
                data[first, j] = octets[at + 8 + j] if j < size else 0
            first += 1
    return first


@njit
def note_senders(
    ids: NDArray[np.uint32], stamp_ns: Ints, count: int, mask: int, numbers: Ints, heard_ns: Ints
) -> None:
    """Note the newest stamp of each sender.

    Parameters
    ----------
    ids, stamp_ns : (N,) arrays
        Of `CanMessages`.
    numbers : (K, B) int64 array
        What the `mask` of a sender's identifiers holds.
    heard_ns : (K, B) int64 array
        Written.
    """
    for i in range(count):
        for k in range(numbers.shape[0]):
            for j in range(numbers.shape[1]):
                if ids[i] & mask == numbers[k, j]:
                    heard_ns[k, j] = stamp_ns[i]
