"""Presses with known truth: forces, complementarity, and what the readings say."""

from dataclasses import replace

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.simulate import Bar, Cylinder, Ring, Sphere, press, press_ladder
from skinfield.simulate.pressing.press import readings_around

LAYER = sf.Layer(2e-3, 100e3, 0.5)
BALL = Sphere(radius=6e-3, force=1.0)


@pytest.mark.parametrize(
    ("radius", "force", "depth", "edge"),
    [(6e-3, 0.2, 0.2953, 1.71), (6e-3, 0.5, 0.4554, 2.20), (6e-3, 1.0, 0.6258, 2.63),
     (6e-3, 1.8, 0.8155, 3.03), (6e-3, 3.0, 1.0242, 3.43), (3e-3, 0.2, 0.427, 1.37),
     (3e-3, 0.5, 0.678, 1.76), (3e-3, 1.0, 0.956, 2.09), (3e-3, 1.8, 1.280, 2.38)],
)  # fmt: skip
def test_balls_by_the_default_cells_have_the_finite_elements_depth_and_radius(
    radius: float, force: float, depth: float, edge: float
) -> None:
    """Published finite elements and another contact solver, in mm, to their printed digits."""
    found = press(LAYER, [Sphere(radius=radius, force=force)], extent=20e-3)
    assert found.approach[0] * 1e3 == pytest.approx(depth, abs=6e-4)
    assert np.sqrt(found.contact_area / np.pi) * 1e3 == pytest.approx(edge, abs=0.015)
    given = press(LAYER, [Sphere(radius=radius, depth=found.approach[0])], extent=20e-3)
    assert given.force == pytest.approx(force, rel=2e-4)
    assert found.residual <= 1e-6


@pytest.mark.parametrize(
    ("radius", "depth", "middle", "cells"),
    [(1.5e-3, 0.930e-3, 81.5e3, 6), (6e-3, 0.03442e-3, 9.43e3, 24)],
)
def test_flat_ends_by_the_default_cells_are_not_staircases(
    radius: float, depth: float, middle: float, cells: int
) -> None:
    """Depth by finite elements and by the table of Hayes; base stress of the former."""
    for x in (0.0, 0.13e-3, 0.25e-3):
        found = press(LAYER, [Cylinder(radius=radius, position=(x, 0.1e-3))], extent=20e-3)
        assert found.approach[0] == pytest.approx(depth, rel=1e-3)
        assert found.base_stress([[x, 0.1e-3]], 0.0)[0] == pytest.approx(middle, rel=5e-3)
        assert found.contact_area == pytest.approx(np.pi * radius**2, rel=1e-3)
        assert abs(np.count_nonzero(found.contact) / (np.pi * (cells / 2) ** 2) - 1) < 0.2


def test_where_the_cells_lie_makes_no_difference() -> None:
    """The layer has no border: readings move with the press, to a part of a cell."""
    places = np.stack(np.meshgrid([-6e-3, -2e-3, 1e-3, 4e-3], [0.0, 3e-3]), -1).reshape(-1, 2)
    for body in (Sphere, Cylinder):
        still = press(LAYER, [body(radius=3e-3, force=0.5)], extent=20e-3)
        for shift in (np.array([0.17e-3, -0.21e-3]), np.array([2.0e-3, 0.25e-3])):
            ball = body(radius=3e-3, force=0.5, position=tuple(shift))
            moved = press(LAYER, [ball], extent=20e-3)
            # The electric field's mesh is as fine as h / 10, which is seen.
            for quantity, rough, least in (
                ("stress", 1e-3, 2.0),
                ("gap", 1e-3, 2e-5),
                ("capacitance", 4e-3, 1e-4),
            ):
                np.testing.assert_allclose(
                    moved.readings(places + shift, 4e-3, quantity),
                    still.readings(places, 4e-3, quantity),
                    rtol=rough,
                    atol=least,
                )


