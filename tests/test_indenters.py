"""Shapes of indenters against surfaces made of their sizes alone, however they lean."""

from dataclasses import replace

import numpy as np
import pytest
from indenter_bodies import filleted, hull, lying_rod, rounded_box_points, swept_ring, wedge_points

from skinfield.errors import InputError
from skinfield.simulate import (
    Bar,
    Cone,
    Cylinder,
    HeightMap,
    Indenter,
    Mesh,
    Ring,
    Rod,
    Sphere,
    Wedge,
)

MM = 1e-3
STEEP = np.radians(70.0)
X, Y = np.meshgrid(*[np.linspace(-9 * MM, 9 * MM, 61)] * 2)
SHAPES: dict[str, tuple[Indenter, tuple]] = {
    "flat cylinder": (Cylinder(radius=5 * MM), filleted(5 * MM, 0.0)),
    "rounded cylinder": (Cylinder(radius=5 * MM, edge_radius=MM), filleted(5 * MM, MM)),
    "sharp cone": (Cone(radius=5 * MM, half_angle=STEEP), filleted(5 * MM, 0.0, 1 / np.tan(STEEP))),
    "rounded cone": (Cone(radius=5 * MM, half_angle=STEEP, edge_radius=2 * MM),
        filleted(5 * MM, 2 * MM, 1 / np.tan(STEEP))),
    "bar": (Bar(length=12 * MM, width=4 * MM), hull(rounded_box_points(12 * MM, 4 * MM, 0.0))),
    "rounded bar": (Bar(length=12 * MM, width=4 * MM, edge_radius=MM),
        hull(rounded_box_points(12 * MM, 4 * MM, MM))),
    "rod": (Rod(radius=3 * MM, length=12 * MM), lying_rod(3 * MM, 12 * MM, 0.0)),
    "capsule": (Rod(radius=3 * MM, length=12 * MM, edge_radius=3 * MM),
        lying_rod(3 * MM, 12 * MM, 3 * MM)),
    "wedge": (Wedge(half_angle=STEEP, length=10 * MM, width=6 * MM),
        hull(wedge_points(STEEP, 10 * MM, 6 * MM))),
    "ring": (Ring(inner_radius=4 * MM, outer_radius=6 * MM), swept_ring(4 * MM, 6 * MM, 0.0)),
    "O-ring": (Ring(inner_radius=4 * MM, outer_radius=6 * MM, edge_radius=MM),
        swept_ring(4 * MM, 6 * MM, MM)),
}  # fmt: skip
POSES = {
    "upright": {},
    "about y": {"tilt": (0.0, np.radians(4.0))},
    "far, turned": {
        "tilt": (np.radians(-12.0), np.radians(17.0)),
        "rotation": 0.7, "position": (1.3 * MM, -0.4 * MM),
    },
}  # fmt: skip


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("name", SHAPES)
def test_a_leaning_body_is_that_of_its_triangles(name: str, pose: str) -> None:
    shape, (vertices, faces) = SHAPES[name]
    posed = replace(shape, **POSES[pose])
    other = Mesh(vertices=vertices, faces=faces, **POSES[pose])
    mine, want = posed.height(X, Y), other.height(X, Y)
    both = np.isfinite(mine) & np.isfinite(want) & (want < 4 * MM)
    assert both.sum() > 200
    # The triangles lie inside a round body, and inside a hole, by up to 0.6 um along its normal.
    off = want[both] - mine[both]
    assert off.min() > -2e-6
    assert np.quantile(off, 0.05) > -0.7e-6
    assert np.quantile(off, 0.95) < 1e-6
    # They end at the same rim, but for places that it passes through.
    differ = (mine < MM) != (want < MM)
    assert differ.mean() < 0.004


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("name", SHAPES)
def test_the_lowest_point_is_where_it_says_and_nothing_is_lower(name: str, pose: str) -> None:
    posed = replace(SHAPES[name][0], **POSES[pose])
    height = posed.height(X, Y)
    assert height.min() >= -1e-15
    if pose == "upright":
        assert posed.lowest == pytest.approx((0.0, 0.0), abs=1e-15)
        if not name.endswith("ing"):  # a ring has nothing in its middle
            assert posed.height(np.zeros(1), np.zeros(1)) == pytest.approx([0.0], abs=1e-15)
    else:
        x, y = posed.lowest
        assert posed.height(np.array([x]), np.array([y])) == pytest.approx([0.0], abs=1e-9)


def test_a_ball_is_round_however_it_leans() -> None:
    ball = Sphere(radius=6 * MM)
    leaning = replace(ball, tilt=(0.3, -0.2), rotation=1.0)
    np.testing.assert_array_equal(ball.height(X, Y), leaning.height(X, Y))
    assert ball.height(np.array([3 * MM]), np.zeros(1))[0] == pytest.approx(6 * MM - 27**0.5 * MM)


def test_triangles_are_found_over_every_place() -> None:
    """Against every triangle tried on every place."""
    rng = np.random.default_rng(0)
    vertices = rng.uniform(-1, 1, (60, 3)) * [4 * MM, 3 * MM, 2 * MM]
    faces = rng.integers(0, 60, (40, 3))
    x, y = rng.uniform(-5 * MM, 5 * MM, (2, 500))
    want = np.full(500, np.inf)
    for a, b, c in vertices[faces]:
        sides = np.column_stack([b - a, c - a])[:2]
        if abs(np.linalg.det(sides)) < 1e-20:
            continue
        p, q = np.linalg.solve(sides, np.stack([x - a[0], y - a[1]]))
        inside = (p >= 0) & (q >= 0) & (p + q <= 1)
        z = a[2] + p * (b - a)[2] + q * (c - a)[2] - vertices[faces, 2].min()
        want = np.where(inside, np.minimum(want, z), want)
    found = Mesh(vertices=vertices, faces=faces).height(x, y)
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(want))
    both = np.isfinite(want)
    assert 100 < both.sum() < 400
    assert found[both] == pytest.approx(want[both], abs=1e-15)


