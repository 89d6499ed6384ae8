"""The half-space: point forces obey mechanics, cells and pads are what they say."""

import numpy as np
import pytest
from closed_forms import point_displacement
from layer_reference import mean_inverse_distance
from scipy.special import j0, j1

from skinfield.elastic import HalfSpace, Layer
from skinfield.elastic.half_space import (
    coincident_displacement,
    displacement_kernel,
    surface_displacement,
    traction_kernel,
    virtual_depth,
)
from skinfield.errors import InputError

ratios = pytest.mark.parametrize("nu", [0.0, 0.3, 0.49, 0.5])
OFFSETS = np.array([[0, 0], [0.5, 0.2], [2, 0], [1.9, 1], [6, 2], [-20, 9]]) * 1e-3


def over_plane(function):
    """Integral over the plane of function(x, y) with units of length near 1."""
    node, weight = np.polynomial.legendre.leggauss(400)
    radius, angle = np.tan((node + 1) * np.pi / 4), np.arange(16) * np.pi / 8
    weight = weight * np.pi / 4 * (1 + radius**2) * radius * np.pi / 8
    x, y = np.outer(radius, np.cos(angle)), np.outer(radius, np.sin(angle))
    return np.einsum("...ra,r->...", function(x, y), weight)


def test_base_traction_balances_force_and_moment() -> None:
    depth = 0.7
    total = over_plane(lambda x, y: traction_kernel(x, y, depth))
    np.testing.assert_allclose(total, np.eye(3), atol=1e-12)
    arms = lambda x, y: np.stack([x, y])[:, None] * traction_kernel(x, y, depth)[2]
    # a tangential force at the height `depth` above the plane turns it by force times height
    np.testing.assert_allclose(over_plane(arms)[:, :2], -depth * np.eye(2), atol=1e-12)


@ratios
def test_traction_is_hookes_law_of_the_displacement(nu: float) -> None:
    nu = min(nu, 0.499)  # Lamé's first constant is infinite at 0.5
    x, y, z, step, modulus = 0.4, -0.7, -1.1, 1e-4, 2.0
    at = lambda x, y, z: displacement_kernel(np.array(x), np.array(y), -z, modulus, nu)
    gradient = np.empty((3, 3, 3))  # [derivative, component, force]
    for axis, e in enumerate(np.eye(3) * step):
        ahead, behind = (at(*(np.array([x, y, z]) + s * e)) for s in (1, -1))
        gradient[axis] = (ahead - behind) / (2 * step)
    shear = modulus / (2 * (1 + nu))
    stress = shear * (gradient[2] + gradient[:, 2])
    stress[2] += 2 * shear * nu / (1 - 2 * nu) * np.einsum("iij->j", gradient)
    want = traction_kernel(np.array(x), np.array(y), -z)
    np.testing.assert_allclose(stress, want, atol=1e-6 if nu < 0.49 else 1e-5)


def slab_work(nu: float, component: int, low: float, high: float) -> float:
    """Twice the energy between two depths per force², as work on their planes: (21), (23)."""

    def work(depth: float) -> float:
        def density(x, y):
            t = traction_kernel(x, y, depth)[:, component]
            u = displacement_kernel(x, y, depth, 1.0, nu)[:, component]
            return np.sum(t * u, axis=0)

        return over_plane(density)

    return work(low) - work(high)


@ratios
@pytest.mark.parametrize("component", [0, 2])
def test_coincident_displacement_is_the_energy_of_the_slab(nu: float, component: int) -> None:
    layer, area = Layer(0.8, 1.0, nu), 1.3
    own = coincident_displacement(layer, area)[component, component]
    depth = virtual_depth(area)
    assert own == pytest.approx(slab_work(nu, component, depth, depth + 0.8), rel=1e-10)


@ratios
def test_uniform_cells_are_made_of_smaller_ones(nu: float) -> None:
    model, layer, cell = HalfSpace(point_forces=False), Layer(2e-3, 150e3, nu), 1.6e-3
    shifts = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]) * cell / 4
    for response in (
        lambda offset, side: model.base_stress(layer, offset, side),
        lambda offset, side: model.base_stress(layer, offset, side, 4e-3),
        lambda offset, side: model.base_traction(layer, offset, side, 1e-3),
        lambda offset, side: model.surface_displacement(layer, offset, side),
        lambda offset, side: model.indentation(layer, offset, side),
        lambda offset, side: model.indentation(layer, offset, side, 3e-3),
        lambda offset, side: model.indentation(layer, offset, side, 3e-3, True),
    ):
        whole = response(OFFSETS, cell)
        parts = sum(response(OFFSETS + shift, cell / 2) for shift in shifts)
        np.testing.assert_allclose(parts, whole, rtol=0, atol=1e-10 * np.abs(whole).max())


@ratios
def test_cells_far_away_are_point_forces(nu: float) -> None:
    offset, layer = np.array([[40e-3, 25e-3]]), Layer(2e-3, 150e3, nu)
    point, square = HalfSpace(), HalfSpace(point_forces=False)
    for name, args in {
        "base_stress": (4e-3,),
        "base_traction": (1e-3,),
        "surface_displacement": (),
        "indentation": (4e-3,),
    }.items():
        got, want = (getattr(m, name)(layer, offset, 0.5e-3, *args) for m in (square, point))
        np.testing.assert_allclose(got, want, rtol=1e-3, atol=1e-3 * np.abs(want).max())


