"""Handover between two engines of a running skin: the next prepares itself beside the first."""

import contextlib
import os
import pickle
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass, field
from typing import IO

from skinfield.errors import InputError
from skinfield.loop.baseline import Baseline
from skinfield.loop.binding import Binding, bind
from skinfield.loop.control import order
from skinfield.loop.model_config import ModelConfig, model_config_of
from skinfield.loop.process_supervisor import Child, last_line, start_python
from skinfield.loop.ring_fields import known_baseline
from skinfield.loop.settings import LiveSettings
from skinfield.loop.update import Updater
from skinfield.ring import RingReader
from skinfield.signal import Port

READY, GO = b"ready\n", b"go\n"
PATIENCE = 2.0  # s for the engine before to end by itself


@dataclass(frozen=True, eq=False)
class Handover:
    """What an engine that takes over is made of.

    Attributes
    ----------
    settings : LiveSettings
    ports : tuple of Port
        Of the sources, which the engine before still holds.
    known : Baseline
        Its calibration: something may lie on the skin.
    """

    settings: LiveSettings
    ports: tuple[Port, ...]
    known: Baseline

    @classmethod
    def of(cls, settings: LiveSettings) -> "Handover":
        """From the engine that runs under the same name.

        Raises
        ------
        InputError
            If none does, or it has no baseline yet.
        """
        with RingReader(settings.name) as reader:
            known, ports = known_baseline(reader), model_config_of(reader).ports
        if known is None:
            raise InputError(
                f"{settings.name!r} has no baseline yet, expected one that answers: wait until it "
                "runs"
            )
        return cls(settings, ports, known)

    def updater(self) -> tuple[Binding, Updater]:
        """The prepared cycle, and what it is bound to."""
        model_config, known = ModelConfig.of(self.settings, self.ports), self.known
        binding = bind(self.settings.skin, self.ports)
        made = Updater(model_config, binding, known.calibration, known.noise_std, known.stale_ns)
        return binding, made


def spawn(asked: LiveSettings | Handover, errors: IO[bytes]) -> Child:
    """Start an engine's process; one that takes over then waits for `GO`."""
    waits = isinstance(asked, Handover)
    child = start_python(
        "skinfield.loop.engine_process",
        str(os.getpid()),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE if waits else subprocess.DEVNULL,
        stderr=errors,
    )
    assert child.stdin is not None  # it is a pipe
    with contextlib.suppress(BrokenPipeError):  # it is gone: whoever watches it says why
        pickle.dump(asked, child.stdin)
        child.stdin.flush()
        if not waits:
            child.stdin.close()
    return child


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
                self.child = spawn(Handover.of(self.settings), self.errors)
                assert self.child.stdout is not None  # it is a pipe
                os.set_blocking(self.child.stdout.fileno(), False)
                return False
            assert self.child.stdout is not None
            if self.child.stdout.read(len(READY)) == READY:
                return True
        except (OSError, InputError) as error:
            self.fail(str(error))
            return False
        if self.child.poll() is not None:
            self.fail(last_line(self.errors) or f"it ended with status {self.child.returncode}")
        elif time.monotonic() > self.end:
            self.fail("it was not ready in time")
        return False

    def fail(self, why: str) -> None:
        """Give it up: all stays as it was."""
        if self.child is not None:
            self.child.kill()
            self.child.wait()
            self._close_pipes()
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
            try:
                before.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                before.kill()
                before.wait()
        assert self.child is not None
        assert self.child.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # it died just now: the supervisor will see
            self.child.stdin.write(GO)
            self.child.stdin.flush()
        self._close_pipes()

    def _close_pipes(self) -> None:
        assert self.child is not None
        for pipe in (self.child.stdin, self.child.stdout):
            assert pipe is not None
            with contextlib.suppress(BrokenPipeError):
                pipe.close()
