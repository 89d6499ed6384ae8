"""Supervisor of an engine: its process is started, watched, started again, and handed over.

An engine with another solver prepares itself beside the one that runs, and then takes over.
"""

import contextlib
import math
import os
import pickle
import subprocess
import tempfile
import threading
import time
from collections import deque
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, NamedTuple, Self

from skinfield.errors import InputError, check_offers
from skinfield.loop.control import address_of, order
from skinfield.loop.model_config import Configuration
from skinfield.loop.process_supervisor import (
    SupervisedProcess,
    close_pipes,
    end_within,
    last_line,
    last_words,
)
from skinfield.loop.runtime_parameters import Tuning
from skinfield.loop.settings import LiveSettings
from skinfield.loop.status_text import read_notes, start_in_words
from skinfield.processes import Child, start_python
from skinfield.ring import Ring, RingReader, State
from skinfield.ring.files import sidecar, write_sidecar
from skinfield.solve import Solver

READY, GO = b"ready\n", b"go\n"
PATIENCE = 2.0  # s for the engine before to end by itself


def spawn(settings: LiveSettings, errors: IO[bytes], takes_over: bool = False) -> Child:
    """Start an engine's process; one that takes over prepares itself, and waits for `GO`."""
    child = start_python(
        "skinfield.loop.engine_process",
        str(os.getpid()),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE if takes_over else subprocess.DEVNULL,
        stderr=errors,
    )
    send(settings, child, takes_over)
    return child


def send(settings: LiveSettings, child: Child, takes_over: bool = False) -> None:
    """Let an engine's process begin."""
    assert child.stdin is not None  # it is a pipe
    with contextlib.suppress(BrokenPipeError):  # it is gone: whoever watches it says why
        pickle.dump((settings, takes_over), child.stdin)
        child.stdin.flush()
        if not takes_over:
            child.stdin.close()


@dataclass(eq=False)
class Change:
    """An engine that shall take over, from when it is asked for until it has, or has failed.

    Parameters
    ----------
    settings : LiveSettings
    end : float
        By `time.monotonic`: until when it must be ready.

    Attributes
    ----------
    over : Event
    failure : str
        Why the engine before goes on; empty when the change is made.
    """

    settings: LiveSettings
    end: float
    over: threading.Event = field(default_factory=threading.Event, init=False)
    failure: str = field(default="", init=False)
    child: Child | None = field(default=None, init=False)
    errors: IO[bytes] = field(default_factory=tempfile.TemporaryFile, init=False)

    def step(self) -> bool:
        """Go on; whether the next engine is ready."""
        try:
            if self.child is None:
                self.child = spawn(self.settings, self.errors, takes_over=True)
                assert self.child.stdout is not None  # it is a pipe
                os.set_blocking(self.child.stdout.fileno(), False)
                return False
            assert self.child.stdout is not None
            if self.child.stdout.read(len(READY)) == READY:
                return True
        except OSError as error:
            self.fail(str(error))
            return False
        if self.child.poll() is not None:
            why = last_line(last_words(self.errors))
            self.fail(why or f"it ended with status {self.child.returncode}")
        elif time.monotonic() > self.end:
            self.fail("it was not ready in time")
        return False

    def fail(self, why: str) -> None:
        """Give it up: all stays as it was."""
        if self.child is not None:
            self.child.kill()
            self.child.wait()
            close_pipes(self.child)
        self.errors.close()
        self.failure = why
        self.over.set()

    def switch(self, before: Child | None) -> None:
        """End the engine before, and let the next one go."""
        if before is not None:
            try:
                order(self.settings.name, "hand over")
            except InputError:  # it does not listen yet, or not any more
                before.terminate()
            end_within(before, PATIENCE)
        assert self.child is not None
        assert self.child.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # it died just now: the supervisor will see
            self.child.stdin.write(GO)
        close_pipes(self.child)


LIMITS = {State.RUNNING: 3.0, State.CALIBRATING: 60.0}  # s without a sign of life
KEPT = 100  # events
TAKES_OVER = 60.0  # s from the end of one engine to the first answer of the next
LOOK = 0.1  # s between looks how far it is: each opens its ring
TRIES = 3  # failures of an engine that never answered, after which it is no use


class Event(NamedTuple):
    """Something that happened to an engine.

    Attributes
    ----------
    time_ns : int, ns
        Since the epoch.
    what : str
        "started", "failed", "hung", "changed" or "stopped".
    text : str
        In a sentence.
    """

    time_ns: int
    what: str
    text: str


class EngineFailed(InputError):
    """An engine that could not even start."""


