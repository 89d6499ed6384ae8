"""The accuracy table: its parts, its order, and what must come out of it."""

import csv
import json
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.experiments.accuracy.picture import accuracy_figure
from skinfield.experiments.accuracy.plan import (
    ANYWHERE,
    SHORT,
    SMOKE,
    AccuracyPlan,
    accuracy_plan,
    noise_per_count,
)
from skinfield.experiments.accuracy.rows import (
    SINKS,
    accuracy_rows,
    accuracy_table,
    accuracy_tasks,
    pose_places,
)
from skinfield.experiments.paper.presses import INNER, PLACES, TIPS, paper_patch
from skinfield.experiments.scoring.rows import Row, write_csv, write_json

TINY = replace(SMOKE, quantities=("stress",), noise_counts=(0.05, 3.5), poses=12, cell=0.5e-3)


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    return accuracy_table(TINY)


def test_every_combination_has_a_row(rows: list[Row]) -> None:
    heads = {(r["solver"], r["model"], r["load_N"], r["noise_counts"]) for r in rows}
    assert len(rows) == len(heads) == 2 * 2 * 2 * 2
    assert {r["quantity"] for r in rows} == {"stress"}
    assert {r["readings"] for r in rows} == {12}
    assert len({tuple(row) for row in rows}) == 1  # all have the same columns
    assert not any(row["note"] for row in rows)


def test_intervals_hold_their_medians(rows: list[Row]) -> None:
    names = [key[:-7] for key in rows[0] if key.endswith("_median")]
    assert {"force_error", "place_error_mm", "deformation_error"} <= set(names)
    for row in rows:
        for name in names:
            if np.isfinite(row[f"{name}_low"]):
                assert row[f"{name}_low"] <= row[f"{name}_median"] <= row[f"{name}_high"]
        assert row["missed_low"] <= row["missed"] <= row["missed_high"]


def test_less_noise_misses_less_and_the_bound_is_in_proportion(rows: list[Row]) -> None:
    def of(counts: float) -> list[Row]:
        return [row for row in rows if row["noise_counts"] == counts]

    quiet, loud = of(0.05), of(3.5)
    assert sum(row["missed"] for row in quiet) < sum(row["missed"] for row in loud)
    for one, other in zip(quiet, loud, strict=True):
        assert other["bound_place_mm"] == pytest.approx(70.0 * one["bound_place_mm"])
        assert other["noise_std"] == pytest.approx(70.0 * one["noise_std"])
    heavy = [row for row in quiet if row["load_N"] == 3.0]
    for row in heavy:  # far above the bound: what is between taxels is not seen by linear solvers
        assert row["missed"] < 0.1
        assert row["bound_place_mm"] < 0.05 < 0.3 < row["place_error_mm_median"] < 3.5
        assert row["bound_force"] < 0.02 < 0.04 < row["force_error_median"] < 0.7
        assert 0.2 < row["blurred_pressure_error_median"] < 0.9
        assert row["pressure_error_median"] > row["blurred_pressure_error_median"]


def test_tasks_are_independent_and_the_same_each_time(rows: list[Row]) -> None:
    tasks = pickle.loads(pickle.dumps(accuracy_tasks(TINY)))
    assert [name for name, _, _ in tasks] == ["half-sphere 1.2 cm 0.5 N", "half-sphere 1.2 cm 3 N"]
    _, function, arguments = tasks[1]
    alone = function(*arguments)
    assert [str(row) for row in alone] == [str(row) for row in rows[len(rows) // 2 :]]


def test_places_are_what_they_are_called() -> None:
    places = pose_places(SHORT, TIPS[0], 0.5)
    taxels = paper_patch().plane
    nearest = {
        name: np.sort(np.linalg.norm(taxels[None] - group[:, None], axis=2), axis=1)
        for name, group in places.items()
    }
    assert list(places) == [*PLACES, ANYWHERE]
    np.testing.assert_allclose(nearest["over a taxel"][:, 0], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.ptp(nearest["between two"][:, :2], axis=1), 0.0, atol=1e-8)
    assert np.ptp(nearest["between three"][:, :3], axis=1).max() < 0.4e-3
    for group in places.values():
        assert np.linalg.norm(group, axis=1).max() <= INNER


def test_what_sinks_is_said() -> None:
    [row] = accuracy_rows(TINY, TIPS[2], 3.0)  # 0.3 cm at 3 N
    assert row["note"] == SINKS
    assert (row["indenter"], row["load_N"]) == ("cylinder 0.3 cm", 3.0)


def test_one_count_is_worth_the_same_part_of_a_press_in_each_quantity() -> None:
    worth = noise_per_count(SHORT.layer, 0.5e-3)
    assert worth["capacitance"] == pytest.approx(1 / 171)
    # of a taxel below the ball at 1 N, from other solvers: 41.9 kPa for 0.2388 of ΔC/C₀
    assert worth["stress"] == pytest.approx(41.9e3 / 0.2388 / 171, rel=0.03)
    assert worth["gap"] < worth["capacitance"] < 1.3 * worth["gap"]


def test_plans_are_checked() -> None:
    assert accuracy_plan("smoke") is SMOKE
    with pytest.raises(InputError, match="size is 'huge'"):
        accuracy_plan("huge")
    with pytest.raises(InputError, match="poses is 1"):
        AccuracyPlan(poses=1)
    with pytest.raises(InputError, match="places is 'nowhere'"):
        AccuracyPlan(places=("nowhere",))
    with pytest.raises(InputError, match="noise_counts"):
        AccuracyPlan(noise_counts=(0.0,))


def test_rows_in_files(rows: list[Row], tmp_path: Path) -> None:
    mixed = [*rows, {"note": "sinks", "force_error_median": float("nan")}]
    write_csv(mixed, tmp_path / "a.csv")
    write_json(mixed, tmp_path / "a.json", seed=3)
    with (tmp_path / "a.csv").open() as file:
        table = list(csv.DictReader(file))
    assert len(table) == len(mixed)
    assert float(table[0]["load_N"]) == rows[0]["load_N"]
    assert table[-1]["force_error_median"] == table[-1]["solver"] == ""
    read = json.loads((tmp_path / "a.json").read_text())
    assert read["seed"] == 3
    assert read["rows"][-1]["force_error_median"] is None


def test_the_picture_holds_every_solver_and_the_bound(rows: list[Row], tmp_path: Path) -> None:
    figure = accuracy_figure(rows, noise_counts=0.05)
    assert len(figure.axes) == 3  # place, force and misses of one quantity
    names = figure.axes[0].get_legend_handles_labels()[1]
    assert set(names) == {
        "inverse (paper), half-space", "inverse (paper), layer", "Gaussian field, layer",
        "Cramér-Rao bound (rms)",
    }  # fmt: skip
    heights = [line.get_ydata() for line in figure.axes[0].get_lines()]
    bound = [row["bound_place_mm"] for row in rows if row["noise_counts"] == 0.05]
    assert any(np.allclose(line, sorted(set(bound), reverse=True)) for line in heights)
    figure.savefig(tmp_path / "a.png")
    with pytest.raises(InputError, match="no rows of"):
        accuracy_figure(rows, noise_counts=77.0)
