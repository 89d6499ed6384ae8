"""The layer on spheres and cylinders against closed forms, force balance, and the flat layer."""

import curved_closed_forms
import numpy as np
import pytest

from skinfield.elastic.curved_series import cylinder_responses, sphere_responses
from skinfield.elastic.hankel import LayerTransfer, electrostatic

RADII = [2.5, 5.0, 15.0, 30.0]
POISSON = [0.3, 0.45, 0.5]


@pytest.mark.parametrize("nu", POISSON)
@pytest.mark.parametrize("radius", RADII)
def test_sphere_harmonics_are_those_of_closed_forms(radius, nu):
    orders = np.unique(np.round(np.array([0.3, 0.6, 1.0, 3.0, 8.0, 20.0]) * radius))
    true = np.array([curved_closed_forms.sphere(n, radius, nu) for n in orders]).T
    found = sphere_responses(orders, radius, nu)
    np.testing.assert_allclose(found.stress, true[0], atol=1e-5)
    np.testing.assert_allclose(found.indentation, true[1], rtol=1e-5)


@pytest.mark.parametrize("nu", POISSON)
@pytest.mark.parametrize("radius", RADII)
def test_cylinder_harmonics_are_those_of_closed_forms(radius, nu):
    m, k = (each.ravel() for each in np.meshgrid([1, 2, 5, 9], [0.3, 1.0, 3.0]))
    true = np.array(
        [curved_closed_forms.cylinder(*mk, radius, nu) for mk in zip(m, k, strict=True)]
    ).T
    found = cylinder_responses(m, k, radius, nu)
    np.testing.assert_allclose(found.stress, true[0], atol=1e-5)
    np.testing.assert_allclose(found.indentation, true[1], rtol=2e-5)


@pytest.mark.parametrize("nu", POISSON)
@pytest.mark.parametrize("radius", RADII)
def test_base_carries_less_than_the_whole_force(radius, nu):
    q = radius / (radius + 1)
    sphere = q**2 * sphere_responses([0.0], radius, nu).stress[0]
    cylinder = q * cylinder_responses([0.0], [0.0], radius, nu).stress[0]
    expected = 3 * (1 - nu) * q**2 / (1 + nu + 2 * (1 - 2 * nu) * q**3)
    assert sphere == pytest.approx(expected, rel=1e-7)
    expected = 2 * (1 - nu) * q / (1 + (1 - 2 * nu) * q**2)
    assert cylinder == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("nu", POISSON)
def test_wide_bodies_are_flat(nu):
    radius, alpha = 2000.0, np.array([0.5, 1.0, 2.0, 4.0])
    layer, between = LayerTransfer(nu), radius + 0.5
    inwards = (1 - nu) / alpha * layer.normal(alpha)
    expected = layer.base_normal(alpha), inwards, inwards * electrostatic(alpha)
    halves = between * alpha / np.sqrt(2.0)
    for found in (
        sphere_responses(between * alpha - 0.5, radius, nu),
        cylinder_responses(halves, halves / between, radius, nu),
    ):
        for mine, flat in zip(found, expected, strict=True):
            np.testing.assert_allclose(mine, flat, rtol=1.5e-3)
