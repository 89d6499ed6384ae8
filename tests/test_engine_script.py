"""Cycles that are repeated bit for bit, wherever the clock had cut them."""

import subprocess
import sys
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from engine_scenes import RUNGS, SKIN, engine_of, readings_of
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from script_scenes import SOLVERS, STARTS, digest, lived, moving, replayed, save

from skinfield.engine import Engine
from skinfield.engine.script import SEARCH, WIDTH
from skinfield.errors import InputError

CYCLES = 2000
NATURAL, UNPROVED, LATE = 0, 1, 2  # of endings, beside the turns
AGAIN = settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))


@lru_cache(maxsize=2)
def engines(solver: str) -> tuple[Engine, Engine]:
    return engine_of(SOLVERS[solver]), engine_of(SOLVERS[solver])


@pytest.mark.parametrize("solver", list(SOLVERS))
def test_long_chains_are_repeated_here_and_in_another_process(solver: str, tmp_path: Path) -> None:
    readings, valid = moving(CYCLES, seed=7)
    budgets = 10.0 ** np.random.default_rng(1).uniform(-5.0, -3.0, CYCLES)
    chain = lived(engines(solver)[0], readings, valid, budgets)
    assert len(set(chain.digests)) > 0.5 * CYCLES  # idle ones are alike
    assert replayed(engines(solver)[1], chain) == chain.digests
    save(tmp_path / "chain.npz", chain)
    call = "import sys, script_scenes; script_scenes.replay_file(*sys.argv[1:])"
    subprocess.run(
        [sys.executable, "-c", call, str(tmp_path / "chain.npz"), solver],
        cwd=Path(__file__).parent,
        check=True,
        timeout=300,
    )


@AGAIN
@given(st.lists(st.floats(1e-6, 2e-3), min_size=1, max_size=30), st.integers(0, 5))
def test_whatever_the_budgets(budgets: list[float], seed: int) -> None:
    readings, valid = moving(40, seed)
    for solver in SOLVERS:
        live, other = engines(solver)
        chain = lived(live, readings[: len(budgets)], valid, np.array(budgets))
        chain = chain._replace(valid=valid[: len(budgets)])
        assert replayed(other, chain) == chain.digests


def test_the_estimates_are_the_same() -> None:
    live, other = engines("search")
    rng = np.random.default_rng(3)
    flat, _ = moving(30, seed=9)
    live.reset()
    other.reset()
    for cycle in range(30):
        parts = zip(SKIN, STARTS, strict=False)
        readings = {patch.name: flat[cycle, at : at + len(patch)] for patch, at in parts}
        if cycle % 4 == 1:
            del readings["moved"]
        valid = {"other": rng.random(len(SKIN["other"])) < 0.9} if cycle % 3 else None
        estimates = live(readings, valid=valid, budget=10.0 ** rng.uniform(-4.5, -2.5)).keep()
        again = other.again(readings, valid=valid, stamp_ns=5, script=live.script)
        assert set(again) == set(estimates)
        for name, estimate in estimates.items():
            same = again[name]
            assert np.array_equal(estimate.pressure, same.pressure)
            assert np.array_equal(estimate.gap, same.gap, equal_nan=True)
            assert (estimate.iterations, same.stamp_ns) == (same.iterations, 5)
            one, two = estimates.report[name], again.report[name]
            assert (one.answer, one.rung, one.waited) == (two.answer, two.rung, two.waited)
        assert np.array_equal(other.script, live.script)


def test_a_reset_forgets_all_that_matters() -> None:
    """Engines of different pasts answer the same after it, from then on."""
    readings, valid = moving(60, seed=2)
    for solver in SOLVERS:
        one, other = engines(solver)
        for cycle in range(37):
            one.run(readings[cycle], valid[cycle], budget=1e-3)
        chain = lived(one, readings[40:], valid[40:], np.full(20, 3e-4))
        for cycle in range(11):
            other.run(readings[3 * cycle], valid[cycle], budget=10.0)
        assert replayed(other, chain) == chain.digests


@pytest.mark.parametrize("flags", [NATURAL, UNPROVED, LATE, LATE + UNPROVED])
def test_every_ending_of_a_search_can_be_told(flags: int) -> None:
    """From the same start, searches that are told the same ending do the same."""
    group = engines("search")[0].groups[-1]
    whole, nodes = group.searches[-1][0], len(group.feasible[-1][0])
    first, second = whole.twin(), whole.twin()
    readings, _ = moving(40, seed=1)
    place = [patch.name for patch in SKIN].index(group.kind.patches[0].name)
    rows = readings[:, STARTS[place] : STARTS[place + 1]]
    rows = rows[np.isfinite(rows).all(axis=1)]
    endings, fields = [], []
    for turns, row in enumerate(rows[:25], start=1):
        out, same = np.zeros(nodes), np.ones(nodes)
        first.again(row, out, 4 * turns + flags)
        second.again(row, same, first.ending)  # where it ended: by itself, or as told
        assert np.array_equal(out, same)
        assert np.array_equal(first.dual, second.dual)
        assert np.array_equal(first.gap, second.gap)
        assert first.ending == second.ending
        told, its = divmod(first.ending, 4)
        assert its in (NATURAL, flags)
        assert told <= turns or not its & LATE
        endings.append(first.ending)
        fields.append(out)
    assert any(field.any() for field in fields)
    assert len(set(endings)) > 3


