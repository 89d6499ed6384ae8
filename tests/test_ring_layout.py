"""Layout of a ring's file, files that are none, any bytes, and several processes on one ring."""

import errno
import gc
import json
import os
import signal
import struct
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import fuzz_ring
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from ring_scenes import (
    LOG_BYTES,
    SLOT,
    SLOTS,
    bytes_of,
    go,
    numbers,
    own_name,
    reopened,
    worker,
    write,
)

from skinfield.errors import FileError, InputError
from skinfield.ring import Field, Ring, RingReader, State, files

FIELDS = (
    Field("stamp", "<i8"),
    Field("place", "f4", (3, 4)),
    Field("pressure", "<f8", (10,)),
    Field("valid", "?", (5,)),
)
STATUS = (Field("late", "u8", (6,)), Field("load", "f8"))
NAMES = [field.name for field in (*FIELDS, *STATUS)]


@pytest.fixture
def ring(tmp_path: Path) -> Iterator[Ring]:
    description = {"skin": "hexagon", "rate": 1000.0, "µ": [1, 2]}
    with Ring.create("one", FIELDS, STATUS, description, 4, 8192, folder=tmp_path) as ring:
        yield ring


def word(data: bytes, at: int) -> int:
    return struct.unpack_from("<Q", data, at)[0]


def test_header(ring: Ring) -> None:
    ring.heartbeat(123456789)
    ring.set_state(State.RUNNING)
    data = ring.path.read_bytes()
    assert data[:8] == b"SKINFLD\0"
    assert struct.unpack_from("<II", data, 8) == (1, 4096)
    assert word(data, 16) == len(data) == ring.path.stat().st_size
    assert (word(data, 32), word(data, 40)) == (4, 2)
    assert data[word(data, 48) :][: word(data, 56)] == json.dumps(ring.description).encode()
    assert word(data, 72) == 64  # of which 48 and 8 are used
    assert word(data, 96) == 4
    assert word(data, 88) == 64 + 64 + 128  # its own; stamp and place; pressure and valid
    assert word(data, 104) - word(data, 80) == 4096  # a page, of which slots need a quarter
    assert word(data, 112) == 8192
    assert [word(data, at) for at in (128, 192, 256, 264, 320)] == [0, 0, 0, 0, 123456789]
    assert struct.unpack_from("<III", data, 384) == (os.getpid(), 2, 1)
    assert ring.path.stat().st_mode & 0o777 == 0o600


def test_marks_are_the_first_ends_in_a_64th(ring: Ring) -> None:
    ends, end = {}, 0
    for size in (50, 100, 28, 128, 500, 1, 3000, 4000, 90, 700, 64, 64):
        before, end = end, ring.log(np.zeros(size, np.uint8))
        if end // 128 != before // 128:
            ends[end // 128] = end
    marks = struct.unpack_from("<64Q", ring.path.read_bytes(), 512)
    newest = {segment % 64: end for segment, end in ends.items()}
    assert {i: mark for i, mark in enumerate(marks) if mark} == newest


def test_large_arrays_begin_with_a_cache_line(ring: Ring) -> None:
    for _ in range(4):
        slot = ring.begin()
        assert slot["pressure"].ctypes.data % 64 == 0
        ring.publish()


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"slots": 1}, "slots is 1"),
        ({"log_bytes": 5000}, "power of two: take 8192"),
        ({"log_bytes": 2048}, "log_bytes is 2048"),
        ({"description": {"a": float("nan")}}, "finite"),
        ({"description": {"a": object()}}, "plain"),
        ({"name": "../etc"}, "name of a ring"),
        ({"name": ""}, "name of a ring"),
        ({"slot_fields": [Field("1st", "f8")]}, "a letter"),
        ({"slot_fields": [Field("a" * 48, "f8")]}, "at most 47"),
        ({"slot_fields": [Field("a", "f8"), Field("a", "f4")]}, "different names"),
        ({"slot_fields": [Field("a", ">f8")]}, "little-endian"),
        ({"slot_fields": [Field("a", "O")]}, "little-endian numbers"),
        ({"slot_fields": [Field("a", "f8,f8")]}, "little-endian numbers"),
        ({"slot_fields": [Field("a", "nonsense")]}, "a type and a shape"),
        ({"slot_fields": [Field("a", "f8", (-1,))]}, "up to 6 lengths"),
        ({"slot_fields": [Field("a", "f8", (1,) * 7)]}, "up to 6 lengths"),
        ({"slot_fields": [Field("a", "f8", (0, 1 << 40, 1 << 40))]}, "less than"),
        ({"slot_fields": [Field(f"a{i}", "f8") for i in range(1025)]}, "at most 1024"),
    ],
)
def test_arguments_that_cannot_be(changed: dict[str, object], said: str, tmp_path: Path) -> None:
    arguments = {"name": "one", "slot_fields": FIELDS, "folder": tmp_path} | changed
    with pytest.raises(InputError, match=said):
        Ring.create(**arguments)  # type: ignore[arg-type]
    assert not [*tmp_path.iterdir()]


