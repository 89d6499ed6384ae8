"""Finding the few blocks that tell of sources among the many that hold counts, compiled."""

import numpy as np
from numba import njit

from skinfield.acquisition.block import Words
from skinfield.acquisition.kernel import HEADER_WORDS, LOST, SOURCE, payload_words


@njit(cache=True, nogil=True)
def find_told(words: Words, found: Words) -> int:
    """Places of blocks of SOURCE and LOST.

    Parameters
    ----------
    words : (W,) int64 array
        Blocks.
    found : (N,) int64 array
        Filled with the word at which each begins.

    Returns
    -------
    int
        How many, at most N.
    """
    at, count = 0, 0
    while at + HEADER_WORDS <= len(words) and count < len(found):
        second = words[at + 1]
        channels = (second >> 32) & 0xFFFF
        kind = (second >> 48) & 0xFF
        size = payload_words(kind, channels)
        if size < 0 or at + HEADER_WORDS + size > len(words):
            return count
        if kind in (SOURCE, LOST):
            found[count] = at
            count += 1
        at += HEADER_WORDS + size
    return count


def told_in(data: bytes) -> list[tuple[int, int, int, int]]:
    """Stamp, source, kind and number of each block of SOURCE and LOST."""
    words = np.frombuffer(data, "<i8", len(data) // 8)
    found = np.zeros(len(words) // (HEADER_WORDS + 1), np.int64)
    places = found[: find_told(words, found)]
    return [
        (int(words[at]), int(words[at + 1] & 0xFFFFFFFF), int(words[at + 1] >> 48 & 0xFF),
         int(words[at + 2]))
        for at in places
    ]  # fmt: skip
