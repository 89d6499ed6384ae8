"""Task runner: many runs at once, which can be stopped at any time and gone on with later.

A task is a function of the module level with its arguments. It gets a folder of its own, writes
files there, and may return a summary that JSON can hold::

    def measure(folder: Path, load: float, seed: int) -> dict[str, float]:
        np.savez(folder / "result.npz", ...)
        return {"peak_N": load}

    tasks = [Task(f"load-{load:g}N", measure, (load, 0)) for load in (0.2, 0.5, 1.8)]
    for outcome in run(tasks, "out", workers=2):
        print(outcome.name, outcome.failure or outcome.result)

Afterwards ``out/load-0.2N`` holds ``result.npz`` and ``task.json``: the fingerprint of the task,
the seconds that it took and its summary. The folder appears whole or not at all, as it is written
under another name. A task whose folder has the same fingerprint, a hash of the function's name,
the arguments and the task's `version`, is not run again. A task that fails leaves its traceback
in ``out/load-0.2N.failed.txt`` and stops no other.

`run` is a generator of `Outcome`; whoever stops asking stops the runs, and Ctrl-C does. With
more than one worker tasks run in processes of their own, with one thread each for BLAS and
Numba; a script that calls `run` then needs ``if __name__ == "__main__":``. `stored` reads what
there is without running anything. One call of `run` at a time may write to a folder.
"""

import hashlib
import json
import os
import re
import shutil
import signal
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from multiprocessing import get_context
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+=,-]{0,119}", re.ASCII)
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
        Of its folder: letters, digits and ``._+=,-``.
    function : callable
        ``function(folder, *arguments)`` of the module level; returns what JSON can hold, or None;
        NaN becomes None.
    arguments : tuple
        Of what `fingerprint` knows.
    version : str
        Another one makes earlier results void.
    """

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    version: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not NAME.fullmatch(self.name):
            raise InputError(
                f"name is {self.name!r}, expected up to 120 letters, digits and ._+=,- that begin "
                "with a letter or digit: it becomes the name of a folder"
            )
        if "<" in _qualified(self.function):
            raise InputError(
                f"function of {self.name} is {_qualified(self.function)}, expected one of the "
                "module level: other processes must be able to import it"
            )

    @property
    def fingerprint(self) -> str:
        """Of function, arguments and version; the name is not in it."""
        return fingerprint((_qualified(self.function), self.arguments, self.version))


def fingerprint(value: Any) -> str:
    """Hash of a value that is the same in every process, 32 hexadecimal digits.

    Parameters
    ----------
    value : object
        Of None, bool, int, float, complex, str, bytes, paths, enums, NumPy arrays and numbers,
        functions and classes (by name), dataclasses and other objects (by their attributes), and
        tuples, lists, sets and mappings of those.

    Raises
    ------
    InputError
        For anything else: what it holds cannot be seen.
    """
    text = _canonical(value).encode("utf-8", "surrogatepass")
    return hashlib.blake2b(text, digest_size=16).hexdigest()


def _qualified(function: Callable[..., Any]) -> str:
    return f"{function.__module__}.{function.__qualname__}"


def _canonical(value: Any) -> str:
    """The value's types and contents, such that two values differ where their texts do."""
    if isinstance(value, np.generic):
        value = value.item()
    kind = type(value).__qualname__
    if isinstance(value, np.ndarray) and value.dtype != object:
        content = hashlib.blake2b(np.ascontiguousarray(value).tobytes()).hexdigest()
        return f"{kind}({value.dtype.str}{value.shape}{content})"
    parts: list[str]
    if value is None or isinstance(value, int | float | complex | str | bytes | Enum | PurePath):
        parts = [repr(value)]
    elif is_dataclass(value) and not isinstance(value, type):  # other fields are no part of it
        named = [each.name for each in fields(value) if each.compare]
        parts = [f"{name}={_canonical(getattr(value, name))}" for name in named]
    elif isinstance(value, tuple | list):
        parts = [_canonical(item) for item in value]
    elif isinstance(value, Mapping):
        parts = sorted(f"{_canonical(key)}:{_canonical(item)}" for key, item in value.items())
    elif isinstance(value, set | frozenset):
        parts = sorted(_canonical(item) for item in value)
    elif callable(value) and hasattr(value, "__qualname__"):
        parts = [_qualified(value)]
    elif hasattr(value, "__dict__"):
        parts = [_canonical(vars(value))]
    else:
        raise InputError(
            f"an argument is {value!r} of {kind}, expected numbers, texts, arrays, dataclasses, or "
            "collections of them: what else it holds cannot be hashed"
        )
    return f"{kind}({', '.join(parts)})"


@dataclass(frozen=True)
class Outcome:
    """How a task went.

    Attributes
    ----------
    name : str
    folder : Path
        Of its files; not there where it failed.
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
    folder: Path
    seconds: float
    result: Any = None
    reused: bool = False
    failure: str = ""


def stored(task: Task, folder: str | Path) -> Outcome | None:
    """What an earlier run left of this very task; None if nothing, or of another fingerprint."""
    place = Path(folder) / task.name
    try:
        record = json.loads((place / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None  # as good as not there: it is run again
    if not isinstance(record, dict) or record.get("fingerprint") != task.fingerprint:
        return None
    seconds = record.get("seconds")
    if isinstance(seconds, bool) or not isinstance(seconds, int | float):
        return None
    return Outcome(task.name, place, float(seconds), record.get("result"), reused=True)


def _part_of(task: Task, folder: Path) -> Path:
    """Folder that a task writes to until it is whole."""
    return folder / f".{task.name}.part"


def _clear(path: Path) -> None:
    """Remove a folder or file, if it is there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _seal(task: Task, folder: Path, seconds: float, result: Any) -> None:
    """Write the record and give the task's folder its name; an older one is replaced."""
    import msgspec

    part, place = _part_of(task, folder), folder / task.name
    record = {
        "name": task.name,
        "function": f"{task.function.__module__}.{task.function.__qualname__}",
        "version": task.version,
        "fingerprint": task.fingerprint,
        "seconds": seconds,
        "result": result,
    }
    try:
        text = msgspec.json.format(msgspec.json.encode(record, enc_hook=float), indent=1)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{task.name} returned {result!r}, expected None or what JSON can hold ({error}): "
            "write arrays to files in the folder"
        ) from error
    (part / RECORD).write_bytes(text + b"\n")
    _clear(place)
    part.replace(place)


