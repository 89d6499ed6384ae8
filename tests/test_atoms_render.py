"""Fields and contacts of atoms against exact solutions, convolutions, presses and geometry."""

import numpy as np
import pytest

from skinfield.elastic import BondedLayer, Deformation, HalfSpace, Layer, Mechanics
from skinfield.elastic.axisymmetric import Paraboloid, indent_by_force, indent_to_radius, punch
from skinfield.errors import InputError
from skinfield.simulate import Sphere, press
from skinfield.skin import Grid, Patch
from skinfield.skin.generators import cylinder
from skinfield.solve.atoms.render import AtomRenderer
from skinfield.solve.atoms.table import BALL, FLAT, unit_pressure

LAYER = Layer(2e-3, 210e3, 0.5)
SQUARE = Patch(np.array([(-0.02, -0.02), (0.02, -0.02), (0.02, 0.02), (-0.02, 0.02)]))
GRID = Grid.window(SQUARE, (-0.02, -0.02), (0.02, 0.02), 1.25e-3)
BONDED = BondedLayer()
FINE = Grid.window(SQUARE, (-8e-3, -8e-3), (8e-3, 8e-3), 0.16e-3)


def atom(
    x: float = 0.3e-3,
    y: float = -0.2e-3,
    force: float = 1.0,
    radius: float = 2e-3,
    half: float = 0.0,
    angle: float = 0.0,
) -> np.ndarray:
    return np.array([[x, y, force, radius, half, angle]])


def drawn(
    grid: Grid, atoms: np.ndarray, family: int, layer: Layer = LAYER, mechanics: Mechanics = BONDED
) -> tuple[np.ndarray, np.ndarray]:
    """Pressure and displacement."""
    renderer = AtomRenderer(grid, layer, mechanics)
    moved = renderer.displacement(atoms, np.full(len(atoms), family))
    return pressure(grid, atoms, family, mechanics, layer), moved


def pressure(
    grid: Grid, atoms: np.ndarray, family: int, mechanics: Mechanics = BONDED, layer: Layer = LAYER
) -> np.ndarray:
    out = np.empty(len(grid))
    AtomRenderer(grid, layer, mechanics).pressure(atoms, np.full(len(atoms), family), out)
    return out


@pytest.mark.parametrize("family", [BALL, FLAT])
@pytest.mark.parametrize(
    ("radius", "half"), [(0.8e-3, 0.0), (2e-3, 0.0), (7e-3, 0.0), (1e-3, 4e-3)]
)
def test_cells_share_the_whole_force_at_its_place(radius: float, half: float, family: int) -> None:
    for x, y in [(0.0, 0.0), (0.4e-3, -0.1e-3), (3.07e-3, -5.61e-3)]:
        field = pressure(GRID, atom(x, y, 2.5, radius, half, 0.7), family)
        assert field.min() >= 0.0
        assert field.sum() * GRID.cell_area == pytest.approx(2.5, rel=1e-8)
        assert field @ GRID.plane / field.sum() == pytest.approx([x, y], abs=1e-6 * GRID.pitch)


def test_an_atom_smaller_than_half_a_cell_is_as_near_to_its_place_as_its_cells_allow() -> None:
    field = pressure(GRID, atom(0.3e-3, -0.2e-3, 1.0, 0.3e-3), BALL)
    assert field.min() >= 0.0
    assert field.sum() * GRID.cell_area == pytest.approx(1.0, rel=1e-8)
    assert field @ GRID.plane / field.sum() == pytest.approx([0.3e-3, -0.2e-3], abs=0.6e-3)


@pytest.mark.parametrize(("family", "worst"), [(BALL, 0.004), (FLAT, 0.035)])
@pytest.mark.parametrize("mechanics", [BondedLayer(), HalfSpace()])
def test_cells_have_the_mean_of_the_exact_pressure(
    mechanics: Mechanics, family: int, worst: float
) -> None:
    """Of a million points that carry the same force each, in all rings and directions."""
    radius, steps = 5e-3, (np.arange(1000) + 0.5) / 1000
    rings = radius * np.sqrt(1.0 - steps**2)  # even in sqrt(1 - r²/a²)
    share = unit_pressure(LAYER, mechanics, family, radius, rings) * steps
    turn = 2.0 * np.pi * steps
    x, y = (
        middle + rings[:, None] * f(turn) for middle, f in ((0.3e-3, np.cos), (-0.2e-3, np.sin))
    )
    column = np.rint((x - GRID.origin[0]) / GRID.pitch).astype(int)
    row = np.rint((y - GRID.origin[1]) / GRID.pitch).astype(int)
    cells = (row * GRID.shape[1] + column).ravel()
    exact = np.bincount(cells, np.repeat(share, len(turn)), len(GRID))
    exact /= exact.sum() * GRID.cell_area
    found = pressure(GRID, atom(radius=radius), family, mechanics)
    assert np.abs(found - exact).max() < worst * exact.max()


@pytest.mark.parametrize("family", [BALL, FLAT])
def test_a_grid_that_the_contact_reaches_beyond_shows_its_part(family: int) -> None:
    atoms = atom(2e-3, 1e-3, 1.0, 3e-3, 2e-3, 0.4)
    part = Grid(SQUARE, (3, 2), GRID.pitch, GRID.plane[18 * 32 + 15])
    whole = pressure(GRID, atoms, family).reshape(GRID.shape)
    assert pressure(part, atoms, family).reshape(3, 2) == pytest.approx(
        whole[18:21, 15:17], rel=1e-12
    )
    assert not pressure(part, atom(15e-3), family).any()


