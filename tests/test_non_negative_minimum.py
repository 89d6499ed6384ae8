"""The minimum of `NonNegative` against scipy's NNLS, and what it proves when it is interrupted."""

import time
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from non_negative_reference import (
    Dense,
    Either,
    Search,
    amounts_of,
    assert_proved,
    bumps,
    made_model,
    pressed,
    random_model,
    search_of,
    small_model,
    solve,
    solved,
)

import skinfield as sf
from skinfield.elastic import BaseStress, BondedLayer, Capacitance, Layer, ObservationModel
from skinfield.errors import Floats
from skinfield.skin import Grid
from skinfield.solve import NonNegative, non_negative
from skinfield.solve.dual.problem import DROPPED, MOST, PENALTY

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
    operator, dense = search_of(solver, model), Dense.of(solver, model)
    for seed in range(3):
        readings = pressed(model, np.random.default_rng(seed))
        pressure = solve(operator, readings)
        assert pressure.any()
        assert_proved(operator, dense, readings, pressure, PRECISIONS[precision])
    by_rows, by_squares = dense.minimum(readings), dense.minimum_by_squares(readings)
    assert by_rows == pytest.approx(by_squares, abs=1e-8 * by_rows.max())  # two NNLS, one minimum


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
    operator, dense = search_of(solver, model), Dense.of(solver, model)
    assert operator.problem.threshold == pytest.approx(dense.threshold)
    for _ in range(3):  # the second and third start from the one before
        readings = pressed(model, rng, 1) * 10.0 ** rng.uniform(-2, 3)
        found = solve(operator, readings)
        amounts = amounts_of(operator)
        assert np.isfinite(found).all()
        assert found.min() >= 0.0
        assert 0.0 <= operator.gap <= 1.0
        highest = max(found.max(), 1e-300)
        expected = dense.scale(readings) * dense.bumps @ amounts
        assert found == pytest.approx(expected, rel=1e-4, abs=1e-5 * highest)
        if operator.idle:
            assert dense.score(readings).max() <= dense.threshold * (1 + 1e-5)
            continue
        assert dense.score(readings).max() >= dense.threshold * (1 - 1e-5)
        value = dense.objective(amounts, readings)
        least = dense.objective(dense.minimum_by_squares(readings), readings)
        assert operator.objective == pytest.approx(value, rel=2e-5)
        assert value - least <= (operator.gap + 1e-9) * value
        assert operator.gap <= 1e-4


def test_the_dual_is_what_the_readings_lack() -> None:
    model = small_model()
    solver = NonNegative(tolerance=EXACT, precision=np.float64)
    operator, dense = search_of(solver, model), Dense.of(solver, model)
    readings = pressed(model, np.random.default_rng(6))
    expected = dense.target(readings) - dense.seen @ dense.minimum(readings)
    solve(operator, readings)
    assert operator.dual == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def test_a_taxel_without_a_signature_tells_nothing() -> None:
    matrix = np.abs(np.random.default_rng(0).normal(size=(6, 25)))
    matrix[2] = 0.0
    matrix[:, 7] = 0.0  # nor a node that no taxel sees
    free = {"common_mode": 0.0, "model_error": 0.0}  # else it tells of the offset, or the highest
    solver = NonNegative(length_scale=0.0, tolerance=EXACT, precision=np.float64, **free)
    model = made_model(matrix, (5, 5))
    operator = search_of(solver, model)
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
    linear = sf.GaussianField(snr=1.0, length_scale=3e-3, common_mode=0.0).prepare(model)
    readings = model.matrix @ np.full(len(model.grid), 5e3)
    expected = linear.matrix @ readings
    assert expected.min() > 0
    free = {"shrinkage": 0.0, "common_mode": 0.0, "model_error": 0.0}
    solver = NonNegative(snr=1.0, length_scale=3e-3, **free)
    found = solve(search_of(solver, model), readings).reshape(31, 31)
    middle = slice(10, 21)  # the prior differs at the border alone, where bumps are cut
    assert found[middle, middle] == pytest.approx(
        expected.reshape(31, 31)[middle, middle], rel=0.02
    )


LOOSE = 1e-6  # share of the objective that single precision may be off


