"""Contact of rigid bodies, normal and with friction, against Hertz, Cattaneo and Mindlin."""

from functools import lru_cache

import numpy as np
import pytest
from closed_forms import square_displacement

import skinfield as sf
from skinfield.elastic import LatticeConvolution
from skinfield.elastic.cell_integrals import inverse_distance_integrals
from skinfield.elastic.contact import (
    ContactProblem,
    ShearProblem,
    solve_contact,
    solve_slip,
    solve_stick,
)
from skinfield.elastic.lattice import interpolation, lattice, mirrored
from skinfield.errors import InputError, SkinfieldError
from skinfield.simulate import Cylinder, Sphere, press, press_path

MODULUS = 130e3  # E / (1 - nu²), Pa


COUNT, CELL = 61, 0.1e-3  # of square cells around the origin of the half-space
AXIS = (np.arange(COUNT) - (COUNT - 1) / 2) * CELL
X, Y = np.meshgrid(AXIS, AXIS)
LOVE = inverse_distance_integrals(lattice(COUNT - 1, COUNT - 1, CELL), CELL).inverse / (
    np.pi * MODULUS
)
INDENT = LatticeConvolution(mirrored(LOVE.reshape(COUNT, COUNT)))  # of pressure (Love 1929)


def solve(heights, forces, depths=None, bodies=None, **settings):
    forces = np.atleast_1d(np.asarray(forces, dtype=float))
    problem = ContactProblem(
        INDENT,
        np.full(X.shape, LOVE[0]),
        heights,
        np.zeros(X.shape, dtype=np.int64) if bodies is None else bodies,
        np.full(X.shape, CELL**2),
        forces,
        np.full(forces.shape, np.nan) if depths is None else np.atleast_1d(depths),
    )
    return solve_contact(problem, np.zeros(X.shape), np.zeros(X.shape), **settings)


def paraboloid(x, y, radius=10e-3):
    return (x**2 + y**2) / (2 * radius)


def test_a_given_depth_and_its_force_are_one_contact() -> None:
    heights = paraboloid(X - 0.3e-3, Y)
    deep = solve(heights, np.nan, depths=0.5e-3)
    force = deep.pressure.sum() * CELL**2
    assert force == pytest.approx(4 / 3 * MODULUS * np.sqrt(10e-3) * 0.5e-3**1.5, rel=1e-3)
    pushed = solve(heights, force)
    assert pushed.approach[0] == pytest.approx(0.5e-3, rel=1e-5)
    np.testing.assert_allclose(pushed.pressure, deep.pressure, atol=1e-3 * deep.pressure.max())


def test_complementarity_is_certified_and_the_certificate_is_what_it_says() -> None:
    found = solve(paraboloid(X, Y), 1.0, tolerance=1e-8)
    assert found.residual <= 1e-8
    sunk = INDENT(found.pressure)
    gap = sunk + paraboloid(X, Y) - found.approach[0]
    np.testing.assert_allclose(found.gap, gap, atol=1e-15)
    touching = found.pressure > 0
    deepest = sunk[touching].max()
    assert found.pressure.min() == 0.0
    assert np.abs(gap[touching]).max() <= 1e-8 * deepest
    assert gap[~touching].min() >= -1e-8 * deepest


def test_forces_and_depths_together() -> None:
    """Each of two bodies keeps what it was given, and feels the other."""
    bodies = (X > 0).astype(np.int64)
    heights = np.where(X > 0, paraboloid(X - 1.6e-3, Y), paraboloid(X + 1.6e-3, Y))
    found = solve(heights, [0.3, np.nan], [np.nan, 0.6e-3], bodies)
    area = CELL**2
    assert found.pressure[bodies == 0].sum() * area == pytest.approx(0.3, rel=1e-9)
    assert found.approach[1] == 0.6e-3
    again = solve(
        heights,
        [np.nan, found.pressure[bodies == 1].sum() * area],
        [found.approach[0], np.nan],
        bodies,
    )
    np.testing.assert_allclose(again.approach, found.approach, rtol=1e-5)
    alone = solve(np.where(bodies == 0, heights, np.inf), 0.3)
    assert found.approach[0] > alone.approach[0] * 1.02


def test_one_cell_carries_a_body() -> None:
    heights = np.full(X.shape, np.inf)
    heights[30, 30] = 0.0
    found = solve(heights, 0.1)
    assert found.pressure[30, 30] * CELL**2 == pytest.approx(0.1, rel=1e-12)
    assert found.approach[0] == pytest.approx(found.pressure[30, 30] * LOVE[0], rel=1e-12)


