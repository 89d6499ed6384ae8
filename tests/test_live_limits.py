"""What does not fit, or fails beside the loop, ends no engine."""

import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from live_skins import settings

from skinfield.acquisition import Blocks, Kind, blocks_of
from skinfield.acquisition.recorded import CycleFlag
from skinfield.errors import InputError
from skinfield.live import recorder
from skinfield.live.engine_process import EngineProcess
from skinfield.live.recipe import Recipe
from skinfield.live.ring_fields import open_ring, room_for, write_tare
from skinfield.live.slots import Head
from skinfield.live.supervisor import Supervisor
from skinfield.live.tare import Tared
from skinfield.realtime import TimingTable

SECOND = 10**9


@pytest.mark.parametrize("taxels", [1, 72, 10_922, 10_923, 200_000])
def test_a_calibration_of_any_skin_fits_into_the_blocks_of_a_poll(taxels: int) -> None:
    table = np.arange(4.0 * taxels).reshape(taxels, 4)
    tared = Tared(table, np.arange(float(taxels)), 50_000_000)
    names = ("calibration", "noise_std", "stale_ns", "tares")
    shapes = ((taxels, 4), (taxels,), (1,), (1,))
    status = dict(zip(names, map(np.zeros, shapes), strict=True))
    blocks = Blocks(room_for(taxels))
    write_tare(SimpleNamespace(status=status), tared, blocks, 7)  # type: ignore[arg-type]
    found = list(blocks_of(blocks.data))
    assert {block.kind for block in found} == {Kind.CALIBRATION}
    rows = np.concatenate([block.payload.reshape(-1, 6) for block in found])
    again = Tared.from_rows(rows)
    assert (again.calibration == table).all()
    assert again.stale_ns == tared.stale_ns
    assert status["tares"][0] == 1


def test_a_log_that_one_poll_could_overfill_is_refused() -> None:
    made = settings(log_bytes=1 << 20)
    with pytest.raises(InputError, match="log_bytes is 1048576, expected at least 4194304"):
        open_ring(made, Recipe.of(made, ()))


def test_a_new_baseline_that_fails_leaves_the_old_one() -> None:
    def finish() -> Tared:
        raise InputError("counts reach 300")

    notes: dict[str, object] = {}
    engine = SimpleNamespace(again=SimpleNamespace(finish=finish), _note=notes.update)
    EngineProcess._finish_tare(engine, SimpleNamespace(), 1)  # type: ignore[arg-type]
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
def test_cycles_say_that_they_were_late(due: int, flags: CycleFlag) -> None:
    def nothing(*_: object, **__: object) -> bool:
        return False

    slot = SimpleNamespace(head=np.zeros(len(Head), np.int64))
    slot.head[Head.DUE_NS] = time.monotonic_ns() - due * SECOND
    engine = SimpleNamespace(
        since_key=5,
        keys=9,
        journal=SimpleNamespace(budget_ns=400_000),
        flags=0,
        intake=SimpleNamespace(channels=None),
        timing=TimingTable(20 * SECOND, 5 * SECOND),
        ring=SimpleNamespace(publish=nothing, heartbeat=nothing),
        waiter=SimpleNamespace(skipped=0),
    )
    cycle = SimpleNamespace(answer=nothing)
    EngineProcess._answer(engine, cycle, slot, int(slot.head[Head.DUE_NS]), 0)  # type: ignore[arg-type]
    assert CycleFlag(int(slot.head[Head.FLAGS])) == flags
    assert engine.since_key == 4


def test_an_engine_that_cannot_be_started_now_is_started_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    supervisor, tries = Supervisor(settings()), []

    def start() -> None:
        tries.append(1)
        if len(tries) < 3:
            raise OSError(11, "Resource temporarily unavailable")
        supervisor._stopping.set()

    monkeypatch.setattr(supervisor, "_start", start)
    monkeypatch.setattr("skinfield.live.supervisor.PAUSES", (0.01,))
    supervisor._watch()
    assert len(tries) == 3
    assert [each.what for each in supervisor.events] == ["failed", "failed"]
    assert "temporarily unavailable" in supervisor.failure
    supervisor.status_path.unlink()


def test_signals_without_a_name_are_told_by_their_number(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    supervisor = Supervisor(settings())
    monkeypatch.setattr(supervisor, "_again", lambda: None)
    supervisor._gone(-40)
    supervisor._gone(-9)
    assert [each.text for each in supervisor.events] == [
        "ended with signal 40",
        "ended with signal SIGKILL",
    ]
    supervisor.status_path.unlink()


def test_the_watch_goes_on_where_its_events_cannot_be_written(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    supervisor = Supervisor(settings())
    monkeypatch.setattr(
        "skinfield.live.supervisor.beside", lambda name, what: tmp_path / "not there" / name
    )
    supervisor._tell("failed", "text")
    assert supervisor.events[-1].text == "text"


def test_a_recorder_asks_for_a_beginning_once_older_readings_do_not_count(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[float] = []
    clock = SimpleNamespace(now=100.0)
    monkeypatch.setattr(recorder.time, "monotonic", lambda: clock.now)
    monkeypatch.setattr(recorder, "order", lambda name, what: asked.append(clock.now))
    status = {"stale_ns": np.zeros(1, np.int64), "tares": np.zeros(1, np.int64)}
    made = SimpleNamespace(
        _since=float("inf"),
        _ask_at=99.0,
        _drain=SimpleNamespace(cycles=1),
        _reader=SimpleNamespace(status_view=status),
        settings=SimpleNamespace(name="skin"),
    )
    for step in range(300):
        clock.now = 100.0 + step / 100.0
        if step == 50:  # a baseline is there
            status["stale_ns"][0], status["tares"][0] = SECOND, 1
        if clock.now > made._ask_at:
            recorder.Recorder._ask_for_a_beginning(made)  # type: ignore[arg-type]
    (at,) = asked
    assert 101.1 <= at < 101.3
