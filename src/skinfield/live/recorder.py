"""Records a running skin, from a process of its own: python -m skinfield.live.recorder.

Two threads. One takes everything new out of the ring every few milliseconds: it reads shared memory
and nothing else, so the engine never waits for it. The other writes: it may wait for the disk as
long as the disk likes, as a bounded queue lies between them. What the queue cannot hold is dropped,
counted, and told in the file, in the state beside the ring and to whoever listens.
"""

import contextlib
import math
import os
import threading
import time
from collections.abc import Callable

from skinfield.errors import InputError
from skinfield.live.control import order
from skinfield.live.fit_ring import LAYOUT as FIT
from skinfield.live.recorder_disk import Disk
from skinfield.live.recorder_drain import Drain
from skinfield.live.recorder_place import Place, load, place_now, place_since
from skinfield.live.recorder_queue import Queue, Told
from skinfield.live.recorder_settings import RecorderSettings
from skinfield.live.recorder_state import RecorderState
from skinfield.live.recorder_views import shower_of
from skinfield.live.recorder_watch import Watch, enclosed_of, layout_of
from skinfield.ring import RingReader
from skinfield.sinks.mcap import RecordingWriter
from skinfield.sinks.mcap.output import Output

PAUSE = 0.005  # s between looks at the ring
SECOND = 1.0  # s between looks at everything else
BEGINNING = 0.1  # s beyond the age at which readings are too old
LOWEST = 1  # of the real-time priorities
NICE = -10  # where that is not granted


