"""Lines of numbers from long files: whole blocks at once, bad lines one by one."""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats
from skinfield.files.recordings.head import decimals_of
from skinfield.files.recordings.stamp import ns_from_text

Progress = Callable[[int, int], None]
BLOCK = 4 << 20  # bytes read at once
WORST = 0.2  # of the lines may be bad; beyond, the file is not what it was taken for
SHOWN = 3  # bad lines that a note names


@dataclass(frozen=True, kw_only=True)
class Grammar:
    """What one line of a file holds.

    Attributes
    ----------
    width : int
        Numbers on a line.
    stamp : int
        Which of them is the time.
    scale : int
        Nanoseconds in the time's unit.
    expected : str
        The same in words, for messages.
    delimiter : str or None
        None stands for any space; with a delimiter, nothing between two of them is a missing value.
    blank : bytes
        Characters that count as spaces.
    decimals : int
        Of the last number on every line, where they agree; tells a cut number from a whole one.
    skip : int
        Lines before the data.
    """

    width: int
    stamp: int
    expected: str
    scale: int = 10**9
    delimiter: str | None = None
    blank: bytes = b""
    decimals: int = 0
    skip: int = 0


@dataclass(frozen=True)
class Block:
    """Good lines of one stretch of a file: line numbers (N,), stamps (N,) ns, numbers (N, W)."""

    line: NDArray[np.int64]
    stamp_ns: NDArray[np.int64]
    table: Floats


@dataclass
class Tally:
    """Counts the lines of a file and remembers the first bad ones."""

    path: Path
    lines: int = 0
    skipped: int = 0
    cut: int = 0
    open_end: bool = False
    first: list[tuple[int, str]] = field(default_factory=list)

    def skip(self, line: int, why: str) -> None:
        """Count a line that cannot be used."""
        self.skipped += 1
        if len(self.first) < SHOWN:
            self.first.append((line, why))

    def check(self, expected: str) -> None:
        """Raise FileError if too much of the file is bad, or nothing is left of it."""
        if self.skipped == self.lines or self.skipped - self.cut > WORST * self.lines:
            line, why = self.first[0] if self.first else (1, "no data follow")
            raise FileError(
                f"{self.path}:{line}: {why}; expected {expected} "
                f"({self.skipped} of {self.lines} lines are unusable; at most {WORST:.0%} may be)"
            )

    def notes(self) -> tuple[str, ...]:
        """What was skipped or is doubtful, in sentences."""
        doubt = "the last line has no end: kept, though its last number may be cut"
        notes = (doubt,) if self.open_end else ()
        if not self.skipped:
            return notes
        where = "; ".join(f"{self.path.name}:{line} {why}" for line, why in self.first)
        more = "; ..." if self.skipped > len(self.first) else ""
        return (f"{self.skipped} of {self.lines} lines skipped: {where}{more}", *notes)


def blocks(
    path: Path, grammar: Grammar, tally: Tally, progress: Progress | None
) -> Iterator[Block]:
    """Good lines of a file, block by block; bad ones go to `tally`."""
    for number, lines, ended in _stretches(path, grammar.blank, progress):
        kept = [
            (number + k, line)
            for k, line in enumerate(lines)
            if number + k > grammar.skip and line and not line.startswith("#")
        ]
        tally.lines += len(kept)
        if kept and not ended:
            _check_end(kept, grammar, tally)
        if kept:
            yield _numbers(kept, grammar, tally)


def _stretches(
    path: Path, blank: bytes, progress: Progress | None
) -> Iterator[tuple[int, list[str], bool]]:
    """Whole lines in stretches: number of the first, lines, whether the last has its end."""
    spaces = bytes.maketrans(blank, b" " * len(blank))
    total, done, number, rest = path.stat().st_size, 0, 1, b""
    with path.open("rb") as file:
        while chunk := file.read(BLOCK):
            chunk = chunk if done else chunk.removeprefix(b"\xef\xbb\xbf")
            done = file.tell()
            whole, end, rest = (rest + chunk).rpartition(b"\n")
            if end:
                lines = _split(whole, spaces)
                yield number, lines, True
                number += len(lines)
            if progress is not None:
                progress(done, max(total, done))
    if rest.strip():
        yield number, _split(rest, spaces), False


def _split(data: bytes, spaces: bytes) -> list[str]:
    # latin-1 never fails: a byte that is no digit makes its own line bad, not the file
    return [line.strip() for line in data.translate(spaces).decode("latin-1").split("\n")]


def _check_end(kept: list[tuple[int, str]], grammar: Grammar, tally: Tally) -> None:
    """Drop a last line without an end where it is not whole."""
    number, line = kept[-1]
    tokens, why = line.split(grammar.delimiter), ""
    if len(tokens) < grammar.width:
        why = f"the file ends after {len(tokens)} of {grammar.width} numbers"
    elif decimals_of(tokens[-1]) < grammar.decimals:
        why = f"the file ends within the number {tokens[-1]!r}"
    if why:
        tally.skip(number, why)
        tally.cut += 1
        kept.pop()
    tally.open_end = not why and not grammar.decimals


def _numbers(kept: list[tuple[int, str]], grammar: Grammar, tally: Tally) -> Block:
    table = _all_at_once([line for _, line in kept], grammar)
    if table is None:
        kept, table = _one_by_one(kept, grammar, tally)
    stamps, good = np.zeros(len(kept), np.int64), np.ones(len(kept), bool)
    for row, (number, line) in enumerate(kept):
        token = line.split(grammar.delimiter, grammar.stamp + 1)[grammar.stamp]
        try:
            stamps[row] = ns_from_text(token, grammar.scale)
        except ValueError as error:
            tally.skip(number, str(error))
            good[row] = False
    numbers = np.array([number for number, _ in kept], np.int64)
    return Block(numbers[good], stamps[good], table if good.all() else table[good])


def _all_at_once(lines: list[str], grammar: Grammar) -> Floats | None:
    """Table of the lines, or None if one of them is not as expected."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            table = np.loadtxt(lines, comments=None, delimiter=grammar.delimiter, ndmin=2)
    except (ValueError, Warning):
        return None
    return table if table.shape == (len(lines), grammar.width) else None


def _one_by_one(
    kept: list[tuple[int, str]], grammar: Grammar, tally: Tally
) -> tuple[list[tuple[int, str]], Floats]:
    good, rows = [], []
    for number, line in kept:
        tokens = line.split(grammar.delimiter)
        try:
            if len(tokens) != grammar.width:
                raise ValueError(f"holds {len(tokens)} numbers, not {grammar.width}")
            rows.append([_number(token) for token in tokens])
            good.append((number, line))
        except ValueError as error:
            tally.skip(number, str(error))
    return good, np.array(rows, np.float64).reshape(len(rows), grammar.width)


def _number(token: str) -> float:
    try:
        if "_" not in token:
            return float(token) if token.strip() else float("nan")
    except ValueError:
        pass
    shown = token if len(token) <= 20 else token[:20] + "..."
    raise ValueError(f"{shown!r} is not a number")
