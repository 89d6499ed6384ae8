"""The whole of the experiments: choose, compute what is not there yet, write the report."""

import hashlib
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path

from skinfield.errors import InputError
from skinfield.experiments.catalogue import EXPERIMENTS
from skinfield.experiments.report import Run, read_section, write_report, write_section
from skinfield.experiments.section import Experiment, Missing, Section
from skinfield.experiments.settings import Settings

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
Outcome = Section | Missing
Progress = Callable[[str, int, int], None]  # what is done, how many, of how many


def chosen(names: Sequence[str]) -> tuple[Experiment, ...]:
    """Experiments by name or by the paper's figures; all if none is named.

    Raises
    ------
    InputError
        For a name that no experiment has.
    """
    wanted = [name.strip().lower() for name in names if name.strip()]
    known = list(dict.fromkeys(tag for each in EXPERIMENTS for tag in (each.name, *each.figures)))
    for name in wanted:
        if name not in known:
            raise InputError(
                f"{name!r} names no experiment, expected some of {', '.join(known)}: sections of "
                "the report, or figures of the paper"
            )
    return tuple(
        each for each in EXPERIMENTS if not wanted or {each.name, *each.figures} & set(wanted)
    )


def run(
    experiments: Sequence[Experiment],
    settings: Settings,
    folder: Path,
    workers: int = 1,
    progress: Progress = lambda name, done, of: None,
) -> Path:
    """Compute what `folder` does not hold yet, and write the report; its path comes back.

    Parameters
    ----------
    experiments : sequence of Experiment
    settings : Settings
    folder : Path
        Sections that an earlier run with the same settings and the same program left there are
        taken as they are.
    workers : int
        Processes at once. What measures time runs by itself, after the others.
    progress : function of (name, done, of)

    Raises
    ------
    FileError
        If the folder cannot be written.
    """
    start = time.perf_counter()
    marks = {each.name: fingerprint(each, settings) for each in experiments}
    found: dict[str, Outcome] = {}
    for each in experiments:
        kept = read_section(each.name, folder, marks[each.name])
        if kept is not None:
            found[each.name] = kept
    total = len(experiments)
    progress("", len(found), total)
    todo = [each for each in experiments if each.name not in found]
    for name, outcome in _outcomes(todo, settings, workers):
        if isinstance(outcome, Section):
            write_section(outcome, folder, marks[name])
        found[name] = outcome
        progress(name, len(found), total)
    outcomes = [found[each.name] for each in experiments]
    result = Run(
        settings,
        tuple(outcome for outcome in outcomes if isinstance(outcome, Section)),
        tuple(outcome.reason for outcome in outcomes if isinstance(outcome, Missing)),
        time.perf_counter() - start,
    )
    return write_report(result, folder)


def made(experiment: Experiment, settings: Settings) -> Outcome:
    """Run one experiment, with its wall time."""
    start = time.perf_counter()
    outcome = experiment.make(settings)
    if isinstance(outcome, Section):
        return replace(outcome, name=experiment.name, seconds=time.perf_counter() - start)
    return outcome


def _outcomes(
    todo: Sequence[Experiment], settings: Settings, workers: int
) -> Iterator[tuple[str, Outcome]]:
    together = [each for each in todo if not each.alone]
    if workers > 1 and len(together) > 1:
        with _one_thread_each(), ProcessPoolExecutor(workers, get_context("spawn")) as pool:
            jobs: dict[Future[Outcome], str] = {
                pool.submit(made, each, settings): each.name for each in together
            }
            for job in as_completed(jobs):
                yield jobs[job], job.result()
    else:
        for each in together:
            yield each.name, made(each, settings)
    for each in todo:
        if each.alone:
            yield each.name, made(each, settings)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Let processes that are started here use one thread: workers fill the cores themselves."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def fingerprint(experiment: Experiment, settings: Settings) -> str:
    """Changes when the settings or the program do."""
    text = f"{experiment.name} {settings!r} {_program()}"
    return hashlib.sha256(text.encode()).hexdigest()[:16]


@lru_cache(maxsize=1)
def _program() -> str:
    """Digest of skinfield's own sources."""
    root = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for file in sorted(root.rglob("*.py")):
        digest.update(str(file.relative_to(root)).encode() + file.read_bytes())
    return digest.hexdigest()
