"""Calibration by unknown touches, which another program pressed: layer, cover, gains."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from command_line import refused, run
from scipy.interpolate import CubicSpline

import skinfield as sf
from skinfield.calibrate import by_touch, save_calibration, touch_sampling
from skinfield.calibrate.press_tables import PressTables
from skinfield.calibrate.touch_presses import between, noise_of_differences, presses
from skinfield.calibrate.touch_relaxation import relaxation, traces
from skinfield.errors import FileError, InputError
from skinfield.files import save_recording
from skinfield.reconstruct.diagnostics import Conditioning, condition
from skinfield.simulate import Sphere, press
from skinfield.skin.reading import Recording

PATCH = replace(sf.layouts.hexagon72().subset(range(36)), n_channels=36)  # three modules
NOISE = 5e-4


@cache
def touches(
    count: int = 80, seed: int = 0, thickness: float = 2.3e-3, ratio: float = 0.47
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Readings (T, L) of balls anywhere by the axisymmetric press, gains, and forces (T,), N."""
    rng, layer = np.random.default_rng(seed), sf.Layer(thickness, 150e3, ratio)
    far, kinds = np.linspace(0.0, 66e-3, 331), []
    for _ in range(8):
        radius, force = np.exp(rng.uniform(np.log([3e-3, 0.3]), np.log([12e-3, 3.0])))
        ball = press(layer, [Sphere(radius=radius, force=force)], 20e-3, 0.4e-3)
        places = np.column_stack([far, 0.0 * far])
        read = ball.readings(places, PATCH.pad_diameter, "capacitance")
        kinds.append((CubicSpline(far, read), force))
    low, high = PATCH.plane.min(axis=0), PATCH.plane.max(axis=0)
    gain = np.exp(0.1 * rng.standard_normal(len(PATCH)))
    gain /= np.exp(np.log(gain).mean())
    chosen, where = rng.integers(8, size=count), rng.uniform(low, high, (count, 2))
    away = np.linalg.norm(PATCH.plane[None] - where[:, None], axis=2)
    readings = np.array([kinds[k][0](each) for k, each in zip(chosen, away, strict=True)]) * gain
    forces = np.array([kinds[k][1] for k in chosen])
    return readings + NOISE * rng.standard_normal(readings.shape), gain, forces


@cache
def found() -> sf.calibrate.TouchCalibration:
    """With ten known forces, as of a skin half as stiff."""
    readings, _, forces = touches()
    some, known = np.argsort(readings.max(axis=1))[-20:-10], np.full(len(readings), np.nan)
    known[some] = 0.5 * forces[some]
    return sf.calibrate.touch(PATCH, readings, noise_std=NOISE, known_force=known)


def test_layer_and_gains_are_found_by_touches_alone() -> None:
    made, gain = found(), touches()[1]
    assert made.layer.thickness == pytest.approx(2.3e-3, rel=0.045)
    assert made.layer.poisson_ratio == pytest.approx(0.47, abs=0.004)
    assert not made.covered
    off = np.std(np.log(made.gain / gain))
    assert 0.01 < off < 0.7 * np.std(np.log(gain))
    assert off < 2.0 * np.median(made.gain_std)
    assert np.log(made.gain).mean() == pytest.approx(0.0, abs=1e-9)
    assert made.young_modulus == pytest.approx(75e3, rel=0.1)
    assert not made.relative


def test_a_reconstructor_knows_the_skin_by_it() -> None:
    made, (readings, _, forces) = found(), touches()
    strong = np.flatnonzero((readings.max(axis=1) > 0.05) & (readings.max(axis=1) < 0.5))[:15]
    told = sf.Reconstructor(PATCH, calibration=made, solver=sf.ContactFit(check_mechanics=False))
    answers = []
    for row in strong:
        told.reset()
        answers.append(float(told(readings[row]).normal_force))
    error = np.median(np.abs(2.0 * np.array(answers) / forces[strong] - 1.0))
    assert told.layer == made.layer
    assert 0.002 < error < 0.1


def test_too_few_touches_are_refused() -> None:
    with pytest.raises(InputError, match=r"hold 0 touches .* expected 20 or more.* add 20 or more"):
        sf.calibrate.touch(PATCH, np.zeros((100, 36)), noise_std=NOISE)


