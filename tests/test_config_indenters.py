"""Indenters as settings: what the words make, and what is said of those that mean nothing."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from skinfield.errors import InputError
from skinfield.lab.scenarios import indenter_from_mapping
from skinfield.simulate import Mesh

MM = 1e-3


def test_settings_make_the_same_shapes(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.cylinder(radius=5.0, height=8.0).export(tmp_path / "punch.stl")
    Image.fromarray(np.full((4, 4), 255, np.uint8)).save(tmp_path / "logo.png")
    mesh = indenter_from_mapping(
        {"shape": "mesh", "file": "punch.stl", "down": [0, 0, 1], "depth_mm": 0.2, "x_mm": 3},
        folder=tmp_path,
    )
    assert isinstance(mesh, Mesh)
    assert (mesh.force, mesh.depth, mesh.position) == (None, 0.2 * MM, (3 * MM, 0.0))
    stamp = indenter_from_mapping(
        {"shape": "heightmap", "file": "logo.png", "pixel_mm": 0.5, "relief_mm": 1, "force_n": 2},
        folder=tmp_path,
    )
    assert (stamp.force, stamp.pixel) == (2.0, 0.5 * MM)  # type: ignore[attr-defined]
    keys = {"shape": "cone", "radius_mm": 6, "half_angle_deg": 75, "tilt_y_deg": 3, "y_mm": -2}
    cone = indenter_from_mapping(keys | {"shear_x_n": 0.1, "edge_radius_mm": 0.5})
    assert cone.half_angle == pytest.approx(np.radians(75))  # type: ignore[attr-defined]
    assert cone.tilt == pytest.approx((0.0, np.radians(3)))
    assert (cone.position, cone.shear, cone.force) == ((0.0, -2 * MM), (0.1, 0.0), 1.0)


@pytest.mark.parametrize(
    ("mapping", "said"),
    [
        ({}, "rig.press: shape is missing, expected one of sphere, cylinder"),
        ({"shape": "spere"}, "did you mean sphere"),
        ({"shape": "sphere"}, "radius_mm is missing, .*'sphere radius_mm=6 force_n=1'"),
        ({"shape": "sphere", "radius": 6}, "'radius' is not known, .*did you mean radius_mm"),
        ({"shape": "sphere", "radius_mm": "6"}, "radius_mm is '6', expected a finite number"),
        ({"shape": "sphere", "radius_mm": True}, "radius_mm is True, expected a finite number"),
        ({"shape": "sphere", "radius_mm": float("inf")}, "radius_mm is inf"),
        ({"shape": "sphere", "radius_mm": -6}, "rig.press: radius is -0.006"),
        ({"shape": "sphere", "radius_mm": 6, "force_n": 1, "depth_mm": 1}, "one of the two"),
        ({"shape": "mesh", "file": 3}, "file is 3, expected a text"),
        ({"shape": "mesh", "file": "a.stl", "down": [1]}, r"down is \[1\], expected a list"),
        ({"shape": "mesh", "file": "nowhere.stl"}, "nowhere.stl cannot be read"),
        ({"shape": "heightmap", "file": "a.png", "pixel_mm": 1, "invert": 1}, "invert is 1"),
    ],
)
def test_settings_that_mean_nothing_are_named(mapping: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        indenter_from_mapping(mapping, where="rig.press")
