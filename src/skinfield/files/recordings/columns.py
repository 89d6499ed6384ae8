"""Columns of a log of one's own: which is the time, which are taxels, in which units.

They stand in the table `[log]` of a skin's file (`skinfield new` writes it), so that a CSV with any
names is read as it is:

    [log]
    time = "t"
    time_unit = "ms"
    columns = ["ch0", "ch1", "ch2"]

Delimiters are `,` `;` tab or spaces; beside `;` and tabs commas are decimal. Names stand in the
line above the numbers, in a comment, too, as NumPy writes them; columns without names are called 1,
2, 3 ...
"""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from skinfield.errors import FileError, Floats, InputError
from skinfield.files import numbers
from skinfield.files.recordings import table
from skinfield.files.recordings.head import SAMPLE, Magic, is_number, usual_decimals
from skinfield.files.recordings.lines import LIMIT, RecordingStream
from skinfield.settings import nearest
from skinfield.skin.log import NS, LogSettings, TimeUnit
from skinfield.skin.reading import Recording

STEPS: dict[TimeUnit, float] = {"s": 2.0, "ms": 600.0, "us": 1e6, "ns": float("inf")}  # below
LIKELY = 0.5, 2000.0  # readings per second
SHORTEST, LONGEST = 2e-5, 1000.0  # s from reading to reading
SHOWN = 12  # names in a message
TIME = re.compile(r"(?i)(t|time|times?tamp|stamp|clock|seconds?|sec|millis|micros)([ _.\[(].*)?")
FORCE = re.compile(r"(?i)(.*[ _])?(force|load|fz|f_?n|load_?cell|newtons?|weight)([ _.\[(].*)?")
OF_TIME = {"s": "s", "sec": "s", "seconds": "s", "ms": "ms", "msec": "ms", "millis": "ms",
           "us": "us", "usec": "us", "micros": "us", "ns": "ns", "nsec": "ns"}  # fmt: skip


@dataclass(frozen=True)
class Table:
    """Head of a table of numbers.

    Attributes
    ----------
    source : str
    names : tuple of str
        Of its columns.
    delimiter : str or None
        None is any space.
    decimal : str
        Decimal sign, a point or a comma.
    skip : int
        Lines before the numbers.
    rows : list
        Tokens of the first ones, with decimal points.
    """

    source: str
    names: tuple[str, ...]
    delimiter: str | None
    decimal: str
    skip: int
    rows: list[list[str]]

    def numbers(self, name: str) -> Floats:
        """First numbers (N,) of a column; NaN where there is none."""
        place = self.names.index(name)
        cells = [row[place].strip() if place < len(row) else "" for row in self.rows]
        return np.array([float(cell) if is_number(cell) else np.nan for cell in cells])

    def column(self, wanted: str) -> str:
        """Name of the one column that is meant; InputError for none, or several."""
        found = self.columns([wanted])
        if len(found) > 1:
            raise InputError(f"column {wanted!r} matches {shortlist(found)}, expected one column")
        return found[0]

    def columns(self, wanted: Sequence[str], but: Sequence[str | None] = ()) -> tuple[str, ...]:
        """Names of columns that names, patterns and numbers mean, in their order.

        What a pattern matches stands by the numbers in the names where they differ in these alone,
        else as in the file; columns `but` are none of them.

        Raises
        ------
        InputError
            If one matches nothing, or two name the same; with the columns that are there.
        """
        found: list[str] = []
        for each in wanted:
            its = [name for name in self._of(each) if name not in but]
            if not its:
                raise InputError(
                    f"columns {each!r} match nothing in {self.source}, expected some of its "
                    f"{len(self.names)}: {shortlist(self.names)}{nearest(each, self.names)}"
                )
            found += its
        twice = sorted({name for name in found if found.count(name) > 1})
        if twice:
            raise InputError(
                f"columns {', '.join(wanted)} name {shortlist(twice)} twice, expected each once"
            )
        return tuple(found)

    def _of(self, word: str) -> list[str]:
        if word in self.names:
            return [word]
        if set(word) & set("*?["):
            return by_number([name for name in self.names if fnmatchcase(name, word)])
        ends = re.fullmatch(r"(\d{1,6})(-(\d{0,6}))?", word, re.ASCII)
        if not ends:
            return []
        last = int(ends[3] or len(self.names)) if ends[2] else int(ends[1])
        return list(self.names[max(int(ends[1]) - 1, 0) : last]) if int(ends[1]) else []


