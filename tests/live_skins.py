"""Live skins for tests: sources in memory, and settings that need no hardware."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from uuid import uuid4

import numpy as np

import skinfield as sf
from skinfield.loop.baseline import TareBaseline
from skinfield.loop.model_config import Configuration, ModelConfig, write_configuration
from skinfield.loop.realtime import RealTime
from skinfield.loop.ring_fields import open_ring
from skinfield.loop.runtime_parameters import Tuning
from skinfield.loop.settings import LiveSettings
from skinfield.loop.slots import CycleHead, CycleSlot
from skinfield.loop.update import Updater
from skinfield.reconstruct.engine.state import Answer
from skinfield.ring import Ring, State
from skinfield.signal import Blocks, ICubByte, Kind, Port, counters
from skinfield.simulate import Sphere, press

LAYER = sf.Layer(2e-3, 150e3, 0.5)
GAIN, REST = -171.0, 240.0


def unique_name() -> str:
    """For a ring that no other test has."""
    return f"test-{uuid4().hex[:12]}"


def gentle() -> RealTime:
    """Ask the system for nothing: tests run side by side."""
    return RealTime(priority=0, lock_memory=False, freeze_gc=False, keep_awake=False)


@dataclass(frozen=True)
class Ticking:
    """Source of a still skin with noise, by the time of day; it fails when told to.

    Parameters
    ----------
    channels : int
    period : float, s
    fail_after : int
        Polls, after which it raises once in a process; 0: never.
    pressed : Path, optional
        Of a hexagon that is pressed, now harder and now weaker, once this file is there.
    """

    channels: int = 72
    period: float = 0.005
    fail_after: int = 0
    pressed: Path | None = None

    def open(self) -> "TickingStream":
        return TickingStream(self)


FALLEN: list[Ticking] = []


class TickingStream:
    """See `Stream`."""

    def __init__(self, source: Ticking) -> None:
        self.source, self.up = source, True
        self.ports: Sequence[Port] = (Port("ticking", source.channels),)
        self.counters = counters()
        self._rng = np.random.default_rng(1)
        self._change = 0.0 if source.pressed is None else pressed_counts(1.5) - REST
        self._last, self._polls = 0, 0

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        self._polls += 1
        if self._polls == self.source.fail_after and self.source not in FALLEN:
            FALLEN.append(self.source)
            raise RuntimeError("the driver fell over")
        if now_ns - self._last < self.source.period * 1e9:
            return 0
        self._last = now_ns
        counts = REST + self._rng.integers(-1, 2, self.source.channels)
        if self.source.pressed is not None and self.source.pressed.exists():
            counts += (0.75 + 0.25 * np.sin(now_ns * 3e-9)) * self._change
        blocks.put(now_ns, channel, np.clip(np.rint(counts), 0, 255), Kind.BYTES)
        self.counters[0] += 1
        self.counters[1] += 1
        return 1

    def filenos(self) -> Sequence[int]:
        return ()

    def close(self) -> None:
        self.up = False


def settings(**changes: object) -> LiveSettings:
    """Of a hexagon on a ticking source, quick to prepare."""
    known: dict[str, object] = {
        "skin": sf.layouts.hexagon72(),
        "sources": (Ticking(),),
        "name": unique_name(),
        "layer": LAYER,
        "board": ICubByte(),
        "rungs": (10, 20),
        "rate": 200.0,
        "tare_seconds": 0.3,
        "real_time": gentle(),
        "log_bytes": 1 << 22,
    }
    return LiveSettings(**(known | changes))  # type: ignore[arg-type]


def cycle_of(made: LiveSettings, noise: float = 0.004) -> Updater:
    """A cycle with a known calibration."""
    taxels = sum(map(len, made.skin))
    model_config = ModelConfig.of(
        made, (Port("port", max(int(p.channel.max()) for p in made.skin) + 1),)
    )
    table = np.tile([REST, GAIN, 0.6, 1.0], (taxels, 1))
    return Updater(model_config, TareBaseline(table, np.full(taxels, noise), 10**8))


@cache
def pressed_counts(force: float = 1.0, at: tuple[float, float] = (0.0, 7.5e-3)) -> np.ndarray:
    """Bytes (72,) of a press on a hexagon, without noise."""
    patch = sf.layouts.hexagon72()
    body = Sphere(radius=6e-3, force=force, position=at)
    made = press(LAYER, [body], 40e-3, 0.5e-3)
    change = made.readings(patch.plane, patch.pad_diameter, "capacitance")
    return np.clip(np.rint(REST + GAIN * change), 0, 255)


def wait_for(condition, seconds: float = 180.0):  # type: ignore[no-untyped-def]
    """What `condition()` gives, as soon as that is true."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := condition():
            return found
        time.sleep(0.02)
    raise AssertionError(f"not within {seconds:g} s: {condition}")


@contextmanager
def skin_ring(made: LiveSettings | None = None, unit: str = "count") -> Iterator[Ring]:
    """A ring of a live skin, which tests fill."""
    made = settings() if made is None else made
    taxels = sum(len(patch) for patch in made.skin)
    ring, _ = open_ring(made, ModelConfig.of(made, (Port("ticking", taxels, unit),)))
    try:
        with ring:
            begin(ring, made)
            yield ring
    finally:
        Ring.remove(made.name)


def begin(ring: Ring, made: LiveSettings) -> None:
    """What an engine says when it starts to answer."""
    known = Configuration(ring.generation, made.solver, Tuning(deadline=made.time_to_answer))
    write_configuration(ring.status["configuration"], known)
    ring.set_state(State.RUNNING)


def fill(
    ring: Ring, rng: np.random.Generator, stamp_ns: int, *forces: float, fresh: int = 1
) -> int:
    """A cycle with these contacts and a pressure by chance."""
    slot = CycleSlot.of(ring.begin())
    slot.head[:] = 0
    slot.head[CycleHead.FRESH], slot.head[CycleHead.CONTACTS] = fresh, len(forces)
    slot.head[CycleHead.WALL_NS], slot.head[CycleHead.GENERATION] = stamp_ns, ring.generation
    rows = slot.patches
    rows["answer"], rows["rung"], rows["stamp_ns"] = int(Answer.LINEAR), 20, stamp_ns
    rows["contacts"], rows["force"], rows["gap"] = len(forces), sum(forces), np.nan
    for k, force in enumerate(forces):
        row = slot.contacts[0][k]
        row["track"], row["patch"], row["normal_force"] = k + 1, 0, force
        row["position"], row["normal"] = rng.normal(size=3), (0.0, 0.0, 1.0)
        row["x"], row["y"] = row["position"][:2]
        row["force_std"], row["place_std"], row["area"] = 0.1 * force, np.nan, 1e-4
    slot.counts[:] = rng.normal(200.0, 10.0, slot.counts.shape)
    slot.values[:] = rng.normal(0.0, 0.01, slot.values.shape)
    slot.valid[:] = 1
    slot.pressure[:] = rng.uniform(0.0, 1e4, slot.pressure.shape)
    return ring.publish()
