"""`skinfield experiments`: one command, from nothing to a report, and on from where it stopped."""

import json
import os
from pathlib import Path

from command_line import refused, run

from skinfield.lab import experiments as running
from skinfield.lab.report import SMOKE, Experiment, Missing, Section, Settings
from skinfield.lab.runner import Task

SETTINGS = Settings(size=SMOKE)
QUICK = ("--size", "smoke", "--workers", 1, "--only")


def quick(settings: Settings) -> Section:
    return Section("x", "Quick", "", (f"threads {os.environ.get('OMP_NUM_THREADS')}",))


SEEN: list[int] = []


def sometimes(settings: Settings) -> Section | Missing:
    return quick(settings) if SEEN else Missing("not yet")


def share(folder: Path, number: float) -> float:
    return number if number < 3 else float("nan")


def shares(settings: Settings) -> list[Task]:
    return [Task(f"share-{number:g}", share, (number,)) for number in (1.0, 2.0, 3.0)]


def gather(settings: Settings, results: list[float | None]) -> Section:
    return Section("x", "Whole", "", (str(results),))


def failing(settings: Settings) -> Section:
    raise ZeroDivisionError("on purpose")


def absent(settings: Settings) -> Missing:
    return Missing("nothing there")


def test_one_part_from_nothing_and_kept(tmp_path: Path) -> None:
    words = ("--size", "smoke", "--only", "model", "--workers", "1", "-o", str(tmp_path))
    first = run("experiments", *words)
    assert first.split()[-2:] == ["wrote", str(tmp_path / "report.html")]
    assert "does not hold" in first
    names = {file.name for file in (tmp_path / "agreement").iterdir()}
    assert names == {"task.json", "section.json", "agreement.csv", "errors.png", "half-space.png"}
    page = (tmp_path / "report.html").read_text()
    stamp = (tmp_path / "agreement" / "section.json").stat().st_mtime_ns
    run("experiments", *words)
    assert (tmp_path / "agreement" / "section.json").stat().st_mtime_ns == stamp
    again = (tmp_path / "report.html").read_text()
    assert (
        page.split("<main>")[1].split("</main>")[0] == again.split("<main>")[1].split("</main>")[0]
    )


def test_other_settings_are_made_anew() -> None:
    each = Experiment("part", (), quick)
    tasks = [running.task_of(each, Settings(size=SMOKE, seed=seed)) for seed in (0, 0, 1)]
    assert len({task.fingerprint for task in tasks}) == 2


def test_what_was_missing_is_looked_for_again(tmp_path: Path) -> None:
    part = Experiment("part", (), sometimes)
    running.run((part,), SETTINGS, tmp_path)
    assert json.loads((tmp_path / "results.json").read_text())["sections"] == []
    SEEN.append(1)
    running.run((part,), SETTINGS, tmp_path)
    assert len(json.loads((tmp_path / "results.json").read_text())["sections"]) == 1


def test_parts_are_kept_and_handed_on_in_order(tmp_path: Path) -> None:
    whole = Experiment("whole", (), gather, parts=shares)
    for _ in range(2):
        running.run((whole,), SETTINGS, tmp_path)
        section = json.loads((tmp_path / "whole" / "section.json").read_text())
        assert section["sentences"] == ["[1.0, 2.0, None]"]
        assert {file.name for file in (tmp_path / "parts").iterdir()} == {
            "share-1",
            "share-2",
            "share-3",
        }


def test_a_part_that_fails_stops_no_other(tmp_path: Path, monkeypatch) -> None:
    parts = (Experiment("bad", (), failing), Experiment("good", (), quick))
    monkeypatch.setattr(running, "chosen", lambda names: parts)
    result = refused("experiments", "--size", "smoke", "--workers", "1", "-o", tmp_path)
    assert "bad.failed.txt" in "".join(result.split())
    page = (tmp_path / "report.html").read_text()
    assert "bad failed: ZeroDivisionError" in page
    assert "Quick" in page


def test_parts_run_side_by_side_on_one_thread_each_and_missing_ones_are_named(
    tmp_path: Path,
) -> None:
    parts = (
        Experiment("first", (), quick),
        Experiment("second", (), quick),
        Experiment("absent", (), absent),
        Experiment("last", (), quick, alone=True),
    )
    seen: list[tuple[str, int, int]] = []
    before = os.environ.get("OMP_NUM_THREADS")
    running.run(parts, SETTINGS, tmp_path, 2, lambda *step: seen.append(step))
    assert os.environ.get("OMP_NUM_THREADS") == before
    results = json.loads((tmp_path / "results.json").read_text())
    assert [section["name"] for section in results["sections"]] == ["first", "second", "last"]
    assert results["sections"][0]["sentences"] == ["threads 1"]
    assert results["missing"] == ["nothing there"]
    assert seen[0] == ("", 0, 4)
    assert [done for _, done, _ in seen] == [0, 1, 2, 3, 4]
    assert seen[-1][0] == "last"  # what measures time waits for all others


def test_a_name_that_is_none(tmp_path: Path) -> None:
    assert "'fig12' names no experiment, expected some of imposed, fig3" in refused(
        "experiments", "--only", "fig12", "-o", tmp_path
    )


def test_a_folder_that_is_a_file(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("")
    refused("experiments", "--only", "model", "-o", file)
    below = refused(
        "experiments", "--only", "model", "--size", "smoke", "--workers", "1", "-o", file / "below"
    )
    assert "cannot be made" in below


def test_recorded_data_without_a_folder_is_said(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.delenv("SKINFIELD_SHARED_DATA", raising=False)
    run("experiments", "--only", "real-foot", "--size", "smoke", "--workers", "1", "-o", tmp_path)
    assert "no folder of recordings was given" in (tmp_path / "report.html").read_text()
