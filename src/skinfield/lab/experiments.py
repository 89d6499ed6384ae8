"""Experiment catalogue and runner: choose sections, compute what is not there yet, report all.

One experiment more is one file in `sections`, and one line in `EXPERIMENTS`.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from skinfield.errors import InputError
from skinfield.lab.report import (
    Experiment,
    Run,
    Section,
    Settings,
    Verdict,
    program,
    read_section,
    write_report,
    write_section,
)
from skinfield.lab.runner import Outcome, Task
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


@dataclass(frozen=True)
class Finished:
    """Where the report is, which parts failed, with the files of the reasons, and what came out."""

    page: Path
    failures: tuple[tuple[str, Path], ...]
    verdicts: tuple[Verdict, ...]


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
) -> Finished:
    """Compute what `folder` does not hold yet, and write the report.

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
    made: dict[str, Outcome] = {}
    progress("", 0, len(experiments))
    for alone in (False, True):
        tasks = [task_of(each, settings) for each in experiments if each.alone == alone]
        for outcome in run_tasks(tasks, folder, workers=1 if alone else workers):
            made[outcome.name] = outcome
            progress(outcome.name, len(made), len(experiments))
    result = _gathered([made[each.name] for each in experiments], settings)
    page = write_report(replace(result, seconds=time.perf_counter() - start), folder)
    failures = [(n, folder / f"{n}.failed.txt") for n, one in made.items() if one.failure]
    verdicts = tuple(verdict for section in result.sections for verdict in section.verdicts)
    return Finished(page, tuple(failures), verdicts)


def _gathered(outcomes: Sequence[Outcome], settings: Settings) -> Run:
    sections: list[Section] = []
    missing: list[str] = []
    for outcome in outcomes:
        if outcome.failure:
            missing.append(f"{outcome.name} failed: {outcome.failure.strip().splitlines()[-1]}")
        else:
            sections.append(replace(read_section(outcome.folder), seconds=outcome.seconds))
    return Run(settings, tuple(sections), tuple(missing), 0.0)


def task_of(experiment: Experiment, settings: Settings) -> Task:
    """The experiment as a task; other settings and another program make another one."""
    return Task(experiment.name, make_section, (experiment, settings), version=program())


def make_section(folder: Path, experiment: Experiment, settings: Settings) -> None:
    """Run one experiment and write its section into `folder`."""
    write_section(replace(experiment.make(settings), name=experiment.name), folder)
