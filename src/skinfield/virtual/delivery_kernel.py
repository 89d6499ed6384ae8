"""What becomes of messages on their way, compiled."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from skinfield.acquisition.block import Octets
from skinfield.errors import Floats, Ints

LOST, DUPLICATED, SWAPPED = 0, 1, 2
KEPT = -1  # in an order: the message that was kept back before
State = NDArray[np.uint64]


@njit(cache=True, nogil=True)
def uniform(state: State) -> float:
    """Next number from 0 to 1 of SplitMix64 (Steele, Lea and Flood 2014)."""
    state[0] += np.uint64(0x9E3779B97F4A7C15)
    z = state[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return np.float64(z >> np.uint64(11)) * 1.1102230246251565e-16


@njit(cache=True, nogil=True)
def fates(count: int, chances: Floats, state: State, kept: Ints, order: Ints, counts: Ints) -> int:
    """In which order messages 0 to `count` - 1 go out; how many go.

    Parameters
    ----------
    chances : (3,) array
        Of being lost, doubled, and sent after the next one.
    state : (1,) uint64 array
    kept : (1,) int64 array
        The message that waits for the next one: its index, `KEPT` of the burst before, or -2.
    order : (2 count + 1,) int64 array
        Indices of messages; `KEPT` for the one of the burst before.
    counts : (3,) int64 array
        Lost, duplicated and swapped ones are added.
    """
    out = 0
    for message in range(count):
        if chances[0] > 0.0 and uniform(state) < chances[0]:
            counts[LOST] += 1
            continue
        if chances[2] > 0.0 and kept[0] == -2 and uniform(state) < chances[2]:
            kept[0] = message
            continue
        order[out] = message
        out += 1
        if chances[1] > 0.0 and uniform(state) < chances[1]:
            order[out] = message
            out += 1
            counts[DUPLICATED] += 1
        if kept[0] != -2:
            order[out] = kept[0]
            out += 1
            kept[0] = -2
            counts[SWAPPED] += 1
    return out


@njit(cache=True, nogil=True)
def gather(
    order: Ints,
    count: int,
    ids: NDArray[np.uint32],
    lengths: Octets,
    data: Octets,
    kept_ids: NDArray[np.uint32],
    kept_lengths: Octets,
    kept_data: Octets,
    out_ids: NDArray[np.uint32],
    out_lengths: Octets,
    out_data: Octets,
) -> None:
    """Copy CAN messages in their order; the arrays are those of `CanMessages`."""
    for row in range(count):
        at = order[row]
        if at == KEPT:
            out_ids[row], out_lengths[row] = kept_ids[0], kept_lengths[0]
            out_data[row] = kept_data[0]
        else:
            out_ids[row], out_lengths[row] = ids[at], lengths[at]
            out_data[row] = data[at]
