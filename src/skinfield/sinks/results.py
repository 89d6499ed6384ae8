"""Results as readings and settings: small, exact, and everything else is computed from them."""

import os
import zlib
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, check_shape
from skinfield.pipeline import Reconstructor
from skinfield.pipeline.batch_format import (
    BLOCK,
    READINGS,
    SETTINGS,
    STAMPS,
    Extent,
    narrowed,
    text_from_content,
)
from skinfield.pipeline.batch_recipe import Recipe
from skinfield.pipeline.batch_text import plain_from_value
from skinfield.pipeline.conditioner import Conditioner
from skinfield.sinks.pending import Pending, explained, pending
from skinfield.sinks.sink import Closing


@dataclass
class _Column:
    """One array that grows, and the sums of its blocks."""

    file: IO[bytes]
    kind: np.dtype[Any]
    tail: tuple[int, ...]
    rows: int = 0
    sums: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.start = self._head()

    def append(self, rows: NDArray[Any]) -> None:
        data = np.ascontiguousarray(rows, dtype=self.kind)
        self.file.write(data.data)
        while len(data):
            begun = self.rows % BLOCK
            take, data = data[: BLOCK - begun], data[BLOCK - begun :]
            self.sums[len(self.sums) - bool(begun) :] = [
                zlib.crc32(take.data, self.sums[-1] if begun else 0)
            ]
            self.rows += len(take)

    def finish(self) -> None:
        self.file.seek(0)
        if self._head() != self.start:  # numpy leaves room for 21 digits
            raise InputError(f"the head of an array of {self.rows} rows outgrew its room")
        self.file.flush()
        os.fsync(self.file.fileno())
        self.file.close()

    def _head(self) -> int:
        shape = (self.rows, *self.tail)
        np.lib.format.write_array_header_1_0(
            self.file, {"descr": self.kind.str, "fortran_order": False, "shape": shape}
        )
        return self.file.tell()


class ResultsWriter(Closing):
    """Writes the readings of a recording as they come; made by `open_results_file`."""

    def __init__(
        self, place: Pending, content: dict[str, Any], taxels: int, kind: np.dtype[Any]
    ) -> None:
        self.place, self.content, self.taxels, self.kind = place, content, taxels, kind
        self._columns: list[_Column] = []
        with explained(place.target):
            place.part.mkdir()
            try:
                for name, each, tail in ((STAMPS, "<i8", ()), (READINGS, kind, (taxels,))):
                    file = (place.part / name).open("xb")
                    self._columns.append(_Column(file, np.dtype(each), tail))
            except BaseException:
                self.discard()
                raise

    def write(self, stamp_ns: NDArray[np.int64], readings: Floats) -> None:
        """Add readings (T, L), as they are stored, with their stamps (T,).

        Raises
        ------
        FileError
            If they cannot be written.
        """
        check_shape("readings", readings, (None, self.taxels), "one number per taxel")
        check_shape("stamp_ns", stamp_ns, (len(readings),), "one per reading")
        with explained(self.place.target):
            self._columns[0].append(stamp_ns)
            self._columns[1].append(narrowed(readings, self.kind))

    def close(self, notes: tuple[str, ...] | None = None) -> None:
        """Finish; `notes`, if given, take the place of those that were said at the start."""
        if not self._columns:
            return
        stamps, readings = self._columns
        try:
            if not readings.rows:
                raise InputError("no reading was written, expected one or more")
            sums = {STAMPS: stamps.sums, READINGS: readings.sums}
            self.content |= {"readings": readings.rows, "sums": sums}
            if notes is not None:
                self.content["notes"] = list(notes)
            text = text_from_content(self.content)
            with explained(self.place.target):
                for column in self._columns:
                    column.finish()
                (self.place.part / SETTINGS).write_text(text, encoding="utf-8")
            self.place.commit()
            self._columns = []
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """Give up: what was written is removed."""
        for column in self._columns:
            with suppress(OSError, ValueError):
                column.file.close()
        self._columns = []
        self.place.discard()


def open_results_file(
    path: str | Path,
    recipe: Recipe,
    kind: np.dtype[Any],
    *,
    conditioner: Conditioner | None = None,
    notes: tuple[str, ...] = (),
    source: str = "",
) -> ResultsWriter:
    """Start a file of results, which `sources.open_results` reads.

    Parameters
    ----------
    path : str or Path
        Ends in `.skinfield`; a folder of that name is made at the end.
    recipe : Recipe
        Of the reconstructor.
    kind : dtype
        Of the readings in the file; see `batch_format.Extent`.
    conditioner : Conditioner, optional
        What turns counts into readings in the quantity's unit; without it they are.
    notes, source
        As `LazyResults` has them.

    Raises
    ------
    InputError
        For another extension, or a part of the recipe that no file can hold.
    FileError
        If the file cannot be made.
    """
    if Path(path).suffix.lower() != ".skinfield":
        raise InputError(f"path is {str(path)!r}, expected a name that ends in .skinfield")
    how = (None, None) if conditioner is None else (conditioner.calibration, conditioner.board)
    content: dict[str, Any] = {
        "taxels": len(recipe.patch),
        "type": kind.str,
        "recipe": recipe.to_plain(),
        "calibration": plain_from_value("calibration", how[0]),
        "board": plain_from_value("board", how[1]),
        "notes": list(notes),
        "source": source,
    }
    return ResultsWriter(pending(path), content, len(recipe.patch), kind)


def save_results(
    path: str | Path,
    reconstructor: Reconstructor,
    readings: ArrayLike,
    stamp_ns: ArrayLike | None = None,
    *,
    exact: bool = False,
    notes: tuple[str, ...] = (),
    source: str = "",
) -> None:
    """Write readings with what reconstructs them; `sources.open_results` computes the rest.

    Parameters
    ----------
    path : str or Path
        Ends in `.skinfield`.
    reconstructor : Reconstructor
    readings : (T, L) array, in the quantity's unit
        NaN marks a taxel that did not answer; each with a valid taxel.
    stamp_ns : (T,) array, ns, optional
        Default the number of the reading.
    exact : bool
        Keep double precision where single would round; else only if it rounds by a thousandth of
        the noise or more.

    Raises
    ------
    InputError
        For another extension, readings that no skin has, or a solver that no file can hold.
    FileError
        If the file cannot be written.
    """
    from skinfield.pipeline.arguments import checked_readings

    table, _ = checked_readings(readings, None, reconstructor.patch, reconstructor.quantity)
    stamps = np.arange(len(table)) if stamp_ns is None else np.asarray(stamp_ns)
    check_shape("stamp_ns", stamps, (len(table),), "one per reading")
    if stamps.dtype.kind not in "iu":
        raise InputError(f"stamp_ns holds {stamps.dtype}, expected whole nanoseconds")
    if int(stamps.max()) > np.iinfo(np.int64).max:
        raise InputError(f"stamp_ns reaches {stamps.max()}, expected nanoseconds below 2**63")
    extent = Extent()
    extent.add(table)
    noise = None if exact else float(np.min(reconstructor.model.noise_std))
    with open_results_file(
        path, Recipe.of(reconstructor), extent.kind(noise), notes=notes, source=source
    ) as writer:
        writer.write(stamps.astype(np.int64), table)
