"""`skinfield reconstruct` on recordings that are long, kept, sliced and shared among processes."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import skinfield as sf
from skinfield.cli import main, reconstruct_intake, reconstruct_work
from skinfield.reading import Recording
from skinfield.sinks import save_recording

PATCH = sf.layouts.icub_triangle()
LAYOUT = ("--layout", "icub_triangle", "--grid", 8)
READINGS = 700


def run(*words: object) -> tuple[int, str]:
    result = CliRunner().invoke(main, [str(word) for word in words])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.output
    return result.exit_code, " ".join(result.output.split())


def counts(readings: int = READINGS) -> np.ndarray:
    """Bytes at rest for a third, then a touch that wanders over the triangle."""
    rng = np.random.default_rng(4)
    found = 240 + rng.normal(scale=1.5, size=(readings, len(PATCH))).round()
    place = PATCH.plane[3] + np.linspace(0, 8e-3, readings)[:, None] * [1.0, 0.3]
    away = np.square(PATCH.plane[None] - place[:, None]).sum(axis=2)
    found -= (np.arange(readings) > readings // 3)[:, None] * 40 * np.exp(-away / (5e-3) ** 2)
    found[10, 2] = np.nan
    return found.round()


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("long") / "long.csv"
    save_recording(Recording(np.arange(READINGS) * 20_000_000, counts()), path)
    return path


@pytest.fixture(scope="module")
def kept(recording: Path) -> Path:
    path = recording.with_name("long.skinfield")
    code, said = run("reconstruct", recording, *LAYOUT, "-o", path)
    assert code == 0, said
    return path


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pieces of some readings, so that a short recording has several."""
    monkeypatch.setitem(reconstruct_work.PIECE, "contacts", 128)


def rows_of(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.open()))


def test_results_are_kept_in_the_size_of_the_readings(recording: Path, kept: Path) -> None:
    results = sf.open_results(kept)
    assert np.load(kept / "readings.npy").dtype == np.uint8  # 254 at most, and what is missing
    np.testing.assert_array_equal(results.kept.recorded(0, READINGS), counts())
    assert results.pressure.shape == (READINGS, 64)
    expected = results.reconstructor(results.readings[:])
    found = results.pressure[:]
    assert np.abs(found - expected.pressure).max() < 1e-5 * expected.pressure.max()
    assert any("taken as iCub bytes" in note for note in results.notes)
    code, said = run("reconstruct", recording, *LAYOUT)
    assert code == 0, said
    best = int(np.argmax(results.normal_force[:]))
    assert f"reading {best} at {best * 0.02:.2f} s" in said


def test_a_slice_of_kept_results_is_written(recording: Path, kept: Path, tmp_path: Path) -> None:
    code, said = run(
        "reconstruct", kept, "--slice", "300:420", "--fields", tmp_path / "f.npz",
        "-o", tmp_path / "c.csv", "--summary", tmp_path / "s.json",
    )  # fmt: skip
    assert code == 0, said
    assert "120 readings in 2.38 s" in said
    results, fields = sf.open_results(kept), np.load(tmp_path / "f.npz")
    np.testing.assert_allclose(
        fields["pressure"].reshape(120, 64), results.pressure[300:420], rtol=1e-5, atol=1.0
    )
    np.testing.assert_allclose(
        fields["displacement"].reshape(120, 64, 3), results.displacement[300:420], atol=1e-9
    )
    np.testing.assert_array_equal(fields["stamp_ns"], results.stamp_ns[300:420])
    rows = rows_of(tmp_path / "c.csv")
    assert [int(r["reading"]) for r in rows if int(r["contact"]) <= 0] == list(range(300, 420))
    expected = [sum(c.normal_force for c in each) for each in results.contacts[300:420]]
    load = np.zeros(120)
    for row in rows:
        load[int(row["reading"]) - 300] += float(row["normal_force_N"] or 0.0)
    np.testing.assert_allclose(load, expected, rtol=1e-4, atol=1e-4)
    summary = json.loads((tmp_path / "s.json").read_text())
    assert summary["readings"] == 120
    assert summary["contact_force_N"]["highest"] == pytest.approx(max(expected), rel=1e-5)
    assert summary["highest_load_reading"] == 300 + int(np.argmax(expected))


