"""The non-negative field: against scipy's NNLS, its optimality conditions, and presses."""

import time
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_triangular
from scipy.optimize import nnls
from test_readme import ROOT, follow

import skinfield as sf
from skinfield.errors import Floats, InputError
from skinfield.inverse import GaussianField, NonNegative
from skinfield.inverse.non_negative_operator import NonNegativeOperator
from skinfield.inverse.non_negative_prior import matern_precision
from skinfield.layout import Grid
from skinfield.mechanics import BondedLayer, Layer
from skinfield.observation import BaseStress, Capacitance, ObservationModel
from skinfield.simulate import Bar, Ring, press
from skinfield.testing import SolverContract
from skinfield.testing.solver import square_patch

Either = BaseStress | Capacitance
EXACT = 1e-9  # tolerance: until rounding leaves nothing to gain


class TestNonNegative(SolverContract):
    solver = NonNegative()
    force_ratio = (0.95, 1.05)
    place_error = 0.3e-3


@lru_cache(maxsize=8)
def small_model(nodes: int = 13, side: int = 5, quantity: Either | None = None) -> ObservationModel:
    patch = square_patch(side=side)
    quantity = BaseStress() if quantity is None else quantity
    noise = 20.0 if isinstance(quantity, BaseStress) else 0.002
    grid = Grid.square(patch, nodes=nodes)
    return ObservationModel.of(patch, Layer(), grid, BondedLayer(), quantity, noise)


def random_model(rng: np.random.Generator, shape: tuple[int, int], taxels: int) -> ObservationModel:
    """Any matrix at all on a small lattice."""
    patch = square_patch(side=3)
    grid = Grid(patch, shape, 2e-3, np.zeros(2))
    return ObservationModel(
        matrix=rng.normal(size=(taxels, len(grid))) * 10.0 ** rng.uniform(-9, 3),
        noise_std=10.0 ** rng.uniform(-4, 3, taxels),
        taxels=rng.uniform(0, 0.01, (taxels, 2)),
        grid=grid,
        virtual_matrix=lambda points: np.zeros((len(points), len(grid))),
    )


def pressed(model: ObservationModel, rng: np.random.Generator, places: int = 3) -> Floats:
    """Readings (L,) of some patches of pressure of many times the noise, with noise."""
    truth = np.zeros(model.grid.shape)
    for _ in range(places):
        row, column = (int(rng.integers(0, n)) for n in truth.shape)
        truth[row : row + 3, column : column + 4] = rng.uniform(0.3, 1.0)
    clean = model.matrix @ truth.ravel()
    clean *= 50.0 / max(np.abs(clean / model.noise_std).max(), 1e-300)
    return np.asarray(clean + rng.normal(size=len(clean)) * model.noise_std)


def precision_of(operator: NonNegativeOperator) -> Floats:
    """The prior's precision as a dense matrix (K, K)."""
    row, column = np.divmod(np.arange(np.prod(operator.shape)), operator.shape[1])
    table = operator.precision.table
    reach = len(table) // 2
    down, aside = row[:, None] - row, column[:, None] - column
    near = (np.abs(down) <= reach) & (np.abs(aside) <= reach)
    dense = np.zeros(down.shape)
    dense[near] = table[down[near] + reach, aside[near] + reach]
    return dense


def curvature_and_slope(operator: NonNegativeOperator, readings: Floats) -> tuple[Floats, Floats]:
    """H (K, K) and slope at 0 (K,) of the objective, densely."""
    rows = operator.signatures
    slope = operator.penalty - rows @ (readings * operator.whitening)
    return rows @ rows.T + precision_of(operator), slope


def by_nnls(operator: NonNegativeOperator, readings: Floats) -> Floats:
    """The same minimum from scipy: least squares of the Cholesky factor."""
    curvature, slope = curvature_and_slope(operator, readings)
    scale = 1 / np.sqrt(np.diag(curvature))
    lower = np.linalg.cholesky(curvature * np.outer(scale, scale))
    target = solve_triangular(lower, -slope * scale, lower=True)
    return np.asarray(nnls(lower.T, target, maxiter=100 * len(slope))[0] * scale)


def solve(operator: NonNegativeOperator, readings: Floats, deadline: int | None = None) -> Floats:
    out = np.full(len(operator.signatures), np.nan)
    operator.apply(readings, out, deadline)
    return out


def objective(operator: NonNegativeOperator, readings: Floats, pressure: Floats) -> float:
    curvature, slope = curvature_and_slope(operator, readings)
    return float(0.5 * pressure @ curvature @ pressure + slope @ pressure)


