"""A recording of a small live skin, made without processes: every cycle of it is known."""

import io
import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from live_skins import GAIN, REST, cycle_of, pressed_counts, settings
from mcap.records import Channel
from numpy.lib.recfunctions import repack_fields

from skinfield.files.mcap import RecordingWriter
from skinfield.files.mcap.schema import CYCLES, FIELDS, Cycle, CycleLayout, Enclosed, FieldRecord
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.slots import LAYOUT as ROWS
from skinfield.loop.slots import CycleHead, CycleSlot
from skinfield.signal import Blocks, Channels, Kind

START = 1_700_000_000_000_000_000
PERIOD = 10_000_000  # ns
STALE = 100_000_000  # ns
NOISE = 0.004
FIT = 9  # channel


@dataclass(frozen=True)
class Known:
    """A cycle as it was made."""

    number: int
    wall_ns: int
    force: float
    patches: bytes
    contacts: bytes
    pressure: bytes
    values: bytes


def level(number: int) -> float:
    """How hard it is pressed: up and down, once in 0.75 s."""
    return abs(float(np.sin(number / 75 * np.pi)))


def tare_file(table: np.ndarray, number: int = 1) -> Enclosed:
    buffer = io.BytesIO()
    noise = np.full(len(table), NOISE)
    np.savez(buffer, calibration=table, noise_std=noise, stale_ns=np.array([STALE]), tares=[1])
    return Enclosed(f"tare-{number}.npz", "application/octet-stream", buffer.getvalue())


def rows_of(cycle: Cycle, layout: CycleLayout) -> Cycle:
    """The cycle with rows of fewer fields."""
    contacts, patches = (
        repack_fields(rows[list(kind.names)])
        for rows, kind in ((cycle.contacts, layout.contact), (cycle.patches, layout.patch))
    )
    return replace(cycle, contacts=contacts, patches=patches)


def write(
    path: Path,
    cycles: int,
    *,
    first: int = 0,
    without: range = range(0),
    tared_at: int = -1,
    every: int = 1,
    beside: Callable[[RecordingWriter, CycleSlot, int], None] | None = None,
    layout: CycleLayout = ROWS,
) -> list[Known]:
    """Write `cycles` cycles of a press that comes and goes.

    Parameters
    ----------
    first : int
        What comes before this cycle is not in the file.
    without : range
        Nor are these cycles and their readings.
    tared_at : int
        Cycle before which another baseline is taken.
    every : int
        Cycles from field to field.
    beside : function of writer, slot and number, optional
        Called after each cycle; more may be written then.
    layout : CycleLayout
        Of rows with fewer fields, as older recordings have.
    """
    cycle, made = cycle_of(settings(), NOISE), []
    model_config: ModelConfig = cycle.model_config
    table = np.tile([REST, GAIN, 0.6, 1.0], (72, 1))
    skin_files = (
        Enclosed("configuration.json", "application/json", model_config.to_json().encode()),
        Enclosed("ring.json", "application/json", json.dumps({"period": 1e-9 * PERIOD}).encode()),
        tare_file(table),
    )
    writer = RecordingWriter(path, skin_files, layout=layout, overwrite=True)
    if layout != ROWS:  # beside which a second process found contacts
        writer.container.put(Channel(FIT, "/skin/fit", "x-skinfield-fit", {}, 1))
    channels, slot, blocks = Channels(72), CycleSlot.empty(cycle.sizes), Blocks(1 << 13)
    change, position = pressed_counts() - REST, 0
    for number in range(cycles):
        wall = START + number * PERIOD
        blocks.clear()
        blocks.put(wall - 1000, 0, np.rint(REST + level(number) * change), Kind.BYTES)
        if number == tared_at:
            table = table + np.array([0.25, 0.0, 0.0, 0.0])
            cycle.calibrate(table)
        channels.apply_good(blocks)
        cycle.answer(channels, wall, slot, reset=number == 0, budget=10.0)
        data = bytes(blocks.data)
        position += len(data)
        _stamp(slot, wall, position)
        told = slot.recorded(number)
        if number >= first and number not in without:
            writer.write_blocks(wall, position - len(data), data)
            writer.write(CYCLES, wall, layout.encode(rows_of(told, layout)))
            if layout != ROWS:
                writer.container.add_message(FIT, number, wall, bytes(56))
            if number % every == 0:
                writer.write(FIELDS, wall, _field(number, wall, slot).encode())
            if number % 10 == 9:
                writer.flush()
            if number == tared_at:
                writer.enclose(wall, tare_file(table, 2))
                writer.event(wall, "calibrated", "the baseline was taken anew", tares=2)
            if beside is not None:
                beside(writer, slot, number)
        made.append(_known(told, slot))
    writer.close()
    return made


def _field(number: int, wall: int, slot: CycleSlot) -> FieldRecord:
    taxels = slot.counts, slot.values, slot.valid
    return FieldRecord.of(number, wall, slot.patches["rung"], slot.pressure, taxels)


def _stamp(slot: CycleSlot, wall: int, position: int) -> None:
    head = slot.head
    head[CycleHead.FLAGS], head[CycleHead.WALL_NS], head[CycleHead.LOG_POSITION] = 0, wall, position
    head[CycleHead.DUE_NS] = wall - START
    head[CycleHead.WAKE_NS] = wall - START + 20_000
    head[CycleHead.ACQUIRED_NS] = wall - START + 40_000
    head[CycleHead.READY_NS] = wall - START + 300_000


def _known(told: Any, slot: CycleSlot) -> Known:
    rung = int(slot.patches["rung"][0])
    touched = int(slot.patches["answer"][0]) > 1
    pressure = slot.pressure[0, : rung * rung] if touched else slot.pressure[0, :0]
    return Known(
        told.number,
        told.wall_ns,
        float(slot.patches["force"].sum()),
        slot.patches.tobytes(),
        told.contacts.tobytes(),
        pressure.tobytes(),
        slot.values.tobytes(),
    )
