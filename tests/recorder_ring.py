"""Rings as an engine writes them, made up, and recorders of them: for tests."""

import sys
import time
from pathlib import Path
from typing import Any, Self

import numpy as np
from live_skins import unique_name

from skinfield.estimate.live_contacts import CONTACT
from skinfield.files.mcap.live import LiveRecording
from skinfield.files.mcap.schema import CycleFlag
from skinfield.loop.model_config import Configuration, ModelConfig, write_configuration
from skinfield.loop.ring_fields import description_of, status_fields
from skinfield.loop.runtime_parameters import Tuning
from skinfield.loop.settings import LiveSettings
from skinfield.loop.slots import PATCH, CycleHead, CycleSlot, Sizes
from skinfield.record.recorder import Recorder, forget_state
from skinfield.ring import Ring, State
from skinfield.signal import Blocks, Kind, Port
from skinfield.skin import Patch, Skin


class NoSource:
    def open(self):
        raise NotImplementedError


def skin_of(taxels: int) -> Skin:
    side = int(np.ceil(np.sqrt(taxels)))
    where = np.array([(i % side, i // side) for i in range(taxels)], float) * 5e-3
    return Skin((Patch(where, name="arm"),), name="test")


class Engine:
    """A ring of a skin whose engine runs; as a context it leaves nothing behind.

    Parameters
    ----------
    skin : Skin
    name : str
        Of the ring; without one, a name that nobody else has.
    slots, log_bytes : int
    """

    def __init__(self, skin: Skin, name: str = "", slots: int = 64, log_bytes: int = 1 << 20):
        self.skin, taxels = skin, sum(map(len, skin))
        tree = {"skin": {"thickness_mm": 3.0, "modulus_kpa": 80.0}}
        settings = LiveSettings(
            skin=skin,
            sources=(NoSource(),),
            name=name or unique_name(),
            rungs=(4,),
            tree=tree,
            relative=True,
        )
        ports = tuple(Port(patch.name, len(patch)) for patch in skin)
        description = description_of(settings, ModelConfig.of(settings, ports))
        fields = Sizes(len(skin), taxels, 16, 8).fields(), status_fields(len(skin), taxels)
        self.layout = (*fields, slots, log_bytes)
        self.ring = Ring.create(settings.name, *fields, description, slots, log_bytes)
        status = self.ring.status
        status["noise_std"][:], status["tares"][0] = 0.01, 1
        write_configuration(status["configuration"], Configuration(1, settings.solver, Tuning()))
        self.ring.set_state(State.RUNNING)
        self.blocks = Blocks(1 << 16)

    def reopen(self) -> None:
        """As a new process after a crash."""
        self.ring.close()
        self.ring = Ring.reopen(self.ring.name, *self.layout)
        self.ring.set_state(State.RUNNING)

    def begin(self, now_ns: int) -> CycleSlot:
        """The next slot: empty, but for the time and how far the log goes."""
        slot = CycleSlot.of(self.ring.begin())
        slot.head[:] = 0
        slot.head[CycleHead.WALL_NS], slot.head[CycleHead.LOG_POSITION] = now_ns, self.ring.log_end
        slot.patches[:] = np.zeros(len(self.skin), PATCH)
        slot.valid[:] = 1
        return slot

    def publish(self) -> int:
        """The slot that was begun; its number."""
        self.ring.heartbeat(time.monotonic_ns())
        self.ring.status["totals"][0] += 1
        return self.ring.publish()

    def close(self) -> None:
        self.ring.unlink()
        self.ring.close()
        forget_state(self.ring.name)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class FakeEngine(Engine):
    """Publishes a cycle whenever told: blocks of random counts, a contact, a pressure."""

    def __init__(self, name: str = "", taxels: int = 24, slots: int = 64, log_bytes: int = 1 << 20):
        super().__init__(skin_of(taxels), name, slots, log_bytes)
        self.ring.status["calibration"][:] = (200.0, -100.0, 2e4, 1.0)  # as noisy as the counts
        self.blocks.put(0, 0, [0], Kind.BYTES)  # compiled before anyone waits
        self.rng = np.random.default_rng(1)
        self.taxels, self.number = taxels, 0
        self.counts, self.written = [], []
        self.keep = True

    def cycle(self, kind: Kind = Kind.SHORTS, extra=lambda blocks, now: None, counts=None) -> None:
        now = time.time_ns()
        self.blocks.clear()
        if counts is None:
            counts = self.rng.integers(0, 256 if kind == Kind.BYTES else 65536, self.taxels)
        self.blocks.put(now, 0, counts, kind)
        extra(self.blocks, now)
        data = self.blocks.data
        self.ring.log(data)
        slot, mono = self.begin(now), time.monotonic_ns()
        slot.head[CycleHead.FLAGS] = CycleFlag.LATE * (self.number % 10 == 0)
        slot.head[CycleHead.FRESH] = 1
        slot.head[CycleHead.DUE_NS : CycleHead.WALL_NS] = mono + np.arange(4)
        slot.counts[:], slot.values[:] = counts, 1e-3 * self.number
        slot.pressure[:] = 0.0
        slot.pressure[0, self.number % 16] = self.number
        slot.patches["contacts"] = self.number % 3
        slot.patches["rung"] = 4
        slot.patches["force"] = self.number
        slot.contacts[:] = np.zeros(8, CONTACT)
        slot.contacts["track"] = self.number
        slot.contacts["shape"], slot.contacts["maybe"], slot.contacts["radius"] = 1, 1, 4e-3
        self.number = self.publish()
        if self.keep:
            self.counts.append(counts)
            self.written.append(bytes(data))


def contact(x: float = 0.0, y: float = 0.0, force: float = 1.0, **more: Any) -> Any:
    """A row of CONTACT."""
    row = np.zeros(1, CONTACT)
    row["x"], row["y"], row["normal_force"], row["normal"] = x, y, force, (0.0, 0.0, 1.0)
    row["position"], row["covariance"] = (x, y, 0.0), np.nan
    for name, value in more.items():
        row[name] = value
    return row


def recorder_of(engine: Engine, path: Path, **how: Any) -> Recorder:
    return Recorder(engine.ring.name, path, **how)


def record(engine: FakeEngine, path: Path, cycles: int, every: int = 3, **how: Any) -> Recorder:
    """Cycles into a file, whose recorder looks after some of them; the recorder, which ended."""
    recorder = recorder_of(engine, path, **how)
    for i in range(cycles):
        engine.cycle()
        if i % every == 0:
            recorder.step()
    recorder.close()
    return recorder


def whole(engine: FakeEngine, path: Path) -> LiveRecording:
    """A finished recording, after it was seen that it has all of the ring's log."""
    found = LiveRecording.open(path)
    assert found.finished
    assert b"".join(each.data for each in found.blocks()) == b"".join(engine.written)
    return found


def missing_bytes(recording) -> int:
    """Of the log between the first and the last that is in a file."""
    blocks = list(recording.blocks())
    spanned = blocks[-1].position + len(blocks[-1].data) - blocks[0].position
    return spanned - sum(len(each.data) for each in blocks)


def main() -> None:
    """Run at a rate: name, taxels, cycles per second, seconds, slots, bytes of the log."""
    name, taxels, rate, seconds, slots, log = sys.argv[1:7]
    engine = FakeEngine(name, int(taxels), int(slots), int(log))
    engine.keep = False
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    sys.stdin.readline()
    start, period = time.monotonic(), 1.0 / float(rate)
    total = int(float(rate) * float(seconds))
    noise = engine.rng.normal(20000.0, 2.0, (64, engine.taxels))
    place = np.linspace(0.0, 6.0, engine.taxels)
    for i in range(total):
        engine.cycle(counts=(noise[i % 64] + 300.0 * np.sin(place + 2e-3 * i)).astype(np.uint16))
        left = start + (i + 1) * period - time.monotonic()
        if left > 0:
            time.sleep(left)
    sys.stdout.write(f"{engine.number} {engine.ring.log_end}\n")
    sys.stdout.flush()
    sys.stdin.readline()
    engine.close()


if __name__ == "__main__":
    main()
