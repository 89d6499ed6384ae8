"""Accuracy on random presses: against other presses, bounds and chance."""

from collections import Counter
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.errors import FileError, InputError
from skinfield.lab import accuracy, case_sets
from skinfield.lab.accuracy import KNOWN, UNKNOWN, AccuracyPlan, Findings
from skinfield.lab.case_files import save_case
from skinfield.lab.case_sets import EXTENDED, SEVERAL, SINGLE, random_cases, random_press
from skinfield.lab.cases import Case
from skinfield.lab.score import column, where
from skinfield.lab.validation import (
    FLOORS,
    GAUSSIAN,
    PAPER,
    Entrant,
    NoiseLevel,
    at_level,
    known_entrants,
    rows_of_case,
)  # isort: skip # fmt: skip
from skinfield.simulate import Sphere
from skinfield.simulate.pressing.press import readings_anywhere
from skinfield.skin.generators import icub_hexagon, icub_triangle
from skinfield.solve import LinearOperator

PATCH = icub_hexagon()
FEW = 10


@lru_cache(maxsize=1)
def presses() -> list[case_sets.RandomPress]:
    return [random_press(PATCH, index, 7, cell=0.5e-3) for index in range(FEW)]


def case_of(press: case_sets.RandomPress) -> Case:
    return Case.from_press(press.name, press.press, PATCH, "stress", press.pose)


def test_shares_of_the_groups_and_what_is_in_them() -> None:
    assert Counter(case_sets.GROUPS) == {SINGLE: 12, SEVERAL: 5, EXTENDED: 3}
    for press in presses():
        kinds = {body.kind for body in press.press.indenters}
        if press.group == SINGLE:
            assert kinds <= {"ball", "cone"}
        if press.group == EXTENDED:
            assert kinds <= {"flat cylinder", "bar", "ring"}
        assert (len(press.press.indenters) > 1) == (press.group == SEVERAL)


def test_loads_depths_and_places_are_within_what_is_said() -> None:
    low, high = PATCH.plane.min(axis=0), PATCH.plane.max(axis=0)
    inner = 0.3 * (high - low)
    for press in presses():
        solved = press.press
        assert solved.approach.max() <= case_sets.DEEPEST * solved.layer.thickness
        assert (
            (solved.forces > 0.999 * case_sets.LOADS[0])
            & (solved.forces < 1.001 * case_sets.LOADS[1])
        ).all()
        places = np.array([contact.position for contact in case_of(press).truth.contacts])
        assert len(places) == len(solved.indenters)
        assert (np.abs(places - (low + high) / 2) <= inner + 0.2e-3).all()
        if press.group == SEVERAL:
            apart = np.linalg.norm(places[:, None] - places, axis=2)
            assert apart[np.triu_indices(len(places), 1)].min() > case_sets.APART[0] - 0.2e-3


def test_readings_are_those_of_the_press_moved_taxel_by_taxel() -> None:
    """The spline over the distance, and the pose, against the press solved at its place."""
    press = presses()[0]
    [body] = press.press.indenters
    there = replace(body, position=(press.pose.x, press.pose.y))
    direct = sf.simulate.press(press.press.layer, [there], extent=60e-3, cell=0.25e-3)
    expected = direct.base_stress(PATCH.plane, PATCH.pad_diameter)
    found = case_of(press).readings
    assert np.abs(found - expected).max() < 2e-3 * expected.max()


def test_the_same_seed_gives_the_same_cases() -> None:
    one, again = (
        [case.readings for case in random_cases(PATCH, 1, 7, "stress", 100.0, 2, cell=0.5e-3)]
        for _ in range(2)
    )
    np.testing.assert_array_equal(one, again)
    other = next(random_cases(PATCH, 1, 8, "stress", 100.0, 2, cell=0.5e-3))
    assert np.abs(other.readings - one[0]).max() > 1e3


def test_a_small_patch_has_no_room_for_several() -> None:
    with pytest.raises(InputError, match="take a larger patch"):
        random_press(icub_triangle(), 1, 0)


