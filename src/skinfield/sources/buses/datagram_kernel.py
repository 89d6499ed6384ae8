"""Headers of many datagrams, compiled: lengths, stamps and drops out of struct mmsghdr.

On 64-bit little-endian Linux struct mmsghdr is 8 words: address, its length, iovec, its count,
control, its length, flags, length of the datagram.
"""

from typing import Any

import numpy as np
from numba import njit

from skinfield.acquisition.block import Octets
from skinfield.errors import Ints

NAME_LENGTH, CONTROL_LENGTH, FLAGS, LENGTH = 1, 5, 6, 7  # words of a header
TRUNCATED = 0x20  # MSG_TRUNC
SOCKET_LEVEL, STAMP, DROPPED = 1, 35, 40  # SOL_SOCKET, SCM_TIMESTAMPNS, SO_RXQ_OVFL
CONTROL_HEADER = 16  # bytes of struct cmsghdr
TOO_LONG = -1  # as the length of a datagram that was cut
DROPS_SEEN, DROPS = 0, 1  # of `drops`: the socket's own 32-bit count, ours


@njit(cache=True, nogil=True, inline="always")
def number32(octets: Octets, at: int) -> int:
    """Little-endian, unsigned."""
    number: Any = np.int64(octets[at])
    for i in range(1, 4):
        number |= np.int64(octets[at + i]) << (8 * i)
    return int(number)


@njit(cache=True, nogil=True)
def take_headers(
    headers: Ints,
    control: Octets,
    count: int,
    now_ns: int,
    lengths: Ints,
    stamp_ns: Ints,
    drops: Ints,
    name_room: int,
    control_room: int,
) -> int:
    """Read what came with `count` datagrams and make their headers ready for the next call.

    Parameters
    ----------
    headers : (N, 8) int64 array
    control : (N * control_room,) uint8 array
    now_ns : int, ns
        Stamp of datagrams without one.
    lengths, stamp_ns : (N,) int64 arrays
        Written; a datagram that was cut has length `TOO_LONG`.
    drops : (2,) int64 array
        Written: see `DROPS`.

    Returns
    -------
    int, bytes
        Of all datagrams.
    """
    octets = 0
    for i in range(count):
        length = headers[i, LENGTH] & 0xFFFFFFFF
        octets += length
        cut = headers[i, FLAGS] & TRUNCATED
        lengths[i] = TOO_LONG if cut else length
        start = i * control_room
        room = min(max(headers[i, CONTROL_LENGTH], 0), control_room)
        stamp_ns[i] = take_control(control, start, start + room, now_ns, drops)
        headers[i, NAME_LENGTH], headers[i, CONTROL_LENGTH] = name_room, control_room
        headers[i, FLAGS] = 0
    return octets


@njit(cache=True, nogil=True)
def take_control(control: Octets, at: int, end: int, now_ns: int, drops: Ints) -> int:
    """Stamp among the control messages in `control[at:end]`; notes the drops that they tell."""
    stamp = now_ns
    while at + CONTROL_HEADER <= end:
        size = number32(control, at)
        level, kind = number32(control, at + 8), number32(control, at + 12)
        data = at + CONTROL_HEADER
        if size < CONTROL_HEADER or at + size > end:
            break
        if level == SOCKET_LEVEL and kind == STAMP and size >= CONTROL_HEADER + 16:
            seconds = number32(control, data) | (number32(control, data + 4) << 32)
            stamp = seconds * 1_000_000_000 + number32(control, data + 8)
        elif level == SOCKET_LEVEL and kind == DROPPED and size >= CONTROL_HEADER + 4:
            seen = number32(control, data)
            drops[DROPS] += (seen - drops[DROPS_SEEN]) & 0xFFFFFFFF
            drops[DROPS_SEEN] = seen
        at += (size + 7) & ~7
    return stamp
