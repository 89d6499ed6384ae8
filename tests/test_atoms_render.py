"""Fields and contacts of atoms against exact solutions, convolutions, presses and geometry."""

import numpy as np
import pytest

from skinfield.elastic import BondedLayer, Deformation, HalfSpace, Layer, Mechanics
from skinfield.elastic.axisymmetric import Paraboloid, indent_by_force, indent_to_radius, punch
from skinfield.errors import InputError
from skinfield.estimate import Contact
from skinfield.simulate import Sphere, press
from skinfield.skin import Grid, Patch
from skinfield.skin.generators import cylinder
from skinfield.solve.atoms.contacts import bodies, body_of
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
    moved = np.empty((len(grid), 3))
    renderer = AtomRenderer(grid, layer, mechanics)
    renderer.displacement(atoms, np.full(len(atoms), family), moved)
    return pressure(grid, atoms, family, mechanics, layer), moved


def pressure(
    grid: Grid, atoms: np.ndarray, family: int, mechanics: Mechanics = BONDED, layer: Layer = LAYER
) -> np.ndarray:
    out = np.empty(len(grid))
    AtomRenderer(grid, layer, mechanics).pressure(atoms, np.full(len(atoms), family), out)
    return out


def pressure_std(atoms: np.ndarray, covariance: np.ndarray, grid: Grid = GRID) -> np.ndarray:
    out = np.empty(len(grid))
    AtomRenderer(grid, LAYER, BONDED).pressure_std(atoms, np.array([BALL]), covariance, out)
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
    np.testing.assert_allclose(-out[:, 2], sunk, rtol=0, atol=2e-3 * sunk.max())


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
    np.testing.assert_allclose(found[:, :2], cells[:, :2], rtol=0, atol=0.006 * deepest)
    np.testing.assert_allclose(found[:, 2], cells[:, 2], rtol=0, atol=0.01 * deepest)
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


def test_the_std_of_the_pressure_is_what_random_atoms_have() -> None:
    atoms = atom(radius=3e-3, half=1e-3, angle=0.4)
    root = np.diag([0.1e-3, 0.15e-3, 0.05, 0.1e-3, 0.15e-3, 0.05])
    root[3, 2], root[1, 0] = -0.1e-3, 0.1e-3
    out = pressure_std(atoms, (root @ root.T)[None])
    rng = np.random.default_rng(5)
    draws = np.array(
        [pressure(GRID, atoms + root @ rng.standard_normal(6), BALL) for _ in range(1500)]
    )
    assert apart(out, draws.std(axis=0)) < 0.06
    assert not out[draws.max(axis=0) == 0.0].any()


def test_a_place_that_nobody_knows_leaves_the_std_below_the_peak() -> None:
    covariance = np.diag([1e-4, 1e-4, 0.01, 1e-7, 0.0, 0.0])[None]
    out = pressure_std(atom(), covariance)
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
    renderer = AtomRenderer(GRID, LAYER, BONDED)
    none, family = np.zeros((0, 6)), np.zeros(0, dtype=np.int64)
    field, moved, std = np.ones(len(GRID)), np.ones((len(GRID), 3)), np.ones(len(GRID))
    renderer.pressure(none, family, field)
    renderer.displacement(none, family, moved)
    renderer.pressure_std(none, family, np.zeros((0, 6, 6)), std)
    assert not field.any()
    assert not moved.any()
    assert not std.any()
    assert renderer.contacts(none, family, np.zeros((0, 0)), []) == ()


def test_what_cannot_be_drawn_is_named() -> None:
    renderer, out = AtomRenderer(GRID, LAYER, BondedLayer()), np.empty(len(GRID))
    with pytest.raises(InputError, match=r"atoms\[\(0, 3\)\] is nan"):
        renderer.pressure(atom(radius=np.nan), np.array([BALL]), out)
    with pytest.raises(InputError, match="expected 0"):
        renderer.contacts(atom(), np.array([2]), np.zeros((6, 6)), [[0]])


def test_a_longer_atom_or_a_finer_grid_has_room() -> None:
    grid = Grid.window(SQUARE, (-0.02, -0.02), (0.02, 0.02), 0.2e-3)
    atoms = atom(0.0, 0.0, 1.0, 6e-3, 10e-3, 0.3)
    assert pressure(grid, atoms, BALL).sum() * grid.cell_area == pytest.approx(1.0, rel=1e-8)
    covariance = np.diag([1e-8, 1e-8, 0.01, 1e-4, 1e-4, 1.0])[None]
    assert np.isfinite(pressure_std(atoms, covariance, grid)).all()


