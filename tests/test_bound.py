"""The Cramér-Rao bound against a closed form, an estimator that attains it, and earlier figures."""

from dataclasses import replace

import numpy as np
import pytest

from skinfield.elastic import Layer
from skinfield.errors import Floats, InputError
from skinfield.lab.bound import Family, bound_of, contact_bounds, contact_family
from skinfield.simulate import Bar, Sphere, press
from skinfield.simulate.pressing.press import is_round, readings_anywhere
from skinfield.skin.generators import hexagon72, icub_hexagon

LAYER = Layer(2e-3, 100e3, 0.5)
DEPTH, FORCE = 2e-3, 1.5


def point_force(points: Floats, force: float = FORCE, depth: float = DEPTH) -> Floats:
    """Boussinesq's normal stress at a depth below a point force on a half-space."""
    square = (points**2).sum(axis=1) + depth**2
    return np.asarray(3 * force * depth**3 / (2 * np.pi * square**2.5))


FAMILY = Family(
    base=point_force,
    lighter=lambda points: point_force(points, FORCE * 0.9),
    heavier=lambda points: point_force(points, FORCE * 1.1),
    force_step=0.1,
    smaller=lambda points: point_force(points, FORCE, DEPTH * np.exp(-0.01)),
    larger=lambda points: point_force(points, FORCE, DEPTH * np.exp(0.01)),
    size_step=0.01,
    shift=0.02e-3,
)


def by_hand(taxels: Floats) -> Floats:
    """Derivatives of `point_force` by x and y of the force, ln F and ln depth."""
    square = (taxels**2).sum(axis=1) + DEPTH**2
    value = point_force(taxels)
    moved = 5 * value / square
    return np.column_stack(
        [moved * taxels[:, 0], moved * taxels[:, 1], value, value * (3 - 5 * DEPTH**2 / square)]
    )


def test_derivatives_are_those_of_the_closed_form() -> None:
    taxels = np.random.default_rng(0).uniform(-8e-3, 8e-3, (40, 2))
    found, expected = FAMILY.jacobian(taxels), by_hand(taxels)
    for column, close in enumerate((2e-3, 2e-3, 4e-3, 2e-3)):  # ln is not linear over 10 %
        scale = np.abs(expected[:, column]).max()
        np.testing.assert_allclose(found[:, column], expected[:, column], atol=close * scale)


def test_bound_of_one_symmetric_cross_is_known_in_closed_form() -> None:
    # four taxels at distance r: sums of products of different derivatives cancel
    r, noise = 3e-3, 500.0
    cross = r * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    value = float(point_force(cross[:1])[0])
    slope = 5 * value * r / (r**2 + DEPTH**2)
    found = bound_of(by_hand(cross)[:, :3], noise)
    assert found.place == pytest.approx(noise / slope, rel=1e-9)  # hypot of two noise/(slope √2)
    assert found.force == pytest.approx(noise / (2 * value), rel=1e-9)
    [numeric] = contact_bounds(FAMILY, cross, [[0.0, 0.0]], noise, size_prior=1e-6)
    assert numeric.place == pytest.approx(found.place, rel=2e-3)
    assert numeric.force == pytest.approx(found.force, rel=5e-3)


def test_what_is_not_known_of_the_size_costs_precision() -> None:
    taxels = hexagon72().plane
    known = contact_bounds(FAMILY, taxels, [[2e-3, 3e-3]], 300.0, size_prior=1e-4)[0]
    prior = contact_bounds(FAMILY, taxels, [[2e-3, 3e-3]], 300.0, size_prior=0.3)[0]
    unknown = contact_bounds(FAMILY, taxels, [[2e-3, 3e-3]], 300.0)[0]
    assert known.force < prior.force < unknown.force
    assert known.place <= prior.place <= unknown.place
    assert unknown.covariance.shape == (4, 4)


def test_where_nothing_is_felt_the_bound_is_infinite() -> None:
    flat = Family(base=lambda p: 0 * p[:, 0], lighter=lambda p: 0 * p[:, 0],
                  heavier=lambda p: 0 * p[:, 0])  # fmt: skip
    [found] = contact_bounds(flat, np.zeros((5, 2)), [[0.0, 0.0]], 1.0)
    assert (found.place, found.force) == (np.inf, np.inf)
    [two] = contact_bounds(FAMILY, np.array([[1e-3, 0.0], [2e-3, 0.0]]), [[0.0, 0.0]], 1.0)
    assert two.place == np.inf  # fewer taxels than unknowns
    with pytest.raises(InputError, match="no reading is exact"):
        bound_of(np.eye(3), 0.0)