def test_windows_far_apart_feel_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two windows, joined by interpolation, against one window over both, which is exact."""
    balls = [Sphere(radius=6e-3, force=2.0), Sphere(radius=2e-3, force=0.1, position=(8e-3, 1e-3))]
    two = press(LAYER, balls, extent=30e-3)
    monkeypatch.setattr("skinfield.simulate.pressing.windows.APART", 100)
    one = press(LAYER, balls, extent=30e-3)
    assert len(two.touches) == 2
    assert len(one.touches) == 1
    np.testing.assert_allclose(two.approach, one.approach, rtol=4e-4)
    np.testing.assert_allclose(two.displacement, one.displacement, atol=3e-7)
    alone = press(LAYER, balls[1:], extent=30e-3)
    assert abs(two.approach[1] - alone.approach[0]) > 0.01 * alone.approach[0]


def test_what_is_read_at_points_is_what_the_fields_show() -> None:
    """Sums over sources against convolutions and, where it touches, against the ball itself."""
    found = press(LAYER, [BALL], extent=24e-3)
    some = np.arange(0, len(found.grid), 13)
    plane = found.grid.plane[some]
    read, r = found.gap_change(plane, 0.0), np.hypot(*plane.T)
    np.testing.assert_allclose(read[r > 4e-3], -found.displacement[some, 2][r > 4e-3], atol=2e-8)
    under = r < 2.4e-3
    assert under.sum() > 4
    sunk = found.approach[0] - BALL.height(*plane[under].T)
    np.testing.assert_allclose(read[under], sunk, atol=1e-7)


def test_the_table_around_a_pushed_ball_has_what_single_pads_read() -> None:
    quantity = "capacitance"
    ball = Sphere(radius=6e-3, force=1.0, shear=(0.3, 0.4))
    found = press(LAYER, [ball], extent=14e-3, friction=0.5)
    table = readings_around(found, 4e-3, quantity)
    points = np.random.default_rng(3).uniform(-8e-3, 8e-3, (60, 2))
    exact = found.readings(points, 4e-3, quantity)
    assert np.abs(table(points) - exact).max() < 2e-3 * np.abs(exact).max()
    flat, dipole, *rest = np.abs(table.harmonics).max(axis=1)
    assert 0.05 * flat < dipole < 0.3 * flat
    assert max(rest) < 0.25 * dipole
    with pytest.raises(InputError, match="expected one upright sphere"):
        readings_around(press(LAYER, [replace(ball, position=(1e-3, 0.0))], 16e-3), 4e-3, quantity)


def test_forces_and_moments_of_each_body() -> None:
    """A moment is the force's at the place of a round body; of a tilted end at its low side."""
    bodies = [
        Sphere(radius=6e-3, force=1.0, position=(-7e-3, 2e-3), shear=(0.1, 0.2)),
        Cylinder(radius=2e-3, force=0.4, position=(6e-3, 0.0), tilt=(0.0, 0.05)),
    ]
    found = press(LAYER, bodies, extent=30e-3)
    np.testing.assert_allclose(found.forces, [1.0, 0.4], rtol=1e-9)
    np.testing.assert_allclose(
        (found.traction * found.grid.cell_area).sum(axis=0), [0.1, 0.2, -1.4], rtol=1e-6
    )
    about = [2e-3 * -1.0, 7e-3 * -1.0, -7e-3 * 0.2 - 2e-3 * 0.1]
    assert found.moments[0, 2] == pytest.approx(about[2], rel=1e-4)
    # The bulge ahead takes more of the load of the one that is sheared.
    ahead = (found.moments[0, [1, 0]] - np.array(about)[[1, 0]]) * [1.0, -1.0]
    assert ahead[1] == pytest.approx(2.0 * ahead[0], rel=0.05)
    assert 0.05e-3 < np.hypot(*ahead) < 0.12e-3
    np.testing.assert_allclose(found.moment, found.moments.sum(axis=0))
    lowest = bodies[1].lowest[0] - 6e-3
    centre = found.moments[1, 1] / 0.4 - 6e-3
    assert 0.1 < centre / lowest < 1.0


def test_the_gap_is_open_around_touch_and_infinite_beyond_the_body() -> None:
    found = press(LAYER, [Cylinder(radius=3e-3, edge_radius=1e-3)], extent=14e-3)
    r = np.hypot(*found.grid.plane.T)
    assert np.isinf(found.gap[r > 3e-3]).all()
    assert np.isfinite(found.gap[r < 3e-3]).all()
    assert np.abs(found.gap[found.contact]).max() < 2e-6 * found.approach[0]
    assert found.gap[(r < 3e-3) & ~found.contact].min() > 0.0
    assert (found.pressure[found.contact] > 0).all()


def test_outlines_enclose_the_area_and_holes_run_backwards() -> None:
    ring = Ring(inner_radius=2e-3, outer_radius=4e-3, force=0.5, position=(1e-3, 0.0))
    found = press(LAYER, [ring], extent=14e-3)
    outer, hole = sorted(found.outline, key=len, reverse=True)
    np.testing.assert_array_equal(outer[0], outer[-1])
    inside = [np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) / 2 for x, y in (outer.T, hole.T)]
    assert inside == [
        pytest.approx(np.pi * 16e-6, rel=3e-3),
        pytest.approx(-np.pi * 4e-6, rel=6e-3),
    ]
    assert found.contact_area == pytest.approx(np.pi * 12e-6, rel=1e-3)
    assert np.hypot(*(outer - [1e-3, 0.0]).T) == pytest.approx(4e-3, rel=0.01)


