"""The normal contact solver on the half-space, whose contacts have closed forms."""

from functools import lru_cache

import numpy as np
import pytest

from skinfield.errors import InputError, SkinfieldError
from skinfield.mechanics import LatticeConvolution
from skinfield.mechanics.contact import (
    ContactProblem,
    edge_softness,
    rim,
    solve_contact,
)
from skinfield.mechanics.lattice import interpolation, lattice, mirrored
from skinfield.mechanics.love import inverse_distance_integrals

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


def test_the_cone_of_love_and_sneddon() -> None:
    """F = (2/pi) E* d² cot(slope), contact radius (2/pi) d cot(slope); its tip is singular."""
    slope, depth = 0.2, 0.6e-3
    heights = np.tan(slope) * np.hypot(BENCH.x, BENCH.y)
    found = BENCH.solve(heights, np.nan, depths=depth)
    force = 2 / np.pi * MODULUS * depth**2 / np.tan(slope)
    assert found.pressure.sum() * BENCH.cell**2 == pytest.approx(force, rel=4e-3)
    a = 2 / np.pi * depth / np.tan(slope)
    assert np.sqrt((found.pressure > 0).sum() / np.pi) * BENCH.cell == pytest.approx(a, rel=0.015)


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
