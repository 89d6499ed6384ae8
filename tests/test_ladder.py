"""Resolutions of one patch: what they share, what switching costs, what gaps leave out."""

import tracemalloc
from typing import Any

import numpy as np
import pytest
from engine_scenes import HEXAGON, LAYER, NOISE, touched
from engine_scenes import TRIANGLE as PATCH

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, InputError
from skinfield.reconstruct.multigrid_levels import RestrictedPosterior, Restriction

RUNGS = (6, 12, 24)
READINGS = touched(PATCH, 0, taxel=4)


def ladder_of(solver: Any) -> sf.Ladder:
    return sf.Ladder(PATCH, LAYER, RUNGS, solver=solver, noise_std=NOISE)


@pytest.fixture(scope="module")
def linear() -> sf.Ladder:
    return ladder_of(sf.GaussianField())


@pytest.fixture(scope="module")
def searching() -> sf.Ladder:
    return ladder_of(sf.NonNegative())


def test_the_finest_rung_is_a_reconstructor(linear: sf.Ladder) -> None:
    grid, solver = sf.Grid.square(PATCH, 24), sf.GaussianField()
    rec = sf.Reconstructor(PATCH, LAYER, grid, solver=solver, noise_std=NOISE)
    linear.rung = 24
    ours, alone = linear(READINGS, stamp_ns=5), rec(READINGS)
    for name in ("pressure", "displacement", "pressure_std", "residual", "traction"):
        expected = getattr(alone, name)
        np.testing.assert_allclose(
            getattr(ours, name), expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max()
        )
    assert ours.contacts[0].normal_force == pytest.approx(alone.contacts[0].normal_force)
    assert (ours.stamp_ns, ours.gap, ours.deadline_met) == (5, 0.0, True)


def test_all_rungs_state_the_same_force_and_moment(linear: sf.Ladder) -> None:
    forces, middles = [], []
    for nodes in RUNGS:
        linear.rung = nodes
        estimate = linear(READINGS)
        assert len(estimate.pressure) == nodes**2 == len(linear.grid)
        forces.append(estimate.normal_force)
        middles.append(estimate.pressure @ estimate.grid.plane * estimate.grid.cell_area)
    np.testing.assert_allclose(forces, forces[-1], rtol=1e-10)
    shift = np.abs(np.subtract(middles, middles[-1])).max() / abs(forces[-1])
    assert shift < PATCH.pitch  # the middle of a coarse cell stands for what lies in it


def test_coarse_uncertainty_is_that_of_averages(linear: sf.Ladder) -> None:
    """Against fields drawn from the fine posterior, and averaged."""
    grid, coarse = sf.Grid.square(PATCH, 24), sf.Grid.square(PATCH, 6)
    model = ObservationModel.of(
        PATCH, LAYER, grid, sf.BondedLayer(), sf.Capacitance(), np.full(len(PATCH), NOISE)
    )
    fine = sf.GaussianField().prepare(model).posterior
    assert fine is not None
    every = np.arange(len(grid))
    row, column = np.divmod(every, 24)
    prior = fine.prior[abs(row[:, None] - row), abs(column[:, None] - column)]
    covariance = prior - fine.factor @ fine.factor.T
    restriction = Restriction.between(grid, coarse)
    matrix = restriction(np.eye(len(grid))).T
    np.testing.assert_allclose(restriction.transposed(np.eye(36)), matrix)
    expected = matrix @ covariance @ matrix.T
    linear.rung = 6
    np.testing.assert_allclose(linear(READINGS).pressure_std, np.sqrt(np.diag(expected)), rtol=1e-6)
    posterior = RestrictedPosterior(fine, restriction)
    cells = np.array([14, 15, 20, 14])  # one of them twice
    weights = np.random.default_rng(0).normal(size=(3, 4))
    whole = np.zeros((3, 36))
    np.add.at(whole.T, cells, weights.T)
    np.testing.assert_allclose(
        posterior.covariance_of_sums(cells, weights), whole @ expected @ whole.T, rtol=1e-6
    )
    assert posterior.felt == 36