def test_a_soft_layer_bears_no_load(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skinfield.lab.case_sets.LOADINGS", 4)
    with pytest.raises(InputError, match="expected one that bears"):
        random_press(PATCH, 0, 0, layer=sf.Layer(0.3e-3, 3e3, 0.5), cell=0.5e-3)


def plan_of(**changes: object) -> AccuracyPlan:
    small = AccuracyPlan(
        entrants=known_entrants()[:2], levels=(NoiseLevel("stress", 380.0),), presses=2,
        cell=0.5e-3, idle=300,
    )  # fmt: skip
    return replace(small, **changes)  # type: ignore[arg-type]


def test_errors_at_the_bound_have_its_size() -> None:
    press = next(each for each in presses() if isinstance(each.press.indenters[0], Sphere))
    [contact], [ball] = case_of(press).truth.contacts, press.press.indenters
    balls = [
        replace(ball, position=(0.0, 0.0), force=contact.force * part) for part in (0.95, 1.0, 1.05)
    ]
    solved = [sf.simulate.press(case_sets.SILICONE, [each], 20e-3, 0.3e-3) for each in balls]
    reads = [readings_anywhere(each, PATCH.pad_diameter, "stress") for each in solved]
    seen, ways = PATCH.plane - contact.position, 0.1e-3 * np.eye(2)
    slopes = [(reads[1](seen - way) - reads[1](seen + way)) / 0.2e-3 for way in ways]
    by_force = (reads[2](seen) - reads[0](seen)) / np.log(1.05 / 0.95)
    jacobian = np.column_stack([*slopes, by_force]) / 380.0
    variance = np.diag(np.linalg.inv(jacobian.T @ jacobian))
    rows = accuracy.bound_rows(
        plan_of(), [ball], case_of(press).truth, np.random.default_rng(0), 4000
    )
    keys = ("place_error_mm", "force_error")
    known, unknown = (where(rows, method=name) for name in (KNOWN, UNKNOWN))
    rms = [np.sqrt(np.mean(column(known, key) ** 2)) for key in keys]
    expected = [1e3 * np.sqrt(variance[:2].sum()), np.sqrt(variance[2])]
    assert rms == pytest.approx(expected, rel=0.1)
    weaker = np.sqrt(np.mean(column(unknown, "force_error") ** 2))
    assert weaker > rms[1]  # a smaller ball presses as a weaker one


class Blind:
    """A field of nothing: it never finds a contact."""

    def prepare(self, model: ObservationModel) -> LinearOperator:
        nodes, taxels = len(model.grid), len(model.taxels)
        return LinearOperator(self, model, np.zeros((nodes, taxels)), np.ones(nodes))


def test_who_finds_nothing_misses_all_and_raises_no_alarm() -> None:
    blind = Entrant(name="blind", solver=Blind(), nodes=10)
    case = case_of(presses()[1])
    [row] = rows_of_case(case, [NoiseLevel("stress", 380.0)], [blind], 0)
    assert row["missed"] == row["contacts"] == len(presses()[1].press.indenters)
    assert (row["force_error"], row["false"], row["matched"]) == (-1.0, 0, 0)
    assert np.isnan(row["place_error_mm"])
    [quiet] = accuracy.idle_rows(Path(), plan_of(entrants=(blind,)), NoiseLevel("stress", 380.0))[
        "idle"
    ]
    assert (quiet["idle"], quiet["seen"]) == (300, 0)


def test_rows_of_the_known_methods() -> None:
    case = case_of(presses()[2])
    levels = [NoiseLevel("stress", 0.0), NoiseLevel("stress", 380.0)]
    rows = list(rows_of_case(case, levels, known_entrants()[:2], 0))
    assert [row["method"] for row in rows] == [PAPER, GAUSSIAN] * 2
    for row in rows:
        assert 0.0 < abs(row["force_error"]) < 1.2
        assert row["place_error_mm"] < 4.0
        assert min(row["cold_ms"], row["warm_ms"]) > 0.0
    again = list(rows_of_case(case, levels, known_entrants()[:2], 0))
    assert [r["force_error"] for r in again] == [r["force_error"] for r in rows]


def test_exact_readings_are_told_with_the_floor() -> None:
    case = case_of(presses()[2])
    exact = at_level(case, NoiseLevel("stress", 0.0), 3)
    np.testing.assert_array_equal(exact.readings, np.stack([case.readings] * 2))
    assert (exact.noise_std == FLOORS["stress"]).all()
    some = at_level(case, NoiseLevel("stress", 500.0), 3)
    spread = (some.readings - case.readings).std()
    assert 350 < spread < 650
    with pytest.raises(InputError, match="noise is -1"):
        NoiseLevel("stress", -1.0)


def test_table_of_rows_made_by_hand() -> None:
    rows = [
        {
            "case": f"{index}", "quantity": "stress", "noise": 380.0, "method": "m",
            "contacts": 1, "matched": 1, "missed": 0, "false": index % 2,
            "force_error": 0.1 * index, "place_error_mm": 1.0 * index,
            "contact_force_error": 0.2, "pressure_error": 0.6, "blurred_pressure_error": 0.3,
            "deformation_error": 0.4,
            "cold_ms": 10.0, "warm_ms": 1.0, "place_held": 1, "force_held": 0,
        }
        for index in range(11)
    ]  # fmt: skip
    idle = [{"quantity": "stress", "noise": 380.0, "method": "m", "idle": 100, "false": 3}]
    [row] = accuracy.accuracy_rows(Findings(rows, idle=idle), resamples=99)
    assert row["force_error_median"] == pytest.approx(0.5)
    assert row["place_error_mm_median"] == pytest.approx(5.0)
    assert row["place_error_mm_p90"] == pytest.approx(9.0)
    assert row["force_error_low"] < 0.5 < row["force_error_high"]
    assert row["false_per_reading"] == pytest.approx(5 / 11)
    assert row["idle_false_per_reading"] == pytest.approx(0.03)
    assert (row["missed"], row["place_held"], row["force_held"]) == (0.0, 1.0, 0.0)
    assert (row["cold_ms_median"], row["warm_ms_median"]) == (10.0, 1.0)


def test_a_campaign_from_its_parts() -> None:
    plan = plan_of(entrants=known_entrants(nodes=20)[:2], idle=50)
    steps: list[tuple[int, int]] = []
    found = accuracy.computed(plan, progress=lambda *step: steps.append(step))
    assert len(found.rows) == 2 * 2
    assert {row["method"] for row in found.bound} == {KNOWN, UNKNOWN}
    assert {row["idle"] for row in found.idle} == {50}
    assert steps == [(0, 2), (1, 2), (2, 2)]


def test_worlds_share_bodies_and_places_and_state_the_same_layer() -> None:
    """What is there differs from world to world, and what is stated does not."""
    made = {
        name: random_press(PATCH, 0, 7, cell=0.5e-3, world=world, group=SINGLE)
        for name, world in case_sets.WORLDS.items()
        if name in ("as-stated", "slipping", "cover", "released-0.1s")
    }
    cases = {
        name: case_sets.WORLDS[name].case(each, case_sets.SILICONE, case_of(each))
        for name, each in made.items()
    }
    usual, pushed = cases["as-stated"], cases["slipping"]
    assert {case.layer for case in cases.values()} == {case_sets.SILICONE}
    assert not any(case.mechanics.inextensible_cover for case in cases.values())
    assert made["cover"].press.mechanics.inextensible_cover
    assert len({tuple(each.pose) for each in made.values()}) == 1
    force = usual.truth.force
    assert pushed.truth.force == pytest.approx(force, rel=1e-6)
    assert np.hypot(*pushed.truth.contacts[0].shear) == pytest.approx(force / 2, rel=1e-4)
    assert usual.truth.contacts[0].shear == (0.0, 0.0)
    # 15 % of creep with a retardation time of 1/0.85 s: what is there, and what is left of it.
    late = case_sets.WORLDS["creep-1s"]
    assert late.share == pytest.approx(1 - 0.15 * np.exp(-0.85), rel=1e-6)
    crept = late.case(made["as-stated"], case_sets.SILICONE, usual).truth
    assert crept.force == pytest.approx(force / late.share, rel=1e-6)
    assert crept.pressure.sum() == pytest.approx(usual.truth.pressure.sum() / late.share)
    left = made["released-0.1s"].press.force / force
    assert left == pytest.approx(0.15 * np.exp(-0.085), rel=1e-6)
    assert cases["released-0.1s"].truth.contacts == ()
    assert np.abs(cases["released-0.1s"].readings).max() > 0


def test_creep_that_is_stated_comes_with_the_readings_before() -> None:
    """From rest on, in time, up to the reading; and what is left of a load fades with its field."""
    for name in ("creep-0.1s", "released-0.1s"):
        plain, world = case_sets.WORLDS[name], case_sets.WORLDS[f"{name}-stated"]
        made = random_press(PATCH, 0, 7, cell=0.5e-3, world=world, group=SINGLE)
        one = plain.case(made, case_sets.SILICONE, case_of(made))
        case = world.case(made, case_sets.SILICONE, case_of(made))
        assert (case.layer.relaxation, one.layer.relaxation) == (case_sets.CREEP, None)
        np.testing.assert_array_equal(case.readings, one.readings)
        times, before = case.history_s, np.abs(case.history).max(axis=1)
        assert (np.diff(times) > 0.0).all()
        assert times[-1] == pytest.approx(-case_sets.INTERVAL)
        assert (before[:3] == 0.0).all()
        last, now = before[-1], np.abs(case.readings).max()
        late = case_sets.CREEP.retardation_time
        if world.released:
            assert now / last == pytest.approx(np.exp(-case_sets.INTERVAL / late), rel=0.01)
            assert before.max() / now > 5.0
        else:
            assert 0.9 < last / now < 1.0
            share = made.press.force / case.truth.force
            assert share == pytest.approx(1.0 - 0.15 * np.exp(-0.1 / late), rel=1e-6)
        noisy = case.with_noise(3, 2, 0.01)
        assert np.std(noisy.history - case.history) == pytest.approx(0.01, rel=0.1)
        with pytest.raises(FileError, match="creeps"):
            save_case(case, "a.npz")


def test_a_table_of_worlds_has_a_row_for_each() -> None:
    plan = plan_of(entrants=known_entrants()[1:2], group=SINGLE)
    worlds = ("cover", "released-0.1s")
    made = [accuracy.rows_of_presses(Path(), plan, 0, 1, name) for name in worlds]
    assert not any(each["bound"] for each in made)  # it is of what is as stated
    found = Findings([row for each in made for row in each["rows"]])
    assert {row["group"] for row in found.rows} == {SINGLE}
    rows = accuracy.accuracy_rows(found, resamples=99)
    assert tuple(row["world"] for row in rows) == worlds
    assert [row["contacts"] for row in rows] == [1, 0]