def test_a_folder_without_room_is_said_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(descriptor: int, start: int, size: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(FileError, match="has no room: No space left"):
        Ring.create("one", FIELDS, folder=tmp_path)
    assert not [*tmp_path.iterdir()]


def test_reader_knows_fields_and_description(ring: Ring, tmp_path: Path) -> None:
    with RingReader("one", folder=tmp_path) as reader:
        assert reader.description == ring.description
        assert [field.name for field in reader.slot_fields + reader.status_fields] == NAMES
        assert reader.slot_fields[1] == Field("place", "<f4", (3, 4))
        assert reader.slot_fields[3].dtype == "|b1"
        assert (reader.slots, reader.log_bytes) == (4, 8192)


def test_names_tell_all_and_survive_what_is_no_ring(tmp_path: Path) -> None:
    assert Ring.names(tmp_path) == ()
    with Ring.create("good", SLOT, folder=tmp_path) as ring:
        write(ring)
        (found,) = Ring.names(tmp_path)
        assert (found.name, found.path, found.problem) == ("good", ring.path, "")
        assert (found.state, found.alive) == (State.STARTING, True)
        assert (found.number, found.generation) == (1, 1)
    (tmp_path / "skinfield.bad").write_bytes(b"nonsense")
    (tmp_path / "skinfield.none").write_bytes(b"")
    bad, good, none = Ring.names(tmp_path)
    assert (bad.name, bad.state, bad.alive) == ("bad", None, False)
    assert "is no ring" in bad.problem
    assert "cannot be mapped" in none.problem
    assert (good.state, good.alive, good.problem) == (State.STOPPED, False, "")
    for each in ("bad", "good", "none", "never"):
        Ring.remove(each, tmp_path)
    assert not [*tmp_path.iterdir()]


def test_what_remained_of_a_killed_maker_is_used_up(tmp_path: Path) -> None:
    rest = files.unfinished(tmp_path / "skinfield.one")
    rest.write_bytes(b"x" * 10_000)
    with Ring.create("one", SLOT, folder=tmp_path):
        assert [each.name for each in tmp_path.iterdir()] == ["skinfield.one"]
    rest.write_bytes(b"x")
    Ring.remove("one", tmp_path)
    assert not [*tmp_path.iterdir()]


def test_links_are_not_followed(tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.write_text("mine")
    (tmp_path / "skinfield.one").symlink_to(other)
    files.unfinished(tmp_path / "skinfield.two").symlink_to(other)
    for name in ("one", "two"):
        with pytest.raises(FileError):
            Ring.create(name, SLOT, folder=tmp_path)
    with pytest.raises(FileError, match="cannot be opened"):
        RingReader("one", folder=tmp_path)
    assert other.read_text() == "mine"


def test_a_ring_that_is_forgotten_is_free(tmp_path: Path) -> None:
    ring = Ring.create("one", SLOT, folder=tmp_path)
    slot = ring.begin()
    with RingReader("one", folder=tmp_path) as reader:
        assert reader.alive
        del ring
        gc.collect()
        assert not reader.alive
    assert slot["words"].sum() == 0  # its memory is not


CHANGES = st.tuples(
    st.integers(0, 0xFFFF),
    st.integers(0, 7),
    st.one_of(
        st.sampled_from([0, 1, 63, 64, 1 << 12, 1 << 31, 1 << 32, (1 << 63) - 1, (1 << 64) - 1]),
        st.integers(0, (1 << 64) - 1),
        st.integers(0, 1 << 16),
    ),
)
HEADER = st.tuples(st.integers(0, 15).map(lambda i: 8 * i), st.just(0), st.integers(0, 1 << 15))


def octets(change: tuple[int, int, int]) -> bytes:
    place, part, word = change
    return place.to_bytes(2, "little") + bytes([part]) + word.to_bytes(8, "little")


@settings(max_examples=400)
@given(st.lists(st.one_of(CHANGES, HEADER), max_size=6))
@example([(0xFFFF, 0, 4096)])
@example([(0, 6, 1 << 40)])  # a head that nothing bears out
@example([(128, 6, 1 << 63), (136, 6, (1 << 64) - 1)])  # a log that has no end
def test_changed_files(changes: list[tuple[int, int, int]]) -> None:
    fuzz_ring.read(fuzz_ring.changed(b"".join(map(octets, changes))))


@given(st.binary(max_size=9000))
def test_any_bytes(data: bytes) -> None:
    fuzz_ring.one_input(data)


def test_the_sample_itself_is_read(tmp_path: Path) -> None:
    (tmp_path / "skinfield.whole").write_bytes(fuzz_ring.GOOD)
    with RingReader("whole", folder=tmp_path) as reader:
        fuzz_ring.look(reader)
        assert reader.latest()["words"].tolist() == [[7, 7]] * 3


COUNT = 40_000


@pytest.fixture
def name() -> Iterator[str]:
    """Of a ring that was made and is waiting for a writer."""
    with own_name() as name:
        Ring.create(name, SLOT, slots=SLOTS, log_bytes=LOG_BYTES).close()
        yield name


def test_readers_at_full_speed_see_nothing_torn(name: str) -> None:
    reading = ("read", name, COUNT)
    with (
        worker("write", name, COUNT) as writer,
        worker(*reading) as first,
        worker(*reading) as second,
        worker(*reading) as victim,
    ):
        everyone = (writer, first, second, victim)
        assert [each.stdout.readline() for each in everyone] == ["ready\n"] * 4
        with RingReader(name) as reader:
            go(writer)
            while reader.wait(0, 60) < COUNT // 10:
                assert reader.alive
        victim.send_signal(signal.SIGKILL)
        assert victim.wait(60) == -signal.SIGKILL
        assert writer.stdout.readline() == "done\n"  # all of them, though nobody waited
        results = [json.loads(each.stdout.readline()) for each in (first, second)]
    for result in results:
        assert result["torn"] == 0
        assert result["newest"] == COUNT
        assert result["whole"] > 0
        assert result["log"] + result["lost"] > 0
    assert sum(result["whole"] + result["overtaken"] for result in results) > 1000


@pytest.mark.parametrize("where", [0, 1], ids=["slot", "log"])
def test_what_a_killed_writer_left_half_done_is_never_seen(name: str, where: int) -> None:
    ring = reopened(name)
    write(ring, 10)
    ring.log(bytes_of(b"whole"))
    ring.close()
    with RingReader(name) as reader, worker("stop", name, where) as writer:
        log = reader.log_reader(0)
        assert [writer.stdout.readline() for _ in range(2)] == ["ready\n", "half\n"]
        assert (reader.alive, reader.pid) == (True, writer.pid)
        with pytest.raises(InputError, match=f"living process .process {writer.pid}"):
            reopened(name)
        before = numbers(reader)
        assert before == ([8, 9, 10] if where == 0 else [7, 8, 9, 10])
        writer.send_signal(signal.SIGKILL)
        writer.wait(60)
        assert not reader.alive
        assert numbers(reader) == before
        (found,) = (each for each in Ring.names() if each.name == name)
        assert (found.alive, found.pid, found.state) == (False, writer.pid, State.STARTING)
        with reopened(name) as ring:
            assert (ring.number, ring.generation, ring.log_end) == (10, 4, 5)
            assert numbers(reader) == before
            write(ring)
            ring.log(bytes_of(b"on"))
            assert numbers(reader) == [8, 9, 10, 11]
            assert log.read() == (b"wholeon", 0)
            assert reader.latest().generation == ring.generation == reader.generation


def test_a_writer_killed_anywhere_leaves_a_good_ring(name: str) -> None:
    with RingReader(name) as reader:
        for _ in range(2):
            newest = reader.number
            with worker("write", name, 10**9) as writer:
                writer.stdout.readline()
                go(writer)
                while reader.wait(newest, 60) < newest + 1000:
                    assert reader.alive
                writer.send_signal(signal.SIGKILL)
                writer.wait(60)
            newest = reader.number
            assert set(numbers(reader)[-3:]) >= {newest - 1, newest}
            log = reader.log_reader(reader.log_end)
            with reopened(name) as ring:
                assert ring.number == newest
                write(ring, 2 * SLOTS)
                ring.log(bytes_of(b"12345678"))
            assert numbers(reader) == list(range(newest + SLOTS + 1, newest + 2 * SLOTS + 1))
            assert log.read() == (b"12345678", 0)


def test_a_reader_cannot_write_even_past_python(name: str) -> None:
    with worker("scribble", name) as process:
        assert process.communicate(timeout=300)[0] == "ready\n"
        assert process.returncode == -signal.SIGSEGV


def test_a_child_that_outlives_the_writer_is_no_writer(name: str) -> None:
    with worker("fork", name) as writer, RingReader(name) as reader:
        assert writer.stdout.readline() == "ready\n"
        child = int(writer.stdout.readline())
        try:
            assert reader.alive
            writer.kill()
            writer.wait(60)
            assert not reader.alive
            reopened(name).close()
        finally:
            os.kill(child, signal.SIGKILL)


def test_of_many_makers_one_wins() -> None:
    with own_name() as name, ExitStack() as stack:
        makers = [stack.enter_context(worker("create", name)) for _ in range(3)]
        assert [each.stdout.readline() for each in makers] == ["ready\n"] * 3
        for each in makers:
            go(each)
        said = [each.stdout.readline() for each in makers]
        assert sorted(said) == ["refused\n"] * 2 + ["won\n"]
        with RingReader(name) as reader:
            assert reader.pid == makers[said.index("won\n")].pid
        stack.close()  # before the ring is removed
