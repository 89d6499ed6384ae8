"""`skinfield design`: table, verdict, maps as picture, CSV and JSON; words for what is wrong."""

from pathlib import Path

import numpy as np
import pytest
from command_line import refused, run

import skinfield as sf
from skinfield.design import Places, SkinDesign, Touch, detectable_force
from skinfield.elastic import BaseStress
from skinfield.skin.generators import icub_triangle

STRESS = ("--quantity", "stress", "--noise", 400)


def test_one_layout_is_told_drawn_and_written(tmp_path: Path) -> None:
    picture, table = (tmp_path / name for name in ("d.png", "d.csv"))
    said = run(
        "design", "icub_triangle", "--thickness-mm", 4, "--modulus-kpa", 100, "--poisson", 0.49,
        *STRESS, "--force-n", 0.4, "--radius-mm", 1.5, "--pitch-mm", 1.5, "-o", picture,
        "--maps", table,
    )  # fmt: skip
    assert picture.read_bytes().startswith(b"\x89PNG")
    layer = sf.Layer(4e-3, 100e3, 0.49)
    design = SkinDesign(patch=icub_triangle(), layer=layer, quantity=BaseStress(), noise_std=400.0)
    places = Places.over(design.patch, 1.5e-3)
    want = detectable_force(design, Touch(0.4, 1.5e-3), places).unknown_place
    rows = np.genfromtxt(table, delimiter=",", names=True)
    np.testing.assert_allclose(rows["x_mm"], places.plane[:, 0] * 1e3, atol=1e-3)
    np.testing.assert_allclose(rows["smallest_force_found_N"], want, rtol=1e-4)
    assert "smallest force found" in said
    assert f"{np.sort(want)[-1]:.3g}" in said
    assert "A touch of 0.4 N is found" in said


def test_a_curved_patch_is_judged_in_its_plane(tmp_path: Path) -> None:
    said = run(
        "design", "cylinder:radius_mm=30,length_mm=25", *STRESS, "--thickness-mm", 4,
        "--pitch-mm", 6, "-o", tmp_path / "c.png",
    )  # fmt: skip
    assert "is found" in said


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["nothing"], "no such file, and no generator"),
        (["hexagon72", "-o", "a.txt"], "expected one of .png"),
        (["hexagon72", "-o", "nowhere/d.png"], "nowhere is no folder, expected one that is there"),
        (["hexagon72", "--maps", "a.txt"], "ends in .csv"),
        (["hexagon72", "--maps", "nowhere/a.csv"], "nowhere is no folder"),
        (["hexagon72", "--thickness-mm", "-1"], "--thickness-mm is -1.0, expected"),
        (["hexagon72", "--poisson", "0.7"], "--poisson is 0.7, expected"),
        (["hexagon72", "--noise", "0"], "--noise is 0.0, expected"),
        (["hexagon72", "--force-n", "nan"], "--force-n is nan, expected"),
        (["hexagon72", "--radius-mm", "0.01", "--linear"], "radius is"),
        (["hexagon72", "--pitch-mm", "-2"], "--pitch-mm is -2.0, expected"),
        (["hexagon72", "--pitch-mm", "0.001"], "expected at most 400000"),
        (["hexagon72", "--false-alarms", "2", "--linear"], "--false-alarms is 2.0, expected"),
        (["hexagon72", "--patch", "left"], "left"),
    ],
)
def test_what_is_wrong_is_said(words: list[str], part: str, tmp_path: Path) -> None:
    if "-o" not in words:
        words = [*words, "-o", str(tmp_path / "d.png")]
    assert part in refused("design", *words)
    assert not (tmp_path / "d.png").exists()
