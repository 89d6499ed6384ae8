"""Layout files: read, written, and read again; broken ones are told so."""

import json
import re
import struct
from pathlib import Path

import numpy as np
import pytest
from any_bytes import ANYTHING, damaged
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from skinfield.errors import FileError, InputError
from skinfield.files.layouts.load import FORMATS, load_layout, save_layout
from skinfield.skin import Patch, Skin, generators


def pose_of(rng: np.random.Generator) -> np.ndarray:
    """Homogeneous, of a few hundred millimetres."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    pose[:3, 3] = rng.uniform(-0.3, 0.3, 3)
    return pose


@st.composite
def patches(draw, name: str = "patch") -> Patch:
    """Clean patches: a jittered array bent over a sphere of any radius, anywhere."""
    rows, columns = draw(st.integers(2, 6)), draw(st.integers(2, 6))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    plane = np.stack(np.meshgrid(np.arange(rows), np.arange(columns)), -1).reshape(-1, 2) * 6e-3
    plane = plane + rng.uniform(-2e-4, 2e-4, plane.shape) - plane.mean(axis=0)
    radius = draw(st.sampled_from([0.03, 0.08, 1e6]))  # m
    height = np.sqrt(radius**2 - (plane**2).sum(axis=1))
    normals = np.column_stack([plane, height]) / radius
    turn, count = pose_of(rng), len(plane)
    uid = rng.choice(2**40, count, replace=False).astype(np.uint64) * np.uint64(16) + np.uint64(3)
    return Patch(
        np.column_stack([plane, height - radius]) @ turn[:3, :3].T + turn[:3, 3],
        pad_diameter=draw(st.floats(0.5e-3, 5e-3)),
        normals=normals @ turn[:3, :3].T,
        module=rng.integers(0, 5, count),
        uid=uid,
        channel=rng.permutation(count),
        name=name,
        link=draw(st.sampled_from(["", "r_foot", 'forearm "3" \\ µ'])),
        link_from_patch=pose_of(rng),
    )


@pytest.mark.parametrize("name", ["a.toml", "a.npz"])
@settings(max_examples=25)
@given(first=patches(), second=patches("p2"), notes=st.lists(st.text(max_size=20), max_size=2))
def test_own_formats_keep_every_bit(tmp_path_factory, name, first, second, notes) -> None:
    skin = Skin((first, second), name="two of them", notes=tuple(n.strip("\0") for n in notes))
    path = tmp_path_factory.getbasetemp() / name
    save_layout(skin, path)
    again = load_layout(path)
    assert (again.name, again.notes) == (skin.name, skin.notes)
    for made, read in zip(skin, again, strict=True):
        np.testing.assert_array_equal(read.positions, made.positions)
        assert np.abs(read.normals - made.normals).max() < 1e-15  # made unit length once more
        np.testing.assert_allclose(read.link_from_patch, made.link_from_patch, atol=1e-12)
        for key in ("name", "link", "n_channels"):
            assert getattr(read, key) == getattr(made, key)
        for key in ("module", "uid", "channel"):
            np.testing.assert_array_equal(getattr(read, key), getattr(made, key))
        assert read.pad_diameter == pytest.approx(made.pad_diameter, abs=2e-9)


# -- what a format means ---------------------------------------------------------------------------


def test_content_decides_not_the_extension(tmp_path: Path) -> None:
    save_layout(generators.icub_triangle(), tmp_path / "a.npz")
    (tmp_path / "a.npz").rename(tmp_path / "a.toml")
    assert len(load_layout(tmp_path / "a.toml")[0]) == 12
    for ending in ("ini", "json", "txt", "xyz"):  # formats of others are only read
        with pytest.raises(InputError, match=rf"'\.{ending}' is of no .*expected \.toml or"):
            save_layout(generators.icub_triangle(), tmp_path / f"a.{ending}")


def test_unknown_content_lists_what_was_tried(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"a\.txt") as caught:
        read(tmp_path, "a.txt", "x y z\n1 2 3\n")
    assert all(form.NAME in str(caught.value) for form in FORMATS)
    with pytest.raises(FileError, match=r"no_such.*No such file"):
        load_layout(tmp_path / "no_such.txt")


HAND = "skinfield_layout = 1\n[[patch]]\n"


def test_a_layout_by_hand(tmp_path: Path) -> None:
    skin = read(
        tmp_path, "a.toml",
        f"{HAND}positions_mm = [[0, 0], [4.75, 0], [0, 4.75]]\n"
        "link_from_patch_translation_mm = [10, 0, 2.5]\n",
    )  # fmt: skip
    assert (skin.name, skin[0].name, skin.notes) == ("a", "patch 0", ())
    assert skin[0].positions[1, 0] == 4.75e-3
    np.testing.assert_array_equal(skin[0].normals, [[0, 0, 1]] * 3)
    np.testing.assert_array_equal(skin[0].link_from_patch[:3, 3], [0.01, 0, 0.0025])


CYSKIN_TAXELS = [
    {"id": uid, "x": [x, y, 0.0], "n": [0, 0, -1], "type": "pressure", "cut": int(uid == 0x335)}
    for uid, x, y in [
        (0x501, 0.0, 0.0), (0x502, 0.007, 0.0), (0x334, 0.0, 0.007),
        (0x330, 0.002, 0.002), (0x335, 0.007, 0.007), (0, 0.009, 0.007),  # these are none
    ]
]  # fmt: skip
TURNED = [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0.1, 0.2, 0.3, 1]  # column by column
POSE = {"name": "forearm", "tf_matrix": TURNED}


def cyskin(**tree) -> str:
    return json.dumps({"info": {"file_version": "2", "name": "arm"}, **tree})


def read(folder: Path, name: str, text: str) -> Skin:
    (folder / name).write_bytes(text.encode())
    return load_layout(folder / name)


@pytest.mark.parametrize("as_list", [False, True])
def test_cyskin_modules_poses_maps_and_what_is_no_taxel(tmp_path: Path, as_list: bool) -> None:
    body = {"parent_frames": [POSE], "taxels": CYSKIN_TAXELS}
    skin = read(tmp_path, "a.json", cyskin(skin=[body] if as_list else body))
    patch = skin[0]
    assert patch.uid.tolist() == [0x501, 0x502, 0x334]
    assert patch.module.tolist() == [1, 1, 0]
    assert patch.link == "forearm"
    np.testing.assert_array_equal(patch.normals, [[0, 0, -1]] * 3)
    point = patch.link_from_patch @ [1, 0, 0, 1]  # +x of the patch is +y of the link
    np.testing.assert_allclose(point, [0.1, 1.2, 0.3, 1], atol=1e-12)
    assert sum("left out" in note for note in skin.notes) == 3
    flat = [{"id": t["id"], "x": t["x"][:2], "type": "pressure"} for t in CYSKIN_TAXELS[:3]]
    body = {"name": "map", "type": "isomap", "taxels": flat}
    skin = read(tmp_path, "a.json", cyskin(tactile_maps=[body, body] if as_list else body))
    assert [p.name for p in skin] == (["map_0", "map_1"] if as_list else ["map"])
    np.testing.assert_array_equal(skin[0].normals, [[0, 0, 1]] * 3)


def positions(rows: list[str], taxel2repr: str) -> str:
    head = ["name r_foot", f"taxel2Repr ({taxel2repr})", "[calibration]"]
    return "\r\n".join([*head, *rows, "", ""])


FOOT = ["0.00 0 0.01 1 0 0", "0 0 0 0 0 0", "0.01 0 0.01 1 0 0", "0.00 0.01 0.01 1 0 0"]


def test_icub_channels_are_rows(tmp_path: Path) -> None:
    rows = ["0 0 0 0 0 0"] * 12 + FOOT
    text = positions(rows, " ".join(["-1"] * 12 + ["12", "-1", "12", "-2"]))
    patch = read(tmp_path, "a.txt", text)[0]
    assert (patch.channel.tolist(), patch.n_channels) == ([12, 14], 16)
    assert patch.module.tolist() == [1, 1]
    assert (patch.name, patch.link) == ("r_foot", "r_foot")


DRAWING = "cardid 3 2\nrobotPart foot\n[SENSORS]\n{}\n"


def test_drawings_place_boards_and_pads(tmp_path: Path) -> None:
    patch = read(tmp_path, "a.ini", DRAWING.format("triangle 2 10 20 90 5 0 0"))[0]
    assert patch.n_channels == 384
    assert patch.channel.tolist() == list(range(24, 36))
    # the apex of the template, pad 9 at (0, 11.547), turns by 90 degrees to (-11.547, 0)
    np.testing.assert_allclose(patch.positions[9], [10e-3 - 11.547e-3, 20e-3, 0], atol=1e-6)
    backwards = read(tmp_path, "a.ini", DRAWING.format("triangle 2 10 20 90 5 0 1"))[0]
    assert backwards.channel.tolist() == list(range(35, 23, -1))


def test_a_mirrored_board_faces_away(tmp_path: Path) -> None:
    """Seen along its normal, a real board is never mirrored: pads keep their sense of rotation."""
    senses = []
    for mirror in (0, 1):
        drawing = DRAWING.format(f"triangle_10pad 0 5 6 30 5 {mirror}")
        patch = read(tmp_path, "a.ini", drawing)[0]
        corner = {int(c): p for c, p in zip(patch.channel, patch.positions, strict=True)}
        turn = np.cross(corner[9] - corner[1], corner[5] - corner[1]) @ patch.normals[0]
        senses.append(np.sign(turn))
        assert len(patch) == 10
    assert senses == [1.0, 1.0]


TIP = "TAXEL 1\n-1.0\t-20.9\n0.0\t0.0\n0.0\t0.0\n\nTAXEL 2\n-0.5 -18.7\n0.8 3.15\n0.3 1\n"


def test_fingertip_counts_backwards(tmp_path: Path) -> None:
    patch = read(tmp_path, "tip.txt", TIP)[0]
    assert patch.channel.tolist() == [1, 0]
    np.testing.assert_allclose(patch.positions[0], [-20.9e-3, 0, 0])


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.toml", "skinfield_layout = 2\n", "skinfield_layout is 2, expected 1"),
        ("a.toml", "skinfield_layout = 1\n", "missing required field `patch`"),
        ("a.toml", f"{HAND}positions = [[1, 2]]\n", "unknown field `positions` - at `patch\\[0"),
        ("a.toml", f"{HAND}positions_mm = [[1, 2]]\nuids = [1]\n", "field `uids`"),
        ("a.toml", f"{HAND}positions_mm = [[1, 2], [3]]\n", r"_mm\[1\]`"),
        ("a.toml", f"{HAND}positions_mm = [[1, nan]]\n", "finite numbers"),
        ("a.toml", f"{HAND}positions_mm = [[1, 2]]\nuid = [1.5]\n", "`int . str`, got"),
        ("a.toml", "skinfield_layout = 1\nname = \n", "line 2"),
        ("a.json", cyskin(skin={"taxels": [*CYSKIN_TAXELS, {"id": 17, "x": [1, "a", 0]}]}),
         r"a\.json: .*skin\.taxels\[6\]\.x"),
        ("a.json", cyskin(skin={"parent_frames": [{"name": "a", "tf_matrix": [1.0] * 16}],
                                "taxels": CYSKIN_TAXELS}), "tf_matrix.*expected a rigid motion"),
        ("a.txt", positions([*FOOT, "0.1 0.2 x 0 0 1"], "0"),
         r"a\.txt, line 8: found 'x', expected six numbers"),
        ("a.txt", positions([*FOOT, "0.1 0.2 0"], "0"), r"line 8: found '0\.1 0\.2 0'"),
        ("a.txt", positions(FOOT, "-1 -1 -1 -1"), "no row has a pose"),
        ("a.ini", DRAWING.format("triangle 2 10 20"), r"line 4.*type number x y th"),
        ("a.ini", DRAWING.format("fingertip 2 10 20 0 5 0"), "no triangle"),
        ("tip.txt", TIP[:-4], r"tip\.txt, line 9"),
    ],
)  # fmt: skip
def test_faults_are_named_with_their_place(
    tmp_path: Path, name: str, text: str, message: str
) -> None:
    with pytest.raises(FileError, match=message):
        read(tmp_path, name, text)


# -- a folder as one skin --------------------------------------------------------------------------


def test_patches_of_all_files_in_the_order_of_their_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    foot, arm = generators.hexagon72(), generators.rectangular(rows=3, columns=4)
    save_layout(Skin((foot,)), tmp_path / "b.toml")
    save_layout(Skin((arm,)), tmp_path / "a.npz")
    (tmp_path / "notes.md").write_text("Where the parts are mounted.")
    (tmp_path / ".hidden").write_text("?")
    (tmp_path / "deeper").mkdir()
    skin = load_layout(tmp_path)
    assert skin.name == tmp_path.name
    monkeypatch.chdir(tmp_path)
    assert load_layout(".").name == tmp_path.name
    assert [len(patch) for patch in skin] == [12, 72]
    assert [patch.name for patch in skin] == [arm.name, foot.name]
    np.testing.assert_allclose(skin[1].positions, foot.positions, atol=1e-9)
    assert [note for note in skin.notes if "notes.md" in note and "left out" in note]
    assert not [note for note in skin.notes if "hidden" in note]


def test_patches_of_one_name_are_told_apart_by_their_files(tmp_path: Path) -> None:
    for name in ("left.toml", "right.toml", "right.npz"):
        save_layout(generators.hexagon72(), tmp_path / name)
    names = [patch.name for patch in load_layout(tmp_path)]
    assert len(set(names)) == 3
    assert names[0].startswith("left/")
    (tmp_path / "right.npz").unlink()
    single = generators.hexagon72().name
    assert [p.name for p in load_layout(tmp_path)] == [f"left/{single}", f"right/{single}"]


def test_folders_without_layouts_and_broken_files_are_refused(tmp_path: Path) -> None:
    for name, text, why in (
        (".hidden", "", "none of its 0 files is a layout.*directory"),
        ("readme.txt", "nothing", "none of its 1 file is a layout"),
        ("positions.txt", "[calibration]\n1 2 3\n", r"positions\.txt, line 2"),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(FileError, match=why):
            load_layout(tmp_path)


# -- broken files are read or refused in words ----------------------------------------------------

CLOUD = """# .PCD v0.7 - Point Cloud Data file format
VERSION 0.7
FIELDS x y z rgb normal_x normal_y normal_z
SIZE 4 4 4 4 4 4 4
TYPE F F F U F F F
COUNT 1 1 1 2 1 1 1
WIDTH {points}
HEIGHT 1
POINTS {points}
DATA {form}
"""


def cloud(form: str) -> bytes:
    patch = generators.icub_triangle()
    rgb = np.arange(24, dtype="<u4").reshape(12, 2)
    places, normals = patch.positions.astype("<f4"), patch.normals.astype("<f4")
    rows = [[*places[i], *rgb[i], *normals[i]] for i in range(12)]
    head = CLOUD.format(points=12, form=form).encode()
    if form == "ascii":
        return head + "\n".join(" ".join(map(str, row)) for row in rows).encode()
    if form == "binary":
        return head + b"".join(value.tobytes() for row in rows for value in row)
    fields = b"".join(a.tobytes() for a in (*places.T, rgb, *normals.T))
    packed = lzf(fields)
    return head + struct.pack("<II", len(packed), len(fields)) + packed


def lzf(data: bytes) -> bytes:
    """Literals, and zeros as copies of the zero before them: a short length has one byte."""
    out = b""
    for part in re.findall(rb"\0{4,200}|(?:(?!\0{4}).){1,32}", data, re.DOTALL):
        more = len(part) - 3  # than two bytes that are copied
        if part[:4] != bytes(4):
            out += bytes([len(part) - 1]) + part
        else:
            out += b"\0\0" + (bytes([more << 5, 0]) if more < 7 else bytes([7 << 5, more - 7, 0]))
    return out


@pytest.mark.parametrize("form", ["ascii", "binary", "binary_compressed"])
def test_clouds_of_every_packing(tmp_path: Path, form: str) -> None:
    (tmp_path / "a.pcd").write_bytes(cloud(form))
    patch = load_layout(tmp_path / "a.pcd")[0]
    np.testing.assert_allclose(patch.positions, generators.icub_triangle().positions, atol=1e-9)
    np.testing.assert_array_equal(patch.normals, [[0, 0, 1]] * 12)
    (tmp_path / "a.pcd").write_bytes(cloud(form)[:-30])
    with pytest.raises(FileError, match=r"a\.pcd.*(cut short|line)"):
        load_layout(tmp_path / "a.pcd")


@pytest.fixture(scope="module")
def valid(tmp_path_factory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("valid")
    texts = {
        "a.json": cyskin(skin={"taxels": CYSKIN_TAXELS, "parent_frames": [POSE]}),
        "a.ini": DRAWING.format("triangle_10pad 2 10 20 90 5 1 0"),
        "a.cache": "2 2\n0 0 0 0 0 1 0 0 0.002 0 1 1\n0.005 0 0 0 0 1 0 0 0.002 0 1 0\n",
        "positions.txt": positions(FOOT, "1 1 -1 1"),
        "tip.txt": TIP,
    }
    files = {name: text.encode() for name, text in texts.items()}
    skin = Skin((generators.icub_triangle(),), name="a")
    for name in ("own.toml", "own.npz"):
        save_layout(skin, folder / name)
        files[name] = (folder / name).read_bytes()
    for kind in ("ascii", "binary", "binary_compressed"):
        files[f"{kind}.pcd"] = cloud(kind)
    return files


def read_or_refuse(path: Path, data: bytes) -> None:
    """Read a skin, or be refused in words that name the file: nothing else may happen."""
    path.write_bytes(data)
    parsers = [load_layout, *(form.parse for form in FORMATS if form.sniff(data))]
    for parse in parsers:
        try:
            with np.errstate(all="raise", under="ignore"):
                parse(path)
        except FileError as error:
            said = str(error)
            assert path.name in said
            assert len(said) < 2000


STARTS = [
    b"", b"skinfield_layout = 1\n", b"PK\x03\x04skinfield_layout", b'{"skin":', b"[calibration]\n",
    b"[SENSORS]\n", b"VERSION 0.7\nFIELDS x y z\nDATA ascii\n", b"3 3\n0 0 0 0 0 1 0 0 1 0 0\n",
    b"TAXEL 1\n",
]  # fmt: skip
RANDOM = st.tuples(st.sampled_from(STARTS), ANYTHING).map(b"".join)


@settings(max_examples=180)
@given(data=st.data())
def test_damaged_and_random_files_are_read_or_refused(tmp_path_factory, valid, data) -> None:
    name = data.draw(st.sampled_from(sorted(valid)))
    content = data.draw(damaged(valid[name]) | RANDOM)
    read_or_refuse(tmp_path_factory.getbasetemp() / name, content)


def test_deep_nesting_is_refused(tmp_path: Path) -> None:
    read_or_refuse(tmp_path / "a.json", b'{"skin":' + b"[" * 100_000)
    read_or_refuse(tmp_path / "a.toml", b"skinfield_layout = " + b"[" * 100_000)
