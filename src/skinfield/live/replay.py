"""A recording answered again: the same code, the same bytes, the same decisions."""

import io
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skinfield.acquisition import Blocks, Channels, Kind, blocks_of
from skinfield.acquisition.recorded import TARE, CycleFlag
from skinfield.acquisition.recorded import Cycle as Recorded
from skinfield.contacts.live import CONTACT
from skinfield.errors import FileError, InputError
from skinfield.live.binding import bind
from skinfield.live.cycle import Cycle
from skinfield.live.recipe import Recipe
from skinfield.live.slots import PATCH, Head, Sizes, Slot
from skinfield.live.tare import Tared
from skinfield.sources.recordings.mcap_live import LiveRecording
from skinfield.sources.recordings.mcap_steps import Step, Steps

KEY = int(CycleFlag.KEY)
WORD = 8


@dataclass(frozen=True, eq=False)
class Answered:
    """One cycle, answered again.

    Attributes
    ----------
    recorded : Cycle
        As it was live.
    slot : Slot
        As it is now; overwritten by the next.
    fresh : bool
        Whether it had a new reading.
    same : bool
        Whether contacts and patches are the same, bit for bit.
    """

    recorded: Recorded
    slot: Slot
    fresh: bool
    same: bool


def is_unanswered(cycle: Recorded) -> bool:
    """Whether it is of an engine that was still starting, and told nothing."""
    rows = cycle.patches
    if rows.dtype != PATCH:
        return False
    return not rows["answered_ns"].any() and bool(np.isnan(rows["gap"]).all())


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
        self.tared = self._first_tare()
        self._cycle: Cycle | None = None

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
        before: Recorded | None = None
        going, since_ns = False, 0  # from when on nothing is missing
        blocks = Blocks(1 << 12)
        for step in Steps(self.recording):
            cycle = step.cycle
            gap = before is not None and (step.missing > 0 or cycle.number != before.number + 1)
            again = before is not None and is_unanswered(cycle) and not is_unanswered(before)
            self.gaps += gap
            if before is None or gap or again:
                going, since_ns = False, cycle.wall_ns
            if again:
                self._forget()
            blocks = self._room(blocks, len(step.data))
            self._take(step, blocks)
            if cycle.flags & KEY and self._knows_all(cycle.wall_ns - since_ns):
                going = going or self._begin(before)
            if going and self._cycle is not None:
                yield self._answered(self._cycle, cycle, bool(cycle.flags & KEY))
            else:
                self._pass(cycle)
            before = cycle

    def _knows_all(self, complete_ns: int) -> bool:
        """Whether all that an answer follows from was read since then.

        Readings from before count until they are too old: an engine that was running when the
        recording began, or while something got lost, knew them.
        """
        return self.tared is not None and complete_ns > self.tared.stale_ns

    def _forget(self) -> None:
        """Begin as an engine does that was started again: it knows the calibration alone."""
        self.channels, self._cycle = Channels(self.binding.channels), None

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

    def _take(self, step: Step, blocks: Blocks) -> None:
        """Apply the readings of a step, and a new calibration if it brings one."""
        from skinfield.acquisition.kernel import find_kind

        if not step.data:
            return
        blocks.put_data(step.data)
        self.channels.apply_good(blocks)
        if find_kind(blocks.words, 0, int(blocks.end[0]), int(Kind.CALIBRATION)) < 0:
            return
        rows = np.zeros((len(self.binding.channel), 6))
        for block in blocks_of(blocks.data):
            if block.kind == Kind.CALIBRATION and block.channel + block.count <= len(rows):
                rows[block.channel : block.channel + block.count] = block.payload.reshape(-1, 6)
        self.tared = Tared.from_rows(rows)
        if self._cycle is not None:
            self._cycle.calibrate(self.tared.calibration)

    def _begin(self, before: Recorded | None) -> bool:
        """Start at a key cycle, from the contacts that the cycle before it told."""
        tared = self.tared
        assert tared is not None  # whoever calls has looked
        if self._cycle is None:
            noise, stale = tared.noise_std, tared.stale_ns
            self._cycle = Cycle(self.recipe, self.binding, tared.calibration, noise, stale)
        if before is not None:
            self._check(before)
            if is_unanswered(before):
                self._cycle.tracks[0] = before.patches["tracks"][0]
            else:
                self._cycle.go_on_from(before)
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
        return Answered(recorded, slot, fresh, same)
