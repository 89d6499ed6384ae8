"""Which rings there are."""

import os
from dataclasses import dataclass
from pathlib import Path

from skinfield.errors import FileError
from skinfield.ring import files
from skinfield.ring.header import State
from skinfield.ring.reader import RingReader


@dataclass(frozen=True)
class Present:
    """A ring that was found.

    Attributes
    ----------
    name : str
    path : Path
    pid : int
        Of its writer, or of its last one; 0 if the file is damaged.
    state : State or None
        As the writer last said; None if the file is damaged.
    alive : bool
        Whether its writer lives.
    generation, number : int
        Of writers so far; of the newest slot.
    problem : str
        Why it cannot be read; empty if it can.
    """

    name: str
    path: Path
    pid: int
    state: State | None
    alive: bool
    generation: int
    number: int
    problem: str = ""


def present(folder: Path | None = None) -> tuple[Present, ...]:
    """Rings that are there, by name, with the state of their writers; damaged ones too."""
    paths = sorted(files.folder_of(folder).glob(f"{files.PREFIX}*"))
    return tuple(_look(path) for path in paths if path.is_file())


def _look(path: Path) -> Present:
    name = path.name.removeprefix(files.PREFIX)
    try:
        with RingReader(name, folder=path.parent) as reader:
            return Present(
                name,
                path,
                reader.pid,
                reader.state,
                reader.alive,
                reader.generation,
                reader.number,
            )
    except FileError as error:
        return Present(name, path, 0, None, _written(path), 0, 0, str(error))


def _written(path: Path) -> bool:
    """Whether a living process writes a file that is damaged."""
    try:
        descriptor = files.open_ring(path, write=False)
    except FileError:
        return False
    try:
        return files.locked(descriptor)
    finally:
        os.close(descriptor)
