"""Writer of a ring in shared memory, and making or taking over its file."""

import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, InputError
from skinfield.ring import files
from skinfield.ring import layout as header
from skinfield.ring.files import Lock
from skinfield.ring.layout import Field, Layout, State
from skinfield.ring.log import Log, Octets
from skinfield.ring.reader import LOW, MappedRing, rings_in

_PATIENCE = 2.0  # s, for another process that makes the same ring


@contextmanager
def made(path: Path, plan: Layout) -> Iterator[tuple[Lock, Path]]:
    """A new file, locked, and where it is now; it gets its name when all went well.

    So readers never see half a ring, and the file of a writer that lives is never replaced.

    Raises
    ------
    InputError
        If a living process writes a ring there.
    FileError
        If there is no memory for it.
    """
    lock, new = _new_file(path)
    try:
        with ExitStack() as stack:
            for old in _claimed(path):
                stack.callback(old.close)
            files.reserve(lock.descriptor, plan.header.file_bytes, path)
            os.pwrite(lock.descriptor, plan.beginning(), 0)
            yield lock, new
            new.rename(path)
    except BaseException:
        new.unlink(missing_ok=True)
        lock.close()
        raise


@contextmanager
def taken_over(path: Path) -> Iterator[Lock]:
    """A ring's file, now locked for this process.

    Raises
    ------
    InputError
        If a living process writes it.
    FileError
        If it is not there.
    """
    claimed = _claimed(path)
    if not claimed:
        raise FileError(f"{path} is not there, expected a ring to go on with: use Ring.create")
    try:
        yield claimed[0]
    except BaseException:
        claimed[0].close()
        raise


def remove(path: Path) -> None:
    """Delete a ring that nobody writes, and what remained of making one."""
    for each in (path, files.unfinished(path)):
        for lock in _claimed(each):
            each.unlink(missing_ok=True)
            lock.close()


def _claimed(path: Path) -> list[Lock]:
    """Lock the file of that name; an empty list if there is no such file.

    As long as its lock is held, nobody else gives the name to another file.
    """
    while True:
        try:
            descriptor = files.open_ring(path, write=True)
        except FileError:
            if os.path.lexists(path):
                raise
            return []
        lock = Lock.take(descriptor)
        if lock is None:
            raise InputError(_taken(path))
        if files.same(lock.descriptor, path):
            return [lock]
        lock.close()  # replaced between opening and locking: look again


def _new_file(path: Path) -> tuple[Lock, Path]:
    """Open and lock the file that becomes a ring when it is renamed: one process at a time."""
    new, end = files.unfinished(path), time.monotonic() + _PATIENCE
    while time.monotonic() < end:
        try:
            flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
            descriptor = os.open(new, flags, 0o600)
        except OSError as error:
            raise FileError(
                f"{new} cannot be made: {error.strerror}, expected a folder that can be written"
            ) from error
        lock = Lock.take(descriptor)
        if lock is not None:
            if files.same(lock.descriptor, new):
                os.fchmod(lock.descriptor, 0o600)
                return lock, new
            lock.close()  # another has just given it its name
    raise InputError(f"{path} is being made by another process, expected one at a time")


def _taken(path: Path) -> str:
    who = [each for each in rings_in(path.parent) if each.path == path]
    text = f" (process {who[0].pid})" if who and who[0].pid else ""
    return (
        f"{path} is written by a living process{text}, expected none: stop that one first, or "
        "take another name"
    )


