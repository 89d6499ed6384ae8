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
import re
import shutil
import signal
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass, replace
from enum import Enum
from multiprocessing import get_context
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError, check_count

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
        if record["fingerprint"] != task.fingerprint:
            return None
        seconds, result = float(record["seconds"]), record["result"]
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return None  # as good as not there: it is run again
    return Outcome(task.name, place, seconds, result, reused=True)


def _part_of(task: Task, folder: Path) -> Path:
    """Folder that a task writes to until it is whole."""
    return folder / f".{task.name}.part"


def _failure_file(task: Task, folder: Path) -> Path:
    """Where the traceback of a failed task is."""
    return folder / f"{task.name}.failed.txt"


def _clear(path: Path) -> None:
    """Remove a folder or file, if it is there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def run(tasks: Sequence[Task], folder: str | Path, *, workers: int = 1) -> Iterator[Outcome]:
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
    InputError
        If two tasks have one name, or `workers` is below 1.
    FileError
        If the folder cannot be made.
    """
    folder = Path(folder)
    twice = [name for name, count in Counter(task.name for task in tasks).items() if count > 1]
    if twice:
        raise InputError(
            f"{len(twice)} names of tasks come twice, the first is {twice[0]!r}, expected "
            "different ones: each is a folder"
        )
    check_count("workers", workers, 1, 4096, "processes at once")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(
            f"{folder} cannot be made: {error.strerror or error}; expected a name for a folder"
        ) from error
    return _outcomes(list(tasks), folder, workers)


def _outcomes(tasks: list[Task], folder: Path, workers: int) -> Iterator[Outcome]:
    todo = []
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
    elif todo:
        yield from _in_processes(todo, folder, min(workers, len(todo)))


def _in_processes(todo: list[Task], folder: Path, workers: int) -> Iterator[Outcome]:
    """All at once; if a process dies, the rest one by one, as then it is clear who killed it."""
    left = {task.name: task for task in todo}
    alone = False
    try:
        while left:
            with _pool(1 if alone else workers) as pool:
                with _one_thread_each():
                    batch = list(left.values())[: 1 if alone else None]
                    futures = {pool.submit(_execute, task, folder): task for task in batch}
                for future in as_completed(futures):
                    task = futures[future]
                    try:
                        outcome = future.result()
                    except BrokenProcessPool:
                        if not alone:
                            continue
                        _failure_file(task, folder).write_text(DIED, encoding="utf-8")
                        outcome = Outcome(task.name, folder / task.name, 0.0, failure=DIED)
                    del left[task.name]
                    yield outcome
            alone = True
    finally:
        for task in left.values():
            _clear(_part_of(task, folder))


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that start afresh: threads and locks of this one cannot hang them."""
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_begin)
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _begin() -> None:
    """Let Ctrl-C end a process at once; the parent clears up."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Processes that are started meanwhile have one thread for each of the numerical libraries."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _execute(task: Task, folder: Path) -> Outcome:
    """Run a task; its folder gets its name when it is whole, and a failure becomes a text."""
    part, place, begun = _part_of(task, folder), folder / task.name, time.perf_counter()
    _clear(part)  # of a run that was killed
    try:
        part.mkdir()
        result = task.function(part, *task.arguments)
        seconds = time.perf_counter() - begun
        (part / RECORD).write_bytes(_record(task, seconds, result))
        _clear(place)
        part.replace(place)
        _failure_file(task, folder).unlink(missing_ok=True)
    except Exception:
        text = traceback.format_exc()
        _failure_file(task, folder).write_text(text, encoding="utf-8")
        return Outcome(task.name, place, time.perf_counter() - begun, failure=text)
    finally:
        _clear(part)
    found = stored(task, folder)
    assert found is not None, f"{place} vanished while it was written"
    return replace(found, reused=False)


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
