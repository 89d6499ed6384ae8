"""One writer and its readers in one process; several processes are in test_ring_processes."""

import threading
from collections.abc import Iterator

import pytest
from ring_scenes import SLOT, SLOTS, bytes_of, numbers, own_name, write

from skinfield.errors import FileError, InputError
from skinfield.ring import Field, Ring, RingReader, State

STATUS = (Field("late", "u8", (3,)),)
SHAPE = {"slots": SLOTS, "log_bytes": 4096}


@pytest.fixture
def name() -> Iterator[str]:
    with own_name() as name:
        yield name


@pytest.fixture
def ring(name: str) -> Iterator[Ring]:
    with Ring.create(name, SLOT, STATUS, **SHAPE) as ring:
        yield ring


@pytest.fixture
def reader(ring: Ring) -> Iterator[RingReader]:
    with RingReader(ring.name) as reader:
        yield reader


def test_readers_see_the_last_slots_and_no_others(ring: Ring, reader: RingReader) -> None:
    assert reader.latest() is None
    assert numbers(reader) == []
    for newest in range(1, 3 * SLOTS):
        write(ring)
        assert reader.number == newest
        assert numbers(reader) == list(range(max(1, newest - SLOTS + 1), newest + 1))
        assert reader.latest().number == newest
    ring.begin()["words"][:] = 1  # takes the place of the oldest
    assert numbers(reader) == list(range(newest - SLOTS + 2, newest + 1))
    assert reader.get(0) is reader.get(-1) is reader.get(newest + 1) is None


def test_a_copy_is_a_copy(ring: Ring, reader: RingReader) -> None:
    slot = reader.slot()
    write(ring)
    first = reader.latest()
    assert reader.latest(slot) is slot
    write(ring, SLOTS)
    assert first["words"][0] == slot["words"][0] == 1
    assert reader.get(2, slot) is slot
    assert slot["words"][0] == slot.number == 2
    assert [*slot] == ["number", "words"]
    assert slot["words"].ctypes.data % 64 == 0


def test_begin_gives_the_same_memory_again_and_again(ring: Ring) -> None:
    seen = []
    for _ in range(2 * SLOTS):
        seen.append(ring.begin())
        assert ring.begin() is seen[-1]  # a cycle that gave up begins anew
        assert ring.publish() == ring.number == len(seen)
    assert all(seen[i] is seen[i + SLOTS] for i in range(SLOTS))
    with pytest.raises(InputError, match="begin"):
        ring.publish()


def test_a_slot_that_changes_while_it_is_copied_is_not_given(
    ring: Ring, reader: RingReader
) -> None:
    """The fence of other machines is called after the copy too: there the writer comes round."""
    write(ring)
    calls = []

    def overtake() -> None:
        calls.append(1)
        if len(calls) == 2:  # 1: between lock and copy; 2: between copy and lock
            write(ring, SLOTS)

    reader._fence = overtake
    slot = reader.slot()
    assert reader.get(1, slot) is None
    assert slot.number == 0
    assert len(calls) == 2
    calls.clear()
    assert reader.latest().number == 2 * SLOTS + 1  # tries again


def test_latest_gives_up_when_every_try_is_overtaken(ring: Ring, reader: RingReader) -> None:
    write(ring)
    reader._fence = lambda: write(ring, SLOTS)
    with pytest.raises(InputError, match="more slots or a slower writer"):
        reader.latest()


def test_status_state_and_heartbeat(ring: Ring, reader: RingReader) -> None:
    copy = reader.status["late"]
    ring.status["late"][:] = (1, 2, 3)
    assert copy.tolist() == [0, 0, 0]
    assert reader.status["late"].tolist() == reader.status_view["late"].tolist() == [1, 2, 3]
    with pytest.raises(ValueError, match="read-only"):
        reader.status_view["late"][0] = 1
    assert reader.state == ring.state == State.STARTING
    ring.set_state(State.RUNNING)
    assert reader.state == ring.state == State.RUNNING
    assert reader.heartbeat_ns > 0  # from the beginning
    ring.heartbeat(77)
    assert reader.heartbeat_ns == 77
    assert reader.alive
    assert reader.pid > 0


@pytest.mark.parametrize(
    ("error", "state"),
    [(None, State.STOPPED), (ValueError, State.FAILED), (KeyboardInterrupt, State.STOPPED)],
)
def test_how_it_ended_is_said(name: str, error: type[BaseException], state: State) -> None:
    ring = Ring.create(name, SLOT)
    with RingReader(name) as reader:
        ring.__exit__(error, None, None)
        assert reader.state == state
        assert not reader.alive


