"""Reader of a ring in shared memory, which never disturbs its writer, and the rings there are."""

import contextlib
import mmap
import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, InputError, check_count
from skinfield.ring import files, system
from skinfield.ring import layout as header
from skinfield.ring.layout import LINE, SLOT_GENERATION, SLOT_LOG_END, Field, Layout, Span, State
from skinfield.ring.log import LogReader


class Slot:
    """A copy of a slot; `RingReader.slot` makes one that can be filled again and again.

    Attributes
    ----------
    number : int
        0 as long as it is empty.
    generation : int
        Of the writer that made it.
    log_end : int, bytes
        Of the log when the slot was complete: what was appended before is at lower positions.
    arrays : dict of str to array
        By the fields' names; ``slot["name"]`` is short for them.
    octets : (slot_bytes,) uint8 array
        The same, as it lies in the ring.
    """

    def __init__(self, fields: tuple[Span, ...], size: int) -> None:
        self.number = self.generation = self.log_end = 0
        room = np.zeros(size + LINE, np.uint8)
        start = -room.ctypes.data % LINE
        self.octets: NDArray[np.uint8] = room[start : start + size]
        self.arrays: dict[str, NDArray[Any]] = {
            placed.field.name: placed.view(self.octets, 0) for placed in fields
        }
        self._words = self.octets.data.cast("Q")

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.arrays)

    def took(self, number: int) -> Self:
        """Note which slot `octets` now are a whole copy of; 0 if of none."""
        self.number = number
        self.log_end = self._words[SLOT_LOG_END]
        self.generation = self._words[SLOT_GENERATION]
        return self


class RingInfo(NamedTuple):
    """A ring that was found.

    Attributes
    ----------
    name : str
    path : Path
    pid : int
        Of its writer, or of its last one; 0 if the file is damaged.
    state : State or None
        As the writer last said; None if the file is damaged.
    alive : bool
        Whether its writer lives; False if the file is damaged.
    generation, number : int
        Of writers so far; of the newest slot.
    problem : str
        Why it cannot be read; empty if it can.
    """

    name: str
    path: Path
    pid: int
    state: State | None
    alive: bool
    generation: int
    number: int
    problem: str = ""


def rings_in(folder: Path | None = None) -> tuple[RingInfo, ...]:
    """Rings that are there, by name, with the state of their writers; damaged ones too."""
    paths = sorted(files.folder_of(folder).glob(f"{files.PREFIX}*"))
    return tuple(_look(path) for path in paths if path.is_file())


def _look(path: Path) -> RingInfo:
    name = path.name.removeprefix(files.PREFIX)
    try:
        with RingReader(name, folder=path.parent) as reader:
            now = reader.pid, reader.state, reader.alive, reader.generation, reader.number
            return RingInfo(name, path, *now)
    except FileError as error:
        return RingInfo(name, path, 0, None, False, 0, 0, str(error))


_TRIES = 64  # to copy the newest slot before the writer comes round
_LONGEST = 0.5  # s in one system call
_WORD = 0xFFFFFFFFFFFFFFFF
LOW = 0xFFFFFFFF
_ALL = (slice(None),)


