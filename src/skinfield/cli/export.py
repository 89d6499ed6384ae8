"""`skinfield export`: a recording of a live skin into tables that others read."""

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from skinfield.cli.options import OUTPUT, Force, Json, McapFile
from skinfield.cli.report import check_output, finish, progress, say_notes


def export(
    file: McapFile,
    /,
    *,
    output: Annotated[str, OUTPUT],
    patch: tuple[str, ...] = (),
    form: Annotated[Literal["rosbag2", "rosbag2-sqlite"] | None, Parameter(name="--format")] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Turn FILE, a recording of a live skin, into tables that others read.

    The raw counts of every patch over time, one row per scan and empty where a taxel did not
    answer; the contacts and each patch's answer in each cycle; the cycles' times; and what
    happened. In the order of the layout's taxels, stamps in ns since the epoch, all else in SI
    units.

      out.parquet, .csv    the counts; beside it out.contacts.*, out.patch_cycles.*,
                           out.cycles.* and out.events.json

    It is read and written piece by piece: a recording may be longer than memory.

    --format rosbag2 makes a folder that `ros2 bag` reads, without ROS: counts as PointCloud2,
    contacts, forces and frames as messages, see docs/how-to/ros2.md.

      skinfield export touch.mcap -o touch.parquet
      skinfield export touch.mcap --format rosbag2 -o touch_bag
      skinfield export touch.mcap -o touch.csv --patch left_forearm

    Parameters
    ----------
    output : str
        File to write: .parquet or .csv; for a bag, a DIR.
    patch : tuple of str
        Only this patch; again for more. Default all.
    form : str, optional
        A DIR as a bag of ROS 2: MCAP, or SQLite as Humble has it. Default by the ending.
    """
    from skinfield.files.mcap.export import Export, LiveExport, TableExport
    from skinfield.files.mcap.live import LiveRecording
    from skinfield.files.ros import BagExport

    check_output("--output", output, force)
    recording = LiveRecording.open(Path(file))
    work = Export(recording, patch)
    with ExitStack() as parts:
        if form is None:
            sink: LiveExport = parts.enter_context(TableExport(output, work))
        else:
            sqlite = form == "rosbag2-sqlite"
            bag = BagExport(output, work.patches, work.numbers, sqlite=sqlite, forces=work.scale)
            sink = parts.enter_context(bag)
        with progress("exporting", recording.outline.size) as step:
            for at in work.into(sink):
                step(at)
        if form is not None:
            work.taxels_into(sink)
    notes = [f"byte {each.byte}: {each.why}: left out" for each in recording.damage[:8]]
    if not recording.finished:
        notes.insert(0, f"{file} was not finished: its end may be missing")
    say_notes(notes)
    patches = [each.name for each in work.patches]
    finish(as_json, {"file": output, "patches": patches, "notes": notes}, [output])
