"""Recorder of a running skin, in a process of its own: python -m skinfield.record.recorder.

Two threads. One takes everything new out of the ring every few milliseconds: it reads shared memory
and nothing else, so the engine never waits for it. The other writes: it may wait for the disk as
long as the disk likes, as a bounded queue lies between them. What the queue cannot hold is dropped,
counted, and published in the file, in the state beside the ring and to whoever listens.
"""

import argparse
import contextlib
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from skinfield.errors import SkinfieldError, check_range
from skinfield.files.mcap import RecordingWriter
from skinfield.files.mcap.container import FileOutput
from skinfield.loop.model_config import model_config_of
from skinfield.loop.process_supervisor import end_with, stop_on
from skinfield.loop.slots import LAYOUT as CYCLE
from skinfield.record.drain import Drain, StatusWatch, enclosed_of, place_since
from skinfield.record.queue import Disk, Queue
from skinfield.record.state import RecorderState as RecorderState
from skinfield.record.state import forget_state as forget_state
from skinfield.record.state import read_state as read_state
from skinfield.ring import RingReader

PAUSE = 0.005  # s between looks at the ring
SECOND = 1.0  # s between looks at everything else
LOWEST = 1  # of the real-time priorities
NICE = -10  # where that is not granted
TOTALS = (
    "bytes_read",
    "cycles",
    "overrun_bytes",
    "overrun_cycles",
    "dropped_bytes",
    "dropped_cycles",
)


class Recorder:
    """A recording that is going on.

    Parameters
    ----------
    name : str
        Of the ring.
    path : Path
        Ends in .mcap by custom.
    say : function of a sentence
        Called with what goes wrong, and when it is well again.
    output : FileOutput, optional
        Instead of a file.
    overwrite : bool
        Whether a file of this name may be replaced.
    since_ns : int, ns
        Time since the epoch from which on to record, as far as the ring still has it; 0: now.
    queue_bytes : int
        That may wait for the disk; what comes beyond is dropped and counted.
    view_rate : float, 1/s
        Of the fields of pressure.
    first : bool
        Whether this thread and the one that writes shall come before ordinary work from now on,
        where that is permitted.

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
        name: str,
        path: Path,
        say: Callable[[str], None] = lambda text: None,
        output: FileOutput | None = None,
        *,
        overwrite: bool = False,
        since_ns: int = 0,
        queue_bytes: int = 1 << 26,
        view_rate: float = 20.0,
        first: bool = False,
    ) -> None:
        check_range("view_rate", view_rate, 1e-3, 1e3, "messages a second")
        self.name, self._say = name, say
        self._reader = RingReader(name)
        self._began = time.monotonic()
        self._live = live = RecorderState(os.getpid(), str(path), time.time_ns())
        model_config = model_config_of(self._reader)
        tares = int(self._reader.status_view["tares"][0])  # before: a new one is enclosed later
        enclosed = enclosed_of(self._reader, model_config)
        self._writer = RecordingWriter(
            path, enclosed, layout=CYCLE, overwrite=overwrite, output=output
        )
        self._queue = Queue(queue_bytes, live)
        self._watch = StatusWatch(self._reader, self._queue, model_config, tares)
        begin = place_since(self._reader, since_ns)
        self._drain = Drain(self._reader, self._queue, model_config, view_rate, begin)
        self._disk = Disk(self._writer, self._queue)
        self._said: dict[str, str] = {}
        text = f"recording {name} of process {self._reader.pid}"
        self._queue.event("recording_started", text)
        if first:  # now, as all that must be loaded is: the other thread inherits it
            come_first()
        self._disk.start()
        self._next = self._began
        self.state = self._state()

    def run(
        self,
        stop: threading.Event,
        seconds: float | None = None,
        told: Callable[[RecorderState], None] = lambda state: None,
    ) -> RecorderState:
        """Record until `stop` is set, the time is over, or the ring is taken away.

        Each new state, once a second, is told beside the ring, and to `told`.
        """
        end = None if seconds is None else self._began + seconds
        known = self.state
        while not self._live.ended:
            self.step()
            if self.state is not known:
                known = self.state
                known.write(self.name)
                told(known)
            if stop.wait(PAUSE):
                self._live.ended = "it was told to stop"
            elif end is not None and time.monotonic() >= end:
                self._live.ended = "its time is over"
        self.close()
        self.state.write(self.name)
        return self.state

    def step(self) -> None:
        """Take what is new; once a second, look at all else and tell of it."""
        self._drain.take()
        if time.monotonic() < self._next:
            return
        self._next += SECOND
        self._drain.tell_lost()
        self._watch.look()
        self.state = self._state()
        self._say_changes()
        if self._disk.crash is not None:
            self._live.ended = "the thread that writes has failed"
        elif self._reader.replaced():
            self._live.ended = "the ring was taken away: the skin was stopped"

    def close(self) -> RecorderState:
        """Take what is left, finish the file, and tell how it went."""
        self._drain.take()
        self._drain.tell_lost()
        self._watch.look()
        text = f"the recording ends: {self._live.ended or 'closed'}"
        totals = {key: getattr(self._live, key) for key in TOTALS}
        self._queue.event("recording_ended", text, **totals)
        try:
            self._disk.stop()
        finally:
            self._reader.close()
        self._live.ended = self._live.ended or "closed"
        self.state = self._state()
        self._say_changes()
        return self.state

    def _state(self) -> RecorderState:
        """What is counted all the time, and what is looked at now."""
        disk, now, now_ns = self._disk, time.monotonic(), time.time_ns()
        oldest = self._queue.oldest_ns
        return replace(
            self._live,
            told_ns=now_ns,
            seconds=now - self._began,
            bytes_written=self._writer.bytes_written,
            queue_bytes=self._queue.waiting,
            lag=(now_ns - oldest) * 1e-9 if oldest else 0.0,
            since_flush=now - disk.last_flush,
            since_sync=now - disk.last_sync,
            failing=bool(disk.failing_since),
        )

    def _say_changes(self) -> None:
        """Say what is new since the last second."""
        state = self.state
        dropped = state.dropped_bytes, state.dropped_cycles
        overrun = state.overrun_bytes, state.overrun_cycles
        sentences = {
            "dropped": any(dropped)
            and "the disk does not keep up: {} bytes and {} cycles dropped so far".format(*dropped),
            "overrun": any(overrun)
            and "the recorder does not keep up: {} bytes and {} cycles overwritten unread so "
            "far".format(*overrun),
            "failing": state.failing and f"nothing can be written: {state.failure}",
            "given_up": state.given_up
            and f"{state.given_up} messages could not be written at the end",
        }
        for what, text in sentences.items():
            if text and self._said.get(what) != text:
                self._said[what] = text
                self._say(text)
            elif what == "failing" and not text and self._said.pop(what, ""):
                self._say("the file can be written again")


def come_first() -> None:
    """Have this thread come before ordinary work, where that is permitted.

    The ring holds a limited number of cycles, and on a busy machine an ordinary process may wait
    longer than that for a processor. It sleeps most of the time, and the engine's priority is far
    above.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(LOWEST))
    except (OSError, AttributeError):
        with contextlib.suppress(OSError, AttributeError):
            os.setpriority(os.PRIO_PROCESS, 0, NICE)