CLOSE = Grid.window(SQUARE, (-0.02, -0.02), (0.02, 0.02), 0.5e-3)
RENDERER = AtomRenderer(CLOSE, LAYER, BondedLayer())
COVARIANCE = np.diag([0.1e-3, 0.2e-3, 0.05, 0.15e-3, 0.3e-3, 0.1]) ** 2
BALLS = np.zeros(1, dtype=np.int64)

ROUND = np.array([0.31e-3, -0.17e-3, 1.5, 2.2e-3, 0.0, 0.0])
LONG = np.array([-4e-3, 3e-3, 2.0, 1.2e-3, 3e-3, 0.7])


def contact_of(atom: np.ndarray, family: int = BALL) -> Contact:
    (contact,) = RENDERER.contacts(atom[None], np.array([family]), COVARIANCE, [[0]])
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
    field = np.empty(len(CLOSE))
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
    x, y, _ = contact.outline.T
    enclosed = 0.5 * (x[:-1] * y[1:] - x[1:] * y[:-1]).sum()
    assert enclosed == pytest.approx(contact.area, rel=0.01)
    along = (contact.outline - contact.position) @ [np.cos(0.7), np.sin(0.7), 0.0]
    across = (contact.outline - contact.position) @ [-np.sin(0.7), np.cos(0.7), 0.0]
    assert np.abs(along).max() == pytest.approx(4.2e-3, rel=0.01)
    assert np.abs(across).max() == pytest.approx(1.2e-3, rel=0.01)
    moments = [spread(LONG, angle) for angle in (0.7, 0.7 + np.pi / 2)]
    assert contact.axes == pytest.approx(moments, rel=0.01)
    back = contact_of(LONG + np.array([0, 0, 0, 0, 0, np.pi / 2]))
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
    assert len(contact.cells) * CLOSE.cell_area == pytest.approx(contact.area, rel=0.06)
    side = contact.outline[:-1, None, :2] - CLOSE.plane[None, contact.cells]
    following = contact.outline[1:, None, :2] - CLOSE.plane[None, contact.cells]
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
        int(np.argmin(np.linalg.norm(CLOSE.plane - (0.01e-3, 0.02e-3), axis=1)))
    ]
    beside = contact_of(np.array([0.05, 0.0, 1.0, 2e-3, 0.0, 0.0]))
    assert CLOSE.plane[beside.cells[0], 0] == CLOSE.plane[:, 0].max()
    assert beside.normal_force == pytest.approx(1.0)


def lens(radius: float, apart: float) -> float:
    half = np.arccos(apart / (2 * radius))
    return float(2 * radius**2 * half - apart / 2 * np.sqrt(4 * radius**2 - apart**2))


def test_discs_that_overlap_are_one_body() -> None:
    atoms = np.stack([ROUND, ROUND + np.array([3e-3, 0, -0.5, 0, 0, 0])])
    family = np.array([BALL, FLAT])
    (both,) = RENDERER.contacts(atoms, family, np.kron(np.eye(2), COVARIANCE), bodies(atoms))
    assert both.shape == "other"
    assert both.area == pytest.approx(2 * np.pi * 2.2e-3**2 - lens(2.2e-3, 3e-3), rel=0.01)
    assert both.normal_force == pytest.approx(2.5)
    assert both.position[0] == pytest.approx((1.5 * 0.31e-3 + 1.0 * 3.31e-3) / 2.5)
    assert both.angle == pytest.approx(0.0, abs=1e-3)
    assert both.axes[0] > 1.3 * both.axes[1]
    one, other = RENDERER.contacts(atoms, family, np.kron(np.eye(2), COVARIANCE), [[0], [1]])
    assert (one.shape, other.shape) == ("sphere", "flat")
    assert set(one.cells) | set(other.cells) == set(both.cells)


def test_a_body_has_the_covariance_of_random_atoms() -> None:
    atoms = np.stack([ROUND, ROUND + np.array([3e-3, 1e-3, -0.5, -0.4e-3, 0, 0])])
    root = np.zeros((12, 12))
    root[range(12), range(12)] = np.tile([0.05e-3, 0.05e-3, 0.1, 0.05e-3, 0, 0], 2)
    root[8, 2] = -0.095  # one force takes what the other leaves
    (body,) = RENDERER.contacts(atoms, np.zeros(2, dtype=int), root @ root.T, [[0, 1]])
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
    every = np.kron(np.eye(24), COVARIANCE)
    (contact,) = RENDERER.contacts(atoms, np.zeros(24, dtype=int), every, [list(range(24))])
    assert contact.area == pytest.approx(24 * np.pi * 0.6e-3**2, rel=0.01)
    assert np.linalg.norm(contact.outline, axis=1) == pytest.approx(5.6e-3, rel=0.02)
    assert np.linalg.norm(CLOSE.plane[contact.cells], axis=1).min() > 4.3e-3


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
    (contact,) = renderer.contacts(atom[None], BALLS, COVARIANCE, [[0]])
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
