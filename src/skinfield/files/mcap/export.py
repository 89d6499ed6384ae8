"""Export of a recording of a live skin: from its messages to the rows of tables.

Everything comes in pieces and is written as it comes: memory does not grow with the recording.
"""

import json
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, Ints
from skinfield.files.mcap.reader import Scan, port_of, ports_of
from skinfield.files.mcap.schema import BLOCKS, CYCLES, FITS
from skinfield.files.pending import Closing, explained, pending
from skinfield.files.tables import Table, Values

HELD = 4096  # cycles whose rows are written together
TIMES = ("flags", "wall_ns", "due_ns", "wake_ns", "acquired_ns", "done_ns", "log_position")
CYCLE = np.dtype([(name, "<i8") for name in ("cycle", *TIMES, "contacts")])
Rows = NDArray[np.void]


class LiveExport(Closing):
    """Takes the parts of a recording in any order of pieces."""

    @abstractmethod
    def add_counts(self, patch: int, stamp_ns: Ints, counts: Floats) -> None:
        """Add readings (T, L) of a patch, in the order of its taxels; NaN where there was none."""

    @abstractmethod
    def add_rows(self, table: str, rows: Rows) -> None:
        """Add rows of one of `Export.tables`."""

    @abstractmethod
    def add_happened(
        self, timing: Sequence[dict[str, Any]], events: Sequence[dict[str, Any]]
    ) -> None:
        """Add what was measured each second, and what happened."""


def flat(rows: np.dtype[Any]) -> Iterator[tuple[str, np.dtype[Any], str, tuple[int, ...]]]:
    """Columns of a table, where a field of n numbers becomes n: name, dtype, field and place."""
    for field in rows.names or ():
        for index in np.ndindex(rows[field].shape):
            yield "_".join((field, *map(str, index))), rows[field].base, field, index


class TableExport(LiveExport):
    """Counts in the file that was asked for; contacts and the rest in files beside it.

    Of one patch, the counts' columns are `uid_<uid>` (as `open_recording` reads them); of several,
    `<patch>.<taxel>`, and a row has values of one patch only. Files are written as it comes, and
    have their names once they are whole.

    Parameters
    ----------
    path : str or Path
        Ends in .parquet or .csv.
    export : Export

    Raises
    ------
    InputError
        For another ending.
    SkinfieldError
        If the package that writes it is not installed.
    FileError
        If it cannot be written there.
    """

    def __init__(self, path: str | Path, export: "Export") -> None:
        path, source = Path(path), {"source": export.source}
        self._files: dict[str, Table] = {}
        self._happened = pending(path.with_suffix(".events.json"))
        single = len(export.patches) == 1
        names = [
            f"uid_{uid}" if single else f"{patch.name}.{taxel}"
            for patch in export.patches
            for taxel, uid in enumerate(patch.uid.tolist())
        ]
        self._starts = np.cumsum([0, *map(len, export.patches)])
        counts: list[tuple[str, np.dtype[Any]]] = [("stamp_ns", np.dtype(np.int64))]
        counts += [(name, np.dtype("<f4")) for name in names]
        try:
            self._files["counts"] = Table(path, counts, {"unit": export.units[0], **source})
            for table, rows in export.tables.items():
                beside = path.with_suffix(f".{table}{path.suffix}")
                self._files[table] = Table(beside, [each[:2] for each in flat(rows)], source)
        except BaseException:
            self.discard()
            raise

    def add_counts(self, patch: int, stamp_ns: Ints, counts: Floats) -> None:
        """See `LiveExport`."""
        first, last = self._starts[patch], self._starts[patch + 1]
        values: list[Values] = [None] * (1 + int(self._starts[-1]))
        values[0] = stamp_ns
        values[1 + first : 1 + last] = list(np.ascontiguousarray(counts.T.astype(np.float32)))
        self._files["counts"].add(values, len(stamp_ns))

    def add_rows(self, table: str, rows: Rows) -> None:
        """See `LiveExport`."""
        columns: list[Values] = []
        for _, _, name, index in flat(rows.dtype):
            field: Any = rows[name]
            columns.append(np.ascontiguousarray(field[(slice(None), *index)]))
        self._files[table].add(columns, len(rows))

    def add_happened(
        self, timing: Sequence[dict[str, Any]], events: Sequence[dict[str, Any]]
    ) -> None:
        """See `LiveExport`."""
        with explained(self._happened.target):
            text = json.dumps({"timing": list(timing), "events": list(events)}, indent=1)
            self._happened.part.write_text(text, encoding="utf-8")

    def close(self) -> None:
        """See `Closing`."""
        try:
            for file in self._files.values():
                file.close()
            if self._happened.part.exists():
                self._happened.commit()
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """See `Closing`."""
        for file in self._files.values():
            file.discard()
        self._happened.discard()


