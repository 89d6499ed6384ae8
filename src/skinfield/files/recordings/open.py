"""Open a recording, whatever its format."""

from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Protocol

from skinfield.errors import FileError
from skinfield.files.mcap import reader as mcap
from skinfield.files.recordings import archive, cyskin_recorder, cyskin_text, table, yarp
from skinfield.files.recordings.head import Head, read_head
from skinfield.files.recordings.lines import Progress
from skinfield.files.recordings.mistaken import is_binary, verdict
from skinfield.files.recordings.stream import Contents, RecordingStream, collected
from skinfield.skin.reading import Recording


class Format(Protocol):
    """What every module of a format offers."""

    def matches(self, head: Head, /) -> bool:
        """Whether the file is of this format."""
        ...

    def contents(self, head: Head, columns: Sequence[int | str] | None, /) -> Contents:
        """What its lines hold."""
        ...


FORMATS: tuple[Format, ...] = (table, cyskin_recorder, cyskin_text, yarp)  # the strictest first


def open_recording(
    path: str | Path,
    *,
    columns: Sequence[int | str] | None = None,
    progress: Progress | None = None,
) -> Recording:
    """Read a recording; its content says which format it has.

    Parameters
    ----------
    path : str or Path
        A recording of a live skin (MCAP), a yarpdatadumper log (the folder or its `data.log`),
        CySkin text of either kind, CSV or NPZ: see the modules of this package for each.
    columns : sequence of int or str, optional
        Value columns to keep, by place from 0, or by name where the file has names. Default all.
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
    InputError
        If `columns` names one that is not there.
    """
    found = stream_recording(path, columns=columns, progress=progress)
    return found if isinstance(found, Recording) else collected(found)


def stream_recording(
    path: str | Path,
    *,
    columns: Sequence[int | str] | None = None,
    progress: Progress | None = None,
) -> RecordingStream | mcap.LiveStream | Recording:
    """Open a recording that may be too long for memory; see `open_recording`.

    Returns
    -------
    RecordingStream, LiveStream or Recording
        A stream of text of any kind, or of MCAP, whose `blocks` are read one by one. An NPZ file is
        read as a whole: it is compressed as such.
    """
    head = read_head(_file(Path(path)))
    if archive.matches(head):
        return archive.read(head, columns, progress)
    if mcap.matches(head):
        return mcap.stream(head, columns, progress)
    return RecordingStream(_contents(head, columns), progress)


def _contents(head: Head, columns: Sequence[int | str] | None) -> Contents:
    if not is_binary(head):
        for fmt in FORMATS:
            if fmt.matches(head):
                return fmt.contents(head, columns)
    raise FileError(verdict(head))


def _file(path: Path) -> Path:
    """The file itself, or the log in a folder."""
    try:
        if not path.is_dir():
            return path
        if (path / "data.log").is_file():
            return path / "data.log"
        inner = [
            str(log.parent)
            for depth in ("*", "*/*", "*/*/*", "*/*/*/*", "*/*/*/*/*")
            for log in islice(path.glob(f"{depth}/data.log"), 5)
        ]
    except (OSError, ValueError) as error:  # a path with a zero byte is a ValueError
        raise FileError(f"{path!s} cannot be opened: {error}; expected a recording") from error
    hint = f"; logs lie in {', '.join(inner[:5])}" if inner else ""
    raise FileError(f"{path} is a folder without data.log, expected a yarpdatadumper log{hint}")
