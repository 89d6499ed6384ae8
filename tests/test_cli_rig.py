"""`skinfield rig`, and what the rest of the program makes of its files."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from command_line import refused, run
from test_readme import ROOT, blocks, doc, follow

from skinfield.files import open_recording
from skinfield.files.layouts.load import load_layout
from skinfield.lab.scenarios import load_scenario
from skinfield.signal import load_calibration
from skinfield.simulate.rig import run_rig

FOAM = ROOT / "examples" / "scenarios" / "foam.toml"
SCENARIO = FOAM.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rig")
    (folder / "foam.toml").write_text(SCENARIO)
    result = run("rig", folder / "foam.toml", "-o", folder / "out", "--workers", "1")
    assert "foam-ball" in result
    assert re.search(r"│ +10 │ +\d+ │ +2\.00 │", result)
    return folder / "out" / "foam-ball"


def test_a_run_has_its_files(made: Path) -> None:
    assert sorted(path.name for path in made.iterdir()) == [
        "calibration.toml", "layout.toml", "load_cell.csv", "recording.npz", "run.png",
        "task.json", "truth.npz",
    ]  # fmt: skip
    assert (made / "run.png").stat().st_size > 50_000
    assert json.loads((made / "task.json").read_text())["result"]["highest_force_N"] == 2.0
    force = open_recording(made / "load_cell.csv")
    with np.load(made / "truth.npz") as truth:
        true = np.interp(force.stamp_ns * 1e-9, truth["time_s"], truth["force_N"])
        assert -force.counts[:, 2] == pytest.approx(true, abs=0.02)
        assert truth["pressure_Pa"].shape[0] == 2


def test_its_scenario_makes_it_again(made: Path) -> None:
    again = run_rig(load_scenario(made.parent / "foam.toml"))
    recording = open_recording(made / "recording.npz")
    assert np.array_equal(recording.counts, again.recording.counts, equal_nan=True)
    assert np.array_equal(recording.stamp_ns, again.recording.stamp_ns)
    (patch,) = load_layout(made / "layout.toml")
    assert load_calibration(made / "calibration.toml", patch).gain == pytest.approx(again.skin.gain)


def test_a_run_that_is_there_is_not_made_again(made: Path) -> None:
    before = (made / "truth.npz").stat().st_mtime_ns
    words = ("rig", str(made.parents[1] / "foam.toml"), "-o", str(made.parent))
    said = run(*words)
    assert "1 run in" in said
    assert "1 of them from before" in said
    assert (made / "truth.npz").stat().st_mtime_ns == before
    assert re.search(r"foam-ball +│ ball +│ +10 │ +35.0 │ there", run(*words, "--dry-run"))


def real(made: Path) -> tuple[object, ...]:
    """Options for what the rig made, taken for a real skin."""
    calibration = made / "calibration.toml"
    return ("--skin", made / "layout.toml", "--calibration", calibration, "--poisson", 0.3)


def number_in(text: str, pattern: str) -> float:
    return float(re.search(pattern, text).group(1))  # type: ignore[union-attr]


def test_reconstruct_takes_it_for_a_real_recording(made: Path) -> None:
    words = (*real(made), "--modulus-kpa", 90, "-o", made.parent / "contacts.csv")
    highest = number_in(run("reconstruct", made / "recording.npz", *words), r": ([\d.]+) N, ")
    assert 1.7 < highest < 2.4  # 2.0 pressed
    assert (made.parent / "contacts.csv").stat().st_size > 1000


def test_its_scale_is_fitted_by_its_load_cell(made: Path, tmp_path: Path) -> None:
    """From a modulus that is a third too high back to the true one."""
    words = ("calibrate", "scale", made / "recording.npz", made / "load_cell.csv", *real(made))
    result = run(*words, "--modulus-kpa", 120)
    assert number_in(result, r"modulus ([\d.]+) kPa") == pytest.approx(90.0, rel=0.15)
    assert number_in(result, r"correlation ([\d.]+)") > 0.9
    written = tmp_path / "scale.json"  # along the wrong axis
    result = refused(*words, "--axis", "z", "-o", written)
    assert "expected one above 0: the sensor's axis points the other way" in result
    assert not written.exists()


def test_a_template_is_written_once(tmp_path: Path) -> None:
    path = tmp_path / "new.toml"
    run("rig", "--new", path)
    run("rig", path, "--dry-run")
    assert "is there already, expected a new file" in refused("rig", "--new", path)


def test_a_run_that_fails_is_told_and_the_others_are_made(tmp_path: Path) -> None:
    text = SCENARIO.replace("[[places]]", '[[indenter]]\nname = "pin"\nshape = "cylinder"\n'
                            "radius_mm = 0.3\n[[places]]", 1)  # fmt: skip
    text = text[: text.index('[[places]]\nkind = "raster')] + text[text.index("[loads]") :]
    (tmp_path / "s.toml").write_text(text)
    assert "1 of 2 runs failed: foam-pin" in refused(
        "rig", tmp_path / "s.toml", "-o", tmp_path / "o", "--workers", "1"
    )
    assert (tmp_path / "o" / "foam-ball" / "truth.npz").is_file()
    assert "Traceback" in (tmp_path / "o" / "foam-pin.failed.txt").read_text()


@pytest.mark.parametrize("path", sorted(FOAM.parent.glob("*.toml")), ids=lambda path: path.stem)
def test_examples_are_scenarios(path: Path) -> None:
    assert "to do" in run("rig", path, "--dry-run")


def test_mistakes_are_a_paragraph(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text("skinfield_rig = 1\n[profile]\nhold = 3\n")
    assert "did you mean hold_s?" in refused("rig", tmp_path / "s.toml")
    assert "SCENARIO is missing" in refused("rig")
    (tmp_path / "s.toml").write_text("skinfield_rig = 1\n")
    twice = refused("rig", tmp_path / "s.toml", tmp_path / "s.toml")
    assert "both have a run rig-sphere6" in twice
    assert "truth.npz" in run("rig", "--help")


def test_the_page_runs_and_prints_what_it_says(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("trimesh")
    page = doc("simulate")
    shown = list(blocks(page))
    assert ("toml", "foam.toml", SCENARIO) in shown
    shutil.copytree(made, tmp_path / "rig" / "foam-ball")  # so that it need not be made again
    monkeypatch.chdir(tmp_path)
    capsys.readouterr()
    assert follow(page) == (3, 7)
    for name in ("lean.png", "pyramid.npz", "press.png"):
        assert Path(name).stat().st_size > 10_000
    number = re.compile(r"\d+\.\d+")
    said, printed = (number.findall(text) for text in (shown[-1][2], capsys.readouterr().out))
    assert len(said) == 6
    assert [float(value) for value in printed[-6:]] == pytest.approx(
        [float(value) for value in said], abs=0.03
    )
