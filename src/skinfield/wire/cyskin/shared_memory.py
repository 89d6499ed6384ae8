"""Shared memory of CySkin's acquisition tool: its layout, and reading it.

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

import ctypes
from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, Ints, check_count
from skinfield.signal import Blocks, Count
from skinfield.wire.cyskin.modules import CySkinBoard, checked_boards, uids_of
from skinfield.wire.links import BreakingLink

HEADER_WORDS, HEADER_KEY, DATA_KEY = 10, 450, 64
DATA_HEAD = 3  # words before the uids
HIGHEST = 65535  # of a response
MOST = 1 << 20  # sensors that a header may speak of

Words32 = NDArray[np.uint32]
IPC_STAT, SHM_RDONLY = 2, 0o10000
SIZE_AT = 48  # octet of shm_segsz in struct shmid_ds, on Linux of 64 bits
TRIES = 4  # snapshots before what is torn is left for the next poll
HIGHEST_KEY = 2**31 - 1


class Area:
    """One area of shared memory as uint32 words, which are only read.

    Parameters
    ----------
    key : int
    words : int
        That are mapped.

    Raises
    ------
    OSError
        If it is not there, or belongs to someone else.
    InputError
        If it is smaller than that.
    """

    def __init__(self, key: int, words: int) -> None:
        self.key, self.number = key, area_number(key)
        status = ctypes.create_string_buffer(256)
        if self.number < 0 or libc().shmctl(self.number, IPC_STAT, status) < 0:
            raise OSError(ctypes.get_errno(), f"shared memory with key {key} is not there")
        size = int.from_bytes(status.raw[SIZE_AT : SIZE_AT + 8], "little")
        # The maker's tool makes its header of 10 bytes. A page has 4096, so 40 are there even so.
        if size < 4 * words and not (words == HEADER_WORDS and size >= HEADER_WORDS):
            raise InputError(
                f"shared memory with key {key} has {size} bytes, expected {4 * words}: of another "
                "program, or another number of sensors"
            )
        self._address = libc().shmat(self.number, None, SHM_RDONLY)
        if self._address in (None, ctypes.c_void_p(-1).value):
            raise OSError(ctypes.get_errno(), f"shared memory with key {key} cannot be mapped")
        mapped = (ctypes.c_uint32 * words).from_address(self._address)
        self.words: Words32 = np.ctypeslib.as_array(mapped)
        self.words.flags.writeable = False  # the system would end the process instead

    def close(self) -> None:
        """Unmap it; `words` must not be used after that."""
        self.words = np.zeros(0, np.uint32)
        libc().shmdt(self._address)


def area_number(key: int) -> int:
    """Number by which the system knows an area now; -1 if there is none."""
    return int(libc().shmget(key, 0, 0))


@cache
def libc() -> Any:
    """The system's calls."""
    calls = ctypes.CDLL(None, use_errno=True)
    calls.shmget.argtypes = [ctypes.c_int, ctypes.c_size_t, ctypes.c_int]
    calls.shmat.argtypes = [ctypes.c_int, ctypes.c_void_p, ctypes.c_int]
    calls.shmat.restype = ctypes.c_void_p
    calls.shmdt.argtypes = [ctypes.c_void_p]
    calls.shmctl.argtypes = [ctypes.c_int, ctypes.c_int, ctypes.c_void_p]
    return calls