@lru_cache(maxsize=4)
def large(quantity: Either) -> tuple[Search, Dense, list[tuple[Floats, float, float]]]:
    """A problem of many steps: operator, its algebra, readings with the least and zero's value."""
    model = small_model(24, 7, quantity)
    solver = NonNegative(tolerance=1e-6)
    dense = Dense.of(solver, model)
    rng = np.random.default_rng(3)
    readings = [pressed(model, rng, 5) * size for size in (0.3, 1.0, 10.0)]
    least = [dense.objective(dense.minimum_by_squares(each), each) for each in readings]
    zero = [dense.objective(np.zeros(len(model.grid)), each) for each in readings]
    return search_of(solver, model), dense, list(zip(readings, least, zero, strict=True))


def assert_honest(
    operator: Search, dense: Dense, readings: Floats, least: float, zero: float
) -> float:
    """The gap is not below the true one and the answer no worse than 0; returns its objective."""
    amounts = amounts_of(operator)
    assert amounts.min() >= 0.0
    assert np.isfinite(amounts).all()
    reached = dense.objective(amounts, readings)
    assert reached <= zero * (1 + LOOSE)
    assert operator.objective == pytest.approx(reached, rel=20 * LOOSE)
    assert 0.0 <= operator.gap <= 1.0
    assert (reached - least) / reached <= operator.gap + LOOSE
    return reached


@pytest.mark.parametrize("precision", [np.float32, np.float64])
@pytest.mark.parametrize("quantity", BOTH)
def test_more_steps_never_make_it_worse_and_each_is_proved(
    quantity: Either, precision: type[np.floating]
) -> None:
    _, dense, cases = large(quantity)
    model = small_model(24, 7, quantity)
    whole = search_of(NonNegative(tolerance=1e-6, precision=precision), model)
    for readings, least, zero in cases:
        before, gaps = np.inf, []
        for most in range(1, 40):
            numbers = whole.problem.numbers.copy()
            numbers[MOST] = most
            problem = whole.problem._replace(numbers=numbers)
            operator = Search(replace(whole.operator, problem=problem))
            solve(operator, readings)
            reached = assert_honest(operator, dense, readings, least, zero)
            assert operator.steps <= most
            assert reached <= before * (1 + LOOSE)
            before = reached
            gaps.append(operator.gap)
            if operator.steps < most:
                break
        assert gaps[-1] <= 1e-5
        assert len(gaps) > 3


@settings(max_examples=150, deadline=None)
@given(
    quantity=st.sampled_from(BOTH),
    which=st.integers(0, 2),
    allowed=st.one_of(st.integers(-5_000, 2_000), st.integers(0, 1_000_000), st.just(-(10**19))),
    warm=st.booleans(),
)
def test_whatever_the_deadline_the_proof_holds(
    quantity: Either, which: int, allowed: int, warm: bool
) -> None:
    operator, dense, cases = large(quantity)
    if not warm:
        operator.reset()
    readings, least, zero = cases[which]
    out = np.full(len(dense.penalty), np.nan)
    limit = max(time.perf_counter_ns() + allowed, -(10**18))  # before the clock's start, too
    operator.apply(readings, out, limit)
    after = time.perf_counter_ns()
    assert_honest(operator, dense, readings, least, zero)
    want = dense.scale(readings) * dense.bumps @ amounts_of(operator)
    assert out.min() >= 0.0
    assert (np.abs(out - want) <= np.maximum(1e-4 * want, 1e-5 * max(out.max(), 1.0))).all()
    if after < limit:
        assert operator.in_time
    if allowed <= 0:
        assert not operator.in_time
        assert operator.steps == 0


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-8, 1e-12])
def test_no_tolerance_is_too_strict_for_single_precision(tolerance: float) -> None:
    """It ends where rounding leaves no better proof, with all nodes looked at."""
    model = small_model()
    for seed in range(20):
        readings = pressed(model, np.random.default_rng(seed)) * 30.0 ** (seed % 3)
        for snr in (3.0, 15.0, 100.0):
            solver = NonNegative(snr=snr, tolerance=tolerance)
            operator = search_of(solver, model)
            solve(operator, readings)
            assert operator.gap <= max(tolerance, 1e-4)
            assert operator.steps < 60


