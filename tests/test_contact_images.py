"""Contact images: outlines and forces of stamps whose truth is the simulator's own press."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from matplotlib.path import Path as Polygon

import skinfield as sf
from skinfield.elastic import BaseStress
from skinfield.errors import InputError
from skinfield.estimate.contact_image import ContactImage
from skinfield.reconstruct.contact_image_fit import ImageFit, Response
from skinfield.reconstruct.contact_images_kernel import look
from skinfield.simulate import Bar, HeightMap, press
from skinfield.simulate.pressing.press import readings_anywhere
from skinfield.skin import Grid

NOISE, FORCE, PIXEL = 0.002, 5.0, 0.2e-3  # ΔC/C₀; N; m
PATCH, LAYER = sf.layouts.hexagon72(), sf.Layer()
STEP = 0.1e-3  # m: between points at which regions are compared


def letter() -> HeightMap:
    """J of strokes of 4 mm, none of the letters that the weights were chosen by."""
    axis = np.arange(-10e-3, 10e-3, PIXEL) + PIXEL / 2
    x, y = np.meshgrid(axis * 1e3, axis * 1e3)
    inside = (np.abs(x - 4) < 2) & (np.abs(y) < 8)
    inside |= (np.abs(x) < 6) & (np.abs(y + 6) < 2)
    inside |= (np.abs(x + 4) < 2) & (y > -8) & (y < -1)
    return HeightMap(heights=np.where(inside, 0.0, np.nan), pixel=PIXEL, force=FORCE)


class Stamp:
    """A body on the simulated skin, in any pose."""

    def __init__(self, body: Any) -> None:
        self.body = body
        self.press = press(LAYER, [body], extent=30e-3, cell=0.25e-3)
        self.clean = readings_anywhere(self.press, PATCH.pad_diameter, "capacitance", 0.5e-3)

    def readings(self, pose: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        places = (PATCH.plane - pose[:2]) @ np.array([[cos, -sin], [sin, cos]])
        return self.clean(places) + rng.normal(scale=NOISE, size=len(PATCH))

    def overlap(self, image: ContactImage, pose: np.ndarray) -> float:
        """Intersection of the outline on the skin and the truth there, over their union."""
        axis = np.arange(-13e-3, 13e-3, STEP)
        x, y = np.meshgrid(axis + pose[0], axis + pose[1])
        points = np.column_stack([x.ravel(), y.ravel()])
        found = sum(Polygon(line[:, :2]).contains_points(points).astype(int)
                    for line in image.outline) % 2 == 1  # fmt: skip
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        own = (points - pose[:2]) @ np.array([[cos, -sin], [sin, cos]])
        true = np.isfinite(self.body.height(*own.T))
        return float((found & true).sum() / (found | true).sum())


@pytest.fixture(scope="module")
def stamp() -> Stamp:
    found = Stamp(letter())
    face = np.isfinite(found.body.heights).sum() * PIXEL**2
    assert found.press.contact_area == pytest.approx(face, rel=1e-6), "all of its face touches"
    return found


@pytest.fixture(scope="module")
def rec() -> sf.Reconstructor:
    return sf.Reconstructor(PATCH, LAYER, solver=sf.Tikhonov(), noise_std=NOISE)


def scattered(count: int, rng: np.random.Generator) -> np.ndarray:
    places = rng.uniform(-1, 1, (count, 2)) * PATCH.pitch / 2
    return np.column_stack([places, np.full(count, 0.4)])


def round_way(count: int) -> np.ndarray:
    turn = np.linspace(0.0, 2 * np.pi, 30)[:count]
    return np.column_stack([2.5e-3 * np.cos(turn), 2.5e-3 * np.sin(turn), 0.5 + 0.2 * np.sin(turn)])


def test_what_moves_is_seen_more_sharply_than_one_reading_shows_it(
    stamp: Stamp, rec: sf.Reconstructor
) -> None:
    rng = np.random.default_rng(1)
    images, poses = sf.ContactImages(rec), scattered(20, rng)
    overlaps = []
    for pose in poses:
        (image,) = images.update(stamp.readings(pose, rng), poses=pose)
        overlaps.append(stamp.overlap(image, pose))
    assert 0.35 < overlaps[0] < 0.75, "a reading knows little between taxels"
    assert overlaps[-1] > 0.8
    assert overlaps[-1] > overlaps[0] + 0.15
    assert image.force == pytest.approx(FORCE, rel=0.1)
    assert image.area == pytest.approx(stamp.press.contact_area, rel=0.15)
    assert image.readings == 20
    assert image.misfit < 2.0
    confident = image.confidence
    assert confident.shape == image.pressure.shape
    assert confident.min() >= 0.5
    assert confident.max() <= 1.0
    assert np.median(confident[image.pressure == 0.0]) > 0.9


def test_an_unknown_motion_is_found_along_with_the_shape(rec: sf.Reconstructor) -> None:
    bar = Stamp(Bar(length=18e-3, width=4e-3, force=FORCE))
    rng, images, poses = np.random.default_rng(2), sf.ContactImages(rec), round_way(24)
    found, numbers = [], set()
    for pose in poses:
        (image,) = images.update(bar.readings(pose, rng))
        found.append(image.pose)
        numbers.add(image.track_id)
    assert len(numbers) == 1
    assert bar.overlap(image, poses[-1]) > 0.7
    moved, true = np.array(found)[8:], poses[8:]
    turned = moved[:, 2] - true[:, 2]
    assert np.degrees(np.abs(turned - turned.mean())).max() < 6.0
    assert image.axes[0] > 2.5 * image.axes[1]
    assert image.convexity > 0.85
    angle = (image.angle - poses[-1, 2] + np.pi / 2) % np.pi - np.pi / 2
    assert abs(np.degrees(angle)) < 6.0


def test_force_follows_each_reading(stamp: Stamp, rec: sf.Reconstructor) -> None:
    lighter = Stamp(HeightMap(heights=stamp.body.heights, pixel=PIXEL, force=3.0))
    rng, images, forces = np.random.default_rng(3), sf.ContactImages(rec), []
    for count, pose in enumerate(scattered(16, rng)):
        which = (stamp, lighter)[count % 2]
        (image,) = images.update(which.readings(pose, rng), poses=pose)
        forces.append(image.force)
    assert np.mean(forces[-5::2]) == pytest.approx(3.0, rel=0.12)
    assert np.mean(forces[-6::2]) == pytest.approx(5.0, rel=0.12)


def test_an_estimate_and_lost_taxels_give_the_same_as_readings(
    stamp: Stamp, rec: sf.Reconstructor
) -> None:
    rng = np.random.default_rng(4)
    pose = np.array([1e-3, 0.0, 0.1])
    readings = np.stack([stamp.readings(pose, rng) for _ in range(2)])
    readings[:, 40] = np.nan
    ours, theirs = sf.ContactImages(rec), sf.ContactImages(rec)
    (one,) = ours.update(readings, stamp_ns=np.array([5, 9]))
    (other,) = theirs.update(rec(readings, stamp_ns=np.array([5, 9])))
    assert one.stamp_ns == other.stamp_ns == 9
    np.testing.assert_array_equal(one.pressure, other.pressure)


def test_bodies_come_and_go_each_with_its_image(rec: sf.Reconstructor) -> None:
    bars = [Bar(length=8e-3, width=5e-3, force=force, position=place)
            for force, place in ((4.0, (-20e-3, 0.0)), (2.0, (20e-3, 2e-3)))]  # fmt: skip
    both = press(LAYER, bars, extent=60e-3, cell=0.5e-3)
    readings = both.capacitance(PATCH.plane, PATCH.pad_diameter)
    images, rng = sf.ContactImages(rec, coast=1), np.random.default_rng(5)
    for _ in range(3):
        found = images.update(readings + rng.normal(scale=NOISE, size=len(PATCH)))
    assert {image.track_id for image in found} == {1, 2}
    assert found[0].force > found[1].force
    assert np.ptp([image.positions[..., 0].mean() for image in found]) > 30e-3
    for _ in range(3):
        assert images.update(rng.normal(scale=NOISE, size=len(PATCH))) == ()
    again = images.update(readings)
    assert {image.track_id for image in again} == {3, 4}, "they were forgotten"


def linear_fit(cell: float = 1e-3) -> ImageFit:
    quantity = BaseStress()
    rec = sf.Reconstructor(PATCH, LAYER, quantity=quantity, solver=sf.Tikhonov())
    step = 1e-3, 0.1
    return ImageFit(Response(rec.model, cell), np.array([1e-3, 0.0]), 12, 10, step, step, True)


def test_readings_of_a_body_are_those_of_the_observation_model() -> None:
    """In a pose whose cells are those of a patch's grid, and their slopes by differences."""
    fit, rng = linear_fit(), np.random.default_rng(6)
    pose = np.array([2e-3, -1e-3, np.pi / 2])
    grid = Grid(PATCH, (12, 12), 1e-3, np.array([-3.5e-3, -5.5e-3]))
    physics = fit.response.physics
    matrix = physics.quantity.matrix(
        physics.mechanics, LAYER, grid, PATCH.plane, PATCH.pad_diameter
    )
    pressure = rng.uniform(size=(12, 12))
    fields, out, slopes = np.zeros((3, 144)), np.zeros((3, 72)), np.zeros((3, 3, 72))
    fields[0] = pressure.ravel()
    fit._lattice.first[:] = fit.response.first
    look(fit._lattice, pose, fields, out, slopes)
    # turned by a quarter: x of the body is y of the plane, and y of the body -x
    expected = matrix @ pressure.T[:, ::-1].ravel()
    assert np.abs(out[0] - expected).max() < 0.01 * expected.max()
    for k, step in enumerate((1e-4, 1e-4, 1e-2)):
        sides, nothing = np.zeros((2, 3, 72)), np.zeros((3, 3, 72))
        for side, sign in zip(sides, (1.0, -1.0), strict=True):
            look(fit._lattice, pose + sign * np.eye(3)[k] * step, fields, side, nothing)
        by_difference = (sides[0, 0] - sides[1, 0]) / (2 * step)
        assert np.abs(slopes[0, k] - by_difference).max() < 0.05 * np.abs(by_difference).max()