class SharedMemoryReader(BreakingLink):
    """New samples of the tool's shared memory, as blocks.

    Each sample is copied until two copies in a row are the same, as the writer takes no lock; that
    fails only if the writer stands still between two words just then. Samples that were written
    over before they were read are `LOST`. The writer may end and begin again at any time.

    Parameters
    ----------
    boards : iterable of CySkinBoard
        Modules of the port, which give each uid its channel: sensor s of module m is 12 m + s.
    key : int
        Of the header. 450 is the tool's.

    Attributes
    ----------
    unknown : int
        Sensors of the last uids that no module has; they are left out.
    """

    def __init__(self, boards: Iterable[CySkinBoard], key: int = HEADER_KEY) -> None:
        check_count("key", key, 1, HIGHEST_KEY, "of the header's shared memory")
        super().__init__(f"shared memory with key {key}")
        self.key, self.fault = key, f"{self.label}: no tool runs"
        uids, channels = uids_of(checked_boards(boards))
        order = np.argsort(uids)
        self._known, self._channels = uids[order], channels[order]
        self.unknown = 0
        self._uids: Words32 = np.zeros(0, np.uint32)
        self._take: Ints = np.zeros(0, np.int64)
        self._runs: Ints = np.zeros(0, np.int64)
        self._words = 0  # of the blocks of these
        self._areas: tuple[Area, Area] | None = None
        self._copies: Words32 = np.zeros((2, 0), np.uint32)
        self._sample = -1

    def _open(self) -> bool:
        if self._areas is not None:
            return True
        try:
            header = Area(self.key, HEADER_WORDS)
        except OSError:
            return False
        sensors, _, key = header.words[:3].tolist()
        try:
            check_count("sensors in the header", sensors, 1, MOST, "none yet: it is being made")
            data = Area(key or DATA_KEY, 2 * sensors + DATA_HEAD)
        except (OSError, InputError):  # between the writer's two steps, or another program's
            header.close()
            return False
        self._areas, self._sample = (header, data), -1
        self._copies = np.zeros((2, len(data.words)), np.uint32)
        return self._opened(-1)

    def read(self, blocks: Blocks, channel: int, counters: Ints, now_ns: int) -> int:
        """Append the newest sample if it is new; samples taken, 0 or 1.

        Parameters
        ----------
        blocks : Blocks
        channel : int
            That the port's first channel has among all.
        counters : (len(Count),) int64 array
        now_ns : int, ns
            Stamp of the blocks.
        """
        if self._areas is None or not self._still_there():
            return 0
        words = self._areas[1].words
        if self._sample == int(words[0]) or not self._copied(words):
            return 0
        copy = self._copies[0]
        sample, active = int(copy[0]), int(copy[2])
        if sample == self._sample or (sample == 0 and active == 0):
            return 0  # nothing was written yet
        uids, responses = copy[DATA_HEAD:].reshape(2, -1)
        if responses.max() > HIGHEST:
            counters[Count.MALFORMED] += 1
            self._sample = sample
            return 0
        self.follow(uids)
        if not self.put(responses, blocks, channel, counters, now_ns):
            return 0
        if 0 <= self._sample < sample:
            counters[Count.LOST] += sample - self._sample - 1
        self._sample = sample
        counters[Count.RECEIVED] += 1
        counters[Count.FOREIGN] += self.unknown > 0
        counters[Count.BYTES] += words.nbytes
        return 1

    def follow(self, uids: Words32) -> None:
        """Learn where the uids of the next responses belong; costs little if they are the same."""
        if np.array_equal(uids, self._uids):
            return
        self._uids = uids.copy()
        at = np.minimum(np.searchsorted(self._known, uids), len(self._known) - 1)
        found = self._known[at] == uids
        channels, first = np.unique(self._channels[at[found]], return_index=True)  # of twins one
        self._take, self._runs = np.flatnonzero(found)[first], channels
        ends = np.flatnonzero(np.diff(channels, append=-1) != 1) + 1
        self._words = int((2 + (np.diff(ends, prepend=0) + 3) // 4).sum())
        self.unknown = len(uids) - len(first)

    def put(
        self, responses: Words32, blocks: Blocks, channel: int, counters: Ints, now_ns: int
    ) -> bool:
        """Append the responses (N,) of the last uids; False, and nothing, if they do not fit."""
        from skinfield.wire.cyskin.kernel import put_pairs

        if blocks.end[0] + self._words > len(blocks.words):
            return False
        octets = responses[self._take].astype(np.uint16).view(np.uint8)
        into, stop = (blocks.words, blocks.octets, blocks.end), len(self._runs)
        put_pairs(into, now_ns, channel, self._runs, 0, stop, octets, 0, False, counters)
        return True

    def _still_there(self) -> bool:
        """Whether the keys still mean what is mapped; a writer that began anew made it anew."""
        assert self._areas is not None
        if all(area_number(area.key) == area.number for area in self._areas):
            return True
        self.broke("no tool runs")
        return False

    def _copied(self, words: Words32) -> bool:
        """Copy until two copies are the same.

        NumPy copies, not a compiled loop of ours: a compiler may take one copy for the other.
        """
        one, other = self._copies
        np.copyto(one, words)
        for _ in range(TRIES):
            np.copyto(other, words)
            if np.array_equal(one, other):
                return True
            np.copyto(one, other)
        return False

    def close(self) -> None:
        """Unmap the memory."""
        if self._areas is not None:
            for area in self._areas:
                area.close()
        self._areas, self.up = None, False
