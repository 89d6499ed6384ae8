"""Rows of contacts against the finder's contacts."""

import tracemalloc

import numpy as np
import pytest
from contact_scenes import FINDERS, bumps, errors_on, grids, scenes

from skinfield.errors import InputError
from skinfield.estimate import Contact, ContactFinder, ContactTable, PressureNoise, summarise
from skinfield.skin import Grid

FLAT = {name: grid for name, grid in grids().items() if grid.patch.surface.is_flat}


def check_rows(grid: Grid, rows: np.ndarray, contacts: tuple[Contact, ...]) -> None:
    """Compare, in the same order."""
    frame = grid.patch.surface.frame_from_plane(np.zeros((1, 2)))[0, :, :2]
    origin = grid.patch.surface.position_from_plane(np.zeros((1, 2)))[0]
    expected = np.array(
        [
            (
                *((contact.position - origin) @ frame),
                contact.normal_force,
                contact.area,
                contact.peak_pressure,
                len(contact.cells),
            )
            for contact in contacts
        ]
    ).reshape(-1, 6)
    found = np.array([list(row) for row in rows]).reshape(-1, 6)
    assert np.all(np.diff(found[:, 2]) <= 1e-9 * found[1:, 2])
    assert found[:, :2] == pytest.approx(expected[:, :2], abs=1e-9 * grid.pitch)
    assert found[:, 2:] == pytest.approx(expected[:, 2:], rel=1e-9)


@pytest.mark.parametrize("kind", list(FLAT))
def test_rows_are_the_finders_contacts(kind: str) -> None:
    found = 0
    for scene in scenes(seed=21, each=4, kinds={kind: FLAT[kind]}):
        grid, noise = scene.grid, scene.noise
        table = ContactTable(grid, 1 + len(grid), finder=scene.finder, noise=noise)
        contacts = scene()
        assert table(scene.pressure) == len(contacts), scene.name
        strong = [c for c in contacts if c.normal_force > 1e-5 * contacts[0].normal_force]
        check_rows(grid, table.rows[: len(strong)], tuple(strong))
        found += len(contacts)
    assert found > 4


@pytest.mark.parametrize("finder", FINDERS, ids=range(len(FINDERS)))
def test_a_field_that_is_0_where_nothing_presses_needs_no_noise(finder: ContactFinder) -> None:
    """Peak, saddle and edge go by the same rules; any pressure stands out of no noise."""
    grid, rng = grids()["hexagon"], np.random.default_rng(2)
    still = PressureNoise(np.zeros((len(grid), 1)))
    table = ContactTable(grid, 50, finder=finder)
    for count in (0, 1, 2, 3, 5):
        pressure = np.maximum(bumps(grid, rng, count) - 2e3, 0.0)
        contacts = finder(grid, pressure, still)
        assert table(pressure) == len(contacts)
        check_rows(grid, table.rows[: len(contacts)], contacts)
        check_rows(grid, summarise(grid, pressure, rows=50, finder=finder), contacts)


def test_on_a_curved_skin_the_force_is_the_sum_of_the_pressure() -> None:
    grid = grids()["pipe"]
    pressure = 1e4 * (np.hypot(*(grid.plane - grid.plane.mean(axis=0)).T) < 6e-3)
    (row,) = summarise(grid, pressure)
    (contact,) = ContactFinder()(grid, pressure, PressureNoise(np.zeros((len(grid), 1))))
    assert row["normal_force"] == pytest.approx(pressure.sum() * grid.cell_area)
    assert 0.95 < contact.normal_force / row["normal_force"] < 1.0
    place = np.array([[row["x"], row["y"]]])
    assert grid.patch.surface.position_from_plane(place)[0] == pytest.approx(contact.position)


def test_the_strongest_are_told_and_all_are_counted() -> None:
    grid, rng = grids()["hexagon"], np.random.default_rng(8)
    pressure = np.abs(rng.normal(size=len(grid)))
    finder = ContactFinder(relative_height=0.1, prominence=0.2, edge=0.5)
    whole = ContactTable(grid, 500, finder=finder)
    count = whole(pressure)
    assert count > 20
    for rows in (1, 5, count):
        table = ContactTable(grid, rows, finder=finder)
        assert table(pressure) == count
        assert table.rows.tolist() == whole.rows[:rows].tolist()


def test_a_table_serves_one_field_after_the_other() -> None:
    grid, rng = grids()["coarse"], np.random.default_rng(4)
    noise, _ = errors_on(grid, rng)
    kept = ContactTable(grid, noise=noise)
    for count in (3, 0, 1, 8, 2, 0):
        pressure = bumps(grid, rng, count)
        fresh = summarise(grid, pressure, noise=noise)
        assert kept(pressure) == len(fresh)
        assert kept.rows[: len(fresh)].tolist() == fresh.tolist()
    assert kept(np.full(len(grid), np.nan)) == 0


def test_nothing_is_allocated_per_field() -> None:
    grid = grids()["hexagon"]
    table, pressure = ContactTable(grid), bumps(grid, np.random.default_rng(1), 3)
    table(pressure)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        for _ in range(100):
            table(pressure)
        assert tracemalloc.get_traced_memory()[1] - before < 2000  # Python's own numbers
    finally:
        tracemalloc.stop()


def test_arguments_are_checked() -> None:
    grid = grids()["coarse"]
    with pytest.raises(InputError, match="rows is 0, expected 1 or more"):
        ContactTable(grid, 0)
    with pytest.raises(InputError, match="pressure has shape"):
        ContactTable(grid)(np.zeros(3))
    with pytest.raises(InputError, match=r"noise\.std has shape"):
        ContactTable(grid, noise=PressureNoise(np.zeros((3, 1))))
