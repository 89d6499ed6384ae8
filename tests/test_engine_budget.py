"""Budget of an engine: planning, predictions and promises, by a clock that is told."""

import itertools
from typing import Any

import numpy as np
import pytest
from engine_clock import engine_of, readings_of
from hypothesis import given, settings
from hypothesis import strategies as st

from skinfield.errors import Floats
from skinfield.reconstruct.engine.cycle_kernel import plan, relax, take_in
from skinfield.reconstruct.engine.state import FEASIBLE, LINEAR, EngineState, Step
from skinfield.reconstruct.engine.timing_model import CostModel


def planned(costs: Floats, unresolved: Floats, energy: Floats, left: float) -> tuple[Any, Any]:
    """Rung of each patch, -1 for none, and the patches that are searched, in their order."""
    state = EngineState(np.zeros(len(energy), dtype=np.int64))
    state.energy[:], state.excess[:], state.kind[:] = energy, energy, 0
    none, ones = np.zeros(len(energy), dtype=np.int64), np.ones(len(energy))
    target, order, tops, times = none.copy(), none.copy(), none + costs.shape[2] - 1, [costs, costs]
    known = state.group, state.integers, state.numbers, state.age, tops, ones, np.array(times), 0.0
    room = target, order, none.copy(), 0.0 * ones
    chosen = plan(np.arange(len(energy)), *known, unresolved, left, 0.0 * costs, *room)
    return target, order[:chosen]


@given(
    patches=st.integers(1, 6),
    rungs=st.integers(1, 3),
    seed=st.integers(0, 10_000),
    left=st.floats(0.0, 3.0),
)
@settings(max_examples=150, deadline=None)
def test_a_plan_fits_and_leaves_nothing_out_that_would_fit(
    patches: int, rungs: int, seed: int, left: float
) -> None:
    rng = np.random.default_rng(seed)
    costs = np.cumsum(rng.uniform(0.05, 1.0, (1, 1, rungs)), axis=2)
    unresolved = np.sort(rng.uniform(0.0, 0.9, (1, rungs)))[:, ::-1].copy()
    energy = rng.uniform(1.0, 100.0, patches)
    target, chosen = planned(costs, unresolved, energy, left)
    assert sorted(chosen) == sorted(np.flatnonzero(target >= 0))
    paid = costs[0, 0, target[chosen]].sum()
    assert paid <= left + 1e-9
    for patch in range(patches):
        before = costs[0, 0, target[patch]] if target[patch] >= 0 else 0.0
        finer = costs[0, 0, target[patch] + 1 :]
        assert not (finer - before <= left - paid - 1e-9).any()


def test_a_plan_gains_nearly_what_the_best_of_all_plans_gains() -> None:
    rng, shares = np.random.default_rng(3), []
    for _ in range(60):
        costs = np.cumsum(rng.uniform(0.05, 1.0, (1, 1, 3)), axis=2)
        unresolved = np.array([[0.5, 0.2, 0.0]])
        energy, left = rng.uniform(1.0, 10.0, 4), float(rng.uniform(0.5, 6.0))
        target, _ = planned(costs, unresolved, energy, left)

        def gain(choice: Any, energy: Any = energy, unresolved: Any = unresolved) -> float:
            kept = [0.0 if r < 0 else 1.0 - unresolved[0, r] for r in choice]
            return float(energy @ np.array(kept))

        def cost(choice: Any, costs: Any = costs) -> float:
            return float(sum(costs[0, 0, r] for r in choice if r >= 0))

        every = itertools.product(range(-1, 3), repeat=4)
        best = max(gain(choice) for choice in every if cost(choice) <= left)
        shares.append(gain(target) / best if best else 1.0)
    assert np.mean(shares) > 0.95  # a greedy plan; the problem is a knapsack
    assert max(shares) <= 1.0 + 1e-12


@given(hot=st.sets(st.integers(0, 5)), budget=st.floats(20e-6, 2e-3))
@settings(max_examples=60, deadline=None)
def test_no_cycle_ends_late_when_steps_take_what_they_took(hot: set[int], budget: float) -> None:
    engine = ENGINE
    engine.reset()
    for cycle in range(4):
        report = engine(readings_of(engine, hot), budget=budget).report
        assert report.steps[0].kind == Step.TEST  # idle or not is told before any search
        assert report.overrun == (report.spent > budget)
        assert report.spent <= budget, (cycle, report.steps)
        assert set(report.idle) == {f"p{i}" for i in range(6) if i not in hot}
        assert not report.missing


ENGINE = engine_of(6, 1e-3)


def test_time_enough_settles_every_contact_on_the_finest_rung() -> None:
    engine = engine_of(5, 5e-3)
    estimates = engine(readings_of(engine, {0, 3}))
    for name in ("p0", "p3"):
        each = estimates.report[name]
        assert (each.answer, each.rung, each.gap, each.skipped) == ("field", 16, 1e-4, "")
        assert estimates[name].gap == 1e-4
        assert estimates[name].iterations == 3
    assert estimates.report["p1"].answer == "idle"
    assert estimates.report["p1"].rung == 16  # what time was left proved it on the finest grid
    assert estimates.report.skipped == ()


