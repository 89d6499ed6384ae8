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
from skinfield.calibrate.by_pressure import check_pressure
from skinfield.cli.calibration_inputs import Series, delay_of, label_series
from skinfield.errors import FileError, InputError, SkinfieldError
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
    assert tried["constant_rmse_N"] == pytest.approx(np.std(truth), rel=0.1)
    assert tried["rmse_N"] < tried["sum_rmse_N"] < tried["constant_rmse_N"]
    assert abs(tried["mean_off_N"]) < 0.3
    assert 0.6 < tried["within_one_std"] < 0.95
    assert "answers" in run("calibrate", "check", cal, skin, *SKIN)
    assert "there already" in refused(*words, "-o", cal)
    assert "'gone' is not in" in refused(*words[:-1], "gone")
    assert "--unit is 'kp', expected one of N, kN, mN" in refused(*words, "--unit", "kp")


def test_force_of_several_recordings_less_what_their_sensor_reads_without_load(
    tmp_path: Path,
) -> None:
    files, tables, forces = [], [], []
    for seed in (1, 2):
        counts, force = pressed(150, seed)
        files.append(recorded(tmp_path / f"{seed}.csv", counts))
        files.append(labels_in(tmp_path / f"{seed}_f.csv", "force_N", force + 40.0))
        tables.append(counts)
        forces.append(force)
    cal, words = tmp_path / "cal.npz", ("calibrate", "force", *files, *SKIN)
    run(*words, "--offset", "40", "-o", cal)
    together = sf.calibrate.force(PATCH, np.concatenate(tables), np.concatenate(forces))
    np.testing.assert_allclose(
        sf.load_calibration(cal).force(tables[0]), together.force(tables[0]), rtol=1e-6
    )
    tried = ("calibrate", "check", cal, *files[:2], *SKIN)
    assert json.loads(run(*tried, "--json"))["mean_off_N"] == pytest.approx(-40.0, abs=0.5)
    found = json.loads(run(*tried, "--offset", "40", "--json"))
    assert found["mean_off_N"] == pytest.approx(0.0, abs=0.5)
    labels_in(files[1], "force_N", -forces[0])
    found = json.loads(run(*tried, "--json"))
    assert found["mean_off_N"] == pytest.approx(2.0 * forces[0].mean(), abs=0.5)
    assert "is their sign that of the calibration's?" in found["verdict"]
    assert "2_f.csv goes the other way than the labels before it" in refused(*words)
    labels_in(files[1], "force_N", forces[0] + 40.0)
    assert "expected 1 number in the unit" in refused(*words, "--offset", "1,2,3")
    assert "--offset is 'much'" in refused(*words, "--offset", "much")
    assert "has no labels, expected RECORDING LABELS in pairs" in refused(*words, files[0])
    dead = np.random.default_rng(0).normal(-6.0, 0.1, 150)
    labels_in(files[3], "force_N", dead)
    assert "2_f.csv: force, -5.99 N with a deviation" in refused(*words)
    labels_in(files[3], "fx,fy", dead, dead)
    assert "has 2 columns of labels, expected one force or three axes" in refused(*words)


def test_an_offset_is_in_the_unit_of_the_labels(tmp_path: Path) -> None:
    counts, force = pressed(300, 1)
    force[:60], counts[:60] = 0.0, 240.0 + np.random.default_rng(1).normal(size=(60, 72))
    plain = sf.calibrate.force(PATCH, counts, force).force(counts)
    skin, cal = recorded(tmp_path / "a.csv", counts), tmp_path / "cal.npz"
    label, nothing = 5e3 - 1e3 * force, np.zeros(300)
    for names, columns, words in (
        ("force_mN", (label,), ("--offset", "5000")),
        ("load", (label,), ("--offset", "5000", "--unit", "mN")),
        ("x_mN,y_mN,z_mN", (nothing, 7.0 + nothing, label), ("--offset", "0,7,5000")),
    ):
        file = labels_in(tmp_path / "f.csv", names, *columns)
        said = run("calibrate", "force", skin, file, *SKIN, *words, "-o", cal, "--force")
        assert "labels are turned" in said
        assert "pressed least" not in said
        np.testing.assert_allclose(sf.load_calibration(cal).force(counts), plain, atol=1e-6)
        tried = run("calibrate", "check", cal, skin, file, *SKIN, *words, "--json")
        assert abs(json.loads(tried)["mean_off_N"]) < 0.1
    assert "labels read about 5 N where the skin is pressed least" in run(
        "calibrate", "force", skin, file, *SKIN
    )
    labels_in(file, "time_s,force_mN", np.empty(0), np.empty(0))
    assert "f.csv holds a line of names only" in refused("calibrate", "force", skin, file, *SKIN)


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
    unit = (skin, tmp_path / "a.mat:trial.P", "--columns", "3-")
    assert "it is in bar, most likely" in refused("calibrate", "check", cal, *unit)
    assert "has 8 columns, expected 6" in refused("calibrate", "check", cal, skin, label)
    assert "expected one named so" in refused("calibrate", "pressure", tmp_path / "a.mat", label)