def test_what_a_body_adds_beyond_first_order_is_that_of_the_deformed_gap(stamp: Stamp) -> None:
    rec = sf.Reconstructor(PATCH, LAYER, solver=sf.Tikhonov())
    cell, side = stamp.press.grid.pitch, stamp.press.grid.shape[0]
    step = 1e-3, 0.1
    fit = ImageFit(Response(rec.model, cell), np.zeros(2), side, 1, step, step, True)
    fit._batch.pressure[:] = stamp.press.pressure
    fit._lattice.first[:] = fit.response.first
    fit._add_charge()
    out, slopes = np.zeros((3, 72)), np.zeros((3, 3, 72))
    look(fit._lattice, np.zeros(3), fit._batch.fields, out, slopes)
    true = stamp.press.capacitance(PATCH.plane, PATCH.pad_diameter)
    first = stamp.press.capacitance(PATCH.plane, PATCH.pad_diameter, order=1)
    assert np.abs(true - first).max() > NOISE, "it matters"
    assert np.abs(out[0] - first).max() < 0.02 * first.max()
    assert np.abs(out[1] + out[2] - (true - first)).max() < 0.12 * (true - first).max()


def image_of(inside: Callable[[np.ndarray, np.ndarray], np.ndarray], pose: Any) -> ContactImage:
    axis = (np.arange(60) - 29.5) * 0.5e-3
    x, y = np.meshgrid(axis, axis)
    return ContactImage(
        pressure=np.where(inside(x, y), 20e3, 0.0),
        body_positions=np.stack([x, y], axis=-1),
        pose=np.asarray(pose, dtype=float),
        patch=PATCH,
        readings=3,
        misfit=1.0,
        track_id=1,
        stamp_ns=0,
        deviation=lambda: np.full(x.shape, 1e3),
    )


