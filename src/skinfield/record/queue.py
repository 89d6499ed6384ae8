"""Queue of a recorder, and the thread that writes: it may wait for the disk as long as it likes."""

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from skinfield.errors import FileError
from skinfield.files.mcap import RecordingWriter
from skinfield.record.state import RecorderState

FLUSH = 0.15  # s after which what was read is handed to the system, and survives a `kill -9`
SYNC = 1.5  # s after which it is on the disk, and survives power loss
RETRY = 0.2  # s between attempts to write to a disk that refuses
LAST_CHANCE = 1.0  # s that a full disk gets at the end
SLOW = 0.5  # s that one write or sync may take before it is told


class Item(NamedTuple):
    """Something to be written.

    Attributes
    ----------
    time_ns : int, ns
        Since the epoch.
    size : int, bytes
    write : function of the writer
    cycle : bool
        Whether it is a cycle; other readings are counted in bytes where they are dropped.
    """

    time_ns: int
    size: int
    write: Callable[[RecordingWriter], None]
    cycle: bool = False


def event_item(time_ns: int, kind: str, text: str, values: dict[str, object]) -> Item:
    """An event, see `RecordingWriter.event`."""
    return Item(time_ns, 0, lambda writer: writer.event(time_ns, kind, text, **values))


@dataclass
class Dropped:
    """What did not fit, since it was last told.

    Attributes
    ----------
    bytes, cycles : int
    since_ns, until_ns : int, ns
    """

    bytes: int = 0
    cycles: int = 0
    since_ns: int = 0
    until_ns: int = 0

    def add(self, item: Item) -> None:
        """Count one."""
        self.cycles += item.cycle
        self.bytes += 0 if item.cycle else item.size
        self.since_ns = self.since_ns or item.time_ns
        self.until_ns = item.time_ns


class Queue:
    """Bounded: whoever puts never waits, but loses what does not fit.

    Parameters
    ----------
    most : int, bytes
    state : RecorderState
        Counts what is dropped.

    Attributes
    ----------
    waiting : int, bytes
        In it.
    ended : bool
        Whether nothing more comes; something may still be there.
    """

    def __init__(self, most: int, state: RecorderState) -> None:
        self._most, self.state = most, state
        self._items: deque[Item] = deque()
        self.waiting, self.ended = 0, False
        self._ready = threading.Condition()
        self._dropped = Dropped()

    @property
    def oldest_ns(self) -> int:
        """When its oldest item came, ns since the epoch; 0 if it is empty."""
        with self._ready:
            return self._items[0].time_ns if self._items else 0

    def put(self, item: Item) -> bool:
        """Append readings or a cycle, if they fit.

        Once something did not fit, nothing more does until half of the room is free again: a few
        long gaps can be told and understood, thousands of short ones cannot.
        """
        with self._ready:
            room = self._most // 2 if self._dropped.since_ns else self._most
            if self.waiting + item.size > room:
                self._dropped.add(item)
                self.state.dropped_bytes += 0 if item.cycle else item.size
                self.state.dropped_cycles += item.cycle
                return False
            if self._dropped.since_ns:
                self._tell_dropped()
            self._items.append(item)
            self.waiting += item.size
            self._ready.notify()
            return True

    def tell(self, item: Item) -> None:
        """Append an event, a second's timing or a small file: always kept."""
        with self._ready:
            self._items.append(item)
            self._ready.notify()

    def event(self, kind: str, text: str, /, **values: object) -> None:
        """Append something that happens now."""
        self.tell(event_item(time.time_ns(), kind, text, values))

    def offer(self, item: Item) -> bool:
        """Append something that comes after all readings, if there is room enough for those."""
        with self._ready:
            if self._dropped.since_ns or self.waiting + item.size > self._most // 2:
                return False
            self._items.append(item)
            self.waiting += item.size
            return True

    def take(self, timeout: float) -> list[Item]:
        """Everything that is there, as soon as there is something; empty after `timeout` s."""
        with self._ready:
            if not self._items and not self.ended:
                self._ready.wait(timeout)
            found = list(self._items)
            self._items.clear()
            self.waiting = 0
            return found

    def end(self) -> None:
        """Say that nothing more comes."""
        with self._ready:
            if self._dropped.since_ns:
                self._tell_dropped()
            self.ended = True
            self._ready.notify()

    def _tell_dropped(self) -> None:
        """Leave a word where the gap is."""
        lost, self._dropped = self._dropped, Dropped()
        text = (
            f"the disk did not keep up: {lost.bytes} bytes of readings and {lost.cycles} cycles "
            "were dropped"
        )
        values: dict[str, object] = dict(vars(lost))
        self._items.append(event_item(lost.until_ns, "dropped", text, values))


