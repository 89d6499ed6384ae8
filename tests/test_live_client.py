"""Readers of a live skin's ring, cycle by cycle, and what ends no engine."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from live_skins import fill, settings, skin_ring
from numpy.testing import assert_array_equal

from skinfield.errors import InputError
from skinfield.files.mcap.schema import CycleFlag
from skinfield.loop.baseline import Baseline
from skinfield.loop.client import Live
from skinfield.loop.engine_process import EngineProcess
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.realtime import TimingTable
from skinfield.loop.ring_fields import open_ring
from skinfield.loop.slots import Head
from skinfield.loop.supervisor import Supervisor
from skinfield.ring import Ring

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
SECOND = 10**9


@pytest.fixture
def ring() -> Iterator[Ring]:
    with skin_ring() as found:
        yield found


def publish(ring: Ring, *forces: float, fresh: int = 1) -> int:
    """A cycle with contacts of these forces."""
    return fill(ring, np.random.default_rng(ring.number), SECOND, *forces, fresh=fresh)


def test_the_cycle_of_the_contact_is_the_one_that_is_returned(ring: Ring) -> None:
    publish(ring)
    found = []
    with Live(ring.name) as live:
        waiting = threading.Thread(target=lambda: found.append(live.wait_contact(60.0, force=1.0)))
        waiting.start()
        publish(ring, 0.5)
        wanted = publish(ring, 0.25, 1.5)
        waiting.join()
    (snapshot,) = found
    assert snapshot is not None
    assert snapshot.number == wanted
    assert_array_equal(snapshot.contacts["normal_force"], [0.25, 1.5])


def test_what_was_returned_does_not_change_later(ring: Ring) -> None:
    publish(ring, 2.0)
    with Live(ring.name) as live:
        first = live.wait_contact(60.0)
        assert first is not None
        readings = first.readings.copy()
        publish(ring, 3.0)
        second = live.wait_contact(60.0)
        assert second is not None
        assert_array_equal(first.readings, readings)
        assert first.patches["contacts"][0] == 1
        assert first.contacts["normal_force"][0] == 2.0
        assert second.contacts["normal_force"][0] == 3.0
        assert not np.array_equal(second.readings, readings)


def test_a_loop_passes_over_cycles_without_a_new_reading(ring: Ring) -> None:
    first = publish(ring)
    with Live(ring.name) as live:
        loop = iter(live)
        assert next(loop).number == first
        publish(ring, fresh=0)
        found = []
        waiting = threading.Thread(target=lambda: found.append(next(loop)))
        waiting.start()
        third = publish(ring)
        waiting.join()
    assert [each.number for each in found] == [third]


def test_a_log_that_one_poll_could_overfill_is_refused() -> None:
    made = settings(log_bytes=1 << 20)
    with pytest.raises(InputError, match="log_bytes is 1048576, expected at least 4194304"):
        open_ring(made, ModelConfig.of(made, ()))


def test_a_new_baseline_that_fails_leaves_the_old_one() -> None:
    def finish() -> Baseline:
        raise InputError("counts reach 300")

    notes: dict[str, object] = {}
    engine = SimpleNamespace(again=SimpleNamespace(finish=finish), _note=notes.update)
    EngineProcess._finish_tare(engine, SimpleNamespace())  # type: ignore[arg-type]
    assert engine.again is None
    assert notes == {"tare": ["the baseline stays as it was: counts reach 300"]}


@pytest.mark.parametrize(
    ("due", "flags"),
    [
        (0, CycleFlag(0)),
        (6, CycleFlag.LATE),
        (40, CycleFlag.LATE | CycleFlag.OVERRUN),
    ],
)
def test_cycles_say_that_they_were_late(
    monkeypatch: pytest.MonkeyPatch, due: int, flags: CycleFlag
) -> None:
    def nothing(*_: object, **__: object) -> bool:
        return False

    slot = SimpleNamespace(head=np.zeros(len(Head), np.int64))
    slot.head[Head.DUE_NS] = (100 - due) * SECOND
    clock = SimpleNamespace(monotonic_ns=lambda: 100 * SECOND)
    monkeypatch.setattr("skinfield.loop.engine_process.time", clock)
    engine = SimpleNamespace(
        reset=True,
        budget_ns=400_000,
        flags=0,
        intake=SimpleNamespace(channels=None),
        timing=TimingTable(20 * SECOND, 5 * SECOND),
        ring=SimpleNamespace(publish=nothing, heartbeat=nothing),
        waiter=SimpleNamespace(skipped=0),
    )
    cycle = SimpleNamespace(answer=nothing)
    EngineProcess._answer(engine, cycle, slot, int(slot.head[Head.DUE_NS]), 0)  # type: ignore[arg-type]
    assert CycleFlag(int(slot.head[Head.FLAGS])) == flags
    assert not engine.reset


def test_an_engine_that_cannot_be_started_now_is_started_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    supervisor, tries = Supervisor(settings()), []

    def spawn() -> subprocess.Popen[bytes]:
        tries.append(1)
        if len(tries) < 3:
            raise OSError(11, "Resource temporarily unavailable")
        supervisor.stopping.set()
        return subprocess.Popen([sys.executable, "-c", ""])

    monkeypatch.setattr(supervisor, "spawn", spawn)
    monkeypatch.setattr(supervisor, "pauses", (0.01,))
    supervisor._watch()
    supervisor.end()
    assert [each.what for each in supervisor.events] == ["failed", "failed", "started"]
    assert "temporarily unavailable" in supervisor.failure
    supervisor.status_path.unlink()


def test_the_watch_goes_on_where_its_events_cannot_be_written(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    supervisor = Supervisor(settings())
    monkeypatch.setattr(
        "skinfield.loop.supervisor.sidecar", lambda name, what: tmp_path / "not there" / name
    )
    supervisor.report("failed", "text")
    assert supervisor.events[-1].text == "text"
