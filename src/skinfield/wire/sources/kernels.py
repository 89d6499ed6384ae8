"""Kernels of live sources, compiled: senders of CAN messages, replay of blocks."""

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.errors import Ints
from skinfield.signal.block import Words
from skinfield.signal.blocks_kernel import HEADER_WORDS, STATUS, payload_words


@njit
def note_senders(
    ids: NDArray[np.uint32], stamp_ns: Ints, count: int, mask: int, numbers: Ints, heard_ns: Ints
) -> None:
    """Note the newest stamp of each sender: `numbers` (B,) are what the identifiers' `mask` holds.

    Parameters
    ----------
    ids, stamp_ns : (N,) arrays
        Of `CanMessages`.
    heard_ns : (B,) int64 array
        Written.
    """
    for i in range(count):
        for k in range(len(numbers)):
            if ids[i] & mask == numbers[k]:
                heard_ns[k] = stamp_ns[i]
                break


SPAN = 1 << 56  # ns, 2.3 years: what is divided by the least speed fits into 64 bits


@njit
def survey(words: Words, tape: Words, table: Ints, bounds: Ints) -> int:
    """Take out of a recording the blocks of counts and status; words up to the last whole block.

    A step ends where the channel with which it began comes once more.

    Parameters
    ----------
    words : (W,) int64 array
        The recording.
    tape : (W,) int64 array
        Written: the blocks, one behind the other.
    table : (W / 3, 4) int64 array
        Written for each of them: first word in `tape`, stamp in ns, step, and how many of counts
        there are with it.
    bounds : (3,) int64 array
        Written: channels, the highest one's number and 1; blocks; words of the tape.

    Returns
    -------
    int
        Less than there are words, if something there is no block, or more than `SPAN` off the
        first one's stamp.
    """
    at, to, rows, step, counts, began, since = 0, 0, 0, 0, 0, -1, 0
    while at + HEADER_WORDS <= len(words):
        stamp, head = words[at], words[at + 1]
        first, count, kind = head & 0xFFFFFFFF, (head >> 32) & 0xFFFF, (head >> 48) & 0xFF
        size = HEADER_WORDS + payload_words(kind, count)
        if size < HEADER_WORDS or at + size > len(words):
            break
        if stamp < 0 or words[0] < 0 or abs(stamp - words[0]) > SPAN:
            break
        if kind <= STATUS:
            if kind < STATUS and first == began and stamp != since:
                step, began = step + 1, -1
            if began < 0:
                began, since = first, stamp
            bounds[0] = max(bounds[0], first + count)
            counts += kind < STATUS
            table[rows, 0], table[rows, 1], table[rows, 2], table[rows, 3] = to, stamp, step, counts
            rows += 1
            for i in range(size):
                tape[to + i] = words[at + i]
            to += size
        at += size
    bounds[1], bounds[2] = rows, to
    return int(at)
