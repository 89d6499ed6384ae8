"""Replay of a recording: readings, settings and estimates as they were, cycle by cycle."""

import io
import json
import time
from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from skinfield.errors import FileError, Floats, InputError
from skinfield.files.mcap.live import LiveRecording, NewestField
from skinfield.files.mcap.schema import CYCLES, TARE, Cycle, FieldRecord
from skinfield.loop import Answer
from skinfield.loop.model_config import Configuration, ModelConfig, Models, write_configuration
from skinfield.loop.realtime import TimingTable
from skinfield.loop.ring_fields import describe, slots_for, status_fields
from skinfield.loop.runtime_parameters import Tuning
from skinfield.loop.slots import LAYOUT as CYCLE
from skinfield.loop.slots import CycleHead, CycleSlot, Sizes
from skinfield.loop.status_text import write_notes
from skinfield.ring import Ring, State

SOURCE = "replay"
FIXED = "it is a replay, and goes by what was in force then"
LINEAR, MISSING = int(Answer.LINEAR), int(Answer.MISSING)


class RecordedCycle(NamedTuple):
    """One cycle.

    Attributes
    ----------
    cycle : Cycle
        As it was recorded.
    slot : CycleSlot
        As readers of the ring had it, but for readings and pressure: those of the newest cycle so
        far of which they are in the file, and a touched patch's rung is that of its pressure. The
        next cycle overwrites it.
    fresh : bool
        Whether it had a new reading.
    """

    cycle: Cycle
    slot: CycleSlot
    fresh: bool


class ConfigChange(NamedTuple):
    """What the engine went by from a time on.

    Attributes
    ----------
    time_ns : int, ns
        Since the epoch.
    configuration : Configuration
    """

    time_ns: int
    configuration: Configuration


class BaselineRecord(NamedTuple):
    """A calibration from a time on, ns since the epoch: (L, 4), and noise (L,)."""

    time_ns: int
    calibration: Floats
    noise_std: Floats


