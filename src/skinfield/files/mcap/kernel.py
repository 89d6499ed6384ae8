"""Kernel from blocks to rows: one per scan of a patch, compiled."""

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.errors import Floats, Ints
from skinfield.signal.block import UNUSABLE, Octets, Words
from skinfield.signal.blocks_kernel import (
    BYTES,
    FLOATS,
    HEADER_WORDS,
    SHORTS,
    STATUS,
    count_at,
    payload_words,
)


@njit
def put_row(row: Floats, fresh: Octets, status: Octets, out: Floats) -> None:
    """Copy a row, and begin a new one."""
    for k in range(len(row)):
        out[k] = row[k] if fresh[k] and not status[k] & UNUSABLE else np.nan
        fresh[k] = 0


@njit
def is_in_row(column: Ints, first: int, count: int, fresh: Octets) -> bool:
    """Whether the row has one of these channels already."""
    found = False
    for i in range(first, first + count):
        found = found or (column[i] >= 0 and fresh[column[i]] > 0)
    return found


@njit
def scan(
    words: Words,
    octets: Octets,
    shorts: NDArray[np.uint16],
    singles: NDArray[np.float32],
    at: int,
    column: Ints,
    row: Floats,
    fresh: Octets,
    status: Octets,
    newest: Ints,
    out: Floats,
    stamps: Ints,
) -> tuple[int, int]:
    """Fill rows; a row ends where a channel comes that is in it already.

    Parameters
    ----------
    words, octets, shorts, singles : arrays
        The same memory, of blocks.
    at : int
        Word to begin with.
    column : (C,) int64 array
        Of each channel; -1 where it is not wanted.
    row, fresh, status : (K,) arrays
        The row that is being filled, and bits of `Status`; kept from call to call.
    newest : (1,) int64 array, ns
        Stamp of the row, likewise.
    out : (R, K) array
        Rows; NaN where nothing came, or what came must not be used.
    stamps : (R,) int64 array, ns

    Returns
    -------
    int
        Word to go on with: the end, or that of a block for whose row there is no room. Negative
        -w - 1 where word w begins no block.
    int
        Rows that were filled.
    """
    rows = 0
    while at < len(words):
        if at + HEADER_WORDS > len(words):
            return -at - 1, rows
        second = words[at + 1]
        first = second & 0xFFFFFFFF
        count, kind, bits = (second >> 32) & 0xFFFF, (second >> 48) & 0xFF, (second >> 56) & 0xFF
        size = payload_words(kind, count)
        if size < 0 or at + HEADER_WORDS + size > len(words):
            return -at - 1, rows
        count = max(min(count, len(column) - first), 0)
        if kind in (BYTES, SHORTS, FLOATS):
            if is_in_row(column, first, count, fresh):
                if rows == len(out):
                    return at, rows
                put_row(row, fresh, status, out[rows])
                stamps[rows] = newest[0]
                rows += 1
            payload = at + HEADER_WORDS
            for i in range(count):
                k = column[first + i]
                if k < 0:
                    continue
                row[k] = count_at(octets, shorts, singles, kind, payload, i)
                fresh[k] = 1
                newest[0] = words[at]
                if bits:
                    status[k] = bits
        elif kind == STATUS:
            for i in range(count):
                if column[first + i] >= 0:
                    status[column[first + i]] = bits
        at += HEADER_WORDS + size
    return at, rows
