"""A recording answered again: the same code, the same bytes, the same decisions."""

import io
import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np

from skinfield.acquisition import Blocks, Channels, Kind, blocks_of
from skinfield.acquisition.block import Octets
from skinfield.acquisition.recorded import TARE, CycleFlag
from skinfield.acquisition.recorded import Cycle as Recorded
from skinfield.contacts.live import CONTACT
from skinfield.engine.state import Answer
from skinfield.errors import FileError, InputError
from skinfield.live.answered import Answered as Answered
from skinfield.live.answered import Passed as Passed
from skinfield.live.answered import is_unanswered
from skinfield.live.binding import bind
from skinfield.live.configuration import Configuration, same
from skinfield.live.cycle import Cycle
from skinfield.live.in_force import InForce, beginning
from skinfield.live.recipe import Recipe
from skinfield.live.slots import PATCH, Head, Sizes, Slot
from skinfield.live.tare import Tared
from skinfield.live.tuning import Tuning
from skinfield.sources.recordings.mcap_live import LiveRecording
from skinfield.sources.recordings.mcap_moments import LASTING, Moments
from skinfield.sources.recordings.mcap_steps import Step, Steps

KEY = int(CycleFlag.KEY)
IDLE = int(Answer.IDLE)
SLACK_NS = 100_000_000  # by which a replay begins earlier than it must