@pytest.mark.parametrize(
    ("radius", "ball", "flat"),
    [(0.41e-3, 0.06, 0.03), (1.3e-3, 0.02, 0.04), (5.3e-3, 0.006, 0.02), (13e-3, 0.005, 0.035)],
)
def test_the_surface_moves_as_the_exact_solution_says(
    radius: float, ball: float, flat: float
) -> None:
    """Nowhere off by more than a part of the peak for a ball; in all for a flat end's edge."""
    grid = Grid.window(SQUARE, (-0.03, -0.03), (0.03, 0.03), 0.7e-3)
    distance = np.hypot(grid.plane[:, 0] - 0.3e-3, grid.plane[:, 1] + 0.2e-3)
    exact = indent_to_radius(LAYER, Paraboloid(radius=1.0), radius)
    sunk = exact.indentation(distance) / exact.force
    out = drawn(grid, atom(radius=radius), BALL)[1]
    np.testing.assert_allclose(-out[:, 2], sunk, rtol=0, atol=ball * sunk.max())
    exact = punch(LAYER, radius, depth=1.0)
    out = drawn(grid, atom(radius=radius), FLAT)[1]
    assert apart(-out[:, 2], exact.indentation(distance) / exact.force) < flat


@pytest.mark.parametrize("mechanics", [BONDED, HalfSpace(point_forces=False)])
def test_the_surface_moves_as_its_own_pressure_moves_it(mechanics: Mechanics) -> None:
    """In all three directions, on a grid that needs no finer cells."""
    layer = Layer(2e-3, 210e3, 0.4)
    field, found = drawn(FINE, atom(radius=1.2e-3, half=2e-3, angle=0.4), BALL, layer, mechanics)
    cells = Deformation(FINE, layer, mechanics)(field)
    np.testing.assert_allclose(found, cells, rtol=0, atol=1e-9 * np.abs(cells).max())


def test_a_ball_that_is_pressed_is_rendered_as_the_simulator_solves_it() -> None:
    """The simulator's body is a sphere, the atom a paraboloid with the same contact radius."""
    force, radius = 1.0, 6e-3
    truth = press(
        LAYER, [Sphere(radius=radius, force=force, position=(0.31e-3, -0.17e-3))], extent=40e-3
    )
    a = indent_by_force(LAYER, Paraboloid(radius=radius), force).contact_radius
    field, moved = drawn(truth.grid, atom(0.31e-3, -0.17e-3, force, a), BALL)
    assert 1e-3 < apart(field, truth.pressure) < 0.03
    assert 1e-3 < apart(moved[:, 2], truth.displacement[:, 2]) < 0.025
    assert apart(moved, truth.displacement) < 0.025


def apart(found: np.ndarray, truth: np.ndarray) -> float:
    return float(np.linalg.norm(found - truth) / np.linalg.norm(truth))


@pytest.mark.parametrize(("family", "worst"), [(BALL, 0.03), (FLAT, 0.12)])
def test_a_drawn_out_atom_is_a_row_of_round_ones(family: int, worst: float) -> None:
    count, half, angle = 200, 2e-3, 0.4
    step = half * (2.0 * (np.arange(count) + 0.5) / count - 1.0)
    row = np.repeat(atom(force=1.0 / count, radius=1e-3), count, axis=0)
    row[:, 0] += step * np.cos(angle)
    row[:, 1] += step * np.sin(angle)
    grid = Grid.window(SQUARE, (-8e-3, -8e-3), (8e-3, 8e-3), 0.5e-3)
    one = atom(radius=1e-3, half=half, angle=angle)
    assert apart(pressure(grid, one, family), pressure(grid, row, family)) < worst
    moved = [drawn(grid, atoms, family)[1] for atoms in (one, row)]
    assert apart(*moved) < worst


def test_on_a_curved_patch_nodes_move_along_its_own_normals() -> None:
    patch = cylinder(radius=25e-3, length=40e-3, arc_angle=2.0)
    grid = Grid.square(patch, nodes=30)
    _, out = drawn(grid, atom(8e-3, 2e-3), BALL)
    node = int(np.argmin(np.linalg.norm(grid.plane - (8e-3, 2e-3), axis=1)))
    inwards = -out[node] / np.linalg.norm(out[node])
    assert inwards == pytest.approx(grid.normals[node], abs=0.15)
    local = np.einsum("kij,ki->kj", grid.frames, out)
    _, flat = drawn(Grid(SQUARE, grid.shape, grid.pitch, grid.origin), atom(8e-3, 2e-3), BALL)
    assert local == pytest.approx(flat, abs=1e-12)


def test_no_atom_is_no_pressure() -> None:
    renderer = AtomRenderer(GRID, LAYER, BONDED)
    none, family = np.zeros((0, 6)), np.zeros(0, dtype=np.int64)
    field = np.ones(len(GRID))
    renderer.pressure(none, family, field)
    assert not field.any()
    assert not renderer.displacement(none, family).any()


def test_what_cannot_be_drawn_is_named() -> None:
    renderer, out = AtomRenderer(GRID, LAYER, BondedLayer()), np.empty(len(GRID))
    with pytest.raises(InputError, match=r"atoms\[\(0, 3\)\] is nan"):
        renderer.pressure(atom(radius=np.nan), np.array([BALL]), out)
    with pytest.raises(InputError, match="expected 0"):
        renderer.pressure(atom(), np.array([2]), out)


def test_a_longer_atom_or_a_finer_grid_has_room() -> None:
    grid = Grid.window(SQUARE, (-0.02, -0.02), (0.02, 0.02), 0.2e-3)
    atoms = atom(0.0, 0.0, 1.0, 6e-3, 10e-3, 0.3)
    assert pressure(grid, atoms, BALL).sum() * grid.cell_area == pytest.approx(1.0, rel=1e-8)
