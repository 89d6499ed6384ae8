"""Calibration files: arrays, numbers and texts by name, as TOML for people or NPZ for programs."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import FileError
from skinfield.settings import plain_from_toml, text_of_file

FORMAT = "skinfield-calibration"
VERSION = 1


def write_file(path: Path | str, kind: str, table: Mapping[str, Any], words: str = "") -> None:
    """Write a calibration to `path`, ``.npz`` or ``.toml`` by its ending.

    Parameters
    ----------
    path : path
    kind : str
        Of calibration, by which a reader knows what the table holds.
    table : mapping
        Arrays, numbers, texts, and tables of the same.
    words : str
        What is in it, in a line, for people.

    Raises
    ------
    FileError
        If the ending is another, or the file cannot be written.
    """
    path = Path(path)
    whole = {"format": FORMAT, "version": VERSION, "kind": kind, **table}
    try:
        if _ending(path) == ".npz":
            with path.open("wb") as file:
                np.savez(file, **dict(_flat(whole)))
        else:
            import tomli_w

            head = f"# {words}\n" if words else ""
            path.write_text(head + tomli_w.dumps(_plain(whole)), encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror or error}") from error


def read_file(path: Path | str) -> tuple[str, dict[str, Any]]:
    """Kind of a calibration file, and its table.

    Raises
    ------
    FileError
        If the file is missing, of another format or version, or broken.
    """
    path = Path(path)
    if _ending(path) == ".npz":
        content = _read_npz(path)
    else:
        content = dict(plain_from_toml(text_of_file(path), str(path)))
    if str(content.get("format")) != FORMAT:
        raise FileError(
            f"{path} has format {str(content.get('format'))[:40]!r}, expected {FORMAT!r}: "
            "this is not a calibration"
        )
    if str(content.get("version")) != str(VERSION):
        raise FileError(
            f"{path} has version {str(content.get('version'))[:40]}, expected {VERSION}: "
            "it was written by another release"
        )
    return str(content.get("kind", "counts"))[:40], content


def _ending(path: Path) -> str:
    if path.suffix not in (".npz", ".toml"):
        raise FileError(f"{path} ends in {path.suffix!r}, expected .npz or .toml")
    return path.suffix


def _flat(table: Mapping[str, Any]) -> Mapping[str, Any]:
    """Without tables in it: their names stand before a dot."""
    flat: dict[str, Any] = {}
    for name, value in table.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}.{key}": each for key, each in _flat(value).items()}
        else:
            flat[name] = value
    return flat


def _plain(table: Mapping[str, Any]) -> dict[str, Any]:
    """With lists in place of arrays."""
    return {
        name: _plain(value)
        if isinstance(value, Mapping)
        else value.tolist()
        if isinstance(value, np.ndarray | np.generic)
        else value
        for name, value in table.items()
    }


def _read_npz(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = {}
    try:
        with np.load(path, allow_pickle=False) as file:
            for name in file.files:
                *tables, last = name.split(".")
                into = content
                for each in tables:
                    into = into.setdefault(each, {})
                into[last] = file[name]
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror or error}") from error
    except Exception as error:  # zipfile, zlib and NumPy raise all kinds on garbage
        raise FileError(f"{path} is not an NPZ file that can be read: {error}") from error
    return content
