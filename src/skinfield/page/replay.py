"""Replay of a recording on the page: as it was, at any pace and from any time on."""

import math
import threading
import time
from collections import deque
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError, SkinfieldError, check_range
from skinfield.loop.realtime import Timing, TimingTable
from skinfield.loop.slots import CycleSlot, say_nothing
from skinfield.loop.snapshot import Snapshot
from skinfield.loop.status import LiveStatus, patch_rows, plain_contacts
from skinfield.page.timeline import Timeline
from skinfield.record.replay import RecordedCycle, Replay
from skinfield.skin import Skin

SPEEDS = 0.1, 10.0
LATE = 0.25  # s behind, from which on time is not made up for
SHORTEST = 0.05  # s: gaps that are shorter are not worth a word
MOST_GAPS = 4  # that are told
ENDS = 10.0  # s for the thread to end
BACK = 20  # cycles that a new reading is shown for, at the least: its times are those of an answer
MARKS = 250_000_000  # ns between counts of what was
RECENT = 1.0  # s that the status calls the last


class Clock:
    """When a cycle is due.

    Where reading takes longer than the asked pace allows, time goes on as fast as it comes.

    Attributes
    ----------
    speed : float
        Times its own pace.
    behind : bool
        Whether it goes slower than was asked.
    """

    def __init__(self, playing: bool) -> None:
        self.playing, self.speed, self.behind = playing, 1.0, False
        self._since: tuple[float, int] | None = None  # a moment, and the time that was shown then

    def play(self) -> None:
        """Let time go on."""
        self.playing, self._since = True, None

    def pause(self) -> None:
        """Stop time."""
        self.playing = self.behind = False

    def set_speed(self, speed: float) -> None:
        """Go on so many times as fast as it was."""
        self.speed, self.behind, self._since = speed, False, None

    def begin(self, time_ns: int) -> None:
        """It is this time now."""
        self.behind, self._since = False, (time.monotonic(), time_ns)

    def left(self, time_ns: int) -> float:
        """Seconds until it is this time, at most 0 if it is; infinite as long as it stands."""
        if not self.playing:
            return math.inf
        now = time.monotonic()
        if self._since is None:
            self._since = now, time_ns
        moment, shown = self._since
        left = moment + (time_ns - shown) * 1e-9 / self.speed - now
        if left > 0.0:
            self.behind = False
        elif left < -LATE:
            self.behind, self._since = True, (now, time_ns)
        return left


