"""Task runner: many runs at once, which can be stopped at any time and gone on with later.

A task is a function of the module level with its arguments. It gets a folder of its own, writes
files there, and may return a summary that JSON can hold::

    tasks = [Task(f"load-{load:g}N", measure, (load, 0)) for load in (0.2, 0.5, 1.8)]
    for outcome in run(tasks, "out", workers=2):
        print(outcome.name, outcome.failure or outcome.result)

Afterwards ``out/load-0.2N`` holds its files and ``task.json``: the fingerprint of the task, the
seconds that it took and its summary. The folder appears whole or not at all, as it is written
under another name. A task whose folder has the same fingerprint, a hash of the function's name,
the arguments and the task's `version`, is not run again. A task that fails leaves its traceback
in ``out/load-0.2N.failed.txt`` and stops no other.

With more than one worker tasks run in processes of their own, with one thread each for BLAS and
Numba; a script that calls `run` then needs ``if __name__ == "__main__":``. One call of `run` at a
time may write to a folder.
"""

import hashlib
import json
import os
import shutil
import signal
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError

RECORD = "task.json"
THREADS = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS",
    "NUMBA_NUM_THREADS",
)  # fmt: skip
DIED = "the process died without a word, which mostly means that memory ran out\n"


@dataclass(frozen=True)
class Task:
    """A function and its arguments.

    Parameters
    ----------
    name : str
        Of its folder: letters, digits and ``._+=,-``; another one for each task of a run.
    function : callable
        ``function(folder, *arguments)`` of the module level; returns what JSON can hold, or None;
        NaN becomes None.
    arguments : tuple
        Of numbers, texts, arrays, functions, dataclasses of those, and tuples of all.
    version : str
        Another one makes earlier results void.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    version: str = ""

    @property
    def fingerprint(self) -> str:
        """Of function, arguments and version, 32 hexadecimal digits; the name is not in it."""
        text = canonical((self.function, self.arguments, self.version))
        return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def canonical(value: Any) -> str:
    """Text of a value, the same in every process, and another one of another value."""
    if isinstance(value, np.ndarray):
        content = hashlib.blake2b(np.ascontiguousarray(value).tobytes()).hexdigest()
        return f"{value.dtype.str}{value.shape}{content}"
    if is_dataclass(value) and not isinstance(value, type):
        names = [each.name for each in fields(value) if each.init]
        parts = [f"{name}={canonical(getattr(value, name))}" for name in names]
        return f"{type(value).__qualname__}({', '.join(parts)})"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(canonical, value))})"
    if hasattr(value, "__qualname__"):
        return f"{value.__module__}.{value.__qualname__}"
    return repr(value)


@dataclass(frozen=True)
class TaskOutcome:
    """How a task went.

    Attributes
    ----------
    name : str
    seconds : float
        That it took when it was run.
    result : object
        What it returned, as JSON gives it back.
    reused : bool
        It had been run before.
    failure : str
        Traceback, or "" where all went well.
    """

    name: str
    seconds: float
    result: Any = None
    reused: bool = False
    failure: str = ""


def stored(task: Task, folder: str | Path) -> TaskOutcome | None:
    """What an earlier run left of this very task; None if nothing, or of another fingerprint."""
    try:
        record = json.loads((Path(folder) / task.name / RECORD).read_text(encoding="utf-8"))
        if record["fingerprint"] != task.fingerprint:
            return None
        return TaskOutcome(task.name, float(record["seconds"]), record["result"], reused=True)
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return None  # as good as not there: it is run again


def _part_of(task: Task, folder: Path) -> Path:
    """Folder that a task writes to until it is whole."""
    return folder / f".{task.name}.part"


def _failure_file(task: Task, folder: Path) -> Path:
    """Where the traceback of a failed task is."""
    return folder / f"{task.name}.failed.txt"


def run(tasks: Sequence[Task], folder: str | Path, *, workers: int = 1) -> Iterator[TaskOutcome]:
    """Run tasks and yield the outcome of each as it ends, well or not.

    Whoever stops asking stops the runs, and Ctrl-C does.

    Parameters
    ----------
    tasks : sequence of Task
        Of different names.
    folder : str or Path
        Made if it is not there; each task gets the folder of its name in it.
    workers : int
        Processes at once; with 1 tasks run in this one.

    Raises
    ------
    FileError
        If the folder cannot be made.
    """
    folder, todo = Path(folder), []
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(
            f"{folder} cannot be made: {error.strerror or error}; expected a name for a folder"
        ) from error
    for task in tasks:
        before = stored(task, folder)
        if before is None:
            todo.append(task)
        else:
            _failure_file(task, folder).unlink(missing_ok=True)
            yield before
    if workers == 1 or len(todo) == 1:
        for task in todo:
            yield _execute(task, folder)
    else:
        yield from _in_processes(todo, folder, min(workers, len(todo)))


def _in_processes(todo: list[Task], folder: Path, workers: int) -> Iterator[TaskOutcome]:
    """All at once; if a process dies, the rest one by one, as then it is clear who killed it."""
    left = {task.name: task for task in todo}
    alone = False
    try:
        while left:
            with _pool(1 if alone else workers) as pool:
                batch = list(left.values())[: 1 if alone else None]
                futures = {pool.submit(_execute, task, folder): task for task in batch}
                for future in as_completed(futures):
                    task = futures[future]
                    try:
                        outcome = future.result()
                    except BrokenProcessPool:
                        if not alone:
                            continue
                        outcome = _failed(task, folder, 0.0, DIED)
                    del left[task.name]
                    yield outcome
            alone = True
    finally:
        for task in left.values():
            shutil.rmtree(_part_of(task, folder), ignore_errors=True)


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that start afresh: threads and locks of this one cannot hang them.

    They have one thread for each of the numerical libraries, and Ctrl-C ends them at once.
    """
    before = dict(os.environ)
    os.environ.update(dict.fromkeys(THREADS, "1"))
    ended_by = (signal.SIGINT, signal.SIG_DFL)
    pool = ProcessPoolExecutor(
        workers, get_context("spawn"), initializer=signal.signal, initargs=ended_by
    )
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        for name in THREADS:
            del os.environ[name]
        os.environ.update(before)


