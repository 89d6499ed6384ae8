"""Resolutions of one patch: what they share."""

import numpy as np
import pytest
from engine_scenes import LAYER, NOISE, touched
from engine_scenes import TRIANGLE as PATCH

import skinfield as sf
from skinfield.errors import InputError
from skinfield.estimate import PressurePosterior
from skinfield.reconstruct.multigrid import (
    RestrictedPosterior,
    Restriction,
    Rungs,
    prepare_rungs,
)

RUNGS = (6, 12, 24)
READINGS = touched(PATCH, 0, taxel=4)


@pytest.fixture(scope="module")
def rungs() -> Rungs:
    physics = sf.BondedLayer(), sf.Capacitance()
    return prepare_rungs(PATCH, LAYER, RUNGS, *physics, sf.GaussianField(), NOISE)


def test_all_rungs_state_the_same_force_and_moment(rungs: Rungs) -> None:
    forces, middles = [], []
    for nodes, step in zip(RUNGS, rungs.steps, strict=True):
        pressure = step.operator.solve(READINGS, step.operator.data()).pressure
        assert len(pressure) == nodes**2 == len(step.grid)
        forces.append(pressure.sum() * step.grid.cell_area)
        middles.append(pressure @ step.grid.plane * step.grid.cell_area)
    np.testing.assert_allclose(forces, forces[-1], rtol=1e-10)
    shift = np.abs(np.subtract(middles, middles[-1])).max() / abs(forces[-1])
    assert shift < PATCH.pitch  # the middle of a coarse cell stands for what lies in it


def test_coarse_uncertainty_is_that_of_averages(rungs: Rungs) -> None:
    """Against fields drawn from the fine posterior, and averaged."""
    grid, coarse = sf.Grid.square(PATCH, 24), sf.Grid.square(PATCH, 6)
    fine = rungs.start.posterior
    assert isinstance(fine, PressurePosterior)
    every = np.arange(len(grid))
    row, column = np.divmod(every, 24)
    prior = fine.prior[abs(row[:, None] - row), abs(column[:, None] - column)]
    covariance = prior - fine.factor @ fine.factor.T
    restriction = Restriction.between(grid, coarse)
    matrix = restriction(np.eye(len(grid))).T
    np.testing.assert_allclose(restriction.transposed(np.eye(36)), matrix)
    expected = matrix @ covariance @ matrix.T
    std = rungs.steps[0].operator.pressure_std()
    np.testing.assert_allclose(std, np.sqrt(np.diag(expected)), rtol=1e-6)
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


def test_arguments_that_do_not_fit() -> None:
    with pytest.raises(InputError, match="rungs is \\(\\), expected one or more"):
        sf.Reconstructor(PATCH, LAYER, ())
    with pytest.raises(InputError, match="rungs is 1, expected a whole number from 4 to 400"):
        sf.Reconstructor(PATCH, LAYER, (1, 10))
