"""Manifest of a folder of results: which windows of which recordings are complete.

A run that was ended goes on where it was. `manifest.json` is written whole or not at all; each
recording has its totals by the first reading of its windows.
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError
from skinfield.files.pending import Pending, explained, write_bytes

FORMAT, VERSION, MANIFEST = "skinfield manifest", 2, "manifest.json"
WINDOW = 4096  # readings of a job: a multiple of the steps and of the chunks that it writes


@dataclass
class Totals:
    """What many readings leave: sums and the highest, whatever their number.

    Attributes
    ----------
    readings : int
    force, highest_force : float, N
        `Estimate.normal_force`: summed over the readings, and the highest.
    peak : int
        The reading of the highest.
    contacts : int
    seconds : float
        That reconstruction took.
    silent : list of int, or None
        Taxels that never answered; None of no reading.
    """

    readings: int = 0
    force: float = 0.0
    highest_force: float = -np.inf
    peak: int = -1
    contacts: int = 0
    seconds: float = 0.0
    silent: list[int] | None = None

    def add(self, other: "Totals") -> None:
        """Take in those of later readings."""
        for name in ("readings", "force", "contacts", "seconds"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        if other.highest_force > self.highest_force:
            self.highest_force, self.peak = other.highest_force, other.peak
        if self.silent is not None:  # of readings before
            self.silent = [taxel for taxel in self.silent if taxel in (other.silent or ())]
        else:
            self.silent = other.silent


@dataclass
class Entry:
    """A recording in a manifest.

    Attributes
    ----------
    path : str
    size, modified_ns : int
        Of its file, or of all files of its folder.
    readings, skipped : int
        Once it was taken in; -1 before.
    windows : dict
        Totals by the first reading of each window that is complete.
    complete : bool
        Whether its folder of results has its name.
    """

    path: str
    size: int
    modified_ns: int
    readings: int = -1
    skipped: int = 0
    windows: dict[str, dict[str, Any]] = field(default_factory=dict)
    complete: bool = False

    @classmethod
    def of(cls, path: str) -> "Entry":
        """A recording that was not begun; raises FileError if there is none."""
        place = Path(path)
        try:
            files = sorted(place.iterdir()) if place.is_dir() else [place]
            stats = [file.stat() for file in files]
        except (OSError, ValueError) as error:
            raise FileError(f"{path} cannot be read: {error}; expected a recording") from error
        newest = max((each.st_mtime_ns for each in stats), default=0)
        return cls(str(place.resolve()), sum(each.st_size for each in stats), newest)

    def left(self) -> list[tuple[int, int]]:
        """Windows that are not complete: their first reading, and the one after the last."""
        firsts = (k for k in range(0, self.readings, WINDOW) if str(k) not in self.windows)
        return [(first, min(first + WINDOW, self.readings)) for first in firsts]

    def totals(self) -> Totals:
        """Of all windows, in their order."""
        whole = Totals()
        for first in sorted(self.windows, key=int):
            whole.add(Totals(**self.windows[first]))
        return whole


@dataclass
class Manifest:
    """Which windows of which recordings are complete; written whole after each.

    Attributes
    ----------
    folder : Path
        Holds `manifest.json`, and a folder of results for each recording.
    settings : dict
        What the results are made with.
    entries : dict of Entry
        By the recordings' names.
    names : tuple of str
        Of the recordings of this run.
    """

    folder: Path
    settings: dict[str, Any]
    entries: dict[str, Entry]
    names: tuple[str, ...]

    @classmethod
    def open(
        cls, folder: str | Path, recordings: Iterable[str], settings: Mapping[str, Any]
    ) -> "Manifest":
        """Begin a run, or go on with one.

        Raises
        ------
        InputError
            If the folder was begun with other settings, or holds something else.
        FileError
            If it cannot be made, or a recording cannot be read.
        """
        folder, settings = Path(folder), dict(settings)
        fresh = {name: Entry.of(path) for name, path in names_of(recordings).items()}
        with explained(folder):
            folder.mkdir(parents=True, exist_ok=True)
            begun = (folder / MANIFEST).exists()
            if not begun and any(folder.iterdir()):
                raise InputError(
                    f"{folder} holds files but no {MANIFEST}, expected a new folder, or that of an "
                    "earlier run"
                )
        entries = _entries_of(folder / MANIFEST, settings) if begun else {}
        for name, entry in fresh.items():
            key = (entry.path, entry.size, entry.modified_ns)
            known = entries.setdefault(name, entry)
            if (known.path, known.size, known.modified_ns) != key:  # another than it was
                entries[name] = entry
        manifest = cls(folder, settings, entries, tuple(fresh))
        manifest.settle()
        return manifest

    def part(self, name: str) -> Path:
        """Folder of results of a recording until it is complete."""
        return self.folder / f".{name}.part"

    def target(self, name: str) -> Path:
        """Folder of results of a recording."""
        return self.folder / f"{name}.skinfield"

    def settle(self) -> None:
        """Give complete folders their names, and forget what is gone."""
        for name, entry in self.entries.items():
            ready = entry.readings > 0 and not entry.left()
            if ready and self.part(name).is_dir():
                Pending(self.target(name), self.part(name)).commit()
                entry.complete = True
            elif ready and self.target(name).is_dir():
                entry.complete = True
            elif entry.complete or not self.part(name).is_dir():
                entry.complete, entry.readings, entry.windows = False, -1, {}
        self.save()

    def save(self) -> None:
        """Write the manifest, whole or not at all."""
        content = {
            "format": FORMAT,
            "version": VERSION,
            "settings": self.settings,
            "window": WINDOW,
            "recordings": {name: asdict(entry) for name, entry in self.entries.items()},
        }
        text = json.dumps(content, indent=1, allow_nan=False)
        write_bytes(self.folder / MANIFEST, (text + "\n").encode())


def names_of(recordings: Iterable[str]) -> dict[str, str]:
    """A name for each recording: its file's, after as many of its folders' as tell them apart."""
    paths = {path: Path(path).resolve().with_suffix("").parts[1:] for path in recordings}
    for length in range(1, max(map(len, paths.values())) + 1):
        names = {"-".join(words[-length:]): path for path, words in paths.items()}
        if len(names) == len(paths):
            return names
    raise InputError(
        f"recordings {', '.join(paths)} differ in their endings alone, expected other names"
    )


def _entries_of(path: Path, settings: Mapping[str, Any]) -> dict[str, Entry]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if (content["format"], content["version"]) != (FORMAT, VERSION):
            raise ValueError(f"it is {content['format']!r} {content['version']!r}")
        before, window = dict(content["settings"]), content["window"]
        entries = {name: Entry(**entry) for name, entry in content["recordings"].items()}
        for entry in entries.values():
            entry.totals()
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise FileError(
            f"{path} cannot be read ({type(error).__name__}: {str(error)[:120]}), expected the "
            "manifest of an earlier run: name another folder"
        ) from error
    other = sorted(key for key in settings if before.get(key) != settings[key])
    if other or window != WINDOW:
        raise InputError(
            f"{path.parent} was begun with other settings ("
            + ", ".join(f"{key} {before.get(key)!r}, not {settings[key]!r}" for key in other)
            + "), expected the same: name another folder"
        )
    return entries
