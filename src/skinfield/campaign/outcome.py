"""What a task left, in its folder and in memory."""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skinfield.campaign.task import Task
from skinfield.errors import FileError, InputError

RECORD = "task.json"


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


def part_of(task: Task, folder: Path) -> Path:
    """Folder that a task writes to until it is whole."""
    return folder / f".{task.name}.part"


def clear(path: Path) -> None:
    """Remove a folder or file, if it is there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def seal(task: Task, folder: Path, seconds: float, result: Any) -> None:
    """Write the record and give the task's folder its name; an older one is replaced."""
    part, place = part_of(task, folder), folder / task.name
    record = {
        "name": task.name,
        "function": f"{task.function.__module__}.{task.function.__qualname__}",
        "version": task.version,
        "fingerprint": task.fingerprint,
        "seconds": seconds,
        "result": result,
    }
    try:
        text = json.dumps(record, indent=1, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{task.name} returned {result!r}, expected None or what JSON can hold ({error}): "
            "write arrays to files in the folder"
        ) from error
    (part / RECORD).write_text(text + "\n", encoding="utf-8")
    clear(place)
    part.replace(place)


def check_folder(folder: Path) -> None:
    """Make the folder of a campaign, or say why not."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(
            f"{folder} cannot be made: {error.strerror or error}; expected a name for a folder"
        ) from error


def failure_file(task: Task, folder: Path) -> Path:
    """Where the traceback of a failed task is."""
    return folder / f"{task.name}.failed.txt"
