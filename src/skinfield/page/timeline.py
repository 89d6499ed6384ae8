"""Timeline of a recording: force, touches and readings over time, and its table of contacts."""

import csv
import io
import threading
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import InputError, SkinfieldError
from skinfield.estimate.contact_table import COLUMNS, Row, rows_from_estimate
from skinfield.files.mcap.live import LiveRecording
from skinfield.loop.slots import CycleSlot
from skinfield.loop.snapshot import Snapshot
from skinfield.record.replay import Replay

HEAD = ",".join((*COLUMNS, "track", "patch"))  # the library's columns, and whose contact it is
BINS = 1500  # of the force over a recording
MOST_TOUCHES = 2000  # that are told
MOST_ROWS = 200_000  # of a table that is asked for at once
NEAR = 1e-6  # s: times of the same reading
ENDS = 10.0  # s for the thread to end


def rows_of(snapshot: Snapshot, start_ns: int) -> Iterator[Row]:
    """Rows of the contacts of one cycle in the order of `HEAD`; `start_ns` is where time is 0."""
    known = set(snapshot)
    for place, patch in enumerate(snapshot.model_config.skin):
        tracks = snapshot.contacts["track"][snapshot.contacts["patch"] == place].tolist()
        if not tracks or patch.name not in known:
            continue
        found = rows_from_estimate(snapshot[patch.name], snapshot.number, start_ns)
        for row, track in zip(found, tracks, strict=True):
            yield (*row, track, patch.name)


def lines(rows: Iterable[Row]) -> list[str]:
    """Rows as lines of a CSV file, numbers with nine digits; times and counts whole."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    for row in rows:
        writer.writerow([f"{each:.9g}" if isinstance(each, float) else each for each in row])
    return out.getvalue().splitlines()


class Timeline:
    """Reads a recording from its beginning to its end once, beside what is shown of it.

    Parameters
    ----------
    path : Path
        Of a recording that `Replay` reads.
    first_ns, end_s : int, float
        When its first cycle was, ns since the epoch, and how much later the last one.

    Attributes
    ----------
    told : dict or None
        `times` and total `force` of equal parts of the recording, s and N, the largest of each
        that has a cycle; `touches`: pairs of times; `contacts`: pairs of times and forces of each,
        by its key. None until they are known.
    damage : str
        Why it could not be read to its end, if so.
    """

    def __init__(self, path: Path, first_ns: int, end_s: float) -> None:
        self._path, self._first_ns, self._end_s = path, first_ns, end_s
        self.told: dict[str, Any] | None = None
        self.damage = ""
        self._fresh = array("d")  # when readings were, s
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=f"timeline-{path.name}", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        force = np.full(BINS, np.nan)  # parts without a cycle stay so, and are not told
        touches: dict[int, list[float]] = {}
        forces: dict[int, dict[int, float]] = {}  # of each track, by parts
        try:
            for cycle in LiveRecording.open(self._path).cycles():
                if self._closed:
                    return
                time_s = min(max((cycle.wall_ns - self._first_ns) * 1e-9, 0.0), self._end_s)
                if (cycle.patches["fresh"] > 0).any():
                    self._fresh.append(time_s)
                part = min(int(BINS * time_s / max(self._end_s, 1e-9)), BINS - 1)
                force[part] = np.fmax(force[part], cycle.contacts["normal_force"].sum())
                seen = cycle.contacts["track"].tolist(), cycle.contacts["normal_force"].tolist()
                for track, newtons in zip(*seen, strict=True):
                    touches.setdefault(track, [time_s, time_s])[1] = time_s
                    its = forces.setdefault(track, {})
                    its[part] = max(its.get(part, newtons), newtons)
        except SkinfieldError as error:  # what is before it is told
            self.damage = str(error)
        times = (np.arange(BINS) + 0.5) * (self._end_s / BINS)
        there = np.isfinite(force)
        known = sorted(touches.values())[:MOST_TOUCHES]
        longest = sorted(forces, key=lambda track: -len(forces[track]))[:MOST_TOUCHES]
        self.told = {
            "times": np.round(times[there], 4).tolist(),
            "force": np.round(force[there], 4).tolist(),
            "touches": [[round(begin, 3), round(end, 3)] for begin, end in known],
            "contacts": {
                f"{self._path.name} {track}": [
                    np.round(times[list(forces[track])], 4).tolist(),
                    np.round(list(forces[track].values()), 4).tolist(),
                ]
                for track in longest
            },
        }

    def step(self, time_s: float, count: int) -> float:
        """Time, s, of the reading that is `count` after the one at a time, or before it.

        Raises
        ------
        InputError
            While the recording is still being read.
        """
        if self.told is None:
            raise InputError("the recording is still being read, expected to step a moment later")
        if not self._fresh:
            return time_s
        after = bisect_right(self._fresh, time_s + NEAR) - 1
        before = bisect_left(self._fresh, time_s - NEAR)
        place = (after if count > 0 else before) + count
        return self._fresh[min(max(place, 0), len(self._fresh) - 1)]

    def csv(self, begin_s: float, end_s: float) -> str:
        """The table of contacts of a span: `HEAD`, and a row per contact and reading.

        Raises
        ------
        InputError
            For a span with more than `MOST_ROWS` of them.
        """
        found = [HEAD]
        for row in self._rows(begin_s, end_s):
            found += lines([row])
            if len(found) > MOST_ROWS:
                raise InputError(
                    f"{begin_s:g} s to {end_s:g} s has more than {MOST_ROWS} contacts, expected a "
                    f"shorter span: `skinfield export {self._path.name} -o contacts.csv` writes all"
                )
        return "\n".join(found) + "\n"

    def _rows(self, begin_s: float, end_s: float) -> Iterator[Row]:
        replay = Replay(self._path)
        for each in replay.from_time(self._first_ns + round(begin_s * 1e9)):
            wall_ns = each.cycle.wall_ns
            if wall_ns > self._first_ns + round(end_s * 1e9):
                return
            if each.fresh:
                own = CycleSlot.empty(replay.sizes)
                own.copy_from(each.slot)
                snapshot = Snapshot(own, each.cycle.number, replay.models(wall_ns), wall_ns)
                yield from rows_of(snapshot, self._first_ns)

    def close(self) -> None:
        """End the thread."""
        self._closed = True
        self._thread.join(ENDS)
