"""The writer's side of a ring."""

import contextlib
import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError
from skinfield.ring import files, layout, system
from skinfield.ring.fields import Field
from skinfield.ring.layout import Layout, State
from skinfield.ring.present import Present, present

Octets = NDArray[np.uint8]
_LOW = 0xFFFFFFFF


class Ring:
    """Slots, status and a log in shared memory, which one process writes and any number read.

    Made by `Ring.create`, or by `Ring.reopen` after the process that wrote it has died. Readers
    only ever map the file for reading: none can disturb the writer, or make it wait.

    Attributes
    ----------
    name : str
    path : Path
    description : dict
        As it was given to `create`.
    status : dict of str to array
        In shared memory, to be written in place; readers see each 64-bit word whole, but not all
        words of one moment.
    log_end : int, bytes
        Ever appended to the log.
    generation : int
        1 for the first writer, one more for each that went on.
    notes : tuple of str
        Sentences on what this system does not offer; empty on Linux.
    """

    def __init__(self, descriptor: int, path: Path) -> None:
        """Map a locked file; for `create` and `reopen`."""
        self.path, self.name = path, path.name.removeprefix(files.PREFIX)
        self._descriptor = descriptor
        self._memory = files.mapped(descriptor, path, write=True)
        self._layout = plan = Layout.read(memoryview(self._memory), str(path))
        self.description: dict[str, Any] = plan.described(str(path))
        self._fence = system.fence()
        octets = files.octets_of(self._memory)
        self._words = memoryview(self._memory).cast("Q")
        self._signal = system.signal(octets.ctypes.data + 8 * layout.FUTEX)
        self.notes = _notes(path, self._signal)
        self.status: dict[str, NDArray[Any]] = {
            placed.field.name: placed.view(self._memory, plan.status_offset)
            for placed in plan.status_fields
        }
        starts = [plan.slots_offset + i * plan.slot_bytes for i in range(plan.slots)]
        self._locks = [start // 8 for start in starts]
        self._slots: list[dict[str, NDArray[Any]]] = [
            {placed.field.name: placed.view(self._memory, start) for placed in plan.slot_fields}
            for start in starts
        ]
        self._log: Octets = octets[plan.log_offset : plan.log_offset + plan.log_bytes]
        self._shift = plan.mark_shift
        self._number = int(self._words[layout.HEAD])  # of the slot that is written, or was last
        self._begun = False
        self.log_end = int(self._words[layout.LOG_END])
        self._reserved = int(self._words[layout.LOG_RESERVED])
        self._take_over()
        self.generation = int(self._words[layout.GENERATION])

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
        """Make a ring, in place of one of that name whose writer is gone.

        Parameters
        ----------
        name : str
            Letters, digits, ``_``, ``-`` and ``.``, at most 64.
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
        plan = Layout.plan(slot_fields, status_fields, description or {}, slots, log_bytes)
        descriptor, new = files.new_file(path)
        held: list[int] = []
        try:
            held += _claimed(path)
            files.reserve(descriptor, plan.file_bytes, path)
            os.pwrite(descriptor, plan.beginning(time.time_ns()), 0)
            ring = cls(descriptor, path)
            new.rename(path)
        except BaseException:
            new.unlink(missing_ok=True)
            os.close(descriptor)
            raise
        finally:
            for each in held:
                os.close(each)
        return ring

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
        descriptor = files.open_ring(path, write=True)
        try:
            if not files.lock(descriptor) or not files.same(descriptor, path):
                raise InputError(_taken(path))
            found = Layout.read(memoryview(files.mapped(descriptor, path, write=False)), str(path))
            if found.shape() != plan.shape():
                raise InputError(
                    f"{path} has other fields, slots or log than asked for, expected the same "
                    f"({plan.difference(found)}): make it anew with Ring.create"
                )
            return cls(descriptor, path)
        except BaseException:
            os.close(descriptor)
            raise

    def _take_over(self) -> None:
        """Become the writer: what a dead one left unfinished is marked as never written."""
        words = self._words
        for lock in self._locks:
            if words[lock] & 1 or words[lock] > 2 * self._number + 2:
                words[lock] = 0
        words[layout.FUTEX] = self._number & _LOW
        words[layout.GENERATION] += 1
        words[layout.HEARTBEAT] = time.monotonic_ns()
        self.set_state(State.STARTING)

    def begin(self) -> dict[str, NDArray[Any]]:
        """Arrays of the next slot, to be written in place before `publish`.

        They hold what was there some slots ago. Nothing is allocated; a second call without
        `publish` gives the same slot again.
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
            Its number: 1 for the first, then one more each.

        Raises
        ------
        InputError
            If there was no `begin`.
        """
        if not self._begun:
            raise InputError("nothing to publish, expected begin() before publish()")
        words, number, fence = self._words, self._number, self._fence
        lock = self._locks[number % len(self._locks)]
        words[lock + layout.SLOT_LOG_END] = self.log_end
        words[lock + layout.SLOT_GENERATION] = self.generation
        if fence:
            fence()
        words[lock] = 2 * number + 2
        if fence:
            fence()
        words[layout.HEAD] = number
        if fence:
            fence()
        words[layout.FUTEX] = number & _LOW
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
        count = len(octets) if count is None else count
        start, size = self.log_end, len(self._log)
        if not 0 <= count <= min(len(octets), size):
            raise InputError(
                f"count is {count}, expected 0 to {min(len(octets), size)} bytes: a batch must fit "
                "into its array and into the log"
            )
        end, at = start + count, start & (size - 1)
        words, fence = self._words, self._fence
        if end > self._reserved:  # not so after a writer died in the middle of a batch
            words[layout.LOG_RESERVED] = self._reserved = end
        if fence:
            fence()
        first = min(count, size - at)
        self._log[at : at + first] = octets[:first]
        if first < count:
            self._log[: count - first] = octets[first:count]
        if fence:
            fence()
        words[layout.LOG_END] = self.log_end = end
        segment = end >> self._shift
        if segment != start >> self._shift:
            if fence:
                fence()
            words[layout.MARK + segment % layout.MARKS] = end
        return end

    def heartbeat(self, now_ns: int) -> None:
        """Say that the writer is at work.

        Parameters
        ----------
        now_ns : int, ns
            Of `time.monotonic_ns`.
        """
        self._words[layout.HEARTBEAT] = now_ns

    def set_state(self, state: State) -> None:
        """Say what the writer is doing, and wake those who wait."""
        self._words[layout.WRITER] = os.getpid() | int(state) << 32
        self._signal.wake()

    @property
    def number(self) -> int:
        """Of the newest complete slot, 0 before the first."""
        return self._number - self._begun

    @property
    def state(self) -> State:
        """What the writer last said that it was doing."""
        return State(self._words[layout.WRITER] >> 32)

    def unlink(self) -> None:
        """Take the file's name away; who has it open keeps it."""
        if self._descriptor >= 0 and files.same(self._descriptor, self.path):
            self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Stop writing; the file stays, for `reopen` or for who looks at what was last.

        Arrays that were handed out must not be written any more.
        """
        if self._descriptor < 0:
            return
        if self.state != State.FAILED:
            self.set_state(State.STOPPED)
        files.unlock(self._descriptor)
        os.close(self._descriptor)
        self._descriptor = -1
        self._slots, self.status, self._log = [], {}, np.zeros(0, np.uint8)
        self._words.release()
        with contextlib.suppress(BufferError):  # arrays of it are still held elsewhere
            self._memory.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is not None and self._descriptor >= 0:
            self.set_state(State.FAILED)
        self.close()

    @staticmethod
    def names(folder: Path | None = None) -> tuple[Present, ...]:
        """Rings that are there, with the state of their writers; damaged ones too."""
        return present(folder)

    @staticmethod
    def remove(name: str, folder: Path | None = None) -> None:
        """Delete a ring whose writer has ended; nothing happens if there is none.

        Raises
        ------
        InputError
            If a living process writes it.
        """
        path = files.path_of(name, folder)
        for held in _claimed(path):
            path.unlink(missing_ok=True)
            os.close(held)


def _claimed(path: Path) -> list[int]:
    """Descriptors of the locked file of that name: one, or none if there is no such file."""
    if not path.exists():
        return []
    descriptor = files.open_ring(path, write=True)
    if not files.lock(descriptor):
        os.close(descriptor)
        raise InputError(_taken(path))
    return [descriptor]


def _taken(path: Path) -> str:
    who = [each for each in present(path.parent) if each.path == path]
    text = f" (process {who[0].pid})" if who and who[0].pid else ""
    return (
        f"{path} is written by a living process{text}, expected none: stop that one first, or "
        "take another name"
    )


def _notes(path: Path, signal: system.Futex | system.Polling) -> tuple[str, ...]:
    notes = []
    if path.parent != files.SHARED:
        notes.append(f"The ring is in {path.parent}, which may be on a disk.")
    if isinstance(signal, system.Polling):
        notes.append(
            "This system has no futex that processes share: readers look every "
            f"{system.POLL * 1e6:g} µs."
        )
    return tuple(notes)