class MappedRing:
    """A ring's file in memory, as its writer and its readers have it.

    Parameters
    ----------
    path : Path
    memory : mmap
    plan : Layout
        Of it.

    Attributes
    ----------
    name : str
    path : Path
    description : dict
        As the writer gave it to `Ring.create`.
    """

    def __init__(self, path: Path, memory: mmap.mmap, plan: Layout) -> None:
        self.path, self.name = path, path.name.removeprefix(files.PREFIX)
        self._memory, self._layout, self._header = memory, plan, plan.header
        self.description: dict[str, Any] = plan.described(str(path))
        self._fence = system.fence()
        self._octets = octets = np.frombuffer(memory, np.uint8)
        self._words = memoryview(memory)[: len(octets) // 8 * 8].cast("Q")
        self._signal = system.signal(octets.ctypes.data + 8 * header.FUTEX)
        self._locks = [start // 8 for start in plan.header.slot_starts]
        self._status: dict[str, NDArray[Any]] = {
            placed.field.name: placed.view(octets, plan.header.status_offset)
            for placed in plan.status_fields
        }

    @property
    def number(self) -> int:
        """Of the newest slot, 0 before the first."""
        return self._words[header.HEAD]

    @property
    def state(self) -> State:
        """What the writer last said that it was doing."""
        number = self._words[header.WRITER] >> 32
        try:
            return State(number)
        except ValueError:
            raise FileError(f"state of {self.path} is {number}, expected one of State") from None

    @property
    def generation(self) -> int:
        """1 for the first writer, one more for each that went on."""
        return self._words[header.GENERATION] & LOW

    @property
    def log_end(self) -> int:
        """Bytes ever appended to the log."""
        return self._words[header.LOG_END]

    def _unmap(self) -> None:
        self._status, self._octets = {}, np.zeros(0, np.uint8)
        self._words.release()
        with contextlib.suppress(BufferError):  # arrays of it are still held elsewhere
            self._memory.close()

    def __enter__(self) -> Self:
        return self


class RingReader(MappedRing):
    """Reads a ring that another process writes, or the same one.

    The file is mapped for reading only. A reader stays good when the writer dies and another goes
    on with the ring; `replaced` says whether the name now belongs to another file.

    Parameters
    ----------
    name : str
    folder : Path, optional
        As for `Ring.create`.

    Raises
    ------
    FileError
        If there is no such ring, it may not be read, or it is damaged.

    Attributes
    ----------
    slot_fields, status_fields : tuples of Field
    slots : int
    log_bytes : int
    """

    def __init__(self, name: str, *, folder: Path | None = None) -> None:
        path = files.path_of(name, folder)
        self._descriptor = files.open_ring(path, write=False)
        try:
            memory = files.mapped(self._descriptor, path, write=False)
            plan = Layout.read(memoryview(memory), str(path))
            super().__init__(path, memory, plan)
        except BaseException:
            os.close(self._descriptor)
            raise
        self.slots, self.log_bytes = plan.header.slots, plan.header.log_bytes
        self.slot_fields: tuple[Field, ...] = tuple(each.field for each in plan.slot_fields)
        self.status_fields: tuple[Field, ...] = tuple(each.field for each in plan.status_fields)
        size = plan.header.slot_bytes
        self._slots = [self._octets[start : start + size] for start in plan.header.slot_starts]
        self._spans = {
            placed.field.name: slice(placed.offset, placed.offset + placed.size)
            for placed in plan.slot_fields
        }

    @property
    def pid(self) -> int:
        """Process of the writer, or of the last one."""
        return self._words[header.WRITER] & LOW

    @property
    def heartbeat_ns(self) -> int:
        """When the writer last was at work, ns of `time.monotonic_ns`."""
        return self._words[header.HEARTBEAT]

    @property
    def alive(self) -> bool:
        """Whether the writer's process lives, whatever it last said."""
        return files.locked(self._descriptor)

    @property
    def status(self) -> dict[str, NDArray[Any]]:
        """A copy of the status; each 64-bit word is whole, but not all are of one moment."""
        return {name: array.copy() for name, array in self._status.items()}

    @property
    def status_view(self) -> dict[str, NDArray[Any]]:
        """The status itself, read-only: it changes while it is looked at, and costs nothing."""
        return self._status

    def replaced(self) -> bool:
        """Whether the file no longer has the ring's name: make a new reader then."""
        return not files.same(self._descriptor, self.path)

    def slot(self) -> Slot:
        """Make an empty slot, for `latest` and `get` to fill."""
        return Slot(self._layout.slot_fields, self._header.slot_bytes)

    def latest(self, into: Slot | None = None) -> Slot | None:
        """Copy the newest slot.

        Parameters
        ----------
        into : Slot, optional
            Of `slot`, filled and returned; otherwise a new one.

        Returns
        -------
        Slot or None
            None before the first.

        Raises
        ------
        FileError
            If the file is damaged.
        InputError
            If the writer overtook every attempt: it needs more slots.
        """
        into = into or self.slot()
        for _ in range(_TRIES):
            number = self.number
            if not number:
                return None
            if self._copy(number, into, _ALL):
                return into.took(number)
            if self._fence:
                self._fence()
            if self.number == number:  # complete, if the file is good
                raise FileError(f"{self.path} is damaged: its newest slot {number} is not complete")
        raise InputError(
            f"{self.path} has {self.slots} slots, and the writer came round {_TRIES} times while "
            "one was copied, expected more slots or a slower writer"
        )

    def get(self, number: int, into: Slot | None = None) -> Slot | None:
        """Copy a certain slot; None if it does not exist yet, or not any more."""
        into = into or self.slot()
        head = self.number
        if not max(0, head - self.slots) < number <= head:
            return None
        return into.took(number) if self._copy(number, into, _ALL) else None

    def part(self, number: int, into: Slot, names: Sequence[str]) -> bool:
        """Copy some fields of a certain slot: less to move where the others are large.

        Returns
        -------
        bool
            Whether it was there, and whole. The other fields keep what they had.
        """
        if not max(0, self.number - self.slots) < number:
            return False
        return self._copy(number, into, [self._spans[name] for name in names])

    def _copy(self, number: int, into: Slot, spans: Sequence[slice]) -> bool:
        """Copy some octets of a slot, if it was whole before and after."""
        index, fence, whole = number % self.slots, self._fence, 2 * number + 2 & _WORD
        lock, octets = self._locks[index], self._slots[index]
        if self._words[lock] != whole:
            return False
        if fence:
            fence()
        for span in spans:
            into.octets[span] = octets[span]
        if fence:
            fence()
        if self._words[lock] != whole:
            into.took(0)
            return False
        return True

    def wait(self, after: int, timeout: float) -> int:
        """Wait for a slot that is newer than `after`, or for the writer's state to change.

        Parameters
        ----------
        after : int
            Number of the last slot that was seen; 0 for none.
        timeout : float, s
            May be infinite.

        Returns
        -------
        int
            Number of the newest slot, which is not above `after` if there was none in time.
        """
        if not timeout >= 0:
            raise InputError(f"timeout is {timeout!r}, expected a number of seconds, 0 or more")
        end = time.monotonic() + timeout
        words, writer = self._words, self._words[header.WRITER]
        while True:
            seen = words[header.FUTEX]
            if self._fence:
                self._fence()
            number = words[header.HEAD]
            left = end - time.monotonic()
            if number > after or left <= 0 or words[header.WRITER] != writer:
                return number
            self._signal.wait(seen & LOW, min(left, _LONGEST))

    def log_reader(self, position: int | None = None) -> LogReader:
        """Read the log from now on, or from a position.

        Parameters
        ----------
        position : int, bytes, optional
            An end of a batch: the `log_end` of a slot, or 0 for all that is still there (what is
            not counts as lost).
        """
        end = self.log_end
        if position is not None:
            check_count("position", position, 0, end, "bytes, where a batch ended")
        start, size = self._header.log_offset, self._header.log_bytes
        log = memoryview(self._memory)[start : start + size]
        return LogReader(
            self._words,
            log,
            self._header.mark_shift,
            self._fence,
            end if position is None else position,
        )

    def close(self) -> None:
        """Unmap the file; log readers of it end too."""
        if self._descriptor < 0:
            return
        os.close(self._descriptor)
        self._descriptor, self._slots = -1, []
        self._unmap()

    def __exit__(self, *_: object) -> None:
        self.close()