class Recorder:
    """A recording that is going on.

    Parameters
    ----------
    settings : RecorderSettings
    say : function of a sentence
        Told what goes wrong, and when it is well again.
    output : Output, optional
        Instead of a file.
    first : bool
        Whether this thread and the one that writes shall come before ordinary work from now on,
        where that is permitted.
    rehearsal : bool
        Whether this is only to load what is needed: nobody is told, and the engine asked nothing.

    Raises
    ------
    InputError
        If there is no such ring, or the file is there already.
    FileError
        If it cannot be made.

    Attributes
    ----------
    state : RecorderState
        Made anew every second.
    """

    def __init__(
        self,
        settings: RecorderSettings,
        say: Callable[[str], None] = lambda text: None,
        output: Output | None = None,
        *,
        first: bool = False,
        rehearsal: bool = False,
    ) -> None:
        self.settings, self._say, self._rehearsal = settings, say, rehearsal
        self._reader = RingReader(settings.name)
        self._began, self._began_ns = time.monotonic(), time.time_ns()
        load()
        before = place_now(self._reader)
        layout = layout_of(self._reader)
        tares = int(self._reader.status_view["tares"][0])  # before: a new one is enclosed later
        enclosed = enclosed_of(self._reader)
        shower = shower_of(self._reader, settings)
        self._writer = RecordingWriter(
            settings.path,
            enclosed,
            layout=layout,
            fit=FIT,
            settings=settings.file,
            output=output,
            views=shower.views,
        )
        self._queue = Queue(settings.queue_bytes)
        sources = [str(each) for each in self._reader.description.get("sources", [])]
        self._watch = Watch(self._reader, self._queue, tares)
        place = self._place(before, tares)
        self._drain = Drain(self._reader, self._queue, layout, sources, shower, place)
        self._disk = Disk(self._writer, self._queue, settings.flush, settings.sync)
        self._said: dict[str, str] = {}
        self._ended = ""
        text = f"recording {settings.name} of process {self._reader.pid}"
        self._queue.tell(Told(self._began_ns, "recording_started", text, {}))
        if first:  # now, as all that must be loaded is: the other thread inherits it
            come_first()
        self._disk.start()
        self._next = self._began
        self.state = self._state()
        self._since = math.inf  # when the first cycle was there
        if place.wall_ns:
            self._since = self._began - (self._began_ns - place.wall_ns) * 1e-9
        self._ask_at = math.inf if rehearsal else self._began

    def _place(self, before: Place, tares: int) -> Place:
        """Where to begin: far enough back for a replay from the time on that is wanted.

        A calibration that is newer than the enclosed one must be in the file, and is behind
        `before`.
        """
        status, since_ns = self._reader.status_view, self.settings.since_ns
        now = place_now(self._reader)  # first: a calibration that comes after it is recorded
        if int(status["tares"][0]) != tares:
            return before
        if not since_ns:
            return now
        known = int(status["stale_ns"][0]) + int(BEGINNING * 1e9)
        return place_since(self._reader, since_ns - known, now)

    def _write_state(self) -> None:
        if not self._rehearsal:
            self.state.write(self.settings.name)

    def _ask_for_a_beginning(self) -> None:
        """Have the engine make its next cycle a key cycle, from which a replay can begin.

        Only once all that its answers follow from is in the file: until then older readings count.
        """
        now, status = time.monotonic(), self._reader.status_view
        if self._drain.cycles and math.isinf(self._since):
            self._since = now
        due = self._since + BEGINNING + int(status["stale_ns"][0]) * 1e-9
        if now < due or not status["tares"][0]:
            self._ask_at = max(due, now + BEGINNING) if self._drain.cycles else now
            return
        self._ask_at = math.inf
        try:
            order(self.settings.name, "key")
        except InputError:
            return  # no engine listens now: the first cycle of the next is one

    def run(
        self,
        stop: threading.Event,
        seconds: float | None = None,
        told: Callable[[RecorderState], None] = lambda state: None,
    ) -> RecorderState:
        """Record until `stop` is set, the time is over, or the ring is taken away.

        `told` gets each new state, once a second.
        """
        end = None if seconds is None else self._began + seconds
        known = self.state
        while not self._ended:
            self.step()
            if self.state is not known:
                known = self.state
                told(known)
            if stop.wait(PAUSE):
                self._ended = "it was told to stop"
            elif end is not None and time.monotonic() >= end:
                self._ended = "its time is over"
        return self.close()

    def step(self) -> None:
        """Take what is new; once a second, look at all else and tell of it."""
        self._drain.take()
        if time.monotonic() > self._ask_at:
            self._ask_for_a_beginning()
        if time.monotonic() < self._next:
            return
        self._next += SECOND
        self._drain.tell_lost()
        self._watch.look()
        self.state = self._state()
        self._write_state()
        self._say_changes()
        if self._disk.crashed:
            self._ended = "the thread that writes has failed"
        elif self._reader.replaced():
            self._ended = "the ring was taken away: the skin was stopped"

    def close(self) -> RecorderState:
        """Take what is left, finish the file, and tell how it went."""
        self._drain.take()
        self._drain.tell_lost()
        self._watch.look()
        text = f"the recording ends: {self._ended or 'closed'}"
        self._queue.tell(Told(time.time_ns(), "recording_ended", text, self._totals()))
        try:
            self._disk.stop()
        finally:
            self._drain.close()
            self._reader.close()
        self._ended = self._ended or "closed"
        self.state = self._state()
        self._write_state()
        self._say_changes()
        return self.state

    def _totals(self) -> dict[str, object]:
        drain, queue = self._drain, self._queue
        return {
            "bytes_read": drain.bytes_read,
            "cycles": drain.cycles,
            "overrun_bytes": drain.overrun_bytes,
            "overrun_cycles": drain.overrun_cycles,
            "dropped_bytes": queue.dropped_bytes,
            "dropped_cycles": queue.dropped_cycles,
        }

    def _state(self) -> RecorderState:
        disk, now, now_ns = self._disk.state, time.monotonic(), time.time_ns()
        oldest = self._queue.oldest_ns
        return RecorderState(
            pid=os.getpid(),
            path=str(self.settings.path),
            began_ns=self._began_ns,
            told_ns=now_ns,
            seconds=now - self._began,
            bytes_written=self._writer.bytes_written,
            bytes_read=self._drain.bytes_read,
            cycles=self._drain.cycles,
            overrun_bytes=self._drain.overrun_bytes,
            overrun_cycles=self._drain.overrun_cycles,
            dropped_bytes=self._queue.dropped_bytes,
            dropped_cycles=self._queue.dropped_cycles,
            given_up=disk.lost,
            queue_bytes=self._queue.waiting,
            lag=(now_ns - oldest) * 1e-9 if oldest else 0.0,
            since_flush=now - disk.last_flush,
            since_sync=now - disk.last_sync,
            longest=disk.longest,
            failing=bool(disk.failing_since),
            failure=disk.failure,
            finished=disk.finished,
            ended=self._ended,
        )

    def _say_changes(self) -> None:
        """Say what is new since the last second."""
        state = self.state
        dropped = f"{state.dropped_bytes} bytes and {state.dropped_cycles} cycles"
        overrun = f"{state.overrun_bytes} bytes and {state.overrun_cycles} cycles"
        sentences = {
            "dropped": f"the disk does not keep up: {dropped} dropped so far",
            "overrun": f"the recorder does not keep up: {overrun} overwritten unread so far",
            "failing": f"nothing can be written: {state.failure}",
            "given_up": f"{state.given_up} messages could not be written at the end",
        }
        now = {
            "dropped": bool(state.dropped_bytes or state.dropped_cycles),
            "overrun": bool(state.overrun_bytes or state.overrun_cycles),
            "failing": state.failing,
            "given_up": bool(state.given_up),
        }
        for what, text in sentences.items():
            if now[what] and self._said.get(what) != text:
                self._said[what] = text
                self._say(text)
            elif what == "failing" and not now[what] and self._said.pop(what, ""):
                self._say("the file can be written again")


def come_first() -> str:
    """Have this thread come before ordinary work, where that is permitted.

    The ring holds a limited number of cycles, and on a busy machine an ordinary process may wait
    longer than that for a processor. It sleeps most of the time, and the engine's priority is far
    above.

    Returns
    -------
    str
        What was granted.
    """
    with contextlib.suppress(OSError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(LOWEST))
        return f"SCHED_FIFO {LOWEST}"
    with contextlib.suppress(OSError, AttributeError):
        os.setpriority(os.PRIO_PROCESS, 0, NICE)
        return f"nice {NICE}"
    return "ordinary"


if __name__ == "__main__":
    from skinfield.live.recorder_process import main

    main()
