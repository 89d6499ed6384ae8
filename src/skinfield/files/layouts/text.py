"""Files of text and numbers, with errors that name file and line."""

import math
from collections.abc import Sequence
from pathlib import Path

from skinfield.errors import FileError

LARGEST = 10**18  # of an integer in a file: whatever is above cannot be a count, a row or a uid


def read_bytes(path: Path) -> bytes:
    """All bytes of a file.

    Raises
    ------
    FileError
        When it cannot be opened.
    """
    try:
        return path.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = getattr(error, "strerror", None) or error
        raise FileError(f"{path}: {reason}, expected a layout file that can be read") from error


def read_lines(path: Path) -> list[str]:
    """Lines of a text file, without their ends (LF or CRLF); stray bytes become U+FFFD."""
    return [line.rstrip("\r") for line in read_bytes(path).decode("utf-8", "replace").split("\n")]


def spoilt(path: Path, line: int | None, got: str, expected: str) -> FileError:
    """Error of a line (from 1) of a file: what stands there, cut short, and what was expected."""
    where = f"{path}" if line is None else f"{path}, line {line}"
    shown = got if len(got) <= 60 else got[:57] + "..."
    return FileError(f"{where}: found {shown!r}, expected {expected}")


def numbers(path: Path, line: int, words: Sequence[str], expected: str) -> list[float]:
    """Finite numbers of a line.

    Raises
    ------
    FileError
        When a word is no finite number.
    """
    values = []
    for word in words:
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise spoilt(path, line, word, expected)
        values.append(value)
    return values


def integer(path: Path, line: int | None, word: str, expected: str, lowest: int = 0) -> int:
    """Integer of at least `lowest`.

    Raises
    ------
    FileError
        When the word is none.
    """
    try:
        value = int(word) if len(word) < 25 else LARGEST + 1
    except ValueError:
        value = lowest - 1
    if not lowest <= value <= LARGEST:
        raise spoilt(path, line, word, expected)
    return value


def listed(items: Sequence[object], most: int = 8) -> str:
    """Items in a sentence, the first few of them."""
    shown = ", ".join(str(item) for item in items[:most])
    return shown if len(items) <= most else f"{shown}, ... ({len(items)} in all)"


def many(count: int, noun: str) -> str:
    """Write `1 taxel`, `2 taxels`."""
    return f"{count} {noun}" + ("" if count == 1 else "s")
