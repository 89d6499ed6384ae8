"""The non-negative field as a solver: its contract, idle patches, presses, settings, its page."""

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from non_negative_reference import (
    Dense,
    Either,
    made_model,
    pressed,
    search_of,
    small_model,
    solve,
)
from test_readme import doc, follow

import skinfield as sf
from skinfield.elastic import BaseStress, Capacitance, Layer
from skinfield.errors import InputError
from skinfield.simulate import Bar, Ring, Sphere, press
from skinfield.skin import Grid
from skinfield.solve import GaussianField, NonNegative
from skinfield.solve.contract import SolverContract, square_patch

BOTH = [BaseStress(), Capacitance()]


class TestNonNegative(SolverContract):
    solver = NonNegative()
    force_ratio = (0.93, 1.0)
    place_error = 0.3e-3


class TestWhiteCells(SolverContract):
    solver = NonNegative(length_scale=0.0)
    force_ratio = (0.5, 1.0)
    place_error = 0.6e-3
    left_out_change = 0.05


@pytest.mark.parametrize("quantity", BOTH)
@pytest.mark.parametrize("rate", [0.3, 0.05])
def test_false_alarms_stay_below_the_stated_rate(quantity: Either, rate: float) -> None:
    model = small_model(21, 6, quantity)
    operator = search_of(NonNegative(false_alarm_rate=rate), model)
    noise = np.random.default_rng(7).normal(size=(4000, len(model.taxels))) * model.noise_std
    answers = [(solve(operator, readings).any(), operator.idle) for readings in noise]
    alarms = np.mean([pressed for pressed, _ in answers])
    assert 0.1 * rate < alarms < rate  # nodes share taxels, so Boole's bound is not reached
    assert all(pressed != idle for pressed, idle in answers)


@pytest.mark.parametrize("quantity", BOTH)
@pytest.mark.parametrize("shrinkage", [0.0, 0.5, 1.0])
def test_idle_is_proved_exactly_below_the_threshold(quantity: Either, shrinkage: float) -> None:
    model = small_model(13, 5, quantity)
    solver = NonNegative(shrinkage=shrinkage, precision=np.float64)
    operator, dense = search_of(solver, model), Dense.of(solver, model)
    for seed in range(20):
        readings = pressed(model, np.random.default_rng(seed))
        at_threshold = readings * dense.threshold / dense.score(readings).max()
        assert not solve(operator, 0.999999 * at_threshold).any()
        assert operator.idle
        assert operator.gap == 0.0
        assert operator.objective == pytest.approx(
            0.5 * np.square(dense.target(0.999999 * at_threshold)).sum()
        )
        assert solve(operator, 1.000001 * at_threshold).any() or shrinkage == 1.0
        assert not operator.idle
        if shrinkage == 1.0:  # the test is then the very condition that 0 is the minimum
            assert not dense.minimum(0.999 * at_threshold).any()
            assert dense.minimum(1.01 * at_threshold).any()
            assert solve(operator, 1.01 * at_threshold).any()
    assert not solve(operator, np.zeros(len(readings))).any()
    assert operator.objective == 0.0


@pytest.fixture(scope="module", name="presses")
def _presses() -> dict[str, sf.simulate.Press]:
    layer = Layer(2e-3, 100e3, 0.5)
    bodies: dict[str, Any] = {
        "bar": Bar(length=16e-3, width=3e-3, force=2.0),
        "ring": Ring(inner_radius=4e-3, outer_radius=5e-3, force=2.0),
    }
    return {name: press(layer, [body], extent=28e-3, cell=0.4e-3) for name, body in bodies.items()}


@pytest.mark.parametrize("kind", ["bar", "ring"])
def test_the_field_of_a_capacitive_skin_keeps_its_force(
    kind: str, presses: dict[str, sf.simulate.Press]
) -> None:
    """Truth is the simulated press: a linear field's sum is about 0, this one's is not."""
    patch = sf.layouts.hexagon72()
    made = presses[kind]
    readings = made.readings(patch.plane - [4e-3, 3e-3], patch.pad_diameter, "capacitance")
    found = {}
    for solver in (GaussianField(), NonNegative()):
        rec = sf.Reconstructor(
            patch, made.layer, quantity=Capacitance(), noise_std=0.002, solver=solver
        )
        found[type(solver)] = rec(readings)
    force = {kind: float(est.normal_force) for kind, est in found.items()}
    assert abs(force[GaussianField]) < 0.3
    assert 0.8 < force[NonNegative] < 2.4  # of 2 N
    assert found[NonNegative].pressure.min() == 0.0
    assert found[NonNegative].contacts