@pytest.mark.parametrize("quantity", [BaseStress(), Capacitance()])
@pytest.mark.parametrize("shrinkage", [0.0, 0.3, 1.0])
def test_it_is_the_minimum_that_nnls_finds(quantity: Either, shrinkage: float) -> None:
    model = small_model(17, 5, quantity)
    operator = NonNegative(shrinkage=shrinkage, tolerance=EXACT).prepare(model)
    for seed in range(3):
        readings = pressed(model, np.random.default_rng(seed))
        expected = by_nnls(operator, readings)
        assert expected.any()
        assert solve(operator, readings) == pytest.approx(expected, abs=1e-8 * expected.max())
        assert operator.objective == pytest.approx(objective(operator, readings, expected))


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    shape=st.tuples(st.integers(1, 9), st.integers(1, 9)),
    taxels=st.integers(1, 30),
    snr=st.floats(0.1, 300.0),
    length=st.floats(0.1e-3, 20e-3),
    shrinkage=st.floats(0.0, 1.0),
)
def test_any_problem_is_solved(
    seed: int, shape: tuple[int, int], taxels: int, snr: float, length: float, shrinkage: float
) -> None:
    rng = np.random.default_rng(seed)
    model = random_model(rng, shape, taxels)
    solver = NonNegative(
        snr=snr, length_scale=length, shrinkage=shrinkage, tolerance=1e-6, false_alarm_rate=0.5
    )
    operator = solver.prepare(model)
    for _ in range(3):  # the second and third start from the one before
        readings = pressed(model, rng, 1) * 10.0 ** rng.uniform(-2, 2)
        found = solve(operator, readings)
        assert np.isfinite(found).all()
        assert found.min() >= 0.0
        assert 2 * operator.gap <= 1e-12 * max(1.0, -1e2 * operator.objective)
        score = operator.signatures @ (readings * operator.whitening) / operator.strength
        if score.max() > operator.threshold:
            expected = by_nnls(operator, readings)
            least = objective(operator, readings, expected)
            assert operator.objective <= least + 1e-9 * abs(least) + 1e-9
        else:
            assert not found.any()


def test_slope_and_pressure_are_complementary() -> None:
    model = small_model(31, 7)
    operator = NonNegative(tolerance=EXACT).prepare(model)
    readings = pressed(model, np.random.default_rng(5))
    found = solve(operator, readings)
    curvature, slope = curvature_and_slope(operator, readings)
    slope = curvature @ found + slope
    scale = np.abs(operator.signatures @ (readings * operator.whitening)).max()
    assert found.min() == 0.0
    assert found.any()
    assert slope.min() > -1e-9 * scale
    assert np.abs(slope[found > 0]).max() < 1e-9 * scale


def test_the_gap_bounds_objective_and_sums() -> None:
    model = small_model(21, 6)
    readings = pressed(model, np.random.default_rng(2), places=6)
    best = NonNegative(tolerance=EXACT).prepare(model)
    exact = solve(best, readings)
    least = best.objective
    weights = np.random.default_rng(3).normal(size=(50, len(exact)))
    spread = np.sqrt(np.diagonal(best.posterior.covariance_of_sums(np.arange(len(exact)), weights)))
    gaps, missing = [], []
    for steps in range(1, best.iterations + 1):
        operator = NonNegative(tolerance=EXACT, most_iterations=steps).prepare(model)
        found = solve(operator, readings)
        assert operator.iterations == steps
        assert operator.objective - least <= operator.gap + 1e-9
        bound = np.sqrt(2 * operator.gap) * spread
        assert (np.abs(weights @ (found - exact)) <= bound + 1e-9 * np.abs(exact).max()).all()
        gaps.append(operator.gap)
        missing.append(operator.objective - least)
    assert (np.diff(missing) < 1e-9).all()  # more steps never make it worse
    assert missing[0] > 1.0
    assert gaps[-1] < 1e-9


def test_a_deadline_leaves_something_feasible_and_time_improves_it() -> None:
    model = small_model(41, 9)
    operator = NonNegative(tolerance=EXACT).prepare(model)
    readings = pressed(model, np.random.default_rng(4), places=8)
    exact = solve(operator, readings)
    least = operator.objective
    before = 0.0
    for allowed in (-1_000_000, 0, 200_000, 1_000_000, 3_000_000, 10_000_000_000):
        operator.reset()
        found = solve(operator, readings, time.perf_counter_ns() + allowed)
        assert found.min() >= 0.0
        assert operator.objective <= 0.0
        assert operator.objective >= least - 1e-9
        before = min(before, operator.objective)
    assert found == pytest.approx(exact, abs=1e-9 * exact.max())
    late = solve(operator, readings, time.perf_counter_ns() - 1)
    assert late == pytest.approx(exact, abs=1e-9 * exact.max())  # starts from the one before


def test_a_chain_of_noisy_readings_ends_where_each_alone_would() -> None:
    model = small_model(25, 6, Capacitance())
    warm, cold = (NonNegative(tolerance=1e-5).prepare(model) for _ in range(2))
    rng = np.random.default_rng(6)
    clean = pressed(model, rng)
    for index in range(300):
        if index % 50 == 0:
            clean = pressed(model, rng)
        readings = clean + rng.normal(size=len(clean)) * model.noise_std
        if index % 37 == 36:
            readings = rng.normal(size=len(clean)) * model.noise_std
        found = solve(warm, readings)
        cold.reset()
        expected = solve(cold, readings)
        assert warm.gap <= 1e-10 / 2
        assert found == pytest.approx(expected, abs=1e-4 * max(expected.max(), 1.0))


