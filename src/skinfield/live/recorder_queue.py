"""What waits between the thread that reads the ring and the one that writes the file."""

import threading
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

from skinfield.acquisition.recorded import Enclosed
from skinfield.sinks.mcap import RecordingWriter
from skinfield.sinks.mcap.views import ViewMessage


class Entry(NamedTuple):
    """Something to be written; `put` hands it to a writer.

    Attributes
    ----------
    time_ns : int, ns
        Since the epoch.
    position : int, bytes
        Of blocks in the log; -1 for a cycle.
    data : bytes
    """

    time_ns: int
    position: int
    data: bytes

    def put(self, writer: RecordingWriter) -> None:
        """Write it."""
        if self.position < 0:
            writer.write_cycle(self.time_ns, self.data)
        else:
            writer.write_blocks(self.time_ns, self.position, self.data)


class Told(NamedTuple):
    """An event or a second's timing: never dropped."""

    time_ns: int
    kind: str
    text: str
    values: dict[str, object]

    def put(self, writer: RecordingWriter) -> None:
        """Write it."""
        if self.kind == "timing":
            writer.timing(self.time_ns, self.values)
        else:
            writer.event(self.time_ns, self.kind, self.text, **self.values)


class Attached(NamedTuple):
    """A small file that is enclosed while recording: never dropped."""

    time_ns: int
    enclosed: Enclosed

    def put(self, writer: RecordingWriter) -> None:
        """Write it."""
        writer.enclose(self.time_ns, self.enclosed)


class Shown(NamedTuple):
    """A message for other programs: dropped first, and not missed."""

    time_ns: int
    message: ViewMessage

    def put(self, writer: RecordingWriter) -> None:
        """Write it."""
        writer.show(self.message)


class Beside(NamedTuple):
    """An answer of the fit beside the engine: left out where the disk does not keep up."""

    time_ns: int
    data: bytes

    def put(self, writer: RecordingWriter) -> None:
        """Write it."""
        writer.write_fit(self.time_ns, self.data)


Item = Entry | Told | Attached | Shown | Beside


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

    def add(self, entry: Entry) -> None:
        """Count one."""
        if entry.position < 0:
            self.cycles += 1
        else:
            self.bytes += len(entry.data)
        self.since_ns = self.since_ns or entry.time_ns
        self.until_ns = entry.time_ns


class Queue:
    """Bounded: whoever puts never waits, but loses what does not fit.

    Parameters
    ----------
    most : int, bytes

    Attributes
    ----------
    dropped : Dropped
        Since `take_dropped`.
    dropped_bytes, dropped_cycles : int
        In all.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._entries: deque[Item] = deque()
        self._bytes = 0
        self._ready = threading.Condition()
        self._ended = False
        self.dropped = Dropped()
        self.dropped_bytes = self.dropped_cycles = 0

    @property
    def waiting(self) -> int:
        """Bytes in it."""
        return self._bytes

    @property
    def oldest_ns(self) -> int:
        """When its oldest entry came, ns since the epoch; 0 if it is empty."""
        with self._ready:
            return self._entries[0].time_ns if self._entries else 0

    def put(self, entry: Entry) -> bool:
        """Append, if it fits.

        Once something did not fit, nothing more does until half of the room is free again: a few
        long gaps can be told and understood, thousands of short ones cannot.
        """
        with self._ready:
            room = self._most // 2 if self.dropped.since_ns else self._most
            if self._bytes + len(entry.data) > room:
                self.dropped.add(entry)
                self.dropped_bytes += len(entry.data) if entry.position >= 0 else 0
                self.dropped_cycles += entry.position < 0
                return False
            if self.dropped.since_ns:
                self._tell_dropped()
            self._entries.append(entry)
            self._bytes += len(entry.data)
            self._ready.notify()
            return True

    def tell(self, told: Told | Attached) -> None:
        """Append something that is always kept."""
        with self._ready:
            self._entries.append(told)
            self._ready.notify()

    def show(self, shown: Shown) -> None:
        """Append something that is only shown, if there is plenty of room."""
        with self._ready:
            if self._bytes + len(shown.message.data) < self._most // 4:
                self._entries.append(shown)
                self._bytes += len(shown.message.data)

    def offer(self, beside: Beside) -> bool:
        """Append something that comes after all readings, if there is room enough for those."""
        with self._ready:
            if self.dropped.since_ns or self._bytes + len(beside.data) > self._most // 2:
                return False
            self._entries.append(beside)
            self._bytes += len(beside.data)
            return True

    def take(self, timeout: float) -> list[Item]:
        """Everything that is there, as soon as there is something; empty after `timeout` s."""
        with self._ready:
            if not self._entries and not self._ended:
                self._ready.wait(timeout)
            found = list(self._entries)
            self._entries.clear()
            self._bytes = 0
            return found

    def end(self) -> None:
        """Say that nothing more comes."""
        with self._ready:
            if self.dropped.since_ns:
                self._tell_dropped()
            self._ended = True
            self._ready.notify()

    @property
    def ended(self) -> bool:
        """Whether nothing more comes; something may still be there."""
        return self._ended

    def _tell_dropped(self) -> None:
        """Leave a word where the gap is."""
        lost, self.dropped = self.dropped, Dropped()
        text = (
            f"the disk did not keep up: {lost.bytes} bytes of readings and {lost.cycles} cycles "
            "were dropped"
        )
        values: dict[str, object] = dict(vars(lost))
        self._entries.append(Told(lost.until_ns, "dropped", text, values))