def test_less_noise_leaves_less_error(presses: dict[str, sf.simulate.Press]) -> None:
    """What no pressure explains is not made of pressure: without noise it was twice the force."""
    patch, layer, errors = sf.layouts.hexagon72(), presses["bar"].layer, []
    ball = press(layer, [Sphere(radius=6e-3, force=2.0)], extent=28e-3, cell=0.4e-3)
    places = [patch.plane - at for at in np.random.default_rng(3).uniform(-9e-3, 9e-3, (8, 2))]
    made = [each for each in (*presses.values(), ball) for _ in places]
    clean = np.array(
        [
            each.readings(at, patch.pad_diameter, "capacitance")
            for each, at in zip(made, 3 * places, strict=True)
        ]
    )
    noise = np.random.default_rng(4).normal(size=clean.shape)
    for std in (4e-3, 5e-4, 1e-6):
        rec = sf.Reconstructor(
            patch, layer, quantity=Capacitance(), noise_std=std, solver=NonNegative()
        )
        errors.append(np.median(np.abs(rec(clean + std * noise).normal_force / 2.0 - 1.0)))
    assert errors[0] > 1.2 * errors[1]
    assert 0.08 < errors[2] < 1.25 * errors[1] < 0.25


@pytest.mark.parametrize("solver", [NonNegative(), GaussianField()], ids=repr)
def test_a_drift_that_taxels_share_is_no_contact(solver: Any) -> None:
    patch = sf.layouts.hexagon72()
    rec = sf.Reconstructor(patch, solver=solver, quantity=Capacitance(), noise_std=0.002)
    noise = np.random.default_rng(5).normal(0.0, 0.002, (300, 72))
    for drift in (-0.005, 0.0, 0.005):
        assert sum(map(len, rec(noise + drift).contacts)) <= 2


def test_through_a_reconstructor_taxels_may_be_missing() -> None:
    patch = square_patch(side=6)
    rec = sf.Reconstructor(
        patch,
        grid=Grid.square(patch, nodes=25),
        quantity=BaseStress(),
        noise_std=20.0,
        solver=NonNegative(),
    )
    readings = pressed(rec.model, np.random.default_rng(1))
    whole = rec(readings)
    readings[0] = np.nan
    part = rec(np.stack([readings, np.where(np.isnan(readings), np.nan, 0.0)]), deadline=1.0)
    assert whole.gap <= 1e-4
    assert whole.deadline_met
    assert whole.iterations > 0
    assert (part.gap <= 1e-4).all()
    assert part.gap[1] == 0.0  # idle
    rushed = rec(readings, deadline=1e-9)
    assert not rushed.deadline_met
    assert 0.0 <= rushed.gap <= 1.0
    assert rushed.pressure.min() >= 0.0
    assert whole.pressure.max() > 0
    assert np.isfinite(part.pressure).all()
    assert part.pressure.min() == 0.0
    assert part[0].pressure.max() > 0
    assert not part[1].pressure.any()


def test_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow(doc("fields")) == (2, 0)
    pressure, proof, sheet, _ = capsys.readouterr().out.splitlines()
    assert pressure.endswith("N of 2 N, least pressure 0 Pa")
    assert 1.0 < float(pressure.split()[0]) < 2.4
    gap, steps, met, took = proof.split(", ")
    assert 0.0 <= float(gap.split()[1]) <= 1.0
    assert steps.endswith(" steps")
    assert met in ("in time", "late")
    assert took.endswith(" µs")
    assert float(sheet.split()[-5]) == pytest.approx(11.6, abs=0.3)  # "... N of 15.0 N"


def test_settings_are_checked() -> None:
    cases: tuple[tuple[str, Any, str], ...] = (
        ("snr", 0.0, "snr is 0.0, expected a finite number above 0"),
        ("length_scale", -1.0, "length_scale is -1.0, expected a finite number above 0"),
        ("false_alarm_rate", 0.0, "false_alarm_rate is 0.0, expected a number from 1e-12"),
        ("shrinkage", 1.5, "shrinkage is 1.5, expected a number from 0 to 1"),
        ("common_mode", -1.0, "common_mode is -1.0, expected a number from 0 to 1000: in standard"),
        ("model_error", 2.0, "model_error is 2.0, expected a number from 0 to 1: part of the"),
        ("tolerance", 0.0, "tolerance is 0.0, expected a number from 1e-12 to 1"),
        ("most_iterations", 0, "most_iterations is 0, expected 1 or more"),
        ("precision", np.int32, "precision is .*, expected numpy.float32 or numpy.float64"),
    )
    for name, value, said in cases:
        with pytest.raises(InputError, match=said):
            NonNegative(**{name: value})
    blind = made_model(np.zeros((3, 9)), (3, 3))
    with pytest.raises(InputError, match="no taxel sees any node"):
        search_of(NonNegative(), blind)
    operator = search_of(NonNegative(), small_model())
    with pytest.raises(InputError, match="has shape"):
        operator.without(np.ones(7, dtype=bool))


def test_a_length_longer_than_the_grid_is_no_harm_but_there_is_an_end() -> None:
    model = small_model()
    readings = pressed(model, np.random.default_rng(1))
    found = solve(search_of(NonNegative(length_scale=20e-3), model), readings)  # the grid is 16 mm
    assert np.isfinite(found).all()
    assert found.min() >= 0.0
    with pytest.raises(InputError, match=r"length_scale is 500 mm on nodes .* expected at most"):
        search_of(NonNegative(length_scale=0.5), model)


def test_the_clock_is_that_of_the_deadline() -> None:
    from skinfield.solve.clock import now_ns

    room = np.zeros(2, dtype=np.int64)
    for _ in range(100):
        before = time.perf_counter_ns()
        inside = now_ns(room)
        assert before <= inside <= time.perf_counter_ns()
