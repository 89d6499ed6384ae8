"""Which rings there are, and files that are none."""

import gc
from pathlib import Path

import pytest
from ring_scenes import SLOT, write

from skinfield.errors import FileError
from skinfield.ring import Ring, RingReader, State, files


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
