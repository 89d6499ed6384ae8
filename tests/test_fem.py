"""The judge is judged at small strain: patch test, closed forms, equilibrium, refinement."""

import sys

import numpy as np
import pytest
import skfem
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.special import j0, j1

from skinfield.errors import InputError
from skinfield.fem import ConeProfile, FlatProfile, SphereProfile, apply_pressure, indent
from skinfield.fem.grading import graded, towards
from skinfield.fem.linear import law_of
from skinfield.fem.section import mesh_section
from skinfield.fem.trace import Trace
from skinfield.mechanics import Layer

SOFT = Layer(2e-3, 100e3, 0.5)
BALL = SphereProfile(radius=6e-3)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
@pytest.mark.parametrize("strain", [1e-6, 0.3])
def test_a_confined_column_is_in_equilibrium_under_the_stress_of_its_law(
    nu: float, strain: float
) -> None:
    """Uniform strain is in the space of the elements: inner nodes feel nothing, to rounding."""
    radii, heights = np.array([0.0, 0.3, 0.4, 1.0]), np.array([0.0, 0.6, 1.0])
    mesh = mesh_section(radii, heights)
    whole = skfem.MeshQuad.init_tensor(radii, heights)
    r, z = skfem.Basis(whole, skfem.ElementVector(skfem.ElementQuad2())).doflocs
    law = law_of(Layer(1.0, 1.0, nu), mesh)
    upwards = np.zeros(mesh.displacements, dtype=bool)
    moved = np.concatenate([-strain * z, np.full(mesh.pressures, -strain / law.bulk_compliance)])
    pair = skfem.Basis(whole, skfem.ElementVector(skfem.ElementQuad2()))
    upwards[pair.nodal_dofs[1]] = upwards[pair.facet_dofs[1]] = True
    upwards[pair.interior_dofs[1]] = True
    moved[: mesh.displacements][~upwards] = 0.0
    forces = law.forces(moved)
    inner = (r > 0) & (r < 1) & (z > 0) & (z < 1)
    assert np.abs(forces[: mesh.displacements][inner]).max() < 1e-14
    assert np.abs(forces[mesh.displacements :]).max() < 1e-15
    mu, stretch = law.shear_modulus, 1 - strain
    stress = mu * (stretch - 1 / stretch) - strain / law.bulk_compliance
    assert forces[mesh.top_z].sum() == pytest.approx(np.pi * stress, rel=1e-9)
    if strain < 1e-3:
        modulus = (1 - nu) / ((1 + nu) * (1 - 2 * nu))
        assert stress / strain == pytest.approx(-modulus, rel=1e-5)


def exact_disc(radius: float, at: float, nu: float) -> tuple[float, float]:
    """Base stress at a radius and depth at the axis, of a disc of unit pressure; h = E = 1."""
    soft = 3 - 4 * nu

    def below(k: float) -> float:
        return float(soft * np.cosh(2 * k) + 2 * k**2 + 8 * nu**2 - 12 * nu + 5)

    def base(k: float) -> float:
        transfer = 4 * (1 - nu) * (k * np.sinh(k) + 2 * (1 - nu) * np.cosh(k)) / below(k)
        return float(transfer * radius * j1(k * radius) * j0(k * at))

    def added(k: float) -> float:
        share = (soft * np.sinh(2 * k) - 2 * k) / below(k) - 1
        return float(share * radius * j1(k * radius) / k)

    depth = radius + quad(added, 1e-9, 40, limit=400)[0]
    return quad(base, 0, 40, limit=400)[0], 2 * (1 - nu**2) * depth


@pytest.mark.parametrize("nu", [0.5, 0.49, 0.3, 0.0])
def test_a_loaded_disc_gives_the_base_stress_and_depth_of_the_layer(nu: float) -> None:
    found = apply_pressure(Layer(2e-3, 100e3, nu), np.ones_like, 1.5e-3)
    for at in (0.0, 0.5, 1.0, 2.0):
        stress, depth = exact_disc(0.75, at, nu)
        assert found.base_stress([at * 2e-3])[0] == pytest.approx(stress, abs=2e-3 * 0.68)
    assert found.depth == pytest.approx(depth * 2e-3 / 100e3, rel=3e-4)
    assert found.force == pytest.approx(np.pi * 1.5e-3**2, rel=1e-9)
    assert found.surface.integral(found.nodal_base_stress) == pytest.approx(found.force, rel=3e-4)


