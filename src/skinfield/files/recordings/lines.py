"""Reader of text recordings: whole blocks of lines of numbers at once, bad lines one by one."""

import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, Ints
from skinfield.files.recordings.head import decimals_of
from skinfield.skin.reading import Recording

Progress = Callable[[int, int], None]
BLOCK = 4 << 20  # bytes read at once
WORST = 0.2  # of the lines may be bad; beyond, the file is not what it was taken for
SHOWN = 3  # bad lines that a note names
LIMIT = 2**63 - 1  # ns


@dataclass(kw_only=True)
class RecordingStream:
    """Recording as text, block by block: memory does not grow with the length of the file.

    Attributes
    ----------
    path : Path
    width : int
        Numbers on a line.
    expected : str
        What a line holds in words, for messages.
    keep : (C,) int array
        Columns that are readings.
    stamp : int
        The column of times; -1 where there is none: lines are evenly spaced.
    scale : int
        Nanoseconds in the time's unit, or between lines.
    delimiter : str or None
        None stands for any space; with a delimiter, nothing between two of them is a missing value.
    blank : bytes
        Characters that count as spaces.
    decimal : bytes
        Sign before the decimals.
    others : bool
        Whether columns that are neither time nor readings must hold numbers, too.
    decimals : int
        Of the last number on every line, where they agree; tells a cut number from a whole one.
    skip : int
        Lines before the data.
    check : callable, optional
        Mends the numbers of some lines (N, W) in place; which of the lines are of the same uids.
    uid : (C,) uint64 array, optional
        Of the columns.
    channel : (C,) int array, optional
        Of the columns; channels without one are missing. Default their order.
    unit, source : str
    notes : tuple of str
        Complete once `blocks` is exhausted.
    sequenced : bool
        Whether the first column counts messages, so that gaps are lost ones.
    progress : callable, optional
        Called with bytes done and bytes in all.
    skipped : int
        Bad lines, once `blocks` is exhausted.
    """

    path: Path
    width: int
    expected: str
    keep: Ints
    stamp: int = 1
    scale: int = 10**9
    delimiter: str | None = None
    blank: bytes = b""
    decimal: bytes = b"."
    others: bool = True
    decimals: int = 0
    skip: int = 0
    check: Callable[[Floats], NDArray[np.bool_]] | None = None
    uid: NDArray[np.uint64] | None = None
    channel: Ints | None = None
    unit: str = "count"
    source: str = ""
    notes: tuple[str, ...] = ()
    sequenced: bool = False
    progress: Progress | None = None
    skipped: int = field(default=0, init=False)

    def blocks(self) -> Iterator[Recording]:
        """Good lines as recordings of some thousand readings each, once.

        Raises
        ------
        FileError
            If the file cannot be read, too many of its lines are not as the first ones, or not one
            value is there; the last two only at the end.
        """
        doubts = Doubts(self.path)
        width = 0 if self.channel is None else int(self.channel.max()) + 1
        try:
            for lines in self._stretches(doubts):
                line, stamp_ns, table = self._numbers(lines, doubts)
                if not len(line):
                    continue
                values = table[:, self.keep]
                doubts.add(stamp_ns, values, line, table[:, 0])
                if self.channel is not None:
                    columns, values = values, np.full((len(line), width), np.nan)
                    values[:, self.channel] = columns
                yield Recording(stamp_ns, values, self.uid, self.unit, self.source)
        except OSError as error:
            why = error.strerror or error
            raise FileError(f"{self.path} cannot be read to its end: {why}") from error
        doubts.check_lines(self.expected)
        self.skipped = doubts.skipped
        lost = doubts.lost() if self.sequenced and not doubts.skipped else ()
        self.notes = (*self.notes, *lost, *doubts.notes())
        if missing := width and width - len(self.keep):
            self.notes += (f"{missing} of {width} channels have no column: missing",)

    def _stretches(self, doubts: "Doubts") -> Iterator[list[tuple[int, str]]]:
        """Lines that hold data, with their numbers from 1; some megabytes of them at once."""
        spaces = bytes.maketrans(self.blank + self.decimal, b" " * len(self.blank) + b".")
        total, first = self.path.stat().st_size, 1
        with self.path.open("rb") as file:
            while data := file.read(BLOCK) + file.readline():
                data = data.removeprefix(b"\xef\xbb\xbf") if first == 1 else data
                # latin-1 never fails: a byte that is no digit makes its own line bad, not the file
                texts = data.translate(spaces).decode("latin-1").split("\n")
                lines = [
                    (number, text)
                    for number, line in enumerate(texts, first)
                    if number > self.skip and (text := line.strip()) and not text.startswith("#")
                ]
                first += len(texts) - 1
                doubts.lines += len(lines)
                if lines and lines[-1][0] == first:  # the last line has no end
                    last = lines.pop()
                    yield lines
                    lines = [last] if self._is_whole(*last, doubts) else []
                yield lines
                if self.progress is not None:
                    self.progress(file.tell(), max(total, file.tell()))

    def _is_whole(self, number: int, line: str, doubts: "Doubts") -> bool:
        """Whether nothing of a last line without an end is missing."""
        tokens, why = line.split(self.delimiter), ""
        if len(tokens) < self.width:
            why = f"the file ends after {len(tokens)} of {self.width} numbers"
        elif decimals_of(tokens[-1]) < self.decimals:
            why = f"the file ends within the number {tokens[-1]!r}"
        if why:
            doubts.skip(number, why)
            doubts.cut += 1
        doubts.open_end = not why and not self.decimals
        return not why

    def _numbers(self, lines: list[tuple[int, str]], doubts: "Doubts") -> tuple[Ints, Ints, Floats]:
        """Line numbers (N,), stamps (N,) ns and numbers (N, W) of the good ones of some lines."""
        table = self._all_at_once([text for _, text in lines])
        good: list[int] = []
        stamps: list[int] = []
        rows: list[Any] = []
        for row, (number, text) in enumerate(lines):
            try:
                values = self._one(text) if table is None else table[row]
                if self.stamp < 0:
                    stamps.append((number - self.skip - 1) * self.scale)
                else:
                    token = text.split(self.delimiter, self.stamp + 1)[self.stamp]
                    stamps.append(ns_from_text(token, self.scale))
            except ValueError as error:
                doubts.skip(number, str(error))
                continue
            good.append(number)
            rows.append(values)
        line, stamp_ns = np.array(good, np.int64), np.array(stamps, np.int64)
        found = np.array(rows, np.float64).reshape(len(rows), self.width)
        if self.check is None:
            return line, stamp_ns, found
        same = self.check(found)
        for number in line[~same].tolist():
            doubts.skip(number, "holds other uids than the first line")
        return line[same], stamp_ns[same], found[same]

    def _all_at_once(self, lines: list[str]) -> Floats | None:
        """Table of the lines, or None if one of them is not as expected."""
        needed = self._needed()
        if needed is not None and any(len(t.split(self.delimiter)) != self.width for t in lines):
            return None
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                found = np.loadtxt(
                    lines, comments=None, delimiter=self.delimiter, usecols=needed, ndmin=2
                )
        except (ValueError, Warning):
            return None
        if needed is None:
            return found if found.shape == (len(lines), self.width) else None
        table = np.full((len(lines), self.width), np.nan)
        table[:, needed] = found
        return table

    def _needed(self) -> list[int] | None:
        """Columns that must hold numbers; None for all."""
        if self.others:
            return None
        return sorted({*self.keep.tolist(), *([self.stamp] if self.stamp >= 0 else [])})

    def _one(self, line: str) -> list[float]:
        """Numbers of one line; raises ValueError if it is not as expected."""
        tokens = line.split(self.delimiter)
        if len(tokens) != self.width:
            raise ValueError(f"holds {len(tokens)} numbers, not {self.width}")
        needed = self._needed()
        if needed is None:
            return [_number(token) for token in tokens]
        values = [float("nan")] * self.width
        for place in needed:
            values[place] = _number(tokens[place])
        return values


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
    shown = f"the time {token.strip()[:20]!r}"
    try:
        stamp = Decimal(token) * scale
        if abs(stamp) <= LIMIT:
            return round(stamp)
    except ArithmeticError:  # no number, or nan
        raise ValueError(f"{shown} is not a finite number") from None
    raise ValueError(f"{shown} is beyond 292 years: is it in seconds?")