def test_processes_change_nothing(recording: Path, tmp_path: Path) -> None:
    for processes in (1, 2):
        code, said = run(
            "reconstruct", recording, *LAYOUT, "--solver", "nonnegative", "--processes", processes,
            "--slice", "200:620",
            "-o", tmp_path / f"{processes}.csv", "--fields", tmp_path / f"{processes}.npz",
        )  # fmt: skip
        assert code == 0, said
    assert (tmp_path / "1.csv").read_text() == (tmp_path / "2.csv").read_text()
    one, two = (np.load(tmp_path / f"{n}.npz") for n in (1, 2))
    for name in ("pressure", "pressure_std", "displacement", "stamp_ns"):
        np.testing.assert_array_equal(one[name], two[name])


def test_the_runs_of_an_iterative_solver_are_those_of_lazy_results(
    recording: Path, tmp_path: Path
) -> None:
    path = tmp_path / "n.skinfield"
    code, said = run("reconstruct", recording, *LAYOUT, "--solver", "nonnegative", "-o", path)
    assert code == 0, said
    code, said = run("reconstruct", path, "--slice", "450:600", "--fields", tmp_path / "f.npz")
    assert code == 0, said
    fields, results = np.load(tmp_path / "f.npz"), sf.open_results(path)
    np.testing.assert_array_equal(fields["pressure"].reshape(150, 64), results.pressure[450:600])
    assert fields["pressure"].min() >= 0


def test_readings_that_lack_any_taxels_are_written_too(tmp_path: Path) -> None:
    table = counts(200)
    table[np.random.default_rng(0).uniform(size=table.shape) < 0.02] = np.nan
    table[:, 5] = np.nan
    table[77] = np.nan
    path = tmp_path / "gaps.csv"
    save_recording(Recording(np.arange(200) * 20_000_000, table), path)
    code, said = run(
        "reconstruct", path, *LAYOUT, "--fields", tmp_path / "f.npz", "-o", tmp_path / "c.csv",
        "-o", tmp_path / "r.skinfield",
    )  # fmt: skip
    assert code == 0, said
    assert "1 of 200 readings have no valid taxel" in said
    assert "(1 left out)" in said
    results = sf.open_results(tmp_path / "r.skinfield")
    assert len(results) == 199
    fields = np.load(tmp_path / "f.npz")
    expected = results.reconstructor(results.readings[:])
    for name in ("pressure", "pressure_std"):
        scale = np.abs(getattr(expected, name)).max()
        off = fields[name].reshape(199, 64) - getattr(expected, name)
        assert np.abs(off).max() < 1e-5 * scale


