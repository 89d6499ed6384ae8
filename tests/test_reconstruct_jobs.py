"""`skinfield reconstruct` on recordings that are long, stored, sliced and shared among workers."""

import csv
import json
import os
import re
import shutil
import signal
import tracemalloc
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import invoke, refused, run
from live_skins import wait_for

import skinfield as sf
from skinfield.cli import reconstruct_jobs
from skinfield.cli.options import CountSettings
from skinfield.cli.reconstruct_jobs import JobPlan, dask_client, run_jobs
from skinfield.cli.settings import Elastomer, ModelSettings
from skinfield.files import fields, results, save_recording, tables
from skinfield.files import manifest as manifest_module
from skinfield.files.manifest import Manifest
from skinfield.files.recordings import lines, spool
from skinfield.files.results import read_results
from skinfield.skin.reading import Recording

for package in ("distributed", "xarray", "zarr", "pyarrow"):
    pytest.importorskip(package, reason="of the extra batch")

PATCH = sf.layouts.icub_triangle()
LAYOUT = ("--skin", "icub_triangle", "--grid", 8)
READINGS = 1200


def counts(readings: int) -> np.ndarray:
    """Bytes at rest for a third, then a touch that wanders over the triangle."""
    rng = np.random.default_rng(4)
    found = 240 + rng.normal(scale=1.5, size=(readings, len(PATCH))).round()
    place = PATCH.plane[3] + np.linspace(0, 8e-3, readings)[:, None] * [1.0, 0.3]
    away = np.square(PATCH.plane[None] - place[:, None]).sum(axis=2)
    found -= (np.arange(readings) > readings // 3)[:, None] * 40 * np.exp(-away / (5e-3) ** 2)
    found[10, 2] = np.nan
    return found.round()


def recorded(path: Path, readings: int = READINGS) -> Path:
    return saved(path, counts(readings))


def saved(path: Path, table: np.ndarray, unit: str = "count") -> Path:
    """Readings (T, taxels) as a recording, 20 ms apart."""
    save_recording(Recording(np.arange(len(table)) * 20_000_000, table, unit=unit), path)
    return path


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("long") / "long.csv")


