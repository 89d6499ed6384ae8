"""Answers of a fit beside the engine, from its ring into the file."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from fit_rings import FakeFit, contact
from recorder_ring import FakeEngine, recorder_of, whole

from skinfield.files.mcap.live import LiveRecording
from skinfield.files.mcap.schema import FitRecord
from skinfield.loop import fit_ring
from skinfield.loop.fit_ring import Fitted, fit_name
from skinfield.record.queue import Item, Queue
from skinfield.record.recorder import Recorder
from skinfield.record.state import RecorderState
from skinfield.ring import Field, Ring


@pytest.fixture(autouse=True)
def _at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fit_ring, "AGAIN", 0.0)  # s between looks for a ring


@pytest.fixture(name="fit")
def _fit(engine: FakeEngine) -> Iterator[FakeFit]:
    with FakeFit(engine.ring.name) as made:
        yield made


@pytest.fixture(name="path")
def _path(tmp_path: Path) -> Path:
    return tmp_path / "a.mcap"


def step(engine: FakeEngine, recorder: Recorder) -> None:
    engine.cycle()
    recorder.step()


def ended(engine: FakeEngine, recorder: Recorder, path: Path) -> list[FitRecord]:
    """What is in the file, after it was seen that the engine was recorded whole."""
    state = recorder.close()
    assert state.finished
    found = whole(engine, path)
    assert [each.number for each in found.cycles()] == list(range(1, engine.number + 1))
    told = list(found.fits())
    assert found.damage == []
    return told


def test_each_answer_is_in_the_file_to_the_last_bit(
    engine: FakeEngine, fit: FakeFit, path: Path
) -> None:
    recorder = recorder_of(engine, path)
    field = [0.0, 3.5, 0.0, 1e-30]
    fit.tell(contact(1e-3, force=2.0, track=4), contact(9e-3, track=7), pressure=field)
    fit.tell(contact(2e-3, force=1.0, track=4), pressure=[1.0])
    step(engine, recorder)
    fit.tell(state=Fitted.UNHELPFUL)
    step(engine, recorder)
    first, second, third = ended(engine, recorder, path)
    assert [each.number for each in (first, second, third)] == [1, 2, 3]
    assert first.time_ns < second.time_ns < third.time_ns <= time.time_ns()
    assert first.sizes == (1, 16, 8)
    assert first.places.tolist() == [0]
    assert first.contacts["track"].tolist() == [4, 7]
    assert first.contacts["position"].tolist() == [[1e-3, 0.0, 0.0], [9e-3, 0.0, 0.0]]
    assert first.forms["radius"].tolist() == [5e-3, 5e-3]
    assert first.nodes.tolist() == [1, 3]
    assert first.pressure.tolist() == [3.5, float(np.float32(1e-30))]
    assert second.contacts["normal_force"].tolist() == [1.0]
    assert third.patches["state"].tolist() == [int(Fitted.UNHELPFUL)]
    assert len(third.nodes) == len(third.contacts) == 0


def test_what_says_nothing_new_is_left_out(engine: FakeEngine, fit: FakeFit, path: Path) -> None:
    recorder = recorder_of(engine, path)
    for _ in range(3):
        fit.tell(state=Fitted.NOTHING)  # an untouched skin, looked at again
        step(engine, recorder)
    fit.tell(contact(), stamp_ns=5)
    fit.tell(contact(), stamp_ns=5)
    step(engine, recorder)
    for _ in range(2):
        fit.tell(state=Fitted.NOTHING)
    told = ended(engine, recorder, path)
    assert [len(each.places) for each in told] == [1, 0]


def test_a_fit_may_come_go_and_come_again(engine: FakeEngine, path: Path) -> None:
    recorder = recorder_of(engine, path)
    step(engine, recorder)
    for force in (1.0, 2.0):
        with FakeFit(engine.ring.name) as fit:
            fit.tell(contact(force=force))
            step(engine, recorder)
        step(engine, recorder)
    told = ended(engine, recorder, path)
    forces = [each.contacts["normal_force"].tolist() for each in told]
    assert forces == [[1.0], [], [2.0], []]
    assert [each.number for each in told] == [1, 0, 1, 0]


def test_one_that_runs_already_is_known_from_the_beginning(
    engine: FakeEngine, fit: FakeFit, path: Path
) -> None:
    for force in range(1, 40):
        fit.tell(contact(force=force))
    told = ended(engine, recorder_of(engine, path), path)
    assert told[-1].contacts["normal_force"].tolist() == [39.0]


def test_one_of_another_skin_is_left_out(engine: FakeEngine, path: Path) -> None:
    recorder = recorder_of(engine, path)
    for other in ({"patches": ("leg",)}, {"nodes": 25}):
        with FakeFit(engine.ring.name, **other) as fit:
            fit.tell(contact())
            step(engine, recorder)
    assert ended(engine, recorder, path) == []


def test_too_many_for_the_recorder_are_counted(
    engine: FakeEngine, fit: FakeFit, path: Path
) -> None:
    recorder = recorder_of(engine, path)
    fit.tell(contact(force=0.5))
    step(engine, recorder)
    for force in range(1, 60):
        fit.tell(contact(force=force))
    step(engine, recorder)
    told = ended(engine, recorder, path)
    assert told[-1].contacts["normal_force"].tolist() == [59.0]
    (event,) = [e for e in LiveRecording.open(path).events() if e["kind"] == "fit_missed"]
    assert event["answers"] > 0


def test_a_full_queue_leaves_answers_out_and_no_readings(
    engine: FakeEngine, fit: FakeFit, path: Path
) -> None:
    recorder = recorder_of(engine, path, queue_bytes=1 << 12)
    recorder._queue.take(0.0)
    recorder._queue.offer = lambda beside: False  # type: ignore[method-assign]
    fit.tell(contact(force=1.0))
    step(engine, recorder)
    del recorder._queue.offer
    assert recorder._drain.fit.missed == 1
    fit.tell(contact(force=2.0))
    step(engine, recorder)
    told = ended(engine, recorder, path)
    assert [each.contacts["normal_force"].tolist() for each in told] == [[2.0]]


def test_a_queue_keeps_half_of_its_room_for_readings() -> None:
    queue = Queue(1 << 12, RecorderState())

    def item(size: int) -> Item:
        return Item(1, size, lambda writer: None)

    assert [queue.offer(item(1000)) for _ in range(3)] == [True, True, False]
    assert queue.put(item(1500))
    assert not queue.put(item(2000))  # from here on readings are missing
    assert [each.size for each in queue.take(0.0)] == [1000, 1000, 1500]
    assert not queue.offer(item(1))


def test_wrong_numbers_in_the_ring_end_nothing(
    engine: FakeEngine, fit: FakeFit, path: Path
) -> None:
    recorder = recorder_of(engine, path)
    for wrong in (-1, 9, 1 << 30):
        fit.master.patches["contacts"] = wrong
        slot = fit.ring.begin()
        for name, array in slot.items():
            np.copyto(array, 255 if name == "forms" else 0)
        slot["patches"][:] = fit.master.patches.view(np.uint8)
        slot["patches"].view(fit.master.patches.dtype)["state"] = int(Fitted.DONE)
        fit.ring.publish()
        step(engine, recorder)
    fit.tell(contact(force=3.0), told_ns=1 << 62)  # a time that cannot be
    step(engine, recorder)
    told = ended(engine, recorder, path)
    assert [each.contacts["normal_force"].tolist() for each in told] == [[3.0]]
    assert told[0].time_ns <= time.time_ns()


@pytest.mark.parametrize("what", ["another layout", "no words", "cut"])
def test_a_ring_that_is_none_ends_nothing(engine: FakeEngine, path: Path, what: str) -> None:
    recorder, name = recorder_of(engine, path), fit_name(engine.ring.name)
    fields = [Field("patches", "<u1", (8,))]
    said = {"skinfield_fit": 2, "patches": ["arm"]} if what == "another layout" else {}
    with Ring.create(name, fields, fields, said, 4, 1 << 12) as ring:
        ring.begin()
        ring.publish()
        if what == "cut":
            file = Path("/dev/shm") / f"skinfield.{name}"
            if not file.exists():
                (file,) = Path("/dev/shm").glob(f"*{name}*")
            file.write_bytes(b"damaged" * 9)
        step(engine, recorder)
        assert ended(engine, recorder, path) == []
        ring.unlink()
