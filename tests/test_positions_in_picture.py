"""Positions from pictures of an array: dots that are drawn here at known places."""

import io
from pathlib import Path

import numpy as np
import pytest
from any_bytes import ANYTHING, damaged
from hypothesis import given, settings

from skinfield.errors import FileError, Floats, InputError
from skinfield.files.layouts.positions import positions_in_picture

Image = pytest.importorskip("PIL.Image")
GROUND, DOT = np.array([236.0, 232.0, 225.0]), np.array([70.0, 50.0, 40.0])


def staggered(rows: int = 5, columns: int = 7, pitch: float = 40.0) -> Floats:
    """Centres of rows that are staggered, in the order they are read, pixels."""
    return np.array(
        [[60 + pitch * (c + 0.5 * (r % 2)), 50 + 0.9 * pitch * r]
         for r in range(rows) for c in range(columns)]
    )  # fmt: skip


def drawn(centres: Floats, radius: float = 12.0, shape: tuple[int, int] = (270, 400)) -> Floats:
    """Picture (H, W, 3) of dots with soft edges."""
    y, x = np.indices(shape)
    image = np.tile(GROUND, (*shape, 1))
    for cx, cy in centres:
        cover = np.clip(radius - np.hypot(x - cx, y - cy) + 0.5, 0.0, 1.0)[..., None]
        image = image * (1 - cover) + DOT * cover
    return image


def saved(image: Floats, name: str = "array.png") -> Path:
    Image.fromarray(np.clip(image, 0, 255).astype(np.uint8)).save(name)
    return Path(name)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def check(path: Path, centres: Floats, off: float) -> None:
    """All taxels are found in order, to a part of a pixel that stands for 0.125 mm."""
    found = positions_in_picture(path, pitch=5e-3).positions[:, :2] / 5e-3
    middle = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    expected = (centres - middle) * [1, -1] / 40.0
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() * 40.0 < off


def test_dots_are_found_by_rows() -> None:
    centres = staggered()
    check(saved(drawn(centres)), centres, 0.05)
    wide = positions_in_picture(Path("array.png"), width=26e-3).positions
    assert np.ptp(wide[:, 0]) == pytest.approx(26e-3)
    assert "by rows from top" in positions_in_picture(Path("array.png"), 5e-3).notes[0]


def test_a_photo_that_is_tilted_noisy_and_lit_from_one_side() -> None:
    centres = staggered()
    angle = np.radians(5.0)  # over seven columns, more than half a row
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    turned = (centres - 150.0) @ turn + 150.0
    image = drawn(turned) * np.linspace(0.55, 1.0, 400)[None, :, None]
    image += np.random.default_rng(0).normal(scale=5.0, size=image.shape)
    check(saved(image, "photo.jpg"), turned, 0.6)


def test_a_frame_and_dust_are_no_taxels() -> None:
    centres = staggered()
    image = drawn(centres)
    image[[12, 13, 255, 256], 15:385] = image[12:257, [15, 16, 383, 384]] = DOT
    image[30:33, 200:203] = DOT
    path = saved(image)
    check(path, centres, 0.05)
    assert "1 speck" in positions_in_picture(path, 5e-3).notes[1]


def test_rings_and_light_dots_on_dark_ground() -> None:
    centres = staggered()
    hollow = drawn(centres) + (GROUND - drawn(centres, 9.0))  # filled, they are dots
    check(saved(hollow), centres, 0.05)
    check(saved(255.0 - drawn(centres)), centres, 0.05)


def test_what_is_wrong_is_said_with_its_remedy() -> None:
    centres = staggered()
    path = saved(drawn(centres))
    with pytest.raises(InputError, match="unknown, expected --pitch-mm"):
        positions_in_picture(path)
    with pytest.raises(InputError, match="given twice"):
        positions_in_picture(path, 5e-3, 30e-3)
    joined = np.vstack([centres, centres[10] + [20.0, 0.0]])
    with pytest.raises(FileError, match=r"1 of 34 marks differ in size .* do not touch"):
        positions_in_picture(saved(drawn(joined)), 5e-3)
    with pytest.raises(FileError, match="all of one colour"):
        positions_in_picture(saved(drawn(centres[:0])), 5e-3)
    Path("array.svg").write_text('<?xml version="1.0"?><svg></svg>')
    with pytest.raises(FileError, match="export it as PNG"):
        positions_in_picture(Path("array.svg"), 5e-3)


def small_png() -> bytes:
    file = io.BytesIO()
    Image.fromarray(drawn(staggered(1, 2), 5.0, (80, 140)).astype(np.uint8)).save(file, "PNG")
    return file.getvalue()


@settings(deadline=None, max_examples=40)
@given(data=ANYTHING | damaged(small_png()))
def test_any_bytes_are_positions_or_an_error(
    data: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("any") / "p.png"
    path.write_bytes(data)
    try:
        found = positions_in_picture(path, 5e-3)
    except (FileError, InputError):
        return
    assert np.isfinite(found.positions).all()
