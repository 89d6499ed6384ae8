"""Contacts of atoms against plane geometry and against their own fields."""

import numpy as np
import pytest

from skinfield.elastic import BondedLayer, Layer
from skinfield.estimate import Contact
from skinfield.simulate.pressing.press import enclosed
from skinfield.skin import Grid, Patch
from skinfield.skin.generators import cylinder
from skinfield.solve.atoms.contacts import bodies, body_of
from skinfield.solve.atoms.render import AtomRenderer
from skinfield.solve.atoms.table import BALL, FLAT, unit_pressure

LAYER = Layer(2e-3, 210e3, 0.5)
SQUARE = Patch(np.array([(-0.02, -0.02), (0.02, -0.02), (0.02, 0.02), (-0.02, 0.02)]))
GRID = Grid.window(SQUARE, (-0.02, -0.02), (0.02, 0.02), 0.5e-3)
RENDERER = AtomRenderer(GRID, LAYER, BondedLayer())
COVARIANCE = np.diag([0.1e-3, 0.2e-3, 0.05, 0.15e-3, 0.3e-3, 0.1]) ** 2
BALLS = np.zeros(1, dtype=np.int64)

ROUND = np.array([0.31e-3, -0.17e-3, 1.5, 2.2e-3, 0.0, 0.0])
LONG = np.array([-4e-3, 3e-3, 2.0, 1.2e-3, 3e-3, 0.7])


def moved(
    atom: np.ndarray,
    x: float = 0.0,
    y: float = 0.0,
    force: float = 0.0,
    radius: float = 0.0,
    angle: float = 0.0,
) -> np.ndarray:
    return atom + np.array([x, y, force, radius, 0.0, angle])


def contact_of(atom: np.ndarray, family: int = BALL) -> Contact:
    (contact,) = RENDERER.contacts(atom[None], np.array([family]), COVARIANCE[None])
    return contact


def test_a_ball_has_its_place_force_and_circle() -> None:
    contact = contact_of(ROUND)
    assert contact.shape == "sphere"
    assert contact.position == pytest.approx([0.31e-3, -0.17e-3, 0.0])
    assert contact.force == pytest.approx([0.0, 0.0, -1.5])
    assert not contact.moment.any()
    assert contact.normal == pytest.approx([0.0, 0.0, 1.0])
    assert contact.area == pytest.approx(np.pi * 2.2e-3**2)
    assert contact.area_std == pytest.approx(np.hypot(2 * np.pi * 0.15e-3, 4 * 0.3e-3) * 2.2e-3)
    assert contact.radius == 2.2e-3
    assert contact.axes == pytest.approx([2.2e-3, 2.2e-3])
    assert contact.covariance == pytest.approx(COVARIANCE[:3, :3])
    assert contact.peak_pressure == pytest.approx(
        1.5 * unit_pressure(LAYER, BondedLayer(), BALL, 2.2e-3, np.zeros(1))[0], rel=1e-5
    )
    away = np.linalg.norm(contact.outline - contact.position, axis=1)
    assert away == pytest.approx(2.2e-3)
    assert contact.outline[0] == pytest.approx(contact.outline[-1], abs=1e-12)
    assert len(contact.outline) == 33


def test_a_flat_end_has_a_finite_peak() -> None:
    contact = contact_of(ROUND, FLAT)
    assert contact.shape == "flat"
    field = np.empty(len(GRID))
    RENDERER.pressure(ROUND[None], np.array([FLAT]), field)
    assert contact.peak_pressure == pytest.approx(field.max())
    assert contact.peak_pressure > 1.5 / contact.area


def test_a_drawn_out_atom_has_its_length_width_and_angle() -> None:
    contact = contact_of(LONG)
    assert contact.shape == "line"
    assert contact.area == pytest.approx(np.pi * 1.2e-3**2 + 4 * 1.2e-3 * 3e-3)
    assert contact.area_std == pytest.approx(
        np.hypot((2 * np.pi * 1.2e-3 + 4 * 3e-3) * 0.15e-3, 4 * 1.2e-3 * 0.3e-3)
    )
    assert contact.radius == pytest.approx(np.sqrt(contact.area / np.pi))
    assert contact.angle == pytest.approx(0.7)
    assert enclosed(contact.outline[:, :2]) == pytest.approx(contact.area, rel=0.01)
    along = (contact.outline - contact.position) @ [np.cos(0.7), np.sin(0.7), 0.0]
    across = (contact.outline - contact.position) @ [-np.sin(0.7), np.cos(0.7), 0.0]
    assert np.abs(along).max() == pytest.approx(4.2e-3, rel=0.01)
    assert np.abs(across).max() == pytest.approx(1.2e-3, rel=0.01)
    moments = [spread(LONG, angle) for angle in (0.7, 0.7 + np.pi / 2)]
    assert contact.axes == pytest.approx(moments, rel=0.01)
    back = contact_of(moved(LONG, angle=np.pi / 2))
    assert back.angle == pytest.approx(0.7 - np.pi / 2)
    assert contact_of(LONG * [1, 1, 1, 1, 0.1, 1]).shape == "sphere"  # hardly drawn out


