"""What belongs to a prepared `NonNegative`: missing taxels, starts, memory."""

import gc
import sys
import time
import tracemalloc

import numpy as np
import pytest
from non_negative_reference import (
    Dense,
    Either,
    Search,
    amounts_of,
    assert_proved,
    pressed,
    search_of,
    small_model,
    solve,
    solved,
)

import skinfield as sf
from skinfield.elastic import BaseStress, BondedLayer, Capacitance, Layer, ObservationModel
from skinfield.errors import Floats, InputError
from skinfield.skin import Grid
from skinfield.solve import NonNegative, non_negative

BOTH = [BaseStress(), Capacitance()]
ROUNDING = 2e-6


@pytest.mark.parametrize("quantity", BOTH)
@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_taxels_are_left_out_as_if_they_were_not_there(
    quantity: Either, precision: type[np.floating]
) -> None:
    model = small_model(13, 5, quantity)
    solver = NonNegative(tolerance=1e-6, precision=precision)
    operator, dense = search_of(solver, model), Dense.of(solver, model)
    rng = np.random.default_rng(3)
    for missing in (1, 5, 20):
        readings = pressed(model, rng)
        valid = np.ones(len(readings), dtype=bool)
        valid[rng.choice(len(readings), missing, replace=False)] = False
        left = dense.left(valid)
        readings[~valid] = np.nan
        part = operator.without(valid)
        pressure = solve(part, readings)
        assert np.isfinite(pressure).all()
        assert np.isfinite(part.dual).all()
        assert not part.dual[~valid].any()
        if not part.idle:
            assert_proved(part, left, readings[valid], pressure, 1e-5)


def test_a_start_says_nothing_of_taxels_that_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(non_negative, "LARGE", 0)  # by stamps, which still hold them
    model = small_model(24, 7)
    operator = search_of(NonNegative(), model)
    assert len(operator.problem.stamps) > 0
    readings = pressed(model, np.random.default_rng(9))
    valid = np.arange(len(readings)) % 5 != 0
    expected = solve(operator.without(valid), readings)
    part = operator.without(valid)
    for value in (-50.0, 50.0):
        part.start_from(np.where(valid, 0.1, value))
        solve(part, readings, 1)  # cut short at once
        assert not part.dual[~valid].any()
        part.start_from(np.where(valid, 0.1, value))
        assert solve(part, readings) == pytest.approx(expected, abs=0.01 * expected.max())


def test_without_any_taxel_nothing_is_pressed() -> None:
    model = small_model()
    part = search_of(NonNegative(), model).without(np.zeros(len(model.taxels), dtype=bool))
    assert not solve(part, np.full(len(model.taxels), np.nan)).any()
    assert part.idle


@pytest.mark.parametrize("quantity", BOTH)
def test_the_dual_of_a_coarse_grid_is_a_start_for_a_fine_one(quantity: Either) -> None:
    patch = sf.layouts.hexagon72()
    noise = quantity.typical_noise
    models = [
        ObservationModel.of(patch, Layer(), Grid.square(patch, n), BondedLayer(), quantity, noise)
        for n in (12, 20)
    ]
    coarse, fine = (search_of(NonNegative(length_scale=2e-3), model) for model in models)
    alone, saved = Search(fine.operator), []
    for seed in range(20):
        readings = pressed(models[0], np.random.default_rng(seed))
        solved(coarse, readings)
        assert solved(alone, readings).any()
        fine.reset()
        fine.start_from(coarse.dual)
        solve(fine, readings)
        assert_near(fine, alone)
        assert fine.gap <= 1e-4
        saved.append(alone.steps - fine.steps)
    assert np.mean(saved) > 0.0


def test_a_bad_start_is_no_harm() -> None:
    model = small_model()
    operator = search_of(NonNegative(), model)
    readings = pressed(model, np.random.default_rng(4))
    expected = solved(operator, readings)
    for value in (np.nan, np.inf, 1e30, -1e30, 1e6, -1e3, 0.0):
        operator.start_from(np.full(len(readings), value))
        found = solve(operator, readings)
        assert found == pytest.approx(expected, abs=0.02 * expected.max())
        assert operator.gap <= 1e-4
        operator.start_from(np.full(len(readings), value))
        assert not solve(operator, 0.0 * readings).any()
        assert operator.idle
    with pytest.raises(InputError, match="dual has shape"):
        operator.start_from(np.zeros(3))


