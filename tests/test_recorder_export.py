"""Exports and channels of recordings for other programs, read back by those; the page runs."""

import contextlib
import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import refused, result_of, run
from fit_rings import FakeFit, contact
from mcap.reader import make_reader
from pyarrow import parquet
from recorder_ring import FakeEngine, record, recorder_of

from skinfield.files import open_recording, readings_for
from skinfield.signal import Blocks, Kind, Status

CYCLES = 60


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("export") / "a.mcap"
    with FakeEngine() as engine:
        record(engine, path, CYCLES, every=5)
    return path, np.array(engine.counts), engine.skin


@pytest.fixture(scope="module", name="fitted")
def _fitted(tmp_path_factory):
    """With a fit beside the engine: 1 N, then that and 2 N on another place, then nothing."""
    path = tmp_path_factory.mktemp("export") / "fit.mcap"
    with FakeEngine() as engine, FakeFit(engine.ring.name) as fit:
        recorder = recorder_of(engine, path)
        for number, forces in enumerate([(1.0,), (1.0, 2.0), ()]):
            engine.cycle()
            rows = [contact(0.01 * k, force=force, track=k + 3) for k, force in enumerate(forces)]
            fit.tell(*rows, stamp_ns=10 + number, pressure=[5.0])
            recorder.step()
        recorder.close()
    return path


def test_parquet(recorded, tmp_path):
    path, counts, skin = recorded
    run("export", path, "-o", tmp_path / "a.parquet")
    table = parquet.read_table(tmp_path / "a.parquet")
    assert table.column_names == ["stamp_ns", *(f"uid_{uid}" for uid in skin[0].uid)]
    values = np.array([table[name].to_numpy() for name in table.column_names[1:]]).T
    np.testing.assert_array_equal(values, counts)
    contacts = parquet.read_table(tmp_path / "a.contacts.parquet")
    expected = np.repeat(np.arange(CYCLES), np.arange(CYCLES) % 3)
    np.testing.assert_array_equal(contacts["track"].to_numpy(), expected)
    cycles = parquet.read_table(tmp_path / "a.cycles.parquet")
    np.testing.assert_array_equal(cycles["contacts"].to_numpy(), np.arange(CYCLES) % 3)
    np.testing.assert_array_equal(cycles["cycle"].to_numpy(), np.arange(1, CYCLES + 1))
    answers = parquet.read_table(tmp_path / "a.patch_cycles.parquet")
    np.testing.assert_array_equal(answers["cycle"].to_numpy(), np.arange(1, CYCLES + 1))
    np.testing.assert_array_equal(answers["force"].to_numpy(), np.arange(CYCLES))
    happened = json.loads((tmp_path / "a.events.json").read_text())
    kinds = ["recording_started", "settings", "recording_ended"]
    assert [each["kind"] for each in happened["events"]] == kinds
    assert happened["timing"][-1]["cycles"] >= 0


def test_csv(recorded, tmp_path):
    path, counts, skin = recorded
    run("export", path, "-o", tmp_path / "a.csv")
    lines = [line for line in (tmp_path / "a.csv").open() if not line.startswith("#")]
    rows = list(csv.reader(lines))
    np.testing.assert_array_equal(np.array(rows[1:], float)[:, 1:], counts)
    again = readings_for(open_recording(tmp_path / "a.csv"), skin[0])
    np.testing.assert_array_equal(again.counts, counts)
    assert again.unit == "count"
    with (tmp_path / "a.contacts.csv").open() as file:
        lines = [line for line in file if not line.startswith("#")]
    assert [row["cycle"] for row in csv.DictReader(lines)][:3] == ["2", "3", "3"]


