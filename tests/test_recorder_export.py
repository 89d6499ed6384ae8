"""Exports and channels of recordings for other programs, read back by those; the page runs."""

import csv
import json
import re
from contextlib import contextmanager
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest
from command_line import refused, result_of, run
from mcap.reader import make_reader
from pyarrow import parquet
from recorder_ring import FakeEngine, recorder_of
from test_readme import doc

from skinfield.files import LiveRecording, open_recording, readings_for
from skinfield.signal import Blocks, Kind, Status

CYCLES = 60


@contextmanager
def recording(factory, file: str):
    """An engine, what records it, and the file."""
    path = factory.mktemp("export") / file
    with FakeEngine() as engine:
        recorder = recorder_of(engine, path)
        yield engine, recorder, path
        recorder.close()


def of_all_kinds(blocks: Blocks, now_ns: int) -> None:
    """Blocks that hold no counts: who reads the bytes must know how long they are."""
    blocks.put_number(now_ns, 0, Kind.SOURCE, 1)
    blocks.put_number(now_ns, 0, Kind.LOST, 3)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    with recording(tmp_path_factory, "touch.mcap") as (engine, recorder, path):
        for number in range(CYCLES):
            engine.cycle(**({"extra": of_all_kinds} if number == 7 else {}))
            if number % 5 == 0:
                recorder.step()
    return path, np.array(engine.counts), engine


def test_parquet(recorded, tmp_path):
    path, counts, engine = recorded
    run("export", path, "-o", tmp_path / "a.parquet")
    table = parquet.read_table(tmp_path / "a.parquet")
    assert table.column_names == ["stamp_ns", *(f"uid_{uid}" for uid in engine.skin[0].uid)]
    values = np.array([table[name].to_numpy() for name in table.column_names[1:]]).T
    np.testing.assert_array_equal(values, counts)
    cycles = np.arange(CYCLES)
    for name, columns in {
        "contacts": {"track": np.repeat(cycles, cycles % 3)},
        "cycles": {"contacts": cycles % 3, "cycle": cycles + 1},
        "patch_cycles": {"cycle": cycles + 1, "force": cycles},
    }.items():
        table = parquet.read_table(tmp_path / f"a.{name}.parquet")
        for column, expected in columns.items():
            np.testing.assert_array_equal(table[column].to_numpy(), expected)
    happened = json.loads((tmp_path / "a.events.json").read_text())
    kinds = ["recording_started", "settings", "source_up", "messages_lost", "recording_ended"]
    assert sorted(each["kind"] for each in happened["events"]) == sorted(kinds)
    assert happened["timing"][-1]["cycles"] >= 0


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def test_csv(recorded, tmp_path):
    path, counts, engine = recorded
    run("export", path, "-o", tmp_path / "a.csv")
    values = [list(row.values())[1:] for row in rows_of(tmp_path / "a.csv")]
    np.testing.assert_array_equal(np.array(values, float), counts)
    again = readings_for(open_recording(tmp_path / "a.csv"), engine.skin[0])
    np.testing.assert_array_equal(again.counts, counts)
    assert again.unit == "count"
    assert "# forces = relative\n" in (tmp_path / "a.contacts.csv").read_text()
    rows = rows_of(tmp_path / "a.contacts.csv")
    assert [row["cycle"] for row in rows][:3] == ["2", "3", "3"]
    assert [rows[0][name] for name in ("shape", "maybe", "radius")] == ["1", "1", "0.004"]


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
    assert (said["finished"], said["cycles"], said["late"]) == (True, CYCLES, CYCLES // 10)
    assert said["fields"]["messages"] >= 1
    assert [each["cycle"] for each in said["settings"]] == [2]
    assert said["patches"][0]["readings"] == CYCLES
    assert said["contacts"] == {"cycles": 40, "most_at_once": 2, "tracks": 40}
    assert said["readings"]["missing_bytes"] == 0
    assert {name: count for name, count in said["lost"].items() if count} == {"messages": 3}
    assert "40 tracks in 40 cycles, at most 2 at once" in run("info", path)


def test_reconstruct_takes_it(recorded, tmp_path):
    """Its layout, calibration and settings are enclosed; flags come before them."""
    path, contacts, summary = recorded[0], tmp_path / "contacts.csv", tmp_path / "s.json"
    words = ("--grid", "8", "-o", contacts, "--summary", summary, "--modulus-kpa", "90")
    run("reconstruct", path, *words)
    assert contacts.exists()
    made = json.loads(summary.read_text())
    assert "thickness 3.00 mm, E 90.0 kPa" in made["layer"]
    assert "gain not given" not in " ".join(made["notes"])  # as it is without a calibration


(PROGRAM,) = re.findall(
    r"```python\n(.*?)```", doc("recording-file").read_text(encoding="utf-8"), re.DOTALL
)
EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "read_recording.py"


def test_programs_of_the_page(recorded, monkeypatch):
    """With mcap alone, and with skinfield."""
    path, counts, _ = recorded
    monkeypatch.chdir(path.parent)
    assert "skinfield" not in re.sub(r'""".*?"""', "", EXAMPLE.read_text(), flags=re.DOTALL)
    example = run_path(str(EXAMPLE))
    read = list(example["readings"]("touch.mcap"))
    np.testing.assert_array_equal([values for _, _, values in read], counts)
    forces = list(example["forces"]("touch.mcap"))
    wanted = [cycle.contacts["normal_force"].sum() for cycle in LiveRecording.open(path).cycles()]
    assert forces == wanted
    assert len(forces) == CYCLES
    found: dict[str, object] = {}
    exec(compile(PROGRAM, "recording-file.md", "exec"), found)
    np.testing.assert_array_equal(found["counts"].counts, counts)
    assert found["cycle"].number == CYCLES
    assert found["field"].sides.tolist() == [4]


def test_the_file_itself_says_what_kinds_of_blocks_there_are(recorded):
    with recorded[0].open("rb") as file:
        summary = make_reader(file).get_summary()
    (text,) = [s.data.decode() for s in summary.schemas.values() if s.name == "skinfield.Blocks"]
    said, _, bits = text.partition("Kinds, and")[2].partition("Status bits:")
    assert all(re.search(rf"\b{int(kind)}[:,]", said) for kind in Kind)
    for status in (Status.NO_ACK, Status.NOT_CONNECTED, Status.OUT_OF_RANGE, Status.INVALID):
        assert f" {int(status)} " in bits