@pytest.fixture(scope="module")
def ball() -> Family:
    return contact_family(
        LAYER, Sphere(radius=6e-3, force=1.0), "stress", 4e-3, extent=12e-3, cell=0.5e-3
    )


def test_steps_of_the_differences_do_not_matter(ball: Family) -> None:
    places = np.random.default_rng(1).uniform(-12e-3, 12e-3, (50, 2))
    taxels = hexagon72().plane
    base = contact_bounds(ball, taxels, places, 400.0)
    for shift in (0.2e-3, 0.05e-3):
        again = contact_bounds(replace(ball, shift=shift), taxels, places, 400.0)
        for name in ("place", "force"):
            ratio = [getattr(a, name) / getattr(b, name) for a, b in zip(again, base, strict=True)]
            assert np.median(np.abs(np.array(ratio) - 1)) < 0.02, (shift, name)


def test_maximum_likelihood_attains_the_bound(ball: Family) -> None:
    from scipy.optimize import least_squares

    taxels, place, noise = icub_hexagon().plane, np.array([8e-3, 6e-3]), 100.0
    [bound] = contact_bounds(ball, taxels, place, noise)
    rng, found = np.random.default_rng(2), []

    def expected(x: Floats) -> Floats:  # the load moves readings as it does to first order
        seen = taxels - place - x[:2]
        by_load = (ball.heavier(seen) - ball.lighter(seen)) / (np.log(1.05) - np.log(0.95))
        return np.asarray(ball.base(seen) + x[2] * by_load)

    exact = ball.base(taxels - place)
    for _ in range(300):
        readings = exact + rng.normal(scale=noise, size=len(taxels))
        fit = least_squares(
            lambda x, readings=readings: (expected(x) - readings) / noise,
            np.zeros(3), x_scale=[1e-4, 1e-4, 1e-2],
        )  # fmt: skip
        found.append(fit.x)
    spread = np.std(found, axis=0)
    # of 300 draws a standard deviation is known to 4 %
    assert np.hypot(*spread[:2]) == pytest.approx(bound.place, rel=0.12)
    assert spread[2] == pytest.approx(bound.force, rel=0.12)


@pytest.mark.parametrize(
    ("quantity", "noise", "force", "place_mm", "part", "close"),
    [  # medians found before with another contact solver, over the hexagon inset by 5 mm
        ("stress", 1e3, 0.5, 2.3, 0.44, 0.2),
        ("stress", 1e3, 1.0, 0.73, 0.13, 0.2),
        ("stress", 380.0, 3.0, 0.051, 0.009, 0.2),
        ("capacitance", 0.005, 1.0, 0.63, 0.16, 0.2),
        # the least sure one: at 0.3 of ΔC/C₀ and more, how readings bend with the load decides
        ("capacitance", 0.002, 3.0, 0.056, 0.007, 0.65),
    ],
)
def test_bounds_are_those_found_before(
    quantity: str, noise: float, force: float, place_mm: float, part: float, close: float
) -> None:
    corners = np.radians(60.0 * np.arange(6) + 30.0)  # directions of the hexagon's sides
    outward = np.stack([np.cos(corners), np.sin(corners)])
    places = np.random.default_rng(0).uniform(-30e-3, 30e-3, (1500, 2))
    inside = (places @ outward < 30e-3 * np.sqrt(0.75) - 5e-3).all(axis=1)
    family = contact_family(
        LAYER, Sphere(radius=6e-3, force=force), quantity, 4e-3, extent=12e-3, cell=0.5e-3
    )
    bounds = contact_bounds(family, icub_hexagon().plane, places[inside][:400], noise)
    assert np.median([b.place for b in bounds]) * 1e3 == pytest.approx(place_mm, rel=0.2)
    assert np.median([b.force for b in bounds]) == pytest.approx(part, rel=close)


def test_radial_readings_are_those_of_the_press() -> None:
    solved = press(LAYER, [Sphere(radius=6e-3, force=1.0)], extent=12e-3, cell=0.5e-3)
    points = np.random.default_rng(3).uniform(-15e-3, 15e-3, (60, 2))
    assert is_round(solved)
    for quantity, close in (("stress", 3e-3), ("capacitance", 1e-2)):
        exact = solved.readings(points, 4e-3, quantity)
        quick = readings_anywhere(solved, 4e-3, quantity)(points)
        np.testing.assert_allclose(quick, exact, atol=close * np.abs(exact).max())
    bar = press(LAYER, [Bar(length=8e-3, width=2e-3)], extent=12e-3, cell=0.5e-3)
    assert not is_round(bar)
    exact = bar.readings(points, 4e-3, "stress")
    np.testing.assert_array_equal(readings_anywhere(bar, 4e-3, "stress")(points), exact)
