"""Habits of real skins: like what others have recorded, and the same seed gives the same skin."""

import json
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from scipy import stats

import skinfield as sf
from skinfield.elastic import Layer
from skinfield.emulator import VirtualSettings, VirtualSkin, press_tables
from skinfield.emulator.press_tables import FORCES, PressTable
from skinfield.emulator.scenes import SOFT, SceneTool
from skinfield.emulator.settings import HabitsName
from skinfield.errors import FileError, InputError
from skinfield.lab.habit_cases import FOAM, HabitCases
from skinfield.lab.scenarios import scenario_from_toml
from skinfield.lab.score import summarise
from skinfield.simulate import Finger, Sphere, press
from skinfield.simulate.electronics import Defects, Noise, cyskin_electronics, icub_electronics
from skinfield.simulate.electronics.array import Hysteresis
from skinfield.simulate.habits import HABITS, NONE, REAL, Tolerances, habits_by_name
from skinfield.simulate.rig import run_rig
from skinfield.skin.generators import by_name, rectangular

HABITS_OF_REAL = habits_by_name(REAL)


@pytest.fixture(scope="module")
def idle():
    """Counts of 21 idle recordings of 3 s at 10 Hz of a CySkin patch, as the real ones."""
    patch, rng = rectangular(25, 25), np.random.default_rng(0)
    usual = cyskin_electronics()
    usual = replace(usual, delivery=replace(usual.delivery, rate=10.0))
    sound = replace(HABITS_OF_REAL, defects=Defects())
    skin = sound.electronics(usual).manufacture(patch, rng)
    return np.concatenate([skin.counts(np.zeros((30, 625)), None, rng) for _ in range(21)])


def between(value, measured, factor):
    """Within a factor of what was measured on real ones, to both sides."""
    assert measured / factor < value < measured * factor


def test_idle_readings_are_like_those_of_a_real_patch(idle):
    std, rest = idle.std(axis=0), np.median(idle, axis=0)
    for share, measured in ((0.1, 13.0), (0.5, 93.0), (0.9, 273.0)):
        between(np.quantile(std, share), measured, 1.6)
    between(std.max(), 1020.0, 2.5)
    between(np.quantile(rest, 0.9), 304.0, 1.6)
    assert np.quantile(rest, 0.5) < 30.0
    assert 0.40 < (idle == 0.0).mean() < 0.56  # 0.48
    apart = np.abs(idle - rest) / np.where(std > 0.0, std, np.inf)
    between((apart > 5.0).mean(), 0.0028, 1.6)
    between((apart > 8.0).mean(), 0.00041, 2.5)
    assert 0.7 < (apart > 5.0).any(axis=1).mean() < 0.96  # 0.83
    moved = (idle[1:] - rest) * (idle[:-1] - rest)
    assert abs(moved.mean() / np.square(idle - rest).mean()) < 0.1  # white in time


def test_jumps_are_those_of_student():
    rng = np.random.default_rng(1)
    values = Noise(white=1.0, jumps=0.2).deviates((400_000,), rng, np.random.default_rng(2))
    far = 0.2 * 2 * stats.t.sf(5.0, 2.5) + 0.8 * 2 * stats.norm.sf(5.0)
    assert (np.abs(values) > 5.0).mean() == pytest.approx(far, rel=0.1)
    same = Noise(white=1.0).deviates(400_000, np.random.default_rng(1), np.random.default_rng(2))
    assert (same == values).mean() == pytest.approx(0.8, abs=0.01)


def test_hysteresis_opens_a_loop_and_closes_it():
    up = np.linspace(0.0, 0.5, 501)
    change = np.concatenate([up, up[::-1]])[:, None]
    seen = Hysteresis(width=0.04).applied(change)[:, 0]
    assert seen[:501] == pytest.approx(up)
    loop = seen[501:][::-1] - up
    assert loop.max() == pytest.approx(0.04 * 0.5, rel=0.01)
    assert up[loop.argmax()] == pytest.approx(0.25, abs=0.01)
    assert abs(loop[0]) < 1e-12
    assert abs(loop[-1]) < 1e-12
    again = Hysteresis(width=0.04).applied(np.tile(change, (2, 1)))[:, 0]
    assert again[len(seen) :] == pytest.approx(seen)  # at rest it is forgotten


