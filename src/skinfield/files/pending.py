"""Atomic writing of results: under another name and renamed at the end, so whole or not at all."""

import io
import json
import math
import os
import secrets
import shutil
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from skinfield.errors import FileError, InputError


class Closing(ABC):
    """A `with` block around a sink: closed at its end, discarded on an error."""

    @abstractmethod
    def close(self) -> None:
        """Finish."""

    @abstractmethod
    def discard(self) -> None:
        """Give up: nothing is left, and what stood at the result's place stays."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None:
            self.close()
        else:
            self.discard()


@dataclass(frozen=True)
class Pending:
    """A result that is being written: its place, and the name it has until then."""

    target: Path
    part: Path

    def commit(self) -> None:
        """Give the result its name; a result that was there before is replaced."""
        with explained(self.target):
            if self.target.is_dir():  # folders cannot be replaced in one step
                old = self.part.with_name(self.part.name + ".old")
                self.target.rename(old)
                self.part.rename(self.target)
                shutil.rmtree(old)
            else:
                self.part.replace(self.target)

    def discard(self) -> None:
        """Remove what was written."""
        if self.part.is_dir():
            shutil.rmtree(self.part, ignore_errors=True)
        else:
            self.part.unlink(missing_ok=True)


def pending(path: str | Path) -> Pending:
    """A result beside its place, in the same folder so that renaming does not copy.

    Raises
    ------
    FileError
        If there is no such folder, or a folder stands at the place of a file.
    """
    try:
        target = Path(path).resolve()  # what a link points to is written, not the link
    except ValueError as error:  # a zero byte
        raise FileError(f"{str(path)!r} cannot be written: {error}; expected a path") from error
    with explained(target):
        folder = target.parent
        if not folder.is_dir():
            raise FileError(
                f"{target} cannot be written: {folder} is no folder, expected one that is there"
            )
        marks = ("zarr.json", "results.zarr/zarr.json", "metadata.yaml")  # the last: of a bag
        own = any((target / mark).is_file() for mark in marks)
        if target.is_dir() and not own:
            raise FileError(
                f"{target} is a folder that is neither results nor a bag, expected a new name"
            )
        if target.exists() and not (target.is_dir() or target.is_file()):
            raise FileError(f"{target} is no file, expected the name of one: it cannot be replaced")
        if not os.access(folder, os.W_OK):
            raise FileError(f"{target} cannot be written: no permission to write into {folder}")
    return Pending(target, folder / f".{target.name[:80]}.{secrets.token_hex(4)}.part")


@contextmanager
def explained(target: Path) -> Iterator[None]:
    """Turn what the system says about files into FileError."""
    try:
        yield
    except OSError as error:
        raise FileError(
            f"{target} cannot be written: {error.strerror or error}; expected a folder that can be "
            "written to, with room"
        ) from error


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write a small file whole or not at all; raises FileError if it cannot be written."""
    place = pending(path)
    try:
        with explained(place.target), place.part.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        place.commit()
    except BaseException:
        place.discard()
        raise


def write_npz(path: str | Path, arrays: Mapping[str, Any]) -> None:
    """Write arrays as a compressed NPZ file; see `write_bytes`."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    write_bytes(path, buffer.getvalue())


def write_summary(path: str | Path, summary: Mapping[str, Any]) -> None:
    """Write numbers, texts, lists and arrays under their names; NaN and infinities become null.

    Raises
    ------
    InputError
        If a value is none of these.
    FileError
        If the file cannot be written.
    """
    text = json.dumps(plain_json(summary, "summary"), indent=2, ensure_ascii=False, allow_nan=False)
    write_bytes(path, (text + "\n").encode())


def plain_json(value: Any, name: str) -> Any:
    """The value in types that JSON knows; NaN and infinities become None.

    Raises
    ------
    InputError
        If it is no number, text, list, array or mapping; `name` is what the error calls it.
    """
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, np.ndarray | np.generic):
        return plain_json(value.tolist(), name)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain_json(item, f"{name}[{key!r}]") for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain_json(item, f"{name}[{k}]") for k, item in enumerate(value)]
    raise InputError(f"{name} is {value!r}, expected a number, text, list, array or mapping")