def test_contacts_of_a_fit(fitted, tmp_path):
    run("export", fitted, "-o", tmp_path / "a.csv")
    with (tmp_path / "a.fit_contacts.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    table = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    assert table["normal_force"].tolist() == [1.0, 1.0, 2.0]
    assert table["track"].tolist() == [3, 3, 4]
    assert table["stamp_ns"].tolist() == [10, 11, 11]
    assert table["radius"].tolist() == [5e-3] * 3
    assert (np.diff(table["wall_ns"]) >= 0).all()


def test_a_bag_has_the_engines_own(fitted, tmp_path):
    run("export", fitted, "--format", "rosbag2", "-o", tmp_path / "bag")
    assert (tmp_path / "bag" / "metadata.yaml").exists()
    assert result_of("info", fitted)["fit"]["answers"] == 3


def test_what_cannot_be(recorded, tmp_path):
    path, _, _ = recorded
    for words in (
        ("export", path, "-o", tmp_path / "a.xls"),
        ("export", path, "-o", tmp_path / "a.csv", "--patch", "leg"),
        ("export", tmp_path / "no.mcap", "-o", tmp_path / "a.csv"),
    ):
        assert "expected" in refused(*words)
    assert list(tmp_path.iterdir()) == []


def test_info(recorded):
    path, _, _ = recorded
    said = result_of("info", path)
    assert said["finished"]
    assert said["cycles"] == CYCLES
    assert said["late"] == CYCLES // 10
    assert said["fields"]["messages"] >= 1
    assert [each["cycle"] for each in said["settings"]] == [2]
    assert said["patches"][0]["readings"] == CYCLES
    assert said["contacts"] == {"cycles": 40, "most_at_once": 2, "tracks": 40}
    assert said["readings"]["missing_bytes"] == 0
    assert set(said["lost"].values()) == {0}
    text = run("info", path)
    assert "40 tracks in 40 cycles, at most 2 at once" in text


def test_reconstruct_takes_it(recorded, tmp_path):
    """Its layout, calibration and settings are enclosed; flags come before them."""
    path, contacts, summary = recorded[0], tmp_path / "contacts.csv", tmp_path / "s.json"
    words = ("--grid", "8", "-o", contacts, "--summary", summary, "--modulus-kpa", "90")
    run("reconstruct", path, *words)
    assert contacts.exists()
    made = json.loads(summary.read_text())
    assert "thickness=0.003, young_modulus=90000.0" in made["layer"]
    assert "gain not given" not in " ".join(made["notes"])  # as it is without a calibration


PAGE = Path(__file__).resolve().parent.parent / "docs" / "recorder.md"
PROGRAMS = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def of_all_kinds(blocks: Blocks, now_ns: int) -> None:
    """Blocks that hold no counts: who reads the bytes must know how long they are."""
    blocks.put_number(now_ns, 0, Kind.SOURCE, 1)
    blocks.put_number(now_ns, 0, Kind.LOST, 3)


@pytest.fixture(scope="module")
def docs_recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("docs")
    with FakeEngine() as engine:
        recorder = recorder_of(engine, folder / "touch.mcap")
        for number in range(30):
            engine.cycle(**({"extra": of_all_kinds} if number == 7 else {}))
        recorder.close()
    return folder, engine


def made_by(program: int, folder: Path) -> dict[str, Any]:
    """What a program of the page makes where the recording lies."""
    made: dict[str, Any] = {}
    with contextlib.chdir(folder):
        exec(compile(PROGRAMS[program], "recorder.md", "exec"), made)
    return made


def test_mcap_alone_is_enough(docs_recording):
    folder, engine = docs_recording
    assert "skinfield" not in PROGRAMS[0].replace("/skin/", "")
    found = made_by(0, folder)
    np.testing.assert_array_equal([values for _, _, values in found["readings"]], engine.counts)
    assert found["log"] == b"".join(engine.written)
    assert len(found["forces"]) == 30


def test_with_skinfield(docs_recording):
    folder, engine = docs_recording
    found = made_by(1, folder)
    np.testing.assert_array_equal(found["counts"].counts, engine.counts)
    assert found["cycle"].number == 30
    assert found["field"].sides.tolist() == [4]


def test_the_file_itself_says_what_kinds_of_blocks_there_are(docs_recording):
    with (docs_recording[0] / "touch.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    (text,) = [s.data.decode() for s in summary.schemas.values() if s.name == "skinfield.Blocks"]
    said, _, bits = text.partition("Kinds, and")[2].partition("Status bits:")
    assert all(re.search(rf"\b{int(kind)}[:,]", said) for kind in Kind)
    for status in (Status.NO_ACK, Status.NOT_CONNECTED, Status.OUT_OF_RANGE, Status.INVALID):
        assert f" {int(status)} " in bits
