"""Keeps an engine running in its own process: starts it, watches it, starts it again."""

import json
import math
import os
import pickle
import signal
import subprocess
import threading
import time
from collections import deque
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from skinfield.errors import InputError, check_offers
from skinfield.loop.control import address_of
from skinfield.loop.handover import Change, nameless_file, plain_error, spawn, tail_of
from skinfield.loop.model_config import Configuration
from skinfield.loop.settings import LiveSettings
from skinfield.loop.status_text import read_notes, start_in_words
from skinfield.ring import Ring, RingReader, State
from skinfield.ring.files import sidecar
from skinfield.solve import Solver

LOOK = 0.1  # s between looks
LIMITS = {State.RUNNING: 3.0, State.CALIBRATING: 60.0}  # s without a sign of life
PAUSES = (0.1, 0.3, 1.0, 3.0)  # s before it is started again, the last for ever
SETTLED = 30.0  # s after which a failure counts as the first one again
KEPT = 100  # events
TAKES_OVER = 60.0  # s from the end of one engine to the first answer of the next
TRIES = 3  # failures of an engine that never answered, after which it is no use


@dataclass(frozen=True)
class Event:
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


@dataclass(eq=False)
class Supervisor:
    """Runs the engine of a live skin as long as the `with` block lasts.

    Parameters
    ----------
    settings : LiveSettings

    Attributes
    ----------
    events : deque of Event
    restarts : int
    """

    settings: LiveSettings
    events: deque[Event] = field(default_factory=lambda: deque(maxlen=KEPT), init=False)
    restarts: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self._child: subprocess.Popen[bytes] | None = None
        self._said: IO[bytes] | None = None
        pickle.dumps(self.settings)  # what cannot be sent to a process is told now
        self._change: Change | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="supervisor", daemon=True)
        self._began = 0.0
        self._failures = 0
        self.never_ran = True
        self.failure = ""

    @property
    def status_path(self) -> Path:
        """File in which restarts are told to others."""
        return sidecar(self.settings.name, "supervisor")

    def __enter__(self) -> Self:
        try:
            self._start()
            self._thread.start()
        except BaseException:  # a Ctrl-C now must leave nothing behind
            self.stop()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def _start(self) -> None:
        if self._said is not None:
            self._said.close()
        self._said = nameless_file()
        self._child = spawn(self.settings, self._said)
        self._began = time.monotonic()
        self._tell("started", f"engine process {self._child.pid}")

    def _watch(self) -> None:
        while not self._stopping.wait(LOOK):
            child = self._child
            if child is None:  # it could not be started
                self._again()
                continue
            code = child.poll()
            if code is not None:
                self._gone(code)
            elif silence := self._hangs(child.pid):
                child.kill()
                child.wait()
                self._tell("hung", f"no sign of life for {silence:g} s: killed")
                self._again()
            elif self._change is not None:
                self._go_on_with(self._change)

    def _go_on_with(self, change: Change) -> None:
        """One step of a change; processes are only started here, as they end with this thread."""
        if change.step():
            change.switch(self._child)
            if self._said is not None:
                self._said.close()
            self.settings, self._child, self._said = change.settings, change.child, change.said
            self._began = time.monotonic()
            solver = type(self.settings.solver).__name__
            assert self._child is not None  # it was ready
            self._tell("changed", f"engine process {self._child.pid} answers with {solver}")
            change.done.set()
        if change.done.is_set():
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
        Configuration(1, solver).text()  # refuses what no recording could tell
        if self._change is not None:
            raise EngineFailed("the engine is being changed already, expected one at a time: wait")
        settings = replace(self.settings, solver=solver)
        self._change = change = Change(settings, time.monotonic() + timeout)
        while not change.done.wait(1.0):
            if not self._thread.is_alive():
                change.fail("the skin was stopped")
        if change.failure:
            raise EngineFailed(f"the engine stays as it was: {change.failure}")
        self.wait(TAKES_OVER).close()

    def _gone(self, code: int) -> None:
        said = self._tail()
        names = {each.value: each.name for each in signal.Signals}  # not all numbers have one
        how = f"signal {names.get(-code, -code)}" if code < 0 else f"status {code}"
        last = said.strip().splitlines()[-1] if said.strip() else how
        self.failure = plain_error(last)
        why = "" if self.failure == how else f": {self.failure}"
        self._tell("failed", f"ended with {how}{why}")
        self._again()

    def _again(self) -> None:
        """Start it once more, after a pause that grows while it keeps failing."""
        if time.monotonic() - self._began > SETTLED:
            self._failures = 0
        pause = PAUSES[min(self._failures, len(PAUSES) - 1)]
        self._failures += 1
        self._child = None
        if self._stopping.wait(pause):
            return
        self.restarts += 1
        try:
            self._start()
        except OSError as error:  # no memory or process left for it: perhaps later
            self.failure = str(error)
            self._tell("failed", f"could not be started again: {error}")

    def _hangs(self, pid: int) -> float:
        """How long it has been silent, s, if that is too long; else 0."""
        try:
            with RingReader(self.settings.name) as reader:
                limit = LIMITS.get(reader.state, math.inf)
                silence = (time.monotonic_ns() - reader.heartbeat_ns) * 1e-9
                return silence if reader.pid == pid and silence > limit else 0.0
        except InputError:
            return 0.0

    def _tail(self) -> str:
        return "" if self._said is None else tail_of(self._said)

    def _tell(self, what: str, text: str) -> None:
        self.events.append(Event(time.time_ns(), what, text))
        told = [[each.time_ns, each.what, each.text] for each in self.events]
        path = self.status_path
        new = path.with_suffix(f".{os.getpid()}.new")
        text_of_all = json.dumps({"pid": os.getpid(), "restarts": self.restarts, "events": told})
        try:
            new.write_text(text_of_all)
            new.chmod(0o600)
            new.replace(path)
        except OSError:  # no room: the watch goes on, and `events` has it
            new.unlink(missing_ok=True)

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
                raise EngineFailed(f"the engine does not start: {self.failure}")
            reader = self._reader(state)
            if reader is not None:
                self.never_ran &= state != State.RUNNING
                return reader
            time.sleep(0.02)
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

    def _reader(self, state: State) -> RingReader | None:
        child = self._child
        try:
            reader = RingReader(self.settings.name)
        except InputError:
            return None
        if child is not None and reader.pid == child.pid and state <= reader.state <= State.RUNNING:
            return reader
        reader.close()
        return None

    def stop(self, patience: float = 5.0) -> None:
        """Stop the engine, and take its ring away."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join()
        change, self._change = self._change, None
        if change is not None:
            change.fail("the skin was stopped")
        child, self._child = self._child, None
        if child is not None:
            child.terminate()
            try:
                child.wait(patience)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()
            self._tell("stopped", f"engine process {child.pid}")
        if self._said is not None:
            self._said.close()
        self.status_path.unlink(missing_ok=True)
        address_of(self.settings.name).unlink(missing_ok=True)  # of an engine that was killed
        Ring.remove(self.settings.name)
