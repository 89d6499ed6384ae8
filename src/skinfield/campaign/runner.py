"""Tasks in processes, one event for each that ends."""

import os
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

from skinfield.campaign.outcome import Outcome, check_folder, failure_file, stored
from skinfield.campaign.task import Task
from skinfield.campaign.worker import begin, execute, held_back
from skinfield.errors import InputError

THREADS = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS",
    "NUMBA_NUM_THREADS",
)  # fmt: skip
DIED = "the process died without a word, which mostly means that memory ran out\n"


@dataclass(frozen=True)
class Event:
    """A task has ended.

    Attributes
    ----------
    done, total : int
        Tasks that have ended, well or not, and all of them.
    failures : int
        Of those that have ended.
    reused : int
        Of those that have ended, the ones that had been run before.
    seconds : float
        Since the campaign began.
    outcome : Outcome
        Of the task that has ended.
    """

    done: int
    total: int
    failures: int
    reused: int
    seconds: float
    outcome: Outcome


def run(
    tasks: Sequence[Task], folder: str | Path, *, workers: int = 1, fresh: bool = False
) -> Iterator[Event]:
    """Run tasks and yield an event for each that ends.

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
    check_folder(folder)
    return _events(list(tasks), folder, workers, fresh)


def _check(tasks: Sequence[Task], workers: int) -> None:
    twice = [name for name, count in Counter(task.name for task in tasks).items() if count > 1]
    if twice:
        raise InputError(
            f"{len(twice)} names of tasks come twice, the first is {twice[0]!r}, expected "
            "different ones: each is a folder"
        )
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise InputError(f"workers is {workers!r}, expected a whole number of processes above 0")


def _events(tasks: list[Task], folder: Path, workers: int, fresh: bool) -> Iterator[Event]:
    begun = time.perf_counter()
    failures = reused = 0
    for done, outcome in enumerate(_outcomes(tasks, folder, workers, fresh), start=1):
        failures += bool(outcome.failure)
        reused += outcome.reused
        yield Event(done, len(tasks), failures, reused, time.perf_counter() - begun, outcome)


def _outcomes(tasks: list[Task], folder: Path, workers: int, fresh: bool) -> Iterator[Outcome]:
    todo = []
    for task in tasks:
        before = None if fresh else stored(task, folder)
        if before is None:
            todo.append(task)
        else:
            failure_file(task, folder).unlink(missing_ok=True)
            yield before
    if workers == 1 or len(todo) == 1:
        for task in todo:
            yield execute(task, folder)
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
                pending[pool.submit(execute, task, folder)] = task
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
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=begin)
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
        with held_back():
            yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _died(task: Task, folder: Path) -> Outcome:
    failure_file(task, folder).write_text(DIED, encoding="utf-8")
    return Outcome(task.name, folder / task.name, 0.0, failure=DIED)
