"""`skinfield calibrate force | pressure | check`: files in, a calibration and a page out."""

import json
from pathlib import Path

import numpy as np
import pytest
from any_bytes import ANYTHING
from command_line import refused, run
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat
from test_calibrate_force import pressed
from test_calibrate_pressure import foam, plenum

import skinfield as sf
from skinfield.cli.calibration_inputs import Series, delay_of
from skinfield.errors import SkinfieldError
from skinfield.files import save_recording
from skinfield.files.numbers import read_numbers
from skinfield.skin.reading import Recording

PATCH = sf.layouts.hexagon72()
SKIN = ("--skin", "hexagon72")


def recorded(path: Path, counts: np.ndarray) -> Path:
    """A recording of hexagon72, 20 ms apart."""
    save_recording(Recording(np.arange(len(counts)) * 20_000_000, counts), path)
    return path


def labels_in(path: Path, names: str, *columns: np.ndarray) -> Path:
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=names, comments="")
    return path


def test_force_is_calibrated_and_tried_on_another_recording(tmp_path: Path) -> None:
    counts, force = pressed(300, 1)
    time = 0.02 * np.arange(300)
    skin = recorded(tmp_path / "a.csv", counts)
    labels = labels_in(tmp_path / "a_force.csv", "time_s,force_N,room_C", time, force, 20 + time)
    cal, page = tmp_path / "cal.toml", tmp_path / "page"
    words = ("calibrate", "force", skin, labels, *SKIN, "--labels", "force_N")
    found = json.loads(run(*words, "-o", cal, "--report", page, "--json"))
    assert 0.3 < found["rmse_N"] < found["constant_rmse_N"]
    html = (page / "report.html").read_text()
    assert "N off (rms" in html
    assert all((page / f"{name}.png").stat().st_size > 10_000 for name in (
        "each-fifth-foretold-from-the-others", "error-beside-trivial-answers",
    ))  # fmt: skip
    assert html.count("<img") == 2
    np.testing.assert_allclose(
        sf.load_calibration(cal, PATCH).force(counts),
        sf.calibrate.force(PATCH, counts, force).force(counts),
        rtol=1e-6,
    )
    other, truth = pressed(200, 2)
    skin = recorded(tmp_path / "b.csv", other)
    labels = labels_in(tmp_path / "b_force.csv", "time_s,force_N", 0.02 * np.arange(200), truth)
    tried = json.loads(run("calibrate", "check", cal, skin, labels, *SKIN, "--json"))
    assert tried["rmse_N"] == pytest.approx(found["rmse_N"], rel=0.25)
    assert "answers" in run("calibrate", "check", cal, skin, *SKIN)
    assert "there already" in refused(*words, "-o", cal)
    assert "'gone' is not in" in refused(*words[:-1], "gone")
    assert "--unit is 'kp', expected one of Pa" in refused(*words, "--unit", "kp")


def test_pressure_is_calibrated_from_matlab_and_bar(tmp_path: Path) -> None:
    reference = plenum(1500, 3)
    counts = foam(reference, 6, 3)
    table = np.column_stack([np.arange(1500), 0.02 * np.arange(1500), counts])
    savemat(tmp_path / "a.mat", {"trial": {"C": table, "P": reference[:1450] / 1e5}})
    skin, label = tmp_path / "a.mat:trial.C", tmp_path / "a.mat:trial.P"
    words = (skin, label, "--columns", "3-", "--unit", "bar")
    cal = tmp_path / "foam.npz"
    found = json.loads(run("calibrate", "pressure", *words, "-o", cal, "--json").splitlines()[0])
    assert found["usable"] == 6
    assert found["rmse_Pa"] < found["line_rmse_Pa"]
    made = sf.load_calibration(cal)
    assert made.pressure(counts[:1450]) == pytest.approx(
        sf.calibrate.pressure(counts[:1450], reference[:1450]).pressure(counts[:1450]), rel=1e-6
    )
    tried = json.loads(run("calibrate", "check", cal, *words, "--json").splitlines()[0])
    assert tried["rmse_Pa"] < 2.0 * found["rmse_Pa"]
    assert "most likely; give Pa" in refused("calibrate", "pressure", *words[:-2])
    assert "has 8 columns, expected 6" in refused("calibrate", "check", cal, skin, label)
    assert "expected one named so" in refused("calibrate", "pressure", tmp_path / "a.mat", label)


def test_labels_that_are_late_are_taken_back() -> None:
    rng = np.random.default_rng(0)
    time = 0.02 * np.arange(1000)
    force = np.convolve(rng.standard_normal(1000), np.ones(25), "same")
    late = np.interp(time - 0.3, time, force)
    counts = np.outer(force - force.min(), np.ones(4))
    assert delay_of(Series(counts, time), Series(late[:, None], time)) == pytest.approx(0.3)
    assert delay_of(Series(counts, time), Series(force[:, None], time)) == 0.0


@settings(max_examples=100, deadline=None)
@given(st.sampled_from([".csv", ".mat", ".npz", ".npy"]), ANYTHING)
def test_any_bytes_are_numbers_or_an_error(
    tmp_path_factory: pytest.TempPathFactory, ending: str, content: bytes
) -> None:
    path = tmp_path_factory.mktemp("numbers") / f"a{ending}"
    path.write_bytes(content)
    try:
        found = read_numbers(str(path))
    except SkinfieldError:
        return
    assert found.values.shape[1] == len(found.names)
