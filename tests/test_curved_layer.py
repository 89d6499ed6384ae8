"""The layer on spheres and cylinders against closed forms, force balance, and the flat layer."""

import curved_closed_forms
import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import curved_series
from skinfield.elastic.curved_series import cylinder_responses, sphere_responses
from skinfield.elastic.hankel import CoveredTransfer, LayerTransfer, electrostatic, jinc

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


@pytest.mark.parametrize("radius", [2.5, 30.0])
def test_surface_yields_the_same_both_ways(radius):
    """Betti: the work of one load on what another does is that of the other on what it does."""
    n = np.array([1.0, 3.0, 20.0])
    sphere, _ = curved_series._carried(curved_series._sphere(n, 0.4), radius, 200)
    np.testing.assert_allclose(sphere[:, 0, 1], n * (n + 1) * sphere[:, 1, 0], rtol=1e-6)
    system = curved_series._cylinder(n, n / 7, 0.4)
    cylinder, _ = curved_series._carried(system, radius, 200)
    np.testing.assert_allclose(cylinder, np.swapaxes(cylinder, 1, 2), atol=1e-7)


def test_covered_bodies_are_flat_where_they_are_wide():
    radius, alpha, nu = 2000.0, np.array([0.5, 1.0, 2.0, 4.0]), 0.45
    layer, between = CoveredTransfer(nu), radius + 0.5
    expected = layer.base_normal(alpha), (1 - nu) / alpha * layer.normal(alpha)
    found = sphere_responses(between * alpha - 0.5, radius, nu, covered=True)
    np.testing.assert_allclose(found[:2], expected, rtol=2e-3)


H, PAD = 2e-3, 4e-3


def readings(patch, layer, quantity, pressure, nodes=110):
    """Readings of a pressure, a function of directions or places (K, 3) on the base."""
    grid = sf.Grid.square(patch, nodes=nodes)
    model = sf.ObservationModel.of(
        patch, layer, grid, mechanics=sf.CurvedLayer(), quantity=quantity
    )
    assert model.matrix.shape == (len(patch), nodes**2)
    return model.matrix @ pressure(grid.positions)


def quantities(layer):
    """Names of responses, quantities, and what brings the one to the other."""
    softness = 2 * (1 + layer.poisson_ratio) / layer.young_modulus
    yield "stress", sf.BaseStress(), 1.0
    yield "indentation", sf.Gap(), softness
    yield "charge", sf.Capacitance(), softness


@pytest.mark.parametrize(
    ("radius", "cap", "polar", "nu"),
    [(5e-3, 1.3, 0.3, 0.3), (10e-3, 1.0, 0.3, 0.5), (10e-3, 2.0, 1.5, 0.5), (30e-3, 0.7, 0.2, 0.4)],
)
def test_cap_reads_what_the_series_says(radius, cap, polar, nu):
    patch = sf.layouts.sphere_cap(radius=radius, cap_angle=cap, pitch=min(5e-3, radius * 0.6))
    layer = sf.Layer(thickness=H, poisson_ratio=nu)
    towards, edge = np.array([np.sin(polar), 0.0, np.cos(polar)]), 3e-3 / (radius + H)
    away = lambda at: np.arccos(np.clip(at @ towards / np.linalg.norm(at, axis=1), -1, 1))
    dome = lambda angle: np.sqrt(np.maximum(1 - (angle / edge) ** 2, 0.0))
    series = curved_series.legendre_series(radius / H, nu)
    for name, quantity, unit in quantities(layer):
        found = readings(patch, layer, quantity, lambda at: dome(away(at)))
        places = away(patch.positions), edge
        response = unit * getattr(series, name)
        true = curved_closed_forms.of_cap(response, radius, PAD / 2 / radius, *places, dome)
        assert np.linalg.norm(found - true) < 0.01 * np.linalg.norm(true)