class Ring(MappedRing):
    """Slots, status and a log in shared memory, which one process writes and any number read.

    Made by `create`, or by `reopen` after the process that wrote it has ended. Readers only ever
    map the file for reading: none can disturb the writer, or make it wait.

    Attributes
    ----------
    status : dict of str to array
        In shared memory, to be written in place; readers see each 64-bit word whole, but not all
        words of one moment.
    """

    def __init__(self, lock: files.Lock, path: Path, plan: Layout, now: Path) -> None:
        """Map a locked file, as yet at `now`, which must be as planned; for the methods below."""
        memory = files.mapped_apart(now)
        found = Layout.read(memoryview(memory), str(path))
        if difference := plan.difference(found):
            raise InputError(
                f"{path} has other fields or sizes, expected those asked for: {difference}; "
                "make it anew with Ring.create"
            )
        super().__init__(path, memory, found)
        self._lock = lock
        self.status: dict[str, NDArray[Any]] = self._status
        self._slots: list[dict[str, NDArray[Any]]] = [
            {placed.field.name: placed.view(self._octets, start) for placed in found.slot_fields}
            for start in found.header.slot_starts
        ]
        start, size = found.header.log_offset, found.header.log_bytes
        log = self._octets[start : start + size]
        self._log = Log(self._words, log, found.header.mark_shift, self._fence)
        self._number = self._words[header.HEAD]  # of the slot that is written, or was last
        self._begun = False
        self._take_over()

    def _take_over(self) -> None:
        """Become the writer: what a dead one left unfinished is marked as never written."""
        words = self._words
        for lock in self._locks:
            if words[lock] & 1 or words[lock] > 2 * self._number + 2:
                words[lock] = 0
        words[header.FUTEX] = self._number & LOW
        words[header.GENERATION] = words[header.GENERATION] + 1 & LOW
        words[header.HEARTBEAT] = time.monotonic_ns()
        self.set_state(State.STARTING)

    @classmethod
    def create(
        cls,
        name: str,
        slot_fields: Sequence[Field],
        status_fields: Sequence[Field] = (),
        description: Mapping[str, Any] | None = None,
        slots: int = 64,
        log_bytes: int = 1 << 24,
        *,
        folder: Path | None = None,
    ) -> Self:
        """Make a ring, in place of one of that name whose writer has ended.

        Parameters
        ----------
        name : str
            Letters, digits, ``_-.``, at most 64.
        slot_fields, status_fields : sequences of Field
        description : mapping, optional
            What readers must know, in plain values; written as JSON.
        slots : int
            Readers have as many cycles, less one, to copy a slot.
        log_bytes : int
            Room of the log, a power of two; a reader may be that much behind.
        folder : Path, optional
            Otherwise /dev/shm, or the folder for temporary files where that is missing.

        Raises
        ------
        InputError
            If an argument cannot be used, or a living process writes a ring of that name.
        FileError
            If there is no memory for it.
        """
        path = files.path_of(name, folder)
        stamp = time.time_ns()
        plan = Layout.plan(slot_fields, status_fields, description or {}, slots, log_bytes, stamp)
        with made(path, plan) as (lock, now):
            return cls(lock, path, plan, now)

    @classmethod
    def reopen(
        cls,
        name: str,
        slot_fields: Sequence[Field],
        status_fields: Sequence[Field] = (),
        slots: int = 64,
        log_bytes: int = 1 << 24,
        *,
        folder: Path | None = None,
    ) -> Self:
        """Go on with a ring whose writer has ended: numbers and the log continue.

        Readers stay as they are. A slot that the dead writer did not finish is never shown.

        Parameters
        ----------
        name, slot_fields, status_fields, slots, log_bytes, folder
            As for `create`, and the same as then.

        Raises
        ------
        InputError
            If a living process writes it, or it has other fields or sizes.
        FileError
            If it is not there, or damaged.
        """
        path = files.path_of(name, folder)
        plan = Layout.plan(slot_fields, status_fields, {}, slots, log_bytes)
        with taken_over(path) as lock:
            return cls(lock, path, plan, path)

    def begin(self) -> dict[str, NDArray[Any]]:
        """Arrays of the next slot, to be written in place before `publish`.

        They hold what was there some slots ago. Nothing is allocated; without `publish` in
        between, the next call gives the same slot again.
        """
        if not self._begun:
            self._number += 1
            self._begun = True
            self._words[self._locks[self._number % len(self._locks)]] = 2 * self._number + 1
            if self._fence:
                self._fence()
        return self._slots[self._number % len(self._slots)]

    def publish(self) -> int:
        """Show the slot to readers and wake those who wait.

        Returns
        -------
        int
            Its number: 1 for the first.

        Raises
        ------
        InputError
            If there was no `begin`.
        """
        if not self._begun:
            raise InputError("there is no slot to publish, expected begin() before publish()")
        words, number, fence = self._words, self._number, self._fence
        lock = self._locks[number % len(self._locks)]
        words[lock + header.SLOT_LOG_END] = self._log.end
        words[lock + header.SLOT_GENERATION] = words[header.GENERATION]
        if fence:
            fence()
        words[lock] = 2 * number + 2
        if fence:
            fence()
        words[header.HEAD] = number
        if fence:
            fence()
        words[header.FUTEX] = number & LOW
        self._begun = False
        self._signal.wake()
        return number

    def log(self, octets: Octets, count: int | None = None) -> int:
        """Append a batch to the log; readers see it as a whole or not at all.

        Parameters
        ----------
        octets : (n,) uint8 array
        count : int, optional
            Of its bytes, otherwise all.

        Returns
        -------
        int
            `log_end`, behind it.

        Raises
        ------
        InputError
            If it has not so many bytes, or is longer than the log.
        """
        return self._log.append(octets, len(octets) if count is None else count)

    def heartbeat(self, now_ns: int) -> None:
        """Say that the writer is at work, at `now_ns` of `time.monotonic_ns`."""
        self._words[header.HEARTBEAT] = now_ns

    def set_state(self, state: State) -> None:
        """Say what the writer is doing, and wake those who wait."""
        self._words[header.WRITER] = os.getpid() | int(state) << 32
        self._signal.wake()

    def unlink(self) -> None:
        """Take the file's name away, before `close`; who has the file open keeps it."""
        if self._lock.held and files.same(self._lock.descriptor, self.path):
            self.path.unlink()

    def close(self) -> None:
        """Stop writing; the file stays, for `reopen` or for who looks at what was last.

        Arrays that were handed out must not be written any more.
        """
        if not self._lock.held:
            return
        if self.state != State.FAILED:
            self.set_state(State.STOPPED)
        self._lock.close()
        self._slots, self.status = [], {}
        self._log = Log(self._words, np.zeros(0, np.uint8), 0, None)
        self._unmap()

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None and issubclass(kind, Exception) and self._lock.held:
            self.set_state(State.FAILED)  # not after Ctrl-C, which is an ordinary end
        self.close()

    names = staticmethod(rings_in)

    @staticmethod
    def remove(name: str, folder: Path | None = None) -> None:
        """Delete a ring whose writer has ended; nothing happens if there is none.

        Raises
        ------
        InputError
            If a living process writes it.
        """
        remove(files.path_of(name, folder))