class Disk(threading.Thread):
    """Takes from the queue, writes, flushes and syncs in time, and closes the file at the end.

    Parameters
    ----------
    writer : RecordingWriter
    queue : Queue

    Attributes
    ----------
    failing_since : float, s
        Monotonic time; 0 while writing works.
    last_flush, last_sync : float, s
        Monotonic time.
    crash : BaseException or None
        Why it ended too early.
    """

    def __init__(self, writer: RecordingWriter, queue: Queue) -> None:
        super().__init__(name="disk", daemon=True)
        self._writer, self._queue = writer, queue
        now = time.monotonic()
        self._state, self.failing_since = queue.state, 0.0
        self.last_flush = self.last_sync = now
        self._slow_told = 0.0
        self.crash: BaseException | None = None

    def run(self) -> None:
        """Work until the queue has ended."""
        try:
            while not self._queue.ended:
                self._round()
            self._finish()
        except BaseException as error:
            self.crash = error

    def stop(self) -> None:
        """Wait for its end; raises what went wrong with it."""
        self._queue.end()
        self.join()
        if self.crash is not None:
            raise self.crash

    def _round(self) -> None:
        """Write what came, unless the disk refuses: then what comes waits in the queue."""
        if self.failing_since:
            time.sleep(RETRY)
        else:
            due = self.last_flush + FLUSH - time.monotonic()
            self._put_all(max(due, 0.0))
        if self.failing_since or time.monotonic() - self.last_flush >= FLUSH:
            self._flush()
        if not self.failing_since and time.monotonic() - self.last_sync >= SYNC:
            self._sync()

    def _put_all(self, timeout: float) -> None:
        for item in self._queue.take(timeout):
            self._put(item)

    def _put(self, item: Item) -> None:
        try:
            item.write(self._writer)
        except FileError as error:  # it waits in the writer
            self._failed(error)

    def _event(self, kind: str, text: str, **values: object) -> None:
        self._put(event_item(time.time_ns(), kind, text, values))

    def _hand_over(self, what: str, write: Callable[[], None]) -> bool:
        """Flush or sync; False if the disk refuses."""
        began = time.monotonic()
        try:
            write()
        except FileError as error:
            self._failed(error)
            return False
        took = time.monotonic() - began
        self._state.longest = max(self._state.longest, took)
        if took > SLOW and began - self._slow_told > 1.0:
            self._slow_told = began
            text = f"a {what} took {took:.1f} s: the disk is slow"
            self._event("disk_slow", text, seconds=round(took, 3))
        return True

    def _flush(self) -> None:
        if not self._hand_over("write", self._writer.flush):
            return
        now = time.monotonic()
        if self.failing_since:
            seconds, self.failing_since = now - self.failing_since, 0.0
            why = f"for {seconds:.1f} s ({self._state.failure})"
            text = f"nothing could be written {why}; now it works again"
            self._event("disk_failed", text, seconds=round(seconds, 3))
        self.last_flush = now

    def _sync(self) -> None:
        if self._hand_over("sync", self._writer.sync):
            self.last_sync = time.monotonic()

    def _failed(self, error: FileError) -> None:
        self._state.failure = str(error)
        self.failing_since = self.failing_since or time.monotonic()

    def _give_up(self) -> None:
        """Let go of what cannot be written; a word about it may still fit."""
        state = self._state
        state.given_up = self._writer.container.give_up_waiting().total()
        text = f"{state.given_up} messages could not be written at the end: {state.failure}"
        self._event("given_up", text, messages=state.given_up)
        try:
            self._writer.flush()
        except FileError:
            self._writer.container.give_up_waiting()

    def _finish(self) -> None:
        """Close the file; a disk that is still full gets a last chance, then data is given up."""
        end = time.monotonic() + LAST_CHANCE
        self._put_all(0.0)
        self._flush()
        while self.failing_since and time.monotonic() < end:
            time.sleep(RETRY)
            self._flush()
        if self.failing_since:
            self._give_up()
        try:
            self._writer.close()
            self._state.finished = True
        except FileError as error:
            self._failed(error)