class Export:
    """From the messages of a recording to the pieces of an export.

    Parameters
    ----------
    recording : LiveRecording
    names : tuple of str
        Patches; none for all.

    Attributes
    ----------
    source : str
        File that it comes from.
    patches : tuple of Patch
    units : tuple of str
        Of the patches' counts.
    tables : dict of str to dtype
        Fields of contacts, patch_cycles, cycles and, where there is a fit, fit_contacts.
    numbers : list of int
        Of the patches among all of the skin's.
    """

    def __init__(self, recording: Any, names: tuple[str, ...]) -> None:
        ports, skin = ports_of(recording), recording.skin
        for name in names:
            skin[name]  # says which there are
        self._recording = recording
        self.source = str(recording.path)
        self.patches = tuple(patch for patch in skin if not names or patch.name in names)
        every = [patch.name for patch in skin]
        self.numbers = [every.index(patch.name) for patch in self.patches]
        total = sum(port.channels for port in ports)
        its = [port_of(patch, ports) for patch in self.patches]
        self.units = tuple(port.unit for port in its)
        self._scans = [
            Scan(patch.channel + port.first, total)
            for patch, port in zip(self.patches, its, strict=True)
        ]
        layout = recording.cycle_layout
        self.tables = {
            "contacts": _with_cycle(layout.contact),
            "patch_cycles": _with_cycle(layout.patch, "patch"),
            "cycles": CYCLE,
        }
        self._fit = FitRows.of(recording)
        if self._fit is not None:
            self.tables["fit_contacts"] = self._fit.fields
        self._held: list[Any] = []

    def into(self, sink: LiveExport) -> Iterator[int]:
        """Hand everything to the sink; bytes of the file that are done, now and then."""
        recording, fit = self._recording, self._fit
        for topic, at, message in recording.messages((BLOCKS, CYCLES, FITS)):
            if topic == FITS:
                if fit is not None and len(rows := fit.rows_of(at, message.data)):
                    sink.add_rows("fit_contacts", rows)
            elif topic == CYCLES:
                cycle = recording.cycle_of(at, message.data)
                if cycle is not None:
                    self._held.append(cycle)
                if len(self._held) >= HELD:
                    self._put_cycles(sink)
            elif (logged := recording.logged_of(at, message)) is not None:
                for patch, scan in enumerate(self._scans):
                    for stamps, counts in scan.feed(logged.data):
                        sink.add_counts(patch, stamps, counts)
            yield at
        for patch, scan in enumerate(self._scans):
            for stamps, counts in scan.finish():
                sink.add_counts(patch, stamps, counts)
        self._put_cycles(sink)
        sink.add_happened(list(recording.timing()), list(recording.events()))

    def taxels_into(self, bag: Any) -> None:
        """Hand a bag what the taxels read, where that was recorded."""
        ends = np.cumsum([len(patch) for patch in self._recording.skin])
        for field in self._recording.fields():
            if len(field.values) == ends[-1]:
                parts = np.split(np.where(field.valid > 0, field.values, np.nan), ends[:-1])
                for place, number in enumerate(self.numbers):
                    bag.add_taxels(place, field.time_ns, parts[number])

    def _put_cycles(self, sink: LiveExport) -> None:
        held, self._held = self._held, []
        if not held:
            return
        sink.add_rows("cycles", _cycle_rows(held))
        for table in ("contacts", "patch_cycles"):
            rows = _rows_of(held, table, self.tables[table])
            if len(rows):
                sink.add_rows(table, rows)


