"""`NonNegative` reading after reading: moving contacts with noise, jumps and sizes."""

import time

import numpy as np
import pytest
from non_negative_reference import Dense, Either, amounts_of, small_model, solve, solved

from skinfield.elastic import BaseStress, Capacitance, ObservationModel
from skinfield.errors import Floats
from skinfield.solve import NonNegative
from skinfield.solve.non_negative import NonNegativeOperator

BOTH = [BaseStress(), Capacitance()]
ROUNDING = 2e-6


def blob(model: ObservationModel, x: float, y: float, radius: float, strength: float) -> Floats:
    """Readings (L,) without noise of a paraboloid of pressure, in noise deviations at its taxel."""
    square = np.sum((model.grid.plane - (x, y)) ** 2, axis=1)
    clean = model.matrix @ np.maximum(0.0, 1 - square / radius**2)
    return np.asarray(clean * strength / max(np.abs(clean / model.noise_std).max(), 1e-12))


def moving(model: ObservationModel, count: int, rng: np.random.Generator) -> list[Floats]:
    """Two contacts that wander, come, go and jump, with noise."""
    rows = []
    for index in range(count):
        angle = 0.05 * index
        clean = blob(model, 6e-3 * np.cos(angle), 6e-3 * np.sin(angle), 4e-3, 40.0)
        if 60 <= index % 120 < 100:  # another appears, jumps in the middle of its stay, vanishes
            side = -5e-3 if index % 120 < 80 else 5e-3
            clean = clean + blob(model, side, 2e-3, 2.5e-3, 25.0)
        if index % 120 in range(20, 30):
            clean = np.zeros(len(clean))
        rows.append(clean + rng.normal(size=len(clean)) * model.noise_std)
    return rows


def assert_same_within_proofs(
    warm: NonNegativeOperator, cold: NonNegativeOperator, readings: Floats, floor: float = ROUNDING
) -> None:
    """Two answers to one reading are as near to each other as their gaps say."""
    found, expected = solve(warm, readings), solved(cold, readings)
    assert found.min() >= 0.0
    assert np.isfinite(found).all()
    assert warm.idle == cold.idle
    apart = sum(np.sqrt(2 * (each.gap + floor) * each.objective) for each in (warm, cold))
    assert np.linalg.norm(amounts_of(warm) - amounts_of(cold)) <= apart
    if not expected.any():
        assert warm.idle or warm.gap <= warm.problem.tolerance + floor


@pytest.mark.parametrize("quantity", BOTH)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
@pytest.mark.parametrize("length", [None, 0.0])
def test_a_chain_of_moving_contacts(
    quantity: Either, tolerance: float, length: float | None
) -> None:
    model = small_model(21, 7, quantity)
    solver = NonNegative(tolerance=tolerance, length_scale=length)
    warm = solver.prepare(model)
    cold = warm.twin()
    for readings in moving(model, 300, np.random.default_rng(0)):
        assert_same_within_proofs(warm, cold, readings)
        assert warm.gap <= tolerance + ROUNDING
        assert cold.gap <= tolerance + ROUNDING
        assert warm.iterations <= 40


@pytest.mark.parametrize("quantity", BOTH)
def test_every_answer_of_a_chain_against_nnls(quantity: Either) -> None:
    model = small_model(13, 5, quantity)
    solver = NonNegative(tolerance=1e-3)
    operator, dense = solver.prepare(model), Dense.of(solver, model)
    idle = 0
    for readings in moving(model, 200, np.random.default_rng(1)):
        solve(operator, readings)
        if operator.idle:
            idle += 1
            assert dense.score(readings).max() <= dense.threshold * (1 + 1e-5)
            continue
        reached = dense.objective(amounts_of(operator), readings)
        least = dense.objective(dense.minimum_by_squares(readings), readings)
        assert -1e-9 * least <= reached - least <= (operator.gap + ROUNDING) * reached
        assert operator.gap <= 1e-3
    assert 8 <= idle <= 25  # the readings of noise alone, at the least


@pytest.mark.parametrize("quantity", BOTH)
def test_sizes_that_change_by_orders_of_magnitude(quantity: Either) -> None:
    model = small_model(15, 5, quantity)
    warm = NonNegative().prepare(model)
    cold = warm.twin()
    rng = np.random.default_rng(2)
    clean = [blob(model, *rng.uniform(-6e-3, 6e-3, 2), 4e-3, 1.0) for _ in range(6)]
    for index in range(300):
        size = 10.0 ** rng.uniform(-3, 6)
        sign = -1.0 if index % 11 == 0 else 1.0
        readings = sign * size * clean[index % 6] + rng.normal(size=len(clean[0])) * model.noise_std
        if index % 13 == 0:
            readings = np.zeros(len(readings))
        assert_same_within_proofs(warm, cold, readings, 2e-5)
        assert warm.gap <= 2e-4


def test_a_reading_that_stays_needs_no_step() -> None:
    model = small_model(21, 7)
    operator = NonNegative().prepare(model)
    readings = moving(model, 1, np.random.default_rng(3))[0]
    first = solve(operator, readings)
    assert operator.iterations > 0
    for _ in range(5):
        assert solve(operator, readings) == pytest.approx(first, abs=1e-3 * first.max())
        assert operator.iterations <= 1
    constant = np.full(len(readings), 30.0 * model.noise_std[0])
    cold = operator.twin()
    for _ in range(3):
        assert_same_within_proofs(operator, cold, constant)


def test_a_warm_start_saves_steps_where_little_changes() -> None:
    model = small_model(21, 7)
    warm = NonNegative().prepare(model)
    cold = warm.twin()
    clean = blob(model, 1e-3, 2e-3, 4e-3, 60.0)
    rng = np.random.default_rng(4)
    steps = []
    for _ in range(100):
        readings = clean + 0.2 * rng.normal(size=len(clean)) * model.noise_std
        assert_same_within_proofs(warm, cold, readings)
        steps.append((warm.iterations, cold.iterations))
    found = np.mean(steps, axis=0)
    assert found[0] < 0.7 * found[1]


def test_deadlines_in_a_chain_leave_no_trace() -> None:
    """A reading that was cut short starts the next one badly at most, never wrongly."""
    model = small_model(21, 7, BOTH[1])
    warm = NonNegative().prepare(model)
    cold = warm.twin()
    rng = np.random.default_rng(5)
    for index, readings in enumerate(moving(model, 200, rng)):
        if index % 3:
            solve(warm, readings, time.perf_counter_ns() + int(rng.integers(0, 150_000)))
            continue
        assert_same_within_proofs(warm, cold, readings)
        assert warm.gap <= 1e-4 + ROUNDING