def test_a_point_force_gives_the_kernel_of_the_incompressible_layer() -> None:
    """Its values, times h² per N, are known to six digits; the disc here is h/40 in radius."""
    small = 0.05e-3
    load = 1.0 / (np.pi * small**2)
    found = apply_pressure(SOFT, lambda r: np.full_like(r, load), small)
    radius = np.array([0.5, 1.0, 3.0, 5.0]) * 2e-3
    kernel = [0.373972, 0.063968, 0.001962, 0.000360]
    assert found.base_stress(radius) * 4e-6 == pytest.approx(kernel, abs=3e-4)
    depth = np.array([0.106069, -0.030008, -0.003991, -0.000732])
    assert found.indentation(radius) * 200.0 == pytest.approx(depth, abs=6e-4)


@pytest.mark.parametrize(("a", "kappa"), [(0.8, 2.86024), (3.0, 18.1574)])
def test_a_sharp_punch_has_the_stiffness_of_hayes_and_others(a: float, kappa: float) -> None:
    radius = a * 2e-3
    found = indent(SOFT, FlatProfile(radius=radius), depth=1e-5)
    stiffness = found.force * 0.75 / (2 * 100e3 * radius * 1e-5)
    assert 0.0 < stiffness / kappa - 1 < 3e-3  # held displacements stiffen
    finer = indent(SOFT, FlatProfile(radius=radius), depth=1e-5, finest=0.003)
    assert finer.force < found.force
    assert found.contact_radius == pytest.approx(radius, rel=5e-3)


@pytest.mark.parametrize(
    ("a", "chi", "over_hertz"),
    [(0.5, 0.417207, 1.85712), (1.0, 0.747941, 3.3711), (2.0, 1.34893, 8.46801)],
)
def test_a_paraboloid_presses_as_the_exact_solution(
    a: float, chi: float, over_hertz: float
) -> None:
    """Contact radius a and chi = sqrt(R depth), in thicknesses, and force over that of Hertz."""
    radius = 40e-3
    depth = (chi * 2e-3) ** 2 / radius
    found = indent(SOFT, lambda r: r**2 / (2 * radius), depth=depth)
    hertz = 16 / 9 * 100e3 * np.sqrt(radius) * depth**1.5
    assert found.force == pytest.approx(over_hertz * hertz, rel=2e-4)
    assert found.contact_radius == pytest.approx(a * 2e-3, rel=7e-3)


def test_a_ball_touches_without_pull_and_without_overlap() -> None:
    found = indent(SOFT, BALL, force=1.0)
    assert found.force == pytest.approx(1.0, rel=1e-9)
    nodes = found.surface.nodes
    gap = BALL(nodes) - found.depth - found.nodal_displacement[:, 1]
    assert found.nodal_force.min() == 0.0
    assert np.abs(gap[found.contact][1:]).max() < 1e-12
    assert gap[~found.contact].min() > 0
    pressure = found.pressure(np.linspace(0, 4e-3, 400))
    assert pressure.min() > -0.01 * pressure.max()
    assert pressure[300:].max() == 0.0
    half = indent(SOFT, BALL, depth=found.depth)
    assert half.force == pytest.approx(1.0, rel=1e-6)


def test_mean_stress_below_a_wide_pad_is_the_force_over_its_area() -> None:
    found = indent(SOFT, BALL, force=1.0, finest=0.04)
    mean = found.pad_stress([0.0], 30e-3)[0]
    assert mean * np.pi * 15e-3**2 == pytest.approx(1.0, rel=6e-3)
    assert found.pad_stress([0.0, 4e-3], 1e-6) == pytest.approx(
        found.base_stress([0.0, 4e-3]), rel=1e-3
    )