class Replay:
    """The cycles of a recording as they were; for one thread at a time.

    Parameters
    ----------
    path : path
        Of an MCAP file of a live skin.

    Attributes
    ----------
    recording : LiveRecording
    index : Index
        When its cycles were.
    model_config : ModelConfig
        What its estimates followed from at the beginning.
    sizes : Sizes
        Of its slots.
    settings : list of ConfigChange
        Changes in time; what was in force at the beginning comes first.

    Raises
    ------
    FileError
        If the file cannot be read, is of another version, or has no cycle.
    """

    def __init__(self, path: str | Path) -> None:
        self.recording = found = LiveRecording.open(path)
        if not found.configuration:
            raise FileError(
                f"{path} encloses no configuration, expected one: nobody can tell of which skin "
                "its estimates are; `skinfield export` still gives its readings"
            )
        self.model_config = ModelConfig.from_json(json.dumps(found.configuration))
        if found.cycle_layout.completed() != CYCLE:
            raise FileError(
                f"{path}: the rows of contacts and patches are of another version, expected those "
                "of this one; `skinfield reconstruct` makes its estimates anew"
            )
        self.index = found.index
        if not self.index.cycles:
            raise FileError(
                f"{path} has no cycle, expected one or more: it is too short or too damaged; "
                "`skinfield export` still gives its readings"
            )
        self.sizes = Sizes.of(
            self.model_config.skin, self.model_config.rungs, self.model_config.rows
        )
        self.settings = list(_config_history(found, self.model_config))
        self._tares = list(_tares(found, self.sizes.taxels))
        self._fields = NewestField(found, self._is_sound)
        self._slot = CycleSlot.empty(self.sizes)
        self._field: FieldRecord | None = None
        self._models: tuple[tuple[int, int], Models] | None = None
        self._show_field(None)

    def __iter__(self) -> Iterator[RecordedCycle]:
        return self.from_time(0)

    def from_time(self, time_ns: int) -> Iterator[RecordedCycle]:
        """Cycles from a time on, ns since the epoch; another iteration must not go on after it."""
        first = self.index.record_before(time_ns)
        for _, at, recorded in self.recording.contents((CYCLES,), first):
            cycle = CYCLE.extend(recorded)
            if cycle.wall_ns < time_ns or not self._fits(at, cycle):
                continue
            self._show_field(self._fields.before(cycle.wall_ns))
            self._show(cycle)
            yield RecordedCycle(cycle, self._slot, bool(self._slot.head[CycleHead.FRESH]))

    def config_at(self, time_ns: int) -> ConfigChange:
        """What the engine went by at a time, ns since the epoch."""
        return self.settings[_newest(self.settings, time_ns)]

    def tare(self, time_ns: int) -> BaselineRecord | None:
        """The calibration at a time, ns since the epoch; None where none was taken."""
        return self._tares[_newest(self._tares, time_ns)] if self._tares else None

    def models(self, time_ns: int) -> Models:
        """What turns pressure into deformation and uncertainty, of a time, ns since the epoch."""
        key = _newest(self.settings, time_ns), _newest(self._tares, time_ns)
        if self._models is None or self._models[0] != key:
            model_config = replace(
                self.model_config, solver=self.settings[key[0]].configuration.solver
            )
            tare = self.tare(time_ns)
            noise = np.zeros(self.sizes.taxels) if tare is None else tare.noise_std
            self._models = key, Models(model_config, noise)
        return self._models[1]

    def _fits(self, at: int, cycle: Cycle) -> bool:
        """Whether a cycle has the rows of such a skin; else it is noted as damage."""
        rows, contacts = cycle.patches, cycle.contacts
        counts, places = rows["contacts"], np.arange(self.sizes.patches)
        limits = (("contacts", self.sizes.rows), ("rung", max(self.model_config.rungs)))
        if len(rows) == len(places) and all(
            ((rows[name] >= 0) & (rows[name] <= most)).all()
            for name, most in (*limits, ("answer", max(Answer)))
        ):
            its = np.repeat(places, counts)
            if len(its) == len(contacts) and (contacts["patch"] == its).all():
                return True
        self.recording.note(
            at, f"cycle {cycle.number} has {len(rows)} patches and {len(contacts)} "
            "contacts, expected those of the skin that is enclosed",
        )  # fmt: skip
        return False

    def _is_sound(self, at: int, found: FieldRecord) -> bool:
        """Whether a field is of such a skin; else it is noted as damage."""
        sizes, its = self.sizes, (len(found.sides), len(found.counts), found.grid)
        if its == (sizes.patches, sizes.taxels, sizes.nodes):
            return True
        self.recording.note(
            at, f"a field of {its[0]} patches, {its[1]} taxels and {its[2]} nodes, expected "
            f"{sizes.patches}, {sizes.taxels} and {sizes.nodes}",
        )  # fmt: skip
        return False

    def _show_field(self, found: FieldRecord | None) -> None:
        """Put readings and pressure into the slot; without any, nothing is known of them."""
        if found is self._field and found is not None:
            return
        self._field, slot = found, self._slot
        if found is None:
            slot.counts[:], slot.values[:], slot.valid[:], slot.pressure[:] = np.nan, 0.0, 0, 0.0
            return
        slot.counts[:], slot.values[:], slot.valid[:] = found.counts, found.values, found.valid
        found.pressure_into(slot.pressure)

    def _show(self, cycle: Cycle) -> None:
        """Put contacts, patches and times into the slot."""
        slot, head, patches = self._slot, self._slot.head, cycle.patches
        slot.patches[:] = patches
        used = np.arange(self.sizes.rows) < patches["contacts"][:, None]
        slot.contacts[used] = cycle.contacts
        if self._field is not None:
            touched = (patches["answer"] >= LINEAR) & (self._field.sides > 0)
            slot.patches["rung"][touched] = self._field.sides[touched]
        head[: CycleHead.MESSAGES] = (
            *(int(cycle.flags), cycle.due_ns, cycle.wake_ns, cycle.acquired_ns, cycle.done_ns),
            *(cycle.wall_ns, cycle.log_position),
        )
        head[CycleHead.FRESH] = np.count_nonzero(patches["fresh"] > 0)
        head[CycleHead.CONTACTS] = len(cycle.contacts)
        head[CycleHead.GENERATION] = self.config_at(cycle.wall_ns).configuration.generation


def _newest(found: list[Any], time_ns: int) -> int:
    """Place of the newest of some up to a time; before all of them, of the first."""
    return max(bisect_right([each.time_ns for each in found], time_ns) - 1, 0)


def _config_history(recording: LiveRecording, model_config: ModelConfig) -> Iterator[ConfigChange]:
    """Settings by time, from the events that tell of them; what makes no sense is noted."""
    tuning = Tuning(deadline=model_config.budget)
    yield ConfigChange(0, Configuration(1, model_config.solver, tuning))
    for event in recording.index.events:
        if event.get("kind") == "settings":
            try:
                yield ConfigChange(event["wall_ns"], Configuration.from_dict(event))
            except InputError as error:
                recording.note(0, f"settings that make no sense are left out: {error!s:.200}")


