"""From blocks of numbers to a recording, with what had to be repaired on the way."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, InputError
from skinfield.reading import Recording
from skinfield.sources.recordings.lines import Block, Grammar, Progress, Tally, blocks
from skinfield.sources.recordings.stamp import milliseconds_if_whole, order_notes

Check = Callable[[Block, Tally], Block]


@dataclass(frozen=True)
class Gathered:
    """All good lines of a file: stamps ns, line numbers and first column (T,), values (T, C)."""

    stamp_ns: NDArray[np.int64]
    values: Floats
    line: NDArray[np.int64]
    sequence: Floats
    tally: Tally


def gather(
    path: Path,
    grammar: Grammar,
    keep: NDArray[np.int64],
    progress: Progress | None,
    check: Check | None = None,
) -> Gathered:
    """Read the columns `keep` of all good lines.

    Raises
    ------
    FileError
        If the file cannot be read, or too many of its lines are not as `grammar` has it.
    """
    tally = Tally(path)
    parts: list[tuple[NDArray[np.int64], Floats, NDArray[np.int64], Floats]] = []
    try:
        for block in blocks(path, grammar, tally, progress):
            good = block if check is None else check(block, tally)
            first = good.table[:, 0].copy()
            parts.append((good.stamp_ns, good.table[:, keep], good.line, first))
    except OSError as error:
        raise FileError(f"{path} cannot be read to its end: {error.strerror or error}") from error
    tally.check(grammar.expected)
    stamps, values, line, first = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Gathered(stamps, values, line, first, tally)


def recording_from(
    gathered: Gathered,
    *,
    uid: NDArray[np.uint64] | None = None,
    unit: str = "count",
    source: str = "",
    notes: Iterable[str] = (),
    clock_is_stated: bool = True,
) -> Recording:
    """Recording of what was gathered; missing values and odd stamps are noted."""
    path, stamps = gathered.tally.path, gathered.stamp_ns
    said = [*notes, *gathered.tally.notes()]
    if not clock_is_stated and (closer := milliseconds_if_whole(stamps)) is not None:
        stamps = closer
        said.append("times are whole numbers far apart: taken as milliseconds")
    said += missing_notes(path, gathered.values, gathered.line)
    said += order_notes(stamps, path.name, gathered.line)
    return Recording(
        stamps, gathered.values, uid, unit, source or str(path), tuple(said), gathered.tally.skipped
    )


def missing_notes(path: Path, values: Floats, line: NDArray[np.int64]) -> tuple[str, ...]:
    """Turn infinities in `values` into NaN, in place, and say how many values are missing.

    Raises
    ------
    FileError
        If not one value is there.
    """
    missing = ~np.isfinite(values)
    count = int(missing.sum())
    if not count:
        return ()
    if count == values.size:
        raise FileError(
            f"{path}:{line[0]}: all {count} values are nan, inf or empty, expected numbers"
        )
    values[missing] = np.nan
    first = line[int(np.argmax(missing.any(axis=1)))]
    return (
        f"{count} of {values.size} values are nan, inf or empty, first at {path.name}:{first}: "
        "taken as missing",
    )


def chosen(columns: Sequence[int | str] | None, width: int, path: Path) -> NDArray[np.int64]:
    """Rows of the chosen value columns, all of them for None.

    Raises
    ------
    InputError
        If a column is chosen that is not there.
    """
    if columns is None:
        return np.arange(width)
    for column in columns:
        if isinstance(column, str) or not 0 <= int(column) < width:
            raise InputError(
                f"columns holds {column!r}, expected whole numbers from 0 to {width - 1}: "
                f"{path} has {width} columns of values without names"
            )
    if not len(columns):
        raise InputError("columns is empty, expected one column or more: leave it out for all")
    return np.array([int(column) for column in columns], np.int64)
