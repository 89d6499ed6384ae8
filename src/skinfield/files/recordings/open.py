"""Open a recording, whatever its format."""

import re
from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from skinfield.errors import FileError
from skinfield.files.mcap.container import MAGIC
from skinfield.files.mcap.live import LiveRecording
from skinfield.files.mcap.reader import LiveStream, live_stream
from skinfield.files.recordings import archive, columns, cyskin, table, yarp
from skinfield.files.recordings.head import Magic, is_whole, read_head
from skinfield.files.recordings.lines import Progress, RecordingStream
from skinfield.skin.log import LogSettings
from skinfield.skin.reading import Recording

KNOWN = (
    "a recording: a yarpdatadumper log (sequence time values), CySkin text (a line of uids, then "
    "sample time values), CySkin SkinRecorder text (devices, taxels, then sample time n uid value "
    "...), CSV with a line of names (time_s,taxel_0,...), or NPZ (stamp_ns, counts). With the file "
    "of a skin, --skin or sf.read(path, skin=...), any columns of CSV, MATLAB, HDF5 and NumPy "
    "files: `skinfield new` writes it"
)
NAMELESS = "its columns have no names, which the file of a skin gives"
OTHERS = {  # first bytes of files that are taken for recordings
    b"\x1f\x8b": "compressed by gzip: unpack it first",
    b"\x93NUMPY": "one NumPy array without times: save it as NPZ with stamp_ns and counts",
    b"PAR1": "a Parquet table: save it as CSV with a column time_s",
    b"\x89HDF": f"an HDF5 or MATLAB file: {NAMELESS}",
    b"MATLAB 5.0": f"a MATLAB file: {NAMELESS}",
    b"\xff\xfe": "UTF-16 text: save it as UTF-8",
    b"\xfe\xff": "UTF-16 text: save it as UTF-8",
}
INFO = r"(Type|Stamp|Source): |\[\d+\.\d+\] /"  # how an info.log begins
FORMATS: tuple[Callable[[Magic], RecordingStream | None], ...] = (  # the strictest first
    table.contents,
    cyskin.recorder,
    cyskin.text,
    yarp.contents,
)


def open_recording(
    path: str | Path, *, log: LogSettings | None = None, progress: Progress | None = None
) -> Recording:
    """Read a recording; its content says which format it has.

    Parameters
    ----------
    path : str or Path
        A recording of a live skin (MCAP), a yarpdatadumper log (the folder or its `data.log`),
        CySkin text of either kind, CSV or NPZ: see the modules of this package for each.
    log : LogSettings, optional
        Columns of a CSV of any names, as a skin's file has them (`[log]`).
    progress : callable, optional
        Called with bytes done and bytes in all, every few megabytes.

    Returns
    -------
    Recording
        A bad line is left out and counted in `skipped`; `notes` name the first ones and why, and
        say what else is doubtful: missing values, stamps that repeat or run backwards, lost
        messages.

    Raises
    ------
    FileError
        If the file is no recording, or more than a fifth of its lines cannot be read.
    """
    found = stream_recording(path, log=log, progress=progress)
    return found if isinstance(found, Recording) else collected(found)


def stream_recording(
    path: str | Path, *, log: LogSettings | None = None, progress: Progress | None = None
) -> RecordingStream | LiveStream | Recording:
    """Open a recording that may be too long for memory; see `open_recording`.

    Returns
    -------
    RecordingStream, LiveStream or Recording
        A stream of text of any kind, or of MCAP, whose `blocks` are read one by one. An NPZ file is
        read as a whole: it is compressed as such.
    """
    if log is not None and log.columns and columns.is_table_of_arrays(str(path)):
        return columns.recording_of_arrays(str(path), log)
    head = read_head(file_of(Path(path)))
    if archive.matches(head):
        return archive.read(head, progress)
    if head.data.startswith(MAGIC):
        return live_stream(LiveRecording.open(head.path), progress)
    if log is not None and log.columns and not is_binary(head):
        stream = columns.contents(head, log)
        stream.progress = progress
        return stream
    for form in () if is_binary(head) else FORMATS:
        if (found := form(head)) is not None:
            found.progress = progress
            return found
    raise FileError(verdict(head))


def collected(stream: RecordingStream | LiveStream) -> Recording:
    """All of a stream in memory."""
    parts = list(stream.blocks())
    return replace(
        parts[0],
        stamp_ns=np.concatenate([part.stamp_ns for part in parts]),
        counts=np.concatenate([part.counts for part in parts]),
        notes=stream.notes,
        skipped=stream.skipped,
    )


def file_of(path: Path) -> Path:
    """The file itself, or the log in a folder."""
    try:
        if not path.is_dir():
            return path
        if (path / "data.log").is_file():
            return path / "data.log"
        logs = (log for depth in range(1, 6) for log in path.glob("*/" * depth + "data.log"))
        inner = [str(log.parent) for log in islice(logs, 5)]
    except (OSError, ValueError) as error:  # a path with a zero byte is a ValueError
        raise FileError(f"{path!s} cannot be opened: {error}; expected a recording") from error
    hint = f"; logs lie in {', '.join(inner)}" if inner else ""
    raise FileError(f"{path} is a folder without data.log, expected a yarpdatadumper log{hint}")


def verdict(head: Magic) -> str:
    """One sentence on what a file that is no recording is, and what was expected."""
    from skinfield.files.layouts.load import fitting_formats

    what = next((what for start, what in OTHERS.items() if head.data.startswith(start)), "")
    if layouts := fitting_formats(head.data):
        what = f"a layout ({layouts[0].NAME}), not a recording: give it as the layout"
    elif not what and is_binary(head):
        what = "a binary file"
    elif re.match(INFO, head.lines[0]):
        what = "the info.log of a yarpdatadumper log: give the data.log beside it"
    if what or not head.numbered():
        return f"{head.path} is {what or 'nothing but comments'}; expected {KNOWN}"
    number, line = head.numbered()[0]
    tokens, shown = line.split(), repr(line if len(line) <= 60 else line[:60] + "...")
    if len(tokens) > 1 and all(map(is_whole, tokens)):
        why = f"starts with {len(tokens)} whole numbers, but no lines of {len(tokens) + 2} follow"
    elif table.looks_like_numbers(head):
        why = "holds numbers, but no line of names stands above them"
    elif re.search("[,;\t]", line):
        why = f"its names {shown} hold none of time_s, time_ms, stamp_ns"
    else:
        why = f"{shown} is no line of a known recording"
    return f"{head.path}:{number}: {why}; expected {KNOWN}"


def is_binary(head: Magic) -> bool:
    """Whether control characters are there that no text has."""
    sample = head.data[:65536]
    control = sum(sample.count(bytes([byte])) for byte in (*range(9), *range(14, 32), 127))
    return b"\0" in sample or control * 50 > len(sample)
