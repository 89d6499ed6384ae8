"""Grid: where nodes are, flat and curved."""

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError


def test_nodes_run_right_then_up() -> None:
    grid = sf.Grid(sf.layouts.hexagon72(), (2, 3), 1e-3, np.array([5e-3, 7e-3]))
    assert len(grid) == 6
    assert grid.shape == (2, 3)
    expected = [[5, 7], [6, 7], [7, 7], [5, 8], [6, 8], [7, 8]]
    np.testing.assert_allclose(grid.plane * 1e3, expected)
    picture = grid.plane.reshape(*grid.shape, 2)
    assert (np.diff(picture[..., 0], axis=1) > 0).all()  # x to the right
    assert (np.diff(picture[..., 1], axis=0) > 0).all()  # y upwards
    assert grid.cell_area == pytest.approx(1e-6)


def test_square_has_its_first_and_last_node_on_the_border() -> None:
    patch = sf.layouts.hexagon72()
    grid = sf.Grid.square(patch, nodes=40)
    low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
    side = (high - low).max()
    assert grid.shape == (40, 40)
    assert grid.pitch == pytest.approx(side / 39)
    np.testing.assert_allclose(grid.plane[0], (low + high - side) / 2, atol=1e-12)
    np.testing.assert_allclose(grid.plane[-1], (low + high + side) / 2, atol=1e-12)
    assert grid.plane[:, 0].min() == pytest.approx(low[0])
    assert grid.plane[:, 0].max() == pytest.approx(high[0])
    np.testing.assert_allclose(grid.positions[:, :2], grid.plane, atol=1e-15)


def test_square_around_one_taxel_is_its_pad() -> None:
    grid = sf.Grid.square(sf.Patch([[0.1, 0.2]], 4e-3), nodes=5)
    assert grid.pitch == pytest.approx(1e-3)
    np.testing.assert_allclose(grid.plane.mean(axis=0), [0.1, 0.2])
    assert not grid.covered.any()  # one taxel has no hull


def test_window_is_filled_with_cells_and_keeps_its_middle() -> None:
    grid = sf.Grid.window(sf.layouts.hexagon72(), [-10e-3, 0], [10e-3, 5e-3], 1e-3)
    assert grid.shape == (5, 20)
    np.testing.assert_allclose(grid.plane.min(axis=0), [-9.5e-3, 0.5e-3], atol=1e-12)
    np.testing.assert_allclose(grid.plane.max(axis=0), [9.5e-3, 4.5e-3], atol=1e-12)
    assert len(grid) * grid.cell_area == pytest.approx(20e-3 * 5e-3)
    broken = sf.Grid.window(sf.layouts.hexagon72(), [0, 0], [10.4e-3, 0.3e-3], 1e-3)
    assert broken.shape == (1, 10)
    np.testing.assert_allclose(broken.plane.mean(axis=0), [5.2e-3, 0.15e-3])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda p: sf.Grid(p, (0, 3), 1e-3), r"shape is \(0, 3\), expected at least one row"),
        (lambda p: sf.Grid(p, (2.5, 3), 1e-3), "expected .rows, columns., whole numbers"),
        (lambda p: sf.Grid(p, (2, 3, 4), 1e-3), "expected .rows, columns., whole numbers"),
        (lambda p: sf.Grid(p, 5, 1e-3), "shape is 5"),
        (lambda p: sf.Grid(p, (2, 3), -1.0), "pitch is -1.0, expected a finite number above 0"),
        (lambda p: sf.Grid(p, (2, 3), np.nan), "pitch is nan"),
        (lambda p: sf.Grid(p, (2, 3), 1e-3, [0, 0, 0]), r"origin has shape \(3,\)"),
        (lambda p: sf.Grid(p, (2, 3), 1e-3, [0, np.nan]), r"origin\[1\] is nan"),
        (lambda p: sf.Grid.square(p, nodes=1), "nodes is 1, expected 2 or more"),
        (lambda p: sf.Grid.square(p, nodes=4.5), "whole numbers"),
        (lambda p: sf.Grid.window(p, [0, 0], [0, 1], 1e-3), "expected above low"),
        (lambda p: sf.Grid.window(p, [0, 0], [1, 1, 1], 1e-3), r"high has shape \(3,\)"),
        (lambda p: sf.Grid.window(p, [0, 0], [1, 1], 0.0), "pitch is 0.0"),
    ],
)
def test_wrong_grids_say_what_is_wrong(make, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make(sf.layouts.hexagon72())


def test_arrays_are_copies_and_read_only() -> None:
    origin = np.zeros(2)
    for patch in (sf.layouts.hexagon72(), sf.layouts.sphere_cap()):
        grid = sf.Grid(patch, (3, 3), 1e-3, origin)
        origin[0] = 0.0  # still the caller's own
        for name in ("origin", "plane", "positions", "frames", "normals"):
            with pytest.raises(ValueError, match="read-only"):
                getattr(grid, name)[0] = 1


def test_covered_is_where_taxels_are_around() -> None:
    patch = sf.layouts.rectangular(11, 11, pitch=4e-3)
    hole = patch.subset(np.linalg.norm(patch.plane, axis=1) > 15e-3)
    grid = sf.Grid.window(hole, [-30e-3, -30e-3], [30e-3, 30e-3], 1e-3)
    inside = np.abs(grid.plane).max(axis=1) <= 20e-3
    distance = np.linalg.norm(grid.plane[:, None] - hole.plane[None], axis=2).min(axis=1)
    assert (grid.covered == (inside & (distance <= 10e-3))).all()
    assert not grid.covered[np.linalg.norm(grid.plane, axis=1).argmin()]
    full = sf.Grid.square(patch, nodes=20)
    assert full.covered.all()
    assert sf.Grid.square(sf.layouts.hexagon72(), nodes=9).covered.sum() > 40


def test_grid_of_a_tilted_patch_lies_in_its_plane() -> None:
    slope = np.array([[0.8, 0, 0.6], [0, 1, 0]])
    normal = np.array([-0.6, 0, 0.8])
    flat = sf.layouts.hexagon72()
    patch = sf.Patch(flat.plane @ slope + 0.3 * normal, normals=np.broadcast_to(normal, (72, 3)))
    grid = sf.Grid.square(patch, nodes=12)
    np.testing.assert_allclose(grid.positions @ normal, 0.3, atol=1e-12)
    np.testing.assert_allclose(grid.normals, np.tile(normal, (144, 1)))
    same = sf.Grid.square(flat, nodes=12)
    np.testing.assert_allclose(grid.positions, same.plane @ slope + 0.3 * normal, atol=1e-9)
    np.testing.assert_allclose(grid.frames[7, :, :2].T, slope, atol=1e-9)


def test_grid_of_a_sphere_lies_on_the_sphere() -> None:
    patch = sf.layouts.sphere_cap(radius=50e-3, cap_angle=np.radians(30), pitch=5e-3)
    grid = sf.Grid.square(patch, nodes=25)
    positions, normals = grid.positions[grid.covered], grid.normals[grid.covered]
    radius = np.linalg.norm(positions, axis=1)
    np.testing.assert_allclose(radius, 50e-3, atol=0.01 * 5e-3)
    cosine = np.einsum("ni,ni->n", normals, positions) / radius
    assert np.degrees(np.arccos(np.minimum(cosine, 1))).max() < 0.3
    assert np.linalg.norm(grid.positions[len(grid) // 2] - [0, 0, 50e-3]) < 0.1e-3
    pole = grid.frames[len(grid) // 2]
    np.testing.assert_allclose(pole, np.eye(3), atol=0.02)
