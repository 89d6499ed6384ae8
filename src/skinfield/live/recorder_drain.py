"""Takes everything new out of a ring, and counts what it came too late for."""

import time
from collections import Counter

from skinfield.acquisition.block import Kind
from skinfield.acquisition.recorded import CycleLayout
from skinfield.live.recorder_fit import fit_drain_of
from skinfield.live.recorder_kernel import told_in
from skinfield.live.recorder_place import Place, place_now
from skinfield.live.recorder_queue import Entry, Queue, Shown, Told
from skinfield.live.recorder_views import Shower
from skinfield.live.slots import Slot
from skinfield.ring import RingReader

PIECE = 1 << 20  # bytes of the log in one message, about


class Drain:
    """Reads the log and the slots of a ring into a queue.

    Parameters
    ----------
    reader : RingReader
    queue : Queue
    layout : CycleLayout
    sources : sequence of str
        Names of the sources, for what is told of them.
    shower : Shower
    begin : Place, optional
        By default now.

    Attributes
    ----------
    bytes_read, cycles : int
    overrun_bytes, overrun_cycles : int
        That the ring had overwritten.
    """

    def __init__(
        self,
        reader: RingReader,
        queue: Queue,
        layout: CycleLayout,
        sources: list[str],
        shower: Shower,
        begin: Place | None = None,
    ) -> None:
        self._shower = shower
        self._reader, self._queue, self._layout, self._sources = reader, queue, layout, sources
        told_in(b"")  # loads what is compiled: the ring would not wait for it later
        self._number, position, _ = begin or place_now(reader)
        self._log = reader.log_reader(position)
        self._slot = reader.slot()
        self._cycle = Slot.of(self._slot.arrays)
        self.generation = reader.generation
        self.bytes_read = self.cycles = self.overrun_bytes = self.overrun_cycles = 0
        queue.put(Entry(time.time_ns(), self._log.position, b""))
        self._first = self._log.position
        self.fit = fit_drain_of(reader, queue)
        self._lost: Counter[int] = Counter()

    def take(self) -> None:
        """Take all that is new."""
        head = self._reader.number
        self._take_log()
        missing: list[int] = []
        for number in range(self._number + 1, head + 1):
            slot = self._reader.get(number, self._slot)
            if slot is None:
                missing.append(number)
                continue
            cycle = self._cycle.recorded(number)
            if cycle.log_position >= self._first:
                self._queue.put(Entry(cycle.wall_ns, -1, self._layout.encode(cycle)))
                self.cycles += 1
                if self._shower.due(cycle.wall_ns):
                    self._show(cycle.wall_ns)
        self._number = max(head, self._number)
        if missing:
            self._tell_missing(missing)
        if self._reader.generation != self.generation:
            self._restarted()
        self.fit.take()

    def close(self) -> None:
        """Let go of the fit's ring; the engine's is the caller's."""
        self.fit.close()

    def _show(self, time_ns: int) -> None:
        for message in self._shower.messages(time_ns, self._cycle):
            self._queue.show(Shown(time_ns, message))

    def _take_log(self) -> None:
        while True:
            data, lost = self._log.read(PIECE)
            now = time.time_ns()
            if lost:
                self.overrun_bytes += lost
                text = f"the ring came round: {lost} bytes of readings were overwritten unread"
                values: dict[str, object] = {"bytes": lost, "position": self._log.position}
                self._queue.tell(Told(now, "log_overrun", text, values))
            if not data:
                return
            self._queue.put(Entry(now, self._log.position - len(data), data))
            self.bytes_read += len(data)
            self._tell_sources(data)

    def _tell_missing(self, missing: list[int]) -> None:
        self.overrun_cycles += len(missing)
        text = f"the ring came round: {len(missing)} cycles were overwritten unread"
        values: dict[str, object] = {
            "cycles": len(missing),
            "first": missing[0],
            "last": missing[-1],
        }
        self._queue.tell(Told(time.time_ns(), "cycle_overrun", text, values))

    def _tell_sources(self, data: bytes) -> None:
        for stamp, source, kind, number in told_in(data):
            if kind == Kind.LOST:
                self._lost[source] += number
                continue
            text = f"{self._name(source)} is {'connected' if number else 'gone'}"
            what = "source_up" if number else "source_down"
            self._queue.tell(Told(stamp, what, text, {"source": source}))

    def tell_lost(self) -> None:
        """Tell what was lost since the last call: answers of the fit, and messages of a bad bus."""
        self.fit.tell_missed()
        for source, number in self._lost.items():
            text = f"{self._name(source)}: {number} messages were lost"
            values: dict[str, object] = {"source": source, "messages": number}
            self._queue.tell(Told(time.time_ns(), "messages_lost", text, values))
        self._lost.clear()

    def _name(self, source: int) -> str:
        return self._sources[source] if source < len(self._sources) else f"source {source}"

    def _restarted(self) -> None:
        before, self.generation = self.generation, self._reader.generation
        text = f"the engine was started again: process {self._reader.pid} goes on with the ring"
        values: dict[str, object] = {
            "generation": self.generation,
            "before": before,
            "pid": self._reader.pid,
        }
        self._queue.tell(Told(time.time_ns(), "engine_restarted", text, values))
