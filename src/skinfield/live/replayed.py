"""A replay at the pace of its recording, and as a running skin that others can look at."""

import time
from collections.abc import Iterable, Iterator
from dataclasses import fields

import numpy as np

from skinfield.engine.state import Answer
from skinfield.live.configuration import write_configuration
from skinfield.live.notes import write_notes
from skinfield.live.replay import Answered, Replay
from skinfield.live.ring_fields import describe, slots_for, status_fields
from skinfield.live.slots import Head, Sizes, Slot
from skinfield.live.tuning import Tuning
from skinfield.realtime import TimingTable
from skinfield.ring import Ring, State

SOURCE = "replay"
FIXED = "it is a replay, and goes by what was in force then"


def paced(cycles: Iterable[Answered], speed: float) -> Iterator[Answered]:
    """Cycles at `speed` times the pace at which they were live; a slow reader is waited for."""
    began, first = time.monotonic(), None
    for each in cycles:
        first = each.recorded.wall_ns if first is None else first
        due = began + (each.recorded.wall_ns - first) * 1e-9 / speed
        left = due - time.monotonic()
        if left > 0:
            time.sleep(left)
        yield each


class Published:
    """Puts a replay into a ring.

    Stamps are moved to now, so that ages mean what they mean live.

    Parameters
    ----------
    name : str
        Of the ring.
    replay : Replay
    """

    def __init__(self, name: str, replay: Replay) -> None:
        recipe = replay.recipe
        sizes = Sizes.of(recipe.skin, recipe.rungs, recipe.rows)
        slot = sizes.fields()
        period = float(replay.recording.description.get("period", 1e-3))
        told = describe(name, recipe, [SOURCE], period) | {"fixed": FIXED}
        self._replay = replay
        status = status_fields(1, sizes.taxels)
        self._ring = Ring.create(name, slot, status, told, slots_for(slot), 1 << 16)
        status_arrays = self._ring.status
        period_ns = max(int(period * 1e9), 1)
        self._timing = TimingTable(period_ns, None, status_arrays["times"], status_arrays["totals"])
        self._told, self._goes_by = Tuning(deadline=recipe.budget), replay.configuration
        status_arrays["tuning"][:] = self._told.numbers(self._ring.description["patches"])
        write_configuration(status_arrays["configuration"], self._goes_by)
        self._ring.set_state(State.RUNNING)
        write_notes(status_arrays["notes"], {"phase": f"replay of {replay.recording.path.name}"})

    def put(self, each: Answered) -> None:
        """Publish one cycle."""
        ring, recorded = self._ring, each.recorded
        tared = self._replay.tared
        if tared is not None and not ring.status["tares"][0]:
            ring.status["calibration"][:] = tared.calibration
            ring.status["noise_std"][:] = tared.noise_std
            ring.status["tares"][0] = 1
        if self._replay.tuning is not self._told:
            self._told = self._replay.tuning
            ring.status["tuning"][:] = self._told.numbers(ring.description["patches"])
        if self._replay.configuration is not self._goes_by:
            self._goes_by = self._replay.configuration
            write_configuration(ring.status["configuration"], self._goes_by)
        slot = Slot.of(ring.begin())
        for part in fields(Slot):
            np.copyto(getattr(slot, part.name), getattr(each.slot, part.name))
        now = time.time_ns()
        shift = now - recorded.wall_ns
        for name in ("stamp_ns", "answered_ns"):
            known = slot.patches[name] > 0
            slot.patches[name][known] += shift
        for place, value in (
            (Head.DUE_NS, recorded.due_ns),
            (Head.WAKE_NS, recorded.wake_ns),
            (Head.ACQUIRED_NS, recorded.acquired_ns),
            (Head.READY_NS, recorded.done_ns),
            (Head.WALL_NS, now),
        ):
            slot.head[place] = value
        slot.head[Head.FLAGS] = int(recorded.flags)
        slot.head[Head.GENERATION] = self._goes_by.generation
        missing = slot.patches["answer"] == int(Answer.MISSING)
        slot.patches["stamp_ns"][missing] = 0
        ring.publish()
        ring.heartbeat(time.monotonic_ns())
        times = (recorded.due_ns, recorded.wake_ns, recorded.acquired_ns, recorded.done_ns)
        self._timing.add(*times, recorded.done_ns, -1)

    def close(self) -> None:
        """Take the ring away."""
        name = self._ring.name
        self._ring.close()
        Ring.remove(name)