def shortlist(names: Sequence[str], most: int = SHOWN) -> str:
    """Names in a message: the first ones and the last."""
    if len(names) <= most:
        return ", ".join(names)
    return f"{', '.join(names[: most - 2])}, ..., {names[-1]}"


def by_number(names: list[str]) -> list[str]:
    """Names by the numbers in them, where they differ in these alone; else as they are."""
    if len({re.sub(r"\d+", "0", name) for name in names}) > 1:
        return names
    return sorted(names, key=lambda name: [int(each) for each in re.findall(r"\d+", name)])


def read_table(head: Magic) -> Table:
    """Names and first rows of a table of numbers.

    Raises
    ------
    FileError
        If it is none.
    """
    lines = head.numbered()
    where = f"{head.path}:{lines[0][0] if lines else 1}"
    if len(lines) < 2:
        raise FileError(f"{where}: no rows of numbers, expected a line of names and numbers below")
    (line, text), (_, below) = lines[:2]
    delimiter, decimal = numbers.delimiter_of(below)
    tokens = _clean(text.split(delimiter))
    names = tokens
    if all(is_number(token.replace(decimal, ".")) for token in tokens):
        comment = head.lines[line - 2] if line > 1 else ""
        said = _clean(comment.lstrip("#% ").split(delimiter))
        fits = len(said) == len(tokens) and not all(map(is_number, said))
        names = said if fits else [str(place + 1) for place in range(len(tokens))]
        line -= 1
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise FileError(f"{where}: column {twice[0]!r} stands there twice, expected each name once")
    rows = [[t.replace(decimal, ".") for t in row] for row in head.rows(line, delimiter)]
    if not any(is_number(token.strip()) for row in rows for token in row):
        raise FileError(f"{where}: no number in the rows below the names, expected a table of them")
    return Table(str(head.path), tuple(names), delimiter, decimal, line, rows)


def is_table_of_arrays(text: str) -> bool:
    """Whether a log is a MATLAB, HDF5 or NumPy file whose columns are named by number."""
    return numbers.is_numbers(text) and Path(text).suffix.lower() not in (".csv", ".txt")


def table_of_arrays(text: str) -> tuple[Table, Floats]:
    """Table of a file of arrays, such as trial.mat:experiment.C, and its numbers (T, C)."""
    found = numbers.read_numbers(text)
    rows = [list(map(repr, row)) for row in found.values[:SAMPLE].tolist()]
    return Table(found.source, found.names, None, ".", 0, rows), found.values


def recording_of_arrays(text: str, log: LogSettings) -> Recording:
    """Recording of a file of arrays whose columns a skin's file names.

    Raises
    ------
    FileError, InputError
        If it cannot be read, or lacks a column.
    """
    found, values = table_of_arrays(text)
    places = [found.names.index(name) for name in _places_of(found, log)]
    if log.time is None:
        stamps = np.arange(len(values)) * (NS["s"] / (log.rate_hz or 1.0))
    else:
        stamps = values[:, found.names.index(log.time)] * NS[log.time_unit]
    if not np.isfinite(stamps).all() or np.abs(stamps).max(initial=0.0) >= LIMIT:
        raise FileError(f"{text}: column {log.time!r} holds times that are no finite numbers")
    chosen = np.where(np.isfinite(values[:, places]), values[:, places], np.nan)
    return Recording(np.rint(stamps).astype(np.int64), chosen, None, log.unit, text)


def _places_of(found: Table, log: LogSettings) -> tuple[str, ...]:
    if log.time is not None and log.time not in found.names:
        raise InputError(
            f"column {log.time!r}, the time as [log] has it, is not in {found.source}, expected "
            f"among its {len(found.names)}: {shortlist(found.names)}"
        )
    return found.columns(log.columns, (log.time, log.load_cell))


def _clean(tokens: Sequence[str]) -> list[str]:
    """Names as people mean them: without quotes, in UTF-8 (files are read as Latin-1)."""
    found = []
    for token in tokens:
        name = token.strip().strip("\"'").strip()
        with suppress(UnicodeError):
            name = name.encode("latin-1").decode("utf-8")
        found.append(name)
    return found