def test_true_skins_lie_within_their_tolerances():
    stated, patch = Layer(2e-3, 150e3, 0.5), by_name("hexagon72")
    found = Tolerances(
        thickness_error=0.2, modulus_error=0.2, poisson_error=0.2, place_error=0.3e-3
    )
    skins = [found.layer(stated, np.random.default_rng(seed)) for seed in range(200)]
    thick = np.array([each.thickness for each in skins])
    assert 1.6e-3 < thick.min() < 1.65e-3
    assert 2.35e-3 < thick.max() < 2.4e-3
    ratios = np.array([each.poisson_ratio for each in skins])
    assert 0.4 < ratios.min() < 0.41
    assert 0.49 < ratios.max() <= 0.5
    assert skins[3] == found.layer(stated, np.random.default_rng(3))
    off = found.plane(patch, np.random.default_rng(0)) - patch.plane
    assert off.std() == pytest.approx(0.3e-3, rel=0.15)
    assert Tolerances().layer(stated, np.random.default_rng(0)) == stated


def test_a_habit_changes_no_other_draw():
    patch = by_name("hexagon72")
    usual = icub_electronics()
    skins = [
        habits.electronics(usual).manufacture(patch, np.random.default_rng(4))
        for habits in (HABITS_OF_REAL, replace(HABITS_OF_REAL, tared=False, gain_spread=0.0))
    ]
    assert skins[0].white_noise == pytest.approx(skins[1].white_noise)
    assert skins[0].defect.tolist() == skins[1].defect.tolist()
    assert habits_by_name(NONE).electronics(usual) == usual
    with pytest.raises(InputError, match="expected one of none, real"):
        habits_by_name("reel")


@pytest.mark.parametrize("second", [0.0, 0.4])
def test_a_finger_presses_with_its_force_where_it_is(second):
    finger = Finger(
        width=8e-3, length=14e-3, second=second, apart=24e-3 if second else 0.0,
        position=(2e-3, -3e-3), rotation=0.4, force=2.0,
    )  # fmt: skip
    made = press(FOAM, [finger], extent=70e-3, cell=0.5e-3)
    assert made.force == pytest.approx(2.0, rel=1e-12)
    assert made.moment[0] == pytest.approx(3e-3 * 2.0, abs=2e-5)
    assert made.moment[1] == pytest.approx(2e-3 * 2.0, abs=2e-5)
    area = np.pi * 8e-3 * 14e-3 / 4 * 2.0 ** (2 * finger.growth)
    assert made.contact_area == pytest.approx(area * (2 if second else 1), rel=0.02)
    highest = 1.5 * 2.0 * (1.0 - second) / area
    assert made.pressure.max() == pytest.approx(highest, rel=0.02)


def test_below_a_wide_finger_the_layer_yields_as_between_plates():
    layer = Layer(1e-3, 100e3, 0.3)
    made = press(layer, [Finger(width=30e-3, force=1.0)], extent=44e-3, cell=0.5e-3)
    stiff = 100e3 * 0.7 / (1.3 * 0.4)  # confined modulus
    peak = 1.5 / (np.pi * 15e-3**2)
    assert made.approach[0] == pytest.approx(1e-3 * peak / stiff, rel=0.02)


