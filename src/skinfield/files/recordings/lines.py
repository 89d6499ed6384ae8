"""Lines of numbers from long files: whole blocks at once, bad lines one by one."""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats
from skinfield.files.recordings.head import decimals_of

Progress = Callable[[int, int], None]
BLOCK = 4 << 20  # bytes read at once
WORST = 0.2  # of the lines may be bad; beyond, the file is not what it was taken for
SHOWN = 3  # bad lines that a note names
LIMIT = 2**63 - 1  # ns


@dataclass(frozen=True, kw_only=True)
class Contents:
    """What the lines of a file hold, as its first ones tell.

    Attributes
    ----------
    path : Path
    width : int
        Numbers on a line.
    stamp : int
        Which of them is the time.
    scale : int
        Nanoseconds in the time's unit.
    expected : str
        What a line holds in words, for messages.
    keep : (C,) int array
        Columns that are readings.
    delimiter : str or None
        None stands for any space; with a delimiter, nothing between two of them is a missing value.
    blank : bytes
        Characters that count as spaces.
    decimals : int
        Of the last number on every line, where they agree; tells a cut number from a whole one.
    skip : int
        Lines before the data.
    check : callable, optional
        Mends or drops the lines of a block.
    uid : (C,) uint64 array, optional
        Of the columns.
    channel : (C,) int array, optional
        Of the columns; channels without one are missing. Default their order.
    unit, source : str
    notes : tuple of str
    sequenced : bool
        Whether the first column counts messages, so that gaps are lost ones.
    """

    path: Path
    width: int
    expected: str
    keep: NDArray[np.int64]
    stamp: int = 1
    scale: int = 10**9
    delimiter: str | None = None
    blank: bytes = b""
    decimals: int = 0
    skip: int = 0
    check: "Callable[[Block, Tally], Block] | None" = None
    uid: NDArray[np.uint64] | None = None
    channel: NDArray[np.int64] | None = None
    unit: str = "count"
    source: str = ""
    notes: tuple[str, ...] = ()
    sequenced: bool = False


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


def blocks(what: Contents, tally: Tally, progress: Progress | None) -> Iterator[Block]:
    """Good lines of a file, block by block; bad ones go to `tally`."""
    for number, lines, ended in _stretches(what.path, what.blank, progress):
        kept = [
            (number + k, line)
            for k, line in enumerate(lines)
            if number + k > what.skip and line and not line.startswith("#")
        ]
        tally.lines += len(kept)
        if kept and not ended:
            _check_end(kept, what, tally)
        if kept:
            yield _numbers(kept, what, tally)


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


def _check_end(kept: list[tuple[int, str]], what: Contents, tally: Tally) -> None:
    """Drop a last line without an end where it is not whole."""
    number, line = kept[-1]
    tokens, why = line.split(what.delimiter), ""
    if len(tokens) < what.width:
        why = f"the file ends after {len(tokens)} of {what.width} numbers"
    elif decimals_of(tokens[-1]) < what.decimals:
        why = f"the file ends within the number {tokens[-1]!r}"
    if why:
        tally.skip(number, why)
        tally.cut += 1
        kept.pop()
    tally.open_end = not why and not what.decimals


def _numbers(kept: list[tuple[int, str]], what: Contents, tally: Tally) -> Block:
    table = _all_at_once([line for _, line in kept], what)
    if table is None:
        kept, table = _one_by_one(kept, what, tally)
    stamps, good = np.zeros(len(kept), np.int64), np.ones(len(kept), bool)
    for row, (number, line) in enumerate(kept):
        token = line.split(what.delimiter, what.stamp + 1)[what.stamp]
        try:
            stamps[row] = ns_from_text(token, what.scale)
        except ValueError as error:
            tally.skip(number, str(error))
            good[row] = False
    numbers = np.array([number for number, _ in kept], np.int64)
    return Block(numbers[good], stamps[good], table if good.all() else table[good])


def _all_at_once(lines: list[str], what: Contents) -> Floats | None:
    """Table of the lines, or None if one of them is not as expected."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            table = np.loadtxt(lines, comments=None, delimiter=what.delimiter, ndmin=2)
    except (ValueError, Warning):
        return None
    return table if table.shape == (len(lines), what.width) else None


def _one_by_one(
    kept: list[tuple[int, str]], what: Contents, tally: Tally
) -> tuple[list[tuple[int, str]], Floats]:
    good, rows = [], []
    for number, line in kept:
        tokens = line.split(what.delimiter)
        try:
            if len(tokens) != what.width:
                raise ValueError(f"holds {len(tokens)} numbers, not {what.width}")
            rows.append([_number(token) for token in tokens])
            good.append((number, line))
        except ValueError as error:
            tally.skip(number, str(error))
    return good, np.array(rows, np.float64).reshape(len(rows), what.width)


def _number(token: str) -> float:
    try:
        if "_" not in token:
            return float(token) if token.strip() else float("nan")
    except ValueError:
        pass
    shown = token if len(token) <= 20 else token[:20] + "..."
    raise ValueError(f"{shown!r} is not a number")


def ns_from_text(token: str, scale: int) -> int:
    """Nanoseconds from a decimal number of `scale` ns; exact, where a float would round to 200 ns.

    Raises
    ------
    ValueError
        If `token` is no number, not finite, or beyond 292 years.
    """
    whole, _, part = token.strip().partition(".")
    digits = whole[1:] if whole[:1] in "+-" else whole
    try:
        if (digits + part).isdecimal() and len(part) <= 9 and len(digits) <= 20:
            sign = -1 if whole.startswith("-") else 1
            fraction = int(part.ljust(9, "0")) * scale // 10**9 if part else 0
            stamp = sign * (int(digits or "0") * scale + fraction)
        else:
            stamp = round(float(token) * scale)
    except (ValueError, OverflowError):
        raise ValueError(f"the time {token.strip()[:20]!r} is not a finite number") from None
    if abs(stamp) > LIMIT:
        raise ValueError(f"the time {token.strip()[:20]!r} is beyond 292 years: is it in seconds?")
    return stamp
