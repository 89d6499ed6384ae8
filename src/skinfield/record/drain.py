"""Drain of a ring into a recorder's queue: readings, cycles, fields, settings, events."""

import contextlib
import io
import time
from collections import Counter
from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, SkinfieldError
from skinfield.files.mcap import RecordingWriter, enclosures
from skinfield.files.mcap.schema import (
    CONFIGURATION,
    CYCLES,
    FIELDS,
    TARE,
    Enclosed,
    FieldRecord,
)
from skinfield.loop.model_config import FIELD as SETTINGS
from skinfield.loop.model_config import ModelConfig, configuration_of
from skinfield.loop.slots import LAYOUT as CYCLE
from skinfield.loop.slots import CycleHead, CycleSlot
from skinfield.loop.status import Observer
from skinfield.loop.status_text import HEAD as CHECKED
from skinfield.record.queue import Item, Queue, event_item
from skinfield.ring import RingReader, State
from skinfield.signal import Calibration
from skinfield.signal.block import HEADER, WORD, Kind, block_bytes

SILENT = 1.0  # s without a sign of life of the engine until it is told
JSON, NPZ = "application/json", "application/x-npz"
Array = NDArray[Any]


def enclosed_of(reader: RingReader, model_config: ModelConfig) -> tuple[Enclosed, ...]:
    """Everything that makes the recording self-contained."""
    description, status = dict(reader.description), reader.status
    configuration = Enclosed(CONFIGURATION, JSON, description.pop("model_config").encode())
    calibrated = calibration_of(model_config, status) if int(status["tares"][0]) > 0 else ()
    return (*enclosures(model_config.skin, description=description), configuration, *calibrated)


def calibration_of(model_config: ModelConfig, status: dict[str, Array]) -> Iterator[Enclosed]:
    """The engine's calibration, patch by patch and as it is in the ring's status."""
    calibrations, start, unit = {}, 0, model_config.binding.unit
    for patch in model_config.skin:
        rows = status["calibration"][start : start + len(patch)]
        baseline, gain, noise_std, alive = rows.T.copy()
        start += len(patch)
        with contextlib.suppress(InputError):  # a patch that never answered has no baseline
            known = baseline, gain, noise_std, alive > 0, patch.uid
            calibrations[patch.name] = Calibration(*known, patch_name=patch.name, unit=unit)
    yield from enclosures(calibrations=calibrations)
    buffer = io.BytesIO()
    names = ("calibration", "noise_std", "stale_ns", "tares")
    np.savez(buffer, allow_pickle=False, **{name: status[name] for name in names})
    yield Enclosed(TARE.format(number=int(status["tares"][0])), NPZ, buffer.getvalue())


class StatusWatch:
    """Looks at a ring once a second.

    Parameters
    ----------
    reader : RingReader
    queue : Queue
    model_config : ModelConfig
    tares : int
        Calibrations so far that are enclosed already.
    """

    def __init__(
        self, reader: RingReader, queue: Queue, model_config: ModelConfig, tares: int
    ) -> None:
        self._reader, self._queue, self._tares = reader, queue, tares
        self._model_config = model_config
        self._observer = Observer(reader)
        self._observer.look()  # loads what it needs: later the ring would not wait
        self._state: State | None = reader.state
        self._silent = False

    def look(self) -> None:
        """Tell the last second's timing, and what has changed."""
        now, status, found = time.time_ns(), self._reader.status, self._observer.look()
        values = {**found.lately.as_dict(), "counters": list(found.sources.values())}
        self._queue.tell(Item(now, 0, lambda writer: writer.timing(now, values)))
        if int(status["tares"][0]) != self._tares:
            self._tares = int(status["tares"][0])
            for each in calibration_of(self._model_config, status):
                enclose = partial(RecordingWriter.enclose, time_ns=now, enclosed=each)
                self._queue.tell(Item(now, 0, enclose))
            self._queue.event("calibrated", "the baseline was taken anew", tares=self._tares)
        self._engine()

    def _engine(self) -> None:
        try:
            state: State | None = self._reader.state
        except SkinfieldError:
            state = None
        if state != self._state and state is not None:
            text = f"the engine is {state.name.lower()}"
            self._queue.event("engine_state", text, state=state.name)
        self._state = state
        age = (time.monotonic_ns() - self._reader.heartbeat_ns) * 1e-9
        silent = age > SILENT and state in (State.RUNNING, State.CALIBRATING)
        if silent and not self._silent:
            text = f"no sign of life of the engine for {age:.1f} s"
            self._queue.event("engine_silent", text, seconds=age)
        elif self._silent and not silent:
            self._queue.event("engine_back", "the engine gives signs of life again")
        self._silent = silent