def _tares(recording: LiveRecording, taxels: int) -> Iterator[BaselineRecord]:
    """Calibrations by time; what makes no sense is noted."""
    start, end = TARE.split("{number}")
    found = {
        int(number): each
        for name, each in recording.attached.items()
        if name.startswith(start)
        and name.endswith(end)
        and (number := name.removeprefix(start).removesuffix(end)).isdecimal()
    }
    known = False
    for _, each in sorted(found.items()):
        try:
            with np.load(io.BytesIO(each.data), allow_pickle=False) as file:
                table, noise = file["calibration"], file["noise_std"]
            if table.shape != (taxels, 4) or noise.shape != (taxels,):
                raise InputError(f"it is of {len(noise)} taxels, expected {taxels}")
            time_ns = each.log_time if known else 0  # the first holds from the beginning on
            known = True
            yield BaselineRecord(time_ns, table.astype(np.float64), noise.astype(np.float64))
        except (OSError, ValueError, KeyError, EOFError, TypeError) as error:
            recording.note(0, f"{each.name} cannot be used, and is left out: {error}")


def paced(moments: Iterable[RecordedCycle], speed: float) -> Iterator[RecordedCycle]:
    """Cycles at `speed` times the pace at which they were live; a slow reader is waited for."""
    began, first = time.monotonic(), None
    for each in moments:
        first = each.cycle.wall_ns if first is None else first
        due = began + (each.cycle.wall_ns - first) * 1e-9 / speed
        left = due - time.monotonic()
        if left > 0:
            time.sleep(left)
        yield each


class Published:
    """A replay in a ring, as a running skin that others can look at.

    Stamps are moved to now, so that ages mean what they mean live.

    Parameters
    ----------
    name : str
        Of the ring.
    replay : Replay
    """

    def __init__(self, name: str, replay: Replay) -> None:
        model_config, slot = replay.model_config, replay.sizes.fields()
        period = float(replay.recording.description.get("period", 1e-3))
        told = describe(name, model_config, [SOURCE], period) | {"fixed": FIXED}
        self._replay = replay
        status = status_fields(1, replay.sizes.taxels)
        self._ring = Ring.create(name, slot, status, told, slots_for(slot), 1 << 16)
        status_arrays = self._ring.status
        period_ns = max(int(period * 1e9), 1)
        self._timing = TimingTable(period_ns, None, status_arrays["times"], status_arrays["totals"])
        self._tare: BaselineRecord | None = None
        self._config: ConfigChange | None = None
        self._go_by(replay.index.first_ns)
        self._ring.set_state(State.RUNNING)
        write_notes(status_arrays["notes"], {"phase": f"replay of {replay.recording.path.name}"})

    def _go_by(self, time_ns: int) -> None:
        """Tell settings and calibration of a time."""
        status, tare = self._ring.status, self._replay.tare(time_ns)
        known = self._replay.config_at(time_ns)
        if known is not self._config:
            self._config = known
            write_configuration(status["configuration"], known.configuration)
        if tare is not None and tare is not self._tare:
            self._tare = tare
            status["calibration"][:], status["noise_std"][:] = tare.calibration, tare.noise_std
            status["tares"][0] += 1

    def put(self, each: RecordedCycle) -> None:
        """Publish one cycle."""
        ring, cycle = self._ring, each.cycle
        self._go_by(cycle.wall_ns)
        slot = CycleSlot.of(ring.begin())
        slot.copy_from(each.slot)
        now = time.time_ns()
        shift = now - cycle.wall_ns
        for name in ("stamp_ns", "answered_ns"):
            known = slot.patches[name] > 0
            slot.patches[name][known] += shift
        slot.head[CycleHead.WALL_NS] = now
        slot.patches["stamp_ns"][slot.patches["answer"] == MISSING] = 0
        ring.publish()
        ring.heartbeat(time.monotonic_ns())
        times = (cycle.due_ns, cycle.wake_ns, cycle.acquired_ns, cycle.done_ns)
        self._timing.add(*times, cycle.done_ns, -1)

    def close(self) -> None:
        """Take the ring away."""
        name = self._ring.name
        self._ring.close()
        Ring.remove(name)