def main() -> None:
    """Record until SIGTERM or Ctrl-C; without a path, stand by until one comes."""
    parser = argparse.ArgumentParser(prog="python -m skinfield.record.recorder")
    parser.add_argument("name")
    parser.add_argument("path", type=Path, nargs="?", help="Default: wait for an order on stdin.")
    parser.add_argument("--parent", type=int, help="Process with which it ends.")
    given = parser.parse_args()
    if given.parent is not None:
        end_with(given.parent)
    try:
        order = {"path": given.path, "since_ns": 0} if given.path else _stand_by(given.name)
        if order is None:
            return  # it is not wanted any more
        good = _record(given.name, Path(order["path"]), order["since_ns"])
    except SkinfieldError as error:
        raise SystemExit(f"recorder: {error}") from error
    raise SystemExit(0 if good else 1)


def _stand_by(name: str) -> dict[str, Any] | None:
    """Load what a recording needs, and wait for its `path` and `since_ns`, a line of JSON on stdin.

    It records a moment into a file that goes. Nothing of the ring is kept, as it may be another one
    until a recording is wanted. None if whoever would have said so is gone.
    """
    with TemporaryDirectory() as folder, contextlib.suppress(SkinfieldError):  # of no ring now
        path = Path(folder) / "rehearsal.mcap"
        rehearsal = Recorder(name, path, since_ns=1)
        rehearsal.step()
        rehearsal.close()
    come_first()  # now, as all is loaded: on a busy machine the order is read at once
    line = sys.stdin.buffer.readline()
    order: dict[str, Any] | None = json.loads(line) if line else None
    return order


def _record(name: str, path: Path, since_ns: int) -> bool:
    """Record until told to stop; whether all that was taken is in the file, and it is whole."""
    stop = stop_on(signal.SIGTERM, signal.SIGINT)
    state = Recorder(name, path, _say, since_ns=since_ns, first=True).run(stop)
    forget_state(name)
    return state.finished and not state.given_up


def _say(text: str) -> None:
    with contextlib.suppress(OSError):  # the terminal is gone: the file is not
        sys.stderr.write(f"recorder: {text}\n")
        sys.stderr.flush()


if __name__ == "__main__":
    main()
