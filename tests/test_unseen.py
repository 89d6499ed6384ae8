"""Random unseen presses, and what is made of them: against other presses, bounds and chance."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

import skinfield as sf
from skinfield.errors import InputError
from skinfield.experiments.cases.unseen import (
    APART,
    DEEPEST,
    EXTENDED,
    GROUPS,
    LOADS,
    SEVERAL,
    SINGLE,
    UnseenPress,
    unseen_cases,
    unseen_press,
)
from skinfield.experiments.scoring.bound import bound_of, contact_family
from skinfield.experiments.section import Missing, Section
from skinfield.experiments.settings import SMOKE, Settings
from skinfield.experiments.trust.attempts import idle_rows, noisy, rows_of_case
from skinfield.experiments.trust.ball_bound import (
    KNOWN,
    UNKNOWN,
    BallTable,
    ball_profiles,
    bound_rows,
    radii,
)
from skinfield.experiments.trust.campaign import gathered, trust_parts
from skinfield.experiments.trust.plan import (
    FLOORS,
    GAUSSIAN,
    PAPER,
    Level,
    Method,
    TrustPlan,
    methods,
    trust_plan,
)
from skinfield.experiments.trust.section import trust
from skinfield.experiments.trust.table import accuracy_rows
from skinfield.experiments.trust.two_points import two_point_rows
from skinfield.inverse import InverseOperator
from skinfield.layout.generators import icub_hexagon, icub_triangle
from skinfield.observation import ObservationModel
from skinfield.simulate import Sphere

PATCH = icub_hexagon()
FEW = 20


@lru_cache(maxsize=1)
def presses() -> list[UnseenPress]:
    return [unseen_press(PATCH, index, 7, cell=0.5e-3) for index in range(FEW)]


def test_shares_of_the_groups_and_what_is_in_them() -> None:
    shares = {group: GROUPS.count(group) / len(GROUPS) for group in (SINGLE, SEVERAL, EXTENDED)}
    assert shares == {SINGLE: 0.60, SEVERAL: 0.25, EXTENDED: 0.15}
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
        assert solved.approach.max() <= DEEPEST * solved.layer.thickness
        assert ((solved.forces > 0.999 * LOADS[0]) & (solved.forces < 1.001 * LOADS[1])).all()
        places = np.array([contact.position for contact in press.truth.contacts])
        assert len(places) == len(solved.indenters)
        assert (np.abs(places - (low + high) / 2) <= inner + 0.2e-3).all()
        if press.group == SEVERAL:
            apart = np.linalg.norm(places[:, None] - places, axis=2)
            assert apart[np.triu_indices(len(places), 1)].min() > APART[0] - 0.2e-3


def test_readings_are_those_of_the_press_moved_taxel_by_taxel() -> None:
    """The spline over the distance, and the pose, against the press solved at its place."""
    press = presses()[0]
    body = press.press.indenters[0]
    assert isinstance(body, Sphere)
    there = replace(body, position=(press.pose.x, press.pose.y))
    direct = sf.simulate.press(press.press.layer, [there], extent=60e-3, cell=0.25e-3)
    expected = direct.base_stress(PATCH.plane, PATCH.pad_diameter)
    found = press.case(PATCH, "stress").readings
    assert np.abs(found - expected).max() < 2e-3 * expected.max()


def test_the_same_seed_gives_the_same_cases() -> None:
    one, again = (
        [case.readings for case in unseen_cases(PATCH, 2, 7, "stress", 100.0, 2, cell=0.5e-3)]
        for _ in range(2)
    )
    np.testing.assert_array_equal(one, again)
    other = next(unseen_cases(PATCH, 1, 8, "stress", 100.0, 2, cell=0.5e-3))
    assert np.abs(other.readings - one[0]).max() > 1e3


def test_a_small_patch_has_no_room_for_several() -> None:
    with pytest.raises(InputError, match="take a larger patch"):
        unseen_press(icub_triangle(), 1, 0)


def test_a_soft_layer_bears_no_load() -> None:
    with pytest.raises(InputError, match="expected one that bears"):
        unseen_press(PATCH, 0, 0, layer=sf.Layer(0.3e-3, 3e3, 0.5), cell=0.5e-3)


def plan_of(**changes: object) -> TrustPlan:
    small = TrustPlan(
        methods=methods()[:2], levels=(Level("stress", 380.0),), presses=2, bound_grid=(6, 6),
        cell=0.5e-3, idle=300, trials=8, resamples=99,
    )  # fmt: skip
    return replace(small, **changes)  # type: ignore[arg-type]


def test_a_gate_is_a_distance() -> None:
    with pytest.raises(InputError, match="gate is 0, expected a finite number above 0"):
        plan_of(gate=0)


@lru_cache(maxsize=1)
def ball_table() -> list[dict[str, object]]:
    return [ball_profiles(plan_of(), radius) for radius in radii(plan_of())]


@pytest.mark.parametrize(("radius", "force"), [(3e-3, 0.5), (9e-3, 1.5)])
def test_derivatives_of_the_table_are_those_of_presses(radius: float, force: float) -> None:
    plan, place = plan_of(), np.array([3.1e-3, 4.2e-3])
    family = contact_family(
        plan.layer, Sphere(radius=radius, force=force), "stress", PATCH.pad_diameter,
        extent=20e-3, size="radius",
    )  # fmt: skip
    direct = family.jacobian(PATCH.plane - place)
    found = BallTable(ball_table(), "stress").jacobian(PATCH.plane, place, radius, force)
    scale = np.abs(direct).max(axis=0)
    assert (np.abs(found - direct).max(axis=0) / scale < [0.01, 0.01, 0.01, 0.2]).all()
    for columns, prior, within in ((3, None, 0.01), (4, 0.6, 0.06)):
        ours, theirs = (bound_of(each[:, :columns], 380.0, prior) for each in (found, direct))
        assert ours.place == pytest.approx(theirs.place, rel=within)
        assert ours.force == pytest.approx(theirs.force, rel=within)


def test_errors_at_the_bound_have_its_size() -> None:
    ball = {"case": "a", "x": 3.1e-3, "y": 4.2e-3, "radius": 6e-3, "force": 1.0}
    rows = bound_rows(plan_of(), ball_table(), [ball], draws=4000)
    taxels, place = PATCH.plane, np.array([3.1e-3, 4.2e-3])
    exact = BallTable(ball_table(), "stress").jacobian(taxels, place, 6e-3, 1.0)
    for name, columns, prior in ((KNOWN, 3, None), (UNKNOWN, 4, 0.6)):
        mine = [row for row in rows if row["method"] == name]
        bound = bound_of(exact[:, :columns], 380.0, prior)
        place_rms = np.sqrt(np.mean([row["place_error_m"] ** 2 for row in mine]))
        force_rms = np.sqrt(np.mean([row["force_error"] ** 2 for row in mine]))
        assert place_rms == pytest.approx(bound.place, rel=0.05)
        assert force_rms == pytest.approx(bound.force, rel=0.05)


def test_far_balls_have_the_bounds_that_each_has_alone() -> None:
    """Joint information of two balls 26 mm apart against that of each."""
    balls = [
        {"case": "two", "x": x, "y": 0.0, "radius": 4e-3, "force": 1.0} for x in (-13e-3, 13e-3)
    ]
    alone = [ball | {"case": f"{index}"} for index, ball in enumerate(balls)]
    rows = bound_rows(plan_of(), ball_table(), [*balls, *alone], draws=4000)
    known = [row for row in rows if row["method"] == KNOWN]
    each = [
        np.mean([row["place_error_m"] for row in known if row["case"] == case])
        for case in ("two", "0", "1")
    ]
    assert each[0] == pytest.approx((each[1] + each[2]) / 2, rel=0.06)


class Blind:
    """A field of nothing: it never finds a contact."""

    def prepare(self, model: ObservationModel) -> InverseOperator:
        nodes, taxels = len(model.grid), len(model.taxels)
        return InverseOperator(np.zeros((nodes, taxels)), np.ones(nodes))


def test_who_finds_nothing_misses_all_and_raises_no_alarm() -> None:
    blind = Method("blind", Blind(), nodes=10)
    case = presses()[1].case(PATCH, "stress")
    [row] = rows_of_case(case, [Level("stress", 380.0)], [blind], 0)
    assert row["missed"] == row["contacts"] == len(presses()[1].press.indenters)
    assert (row["force_error"], row["false"], row["matched"]) == (1.0, 0, 0)
    assert np.isnan(row["place_error_m"])
    [quiet] = idle_rows(plan_of(methods=(blind,)), Level("stress", 380.0))["idle"]
    assert (quiet["idle"], quiet["seen"]) == (300, 0)


def test_rows_of_the_known_methods() -> None:
    case = presses()[2].case(PATCH, "stress")
    levels = [Level("stress", 0.0), Level("stress", 380.0)]
    rows = list(rows_of_case(case, levels, methods()[:2], 0))
    assert [row["method"] for row in rows] == [PAPER, GAUSSIAN] * 2
    for row in rows:
        assert 0.0 < row["force_error"] < 1.2
        assert row["place_error_m"] < 4e-3
        assert min(row["cold_s"], row["warm_s"]) > 0.0
    again = list(rows_of_case(case, levels, methods()[:2], 0))
    assert [r["force_error"] for r in again] == [r["force_error"] for r in rows]


def test_exact_readings_are_told_with_the_floor() -> None:
    case = presses()[2].case(PATCH, "stress")
    exact = noisy(case, Level("stress", 0.0), 3)
    np.testing.assert_array_equal(exact.readings, np.stack([case.readings] * 2))
    assert (exact.noise_std == FLOORS["stress"]).all()
    some = noisy(case, Level("stress", 500.0), 3)
    spread = (some.readings - case.readings).std()
    assert 350 < spread < 650
    with pytest.raises(InputError, match="noise is -1"):
        Level("stress", -1.0)


def test_two_balls_far_apart_are_two_and_close_ones_are_not() -> None:
    level = Level("stress", 100.0)
    plan = plan_of(pairs=(level,), methods=methods()[1:2])
    found = {
        distance: two_point_rows(plan, distance)["pairs"][0]["found"] for distance in (4e-3, 16e-3)
    }
    assert found[4e-3] <= 1
    assert found[16e-3] >= 5  # of eight


def test_table_of_rows_made_by_hand() -> None:
    rows = [
        {
            "case": f"{index}", "quantity": "stress", "noise": 380.0, "method": "m",
            "contacts": 1, "matched": 1, "missed": 0, "false": index % 2,
            "force_error": 0.1 * index, "place_error_m": 1e-3 * index,
            "contact_force_error": 0.2, "blurred_pressure_error": 0.3, "deformation_error": 0.4,
            "cold_s": 0.01, "warm_s": 0.001, "place_held": 1, "force_held": 0,
        }
        for index in range(11)
    ]  # fmt: skip
    idle = [{"quantity": "stress", "noise": 380.0, "method": "m", "idle": 100, "false": 3}]
    [row] = accuracy_rows(rows, (), idle, resamples=99)
    assert row["force_error_median"] == pytest.approx(0.5)
    assert row["place_error_mm_median"] == pytest.approx(5.0)
    assert row["place_error_mm_p90"] == pytest.approx(9.0)
    assert row["force_error_low"] < 0.5 < row["force_error_high"]
    assert row["false_per_reading"] == pytest.approx(5 / 11)
    assert row["idle_false_per_reading"] == pytest.approx(0.03)
    assert (row["missed"], row["place_held"], row["force_held"]) == (0.0, 1.0, 0.0)
    assert (row["cold_ms_median"], row["warm_ms_median"]) == (10.0, 1.0)


def test_the_section_from_its_parts() -> None:
    plan = replace(trust_plan("smoke"), methods=methods()[:2])
    results = [
        part.function(*part.arguments)
        for part in trust_parts(replace(plan, presses=2, idle=50, trials=4))
    ]
    found = gathered(plan, results)
    assert len(found.rows) == 2 * 2
    assert {row["method"] for row in found.bound} == {KNOWN, UNKNOWN}
    section = trust(Settings(size=SMOKE), results)
    assert isinstance(section, Section)
    assert [picture.name for picture in section.pictures] == ["errors-stress", "two-points"]
    assert all(picture.png.startswith(b"\x89PNG") for picture in section.pictures)
    assert isinstance(trust(Settings(size=SMOKE), [None]), Missing)
