"""One task, in whichever process."""

import signal
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from skinfield.campaign.outcome import Outcome, clear, failure_file, part_of, seal, stored
from skinfield.campaign.task import Task


def begin() -> None:
    """Let a process that waits for tasks sleep through Ctrl-C: only tasks are interrupted."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # see `held_back`


@contextmanager
def held_back() -> Iterator[None]:
    """Ctrl-C comes at the end; processes that are started meanwhile hear it after `begin` only.

    While one imports what it needs it could but print a traceback.
    """
    if not hasattr(signal, "pthread_sigmask"):  # not on every system
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _interruptible() -> Iterator[None]:
    """Ctrl-C stops the task that is running."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)


def execute(task: Task, folder: Path) -> Outcome:
    """Run a task; its folder gets its name when it is whole, and a failure becomes a text."""
    part, begun = part_of(task, folder), time.perf_counter()
    clear(part)  # of a run that was killed
    try:
        with _interruptible():
            part.mkdir()
            result = task.function(part, *task.arguments)
            seal(task, folder, time.perf_counter() - begun, result)
        failure_file(task, folder).unlink(missing_ok=True)
    except Exception:
        text = traceback.format_exc()
        failure_file(task, folder).write_text(text, encoding="utf-8")
        seconds = time.perf_counter() - begun
        return Outcome(task.name, folder / task.name, seconds, failure=text)
    finally:
        clear(part)
    written = stored(task, folder)
    assert written is not None, f"{folder / task.name} vanished while it was written"
    return Outcome(task.name, written.folder, written.seconds, written.result)