def test_reset_forgets() -> None:
    model = small_model()
    operator = search_of(NonNegative(), model)
    rng = np.random.default_rng(5)
    readings = pressed(model, rng)
    expected, steps = solve(operator, readings).copy(), operator.steps
    for _ in range(5):
        solve(operator, pressed(model, rng))
    operator.reset()
    assert np.isnan(operator.gap)
    assert not operator.dual.any()
    found = solve(operator, readings)
    assert found == pytest.approx(expected, abs=1e-3 * expected.max())
    assert operator.steps == steps


@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_apply_allocates_nothing(precision: type[np.floating]) -> None:
    model = small_model(21, 7)
    operator = search_of(NonNegative(precision=precision), model)
    rng = np.random.default_rng(6)
    chain = [pressed(model, rng) for _ in range(20)]
    chain += [0.0 * chain[0], rng.normal(size=len(chain[0])) * model.noise_std]
    out = np.empty(len(model.grid))

    def work(laps: int) -> int:
        before = sys.getallocatedblocks()
        for _ in range(laps):
            for readings in chain:
                operator.apply(readings, out)
                operator.apply(readings, out, time.perf_counter_ns() + 50_000)
        return sys.getallocatedblocks() - before

    gc.collect()
    gc.disable()
    try:
        work(40)  # until the interpreter's own stores are full
        assert abs(work(40)) < 40  # of 1760 calls
        tracemalloc.start()
        for readings in chain:
            operator.apply(readings, out)
        _, peak = tracemalloc.get_traced_memory()
        assert peak < out.nbytes  # small objects of the call, no array
    finally:
        tracemalloc.stop()
        gc.enable()


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


def assert_near(warm: Search, cold: Search) -> None:
    """Two answers to one reading are as near to each other as their gaps say."""
    apart = sum(np.sqrt(2 * (each.gap + ROUNDING) * each.objective) for each in (warm, cold))
    assert np.linalg.norm(amounts_of(warm) - amounts_of(cold)) <= apart


def assert_same_within_proofs(warm: Search, cold: Search, readings: Floats) -> None:
    found, expected = solve(warm, readings), solved(cold, readings)
    assert found.min() >= 0.0
    assert np.isfinite(found).all()
    assert warm.idle == cold.idle
    assert_near(warm, cold)
    if not expected.any():
        assert warm.idle or warm.gap <= warm.problem.tolerance + ROUNDING


@pytest.mark.parametrize("quantity", BOTH)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
@pytest.mark.parametrize("length", [None, 0.0])
def test_every_answer_of_a_chain_of_moving_contacts_against_nnls(
    quantity: Either, tolerance: float, length: float | None
) -> None:
    model = small_model(13, 5, quantity)
    solver = NonNegative(tolerance=tolerance, length_scale=length)
    operator, dense = search_of(solver, model), Dense.of(solver, model)
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
        assert operator.gap <= tolerance + ROUNDING
        assert operator.steps <= 40
    assert 8 <= idle <= 25  # the readings of noise alone, at the least


def test_a_reading_that_stays_needs_no_step() -> None:
    model = small_model(21, 7)
    operator = search_of(NonNegative(), model)
    readings = moving(model, 1, np.random.default_rng(3))[0]
    first = solve(operator, readings)
    assert operator.steps > 0
    for _ in range(5):
        assert solve(operator, readings) == pytest.approx(first, abs=1e-3 * first.max())
        assert operator.steps <= 1
    constant = np.full(len(readings), 30.0 * model.noise_std[0])
    cold = Search(operator.operator)
    for _ in range(3):
        assert_same_within_proofs(operator, cold, constant)


def test_a_warm_start_saves_steps_where_little_changes() -> None:
    model = small_model(21, 7)
    warm = search_of(NonNegative(), model)
    cold = Search(warm.operator)
    clean = blob(model, 1e-3, 2e-3, 4e-3, 60.0)
    rng = np.random.default_rng(4)
    steps = []
    for _ in range(100):
        readings = clean + 0.2 * rng.normal(size=len(clean)) * model.noise_std
        assert_same_within_proofs(warm, cold, readings)
        steps.append((warm.steps, cold.steps))
    found = np.mean(steps, axis=0)
    assert found[0] < 0.7 * found[1]


def test_deadlines_in_a_chain_leave_no_trace() -> None:
    """A reading that was cut short starts the next one badly at most, never wrongly."""
    model = small_model(21, 7, BOTH[1])
    warm = search_of(NonNegative(), model)
    cold = Search(warm.operator)
    rng = np.random.default_rng(5)
    for index, readings in enumerate(moving(model, 200, rng)):
        if index % 3:
            solve(warm, readings, time.perf_counter_ns() + int(rng.integers(0, 150_000)))
            continue
        assert_same_within_proofs(warm, cold, readings)
        assert warm.gap <= 1e-4 + ROUNDING