def test_few_touches_are_enough_though_some_are_left_out_and_say_how_little_they_tell() -> None:
    """Of 25 on a skin that is more unlike its model than stated: by noise five times as large."""
    readings, gain, _ = touches()
    strong = readings[readings.max(axis=1) > 0.006][:25]
    made = sf.calibrate.touch(PATCH, strong, noise_std=NOISE / 5.0)
    assert made.presses + made.left_out == 25
    assert 12 <= made.presses <= 20
    assert abs(made.thickness - 2.3e-3) < made.thickness_std
    assert made.thickness_std > found().thickness_std
    assert abs(made.poisson_ratio - 0.47) < made.poisson_std
    far = np.abs(np.log(made.gain / gain)) / (made.gain_std / made.gain)
    assert np.mean(far < 1.96) > 0.8


def test_touches_of_no_ball_are_refused_and_the_message_says_how_many_more_it_takes() -> None:
    squares = np.where(np.arange(20)[:, None] < 11, np.ones((20, 36)), 1e4)
    fit: Any = SimpleNamespace(
        aim=lambda state: None,
        misfit=lambda state: squares,
        data=SimpleNamespace(heard=np.ones((20, 36), np.bool_)),
    )
    state: Any = None
    with pytest.raises(InputError, match=r"^11 of 20 touches are .* expected 12 .* add 2 or more"):
        by_touch._balls(fit, state)
    squares[11] = 1.0
    assert by_touch._balls(fit, state).sum() == 12


