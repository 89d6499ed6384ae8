"""A recording, as the page sees it: answered again, at any pace and from any time on."""

import math
import threading
import time
from pathlib import Path
from typing import Any

from skinfield.errors import FileError, InputError, SkinfieldError, check_range
from skinfield.layout import Skin
from skinfield.live.answered import Answered, Passed
from skinfield.live.recipe import Recipe
from skinfield.live.replay import Replay
from skinfield.live.replay_fit import ReplayFit
from skinfield.live.snapshot import Snapshot
from skinfield.viewer.replay_clock import SPEEDS, Clock
from skinfield.viewer.replay_shown import Shown
from skinfield.viewer.replay_times import Times, told_events
from skinfield.viewer.seen_best import seen_best
from skinfield.viewer.updates import Seen

ENDS = 10.0  # s for the thread to end
LISTENED = 64  # cycles that are answered between looks for another order, without pacing
PATIENCE = 0.3  # s that a time is looked for though another is wanted already


class ReplayFeed:
    """A recording of a live skin as a `Feed`; it begins to play where it can be answered first.

    A thread answers the cycles again, the same as they were live, bit for bit; what is shown is
    the newest one. Where readings are missing nothing can be answered, and all patches are missing.
    Contacts that a fit found beside the engine are as they were recorded.

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
    holes : list of (float, float)
        Spans, s, that cannot be answered again.

    Raises
    ------
    FileError
        If it is no recording of a live skin, or does not say what its estimates followed from.
    """

    def __init__(self, path: str | Path, *, playing: bool = True) -> None:
        self.replay = opened(Path(path))
        self.name = self.replay.recording.path.name
        self._times = Times.of(self.replay)
        self.start_s, self.end_s = 0.0, self._times.end_s
        self.events = told_events(self.replay, self._times)
        self.holes = self._times.holes
        self._shown = Shown(self.replay)
        self._fit, self._fit_lock = ReplayFit(self.replay), threading.Lock()
        self._changed = threading.Condition()
        self._clock = Clock(playing)
        self._target: int | None = None  # time to go to, ns
        self._closed, self._at_end, self._failed = False, False, ""
        self.seek(self._times.begin_s)
        self._thread = threading.Thread(target=self._run, name=f"replay-{self.name}", daemon=True)
        self._thread.start()

    @property
    def skin(self) -> Skin:
        """All its patches."""
        return self.replay.recipe.skin

    @property
    def recipe(self) -> Recipe:
        """What its answers follow from."""
        return self.replay.recipe

    @property
    def time_s(self) -> float:
        """Of the cycle that is shown, s since the first one."""
        return self._times.seconds(self._shown.time_ns)

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
        return self._shown.snapshot()

    def seen(self) -> Seen:
        """The same with the best contacts that were known at that time, as the live page has it."""
        snapshot, time_ns = self._shown.now()
        with self._fit_lock:
            found = None if snapshot is None else self._fit.at(time_ns)
        return seen_best(snapshot, found)

    def status(self) -> dict[str, Any]:
        """As `Status.as_dict`, of the time that is shown; `state` is "playing" or "paused"."""
        state = "playing" if self.playing else "paused"
        told = self._shown.status(self.name, "failed" if self._failed else state)
        told["notes"] |= self._notes()
        return told

    def _notes(self) -> dict[str, Any]:
        said = {"replay": self._times.line(self.time_s)}
        damage = [str(each) for each in self.replay.recording.damage[:3]]
        if self._failed:
            said["failed"] = self._failed
        if self._clock.behind:
            said["pace"] = "slower than asked: it is answered as fast as it can be here"
        return said | ({"damage": damage} if damage else {})

    def play(self) -> None:
        """Go on; from the beginning, where it stands at the end."""
        with self._changed:
            if self._at_end:
                self._target = self._times.nanoseconds(self._times.begin_s)
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
            self._target = self._times.nanoseconds(t_s)
            self._changed.notify_all()

    def set_speed(self, x: float) -> None:
        """Play so many times as fast as it was, 0.1 to 10."""
        check_range("speed", x, *SPEEDS, "times its own pace")
        with self._changed:
            self._clock.set_speed(float(x))
            self._changed.notify_all()

    def close(self) -> None:
        """End the thread."""
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
        with self._changed:
            self._failed, self._target = why, None
            self._clock.pause()
        self._shown.lose()

    def _play_from_target(self) -> None:
        """Answer from the time that was asked for until another is, or the end."""
        target, each = self._target, None
        assert target is not None  # set before the thread starts, and waited for afterwards
        self._shown.move()
        cycles, began = self.replay.from_time(target), time.monotonic()
        for count, each in enumerate(cycles):
            if each.recorded.wall_ns >= target:
                break
            if count % LISTENED == 0 and self._another(target, time.monotonic() - began):
                return
        if each is not None:
            self._arrive(target, each)
        for each in cycles:
            if not self._wait_until(each.recorded.wall_ns):
                return
            self._shown.put(each)
        self._rest(target)

    def _another(self, target: int, seconds: float) -> bool:
        """Whether to leave a search: whoever draws the time bar along sees something meanwhile."""
        return self._closed or (self._target != target and seconds > PATIENCE)

    def _arrive(self, target: int, each: Answered | Passed) -> None:
        self._shown.put(each, at_once=True)
        with self._changed:
            if self._target == target:
                self._target = None
            self._clock.begin(each.recorded.wall_ns)

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
            if self._target == target:
                self._target = None
            if self._target is None:
                self._clock.pause()
                self._at_end = True
            self._changed.wait_for(lambda: self._closed or self._target is not None)
            self._at_end = False


def opened(path: Path) -> Replay:
    """The replay of a file.

    Raises
    ------
    FileError
        If there is nothing to be answered again; it says what else can be done with the file.
    """
    if not _is_other(path):
        return Replay(path)
    raise FileError(
        f"{path} is a recording of counts alone, expected one of a live skin, as `skinfield "
        "record` writes it: `skinfield reconstruct` makes contacts and fields of this one"
    )


def _is_other(path: Path) -> bool:
    """Whether it is a recording of another kind, of those that can be read."""
    from skinfield.sources.recordings import stream_recording
    from skinfield.sources.recordings.mcap_records import MAGIC

    try:
        with path.open("rb") as file:
            if file.read(len(MAGIC)) == MAGIC:
                return False
    except IsADirectoryError:
        pass
    except (OSError, ValueError):
        return False
    try:
        stream_recording(path)
    except SkinfieldError:
        return False
    return True
