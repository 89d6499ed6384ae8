"""Presses of every shape against closed forms, symmetry, and the same body given in another way."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import skinfield as sf
from skinfield.simulate import (
    Bar,
    Cylinder,
    HeightMap,
    Indenter,
    Mesh,
    Press,
    Ring,
    Rod,
    Sphere,
    Wedge,
    press,
)
from skinfield.simulate.pressing.press import parts_of

MM = 1e-3
LAYER = sf.Layer(2 * MM, 100e3, 0.5)
BALL = Sphere(radius=6 * MM, force=1.0)
THICK = sf.Layer(300 * MM, 100e3, 0.5)
MODULUS = 100e3 / 0.75  # E / (1 - nu^2)


def centre_of(part: dict) -> list[float]:
    return [part["x_m"], part["y_m"]]


@cache
def ball_press() -> Press:
    return press(LAYER, [BALL], extent=16 * MM, cell=0.4 * MM)


def ball_as_map() -> HeightMap:
    axis = np.arange(-50, 51) * 0.1 * MM
    x, y = np.meshgrid(axis, axis)
    return HeightMap(heights=BALL.height(x, y), pixel=0.1 * MM, force=1.0)


def ball_as_mesh() -> Mesh:
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(subdivisions=5, radius=6 * MM)
    return Mesh(vertices=ball.vertices, faces=ball.faces, force=1.0)


@pytest.mark.parametrize("make", [ball_as_map, ball_as_mesh])
def test_a_ball_in_pixels_or_triangles_presses_like_a_ball(make) -> None:
    """A pixel of 0.1 mm sags by 0.1^2 / (8 * 6) mm along x and along y; a facet by about 2 um."""
    want, found = ball_press(), press(LAYER, [make()], extent=16 * MM, cell=0.4 * MM)
    assert found.approach == pytest.approx(want.approach, abs=3e-6)
    error = np.linalg.norm(found.pressure - want.pressure) / np.linalg.norm(want.pressure)
    assert error < 0.01
    assert found.contact_area == pytest.approx(want.contact_area, rel=0.02)


def test_a_leaning_cylinder_touches_at_its_rim_and_turns_the_skin_with_it() -> None:
    """About +y its +x side goes down: the pressure is there, and so is its moment."""
    lean = Cylinder(radius=5 * MM, tilt=(0.0, np.radians(4.0)), force=0.5)
    found = press(LAYER, [lean], extent=16 * MM, cell=0.4 * MM)
    centre = centre_of(parts_of(found)[0])
    assert 2.5 * MM < centre[0] < 5 * MM
    assert centre[1] == pytest.approx(0.0, abs=1e-6)
    assert found.moment[1] == pytest.approx(0.5 * centre[0], rel=1e-6)
    assert found.moment[[0, 2]] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert not found.contact[found.grid.plane[:, 0] < 0].any()
    other = press(LAYER, [replace(lean, tilt=(np.radians(4.0), 0.0))], 16 * MM, 0.4 * MM)
    assert centre_of(parts_of(other)[0]) == pytest.approx([0.0, -centre[0]], abs=2e-6)
    upright = press(LAYER, [replace(lean, tilt=(0.0, 0.0))], 16 * MM, 0.4 * MM)
    assert found.approach[0] > 4 * upright.approach[0]


@pytest.mark.parametrize("ratio", [0.3, 0.6])
def test_a_ring_on_a_deep_skin_is_smythes_ring(ratio: float) -> None:
    """F / (2 E* a d) is the capacitance of a charged ring over that of a disc (Smythe 1951)."""
    outer = 5 * MM
    ring = Ring(inner_radius=ratio * outer, outer_radius=outer, force=0.05)
    found = press(THICK, [ring], extent=12 * MM, cell=0.2 * MM)
    share = (2 / np.pi) * (
        np.arccos(ratio) + np.sqrt(1 - ratio**2) * np.arctanh(ratio)
    ) * (1 + 0.0143 / ratio * np.tan(1.28 * ratio) ** 3)  # fmt: skip
    assert 0.05 / (2 * MODULUS * outer * found.approach[0]) == pytest.approx(share, rel=0.03)


@pytest.mark.parametrize(
    "body",
    [
        Bar(length=10 * MM, width=3 * MM),
        Bar(length=10 * MM, width=3 * MM, edge_radius=0.5 * MM),
        Rod(radius=3 * MM, length=10 * MM),
        Wedge(half_angle=np.radians(70), length=10 * MM, width=6 * MM, edge_radius=0.3 * MM),
    ],
    ids=["bar", "rounded bar", "rod", "wedge"],
)
def test_a_long_body_is_symmetric_and_may_be_turned(body: Indenter) -> None:
    found = press(LAYER, [body], extent=18 * MM, cell=0.4 * MM)
    picture = found.pressure.reshape(found.grid.shape)
    peak = picture.max()
    assert picture == pytest.approx(picture[::-1], abs=1e-4 * peak)
    assert picture == pytest.approx(picture[:, ::-1], abs=1e-4 * peak)
    assert found.contact_area < 10 * 3.6e-6
    turned = press(LAYER, [replace(body, rotation=np.pi / 2)], 18 * MM, 0.4 * MM)  # type: ignore[type-var]
    assert turned.pressure.reshape(found.grid.shape) == pytest.approx(picture.T, abs=2e-3 * peak)


def test_parts_of_a_press_add_up_to_it() -> None:
    bodies = [
        replace(BALL, position=(-8 * MM, 1 * MM)),
        Ring(inner_radius=3 * MM, outer_radius=5 * MM, position=(7 * MM, 0), depth=0.1 * MM),
    ]
    found = press(LAYER, bodies, extent=40 * MM, cell=0.5 * MM)
    ball, ring = parts_of(found)
    assert ball["force_N"] == pytest.approx(1.0, rel=1e-5)
    assert ring["depth_m"] == pytest.approx(0.1 * MM)
    assert ball["force_N"] + ring["force_N"] == pytest.approx(found.force, rel=1e-9)
    assert ball["area_m2"] + ring["area_m2"] == pytest.approx(found.contact_area, rel=1e-9)
    assert ring["area_m2"] == pytest.approx(np.pi * (25 - 9) * 1e-6, rel=0.02)
    assert centre_of(ball) == pytest.approx([-8 * MM, 1 * MM], abs=0.05 * MM)
    assert max(ball["peak_Pa"], ring["peak_Pa"]) == found.pressure.max()
    left = found.grid.plane[:, 0] < 0
    each = found.pressure_by_body
    assert each.sum(axis=0) == pytest.approx(found.pressure, rel=1e-12)
    assert not each[1, left].any()
    assert not each[0, ~left].any()


@pytest.mark.parametrize("shear", [(0.0, 0.0), (0.3, -0.1)])
def test_the_map_of_base_stress_is_what_points_at_the_base_read(shear) -> None:
    found = press(LAYER, [replace(BALL, shear=shear)], extent=24 * MM, cell=0.4 * MM)
    stress = found.base_stress_below_cells
    some = np.random.default_rng(0).choice(np.flatnonzero(stress > 0.05 * stress.max()), 25)
    want = found.base_stress(found.grid.plane[some], 0.0)
    assert stress[some] == pytest.approx(want, abs=0.01 * stress.max())
    assert stress.sum() * found.grid.cell_area == pytest.approx(1.0, rel=0.01)