def test_what_cannot_be_calibrated_by_is_refused_with_the_reason() -> None:
    readings = touches()[0]
    with pytest.raises(InputError, match=r"fall under touch.*--gain"):
        sf.calibrate.touch(PATCH, -readings, noise_std=NOISE)
    with pytest.raises(InputError, match=r"quantity is 'capacitance', expected a Quantity"):
        sf.calibrate.touch(PATCH, readings, quantity="capacitance")  # type: ignore[arg-type]
    endless = readings.copy()
    endless[3, 5] = np.inf
    with pytest.raises(InputError, match=r"readings\[\(3, 5\)\] is inf"):
        sf.calibrate.touch(PATCH, endless)
    with pytest.raises(InputError, match=r"where strong presses.*percent by 100"):
        sf.calibrate.touch(PATCH, 100.0 * readings, noise_std=100.0 * NOISE)
    near = readings[:, :3]  # so small a patch is pressed all the time
    with pytest.raises(InputError, match=r"noise_std= \(--noise\)|noise_std=, --noise"):
        sf.calibrate.touch(PATCH.subset(range(3)), near[near.max(axis=1) > 0.05])
    assert "doubtful" in replace(found(), left_out=found().presses).verdict
    assert "doubtful" not in found().verdict


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"place_std": 0.3}, r"place_std is 0\.3, expected a number from 0 to 0\.0\d+: in metres"),
        ({"place_std": -1e-4}, r"place_std is -0\.0001, expected"),
        ({"noise_std": [1.0, 2.0, 3.0]}, r"noise_std has shape \(3,\), expected \(36\)"),
        ({"known_force": np.full(80, np.nan)}, r"known_force holds nothing but NaN"),
        ({"known_force": np.full(80, -2.0)}, r"known_force holds -2 to -2 N"),
        ({"known_force": np.ones(7)}, r"known_force has shape \(7,\), expected \(80\)"),
    ],
)
def test_arguments_are_checked_before_the_fit(
    arguments: dict[str, Any], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(by_touch, "_fitted")
    with pytest.raises(InputError, match=message):
        sf.calibrate.touch(PATCH, touches()[0], **{"noise_std": NOISE} | arguments)


def with_ramps() -> tuple[np.ndarray, np.ndarray]:
    """Readings (P, L) of strong presses; these (T, L) one after the other, with ramps, and idle."""
    each = touches()[0]
    strong = each[each.max(axis=1) > 0.03]
    idle, held = np.zeros((20, 36)), np.array([1.0, 2.0, 3.0] + [4.0] * 20 + [3.0, 2.0, 1.0]) / 4.0
    return strong, np.concatenate([np.vstack([idle, held[:, None] * one]) for one in strong])


def test_rest_is_what_is_read_between_presses() -> None:
    rng, (strong, still) = np.random.default_rng(2), with_ramps()
    rest = np.zeros(36)
    rest[7], rest[20] = 0.1, -0.08  # as where a press was taken for rest
    told = np.rint((still + rest + 0.002 * rng.standard_normal(still.shape)) * 171.0) / 171.0
    off = between(told, noise_of_differences(told)) - rest
    assert 1e-5 < np.abs(off).max() < 1.2e-3  # a fifth of a count
    made = presses(told, None)
    assert len(made.readings) == len(strong)
    assert np.median(np.abs(made.readings - strong)[:, [7, 20]]) < 2e-3
    pressed = np.vstack([force * strong for force in np.linspace(0.7, 1.3, 8)])
    alone = between(pressed, np.full(36, NOISE))  # each reading a press: none is between
    np.testing.assert_array_equal(alone, 0.0)


def test_rest_between_presses_is_kept_with_the_calibration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, taken = found(), list[np.ndarray]()

    def fit(patch: sf.Patch, readings: np.ndarray, **_: object) -> sf.calibrate.TouchCalibration:
        taken.append(readings)
        return made

    monkeypatch.setattr(sf.calibrate, "touch", fit)
    layout, skin, cal = tmp_path / "three.toml", tmp_path / "presses.csv", tmp_path / "cal.toml"
    sf.save_layout(PATCH, layout)
    told = with_ramps()[1]
    counts = np.rint(240.0 - 171.0 * told + np.random.default_rng(5).standard_normal(told.shape))
    recording = Recording(np.arange(len(counts)) * 20_000_000, counts)
    save_recording(recording, skin)
    first = condition(recording, PATCH, sf.Layer(), sf.Capacitance(), Conditioning())[1]
    before = first.conditioner.calibration
    assert before is not None
    run("calibrate", "touch", skin, "--skin", layout, "-o", cal)
    after = sf.load_calibration(cal, PATCH).counts
    assert np.abs(before.baseline - 240.0).max() > 0.3  # no 2 s are idle
    assert 1e-3 < np.abs(after.baseline - 240.0).max() < 0.2
    idle = taken[0][(told == 0.0).all(axis=1)]
    assert 1e-6 < np.abs(idle.mean(axis=0)).max() < 0.2 / 171.0


def test_readings_of_one_press_become_one_and_show_its_noise() -> None:
    rng, each = np.random.default_rng(1), touches()[0]
    strong = each[each.max(axis=1) > 0.03]
    noise = 1e-3 * np.exp(rng.uniform(-1.0, 1.0, 36))
    between = np.insert(strong, range(len(strong)), 0.0, axis=0)  # rest, press, rest, press
    still = np.repeat(between, 20, axis=0)
    told = still + noise * rng.standard_normal(still.shape)
    made = presses(told, None)
    assert len(made.readings) == len(strong) > 15
    assert np.std(np.log(made.noise_std / noise)) < 0.15
    assert np.median(made.noise_std / noise) == pytest.approx(1.0, abs=0.1)
    off = (made.readings - strong) / made.noise
    assert 0.4 < np.sqrt(np.mean(off**2)) < 1.1
    clipped = presses(np.maximum(told, 0.0), None)
    assert 0.3 < clipped.clipped.mean() < 0.9
    assert np.abs((clipped.readings - strong) / noise)[~clipped.clipped].mean() < 0.5


def test_a_recording_of_counts_becomes_a_file_that_reconstruct_takes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in (("BURN", 20), ("ROUNDS", 4), ("SAMPLES", 3)):  # near enough, and quick
        monkeypatch.setattr(touch_sampling, name, value)
    monkeypatch.setattr(by_touch, "ERRORS", by_touch.ERRORS[:3])
    layout = tmp_path / "three.toml"
    sf.save_layout(PATCH, layout)
    readings = touches()[0]
    idle = NOISE * np.random.default_rng(3).standard_normal((100, 36))
    held = np.repeat(readings[:40], 4, axis=0)  # readings of each press
    counts = np.rint(20_000.0 + 20_000.0 * np.vstack([idle, held]))
    skin, cal = tmp_path / "presses.csv", tmp_path / "cal.toml"
    save_recording(Recording(np.arange(len(counts)) * 20_000_000, counts), skin)
    others, other = (
        np.rint(20_100.0 + 20_000.0 * np.vstack([idle, readings[40:]])),
        tmp_path / "b.csv",
    )
    save_recording(Recording(np.arange(len(others)) * 20_000_000, others), other)
    words = (skin, other, "--skin", layout, "--gain", 20_000)
    said = run("calibrate", "touch", *words, "-o", cal, "--report", tmp_path / "page", "--json")
    result = json.loads(next(line for line in said.splitlines() if line.startswith("{")))
    assert result["thickness_mm"] == pytest.approx(2.3, rel=0.12)
    assert result["relative"]
    assert "forces are relative" in result["verdict"]
    assert (tmp_path / "page" / "gain-of-each-taxel.png").stat().st_size > 10_000
    made = sf.load_calibration(cal, PATCH)
    np.testing.assert_allclose(made.readings(counts[100:]), held / made.gain, atol=5e-3)
    table = tmp_path / "contacts.csv"
    said = run("reconstruct", skin, "--skin", layout, "--calibration", cal, "-o", table)
    assert f"thickness {made.thickness * 1e3:.3f}" in said
    assert len(table.read_text().splitlines()) > 60
    forces = np.r_[np.zeros(100), np.repeat(touches()[2][:40], 4)]
    part, labels, short = slice(60, 160), tmp_path / "labels.csv", tmp_path / "c.csv"
    save_recording(Recording(np.arange(100) * 20_000_000, counts[part]), short)
    table = np.column_stack([0.02 * np.arange(100), 3.0 * forces[part]])
    np.savetxt(labels, table, delimiter=",", header="time_s,force_N", comments="")
    words = ("calibrate", "check", cal, short, labels, "--skin", layout, "--json")
    tried = json.loads(next(line for line in run(*words).splitlines() if line.startswith("{")))
    softer = (made.thickness / 2.3e-3) ** 3  # of a bonded layer that hardly changes its volume
    assert tried["factor"] == pytest.approx(3.0 * softer, rel=0.2)
    assert 0.05 < tried["rmse_N"] / tried["constant_rmse_N"] < 0.7
    assert "relative: one is" in tried["verdict"]
    assert "expected the layout beside it" in refused("calibrate", "check", cal, skin)
    save_calibration(
        sf.calibrate.force(PATCH, counts, forces),
        cal,
    )
    words = ("reconstruct", skin, "--skin", layout, "--calibration", cal)
    assert "which holds a ForceCalibration" in refused(*words)


@cache
def press_that_creeps() -> tuple[CubicSpline, CubicSpline, np.ndarray]:
    """A ball by the axisymmetric press at several loads: readings by distance, and its contact.

    And what a tenth of its pressure makes of the layer, whose contact stays.
    """
    layer, far = sf.Layer(2.3e-3, 150e3, 0.47), np.linspace(0.0, 40e-3, 161)
    places, parts = np.column_stack([far, 0.0 * far]), np.array([0.4, 0.8, 1.0, 1.2])
    balls = [Sphere(radius=6e-3, force=1.2 * part) for part in parts]
    every = [press(layer, [ball], 20e-3, 1e-3) for ball in balls]
    read = [each.capacitance(places, PATCH.pad_diameter) for each in every]
    whole = every[2]
    tenth = tuple(replace(t, traction=0.1 * t.traction) for t in whole.touches)
    left = replace(whole, touches=tenth).capacitance(places, PATCH.pad_diameter)
    by_load = CubicSpline(np.r_[0.0, parts], np.vstack([0.0 * far, read]))
    contact = np.log([whole.force, np.sqrt(whole.contact_area / np.pi)])
    return by_load, CubicSpline(far, 10.0 * left), contact


def touches_that_creep(
    solid: sf.StandardLinearSolid, seed: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Stamps, readings (T, L), press of each, and places and contacts of sixteen unsteady touches.

    The load's history is sampled each ms; readings come at uneven times.
    """
    rng, fine, far = (
        np.random.default_rng(seed),
        np.arange(0.0, 4.2, 1e-3),
        np.linspace(0, 40e-3, 161),
    )
    stamps, rows, row, touches, now = [], [], [], [], 10.0
    middle, half = PATCH.plane.mean(axis=0), 0.3 * np.ptp(PATCH.plane, axis=0)
    for number in range(16):
        by_load, left, contact = press_that_creeps()
        at, held = middle + rng.uniform(-half, half), rng.uniform(0.6, 1.6)
        load = np.clip(fine / 0.05, 0.0, 1.0) * np.clip((held - fine) / 0.05, 0.0, 1.0)
        load *= 1.0 + 0.1 * np.sin(4.0 * fine + number)
        felt = solid.effective_force(fine, load)
        away = np.linalg.norm(PATCH.plane - at, axis=1)
        touches.append([*at, *contact])
        for step in np.flatnonzero(rng.uniform(size=len(fine)) < 0.04):
            still = load[step] > 0.0
            read = np.interp(away, far, by_load(felt[step])) if still else felt[step] * left(away)
            rows.append(read)
            row.append(number if 0.3 < fine[step] < held - 0.1 else -1)
            stamps.append(now + fine[step])
        now += fine[-1]
    noise = NOISE * rng.standard_normal((len(rows), len(PATCH)))
    return np.rint(1e9 * np.array(stamps)), np.array(rows) + noise, np.array(row), np.array(touches)


@pytest.mark.parametrize(("share", "seconds"), [(0.15, 1.0), (0.08, 0.3), (0.3, 0.7)])
def test_relaxation_is_told_by_what_touches_leave(share: float, seconds: float) -> None:
    """However unsteady they were."""
    stamps, table, row, touches = touches_that_creep(sf.StandardLinearSolid(1 - share, seconds))
    tables = PressTables(sf.Layer(2.3e-3, 150e3, 0.47), sf.Capacitance(), PATCH.pad_diameter)
    skin, ones = np.array([np.log(2.3e-3), 0.47]), np.ones(len(PATCH))
    tables.centre_on(*skin)
    parts = row, touches, skin, ones, NOISE * ones, (tables, PATCH.plane)
    found = relaxation(traces(table, stamps.astype(np.int64), *parts))
    assert found is not None
    assert found.touches >= 12
    assert 1.0 - found.solid.relaxed_fraction == pytest.approx(share, abs=0.02)
    assert found.solid.time_constant == pytest.approx(seconds, rel=0.15)
    off = abs(1.0 - found.solid.relaxed_fraction - share) / found.share_std
    assert off < 3.0
    assert 0.0 < found.share_std < 0.03
    assert abs(found.solid.time_constant - seconds) < 3.0 * found.time_std


def test_an_elastic_skin_is_told_no_relaxation() -> None:
    stamps, table, row, touches = touches_that_creep(sf.StandardLinearSolid(1.0, 1.0))
    tables = PressTables(sf.Layer(2.3e-3, 150e3, 0.47), sf.Capacitance(), PATCH.pad_diameter)
    skin, ones = np.array([np.log(2.3e-3), 0.47]), np.ones(len(PATCH))
    tables.centre_on(*skin)
    parts = row, touches, skin, ones, NOISE * ones, (tables, PATCH.plane)
    assert relaxation(traces(table, stamps.astype(np.int64), *parts)) is None
    assert relaxation([]) is None


def test_a_file_holds_the_relaxation_and_every_door_undoes_it(tmp_path: Path) -> None:
    from skinfield.cli import options
    from skinfield.cli.settings import Elastomer, ModelSettings

    told = {"relaxed_fraction": 0.85, "relaxed_fraction_std": 0.01}
    told |= {"relaxation_time": 1.1, "relaxation_time_std": 0.1}
    made = replace(found(), **told)
    assert "creeps by 15.0% ± 1.0% within 1.1 ± 0.1 s" in made.verdict
    save_calibration(made, tmp_path / "cal.toml")
    again = sf.load_calibration(tmp_path / "cal.toml")
    assert again.relaxation == made.relaxation == sf.StandardLinearSolid(0.85, 1.1)
    assert sf.Reconstructor(PATCH, calibration=again).layer.relaxation == made.relaxation
    elastomer, _, _ = options.by_touch(str(tmp_path / "cal.toml"), Elastomer(), ModelSettings())
    assert options.layer_of(elastomer).relaxation == made.relaxation
    assert found().relaxation is None
    with pytest.raises(InputError, match="four numbers"):
        replace(made, relaxation_time=None)
    text = (tmp_path / "cal.toml").read_text().replace("fraction = 0.85", "fraction = 1.85")
    (tmp_path / "cal.toml").write_text(text)
    with pytest.raises(FileError, match="relaxed_fraction"):
        sf.load_calibration(tmp_path / "cal.toml")
    assert "creeps" not in found().verdict
