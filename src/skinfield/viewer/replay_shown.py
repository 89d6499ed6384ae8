"""The cycle of a recording that is shown, and what is told of it."""

import threading
from collections import deque
from dataclasses import fields
from typing import Any

import numpy as np

from skinfield.acquisition.recorded import Cycle
from skinfield.engine.state import Answer
from skinfield.live.answered import Answered, Passed
from skinfield.live.estimates import Models
from skinfield.live.replay import Replay
from skinfield.live.slots import Head, Sizes, Slot
from skinfield.live.snapshot import Snapshot
from skinfield.live.status import contacts_of
from skinfield.realtime import Timing, TimingTable

BACK = 20  # cycles that a new reading is shown for, at the least: its times are those of an answer
MARKS = 250_000_000  # ns between counts of what was
RECENT = 1.0  # s that the status calls the last
MISSING = int(Answer.MISSING)


class Shown:
    """Keeps a copy of the newest cycle; one thread puts, others look.

    Parameters
    ----------
    replay : Replay

    Attributes
    ----------
    time_ns : int, ns
        Of the newest cycle, since the epoch.
    """

    def __init__(self, replay: Replay) -> None:
        recipe = replay.recipe
        self.time_ns = 0
        self._replay = replay
        self._sizes = Sizes.of(recipe.skin, recipe.rungs, recipe.rows)
        self._lock = threading.Lock()
        self._slot, self._number, self._wall_ns = Slot.empty(self._sizes), 0, 0
        self._since = 0  # cycles since one was copied
        self._snapshot: Snapshot | None = None
        self._models: Models | None = None
        self._different = 0
        period = float(replay.recording.description.get("period", 1e-3))
        self._timing = TimingTable(max(int(period * 1e9), 1))
        self._marks: deque[tuple[int, Any, Any]] = deque()

    def put(self, each: Answered | Passed, at_once: bool = False) -> None:
        """Show a cycle; of those without a new reading only some, as they hold the same.

        Parameters
        ----------
        each : Answered or Passed
        at_once : bool
            Whether exactly this one must be shown.
        """
        answered = isinstance(each, Answered) and each.whole
        fresh = isinstance(each, Answered) and each.fresh
        with self._lock:
            self.time_ns = each.recorded.wall_ns
            self._since += 1
            if at_once or fresh or self._since >= BACK:
                self._since, self._snapshot = 0, None
                self._number, self._wall_ns = each.recorded.number, each.recorded.wall_ns
                if isinstance(each, Answered) and answered:
                    self._copy(each)
                else:
                    self._miss()
                self._stamp(each.recorded)
            if isinstance(each, Answered):
                self._different += not each.same
                self._count(each)

    def _copy(self, each: Answered) -> None:
        for part in fields(Slot):
            np.copyto(getattr(self._slot, part.name), getattr(each.slot, part.name))

    def _miss(self) -> None:
        """All patches are missing."""
        slot = self._slot
        slot.patches[:] = np.zeros(1, slot.patches.dtype)
        slot.patches["answer"], slot.patches["gap"] = MISSING, np.nan
        slot.head[:] = 0
        slot.counts[:], slot.values[:], slot.valid[:] = np.nan, 0.0, 0

    def _stamp(self, recorded: Cycle) -> None:
        """Times of a cycle as they were live."""
        head = self._slot.head
        head[Head.DUE_NS], head[Head.WAKE_NS] = recorded.due_ns, recorded.wake_ns
        head[Head.ACQUIRED_NS], head[Head.READY_NS] = recorded.acquired_ns, recorded.done_ns
        head[Head.WALL_NS], head[Head.FLAGS] = recorded.wall_ns, int(recorded.flags)

    def _count(self, each: Answered) -> None:
        recorded, latency = each.recorded, -1
        if each.fresh:
            stamp = int(recorded.patches["stamp_ns"].max(initial=0))
            latency = max(recorded.wall_ns + recorded.done_ns - recorded.wake_ns - stamp, 0)
        done = recorded.done_ns
        times = recorded.due_ns, recorded.wake_ns, recorded.acquired_ns, done, done
        self._timing.add(*times, latency)
        marks = self._marks
        if not marks or recorded.wall_ns - marks[-1][0] >= MARKS:
            timing = self._timing
            marks.append((recorded.wall_ns, timing.times.copy(), timing.totals.copy()))
            while len(marks) > 2 and marks[1][0] <= recorded.wall_ns - RECENT * 1e9:
                marks.popleft()

    def move(self) -> None:
        """What comes next is of another time."""
        with self._lock:
            self._marks.clear()

    def lose(self) -> None:
        """Nothing can be shown any more."""
        with self._lock:
            self._miss()
            self._snapshot = None

    def snapshot(self) -> Snapshot | None:
        """The cycle that is shown, in memory of its own; None before the first one."""
        return self.now()[0]

    def now(self) -> tuple[Snapshot | None, int]:
        """The same, and what time it is there, ns since the epoch."""
        with self._lock:
            if self._snapshot is None and self._number:
                own = Slot.empty(self._sizes)
                for part in fields(Slot):
                    np.copyto(getattr(own, part.name), getattr(self._slot, part.name))
                self._snapshot = Snapshot(own, self._number, self._models_now(), self._wall_ns)
            return self._snapshot, self.time_ns

    def _models_now(self) -> Models:
        """Of what was in force then."""
        replay, models = self._replay, self._models
        if models is None or models.recipe is not replay.recipe:
            taxels = self._sizes.taxels
            noise = np.zeros(taxels) if replay.tared is None else replay.tared.noise_std
            typical = replay.recipe.quantity.typical_noise
            models = Models(replay.recipe, np.where(noise > 0, noise, typical))
            self._models = models
        return models

    def status(self, name: str, state: str) -> dict[str, Any]:
        """As `Status.as_dict` of a running skin, for the time that is shown."""
        found = self.snapshot()
        with self._lock:
            timing = self._timing
            since = Timing.of(timing.times, timing.totals)
            now = (self.time_ns, timing.times, timing.totals)
            at, *before = self._marks[0] if self._marks else now
            lately = Timing.of(timing.times, timing.totals, (before[0], before[1]))
            seconds = max((self.time_ns - at) * 1e-9, 1e-9)
            different = self._different
        names = [patch.name for patch in self._replay.recipe.skin]
        notes = {"different": f"{different:,} cycles differ from what was live"}
        return {
            "name": name,
            "state": state,
            "pid": 0,
            "generation": 1,
            "seconds": seconds,
            "rate": lately.cycles / seconds,
            "sources": {},
            "sources_lately": {},
            "patches": [] if found is None else _patches(found, names),
            "contacts": [] if found is None else contacts_of(names, found.slot),
            "notes": notes if different else {},
            "beside": {},
            "memory": {},
            "since_start": since.as_dict(),
            "lately": lately.as_dict(),
            "lost": 0,
        }


def _patches(found: Snapshot, names: list[str]) -> list[dict[str, Any]]:
    """Of each patch what a running skin's status tells."""
    rows, ages = [], found.ages()
    for name, row in zip(names, found.patches, strict=True):
        missing = int(row["answer"]) == MISSING
        rows.append(
            {
                "name": name,
                "answer": Answer(int(row["answer"])).name.lower(),
                "age": ages[name] if np.isfinite(ages[name]) else None,
                "stale": missing,
                "force": float(row["force"]),
                "contacts": int(row["contacts"]),
                "invalid": int(row["invalid"]),
                "rung": int(row["rung"]),
                "gap": None if np.isnan(row["gap"]) else float(row["gap"]),
            }
        )
    return rows
