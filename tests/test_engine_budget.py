"""Budget of an engine: turns, predictions and promises, by a clock that is told."""

import numpy as np
import pytest
from engine_clock import NOISE, engine_of, readings_of
from hypothesis import given, settings
from hypothesis import strategies as st

import skinfield as sf
from skinfield.errors import InputError
from skinfield.reconstruct.engine.engine import measure, prefer
from skinfield.reconstruct.engine.state import FEASIBLE, IDLE, LINEAR, MISSING


@given(hot=st.sets(st.integers(0, 5)), budget=st.floats(20e-6, 2e-3))
@settings(max_examples=60, deadline=None)
def test_no_cycle_ends_late_when_steps_take_what_they_took(hot: set[int], budget: float) -> None:
    engine = ENGINE
    engine.reset()
    for cycle in range(4):
        report = engine(readings_of(engine, hot), budget=budget).report
        assert report.overrun == (report.spent > budget)
        assert report.spent <= budget, cycle
        assert set(report.idle) == {f"p{i}" for i in range(6) if i not in hot}
        assert not report.missing


ENGINE = engine_of(6, 1e-3)


def test_linear_answers_are_on_the_finest_rung_that_is_allowed_whatever_the_budget() -> None:
    engine = sf.Engine(ENGINE.skin, rungs=(4, 8, 16), solver=sf.GaussianField(), noise_std=NOISE)
    readings = readings_of(engine, {1, 4})
    assert [each.rung for each in engine(readings, budget=0.1).report] == [16] * 6
    prefer(engine, 1)
    report = engine(readings, budget=1e-9).report
    assert [each.rung for each in report] == [8] * 6
    assert report.overrun
    assert report.skipped == ()


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


def test_what_one_cycle_has_no_time_for_the_next_goes_on_with() -> None:
    engine = engine_of(5, 300e-6)
    engine.run(np.concatenate(list(readings_of(engine, {0, 1, 4}).values())))
    answers = engine.results.answer.copy()
    assert sorted(answers.tolist()) == [IDLE, IDLE, LINEAR, FEASIBLE, FEASIBLE]
    assert engine.go_on()
    assert engine.results.answer[answers == LINEAR] == FEASIBLE  # it waited longest
    assert set(engine.results.answer[answers == IDLE]) == {MISSING}  # there is nothing to search
    for _ in range(60):
        if not engine.go_on():
            break
    assert not engine.go_on()  # as all came to an end


def test_one_disturbance_of_its_start_costs_an_engine_nothing() -> None:
    engine = engine_of(1, 300e-6)
    work = engine._work
    usual, clock, looks = work.costs.copy(), work.clock, iter(range(10**6))

    def disturbed() -> int:
        clock.now += 10_000_000 if next(looks) == 7 else 0
        return clock()

    work.clock = disturbed
    measure(work)
    np.testing.assert_array_equal(work.costs, usual)


def test_more_budget_never_settles_less() -> None:
    settled = []
    for budget in (60e-6, 120e-6, 250e-6, 500e-6, 1e-3, 2e-3):
        engine = engine_of(4, budget)
        report = engine(readings_of(engine, {0, 1, 2})).report
        settled.append(sum(each.gap == 1e-4 for each in report if each.answer == "field"))
    assert settled == sorted(settled)
    assert settled[0] < settled[-1] == 3


def test_a_budget_that_holds_no_first_answer_is_an_overrun() -> None:
    engine = engine_of(3, 0.2e-6)
    estimates = engine(readings_of(engine, {0}))
    assert estimates.report.overrun
    assert estimates.report.spent > 0.2e-6
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


@pytest.mark.parametrize("budget", [0.2e-6, 15e-6])
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
    assert overruns == (80 if budget < 1e-6 else sum(served))


def test_a_budget_beyond_reason_is_enough() -> None:
    report = ENGINE(readings_of(ENGINE, {1}), budget=1e300).report
    assert report["p1"].rung == 16
    assert not report.overrun


def test_what_is_preferred_is_served_first_where_time_is_short() -> None:
    hot = {0, 1, 2, 3, 4}
    engine = engine_of(6, 500e-6)
    readings = readings_of(engine, hot)
    for first in (None, 3):
        prefer(engine, None, first)
        gaps = np.array([[each.gap for each in engine(readings).report] for _ in range(9)])
        always = {p for p in hot if (gaps[:, p] == 1e-4).all()}
        assert (3 in always) == (first == 3)
        assert (gaps[:, sorted(hot)] == 1e-4).any(axis=0).all()  # nobody starves
    prefer(engine, 0, 3)
    rungs = [each.rung for each in engine(readings).report]
    assert rungs[3] == 16
    assert {rungs[p] for p in hot - {3}} == {4}
    with pytest.raises(InputError, match="finest is 3"):
        prefer(engine, 3)
    with pytest.raises(InputError, match="first is 6"):
        prefer(engine, None, 6)
