"""What steps are predicted to take."""

import numpy as np
import pytest

from skinfield.reconstruct.engine.cycle_kernel import relax, take_in
from skinfield.reconstruct.engine.state import FEASIBLE, LINEAR, WARM, State
from skinfield.reconstruct.engine.timing_model import CostModel


def test_the_cost_model_follows_a_high_quantile() -> None:
    rng = np.random.default_rng(0)
    model = CostModel(np.array([1e-3]), quantile=0.9, pace=0.05)
    laps = 50e-6 * rng.lognormal(sigma=0.4, size=6000)
    predicted = []
    for lap in laps:
        predicted.append(model.predict(0))
        model.observe(0, lap)
    inside = np.mean(laps[1000:] <= np.array(predicted)[1000:])
    assert 0.87 < inside < 0.93
    exact = 50e-6 * np.exp(0.4 * 1.2816)
    assert np.median(predicted[1000:]) == pytest.approx(exact, rel=0.06)


def test_one_interrupted_step_moves_the_prediction_little() -> None:
    model = CostModel(np.array([50e-6]))
    model.observe(0, 10.0)
    assert 50e-6 < model.predict(0) < 56e-6
    for _ in range(200):
        relax(model.steps, model.base)
    assert model.predict(0) == pytest.approx(50e-6)


def test_searches_are_learnt_as_single_steps_are() -> None:
    rng, state = np.random.default_rng(2), State(np.zeros(5, dtype=np.int64))
    times = rng.uniform(20e-6, 80e-6, (2, 1, 6, 3))
    models = [
        CostModel(each.reshape(-1).copy(), quantile=q)
        for each, q in zip(times, (0.9, 0.6), strict=True)
    ]
    moves = np.array([each.moves for each in models])
    state.kind[:] = [3, 4, 4, 3, 4]
    for _ in range(20):
        found = []
        for patch in range(5):
            rung, taken, ended = (
                int(rng.integers(3)),
                int(rng.integers(10_000, 90_000)),
                rng.random() < 0.7,
            )
            found.append((patch, rung, 0.1, 0.0, ended, 2, 30e-6, 0.0, 7, 7 + taken))
        expected = []
        for patch, rung, _, _, ended, *_, start, end in found:
            which = int(state.kind[patch]) * 3 + rung
            expected.append(models[0].predict(which))
            for model in models:
                if ended or (end - start) * 1e-9 >= model.predict(which):  # else it was cut off
                    model.observe(which, (end - start) * 1e-9 if ended else np.inf)
        given = np.array(found, dtype=np.float64)
        arrays = (state.group, state.integers, state.numbers, state.settled, np.zeros((1, 3)))
        take_in(given, *arrays, times, moves)
        np.testing.assert_allclose(given[:, 7], expected, rtol=1e-12)
        assert (state.kind == WARM).all()
        for model, each in zip(models, times, strict=True):
            np.testing.assert_allclose(each.reshape(-1), model.steps, rtol=1e-12)


def test_a_worse_answer_does_not_replace_a_better_one() -> None:
    state = State(np.zeros(2, dtype=np.int64))
    state.answer[:], state.energy[:] = LINEAR, 100.0
    arrays = (state.group, state.integers, state.numbers, state.settled, np.array([[0.2, 0.1]]))
    times, moves = np.full((2, 1, 6, 2), 1e-5), np.ones((2, 3))

    def search(rung: int, gap: float, missing: float) -> None:
        row = (1, rung, gap, missing, missing == 0.0, 3, 2e-5, 0.0, 0, 10_000)
        take_in(np.array([row], dtype=np.float64), *arrays, times, moves)

    search(0, 1e-3, 0.0)
    assert (state.answer[1], state.rung[1], state.at[1], state.gap[1]) == (FEASIBLE, 0, 0, 1e-3)
    assert state.excess[1] == 20.0  # what the coarse grid leaves
    search(1, 0.5, 50.0)
    assert (state.rung[1], state.gap[1], state.settled[1]) == (0, 1e-3, True)
    search(1, 1e-2, 5.0)
    assert (state.rung[1], state.gap[1], state.settled[1]) == (1, 1e-2, False)
    assert state.excess[1] == 15.0
    assert state.iterations[1] == 9
    assert state.spent[1] == pytest.approx(30e-6)
    assert state.answer[0] == LINEAR