def _check_folder(folder: Path) -> None:
    """Make the folder of a campaign, or say why not."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(
            f"{folder} cannot be made: {error.strerror or error}; expected a name for a folder"
        ) from error


def _failure_file(task: Task, folder: Path) -> Path:
    """Where the traceback of a failed task is."""
    return folder / f"{task.name}.failed.txt"


def run(
    tasks: Sequence[Task], folder: str | Path, *, workers: int = 1, fresh: bool = False
) -> Iterator[Outcome]:
    """Run tasks and yield the outcome of each as it ends, well or not.

    Parameters
    ----------
    tasks : sequence of Task
        Of different names.
    folder : str or Path
        Made if it is not there; each task gets the folder of its name in it.
    workers : int
        Processes at once; with 1 tasks run in this one.
    fresh : bool
        Run all anew, whatever there is.

    Raises
    ------
    InputError
        If two tasks have one name, or `workers` is below 1.
    FileError
        If the folder cannot be made.
    """
    folder = Path(folder)
    _check(tasks, workers)
    _check_folder(folder)
    return _outcomes(list(tasks), folder, workers, fresh)


def _check(tasks: Sequence[Task], workers: int) -> None:
    twice = [name for name, count in Counter(task.name for task in tasks).items() if count > 1]
    if twice:
        raise InputError(
            f"{len(twice)} names of tasks come twice, the first is {twice[0]!r}, expected "
            "different ones: each is a folder"
        )
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise InputError(f"workers is {workers!r}, expected a whole number of processes above 0")


def _outcomes(tasks: list[Task], folder: Path, workers: int, fresh: bool) -> Iterator[Outcome]:
    todo = []
    for task in tasks:
        before = None if fresh else stored(task, folder)
        if before is None:
            todo.append(task)
        else:
            _failure_file(task, folder).unlink(missing_ok=True)
            yield before
    if workers == 1 or len(todo) == 1:
        for task in todo:
            yield _execute(task, folder)
    elif todo:
        yield from _in_processes(todo, folder, min(workers, len(todo)))


def _in_processes(todo: list[Task], folder: Path, workers: int) -> Iterator[Outcome]:
    """All at once; if a process dies, the rest one by one, as then it is clear who killed it."""
    left = {task.name: task for task in todo}
    with _pool(workers) as pool:
        for task, outcome in _completed(pool, todo, folder):
            if outcome is not None:
                del left[task.name]
                yield outcome
    for task in left.values():
        with _pool(1) as pool:
            for _, outcome in _completed(pool, [task], folder):
                yield outcome or _died(task, folder)


def _completed(
    pool: ProcessPoolExecutor, tasks: list[Task], folder: Path
) -> Iterator[tuple[Task, Outcome | None]]:
    """Tasks as they end, with None for those whose process died."""
    with _one_thread_each():
        pending: dict[Future[Outcome], Task] = {}
        for task in tasks:
            try:
                pending[pool.submit(_execute, task, folder)] = task
            except BrokenProcessPool:
                break
    while pending:
        for future in wait(pending, return_when=FIRST_COMPLETED).done:
            task = pending.pop(future)
            try:
                yield task, future.result()
            except BrokenProcessPool:
                yield task, None


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that start afresh: threads and locks of this one cannot hang them."""
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_begin)
    try:
        yield pool
    finally:  # after Ctrl-C too: what is running gets the same signal, what waits never begins
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Processes that are started meanwhile have one thread for each of the numerical libraries.

    Nor does Ctrl-C reach them before they are ready for it; here it waits until they are started.
    """
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        with _held_back():
            yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _died(task: Task, folder: Path) -> Outcome:
    _failure_file(task, folder).write_text(DIED, encoding="utf-8")
    return Outcome(task.name, folder / task.name, 0.0, failure=DIED)


def _begin() -> None:
    """Let a process that waits for tasks sleep through Ctrl-C: only tasks are interrupted."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # see `_held_back`


@contextmanager
def _held_back() -> Iterator[None]:
    """Ctrl-C comes at the end; processes that are started meanwhile hear it after `_begin` only.

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


def _execute(task: Task, folder: Path) -> Outcome:
    """Run a task; its folder gets its name when it is whole, and a failure becomes a text."""
    part, begun = _part_of(task, folder), time.perf_counter()
    _clear(part)  # of a run that was killed
    try:
        with _interruptible():
            part.mkdir()
            result = task.function(part, *task.arguments)
            _seal(task, folder, time.perf_counter() - begun, result)
        _failure_file(task, folder).unlink(missing_ok=True)
    except Exception:
        text = traceback.format_exc()
        _failure_file(task, folder).write_text(text, encoding="utf-8")
        seconds = time.perf_counter() - begun
        return Outcome(task.name, folder / task.name, seconds, failure=text)
    finally:
        _clear(part)
    written = stored(task, folder)
    assert written is not None, f"{folder / task.name} vanished while it was written"
    return Outcome(task.name, written.folder, written.seconds, written.result)