@pytest.fixture(scope="module")
def stored(recording: Path) -> Path:
    path = recording.with_name("long.skinfield")
    run("reconstruct", recording, *LAYOUT, "-o", path)
    return path


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Windows of some readings, so that a short recording has several."""
    monkeypatch.setattr(manifest_module, "WINDOW", 512)


def rows_of(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.open()))


def test_what_is_printed_is_the_same_whatever_is_written(
    recording: Path, stored: Path, tmp_path: Path
) -> None:
    said = []
    for words in (
        (recording, *LAYOUT),
        (recording, *LAYOUT, "-o", tmp_path / "c.csv"),
        (recording, *LAYOUT, "-o", tmp_path / "r.skinfield", "--fields", tmp_path / "f.npz"),
        (stored,),
    ):
        text = run("reconstruct", *words)
        timed = r"[\d.e+-]+ ms per reading|wrote \S+|profile \S+: [^ν]*ν 0.5"
        said.append(" ".join(re.sub(timed, "", text).split()))
    assert said[1:] == said[:1] * 3
    results = sf.open_results(tmp_path / "r.skinfield")
    assert any("taken as iCub bytes" in note for note in results.attrs["notes"])
    loads = np.zeros(READINGS)
    for row in rows_of(tmp_path / "c.csv"):
        loads[int(row["reading"])] = float(row["total_force_N"])
    best = int(np.argmax(loads))
    assert f"reading {best} at {best * 0.02:.2f} s: {loads[best]:.2f} (relative)" in said[0]
    table = sf.load_contacts(tmp_path / "r.skinfield", slice(700, 800)).to_pylist()
    assert {row["reading"] for row in table} == set(range(700, 800))
    some = {row["reading"]: row["total_force_N"] for row in table}
    assert sum(some.values()) == pytest.approx(loads[700:800].sum(), rel=1e-6)


def test_a_slice_of_results_is_written(stored: Path, tmp_path: Path) -> None:
    said = run(
        "reconstruct", stored, "--slice", "300:420", "--fields", tmp_path / "f.npz",
        "-o", tmp_path / "c.csv", "--summary", tmp_path / "s.json",
    )  # fmt: skip
    assert "120 readings in 2.38 s" in said
    results, fields = sf.open_results(stored)[{"reading": slice(300, 420)}], tmp_path / "f.npz"
    with np.load(fields) as found:
        np.testing.assert_allclose(found["pressure"], results.pressure, rtol=1e-5, atol=1.0)
        np.testing.assert_allclose(found["displacement"], results.displacement, atol=1e-9)
        np.testing.assert_array_equal(found["stamp_ns"], results.stamp)
    rows = rows_of(tmp_path / "c.csv")
    assert [int(r["reading"]) for r in rows if int(r["contact"]) == 0] == list(range(401, 420))
    load = np.zeros(120)
    for row in rows:
        load[int(row["reading"]) - 300] = float(row["total_force_N"])
    summary = json.loads((tmp_path / "s.json").read_text())
    assert summary["readings"] == 120
    assert summary["total_force_N"]["highest"] == pytest.approx(load.max(), rel=1e-5)
    assert summary["highest_force_reading"] == 300 + int(np.argmax(load))


def test_the_runs_of_an_iterative_solver_are_those_of_the_results(
    recording: Path, tmp_path: Path
) -> None:
    path, file = tmp_path / "n.skinfield", tmp_path / "f.npz"
    words = (*LAYOUT, "--solver", "nonnegative", "--slice", "0:5")
    run("reconstruct", recording, *words, "-o", path)
    run("reconstruct", path, "--slice", "450:600", "--fields", file)
    with np.load(file) as fields:
        results = sf.open_results(path)
        np.testing.assert_array_equal(fields["pressure"], results.pressure[450:600])
        assert fields["pressure"].min() >= 0
    readings = sf.load_contacts(path)["reading"].to_pylist()
    assert set(range(700, READINGS)) <= set(readings)  # not of the slice


def test_readings_that_lack_any_taxels_are_written_too(tmp_path: Path) -> None:
    table = counts(200)
    table[np.random.default_rng(0).uniform(size=table.shape) < 0.02] = np.nan
    table[:, 5] = np.nan
    table[77] = np.nan
    path, fields = saved(tmp_path / "gaps.csv", table), tmp_path / "f.npz"
    outputs = ("-o", tmp_path / "c.csv", "-o", tmp_path / "r.skinfield")
    words = (path, *LAYOUT, "--solver", "gaussian")
    said = run("reconstruct", *words, "--fields", fields, *outputs)
    assert "1 of 200 readings have no valid taxel" in said
    assert "(1 left out)" in said
    results = read_results(tmp_path / "r.skinfield")
    assert len(results) == 199
    expected = results.reconstructor(results.values(0, 199))
    with np.load(fields) as found:
        for name in ("pressure", "pressure_std"):
            true = getattr(expected, name)
            off = found[name].reshape(199, 64) - true
            assert np.abs(off).max() < 1e-5 * np.abs(true).max()


@pytest.mark.parametrize("unit", ["count", "dC/C0"])
@pytest.mark.parametrize("smooth", [0, 60])
def test_in_blocks_or_as_a_whole_it_is_the_same(
    unit: str, smooth: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = counts(3600)
    table = table if unit == "count" else (240 - table) / 171 + 1e-4
    path = saved(tmp_path / "r.npz", table, unit)
    noise = ("--noise", 0.009, "--reading", 0, "--solver", "gaussian")
    words = ("reconstruct", path, *LAYOUT, "--smoothing-ms", smooth, *noise)
    run(*words, "-o", tmp_path / "whole.skinfield")
    for name, value in (("PIECE", 1), ("FEWEST", 900), ("MOST", 900)):
        monkeypatch.setattr(spool, name, value)
    run(*words, "-o", tmp_path / "blocks.skinfield")
    whole, blocks = (read_results(tmp_path / f"{n}.skinfield") for n in ("whole", "blocks"))
    np.testing.assert_array_equal(blocks.stamps(0, 3600), whole.stamps(0, 3600))
    one, other = blocks.values(0, 3600), whole.values(0, 3600)
    np.testing.assert_array_equal(np.isnan(one), np.isnan(other))
    np.testing.assert_allclose(one, other, atol=0.004)  # < 1 count
    np.testing.assert_array_equal(blocks.config.noise_std, whole.config.noise_std)


def test_what_would_have_no_effect_or_makes_no_sense_is_refused(
    recording: Path, stored: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "out"
    for words, message in [
        ((recording,), "--skin is missing, expected a layout file"),
        ((stored, "--grid", 8), "--grid would have no effect"),
        ((stored, "--skin", "hexagon72", "--gain", -1), "--skin, --gain would have no effect"),
        ((stored, "-o", tmp_path / "o.skinfield"), "-o o.skinfield would have no effect"),
        ((stored, "--slice", "5"), "--slice is '5', expected two numbers"),
        ((stored, "--slice", "5:x"), "--slice is '5:x'"),
        ((stored, "--slice", "1200:1300"), "expected readings of 0:1200"),
        ((stored, "--slice", "10:20", "--reading", 20), "--reading is 20, expected 10 to 19"),
        ((recording, *LAYOUT, "--workers", 2), "--workers would have no effect"),
        ((recording, *LAYOUT, "-o", folder, "--plot", "p.png"), "--plot would have no effect"),
        ((recording, *LAYOUT, "-o", folder, "-o", "c.csv"), "the folder"),
        ((recording, recording, *LAYOUT, "-o", "c.csv"), "2 recordings, expected -o DIR"),
        ((stored, "-o", folder), "are results already"),
        ((recording, *LAYOUT, "-o", "a.skinfield", "-o", "b.skinfield"), "two .skinfield folders"),
        ((tmp_path / "gone.skinfield", *LAYOUT), "gone.skinfield"),
        ((tmp_path / "gone.csv", *LAYOUT, "-o", folder), "gone.csv"),
        ((recording, *LAYOUT, "-o", tmp_path / "no/r.skinfield"), "is no folder, expected one"),
        ((recording, *LAYOUT, "--summary", tmp_path / "no/s.json"), "is no folder, expected one"),
        ((recording, *LAYOUT, "--plot", tmp_path / "no/p.png"), "is no folder, expected one"),
        ((recording, *LAYOUT, "-o", stored.parent), "holds files but no manifest.json"),
    ]:
        said = refused("reconstruct", *words)
        assert message in said, said
    assert not list(tmp_path.iterdir())


def test_a_damaged_file_is_named_in_one_paragraph(stored: Path, tmp_path: Path) -> None:
    path = tmp_path / "bad.skinfield"
    shutil.copytree(stored, path)
    chunk = path / "results.zarr" / "readings" / "c" / "0" / "0"
    data = bytearray(chunk.read_bytes())
    data[len(data) // 2] ^= 1
    chunk.write_bytes(data)
    said = refused("reconstruct", path, "-o", tmp_path / "c.csv")
    assert "are not as they were written" in said
    assert "Traceback" not in said
    assert [p.name for p in tmp_path.iterdir()] == ["bad.skinfield"]


def test_ctrl_c_leaves_nothing(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = reconstruct_jobs.parts

    def parts(*words) -> Iterator[reconstruct_jobs.PartialResults]:
        yield next(original(*words))
        raise KeyboardInterrupt

    monkeypatch.setattr(reconstruct_jobs, "parts", parts)
    names = (tmp_path / "r.skinfield", "-o", tmp_path / "c.csv", "--fields", tmp_path / "f.npz")
    done = invoke(["reconstruct", recording, *LAYOUT, "-o", *names])
    assert (done.exit_code, list(tmp_path.iterdir())) == (130, []), done.output


def test_memory_does_not_grow_with_the_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in (("PIECE", 1), ("FEWEST", 64), ("MOST", 64)):
        monkeypatch.setattr(spool, name, value)
    for module, name, value in (
        (lines, "BLOCK", 2048), (results, "BLOCK", 64),
        (reconstruct_jobs, "RUN", 32), (results, "RUN", 32),
        (fields, "MOST", 64), (fields, "COPIED", 1 << 12), (tables, "HELD", 1 << 12),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, value)
    peaks = []
    for readings in (100, 200, 800):  # the first loads what is compiled
        path = recorded(tmp_path / f"{readings}.csv", readings)
        tracemalloc.start() if peaks else None
        run(
            "reconstruct", path, *LAYOUT, "--solver", "gaussian",
            "-o", tmp_path / f"{readings}.csv.skinfield",
            "-o", tmp_path / f"c{readings}.csv", "--fields", tmp_path / f"f{readings}.npz",
        )  # fmt: skip
        peaks.append(tracemalloc.get_traced_memory()[1] if peaks else 1)
        tracemalloc.stop()
    assert peaks[2] < 1.2 * peaks[1], peaks


# ---- workers


def read_whole(path: Path) -> tuple[np.ndarray, np.ndarray, list[dict[str, object]]]:
    results, contacts = sf.open_results(path), sf.load_contacts(path).to_pylist()
    return results.readings.to_numpy(), results.pressure.to_numpy(), contacts


def executing(dask_worker: Any) -> int:
    """How many jobs a worker is at; those that nobody waits for any more count, too."""
    return len(dask_worker.state.executing)


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    with dask_client(2, None) as found:
        yield found


@pytest.mark.slow
def test_a_killed_worker_loses_nothing_and_an_ended_run_goes_on(
    client: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    paths = [recorded(tmp_path / f"{name}/data.csv", n) for name, n in (("a", 600), ("b", 520))]
    single = tmp_path / "single.skinfield"
    run("reconstruct", paths[0], *LAYOUT, "-o", single)
    folder = tmp_path / "out"
    plan = JobPlan.of(LAYOUT[1], None, CountSettings(), Elastomer(), ModelSettings(grid=8))
    seen: list[tuple[str, str, int]] = []

    def end_after_one(kind: str, name: str, readings: int) -> None:
        seen.append((kind, name, readings))
        if kind == "window":
            raise KeyboardInterrupt

    manifest = Manifest.open(folder, map(str, paths), plan.settings(True))
    with pytest.raises(KeyboardInterrupt):
        run_jobs(manifest, plan, True, client, end_after_one)
    wait_for(lambda: not any(client.run(executing).values()))  # workers of an ended run end, too

    def kill_one(kind: str, name: str, readings: int) -> None:
        again.append((kind, name, readings))
        if kind == "window" and not killed:
            killed.extend(client.run(os.getpid).values())
            os.kill(killed[0], signal.SIGKILL)

    again: list[tuple[str, str, int]] = []
    killed: list[int] = []
    manifest = Manifest.open(folder, map(str, paths), plan.settings(True))
    manifest.save()
    assert run_jobs(manifest, plan, True, client, kill_one) == {}
    assert killed[0] not in client.run(os.getpid).values()
    assert sum(n for kind, _, n in again if kind == "window") == 1120
    assert sorted(p.name for p in folder.iterdir()) == [
        "a-data.skinfield", "b-data.skinfield", "manifest.json",
    ]  # fmt: skip
    whole, expected = (read_whole(path) for path in (folder / "a-data.skinfield", single))
    np.testing.assert_array_equal(whole[0], expected[0])
    np.testing.assert_allclose(whole[1], expected[1], rtol=1e-5, atol=1e-2)
    assert whole[2] == expected[2]
    content = json.loads((folder / "manifest.json").read_text())
    assert all(entry["complete"] for entry in content["recordings"].values())
    # nothing is left to do: no worker is started; other settings are refused; what is gone is made
    words = ("reconstruct", *paths, *LAYOUT, "--store-fields", "-o", folder)
    assert "a-data.skinfield" in run(*words, "--scheduler", "tcp://127.0.0.1:1")
    assert "begun with other settings (smoothing_ms 0.0, not 5.0)" in refused(
        *words, "--smoothing-ms", 5
    )
    shutil.rmtree(folder / "b-data.skinfield")
    manifest = Manifest.open(folder, map(str, paths), plan.settings(True))
    assert [manifest.entries[name].complete for name in manifest.names] == [True, False]
    assert manifest.entries["b-data"].left() == []


def test_what_fails_is_named_and_the_rest_is_complete(client: Any, tmp_path: Path) -> None:
    good = recorded(tmp_path / "good.csv", 300)
    bad = tmp_path / "bad.csv"
    bad.write_text("time_s,taxel_0\n0.0,1\n0.02,2\n")
    words = ("reconstruct", good, bad, *LAYOUT, "-o", tmp_path / "out")
    words += ("--scheduler", client.scheduler.address)
    said = refused(*words)
    assert "1 of 2 recordings failed" in said
    assert "bad: " in said
    assert "good.skinfield 300" in " ".join(re.sub("[│┃]", " ", said).split())
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"good.skinfield", "manifest.json"}
