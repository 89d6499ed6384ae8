"""Stated covariances against dense algebra, and against draws of what they speak of."""

import numpy as np
import pytest
from non_negative_reference import small_model

from skinfield.elastic import ObservationModel
from skinfield.errors import InputError
from skinfield.estimate import ContactFinder, ModelError, PressureNoise, PressurePosterior
from skinfield.estimate.uncertainty import normal_interval, normal_radius
from skinfield.skin import Grid
from skinfield.solve import GaussianField, PseudoInverse, Tikhonov
from skinfield.solve.contract import square_patch
from skinfield.solve.linear import correlation

SOLVERS = [GaussianField(snr=12.0, length_scale=3e-3), GaussianField(), Tikhonov()]
DRAWS = 3000  # a variance is then known to 2.6 %, a standard deviation to 1.3 %


def model() -> ObservationModel:
    return small_model(20)


def dense(solver: GaussianField | Tikhonov) -> tuple[np.ndarray, np.ndarray]:
    """Prior and posterior covariance (K, K), from the formulas and nothing else."""
    whole = model()
    white = whole.matrix / whole.noise_std[:, None]
    if isinstance(solver, Tikhonov):
        shape = np.eye(len(whole.grid))
    else:
        length = solver.length_scale or 0.25 * 4e-3  # of the taxels' distance
        plane = whole.grid.plane
        scaled = np.sqrt(3) * np.linalg.norm(plane[:, None] - plane[None], axis=-1) / length
        shape = (1 + scaled) * np.exp(-scaled)
    prior = shape * solver.snr**2 * len(white) / np.trace(white @ shape @ white.T)
    gain = np.linalg.solve(white @ prior @ white.T + np.eye(len(white)), white @ prior)
    return prior, prior - prior @ white.T @ gain


def posterior_of(solver: GaussianField | Tikhonov) -> PressurePosterior:
    posterior = solver.prepare(model()).posterior
    assert posterior is not None
    return posterior


@pytest.mark.parametrize("solver", SOLVERS, ids=repr)
@pytest.mark.parametrize("count", [7, 60, 390])  # of cells
def test_sums_over_cells_have_the_dense_covariance(
    solver: GaussianField | Tikhonov, count: int
) -> None:
    rng = np.random.default_rng(count)
    cells = rng.choice(len(model().grid), count, replace=False)
    cells[-1] = cells[0]  # one comes twice
    weights = rng.normal(size=(3, count))
    expected = weights @ dense(solver)[1][np.ix_(cells, cells)] @ weights.T
    found = posterior_of(solver).covariance_of_sums(cells, weights)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-8 * np.abs(expected).max())
    whole = posterior_of(solver)
    np.testing.assert_allclose(whole.std**2, np.diag(dense(solver)[1]), rtol=1e-6)
    gain = dense(solver)[1] @ model().matrix.T / model().noise_std ** 2
    off = np.abs(solver.prepare(model()).matrix - gain)
    assert (off <= np.maximum(1e-6 * np.abs(gain), 1e-8 * gain.max())).all()
    assert whole.on(cells).covariance_of_sums(np.arange(count), weights) == pytest.approx(found)


def small_spread(pressure: np.ndarray, grid: Grid) -> tuple[PressurePosterior, np.ndarray]:
    """Smooth errors, small beside a pressure: the posterior without readings, and draws of it."""
    prior = (0.03 * pressure.max()) ** 2 * correlation(grid, 4e-3)
    posterior = PressurePosterior.of_lattice(prior, np.zeros((len(grid), 1)))
    plane = grid.plane
    scaled = np.sqrt(3) * np.linalg.norm(plane[:, None] - plane[None], axis=-1) / 4e-3
    whole = prior[0, 0] * (1 + scaled) * np.exp(-scaled)
    root = np.linalg.cholesky(whole + 1e-9 * prior[0, 0] * np.eye(len(grid)))
    return posterior, np.random.default_rng(9).standard_normal((DRAWS, len(grid))) @ root.T


