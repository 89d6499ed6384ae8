"""Recorder processes: one that records a ring, and one that stands by while the page is open."""

import contextlib
import json
import math
import os
import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from skinfield.errors import InputError
from skinfield.loop.process_supervisor import end_child, exit_text
from skinfield.processes import Child, start_python
from skinfield.record.state import read_state

PAUSE = 5.0  # s from one that was used, or died, to the next: it loads for a second
BEGINS = 180.0  # s for a recorder to begin, on a machine that compiles beside it
ENDS = 15.0  # s for a recorder to finish its file
LOOK = 0.01  # s between looks whether a recorder records


class ReadyRecorders:
    """Recorders of one ring, of which one stands by from `prepare` on.

    It is a process that loads all that it needs and waits for its file. What holds for the ring is
    only looked at then: it may be another one, or of another engine.

    Processes end with the thread that starts them, so that `prepare`, `tend` and what records must
    be called from threads that last.

    Parameters
    ----------
    name : str
        Of the ring.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._lock = threading.Lock()
        self._child: Child | None = None
        self._wanted, self._next = False, 0.0

    def prepare(self) -> None:
        """From now on one shall stand by."""
        self._wanted = True
        self.tend()

    def tend(self) -> None:
        """See that one stands by, if that is wanted; to be called again and again."""
        with self._lock:
            now, child = time.monotonic(), self._child
            if child is not None and child.poll() is not None:
                self._child, self._next = None, now + PAUSE
            if self._wanted and self._child is None and now >= self._next:
                self._child = start_recorder(self._name)

    @contextmanager
    def __call__(self, path: Path) -> Iterator[None]:
        """Record into a file, from now on, as long as it is entered."""
        since_ns = time.time_ns()
        with self._lock:
            child, self._child, self._next = self._child, None, math.inf
        try:
            if child is None or child.poll() is not None:
                child = start_recorder(self._name)
            with recording(self._name, path, child, since_ns):
                self._next = time.monotonic() + PAUSE
                yield
        finally:
            self._next = min(self._next, time.monotonic() + PAUSE)

    def close(self) -> None:
        """End the one that waits, if there is one."""
        with self._lock:
            self._wanted, child, self._child = False, self._child, None
        if child is not None:
            end_child(child, ENDS)


@contextmanager
def recorder(name: str, path: Path | None) -> Iterator[None]:
    """A recorder of this ring, if a file is wanted; its file is finished in the end."""
    if path is None:
        yield
        return
    with recording(name, path, start_recorder(name)):
        yield


def start_recorder(name: str) -> Child:
    """A process that waits to record this ring; it ends with the thread that calls this."""
    words = ("skinfield.record.recorder", name, "--parent", str(os.getpid()))
    return start_python(*words, stdin=subprocess.PIPE)


@contextmanager
def recording(name: str, path: Path, child: Child, since_ns: int = 0) -> Iterator[None]:
    """What a process that waits records from a time on; its file is finished in the end.

    Raises
    ------
    InputError
        If it ends, or does not begin in time.
    """
    order = {"path": str(path.absolute()), "since_ns": since_ns}
    assert child.stdin is not None  # it is a pipe
    with contextlib.suppress(BrokenPipeError):  # it is gone, which shows below
        child.stdin.write(json.dumps(order).encode() + b"\n")
        child.stdin.close()
    try:
        _wait_for(name, child)
        yield
    finally:
        code = end_child(child, ENDS)
        unbegun = code == -signal.SIGTERM and not path.exists()  # told to end before it began
        if code and not unbegun:
            raise InputError(
                f"the recorder ended with {exit_text(code)}: see what it said; "
                f"`skinfield recover {path} -o GOOD.mcap` saves what is in the file"
            )


def _wait_for(name: str, child: Child) -> None:
    """Wait until a recorder records, so that nothing of the skin's life is missing."""
    end = time.monotonic() + BEGINS
    while time.monotonic() < end:
        state = read_state(name)
        if state is not None and state.pid == child.pid:
            return
        if child.poll() is not None:
            text = exit_text(child.returncode)
            raise InputError(f"the recorder ended with {text}: see what it said")
        time.sleep(LOOK)
    raise InputError(f"the recorder did not begin within {BEGINS:g} s: is the machine very busy?")