class Replay:
    """The cycles of a recording, answered again.

    Parameters
    ----------
    path : path
        Of an MCAP file of a live skin.

    Attributes
    ----------
    recording : LiveRecording
    recipe : Recipe
    tared : Tared or None
        The calibration in force.
    passed : int
        Cycles that could not be answered: until all that an answer follows from is in the file
        and a key cycle comes, at the beginning and after a gap, and while the engine was starting.
    gaps : int
        Places where readings or cycles are missing.

    Raises
    ------
    FileError
        If the file cannot be read, or does not say what its estimates followed from.
    """

    def __init__(self, path: str | Path) -> None:
        self.recording = LiveRecording.open(path)
        if not self.recording.configuration:
            raise FileError(
                f"{path} encloses no configuration, expected one: it cannot be answered again; "
                "`skinfield export` still gives its readings"
            )
        self.recipe = Recipe.from_json(json.dumps(self.recording.configuration))
        self.binding = bind(self.recipe.skin, self.recipe.ports)
        self.channels = Channels(self.binding.channels)
        self.slot = Slot.empty(Sizes.of(self.recipe.skin, self.recipe.rungs, self.recipe.rows))
        self.passed = self.gaps = 0
        self._first = self.tared = self._first_tare()
        self._cycle: Cycle | None = None
        self._in_force = InForce(self.recipe, len(self.binding.channel))
        self._began_ns, self._whole = 0, False

    @property
    def tuning(self) -> Tuning:
        """What was in force in the cycle that was answered last."""
        return self._in_force.tuning

    @property
    def configuration(self) -> Configuration:
        """Likewise, of the engine."""
        return self._in_force.configuration

    @cached_property
    def moments(self) -> Moments:
        """When its cycles were; found by one pass over the file."""
        return Moments.of(self.recording)

    def _first_tare(self) -> Tared | None:
        """The calibration that was in force when the recording began, if there was one."""
        start, end = TARE.split("{number}")
        numbers = {
            int(name[len(start) : -len(end)]): name
            for name in self.recording.attached
            if name.startswith(start)
            and name.endswith(end)
            and name[len(start) : -len(end)].isdigit()
        }
        if not numbers:
            return None
        attached = self.recording.attached[numbers[min(numbers)]]
        taxels = len(self.binding.channel)
        try:
            with np.load(io.BytesIO(attached.data), allow_pickle=False) as file:
                table, noise = file["calibration"], file["noise_std"]
                stale_ns = int(file["stale_ns"].reshape(-1)[0])
        except (OSError, ValueError, KeyError, EOFError) as error:
            raise FileError(
                f"{self.recording.path}: {attached.name} cannot be used: {error}"
            ) from error
        if table.shape != (taxels, 4) or noise.shape != (taxels,):
            raise FileError(
                f"{self.recording.path}: {attached.name} is of {len(noise)} taxels, expected "
                f"{taxels} as the layout has"
            )
        return Tared(table.astype(np.float64), noise.astype(np.float64), stale_ns)

    def __iter__(self) -> Iterator[Answered]:
        return (each for each in self.walk() if isinstance(each, Answered))

    def from_time(self, time_ns: int) -> Iterator[Answered | Passed]:
        """Cycles from shortly before a time on, so that what was then is answered in full.

        It begins at a key cycle that lies far enough back for every patch to have a new reading
        or none that counts; the cycles until then are among those that come. Another iteration of
        this replay must not go on after this.

        Parameters
        ----------
        time_ns : int, ns
            Since the epoch.
        """
        stale = 0 if self._first is None else self._first.stale_ns
        key = self.moments.key_before(time_ns - stale)
        if key is None:
            return self.walk()
        return self.walk(self.moments.record_before(key - stale - SLACK_NS))

    def walk(self, record: int = 0) -> Iterator[Answered | Passed]:
        """All cycles from a record of the file on, as if the file began there."""
        self._forget()
        self._recall(record)
        before: Recorded | None = None
        going, since_ns = False, 0  # from when on nothing is missing
        blocks = Blocks(1 << 12)
        for step in Steps(self.recording, first=record):
            cycle = step.cycle
            gap = before is not None and (step.missing > 0 or cycle.number != before.number + 1)
            again = before is not None and is_unanswered(cycle) and not is_unanswered(before)
            self.gaps += gap
            if before is None or gap or again:
                going, since_ns = False, cycle.wall_ns
            if again:
                self._forget()
            blocks = self._room(blocks, len(step.data))
            if self._take(step, blocks) and not step.missing:
                going, since_ns = False, 0
            if cycle.flags & KEY and self._knows_all(cycle.wall_ns - since_ns):
                going = going or self._begin(before)
                self._began_ns = self._began_ns or cycle.wall_ns
            if going and self._cycle is not None:
                yield self._answered(self._cycle, cycle, bool(cycle.flags & KEY))
            else:
                self._pass(cycle)
                yield Passed(cycle)
            before = cycle

    def _knows_all(self, complete_ns: int) -> bool:
        """Whether all that an answer follows from was read since then.

        Readings from before count until they are too old: an engine that was running when the
        recording began, or while something got lost, knew them.
        """
        return self.tared is not None and complete_ns > self.tared.stale_ns

    def _forget(self) -> None:
        """Begin as an engine does that was started again: it knows the calibration alone."""
        self.channels = Channels(self.binding.channels)
        self._in_force = InForce(self.recipe, len(self.binding.channel))
        if self._cycle is not None:
            self._cycle.forget()

    def _recall(self, record: int) -> None:
        """Know what was in force before a record of the file, as if the log began with it."""
        self.tared = self._first
        if self._cycle is not None and self.tared is not None:
            self._cycle.calibrate(self.tared.calibration)
        if record > 0:
            self._know(self.moments.lasting_before(record))

    def _pass(self, cycle: Recorded) -> None:
        """Leave a cycle out; what the engine answered in it is not new any more."""
        self.passed += 1
        if cycle.patches.dtype != PATCH or len(cycle.patches) != len(self.recipe.skin):
            return
        starts, channel = self.binding.starts, self.binding.channel
        for patch in np.flatnonzero(cycle.patches["fresh"] > 0):
            self.channels.fresh[channel[starts[patch] : starts[patch + 1]]] = 0

    def _room(self, blocks: Blocks, size: int) -> Blocks:
        """A buffer that holds so many bytes."""
        if size <= blocks.octets.size:
            blocks.clear()
            return blocks
        return Blocks(2 * size)

    def _take(self, step: Step, blocks: Blocks) -> bool:
        """Apply the readings of a step, and what it says about the engine.

        Whether an engine's process began there, which knows no reading from before.
        """
        from skinfield.acquisition.kernel import find_among

        if not step.data:
            return False
        blocks.put_data(step.data)
        at = find_among(blocks.words, 0, int(blocks.end[0]), *LASTING)
        start = beginning(blocks, at) if at >= 0 else -1
        if start >= 0:
            self._forget()
        self.channels.apply_good(blocks, max(start, 0))
        if at >= 0:
            self._know(blocks.data)
        return start >= 0

    def _know(self, data: bytes | Octets) -> None:
        """Take over what blocks say that lasts: a new calibration."""
        rows = np.zeros((len(self.binding.channel), 6)) if self.tared is None else self.tared.rows()
        taken = False
        for block in blocks_of(data):
            if block.kind == Kind.CALIBRATION and block.channel + block.count <= len(rows):
                rows[block.channel : block.channel + block.count] = block.payload.reshape(-1, 6)
                taken = True
        if taken:
            self.tared = Tared.from_rows(rows)
            if self._cycle is not None:
                self._cycle.calibrate(self.tared.calibration)
        self._in_force.take(data, self._cycle)
        known = self._in_force.configuration
        if not same(known.solver, self.recipe.solver):
            self.recipe, self._cycle = replace(self.recipe, solver=known.solver), None

    def _begin(self, before: Recorded | None) -> bool:
        """Start at a key cycle, from the contacts that the cycle before it told."""
        tared = self.tared
        assert tared is not None  # whoever calls has looked
        if self._cycle is None or self._cycle.stale_ns != tared.stale_ns:
            noise, stale = tared.noise_std, tared.stale_ns
            self._cycle = Cycle(self.recipe, self.binding, tared.calibration, noise, stale)
        if before is not None:
            self._check(before)
            if is_unanswered(before):
                self._cycle.tracks[0] = before.patches["tracks"][0]
            else:
                self._cycle.go_on_from(before)
        self._in_force.apply(self._cycle)
        self._began_ns, self._whole = 0, False
        return True

    def _check(self, told: Recorded) -> None:
        """Raise FileError unless rows of patches and contacts are those of such a skin."""
        known = told.patches.dtype == PATCH and told.contacts.dtype == CONTACT
        counts = told.patches["contacts"] if known else np.zeros(0, np.int64)
        within = ((counts >= 0) & (counts <= self.recipe.rows)).all()
        right = len(counts) == len(self.recipe.skin) and counts.sum() == len(told.contacts)
        if not (known and within and right):
            raise FileError(
                f"{self.recording.path}: cycle {told.number} has {len(told.patches)} patches and "
                f"{len(told.contacts)} contacts, expected those of the skin that is enclosed: it "
                "is damaged, or of another version"
            )

    def _answered(self, cycle: Cycle, recorded: Recorded, key: bool) -> Answered:
        script = recorded.script if len(recorded.script) else None
        fresh = cycle.answer(self.channels, recorded.wall_ns, self.slot, key=key, script=script)
        if fresh and script is None:
            raise InputError(
                f"cycle {recorded.number} has new readings and no script, expected one: the "
                "recording is damaged"
            )
        slot = self.slot
        same = (
            slot.used_contacts().tobytes() == recorded.contacts.tobytes()
            and slot.patches.tobytes() == recorded.patches.tobytes()
            and len(recorded.script) == int(slot.head[Head.SCRIPT])
        )
        if not self._whole:
            rows = slot.patches
            known = (rows["answer"] <= IDLE) | (rows["answered_ns"] >= self._began_ns)
            self._whole = bool(known.all())
        return Answered(recorded, slot, fresh, same, self._whole)