def test_shape_of_an_image_is_that_of_its_outline() -> None:
    ellipse = image_of(lambda x, y: (x / 9e-3) ** 2 + (y / 4e-3) ** 2 < 1, (5e-3, -2e-3, 0.6))
    area = np.pi * 9e-3 * 4e-3
    assert ellipse.area == pytest.approx(area, rel=0.02)
    assert ellipse.force == pytest.approx(20e3 * area, rel=0.02)
    np.testing.assert_allclose(ellipse.axes, [9e-3, 4e-3], rtol=0.03)
    assert ellipse.angle == pytest.approx(0.6, abs=0.02)
    assert ellipse.convexity > 0.97
    (outline,) = ellipse.outline
    np.testing.assert_array_equal(outline[0], outline[-1])
    np.testing.assert_allclose(outline[:-1].mean(axis=0), [5e-3, -2e-3, 0.0], atol=2e-4)
    ring = image_of(lambda x, y: np.abs(np.hypot(x, y) - 6e-3) < 2e-3, (0.0, 0.0, 0.0))
    assert len(ring.outline) == 2
    assert ring.area == pytest.approx(np.pi * (8e-3**2 - 4e-3**2), rel=0.03)
    assert ring.convexity == pytest.approx(0.75, abs=0.03)
    assert image_of(lambda x, _: x > 1.0, (0.0, 0.0, 0.0)).outline == []
    assert "mm²" in repr(ring)
    assert "convexity" in ring._repr_html_()
    axes = ring.plot()
    assert axes.get_xlabel() == "x of the body (mm)"


def test_what_does_not_fit_is_refused(stamp: Stamp, rec: sf.Reconstructor) -> None:
    images, rng = sf.ContactImages(rec), np.random.default_rng(7)
    readings = stamp.readings(np.zeros(3), rng)
    for poses, why in (
        (np.zeros(2), "poses"),
        (np.zeros((2, 3)), "poses"),
        ([0, 0, np.nan], "poses"),
    ):
        with pytest.raises(InputError, match=why):
            images.update(readings, poses=poses)
    with pytest.raises(InputError, match="stamp_ns"):
        images.update(readings, stamp_ns=[1, 2])
    images.update(readings)
    with pytest.raises(InputError, match="from its first reading on"):
        images.update(readings, poses=np.zeros(3))
    images.reset()
    images.update(readings, poses=np.zeros(3))
    with pytest.raises(InputError, match="go on giving them"):
        images.update(readings)
    with pytest.raises(InputError, match="rec is"):
        sf.ContactImages(PATCH)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="cell is"):
        sf.ContactImages(rec, cell=0.8)
