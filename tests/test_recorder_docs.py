"""The page's programs, run on a recording."""

import re
import uuid
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from recorder_ring import FakeEngine

from skinfield.acquisition import Blocks, Kind, Status
from skinfield.acquisition.block import PAYLOAD
from skinfield.live.recorder import Recorder
from skinfield.live.recorder_settings import RecorderSettings
from skinfield.live.recorder_state import forget_state

PAGE = Path(__file__).resolve().parent.parent / "docs" / "recorder.md"
PROGRAMS = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def nothing_more(blocks: Blocks, now_ns: int) -> None:
    """Counts alone."""


def of_all_kinds(blocks: Blocks, now_ns: int) -> None:
    """Blocks that hold no counts: who reads the bytes must know how long they are."""
    blocks.put_number(now_ns, 0, Kind.SOURCE, 1)
    blocks.put_number(now_ns, 0, Kind.LOST, 3)
    blocks.put_rows(now_ns, 0, Kind.CALIBRATION, np.ones((24, 6)))
    blocks.put_rows(now_ns, 0, Kind.TUNING, np.ones(9))
    blocks.put_rows(now_ns, 0, Kind.SMOOTHED, np.zeros(24, PAYLOAD[Kind.SMOOTHED]))
    blocks.put_rows(now_ns, 0, Kind.CONFIGURATION, np.full(13, 32, np.uint8))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    name = f"docs{uuid.uuid4().hex[:12]}"
    folder = tmp_path_factory.mktemp("docs")
    engine = FakeEngine(name)
    recorder = Recorder(RecorderSettings(name=name, path=folder / "touch.mcap"))
    for number in range(30):
        engine.cycle(extra=of_all_kinds if number == 7 else nothing_more)
    recorder.close()
    engine.close()
    forget_state(name)
    return folder, engine


def test_mcap_alone_is_enough(recorded, monkeypatch):
    folder, engine = recorded
    monkeypatch.chdir(folder)
    assert "skinfield" not in PROGRAMS[0].replace("/skin/", "")
    found: dict[str, object] = {}
    exec(compile(PROGRAMS[0], "recorder.md", "exec"), found)
    np.testing.assert_array_equal([values for _, _, values in found["readings"]], engine.counts)
    assert found["log"] == b"".join(engine.written)
    assert len(found["forces"]) == 30


def test_with_skinfield(recorded, monkeypatch):
    folder, engine = recorded
    monkeypatch.chdir(folder)
    found: dict[str, object] = {}
    exec(compile(PROGRAMS[1], "recorder.md", "exec"), found)
    np.testing.assert_array_equal(found["counts"].counts, engine.counts)
    assert found["step"].data == engine.written[-1]


def test_the_file_itself_says_what_kinds_of_blocks_there_are(recorded):
    with (recorded[0] / "touch.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    (text,) = [s.data.decode() for s in summary.schemas.values() if s.name == "skinfield.Blocks"]
    said, _, bits = text.partition("Kinds, and")[2].partition("Status bits:")
    assert all(re.search(rf"\b{int(kind)}[:,]", said) for kind in Kind)
    for status in (Status.NO_ACK, Status.NOT_CONNECTED, Status.OUT_OF_RANGE, Status.INVALID):
        assert f" {int(status)} " in bits