def test_what_is_given_twice_or_not_at_all_is_named() -> None:
    heights = paraboloid(X, Y)
    with pytest.raises(InputError, match=r"forces\[0\] is 1.0 and depths\[0\] is 0.001, expected"):
        solve(heights, 1.0, depths=1e-3)
    with pytest.raises(InputError, match=r"forces\[0\] is nan and depths\[0\] is nan"):
        solve(heights, np.nan)
    with pytest.raises(SkinfieldError, match=r"in 2 iterations, expected 1\.0e-06"):
        solve(heights, 1.0, most_iterations=2)


def test_interpolation_keeps_polynomials_and_moments() -> None:
    places = np.random.default_rng(3).uniform(2.0, 9.0, 40)
    weights = interpolation(places, 12)
    for degree in range(6):
        np.testing.assert_allclose(weights @ np.arange(12.0) ** degree, places**degree, rtol=1e-10)


def test_the_convolution_is_the_sum() -> None:
    rng = np.random.default_rng(5)
    kernel, values = rng.normal(size=(2, 9, 13)), rng.normal(size=(5, 7))
    found = LatticeConvolution(kernel)(values)
    for row in range(5):
        for column in range(7):
            part = kernel[:, row : row + 5, column : column + 7][:, ::-1, ::-1]
            np.testing.assert_allclose(found[:, row, column], (part * values).sum((1, 2)))


E, A = 100e3, 2.4e-3
R = np.hypot(X, Y)
INSIDE = R < A


@lru_cache(maxsize=4)
def slide(nu: float):
    """Tangential traction on cells of the half-space to displacement there (Cerruti)."""
    response = square_displacement(lattice(COUNT - 1, COUNT - 1, CELL), CELL, E, nu)
    xx, xy, yy = (response[:, i, j].reshape(COUNT, COUNT) for i, j in [(0, 0), (0, 1), (1, 1)])
    mixed = mirrored(xy, odd_x=True, odd_y=True)
    along_x = LatticeConvolution(np.stack([mirrored(xx), mixed]))
    along_y = LatticeConvolution(np.stack([mixed, mirrored(yy)]))

    def apply(traction):
        x, y = traction.reshape(2, COUNT, COUNT)
        return (along_x(x) + along_y(y)).reshape(2, -1)

    return apply


def problem(nu: float, forces, touching=INSIDE, bodies=None) -> ShearProblem:
    size = COUNT**2
    return ShearProblem(
        slide(nu),
        touching.ravel(),
        np.zeros(size, dtype=np.int64) if bodies is None else bodies.ravel(),
        np.full(size, CELL**2),
        np.atleast_2d(np.asarray(forces, dtype=float)),
    )


def test_sticking_is_reciprocal() -> None:
    """Two bodies, one sheared at a time: each moves the other equally (Betti)."""
    touching = (np.hypot(X - 1.5e-3, Y) < 1e-3) | (np.hypot(X + 1.2e-3, Y + 0.7e-3) < 0.7e-3)
    bodies = (X < 0).astype(np.int64)
    first = solve_stick(problem(0.3, [[0.1, 0], [0, 0]], touching, bodies), tolerance=1e-8)
    second = solve_stick(problem(0.3, [[0, 0], [0, 0.1]], touching, bodies), tolerance=1e-8)
    assert first.translation[1, 1] == pytest.approx(second.translation[0, 0], rel=1e-5)
    assert abs(first.translation[1, 1]) > 1e-3 * first.translation[0, 0]


PRESSURE = 1e4 * np.sqrt(np.maximum(1 - (R / A) ** 2, 0.0))
PUSH = float(PRESSURE.sum() * CELL**2)


