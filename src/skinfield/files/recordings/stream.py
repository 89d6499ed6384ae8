"""Stream of a text recording, block by block: memory does not grow with the length of the file."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats
from skinfield.files.recordings.lines import Block, Grammar, Progress, Tally, blocks
from skinfield.files.recordings.stamp import Order, WholeSeconds
from skinfield.skin.reading import Recording

Check = Callable[[Block, Tally], Block]


@dataclass(frozen=True, kw_only=True)
class Contents:
    """What the lines of a file hold, as its first ones tell.

    Attributes
    ----------
    path : Path
    grammar : Grammar
    keep : (C,) int array
        Columns that are readings.
    check : callable, optional
        Mends or drops the lines of a block.
    uid : (C,) uint64 array, optional
        Of the columns.
    channel : (C,) int array, optional
        Of the columns; channels without one are missing. Default their order.
    unit, source : str
    notes : tuple of str
    clock_is_stated : bool
        False where whole numbers far apart may be milliseconds.
    sequenced : bool
        Whether the first column counts messages, so that gaps are lost ones.
    """

    path: Path
    grammar: Grammar
    keep: NDArray[np.int64]
    check: Check | None = None
    uid: NDArray[np.uint64] | None = None
    channel: NDArray[np.int64] | None = None
    unit: str = "count"
    source: str = ""
    notes: tuple[str, ...] = ()
    clock_is_stated: bool = True
    sequenced: bool = False


@dataclass
class RecordingStream:
    """Blocks of a recording, and in the end what had to be repaired on the way.

    Attributes
    ----------
    contents : Contents
    notes : tuple of str
        Complete once `blocks` is exhausted.
    skipped : int
        Likewise.
    divisor : int
        By which all stamps are to be divided; known once `blocks` is exhausted.
    """

    contents: Contents
    progress: Progress | None = None
    notes: tuple[str, ...] = ()
    skipped: int = 0
    divisor: int = 1
    _missing: "Missing" = field(default_factory=lambda: Missing())
    _lost: "Lost" = field(default_factory=lambda: Lost())
    _order: Order = field(default_factory=Order)
    _seconds: WholeSeconds = field(default_factory=WholeSeconds)

    def blocks(self) -> Iterator[Recording]:
        """Good lines as recordings of some thousand readings each, once.

        Raises
        ------
        FileError
            If the file cannot be read, too many of its lines are not as the first ones, or not one
            value is there; the last two only at the end.
        """
        what, readings = self.contents, 0
        path, tally = what.path, Tally(what.path)
        try:
            for block in blocks(path, what.grammar, tally, self.progress):
                good = block if what.check is None else what.check(block, tally)
                readings += len(good.line)
                if len(good.line):
                    yield self._recording(good)
        except OSError as error:
            why = error.strerror or error
            raise FileError(f"{path} cannot be read to its end: {why}") from error
        tally.check(what.grammar.expected)
        self.skipped = tally.skipped
        self._finish(tally)

    def _recording(self, good: Block) -> Recording:
        what, values = self.contents, good.table[:, self.contents.keep]
        self._missing.mend(values, good.line)
        self._order.add(good.stamp_ns, good.line)
        self._seconds.add(good.stamp_ns)
        self._lost.add(good.table[:, 0], good.line)
        if what.channel is not None:
            whole = np.full((len(values), int(what.channel.max()) + 1), np.nan)
            whole[:, what.channel] = values
            values = whole
        return Recording(good.stamp_ns, values, what.uid, what.unit, what.source)

    def _finish(self, tally: Tally) -> None:
        what, name = self.contents, self.contents.path.name
        lost = self._lost.notes(name) if what.sequenced and not tally.skipped else ()
        said = [*what.notes, *lost, *tally.notes()]
        if not what.clock_is_stated and self._seconds.are_milliseconds:
            self.divisor = 1000
            said.append("times are whole numbers far apart: taken as milliseconds")
        said += self._missing.notes(what.path)
        said += self._order.notes(name)
        if what.channel is not None and (absent := int(what.channel.max()) + 1 - len(what.channel)):
            width = int(what.channel.max()) + 1
            said.append(f"{absent} of {width} channels have no column: missing")
        self.notes = tuple(said)


class Stream(Protocol):
    """Blocks of a recording; the rest is complete once they are exhausted."""

    notes: tuple[str, ...]
    skipped: int
    divisor: int

    def blocks(self) -> Iterator[Recording]:
        """Recordings of some thousand readings each, once; one or more."""
        ...


def collected(stream: Stream) -> Recording:
    """All of a stream in memory."""
    parts = list(stream.blocks())
    return replace(
        parts[0],
        stamp_ns=np.concatenate([part.stamp_ns for part in parts]) // stream.divisor,
        counts=np.concatenate([part.counts for part in parts]),
        notes=stream.notes,
        skipped=stream.skipped,
    )


@dataclass
class Missing:
    """Counts the values that are not there."""

    count: int = 0
    size: int = 0
    first: int = 0
    top: int = 0

    def mend(self, values: Floats, line: NDArray[np.int64]) -> None:
        """Turn infinities in `values` (T, C) into NaN, in place."""
        if not self.size:
            self.top = int(line[0])
        missing = ~np.isfinite(values)
        count = int(missing.sum())
        if count and not self.count:
            self.first = int(line[int(np.argmax(missing.any(axis=1)))])
        if count:
            values[missing] = np.nan
        self.count, self.size = self.count + count, self.size + values.size

    def notes(self, path: Path) -> tuple[str, ...]:
        """How many they were; raises FileError if not one is there."""
        if not self.count:
            return ()
        if self.count == self.size:
            raise FileError(
                f"{path}:{self.top}: all {self.count} values are nan, inf or empty, "
                "expected numbers"
            )
        return (
            f"{self.count} of {self.size} values are nan, inf or empty, "
            f"first at {path.name}:{self.first}: taken as missing",
        )


@dataclass
class Lost:
    """Messages that never arrived, from gaps in the sequence numbers."""

    steps: int = 0
    gaps: Counter[float] = field(default_factory=Counter)
    first: int = 0
    last: float = float("nan")

    def add(self, sequence: Floats, line: NDArray[np.int64]) -> None:
        """Look at some more numbers."""
        steps = np.diff(sequence, prepend=self.last)
        self.steps += len(steps) - bool(np.isnan(self.last) and self.steps == 0)
        wide = (steps > 1) & np.isfinite(steps)
        if wide.any():
            if not self.gaps:
                self.first = int(line[int(np.argmax(wide))])
            self.gaps.update(steps[wide].tolist())
        self.last = float(sequence[-1])

    def notes(self, name: str) -> tuple[str, ...]:
        """What was lost."""
        count = self.gaps.total()
        if not count:
            return ()
        if count * 2 > self.steps:  # every n-th message was kept on purpose
            middle = sorted(self.gaps.elements())[count // 2]
            return (f"sequence numbers step by {middle:.0f}: the log holds every so many-th",)
        lost = sum((gap - 1) * times for gap, times in self.gaps.items())
        gaps = f"{lost:.0f} messages lost in {count} gaps of the sequence numbers"
        return (f"{gaps}, first before {name}:{self.first}",)