@pytest.mark.parametrize("around", [0.25, np.pi])  # beside the middle, and on the seam
def test_sleeve_reads_what_the_series_says(around):
    radius, nu, width = 10e-3, 0.5, 1.5e-3
    patch = sf.layouts.cylinder(radius=radius, length=40e-3, arc_angle=2 * np.pi, pitch=5e-3)
    layer, outer = sf.Layer(thickness=H, poisson_ratio=nu), radius / H + 1.0

    def places(at):
        angle = np.arctan2(at[:, 0], at[:, 2]) - around
        return (angle + np.pi) % (2 * np.pi) - np.pi, at[:, 1] / H

    def bump(at):
        angle, along = places(at)
        return np.exp(-((angle * outer) ** 2 + along**2) * H**2 / (2 * width**2))

    m, k = np.arange(48.0), np.linspace(0.0, 8.0, 81)
    grid = [each.ravel() for each in np.meshgrid(m, k, indexing="ij")]
    series = cylinder_responses(*grid, radius / H, nu)
    pads = jinc(np.hypot(grid[0] * H / radius, grid[1]), PAD / 2 / H)
    for name, quantity, unit in quantities(layer):
        found = readings(patch, layer, quantity, bump)
        response = (unit * getattr(series, name) * pads).reshape(len(m), len(k))
        true = curved_closed_forms.of_bump(
            response, outer, m / outer, k, places(patch.positions), width / H
        )
        assert np.linalg.norm(found - true) < 0.02 * np.linalg.norm(true)


@pytest.mark.parametrize(
    "base", [sf.SphericalBase((0, 0, -3.0), 3.0), sf.CylindricalBase((0, 0, -3.0), (1, 2, 0), 3.0)]
)
def test_wide_base_has_the_kernels_of_the_flat_layer(base):
    patch = sf.layouts.hexagon72()
    grid = sf.Grid.square(patch, nodes=60)
    layer = sf.Layer(thickness=H, poisson_ratio=0.45)
    off_middle = np.linalg.norm(patch.plane - grid.plane.mean(axis=0), axis=1)
    away = grid.plane - patch.plane[np.argmin(off_middle)]
    load = np.exp(-np.sum(away**2, axis=1) / (2 * 3e-3**2))
    for quantity in (sf.BaseStress(), sf.Gap(), sf.Capacitance()):
        flat, curved = (
            sf.ObservationModel.of(patch, layer, grid, each, quantity).matrix @ load
            for each in (sf.BondedLayer(), sf.CurvedLayer(base=base))
        )
        assert np.abs(curved - flat).max() < 1e-3 * np.abs(flat).max()


def test_flat_patch_has_a_flat_layer():
    patch = sf.layouts.hexagon72()
    grid = sf.Grid.square(patch, nodes=8)
    flat, curved = (
        sf.ObservationModel.of(patch, sf.Layer(), grid, each, sf.Gap()).matrix
        for each in (sf.BondedLayer(), sf.CurvedLayer())
    )
    np.testing.assert_array_equal(flat, curved)


@pytest.mark.parametrize("cap", [0.9, 1.5, 1.9])  # rad; beyond a hemisphere
def test_plane_of_a_sphere_has_true_areas_and_covers_it_once(cap):
    radius = 20e-3
    patch = sf.layouts.sphere_cap(radius=radius, cap_angle=cap)
    grid = sf.CurvedLayer().outer(sf.Grid.square(patch, nodes=160), sf.Layer())
    places, outer = grid.positions, radius + sf.Layer().thickness
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), outer, rtol=1e-9)
    inside = places[:, 2] > outer * np.cos(0.8 * cap)
    area = 2 * np.pi * outer**2 * (1 - np.cos(0.8 * cap))
    assert np.count_nonzero(inside) * grid.cell_area == pytest.approx(area, rel=3e-3)


def test_whole_cylinder_is_covered_once():
    patch = sf.layouts.cylinder(radius=10e-3, length=40e-3, arc_angle=2 * np.pi)
    grid = sf.Grid.square(patch, nodes=100)
    layer = sf.Layer(thickness=H, poisson_ratio=0.3)
    model = sf.ObservationModel.of(patch, layer, grid, sf.CurvedLayer(), sf.BaseStress())
    middle = np.abs(patch.positions[:, 1]) < 6e-3
    q = 10 / 12  # of an even pressure all around, the plane strain of a tube
    even = 2 * (1 - 0.3) / (1 + (1 - 2 * 0.3) * q**2)
    np.testing.assert_allclose(model.matrix[middle].sum(axis=1), even, rtol=3e-3)
    assert model.grid.cell_area == pytest.approx(grid.cell_area * 1.2)


