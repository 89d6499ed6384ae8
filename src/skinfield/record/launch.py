"""Recorder processes: one that records a ring, and one that stands ready while the page is open."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from skinfield.errors import InputError

LATER = 3.0  # s after a recording began, until the next one is made ready: it loads for a second
PAUSES = 5.0, 300.0  # s from one that died to the next: the first, and the longest
BEGINS = 180.0  # s for a recorder to begin, on a machine that compiles beside it
ENDS = 15.0  # s for a recorder to finish its file
LOOK = 0.01  # s between looks whether a recorder records
UNWANTED_ENDS = 5.0  # s for one that is not wanted any more
LOADING = "the recorder is still being loaded: this recording begins in a second or so; press then"
NOT_READY = "no recorder stood ready: this recording begins in a second or two; press then"


class ReadyRecorders:
    """Recorders of one ring, of which one stands ready from `prepare` on.

    It is a process that has loaded all that it needs and waits for its file. What holds for the
    ring is only looked at then: it may be another one, or of another engine.

    Processes end with the thread that starts them, so that `prepare`, `tend` and what records must
    be called from threads that last.

    Parameters
    ----------
    name : str
        Of the ring.
    say : function of a sentence
        Told when a recording begins late.
    """

    def __init__(self, name: str, say: Callable[[str], None] = lambda text: None) -> None:
        self._name, self._say = name, say
        self._lock = threading.Lock()
        self._child: subprocess.Popen[bytes] | None = None
        self._wanted, self._loaded = False, False
        self._next, self._pause = 0.0, PAUSES[0]

    @property
    def pid(self) -> int | None:
        """Process of the one that waits; None if there is none."""
        with self._lock:
            return None if self._child is None else self._child.pid

    @property
    def stands_ready(self) -> bool:
        """Whether one waits that has loaded everything."""
        with self._lock:
            return self._is_loaded()

    def prepare(self) -> None:
        """From now on one shall stand ready."""
        self._wanted = True
        self.tend()

    def tend(self) -> None:
        """See that one stands ready, if that is wanted; to be called again and again."""
        with self._lock:
            now, child = time.monotonic(), self._child
            if child is not None and child.poll() is not None:
                _let_go(child)
                self._child = None
                self._next, self._pause = now + self._pause, min(2 * self._pause, PAUSES[1])
            if self._wanted and self._child is None and now >= self._next:
                self._child, self._loaded = _start_waiting(self._name), False

    @contextmanager
    def __call__(self, path: Path) -> Iterator[None]:
        """Record into a file, from now on, as long as it is entered."""
        since_ns = time.time_ns()
        child = self._ordered(path, since_ns)
        if child is None or not self._begins(child, path):
            self._say(NOT_READY)
            child = start_recorder(self._name, str(path), "--since-ns", str(since_ns))
        with recording(self._name, path, child):
            yield

    def _begins(self, child: "subprocess.Popen[bytes]", path: Path) -> bool:
        """Whether the one that stood ready records; else it is gone, and there is no file."""
        try:
            wait_for_recorder(self._name, child)
        except InputError:
            child.kill()
            child.wait()
            if path.exists():
                raise
            return False
        return True

    def _ordered(self, path: Path, since_ns: int) -> "subprocess.Popen[bytes] | None":
        """Have the one that stands ready record; None if there is none."""
        from skinfield.record.recorder import order_of

        with self._lock:
            child, loaded = self._child, self._is_loaded()
            self._child, self._next = None, time.monotonic() + LATER
        if child is None:
            return None
        if not loaded and child.poll() is None:
            self._say(LOADING)
        with contextlib.suppress(BrokenPipeError):  # it is gone
            assert child.stdin is not None  # it is a pipe
            child.stdin.write(order_of(path, since_ns))
            child.stdin.flush()
            self._pause = PAUSES[0]
        _let_go(child)
        return child

    def _is_loaded(self) -> bool:
        from skinfield.record.recorder import READY

        child = self._child
        if child is None or child.poll() is not None:
            return False
        if not self._loaded:
            assert child.stdout is not None  # it is a pipe
            self._loaded = child.stdout.read(len(READY)) == READY
        return self._loaded

    def close(self) -> None:
        """End the one that waits, if there is one."""
        with self._lock:
            self._wanted, child, self._child = False, self._child, None
        if child is None:
            return
        _let_go(child)  # which ends it
        child.terminate()
        try:
            child.wait(UNWANTED_ENDS)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()


def _start_waiting(name: str) -> "subprocess.Popen[bytes]":
    child = start_recorder(name, "--wait", pipe=subprocess.PIPE)
    assert child.stdout is not None  # it is a pipe
    os.set_blocking(child.stdout.fileno(), False)
    return child


def _let_go(child: "subprocess.Popen[bytes]") -> None:
    for pipe in (child.stdin, child.stdout):
        if pipe is not None:
            with contextlib.suppress(BrokenPipeError):
                pipe.close()


@contextmanager
def recorder(name: str, path: Path | None) -> Iterator[None]:
    """A recorder of this ring, if a file is wanted; its file is finished in the end."""
    if path is None:
        yield
        return
    with recording(name, path, start_recorder(name, str(path))):
        yield


def start_recorder(name: str, *words: str, pipe: int | None = None) -> "subprocess.Popen[bytes]":
    """A process that records this ring; it ends with the thread that calls this."""
    command = [sys.executable, "-m", "skinfield.record.recorder", name, *words]
    command += ["--parent", str(os.getpid())]
    return subprocess.Popen(command, process_group=0, stdin=pipe, stdout=pipe)


@contextmanager
def recording(name: str, path: Path, child: "subprocess.Popen[bytes]") -> Iterator[None]:
    """What a process records, from when it does; its file is finished in the end."""
    try:
        wait_for_recorder(name, child)
        yield
    finally:
        if child.poll() is None:
            child.terminate()
        try:
            code = child.wait(ENDS)
        except subprocess.TimeoutExpired:
            child.kill()
            code = child.wait()
        unbegun = code == -signal.SIGTERM and not path.exists()  # told to end before it began
        if code and not unbegun:
            raise InputError(
                f"the recorder ended with status {code}: see what it said; "
                f"`skinfield recover {path} -o GOOD.mcap` saves what is in the file"
            )


def wait_for_recorder(name: str, child: "subprocess.Popen[bytes]") -> None:
    """Wait until a recorder records, so that nothing of the skin's life is missing.

    Raises
    ------
    InputError
        If it ends, or does not begin in time.
    """
    from skinfield.record.recorder import read_state

    end = time.monotonic() + BEGINS
    while time.monotonic() < end:
        state = read_state(name)
        if state is not None and state.pid == child.pid:
            return
        if child.poll() is not None:
            raise InputError(f"the recorder ended with status {child.returncode}: see what it said")
        time.sleep(LOOK)
    raise InputError(f"the recorder did not begin within {BEGINS:g} s: is the machine very busy?")