@pytest.mark.parametrize("unit", ["count", "dC/C0"])
@pytest.mark.parametrize("smooth", [0, 60])
def test_in_blocks_or_as_a_whole_it_is_the_same(
    unit: str, smooth: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = counts(6000)
    table = table if unit == "count" else (240 - table) / 171 + 1e-4
    path = tmp_path / "r.npz"
    save_recording(Recording(np.arange(6000) * 20_000_000, table, unit=unit), path)
    words = ("reconstruct", path, *LAYOUT, "--smooth-ms", smooth, "--noise", 0.009)
    assert run(*words, "-o", tmp_path / "whole.skinfield")[0] == 0
    for name, value in (("PIECE", 1), ("FEWEST", 1500), ("MOST", 1500)):
        monkeypatch.setattr(reconstruct_intake, name, value)
    code, said = run(*words, "-o", tmp_path / "blocks.skinfield")
    assert code == 0, said
    whole, blocks = (sf.open_results(tmp_path / f"{n}.skinfield") for n in ("whole", "blocks"))
    np.testing.assert_array_equal(blocks.stamp_ns[:], whole.stamp_ns[:])
    np.testing.assert_array_equal(np.isnan(blocks.readings[:]), np.isnan(whole.readings[:]))
    np.testing.assert_allclose(blocks.readings[:], whole.readings[:], atol=0.004)  # < 1 count
    np.testing.assert_array_equal(blocks.recipe.noise_std, whole.recipe.noise_std)


def test_what_would_have_no_effect_or_makes_no_sense_is_refused(
    recording: Path, kept: Path, tmp_path: Path
) -> None:
    for words, message in [
        ((recording,), "Missing option '--layout'"),
        ((kept, "--grid", 8), "--grid would have no effect"),
        ((kept, "--layout", "hexagon72", "--gain", -1), "--layout, --gain would have no effect"),
        ((kept, "-o", tmp_path / "o.skinfield"), "-o o.skinfield would have no effect"),
        ((kept, "--slice", "5"), "--slice is '5', expected two numbers"),
        ((kept, "--slice", "5:x"), "--slice is '5:x'"),
        ((kept, "--slice", "700:800"), "expected readings of 0:700"),
        ((kept, "--slice", "10:20", "--reading", 20), "--reading is 20, expected 10 to 19"),
        ((kept, "--processes", 0), "'--processes'"),
        ((recording, *LAYOUT, "-o", "a.skinfield", "-o", "b.skinfield"), "two .skinfield files"),
        ((tmp_path / "gone.skinfield", *LAYOUT), "gone.skinfield"),
        ((recording, *LAYOUT, "-o", tmp_path / "no/r.skinfield"), "is no folder, expected one"),
        ((recording, *LAYOUT, "--summary", tmp_path / "no/s.json"), "is no folder, expected one"),
        ((recording, *LAYOUT, "--plot", tmp_path / "no/p.png"), "is no folder, expected one"),
        ((recording, *LAYOUT, "-o", kept.parent), "expected a name that ends in"),
    ]:
        code, said = run("reconstruct", *words)
        assert code == 2, said
        assert message in said, said
    assert not list(tmp_path.iterdir())


def test_a_damaged_file_is_said_in_one_paragraph(kept: Path, tmp_path: Path) -> None:
    import shutil

    path = tmp_path / "bad.skinfield"
    shutil.copytree(kept, path)
    data = bytearray((path / "readings.npy").read_bytes())
    data[3000] ^= 1
    (path / "readings.npy").write_bytes(data)
    code, said = run("reconstruct", path, "-o", tmp_path / "c.csv")
    assert code == 2, said
    assert "are not as they were written" in said
    assert "Traceback" not in said
    assert [p.name for p in tmp_path.iterdir()] == ["bad.skinfield"]


def test_ctrl_c_leaves_nothing(kept: Path, tmp_path: Path) -> None:
    command = (
        "from skinfield.cli import main, reconstruct_work as w; w.PIECE['iterative'] = 1; "
        "w.PIECE['contacts'] = 1; main()"
    )
    words = ["reconstruct", str(kept), "--processes", "2", "-o", str(tmp_path / "c.csv")]
    running = subprocess.Popen(
        [sys.executable, "-c", command, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, start_new_session=True,
    )  # fmt: skip
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and not list(tmp_path.iterdir()):
        time.sleep(0.02)
    time.sleep(1.5)
    os.killpg(running.pid, signal.SIGINT)
    _, err = running.communicate(timeout=60)
    assert "Traceback" not in err
    assert (running.returncode == 1 and not list(tmp_path.iterdir())) or (
        running.returncode == 0  # it was quicker
    )


def test_fields_by_a_device(kept: Path, tmp_path: Path) -> None:
    for name, words in (("here", ()), ("there", ("--device", "numpy"))):
        code, said = run("reconstruct", kept, "--fields", tmp_path / f"{name}.npz", *words)
        assert code == 0, said
    with np.load(tmp_path / "here.npz") as here, np.load(tmp_path / "there.npz") as there:
        assert sorted(here) == sorted(there)
        scale = np.abs(here["pressure"]).max()
        assert np.abs(here["pressure"] - there["pressure"]).max() < 3e-6 * scale


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--device", "nowhere"), "device is 'nowhere'"),
        (("--device", "numpy", "--processes", 2), "--processes is 2 beside --device numpy"),
    ],
)
def test_a_device_that_cannot_be_used(kept: Path, words: tuple[object, ...], message: str) -> None:
    code, said = run("reconstruct", kept, *words)
    assert code != 0
    assert message in said


def test_a_device_for_a_solver_that_searches(recording: Path) -> None:
    words = ("--solver", "nonnegative", "--device", "numpy", "--slice", "0:5")
    code, said = run("reconstruct", recording, *LAYOUT, *words)
    assert code != 0
    assert "the solver is not linear" in said