def guess_time(found: Table) -> str | None:
    """Column that is named like a time and rises; None without one."""
    for name in found.names:
        if TIME.fullmatch(name) or name in table.TIMES:
            values = found.numbers(name)
            values = values[np.isfinite(values)]
            if len(values) > 1 and (np.diff(values) >= 0).all() and values[-1] > values[0]:
                return name
    return None


def guess_load_cell(found: Table) -> str | None:
    """Column that is named like a force; None without one, or with several."""
    names = [name for name in found.names if FORCE.fullmatch(name)]
    return names[0] if len(names) == 1 else None


def guess_columns(found: Table, but: Sequence[str | None]) -> str | None:
    """Pattern of the most columns whose names differ by a number only; the only one left, else."""
    left = [name for name in found.names if name not in but and name.lower() not in table.IGNORED]
    left = [name for name in left if np.isfinite(found.numbers(name)).any()]
    kinds: dict[str, int] = {}
    for name in left:
        kind = re.sub(r"\d+$", "*", name)
        kinds[kind] = kinds.get(kind, 0) + 1
    if not kinds:
        return None
    best = max(kinds, key=lambda kind: kinds[kind])
    return best if kinds[best] > 1 or len(kinds) == 1 else None


def time_unit_of(name: str, values: Floats) -> tuple[TimeUnit, str]:
    """Unit of times by their column's name, else by their steps; and what tells it.

    Raises
    ------
    InputError
        If times do not rise.
    """
    word = re.split(r"[^A-Za-z]+", name.rstrip(")] "))[-1].lower()
    if word in OF_TIME and word != name.lower():
        unit: TimeUnit = OF_TIME[word]  # type: ignore[assignment]
        return unit, "by its name"
    steps = np.diff(values[np.isfinite(values)])
    step = float(np.median(steps)) if len(steps) else float("nan")
    if not step > 0.0:
        raise InputError(
            f"times of column {name!r} go on by {step:g} from row to row, expected numbers that "
            "rise: choose another column (--time), or say --rate-hz"
        )
    unit = next(unit for unit, longest in STEPS.items() if step < longest)
    rates = {each: NS["s"] / ns / step for each, ns in NS.items()}
    why = f"steps of {step:g} make {rates[unit]:.4g} reading{'s' * (rates[unit] != 1.0)} per second"
    others = [f"{rates[each]:.4g} in {each}" for each in NS
              if each != unit and LIKELY[0] <= rates[each] <= LIKELY[1]]  # fmt: skip
    if others:
        why += f" (they would be {', '.join(others)}: --time-unit)"
    if step == 1.0 and unit == "s":
        why += "; if they count rows, say --rate-hz instead of --time"
    return unit, why


def check_rate(name: str, unit: TimeUnit, values: Floats) -> None:
    """Raise InputError where times in a unit come faster, or slower, than any skin reads."""
    steps = np.diff(values[np.isfinite(values)]) * (NS[unit] / NS["s"])
    step = float(np.median(steps)) if len(steps) else float("nan")
    if not SHORTEST <= step <= LONGEST:
        raise InputError(
            f"times of column {name!r} in {unit} go on by {step:.3g} s from row to row, expected "
            f"{SHORTEST:g} to {LONGEST:g} s: say their unit (--time-unit), or --rate-hz without "
            "--time"
        )


def contents(head: Magic, log: LogSettings) -> RecordingStream:
    """What a table holds whose columns a skin's file names.

    Raises
    ------
    FileError, InputError
        If it is no table of numbers, or lacks a column.
    """
    found = read_table(head)
    if log.time is not None and log.time not in found.names:
        known = table.contents(head)  # one of skinfield's own, whose names say all
        if known is not None:
            return known
    columns = _places_of(found, log)
    rate = log.rate_hz or 1.0
    return RecordingStream(
        path=head.path,
        width=len(found.names),
        stamp=-1 if log.time is None else found.names.index(log.time),
        scale=round(NS["s"] / rate) if log.time is None else NS[log.time_unit],
        expected=f"{len(found.names)} numbers, as the other lines hold",
        delimiter=found.delimiter,
        decimal=found.decimal.encode(),
        others=False,
        decimals=usual_decimals(found.rows),
        skip=found.skip,
        keep=np.array([found.names.index(name) for name in columns], np.int64),
        unit=log.unit,
        source=str(head.path),
    )


def only(log: LogSettings, name: str) -> LogSettings:
    """Settings that read one column of the same log, such as that of its load cell."""
    return replace(log, columns=(name,), load_cell=None)