class Supervisor(SupervisedProcess):
    """Runs the engine of a live skin as long as the `with` block lasts.

    Parameters
    ----------
    settings : LiveSettings
    loading : process and its standard error, optional
        First engine, which loads its code already and waits for its settings.

    Attributes
    ----------
    events : deque of Event
    restarts : int
    failure : str
        Of the last process that failed.
    """

    poll = 0.1
    pauses = (0.1, 0.3, 1.0, 3.0)

    def __init__(
        self, settings: LiveSettings, loading: tuple[Child, IO[bytes]] | None = None
    ) -> None:
        super().__init__("the engine")
        self._loading = loading
        pickle.dumps(settings)  # what cannot be sent to a process is told now
        self.settings = settings
        self.events: deque[Event] = deque(maxlen=KEPT)
        self._change: Change | None = None
        self.never_ran = True

    @property
    def status_path(self) -> Path:
        """File in which restarts are told to others."""
        return sidecar(self.settings.name, "supervisor")

    def __enter__(self) -> Self:
        try:
            self.begin()
            self.watch()
        except BaseException:  # a Ctrl-C now must leave nothing behind
            self.stop()
            raise
        return self

    def spawn(self) -> Child:
        """See `SupervisedProcess`."""
        loading, self._loading = self._loading, None
        if loading is None:
            return spawn(self.settings, self.new_errors())
        self._forget()
        child, self._errors = loading
        send(self.settings, child)
        return child

    def begin(self) -> None:
        """See `SupervisedProcess`; what failed before is told until it answers."""
        failure = self.failure
        super().begin()
        self.failure = failure

    def look(self, child: Child) -> str:
        """See `SupervisedProcess`; a change goes on meanwhile."""
        with contextlib.suppress(InputError), RingReader(self.settings.name) as reader:
            silence = (time.monotonic_ns() - reader.heartbeat_ns) * 1e-9
            if reader.pid == child.pid and silence > LIMITS.get(reader.state, math.inf):
                return f"no sign of life for {silence:g} s"
        if self._change is not None:
            self._go_on_with(self._change)
        return ""

    def _go_on_with(self, change: Change) -> None:
        """One step of a change; processes are only started here, as they end with this thread."""
        if change.step():
            change.switch(self.child)
            self._forget()
            self.settings, self.child, self._errors = change.settings, change.child, change.errors
            self._began = time.monotonic()
            assert self.child is not None  # it was ready
            solver = type(self.settings.solver).__name__
            self.report("changed", f"process {self.child.pid} answers with {solver}")
            change.over.set()
        if change.over.is_set():
            self._change = None

    def reconfigure(self, *, solver: Solver, timeout: float = 180.0) -> None:
        """Answer with another solver from now on, by the baseline that is in force.

        The next engine prepares itself in a process of its own while this one goes on; then it
        takes over sources and ring. Readers and recorders stay with the ring, and contacts keep
        their numbers.

        Parameters
        ----------
        solver : Solver
        timeout : float, s
            For the preparation.

        Raises
        ------
        InputError
            For a solver that is none of skinfield's own.
        EngineFailed
            If the next engine cannot be made, or not in time: this one goes on as it was.
        """
        check_offers("solver", solver, ("prepare",), "one such as NonNegative()")
        Configuration(1, solver, Tuning()).as_dict()  # refuses what no recording could tell
        if self._change is not None:
            raise EngineFailed("the engine is being changed already, expected one at a time: wait")
        settings = replace(self.settings, solver=solver)
        self._change = change = Change(settings, time.monotonic() + timeout)
        while not change.over.wait(1.0):
            if not self._thread.is_alive():
                change.fail("the skin was stopped")
        if change.failure:
            raise EngineFailed(f"the engine stays as it was: {change.failure}")
        self.wait(TAKES_OVER).close()

    def report(self, what: str, text: str) -> None:
        """Note what happened, for `events` and for others."""
        self.events.append(Event(time.time_ns(), what, text))
        told = {"pid": os.getpid(), "restarts": self.restarts, "events": list(self.events)}
        told["traceback"] = self.traceback
        write_sidecar(self.settings.name, "supervisor", told)

    @property
    def hopeless(self) -> bool:
        """Whether it failed again and again, and never answered."""
        return self._failures >= TRIES and self.never_ran

    def wait(self, timeout: float, state: State = State.RUNNING) -> RingReader:
        """Wait until the engine is as far as a state; by default, until it answers.

        Raises
        ------
        EngineFailed
            If it failed three times before it ever answered, or the time is over: with what it
            said last.
        """
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            if self.hopeless:
                raise EngineFailed(f"{TRIES} starts failed: {self.failure}")
            child = self.child
            with contextlib.suppress(InputError):  # there is no ring yet
                reader = RingReader(self.settings.name)
                its = child is not None and reader.pid == child.pid
                if its and state <= reader.state <= State.RUNNING:
                    self.never_ran &= state != State.RUNNING
                    return reader
                reader.close()
            time.sleep(LOOK)
        raise EngineFailed(
            f"the engine did not answer within {timeout:g} s: "
            + (self.failure or self.start_in_words() or "it has said nothing yet")
        )

    def start_in_words(self) -> str:
        """What the engine does before it answers; empty where it has said nothing yet."""
        try:
            with RingReader(self.settings.name) as reader:
                notes = read_notes(reader.status_view["notes"]) or {}
                waits = notes.get("phase") == "taring" and not reader.status_view["sources"].any()
        except InputError:
            return ""
        return "it waits for readings, and none has come" if waits else start_in_words(notes)

    def stop(self) -> None:
        """Stop the engine, and take its ring away."""
        self.stopping.set()
        if self._thread.is_alive():
            self._thread.join()
        change, self._change = self._change, None
        if change is not None:
            change.fail("the skin was stopped")
        child = self.child
        super().stop()
        if child is not None:
            self.report("stopped", f"process {child.pid}")
        self.status_path.unlink(missing_ok=True)
        address_of(self.settings.name).unlink(missing_ok=True)  # of an engine that was killed
        Ring.remove(self.settings.name)