PIECE = 1 << 20  # bytes of the log in one message, about
SPARE = 4  # a fourth of the slots, which the engine may write while the others are taken


class RecordedPosition(NamedTuple):
    """The cycles after `number` are recorded, and the log from `position` on.

    Attributes
    ----------
    number : int
    position : int, bytes
        Of the log, with all readings of the first cycle behind it.
    """

    number: int
    position: int


def place_since(reader: RingReader, since_ns: int) -> RecordedPosition:
    """Before the last cycle that was not after a time, or as far back as the ring goes.

    Parameters
    ----------
    reader : RingReader
    since_ns : int, ns
        Since the epoch; 0: now.

    Returns
    -------
    Place
        Behind the newest cycle if readings since then are not there any more; of an engine that
        starts, before all that is there.
    """
    newest = reader.number  # before the log's end is looked at: no cycle without its readings
    found = now = RecordedPosition(newest, reader.log_end if newest else 0)
    if not since_ns:
        return now
    slot, wall_ns = reader.slot(), 0
    oldest = newest - reader.slots + reader.slots // SPARE
    for number in range(newest, max(oldest, 0), -1):
        if not reader.part(number, slot, ("head",)):
            break
        found = RecordedPosition(number, int(slot["head"][CycleHead.LOG_POSITION]))
        if wall_ns and wall_ns <= since_ns:
            break
        wall_ns = int(slot["head"][CycleHead.WALL_NS])
    _, lost = reader.log_reader(found.position).read()
    return now if lost else found


def source_blocks(data: bytes) -> Iterator[tuple[int, int, int, int]]:
    """Stamp, source, kind and number of each block of SOURCE and LOST, of blocks of a log."""
    words, at = memoryview(data).cast("B").cast("q"), 0
    while at + HEADER // WORD < len(words):
        second = words[at + 1]
        kind, count = second >> 48 & 0xFF, second >> 32 & 0xFFFF
        if kind in (Kind.SOURCE, Kind.LOST):
            yield words[at], second & 0xFFFFFFFF, kind, words[at + 2]
        try:
            at += block_bytes(kind, count) // WORD
        except InputError:  # what follows is damaged
            return


