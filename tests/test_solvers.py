"""Every solver keeps the contract; the paper's two also agree with their definitions."""

import numpy as np
import pytest

from skinfield.elastic import BaseStress, BondedLayer, HalfSpace, Layer, ObservationModel
from skinfield.errors import InputError
from skinfield.skin import Grid
from skinfield.solve import ContactFit, GaussianField, Inverse, PseudoInverse, Solver, Tikhonov
from skinfield.solve.linear import smoothed
from skinfield.testing import SolverContract
from skinfield.testing.solver import square_patch


class TestTikhonov(SolverContract):
    solver = Tikhonov(snr=300.0)
    force_ratio = (0.92, 0.97)  # a known loss: taxels 4 mm apart, 2 mm deep
    place_error = 0.2e-3


class TestPseudoInverse(SolverContract):
    solver = PseudoInverse()
    force_ratio = (0.92, 0.97)  # a known loss: taxels 4 mm apart, 2 mm deep
    place_error = 0.2e-3


class TestPseudoInverseOnVirtualTaxels(SolverContract):
    solver = PseudoInverse(resample=True)
    force_ratio = (0.93, 1.0)
    place_error = 0.4e-3
    left_out_change = 0.25  # the hull loses its corner, and the inverse amplifies the kink
    nodes = 12


class TestInverse(SolverContract):
    solver = Inverse()
    force_ratio = (0.93, 1.0)
    place_error = 0.4e-3
    left_out_change = 0.25
    nodes = 12


class TestGaussianField(SolverContract):
    solver = GaussianField(snr=300.0)
    force_ratio = (0.95, 1.05)
    place_error = 0.3e-3


class TestContactFit(SolverContract):
    """The paraboloid of the broad press is near to what a ball leaves, so one contact finds it."""

    solver = ContactFit()
    force_ratio = (0.97, 1.03)
    place_error = 0.2e-3


def small_model(nodes: int = 9, quantity: BaseStress | None = None) -> ObservationModel:
    patch = square_patch(side=5)
    grid = Grid.square(patch, nodes=nodes)
    quantity = quantity or BaseStress()
    return ObservationModel.of(patch, Layer(), grid, BondedLayer(), quantity, 20.0)


def test_tikhonov_minimises_its_functional() -> None:
    model, solver = small_model(), Tikhonov(snr=7.0)
    readings = np.random.default_rng(1).normal(size=25) * 1e3
    weighted = model.matrix / model.noise_std[:, None]
    penalty = np.trace(weighted @ weighted.T) / (25 * solver.snr**2)
    stacked = np.vstack([weighted, np.sqrt(penalty) * np.eye(81)])
    expected = np.linalg.lstsq(stacked, np.r_[readings / model.noise_std, np.zeros(81)])[0]
    assert solver.prepare(model).matrix @ readings == pytest.approx(expected, rel=1e-8, abs=1e-6)


@pytest.mark.parametrize("solver", [Tikhonov(), GaussianField(), PseudoInverse()])
def test_the_unit_of_the_readings_does_not_matter(solver: Solver) -> None:
    model = small_model()
    scaled = ObservationModel(
        model.matrix * 1e-6, model.noise_std * 1e-6, model.taxels, model.grid, model.virtual_matrix
    )
    expected = solver.prepare(model).matrix
    assert solver.prepare(scaled).matrix * 1e-6 == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_gaussian_field_is_the_posterior_of_its_prior() -> None:
    model, solver = small_model(), GaussianField(snr=12.0, length_scale=3e-3)
    plane = model.grid.plane
    distance = np.sqrt(3) * np.linalg.norm(plane[:, None] - plane[None], axis=-1) / 3e-3
    correlation = (1 + distance) * np.exp(-distance)
    noise = np.diag(model.noise_std**2)
    spread = np.trace(model.matrix @ correlation @ model.matrix.T / model.noise_std**2)
    prior = correlation * solver.snr**2 * 25 / spread
    gain = prior @ model.matrix.T @ np.linalg.inv(model.matrix @ prior @ model.matrix.T + noise)
    operator = solver.prepare(model)
    assert operator.matrix == pytest.approx(gain, rel=1e-7, abs=1e-9)
    variance = np.diag(prior - gain @ model.matrix @ prior)
    assert operator.pressure_std**2 == pytest.approx(variance, rel=1e-6)


def test_gaussian_field_doubts_what_no_taxel_sees() -> None:
    model = small_model(nodes=41)
    std = GaussianField(snr=100.0).prepare(model).pressure_std.reshape(41, 41)
    assert std[20, 20] < 0.8 * std[15, 15]  # on the middle taxel; between four taxels


def test_smoothing_by_convolution_is_the_dense_product() -> None:
    model = small_model()
    plane = model.grid.plane
    distance = np.sqrt(3) * np.linalg.norm(plane[:, None] - plane[None], axis=-1) / 2e-3
    dense = model.matrix @ ((1 + distance) * np.exp(-distance))
    assert smoothed(model.grid, model.matrix, 2e-3) == pytest.approx(dense, rel=1e-9, abs=1e-12)


def test_inverse_on_the_taxels_needs_as_many_nodes() -> None:
    square = small_model(nodes=5)
    operator = Inverse(resample=False).prepare(square)
    assert operator.matrix @ square.matrix == pytest.approx(np.eye(25), abs=1e-9)
    with pytest.raises(InputError, match=r"matrix is \(25, 81\), expected as many nodes as taxels"):
        Inverse(resample=False).prepare(small_model())


def test_inverse_puts_a_force_on_covered_nodes_only() -> None:
    patch = square_patch(side=5)
    grid = Grid.window(patch, (-0.02, -0.02), (0.02, 0.02), pitch=2e-3)
    model = ObservationModel.of(
        patch, Layer(), grid, HalfSpace(), BaseStress(pad_averaged=False), 20.0
    )
    pressure = Inverse().prepare(model).matrix @ np.ones(25)
    assert not pressure[~grid.covered].any()
    assert pressure[grid.covered].any()


def test_a_matrix_that_cannot_be_inverted_is_refused() -> None:
    patch = square_patch(side=3)
    grid = Grid.square(patch, nodes=12)
    model = ObservationModel.of(patch, Layer(10e-3), grid, BondedLayer(), BaseStress(), 20.0)
    with pytest.raises(InputError, match=r"condition .* cannot tell them apart"):
        Inverse().prepare(model)


def test_snr_is_checked() -> None:
    with pytest.raises(InputError, match="snr is 0, expected a finite number above 0"):
        Tikhonov(snr=0)
