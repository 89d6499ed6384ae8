"""Stream of a text recording, block by block: memory does not grow with the length of the file."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, Ints
from skinfield.files.recordings.lines import Block, Contents, Progress, Tally, blocks
from skinfield.skin.reading import Recording


class Stream(Protocol):
    """Blocks of a recording; the rest is complete once they are exhausted."""

    notes: tuple[str, ...]
    skipped: int

    def blocks(self) -> Iterator[Recording]:
        """Recordings of some thousand readings each, once; one or more."""
        ...


def collected(stream: Stream) -> Recording:
    """All of a stream in memory."""
    parts = list(stream.blocks())
    return replace(
        parts[0],
        stamp_ns=np.concatenate([part.stamp_ns for part in parts]),
        counts=np.concatenate([part.counts for part in parts]),
        notes=stream.notes,
        skipped=stream.skipped,
    )


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
    """

    contents: Contents
    progress: Progress | None = None
    notes: tuple[str, ...] = ()
    skipped: int = 0

    def blocks(self) -> Iterator[Recording]:
        """Good lines as recordings of some thousand readings each, once.

        Raises
        ------
        FileError
            If the file cannot be read, too many of its lines are not as the first ones, or not one
            value is there; the last two only at the end.
        """
        what, doubts = self.contents, Doubts(self.contents.path)
        tally = Tally(what.path)
        try:
            for block in blocks(what, tally, self.progress):
                good = block if what.check is None else what.check(block, tally)
                if len(good.line):
                    yield self._recording(good, doubts)
        except OSError as error:
            why = error.strerror or error
            raise FileError(f"{what.path} cannot be read to its end: {why}") from error
        tally.check(what.expected)
        self.skipped = tally.skipped
        lost = doubts.lost() if what.sequenced and not tally.skipped else ()
        self.notes = (*what.notes, *lost, *tally.notes(), *doubts.notes(), *self._absent())

    def _recording(self, good: Block, doubts: "Doubts") -> Recording:
        what, values = self.contents, good.table[:, self.contents.keep]
        doubts.add(good.stamp_ns, values, good.line, good.table[:, 0])
        if what.channel is not None:
            whole = np.full((len(values), int(what.channel.max()) + 1), np.nan)
            whole[:, what.channel] = values
            values = whole
        return Recording(good.stamp_ns, values, what.uid, what.unit, what.source)

    def _absent(self) -> tuple[str, ...]:
        channel = self.contents.channel
        width = 0 if channel is None else int(channel.max()) + 1
        if channel is None or len(channel) == width:
            return ()
        return (f"{width - len(channel)} of {width} channels have no column: missing",)


@dataclass
class Places:
    """How many of something there are, and the line of the first."""

    count: int = 0
    first: int = 0

    def add(self, numbers: NDArray[Any], line: Ints) -> None:
        """Count them, by their number on each line."""
        if numbers.any():
            self.first = self.first if self.count else int(line[np.argmax(numbers > 0)])
            self.count += int(numbers.sum())


@dataclass
class Doubts:
    """What is doubtful in readings: values that are not there, stamps and messages out of order.

    Parameters
    ----------
    path : Path
        Of the file.
    """

    path: Path
    values: int = 0
    lines: int = 0
    top: int = 0
    missing: Places = field(default_factory=Places)
    repeats: Places = field(default_factory=Places)
    backwards: Places = field(default_factory=Places)
    wide: Places = field(default_factory=Places)
    gaps: Counter[float] = field(default_factory=Counter)
    _stamp: int | None = None
    _sequence: float = float("nan")

    def add(
        self, stamp_ns: Ints, values: Floats, line: Ints, sequence: Floats | None = None
    ) -> None:
        """Look at some more readings; infinities in `values` (T, C) become NaN, in place."""
        self.top = self.top or int(line[0])
        missing = ~np.isfinite(values)
        values[missing] = np.nan
        self.values, self.lines = self.values + values.size, self.lines + len(line)
        self.missing.add(missing.sum(axis=1), line)
        before = stamp_ns[0] - 1 if self._stamp is None else self._stamp
        steps = np.diff(stamp_ns, prepend=before)
        self.repeats.add(steps == 0, line)
        self.backwards.add(steps < 0, line)
        self._stamp = int(stamp_ns[-1])
        if sequence is not None:
            gaps = np.diff(sequence, prepend=self._sequence)
            wide = (gaps > 1) & np.isfinite(gaps)
            self.wide.add(wide, line)
            self.gaps.update(gaps[wide].tolist())
            self._sequence = float(sequence[-1])

    def notes(self) -> tuple[str, ...]:
        """Sentences on values and stamps; raises FileError if not one value is there."""
        missing, name = self.missing, self.path.name
        if missing.count and missing.count == self.values:
            raise FileError(
                f"{self.path}:{self.top}: all {missing.count} values are nan, inf or empty, "
                "expected numbers"
            )
        said = []
        if missing.count:
            said.append(
                f"{missing.count} of {self.values} values are nan, inf or empty, "
                f"first at {name}:{missing.first}: taken as missing"
            )
        for wrong, what in (
            (self.repeats, "repeat the one before"),
            (self.backwards, "run backwards"),
        ):
            if wrong.count:
                said.append(f"{wrong.count} stamps {what}, first at {name}:{wrong.first}: kept")
        return tuple(said)

    def lost(self) -> tuple[str, ...]:
        """Sentence on messages that never arrived, from gaps in the sequence numbers."""
        count = self.wide.count
        if not count:
            return ()
        if count * 2 > self.lines - 1:  # every n-th message was kept on purpose
            middle = sorted(self.gaps.elements())[count // 2]
            return (f"sequence numbers step by {middle:.0f}: the log holds every so many-th",)
        lost = sum((gap - 1) * times for gap, times in self.gaps.items())
        gaps = f"{lost:.0f} messages lost in {count} gaps of the sequence numbers"
        return (f"{gaps}, first before {self.path.name}:{self.wide.first}",)
