"""`skinfield export`: a recording of a live skin into tables and arrays that others read."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import numpy as np

from skinfield.cli.report import progress, say_notes
from skinfield.errors import InputError

HELD = 4096  # cycles whose rows are written together


@click.command(
    short_help="Turn a recording of a live skin into Parquet, CSV, Zarr, HDF5 or a bag of ROS 2.",
    help="""Turn FILE, a recording of a live skin, into arrays and tables that others read.

The raw counts of every patch over time, one row per scan and empty where a taxel did not answer;
the engine's contacts and, where a contact fit ran beside it, the fit's; each patch's answer in each
cycle; the cycles' times; and what happened. In the order of the layout's taxels, stamps in ns since
the epoch, all else in SI units.

\b
  out.h5, out.zarr     patches/<name>/counts and stamp_ns; contacts, fit_contacts, patch_cycles,
                       cycles, events
  out.parquet, .csv    the counts; beside it out.contacts.*, out.fit_contacts.*,
                       out.patch_cycles.*, out.cycles.* and out.events.json

It is read and written piece by piece: a recording may be longer than memory.

--format rosbag2 makes a folder that `ros2 bag` reads, without ROS: counts as PointCloud2, contacts,
forces and frames as messages, see docs/ros2.md.

\b
  skinfield export touch.mcap -o touch.h5
  skinfield export touch.mcap --format rosbag2 -o touch_bag
  skinfield export touch.mcap -o touch.parquet --patch left_forearm
""",
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-o", "--output", required=True, help="Ends in .parquet, .csv, .zarr or .h5.")
@click.option("--patch", "patches", multiple=True, help="Only this one; repeatable. Default all.")
@click.option(
    "--format",
    "form",
    type=click.Choice(["rosbag2", "rosbag2-sqlite"]),
    help="A folder as a bag of ROS 2: MCAP, or SQLite as Humble has it. Default by the ending.",
)
def export(file: Path, output: str, patches: tuple[str, ...], form: str | None) -> None:
    """Run the command."""
    from skinfield.sources.recordings.mcap_live import LiveRecording

    recording = LiveRecording.open(file)
    work = _Work(recording, patches)
    with _sink_of(output, form, work) as sink, progress() as bar:
        task = bar.add_task("exporting", total=recording.outline.size)
        for at in work.into(sink):
            bar.update(task, completed=at)
        notes = work.views_into(sink) if form else []
    notes += [f"byte {each.byte}: {each.why}: left out" for each in recording.damage[:8]]
    if not recording.finished:
        notes.insert(0, f"{file} was not finished: its end may be missing")
    say_notes(notes)


def _sink_of(output: str, form: str | None, work: "_Work") -> Any:
    from skinfield.sinks.live_tables import open_export

    if form is None:
        return open_export(output, work.what)
    from skinfield.sinks.ros import BagExport

    return BagExport(output, work.what.patches, work.numbers, sqlite=form == "rosbag2-sqlite")


class _Work:
    """From the messages of a recording to the pieces of an export."""

    def __init__(self, recording: Any, names: tuple[str, ...]) -> None:
        from skinfield.cli.export_fit import FitRows
        from skinfield.sinks.live_tables import Exported
        from skinfield.sources.recordings.mcap_table import Scan, port_of, ports_of

        ports, skin = ports_of(recording), recording.skin
        for name in names:
            skin[name]  # says which there are
        self._recording = recording
        chosen = tuple(patch for patch in skin if not names or patch.name in names)
        every = [patch.name for patch in skin]
        self.numbers = [every.index(patch.name) for patch in chosen]
        total = sum(port.channels for port in ports)
        its = [port_of(patch, ports) for patch in chosen]
        self._scans = [
            Scan(patch.channel + port.first, total) for patch, port in zip(chosen, its, strict=True)
        ]
        layout = recording.cycle_layout
        self._tables = {
            "contacts": _with_cycle(layout.contact),
            "patch_cycles": _with_cycle(layout.patch, "patch"),
            "cycles": CYCLE,
        }
        units = tuple(port.unit for port in its)
        self._fit = FitRows.of(recording)
        if self._fit is not None:
            self._tables["fit_contacts"] = self._fit.fields
        self.what = Exported(str(recording.path), chosen, units, self._tables)
        self._held: list[Any] = []

    def into(self, sink: Any) -> Iterator[int]:
        """Hand everything to the sink; bytes of the file that are done, now and then."""
        from skinfield.acquisition.recorded import BLOCKS, CYCLES
        from skinfield.acquisition.recorded_fit import FITS

        recording, fit = self._recording, self._fit
        for topic, at, message in recording.messages((BLOCKS, CYCLES, FITS)):
            if topic == FITS:
                if fit is not None and len(rows := fit.rows_of(at, message.data)):
                    sink.add_rows("fit_contacts", rows)
            elif topic == CYCLES:
                cycle = recording.cycle_of(at, message)
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

    def views_into(self, bag: Any) -> list[str]:
        """Hand a bag the taxels that were recorded for ROS; what was left out, in words."""
        topics = {bag.taxels_of(place) for place in range(len(self.numbers))}
        known = {each.topic for each in self._recording.channels.values() if each.encoding == "cdr"}
        left = 0
        if not (wanted := known & topics):
            return []
        for topic, _, message in self._recording.messages(wanted):
            left += not bag.add_taxels(topic, message.time_ns, message.data)
        return [f"{left} messages of taxels that cannot be read: left out"] if left else []

    def _put_cycles(self, sink: Any) -> None:
        held, self._held = self._held, []
        if not held:
            return
        sink.add_rows("cycles", _cycle_rows(held))
        for table in ("contacts", "patch_cycles"):
            rows = _rows_of(held, table, self._tables[table])
            if len(rows):
                sink.add_rows(table, rows)


CYCLE = np.dtype(
    [(name, "<i8") for name in ("cycle", "flags", "wall_ns", "due_ns", "wake_ns", "acquired_ns",
                                "done_ns", "log_position", "contacts")]
)  # fmt: skip


def _with_cycle(rows: "np.dtype[Any]", place: str = "") -> "np.dtype[Any]":
    """The rows' fields behind the cycle's number and time, and the row's place if it is named."""
    clash = {"cycle", "wall_ns", place} & set(rows.names or ())
    if clash:
        raise InputError(f"rows have the fields {sorted(clash)}, which stand for the cycle")
    more = [(place, "<i8")] if place else []
    return np.dtype([("cycle", "<i8"), ("wall_ns", "<i8"), *more, *rows.descr])


def _cycle_rows(cycles: list[Any]) -> Any:
    rows = np.zeros(len(cycles), CYCLE)
    for name in CYCLE.names or ():
        rows[name] = [
            {"cycle": each.number, "contacts": len(each.contacts)}.get(name)
            if name in ("cycle", "contacts")
            else getattr(each, name)
            for each in cycles
        ]
    return rows


def _rows_of(cycles: list[Any], table: str, kind: "np.dtype[Any]") -> Any:
    """Rows of all cycles, one after the other."""
    parts = [each.contacts if table == "contacts" else each.patches for each in cycles]
    counts = [len(part) for part in parts]
    rows = np.zeros(sum(counts), kind)
    rows["cycle"] = np.repeat([each.number for each in cycles], counts)
    rows["wall_ns"] = np.repeat([each.wall_ns for each in cycles], counts)
    if table == "patch_cycles":
        rows["patch"] = np.concatenate([np.arange(count) for count in counts])
    joined = np.concatenate(parts)
    for name in joined.dtype.names or ():
        rows[name] = joined[name]
    return rows
