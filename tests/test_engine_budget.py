"""Budget of an engine: turns, predictions and promises, by a clock that is told."""

import numpy as np
import pytest
from engine_clock import NOISE, engine_of, readings_of
from hypothesis import given, settings
from hypothesis import strategies as st

import skinfield as sf
from skinfield.reconstruct.engine.cycle_kernel import relax
from skinfield.reconstruct.engine.engine import prefer
from skinfield.reconstruct.engine.state import PRODUCT, ROW, Step
from skinfield.reconstruct.engine.timing_model import CostModel


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


def test_linear_answers_are_refined_where_something_touches_as_far_as_time_goes() -> None:
    engine = sf.Engine(ENGINE.skin, rungs=(4, 8, 16), solver=sf.GaussianField(), noise_std=NOISE)
    work, readings = engine._work, readings_of(engine, {1, 4})
    for row, expected in (([10e-6, 20e-6, 30e-6], 16), ([0, 20e-6, 1], 8), ([0, 1, 1], 4)):
        work.costs[:, PRODUCT], work.costs[:, ROW] = (0.0, 1.0, 1.0), row
        report = engine(readings, budget=0.1).report
        assert [each.rung for each in report] == [4, expected, 4, 4, expected, 4]
    assert "rung 8: " in report["p1"].skipped


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
    engine = engine_of(5, 300e-6)
    report = engine(readings_of(engine, {0, 1, 2, 3, 4})).report
    answers = [each.answer for each in report]
    assert answers == ["field"] * 2 + ["linear"] * 3  # 150 µs, or what is left of the time
    assert [each.gap for each in report][:2] == [0.5, 0.5]
    assert all("more iterations: no time" in each for each in report.skipped[:2])
    assert all("search: no time" in each for each in report.skipped[2:])
    assert not report.overrun


def test_more_budget_never_settles_less() -> None:
    settled = []
    for budget in (60e-6, 120e-6, 250e-6, 500e-6, 1e-3, 2e-3):
        engine = engine_of(4, budget)
        report = engine(readings_of(engine, {0, 1, 2})).report
        settled.append(sum(each.gap == 1e-4 for each in report if each.answer == "field"))
    assert settled == sorted(settled)
    assert settled[0] < settled[-1] == 3


def test_a_budget_that_holds_no_first_answer_is_an_overrun() -> None:
    engine = engine_of(3, 1e-6)
    estimates = engine(readings_of(engine, {0}))
    assert estimates.report.overrun
    assert estimates.report.spent > 1e-6
    assert estimates.report["p0"].answer == "linear"
    assert "search: no time" in estimates.report["p0"].skipped
    assert estimates["p0"].deadline_met is False
    assert np.isnan(estimates["p0"].gap)
    assert any("no time" in note for note in estimates["p0"].notes)
    assert not engine(readings_of(engine, set()), budget=1e-3).report.overrun


def test_every_contact_is_served_in_turn() -> None:
    engine = engine_of(6, 100e-6)  # one search in a cycle, not to its end
    waited, settled = [], set()
    for _ in range(24):
        report = engine(readings_of(engine, set(range(6)))).report
        settled |= {each.name for each in report if each.gap == 1e-4}
        waited.append(max(each.waited for each in report))
        assert not report.overrun
    assert settled == set(engine.names)
    assert max(waited) <= 6


def test_searches_that_become_slower_are_cut_go_on_and_come_back() -> None:
    engine = engine_of(2, 500e-6)
    factor = engine.solver.slower  # type: ignore[attr-defined]
    hot = readings_of(engine, {0, 1})
    assert engine(hot).report["p0"].gap == 1e-4
    factor["factor"] = 4.0  # 800 µs, in a cycle of 500 for two
    reports = [engine(hot).report for _ in range(60)]
    assert not any(report.overrun for report in reports)
    for name in ("p0", "p1"):
        assert 10 < sum(report[name].gap == 1e-4 for report in reports) < 50
    factor["factor"] = 1.0
    assert {each.gap for each in [engine(hot).report for _ in range(3)][-1]} == {1e-4}


def test_a_finer_rung_goes_on_from_the_coarser_ones_dual() -> None:
    engine = engine_of(1, 5e-3)
    coarse = readings_of(engine, {0})
    prefer(engine, 1)
    assert engine(coarse).report["p0"].rung == 8
    prefer(engine)
    finest = engine.groups[0].data[2][0]
    finest.started.clear()
    assert engine(coarse).report["p0"].rung == 16
    assert finest.started[0] == coarse["p0"][0]


@pytest.mark.parametrize("budget", [1e-6, 15e-6])
def test_a_contact_is_served_in_the_end_though_there_is_no_time_for_it(budget: float) -> None:
    engine = engine_of(3, budget)
    served, overruns = [], 0
    for _ in range(80):
        report = engine(readings_of(engine, {0, 2})).report
        its = [each for each in report if each.answer == "field"]
        assert all(each.rung == 16 for each in its)
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
