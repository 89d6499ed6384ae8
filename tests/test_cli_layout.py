"""`skinfield layout`, as a user types it."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, result_of, run

from skinfield.cli.options import skin_from_text
from skinfield.errors import FileError, InputError
from skinfield.files.layouts.load import load_layout, save_layout
from skinfield.skin import Patch, Skin, generators

DOME = generators.sphere_cap()


@pytest.fixture
def inward(tmp_path: Path) -> Path:
    path, rows = tmp_path / "dome.txt", np.hstack([DOME.positions, -DOME.normals])
    np.savetxt(path, rows, "%.9f", header="name dome\n[calibration]", comments="")
    return path


def test_lint_lists_findings_and_exits_with_one(inward: Path) -> None:
    done = invoke(["layout", "lint", str(inward)])
    assert done.exit_code == 1
    assert "inward-normals" in done.stdout
    assert "1 error" in done.stdout
    done = invoke(["layout", "lint", str(inward), "--json"])
    assert done.exit_code == 1
    first = json.loads(done.stdout)[0]
    assert set(first) == {"code", "severity", "message", "rows"}
    assert first["rows"] == list(range(len(DOME)))


def test_lint_of_a_clean_layout_exits_with_zero(tmp_path: Path) -> None:
    save_layout(DOME, tmp_path / "dome.toml")
    text = tmp_path / "dome.toml"
    assert run("layout", "lint", text) == f"{text}: nothing found\n"
    assert result_of("layout", "lint", text) == result_of("layout", "lint", "hexagon72") == []


def test_convert_says_what_is_repaired(inward: Path) -> None:
    said = run("layout", "convert", inward, inward.with_name("out.toml"))
    assert "note: dome: all normals point into the robot" in said
    read = load_layout(inward.with_name("out.toml"))[0]
    np.testing.assert_allclose(read.normals, DOME.normals, atol=1e-6)


def test_convert_takes_one_patch(tmp_path: Path) -> None:
    run("layout", "convert", "hexagon72", tmp_path / "a.toml")
    words = ["layout", "convert", tmp_path / "a.toml", tmp_path / "a.npz", "--patch", "hexagon72"]
    run(*words)
    assert [patch.name for patch in load_layout(tmp_path / "a.npz")] == ["hexagon72"]


def test_show_draws_flat_and_curved(tmp_path: Path) -> None:
    for text, name, start in (
        ("hexagon72", "a.png", b"\x89PNG"), ("sphere_cap", "a.svg", b"<?xml")
    ):  # fmt: skip
        assert f"wrote {tmp_path / name}" in run("layout", "show", text, "-o", tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(start)


@pytest.mark.parametrize("places", [[[0, 0, 0]], [[0, 0, 0], [0.01, 0, 0]], [[0, 0, 0]] * 4])
def test_show_draws_the_smallest_patches(tmp_path: Path, places) -> None:
    skin = Skin((Patch(places), Patch(DOME.positions, normals=DOME.normals, name="dome")))
    save_layout(skin, tmp_path / "a.toml")
    run("layout", "show", tmp_path / "a.toml", "-o", tmp_path / "a.png")


def test_info_and_generators() -> None:
    assert "72 taxels, 6 modules, 72 channels" in run("layout", "info", "hexagon72")
    assert "hexagon72\n" in run("layout", "generators")


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
