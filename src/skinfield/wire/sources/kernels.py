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


SPAN = 1 << 56  # ns, 2.3 years: what is divided by the least speed fits into 64 bits


@njit
def survey(tape: Words, places: Ints) -> tuple[int, int]:
    """Drop from a recording what is no block of counts or status, and find those.

    A step ends where the channel with which it began comes once more.

    Parameters
    ----------
    tape : (W,) int64 array
        The recording; written: the blocks, one behind the other.
    places : (W / 2 + 1, 2) int64 array
        Written for each of them: first word in `tape`, and step; behind the last: words of all.

    Returns
    -------
    whole, blocks : int
        Words of the recording up to its last whole block, fewer than there are if something there
        is no block, or more than `SPAN` off the first one's stamp; and blocks in `tape`.
    """
    at, to, rows, step, began, since = 0, 0, 0, 0, -1, 0
    start = tape[0] if len(tape) else 0
    while at + HEADER_WORDS <= len(tape):
        stamp, head = tape[at], tape[at + 1]
        first, count, kind = head & 0xFFFFFFFF, (head >> 32) & 0xFFFF, (head >> 48) & 0xFF
        size = HEADER_WORDS + payload_words(kind, count)
        if size < HEADER_WORDS or at + size > len(tape):
            break
        if stamp < 0 or start < 0 or abs(stamp - start) > SPAN:
            break
        if kind <= STATUS:
            if kind < STATUS and first == began and stamp != since:
                step, began = step + 1, -1
            if began < 0:
                began, since = first, stamp
            places[rows, 0], places[rows, 1] = to, step
            rows += 1
            for i in range(size):
                tape[to + i] = tape[at + i]
            to += size
        at += size
    places[rows, 0] = to
    return at, rows