def test_an_idle_patch_stays_at_zero_as_often_as_stated() -> None:
    model = small_model(25, 6, Capacitance())
    operator = NonNegative(false_alarm_rate=0.05).prepare(model)
    noise = np.random.default_rng(7).normal(size=(4000, len(model.taxels))) * model.noise_std
    alarms = np.mean([solve(operator, readings).any() for readings in noise])
    assert 0.01 < alarms < 0.05  # nodes share taxels, so Boole's bound is not reached


def test_with_full_shrinkage_zero_is_the_minimum_exactly_below_the_threshold() -> None:
    model = small_model()
    operator = NonNegative(shrinkage=1.0, tolerance=EXACT).prepare(model)
    readings = pressed(model, np.random.default_rng(8))
    score = operator.signatures @ (readings * operator.whitening) / operator.strength
    at_threshold = readings * operator.threshold / score.max()
    assert not solve(operator, 0.999 * at_threshold).any()
    assert not by_nnls(operator, 0.999 * at_threshold).any()
    assert solve(operator, 1.001 * at_threshold).any()
    assert not solve(operator, np.zeros(len(readings))).any()


def test_the_precision_is_the_inverse_of_a_larger_covariance() -> None:
    grid = Grid(square_patch(side=3), (21, 21), 1e-3, np.zeros(2))
    distance = np.linalg.norm(grid.plane[:, None] - grid.plane[None], axis=-1)
    scaled = np.sqrt(3) * distance / 1.3e-3
    dense = np.linalg.inv(7.0 * (1 + scaled) * np.exp(-scaled))
    middle = 10 * 21 + 10
    found = matern_precision(grid, 1.3e-3, 7.0)
    reach = len(found.table) // 2
    near = dense[middle].reshape(21, 21)
    inside = slice(10 - min(reach, 6), 10 + min(reach, 6) + 1)
    part = slice(reach - min(reach, 6), reach + min(reach, 6) + 1)
    assert found.table[part, part] == pytest.approx(near[inside, inside], abs=1e-6 * near.max())
    largest = np.linalg.eigvalsh(np.linalg.inv(dense))[-1]
    assert largest < found.largest_variance < 1.2 * largest


def test_where_nothing_is_negative_it_is_the_gaussian_field() -> None:
    model = small_model(31, 9)
    linear = GaussianField(snr=1.0, length_scale=3e-3).prepare(model)
    readings = model.matrix @ np.full(len(model.grid), 5e3)
    expected = linear.matrix @ readings
    assert expected.min() > 0
    solver = NonNegative(snr=1.0, length_scale=3e-3, shrinkage=0.0)
    found = solve(solver.prepare(model), readings).reshape(31, 31)
    middle = slice(10, 21)  # the prior differs at the border alone, where this one is 0 beyond
    assert found[middle, middle] == pytest.approx(
        expected.reshape(31, 31)[middle, middle], rel=0.02
    )


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
    assert whole.pressure.max() > 0
    assert np.isfinite(part.pressure).all()
    assert part.pressure.min() == 0.0
    assert part[0].pressure.max() > 0
    assert not part[1].pressure.any()


def test_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow(ROOT / "docs" / "non-negative.md") == (1, 0)
    said = capsys.readouterr().out
    assert said.endswith("N of 2 N, least pressure 0 Pa\n")
    assert 1.0 < float(said.split()[0]) < 2.4


def test_the_unit_of_the_readings_does_not_matter() -> None:
    model = small_model()
    scaled = ObservationModel(
        model.matrix * 1e-6, model.noise_std * 1e-6, model.taxels, model.grid, model.virtual_matrix
    )
    readings = pressed(model, np.random.default_rng(9))
    expected = solve(NonNegative(tolerance=EXACT).prepare(model), readings)
    found = solve(NonNegative(tolerance=EXACT).prepare(scaled), readings * 1e-6)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * expected.max())


def test_settings_are_checked() -> None:
    cases: tuple[tuple[str, Any, str], ...] = (
        ("snr", 0.0, "snr is 0.0, expected a finite number above 0"),
        ("length_scale", -1.0, "length_scale is -1.0, expected a finite number above 0"),
        ("false_alarm_rate", 0.0, "false_alarm_rate is 0.0, expected a number from 1e-12"),
        ("shrinkage", 1.5, "shrinkage is 1.5, expected a number from 0 to 1"),
        ("tolerance", 0.0, "tolerance is 0.0, expected a finite number above 0"),
        ("most_iterations", 0, "most_iterations is 0, expected 1 or more"),
    )
    for name, value, said in cases:
        with pytest.raises(InputError, match=said):
            NonNegative(**{name: value})
    with pytest.raises(
        InputError, match=r"length_scale is 1000 mm on nodes .* expected at most 32"
    ):
        NonNegative(length_scale=1.0).prepare(small_model())
