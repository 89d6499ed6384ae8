"""Recordings to files that `skinfield.files.open_recording` reads."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from skinfield.errors import InputError
from skinfield.files.pending import write_bytes, write_npz
from skinfield.skin.reading import UNITS, Recording


def save_recording(recording: Recording, path: str | Path) -> None:
    """Write a recording as CSV or NPZ, by the extension; nothing of its values is lost.

    Parameters
    ----------
    recording : Recording
        Its notes and count of skipped lines are not kept: they speak of another file.
    path : str or Path
        Ends in `.csv` (comments, a line of names, one line per reading) or `.npz`.

    Raises
    ------
    InputError
        For another extension, or a unit that is not in `skinfield.skin.reading.UNITS`.
    FileError
        If the file cannot be written.
    """
    if recording.unit not in UNITS:
        raise InputError(f"unit is {recording.unit!r}, expected one of {', '.join(UNITS)}")
    kind = Path(path).suffix.lower()
    if kind == ".csv":
        write_bytes(path, "".join(_lines(recording)).encode())
    elif kind == ".npz":
        arrays = {"stamp_ns": recording.stamp_ns, "counts": recording.counts}
        arrays |= {"unit": np.array(recording.unit), "source": np.array(recording.source)}
        write_npz(path, arrays if recording.uid is None else {**arrays, "uid": recording.uid})
    else:
        raise InputError(f"path is {str(path)!r}, expected a name that ends in .csv or .npz")


def _lines(recording: Recording) -> Iterator[str]:
    yield f"# unit = {recording.unit}\n"
    if recording.source:
        yield f"# source = {' '.join(recording.source.split())}\n"
    if recording.uid is None:
        names = [f"taxel_{channel}" for channel in range(recording.counts.shape[1])]
    else:
        names = [f"uid_{uid}" for uid in recording.uid.tolist()]
    yield ",".join(["time_s", *names]) + "\n"
    for stamp, row in zip(recording.stamp_ns.tolist(), recording.counts, strict=True):
        yield f"{seconds(stamp)},{','.join(map(repr, row.tolist()))}\n"


def seconds(stamp_ns: int) -> str:
    """Seconds to the nanosecond, which a float could not hold."""
    whole, part = divmod(abs(stamp_ns), 10**9)
    return f"{'-' if stamp_ns < 0 else ''}{whole}.{part:09d}"