def spread(atom: np.ndarray, angle: float) -> float:
    """Semi-axis from even points in the atom."""
    axis = np.linspace(-5e-3, 5e-3, 801)
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    way = atom[4] * np.array([np.cos(atom[5]), np.sin(atom[5])])
    share = np.clip(points @ way / (way @ way), -1.0, 1.0)
    inside = points[np.linalg.norm(points - share[:, None] * way, axis=1) <= atom[3]]
    return float(2.0 * np.std(inside @ [np.cos(angle), np.sin(angle)]))


@pytest.mark.parametrize("atom", [ROUND, LONG])
def test_the_cells_are_the_nodes_inside_the_outline(atom: np.ndarray) -> None:
    contact = contact_of(atom)
    assert len(contact.cells) * GRID.cell_area == pytest.approx(contact.area, rel=0.06)
    side = contact.outline[:-1, None, :2] - GRID.plane[None, contact.cells]
    following = contact.outline[1:, None, :2] - GRID.plane[None, contact.cells]
    turn = np.arctan2(
        side[..., 0] * following[..., 1] - side[..., 1] * following[..., 0],
        (side * following).sum(axis=-1),
    ).sum(axis=0)  # once around what it encloses, anticlockwise
    inside = turn > np.pi
    assert inside.mean() > 0.95  # the polygon cuts the corners of the round outline
    assert list(contact.cells) == sorted(set(contact.cells))


def test_an_atom_between_or_beside_the_nodes_has_the_nearest() -> None:
    small = contact_of(np.array([0.01e-3, 0.02e-3, 1.0, 0.05e-3, 0.0, 0.0]))
    assert small.cells.tolist() == [
        int(np.argmin(np.linalg.norm(GRID.plane - (0.01e-3, 0.02e-3), axis=1)))
    ]
    beside = contact_of(np.array([0.05, 0.0, 1.0, 2e-3, 0.0, 0.0]))
    assert GRID.plane[beside.cells[0], 0] == GRID.plane[:, 0].max()
    assert beside.normal_force == pytest.approx(1.0)


def test_contacts_come_by_falling_force() -> None:
    atoms = np.stack([ROUND, LONG])
    first, second = RENDERER.contacts(atoms, np.zeros(2, dtype=int), np.stack([COVARIANCE] * 2))
    assert (first.shape, second.shape) == ("line", "sphere")


def lens(radius: float, apart: float) -> float:
    half = np.arccos(apart / (2 * radius))
    return float(2 * radius**2 * half - apart / 2 * np.sqrt(4 * radius**2 - apart**2))


def test_discs_that_overlap_are_one_body() -> None:
    atoms = np.stack([ROUND, moved(ROUND, x=3e-3, force=-0.5)])
    family = np.array([BALL, FLAT])
    (both,) = RENDERER.contacts(atoms, family, np.stack([COVARIANCE] * 2))
    assert both.shape == "other"
    assert both.area == pytest.approx(2 * np.pi * 2.2e-3**2 - lens(2.2e-3, 3e-3), rel=0.01)
    assert both.normal_force == pytest.approx(2.5)
    assert both.position[0] == pytest.approx((1.5 * 0.31e-3 + 1.0 * 3.31e-3) / 2.5)
    assert both.angle == pytest.approx(0.0, abs=1e-3)
    assert both.axes[0] > 1.3 * both.axes[1]
    one, other = RENDERER.contacts(atoms, family, np.stack([COVARIANCE] * 2), groups=[[0], [1]])
    assert (one.shape, other.shape) == ("sphere", "flat")
    assert set(one.cells) | set(other.cells) == set(both.cells)


