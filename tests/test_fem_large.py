"""Large strain: the law against its closed forms, the small-strain limit, touch, honest ends."""

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.fem import FlatProfile, SphereProfile, indent, indent_large
from skinfield.fem.law import Elasticity, jacobian
from skinfield.fem.section import mesh_section
from skinfield.fem.shape import Shape, SmoothShape
from skinfield.mechanics import Layer

SOFT = Layer(2e-3, 100e3, 0.5)
BALL, SMALL = SphereProfile(radius=6e-3), SphereProfile(radius=3e-3)
RADII = np.linspace(0.0, 8e-3, 200)


def relative(found: np.ndarray, judge: np.ndarray) -> float:
    weight = np.sqrt(RADII)
    return float(np.linalg.norm(weight * (found - judge)) / np.linalg.norm(weight * judge))


def test_derivatives_of_the_volume_are_those_of_differences() -> None:
    f = np.array([1.1, 0.2, -0.1, 0.8, 1.3])
    j, first, second = jacobian(f)
    assert j == pytest.approx((1.1 * 0.8 + 0.2 * 0.1) * 1.3)
    for entry in range(5):
        step = 1e-6 * np.eye(5)[entry]
        up, down = jacobian(f + step), jacobian(f - step)
        assert (up[0] - down[0]) / 2e-6 == pytest.approx(first[entry], abs=1e-9)
        assert (up[1] - down[1]) / 2e-6 == pytest.approx(second[entry], abs=1e-9)


def test_the_stiffness_is_the_derivative_of_the_forces() -> None:
    mesh = mesh_section(np.array([0.0, 0.7, 1.5]), np.array([0.0, 0.5, 1.0]))
    law = Elasticity(mesh, 1 / 3, 0.2)
    draw = np.random.default_rng(0)
    state = 0.05 * draw.standard_normal(mesh.unknowns)
    assert law.valid(state)
    stiffness = law.stiffness(state)
    assert abs(stiffness - stiffness.T).max() < 1e-12
    for _ in range(3):
        way = draw.standard_normal(mesh.unknowns)
        slope = (law.forces(state + 1e-6 * way) - law.forces(state - 1e-6 * way)) / 2e-6
        assert stiffness @ way == pytest.approx(slope, rel=1e-7, abs=1e-6)


def test_a_light_press_is_that_of_hookes_law() -> None:
    large = indent_large(SOFT, BALL, depth=0.01e-3, steps=2, finest=0.04).last
    small = indent(SOFT, BALL, depth=0.01e-3)
    assert large.force == pytest.approx(small.force, rel=0.01)
    assert relative(large.base_stress(RADII), small.base_stress(RADII)) < 0.01


@pytest.mark.parametrize(
    ("force", "base", "surface"), [(0.2, 0.008, 0.009), (1.0, 0.010, 0.019), (3.0, 0.045, 0.027)]
)
def test_hookes_law_is_off_as_another_large_strain_solution_says(
    force: float, base: float, surface: float
) -> None:
    """Relative L2: the other one gave 0.4, 0.8, 4.3 % at the base, 0.9, 1.9, 2.6 % on top."""
    path = indent_large(SOFT, BALL, force=force, steps=4, finest=0.08)
    small = indent(SOFT, BALL, force=force)
    assert path.complete
    assert path.last.force == pytest.approx(force, rel=1e-9)
    off = relative(small.base_stress(RADII), path.last.base_stress(RADII))
    assert off == pytest.approx(base, rel=0.3)
    moved = relative(small.indentation(RADII), path.last.indentation(RADII))
    assert moved == pytest.approx(surface, rel=0.3)


def test_a_deep_press_is_in_equilibrium_keeps_its_volume_and_follows_the_ball() -> None:
    path = indent_large(SOFT, SMALL, depth=1.3e-3, steps=8, finest=0.08)
    found = path.last
    assert path.complete
    assert found.depth == pytest.approx(1.3e-3)
    assert found.surface.integral(found.nodal_base_stress) == pytest.approx(found.force, rel=1e-3)
    dip = found.indentation(found.deformed.nodes)
    ups = found.deformed.integral(np.maximum(dip, 0.0))
    assert abs(found.deformed.integral(dip)) < 2e-3 * ups  # what goes down comes up
    nodes = found.deformed.nodes
    gap = SMALL(nodes) - found.depth - found.nodal_displacement[:, 1]
    assert np.abs(gap[found.contact]).max() < 1e-9 * 2e-3 * 10
    assert gap[~found.contact].min() > -1e-9
    assert found.nodal_force[1:].min() >= 0.0
    inside = np.linspace(0.0, 0.9 * found.contact_radius, 50)
    assert found.pressure(inside).min() > 0.0


def test_a_given_force_and_its_depth_are_the_same_press() -> None:
    deep = indent_large(SOFT, SMALL, depth=0.6e-3, steps=4, finest=0.15).last
    strong = indent_large(SOFT, SMALL, force=deep.force, steps=3, finest=0.15).last
    assert strong.depth == pytest.approx(deep.depth, rel=1e-3)
    assert strong.base_stress(RADII) == pytest.approx(deep.base_stress(RADII), abs=500.0)


def test_a_rounded_flat_end_wells_up_against_its_leaning_side() -> None:
    body = FlatProfile(radius=1.5e-3, edge_radius=0.3e-3, flank=4.0)
    path = indent_large(SOFT, body, depth=0.5e-3, steps=6, finest=0.1)
    assert path.complete
    assert path.last.contact_radius > 1.45e-3
    assert path.last.force > indent(SOFT, body, depth=0.45e-3).force


def test_a_path_that_ends_early_says_why_and_keeps_what_it_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sharp = FlatProfile(radius=1.5e-3, edge_radius=0.1e-3)
    path = indent_large(SOFT, sharp, depth=0.6e-3, steps=3, finest=0.1)
    assert not path.complete
    assert path.stopped == "the surface slid over the body's edge"
    assert 0.0 < path.last.depth < 0.6e-3
    monkeypatch.setattr("skinfield.fem.large_strain.SHORTEST", 1.0)
    with pytest.raises(InputError, match="not even the first of 1 steps converged"):
        indent_large(SOFT, sharp, depth=1.2e-3, steps=1, finest=0.2)


def test_a_smooth_shape_goes_on_from_the_edge_of_the_body() -> None:
    ring = FlatProfile(radius=4e-3, inner_radius=2e-3)
    smooth = SmoothShape.of(Shape(ring, 2e-3))
    radius = np.array([0.5, 1.5, 2.5])
    assert smooth.held(radius).tolist() == [False, True, False]
    assert smooth.heights(radius) == pytest.approx([3.0, 0.0, 3.0], abs=0.02)
    height, slope, curvature = SmoothShape.of(Shape(BALL, 2e-3)).derivatives(np.array([1.0]))
    assert height == pytest.approx([3 - np.sqrt(8)])
    assert slope == pytest.approx([1 / np.sqrt(8)], rel=1e-6)
    assert curvature == pytest.approx([9 / 8**1.5], rel=1e-4)
