"""The thread that writes: it may wait for the disk as long as the disk likes."""

import threading
import time
from dataclasses import dataclass

from skinfield.errors import FileError
from skinfield.live.recorder_queue import Item, Queue, Told
from skinfield.sinks.mcap import RecordingWriter

RETRY = 0.2  # s between attempts to write to a disk that refuses
LAST_CHANCE = 1.0  # s that a full disk gets at the end
SLOW = 0.5  # s that one write or sync may take before it is told


@dataclass
class DiskState:
    """What others may know of it.

    Attributes
    ----------
    failing_since : float, s
        Monotonic time; 0 while writing works.
    failure : str
        What the system said last.
    failures : int
        Times that it began to fail.
    last_flush, last_sync : float, s
        Monotonic time.
    longest : float, s
        That one write or sync took.
    lost : int
        Messages that were given up at the end.
    finished : bool
        Whether the file has its end.
    """

    failing_since: float = 0.0
    failure: str = ""
    failures: int = 0
    last_flush: float = 0.0
    last_sync: float = 0.0
    longest: float = 0.0
    lost: int = 0
    finished: bool = False


class Disk(threading.Thread):
    """Takes from the queue, writes, flushes and syncs in time, and closes the file at the end.

    Parameters
    ----------
    writer : RecordingWriter
    queue : Queue
    flush, sync : float, s

    Attributes
    ----------
    state : DiskState
    """

    def __init__(self, writer: RecordingWriter, queue: Queue, flush: float, sync: float) -> None:
        super().__init__(name="disk", daemon=True)
        self._writer, self._queue, self._flush_every, self._sync_every = writer, queue, flush, sync
        now = time.monotonic()
        self.state = DiskState(last_flush=now, last_sync=now)
        self._slow_told = 0.0
        self._crash: BaseException | None = None

    def run(self) -> None:
        """Work until the queue has ended."""
        try:
            while not self._queue.ended:
                self._round()
            self._finish()
        except BaseException as error:
            self._crash = error

    def stop(self) -> None:
        """Wait for its end; raises what went wrong with it."""
        self._queue.end()
        self.join()
        if self._crash is not None:
            raise self._crash

    @property
    def crashed(self) -> bool:
        """Whether it ended too early."""
        return self._crash is not None

    def _round(self) -> None:
        """Write what came, unless the disk refuses: then what comes waits in the queue."""
        state = self.state
        if state.failing_since:
            time.sleep(RETRY)
        else:
            due = state.last_flush + self._flush_every - time.monotonic()
            self._put_all(max(due, 0.0))
        if state.failing_since or time.monotonic() - state.last_flush >= self._flush_every:
            self._flush()
        if not state.failing_since and time.monotonic() - state.last_sync >= self._sync_every:
            self._sync()

    def _put_all(self, timeout: float) -> None:
        for entry in self._queue.take(timeout):
            self._put(entry)

    def _put(self, entry: Item) -> None:
        try:
            entry.put(self._writer)
        except FileError as error:  # it waits in the writer
            self._failed(error)

    def _flush(self) -> None:
        began = time.monotonic()
        try:
            self._writer.flush()
        except FileError as error:
            self._failed(error)
            return
        self._took(began, "write")
        if self.state.failing_since:
            self._works_again()
        self.state.last_flush = time.monotonic()

    def _sync(self) -> None:
        began = time.monotonic()
        try:
            self._writer.sync()
        except FileError as error:
            self._failed(error)
            return
        self._took(began, "sync")
        self.state.last_sync = time.monotonic()

    def _failed(self, error: FileError) -> None:
        state = self.state
        state.failure = str(error)
        if not state.failing_since:
            state.failing_since = time.monotonic()
            state.failures += 1

    def _works_again(self) -> None:
        state = self.state
        seconds = time.monotonic() - state.failing_since
        state.failing_since = 0.0
        text = f"nothing could be written for {seconds:.1f} s ({state.failure}); now it works again"
        self._put(Told(time.time_ns(), "disk_failed", text, {"seconds": round(seconds, 3)}))

    def _took(self, began: float, what: str) -> None:
        took = time.monotonic() - began
        self.state.longest = max(self.state.longest, took)
        if took > SLOW and began - self._slow_told > 1.0:
            self._slow_told = began
            text = f"a {what} took {took:.1f} s: the disk is slow"
            self._put(Told(time.time_ns(), "disk_slow", text, {"seconds": round(took, 3)}))

    def _give_up(self) -> None:
        """Let go of what cannot be written; a word about it may still fit."""
        self.state.lost = sum(self._writer.container.give_up_waiting().values())
        text = f"{self.state.lost} messages could not be written at the end: {self.state.failure}"
        self._put(Told(time.time_ns(), "given_up", text, {"messages": self.state.lost}))
        try:
            self._writer.flush()
        except FileError:
            self._writer.container.give_up_waiting()

    def _finish(self) -> None:
        """Close the file; a disk that is still full gets a last chance, then data is given up."""
        end = time.monotonic() + LAST_CHANCE
        self._put_all(0.0)
        self._flush()
        while self.state.failing_since and time.monotonic() < end:
            time.sleep(RETRY)
            self._flush()
        if self.state.failing_since:
            self._give_up()
        try:
            self._writer.close()
            self.state.finished = True
        except FileError as error:
            self._failed(error)
