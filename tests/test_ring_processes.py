"""Several processes on one ring: nothing is torn, and nobody's death harms the others."""

import json
import os
import signal
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
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

from skinfield.errors import InputError
from skinfield.ring import Ring, RingReader, State

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
        assert process.communicate(timeout=60)[0] == "ready\n"
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