def test_a_small_budget_is_spread_over_contacts_and_the_rest_is_told() -> None:
    engine = engine_of(5, 200e-6)
    report = engine(readings_of(engine, {0, 1, 2, 3, 4})).report
    answers = [each.answer for each in report]
    assert answers.count("field") == 5  # 100 µs of coarse searches; no finer one for all
    assert {each.rung for each in report} <= {4, 8}
    assert report.skipped
    assert all("predicted" in each and "left" in each for each in report.skipped)
    assert not report.overrun


def test_more_budget_is_never_coarser() -> None:
    resolved = []
    for budget in (60e-6, 120e-6, 250e-6, 500e-6, 1e-3, 2e-3):
        engine = engine_of(4, budget)
        report = engine(readings_of(engine, {0, 1, 2})).report
        resolved.append(sum(each.rung for each in report if each.answer == "field"))
    assert resolved == sorted(resolved)
    assert resolved[0] < resolved[-1] == 48


def test_a_budget_that_holds_no_first_answer_is_an_overrun() -> None:
    engine = engine_of(3, 1e-6)
    estimates = engine(readings_of(engine, {0}))
    assert estimates.report.overrun
    assert estimates.report.spent > 1e-6
    assert estimates.report["p0"].answer == "linear"
    assert "search on rung 4" in estimates.report["p0"].skipped
    assert estimates["p0"].deadline_met is False
    assert np.isnan(estimates["p0"].gap)
    assert any("no time" in note for note in estimates["p0"].notes)
    assert not engine(readings_of(engine, set()), budget=1e-3).report.overrun


def test_every_contact_is_served_in_turn() -> None:
    engine = engine_of(6, 60e-6)  # one coarse search in a cycle, or two
    waited, served = [], set()
    for _ in range(12):
        report = engine(readings_of(engine, set(range(6)))).report
        served |= {each.name for each in report if each.answer == "field"}
        waited.append(max(each.waited for each in report))
        assert not report.overrun
    assert served == set(engine.names)
    assert max(waited) <= 6


def test_searches_that_become_slower_are_cut_then_predicted_and_come_back() -> None:
    engine = engine_of(2, 500e-6)
    factor = engine.solver.slower  # type: ignore[attr-defined]
    hot = readings_of(engine, {0, 1})
    assert engine(hot).report["p0"].rung == 16
    factor["factor"] = 4.0  # 800 µs on the finest rung
    reports = [engine(hot).report for _ in range(60)]
    assert not any(report.overrun for report in reports)
    assert {reports[-1]["p0"].rung, reports[-1]["p1"].rung} <= {4, 8}
    assert reports[-1]["p0"].gap == 1e-4
    factor["factor"] = 1.0
    reports = [engine(hot).report for _ in range(1500)]
    assert reports[-1]["p0"].rung == 16  # what was too dear was tried again


def test_a_finer_rung_goes_on_from_the_coarser_ones_dual() -> None:
    engine = engine_of(1, 150e-6)
    coarse = readings_of(engine, {0})
    engine(coarse)
    assert engine(coarse).report["p0"].rung == 8
    finest = engine.groups[0].data[2][0]
    finest.started.clear()
    engine(coarse, budget=5e-3)
    assert finest.started[0] == coarse["p0"][0]


@pytest.mark.parametrize("budget", [1e-6, 15e-6])
def test_a_contact_is_served_in_the_end_though_there_is_no_time_for_it(budget: float) -> None:
    engine = engine_of(3, budget)
    served, overruns = [], 0
    for _ in range(80):
        report = engine(readings_of(engine, {0, 2})).report
        its = [each for each in report if each.answer == "field"]
        assert all(each.rung == 4 and each.gap == 1e-4 for each in its)
        assert report.overrun == (report.spent > budget)
        assert report.overrun or not its
        served.append(len(its))
        overruns += report.overrun
    first = np.flatnonzero(served)
    assert first[0] == 20  # cycles of waiting
    assert set(np.diff(first)) <= {10, 11}  # and no two sooner
    assert max(served) == 1
    assert overruns == (80 if budget < 2e-6 else sum(served))


def test_a_budget_beyond_reason_is_enough() -> None:
    report = ENGINE(readings_of(ENGINE, {1}), budget=1e300).report
    assert report["p1"].rung == 16
    assert not report.overrun


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


def test_a_worse_answer_does_not_replace_a_better_one() -> None:
    state = EngineState(np.zeros(2, dtype=np.int64))
    state.answer[:], state.energy[:] = LINEAR, 100.0
    arrays = (state.group, state.integers, state.numbers, state.settled, np.array([[0.2, 0.1]]))
    times, moves = np.full((2, 1, 6, 2), 1e-5), np.ones((2, 3))

    def search(rung: int, gap: float, missing: float) -> None:
        row = (1, rung, gap, missing, missing == 0.0, 3, 2e-5, 0.0, 0, 10_000)
        take_in(np.array([row], dtype=np.float64), *arrays, times, moves, state.group, state.group)

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