class Drain:
    """Reads the log and the slots of a ring into a queue.

    Parameters
    ----------
    reader : RingReader
    queue : Queue
    model_config : ModelConfig
    view_rate : float, 1/s
        Of pressure fields.
    begin : RecordedPosition
    """

    def __init__(
        self,
        reader: RingReader,
        queue: Queue,
        model_config: ModelConfig,
        view_rate: float,
        begin: RecordedPosition,
    ) -> None:
        self._reader, self._queue = reader, queue
        self._sources = [str(each) for each in reader.description.get("sources", [])]
        self._every, self._shown = int(1e9 / view_rate), 0
        self._number = begin.number
        self._log = reader.log_reader(begin.position)
        self._slot = reader.slot()
        self._cycle = CycleSlot.of(self._slot.arrays)
        self.generation = reader.generation
        self._state = queue.state
        self._put_blocks(time.time_ns(), self._log.position, b"")
        self._first = self._log.position
        self._settings = b""
        self._lost: Counter[int] = Counter()

    def take(self) -> None:
        """Take all that is new."""
        head = self._reader.number
        self._take_log()
        self._take_settings(head)
        missing: list[int] = []
        for number in range(self._number + 1, head + 1):
            slot = self._reader.get(number, self._slot)
            if slot is None:
                missing.append(number)
                continue
            cycle = self._cycle.recorded(number)
            if cycle.log_position >= self._first:
                data = CYCLE.encode(cycle)
                now = cycle.wall_ns
                write = partial(RecordingWriter.write, topic=CYCLES, time_ns=now, data=data)
                self._queue.put(Item(now, len(data), write, cycle=True))
                self._state.cycles += 1
                due = not 0 <= cycle.wall_ns - self._shown < self._every
                if due and self._cycle.head[CycleHead.FRESH]:
                    self._show(number, cycle.wall_ns)
        self._number = max(head, self._number)
        if missing:
            self._tell_missing(missing)
        if self._reader.generation != self.generation:
            self._restarted()

    def _show(self, number: int, time_ns: int) -> None:
        """Offer what the cycle read, and its pressure."""
        self._shown, slot = time_ns, self._cycle
        taxels = slot.counts.copy(), slot.values.copy(), slot.valid.copy()
        sides = np.maximum(slot.patches["rung"], 0)
        data = FieldRecord.of(number, time_ns, sides, slot.pressure, taxels).encode()
        write = partial(RecordingWriter.write, topic=FIELDS, time_ns=time_ns, data=data)
        self._queue.offer(Item(time_ns, len(data), write))

    def _take_settings(self, number: int) -> None:
        """Tell which settings are in force, where they are others than before."""
        now = self._reader.status_view[SETTINGS.name][:CHECKED].tobytes()
        if now == self._settings:
            return
        configuration = configuration_of(self._reader)
        if configuration is None:
            return  # it is being written: the next look sees it
        self._settings = now
        text = f"settings that are in force from cycle {number + 1} on"
        self._queue.event("settings", text, cycle=number + 1, **configuration.as_dict())

    def _put_blocks(self, time_ns: int, position: int, data: bytes) -> None:
        write = partial(RecordingWriter.write_blocks, time_ns=time_ns, position=position, data=data)
        self._queue.put(Item(time_ns, len(data), write))

    def _take_log(self) -> None:
        while True:
            data, lost = self._log.read(PIECE)
            now = time.time_ns()
            if lost:
                self._state.overrun_bytes += lost
                text = f"the ring came round: {lost} bytes of readings were overwritten unread"
                self._queue.event("log_overrun", text, bytes=lost, position=self._log.position)
            if not data:
                return
            self._put_blocks(now, self._log.position - len(data), data)
            self._state.bytes_read += len(data)
            self._tell_sources(data)

    def _tell_missing(self, missing: list[int]) -> None:
        self._state.overrun_cycles += len(missing)
        text = f"the ring came round: {len(missing)} cycles were overwritten unread"
        first, last = missing[0], missing[-1]
        self._queue.event("cycle_overrun", text, cycles=len(missing), first=first, last=last)

    def _tell_sources(self, data: bytes) -> None:
        for stamp, source, kind, number in source_blocks(data):
            if kind == Kind.LOST:
                self._lost[source] += number
                continue
            text = f"{self._name(source)} is {'connected' if number else 'gone'}"
            what = "source_up" if number else "source_down"
            self._queue.tell(event_item(stamp, what, text, {"source": source}))

    def tell_lost(self) -> None:
        """Tell the messages of a bad bus that were lost since the last call."""
        for source, number in self._lost.items():
            text = f"{self._name(source)}: {number} messages were lost"
            self._queue.event("messages_lost", text, source=source, messages=number)
        self._lost.clear()

    def _name(self, source: int) -> str:
        return self._sources[source] if source < len(self._sources) else f"source {source}"

    def _restarted(self) -> None:
        before, self.generation = self.generation, self._reader.generation
        pid = self._reader.pid
        text = f"the engine was started again: process {pid} goes on with the ring"
        values = {"generation": self.generation, "before": before, "pid": pid}
        self._queue.event("engine_restarted", text, **values)