def _with_cycle(rows: "np.dtype[Any]", place: str = "") -> "np.dtype[Any]":
    """The rows' fields behind the cycle's number and time, and the row's place if it is named."""
    more = [(place, "<i8")] if place else []
    return np.dtype([("cycle", "<i8"), ("wall_ns", "<i8"), *more, *rows.descr])


def _cycle_rows(cycles: list[Any]) -> Any:
    rows = np.zeros(len(cycles), CYCLE)
    for row, each in zip(rows, cycles, strict=True):
        row["cycle"], row["contacts"] = each.number, len(each.contacts)
        for name in TIMES:
            row[name] = getattr(each, name)
    return rows


def _rows_of(cycles: list[Any], table: str, kind: "np.dtype[Any]") -> Any:
    """Rows of all cycles, one after the other."""
    parts = [each.contacts if table == "contacts" else each.patches for each in cycles]
    counts = [len(part) for part in parts]
    rows, joined = np.zeros(sum(counts), kind), np.concatenate(parts)
    for name in joined.dtype.names or ():
        rows[name] = joined[name]
    rows["cycle"] = np.repeat([each.number for each in cycles], counts)
    rows["wall_ns"] = np.repeat([each.wall_ns for each in cycles], counts)
    if table == "patch_cycles":
        rows["patch"] = np.concatenate([np.arange(count) for count in counts])
    return rows


class FitRows:
    """From messages of a fit to rows of a table; made by `FitRows.of`.

    A row is a contact: `wall_ns`, when the fit published it; of its patch's answer the engine's
    `cycle`, `stamp_ns` of the newest reading in it and `readings`, how many it is the mean of; and
    all fields of a contact and of its form.
    """

    def __init__(self, recording: Any, layout: Any) -> None:
        self._recording = recording
        taken, fields = {"wall_ns", "spare"}, [("wall_ns", np.dtype("<i8"))]
        self._of: dict[str, list[str]] = {}
        of_patch = ("cycle", "stamp_ns", "readings")
        for part in ("patch", "contact", "form"):
            rows = getattr(layout, part)
            names = [name for name in rows.names if name in of_patch or part != "patch"]
            self._of[part] = [name for name in names if name not in taken]
            taken.update(names)
            fields += [(name, rows[name]) for name in self._of[part]]
        self.fields = np.dtype(fields)
        self._before: dict[int, bytes] = {}

    @classmethod
    def of(cls, recording: Any) -> Self | None:
        """Of a recording; None where it has no channel of fits, or none that can be read."""
        try:
            layout = recording.fit_layout
        except FileError as error:  # the rest is whole
            recording.note(0, str(error))
            return None
        return None if layout is None else cls(recording, layout)

    def rows_of(self, at: int, data: bytes) -> Any:
        """What a message at byte `at` says that was not said before."""
        found = self._recording.fit_of(at, data)
        if found is None:
            return np.zeros(0, self.fields)
        now = {int(p): row.tobytes() for p, row in zip(found.places, found.patches, strict=True)}
        fresh = np.array([self._before.get(place) != row for place, row in now.items()], bool)
        self._before = now
        counts = found.patches["contacts"]
        new = np.repeat(fresh, counts)
        rows = np.zeros(int(new.sum()), self.fields)
        rows["wall_ns"] = found.time_ns
        parts = np.repeat(found.patches, counts), found.contacts, found.forms
        for names, its in zip(self._of.values(), parts, strict=True):
            for name in names:
                rows[name] = its[name][new]
        return rows
