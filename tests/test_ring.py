"""One writer and its readers in one process: slots, the log, fences and waking."""

import platform
import sys
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ring_scenes import SLOT, SLOTS, bytes_of, numbers, own_name, write

from skinfield.errors import FileError, InputError
from skinfield.ring import Field, Ring, RingReader, State, system

STATUS = (Field("late", "u8", (3,)),)
SIZE = 4096  # bytes of the log
SHAPE = {"slots": SLOTS, "log_bytes": SIZE}


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


# What is appended to the log, one piece after the other
TEXT = np.random.default_rng(3).integers(0, 256, 1 << 20, dtype=np.uint8)


def append(ring: Ring, count: int) -> int:
    return ring.log(TEXT[ring.log_end :], count)


@given(
    steps=st.lists(
        st.one_of(
            st.tuples(st.just("append"), st.integers(0, SIZE)),
            st.tuples(st.just("append"), st.integers(0, 100)),
            st.tuples(st.just("read"), st.one_of(st.none(), st.integers(1, 2 * SIZE))),
        ),
        max_size=60,
    )
)
def test_whatever_is_read_was_appended(steps: list[tuple[str, int | None]]) -> None:
    with (
        own_name() as name,
        Ring.create(name, SLOT, log_bytes=SIZE) as ring,
        RingReader(name) as reader,
    ):
        log, ends, longest = reader.log_reader(), {0}, 0
        for what, count in [*steps, *[("read", 500)] * 20]:
            if what == "append":
                ends.add(append(ring, count))
                longest = max(longest, count)
                continue
            position, end = log.position, ring.log_end
            data, lost = log.read(count)
            assert (lost > 0) == (end - position > SIZE)
            start, stop = position + lost, position + lost + len(data)
            assert stop == log.position
            assert {start, stop} <= ends
            assert data == TEXT[start:stop].tobytes()
            assert stop > start or start == end
            assert len(data) <= (SIZE if count is None else max(count, longest + SIZE // 32))
        assert log.position == ring.log_end
        assert log.read() == (b"", 0)


def test_reading_begins_now_or_where_asked(ring: Ring, reader: RingReader) -> None:
    append(ring, 100)
    write(ring)
    append(ring, 50)
    behind = reader.latest().log_end
    assert reader.log_reader().read() == (b"", 0)
    assert reader.log_reader(behind).read() == (TEXT[100:150].tobytes(), 0)
    assert reader.log_reader(0).read() == (TEXT[:150].tobytes(), 0)
    for wrong in (-1, 151, 1.5):
        with pytest.raises(InputError, match="where a batch ended"):
            reader.log_reader(wrong)


def test_slow_reader_loses_the_oldest_and_is_told(ring: Ring, reader: RingReader) -> None:
    log, quick = reader.log_reader(), reader.log_reader()
    while ring.log_end <= SIZE:
        append(ring, 40)
        quick.read()
    data, lost = log.read()
    assert (lost + len(data), quick.lost) == (ring.log_end, 0)
    assert 0 < lost <= SIZE // 4 + 2 * SIZE // 64  # the newest three quarters are there still
    assert lost % 40 == 0
    assert data == TEXT[lost : lost + len(data)].tobytes()
    assert log.lost == lost
    append(ring, 40)
    assert log.read() == (TEXT[ring.log_end - 40 : ring.log_end].tobytes(), 0)


def test_overtaken_while_copying(ring: Ring, reader: RingReader) -> None:
    """The fence of other machines is called after the copy too: there the writer comes round."""
    append(ring, SIZE)
    log, calls = reader.log_reader(0), []

    def overtake() -> None:
        calls.append(1)
        if len(calls) == 2:  # 1: between end and copy; 2: between copy and check
            append(ring, 64)

    log._fence = overtake
    data, lost = log.read()
    assert lost > 0
    assert data == TEXT[lost : lost + len(data)].tobytes()
    assert lost + len(data) == ring.log_end
    log._fence = lambda: append(ring, SIZE)  # every time
    assert log.read()[0] == b""
    assert log.position == ring.log_end - SIZE  # once more behind, but not further
    assert log.lost == log.position - len(data)


def test_a_batch_that_is_being_written_counts_as_written(ring: Ring, reader: RingReader) -> None:
    append(ring, SIZE)
    log = reader.log_reader(0)
    ring._words[33] = SIZE + 8  # log reserved, as `Log.append` does before it copies
    data, lost = log.read()
    assert lost > 0
    assert lost + len(data) == SIZE
    ring._words[33] = SIZE


def test_a_dead_writers_batch_is_written_over(ring: Ring, reader: RingReader) -> None:
    append(ring, 1000)
    ring._words[33] = 1000 + 3500  # died while it copied 3500 bytes
    ring._log._octets[1000:] = 66
    ring.close()
    log = reader.log_reader(0)
    with Ring.reopen(ring.name, SLOT, STATUS, **SHAPE) as again:
        data, lost = log.read()  # what those bytes would have taken the place of is lost
        assert (data, lost) == (b"", 1000)
        append(again, 200)
        assert log.read() == (TEXT[1000:1200].tobytes(), 0)
        assert again.log_end == reader.log_end == 1200


def test_batches_that_do_not_fit_change_nothing(ring: Ring, reader: RingReader) -> None:
    assert append(ring, 0) == 0
    for count in (SIZE + 1, -1):
        with pytest.raises(InputError, match=f"count is {count}, expected 0 to 4096"):
            append(ring, count)
    with pytest.raises(InputError, match="expected 0 to 3 bytes"):
        ring.log(bytes_of(b"abc"), 4)
    assert reader.log_reader(0).read() == (b"", 0)
    assert ring.log(TEXT[:SIZE]) == SIZE
    assert reader.log_reader(0).read() == (TEXT[:SIZE].tobytes(), 0)


def test_x86_needs_no_fence_and_others_do(monkeypatch: pytest.MonkeyPatch) -> None:
    for machine, needed in {"x86_64": False, "AMD64": False, "aarch64": True, "": True}.items():
        monkeypatch.setattr(platform, "machine", lambda machine=machine: machine)
        assert system.needs_fence() == needed
    monkeypatch.setattr(platform, "machine", lambda: "x86_64")
    assert system.fence() is None
    monkeypatch.setattr(platform, "machine", lambda: "m68k")
    assert system.fence_of_kernel() is None
    assert isinstance(system.signal(0), system.Polling)


def test_a_ring_works_with_a_fence(monkeypatch: pytest.MonkeyPatch) -> None:
    fence = system.fence_of_kernel()
    if fence is None:
        pytest.skip("no fence on this machine")
    assert fence() == 0
    calls: list[object] = []
    monkeypatch.setattr(system, "fence", lambda: lambda: calls.append(fence()))
    with own_name() as name, Ring.create(name, SLOT, slots=4) as ring, RingReader(name) as reader:
        for newest in range(1, 10):
            write(ring)
            assert numbers(reader)[-1] == newest
    assert len(calls) > 9 * 4


def test_without_any_fence_it_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "needs_fence", lambda: True)
    monkeypatch.setattr(system, "fence_of_kernel", lambda: None)
    with pytest.raises(InputError, match="membarrier"):
        system.fence()
    monkeypatch.setattr(sys, "byteorder", "big")
    with pytest.raises(InputError, match="little-endian"):
        system.fence()


@pytest.mark.parametrize("polling", [False, True])
def test_who_waits_is_woken(polling: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if polling:
        monkeypatch.setattr(system, "machine", lambda: "")
    elif not system.FUTEX.get(system.machine()):
        pytest.skip("no futex on this machine")
    woken: list[int] = []
    with own_name() as name, Ring.create(name, SLOT) as ring, RingReader(name) as reader:
        assert isinstance(ring._signal, system.Polling) == polling
        threads = [
            threading.Thread(target=lambda: woken.append(reader.wait(0, 60))) for _ in range(2)
        ]
        for thread in threads:
            thread.start()
        time.sleep(0.02)
        write(ring)
        for thread in threads:
            thread.join(60)
    assert woken == [1, 1]


def test_futex_refuses_nonsense(monkeypatch: pytest.MonkeyPatch) -> None:
    if not system.FUTEX.get(system.machine()):
        pytest.skip("no futex on this machine")
    with pytest.raises(InputError, match="failed with E"):
        system.signal(1).wait(0, 0.001)  # no word lies at address 1
