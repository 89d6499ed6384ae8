"""Responses of sensors to blocks, compiled: one block for each run of channels without a gap."""

from numba import njit

from skinfield.acquisition.block import Octets, Words
from skinfield.acquisition.kernel import begin_block
from skinfield.errors import Ints

SHORTS = 2  # as `Kind`
READINGS = 1  # as `Count`


@njit(cache=True, nogil=True)
def run_length(channels: Ints, start: int, stop: int) -> int:
    """Channels from `start` on that follow one another."""
    end = start + 1
    while end < stop and channels[end] == channels[end - 1] + 1:
        end += 1
    return int(end - start)


@njit(cache=True, nogil=True)
def words_of_runs(channels: Ints, start: int, stop: int) -> int:
    """Words of the blocks of `channels[start:stop]`."""
    at, words = start, 0
    while at < stop:
        count = run_length(channels, at, stop)
        words += 2 + ((count + 3) >> 2)
        at += count
    return words


@njit(cache=True, nogil=True)
def put_pairs(
    words: Words,
    payloads: Octets,
    end: Words,
    stamp_ns: int,
    channel: int,
    channels: Ints,
    start: int,
    stop: int,
    octets: Octets,
    at: int,
    big_endian: bool,
    counters: Ints,
) -> bool:
    """Append responses of two octets each, from `octets[at]` on; False, and nothing, if full.

    Parameters
    ----------
    words, payloads, end : arrays
        Of `Blocks`.
    channel : int
        Of the port's first sensor.
    channels : (S,) int64 array
        Of all sensors of a board, in the order of sending.
    start, stop : int
        Which sensors the responses are of.
    """
    if end[0] + words_of_runs(channels, start, stop) > len(words):
        return False
    high, low = (0, 1) if big_endian else (1, 0)
    while start < stop:
        count = run_length(channels, start, stop)
        to = begin_block(words, end, stamp_ns, channel + channels[start], count, SHORTS, 0)
        for i in range(count):
            payloads[to + 2 * i] = octets[at + 2 * i + low]
            payloads[to + 2 * i + 1] = octets[at + 2 * i + high]
        counters[READINGS] += 1
        at += 2 * count
        start += count
    return True