def test_waiting_ends_with_a_slot_a_state_or_in_time(ring: Ring, reader: RingReader) -> None:
    assert reader.wait(0, 0) == 0
    assert reader.wait(0, 0.01) == 0
    for seen, what in ((0, lambda: write(ring)), (1, lambda: ring.set_state(State.STOPPED))):
        thread = threading.Timer(0.05, what)
        thread.start()
        assert reader.wait(seen, 60) == 1
        thread.join()
    assert reader.wait(0, 60) == 1  # at once: it is there
    for wrong in (-1, float("nan")):
        with pytest.raises(InputError, match="timeout"):
            reader.wait(0, wrong)


def test_one_writer_at_a_time(ring: Ring) -> None:
    for another in (Ring.create, Ring.reopen):
        with pytest.raises(InputError, match="written by a living process"):
            another(ring.name, SLOT, STATUS, **SHAPE)
    with pytest.raises(InputError, match="stop that one first"):
        Ring.remove(ring.name)
    assert write(ring) == 1


def test_create_takes_the_place_of_a_dead_ring(ring: Ring, reader: RingReader) -> None:
    write(ring)
    ring.close()
    assert not reader.replaced()
    with Ring.create(ring.name, SLOT) as other:
        assert reader.replaced()
        assert (other.number, other.generation) == (0, 1)
        assert reader.latest().number == 1  # of the old file
        with RingReader(ring.name) as new:
            assert new.latest() is None


def test_unlink_leaves_who_has_it_open(ring: Ring, reader: RingReader) -> None:
    ring.unlink()
    assert reader.replaced()
    write(ring)
    assert reader.latest().number == 1
    with pytest.raises(FileError, match="expected a ring: is its engine running"):
        RingReader(ring.name)
    with Ring.create(ring.name, SLOT):
        ring.unlink()  # not that of the other
        assert RingReader(ring.name).alive


def test_reopen_goes_on(ring: Ring, reader: RingReader) -> None:
    log = reader.log_reader()
    write(ring, 6)
    ring.status["late"][:] = 9
    ring.log(bytes_of(b"first"))
    ring.close()
    ring.close()
    with Ring.reopen(ring.name, SLOT, STATUS, **SHAPE) as again:
        assert (again.number, again.generation, again.log_end) == (6, 2, 5)
        assert again.status["late"].tolist() == [9, 9, 9]
        again.log(bytes_of(b"second"))
        assert write(again) == 7
        assert numbers(reader) == [4, 5, 6, 7]
        assert log.read() == (b"firstsecond", 0)
        slot = reader.latest()
        assert (slot.generation, slot.log_end, reader.generation) == (2, 11, 2)
        assert not reader.replaced()


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"slots": 8}, "8 slots asked for, it has 4"),
        ({"log_bytes": 8192}, "bytes of the log"),
        ({"slot_fields": SLOT[:1]}, "asked for, it has"),
        ({"slot_fields": SLOT[::-1]}, "asked for, it has"),
        ({"status_fields": (Field("late", "i8", (3,)),)}, "'late'.*asked for"),
    ],
)
def test_reopen_wants_the_same_layout(ring: Ring, changed: dict[str, object], said: str) -> None:
    same = {"slot_fields": SLOT, "status_fields": STATUS, **SHAPE}
    ring.close()
    with pytest.raises(InputError, match=said) as problem:
        Ring.reopen(ring.name, **same | changed)  # type: ignore[arg-type]
    assert "Ring.create" in str(problem.value)
    Ring.reopen(ring.name, **same).close()  # type: ignore[arg-type]  # nothing holds it


@pytest.mark.parametrize("step", ["lock", "head"])
def test_reopen_after_death_within_publish(ring: Ring, reader: RingReader, step: str) -> None:
    """Killed between its stores: the lock said complete, but the head did not; or the futex not."""
    write(ring, 5)
    index = ring._locks[6 % SLOTS]
    slot = ring.begin()
    slot["number"][...] = slot["words"][:] = 6
    ring._words[index] = 14
    if step == "head":
        ring._words[16] = 6
    ring._begun = False
    ring.close()
    newest = 5 if step == "lock" else 6
    assert reader.number == newest
    assert reader.get(newest + 1) is None
    with Ring.reopen(ring.name, SLOT, STATUS, **SHAPE) as again:
        assert again.number == newest
        assert reader.wait(0, 60) == newest
        assert write(again) == newest + 1
        assert numbers(reader)[-1] == newest + 1


def test_arrays_of_a_closed_ring_stay_readable(name: str) -> None:
    ring = Ring.create(name, SLOT)
    slot = ring.begin()
    slot["words"][:] = 3
    ring.publish()
    ring.close()
    assert slot["words"].sum() == 3 * len(slot["words"])
    Ring.create(name, SLOT).close()  # and the lock is free
    with pytest.raises(ValueError, match="released"):
        ring.begin()