def _execute(task: Task, folder: Path) -> TaskOutcome:
    """Run a task; its folder gets its name when it is whole, and a failure becomes a text."""
    part, place, begun = _part_of(task, folder), folder / task.name, time.perf_counter()
    shutil.rmtree(part, ignore_errors=True)  # of a run that was killed
    try:
        part.mkdir()
        result = task.function(part, *task.arguments)
        (part / RECORD).write_bytes(_record(task, time.perf_counter() - begun, result))
        shutil.rmtree(place, ignore_errors=True)
        part.replace(place)
        _failure_file(task, folder).unlink(missing_ok=True)
    except Exception:
        return _failed(task, folder, time.perf_counter() - begun, traceback.format_exc())
    finally:
        shutil.rmtree(part, ignore_errors=True)
    found = stored(task, folder)
    assert found is not None, f"{place} vanished while it was written"
    return TaskOutcome(found.name, found.seconds, found.result)


def _failed(task: Task, folder: Path, seconds: float, text: str) -> TaskOutcome:
    _failure_file(task, folder).write_text(text, encoding="utf-8")
    return TaskOutcome(task.name, seconds, failure=text)


def _record(task: Task, seconds: float, result: Any) -> bytes:
    import msgspec

    record = {
        "name": task.name, "fingerprint": task.fingerprint, "seconds": seconds, "result": result,
    }  # fmt: skip
    try:
        return msgspec.json.format(msgspec.json.encode(record, enc_hook=float), indent=1) + b"\n"
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{task.name} returned {result!r}, expected None or what JSON can hold ({error}): "
            "write arrays to files in the folder"
        ) from error
