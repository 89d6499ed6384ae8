"""Shapes from files: what was written is found again, and garbage is said to be garbage."""

import io
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from any_bytes import damaged
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from skinfield.errors import FileError, InputError
from skinfield.simulate import Cylinder
from skinfield.simulate.indenters.shape_files import load_height_map, load_mesh

trimesh = pytest.importorskip("trimesh")
MM = 1e-3
X, Y = np.meshgrid(*[np.linspace(-7 * MM, 7 * MM, 41)] * 2)


def put(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def bytes_of(mesh, kind: str) -> bytes:
    found = mesh.export(file_type=kind)
    return found if isinstance(found, bytes) else found.encode()


def png(array: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(array).save(buffer, "PNG")
    return buffer.getvalue()


def load(path: Path):
    """A shape of a file of any kind."""
    if path.suffix in (".stl", ".obj", ".ply", ".txt"):
        return load_mesh(path)
    return load_height_map(path, MM, MM if path.suffix == ".png" else None)


PUNCH = trimesh.creation.cylinder(radius=5.0, height=8.0, sections=256)


@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "obj", "ply"])
def test_a_mesh_in_millimetres_is_the_body(tmp_path: Path, kind: str) -> None:
    path = put(tmp_path / f"punch.{kind[:3]}", bytes_of(PUNCH, kind))
    found = load_mesh(path)
    assert np.ptp(found.vertices, axis=0) == pytest.approx([10 * MM, 10 * MM, 8 * MM], rel=1e-6)
    assert found.vertices[:, 2].min() == 0.0
    want = Cylinder(radius=5 * MM).height(X, Y)
    inside = np.hypot(X, Y) < 4.99 * MM
    assert found.height(X, Y)[inside] == pytest.approx(want[inside], abs=1e-9)
    assert np.isinf(found.height(X, Y)[np.hypot(X, Y) > 5 * MM]).all()


def test_a_mesh_is_turned_with_its_face_down(tmp_path: Path) -> None:
    """A cone: its point is on one end, so that each direction shows another face."""
    cone = trimesh.creation.cone(radius=5.0, height=4.0, sections=64)  # its point at +z
    path = put(tmp_path / "cone.stl", bytes_of(cone, "stl"))
    upright = load_mesh(path)
    turned, lying, askew = (load_mesh(path, down=d) for d in ((0, 0, 1), (1, 0, 0), (1, 2, 3)))
    np.testing.assert_allclose(upright.height(X, Y)[20, [20, 26]], 0.0, atol=1e-9)
    assert turned.height(X, Y)[20, 20] == pytest.approx(0.0, abs=1e-9)
    assert turned.height(X, Y)[20, 26] == pytest.approx(0.8 * X[20, 26], rel=0.01)
    assert np.ptp(lying.vertices, axis=0) == pytest.approx([4 * MM, 10 * MM, 10 * MM], rel=0.01)
    a, b = (
        np.linalg.norm(m.vertices[m.faces[:, 0]] - m.vertices[m.faces[:, 1]], axis=1)
        for m in (askew, upright)
    )
    assert a == pytest.approx(b, rel=1e-9)  # a rotation keeps lengths


def test_a_mesh_of_another_unit_is_noticed(tmp_path: Path) -> None:
    metres = put(tmp_path / "m.stl", bytes_of(PUNCH.copy().apply_scale(1e-3), "stl"))
    with pytest.raises(FileError, match=r"measures 1e-05 m .* is it in metres"):
        load_mesh(metres)
    assert np.ptp(load_mesh(metres, unit=1.0).vertices[:, 2]) == pytest.approx(8 * MM)
    with pytest.raises(FileError, match=r"measures 10 m .* is it in millimetres"):
        load_mesh(put(tmp_path / "mm.stl", bytes_of(PUNCH, "stl")), unit=1.0)


