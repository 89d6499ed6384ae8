"""Contacts of a sheet, window by window, against the dense solver's on all cells at once."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from test_readme import ROOT, follow
from test_sheet import DISTANCE, LAYER, jittered

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, InputError
from skinfield.estimate import PressureNoise
from skinfield.solve.sheet.contacts import TILE, WindowNoise, windows

TOUCHED = np.array([[0.02, 0.02], [0.032, 0.024], [0.065, 0.02], [0.055, 0.06]])


@lru_cache
def solved() -> tuple[sf.Sheet, ObservationModel, Floats, Floats]:
    """A sheet, the dense model of its cells, the dense solver's matrix and readings of touches."""
    places = jittered(14, np.random.default_rng(3))
    noise_std = np.random.default_rng(1).uniform(100.0, 300.0, len(places))
    sheet = sf.Sheet(
        places, LAYER, noise_std=noise_std, cut=3e-4, tolerance=1e-6, precision=np.float64
    )
    grid = sheet.grid
    model = ObservationModel.of(
        sheet.patch, LAYER, grid, sheet.mechanics, sheet.quantity, sheet.noise_std
    )
    pressed = np.zeros(len(grid))
    for place in TOUCHED:
        pressed += 3e4 * np.exp(-np.square(grid.plane - place).sum(axis=1) / 5e-3**2)
    noise = np.random.default_rng(4).normal(size=len(places)) * noise_std
    return sheet, model, sf.GaussianField().prepare(model).matrix, model.matrix @ pressed + noise


def whole(sheet: sf.Sheet, valid: Floats | None = None) -> WindowNoise:
    every = np.ones(len(sheet), dtype=bool) if valid is None else valid
    return WindowNoise.whole(sheet.plan, every)


def test_noise_is_that_of_the_dense_solver() -> None:
    sheet, _, matrix, _ = solved()
    exact, noise = PressureNoise(matrix * sheet.noise_std), whole(sheet)
    assert np.abs(noise.std - exact.std).max() < 1e-3 * exact.std.max()
    cells = np.flatnonzero(np.random.default_rng(0).uniform(size=len(exact.std)) < 0.03)
    weights = np.random.default_rng(1).normal(size=(3, len(cells)))
    covariance = exact.covariance_of_sums(cells, weights)
    error = np.abs(noise.covariance_of_sums(cells, weights) - covariance)
    assert error.max() < 2e-3 * np.abs(covariance).max()


def test_noise_of_a_window_is_that_of_the_whole() -> None:
    sheet, _, matrix, _ = solved()
    rows, columns = slice(20, 50), slice(30, 52)
    part = replace(whole(sheet), corner=(30, 20), shape=(30, 22))
    exact = PressureNoise(matrix * sheet.noise_std).std.reshape(sheet.shape)[rows, columns]
    assert np.abs(part.std - exact.ravel()).max() < 1e-3 * exact.max()


def test_noise_knows_of_silent_taxels() -> None:
    sheet = solved()[0]
    valid = np.zeros(len(sheet), dtype=bool)
    assert not whole(sheet, valid).std.any()
    assert not whole(sheet, valid).covariance_of_sums(np.arange(5), np.ones((2, 5))).any()


def test_contacts_are_the_dense_solvers() -> None:
    sheet, model, matrix, readings = solved()
    found = sheet(readings).contacts
    noise = PressureNoise(matrix * sheet.noise_std)
    exact = sf.ContactFinder()(model.grid, matrix @ readings, noise)
    assert len(found) == len(exact) >= len(TOUCHED)
    for mine, other in zip(found, exact, strict=True):
        assert np.abs(mine.position - other.position).max() < 20e-6
        assert mine.normal_force == pytest.approx(other.normal_force, rel=3e-3)
        assert mine.force_std == pytest.approx(other.force_std, rel=3e-3)
        assert mine.area_std == pytest.approx(other.area_std, rel=2e-2)
        assert len(np.setxor1d(mine.cells, other.cells)) <= 0.05 * len(other.cells)


def test_an_idle_sheet_has_no_contact() -> None:
    """The finder's rate is one false alarm in a thousand readings."""
    sheet = sf.Sheet(jittered(30, np.random.default_rng(5)), LAYER, noise_std=200.0)
    rng = np.random.default_rng(6)
    for _ in range(10):
        assert sheet(rng.normal(size=len(sheet)) * 200.0).contacts == ()


def test_faint_and_strong_contacts_far_apart() -> None:
    sheet = sf.Sheet(jittered(40, np.random.default_rng(7)), LAYER, noise_std=20.0)
    rows, columns = np.indices(sheet.shape)
    pressed = np.zeros(sheet.shape)
    for (row, column), peak in (((40, 40), 60e3), ((120, 120), 3e3)):
        pressed += peak * np.exp(-((rows - row) ** 2 + (columns - column) ** 2) / 3.5**2)
    estimate = sheet(sheet.predict(pressed.ravel()))
    found = estimate.contacts  # that drops what is below a fifth of the highest
    assert np.argmax(estimate.pressure) in found[0].cells
    faint = sheet.origin + np.array([120, 120]) * sheet.pitch
    apart = [np.hypot(*(contact.position[:2] - faint)) for contact in found]
    nearest = found[int(np.argmin(apart))]
    assert min(apart) < DISTANCE
    assert nearest.peak_pressure < 0.1 * found[0].peak_pressure


def test_nothing_but_silence() -> None:
    sheet = solved()[0]
    assert sheet(np.full(len(sheet), np.nan)).contacts == ()


def test_windows_hold_what_is_marked_once() -> None:
    rng = np.random.default_rng(0)
    high = rng.uniform(size=(230, 310)) < 2e-4
    count = np.zeros(high.shape, dtype=int)
    for rows, columns, free in windows(high):
        count[rows, columns] += free
    assert (count[high] == 1).all()
    for row, column in np.argwhere(high):  # with at least a tile around, once or more
        low, left = max(row - TILE, 0), max(column - TILE, 0)
        assert (count[low : row + TILE + 1, left : column + TILE + 1] >= 1).all()


def test_a_class_is_no_finder() -> None:
    with pytest.raises(InputError, match=r"ContactFinder\(\)"):
        sf.Sheet(jittered(3, np.random.default_rng(0)), LAYER, finder=sf.ContactFinder)


def test_the_page_on_sheets_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow(ROOT / "docs" / "sheet.md") == (1, 0)