@pytest.mark.parametrize("ending", [".h5", ".mat"])
def test_matrices_are_read_from_hdf5_as_matlab_writes_it(tmp_path: Path, ending: str) -> None:
    h5py = pytest.importorskip("h5py", reason="of the extra hdf5")
    table, matlab = np.arange(12.0).reshape(4, 3), ending == ".mat"
    path = tmp_path / f"a{ending}"
    with h5py.File(path, "w", userblock_size=512 if matlab else 0) as file:
        file["trial/C"] = table.T if matlab else table  # by columns
        file["trial/P"] = np.arange(4.0)[None] if matlab else np.arange(4.0)
        file["name"] = np.array([102, 111], np.uint16)
        file["name"].attrs["MATLAB_class"] = np.bytes_("char")
    np.testing.assert_array_equal(read_numbers(f"{path}:trial.C").values, table)
    assert read_numbers(f"{path}:trial.P").values.shape == (4, 1)
    with pytest.raises(FileError, match=r"holds trial\.C, trial\.P, expected one named so"):
        read_numbers(str(path))


def test_units_are_those_of_the_columns_names(tmp_path: Path) -> None:
    force = 2.0 + np.sin(np.arange(60.0))
    for name, by in {"force_N": 1.0, "force_kN": 1e-3, "f (mN)": 1e3, "load": 1.0}.items():
        path = labels_in(tmp_path / "labels.csv", f"time_s,{name}", np.arange(60) / 50, by * force)
        found = label_series(str(path), None, None, "N")
        np.testing.assert_allclose(found.values[:, 0], force)
    path = labels_in(tmp_path / "labels.csv", "time_s,p_kPa", np.arange(60) / 50, force)
    assert label_series(str(path), None, None, "Pa").values[0, 0] == pytest.approx(1e3 * force[0])
    with pytest.raises(InputError, match="'p_kPa' is in kPa, expected Pa: give --unit as it is"):
        label_series(str(path), None, "Pa", "Pa")
    with pytest.raises(InputError, match="'p_kPa' is in kPa, expected N or kN or mN"):
        label_series(str(path), None, None, "N")
    with pytest.raises(InputError, match="reaches 3e\\+06 N, expected 100000 at most"):
        sf.calibrate.force(PATCH, np.zeros((60, 72)), 1e6 * force)
    with pytest.raises(InputError, match="spans 2e\\+08 Pa, expected 1e\\+07 at most"):
        check_pressure(1e8 * force)


def test_labels_that_are_late_are_taken_back() -> None:
    rng = np.random.default_rng(0)
    time = 0.02 * np.arange(1000)
    force = np.convolve(rng.standard_normal(1000), np.ones(25), "same")
    late = np.interp(time - 0.3, time, force)
    counts = np.outer(force - force.min(), np.ones(4))
    assert delay_of(Series(counts, time), Series(late[:, None], time)) == pytest.approx(0.3)
    assert delay_of(Series(counts, time), Series(force[:, None], time)) == 0.0


def test_a_delay_is_not_read_into_labels_that_hardly_follow() -> None:
    """A ramp fits ever better the later it is taken; what is not of the skin, somewhere."""
    time = 0.02 * np.arange(1000)
    counts = np.outer(np.clip(time - 10.0, 0.0, 2.0), np.ones(4))
    ramp = np.clip(time - 14.0, 0.0, 2.0)
    assert delay_of(Series(counts, time), Series(ramp[:, None], time)) == 0.0
    rng = np.random.default_rng(1)
    other = np.convolve(rng.standard_normal(1000), np.ones(25), "same")
    late = 0.3 * np.interp(time - 0.3, time, counts[:, 0]) + 0.2 * other
    assert delay_of(Series(counts, time), Series(late[:, None], time)) == 0.0


@settings(max_examples=100, deadline=None)
@given(st.sampled_from([".csv", ".mat", ".h5", ".npz", ".npy"]), ANYTHING)
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