def test_restriction_conserves_force_between_grids_that_do_not_nest() -> None:
    rng = np.random.default_rng(1)
    for fine, coarse in ((24, 7), (13, 12), (40, 10), (9, 9)):
        grids = sf.Grid.square(PATCH, fine), sf.Grid.square(PATCH, coarse)
        field = rng.normal(size=(3, fine**2))
        averaged = Restriction.between(*grids)(field)
        np.testing.assert_allclose(
            averaged.sum(axis=1) * grids[1].cell_area, field.sum(axis=1) * grids[0].cell_area
        )
    np.testing.assert_allclose(averaged, field)


@pytest.mark.parametrize(("name", "kept"), [("linear", 1000), ("searching", 16_000)])
def test_switching_and_answering_allocate_nothing(name: str, kept: int, request: Any) -> None:
    ladder: sf.Ladder = request.getfixturevalue(name)
    outs, bytes_at = {nodes: np.zeros(nodes**2) for nodes in RUNGS}, np.zeros((2, 80))
    tracemalloc.start()
    for turn in range(80):  # the first ones are for what the compiler keeps of its arguments
        bytes_at[0, turn] = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        for nodes in RUNGS:
            ladder.rung = nodes
            ladder.apply(READINGS, outs[nodes])
        bytes_at[1, turn] = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    before, highest = bytes_at[:, 40:]
    assert (highest - before).max() < 4000  # a field of the finest rung has 4.6 kB
    assert before[-1] - before[0] < kept
    for nodes in RUNGS:
        ladder.rung = nodes
        assert np.abs(outs[nodes]).max() > 0


def test_a_search_goes_on_from_rung_to_rung(searching: sf.Ladder) -> None:
    searching.reset()
    searching.rung = 24
    cold = searching(READINGS)
    assert 0.0 <= cold.gap <= 1e-4
    assert cold.pressure.min() == 0.0
    searching.reset()
    searching.rung = 12
    searching(READINGS)
    searching.rung = 24
    warm = searching(READINGS)
    assert warm.iterations <= cold.iterations
    np.testing.assert_allclose(warm.pressure, cold.pressure, atol=0.02 * cold.pressure.max())
    rec = sf.Reconstructor(
        PATCH, LAYER, sf.Grid.square(PATCH, 24), solver=sf.NonNegative(), noise_std=NOISE
    )
    alone = rec(READINGS)
    np.testing.assert_allclose(cold.pressure, alone.pressure, atol=0.02 * cold.pressure.max())
    np.testing.assert_allclose(cold.residual, alone.residual, atol=0.1 * NOISE)
    assert cold.contacts[0].normal_force == pytest.approx(alone.contacts[0].normal_force, rel=0.02)


def test_a_deadline_reaches_the_search(searching: sf.Ladder) -> None:
    searching.rung = 24
    searching.reset()
    hasty = searching(READINGS, deadline=1e-9)
    assert not hasty.deadline_met
    assert hasty.pressure.min() >= 0.0


def test_contacts_of_a_fit_are_those_of_a_reconstructor_on_every_rung() -> None:
    ladder = ladder_of(sf.ContactFit())
    grid = sf.Grid.square(PATCH, 24)
    rec = sf.Reconstructor(PATCH, LAYER, grid, solver=sf.ContactFit(), noise_std=NOISE)
    ladder.rung, alone = 12, rec(READINGS).contacts[0]
    found = ladder(READINGS).contacts[0]
    assert found.normal_force == pytest.approx(alone.normal_force, rel=1e-3)
    np.testing.assert_allclose(found.position, alone.position, atol=1e-5)


def test_arguments_that_do_not_fit(linear: sf.Ladder) -> None:
    with pytest.raises(InputError, match=r"rung is 7, expected one of \(6, 12, 24\)"):
        linear.rung = 7
    with pytest.raises(InputError, match="rungs is \\(\\), expected one or more"):
        sf.Ladder(PATCH, LAYER, ())
    with pytest.raises(InputError, match="rungs is 1, expected a whole number from 2 to 400"):
        sf.Ladder(PATCH, LAYER, (1, 10))
    with pytest.raises(InputError, match="one reading at a time"):
        linear(np.zeros((2, len(PATCH))))
    with pytest.raises(InputError, match="deadline is 0"):
        linear(np.zeros(len(PATCH)), deadline=0)