def test_a_ladder_is_a_press_for_each_force() -> None:
    forces = [0.8, 0.1, 2.0]
    ladder = press_ladder(LAYER, Sphere(radius=6e-3, depth=1e-3), forces, extent=20e-3)
    for force, found in zip(forces, ladder, strict=True):
        alone = press(LAYER, [Sphere(radius=6e-3, force=force)], extent=20e-3)
        assert found.force == pytest.approx(force, rel=1e-9)
        assert found.indenters[0].force == force
        assert found.approach[0] == pytest.approx(alone.approach[0], rel=3e-4)
    with pytest.raises(InputError, match=r"force is -1.0, expected a finite number above 0"):
        press_ladder(LAYER, BALL, [1.0, -1.0])


def test_bodies_much_smaller_than_a_cell_are_seen() -> None:
    """Hertz below a tenth of a cell, and a punch; their own windows are that much finer."""
    modulus, radius = 100e3 / 0.75, 0.4e-3
    found = press(LAYER, [Sphere(radius=radius, force=1e-5, position=(0.3e-3, 0.0))], 10e-3)
    edge = (0.75 * 1e-5 * radius / modulus) ** (1 / 3)
    assert edge < 0.1 * 0.5e-3
    # The base, 70 contact radii below, lifts the ball by 2 %.
    assert found.approach[0] == pytest.approx(edge**2 / radius, rel=0.03)
    assert np.sqrt(found.contact_area / np.pi) == pytest.approx(edge, rel=0.03)
    punch = press(LAYER, [Cylinder(radius=0.1e-3, force=1e-4, position=(0.3e-3, 0.0))], 10e-3)
    assert punch.approach[0] == pytest.approx(1e-4 / (2 * modulus * 0.1e-3), rel=0.08)


def test_a_body_at_a_depth_that_the_skin_stays_clear_of_does_not_touch() -> None:
    """The dent of a heavy neighbour in foam is deeper than the light one reaches."""
    light = Sphere(radius=1e-3, depth=1e-6, position=(6.9e-3, 0))
    found = press(sf.Layer(2e-3, 100e3, 0.0), [Cylinder(radius=6e-3, depth=0.4e-3), light], 24e-3)
    assert found.forces[0] > 1.0
    assert found.approach[1] == 1e-6
    assert found.forces[1] == 0.0
    assert found.gap[~found.contact].min() > 0.0
    assert found.residual <= 1e-6


def test_bodies_over_each_other_meet_the_skin_with_the_lower_one() -> None:
    """Two balls half in each other: wherever both are above the skin, it stays below both."""
    balls = [Sphere(radius=6e-3), Sphere(radius=3e-3, position=(2e-3, 0.0), force=0.3)]
    found = press(LAYER, balls, extent=20e-3)
    np.testing.assert_allclose(found.forces, [1.0, 0.3], rtol=1e-9)
    assert found.gap.min() > -1e-3 * found.approach.max()


