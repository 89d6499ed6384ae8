"""Process supervisor: processes beside the engine that are started again when they end."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import IO, Self

from skinfield.errors import InputError
from skinfield.loop.handover import nameless_file, plain_error, tail_of

ENDS = 5.0  # s for a process to end when told to
POLL = 0.3  # s between looks whether it still lives
PAUSES = (1.0, 3.0, 10.0, 30.0)  # s before it is started again, the last for ever
SETTLED = 30.0  # s after which a failure counts as the first one again
MOST_NOTICES = 20
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


class SupervisedProcess:
    """A process that shall go on as long as the `with` block lasts.

    Parameters
    ----------
    what : str
        Its name in sentences, such as "the bridge to zenoh".

    Attributes
    ----------
    restarts : int
    failure : str
        Why it is not there; empty while it is.
    child : subprocess.Popen or None
    """

    def __init__(self, what: str) -> None:
        self.what, self.restarts, self.failure = what, 0, ""
        self.child: subprocess.Popen[bytes] | None = None
        self.stopping = threading.Event()
        self._notices: deque[str] = deque(maxlen=MOST_NOTICES)
        self._failures = 0
        self._began = 0.0
        # its process ends with the thread that started it: this one lasts until the end
        self._thread = threading.Thread(target=self._watch, name=what, daemon=True)

    def spawn(self) -> "subprocess.Popen[bytes]":
        """Start the process."""
        raise NotImplementedError

    def greet(self, child: "subprocess.Popen[bytes]") -> None:
        """Wait until it is there, or `stopping`; by default, believe it.

        Raises
        ------
        InputError
            With what it said if it is not.
        """

    @property
    def last_words(self) -> str:
        """What it said before it ended, if that is known."""
        return ""

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
        self.greet(self.child)
        self.failure = ""

    def end(self) -> None:
        """End the process."""
        child, self.child = self.child, None
        if child is None:
            return
        if child.poll() is None:
            child.terminate()
        try:
            child.wait(ENDS)
        except subprocess.TimeoutExpired:  # it compiles, perhaps
            child.kill()
            child.wait()
        if child.stdout is not None:
            child.stdout.close()

    def watch(self) -> None:
        """Watch over the process from now on."""
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stopping.set()
        if self._thread.is_alive():
            self._thread.join()
        self.end()

    def notices(self) -> list[str]:
        """What happened to it since the last time, in sentences."""
        found = []
        while self._notices:
            found.append(self._notices.popleft())
        return found

    def _watch(self) -> None:
        """Start again what ended; until told to stop."""
        while not self.stopping.wait(POLL):
            child = self.child
            if child is not None and child.poll() is None:
                self._settle()
                continue
            if child is not None:
                self.failure = (
                    f"{self.what} ended with {exit_text(child.returncode)}{self.last_words}"
                )
            if self.stopping.wait(self._pause()):
                return
            self.restarts += 1
            try:
                self.begin()
            except InputError as error:
                self.failure = str(error)

    def _settle(self) -> None:
        """Count the next failure as the first one if it has gone well for long."""
        if self._failures and time.monotonic() - self._began > SETTLED:
            if self._failures > 1:
                self._notices.append(f"{self.what} is there again")
            self._failures = 0

    def _pause(self) -> float:
        """How long to wait, s, which is told with the failure; what goes on for ever only once."""
        failures, last = self._failures, len(PAUSES) - 1
        pause = PAUSES[min(failures, last)]
        self._failures += 1
        if failures < last:
            self._notices.append(f"{self.failure}; it is started again")
        elif failures == last:
            self._notices.append(f"{self.failure}; it is tried again every {pause:g} s")
        return pause


def exit_text(code: int) -> str:
    """How a process ended, of its status."""
    names = {each.value: each.name for each in signal.Signals}  # not all numbers have one
    return f"signal {names.get(-code, -code)}" if code < 0 else f"status {code}"


class FitProcess(SupervisedProcess):
    """The process that fits contacts, started again when it ends.

    Parameters
    ----------
    name : str
        Of the live skin.
    """

    def __init__(self, name: str) -> None:
        super().__init__("the contact fit")
        self._name = name
        self._words: IO[bytes] | None = None

    def spawn(self) -> "subprocess.Popen[bytes]":
        """See `SupervisedProcess`."""
        self.forget()
        self._words = nameless_file()
        me = str(os.getpid())
        return subprocess.Popen(
            [sys.executable, "-m", "skinfield.loop.fit_process", self._name, "--parent", me],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._words,
            process_group=0,  # a terminal's Ctrl-C is meant for whoever started it, and ends it
            env=os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )

    @property
    def last_words(self) -> str:
        """See `SupervisedProcess`."""
        said = "" if self._words is None else tail_of(self._words).strip()
        return f": {plain_error(said.splitlines()[-1])}" if said else ""

    def forget(self) -> None:
        """Close what it said."""
        if self._words is not None:
            self._words.close()


@contextmanager
def start_fit(name: str, wanted: bool = True) -> Iterator[FitProcess | None]:
    """Fit the contacts of this skin as long as the block lasts.

    It need not succeed: where there is no fit, the engine's own contacts are shown.

    Parameters
    ----------
    name : str
        Of the live skin.
    wanted : bool
        Otherwise nothing is started, and None is given.
    """
    if not wanted:
        yield None
        return
    fit = FitProcess(name)
    try:
        with fit:
            try:
                fit.begin()
            except InputError as error:
                fit.failure = str(error)
            fit.watch()
            yield fit
    finally:
        fit.forget()
