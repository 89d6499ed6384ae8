"""What a recorder takes from a ring beside readings and cycles: enclosures, timing, events."""

import io
import json
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition.recorded import CONFIGURATION, TARE, CycleLayout, Enclosed
from skinfield.conditioning import Calibration
from skinfield.errors import FileError, InputError, SkinfieldError
from skinfield.layout import Skin
from skinfield.live.recipe import Recipe
from skinfield.live.recorder_queue import Attached, Queue, Told
from skinfield.realtime.timing import Timing
from skinfield.ring import RingReader, State
from skinfield.sinks.mcap import enclosures

SILENT = 1.0  # s without a sign of life of the engine until it is told
JSON, NPZ = "application/json", "application/x-npz"
Array = NDArray[Any]


def layout_of(reader: RingReader) -> CycleLayout:
    """Rows of the ring's cycles; raises FileError if it is no live skin's."""
    said = reader.description
    if "contact_row" not in said or "patch_row" not in said:
        raise FileError(f"{reader.path} is no ring of a live skin, expected that of an engine")
    metadata = {"contact": said["contact_row"], "patch": said["patch_row"]}
    return CycleLayout.from_metadata({key: json.dumps(row) for key, row in metadata.items()})


def enclosed_of(reader: RingReader) -> tuple[Enclosed, ...]:
    """Everything that makes the recording self-contained."""
    said = dict(reader.description)
    text = said.pop("recipe", None)
    skin = skin_of(reader)
    made: list[Enclosed] = []
    if isinstance(text, str):
        made.append(Enclosed(CONFIGURATION, JSON, text.encode()))
    status = reader.status
    calibrations = {}
    if skin is not None and int(status["tares"][0]) > 0:
        calibrations = calibrations_of(skin, status["calibration"])
        made.append(tare_of(status))
    return (*enclosures(skin, calibrations, None, said), *made)


def skin_of(reader: RingReader) -> Skin | None:
    """The skin that a ring says it is of; None where it does not say."""
    text = reader.description.get("recipe")
    return Recipe.from_json(text).skin if isinstance(text, str) else None


def tare_of(status: dict[str, Array]) -> Enclosed:
    """The engine's own calibration, as it is in the ring's status."""
    buffer = io.BytesIO()
    names = ("calibration", "noise_std", "stale_ns", "tares")
    np.savez(buffer, allow_pickle=False, **{name: status[name] for name in names})
    return Enclosed(TARE.format(number=int(status["tares"][0])), NPZ, buffer.getvalue())


def calibrations_of(skin: Skin, table: Array) -> dict[str, Calibration]:
    """Calibrations by patch, of rows baseline, gain, noise_std and alive for all taxels."""
    return dict(_calibrations(skin, table))


def _calibrations(skin: Skin, table: Array) -> Iterator[tuple[str, Calibration]]:
    start = 0
    for patch in skin:
        rows = table[start : start + len(patch)]
        start += len(patch)
        try:
            yield (
                patch.name,
                Calibration(
                    rows[:, 0].copy(),
                    rows[:, 1].copy(),
                    rows[:, 2].copy(),
                    rows[:, 3] > 0,
                    patch.uid,
                    patch_name=patch.name,
                ),
            )
        except InputError:  # a patch that never answered has no baseline
            continue


class Watch:
    """Looks at a ring once a second.

    Parameters
    ----------
    reader : RingReader
    queue : Queue
    tares : int
        Calibrations so far that are enclosed already.
    """

    def __init__(self, reader: RingReader, queue: Queue, tares: int = 0) -> None:
        self._reader, self._queue, self._skin = reader, queue, skin_of(reader)
        status = reader.status
        self._before = (status["times"], status["totals"])
        Timing.of(*self._before, self._before)  # loads what it needs: later the ring would not wait
        self._tares = tares
        self._state: State | None = reader.state
        self._silent = False

    def look(self) -> None:
        """Tell the last second's timing, and what has changed."""
        now = time.time_ns()
        status = self._reader.status
        told: dict[str, object] = dict(
            Timing.of(status["times"], status["totals"], self._before).as_dict()
        )
        self._before = (status["times"], status["totals"])
        names = self._reader.description.get("source_counters", [])
        told["counters"] = [
            dict(zip(names, row, strict=False)) for row in status["sources"].tolist()
        ]
        self._queue.tell(Told(now, "timing", "", told))
        if int(status["tares"][0]) != self._tares:
            self._tares = int(status["tares"][0])
            for each in self._calibrated(status):
                self._queue.tell(Attached(now, each))
            self._tell("calibrated", "the baseline was taken anew", tares=self._tares)
        self._engine()

    def _calibrated(self, status: dict[str, Array]) -> Iterator[Enclosed]:
        """What was enclosed of the calibration before stands for what was read until then."""
        if self._skin is not None:
            yield from enclosures(calibrations=calibrations_of(self._skin, status["calibration"]))
        yield tare_of(status)

    def _engine(self) -> None:
        try:
            state: State | None = self._reader.state
        except SkinfieldError:
            state = None
        if state != self._state and state is not None:
            self._tell("engine_state", f"the engine is {state.name.lower()}", state=state.name)
        self._state = state
        age = (time.monotonic_ns() - self._reader.heartbeat_ns) * 1e-9
        silent = age > SILENT and state in (State.RUNNING, State.CALIBRATING)
        if silent and not self._silent:
            self._tell(
                "engine_silent", f"no sign of life of the engine for {age:.1f} s", seconds=age
            )
        elif self._silent and not silent:
            self._tell("engine_back", "the engine gives signs of life again")
        self._silent = silent

    def _tell(self, kind: str, text: str, **values: object) -> None:
        self._queue.tell(Told(time.time_ns(), kind, text, values))