def test_a_ring_thinner_than_a_tenth_of_a_cell_is_followed_around() -> None:
    ring = Ring(inner_radius=4e-3, outer_radius=4.1e-3, force=0.2)
    found = press(LAYER, [ring], extent=14e-3, cell=0.5e-3)
    assert found.contact_area == pytest.approx(np.pi * (4.1**2 - 4.0**2) * 1e-6, rel=0.02)
    assert len(found.outline) == 2
    np.testing.assert_allclose(found.moment, 0.0, atol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_any_bodies_anywhere_are_certified(seed: int) -> None:
    """Tilted, tiny, wide, by force and by depth at once: forces kept, nothing overlaps."""
    rng = np.random.default_rng(seed)
    bodies: list[sf.simulate.Indenter] = []
    for x, y in [(-9e-3, -8e-3), (8e-3, -9e-3), (0.5e-3, 9e-3)]:
        load = {"force": 10 ** rng.uniform(-4, 0)} if rng.random() < 0.6 else {"depth": 0.2e-3}
        size = 10 ** rng.uniform(-3.5, -2.3)
        pose = {"position": (x, y), "rotation": rng.uniform(0, 6)}
        pose["tilt"] = tuple(rng.normal(0, 0.05, 2))
        kind = rng.integers(3)
        if kind == 0:
            bodies.append(Sphere(radius=size, **pose, **load))
        elif kind == 1:
            bodies.append(Cylinder(radius=size, edge_radius=0.2 * size, **pose, **load))
        else:
            bodies.append(Ring(inner_radius=0.6 * size, outer_radius=size, **pose, **load))
    stiff = sf.Layer(2e-3, 600e3, [0.0, 0.3, 0.45, 0.5][seed])
    found = press(stiff, bodies, extent=36e-3, cell=[0.5e-3, 1e-3][seed % 2])
    for body, force, depth in zip(bodies, found.forces, found.approach, strict=True):
        assert force == pytest.approx(body.force or force, rel=1e-6)
        assert depth == pytest.approx(body.depth or depth, rel=1e-12)
    assert found.residual <= 1e-6
    assert found.pressure.min() >= 0.0
    assert found.gap.min() > -1e-3 * found.approach.max()


def test_a_touch_that_the_square_of_skin_cuts_off_is_refused() -> None:
    bodies = [Sphere(radius=2e-3, position=(-8e-3, 8e-3), force=0.1), Bar(length=40e-3, width=4e-3)]
    with pytest.raises(InputError, match=r"indenters\[1\] touches the border of the 0.024 m"):
        press(LAYER, bodies, extent=24e-3)


@pytest.mark.parametrize("read", ["base_stress", "base_traction", "gap_change", "capacitance"])
@pytest.mark.parametrize(
    ("positions", "pad", "message"),
    [
        (np.zeros((0, 2)), 4e-3, "positions is empty"),
        (np.zeros((3, 4)), 4e-3, r"shape \(3, 4\), expected \(any, 2\)"),
        ([0.0, 0.0], 4e-3, r"shape \(2,\), expected \(any, 2\)"),
        ([[0.0, np.nan]], 4e-3, r"positions\[\(0, 1\)\] is nan"),
        ([[0.0, 0.0]], -4e-3, "pad_diameter is -0.004"),
        ([[0.0, 0.0]], np.nan, "pad_diameter is nan"),
        ([[0.0, 0.0]], 4, "pad_diameter is 4"),
    ],
)
def test_pads_that_cannot_be_are_named(press_of_a_ball, read, positions, pad, message) -> None:
    with pytest.raises(InputError, match=message):
        getattr(press_of_a_ball, read)(positions, pad)


@pytest.fixture(scope="module")
def press_of_a_ball():
    return press(LAYER, [BALL], extent=16e-3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Sphere(radius=-1), "radius is -1, expected a finite number above 0"),
        (lambda: press(LAYER, [Sphere(radius=1e-3, position=(1.0, 0.0))]),
         r"indenters\[0\] at \(1.0, 0.0\) m covers no cell"),
        (lambda: press(LAYER, []), "indenters is empty"),
        (lambda: press(LAYER, BALL), r"indenters is Sphere\(.*expected a list"),
        (lambda: press(LAYER, [BALL, BALL]), r"indenters\[1\] at \(0.0, 0.0\) m lies behind"),
        (lambda: press(LAYER, [Sphere(radius=6e-3, force=100.0)], 30e-3, 1e-3),
         r"indenters\[0\] with 100 N sinks .* into a layer of 2 mm"),
        (lambda: press(LAYER, [Sphere(radius=6e-3, depth=3e-3)], 20e-3),
         r"indenters\[0\] with 0.003 m sinks 3 mm"),
        (lambda: press(LAYER, [Sphere(radius=6e-3, position=(14e-3, 0.0))], 20e-3, 1e-3),
         r"touches the border of the 0\.02 m of skin"),
        (lambda: press(LAYER, [BALL], cell=1e-6),
         r"cell is 1e-06 m, expected 3e-05 m or more in an extent"),
    ],
)  # fmt: skip
def test_what_cannot_be_pressed_is_named(make, message) -> None:
    with pytest.raises(InputError, match=message):
        make()


def test_what_cannot_be_read_is_named(press_of_a_ball) -> None:
    with pytest.raises(InputError, match="quantity is 'volts', expected one of"):
        press_of_a_ball.readings([[0, 0]], 4e-3, "volts")
    with pytest.raises(InputError, match=r"positions lie up to 25 m .* give positions in metres"):
        press_of_a_ball.capacitance([[25.0, -10.0], [0.0, 0.0]], 4e-3)
    for order in (0, 4, 2.5):
        with pytest.raises(InputError, match=r"order is .*, expected 1, 2 or 3 terms"):
            press_of_a_ball.capacitance([[0.0, 0.0]], 4e-3, order)
