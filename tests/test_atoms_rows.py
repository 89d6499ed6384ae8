"""Contacts of atoms against geometry, sums over cells and random atoms."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from skinfield.compiled import njit
from skinfield.elastic import BondedLayer, Layer
from skinfield.estimate import Contact
from skinfield.estimate.live_contacts import CONTACT
from skinfield.estimate.row_contacts import contacts_of_rows
from skinfield.skin import Grid, Patch
from skinfield.skin.generators import cylinder
from skinfield.solve.atoms.render import AtomRenderer
from skinfield.solve.atoms.rows_kernel import Drawing, join, write_bodies
from skinfield.solve.atoms.table import BALL, FLAT, unit_pressure

LAYER, BONDED = Layer(2e-3, 210e3, 0.5), BondedLayer()
SQUARE = Patch(np.array([(-0.02, -0.02), (0.02, -0.02), (0.02, 0.02), (-0.02, 0.02)]))
GRID = Grid.window(SQUARE, (-0.02, -0.02), (0.02, 0.02), 0.5e-3)
STD = np.array([0.1e-3, 0.2e-3, 0.05, 0.15e-3, 0.3e-3, 0.1])
ROUND = np.array([0.31e-3, -0.17e-3, 1.5, 2.2e-3, 0.0, 0.0])
NEXT = np.array([3.31e-3, 0.83e-3, 1.0, 2.2e-3, 0.0, 0.0])
LONG = np.array([-4e-3, 3e-3, 2.0, 1.2e-3, 3e-3, 0.7])


@njit
def write(grid: Any, drawing: Drawing, count: int, pressure: Any, rows: Any) -> int:
    for n in range(count):
        join(drawing, n)
    return write_bodies(grid, drawing, count, pressure, rows)


def rows_of(
    atoms: np.ndarray, family: Any = BALL, covariance: Any = None, grid: Grid = GRID
) -> tuple[np.ndarray, np.ndarray]:
    """Rows (N,) and the pressure."""
    drawing, count = Drawing.of(len(atoms)), len(atoms)
    drawing.atoms[:count, :6], drawing.family[:count] = atoms, family
    drawing.covariance[:count, :6, :6] = np.diag(STD**2) if covariance is None else covariance
    rows, pressure = np.zeros(count, CONTACT), np.zeros(len(grid))
    known = AtomRenderer(grid, LAYER, BONDED).rows.value
    return rows[: write(known, drawing, count, pressure, rows)], pressure


def contact_of(atoms: np.ndarray, family: Any = BALL, grid: Grid = GRID, **how: Any) -> Contact:
    rows, pressure = rows_of(np.atleast_2d(atoms), family, grid=grid, **how)
    (contact,) = contacts_of_rows(rows, grid, pressure)
    return contact


def test_a_ball_has_its_place_force_and_circle() -> None:
    contact = contact_of(ROUND)
    assert (contact.shape, contact.radius, contact.track_id) == ("sphere", 2.2e-3, None)
    assert_allclose(contact.position, [0.31e-3, -0.17e-3, 0.0], atol=1e-15)
    assert_allclose(contact.force, [0.0, 0.0, -1.5])
    assert_allclose(contact.normal, [0.0, 0.0, 1.0])
    assert contact.area == pytest.approx(np.pi * 2.2e-3**2)
    assert contact.area_std == pytest.approx(np.hypot(2 * np.pi * 0.15e-3, 4 * 0.3e-3) * 2.2e-3)
    assert_allclose(contact.axes, 2.2e-3)
    assert_allclose(contact.covariance, np.diag(STD[:3] ** 2))
    peak = 1.5 * unit_pressure(LAYER, BONDED, BALL, 2.2e-3, np.zeros(1))[0]
    assert contact.peak_pressure == pytest.approx(peak, rel=1e-5)
    assert_allclose(np.linalg.norm(contact.outline - contact.position, axis=1), 2.2e-3)
    assert contact_of(LONG * [1, 1, 1, 1, 0.1, 1]).shape == "sphere"  # hardly drawn out


def test_a_flat_end_has_a_finite_peak() -> None:
    contact = contact_of(ROUND, FLAT)
    assert contact.shape == "flat"
    assert contact.peak_pressure == pytest.approx(rows_of(ROUND[None], FLAT)[1].max())
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
    along = (contact.outline - contact.position) @ [np.cos(0.7), np.sin(0.7), 0.0]
    across = (contact.outline - contact.position) @ [-np.sin(0.7), np.cos(0.7), 0.0]
    assert_allclose([np.ptp(along), np.ptp(across)], [8.4e-3, 2.4e-3], rtol=1e-6)
    back = contact_of(LONG + np.array([0, 0, 0, 0, 0, np.pi / 2]))
    assert back.angle == pytest.approx(0.7 - np.pi / 2)


@pytest.mark.parametrize("family", [BALL, FLAT])
@pytest.mark.parametrize("atoms", [[ROUND], [LONG], [ROUND, NEXT]])
def test_moments_are_those_of_the_pressure(atoms: list[np.ndarray], family: int) -> None:
    rows, pressure = rows_of(np.stack(atoms), family)
    share, (row,) = pressure / pressure.sum(), rows
    spread = (share[:, None] * (GRID.plane - [row["x"], row["y"]])).T @ GRID.plane
    spread -= np.eye(2) * GRID.pitch**2 / 12  # of cells
    xx, yy, xy = row["moments"]
    assert_allclose([[xx, xy], [xy, yy]], spread, rtol=0.02, atol=0.02 * spread.max())


@pytest.mark.parametrize("atom", [ROUND, LONG])
def test_the_cells_are_those_that_carry_the_force(atom: np.ndarray) -> None:
    contact, (_, pressure) = contact_of(atom), rows_of(atom[None])
    assert pressure[contact.cells].sum() * GRID.cell_area == pytest.approx(atom[2])
    assert list(contact.cells) == np.flatnonzero(pressure).tolist()


def test_atoms_beside_the_grid_have_none() -> None:
    beside = contact_of(np.array([0.05, 0.0, 1.0, 2e-3, 0.0, 0.0]))
    assert len(beside.cells) == 0
    assert beside.normal_force == pytest.approx(1.0)


def lens(radius: float, apart: float) -> float:
    half = apart / 2
    return float(2 * (radius**2 * np.arccos(half / radius) - half * np.sqrt(radius**2 - half**2)))


def test_atoms_that_overlap_are_one_body() -> None:
    atoms = np.stack([ROUND, ROUND + np.array([3e-3, 0, -0.5, 0, 0, 0])])
    both = contact_of(atoms, [BALL, FLAT])
    assert both.shape == "other"
    assert both.area == pytest.approx(2 * np.pi * 2.2e-3**2 - lens(2.2e-3, 3e-3), rel=0.02)
    assert both.normal_force == pytest.approx(2.5)
    assert both.position[0] == pytest.approx((1.5 * 0.31e-3 + 1.0 * 3.31e-3) / 2.5)
    assert both.angle == pytest.approx(0.0, abs=1e-3)
    assert both.axes[0] > 1.3 * both.axes[1]
    atoms[1, 0] += 2e-3
    rows, _ = rows_of(atoms, [BALL, FLAT])
    assert rows["shape"].tolist() == [1, 2]
    assert_allclose(rows["normal_force"], [1.5, 1.0])


def test_a_body_has_the_covariance_of_random_atoms() -> None:
    atoms = np.stack([ROUND, ROUND + np.array([3e-3, 1e-3, -0.5, -0.4e-3, 0, 0])])
    root = np.diag([0.05e-3, 0.05e-3, 0.1, 0.05e-3, 0, 0])
    root[2, 0], root[1, 0], root[3, 2] = 0.05, 0.03e-3, -0.04e-3
    body = contact_of(atoms, covariance=root @ root.T)
    rng = np.random.default_rng(1)
    draws = atoms + np.einsum("nij,kj->nik", rng.standard_normal((4000, 2, 6)), root)
    force = draws[:, :, 2]
    place = np.einsum("ni,nij->nj", force, draws[:, :, :2]) / force.sum(axis=1)[:, None]
    sampled = np.cov(np.column_stack([place, force.sum(axis=1)]).T)
    assert_allclose(np.sqrt(np.diag(body.covariance)), np.sqrt(np.diag(sampled)), rtol=0.06)
    scale = np.sqrt(np.outer(np.diag(sampled), np.diag(sampled)))
    assert_allclose(body.covariance / scale, sampled / scale, atol=0.06)
    areas = [rows_of(draw)[0]["area"][0] for draw in draws[:200]]
    assert body.area_std == pytest.approx(np.std(areas), rel=0.25)


def test_a_ring_of_atoms_has_no_area_in_the_hole() -> None:
    turn = np.arange(24) * np.pi / 12
    atoms = np.zeros((24, 6))
    atoms[:, 0], atoms[:, 1] = 5e-3 * np.cos(turn), 5e-3 * np.sin(turn)
    atoms[:, 2:4] = 0.2, 1.2e-3
    (row,), _ = rows_of(atoms)
    axis = np.linspace(-7e-3, 7e-3, 701)
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    near = np.min([np.linalg.norm(points - atom[:2], axis=1) for atom in atoms], axis=0)
    assert row["area"] == pytest.approx((near <= 1.2e-3).sum() * (axis[1] - axis[0]) ** 2, rel=0.02)
    assert_allclose(row["position"], 0.0, atol=1e-12)


def test_segments_that_cross_touch_and_neighbours_do_not() -> None:
    cross = np.array([[0, 0, 1, 0.2e-3, 4e-3, 0.0], [0, 0, 1, 0.2e-3, 4e-3, 1.5]])
    assert len(rows_of(cross)[0]) == 1
    apart = np.array([[0, 0, 1, 1e-3, 4e-3, 0.0], [0, 2.1e-3, 1, 1e-3, 4e-3, 0.0]])
    assert len(rows_of(apart)[0]) == 2
    chain = np.array([[x, 0, 1, 1e-3, 0, 0] for x in (0.0, 6e-3, 1.9e-3, 3.8e-3)])
    assert rows_of(chain)[0]["normal_force"].tolist() == [3.0, 1.0]


def test_on_a_curved_patch_a_contact_stands_on_the_skin() -> None:
    patch = cylinder(radius=25e-3, length=40e-3, arc_angle=2.0)
    contact = contact_of(
        np.array([8e-3, 2e-3, 1.5, 4e-3, 0.0, 0.0]), grid=Grid.square(patch, nodes=40)
    )
    angle = 8e-3 / 25e-3
    normal = np.array([np.sin(angle), 0.0, np.cos(angle)])
    assert_allclose(contact.normal, normal, atol=0.02)
    assert_allclose(contact.position, 25e-3 * normal + [0, 2e-3, 0], atol=0.2e-3)
    assert_allclose(contact.force, -1.5 * contact.normal)
    away = np.linalg.norm(contact.outline - contact.position, axis=1)
    assert_allclose(away, 4e-3, rtol=0.02)