@pytest.mark.parametrize("deadline", [1e10, 1e300])
@pytest.mark.parametrize("name", ["linear", "searching"])
def test_a_deadline_beyond_reason_is_none(name: str, deadline: float, request: Any) -> None:
    ladder: sf.Ladder = request.getfixturevalue(name)
    ladder.rung = 6
    assert ladder(READINGS, deadline=deadline).deadline_met


FINEST = sf.Grid.square(HEXAGON, 24)
LINEAR: dict[str, Any] = {
    "gaussian": sf.GaussianField(),
    "white": sf.Tikhonov(),
    "exact": sf.PseudoInverse(),
}
FIELDS = ("pressure", "displacement", "traction", "pressure_std", "residual")


def readings_lacking(missing: int) -> Floats:
    """A ball's readings with noise, some taxels missing, those below the ball among them."""
    ball = sf.simulate.Sphere(radius=8e-3, force=3.0)
    press = sf.simulate.press(LAYER, [ball], cell=1e-3)
    readings = press.readings(
        HEXAGON.plane - HEXAGON.plane[30], HEXAGON.pad_diameter, "capacitance"
    )
    rng = np.random.default_rng(missing)
    readings = np.asarray(readings + rng.normal(0.0, NOISE, len(HEXAGON)))
    readings[rng.choice(len(HEXAGON), missing, replace=False)] = np.nan
    return readings


@pytest.fixture(scope="module", params=LINEAR)
def pair(request: Any) -> tuple[sf.Ladder, sf.Reconstructor]:
    solver = LINEAR[request.param]
    ladder = sf.Ladder(HEXAGON, LAYER, (8, 24), solver=solver, noise_std=NOISE)
    return ladder, sf.Reconstructor(HEXAGON, LAYER, FINEST, solver=solver, noise_std=NOISE)


def near(found: Floats, expected: Floats) -> None:
    size = np.nanmax(np.abs(expected))  # 1e-13: a residual of readings that are met exactly
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-8 * size + 1e-13)


@pytest.mark.parametrize("missing", [1, 12, 60])
def test_all_is_that_of_a_reconstructor(
    pair: tuple[sf.Ladder, sf.Reconstructor], missing: int
) -> None:
    ladder, rec = pair
    ladder.rung = 24
    readings = readings_lacking(missing)
    ours, alone = ladder(readings), rec(readings)
    for name in FIELDS:
        near(getattr(ours, name), getattr(alone, name))
    assert len(ours.contacts) == len(alone.contacts)
    for one, other in zip(ours.contacts, alone.contacts, strict=True):
        assert one.normal_force == pytest.approx(other.normal_force, rel=1e-7)
        near(one.covariance, other.covariance)
    assert ours.notes == (f"{missing} taxels left out",)


def test_a_coarse_rung_is_its_means(pair: tuple[sf.Ladder, sf.Reconstructor]) -> None:
    ladder, rec = pair
    readings = readings_lacking(12)
    whole = rec(readings)
    ladder.rung = 8
    coarse = ladder(readings)
    near(coarse.pressure, Restriction.between(FINEST, ladder.grid)(whole.pressure))
    near(coarse.residual, whole.residual)


def test_what_stands_in_place_of_a_missing_reading_does_not_count() -> None:
    ladder = sf.Ladder(HEXAGON, LAYER, (24,), noise_std=NOISE)
    lacking = readings_lacking(5)
    valid = ~np.isnan(lacking)
    wild = np.where(valid, lacking, 7.0)
    near(ladder(wild, valid=valid).pressure, ladder(lacking).pressure)
    empty = np.full(len(HEXAGON), np.nan)
    with pytest.raises(InputError, match="no valid taxel"):
        ladder(empty)


def test_a_searchs_deviations_are_those_without_the_missing() -> None:
    solver = sf.NonNegative(tolerance=1e-6, precision=np.float64)
    ladder = sf.Ladder(HEXAGON, LAYER, (24,), solver=solver, noise_std=NOISE)
    rec = sf.Reconstructor(HEXAGON, LAYER, FINEST, solver=solver, noise_std=NOISE)
    readings = readings_lacking(30)
    ours, alone = ladder(readings), rec(readings)
    near(ours.pressure_std, alone.pressure_std)
    away = np.linalg.norm(ours.pressure - alone.pressure) / np.linalg.norm(alone.pressure)
    assert away < 1e-2  # both to the tolerance
