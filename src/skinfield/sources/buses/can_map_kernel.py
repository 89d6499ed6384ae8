"""CAN messages as python-can's `udp_multicast` packs them, compiled: one msgpack map each.

`{timestamp, arbitration_id, is_extended_id, is_remote_frame, is_error_frame, channel, dlc, data,
is_fd, bitrate_switch, error_state_indicator}`, in this order when it is python-can that packs;
read in any order, with other keys beside them and numbers of any width.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets
from skinfield.errors import Ints
from skinfield.sources.buses.msgpack_kernel import (
    ARRAY,
    BAD,
    BINARY,
    BOOL,
    FLOAT,
    INT,
    MAP,
    NIL,
    TEXT,
    behind,
    item_at,
)

NAMES = (
    "timestamp",
    "arbitration_id",
    "is_extended_id",
    "is_remote_frame",
    "is_error_frame",
    "channel",
    "dlc",
    "data",
    "is_fd",
    "bitrate_switch",
    "error_state_indicator",
)
KEYS = np.zeros((len(NAMES), 24), np.uint8)  # of each name: its length, its letters
for _row, _name in zip(KEYS, NAMES, strict=True):
    _row[0], _row[1 : 1 + len(_name)] = len(_name), np.frombuffer(_name.encode(), np.uint8)
ID, EXTENDED_ID, REMOTE_FRAME, ERROR_FRAME, DLC, DATA, FD = 1, 2, 3, 4, 6, 7, 8
UNKNOWN = -1
NOTHING = (BAD, 0, 0, 0)
EXTENDED, REMOTE, ERROR = 0x80000000, 0x40000000, 0x20000000  # as in acquisition.can
LONGEST = 8  # octets of a classic message
MALFORMED, ERRORS = 0, 1  # of `counts`
IPV6 = 10  # AF_INET6 of Linux


@njit(cache=True, nogil=True, forceinline=True)
def key_at(octets: Octets, at: int, length: int, guess: int) -> int:
    """Which of `NAMES` the text is; `guess`, up to their count, is tried first."""
    for step in range(len(KEYS)):
        key = guess + step if guess + step < len(KEYS) else guess + step - len(KEYS)
        if KEYS[key, 0] != length:
            continue
        different = 0
        for i in range(length):  # without a way out: this becomes a few vector instructions
            different |= KEYS[key, 1 + i] ^ octets[at + i]
        if different == 0:
            return key
    return UNKNOWN


@njit(cache=True, nogil=True, forceinline=True)
def data_at(octets: Octets, kind: int, number: int, at: int, end: int, data: Octets) -> int:
    """Copy up to 8 octets of data: binary, text, none, or a list of numbers; how many, or -1."""
    if kind == NIL:
        return 0
    if number > LONGEST or kind not in (BINARY, TEXT, ARRAY):
        return -1
    for i in range(number):
        if kind == ARRAY:
            member, value, at, size = item_at(octets, at, end)
            if member != INT or value < 0 or value > 255:
                return -1
            at += size
            data[i] = value
        else:
            data[i] = octets[at + i]
    return int(number)


@njit(cache=True, nogil=True, forceinline=True)
def unpack_message(octets: Octets, at: int, end: int, data: Octets) -> tuple[bool, int, int]:
    """Read the map in `octets[at:end]`.

    Parameters
    ----------
    data : (8,) uint8 array
        Written, as far as there is data.

    Returns
    -------
    tuple
        Whether it is a message of classic CAN, its identifier with flags, octets of data.
    """
    kind, members, at, _ = item_at(octets, at, end)
    if kind != MAP:
        return False, 0, 0
    identifier, flags, length, dlc, key = -1, EXTENDED, 0, -1, UNKNOWN
    for _ in range(members):
        kind, number, start, size = item_at(octets, at, end)
        if kind == TEXT:
            key = key_at(octets, start, size, key + 1)
            at = start + size
        else:
            key, at = UNKNOWN, behind(octets, at, end)
        kind, number, start, size = item_at(octets, at, end) if at >= 0 else NOTHING
        if kind == BAD:
            return False, 0, 0
        if key == ID:
            identifier = number if kind == INT else -1
        elif key in (EXTENDED_ID, REMOTE_FRAME, ERROR_FRAME, FD):
            if kind not in (BOOL, INT, NIL, FLOAT):
                return False, 0, 0
            flags = (flags | flag_of(key)) if number else (flags & ~flag_of(key))
        elif key == DLC:
            dlc = -1 if kind == NIL else number if kind == INT else -2
        elif key == DATA:
            length = data_at(octets, kind, number, start, end, data)
        at = behind(octets, at, end) if kind in (ARRAY, MAP) else start + size
        if at < 0:
            return False, 0, 0
    return checked(identifier, flags, length, dlc, at == end)


@njit(cache=True, nogil=True, forceinline=True)
def flag_of(key: int) -> int:
    """Bit of a key's flag."""
    if key == EXTENDED_ID:
        return EXTENDED
    if key == REMOTE_FRAME:
        return REMOTE
    return ERROR if key == ERROR_FRAME else 1


