"""Fields of atoms against exact solutions, convolutions, presses and Monte Carlo."""

import numpy as np
import pytest

import skinfield as sf
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
    grid: Grid,
    atoms: np.ndarray,
    family: int,
    layer: Layer = LAYER,
    mechanics: Mechanics | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Pressure and displacement."""
    field, moved = np.empty(len(grid)), np.empty((len(grid), 3))
    renderer = AtomRenderer(grid, layer, mechanics or BondedLayer())
    renderer.pressure(atoms, np.full(len(atoms), family), field)
    renderer.displacement(atoms, np.full(len(atoms), family), moved)
    return field, moved


def pressure(
    grid: Grid, atoms: np.ndarray, family: int, mechanics: Mechanics | None = None
) -> np.ndarray:
    out = np.empty(len(grid))
    renderer = AtomRenderer(grid, LAYER, mechanics or BondedLayer())
    renderer.pressure(atoms, np.full(len(atoms), family), out)
    return out


def pressure_std(atoms: np.ndarray, covariance: np.ndarray, *family: int) -> np.ndarray:
    out = np.empty(len(GRID))
    renderer = AtomRenderer(GRID, LAYER, BondedLayer())
    renderer.pressure_std(atoms, np.array(family), covariance, out)
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


@pytest.mark.parametrize("family", [BALL, FLAT])
@pytest.mark.parametrize("radius", [0.41e-3, 1.3e-3, 5.3e-3, 13e-3])
def test_the_surface_moves_as_the_exact_solution_says(radius: float, family: int) -> None:
    exact = (
        punch(LAYER, radius, depth=1.0)
        if family == FLAT
        else indent_to_radius(LAYER, Paraboloid(radius=1.0), radius)
    )
    grid = Grid.window(SQUARE, (-0.03, -0.03), (0.03, 0.03), 0.7e-3)
    _, out = drawn(grid, atom(radius=radius), family)
    distance = np.hypot(grid.plane[:, 0] - 0.3e-3, grid.plane[:, 1] + 0.2e-3)
    sunk = exact.indentation(distance) / exact.force
    assert -out[:, 2] == pytest.approx(sunk, abs=2e-3 * sunk.max())


@pytest.mark.parametrize(
    ("mechanics", "poisson_ratio"),
    [
        (BondedLayer(), 0.5),
        (BondedLayer(), 0.4),
        (BondedLayer(inextensible_cover=True), 0.5),
        (HalfSpace(point_forces=False), 0.4),
    ],
)
@pytest.mark.parametrize(("radius", "half"), [(0.9e-3, 0.0), (3e-3, 0.0), (1.2e-3, 2e-3)])
def test_the_surface_moves_as_its_own_pressure_moves_it(
    radius: float, half: float, mechanics: Mechanics, poisson_ratio: float
) -> None:
    """In all three directions; the convolution takes the pressure as even on each cell."""
    layer = Layer(2e-3, 210e3, poisson_ratio)
    atoms = atom(radius=radius, half=half, angle=0.4)
    field, found = drawn(FINE, atoms, BALL, layer, mechanics)
    cells = Deformation(FINE, layer, mechanics)(field)
    deepest = np.abs(cells[:, 2]).max()
    assert found[:, :2] == pytest.approx(cells[:, :2], abs=0.006 * deepest)
    assert found[:, 2] == pytest.approx(cells[:, 2], abs=0.01 * deepest)
    field, flat = drawn(FINE, atoms, FLAT, layer, mechanics)
    cells = Deformation(FINE, layer, mechanics)(field)
    assert np.linalg.norm(flat - cells) < 0.04 * np.linalg.norm(cells)  # its edge is sharp


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


@pytest.mark.parametrize("family", [BALL, FLAT])
def test_mirrored_and_turned_atoms_have_mirrored_and_turned_fields(family: int) -> None:
    grid = Grid.square(SQUARE, nodes=21)

    def fields(atoms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        field, moved = drawn(grid, atoms, family)
        return field.reshape(grid.shape), moved.reshape(*grid.shape, 3)

    plain, moved = fields(atom(3e-3, 1e-3, 1.0, 2e-3, 4e-3, 0.3))
    mirrored, moved_mirrored = fields(atom(-3e-3, 1e-3, 1.0, 2e-3, 4e-3, np.pi - 0.3))
    turned, moved_turned = fields(atom(1e-3, 3e-3, 1.0, 2e-3, 4e-3, np.pi / 2 - 0.3))
    assert mirrored[:, ::-1] == pytest.approx(plain, abs=1e-9 * plain.max())
    assert np.abs(turned.T - plain).max() < 0.02 * plain.max()  # rules along x and y differ
    size = np.abs(moved).max()
    assert moved_mirrored[:, ::-1] * [-1, 1, 1] == pytest.approx(moved, abs=1e-9 * size)
    assert moved_turned.transpose(1, 0, 2)[..., [1, 0, 2]] == pytest.approx(moved, abs=1e-9 * size)


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


def test_fields_of_several_atoms_add_up() -> None:
    atoms = np.vstack([atom(-3e-3, 2e-3, 1.0, 1e-3), atom(4e-3, 0.0, 0.5, 2e-3, 1e-3, 0.5)])
    both = pressure(GRID, atoms, BALL)
    assert both == pytest.approx(sum(pressure(GRID, one[None], BALL) for one in atoms), rel=1e-12)


def test_the_std_of_the_pressure_is_what_random_atoms_have() -> None:
    atoms = atom(radius=3e-3, half=1e-3, angle=0.4)
    root = np.diag([0.1e-3, 0.15e-3, 0.05, 0.1e-3, 0.15e-3, 0.05])
    root[3, 2], root[1, 0] = -0.1e-3, 0.1e-3
    out = pressure_std(atoms, (root @ root.T)[None], BALL)
    rng = np.random.default_rng(5)
    draws = np.array(
        [pressure(GRID, atoms + root @ rng.standard_normal(6), BALL) for _ in range(1500)]
    )
    assert apart(out, draws.std(axis=0)) < 0.06
    assert not out[draws.max(axis=0) == 0.0].any()


def test_the_std_of_a_force_alone_is_that_share_of_the_pressure() -> None:
    covariance = np.zeros((2, 6, 6))
    covariance[0, 2, 2] = 0.3**2
    atoms = np.vstack([atom(-6e-3), atom(6e-3)])
    out = pressure_std(atoms, covariance, BALL, FLAT)
    assert out == pytest.approx(0.3 * pressure(GRID, atoms[:1], BALL), abs=1e-6)


def test_a_place_that_nobody_knows_leaves_the_std_below_the_peak() -> None:
    covariance = np.diag([1e-4, 1e-4, 0.01, 1e-7, 0.0, 0.0])[None]
    out = pressure_std(atom(), covariance, BALL)
    peak = pressure(GRID, atom(), BALL).max()
    assert 0.5 * peak < out.max() < 1.5 * peak
    assert out[pressure(GRID, atom(), BALL) > 0.1 * peak].min() > 0.05 * peak


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
    renderer = AtomRenderer(GRID, sf.Layer(2e-3, 210e3, 0.5), BondedLayer())
    none, family = np.zeros((0, 6)), np.zeros(0, dtype=np.int64)
    field, moved, std = np.ones(len(GRID)), np.ones((len(GRID), 3)), np.ones(len(GRID))
    renderer.pressure(none, family, field)
    renderer.displacement(none, family, moved)
    renderer.pressure_std(none, family, np.zeros((0, 6, 6)), std)
    assert not field.any()
    assert not moved.any()
    assert not std.any()
    assert renderer.contacts(none, family, np.zeros((0, 6, 6))) == ()


def test_what_cannot_be_drawn_is_named() -> None:
    renderer, out = AtomRenderer(GRID, LAYER, BondedLayer()), np.empty(len(GRID))
    with pytest.raises(InputError, match=r"atoms\[\(0, 3\)\] is nan"):
        renderer.pressure(atom(radius=np.nan), np.array([BALL]), out)
    with pytest.raises(InputError, match="expected 0"):
        renderer.contacts(atom(), np.array([2]), np.zeros((1, 6, 6)))


def test_a_longer_atom_or_a_finer_grid_has_room() -> None:
    grid = Grid.window(SQUARE, (-0.02, -0.02), (0.02, 0.02), 0.2e-3)
    field = pressure(grid, atom(0.0, 0.0, 1.0, 6e-3, 10e-3, 0.3), BALL)
    assert field.sum() * grid.cell_area == pytest.approx(1.0, rel=1e-8)
    covariance = np.diag([1e-8, 1e-8, 0.01, 1e-4, 1e-4, 1.0])[None]
    std = np.empty(len(grid))
    AtomRenderer(grid, LAYER, BondedLayer()).pressure_std(
        atom(0.0, 0.0, 1.0, 6e-3, 10e-3, 0.3), np.array([BALL]), covariance, std
    )
    assert np.isfinite(std).all()