@pytest.mark.parametrize("share", [0.3, 0.7])
def test_partial_slip_of_cattaneo_and_mindlin(share: float) -> None:
    """Stick radius a (1 - T / mu P)^(1/3) and their traction, exact without Poisson's effect."""
    friction = 0.6
    force = share * friction * PUSH
    found = solve_slip(problem(0.0, [force, 0.0]), friction * PRESSURE.ravel())
    stick = ~found.slipping.reshape(COUNT, COUNT) & INSIDE
    c = A * (1 - share) ** (1 / 3)
    assert np.sqrt(stick.sum() / np.pi) * CELL == pytest.approx(c, rel=0.015)
    x, y = found.traction.reshape(2, COUNT, COUNT)
    inner = 1e4 * c / A * np.sqrt(np.maximum(1 - (R / c) ** 2, 0.0))
    exact = friction * (PRESSURE - inner)
    clear = INSIDE & (np.abs(R - c) > 2 * CELL)
    np.testing.assert_allclose(x[clear], exact[clear], atol=0.02 * friction * 1e4)
    assert np.abs(y).max() < 1e-2 * np.abs(x).max()
    assert (np.hypot(x, y) <= friction * PRESSURE * (1 + 1e-9)).all()
    assert x.sum() * CELL**2 == pytest.approx(force, rel=1e-6)
    # Mindlin (1949): d = 3 mu P (2 - nu) / (16 G a) [1 - (1 - T / mu P)^(2/3)]
    modulus = E / 2
    moved = 3 * friction * PUSH * 2 / (16 * modulus * A) * (1 - (1 - share) ** (2 / 3))
    assert found.translation[0, 0] == pytest.approx(moved, rel=8e-3)


def test_without_a_reached_limit_slip_is_stick() -> None:
    limit = np.full(COUNT**2, 1e9)
    sticks, slips = (
        solve_stick(problem(0.5, [0.2, 0.1])),
        solve_slip(problem(0.5, [0.2, 0.1]), limit),
    )
    np.testing.assert_allclose(slips.translation, sticks.translation, rtol=1e-3)
    assert not slips.slipping.any()


def test_too_much_shear_is_named() -> None:
    with pytest.raises(InputError, match=r"shear of indenters\[0\] is 1 N, expected at most"):
        solve_slip(problem(0.0, [1.0, 0.0]), 1e-3 * PRESSURE.ravel())
    with pytest.raises(InputError, match=r"forces\[0\] is .* N, expected zero: the body does not"):
        problem(0.0, [1.0, 0.0], touching=np.zeros_like(INSIDE))


LAYER = sf.Layer(2e-3, 100e3, 0.5)
BALL = Sphere(radius=6e-3, force=1.0, shear=(0.3, -0.1))


def test_a_sheared_press_carries_its_forces_and_moments_to_the_base() -> None:
    """Equilibrium of the layer: forces, and moments about the plane of the base."""
    ball = Sphere(radius=3e-3, force=0.1, shear=(0.03, -0.01))
    found = press(LAYER, [ball], extent=20e-3, cell=0.25e-3)
    forces = (found.traction * found.grid.cell_area).sum(axis=0)
    np.testing.assert_allclose(forces, [0.03, -0.01, -0.1], rtol=1e-6)
    axis = np.arange(-20, 21) * 1e-3
    places = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    base = found.base_traction(places) * 1e-3**2
    np.testing.assert_allclose(base.sum(axis=0), [0.03, -0.01, -0.1], atol=5e-5)
    # Shear acts a thickness above the base and turns it there by normal stress.
    turned = np.array([places[:, 1] @ base[:, 2], -places[:, 0] @ base[:, 2]])
    h = LAYER.thickness
    np.testing.assert_allclose(turned - found.moment[:2], [0.01 * h, 0.03 * h], atol=1e-6)
    np.testing.assert_allclose(found.base_stress(places, 0.0), -base[:, 2] / 1e-3**2, atol=1e-6)


def test_a_wide_flat_end_shears_the_layer_as_a_block() -> None:
    """u = T h / (G area) for a contact much wider than the layer is thick."""
    thin = sf.Layer(0.5e-3, 100e3, 0.5)
    found = press(thin, [Cylinder(radius=10e-3, force=1.0, shear=(0.01, 0.0))], extent=30e-3)
    block = 0.01 * 0.5e-3 / (100e3 / 3 * np.pi * 10e-3**2)
    assert block * 0.9 < found.translation[0, 0] < block
    inner = np.hypot(*found.grid.plane.T) < 9e-3
    moved = (
        found.displacement[inner, 0]
        - press(thin, [Cylinder(radius=10e-3)], 30e-3).displacement[inner, 0]
    )
    np.testing.assert_allclose(moved, found.translation[0, 0], rtol=2e-3)


@lru_cache
def pushed(shear: float, friction: float | None = None):
    return press(LAYER, [Sphere(radius=6e-3, shear=(shear, 0.0))], 20e-3, friction=friction)


PLACES = np.array([[-3e-3, 0.0], [3e-3, 0.0]])


