"""`skinfield press`: words become bodies, results become a table, a picture and a file."""

from pathlib import Path

import numpy as np
import pytest
from command_line import refused, run

import skinfield as sf
from skinfield.errors import InputError
from skinfield.lab.scenarios.indenters import indenter_from_text, mapping_from_text
from skinfield.simulate import Cylinder, Sphere, press


def test_one_ball_is_told_drawn_and_written(tmp_path: Path) -> None:
    picture, fields = tmp_path / "press.png", tmp_path / "press.npz"
    said = run(
        "press", "--indenter", "sphere radius=6 x=6 y=-4 force=1", "--skin", "hexagon72",
        "--extent-mm", 30, "--modulus-kpa", 100, "--plot", picture, "-o", fields,
    )  # fmt: skip
    assert picture.read_bytes().startswith(b"\x89PNG")
    want = press(
        sf.Layer(2e-3, 100e3), [Sphere(radius=6e-3, position=(6e-3, -4e-3))], 30e-3, 0.4e-3
    )
    assert f"{want.approach[0] * 1e3:.3f}" in said
    assert f"{want.contact_area * 1e6:.1f} mm² touch" in said
    assert "moment 4.00, 6.00, 0.00 N mm" in said  # (6, -4) mm x -1 N along z
    found = np.load(fields)
    shape = want.grid.shape
    assert found["pressure"].shape == found["base_stress"].shape == shape
    assert found["displacement"].shape == found["traction"].shape == (*shape, 3)
    assert found["pressure"].ravel() == pytest.approx(want.pressure)
    assert found["pressure"].sum() * 0.4e-3**2 == pytest.approx(1.0, rel=1e-6)
    x, y = np.meshgrid(found["x"], found["y"])
    assert (found["pressure"] * x).sum() / found["pressure"].sum() == pytest.approx(6e-3, abs=2e-5)
    assert (found["pressure"] * y).sum() / found["pressure"].sum() == pytest.approx(-4e-3, abs=2e-5)
    assert found["depth"] == pytest.approx(want.approach)
    assert found["kind"].tolist() == ["ball"]
    patch = sf.layouts.hexagon72()
    capacitance = want.capacitance(patch.plane, patch.pad_diameter)
    assert found["pad_capacitance"] == pytest.approx(capacitance)
    assert f"to {capacitance.max() * 100:.2f} at taxel {capacitance.argmax()}" in said


def test_several_bodies_by_force_and_depth(tmp_path: Path) -> None:
    said = run(
        "press", "--indenter", "cylinder radius=3 edge_radius=0.3 x=-7 tilt_y=2 depth=0.2",
        "--indenter", "rod radius_mm=3 length_mm=8 x_mm=7 rotation_deg=90 force_n=0.8",
        "--extent-mm", 36, "--cell-mm", 0.6, "--mechanics", "covered-layer",
        "--plot", tmp_path / "a.svg",
    )  # fmt: skip
    assert "0.200" in said
    assert "0.800" in said
    assert "rod" in said


def test_shapes_come_from_files(tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.icosphere(subdivisions=4, radius=6.0).export(tmp_path / "ball.stl")
    grey = np.zeros((30, 30), np.uint8)
    grey[5:25, 12:18] = 255
    image.fromarray(grey).save(tmp_path / "bar.png")
    table = tmp_path / "both.npz"
    said = run(
        "press", "--indenter", f"mesh file='{tmp_path / 'ball.stl'}' x=-7 force=1",
        "--indenter", f"heightmap file='{tmp_path / 'bar.png'}' pixel=0.2 relief=2 x=7",
        "--modulus-kpa", 100, "--extent-mm", 30, "--plot", tmp_path / "b.png", "-o", table,
    )  # fmt: skip
    assert "height map" in said
    depth = np.load(table)["depth"]
    alone = press(sf.Layer(2e-3, 100e3), [Sphere(radius=6e-3)], 16e-3, 0.4e-3)
    assert depth[0] == pytest.approx(alone.approach[0], rel=0.02)  # and a little of the other


def test_units_may_be_left_out() -> None:
    short = indenter_from_text("cylinder radius=5 edge_radius=0.5 x=1 tilt_y=3 depth=0.3")
    long = indenter_from_text(
        "cylinder radius_mm=5 edge_radius_mm=0.5 x_mm=1 tilt_y_deg=3 depth_mm=0.3"
    )
    assert short == long
    assert isinstance(short, Cylinder)
    assert (short.radius, short.edge_radius, short.depth) == (5e-3, 0.5e-3, 0.3e-3)
    assert short.tilt == pytest.approx((0.0, np.radians(3)))
    words = "heightmap file='my logo.png' pixel=0.1 relief=1 invert=yes"
    assert mapping_from_text(words) == {
        "shape": "heightmap", "file": "my logo.png", "pixel_mm": 0.1, "relief_mm": 1.0,
        "invert": True,
    }  # fmt: skip
    assert mapping_from_text("mesh file=a.stl down=0,0,1")["down"] == [0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "shape is '', expected one of sphere, cylinder"),
        ("sphere radius", "'radius', expected key=value"),
        ("sphere radius=", "'radius=', expected key=value"),
        ("sphere radius=six", "radius_mm is 'six', expected a finite number"),
        ("sphere radius=6 radius_mm=6", "'radius_mm=6', expected key=value, each key once"),
        ("sphere radius=6 frce=1", "did you mean force_n"),
        ("sphere 'radius=6", "No closing quotation"),
        ("mesh file=a.stl down=0,0", "down is .*, expected a list of finite numbers"),
        ("mesh file=a.stl down=up", "down is 'up', expected a list"),
        ("heightmap file=a.png pixel=1 invert=perhaps", "expected true or false"),
    ],
)
def test_words_that_mean_nothing_are_named(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        indenter_from_text(text)


def test_the_command_says_what_is_wrong_before_it_works(tmp_path: Path) -> None:
    for words, said in (
        (("--indenter", "mesh file=nowhere.stl"), "nowhere.stl cannot be read"),
        (("-o", "press.txt"), "ends in .npz"),
        (("--plot", "press.txt"), ".png"),
        (("--skin", "nowhere"), "no such file, and no generator"),
        (("--indenter", "sphere radius=6 force=90"), "sinks"),
        (("--indenter", "bar length=80 width=4"), "raise extent"),
    ):
        plot = () if "--plot" in words else ("--plot", tmp_path / "p.png")
        assert said in refused("press", *words, *plot)
    assert not list(tmp_path.iterdir())


def test_help_shows_every_shape() -> None:
    from skinfield.lab.scenarios.indenters import SHAPES

    said = run("press", "--help")
    for name, shape in SHAPES.items():
        line = next(line for line in said.splitlines() if line.strip().startswith(f"{name} "))
        for key in f"{shape.required} {shape.optional}".split():
            assert key.removesuffix("_mm").removesuffix("_deg") in line
