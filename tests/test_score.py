"""Scores of estimates whose errors are known, and the intervals of their summaries."""

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skinfield.elastic import Layer
from skinfield.errors import Floats, InputError
from skinfield.estimate import Contact, Estimate
from skinfield.lab.cases import Case, TrueContact, Truth
from skinfield.lab.score import (
    BLUR,
    STEP,
    Judge,
    Lattice,
    Row,
    blurred,
    matched,
    median_interval,
    summarise,
    write_csv,
)
from skinfield.skin import Grid, Patch
from skinfield.skin.generators import hexagon72

NAN = float("nan")


def bump(plane: Floats, place: tuple[float, float], width: float, force: float) -> Floats:
    """Gaussian pressure of a force, with a standard deviation."""
    square = ((plane - place) ** 2).sum(axis=1)
    return np.asarray(force / (2 * np.pi * width**2) * np.exp(-square / (2 * width**2)))


def true_on(grid: Grid, place: tuple[float, float] = (1e-3, 2e-3), force: float = 2.0) -> Truth:
    pressure = bump(grid.plane, place, 3e-3, force)
    sunk = bump(grid.plane, place, 4e-3, force * 1e-8)
    displacement = np.column_stack([np.zeros((len(grid), 2)), -sunk])
    return Truth(
        cell=grid.pitch, plane=grid.plane, pressure=pressure, displacement=displacement,
        contacts=(TrueContact(place, force, 40e-6),),
    )  # fmt: skip


def case_of(truth: Truth, patch: Patch) -> Case:
    return Case(
        name="case", patch=patch, layer=Layer(), quantity="stress", truth=truth,
        readings=np.zeros(len(patch)), noise_std=400.0,
    )  # fmt: skip


def contact_at(place: tuple[float, float], force: float, area: float = 40e-6) -> Contact:
    return Contact(
        position=np.array([*place, 0.0]),
        force=np.array([0.0, 0.0, -force]),
        moment=np.zeros(3),
        normal=np.array([0.0, 0.0, 1.0]),
        area=area,
        peak_pressure=1.0, covariance=np.zeros((3, 3)), area_std=0.0, radius=0.0, shape="other",
        outline=np.zeros((1, 3)), axes=np.zeros(2), angle=0.0, cells=np.zeros(1, dtype=np.int64),
    )  # fmt: skip


def estimate_of(
    grid: Grid, pressure: Floats, indentation: Floats, *contacts: Contact, **more: Any
) -> Estimate:
    return Estimate(
        grid=grid,
        pressure=pressure,
        traction=-pressure[:, None] * grid.normals,
        displacement=-indentation[:, None] * grid.normals,
        pressure_std=np.ones(len(grid)),
        contacts=contacts,
        residual=np.zeros(len(grid.patch)),
        valid=np.ones(len(grid.patch), dtype=np.bool_),
        readings=np.zeros(len(grid.patch)),
        readings_std=np.ones(len(grid.patch)),
        **more,
    )


@pytest.fixture(scope="module")
def patch() -> Patch:
    return hexagon72()


def score(case: Case, estimate: Estimate) -> Row:
    return Judge(case, estimate.grid)(estimate)


@pytest.mark.parametrize(("nodes", "pitch"), [((90, 100), 0.5e-3), ((41, 41), 1.3e-3)])
def test_the_truth_itself_scores_zero(patch: Patch, nodes: tuple[int, int], pitch: float) -> None:
    grid = Grid(patch, nodes, pitch, np.array([-22.3e-3, -20.1e-3]))
    truth = true_on(grid)
    case = case_of(truth, patch)
    contact = contact_at((1e-3, 2e-3), 2.0)
    got = score(case, estimate_of(grid, truth.pressure, -truth.displacement[:, 2], contact))
    assert got["force_error"] == pytest.approx(0.0, abs=1e-12)
    assert got["total_force_error"] == pytest.approx(0.0, abs=1e-4)  # of the bump's tails
    assert (got["missed"], got["false"], got["contacts"]) == (0, 0, 1)
    for name in ("place_error_mm", "contact_force_error", "area_error", "peak_error",
                 "pressure_error", "blurred_pressure_error", "deformation_error"):  # fmt: skip
        assert got[name] == pytest.approx(0.0, abs=1e-9), name


