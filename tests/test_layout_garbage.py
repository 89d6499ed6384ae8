"""Broken layout files are read or refused in words; nothing else may happen."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from skinfield.errors import FileError
from skinfield.files.layouts.load import FORMATS, load_layout, save_layout
from skinfield.skin import Skin, generators

FUZZ = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
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
    return head + b"".join(value.tobytes() for row in rows for value in row)


@pytest.mark.parametrize("form", ["ascii", "binary"])
def test_clouds_of_every_packing(tmp_path: Path, form: str) -> None:
    (tmp_path / "a.pcd").write_bytes(cloud(form))
    patch = load_layout(tmp_path / "a.pcd")[0]
    np.testing.assert_allclose(patch.positions, generators.icub_triangle().positions, atol=1e-9)
    np.testing.assert_array_equal(patch.normals, [[0, 0, 1]] * 12)
    (tmp_path / "a.pcd").write_bytes(cloud(form)[:-30])
    with pytest.raises(FileError, match=r"a\.pcd.*(cut short|line)"):
        load_layout(tmp_path / "a.pcd")
    (tmp_path / "a.pcd").write_bytes(cloud(form).replace(b"binary", b"binary_compressed"))
    if form == "binary":
        with pytest.raises(FileError, match=r"binary_compressed.*pcl_convert_pcd_ascii_binary"):
            load_layout(tmp_path / "a.pcd")


TEXTS = {
    "a.json": b'{"info": {"file_version": "2"}, "skin": {"n_taxels": 2, "parent_frames": [{"name": '
    b'"a", "tf_matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}], "taxels": [ {"id": 17, '
    b'"x": [0.0, 0, 0], "n": [0, 0, 1], "cut": 0}, {"id": 18, "x": [0.01, 0, 0]}]}}',
    "a.ini": b"cardid 3 2\nrobotPart foot\n[SENSORS]\ntriangle_10pad 2 10 20 90 5 1 0\n",
    "a.cache": b"2 2\n0 0 0 0 0 1 0 0 0.002 0 1 1\n0.005 0 0 0 0 1 0 0 0.002 0 1 0\n",
    "positions.txt": b"name foot\ntaxel2Repr ( 1 1 -1 )\n[calibration]\n0.01 0 0 0 0 1\n"
    b"0.02 0 0 0 0 1\n0 0 0 0 0 0\n",
    "tip.txt": b"TAXEL 1\n-1.0 -20.9\n0.0 0.0\n0.0 0.0\nTAXEL 2\n-0.5 -18.7\n0.8 3.15\n0.3 1\n",
}


@pytest.fixture(scope="module")
def valid(tmp_path_factory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("valid")
    files = dict(TEXTS)
    skin = Skin((generators.icub_triangle(),), name="a")
    for name in ("own.toml", "own.npz"):
        save_layout(skin, folder / name)
        files[name] = (folder / name).read_bytes()
    for kind in ("ascii", "binary"):
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


ODD = [b"nan", b"-1", b"1e400", b"99999999999999999999999999", b"", b"[[", b"null", b"\xff",
       b"0x10", b"1e18", b"1e300", b"-1e-300", b'"a"', b"{}", b"true", b"\n"]  # fmt: skip


@pytest.mark.parametrize("what", ["bytes", "words"])
@FUZZ
@given(data=st.data())
def test_changed_and_cut_files_are_read_or_refused(tmp_path: Path, valid, data, what) -> None:
    name = data.draw(st.sampled_from(sorted(valid)))
    parts = list(valid[name]) if what == "bytes" else valid[name].split(b" ")
    new = st.integers(0, 255) if what == "bytes" else st.sampled_from(ODD)
    for _ in range(data.draw(st.integers(0, 4))):
        parts[data.draw(st.integers(0, len(parts) - 1))] = data.draw(new)
    changed = bytes(parts) if what == "bytes" else b" ".join(parts)
    end = data.draw(st.one_of(st.just(len(changed)), st.integers(0, len(changed))))
    read_or_refuse(tmp_path / name, changed[:end])


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