@njit(cache=True, nogil=True, forceinline=True)
def checked(
    identifier: int, flags: int, length: int, dlc: int, complete: bool
) -> tuple[bool, int, int]:
    """A message's parts, if they fit each other; messages of CAN FD do not fit in."""
    longest = 0x1FFFFFFF if flags & EXTENDED else 0x7FF
    remote = flags & REMOTE != 0
    good = complete and 0 <= identifier <= longest and 0 <= length <= LONGEST and not flags & 1
    if remote:
        good = good and length == 0 and -1 <= dlc <= LONGEST
        length = max(dlc, 0)
    else:
        good = good and (dlc == -1 or dlc == length)
    return good, identifier | flags, length


@njit(cache=True, nogil=True)
def unpack_messages(
    octets: Octets,
    stride: int,
    lengths: Ints,
    stamps: Ints,
    names: Octets,
    own: Octets,
    count: int,
    first: int,
    ids: NDArray[np.uint32],
    sizes: Octets,
    data: Octets,
    stamp_ns: Ints,
    counts: Ints,
) -> int:
    """Read `count` datagrams into the arrays of `CanMessages` from `first` on; the next free row.

    Parameters
    ----------
    octets : (N * stride,) uint8 array
    lengths, stamps : (N,) int64 arrays
    names : (N, 32) uint8 array
        Senders.
    own : (32,) uint8 array
        Address whose datagrams are left out, being ours; its first octet 0: none.
    counts : (2,) int64 array
        Written: see `MALFORMED` and `ERRORS`. Empty datagrams only announce their sender.
    """
    for i in range(count):
        length = lengths[i]
        if length == 0 or is_own(names, i, own):
            continue
        if length < 0 or first >= len(ids):
            counts[MALFORMED] += 1
            continue
        for j in range(LONGEST):
            data[first, j] = 0
        good, identifier, size = unpack_message(
            octets, i * stride, i * stride + length, data[first]
        )
        if not good:
            counts[MALFORMED] += 1
        elif identifier & ERROR:
            counts[ERRORS] += 1
        else:
            ids[first], sizes[first], stamp_ns[first] = identifier, size, stamps[i]
            first += 1
    return first


@njit(cache=True, nogil=True, forceinline=True)
def is_own(names: Octets, row: int, own: Octets) -> bool:
    """Whether the row's address is `own`."""
    if own[0] == 0:
        return False
    # family and port, then the host: behind the flow in IPv6, whose sockaddr is the longer one
    first, last = (8, 24) if own[0] == IPV6 else (4, 8)
    different = 0
    for i in range(4):
        different += names[row, i] != own[i]
    for i in range(first, last):
        different += names[row, i] != own[i]
    return different == 0