def test_refinement_converges() -> None:
    coarse, middle, fine = (indent(SOFT, BALL, force=1.0, finest=f) for f in (0.08, 0.04, 0.02))
    best = indent(SOFT, BALL, force=1.0, finest=0.005)
    errors = [abs(s.depth / best.depth - 1) for s in (coarse, middle, fine)]
    assert errors[0] < 2e-3
    assert errors[2] < 2e-4


def test_a_ring_touches_between_its_edges_and_a_cone_at_its_tip() -> None:
    ring = indent(SOFT, FlatProfile(radius=4e-3, inner_radius=2.5e-3), force=1.0)
    radius = ring.surface.nodes[ring.contact]
    assert radius.min() == pytest.approx(2.5e-3, abs=1e-9)
    assert radius.max() == pytest.approx(4e-3, abs=1e-9)
    assert ring.pressure([0.0, 1e-3]).tolist() == [0.0, 0.0]
    cone = indent(SOFT, ConeProfile(slope=0.3, radius=6e-3), force=0.5)
    assert cone.pressure([0.05e-3])[0] > 2 * cone.pressure([0.5 * cone.contact_radius])[0]


def test_a_thick_layer_is_hertz() -> None:
    found = indent(Layer(100e-3, 100e3, 0.3), BALL, force=0.05, finest=0.002)
    modulus = 100e3 / (1 - 0.3**2)
    edge = (3 * 0.05 * 6e-3 / (4 * modulus)) ** (1 / 3)
    assert found.depth == pytest.approx(edge**2 / 6e-3, rel=0.03)  # a ball on 100 mm


def test_vertices_meet_every_stop_and_the_sizes_asked_for() -> None:
    line = graded([0.0, 0.5, 3.0], towards([0.5], 0.02, 0.3, 0.2))
    assert {0.0, 0.5, 3.0} <= set(line)
    steps = np.diff(line)
    assert steps.min() > 0.01
    assert steps.min() < 0.03
    assert steps.max() <= 0.2 + 1e-12


def test_a_quadratic_is_its_own_trace() -> None:
    def square(radius: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 + radius - 2 * radius**2

    trace = Trace(np.array([0.0, 0.5, 1.0, 1.25, 1.5]))
    at = np.linspace(0, 1.5, 31)
    assert trace.at(square(trace.nodes), at) == pytest.approx(square(at))
    assert trace.at(square(trace.nodes), np.array([2.0])) == pytest.approx([0.0])
    loads = trace.loads(square(trace.gauss_radii))
    assert trace.density(loads) == pytest.approx(square(trace.nodes))
    whole = np.pi * (1.5**2 + 2 / 3 * 1.5**3 - 1.5**4)
    assert trace.integral(square(trace.nodes)) == pytest.approx(whole)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "force is None and depth is None, expected exactly one"),
        ({"force": 1.0, "depth": 1e-4}, "expected exactly one"),
        ({"force": -1.0}, "force is -1.0, expected a finite number above 0"),
        ({"depth": 3e-3}, "depth is 0.003 m, expected less than the layer's 0.002 m"),
        ({"force": 50.0}, "force is 50.0 N, which sinks the body by"),
        ({"force": 1.0, "finest": 0.0}, "finest is 0.0"),
    ],
)
def test_loads_that_cannot_be_are_named(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        indent(SOFT, BALL, **arguments)


def test_bodies_that_cannot_be_are_named() -> None:
    with pytest.raises(InputError, match=r"profile gives .* expected as many heights of"):
        indent(SOFT, lambda r: r - 1e-3, force=1.0)
    with pytest.raises(InputError, match="profile is nowhere below"):
        indent(SOFT, lambda r: np.full_like(r, np.inf), force=1.0)
    with pytest.raises(InputError, match=r"edge_radius is 0\.002"):
        FlatProfile(radius=1e-3, edge_radius=2e-3)
    for make in (SphereProfile, FlatProfile):
        with pytest.raises(InputError, match="radius is 0"):
            make(radius=0.0)


def test_without_the_package_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "skfem", None)
    with pytest.raises(InputError, match=r"pip install 'skinfield\[fem\]'"):
        indent(SOFT, BALL, force=1.0)
