"""Export of a recording of a live skin: from its messages to the rows of tables.

Everything comes in pieces and is written as it comes: memory does not grow with the recording.
"""

import json
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.estimate.contact_table import scale_of
from skinfield.files.mcap.live import LiveRecording
from skinfield.files.mcap.reader import Scan, port_of, ports_of
from skinfield.files.mcap.schema import BLOCKS, CYCLES, Cycle, Rows
from skinfield.files.pending import Closing, write_bytes
from skinfield.files.tables import TableFile, Values

HELD = 4096  # cycles whose rows are written together
TIMES = ("flags", "wall_ns", "due_ns", "wake_ns", "acquired_ns", "done_ns", "log_position")


class LiveExport(Closing):
    """Takes the parts of a recording in any order of pieces."""

    @abstractmethod
    def add_counts(self, patch: int, stamp_ns: Ints, counts: Floats) -> None:
        """Add readings (T, L) of a patch, in the order of its taxels; NaN where there was none."""

    @abstractmethod
    def add_rows(self, tables: Mapping[str, Rows]) -> None:
        """Add rows of some of `Export.tables`; those of cycles come together."""

    @abstractmethod
    def add_happened(
        self, timing: Sequence[dict[str, Any]], events: Sequence[dict[str, Any]]
    ) -> None:
        """Add what was measured each second, and what happened."""


def flat(rows: Rows) -> Iterator[tuple[str, NDArray[Any]]]:
    """Columns of a table by their names, where a field of n numbers becomes n."""
    for field in rows.dtype.names or ():
        values: Any = rows[field]
        for index in np.ndindex(values.shape[1:]):
            column = np.ascontiguousarray(values[(slice(None), *index)])
            yield "_".join((field, *map(str, index))), column


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
        scale = {"forces": export.scale}
        self._files: dict[str, TableFile] = {}
        self._happened, self._text = path.with_suffix(".events.json"), b""
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
            self._files["counts"] = TableFile(path, counts, {"unit": export.units[0], **source})
            for table, rows in export.tables.items():
                beside = path.with_suffix(f".{table}{path.suffix}")
                columns = [(name, values.dtype) for name, values in flat(rows)]
                self._files[table] = TableFile(beside, columns, scale | source)
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

    def add_rows(self, tables: Mapping[str, Rows]) -> None:
        """See `LiveExport`."""
        for table, rows in tables.items():
            if len(rows):
                self._files[table].add([values for _, values in flat(rows)], len(rows))

    def add_happened(
        self, timing: Sequence[dict[str, Any]], events: Sequence[dict[str, Any]]
    ) -> None:
        """See `LiveExport`."""
        happened = {"timing": list(timing), "events": list(events)}
        self._text = json.dumps(happened, indent=1).encode()

    def close(self) -> None:
        """See `Closing`."""
        try:
            for file in self._files.values():
                file.close()
            if self._text:
                write_bytes(self._happened, self._text)
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """See `Closing`."""
        for file in self._files.values():
            file.discard()


class Export:
    """From the messages of a recording to the pieces of an export.

    Parameters
    ----------
    recording : LiveRecording
    names : tuple of str
        Patches; none for all.

    Attributes
    ----------
    source, scale : str
        File that it comes from; what its forces are, see `scale_of`.
    patches : tuple of Patch
    units : tuple of str
        Of the patches' counts.
    tables : dict of str to rows
        None yet of cycles, contacts and patch_cycles.
    numbers : list of int
        Of the patches among all of the skin's.
    """

    def __init__(self, recording: LiveRecording, names: tuple[str, ...]) -> None:
        ports, skin = ports_of(recording), recording.skin
        for name in names:
            skin[name]  # says which there are
        self._recording = recording
        self.source, self.scale = str(recording.path), scale_of(recording.relative)
        self.patches = tuple(patch for patch in skin if not names or patch.name in names)
        every = [patch.name for patch in skin]
        self.numbers = [every.index(patch.name) for patch in self.patches]
        its = [port_of(patch, ports) for patch in self.patches]
        self.units = tuple(port.unit for port in its)
        self._scans = [
            Scan(patch.channel + port.first) for patch, port in zip(self.patches, its, strict=True)
        ]
        self._held: list[Cycle] = []
        self._layout = recording.cycle_layout.completed()
        self.tables = self._cycle_tables()

    def into(self, sink: LiveExport) -> Iterator[int]:
        """Hand everything to the sink; bytes of the file that are done, now and then."""
        recording = self._recording
        for topic, at, what in recording.contents((BLOCKS, CYCLES)):
            if topic == CYCLES:
                self._held.append(self._layout.extend(what))
                if len(self._held) >= HELD:
                    self._put_cycles(sink)
            else:
                for patch, scan in enumerate(self._scans):
                    for stamps, counts in scan.feed(what.data):
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
        if self._held:
            sink.add_rows(self._cycle_tables())
            self._held.clear()

    def _cycle_tables(self) -> dict[str, Rows]:
        """Rows of the tables of the cycles that are held."""
        cycles, layout = self._held, self._layout
        heads = {"cycle": _ints([each.number for each in cycles])}
        heads |= {name: _ints([getattr(each, name) for each in cycles]) for name in TIMES}
        contacts, patches = (
            np.concatenate([np.zeros(0, kind), *(getattr(each, part) for each in cycles)])
            for part, kind in (("contacts", layout.contact), ("patches", layout.patch))
        )
        counts = _ints([len(each.contacts) for each in cycles])
        places = [np.arange(len(each.patches)) for each in cycles]
        of_contacts, of_patches = (
            {name: np.repeat(heads[name], its) for name in ("cycle", "wall_ns")}
            for its in (counts, _ints([len(each) for each in places]))
        )
        of_patches["patch"] = np.concatenate([_ints([]), *places])
        return {
            "cycles": _side_by_side({**heads, "contacts": counts}),
            "contacts": _side_by_side(of_contacts, contacts),
            "patch_cycles": _side_by_side(of_patches, patches),
        }


def _ints(values: Sequence[int]) -> Ints:
    return np.array(values, np.int64)


def _side_by_side(*parts: dict[str, Ints] | Rows) -> Rows:
    """Rows with the columns of all parts, of one name the first."""
    columns: dict[str, NDArray[Any]] = {}
    for part in parts:
        for name in part if isinstance(part, dict) else part.dtype.names or ():
            columns.setdefault(name, part[name])
    kinds = [(name, values.dtype, values.shape[1:]) for name, values in columns.items()]
    rows = np.zeros(len(next(iter(columns.values()))), kinds)
    for name, values in columns.items():
        rows[name] = values
    return rows