def test_a_height_map_is_linear_between_its_samples_and_ends_at_its_pixels() -> None:
    rows, columns = np.mgrid[0:5, 0:7]
    plane = 1e-4 * columns + 2e-4 * rows
    tilted = HeightMap(heights=plane, pixel=MM)
    x, y = np.meshgrid(np.linspace(-3, 3, 25) * MM, np.linspace(-2, 2, 17) * MM)
    assert tilted.height(x, y) == pytest.approx(3e-4 + 0.1 * x + 4e-4 + 0.2 * y, abs=1e-15)
    ends = tilted.height(np.array([3.49, 3.51]) * MM, np.zeros(2))
    assert np.isfinite(ends).tolist() == [True, False]
    assert tilted.lowest == pytest.approx((-3 * MM, -2 * MM))


def test_a_stroke_of_one_pixel_is_one_pixel_wide() -> None:
    heights = np.full((9, 9), np.nan)
    heights[:, 4] = 0.0
    for stamp in (HeightMap(heights=heights, pixel=MM),
                  HeightMap(heights=heights, pixel=MM, tilt=(0.0, 1e-6))):  # fmt: skip
        x = np.linspace(-1.5, 1.5, 301) * MM
        under = np.isfinite(stamp.height(x, np.zeros(301)))
        assert under.sum() == pytest.approx(101, abs=2)


def test_a_leaning_height_map_is_the_leaning_body() -> None:
    """A ball's map, leaning, is the ball; a plane's map is a plane."""
    axis = np.arange(-70, 71) * 0.05 * MM
    x, y = np.meshgrid(axis, axis)
    ball = Sphere(radius=6 * MM)
    lean = HeightMap(heights=ball.height(x, y), pixel=0.05 * MM, tilt=(0.1, -0.15))
    # It rolls about its lowest point, which carries its centre.
    centre = lean.own_from_body() @ [0.0, 0.0, 6 * MM]
    want = Sphere(radius=6 * MM, position=(centre[0], centre[1])).height(X, Y)
    near = np.hypot(X, Y) < 2 * MM
    assert lean.height(X, Y)[near] == pytest.approx(want[near], abs=2e-7)
    assert lean.lowest == pytest.approx(tuple(centre[:2]), abs=0.05 * MM)


def test_loads_are_a_force_or_a_depth() -> None:
    assert Sphere(radius=MM).force == 1.0
    assert Sphere(radius=MM).depth is None
    deep = Bar(length=MM, width=MM, depth=0.1 * MM, shear=(0.2, 0.0))
    assert (deep.force, deep.depth, deep.shear) == (None, 0.1 * MM, (0.2, 0.0))
    with pytest.raises(InputError, match=r"force is 1.0 and depth is 0.001, expected one of"):
        Sphere(radius=MM, force=1.0, depth=1e-3)


SQUARE = np.array([[0.0, 0, 0], [MM, 0, 0], [0, MM, 0]])


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Sphere(radius=0.0), "radius is 0.0, expected a finite number above 0"),
        (lambda: Sphere(radius=MM, force=-1.0), "force is -1.0"),
        (lambda: Sphere(radius=MM, depth=float("nan")), "depth is nan"),
        (lambda: Sphere(radius=MM, position=(1.0, 2.0, 3.0)), r"position has shape \(3,\)"),
        (lambda: Sphere(radius=MM, position=(np.nan, 0.0)), r"position\[0\] is nan"),
        (lambda: Sphere(radius=MM, rotation=np.inf), r"rotation\[0\] is inf"),
        (lambda: Cylinder(radius=MM, tilt=(1.5, 0.0)), "tilt is .* at most 1.4 rad"),
        (lambda: Cylinder(radius=MM, edge_radius=2 * MM), "edge_radius is 0.002"),
        (lambda: Cone(radius=MM, half_angle=np.pi / 2), "half_angle is 1.57"),
        (lambda: Ring(inner_radius=2 * MM, outer_radius=MM), "outer_radius is 0.001"),
        (lambda: Ring(inner_radius=MM, outer_radius=2 * MM, edge_radius=MM), "edge_radius"),
        (lambda: HeightMap(heights=np.full((2, 2), np.nan), pixel=MM), "none of them finite"),
        (lambda: HeightMap(heights=np.zeros(4), pixel=MM), r"heights has shape \(4,\)"),
        (lambda: Mesh(vertices=SQUARE, faces=[[0, 1, 3]]), "faces holds rows 0 to 3"),
        (lambda: Mesh(vertices=SQUARE, faces=np.empty((0, 3), int)), "faces holds 0 rows"),
        (lambda: Mesh(vertices=SQUARE, faces=[[0, 1.0, 2]]), "expected at least one row of"),
        (lambda: Mesh(vertices=SQUARE * np.nan, faces=[[0, 1, 2]]), "vertices.* is nan"),
    ],
)
def test_what_cannot_be_is_named(make, said: str) -> None:
    with pytest.raises(InputError, match=said):
        make()
