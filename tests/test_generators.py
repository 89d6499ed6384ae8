"""Generated patches against published places, real files and closed geometry."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import skinfield as sf
from skinfield.errors import InputError
from skinfield.skin import generators as names
from skinfield.skin.patch import Patch

TABLE72 = 1e-3 * np.array(  # one module about its centroid, rounded to a micrometre
    [
        *[(4.75, 5.918), (10.25, 5.918), (7.5, 1.155), (2.75, -1.587), (2.75, -7.072)],
        *[(0, -11.835), (-2.75, -7.072), (-2.75, -1.587), (-7.5, 1.155), (-10.25, 5.918)],
        *[(-4.75, 5.918), (0, 3.176)],
    ]
)


def nearest(patch: Patch) -> np.ndarray:
    return cKDTree(patch.positions).query(patch.positions, k=2)[0][:, 1]


def test_hexagon72_is_the_calibrated_patch(shared_data: Path) -> None:
    file = shared_data / "contact-modelling-unige" / "calibration.cache"
    rows = [line.split() for line in file.read_text().splitlines() if line.strip()][1:]
    real = np.array([[float(x) for x in row[:3]] for row in rows])
    offset = real - sf.layouts.hexagon72().positions
    assert len(real) == 72
    assert np.linalg.norm(offset - offset.mean(axis=0), axis=1).max() < 1e-6


def test_hexagon72_has_the_published_modules() -> None:
    patch = sf.layouts.hexagon72()
    bearings, rotations = [90, -30, -90, -150, 150, 30], [0, -120, -60, 0, -60, -60]
    for m, (bearing, rotation) in enumerate(zip(bearings, rotations, strict=True)):
        z = TABLE72 @ [1, 1j] * np.exp(1j * np.radians(rotation))
        z = z + 19.320e-3 * np.exp(1j * np.radians(bearing))
        mine = patch.positions[patch.module == m]
        assert np.abs(mine[:, :2] @ [1, 1j] - z).max() < 1.5e-6
    assert patch.name == "hexagon72"
    assert patch.pad_diameter == 4e-3
    assert (patch.normals == [0, 0, 1]).all()
    assert np.abs(patch.positions.mean(axis=0)).max() < 1e-6
    assert patch.n_channels == 72


def test_uids_are_modules_and_sensors_without_the_thermometer() -> None:
    patch = sf.layouts.hexagon72()
    assert (patch.uid >> np.uint64(4) == patch.module).all()
    assert (patch.uid & np.uint64(15)).tolist() == list(range(1, 13)) * 6


def test_icub_triangle_has_the_places_of_its_drawing() -> None:
    expected = [
        *[(7.5, -1.443), (10, -5.774), (5, -5.774), (0, -2.887), (-5, -5.774), (-10, -5.774)],
        *[(-7.5, -1.443), (-2.5, 1.443), (-2.5, 7.217), (0, 11.547), (2.5, 7.217), (2.5, 1.443)],
    ]
    mine = sf.layouts.icub_triangle().positions[:, :2] * 1e3
    np.testing.assert_allclose(mine, expected, atol=6e-4)


def test_icub_hexagon_has_the_published_pitch() -> None:
    patch = sf.layouts.icub_hexagon()
    np.testing.assert_allclose(nearest(patch), 5e-3, rtol=1e-9)


def test_ten_pad_triangle_leaves_the_thermal_pads_out() -> None:
    patch = sf.layouts.ten_pad_triangle()
    expected = {
        0: (6.43, 0),
        1: (9.646, -5.571),
        5: (-9.646, -5.571),
        7: (-6.43, 0),
        9: (0, 11.139),
    }
    assert patch.channel.tolist() == [0, 1, 2, 3, 4, 5, 7, 8, 9, 11]
    assert patch.n_channels == 12
    for channel, place in expected.items():
        mine = patch.positions[patch.channel == channel][0, :2] * 1e3
        np.testing.assert_allclose(mine, place, atol=4e-3)  # the drawing's own rounding
    two = sf.layouts.triangle_lattice(2, template=sf.layouts.TEN_PAD_TRIANGLE)
    assert two.n_channels == 24
    assert two.channel[10:].tolist() == [12 + c for c in patch.channel]


def test_six_cells_make_the_hexagon() -> None:
    lattice, hexagon = sf.layouts.triangle_lattice(6), sf.layouts.icub_hexagon()
    distance, row = cKDTree(hexagon.positions).query(lattice.positions)
    assert distance.max() < 1e-12
    assert sorted(row) == list(range(72))


@pytest.mark.parametrize("template", ["ICUB_TRIANGLE", "PAPER_TRIANGLE", "TEN_PAD_TRIANGLE"])
def test_modules_stay_in_their_cells(template: str) -> None:
    side = 30e-3
    patch = sf.layouts.triangle_lattice(16, side, template=getattr(sf.layouts, template))
    x, y = patch.plane.T
    # A cell is where three families of parallel lines leave the same strip numbers.
    strips = np.stack(
        [
            np.floor(d / (side * 0.75**0.5))
            for d in (y, x * 0.75**0.5 - y / 2, -x * 0.75**0.5 - y / 2)
        ]
    ).T
    cells = [np.unique(strips[patch.module == m], axis=0) for m in range(16)]
    assert all(len(cell) == 1 for cell in cells)
    assert len(np.unique(np.concatenate(cells), axis=0)) == 16


def test_too_many_modules_name_the_limit_of_the_electronics() -> None:
    with pytest.raises(InputError, match="17 modules, expected 1 to 16: one microcontroller"):
        sf.layouts.triangle_lattice(17)
    assert len(sf.layouts.triangle_lattice(17, max_modules=32)) == 17 * 12
    with pytest.raises(InputError, match="0 modules"):
        sf.layouts.triangle_lattice(0)


def test_wrong_templates_say_what_is_wrong() -> None:
    make = sf.layouts.ModuleTemplate
    with pytest.raises(InputError, match="taxels is empty"):
        make(taxels=(), pad_diameter=4e-3)
    with pytest.raises(InputError, match="expected 2 different numbers"):
        make(taxels=((0, 0), (1e-3, 0)), pad_diameter=4e-3, channels=(1, 1))
    with pytest.raises(InputError, match="from 0 to 3"):
        make(taxels=((0, 0),), pad_diameter=4e-3, channels=(4,), n_channels=4)
    with pytest.raises(InputError, match="apex is 0"):
        make(taxels=((0, 0),), pad_diameter=4e-3, apex=0)


def test_rectangular_runs_right_then_up() -> None:
    patch = sf.layouts.rectangular(rows=2, columns=3, pitch=4e-3, pad_diameter=3e-3)
    x, y = (patch.positions[:, :2] * 1e3).T
    np.testing.assert_allclose(x, [-4, 0, 4, -4, 0, 4], atol=1e-12)
    np.testing.assert_allclose(y, [-2, -2, -2, 2, 2, 2], atol=1e-12)


def test_cylinder_keeps_its_pitch_along_the_skin() -> None:
    patch = sf.layouts.cylinder(radius=30e-3, length=50e-3, arc_angle=np.pi / 2, pitch=5e-3)
    x, y, z = patch.positions.T
    angle = np.arctan2(x, z)
    np.testing.assert_allclose(np.hypot(x, z), 30e-3)
    np.testing.assert_allclose(np.diff(np.unique(angle.round(9))) * 30e-3, 5e-3, rtol=1e-6)
    np.testing.assert_allclose(np.diff(np.unique(y.round(9))), 5e-3, rtol=1e-6)
    assert angle.min() == pytest.approx(-angle.max())
    np.testing.assert_allclose(patch.normals, patch.positions * [1, 0, 1] / 30e-3, atol=1e-12)


def test_closed_cylinder_has_no_seam() -> None:
    patch = sf.layouts.cylinder(radius=30e-3, length=1e-3, arc_angle=2 * np.pi, pitch=5e-3)
    angle = np.sort(np.arctan2(patch.positions[:, 0], patch.positions[:, 2]))
    np.testing.assert_allclose(np.diff(angle), 2 * np.pi / len(patch))
    assert len(patch) == int(2 * np.pi * 30 / 5)


def test_sphere_cap_covers_the_cap_evenly() -> None:
    patch = sf.layouts.sphere_cap(radius=50e-3, cap_angle=np.radians(40), pitch=5e-3)
    np.testing.assert_allclose(np.linalg.norm(patch.positions, axis=1), 50e-3)
    np.testing.assert_allclose(patch.normals, patch.positions / 50e-3)
    polar = np.arccos(patch.positions[:, 2] / 50e-3)
    assert np.radians(40) - 0.1 < polar.max() <= np.radians(40) + 1e-12
    assert nearest(patch).min() > 4.3e-3
    assert nearest(patch).max() < 5.7e-3
    assert len(np.unique(patch.uid)) == len(patch)
    assert (patch.uid % np.uint64(16) != 0).all()


def test_by_name_takes_lengths_in_mm_and_angles_in_degrees() -> None:
    patch = sf.layouts.by_name(" rectangular: rows=3, columns=5, pitch_mm=6.5 ,pad_diameter_mm=2")
    assert len(patch) == 15
    assert patch.pitch == pytest.approx(6.5e-3)
    assert patch.pad_diameter == pytest.approx(2e-3)
    curved = sf.layouts.by_name("cylinder:arc_angle_deg=90,radius_mm=20")
    np.testing.assert_allclose(
        curved.positions,
        sf.layouts.cylinder(radius=20e-3, arc_angle=np.pi / 2).positions,
        atol=1e-15,
    )
    assert len(sf.layouts.by_name("triangle_lattice:modules=3")) == 36


@pytest.mark.parametrize("usage", names.known())
def test_every_generator_is_called_as_it_says(usage: str) -> None:
    shown, plain = sf.layouts.by_name(usage), sf.layouts.by_name(usage.partition(":")[0])
    np.testing.assert_allclose(shown.positions, plain.positions, atol=1e-12)
    assert shown.name in ("triangles", usage.partition(":")[0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("hexagon", "generator is 'hexagon', expected one of these.*hexagon72; icub_hexagon.*"),
        ("nope", "rectangular:rows=8,columns=8,pitch_mm=4,pad_diameter_mm=3"),
        ("rectangular:pitch=4", "argument of rectangular is 'pitch'.*called as rectangular:rows=8"),
        ("rectangular:rows=2.5", "rows of rectangular is '2.5', expected a whole number"),
        ("rectangular:pitch_mm=wide", "pitch_mm of rectangular is 'wide', expected a number"),
        ("rectangular:rows=2,rows=3", "given twice"),
        ("hexagon72:rows=2", "argument of hexagon72 is 'rows=2', expected none"),
        ("rectangular:rows=99999,columns=99999", "about 1e.10 taxels, expected at most 100000"),
        ("cylinder:pitch_mm=1e-6", "expected at most 100000"),
        ("cylinder:arc_angle_deg=361", "arc_angle is 6.3"),
        ("sphere_cap:radius_mm=-1", "radius is -0.001, expected a finite number above 0"),
        ("sphere_cap:pitch_mm=nan", "pitch is nan"),
        ("cylinder:length_mm=inf", "length is inf"),
    ],
)
def test_wrong_names_say_what_is_known(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        sf.layouts.by_name(text)


@settings(max_examples=150, deadline=None)
@given(
    st.one_of(
        st.text(max_size=40),
        st.builds(
            "{}:{}={},{}".format,
            st.sampled_from(sorted(names.GENERATORS)),
            st.sampled_from(["rows", "columns", "pitch_mm", "radius_mm", "modules", "side_mm"]),
            st.one_of(st.integers(-3, 40), st.floats(), st.text(max_size=5)),
            st.text(max_size=8),
        ),
    )
)
def test_any_text_gives_a_patch_or_a_clear_error(text: str) -> None:
    try:
        patch = sf.layouts.by_name(text)
    except InputError as error:
        message = str(error)
    else:
        assert np.isfinite(patch.positions).all()
        return
    assert "expected" in message
