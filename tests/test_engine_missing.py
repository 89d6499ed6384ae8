"""Patches some of whose taxels did not answer."""

from typing import Any

import numpy as np
import pytest
from engine_scenes import (
    CUT,
    LAYER,
    NOISE,
    RUNGS,
    SKIN,
    TRIANGLE,
    apart,
    engine_of,
    readings_of,
    touched,
)

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats
from skinfield.reconstruct.engine import Engine
from skinfield.reconstruct.engine.block_sparse_kernel import idle_patches


@pytest.fixture(scope="module")
def linear() -> Engine:
    return engine_of(sf.GaussianField())


@pytest.fixture(scope="module")
def searching() -> Engine:
    return engine_of(sf.NonNegative())


def subset_answer(patch: sf.Patch, readings: Floats, valid: Any) -> Floats:
    """Posterior mean from the valid taxels, its prior that of all: written out."""
    grid = sf.Grid.square(patch, RUNGS[-1])
    model = ObservationModel.of(
        patch, LAYER, grid, sf.BondedLayer(), sf.Capacitance(), np.full(len(patch), NOISE)
    )
    prior = sf.GaussianField().prepare(model).posterior
    assert prior is not None
    row, column = np.divmod(np.arange(len(grid)), grid.shape[1])
    covariance = prior.prior[abs(row[:, None] - row), abs(column[:, None] - column)]
    seen = model.matrix[valid]
    strain = readings[valid] / (1.0 + readings[valid])
    expected = seen @ covariance @ seen.T + NOISE**2 * np.eye(valid.sum())
    return np.asarray(covariance @ seen.T @ np.linalg.solve(expected, strain))


@pytest.mark.parametrize("ranks", [[0], [1, 2, 10, 40], list(range(0, 72, 2))])
def test_missing_taxels_are_left_out_of_a_linear_answer_exactly(
    linear: Engine, ranks: list[int]
) -> None:
    readings = readings_of(SKIN, ("other",), seed=4)
    missing = np.argsort(-readings["other"])[ranks]
    whole = linear(readings)["other"].pressure.copy()
    valid = np.ones(72, np.bool_)
    valid[missing] = False
    expected = subset_answer(SKIN["other"], readings["other"], valid)
    readings["other"][missing] = np.nan
    estimate = linear(readings)["other"]
    assert apart(estimate.pressure, expected) < CUT < apart(whole, expected)
    assert np.isnan(estimate.residual[missing]).all()
    assert not estimate.valid[missing].any()
    assert np.isfinite(estimate.residual[valid]).all()
    assert any("left out" in note for note in estimate.notes)
    readings["other"][missing] = 0.7  # whatever a taxel says that is not to be used
    by_mask = linear(readings, valid={"other": valid})
    np.testing.assert_allclose(by_mask["other"].pressure, estimate.pressure)
    assert by_mask.report["other"].invalid == len(missing)


def test_missing_taxels_are_left_out_of_a_search(searching: Engine) -> None:
    readings = readings_of(SKIN, ("other", "hexagon72"), seed=5)
    group = searching.groups[1]
    operator: Any = group.searches[-1][0]
    for missing in ([5, 6], [40], [5, 6]):  # one search serves both patches, whatever is missing
        searching.reset()
        valid = np.ones(72, np.bool_)
        valid[missing] = False
        given = {name: values.copy() for name, values in readings.items()}
        given["other"][missing] = np.nan
        given["hexagon72"][[1, 2]] = -np.inf  # no skin reads that
        estimates = searching(given)
        assert estimates.report["hexagon72"].invalid == 2
        alone = operator.without(valid)
        expected = np.zeros(len(estimates["other"].grid))
        alone.apply(np.where(valid, given["other"] / (1 + given["other"]), 0.0), expected, None)
        assert apart(estimates["other"].pressure, expected) < 0.02
        assert estimates["other"].gap <= 1e-4
        reduced: Any = group.search_of(2, 0, valid)
        for name in ("rows", "vectors", "whitening"):
            ours, theirs = getattr(reduced._packed, name), getattr(alone._packed, name)
            np.testing.assert_allclose(ours, theirs, rtol=1e-6)
        assert estimates["hexagon72"].pressure.any()


def test_missing_taxels_of_a_solver_without_a_prior_are_told() -> None:
    engine = engine_of(sf.PseudoInverse(), TRIANGLE)
    readings = touched(TRIANGLE, 1)
    readings[3] = np.nan
    report = engine([readings]).report
    assert report.missing == (TRIANGLE.name,)
    assert "1 taxels did not answer, and this solver cannot" in report[TRIANGLE.name].skipped


def seen_by_few(engine: Engine, rung: int, share: float) -> tuple[Floats, Floats, Any]:
    """Readings that stand out by `share` of the threshold, of which two taxels alone are valid.

    Returned with how much they would stand out if all others had answered 0.
    """
    operator: Any = engine.groups[1].searches[rung][0]
    rows = operator.problem.rows[:, :72].astype(np.float64)
    valid = np.zeros(72, np.bool_)
    valid[[48, 51]] = True  # apart, so that no node matches both alone
    norms = np.linalg.norm(rows[:, valid], axis=1)
    white = valid * share * operator.threshold / (rows @ valid / norms).max()
    whole = (rows @ white / np.linalg.norm(rows, axis=1)).max() / operator.threshold
    strain = white * NOISE
    return strain / (1.0 - strain), whole, valid


@pytest.mark.parametrize("share", [0.95, 1.05, 1.5])
def test_idle_is_told_by_the_valid_taxels_alone(searching: Engine, share: float) -> None:
    searching.reset()
    readings, _, valid = seen_by_few(searching, -1, share)
    given = readings_of(SKIN, ()) | {"other": np.where(valid, readings, np.nan)}
    report = searching(given).report
    alone: Any = searching.groups[1].searches[-1][0]
    alone = alone.without(valid)
    alone.apply(readings / (1.0 + readings), np.zeros(RUNGS[-1] ** 2), None)
    assert alone.idle == (share < 1.0)
    assert (report["other"].answer == "idle") == alone.idle
    assert report["other"].rung == RUNGS[-1]
    assert report["other"].gap <= 1e-4


def test_masked_idle_test_differs_from_that_of_all_taxels(searching: Engine) -> None:
    work = searching._work
    readings, whole, valid = seen_by_few(searching, -1, 1.05)
    work.intake.take(readings_of(SKIN, ()) | {"other": np.where(valid, readings, np.nan)}, None)
    work.open()
    patch = work.intake.names.index("other")
    assert whole < 0.99  # by the lengths of whole rows nothing stands out
    idle = np.zeros(len(work.places), np.bool_)
    atlas = work.tests[len(RUNGS) - 1]
    idle_patches(*atlas.arrays[:7], work.intake.white, atlas.scores, idle)
    assert idle[patch]
    assert not work.is_idle(patch, len(RUNGS) - 1)


def test_without_time_idle_is_told_on_the_coarsest_rung(searching: Engine) -> None:
    readings, _, valid = seen_by_few(searching, 0, 0.95)
    given = readings_of(SKIN, ()) | {"other": np.where(valid, readings, np.nan)}
    each = searching(given, budget=1e-6).report["other"]
    assert (each.answer, each.rung) == ("idle", RUNGS[0])