class RecordingSource:
    """A recording of a live skin as a `DataSource`.

    A thread reads the cycles as they were recorded; what is shown is the newest one.

    Parameters
    ----------
    path : path
        Of an MCAP file of a live skin, whole or cut.
    playing : bool
        Whether to play at once.

    Attributes
    ----------
    name : str
        Of the file.
    start_s, end_s : float, s
        Of the first cycle, which is 0, and of the last.
    events : list of (float, str)
        When what happened, s.
    gaps : list of (float, float)
        Spans, s, of which cycles are missing.
    timeline : Timeline
    loop : bool
        Whether it begins anew at its end.

    Raises
    ------
    FileError
        If it is no recording of a live skin, or has nothing that can be shown.
    """

    def __init__(self, path: str | Path, *, playing: bool = True) -> None:
        try:
            self.replay = Replay(path)
        except FileError as error:
            raise FileError(
                f"{error}; of a recording of counts alone `skinfield reconstruct` makes contacts"
            ) from error
        index = self.replay.index
        self.name = self.replay.recording.path.name
        self._first_ns = index.first_ns
        self.start_s, self.end_s = 0.0, (index.last_ns - index.first_ns) * 1e-9
        self.events = sorted(
            (self._seconds(event["wall_ns"]), str(event.get("text") or event.get("kind") or ""))
            for event in index.events
        )
        spans = (((a - self._first_ns) * 1e-9, (b - self._first_ns) * 1e-9) for a, b in index.gaps)
        self.gaps = [(a, b) for a, b in spans if b - a > SHORTEST]
        self._changed = threading.Condition()  # and lock of all that follows
        self._slot, self._number, self._wall_ns = CycleSlot.empty(self.replay.sizes), -1, 0
        self._time_ns = self._since = 0  # of the newest cycle; cycles since one was copied
        self._snapshot: Snapshot | None = None
        period = float(self.replay.recording.description.get("period", 1e-3))
        self._timing = TimingTable(max(int(period * 1e9), 1))
        self._marks: deque[tuple[int, Any, Any]] = deque()
        self._clock = Clock(playing)
        self._target: int | None = self._first_ns  # time to go to, ns
        self._closed, self._at_end, self._failed = False, False, ""
        self.loop = False
        self._thread = threading.Thread(target=self._run, name=f"replay-{self.name}", daemon=True)
        self._thread.start()
        self.timeline = Timeline(self.replay.recording.path, index.first_ns, self.end_s)

    def _seconds(self, time_ns: int) -> float:
        """Of a time since the epoch, ns; those outside of the recording are at its ends."""
        return min(max((time_ns - self._first_ns) * 1e-9, 0.0), self.end_s)

    @property
    def skin(self) -> Skin:
        """All its patches."""
        return self.replay.model_config.skin

    @property
    def time_s(self) -> float:
        """Of the cycle that is shown, s since the first one."""
        return self._seconds(self._time_ns)

    @property
    def playing(self) -> bool:
        """Whether time goes on."""
        return self._clock.playing

    @property
    def speed(self) -> float:
        """Times its own pace."""
        return self._clock.speed

    @property
    def sought(self) -> bool:
        """Whether what is shown is what was asked for: no seek is under way."""
        return self._target is None

    def latest(self) -> Snapshot | None:
        """The newest cycle, in memory of its own; None before the first one is there."""
        with self._changed:
            if self._snapshot is None and self._number >= 0:
                own = CycleSlot.empty(self.replay.sizes)
                own.copy_from(self._slot)
                models = self.replay.models(self._wall_ns)
                self._snapshot = Snapshot(own, self._number, models, self._wall_ns)
            return self._snapshot

    def look(self) -> LiveStatus:
        """Of the time that is shown; `state` is "playing", "paused" or "failed"."""
        names = [patch.name for patch in self.skin]
        with self._changed:
            found, timing = self.latest(), self._timing
            since = Timing.of(timing.times, timing.totals)
            now = (self._time_ns, timing.times, timing.totals)
            at, times, totals = self._marks[0] if self._marks else now
            lately = Timing.of(timing.times, timing.totals, (times, totals))
            seconds = max((self._time_ns - at) * 1e-9, 1e-9)
            return LiveStatus(
                name=self.name,
                state="failed" if self._failed else "playing" if self.playing else "paused",
                since=since,
                lately=lately,
                seconds=seconds,
                rate=lately.cycles / seconds,
                patches=[] if found is None else patch_rows(names, found.patches, self._wall_ns),
                contacts=[] if found is None else plain_contacts(names, found.contacts),
                notes=self._notes(),
                relative=self.replay.model_config.relative,
            )

    def status(self) -> dict[str, Any]:
        """The same, as `LiveStatus.as_dict`."""
        return self.look().as_dict()

    def _notes(self) -> dict[str, Any]:
        said: dict[str, Any] = {"replay": f"{self.time_s:.2f} s of {self.end_s:.2f} s"}
        if self.gaps:
            spans = [f"{begin:.2f} s to {end:.2f} s" for begin, end in self.gaps[:MOST_GAPS]]
            more = len(self.gaps) - MOST_GAPS
            spans += [f"{more} more"] if more > 0 else []
            said["replay"] += f"; cycles are missing from {', '.join(spans)}"
        if self._failed:
            said["failed"] = self._failed
        if self._clock.behind:
            said["pace"] = "slower than asked: it is read as fast as it can be here"
        if self.timeline.damage:
            said["timeline"] = f"ends early: {self.timeline.damage}"
        if self.replay.recording.damage:
            said["damage"] = [str(each) for each in self.replay.recording.damage[:3]]
        return said

    def play(self) -> None:
        """Go on; from the beginning, where it stands at the end."""
        with self._changed:
            if self._at_end:
                self._target = self._first_ns
            self._clock.play()
            self._changed.notify_all()

    def pause(self) -> None:
        """Stay at the cycle that is shown."""
        with self._changed:
            self._clock.pause()
            self._changed.notify_all()

    def seek(self, t_s: float) -> None:
        """Go to a time; soon afterwards the first cycle from then on is shown.

        Parameters
        ----------
        t_s : float, s
            Since the first cycle; before it, or after the last one: there.
        """
        if not math.isfinite(t_s):
            raise InputError(f"t_s is {t_s}, expected {self.start_s:g} to {self.end_s:g} s")
        with self._changed:
            self._target = self._first_ns + round(min(max(t_s, 0.0), self.end_s) * 1e9)
            self._changed.notify_all()

    def step(self, count: int) -> None:
        """Pause, and go so many readings on, or back."""
        place = self.timeline.step(self.time_s, count)
        self.pause()
        self.seek(place)

    def set_loop(self, on: bool) -> None:
        """Whether to begin anew at the end."""
        with self._changed:
            self.loop = on

    def set_speed(self, x: float) -> None:
        """Play so many times as fast as it was, 0.1 to 10."""
        check_range("speed", x, *SPEEDS, "times its own pace")
        with self._changed:
            self._clock.set_speed(float(x))
            self._changed.notify_all()

    def close(self) -> None:
        """End the threads."""
        self.timeline.close()
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join(ENDS)

    # in the thread

    def _run(self) -> None:
        try:
            while not self._closed:
                self._play_from_target()
        except SkinfieldError as error:
            self._fail(str(error))
        except Exception as error:
            self._fail(f"{type(error).__name__}: {error}")
            raise

    def _fail(self, why: str) -> None:
        """Stop; nothing can be shown any more."""
        with self._changed:
            self._failed, self._target, self._snapshot = why, None, None
            self._clock.pause()
            say_nothing(self._slot, 0)
            self._slot.counts[:] = np.nan

    def _play_from_target(self) -> None:
        """Show what was from the time that was asked for until another is, or the end."""
        target = self._target
        assert target is not None  # set before the thread starts, and waited for afterwards
        with self._changed:
            self._marks.clear()
        moments = self.replay.from_time(target)
        first = next(moments, None)
        if first is not None:
            with self._changed:
                self._show(first, at_once=True)
                self._arrive(target)
                self._clock.begin(first.cycle.wall_ns)
        for each in moments:
            if not self._wait_until(each.cycle.wall_ns):
                return
            self._show(each)
        self._rest(target)

    def _arrive(self, target: int) -> None:
        if self._target == target:  # no other was asked for meanwhile
            self._target = None

    def _show(self, each: RecordedCycle, at_once: bool = False) -> None:
        """Show a cycle; of those without a new reading only some, as they hold the same.

        Parameters
        ----------
        each : RecordedCycle
        at_once : bool
            Whether exactly this one must be shown.
        """
        with self._changed:
            self._time_ns = each.cycle.wall_ns
            self._since += 1
            if at_once or each.fresh or self._since >= BACK:
                self._since, self._snapshot = 0, None
                self._number, self._wall_ns = each.cycle.number, each.cycle.wall_ns
                self._slot.copy_from(each.slot)
            self._count(each)

    def _count(self, each: RecordedCycle) -> None:
        recorded, latency = each.cycle, -1
        if each.fresh:
            stamp = int(recorded.patches["stamp_ns"].max(initial=0))
            latency = max(recorded.wall_ns + recorded.done_ns - recorded.wake_ns - stamp, 0)
        done, timing, marks = recorded.done_ns, self._timing, self._marks
        timing.add(recorded.due_ns, recorded.wake_ns, recorded.acquired_ns, done, done, latency)
        if not marks or recorded.wall_ns - marks[-1][0] >= MARKS:
            marks.append((recorded.wall_ns, timing.times.copy(), timing.totals.copy()))
            while len(marks) > 2 and marks[1][0] <= recorded.wall_ns - RECENT * 1e9:
                marks.popleft()

    def _wait_until(self, time_ns: int) -> bool:
        """Wait for the time of a cycle; False if another order came meanwhile."""
        with self._changed:
            while not self._closed and self._target is None:
                left = self._clock.left(time_ns)
                if left <= 0.0:
                    return True
                self._changed.wait(None if math.isinf(left) else left)
        return False

    def _rest(self, target: int) -> None:
        """Stay at the end until another time is asked for."""
        with self._changed:
            self._arrive(target)
            if self._target is None and self.loop and self._clock.playing:
                self._target = self._first_ns
            if self._target is None:
                self._clock.pause()
                self._at_end = True
            self._changed.wait_for(lambda: self._closed or self._target is not None)
            self._at_end = False
