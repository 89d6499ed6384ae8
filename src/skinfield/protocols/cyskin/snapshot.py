"""What lies in the shared memory of CySkin's acquisition tool, and how it becomes blocks.

Two areas of uint32 in the machine's own order, as `shared_memory_publisher` writes them:

======= ============ ====================================================================
area    word         what
======= ============ ====================================================================
header  0            sensors, N
header  1            kind of acquisition
header  2            key of the data, 64
header  3 to 9       not used; the area itself may be only 10 bytes long
data    0            number of the sample, from 0 on
data    1            time since the tool's start, ms
data    2            active sensors; always N until now
data    3 to N + 2   uids
data    from N + 3   responses, in the order of the uids
======= ============ ====================================================================

The writer takes no lock. It writes uids and responses, then the active sensors, the time, and the
number of the sample last, so that a new number means that its responses are there; but those of the
next may be on their way already.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.acquisition import Blocks
from skinfield.errors import InputError, Ints
from skinfield.protocols.cyskin.modules import CySkinBoard, channels_of, checked_boards, uids_of

HEADER_WORDS, HEADER_KEY, DATA_KEY = 10, 450, 64
DATA_HEAD = 3  # words before the uids
HIGHEST = 65535  # of a response
MOST = 1 << 20  # sensors that a header may speak of

Words32 = NDArray[np.uint32]


def data_words(sensors: int) -> int:
    """Words of the data of so many sensors."""
    return 2 * sensors + DATA_HEAD


def words_from_uids(uids: ArrayLike) -> Words32:
    """Uids (N,) as the memory holds them.

    Raises
    ------
    InputError
        If one has more than 32 bits.
    """
    values = np.asarray(uids, np.uint64)
    if (values >> np.uint64(32)).any():
        raise InputError(
            f"uid {int(values.max())} has more than 32 bits, expected sui << 4 | sensor with a sui "
            "of 28: the shared memory holds no more"
        )
    return values.astype(np.uint32)


class Snapshot(NamedTuple):
    """The data, taken apart without copying.

    Attributes
    ----------
    sample, time_ms, active : int
    uids, responses : (N,) uint32 arrays
    """

    sample: int
    time_ms: int
    active: int
    uids: Words32
    responses: Words32


def snapshot_of(words: Words32) -> Snapshot:
    """Take data words apart.

    Raises
    ------
    InputError
        If there are not 2 N + 3 of them.
    """
    sensors = (len(words) - DATA_HEAD) // 2
    if sensors < 0 or len(words) != data_words(sensors):
        raise InputError(f"data have {len(words)} words, expected 2 N + 3 of them for N sensors")
    sample, time_ms, active = words[:DATA_HEAD].tolist()
    uids = words[DATA_HEAD : DATA_HEAD + sensors]
    return Snapshot(sample, time_ms, active, uids, words[DATA_HEAD + sensors :])


class SensorOrder:
    """Responses in the order of their uids, to blocks by channel.

    Parameters
    ----------
    boards : sequence of CySkinBoard
        Their modules make the channels: sensor s of module m is channel 12 m + s.

    Attributes
    ----------
    unknown : int
        Sensors of the last uids that no module has; they are left out.
    """

    def __init__(self, boards: Iterable[CySkinBoard]) -> None:
        boards = checked_boards(boards)
        uids, channels = uids_of(boards)
        order = np.argsort(uids)
        self._known, self._channels = words_from_uids(uids[order]), channels[order]
        self.channels = channels_of(boards)
        self.unknown = 0
        self._uids: Words32 = np.zeros(0, np.uint32)
        self._take: Ints = np.zeros(0, np.int64)
        self._runs: Ints = np.zeros(0, np.int64)
        self._long: Words32 = np.zeros(0, np.uint32)
        self._shorts: NDArray[np.uint16] = np.zeros(0, np.uint16)

    def follow(self, uids: Words32) -> None:
        """Learn where the uids of the next responses belong; costs little if they are the same."""
        if np.array_equal(uids, self._uids):
            return
        self._uids = uids.copy()
        at = np.minimum(np.searchsorted(self._known, uids), len(self._known) - 1)
        found = self._known[at] == uids
        channels = self._channels[at[found]]
        _, first = np.unique(channels, return_index=True)  # sorts, and of twins takes the first
        self._take = np.flatnonzero(found)[first]
        self._runs = channels[first]
        self._long = np.zeros(len(first), np.uint32)
        self._shorts = np.zeros(len(first), np.uint16)
        self.unknown = len(uids) - len(first)

    def put(
        self, responses: Words32, blocks: Blocks, channel: int, counters: Ints, now_ns: int
    ) -> bool:
        """Append the responses (N,) of the last uids; False, and nothing, if they do not fit."""
        from skinfield.protocols.cyskin.runs_kernel import put_pairs

        np.take(
            responses, self._take, out=self._long, mode="clip"
        )  # which needs no room of its own
        self._shorts[:] = self._long
        return bool(
            put_pairs(
                blocks.words, blocks.octets, blocks.end, now_ns, channel, self._runs, 0,
                len(self._runs), self._shorts.view(np.uint8), 0, False, counters,
            )
        )  # fmt: skip