def test_scaled_estimates_are_off_by_the_scale(patch: Patch) -> None:
    grid = Grid.square(patch, nodes=60)
    truth = true_on(grid)
    found = estimate_of(
        grid, 1.3 * truth.pressure, -0.8 * truth.displacement[:, 2],
        contact_at((1e-3, 2e-3), 2.6, 30e-6),
    )  # fmt: skip
    got = score(case_of(truth, patch), found)
    assert got["total_force_error"] == pytest.approx(0.3, abs=1e-4)
    for name in ("force", "contact_force", "peak", "pressure", "blurred_pressure"):
        assert got[f"{name}_error"] == pytest.approx(0.3), name
    assert got["deformation_error"] == pytest.approx(0.2)
    assert got["area_error"] == pytest.approx(-0.25)


def test_shifted_estimates_are_off_as_two_gaussians_are(patch: Patch) -> None:
    grid = Grid.square(patch, nodes=90)
    truth, width, shift = true_on(grid), 3e-3, 2e-3
    pressure = bump(grid.plane, (1e-3 + shift, 2e-3), width, 2.0)
    found = estimate_of(grid, pressure, -truth.displacement[:, 2], contact_at((3e-3, 2e-3), 2.0))
    got = score(case_of(truth, patch), found)

    def apart(deviation: float) -> float:  # of two equal Gaussians, relative to one
        return float(np.sqrt(2 - 2 * np.exp(-(shift**2) / (4 * deviation**2))))

    assert got["place_error_mm"] == pytest.approx(2.0)
    assert got["pressure_error"] == pytest.approx(apart(width), rel=0.02)
    assert got["blurred_pressure_error"] == pytest.approx(apart(np.hypot(width, BLUR)), rel=0.01)
    assert got["deformation_error"] == pytest.approx(0.0, abs=1e-9)
    assert got["pressure_error"] > 1.15 * got["blurred_pressure_error"]


def test_coarse_and_fine_grids_agree_on_the_same_field(patch: Patch) -> None:
    fine = Grid.window(patch, [-15e-3, -15e-3], [17e-3, 19e-3], 0.4e-3)
    truth = true_on(fine)
    case = case_of(truth, patch)
    for pitch, sharp in ((0.7e-3, 0.02), (1.4e-3, 0.07), (2.6e-3, 0.2)):
        grid = Grid.window(patch, [-20e-3, -20e-3], [20e-3, 20e-3], pitch)
        found = estimate_of(
            grid, bump(grid.plane, (1e-3, 2e-3), 3e-3, 2.0),
            bump(grid.plane, (1e-3, 2e-3), 4e-3, 2e-8),
        )  # fmt: skip
        got = score(case, found)
        assert got["pressure_error"] < sharp
        assert got["blurred_pressure_error"] < sharp / 3
        assert got["deformation_error"] < sharp / 2
        assert got["total_force_error"] == pytest.approx(0.0, abs=1e-3)


@given(
    x=st.floats(-9e-3, 9e-3), y=st.floats(-9e-3, 9e-3), cell=st.floats(0.1e-3, 3e-3),
    angle=st.floats(0, 6.3),
)  # fmt: skip
def test_a_deposit_keeps_force_and_place(x: float, y: float, cell: float, angle: float) -> None:
    lattice = Lattice.around(np.array([-12e-3, -12e-3]), np.array([12e-3, 12e-3]))
    cross = np.array([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]]) * cell
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    plane, pressure = cross @ turn.T * 0.9 + [x, y], np.array([5.0, 1.0, 2.0, 3.0, -1.0])
    image = lattice.deposit(plane, pressure, cell)
    area, rows, columns = STEP**2, *np.indices(lattice.shape)
    assert image.sum() * area == pytest.approx(10.0 * cell**2, rel=1e-9)
    for axis, places in ((0, columns), (1, rows)):
        centre = (image * (places + lattice.first[axis])).sum() / image.sum() * STEP
        assert centre == pytest.approx(pressure @ plane[:, axis] / 10.0, abs=1e-9)
    assert blurred(image).sum() == pytest.approx(image.sum(), rel=0.02)


def test_matrices_deposit_as_single_cells_do(patch: Patch) -> None:
    grid = Grid(patch, (7, 5), 1.7e-3, np.array([-3.3e-3, 1.1e-3]))
    lattice = Lattice.around(grid.plane.min(axis=0) - 2e-3, grid.plane.max(axis=0) + 2e-3)
    pressure = np.random.default_rng(0).normal(size=len(grid))
    one_by_one = lattice.deposit(grid.plane, pressure, grid.pitch)
    np.testing.assert_allclose(lattice.of_grid(grid, pressure), one_by_one, atol=1e-12)


