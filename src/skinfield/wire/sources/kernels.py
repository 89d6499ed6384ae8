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
def survey(words: Words, bounds: Ints) -> int:
    """Words up to the end of the last whole block.

    Parameters
    ----------
    words : (W,) int64 array
    bounds : (2,) int64 array
        Written: channels, the highest one's number and 1; newest stamp, ns.

    Returns
    -------
    int
        Less than there are words, if something there is no block, or more than `SPAN` off the
        first one's stamp.
    """
    at = 0
    while at + HEADER_WORDS <= len(words):
        head = words[at + 1]
        first, count, kind = head & 0xFFFFFFFF, (head >> 32) & 0xFFFF, (head >> 48) & 0xFF
        size = payload_words(kind, count)
        if size < 0 or at + HEADER_WORDS + size > len(words):
            break
        if words[at] < 0 or words[0] < 0 or abs(words[at] - words[0]) > SPAN:
            break
        if kind <= STATUS:
            bounds[0] = max(bounds[0], first + count)
        bounds[1] = max(bounds[1], words[at])
        at += HEADER_WORDS + size
    return int(at)


@njit
def play(
    tape: Words,
    at: int,
    until_ns: int,
    step_by_step: bool,
    begin_ns: int,
    start_ns: int,
    speed: float,
    channel: int,
    words: Words,
    end: Words,
    taken: Ints,
) -> int:
    """Copy blocks of counts and status from word `at` on whose time has come; the first one left.

    Parameters
    ----------
    tape : (W,) int64 array
        Whole blocks, the first of which is of `begin_ns` and played at `start_ns`.
    until_ns : int, ns
        Time of now.
    step_by_step : bool
        Copy until a channel would come twice, whatever the time; stamps are `until_ns`.
    channel : int
        Added to each.
    words, end : arrays
        Of `Blocks`.
    taken : (4,) int64 array
        Written: blocks; blocks of counts; first channel and stamp of a step's first block.
    """
    while at < len(tape):
        head, stamp = tape[at + 1], tape[at]
        first, count, kind = head & 0xFFFFFFFF, (head >> 32) & 0xFFFF, (head >> 48) & 0xFF
        size = HEADER_WORDS + payload_words(kind, count)
        if kind <= STATUS:
            if step_by_step:
                if repeats(kind, first, stamp, taken):
                    break
                stamp = until_ns
            else:
                stamp = start_ns + int((stamp - begin_ns) / speed)
            if stamp > until_ns or end[0] + size > len(words):
                break
            words[end[0]] = stamp
            words[end[0] + 1] = (head & ~0xFFFFFFFF) | ((first + channel) & 0xFFFFFFFF)
            for i in range(HEADER_WORDS, size):
                words[end[0] + i] = tape[at + i]
            end[0] += size
            taken[0] += 1
            taken[1] += kind < STATUS
        at += size
    return int(at)


@njit
def repeats(kind: int, first: int, stamp: int, taken: Ints) -> bool:
    """Whether the channel with which a step began comes once more; notes which that is."""
    if taken[1] == 0:
        taken[2], taken[3] = first, stamp
        return False
    return bool(kind < STATUS and first == taken[2] and stamp != taken[3])