def test_place_and_force_of_drawn_fields_scatter_as_the_contact_says() -> None:
    grid = Grid.square(square_patch(side=9), nodes=26)
    pressure = 1e4 * np.maximum(0.0, 1 - ((grid.plane - (2e-3, -1e-3)) ** 2).sum(axis=1) / 64e-6)
    posterior, errors = small_spread(pressure, grid)
    quiet = PressureNoise(np.full((len(grid), 1), 1.0))
    (contact,) = ContactFinder()(grid, pressure, quiet, posterior)
    loads = (pressure + errors)[:, contact.cells] * grid.cell_area
    places = loads @ grid.plane[contact.cells] / loads.sum(axis=1, keepdims=True)
    size = np.sqrt(np.diag(contact.covariance))
    found = np.cov(np.column_stack([places, loads.sum(axis=1)]).T) / np.outer(size, size)
    assert found == pytest.approx(contact.covariance / np.outer(size, size), abs=0.1)
    assert contact.place_std == pytest.approx(np.hypot(size[0], size[1]))


def test_without_a_prior_contacts_scatter_by_the_readings_noise() -> None:
    whole, rng = model(), np.random.default_rng(2)
    truth = 2e4 * np.maximum(0.0, 1 - ((whole.grid.plane - 1e-3) ** 2).sum(axis=1) / 36e-6)
    operator = PseudoInverse(rcond=0.05).prepare(whole)
    assert operator.posterior is None
    pressure = operator.matrix @ (whole.matrix @ truth)
    noise = PressureNoise(operator.matrix * whole.noise_std)
    contact = ContactFinder()(whole.grid, pressure, noise)[0]
    readings = whole.matrix @ truth + 20.0 * rng.standard_normal((DRAWS, len(whole.taxels)))
    loads = (readings @ operator.matrix.T)[:, contact.cells] * whole.grid.cell_area
    places = loads @ whole.grid.plane[contact.cells] / loads.sum(axis=1, keepdims=True)
    assert loads.sum(axis=1).std() == pytest.approx(contact.force_std, rel=0.05)
    assert np.hypot(*places.std(axis=0)) == pytest.approx(contact.place_std, rel=0.05)


def test_model_errors_add_in_square_and_scale_with_the_contact() -> None:
    grid = Grid.square(square_patch(side=9), nodes=26)
    pressure = 1e4 * np.maximum(0.0, 1 - (grid.plane**2).sum(axis=1) / 64e-6)
    quiet = PressureNoise(np.full((len(grid), 1), 1.0))
    known = ModelError(force=0.3, place=2e-4)
    (bare,) = ContactFinder()(grid, pressure, quiet)
    (contact,) = ContactFinder()(grid, pressure, quiet, None, known)
    added = np.diag([2e-4, 2e-4, 0.3 * bare.normal_force]) ** 2
    assert contact.covariance == pytest.approx(bare.covariance + added)
    with pytest.raises(InputError, match="force is -1"):
        ModelError(force=-1.0)


def test_a_matrix_made_by_hand_has_no_known_model_error() -> None:
    whole = model()
    by_hand = ObservationModel(
        whole.matrix, whole.noise_std, whole.taxels, whole.grid, whole.virtual_matrix
    )
    assert GaussianField().prepare(by_hand).model_error == ModelError()
    assert GaussianField().prepare(whole).model_error.force > 0.5  # blind between taxels
    assert PseudoInverse().prepare(by_hand).model_error == ModelError()


@pytest.mark.parametrize("level", [0.5, 0.9, 0.99])
def test_the_circle_of_a_normal_distribution_holds_its_share(level: float) -> None:
    assert normal_radius(np.eye(2), level) == pytest.approx(np.sqrt(-2 * np.log(1 - level)))
    covariance = np.array([[4.0, 1.5], [1.5, 1.0]])
    drawn = np.random.default_rng(0).multivariate_normal([0, 0], covariance, 100_000)
    inside = np.mean(np.hypot(*drawn.T) <= normal_radius(covariance, level))
    assert inside == pytest.approx(level, abs=5e-3)
    assert normal_radius(np.zeros((2, 2)), level) == 0.0
    low, high = normal_interval(1.0, 2.0, level)
    assert np.mean(np.abs(drawn[:, 0]) <= (high - low) / 2) == pytest.approx(level, abs=5e-3)
    with pytest.raises(InputError, match=r"level is 1\.2"):
        normal_interval(1.0, 2.0, 1.2)