def test_contacts_are_assigned_to_the_nearest_as_a_whole(patch: Patch) -> None:
    true = [TrueContact((0.0, 0.0), 1.0), TrueContact((6e-3, 0.0), 2.0)]
    # the nearest to both is the one in the middle: taken greedily, the far one would be left over
    found = [contact_at((2.5e-3, 0.0), 1.9), contact_at((-4e-3, 0.0), 1.1)]
    matches, missed, false = matched(patch, true, found)
    assert [(m.true, m.estimated) for m in matches] == [(0, 1), (1, 0)]
    assert [m.distance for m in matches] == pytest.approx([4e-3, 3.5e-3])
    assert [m.force_error for m in matches] == pytest.approx([0.1, -0.05])
    assert (missed, false) == (0, 0)
    matches, missed, false = matched(patch, true, [*found, contact_at((20e-3, 0.0), 1.0)], 3.8e-3)
    assert [(m.true, m.estimated) for m in matches] == [(1, 0)] or [m.true for m in matches] == [0]
    assert (missed, false) == (1, 2)
    assert matched(patch, true, []) == ((), 2, 0)
    assert matched(patch, [], found) == ((), 0, 2)


def test_what_is_not_known_is_nan(patch: Patch) -> None:
    grid = Grid.square(patch, nodes=10)
    empty = Truth(
        cell=1e-3, plane=np.empty((0, 2)), pressure=[], displacement=np.empty((0, 3)), contacts=()
    )
    zero = np.zeros(len(grid))
    got = score(case_of(empty, patch), estimate_of(grid, zero, zero, contact_at((0, 0), 1.0)))
    assert (got["false"], got["missed"], got["contacts"]) == (1, 0, 0)
    for name in ("force_error", "place_error_mm", "peak_error", "pressure_error", "area_error"):
        assert np.isnan(got[name]), name
    truth = true_on(grid)
    blind = replace(truth, displacement=np.full((len(grid), 3), NAN))
    got = score(case_of(blind, patch), estimate_of(grid, truth.pressure, zero))
    assert np.isnan(got["deformation_error"])
    assert (got["force_error"], got["missed"]) == (-1.0, 1)


def test_an_estimate_of_another_skin_is_refused(patch: Patch) -> None:
    grid = Grid.square(patch, nodes=10)
    with pytest.raises(InputError, match="72 taxels, expected one of 3"):
        Judge(case_of(true_on(grid), Patch(np.eye(3) * 5e-3)), grid)
    with pytest.raises(InputError, match="gate is 0"):
        Judge(case_of(true_on(grid), patch), grid, 0.0)


def rows(errors: Floats, missed: int = 0, false: int = 0) -> list[Row]:
    one = {"case": "a", "contacts": 1, "matched": 0, "peak_error": NAN, "pressure_error": 0.5}
    return [
        one | {"force_error": error, "missed": int(k < missed), "false": int(k < false)}
        for k, error in enumerate(errors)
    ]


def test_a_summary_has_the_numbers_of_its_scores() -> None:
    errors = np.random.default_rng(0).normal(size=200)
    got = summarise(rows(errors, missed=20, false=4))
    assert got["force_error_median"] == pytest.approx(np.median(np.abs(errors)))
    assert got["force_error_p90"] == pytest.approx(np.quantile(np.abs(errors), 0.9))
    assert got["force_bias"] == pytest.approx(np.median(errors))
    assert got["force_error_low"] < got["force_error_median"] < got["force_error_high"]
    missed = [got[f"missed{end}"] for end in ("", "_low", "_high")]
    assert missed == pytest.approx((0.1, 0.0657, 0.1494), abs=1e-3)  # Wilson (1927): 20 of 200
    assert got["false_share"] == got["false_per_reading"] == 0.02
    assert np.isnan(got["peak_error_median"])
    with pytest.raises(InputError, match="rows is empty"):
        summarise([])
    single = summarise(rows(np.array([0.5])))
    assert single["force_error_median"] == pytest.approx(0.5)
    assert np.isnan(single["force_error_low"])  # no interval


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    rng, true = np.random.default_rng(1), 0.6744897501960817  # median of |normal|
    held = 0
    for _ in range(100):
        low, high = median_interval(np.abs(rng.normal(size=60)), resamples=199)
        held += low <= true <= high
    assert 88 <= held <= 100


def test_rows_in_files(tmp_path: Path) -> None:
    mixed = [*rows(np.array([0.25])), {"note": "sinks", "force_error": NAN}]
    write_csv(mixed, tmp_path / "a.csv")
    with (tmp_path / "a.csv").open() as file:
        table = list(csv.DictReader(file))
    assert (float(table[0]["force_error"]), table[0]["note"]) == (0.25, "")
    assert table[1]["force_error"] == table[1]["contacts"] == ""
