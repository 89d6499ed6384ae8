"""Bricks against the axisymmetric elements, the lattice, symmetry and equilibrium."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.fem import SphereProfile, indent, press_3d
from skinfield.fem.box import Box, along_axes
from skinfield.fem.held_box import HeldBox, Load
from skinfield.fem.lines import Line
from skinfield.simulate import Cylinder, Sphere, press

SOFT = sf.Layer(2e-3, 100e3, 0.5)
AXIS = np.linspace(-7e-3, 7e-3, 29)
POINTS = np.stack(np.meshgrid(AXIS, AXIS), -1).reshape(-1, 2)
PAIR = [
    Sphere(radius=6e-3, force=0.8, position=(-3e-3, 0.0)),
    Sphere(radius=6e-3, force=0.5, position=(3e-3, 0.0)),
]


def relative(found: np.ndarray, judge: np.ndarray) -> float:
    return float(np.linalg.norm(found - judge) / np.linalg.norm(judge))


def small_box(compliance: float = 0.3) -> Box:
    x, y, z = np.array([-1.0, 0, 0.7, 1.5]), np.array([0.0, 0.4, 1.0]), np.array([0.0, 0.5, 1.0])
    return Box((Line.along(x), Line.along(y), Line.along(z)), False, 0.4, compliance)


def test_uniform_strain_is_in_equilibrium_inside_a_box() -> None:
    """Patch test: a field linear in the place gives its stress, and no force on inner nodes."""
    box = small_box()
    place = np.stack(np.meshgrid(*(line.nodes for line in box.lines), indexing="ij"))
    strain = np.array([[0.1, 0.02, -0.03], [0.02, -0.05, 0.04], [-0.03, 0.04, 0.07]])
    u = np.einsum("ij,jxyz->ixyz", strain, place)
    volume = np.trace(strain)
    p = np.full(box.pressure_shape, volume / box.bulk_compliance)
    forces, change = box.forces(u, p)
    assert np.abs(forces[:, 1:-1, 1:-1, 1:-1]).max() < 1e-13
    assert np.abs(change).max() < 1e-14
    stress = 2 * 0.4 * strain[2] + np.array([0, 0, volume / 0.3])
    assert forces[2, ..., -1].sum() == pytest.approx(stress[2] * 2.5 * 1.0, rel=1e-9)


def test_scalar_operators_are_inverted_exactly() -> None:
    box = small_box()
    draw = np.random.default_rng(1)
    for component in range(3):
        free = box.free(component)
        forces = np.zeros(box.shape)
        forces[free] = draw.standard_normal(forces[free].shape)
        moved = box.yielding(component, forces)
        u = np.zeros((3, *box.shape))
        u[component] = moved
        back = box.forces(u, np.zeros(box.pressure_shape))[0][component]
        assert back[free] == pytest.approx(forces[free], abs=1e-10)
    i, j = np.array([1, 2, 3]), np.array([1, 3, 2])
    load = np.zeros(box.shape)
    load[2, 3, -1] = 1.0
    expected = box.yielding(2, load)[i, j, -1]
    assert box.surface_yielding(i, j)[:, 1] == pytest.approx(expected)
    eye = [np.eye(n) for n in box.shape]
    assert along_axes(eye, load) == pytest.approx(load)


def test_the_held_system_is_symmetric_and_its_preconditioner_too() -> None:
    box = small_box(0.0)
    nodes = np.array([[2, 3, 3], [2, 2, 3]])
    held = HeldBox(
        box, nodes, np.array([0, 1, 1]), np.zeros(3), [Load(1.0, None), Load(2.0, None)],
        box.surface_yielding(*nodes),
    )  # fmt: skip
    draw = np.random.default_rng(2)
    one, two = (held._gather(*_fields(box, draw)) for _ in range(2))
    for operator in (held._apply, held._precondition):
        assert one @ operator(two) == pytest.approx(two @ operator(one), rel=1e-9)
    assert one @ held._precondition(one) > 0


def _fields(box: Box, draw: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    return draw.standard_normal((3, *box.shape)), draw.standard_normal(box.pressure_shape)


@pytest.mark.parametrize("nu", [0.5, 0.3])
def test_one_ball_is_that_of_the_axisymmetric_elements(nu: float) -> None:
    layer = sf.Layer(2e-3, 100e3, nu)
    found = press_3d(layer, [Sphere(radius=6e-3, force=1.0)], cell=0.2, mirror=True)
    judge = indent(layer, SphereProfile(radius=6e-3), force=1.0)
    assert found.depths == pytest.approx([judge.depth], rel=1.5e-3)
    assert found.forces == pytest.approx([1.0], rel=1e-6)
    distance = np.linalg.norm(POINTS, axis=1)
    assert relative(found.base_stress(POINTS), judge.base_stress(distance)) < 8e-3
    assert relative(found.indentation(POINTS), judge.indentation(distance)) < 8e-3
    assert found.pressure([[0.0, 0.0]]) == pytest.approx(judge.pressure([1e-4]), rel=0.02)


def test_two_balls_that_feel_each_other_are_those_of_the_lattice() -> None:
    found = press_3d(SOFT, PAIR, cell=0.2, mirror=True)
    cells = press(SOFT, PAIR, extent=16e-3, cell=0.32e-3)
    assert found.forces == pytest.approx([0.8, 0.5], rel=1e-6)
    assert found.depths == pytest.approx(cells.approach, rel=2e-3)
    assert relative(cells.base_stress(POINTS, 0.0), found.base_stress(POINTS)) < 0.01
    surface = found.indentation(cells.grid.plane)
    assert relative(-cells.displacement[:, 2], surface) < 0.016
    alone = indent(SOFT, SphereProfile(radius=6e-3), force=0.8)
    assert abs(alone.depth / found.depths[0] - 1) > 5e-3  # the other one matters


def test_a_mirror_changes_nothing_but_the_work() -> None:
    ball = [Sphere(radius=6e-3, depth=0.4e-3)]
    half = press_3d(SOFT, ball, cell=0.5, mirror=True)
    whole = press_3d(SOFT, ball, cell=0.5)
    assert half.forces == pytest.approx(whole.forces, rel=0.01)
    assert half.depths == pytest.approx([0.4e-3])
    points = np.array([[1e-3, 1e-3], [1e-3, -1e-3]])
    moved = half.displacement(points)
    assert moved[0] == pytest.approx(moved[1] * [1, -1, 1], abs=1e-15)
    assert half.base_stress(points) == pytest.approx(whole.base_stress(points), rel=0.02)


def test_presses_that_cannot_be_are_named() -> None:
    aside = Sphere(radius=6e-3, force=1.0, position=(0.0, 1e-3))
    with pytest.raises(InputError, match="mirror is True, but the bodies are not symmetric"):
        press_3d(SOFT, [aside], cell=0.4, mirror=True)
    with pytest.raises(InputError, match="bodies is empty"):
        press_3d(SOFT, [])
    with pytest.raises(InputError, match=r"bodies\[0\] sinks by .* of the layer's thickness"):
        press_3d(SOFT, [Sphere(radius=6e-3, force=40.0)], cell=0.4, mirror=True)
    with pytest.raises(InputError, match="cell is 5"):
        press_3d(SOFT, [Cylinder(radius=3e-3, force=1.0)], cell=5)