@dataclass
class Doubts:
    """What is doubtful in a recording: bad lines, missing values, stamps and messages out of order.

    Parameters
    ----------
    path : Path
        Of the file.

    Attributes
    ----------
    lines, skipped, cut : int
        That hold data; of these, that cannot be used; of these, that the file's end cuts.
    open_end : bool
        Whether the last line has no end.
    """

    path: Path
    lines: int = 0
    skipped: int = 0
    cut: int = 0
    open_end: bool = False
    _bad: list[tuple[int, str]] = field(default_factory=list)  # the first ones: line and why
    _values: int = 0
    _top: int = 0
    _places: dict[str, tuple[int, int]] = field(default_factory=dict)  # how many, the first's line
    _gaps: Counter[float] = field(default_factory=Counter)
    _stamp: int | None = None
    _sequence: float = float("nan")

    def skip(self, line: int, why: str) -> None:
        """Count a line that cannot be used."""
        self.skipped += 1
        if len(self._bad) < SHOWN:
            self._bad.append((line, why))

    def check_lines(self, expected: str) -> None:
        """Raise FileError if too much of the file is bad, or nothing is left of it."""
        if self.skipped == self.lines or self.skipped - self.cut > WORST * self.lines:
            line, why = self._bad[0] if self._bad else (1, "no data follow")
            raise FileError(
                f"{self.path}:{line}: {why}; expected {expected} "
                f"({self.skipped} of {self.lines} lines are unusable; at most {WORST:.0%} may be)"
            )

    def add(
        self, stamp_ns: Ints, values: Floats, line: Ints, sequence: Floats | None = None
    ) -> None:
        """Look at some more readings; infinities in `values` (T, C) become NaN, in place."""
        self._top = self._top or int(line[0])
        self._values += values.size
        missing = ~np.isfinite(values)
        values[missing] = np.nan
        before = stamp_ns[0] - 1 if self._stamp is None else self._stamp
        steps = np.diff(stamp_ns, prepend=before)
        self._stamp = int(stamp_ns[-1])
        self._count("missing", missing.sum(axis=1), line)
        self._count("repeat the one before", steps == 0, line)
        self._count("run backwards", steps < 0, line)
        if sequence is not None:
            gaps = np.diff(sequence, prepend=self._sequence)
            wide = (gaps > 1) & np.isfinite(gaps)
            self._count("gaps", wide, line)
            self._gaps.update(gaps[wide].tolist())
            self._sequence = float(sequence[-1])

    def _count(self, what: str, numbers: NDArray[Any], line: Ints) -> None:
        """Count something by its number on each line."""
        if numbers.any():
            count, first = self._places.get(what, (0, int(line[np.argmax(numbers > 0)])))
            self._places[what] = count + int(numbers.sum()), first

    def notes(self) -> tuple[str, ...]:
        """Sentences on lines, values and stamps; raises FileError if not one value is there."""
        name, notes = self.path.name, []
        if self.skipped:
            where = "; ".join(f"{name}:{line} {why}" for line, why in self._bad)
            more = "; ..." if self.skipped > len(self._bad) else ""
            notes.append(f"{self.skipped} of {self.lines} lines skipped: {where}{more}")
        if self.open_end:
            notes.append("the last line has no end: kept, though its last number may be cut")
        missing, first = self._places.get("missing", (0, 0))
        if missing and missing == self._values:
            raise FileError(
                f"{self.path}:{self._top}: all {missing} values are nan, inf or empty, "
                "expected numbers"
            )
        if missing:
            notes.append(
                f"{missing} of {self._values} values are nan, inf or empty, "
                f"first at {name}:{first}: taken as missing"
            )
        for what in ("repeat the one before", "run backwards"):
            if what in self._places:
                count, first = self._places[what]
                notes.append(f"{count} stamps {what}, first at {name}:{first}: kept")
        return tuple(notes)

    def lost(self) -> tuple[str, ...]:
        """Sentence on messages that never arrived, from gaps in the sequence numbers."""
        count, first = self._places.get("gaps", (0, 0))
        if not count:
            return ()
        if count * 2 > self.lines - 1:  # every n-th message was kept on purpose
            middle = sorted(self._gaps.elements())[count // 2]
            return (f"sequence numbers step by {middle:.0f}: the log holds every so many-th",)
        lost = sum((gap - 1) * times for gap, times in self._gaps.items())
        gaps = f"{lost:.0f} messages lost in {count} gaps of the sequence numbers"
        return (f"{gaps}, first before {self.path.name}:{first}",)