def test_nothing_is_proved_of_what_is_no_number() -> None:
    operator, _, cases = large(BOTH[1])
    readings = cases[1][0]
    expected = solved(operator, readings)
    for strange in (np.nan, np.inf, -np.inf, 1e200, 1e25):
        bad = readings.copy()
        bad[3] = strange
        assert not solve(operator, bad).any()
        assert operator.gap == 1.0
        assert not operator.idle
        found = solve(operator, readings)
        assert found == pytest.approx(expected, abs=1e-4 * expected.max())  # not spoilt by it


def test_before_the_first_reading_nothing_is_stated() -> None:
    operator = search_of(NonNegative(), small_model())
    for each in (operator, Search(operator.operator), operator.without(np.arange(25) != 3)):
        assert np.isnan(each.gap)
        assert np.isnan(each.objective)
        assert each.steps == 0


@pytest.mark.parametrize("precision", [np.float32, np.float64])
@pytest.mark.parametrize("quantity", BOTH)
@pytest.mark.parametrize("cut", [5e-3, 0.2])
def test_what_stamps_lack_is_in_the_proof(
    quantity: Either, precision: type[np.floating], cut: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Passes by windows of each taxel's nodes, as on large grids, prove no less and no more."""
    model = small_model(24, 7, quantity)
    _, dense, cases = large(quantity)
    plain = search_of(NonNegative(tolerance=1e-6, precision=precision), model)
    monkeypatch.setattr(non_negative, "LARGE", 0)
    monkeypatch.setattr(non_negative, "SPARSE", 2.0)
    monkeypatch.setattr(non_negative, "TILE_CUT", cut)
    operator = search_of(NonNegative(tolerance=1e-6, precision=precision), model)
    assert len(plain.problem.stamps) == 0
    assert len(operator.problem.stamps) > 0
    assert operator.problem.nodes[DROPPED].max() > 0.0
    for readings, least, zero in cases:
        solved(plain, readings)
        solved(operator, readings)
        reached = assert_honest(operator, dense, readings, least, zero)
        assert reached == pytest.approx(least, rel=3e-6)
        assert operator.gap == pytest.approx(plain.gap, abs=1e-5)
        for allowed in range(0, 200_000, 10_000):
            operator.reset()
            solve(operator, readings, time.perf_counter_ns() + allowed)
            assert_honest(operator, dense, readings, least, zero)
        quiet = 0.5 * readings * dense.threshold / dense.score(readings).max()
        assert not solve(operator, quiet).any()
        assert operator.idle


def test_a_slow_step_is_not_held_against_all_later_ones() -> None:
    """What no deadline lets happen is not measured either; it is tried again after a while."""
    model = small_model()
    operator = search_of(NonNegative(), model)
    readings = pressed(model, np.random.default_rng(0))
    operator.memory.measures[2:5] *= 1e5
    operator.reset()
    for _ in range(2000):
        operator.reset()
        solve(operator, readings, time.perf_counter_ns() + 50_000_000)
        if operator.gap <= 1e-4:
            break
    assert operator.gap <= 1e-4


@pytest.mark.parametrize("shrinkage", [0.0, 0.5])
def test_rounding_over_hundreds_of_nodes_is_in_the_proof(shrinkage: float) -> None:
    """Single precision by what double precision proves, for readings of up to 1e5 deviations."""
    patch, quantity = sf.layouts.hexagon72(), BOTH[1]
    grid = Grid.square(patch, 40)
    model = ObservationModel.of(
        patch, Layer(), grid, BondedLayer(), quantity, quantity.typical_noise
    )
    solver = NonNegative(tolerance=1e-8, shrinkage=shrinkage)
    single = search_of(solver, model)
    double = search_of(replace(solver, tolerance=1e-12, precision=np.float64), model)
    seen, dense = double.problem.rows[:, : len(patch)].T, Dense.of(solver, model)
    penalty = double.problem.numbers[PENALTY] * double.problem.norms
    rng = np.random.default_rng(0)
    for _ in range(12):
        readings = pressed(model, rng, 6) * 10.0 ** rng.uniform(0, 3.3)
        values = []
        for operator in (single, double):
            solve(operator, readings)
            amounts = amounts_of(operator)
            missing = seen @ amounts - dense.target(readings)
            values.append(0.5 * missing @ missing + 0.5 * amounts @ amounts + penalty @ amounts)
        assert np.count_nonzero(amounts) > 50
        assert double.gap < 1e-11
        assert (values[0] - values[1]) / values[0] <= single.gap + 1e-10
        assert single.gap < 2e-4