@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_contact_is_found_on_the_outer_surface(kind):
    radius, force, size = 20e-3, 2.0, 2.5e-3
    if kind == "sphere":
        patch = sf.layouts.sphere_cap(radius=radius, cap_angle=1.2, pitch=4e-3)
    else:
        patch = sf.layouts.cylinder(radius=radius, length=30e-3, arc_angle=1.5, pitch=4e-3)
    layer, outer, quantity = sf.Layer(thickness=H), radius + H, sf.Capacitance(order=1)
    at = patch.plane.mean(axis=0) + np.array([0.9e-3, 0.5e-3])
    near = sf.Grid.window(patch, at - 4e-3, at + 4e-3, 0.25e-3)
    truth = sf.ObservationModel.of(patch, layer, near, sf.CurvedLayer(), quantity)
    place = truth.grid.positions[np.argmin(np.linalg.norm(near.plane - at, axis=1))]
    away = np.linalg.norm(truth.grid.positions - place, axis=1)  # a chord is nearly the arc
    load = np.sqrt(np.maximum(1 - (away / size) ** 2, 0.0))
    load *= force / (load.sum() * truth.grid.cell_area)
    parts = {"mechanics": sf.CurvedLayer(), "quantity": quantity, "solver": sf.ContactFit()}
    rec = sf.Reconstructor(patch, layer, noise_std=2e-4, **parts)
    found = rec(truth.matrix @ load)
    (contact,) = found.contacts
    assert contact.normal_force == pytest.approx(force, rel=0.04)
    assert found.pressure.sum() * found.grid.cell_area == pytest.approx(force, rel=0.06)
    assert np.linalg.norm(contact.position - place) < 0.3e-3
    across = contact.position if kind == "sphere" else contact.position * [1, 0, 1]
    assert np.linalg.norm(across) == pytest.approx(outer, abs=0.05e-3)
    np.testing.assert_allclose(contact.normal, across / np.linalg.norm(across), atol=0.02)


CAP = sf.layouts.sphere_cap(radius=20e-3, cap_angle=0.8)
PANEL = sf.layouts.cylinder(radius=20e-3, length=30e-3, arc_angle=1.5)
SHIFT = np.array([0.01, -0.02, 0.03])


@pytest.mark.parametrize("normals", [True, False])
def test_base_is_recognised(normals):
    for patch in (CAP, PANEL):
        known = {"normals": patch.normals} if normals else {}
        base = sf.CurvedLayer().base_of(sf.Patch(patch.positions + SHIFT, **known), sf.Layer())
        assert base.radius == pytest.approx(20e-3, rel=1e-9 if normals else 2e-3)
        height, upright = base.upright(patch.positions + SHIFT)
        assert np.abs(height).max() < 1e-4
        assert np.abs(upright - patch.normals).max() < (1e-9 if normals else 0.02)
    assert isinstance(base, sf.CylindricalBase)
    assert abs(base.axis[1]) == pytest.approx(1.0, abs=1e-4)


ROW = PANEL.subset(np.abs(PANEL.positions[:, 1]) < 1e-6)


@pytest.mark.parametrize(
    ("patch", "words"),
    [
        (sf.Patch(CAP.positions, normals=-CAP.normals), "on its inside"),
        (sf.Patch(PANEL.positions * [1, 1, 0.3], normals=PANEL.normals), "off a sphere"),
        (sf.Patch(ROW.positions, normals=ROW.normals), "one row"),
    ],
)
def test_what_no_body_fits_is_refused(patch, words):
    with pytest.raises(sf.errors.InputError, match=words):
        sf.CurvedLayer().base_of(patch, sf.Layer())


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: sf.CurvedLayer(base="sphere"),
        lambda: sf.SphericalBase((0, 0), 1.0),
        lambda: sf.SphericalBase((0, 0, np.nan), 1.0),
        lambda: sf.SphericalBase((0, 0, 0), 0.0),
        lambda: sf.CylindricalBase((0, 0, 0), (0, 0, 0), 1.0),
    ],
)
def test_wrong_bases_are_refused(wrong):
    with pytest.raises(sf.errors.InputError, match="expected"):
        wrong()