def test_shear_adds_the_opposite_on_both_sides() -> None:
    """By reflection at the plane across it, in every quantity, to first order."""
    for read in ("base_stress", "gap_change"):
        before, back, forth = (getattr(pushed(s), read)(PLACES, 4e-3) for s in (0.0, -0.1, 0.1))
        np.testing.assert_allclose(back, forth[::-1], rtol=1e-5)
        added = forth - before
        assert added[0] == pytest.approx(-added[1], rel=0.1)
        assert abs(added[0]) > 0.005 * np.abs(before).max()


@pytest.mark.parametrize("friction", [None, 0.7, 0.4])
def test_a_sheared_ball_rests_on_the_skin_that_its_shear_raises(friction: float | None) -> None:
    """Its surface is the body's where it touches, from all tractions on single squares."""
    found, ball = pushed(0.4, friction), Sphere(radius=6e-3)
    (touch,) = found.touches
    y, x = found._skin.axes(touch.window)
    side = found._skin.side(touch.window)
    squares = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2)
    loads = touch.traction.reshape(3, -1).T
    for place in ([1.5e-3, 0.0], [-1.5e-3, 0.5e-3], [0.3e-3, -1.8e-3]):
        at = squares[np.argmin(np.hypot(*(squares - place).T))]
        each = sf.BondedLayer().surface_displacement(LAYER, at - squares, side)
        sunk = -np.einsum("nj,nj->", each[:, 2], loads)
        assert sunk == pytest.approx(found.approach[0] - ball.height(*at), abs=2e-6 * 0.6)
    # The bulge ahead takes more of the load: without it the middle of the pressure would stay.
    assert 0.1e-3 < found.moment[1] / found.force < 0.3e-3
    assert found.slipping_share == {None: 0.0, 0.4: 1.0}.get(friction, found.slipping_share)


def test_friction_from_the_first_touch_holds_the_skin_below_a_ball() -> None:
    """By symmetry it adds no force aside, and what sticks stays where it was touched."""
    steps = [[Sphere(radius=6e-3, force=force)] for force in (0.3, 0.6, 0.6)]
    path = press_path(LAYER, steps, extent=12e-3, cell=1e-3, friction=0.5)
    plain = press(LAYER, steps[-1], extent=12e-3, cell=1e-3)
    assert 0.9 * plain.approach[0] < path[1].approach[0] < 0.98 * plain.approach[0]
    np.testing.assert_allclose(path[1].shears, 0.0, atol=1e-6)
    held = np.hypot(*path[1].traction[:, :2].T)
    assert (held <= 0.5 * path[1].pressure * (1 + 1e-6)).all()
    assert held.sum() > 0.1 * path[1].pressure.sum()
    # The same load again changes nothing, and what sticks under more load does not move.
    np.testing.assert_allclose(path[2].traction, path[1].traction, atol=2e-3 * held.max())
    inner = np.hypot(*path[0].grid.plane.T) < 1.2e-3
    moved = (path[1].displacement - path[0].displacement)[inner, :2]
    free = plain.displacement[inner, :2] / 2  # as much would move with nothing to hold it
    assert np.abs(moved).max() < 0.1 * np.abs(free).max()
    with pytest.raises(InputError, match="of the same bodies each"):
        press_path(LAYER, [steps[0], []])


def test_a_ball_that_slides_is_held_at_the_limit_everywhere() -> None:
    found = pushed(0.4, 0.4)
    x, y = found.traction[:, 0], found.traction[:, 1]
    np.testing.assert_allclose(x, 0.4 * found.pressure, atol=1e-4 * found.pressure.max())
    assert np.abs(y).max() < 1e-9 * found.pressure.max()


def test_a_limited_press_slips_in_part() -> None:
    found = press(LAYER, [BALL], extent=20e-3, friction=0.6)
    assert 0.2 < found.slipping_share < 0.8
    size = np.hypot(*found.traction[:, :2].T)
    assert (size <= 0.6 * found.pressure * (1 + 1e-6)).all()
    stuck = press(LAYER, [BALL], extent=20e-3)
    assert stuck.slipping_share == 0.0
    assert np.linalg.norm(found.translation) > np.linalg.norm(stuck.translation)
    with pytest.raises(InputError, match=r"no skin holds more; press harder or shear less"):
        press(LAYER, [BALL], extent=20e-3, friction=0.2)
    cover = sf.BondedLayer(inextensible_cover=True)
    with pytest.raises(InputError, match="the cover takes every shear"):
        press(LAYER, [BALL], extent=20e-3, mechanics=cover)
