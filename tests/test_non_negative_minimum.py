"""The minimum of `NonNegative` against scipy's NNLS and its conditions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from non_negative_reference import (
    Dense,
    Either,
    amounts_of,
    assert_proved,
    bumps,
    made_model,
    pressed,
    random_model,
    small_model,
    solve,
    solved,
)

import skinfield as sf
from skinfield.elastic import BaseStress, BondedLayer, Capacitance, Layer, ObservationModel
from skinfield.errors import Floats
from skinfield.skin import Grid
from skinfield.solve import NonNegative

EXACT = 1e-12  # tolerance: until rounding leaves nothing to gain
PRECISIONS = {np.float64: 1e-11, np.float32: 1e-4}  # gaps that are proved then
BOTH = [BaseStress(), Capacitance()]


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("quantity", BOTH)
@pytest.mark.parametrize(
    ("length", "shrinkage"), [(0.0, 0.0), (0.0, 0.5), (None, 0.0), (None, 0.5), (3e-3, 1.0)]
)
def test_it_is_the_minimum_that_nnls_finds(
    quantity: Either, length: float | None, shrinkage: float, precision: type[np.floating]
) -> None:
    model = small_model(13, 5, quantity)
    solver = NonNegative(
        length_scale=length, shrinkage=shrinkage, tolerance=EXACT, precision=precision
    )
    operator, dense = solver.prepare(model), Dense.of(solver, model)
    for seed in range(3):
        readings = pressed(model, np.random.default_rng(seed))
        pressure = solve(operator, readings)
        assert pressure.any()
        assert_proved(operator, dense, readings, pressure, PRECISIONS[precision])
    by_rows, by_squares = dense.minimum(readings), dense.minimum_by_squares(readings)
    assert by_rows == pytest.approx(by_squares, abs=1e-8 * by_rows.max())  # two NNLS, one minimum


@pytest.mark.parametrize("nodes", [10, 20])
@pytest.mark.parametrize("quantity", BOTH)
def test_so_it_is_on_the_papers_patch(nodes: int, quantity: Either) -> None:
    patch = sf.layouts.hexagon72()
    noise = quantity.typical_noise
    model = ObservationModel.of(
        patch, Layer(), Grid.square(patch, nodes), BondedLayer(), quantity, noise
    )
    for solver in (NonNegative(tolerance=EXACT), NonNegative(tolerance=EXACT, length_scale=0.0)):
        operator, dense = solver.prepare(model), Dense.of(solver, model)
        readings = pressed(model, np.random.default_rng(nodes), 4)
        assert_proved(operator, dense, readings, solve(operator, readings), 1e-5)


@settings(max_examples=80, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    shape=st.tuples(st.integers(1, 8), st.integers(1, 8)),
    taxels=st.integers(1, 30),
    snr=st.floats(0.1, 300.0),
    length=st.one_of(st.just(0.0), st.floats(0.1e-3, 20e-3)),
    shrinkage=st.floats(0.0, 1.0),
    precision=st.sampled_from([np.float32, np.float64]),
)
def test_any_problem_is_solved(
    seed: int,
    shape: tuple[int, int],
    taxels: int,
    snr: float,
    length: float,
    shrinkage: float,
    precision: type[np.floating],
) -> None:
    """Matrices of both signs, more or fewer nodes than taxels, readings of any size."""
    rng = np.random.default_rng(seed)
    model = random_model(rng, shape, taxels)
    solver = NonNegative(
        snr=snr,
        length_scale=length,
        shrinkage=shrinkage,
        tolerance=1e-5,
        false_alarm_rate=0.5,
        precision=precision,
    )
    operator, dense = solver.prepare(model), Dense.of(solver, model)
    assert operator.threshold == pytest.approx(dense.threshold)
    for _ in range(3):  # the second and third start from the one before
        readings = pressed(model, rng, 1) * 10.0 ** rng.uniform(-2, 3)
        found = solve(operator, readings)
        amounts = amounts_of(operator)
        assert np.isfinite(found).all()
        assert found.min() >= 0.0
        assert 0.0 <= operator.gap <= 1.0
        highest = max(found.max(), 1e-300)
        assert found == pytest.approx(dense.bumps @ amounts, rel=1e-4, abs=1e-5 * highest)
        if operator.idle:
            assert dense.score(readings).max() <= dense.threshold * (1 + 1e-5)
            continue
        assert dense.score(readings).max() >= dense.threshold * (1 - 1e-5)
        value = dense.objective(amounts, readings)
        least = dense.objective(dense.minimum_by_squares(readings), readings)
        assert operator.objective == pytest.approx(value, rel=2e-5)
        assert value - least <= (operator.gap + 1e-9) * value
        assert operator.gap <= 1e-4


@pytest.mark.parametrize("quantity", BOTH)
def test_slope_and_amounts_are_complementary(quantity: Either) -> None:
    model = small_model(31, 7, quantity)
    solver = NonNegative(tolerance=EXACT, precision=np.float64)
    operator, dense = solver.prepare(model), Dense.of(solver, model)
    readings = pressed(model, np.random.default_rng(5))
    solve(operator, readings)
    amounts, white = amounts_of(operator), readings / dense.noise
    slope = dense.seen.T @ (dense.seen @ amounts - white) + amounts + dense.penalty
    scale = np.abs(dense.seen.T @ white).max()
    assert amounts.min() == 0.0
    assert amounts.any()
    assert slope.min() > -1e-6 * scale
    assert np.abs(slope[amounts > 0]).max() < 1e-6 * scale


def test_the_dual_is_what_the_readings_lack() -> None:
    model = small_model()
    solver = NonNegative(tolerance=EXACT, precision=np.float64)
    operator, dense = solver.prepare(model), Dense.of(solver, model)
    readings = pressed(model, np.random.default_rng(6))
    expected = readings / dense.noise - dense.seen @ dense.minimum(readings)
    solve(operator, readings)
    assert operator.dual == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("taxels", [1, 2, 3])
def test_a_patch_of_few_taxels(taxels: int) -> None:
    patch = sf.Patch(np.array([[0.0, 0.0], [5e-3, 0.0], [0.0, 5e-3]])[:taxels], pad_diameter=3e-3)
    grid = Grid.window(patch, (-6e-3, -6e-3), (6e-3, 6e-3), pitch=1e-3)
    model = ObservationModel.of(patch, Layer(), grid, BondedLayer(), BaseStress(), 20.0)
    solver = NonNegative(tolerance=EXACT, precision=np.float64, length_scale=1.5e-3)
    operator, dense = solver.prepare(model), Dense.of(solver, model)
    readings = np.array([4e3, 2e3, 1e3])[:taxels]
    pressure = solve(operator, readings)
    assert pressure.max() > 0
    assert_proved(operator, dense, readings, pressure, 1e-11)


def test_a_taxel_without_a_signature_tells_nothing() -> None:
    matrix = np.abs(np.random.default_rng(0).normal(size=(6, 25)))
    matrix[2] = 0.0
    matrix[:, 7] = 0.0  # nor a node that no taxel sees
    solver = NonNegative(length_scale=0.0, tolerance=EXACT, precision=np.float64)
    model = made_model(matrix, (5, 5))
    operator = solver.prepare(model)
    readings = 50.0 * matrix[:, 3] + 20.0 * matrix[:, 12]
    first = solved(operator, readings)
    assert first.max() > 0.0
    assert first[7] == 0.0
    readings[2] = 1e2
    assert solved(operator, readings) == pytest.approx(first, abs=1e-5 * first.max())
    only = np.zeros(6)
    only[2] = 1e6
    assert not solved(operator, only).any()
    assert operator.idle


@pytest.mark.parametrize("length", [1e-3, 2.5e-3, 6e-3])
def test_bumps_make_the_covariance_they_are_a_root_of(length: float) -> None:
    """A node's variance is that of the sum of squares of bumps; away from it Matérn-3/2."""
    grid = Grid(small_model().grid.patch, (41, 41), 1e-3, np.zeros(2))
    model = ObservationModel(
        np.ones((1, 41 * 41)), np.ones(1), np.zeros((1, 2)), grid, lambda _: np.ones((1, 41 * 41))
    )
    spread = bumps(model, length)
    assert spread.min() >= 0.0
    middle = 20 * 41 + 20
    found = spread[middle] @ spread
    distance = np.linalg.norm(grid.plane - grid.plane[middle], axis=1)
    scaled = np.sqrt(3.0) * distance / length
    expected = (1.0 + scaled) * np.exp(-scaled)
    assert found[middle] == pytest.approx(1.0, rel=1e-3)
    assert np.abs(found - expected).max() < 0.04


def test_where_nothing_is_negative_it_is_the_gaussian_field() -> None:
    model = small_model(31, 9)
    linear = sf.GaussianField(snr=1.0, length_scale=3e-3).prepare(model)
    readings = model.matrix @ np.full(len(model.grid), 5e3)
    expected = linear.matrix @ readings
    assert expected.min() > 0
    solver = NonNegative(snr=1.0, length_scale=3e-3, shrinkage=0.0)
    found = solve(solver.prepare(model), readings).reshape(31, 31)
    middle = slice(10, 21)  # the prior differs at the border alone, where bumps are cut
    assert found[middle, middle] == pytest.approx(
        expected.reshape(31, 31)[middle, middle], rel=0.02
    )


def test_the_unit_of_the_readings_does_not_matter() -> None:
    model = small_model()
    scaled = ObservationModel(
        model.matrix * 1e-6, model.noise_std * 1e-6, model.taxels, model.grid, model.virtual_matrix
    )
    readings: Floats = pressed(model, np.random.default_rng(9))
    solver = NonNegative(tolerance=EXACT, precision=np.float64)
    expected = solve(solver.prepare(model), readings)
    found = solve(solver.prepare(scaled), readings * 1e-6)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * expected.max())
