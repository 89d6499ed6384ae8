"""Process supervisor: processes beside this one that are started again when they end."""

import ctypes
import os
import re
import signal
import subprocess
import tempfile
import threading
import time
from _thread import start_new_thread
from collections import deque
from contextlib import suppress
from typing import IO, Self

from skinfield.errors import InputError
from skinfield.processes import Child

ENDS = 5.0  # s for a process to end when told to
SETTLED = 30.0  # s after which a failure counts as the first one again
MOST_NOTICES = 20
TAIL = 4000  # bytes of what a process wrote last


def end_within(child: Child, seconds: float) -> None:
    """Wait for the end of a process, and kill it if it takes longer."""
    try:
        child.wait(seconds)
    except subprocess.TimeoutExpired:  # it compiles, perhaps
        child.kill()
        child.wait()


def close_pipes(child: Child) -> None:
    """Close what this process has of its standard input and output."""
    for pipe in (child.stdin, child.stdout):
        if pipe is not None:
            with suppress(BrokenPipeError):
                pipe.close()


def end_child(child: Child, seconds: float) -> int:
    """End a process, which is killed if it takes longer; its exit status."""
    if child.poll() is None:
        child.terminate()
    end_within(child, seconds)
    close_pipes(child)
    return child.returncode


def last_words(errors: IO[bytes]) -> str:
    """What a process wrote last to its standard error: lines, of a traceback where it failed."""
    size = errors.seek(0, os.SEEK_END)
    errors.seek(max(size - TAIL, 0))
    return errors.read().decode(errors="replace").strip()


def last_line(words: str) -> str:
    """The reason in what a process wrote last, without the name of skinfield's errors."""
    lines = words.splitlines()
    fatal = [line for line in lines if line.startswith("Fatal Python error")]
    return re.sub(r"^skinfield\.errors\.\w+: ", "", (fatal or lines)[-1]) if lines else ""


def exit_text(code: int) -> str:
    """How a process ended, of its status."""
    names = {each.value: each.name for each in signal.Signals}  # not all numbers have one
    return f"signal {names.get(-code, -code)}" if code < 0 else f"status {code}"


PARENT_DIED = 1  # PR_SET_PDEATHSIG of Linux


def end_with(parent: int) -> None:
    """Have the system send SIGTERM to this process when its parent ends, where it can.

    Parameters
    ----------
    parent : int
        Process that is expected to be the parent: what it is called if it is already gone differs.

    Raises
    ------
    SystemExit
        If it is gone.
    """
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).prctl(PARENT_DIED, signal.SIGTERM)
    if os.getppid() != parent:
        raise SystemExit("whoever started this process is gone")


def stop_on(*signals: int) -> threading.Event:
    """An event that these signals set: in a thread, as what they interrupt may hold its lock."""
    stop = threading.Event()
    for number in signals:
        signal.signal(number, lambda *_: start_new_thread(stop.set, ()))
    return stop


class SupervisedProcess:
    """A process that shall go on as long as the `with` block lasts.

    Parameters
    ----------
    what : str
        Its name in sentences, such as "the bridge to zenoh".

    Attributes
    ----------
    poll : float, s
        Between looks whether it still lives.
    pauses : tuple of float, s
        Before it is started again, the last for ever.
    restarts : int
    failure : str
        Why it is not there; empty while it is.
    traceback : str
        What the process that failed last wrote at its end.
    child : subprocess.Popen or None
    """

    poll = 0.3
    pauses: tuple[float, ...] = (1.0, 3.0, 10.0, 30.0)

    def __init__(self, what: str) -> None:
        self.what, self.restarts, self.failure, self.traceback = what, 0, "", ""
        self.child: Child | None = None
        self.stopping = threading.Event()
        self._errors: IO[bytes] | None = None
        self._notices: deque[str] = deque(maxlen=MOST_NOTICES)
        self._failures = 0
        self._began = 0.0
        # its process ends with the thread that started it: this one lasts until the end
        self._thread = threading.Thread(target=self._watch, name=what, daemon=True)

    def spawn(self) -> Child:
        """Start the process."""
        raise NotImplementedError

    def greet(self, child: Child) -> None:
        """Wait until it is there, or `stopping`; by default, believe it.

        Raises
        ------
        InputError
            With what it said if it is not.
        """

    def look(self, child: Child) -> str:
        """Why a process that lives must be killed; looked at again and again."""
        return ""

    def report(self, what: str, text: str) -> None:
        """It "started", "failed" or "hung"."""

    def new_errors(self) -> IO[bytes]:
        """For a new process's standard error, in place of what the one before wrote."""
        self._forget()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the next
        return self._errors

    def _forget(self) -> None:
        if self._errors is not None:
            self._errors.close()

    def begin(self) -> None:
        """Start the process.

        Raises
        ------
        InputError
            If it is not there.
        """
        self.end()
        self._began = time.monotonic()
        try:
            self.child = self.spawn()
        except OSError as error:  # no memory or process is left for it: perhaps later
            raise InputError(f"{self.what} could not be started: {error}") from error
        self.report("started", f"process {self.child.pid}")
        self.greet(self.child)
        self.failure = ""

    def end(self) -> None:
        """End the process."""
        child, self.child = self.child, None
        if child is not None:
            end_child(child, ENDS)

    def watch(self) -> None:
        """Watch over the process from now on."""
        self._thread.start()

    def stop(self) -> None:
        """End the watch, and the process."""
        self.stopping.set()
        if self._thread.is_alive():
            self._thread.join()
        self.end()
        self._forget()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def notices(self) -> list[str]:
        """What happened to it since the last time, in sentences."""
        return [self._notices.popleft() for _ in range(len(self._notices))]

    def _watch(self) -> None:
        """Start again what ended; until told to stop."""
        while not self.stopping.wait(self.poll):
            child = self.child
            if child is not None:
                code = child.poll()
                why = self.look(child) if code is None else ""
                if code is None and not why:
                    if self._failures and time.monotonic() - self._began > SETTLED:
                        if self._failures > 1:
                            self._notices.append(f"{self.what} is there again")
                        self._failures = 0  # the next counts as the first one
                    continue
                self._went(child, code, why)
            if self.stopping.wait(self._pause()):
                return
            self.restarts += 1
            try:
                self.begin()
            except InputError as error:
                self.failure = str(error)
                self.report("failed", self.failure)

    def _went(self, child: Child, code: int | None, why: str) -> None:
        """Say how a process ended, or kill it."""
        self.traceback = last_words(self._errors) if self._errors is not None else ""
        if code is None:
            child.kill()
            child.wait()
            text = f"{why}: killed"
        else:
            last = last_line(self.traceback)
            text = f"ended with {exit_text(code)}{': ' * bool(last)}{last}"
        self.failure = f"{self.what} {text}"
        self.report("failed" if code is not None else "hung", text)

    def _pause(self) -> float:
        """How long to wait, s, which is told with the failure; what goes on for ever only once."""
        failures, last = self._failures, len(self.pauses) - 1
        pause = self.pauses[min(failures, last)]
        self._failures += 1
        if failures < last:
            self._notices.append(f"{self.failure}; it is started again")
        elif failures == last:
            self._notices.append(f"{self.failure}; it is tried again every {pause:g} s")
        return pause
