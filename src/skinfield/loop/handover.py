"""A running skin changes to another engine: the next one prepares itself beside the first."""

import contextlib
import os
import pickle
import re
import subprocess
import sys
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
from skinfield.loop.ring_fields import known_baseline
from skinfield.loop.settings import LiveSettings
from skinfield.loop.update import Updater
from skinfield.ring import RingReader
from skinfield.signal import Port

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
READY, GO = b"ready\n", b"go\n"
TAIL = 4000  # characters of what it said last
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


def spawn(asked: LiveSettings | Handover, said: IO[bytes]) -> "subprocess.Popen[bytes]":
    """Start an engine's process; one that takes over then waits for `GO`."""
    waits = isinstance(asked, Handover)
    child = subprocess.Popen(
        [sys.executable, "-m", "skinfield.loop.engine_process", str(os.getpid())],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE if waits else subprocess.DEVNULL,
        stderr=said,
        process_group=0,  # a terminal's Ctrl-C is meant for us: we end it
        env=os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
    assert child.stdin is not None  # it is a pipe
    try:
        pickle.dump(asked, child.stdin)
        if waits:
            child.stdin.flush()
        else:
            child.stdin.close()
    except BrokenPipeError:
        pass  # it is gone: whoever watches it says why
    return child


def nameless_file() -> IO[bytes]:
    """For what an engine says; it goes with its last reader."""
    return tempfile.TemporaryFile()


def tail_of(said: IO[bytes]) -> str:
    """What an engine said last."""
    size = said.seek(0, os.SEEK_END)
    said.seek(max(size - TAIL, 0))
    return said.read().decode(errors="replace")


def plain_error(line: str) -> str:
    """The last line of a traceback without the name of skinfield's own error."""
    return re.sub(r"^skinfield\.errors\.\w+: ", "", line)


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
    done : Event
    failure : str
        Why the engine before goes on; empty when the change is made.
    """

    settings: LiveSettings
    end: float
    done: threading.Event = field(default_factory=threading.Event, init=False)
    failure: str = field(default="", init=False)
    child: "subprocess.Popen[bytes] | None" = field(default=None, init=False)
    said: IO[bytes] | None = field(default=None, init=False)

    def step(self) -> bool:
        """Go on; whether the next engine is ready."""
        try:
            if self.child is None:
                self.said = nameless_file()
                self.child = spawn(Handover.of(self.settings), self.said)
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
            assert self.said is not None
            lines = tail_of(self.said).strip().splitlines()
            last = lines[-1] if lines else f"it ended with status {self.child.returncode}"
            self.fail(plain_error(last))
        elif time.monotonic() > self.end:
            self.fail("it was not ready in time")
        return False

    def fail(self, why: str) -> None:
        """Give it up: all stays as it was."""
        if self.child is not None:
            self.child.kill()
            self.child.wait()
            self._close_pipes()
        if self.said is not None:
            self.said.close()
        self.failure = why
        self.done.set()

    def switch(self, before: "subprocess.Popen[bytes] | None") -> None:
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
