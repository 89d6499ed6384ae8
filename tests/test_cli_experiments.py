"""`skinfield experiments`: one command, from nothing to a report, and on from where it stopped."""

import os
from dataclasses import replace
from pathlib import Path

from command_line import refused, run

from skinfield.lab import experiments as running
from skinfield.lab.report import SMOKE, Chapter, Effort, Experiment

NAMES = ["first", "second", "last"]
QUICK = ("experiments", "--size", "smoke", "--workers", 1)


def quick(settings: Effort) -> Chapter:
    return Chapter("Quick", "", (f"threads {os.environ.get('OMP_NUM_THREADS')}",))


def failing(settings: Effort) -> Chapter:
    raise ZeroDivisionError("on purpose")


def test_one_part_from_nothing_and_kept(tmp_path: Path) -> None:
    words = (*QUICK, "--only", "model", "-o", tmp_path)
    first = run(*words)
    assert first.split()[-2:] == ["wrote", str(tmp_path / "report.html")]
    assert "does not hold" in first
    names = {file.name for file in (tmp_path / "agreement").iterdir()}
    assert names == {"task.json", "agreement.csv", "errors.png", "half-space.png"}
    page, section = tmp_path / "report.html", tmp_path / "agreement" / "task.json"
    mains, stamp = [page.read_text()], section.stat().st_mtime_ns
    run(*words)
    assert section.stat().st_mtime_ns == stamp
    mains.append(page.read_text())
    assert len({text.split("<main>")[1].split("</main>")[0] for text in mains}) == 1


def test_other_settings_are_made_anew() -> None:
    each = Experiment("part", (), quick)
    tasks = [running.task_of(each, replace(SMOKE, seed=seed)) for seed in (0, 0, 1)]
    assert len({task.fingerprint for task in tasks}) == 2


def test_a_part_that_fails_stops_no_other(tmp_path: Path, monkeypatch) -> None:
    parts = (Experiment("bad", (), failing), Experiment("good", (), quick))
    monkeypatch.setattr(running, "chosen", lambda names: parts)
    result = refused(*QUICK, "-o", tmp_path)
    assert "bad.failed.txt" in "".join(result.split())
    page = (tmp_path / "report.html").read_text()
    assert "bad failed: ZeroDivisionError" in page
    assert "Quick" in page


def test_parts_run_side_by_side_on_one_thread_each(tmp_path: Path) -> None:
    parts = [Experiment(name, (), quick, alone=name == "last") for name in NAMES]
    seen: list[tuple[str, int, int]] = []
    before = os.environ.get("OMP_NUM_THREADS")
    made = running.run(parts, SMOKE, tmp_path, 2, lambda *step: seen.append(step))
    assert os.environ.get("OMP_NUM_THREADS") == before
    assert [section.name for section in made.sections] == NAMES
    assert made.sections[0].sentences == ("threads 1",)
    assert made.failures == {}
    assert seen[0] == ("", 0, 3)
    assert [done for _, done, _ in seen] == [0, 1, 2, 3]
    assert seen[-1][0] == "last"  # what measures time waits for all others


def test_a_name_that_is_none(tmp_path: Path) -> None:
    assert "'fig12' names no experiment, expected some of imposed, fig3" in refused(
        "experiments", "--only", "fig12", "-o", tmp_path
    )


def test_a_folder_that_is_a_file(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("")
    refused(*QUICK, "--only", "model", "-o", file)
    assert "cannot be made" in refused(*QUICK, "--only", "model", "-o", file / "below")
