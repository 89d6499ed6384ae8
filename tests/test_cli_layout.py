"""`skinfield layout`, as a user types it."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import Done, invoke

from skinfield.cli.options import skin_from_text
from skinfield.errors import FileError, InputError
from skinfield.files.layouts.load import load_layout, save_layout
from skinfield.skin import Patch, Skin, generators

DOME = generators.sphere_cap()


def call(*words: object) -> Done:
    return invoke([str(word) for word in words])


@pytest.fixture
def inward(tmp_path: Path) -> Path:
    rows = np.hstack([DOME.positions, -DOME.normals])
    lines = [" ".join(f"{value:.9f}" for value in row) for row in rows]
    path = tmp_path / "dome.txt"
    path.write_text("\n".join(["name dome", "[calibration]", *lines]))
    return path


def test_lint_lists_findings_and_exits_with_one(inward: Path) -> None:
    result = call("layout", "lint", inward)
    assert result.exit_code == 1
    assert "inward-normals" in result.stdout
    assert "1 error" in result.stdout


def test_lint_as_json(inward: Path) -> None:
    result = call("layout", "lint", inward, "--json")
    assert result.exit_code == 1
    first = json.loads(result.stdout)[0]
    assert set(first) == {"code", "severity", "message", "rows"}
    assert first["rows"] == list(range(len(DOME)))


def test_lint_of_a_clean_layout_exits_with_zero(tmp_path: Path) -> None:
    save_layout(DOME, tmp_path / "dome.toml")
    text = tmp_path / "dome.toml"
    result = call("layout", "lint", text)
    assert (result.exit_code, result.stdout) == (0, f"{text}: nothing found\n")
    assert call("layout", "lint", text, "--json").stdout == "[]\n"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["lint", "no_such.txt"], "no_such.txt: No such file or directory, expected a layout"),
        (["show", "hexagon72", "-o", "a.gif"], "'.gif'"),
        (["show", "rectangular:rows=x", "-o", "a.png"], "rows"),
        (["convert", "hexagon72", "a.xyz"], "'.xyz'"),
        (["convert", "hexagon72", "a.pcd"], "no layout format that is written"),
        (["convert", "hexagon72", "a.npz", "--patch", "x"], "patch 'x' is not in 'hexagon72'"),
    ],
)
def test_errors_are_one_paragraph(words: list[str], message: str) -> None:
    result = call("layout", *words)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert message in result.stderr
    assert result.stderr.startswith("Error: ")
    assert result.stderr.count("\n") == 1
    assert "Traceback" not in result.stderr


def test_convert_says_what_is_repaired(inward: Path) -> None:
    result = call("layout", "convert", inward, inward.with_name("out.toml"))
    assert result.exit_code == 0
    assert "note: dome: all normals point into the robot" in result.stderr
    read = load_layout(inward.with_name("out.toml"))[0]
    np.testing.assert_allclose(read.normals, DOME.normals, atol=1e-6)


def test_convert_takes_one_patch(tmp_path: Path) -> None:
    assert call("layout", "convert", "hexagon72", tmp_path / "a.toml").exit_code == 0
    words = ["layout", "convert", tmp_path / "a.toml", tmp_path / "a.npz", "--patch", "hexagon72"]
    assert call(*words).exit_code == 0
    assert [patch.name for patch in load_layout(tmp_path / "a.npz")] == ["hexagon72"]


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_show_draws_flat_and_curved(tmp_path: Path, ending: str) -> None:
    for text in ("hexagon72", "sphere_cap"):
        out = tmp_path / f"{text}.{ending}"
        result = call("layout", "show", text, "-o", out)
        assert result.exit_code == 0
        assert f"wrote {out}" in result.stdout
        start = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[ending]
        assert out.read_bytes().startswith(start)


@pytest.mark.parametrize("places", [[[0, 0, 0]], [[0, 0, 0], [0.01, 0, 0]], [[0, 0, 0]] * 4])
def test_show_draws_the_smallest_patches(tmp_path: Path, places) -> None:
    skin = Skin((Patch(places), Patch(DOME.positions, normals=DOME.normals, name="dome")))
    save_layout(skin, tmp_path / "a.toml")
    assert call("layout", "show", tmp_path / "a.toml", "-o", tmp_path / "a.png").exit_code == 0


def test_info_and_generators() -> None:
    assert "72 taxels, 6 modules, 72 channels" in call("layout", "info", "hexagon72").stdout
    assert "hexagon72\n" in call("layout", "generators").stdout


def test_skin_from_text_prefers_files(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(skin_from_text("hexagon72")[0]) == 72
    save_layout(DOME, tmp_path / "a.toml")
    (tmp_path / "a.toml").rename(tmp_path / "hexagon72")
    assert len(skin_from_text("hexagon72")[0]) == len(DOME)
    assert len(skin_from_text("rectangular:rows=3,columns=4")[0]) == 12
    with pytest.raises(FileError, match=r"nix: no such file.*hexagon72"):
        skin_from_text("nix")
    with pytest.raises(InputError, match="row"):
        skin_from_text("rectangular:row=3")