def test_readings_of_another_cycle_are_told() -> None:
    live, other = engines("search")
    readings, _ = moving(40, seed=1)
    other.reset()
    live.reset()
    live.run(readings[0], budget=10.0)
    other.run(readings[0], script=live.script)
    live.run(readings[1], budget=10.0)
    script = live.script.copy()
    search = script[:, 0] == SEARCH
    assert search.any()
    script[search, 3] += 4  # a turn more than it took
    with pytest.raises(InputError, match="reset\\(\\) and begin at a key cycle"):
        other.run(readings[1], script=script)


@pytest.mark.parametrize("solver", list(SOLVERS))
@pytest.mark.parametrize(
    "wrong",
    [
        np.zeros((0, WIDTH), np.int64),
        np.zeros((2, WIDTH)),
        np.zeros((2, 3), np.int64),
        [[7, -1, 0, -1, -1]],
        [[2, 0, 0, -1, -1]],
        [[0, -1, 9, -1, -1]],
        [[1, -1, -1, -1, -1]],
        [[1, -1, 0, -1, -1], [3, 99, 0, 4, 0]],
        [[1, -1, 0, -1, -1], [3, 0, 0, -1, 0]],
        [[1, -1, 0, -1, -1], [3, 0, 0, 4, 2]],
        [[1, -1, 0, -1, -1]] * 500,
        [[0, -1, 0, -1, -1], [0, -1, 0, -1, -1]],
    ],
)
def test_scripts_of_no_such_engine_are_refused(solver: str, wrong) -> None:
    engine, readings = engines(solver)[0], np.zeros(STARTS[-1])
    engine.run(readings)
    before = digest(engine)
    with pytest.raises(InputError, match="script"):
        engine.run(readings, script=wrong)
    assert digest(engine) == before


rows = arrays.arrays(
    np.int64,
    st.tuples(st.integers(0, 12), st.just(WIDTH)),
    elements=st.integers(-2, 5) | st.integers(-(2**63), 2**63 - 1),
)


@AGAIN
@given(rows, st.integers(0, 39))
def test_damaged_scripts_do_no_harm(script, cycle: int) -> None:
    readings, valid = moving(40, 0)
    for solver in SOLVERS:
        engine = engines(solver)[0]
        for first in ([], [[1, -1, 0, -1, -1]], [[0, -1, 2, -1, -1]]):
            told = np.concatenate([np.array(first, np.int64).reshape(-1, WIDTH), script])
            with suppress(InputError):
                engine.run(readings[cycle], valid[cycle], script=told)


def test_flat_readings_are_checked() -> None:
    engine = engines("search")[0]
    with pytest.raises(InputError, match="readings has shape"):
        engine.run(np.zeros(3))
    with pytest.raises(InputError, match="readings has shape"):
        engine.run(np.zeros(STARTS[-1], np.float32))
    with pytest.raises(InputError, match="valid has shape"):
        engine.run(np.zeros(STARTS[-1]), np.ones(STARTS[-1]))


@pytest.mark.parametrize("solver", list(SOLVERS))
def test_flat_readings_are_answered_as_those_by_name(solver: str) -> None:
    named, flat = engines(solver)
    readings = readings_of(SKIN, ("hexagon72", "moved"), seed=11)
    readings["other"][3] = np.nan
    named.reset()
    flat.reset()
    estimates = named(readings, budget=10.0)
    flat.run(np.concatenate([readings[patch.name] for patch in SKIN]), script=named.script)
    for index, patch in enumerate(SKIN):
        row = estimates.report[patch.name]
        assert np.array_equal(flat.results.pressure_of(index), estimates[patch.name].pressure)
        assert RUNGS[flat.results.rung[index]] == row.rung
        assert flat.results.invalid[index] == row.invalid == (patch.name == "other")


@pytest.mark.parametrize("solver", list(SOLVERS))
def test_a_rehearsal_changes_nothing(solver: str) -> None:
    """Not what was answered, nor what follows."""
    live, other = engines(solver)
    readings, valid = moving(40, seed=5)
    live.reset()
    other.reset()
    for cycle in range(40):
        live.run(readings[cycle], valid[cycle], budget=1e-3)
        before, script, number = digest(live), live.script.copy(), live.cycle
        live.rehearse()
        live.rehearse(1e-4)
        assert digest(live) == before
        assert np.array_equal(live.script, script)
        assert live.cycle == number
        other.run(readings[cycle], valid[cycle], script=script)
        assert digest(other) == before
