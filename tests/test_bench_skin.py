"""The benchmark of a whole robot runs, on a small one, and its readings are those of presses."""

import importlib
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from test_readme import follow

import skinfield as sf

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def bench() -> ModuleType:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "benchmarks")
        return importlib.import_module("bench_skin")


def test_contacts_are_certified_where_time_is_no_matter(bench: ModuleType) -> None:
    skin = bench.hexagons(3)
    engine, scene = sf.Engine(skin, rungs=(10, 40)), bench.Scene(skin, {}, 2, 12)
    row = bench.run("small", "2 contacts", engine, scene, 60.0)
    assert row.taxels == 216
    assert row.certified == 1.0
    assert 0.0 < row.worst_gap <= 1e-2
    assert row.overruns == 0.0
    assert 0.0 < row.p10 <= row.p50 <= row.p99
    assert bench.shown(row).count("|") == bench.COLUMNS.count("|") + 2


def test_readings_are_those_of_a_ball_that_wanders(bench: ModuleType) -> None:
    """Noise where nothing touches; else the press of a ball that moves by the stated step."""
    skin = bench.hexagons(4)
    scene = bench.Scene(skin, {}, 1, 40)
    touched = [patch.name for patch in skin].index(scene.touched[0])
    noise = sf.Capacitance().typical_noise
    quiet = np.concatenate([row[i] for row in scene for i in range(4) if i != touched])
    assert quiet.std() == pytest.approx(noise, rel=0.05)
    rows = np.array([row[touched] for row in scene])
    assert rows.max(axis=1).min() > 10 * noise
    weights = np.maximum(rows - 5 * noise, 0.0)
    places = weights @ skin[touched].plane / weights.sum(axis=1, keepdims=True)
    path = np.linalg.norm(places[-1] - places[0])
    chord = 2 * bench.ROUND * np.sin(39 * bench.STEP / bench.ROUND / 2)
    assert path == pytest.approx(chord, rel=0.25)


def test_other_ways_have_the_same_rows(bench: ModuleType) -> None:
    skin = bench.hexagons(2)
    engine = sf.Engine(skin, solver=sf.GaussianField(), rungs=(12,))
    rows = list(bench.beside("small", engine, bench.Scene(skin, {}, 0, 3)))
    sizes = [float(row.note.split()[0]) for row in rows]
    assert sizes == pytest.approx(
        [2 * 144 * 72 * 8e-6, 144 * 72 * 4e-6, 2 * 144 * 72 * 4e-6], abs=0.06
    )


def test_ten_types_of_taxels(bench: ModuleType) -> None:
    skin, layers = bench.ten_types()
    assert sum(map(len, skin)) == 10_000
    assert len({(layers[p.name].thickness, round(p.pitch, 6)) for p in skin}) == 10


def test_the_page_of_whole_robots_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow(ROOT / "docs" / "whole-robot.md") == (1, 0)
    assert capsys.readouterr().out == "5 non-negative\n"
