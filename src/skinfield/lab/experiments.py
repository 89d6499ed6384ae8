"""Experiment catalogue and runner: choose sections, compute what is not there yet, report all.

One experiment more is one file in `sections`, and one line in `EXPERIMENTS`.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from skinfield.errors import InputError
from skinfield.lab.report import (
    Chapter,
    Effort,
    Experiment,
    Run,
    program,
    write_files,
    write_report,
)
from skinfield.lab.runner import Task, TaskOutcome
from skinfield.lab.runner import run as run_tasks
from skinfield.lab.sections.agreement import agreement
from skinfield.lab.sections.detection import detection
from skinfield.lab.sections.imposed import imposed
from skinfield.lab.sections.resolutions import resolutions
from skinfield.lab.sections.timing import timing

EXPERIMENTS = (
    Experiment("imposed", ("fig3", "fig4", "fig5"), imposed),
    Experiment("detection", ("fig6", "fig7"), detection),
    Experiment("resolutions", ("fig8",), resolutions),
    Experiment("timing", ("fig9",), timing, alone=True),
    Experiment("agreement", ("fem", "model"), agreement),
)
Progress = Callable[[str, int, int], None]  # name of what has ended, how many have, of how many


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
    settings: Effort,
    folder: Path,
    workers: int = 1,
    progress: Progress = lambda name, done, of: None,
) -> Run:
    """Compute what `folder` does not hold yet, and write the report.

    Parameters
    ----------
    experiments : sequence of Experiment
    settings : Effort
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
    import msgspec

    start = time.perf_counter()
    made: dict[str, TaskOutcome] = {}
    progress("", 0, len(experiments))
    for alone in (False, True):
        tasks = [task_of(each, settings) for each in experiments if each.alone == alone]
        for outcome in run_tasks(tasks, folder, workers=1 if alone else workers):
            made[outcome.name] = outcome
            progress(outcome.name, len(made), len(experiments))
    sections, failures = [], {}
    for outcome in (made[each.name] for each in experiments):
        if outcome.failure:
            failures[outcome.name] = outcome.failure.strip().splitlines()[-1]
        else:
            section = msgspec.convert(outcome.result, Chapter)
            sections.append(replace(section, seconds=outcome.seconds))
    result = Run(settings, tuple(sections), failures, time.perf_counter() - start)
    write_report(result, folder)
    return result


def task_of(experiment: Experiment, settings: Effort) -> Task:
    """The experiment as a task; other settings and another program make another one."""
    return Task(experiment.name, make_section, (experiment, settings), version=program())


def make_section(folder: Path, experiment: Experiment, settings: Effort) -> Chapter:
    """Run one experiment; its pictures and tables become files in `folder`, too."""
    section = replace(experiment.make(settings), name=experiment.name)
    write_files(section, folder)
    return section
