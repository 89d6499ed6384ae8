"""The benchmark of a whole robot runs, on a small one."""

import importlib
from pathlib import Path
from types import ModuleType

import pytest
from test_readme import doc, follow

import skinfield as sf

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def bench() -> ModuleType:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "benchmarks")
        return importlib.import_module("bench_skin")


def test_contacts_are_certified_where_time_is_no_matter(bench: ModuleType) -> None:
    skin = bench.hexagons(3)
    engine, scene = (
        sf.Engine(skin, rungs=(10, 40), solver=bench.SEARCH),
        bench.Scene(skin, {}, 2, 12),
    )
    row = bench.run("small", "2 contacts", engine, scene, 60.0)
    assert row.taxels == 216
    assert row.certified == 1.0
    assert 0.0 < row.worst_gap <= 1e-2
    assert row.overruns == 0.0
    assert 0.0 < row.p10 <= row.p50 <= row.p99
    assert bench.shown(row).count("|") == bench.COLUMNS.count("|") + 2


def test_the_page_about_the_engine_runs_and_finds_its_ball(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text, page, names = doc("engine").read_text(), tmp_path / "engine.md", {}
    page.write_text(text.replace("budget=500e-6", "budget=60.0"))  # on a machine that is busy
    assert follow(page, names) == (2, 0)
    assert len(names["estimates"].report.idle) == 5
    assert names["strongest"]["normal_force"] == pytest.approx(1.5, rel=0.25)
    assert names["strongest"]["position"] == pytest.approx([12e-3, -10e-3, 0.0], abs=1e-3)
