"""Every solver keeps the contract; the paper's two also agree with their definitions."""

import numpy as np
import pytest
from non_negative_reference import small_model

from skinfield.elastic import BaseStress, BondedLayer, HalfSpace, Layer, ObservationModel
from skinfield.errors import InputError
from skinfield.skin import Grid
from skinfield.solve import (
    Auto,
    ContactFit,
    GaussianField,
    Inverse,
    PseudoInverse,
    Solver,
    Tikhonov,
)
from skinfield.solve.contract import SolverContract, square_patch


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


class TestAuto(TestContactFit):
    solver = Auto()
    name = "ContactFit"


@pytest.mark.parametrize("solver", [Tikhonov(), GaussianField(), PseudoInverse()])
def test_the_unit_of_the_readings_does_not_matter(solver: Solver) -> None:
    model = small_model()
    scaled = ObservationModel(
        model.matrix * 1e-6, model.noise_std * 1e-6, model.taxels, model.grid, model.virtual_matrix
    )
    expected = solver.prepare(model).matrix
    assert solver.prepare(scaled).matrix * 1e-6 == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_inverse_on_the_taxels_needs_as_many_nodes() -> None:
    square = small_model(nodes=5)
    operator = Inverse(resample=False).prepare(square)
    assert operator.matrix @ square.matrix == pytest.approx(np.eye(25), abs=1e-9)
    with pytest.raises(InputError, match=r"matrix is \(25, 81\), expected as many nodes as taxels"):
        Inverse(resample=False).prepare(small_model(9))


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
