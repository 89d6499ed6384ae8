"""Non-negative answers to many readings on any device."""

import numpy as np
import pytest
from device_backends import BACKENDS, GRID, faded_in, operator_of
from scipy.optimize import lsq_linear

import skinfield as sf
from skinfield.errors import InputError
from skinfield.pipeline import device_search
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.device_non_negative import BulkNonNegative


@pytest.fixture(params=BACKENDS)
def backend(request: pytest.FixtureRequest) -> ArrayBackend:
    return BACKENDS[request.param]()


@pytest.fixture(scope="module")
def readings() -> np.ndarray:
    return faded_in()


def test_non_negative_answers_are_those_of_one_by_one(
    backend: ArrayBackend, readings: np.ndarray
) -> None:
    operator = operator_of(sf.NonNegative(tolerance=1e-7, precision=np.float64))
    bulk = BulkNonNegative(operator, backend, tolerance=1e-3, chunk=10)
    found = bulk(readings)
    assert (found.pressure >= 0.0).all()
    assert (found.gap <= 1e-3).all()
    one, idle = np.empty(len(GRID)), 0
    for row, reading in enumerate(readings):
        operator.apply(reading, one)
        assert found.idle[row] == operator.idle
        idle += operator.idle
        if operator.idle:
            assert not found.pressure[row].any()
        above = found.objective[row] / operator.objective - 1.0
        assert -2e-6 <= above <= found.gap[row] / (1.0 - found.gap[row]) + 2e-6  # proved, and true
    assert 0 < idle < 10


def test_in_double_precision_they_converge(backend: ArrayBackend, readings: np.ndarray) -> None:
    operator = operator_of(sf.NonNegative(tolerance=1e-10, precision=np.float64))
    found = BulkNonNegative(operator, backend, precision=np.float64)(readings)
    assert found.gap.max() <= 1e-10
    expected = np.empty((23, len(GRID)))
    for reading, out in zip(readings, expected, strict=True):
        operator.apply(reading, out)
    assert np.abs(found.pressure - expected).max() < 1e-4 * expected.max()


def test_against_a_general_solver_of_bounded_least_squares(readings: np.ndarray) -> None:
    """White cells, so that pressure is amounts times a number: min |Bz - b|²/2 + |z|²/2 + mu z."""
    operator = operator_of(sf.NonNegative(length_scale=0.0))
    problem = operator.problem
    rows, penalty = problem.rows[:, :72].astype(float), problem.penalty.astype(float)
    bulk = BulkNonNegative(operator, ArrayBackend.numpy(), tolerance=1e-9, precision=np.float64)
    found = bulk(readings[-3:])
    for row, reading in enumerate(readings[-3:]):
        white = reading * problem.whitening
        # the linear term goes into the square: |z + mu|² = |z|² + 2 mu z + |mu|²
        system = np.vstack([rows.T, np.eye(len(rows))])
        exact = lsq_linear(system, np.concatenate([white, -penalty]), (0.0, np.inf), tol=1e-13)
        amounts = found.pressure[row] / float(problem.bump[0, 0])
        assert np.abs(amounts - exact.x).max() < 1e-3 * exact.x.max()
        least = exact.cost - 0.5 * penalty @ penalty
        assert found.objective[row] == pytest.approx(least, rel=1e-6)
        mine = 0.5 * np.square(rows.T @ amounts - white).sum() + 0.5 * amounts @ amounts
        assert found.objective[row] == pytest.approx(mine + penalty @ amounts, rel=1e-9)


@pytest.mark.parametrize("length_scale", [0.0, 1e-3])
def test_readings_that_no_pressure_explains(length_scale: float, readings: np.ndarray) -> None:
    """A prior of little noise and readings that are mostly noise: hundreds of steps."""
    operator = operator_of(sf.NonNegative(snr=100.0, length_scale=length_scale))
    wild = np.random.default_rng(0).normal(scale=0.2, size=(6, 72)) - 3.0 * readings[-6:]
    bulk = BulkNonNegative(operator, ArrayBackend.numpy(), 1e-4, precision=np.float64)
    found = bulk(wild)
    assert found.gap.max() <= 1e-4
    assert 100 < found.iterations.min() < found.iterations.max() < 900


def test_a_search_without_success_says_so(readings: np.ndarray) -> None:
    solver = sf.NonNegative(snr=1000.0, tolerance=1e-4, precision=np.float64, length_scale=1e-3)
    operator, out = operator_of(solver), np.empty(len(GRID))
    wild = np.random.default_rng(0).normal(scale=0.2, size=(4, 72))
    found = BulkNonNegative(operator, ArrayBackend.numpy(), most_iterations=64)(wild)
    assert found.gap.min() > 0.1
    nothing = 0.5 * np.square(wild * operator.problem.whitening).sum(axis=1)
    assert (found.objective <= nothing).all()
    for row, reading in enumerate(wild):
        operator.apply(reading, out)
        assert found.objective[row] * (1.0 - found.gap[row]) <= operator.objective


def test_few_steps_leave_a_gap_that_is_said(readings: np.ndarray) -> None:
    operator = operator_of(sf.NonNegative())
    best = BulkNonNegative(operator, ArrayBackend.numpy(), tolerance=1e-7, precision=np.float64)
    least, before = best(readings[-4:]).objective, np.inf
    for most in (1, 16, 32, 64):
        bulk = BulkNonNegative(operator, ArrayBackend.numpy(), 1e-7, most)
        found = bulk(readings[-4:])
        assert (found.objective * (1.0 - found.gap) <= least * (1.0 + 1e-6)).all()
        assert (found.iterations <= most + device_search.EVERY).all()
        assert found.gap.max() < before
        before = found.gap.max()
    assert before < 1e-3


def test_only_idle_readings_and_none(readings: np.ndarray) -> None:
    bulk = BulkNonNegative(operator_of(sf.NonNegative()), ArrayBackend.numpy())
    found = bulk(np.zeros((3, 72)))
    assert found.idle.all()
    assert not found.pressure.any()
    assert not found.gap.any()
    assert bulk(np.zeros((0, 72))).pressure.shape == (0, len(GRID))


def test_readings_that_lack_taxels_are_refused(readings: np.ndarray) -> None:
    bulk = BulkNonNegative(operator_of(sf.NonNegative()), ArrayBackend.numpy())
    spoiled = readings.copy()
    spoiled[2, 5] = np.nan
    with pytest.raises(InputError, match=r"readings\[2, 5\] is nan, expected a finite number"):
        bulk(spoiled)
    with pytest.raises(InputError, match="tolerance"):
        BulkNonNegative(operator_of(sf.NonNegative()), ArrayBackend.numpy(), tolerance=0.0)