def test_what_fingers_cannot_is_said():
    for wrong in ({"depth": 1e-4}, {"shear": (1.0, 0.0)}, {"growth": 0.5}, {"second": 0.7}):
        with pytest.raises(InputError, match="expected"):
            Finger(**wrong)
    with pytest.raises(InputError, match="fingers alone or none"):
        press(FOAM, [Finger(), Sphere(radius=5e-3, position=(15e-3, 0.0))])
    with pytest.raises(InputError, match="overlap"):
        press(FOAM, [Finger(), Finger(position=(4e-3, 0.0))])
    with pytest.raises(InputError, match="sinks"):
        press(FOAM, [Finger(force=50.0)])
    with pytest.raises(InputError, match="raise extent"):
        press(FOAM, [Finger(position=(28e-3, 0.0))])


def test_single_fingers_read_as_on_a_real_patch():
    """Taxels above a tenth of the peak, and what its neighbours read."""
    rng = np.random.default_rng(0)
    offsets = 6e-3 * (np.mgrid[-4:5, -4:5].reshape(2, -1).T)
    counts, near, next_ = [], [], []
    for finger in HABITS_OF_REAL.fingers:
        made = press(FOAM, [replace(finger, force=2.0)], extent=70e-3, cell=1e-3)
        turns = rng.uniform(0.0, 2 * np.pi, 8)
        shifts = rng.uniform(-3e-3, 3e-3, (8, 2))
        spun = [
            (offsets + shift) @ [[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]
            for a, shift in zip(turns, shifts, strict=True)
        ]
        read = made.capacitance(np.concatenate(spun), 4e-3, order=3).reshape(8, -1)
        for each in read * np.exp(0.15 * rng.standard_normal(read.shape)):
            apart = np.linalg.norm(offsets - offsets[each.argmax()], axis=1)
            share = each / each.max()
            counts.append(int((share > 0.1).sum()))
            near += share[(apart > 5e-3) & (apart < 8e-3)].tolist()
            next_ += share[(apart > 8e-3) & (apart < 12e-3)].tolist()
    assert 5 <= np.median(counts) <= 13  # 10
    assert 0.08 < np.median(near) < 0.35  # 0.15
    assert 0.5 < np.quantile(near, 0.9) < 0.9  # 0.67
    assert np.median(next_) < 0.1  # 0.03
    assert 0.2 < np.quantile(next_, 0.9) < 0.8  # 0.72


@pytest.fixture(scope="module")
def made():
    maker = HabitCases(patch=by_name("rectangular:rows=9,columns=9,pitch_mm=6"))
    return list(maker.cases(2, seed=3, draws=3)), maker


def test_cases_of_habits_state_what_a_maker_does(made):
    (idle, pressed), maker = made
    assert idle.truth.contacts == ()
    assert len(pressed.truth.contacts) == 1
    assert pressed.layer == FOAM
    assert (pressed.patch.plane == maker.patch.plane).all()
    assert pressed.readings.shape == (3, 81)
    assert np.nanmax(pressed.readings) > 6 * np.nanmax(idle.readings[:, 40])
    place = np.array(pressed.truth.contacts[0].position)
    strongest = maker.patch.plane[np.nan_to_num(pressed.readings[0]).argmax()]
    assert np.linalg.norm(strongest - place) < 20e-3  # of the one or the other lobe
    assert 60.0 / 20e3 < np.median(idle.noise_std) < 900.0 / 20e3  # 275 of 20,000 on a real patch
    again = next(maker.cases(1, seed=3, draws=3))
    assert np.array_equal(again.readings, idle.readings, equal_nan=True)
    with pytest.raises(InputError, match="draws"):
        list(maker.cases(1, draws=0))
    with pytest.raises(InputError, match="larger one"):
        HabitCases(patch=by_name("icub_triangle"))._fingers(5, np.random.default_rng(0))


def test_scores_count_contacts_and_idle_skins():
    def row(contacts, matched, false):
        return {"contacts": contacts, "matched": matched, "missed": contacts - matched,
                "false": false, "force_error": 0.0}  # fmt: skip

    found = summarise([row(0, 0, 0), row(0, 0, 2), row(2, 2, 0), row(2, 1, 1), row(1, 1, 1)])
    assert found["count_right"] == pytest.approx(3 / 5)
    assert found["idle_touched"] == pytest.approx(1 / 2)


RIG = """skinfield_rig = 1
habits = "real"
seed = 2
patch.layout = "hexagon72"
loads.forces_n = [1.0]
layer = { poisson_ratio = 0.3, young_modulus_kpa = 75.0 }
profile = { rest_s = 1.0, hold_s = 0.5 }
solving = { extent_mm = 60.0, cell_mm = 1.0, rungs = 4 }
electronics = { preset = "cyskin", gain_spread = 0.3 }
"""


def test_a_rig_presses_a_skin_that_is_not_as_stated():
    scenario = scenario_from_toml(RIG)
    assert [tool.indenter.kind for tool in scenario.tools] == ["finger"] * 3
    assert scenario.tolerances == HABITS_OF_REAL.tolerances
    assert scenario.electronics.gain_spread == 0.3  # what the file says counts
    assert scenario.electronics.noise.jumps == HABITS_OF_REAL.jumps
    assert scenario.temperature.end > scenario.temperature.start
    one = replace(scenario, tools=scenario.tools[:1])
    truth = run_rig(one).truth
    assert truth.layer_thickness_m != one.layer.thickness
    assert truth.layer_thickness_m == one.true_layer.thickness
    off = np.linalg.norm(truth.taxel_plane_m - one.patch.plane, axis=1)
    assert 0.2e-3 < np.median(off) < 0.6e-3
    with pytest.raises(FileError, match="expected one of none, real"):
        scenario_from_toml(RIG.replace('"real"', '"reel"'))
    assert scenario_from_toml("skinfield_rig = 1").tolerances == Tolerances()


def test_the_virtual_skin_has_the_same_habits(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    table = PressTable(1.0, np.zeros(FORCES), np.ones((FORCES, 5)))
    monkeypatch.setattr(press_tables, "solve_table", lambda *_: table)
    assert set(get_args(HabitsName)) == set(HABITS)
    settings = VirtualSettings(
        hardware="cyskin", habits="real", scene="idle", control="", at_once=True, seed=3,
        layer=FOAM,
    )  # fmt: skip
    skin = VirtualSkin(settings)
    try:
        assert settings.noise_times == 1.0
        assert VirtualSettings().noise_times == 0.3
        assert skin.world.layer != FOAM
        assert skin.hardware.wires[0].chances["lose"] == HABITS_OF_REAL.lost_messages
        kinds = {fault.kind for fault in skin.hardware.converters.faults}
        assert kinds <= {"dead", "stuck"}
        assert kinds
        board = skin.hardware.converters
        times = 10**18 + 50_000_000 * np.arange(120)
        still = np.array([board.convert(0.0, int(t)) or board.counts[:72].copy() for t in times])
        assert 0.40 < (still == 0.0).mean() < 0.62
        board.change[:72] = 0.3
        pressed = np.array(
            [board.convert(0.0, int(t)) or board.counts[:72].copy() for t in times + 6 * 10**9]
        )
        at_first, at_last = np.median(pressed[:3]), np.median(pressed[-20:])
        assert 1.02 < at_last / at_first < 1.12  # creep of 7 %
    finally:
        skin.close()
    assert json.dumps(vars(skin.hardware.converters.faults[0]))


@pytest.mark.parametrize("shape", list(SOFT))
def test_parts_of_a_finger_are_all_of_it(shape):
    tool = SceneTool(10e-3, shape)
    places, shares = np.array(tool.parts).T
    assert shares.sum() == pytest.approx(1.0)
    assert places @ shares == pytest.approx(0.0, abs=1e-12)


def test_python_makes_a_scenario_with_habits():
    scenario = sf.simulate.rig.Scenario().with_habits(habits_by_name("real"))
    assert scenario.elastomer.relaxed_fraction > 0.9
    assert len(scenario.tools) == 3
