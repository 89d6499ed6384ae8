"""Contact of rigid bodies, normal and with friction, against Hertz, Cattaneo and Mindlin."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from closed_forms import rectangle_displacement

import skinfield as sf
from skinfield.elastic import LatticeConvolution
from skinfield.elastic.cell_integrals import inverse_distance_integrals
from skinfield.elastic.contact import (
    ContactProblem,
    ShearProblem,
    edge_softness,
    rim,
    solve_contact,
    solve_slip,
    solve_stick,
)
from skinfield.elastic.lattice import interpolation, lattice, mirrored
from skinfield.errors import InputError, SkinfieldError
from skinfield.simulate import Cylinder, Sphere, press

MODULUS = 130e3  # E / (1 - nu²), Pa


@lru_cache(maxsize=8)
def half_space(count: int, cell: float) -> LatticeConvolution:
    """Pressure on count x count cells of the half-space to indentation (Love 1929)."""
    near = inverse_distance_integrals(lattice(count - 1, count - 1, cell), cell).inverse
    return LatticeConvolution(mirrored(near.reshape(count, count)) / (np.pi * MODULUS))


class Bench:
    """Square cells of 1 mm / `fine` around the origin of the half-space."""

    def __init__(self, count: int, cell: float) -> None:
        self.cell, self.count = cell, count
        axis = (np.arange(count) - (count - 1) / 2) * cell
        self.x, self.y = np.meshgrid(axis, axis)
        self.indent = half_space(count, cell)

    def solve(self, heights, forces, depths=None, bodies=None, softness=0.0, **settings):
        forces = np.atleast_1d(np.asarray(forces, dtype=float))
        shape = heights.shape
        own = inverse_distance_integrals(np.zeros((1, 2)), self.cell).inverse[0]
        problem = ContactProblem(
            self.indent,
            np.full(shape, own / (np.pi * MODULUS)),
            heights,
            np.zeros(shape, dtype=np.int64) if bodies is None else bodies,
            np.full(shape, self.cell**2),
            forces,
            np.full(forces.shape, np.nan) if depths is None else np.atleast_1d(depths),
        )
        return solve_contact(
            problem, np.zeros(shape), np.broadcast_to(softness, shape).copy(), **settings
        )


BENCH = Bench(61, 0.1e-3)


def paraboloid(x, y, radius=10e-3):
    return (x**2 + y**2) / (2 * radius)


def test_hertz_under_a_force() -> None:
    """Depth, radius, peak and profile of Hertz (1882), 48 cells across the contact."""
    radius, a = 10e-3, 2.4e-3
    force = 4 / 3 * MODULUS * a**3 / radius
    found = BENCH.solve(paraboloid(BENCH.x, BENCH.y), force)
    assert found.approach[0] == pytest.approx(a**2 / radius, rel=3e-4)
    assert found.pressure.sum() * BENCH.cell**2 == pytest.approx(force, rel=1e-9)
    r = np.hypot(BENCH.x, BENCH.y)
    hertz = 2 * MODULUS / np.pi / radius * np.sqrt(np.maximum(a**2 - r**2, 0.0))
    inside = r < 0.9 * a
    np.testing.assert_allclose(found.pressure[inside], hertz[inside], rtol=4e-3)
    touching = found.pressure > 0
    area = (touching.sum() - 0.1 * rim(touching).sum()) * BENCH.cell**2
    assert np.sqrt(area / np.pi) == pytest.approx(a, rel=4e-3)


def test_a_given_depth_and_its_force_are_one_contact() -> None:
    heights = paraboloid(BENCH.x - 0.3e-3, BENCH.y)
    deep = BENCH.solve(heights, np.nan, depths=0.5e-3)
    force = deep.pressure.sum() * BENCH.cell**2
    assert force == pytest.approx(4 / 3 * MODULUS * np.sqrt(10e-3) * 0.5e-3**1.5, rel=1e-3)
    pushed = BENCH.solve(heights, force)
    assert pushed.approach[0] == pytest.approx(0.5e-3, rel=1e-5)
    np.testing.assert_allclose(pushed.pressure, deep.pressure, atol=1e-3 * deep.pressure.max())


def covered(bench: Bench, radius: float, x0: float, y0: float, points: int = 21) -> np.ndarray:
    shift = ((np.arange(points) + 0.5) / points - 0.5) * bench.cell
    x = bench.x[..., None, None] - x0 + shift
    y = bench.y[..., None, None] - y0 + shift[:, None]
    return (np.hypot(x, y) < radius).mean(axis=(2, 3))


@pytest.mark.parametrize(("radius", "within"), [(0.63e-3, 1.5e-3), (2.4e-3, 4e-4)])
def test_a_flat_round_punch_wherever_its_middle_is(radius: float, within: float) -> None:
    """F = 2 E* a d; a staircase for the circle is 1.2 and 0.4 % of its radius too soft."""
    for x0, y0 in [(0.0, 0.0), (0.05e-3, 0.05e-3), (0.013e-3, 0.031e-3), (0.05e-3, 0.02e-3)]:
        grown = covered(BENCH, radius + 0.1 * BENCH.cell, x0, y0)
        heights = np.where(grown > 0, 0.0, np.inf)
        soft = BENCH.solve(heights, 1.0, softness=edge_softness(grown))
        assert 1 / (2 * MODULUS * radius * soft.approach[0]) == pytest.approx(1.0, rel=within)
    stairs = np.where(np.hypot(BENCH.x, BENCH.y) < radius, 0.0, np.inf)
    crude = BENCH.solve(stairs, 1.0)
    assert 1 / (2 * MODULUS * radius * crude.approach[0]) < 1 - 2 * within


def test_complementarity_is_certified_and_the_certificate_is_what_it_says() -> None:
    found = BENCH.solve(paraboloid(BENCH.x, BENCH.y), 1.0, tolerance=1e-8)
    assert found.residual <= 1e-8
    sunk = BENCH.indent(found.pressure)
    gap = sunk + paraboloid(BENCH.x, BENCH.y) - found.approach[0]
    np.testing.assert_allclose(found.gap, gap, atol=1e-15)
    touching = found.pressure > 0
    deepest = sunk[touching].max()
    assert found.pressure.min() == 0.0
    assert np.abs(gap[touching]).max() <= 1e-8 * deepest
    assert gap[~touching].min() >= -1e-8 * deepest


def test_forces_and_depths_together() -> None:
    """Each of two bodies keeps what it was given, and feels the other."""
    bodies = (BENCH.x > 0).astype(np.int64)
    heights = np.where(
        BENCH.x > 0, paraboloid(BENCH.x - 1.6e-3, BENCH.y), paraboloid(BENCH.x + 1.6e-3, BENCH.y)
    )
    found = BENCH.solve(heights, [0.3, np.nan], [np.nan, 0.6e-3], bodies)
    area = BENCH.cell**2
    assert found.pressure[bodies == 0].sum() * area == pytest.approx(0.3, rel=1e-9)
    assert found.approach[1] == 0.6e-3
    again = BENCH.solve(
        heights,
        [np.nan, found.pressure[bodies == 1].sum() * area],
        [found.approach[0], np.nan],
        bodies,
    )
    np.testing.assert_allclose(again.approach, found.approach, rtol=1e-5)
    alone = BENCH.solve(np.where(bodies == 0, heights, np.inf), 0.3)
    assert found.approach[0] > alone.approach[0] * 1.02


def test_a_body_that_the_skin_stays_clear_of_has_no_pressure() -> None:
    """The dent of a deep neighbour leaves nothing for a shallow body."""
    bodies = (BENCH.x > 1.9e-3).astype(np.int64)
    heights = np.where(
        bodies == 1,
        paraboloid(BENCH.x - 2.5e-3, BENCH.y, 1e-3),
        paraboloid(BENCH.x + 0.5e-3, BENCH.y),
    )
    found = BENCH.solve(heights, [np.nan, np.nan], [0.5e-3, 0.02e-3], bodies)
    assert found.pressure[bodies == 1].max() == 0.0
    assert found.residual <= 1e-6


def test_one_cell_carries_a_body() -> None:
    heights = np.full(BENCH.x.shape, np.inf)
    heights[30, 30] = 0.0
    found = BENCH.solve(heights, 0.1)
    assert found.pressure[30, 30] * BENCH.cell**2 == pytest.approx(0.1, rel=1e-12)
    own = inverse_distance_integrals(np.zeros((1, 2)), BENCH.cell).inverse[0] / (np.pi * MODULUS)
    assert found.approach[0] == pytest.approx(found.pressure[30, 30] * own, rel=1e-12)


def test_what_is_given_twice_or_not_at_all_is_named() -> None:
    heights = paraboloid(BENCH.x, BENCH.y)
    with pytest.raises(InputError, match=r"forces\[0\] is 1.0 and depths\[0\] is 0.001, expected"):
        BENCH.solve(heights, 1.0, depths=1e-3)
    with pytest.raises(InputError, match=r"forces\[0\] is nan and depths\[0\] is nan"):
        BENCH.solve(heights, np.nan)
    with pytest.raises(SkinfieldError, match=r"in 2 iterations, expected 1\.0e-06"):
        BENCH.solve(heights, 1.0, most_iterations=2)


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


E, COUNT, CELL = 100e3, 61, 0.1e-3
A = 2.4e-3
AXIS = (np.arange(COUNT) - (COUNT - 1) / 2) * CELL
X, Y = np.meshgrid(AXIS, AXIS)
R = np.hypot(X, Y)
INSIDE = R < A


@lru_cache(maxsize=4)
def slide(nu: float):
    """Tangential traction on cells of the half-space to displacement there (Cerruti)."""
    response = rectangle_displacement(lattice(COUNT - 1, COUNT - 1, CELL), CELL, E, nu)
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


def grown(points: int = 21):
    """Fraction of each cell within a circle whose radius is a tenth of a cell above A."""
    shift = ((np.arange(points) + 0.5) / points - 0.5) * CELL
    apart = np.hypot(X[..., None, None] + shift, Y[..., None, None] + shift[:, None])
    return (apart < A + 0.1 * CELL).mean(axis=(2, 3)).ravel()


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_a_round_contact_that_sticks(nu: float) -> None:
    """Johnson (1985), 7.40 and 7.43: q = T / (2 pi a sqrt(a² - r²)), d = T (2 - nu) / (8 G a)."""
    fraction, free = grown(), slide(nu)
    one = np.zeros((2, COUNT**2))
    one[0, COUNT**2 // 2] = 1.0
    own = free(one)[0, COUNT**2 // 2]
    rigid = replace(
        problem(nu, [0.3, -0.4], touching=fraction > 0),
        slide=lambda traction: free(traction) + own * edge_softness(fraction) * traction,
    )
    found = solve_stick(rigid)
    shear_modulus = E / (2 * (1 + nu))
    moved = np.array([0.3, -0.4]) * (2 - nu) / (8 * shear_modulus * A)
    np.testing.assert_allclose(found.translation[0], moved, rtol=2e-3)
    core = np.hypot(X, Y) < 0.85 * A
    exact = 0.5 / (2 * np.pi * A * np.sqrt(A**2 - R[core] ** 2))
    traction = found.traction.reshape(2, COUNT, COUNT)
    np.testing.assert_allclose(traction[0][core], 0.6 * exact, rtol=0.015)
    np.testing.assert_allclose(traction[1][core], -0.8 * exact, rtol=0.015)
    np.testing.assert_allclose(traction.sum((1, 2)) * CELL**2, [0.3, -0.4], rtol=1e-9)


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
    with pytest.raises(InputError, match=r"shear of indenters\[0\] is 1 N, expected less than"):
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
    np.testing.assert_allclose(turned, [0.01 * h, 0.03 * h], atol=1e-6)
    np.testing.assert_allclose(found.base_stress(places, 0.0), -base[:, 2] / 1e-3**2, atol=1e-6)


def test_a_wide_flat_end_shears_the_layer_as_a_block() -> None:
    """u = T h / (G area) for a contact much wider than the layer is thick."""
    thin = sf.Layer(0.5e-3, 100e3, 0.5)
    found = press(thin, [Cylinder(radius=10e-3, force=1.0, shear=(1.0, 0.0))], extent=30e-3)
    block = 0.5e-3 / (100e3 / 3 * np.pi * 10e-3**2)
    assert block * 0.9 < found.translation[0, 0] < block
    inner = np.hypot(*found.grid.plane.T) < 9e-3
    moved = (
        found.displacement[inner, 0]
        - press(thin, [Cylinder(radius=10e-3)], 30e-3).displacement[inner, 0]
    )
    np.testing.assert_allclose(moved, found.translation[0, 0], rtol=2e-3)


def test_shear_leaves_the_normal_contact_as_it_is_and_tips_the_gap() -> None:
    plain, sheared = (
        press(LAYER, [Sphere(radius=6e-3, shear=shear)], extent=20e-3)
        for shear in [(0.0, 0.0), (0.4, 0.0)]
    )
    np.testing.assert_array_equal(plain.pressure, sheared.pressure)
    np.testing.assert_array_equal(plain.gap, sheared.gap)
    places = [[-3e-3, 0.0], [3e-3, 0.0]]
    # By reflection: what shear adds to the two sides is opposite, in every quantity.
    for read in (plain.base_stress, plain.gap_change):
        before = read(places, 4e-3)
        after = getattr(sheared, read.__name__)(places, 4e-3)
        added = after - before
        assert added[0] == pytest.approx(-added[1], rel=1e-3)
        assert abs(added[0]) > 0.02 * np.abs(before).max()
    added = sheared.capacitance(places, 4e-3, order=1) - plain.capacitance(places, 4e-3, order=1)
    assert added[0] == pytest.approx(-added[1], rel=1e-3)


def test_a_limited_press_slips_in_part() -> None:
    found = press(LAYER, [BALL], extent=20e-3, friction=0.6)
    assert 0.2 < found.slipping_share < 0.8
    size = np.hypot(*found.traction[:, :2].T)
    assert (size <= 0.6 * found.pressure * (1 + 1e-6)).all()
    stuck = press(LAYER, [BALL], extent=20e-3)
    assert stuck.slipping_share == 0.0
    assert np.linalg.norm(found.translation) > np.linalg.norm(stuck.translation)
    with pytest.raises(InputError, match=r"it would slide; press harder or shear less"):
        press(LAYER, [BALL], extent=20e-3, friction=0.2)
    cover = sf.BondedLayer(inextensible_cover=True)
    with pytest.raises(InputError, match="the cover takes every shear"):
        press(LAYER, [BALL], extent=20e-3, mechanics=cover)