def test_a_body_has_the_covariance_of_random_atoms() -> None:
    atoms = np.stack([ROUND, moved(ROUND, x=3e-3, y=1e-3, force=-0.5, radius=-0.4e-3)])
    root = np.zeros((12, 12))
    root[range(12), range(12)] = np.tile([0.05e-3, 0.05e-3, 0.1, 0.05e-3, 0, 0], 2)
    root[8, 2] = -0.095  # one force takes what the other leaves
    (body,) = RENDERER.contacts(atoms, np.zeros(2, dtype=int), root @ root.T)
    rng = np.random.default_rng(1)
    draws = atoms + (rng.standard_normal((4000, 12)) @ root.T).reshape(-1, 2, 6)
    force = draws[:, :, 2]
    place = np.einsum("ni,nij->nj", force, draws[:, :, :2]) / force.sum(axis=1)[:, None]
    sampled = np.cov(np.column_stack([place, force.sum(axis=1)]).T)
    assert np.sqrt(np.diag(body.covariance)) == pytest.approx(np.sqrt(np.diag(sampled)), rel=0.06)
    scale = np.sqrt(np.outer(np.diag(sampled), np.diag(sampled)))
    assert body.covariance / scale == pytest.approx(sampled / scale, abs=0.06)
    areas = [body_of(draw).area for draw in draws[:300]]
    assert body.area_std == pytest.approx(np.std(areas), rel=0.25)


def ring(radius: float) -> np.ndarray:
    turn = np.arange(24) * np.pi / 12
    atoms = np.zeros((24, 6))
    atoms[:, 0], atoms[:, 1] = 5e-3 * np.cos(turn), 5e-3 * np.sin(turn)
    atoms[:, 2:4] = 0.2, radius
    return atoms


def test_a_ring_of_atoms_has_its_outer_outline_and_no_area_in_the_hole() -> None:
    atoms = ring(1.2e-3)
    assert bodies(atoms) == [list(range(24))]
    body = body_of(atoms)
    axis = np.linspace(-7e-3, 7e-3, 701)
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    near = np.min([np.linalg.norm(points - atom[:2], axis=1) for atom in atoms], axis=0)
    inside = points[near <= 1.2e-3]
    assert body.area == pytest.approx(len(inside) * (axis[1] - axis[0]) ** 2, rel=0.01)
    assert body.axes == pytest.approx(2.0 * inside.std(axis=0), rel=0.01)
    away = np.linalg.norm(body.outline, axis=1)
    assert away.min() > 5.9e-3
    assert away.max() == pytest.approx(6.2e-3, rel=1e-3)


def test_atoms_that_do_not_touch_have_an_outline_around_all() -> None:
    atoms = ring(0.6e-3)
    (contact,) = RENDERER.contacts(
        atoms, np.zeros(24, dtype=int), np.stack([COVARIANCE] * 24), groups=[list(range(24))]
    )
    assert contact.area == pytest.approx(24 * np.pi * 0.6e-3**2, rel=0.01)
    assert np.linalg.norm(contact.outline, axis=1) == pytest.approx(5.6e-3, rel=0.02)
    assert np.linalg.norm(GRID.plane[contact.cells], axis=1).min() > 4.3e-3


def test_segments_that_cross_are_one_body_and_neighbours_are_two() -> None:
    cross = np.array([[0, 0, 1, 0.2e-3, 4e-3, 0.0], [0, 0, 1, 0.2e-3, 4e-3, 1.5]])
    assert bodies(cross) == [[0, 1]]
    apart = np.array([[0, 0, 1, 1e-3, 4e-3, 0.0], [0, 2.1e-3, 1, 1e-3, 4e-3, 0.0]])
    assert bodies(apart) == [[0], [1]]
    chain = np.array([[x, 0, 1, 1e-3, 0, 0] for x in (0.0, 6e-3, 1.9e-3, 3.8e-3)])
    assert bodies(chain) == [[0, 2, 3], [1]]


def test_on_a_curved_patch_the_force_is_the_sum_over_the_skin() -> None:
    patch = cylinder(radius=25e-3, length=40e-3, arc_angle=2.0)
    grid = Grid.square(patch, nodes=40)
    renderer = AtomRenderer(grid, LAYER, BondedLayer())
    atom = np.array([8e-3, 2e-3, 1.5, 4e-3, 0.0, 0.0])
    (contact,) = renderer.contacts(atom[None], BALLS, COVARIANCE[None])
    angle = 8e-3 / 25e-3
    normal = np.array([np.sin(angle), 0.0, np.cos(angle)])
    assert contact.normal == pytest.approx(normal, abs=0.02)
    assert contact.position == pytest.approx(25e-3 * normal + [0, 2e-3, 0], abs=0.2e-3)
    field = np.empty(len(grid))
    renderer.pressure(atom[None], BALLS, field)
    forces = -field[:, None] * grid.normals * grid.cell_area
    assert contact.force == pytest.approx(forces.sum(axis=0))
    about = np.cross(grid.positions - contact.position, forces).sum(axis=0)
    assert contact.moment == pytest.approx(about, abs=1e-12)
    assert 0.98 * 1.5 < contact.normal_force < 1.5  # the ends of the load point aside
    away = np.linalg.norm(contact.outline - contact.position, axis=1)
    assert away == pytest.approx(4e-3, rel=0.02)
