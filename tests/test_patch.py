"""Patch and Skin: what is checked, kept, derived."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.skin.geometry import inside_hull, spans_plane

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) * 10e-3


def test_defaults() -> None:
    patch = sf.Patch(SQUARE)
    assert patch.positions.shape == (4, 3)
    assert (patch.positions[:, 2] == 0).all()
    assert (patch.normals == [0, 0, 1]).all()
    assert patch.uid.dtype == np.uint64
    assert patch.uid.tolist() == patch.channel.tolist() == [0, 1, 2, 3]
    assert patch.module.tolist() == [0, 0, 0, 0]
    assert patch.n_channels == 4
    assert (patch.link_from_patch == np.eye(4)).all()
    assert repr(patch) == "Patch('patch', 4 taxels, 1 modules, 10.0 x 10.0 x 0.0 mm)"


def test_arrays_are_copies_and_read_only() -> None:
    mine, up = np.column_stack([SQUARE, np.zeros(4)]), np.tile([0, 0, 1.0], (4, 1))
    uid = np.arange(4, dtype=np.uint64)
    patch = sf.Patch(mine, normals=up, uid=uid)
    mine[0], up[0], uid[0] = 5.0, 5.0, 9  # still the caller's own
    assert patch.positions[0].tolist() == [0, 0, 0]
    assert patch.normals[0].tolist() == [0, 0, 1]
    assert patch.uid[0] == 0
    for name in ("positions", "normals", "module", "uid", "channel", "link_from_patch", "plane"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(patch, name)[0] = 1


def test_normals_become_unit_length() -> None:
    patch = sf.Patch(SQUARE, normals=[[0, 0, 7.0], [0, 0, 1e-3], [0, 0, 1], [0, 0, 2]])
    np.testing.assert_allclose(patch.normals, np.tile([0, 0, 1], (4, 1)))


@pytest.mark.parametrize(
    ("tilt", "expected"),
    [
        ([[1, 0, 0], [0, 1, 0]], [0, 0, 1]),
        ([[1, 0, 0], [0, 0, 1]], [0, 1, 0]),
        ([[0, 1, 0], [0, 0, 1]], [1, 0, 0]),
        ([[1, 0, 1], [0, 1, 0]], [-(0.5**0.5), 0, 0.5**0.5]),
    ],
)
def test_normals_of_a_flat_patch_default_to_the_upper_side(
    tilt: list[list[float]], expected: list[float]
) -> None:
    patch = sf.Patch(SQUARE @ np.array(tilt) + np.array([0.01, 0.02, -0.5]))
    np.testing.assert_allclose(patch.normals, np.tile(expected, (4, 1)), atol=1e-9)
    assert patch.surface.is_flat


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"positions": np.zeros((0, 3))}, "at least one taxel: one row of metres per taxel"),
        ({"positions": np.zeros(3)}, r"positions has shape \(3,\)"),
        ({"positions": np.zeros((3, 4))}, r"expected \(taxels, 2\) or \(taxels, 3\)"),
        ({"positions": [["a", "b"]]}, "positions is .*expected numbers"),
        ({"positions": [[0, 0], [np.nan, 0]]}, r"positions\[\(1, 0\)\] is nan.*left out"),
        ({"positions": [[0.0, 0.0], [6.0, 0.0]]}, "6 m apart over 6 m.*these are millimetres"),
        ({"positions": [[0, 0], [0.05, 0], [11, 0]]}, "over 11 m, which no skin is.*by 1000"),
        ({"pad_diameter": 0.5}, "pad_diameter is 0.5 m, expected a length above 0 and below 0.1"),
        ({"pad_diameter": 4.0}, "pad_diameter is 4.0 m.*4 mm is 4e-3"),
        ({"pad_diameter": -1e-3}, "pad_diameter is -0.001"),
        ({"pad_diameter": np.nan}, "pad_diameter is nan"),
        ({"normals": np.zeros((4, 3))}, r"normals\[0\] is .*leave normals out"),
        ({"normals": [[0, 0, 1], [0, 0, np.inf], [0, 0, 1], [0, 0, 1]]}, r"normals\[1\]"),
        ({"normals": np.ones((3, 3))}, r"normals has shape \(3, 3\), expected \(4, 3\)"),
        ({"module": [0, 0]}, r"module has shape \(2,\), expected \(4"),
        ({"module": [0, 0.5, 1, 1]}, "module is .*expected whole numbers from 0"),
        ({"channel": [0, 1, 2, -1]}, "channel is .*expected whole numbers from 0"),
        ({"channel": [0, 1, 2, np.nan]}, "channel is .*expected whole numbers"),
        ({"uid": ["a", "b", "c", "d"]}, "uid is .*expected whole numbers"),
        ({"channel": [0, 1, 2, 40], "n_channels": 40}, "n_channels is 40, expected at least 41"),
        ({"link_from_patch": np.eye(3)}, r"link_from_patch has shape \(3, 3\)"),
        ({"link_from_patch": 2 * np.eye(4)}, "expected a rotation, a shift in metres"),
        ({"link_from_patch": np.diag([1, 1, -1, 1.0])}, "expected a rotation"),
    ],
)
def test_wrong_input_is_named(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        sf.Patch(**{"positions": SQUARE} | arguments)  # type: ignore[arg-type]


def test_large_uids_survive() -> None:
    largest = np.array([2**64 - 1, 2**63, 1, 0], dtype=np.uint64)
    assert sf.Patch(SQUARE, uid=largest).uid.tolist() == largest.tolist()


def test_subset_keeps_identities_and_the_width_of_the_port() -> None:
    patch = sf.layouts.hexagon72()
    for rows in (patch.module == 2, np.flatnonzero(patch.module == 2), list(range(24, 36))):
        part = patch.subset(rows)
        assert part.uid.tolist() == patch.uid[24:36].tolist()
        assert part.channel.tolist() == list(range(24, 36))
        assert part.n_channels == 72
        assert part.name == "hexagon72"
        np.testing.assert_array_equal(part.positions, patch.positions[24:36])
    assert patch.subset([5, 3]).channel.tolist() == [5, 3]


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([], "at least one taxel"),
        (np.zeros(72, bool), "at least one taxel"),
        (np.ones(71, bool), r"rows has shape \(71,\) and type bool, expected a mask of 72 taxels"),
        ([72], "expected .* below 72: index 72 is out of bounds"),
        ([0.5], "expected a mask of 72 taxels or whole numbers below 72"),
        ([[1, 2]], r"rows has shape \(1, 2\), expected \(any\): a mask, or one row"),
    ],
)
def test_wrong_subsets_say_what_is_wrong(rows: list[int], message: str) -> None:
    with pytest.raises(InputError, match=message):
        sf.layouts.hexagon72().subset(rows)


def test_pitch_is_between_nearest_neighbours() -> None:
    assert sf.layouts.icub_hexagon().pitch == pytest.approx(5e-3)
    assert sf.layouts.rectangular(3, 3, pitch=7e-3).pitch == pytest.approx(7e-3)
    assert sf.layouts.cylinder(pitch=6e-3).pitch == pytest.approx(6e-3, rel=1e-3)
    assert sf.Patch([[0, 0]], 3e-3).pitch == 3e-3
    assert sf.Patch([[0, 0], [0, 0]], 3e-3).pitch == 3e-3


def test_triangles_cover_the_hull_once() -> None:
    patch = sf.layouts.rectangular(4, 7, pitch=4e-3)
    assert len(patch.triangles) == 2 * 3 * 6
    a, b, c = (patch.plane[patch.triangles[:, k]] for k in range(3))
    (x1, y1), (x2, y2) = (b - a).T, (c - a).T
    assert np.abs(x1 * y2 - x2 * y1).sum() / 2 == pytest.approx(3 * 6 * 16e-6)


def test_neighbours_are_the_near_edges_of_the_triangles() -> None:
    patch = sf.layouts.rectangular(4, 7, pitch=4e-3)
    assert len(patch.neighbours) == 4 * 6 + 3 * 7 + 3 * 6  # along rows, columns, one diagonal each
    assert (patch.neighbours[:, 0] < patch.neighbours[:, 1]).all()
    torn = sf.Patch(np.concatenate([patch.plane, patch.plane + np.array([60e-3, 0])]))
    across = (torn.neighbours < 28).sum(axis=1) == 1
    assert not across.any()


def test_taxels_on_a_line_have_their_next_as_neighbours() -> None:
    x = np.array([3, 0, 1, 2, 9]) * 5e-3
    patch = sf.Patch(np.column_stack([x, 2 * x]))
    assert patch.triangles.shape == (0, 3)
    assert patch.neighbours.tolist() == [[0, 3], [1, 2], [2, 3]]
    assert sf.Patch([[0, 0]]).neighbours.shape == (0, 2)


def test_repeated_taxels_take_part_once() -> None:
    patch = sf.Patch(np.concatenate([SQUARE, SQUARE[:2]]))
    assert len(patch.triangles) == 2
    assert patch.triangles.max() < 4


def test_hull_holds_its_border_and_nothing_outside() -> None:
    queries = np.array([[5, 5], [0, 0], [10, 5], [10.001, 5], [-1, -1]]) * 1e-3
    far = np.array([3.0, -2.0])  # metres away from the origin of the frame
    assert inside_hull(SQUARE + far, queries + far).tolist() == [True, True, True, False, False]
    assert not inside_hull(SQUARE[:2], queries).any()
    assert not spans_plane(np.column_stack([np.arange(5), np.arange(5)]) * 1e-3)
    assert spans_plane(SQUARE)


def test_skin_finds_patches_by_name_and_number() -> None:
    a, b = sf.layouts.hexagon72(), sf.layouts.icub_hexagon()
    skin = sf.Skin([a, b], name="two", notes=["left out 3"])  # type: ignore[arg-type]
    assert skin["icub_hexagon"] is b
    assert skin[0] is a
    assert skin[-1] is b
    assert list(skin) == [a, b]
    assert len(skin) == 2
    assert skin.notes == ("left out 3",)
    assert sf.Skin(a).patches == (a,)  # type: ignore[arg-type]


def test_skin_errors_list_the_patches() -> None:
    skin = sf.Skin((sf.layouts.hexagon72(),))
    with pytest.raises(InputError, match="'arm' is not in 'skin', expected one of hexagon72"):
        skin["arm"]
    with pytest.raises(InputError, match="patch 1 is not in"):
        skin[1]
    with pytest.raises(InputError, match="each name once"):
        sf.Skin((skin[0], skin[0]))
    with pytest.raises(InputError, match="expected one or more"):
        sf.Skin(())
