"""Archives of one's own recordings: NPZ as it is read, and NPZ and CSV as they are written.

Keys: `stamp_ns` (T,) whole numbers or `time_s` (T,); `counts` (T, C); and if there is more to say
`uid` (C,), `unit` (one of `skinfield.skin.reading.UNITS`, else "count"), `source`.
"""

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, InputError
from skinfield.files.pending import write_bytes, write_npz
from skinfield.files.recordings.head import Magic
from skinfield.files.recordings.lines import Doubts, Progress
from skinfield.skin.reading import UNITS, Recording

KEYS = ("stamp_ns", "time_s", "counts", "uid", "unit", "source")
LAYOUT = "keys counts (T, C) and stamp_ns (T,) or time_s (T,), if needed uid (C,) and unit"


def matches(head: Magic) -> bool:
    """Whether the file is a zip archive, as NPZ is."""
    return head.data.startswith((b"PK\x03\x04", b"PK\x05\x06"))


def read(head: Magic, progress: Progress | None) -> Recording:
    """Read an archive whose head `matches`."""
    found = _load(head)
    if not {"stamp_ns", "time_s"} & set(found):
        raise FileError(f"{head.path} lacks keys: expected {LAYOUT}")
    counts = _floats(head, "counts", found["counts"])
    if counts.ndim != 2 or not counts.size:
        raise FileError(f"{head.path}: counts has shape {counts.shape}, expected (T, C), T, C >= 1")
    stamps = _stamps(head, found)
    if stamps.shape != counts.shape[:1]:
        raise FileError(
            f"{head.path}: {stamps.shape} stamps for {len(counts)} rows of counts, expected as many"
        )
    uid = _uids(head, found, counts.shape[1])
    rows = np.arange(len(counts))
    doubts = Doubts(head.path)
    doubts.add(stamps, counts, rows)
    notes = doubts.notes()
    unit = str(found["unit"]) if "unit" in found else "count"
    if unit not in UNITS:
        raise FileError(
            f"{head.path}: unit {unit[:20]!r} is not known, expected one of {', '.join(UNITS)}"
        )
    if "unit" not in found:
        notes += ("no key `unit` is there: taken as count",)
    source = f"{head.path} ({found['source']})" if "source" in found else str(head.path)
    if progress is not None:
        progress(head.size, head.size)
    return Recording(stamps, counts, uid, unit, source, notes)


def _load(head: Magic) -> dict[str, NDArray[Any]]:
    """Arrays under the known keys; whatever a damaged archive raises becomes a FileError."""
    try:
        with warnings.catch_warnings(), head.path.open("rb") as file:
            warnings.simplefilter("ignore")
            archive = np.load(file, allow_pickle=False)
            names = list(archive.files)
            found = {key: np.asarray(archive[key]) for key in KEYS if key in names}
    except Exception as error:  # zip, zlib, struct and numpy each have errors of their own
        raise FileError(
            f"{head.path} cannot be read as NPZ ({type(error).__name__}: {str(error)[:120]}), "
            f"expected {LAYOUT}"
        ) from error
    if "counts" in found:
        return found
    hint = ": it looks like a layout, give it as one" if "positions" in names else ""
    hint = ": it looks like fields that were computed" if "pressure" in names else hint
    raise FileError(
        f"{head.path} holds the keys {', '.join(names[:8])[:200]}, expected {LAYOUT}{hint}"
    )


def _floats(head: Magic, key: str, values: NDArray[Any]) -> Floats:
    if values.dtype.kind not in "fiub":
        raise FileError(f"{head.path}: {key} holds {values.dtype}, expected numbers")
    return np.array(values, np.float64)


def _stamps(head: Magic, found: dict[str, NDArray[Any]]) -> NDArray[np.int64]:
    if "stamp_ns" in found:
        stamps = found["stamp_ns"]
        if stamps.dtype.kind not in "iu" or (stamps.size and int(stamps.max()) >= 2**63):
            raise FileError(f"{head.path}: stamp_ns holds {stamps.dtype}, expected int64")
        return stamps.astype(np.int64)
    time = _floats(head, "time_s", found["time_s"])
    if not (np.abs(time) < 9.2e9).all():
        raise FileError(
            f"{head.path}: time_s holds a value that is not finite or beyond 292 years, "
            "expected seconds"
        )
    return np.round(time * 1e9).astype(np.int64)


def _uids(head: Magic, found: dict[str, NDArray[Any]], columns: int) -> NDArray[np.uint64] | None:
    if "uid" not in found:
        return None
    uid = found["uid"]
    fits = uid.dtype.kind in "iu" and uid.shape == (columns,) and (uid.size and uid.min() >= 0)
    if not fits:
        raise FileError(
            f"{head.path}: uid is {uid.dtype} {uid.shape}, expected ({columns},) whole numbers "
            "from 0, one per column of counts"
        )
    return uid.astype(np.uint64)


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
