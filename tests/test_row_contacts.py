"""Contacts of rows of numbers: shapes, outlines, and contacts of a snapshot."""

import numpy as np
import pytest
from live_skins import cycle_of, settings
from numpy.testing import assert_allclose
from recorder_ring import contact

import skinfield as sf
from skinfield.estimate.row_contacts import (
    contacts_of_rows,
    ellipse_of,
    force_covariance_of,
    outline_of,
    pressure_std_of_rows,
    shape_name,
    shear_of,
)
from skinfield.loop import Answer
from skinfield.loop.model_config import Models
from skinfield.loop.slots import CycleSlot
from skinfield.loop.snapshot import Snapshot

PATCH = sf.layouts.hexagon72()
GRID = sf.Grid.square(PATCH, 20)
AREA = np.pi * 12e-6  # m2, of semi-axes of 6 and 2 mm
ROW = contact(
    2e-3, -1e-3, 1.5, track=7, area=AREA, moments=(9e-6, 1e-6, 0.0), shape=3, radius=2e-3
)  # fmt: skip


def test_an_outline_has_the_area_and_the_moments_of_its_row() -> None:
    axes, angle = ellipse_of(ROW[0])
    assert_allclose(axes, [6e-3, 2e-3])
    assert angle == 0.0
    x, y, _ = outline_of(PATCH.surface, ROW[0]).T
    assert 0.5 * abs(x[:-1] @ y[1:] - x[1:] @ y[:-1]) == pytest.approx(AREA, rel=0.01)
    assert_allclose([x.mean(), y.mean()], [2e-3, -1e-3], atol=4e-4)
    for turned, expected in (((1e-6, 9e-6, 0.0), np.pi / 2), ((5e-6, 5e-6, 4e-6), np.pi / 4)):
        assert ellipse_of(contact(area=AREA, moments=turned)[0])[1] == pytest.approx(expected)


def test_a_shear_lies_along_the_skin_by_the_planes_axes() -> None:
    patch = sf.layouts.cylinder()
    surface, at = patch.surface, patch.plane[len(patch) // 3]
    frame = surface.frame_from_plane(at[None])[0]
    row = contact(*at, normal=frame[:, 2], shear=frame[:, :2] @ [0.3, -0.2],
                  shear_covariance=(4e-4, 1e-4, 9e-4))[0]  # fmt: skip
    shear, covariance = shear_of(surface, row)
    assert_allclose(shear, [0.3, -0.2], atol=1e-6)
    along = frame[:, :2].T @ force_covariance_of(surface, row) @ frame[:, :2]
    assert_allclose(along, covariance, atol=1e-9)


@pytest.mark.parametrize("moments", [(0.0, 0.0, 0.0), (np.nan, 1e-6, 0.0), (np.inf, 1e-6, 0.0)])
def test_without_moments_it_is_a_circle(moments: tuple[float, ...]) -> None:
    axes, angle = ellipse_of(contact(area=AREA, moments=moments)[0])
    assert_allclose(axes, np.sqrt(12e-6))
    assert angle == 0.0


@pytest.mark.parametrize(
    ("number", "name"), [(0, "other"), (1, "sphere"), (2, "flat"), (3, "line"), (9, "other")]
)
def test_names_of_shapes(number: int, name: str) -> None:
    assert shape_name(contact(shape=number)[0]) == name


def test_nodes_belong_to_the_nearest_contact() -> None:
    rows = np.concatenate([ROW, contact(-8e-3, 0.0, radius=np.nan, area=np.pi * 1e-6)])
    pressure = np.where(np.abs(GRID.plane[:, 1]) < 4e-3, 1e3, 0.0)
    first, second = contacts_of_rows(rows, GRID, pressure)
    assert sorted([*first.cells, *second.cells]) == np.flatnonzero(pressure).tolist()
    assert (GRID.plane[first.cells, 0] > -4e-3).all()
    assert (first.radius, second.radius) == (2e-3, pytest.approx(1e-3))
    assert contacts_of_rows(rows[:0], GRID, pressure) == ()


def test_a_snapshot_answered_by_contacts_has_those_of_its_rows() -> None:
    cycle = cycle_of(settings(), 0.004)
    slot = CycleSlot.empty(cycle.sizes)
    slot.patches["answer"], slot.patches["rung"] = int(Answer.CONTACTS), 20
    slot.patches["contacts"], slot.patches["readings"] = 1, 16
    row = slot.contacts[0, :1]
    row[:] = ROW
    row["force_std"], row["place_std"] = 0.1, 2e-4
    models = Models(cycle.model_config, np.full(len(PATCH), 0.004))
    notes = {"readings": {PATCH.name: ["it reads unlike its model"]}}
    snapshot = Snapshot(slot, 1, models, 10**18, lambda: notes)
    estimate = snapshot[PATCH.name]
    assert estimate.notes == ("it reads unlike its model",)
    assert snapshot.solvers == [estimate.solver] == ["ContactFit"]
    (found,) = snapshot[PATCH.name].contacts
    assert not snapshot.prepared  # nothing had to be
    assert (found.track_id, found.shape, found.radius) == (7, "line", 2e-3)
    assert (found.normal_force, found.force_std) == (1.5, pytest.approx(0.1))
    assert found.position.tobytes() == row["position"].tobytes()
    assert_allclose(found.covariance, np.diag([4e-8, 4e-8, 1e-2]))
    assert not snapshot[PATCH.name].pressure_std.any()  # of no pressure
    assert not snapshot.prepared


def test_a_line_has_the_border_of_what_is_near_to_a_segment() -> None:
    radius, half = 1.2e-3, 3e-3
    area, along = np.pi * radius**2 + 4 * radius * half, radius**2 / 5
    row = contact(area=area, shape=3, moments=(along, along + half**2 / 3, 0.0))[0]
    x, y, _ = outline_of(PATCH.surface, row).T
    assert_allclose([np.ptp(x), np.ptp(y)], [2 * radius, 2 * (radius + half)], rtol=1e-3)
    assert 0.5 * abs(x[:-1] @ y[1:] - x[1:] @ y[:-1]) == pytest.approx(area, rel=0.03)


def test_the_std_of_the_pressure_follows_place_force_and_area() -> None:
    middle = GRID.plane - (2e-3, -1e-3)
    pressure = 1e4 * np.maximum(1.0 - np.square(middle / 8e-3).sum(axis=1), 0.0)
    row = contact(2e-3, -1e-3, 1.5, area=AREA, peak_pressure=1e4, area_std=0.0)
    top = int(np.argmax(pressure))
    slope = np.gradient(pressure.reshape(GRID.shape), GRID.pitch)[1].ravel()
    for covariance, area, expected in (
        ((0, 0, 0, 0, 0, 0.09), 0.0, 0.2 * pressure),
        ((1e-8, 0, 0, 0, 0, 0), 0.0, 1e-4 * np.abs(slope)),
        ((0, 0, 0, 0, 0, 0), 0.3, 0.3 * pressure),
        ((1.0, 0, 1.0, 0, 0, 0), 0.0, np.full(len(GRID), 1e4) * (pressure > 0)),
    ):
        row["covariance"], row["area_std"] = covariance, area * AREA
        std = pressure_std_of_rows(row, GRID, pressure)
        where = np.hypot(*middle.T) < 6e-3
        where[top] = False  # where nothing moves
        assert_allclose(std[where], expected[where], rtol=1e-9)
    assert not pressure_std_of_rows(row[:0], GRID, pressure).any()
