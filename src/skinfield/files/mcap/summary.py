"""Summary of a live recording, in numbers: one pass over it."""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError, Ints
from skinfield.files.mcap.live import LiveRecording, Logged
from skinfield.files.mcap.reader import Scan, port_of, ports_of
from skinfield.files.mcap.schema import BLOCKS, CYCLES, FIELDS, Cycle, CycleFlag

Progress = Callable[[int, int], None]
SHOWN = 200  # events and places of damage in a summary
SHARES = {"p50": 0.5, "p99": 0.99, "p999": 0.999, "max": 1.0}


def summary_of(recording: LiveRecording, progress: Progress | None = None) -> dict[str, Any]:
    """Everything that `skinfield info` says, as plain values for JSON.

    Parameters
    ----------
    recording : LiveRecording
    progress : callable, optional
        Called with bytes done and bytes in all.

    Raises
    ------
    FileError
        If the file cannot be read any more.
    """
    blocks, cycles = _Blocks(recording), _Cycles()
    first, last = 1 << 63, 0
    fields = {"messages": 0, "bytes": 0}
    for topic, at, message in recording.messages():
        first, last = min(first, message.time_ns), max(last, message.time_ns)
        what = None
        if topic in (BLOCKS, CYCLES):
            with suppress(FileError):  # its layout is damaged, which the message about cycles says
                what = recording.decoded(topic, at, message.data)
        if what is not None:
            (blocks if topic == BLOCKS else cycles).add(what)
        elif topic == FIELDS:
            fields["messages"] += 1
            fields["bytes"] += len(message.data)
        if progress is not None:
            progress(at, recording.outline.size)
    seconds = max(last - first, 0) * 1e-9
    events, skin = list(recording.events()), None
    with suppress(FileError):
        skin = recording.skin
    return {
        "path": str(recording.path),
        "finished": recording.finished,
        "bytes": recording.outline.size,
        "began_ns": first if last else None,
        "seconds": seconds,
        "skin": None if skin is None else skin.name,
        "taxels": None if skin is None else sum(map(len, skin)),
        "patches": list(blocks.patches(seconds)),
        "readings": {"bytes": blocks.bytes, "missing_bytes": blocks.missing},
        **cycles.summary(seconds),
        "fields": fields,
        "settings": [event for event in events if event.get("kind") == "settings"],
        "lost": _lost(events),
        "events": dict(Counter(str(event.get("kind")) for event in events)),
        "last_events": events[-SHOWN:],
        "attachments": {name: len(each.data) for name, each in recording.attached.items()},
        "damage": [{"byte": each.byte, "why": each.why} for each in recording.damage[:SHOWN]],
    }


def _lost(events: list[dict[str, Any]]) -> dict[str, int]:
    """What is not in the file, by what lost it."""

    def total(kind: str, what: str) -> int:
        values = [event.get(what) for event in events if event.get("kind") == kind]
        return sum(value for value in values if isinstance(value, int))

    return {
        "messages": total("messages_lost", "messages"),
        "overrun_bytes": total("log_overrun", "bytes"),
        "overrun_cycles": total("cycle_overrun", "cycles"),
        "dropped_bytes": total("dropped", "bytes"),
        "dropped_cycles": total("dropped", "cycles"),
    }


class _Blocks:
    """Bytes of the log, and scans of each patch."""

    def __init__(self, recording: LiveRecording) -> None:
        self.bytes = self.missing = 0
        self._end = -1
        self._scans: list[tuple[str, int, Scan]] = []
        self._rows: Counter[str] = Counter()
        try:
            ports = ports_of(recording)
            for patch in recording.skin:
                scan = Scan(patch.channel + port_of(patch, ports).first)
                self._scans.append((patch.name, len(patch), scan))
        except InputError:  # without layout or ports nobody knows whose counts they are
            self._scans = []

    def add(self, logged: Logged) -> None:
        """Count one message."""
        if 0 <= self._end < logged.position:
            self.missing += logged.position - self._end
        self._end = logged.position + len(logged.data)
        self.bytes += len(logged.data)
        for name, _, scan in self._scans:
            self._rows[name] += sum(len(stamps) for stamps, _ in scan.feed(logged.data))

    def patches(self, seconds: float) -> Iterator[dict[str, Any]]:
        """Readings and rates."""
        for name, taxels, scan in self._scans:
            self._rows[name] += sum(len(stamps) for stamps, _ in scan.finish())
            count = self._rows[name]
            rate = count / seconds if seconds > 0 else None
            yield {"name": name, "taxels": taxels, "readings": count, "rate": rate}


class _Cycles:
    """Counts and times of the cycles."""

    def __init__(self) -> None:
        self._rows: list[tuple[int, int, int]] = []  # number, flags, contacts
        self._times: list[tuple[int, int]] = []  # due to awake, awake to ready
        self._tracks: set[int] = set()

    def add(self, cycle: Cycle) -> None:
        """Count one."""
        self._rows.append((cycle.number, int(cycle.flags), len(cycle.contacts)))
        rows = cycle.patches  # an engine that starts has other times than later
        if "answered_ns" not in (rows.dtype.names or ()) or rows["answered_ns"].any():
            self._times.append((cycle.wake_ns - cycle.due_ns, cycle.done_ns - cycle.wake_ns))
        if "track" in (cycle.contacts.dtype.names or ()):
            self._tracks.update(cycle.contacts["track"].tolist())

    def summary(self, seconds: float) -> dict[str, Any]:
        """All of it."""
        count = len(self._rows)
        numbers, flags, contacts = np.array(self._rows, np.int64).reshape(-1, 3).T
        wake, ready = np.array(self._times, np.int64).reshape(-1, 2).T
        expected = int(numbers[-1] - numbers[0]) + 1 if count else 0
        late, overrun, restarts = (
            int(np.count_nonzero(flags & flag))
            for flag in (CycleFlag.LATE, CycleFlag.OVERRUN, CycleFlag.RESTARTED)
        )
        return {
            "cycles": count,
            "cycles_missing": max(expected - count, 0),
            "cycle_rate": count / seconds if seconds > 0 else None,
            "late": late,
            "overrun": overrun,
            "restarts": restarts,
            "wake_us": _micros(wake),
            "ready_us": _micros(ready),
            "contacts": {
                "cycles": int(np.count_nonzero(contacts)),
                "most_at_once": int(contacts.max(initial=0)),
                "tracks": len(self._tracks),
            },
        }


def _micros(times_ns: Ints) -> dict[str, float] | None:
    if not len(times_ns):
        return None
    found = np.quantile(times_ns, list(SHARES.values()), method="inverted_cdf") * 1e-3
    return dict(zip(SHARES, found.tolist(), strict=True))
