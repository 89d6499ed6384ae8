"""An engine's answers against those of one reconstructor for each patch, also without taxels."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from engine_scenes import (
    CUT,
    ENOUGH,
    LAYER,
    MOVED,
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
from skinfield.errors import Floats, InputError
from skinfield.reconstruct.engine import Engine, MissingPatch
from skinfield.reconstruct.engine.state import IDLE


@pytest.fixture(scope="module")
def linear() -> Engine:
    return engine_of(sf.GaussianField())


@pytest.fixture(scope="module")
def searching() -> Engine:
    return engine_of(sf.NonNegative())


def test_linear_answers_are_those_of_reconstructors(linear: Engine) -> None:
    readings = readings_of(SKIN, ("moved", "other"))
    estimates = linear(readings, stamp_ns=7)
    assert list(estimates) == [patch.name for patch in SKIN]
    assert not estimates.report.overrun
    assert estimates.report.spent > 0
    for patch in SKIN:
        grid, solver = sf.Grid.square(patch, RUNGS[-1]), sf.GaussianField()
        rec = sf.Reconstructor(patch, LAYER, grid, solver=solver, noise_std=NOISE)
        ours, alone = estimates[patch.name], rec(readings[patch.name])
        assert ours.grid.patch is patch
        assert ours.stamp_ns == 7
        assert ours.gap == 0.0
        np.testing.assert_allclose(ours.grid.positions, rec.grid.positions, atol=1e-12)
        assert apart(ours.pressure, alone.pressure) < CUT
        assert apart(ours.displacement, alone.displacement) < CUT
        assert apart(ours.pressure_std, alone.pressure_std) < 1e-9
        assert apart(ours.residual, alone.residual) < CUT
        assert len(ours.contacts) == len(alone.contacts)
        for one, other in zip(ours.contacts, alone.contacts, strict=True):
            assert one.normal_force == pytest.approx(other.normal_force, rel=CUT)
            np.testing.assert_allclose(one.position, other.position, atol=1e-5)
    assert len(estimates["moved"].contacts) == 1
    assert not estimates["icub_triangle"].contacts


def test_searched_answers_are_those_of_reconstructors(searching: Engine) -> None:
    readings = readings_of(SKIN, ("moved", "other"), seed=3)
    searching.reset()
    estimates = searching(readings)
    report = estimates.report
    assert set(report.idle) == {"icub_triangle", "hexagon72"}
    for name in ("moved", "other"):
        patch = SKIN[name]
        rec = sf.Reconstructor(
            patch, LAYER, sf.Grid.square(patch, RUNGS[-1]), solver=sf.NonNegative(), noise_std=NOISE
        )
        ours, alone = estimates[name], rec(readings[name])
        assert report[name].answer == "field"
        assert report[name].rung == RUNGS[-1]
        assert ours.pressure.min() == 0.0
        assert 0.0 <= ours.gap <= 1e-4
        assert apart(ours.pressure, alone.pressure) < 0.02  # both within 1e-4 of the objective
        assert apart(ours.displacement, alone.displacement) < 0.02
        assert ours.contacts[0].normal_force == pytest.approx(
            alone.contacts[0].normal_force, rel=0.02
        )
    quiet = estimates["hexagon72"]
    assert not quiet.pressure.any()
    assert quiet.gap == 0.0
    assert quiet.contacts == ()
    assert quiet.grid.shape == (RUNGS[-1],) * 2  # the finest test, as time is left


def test_idle_patches_are_told_at_the_stated_rate(searching: Engine) -> None:
    alarms = 0
    for seed in range(150):
        report = searching(readings_of(SKIN, (), seed=seed)).report
        alarms += len(report) - len(report.idle)
    # 600 patches at 1e-3 on each of three grids, by a bound that is safe: 0.6 to 1.8 expected
    assert alarms <= 5


def test_patches_of_one_geometry_share_a_plan_wherever_they_are(linear: Engine) -> None:
    assert [group.count for group in linear.groups] == [2, 2]
    assert linear.groups[0].kind.patches == (TRIANGLE, SKIN["moved"])
    wider = replace(TRIANGLE, pad_diameter=3e-3, name="wider")
    turned = replace(TRIANGLE, positions=TRIANGLE.positions[:, [1, 0, 2]], name="turned")
    order = np.r_[1, 0, 2 : len(TRIANGLE)]
    swapped = replace(TRIANGLE.subset(order), name="swapped")
    skin = sf.Skin((TRIANGLE, wider, turned, swapped, MOVED))
    noisy = {"moved": 2 * NOISE}
    assert len(engine_of(sf.GaussianField(), skin, noise_std=NOISE).groups) == 4
    assert len(engine_of(sf.GaussianField(), skin, noise_std=noisy).groups) == 5
    thick = dict.fromkeys((patch.name for patch in skin), LAYER) | {"moved": sf.Layer(3e-3)}
    engine = Engine(skin, thick, solver=sf.GaussianField(), rungs=(8,), budget=ENOUGH)
    assert len(engine.groups) == 5
    assert engine.groups[-1].kind.layer.thickness == 3e-3


def test_a_sequence_in_the_skins_order_is_a_mapping(linear: Engine) -> None:
    readings = readings_of(SKIN, ("other",))
    by_name = linear(readings).keep()
    in_order = linear([readings[patch.name].tolist() for patch in SKIN])
    for name in by_name:
        np.testing.assert_array_equal(by_name[name].pressure, in_order[name].pressure)


def test_a_missing_patch_is_never_repeated(searching: Engine) -> None:
    readings = readings_of(SKIN, ("other",))
    searching(readings)
    del readings["other"]
    estimates = searching(readings)
    assert "other" not in estimates
    assert len(estimates) == 3
    assert estimates.report.missing == ("other",)
    assert estimates.report["other"].skipped == "no reading"
    assert estimates.get("other") is None
    with pytest.raises(MissingPatch, match="'other' was not answered in this cycle: no reading"):
        estimates["other"]
    readings["other"] = np.full(72, np.nan)
    assert searching(readings).report["other"].skipped == "no valid taxel"


def test_estimates_outlast_the_next_cycle_only_if_kept(linear: Engine) -> None:
    first = linear(readings_of(SKIN, ("other",), seed=1))
    seen = first["other"]
    before = seen.pressure.copy()
    kept = linear(readings_of(SKIN, ("moved",), seed=2)).keep()
    linear(readings_of(SKIN, (), seed=3))
    np.testing.assert_array_equal(first["other"].pressure, before)
    assert seen.contacts
    assert len(kept["moved"].contacts) == 1
    with pytest.raises(InputError, match="after the engine's next cycle"):
        first["moved"]


def test_one_patch_is_a_skin(searching: Engine) -> None:
    engine = engine_of(sf.NonNegative(), TRIANGLE)
    estimate = engine({TRIANGLE.name: touched(TRIANGLE, 0)}, budget=1e300)[TRIANGLE.name]
    assert len(estimate.contacts) == 1


@pytest.mark.parametrize(
    ("solver", "power"), [(sf.Tikhonov(), 2e-3), (sf.PseudoInverse(rcond=1e-3), 2e-3)]
)
def test_other_linear_solvers(solver: Any, power: float) -> None:
    engine = engine_of(solver, TRIANGLE)
    readings = touched(TRIANGLE, 1)
    rec = sf.Reconstructor(
        TRIANGLE, LAYER, sf.Grid.square(TRIANGLE, RUNGS[-1]), solver=solver, noise_std=NOISE
    )
    assert apart(engine([readings])[TRIANGLE.name].pressure, rec(readings).pressure) < power


def test_contacts_of_a_fit_are_those_of_a_reconstructor() -> None:
    readings, solver = readings_of(SKIN, ("icub_triangle",)), sf.Auto()
    engine, rec = (
        engine_of(solver, TRIANGLE),
        sf.Reconstructor(
            TRIANGLE, LAYER, sf.Grid.square(TRIANGLE, RUNGS[-1]), solver=solver, noise_std=NOISE
        ),
    )
    ours, alone = engine([readings[TRIANGLE.name]])[TRIANGLE.name], rec(readings[TRIANGLE.name])
    assert len(ours.contacts) == len(alone.contacts) == 1
    for name in ("position", "force", "covariance"):
        np.testing.assert_allclose(
            getattr(ours.contacts[0], name), getattr(alone.contacts[0], name), rtol=1e-9
        )


def test_equal_patches_state_the_same() -> None:
    reading = readings_of(SKIN, ("icub_triangle",))[TRIANGLE.name]
    skin = sf.Skin((TRIANGLE, replace(TRIANGLE, name="further"), MOVED))
    engine = engine_of(sf.Auto(), skin)
    first, further, shifted = engine([reading] * 3).values()
    (one,), (same,), (other,) = first.contacts, further.contacts, shifted.contacts
    for name in ("position", "force", "covariance", "area_std", "outline", "cells"):
        np.testing.assert_array_equal(getattr(one, name), getattr(same, name))
    np.testing.assert_allclose(
        other.position - one.position, MOVED.positions[0] - TRIANGLE.positions[0], atol=1e-15
    )
    np.testing.assert_array_equal(other.covariance, one.covariance)
    for name in ("displacement", "pressure_std", "residual"):
        np.testing.assert_allclose(getattr(first, name), getattr(shifted, name), atol=1e-12)


def test_a_fit_of_contacts_alone_answers_what_is_not_idle() -> None:
    engine = engine_of(sf.ContactFit(), TRIANGLE, rungs=(8, 16))
    readings = touched(TRIANGLE, 0, taxel=4)
    grid = sf.Grid.square(TRIANGLE, 16)
    rec = sf.Reconstructor(TRIANGLE, LAYER, grid, solver=sf.ContactFit(), noise_std=NOISE)
    (found,), (alone,) = engine([readings])[TRIANGLE.name].contacts, rec(readings).contacts
    assert found.normal_force == pytest.approx(alone.normal_force, rel=1e-6)
    assert engine([0.0 * readings])[TRIANGLE.name].contacts == ()
    assert engine.results.answer[0] == IDLE


def test_arguments_that_do_not_fit() -> None:
    fit = SimpleNamespace(linear=None, on=lambda model: fit)
    with pytest.raises(InputError, match=r"SimpleNamespace has no test of idle patches"):
        engine_of(SimpleNamespace(prepare=lambda model: fit), TRIANGLE)
    with pytest.raises(InputError, match=r"rungs is \(40, 20\), expected one or more"):
        engine_of(sf.GaussianField(), TRIANGLE, rungs=(40, 20))
    with pytest.raises(InputError, match="budget is -1, expected a finite number above 0"):
        engine_of(sf.GaussianField(), TRIANGLE, budget=-1)
    with pytest.raises(InputError, match="layer has no entry for patch 'hexagon72'"):
        Engine(SKIN, {"moved": LAYER, "icub_triangle": LAYER})
    with pytest.raises(InputError, match="noise_std names 'arm', which is no patch"):
        engine_of(sf.GaussianField(), noise_std={"arm": 1.0})
    with pytest.raises(InputError, match="skin is a list, expected a Skin or a Patch"):
        engine_of(sf.GaussianField(), [TRIANGLE])  # type: ignore[arg-type]


def test_readings_that_do_not_fit(linear: Engine) -> None:
    good = readings_of(SKIN, ())
    with pytest.raises(
        InputError, match=r"readings\['other'\] has shape \(71,\), expected \(72,\)"
    ):
        linear(good | {"other": np.zeros(71)})
    with pytest.raises(InputError, match="readings names 'elbow', which is no patch"):
        linear(good | {"elbow": np.zeros(3)})
    with pytest.raises(InputError, match="readings has 1 entries, expected one for each of the 4"):
        linear([np.zeros(72)])
    with pytest.raises(InputError, match=r"valid\['other'\] has shape \(3,\)"):
        linear(good, valid={"other": np.ones(3, np.bool_)})
    with pytest.raises(InputError, match="expected numbers"):
        linear(good | {"other": ["x"] * 72})
    assert not linear(good).report.missing
    taxels = sum(map(len, SKIN))
    for flat in (np.zeros(3), np.zeros(taxels, np.float32)):
        with pytest.raises(InputError, match="readings has shape"):
            linear.run(flat)
    with pytest.raises(InputError, match="valid has shape"):
        linear.run(np.zeros(taxels), np.ones(taxels))


def flat_of(readings: dict[str, Floats]) -> Floats:
    return np.concatenate([readings[patch.name] for patch in SKIN])


@pytest.mark.parametrize("kind", ["linear", "searching"])
def test_flat_readings_are_answered_as_those_by_name(
    kind: str, request: pytest.FixtureRequest
) -> None:
    engine: Engine = request.getfixturevalue(kind)
    readings = readings_of(SKIN, ("hexagon72", "moved"), seed=11)
    readings["other"][3] = np.nan
    engine.reset()
    estimates = engine(readings, budget=10.0).keep()
    engine.reset()
    engine.run(flat_of(readings), budget=10.0)
    for index, patch in enumerate(SKIN):
        row = estimates.report[patch.name]
        assert np.array_equal(engine.results.pressure_of(index), estimates[patch.name].pressure)
        assert engine.rungs[engine.results.rung[index]] == row.rung
        assert engine.results.invalid[index] == row.invalid == (patch.name == "other")


def subset_answer(patch: sf.Patch, readings: Floats, valid: Any) -> Floats:
    """Posterior mean from the valid taxels, its prior about that of all: written out."""
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
    noise = NOISE**2 * (np.eye(valid.sum()) + 5.0**2)  # with the offset that taxels share
    expected = seen @ covariance @ seen.T + noise
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
    assert estimate.readings[valid] == pytest.approx(readings["other"][valid], abs=1e-12)
    assert np.isfinite(estimate.readings).all()
    assert (estimate.readings_std[missing] > NOISE).all()
    assert not estimate.valid[missing].any()
    assert np.isfinite(estimate.residual[valid]).all()
    assert any("left out" in note for note in estimate.notes)
    readings["other"][missing] = 0.7  # whatever a taxel says that is not to be used
    by_mask = linear(readings, valid={"other": valid})
    np.testing.assert_allclose(by_mask["other"].pressure, estimate.pressure)
    assert by_mask.report["other"].invalid == len(missing)


def test_missing_taxels_are_left_out_of_a_search(searching: Engine) -> None:
    readings = readings_of(SKIN, ("other", "hexagon72"), seed=5)
    operator: Any = searching.groups[1].operators[-1]
    for missing in ([5, 6], [40], [5, 6]):  # one search serves both patches, whatever is missing
        searching.reset()
        valid = np.ones(72, np.bool_)
        valid[missing] = False
        given = {name: values.copy() for name, values in readings.items()}
        given["other"][missing] = np.nan
        given["hexagon72"][[1, 2]] = -np.inf, 1e30  # no skin reads that
        estimates = searching(given)
        assert estimates.report["hexagon72"].invalid == 2
        alone = operator.without(valid)
        expected = alone.solve(given["other"], alone.data()).pressure
        assert apart(estimates["other"].pressure, expected) < 0.02
        assert estimates["other"].gap <= 1e-4
        assert estimates["hexagon72"].pressure.any()


def test_missing_taxels_of_a_solver_without_a_prior_are_told() -> None:
    engine = engine_of(sf.PseudoInverse(), TRIANGLE)
    readings = touched(TRIANGLE, 1)
    readings[3] = np.nan
    report = engine([readings]).report
    assert report.missing == (TRIANGLE.name,)
    assert "1 taxels did not answer, and this solver cannot" in report[TRIANGLE.name].skipped


def seen_by_few(engine: Engine, rung: int, share: float) -> tuple[Floats, Any]:
    """Readings that stand out by `share` of the threshold, of which two taxels alone are valid."""
    problem: Any = engine.groups[1].operators[rung].problem
    rows, pair = problem.unshared[:, :72].astype(np.float64), np.zeros(72)
    pair[[48, 51]] = 1.0, -1.0  # apart, so that no node matches both alone, and no offset does
    valid = pair != 0.0
    inverse = np.linalg.inv(np.eye(2) + 5.0**2)
    norms = np.sqrt(np.einsum("ki,ij,kj->k", rows[:, valid], inverse, rows[:, valid]))
    white = pair * share * problem.threshold / (rows @ pair / norms).max()
    if share < 1.5:  # by the lengths of whole rows nothing would stand out
        whole = rows @ white / problem.norms
        assert whole.max() < 0.99 * problem.threshold
    strain = white * NOISE
    return strain / (1.0 - strain), valid


@pytest.mark.parametrize("share", [0.95, 1.05, 1.5])
def test_idle_is_told_by_the_valid_taxels_alone(searching: Engine, share: float) -> None:
    searching.reset()
    readings, valid = seen_by_few(searching, -1, share)
    given = readings_of(SKIN, ()) | {"other": np.where(valid, readings, np.nan)}
    report = searching(given).report
    alone: Any = searching.groups[1].operators[-1].without(valid)
    data = alone.data()
    alone.solve(readings, data)
    assert data.idle == (share < 1.0)
    assert (report["other"].answer == "idle") == data.idle
    assert report["other"].rung == RUNGS[-1]
    assert report["other"].gap <= 1e-4
