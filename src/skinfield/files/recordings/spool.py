"""Spool of a recording: its numbers on disk, to be read again in blocks."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np

from skinfield.errors import InputError
from skinfield.files.recordings.matching import readings_for
from skinfield.files.recordings.open import stream_recording
from skinfield.skin import Patch
from skinfield.skin.log import LogSettings
from skinfield.skin.reading import Recording

PIECE = 1 << 20  # numbers of a block: 8 MB
FEWEST, MOST = 2048, 16384  # readings of one: enough to see motion, and what stands still


class Spool:
    """A recording's numbers in a file without name, in the order of the patch's taxels.

    Parameters
    ----------
    recording : str
        Parsed once.
    patch : Patch
    folder : Path
        Where there is room.
    step : function
        Shows the progress.
    log : LogSettings, optional
        See `open_recording`.
    """

    def __init__(
        self,
        recording: str,
        patch: Patch,
        folder: Path,
        step: Callable[..., None],
        log: LogSettings | None = None,
    ) -> None:
        self.patch, self._count = patch, 0
        self._kind = np.dtype([("stamp_ns", "<i8"), ("counts", "<f8", (len(patch),))])
        self._file = TemporaryFile(dir=folder)  # noqa: SIM115
        opened, like = stream_recording(recording, log=log, progress=step), None
        notes: tuple[str, ...] = ()
        for block in [opened] if isinstance(opened, Recording) else opened.blocks():
            mine = readings_for(block, patch)
            rows = np.empty(len(mine), self._kind)
            rows["stamp_ns"], rows["counts"] = mine.stamp_ns, mine.counts
            self._file.write(rows.view(np.uint8).data)
            self._count += len(rows)
            if like is None:
                like = replace(mine, stamp_ns=mine.stamp_ns[:0], counts=mine.counts[:0])
                notes = mine.notes[len(block.notes) :]
        if like is None:
            raise InputError(f"{recording} holds no reading, expected one or more")
        self.like, self.notes, self.skipped = like, opened.notes + notes, opened.skipped

    def blocks(self) -> Iterator[Recording]:
        """All of it again, in blocks of one size, but for the last: a short rest joins it."""
        size = int(np.clip(PIECE // len(self.patch), FEWEST, MOST))
        self._file.flush()
        rows, first = np.memmap(self._file, self._kind, "r"), 0
        while first < self._count:
            last = first + size if self._count - first >= 2 * size else self._count
            stamps, counts = (rows[name][first:last].copy() for name in ("stamp_ns", "counts"))
            yield replace(self.like, stamp_ns=stamps, counts=counts)
            first = last