@ratios
@pytest.mark.parametrize("point_forces", [True, False])
def test_methods_agree_where_they_overlap(nu: float, point_forces: bool) -> None:
    model, layer = HalfSpace(point_forces), Layer(2e-3, 150e3, nu)
    zz = model.surface_displacement(layer, OFFSETS, 1e-3)[:, 2, 2]
    got = model.indentation(layer, OFFSETS, 1e-3)
    np.testing.assert_allclose(got, zz, rtol=0, atol=1e-14 * zz.max())
    for pad in (0.0, 4e-3):
        stress = model.base_stress(layer, OFFSETS, 1e-3, pad)
        traction = model.base_traction(layer, OFFSETS, 1e-3, pad)[:, 2, 2]
        np.testing.assert_allclose(traction, stress, rtol=0, atol=1e-12 * stress.max())
    assert model.reach(layer) == np.inf


@ratios
def test_electrostatic_pads_are_the_hankel_integral(nu: float) -> None:
    node, weight = np.polynomial.legendre.leggauss(40)
    a = (np.arange(60)[:, None] + (node + 1) / 2).ravel()
    weight = np.tile(weight / 2, 60)
    gap = (1 - (1 + a / (2 - 2 * nu)) * np.exp(-a)) * a / np.sinh(a) * 2 * j1(a) / a
    offset = np.array([[0.0, 0], [1, 0], [3, 4], [20, 0], [60, 0], [75, 0], [90, 10]]) * 1e-3
    rho = np.hypot(*offset.T) / 2e-3
    want = (1 - nu**2) / (np.pi * 150e3 * 2e-3) * 1e-6 * (j0(np.outer(rho, a)) @ (weight * gap))
    got = HalfSpace().indentation(Layer(2e-3, 150e3, nu), offset, 1e-3, 4e-3, electrostatic=True)
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-9 * want[0])


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.95, 0.5), (1.25, 0.0)])
def test_indentation_over_a_pad_is_that_of_the_surface_less_that_of_the_base(place) -> None:
    layer, cell, radius = Layer(2e-3, 150e3, 0.5), 1e-3, 2e-3
    model = HalfSpace(point_forces=False)
    above = 0.75 / (np.pi * 150e3) * mean_inverse_distance(np.array(place), 0.5, 1.0) * 2e-3
    node, weight = np.polynomial.legendre.leggauss(16)
    r, angle = radius * np.sqrt((node + 1) / 2), np.arange(32) * np.pi / 16
    disc = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))], axis=-1)
    x, y = np.meshgrid(node * cell / 2, node * cell / 2)
    area = np.outer(weight, weight).ravel() * cell**2 / 4
    below = 0.0
    for ring, share in zip(disc, weight / 2 / 32, strict=True):
        for point in ring + np.array(place) * 2e-3:
            source = point - np.column_stack([x.ravel(), y.ravel()])
            below += share * area @ point_displacement(source, 2e-3, 150e3, 0.5)[:, 2, 2]
    got = model.indentation(layer, np.array([place]) * 2e-3, cell, 2 * radius)[0]
    assert got == pytest.approx(above - below, rel=1e-10)


def test_capped_rows_give_way_to_the_coincident_ones() -> None:
    layer, cell = Layer(2e-3, 210e3, 0.5), 1e-3
    offset = np.array([[0.0, 0.0], [0.1e-3, 0.0], [5e-3, 0.0]])
    free, capped = (HalfSpace(capped=c).surface_displacement(layer, offset, cell) for c in (0, 1))
    own = coincident_displacement(layer, cell**2) * cell**2
    np.testing.assert_allclose(capped[[0, 1]], [own, own], rtol=1e-14)
    np.testing.assert_array_equal(free[[0, 2]], capped[[0, 2]])
    assert free[1, 2, 2] > 3 * own[2, 2]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: surface_displacement(np.zeros((2, 2)), Layer()), "use coincident_displacement"),
        (lambda: virtual_depth(-1.0), r"cell_area is -1\.0"),
        (lambda: HalfSpace().base_stress(Layer(), np.zeros((1, 3)), 1e-3), r"shape \(1, 3\)"),
        (lambda: HalfSpace().indentation(Layer(), np.zeros((1, 2)), 0.0), r"cell is 0\.0"),
        (lambda: HalfSpace().indentation(Layer(), np.zeros((1, 2)), 1.0, -1.0), "pad_diameter"),
    ],
)
def test_bad_input_is_named(call, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()


def test_the_lift_of_a_pad_is_its_mean_over_the_pad() -> None:
    """By the rule of degree 5, a pad's width away from the cell."""
    model, layer, place, pad = HalfSpace(), Layer(), np.array([[7e-3, 2e-3]]), 2e-3
    node, weight = np.polynomial.legendre.leggauss(12)
    r, angle = pad / 2 * np.sqrt((node + 1) / 2), np.arange(24) * np.pi / 12
    disc = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))], axis=-1)
    points = model.surface_displacement(layer, (place + disc.reshape(-1, 2)), 0.5e-3)
    mean = weight / 2 @ points[:, 2, :2].reshape(12, 24, 2).mean(axis=1)
    np.testing.assert_allclose(model.lift(layer, place, 0.5e-3, pad)[0], mean, rtol=1e-4)