def test_triangles_without_area_are_of_no_matter(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 4 0 3\nf 1 2 3\nf 1 1 1\nf 1 2 2\nf 1 2 4\n"
    found = load_mesh(put(tmp_path / "a.obj", text.encode()))
    place = np.array([-1 * MM]), np.array([-1 * MM])
    assert found.height(*place) == pytest.approx([0.0], abs=1e-12)


def test_a_picture_is_upright_and_white_touches_first(tmp_path: Path) -> None:
    grey = np.zeros((4, 6), dtype=np.uint8)
    grey[0] = 255  # the top row
    grey[3, 0] = 51
    found = load_height_map(put(tmp_path / "a.png", png(grey)), 0.5 * MM, 2 * MM)
    assert found.lowest == pytest.approx((0.0, 0.75 * MM))
    x, y = np.array([-1.25 * MM]), np.array([-0.75 * MM])
    assert found.height(x, y) == pytest.approx([0.8 * 2 * MM])
    assert found.height(-x, y) == pytest.approx([2 * MM])
    stamp = load_height_map(tmp_path / "a.png", 0.5 * MM, 2 * MM, invert=True)
    assert stamp.height(-x, y) == pytest.approx([0.0])
    assert stamp.height(x, y) == pytest.approx([0.4 * MM])


@pytest.mark.parametrize(("kind", "colours"), [("u1", 1), ("u2", 1), ("u1", 3)])
def test_every_depth_of_picture_is_read(tmp_path: Path, kind: str, colours: int) -> None:
    most = np.iinfo(kind).max
    grey = np.linspace(0, most, 64).astype(kind).reshape(8, 8)
    array = grey if colours == 1 else np.dstack([grey] * colours)
    found = load_height_map(put(tmp_path / "a.png", png(array)), MM, MM)
    want = np.linspace(1, 0, 64).reshape(8, 8)[::-1] * MM
    assert found.heights == pytest.approx(want, abs=1.01 / most * MM)


def test_where_a_picture_is_transparent_there_is_no_body(tmp_path: Path) -> None:
    colours = np.full((5, 5, 4), 255, dtype=np.uint8)
    colours[:, :2, 3] = 0
    found = load_height_map(put(tmp_path / "a.png", png(colours)), MM, MM)
    assert np.isinf(found.heights[:, :2]).all()
    assert (found.heights[:, 2:] == 0).all()


@pytest.mark.parametrize("name", ["a.npy", "a.csv"])
def test_tables_hold_millimetres(tmp_path: Path, name: str) -> None:
    heights = np.array([[0.0, 1.0, 2.0], [0.5, np.nan, 2.5]])
    path = put(tmp_path / name, npy(heights))
    if name == "a.csv":
        np.savetxt(path, heights, delimiter=",")
    found = load_height_map(path, MM)
    want = np.where(np.isnan(heights), np.inf, heights * MM)
    np.testing.assert_allclose(found.heights, want, rtol=1e-12)
    with pytest.raises(InputError, match="relief or invert is given"):
        load_height_map(path, MM, MM)


VAST_PLY = (
    b"ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\n"
    b"property float z\nend_header\n1 2 3\n"
)


def vast_png() -> bytes:
    """A picture that claims 60000 x 60000 pixels."""
    content = bytearray(png(np.zeros((9, 9), np.uint8)))
    content[16:24] = struct.pack(">II", 60000, 60000)
    content[29:33] = struct.pack(">I", zlib.crc32(content[12:29]))
    return bytes(content)


def vast_npy() -> bytes:
    """An array that claims 10^12 numbers."""
    head = io.BytesIO()
    shape = {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**6)}
    np.lib.format.write_array_header_1_0(head, shape)
    return head.getvalue() + bytes(1000)


def npy(array: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


BALL = trimesh.creation.icosphere(0, radius=5.0)
SEEDS = {
    **{f".{kind}": bytes_of(BALL, kind) for kind in ("stl", "obj", "ply")},
    ".png": png(np.arange(64, dtype=np.uint8).reshape(8, 8)),
    ".npy": npy(np.arange(64.0).reshape(8, 8)),
    ".csv": b"1,2,3\n4,5,6\n",
}


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.txt", b"", "another ending"),
        ("a.stl", b"", "no triangles|cannot be read"),
        ("a.stl", bytes_of(PUNCH, "stl")[:500], "is cut off: it says .* triangles"),
        ("a.stl", b"solid x\nfacet normal 0 0 1\nouter", "no triangles|cannot be read"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "corner|cannot be read"),
        ("a.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite|corner"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "cannot be read|no triangles"),
        ("a.ply", VAST_PLY, "a.ply"),
        ("a.png", vast_png(), "cannot be read|samples"),
        ("a.png", png(np.zeros((2001, 2001), np.uint8)), "holds 4004001 samples"),
        ("a.png", SEEDS[".png"][:50], "cannot be read"),
        ("a.png", b"GIF89a", "expected a PNG"),
        ("a.npy", npy(np.zeros(5)), r"shape \(5,\)"),
        ("a.npy", npy(np.array(["a"])), "expected a table"),
        ("a.npy", npy(np.full((2, 2), np.nan)), "none of them finite"),
        ("a.npy", npy(np.zeros((9, 9)))[:200], "cannot be read"),
        ("a.npy", vast_npy(), "cannot be read, expected a table"),
        ("a.npz", b"PK\x03\x04", "has another ending"),
        ("a.csv", b"1,2\n3", "cannot be read"),
        ("a.csv", b"", "cannot be read|holds 0 samples"),
        ("a.csv", b"1,x\n", "cannot be read"),
    ],
)
def test_a_broken_file_is_said_to_be_broken(
    tmp_path: Path, name: str, content: bytes, said: str
) -> None:
    with pytest.raises(FileError, match=said):
        load(put(tmp_path / name, content))


@settings(max_examples=60)
@given(data=st.data())
@pytest.mark.parametrize("ending", SEEDS)
def test_any_bytes_give_a_shape_or_a_clear_error(
    ending: str, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    content = data.draw(damaged(SEEDS[ending]) | st.binary(max_size=300))
    path = put(tmp_path_factory.getbasetemp() / f"fuzz{ending}", content)
    said = str(path)
    try:
        height = load(path).height(X, Y)
        assert not np.isnan(height).any()
        assert height.min() >= 0.0
    except FileError as error:
        said = str(error)
    assert str(path) in said
