"""Creep compensation against closed forms, an ODE solver, presses, and at every door."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live_skins import GAIN, REST, cycle_of, settings
from scipy.integrate import solve_ivp
from test_live_update import NOW, STEP, answered

import skinfield as sf
from skinfield.errors import InputError
from skinfield.signal.creep import CreepCompensation
from skinfield.simulate import Sphere, press

SOLID = sf.StandardLinearSolid(relaxed_fraction=0.85, time_constant=1.0)
PATCH = sf.layouts.hexagon72()
NS = 1_000_000_000
SIGMA = 5e-4


def undone(time, strain, solid=SOLID, quantity=None, valid=None):
    """Readings (T,) or (T, L) of a stress, or of another quantity, at times (T,) s."""
    table = np.asarray(strain, float).reshape(len(time), -1)
    creep = CreepCompensation.of(solid, table.shape[1], quantity or sf.BaseStress())
    every = np.ones(table.shape, bool) if valid is None else valid
    stamps = NS + np.rint(np.asarray(time) * 1e9).astype(np.int64)
    return creep.taken(table, every, stamps).reshape(np.shape(strain))


histories = st.lists(
    st.tuples(st.sampled_from([0, 1, 20_000_000, NS // 2, 40 * NS]), st.floats(-0.5, 0.5)),
    min_size=1,
    max_size=40,
)


@given(history=histories, part=st.floats(0.2, 0.99), seconds=st.floats(0.01, 50.0))
def test_it_undoes_what_the_solid_does_to_any_history(history, part, seconds) -> None:
    """Steps, ramps and pauses of any length: both directions are inverse to each other."""
    solid = sf.StandardLinearSolid(part, seconds)
    time, load = np.cumsum([each[0] for each in history]) / 1e9, [each[1] for each in history]
    felt = solid.effective_force(time, load)
    assert undone(time, felt, solid) == pytest.approx(load, abs=1e-9 / part)
    pressed = np.abs(load)
    strain = solid.effective_force(time, pressed)
    read = strain / (1.0 - strain)
    true = np.minimum(pressed, 0.95)
    assert undone(time, read, solid, sf.Capacitance()) == pytest.approx(
        true / (1.0 - true), rel=1e-6, abs=1e-8
    )


def test_a_step_and_a_ramp_by_their_closed_forms() -> None:
    time = np.r_[0.0, np.sort(np.random.default_rng(3).uniform(0.0, 6.0, 899))]
    late = SOLID.retardation_time
    step = 0.3 * (1.0 - 0.15 * np.exp(-time / late))
    assert undone(time, step) == pytest.approx(np.full(900, 0.3), abs=1e-9)
    ramp = 0.05 * (time - 0.15 * late * (1.0 - np.exp(-time / late)))
    assert undone(time, ramp) == pytest.approx(0.05 * time, abs=1e-9)


def test_a_smooth_load_by_an_ode_solver_at_irregular_times() -> None:
    """Taken ten times as often, what is between the readings is off a hundred times less."""

    def load(t):
        return 0.2 * np.sin(1.7 * t) ** 2

    def lag(t, z):
        return (load(t) - z) / SOLID.retardation_time

    off = []
    for count in (60, 600):
        time = np.sort(np.r_[0.0, np.random.default_rng(1).uniform(0.0, 6.0, count)])
        late = solve_ivp(lag, (0.0, 6.0), [0.0], t_eval=time, rtol=1e-11, atol=1e-13).y[0]
        felt = 0.85 * load(time) + 0.15 * late
        off.append(np.abs(undone(time, felt) - load(time)).max())
    assert 1e-6 < off[0] < 1e-3
    assert off[1] < off[0] / 20


def test_a_long_pause_forgets_and_rest_stays_rest() -> None:
    time = np.array([0.0, 1.0, 1e6])
    assert undone(time, np.array([0.0, 0.2, 0.1]))[2] == pytest.approx(0.1, rel=1e-5)
    assert (undone(np.arange(9.0), np.zeros(9)) == 0.0).all()


def test_what_is_left_of_a_deep_press_never_becomes_a_pull() -> None:
    """The strain of a gap that is not even overstates what a press leaves."""
    time = np.r_[np.arange(0.0, 4.0, 0.02), 4.0 + np.arange(0.02, 1.0, 0.02)]
    held, left = 0.3, 0.5 * 0.3 * 0.15  # half of what the strain would leave
    strain = np.where(time < 4.0, held, left * np.exp(-(time - 4.0) / SOLID.retardation_time))
    c = undone(time, strain / (1.0 - strain), quantity=sf.Capacitance())
    assert (c[time > 4.0] == 0.0).all()
    assert undone(time, strain)[time > 4.0].max() < 0.0  # of a quantity that is linear


def test_lost_readings_change_nothing_for_the_others_and_are_bridged() -> None:
    time = np.arange(0.0, 3.0, 0.01)
    load = np.clip(time - 0.5, 0.0, 0.3)
    felt = SOLID.effective_force(time, load)
    table, valid = np.column_stack([felt, felt, felt]), np.ones((300, 3), bool)
    valid[100:140, 1], table[100:140, 1] = False, 77.0
    table[100:140, 2] = np.nan
    got = undone(time, table, valid=valid)
    assert got[:, 0] == pytest.approx(load, abs=1e-12)
    assert (got[100:140, 1] == 77.0).all()
    assert np.isnan(got[100:140, 2]).all()
    assert got[140:, 1:] == pytest.approx(np.column_stack([load, load])[140:], abs=1e-12)


def test_noise_grows_as_stated() -> None:
    time = np.arange(4000) * 0.01
    noise = np.random.default_rng(0).normal(0.0, SIGMA, (4000, 20))
    stated = CreepCompensation.of(SOLID, 20, sf.BaseStress()).noise_factor
    assert stated == pytest.approx(np.full(20, 1.0 / 0.85))
    assert undone(time, noise).std() / SIGMA == pytest.approx(stated[0], rel=0.01)


@cache
def held_press():
    """Times (T,), loads (T,) and readings (T, 72) of a ball that is laid down and lifted again.

    While it presses, the elastic solution at the effective force; then what is left of its field.
    """
    loads = np.array([0.85, 0.925, 1.0])
    pressed = [press(sf.Layer(), [Sphere(radius=6e-3, force=float(f))]) for f in loads]
    places = PATCH.plane - PATCH.plane[30] - [0.8e-3, 0.3e-3]
    read = [each.capacitance(places, PATCH.pad_diameter) for each in pressed]
    terms = np.polynomial.polynomial.polyfit(loads, read, 2)
    time = np.arange(-0.11, 4.5, 0.02)
    force = ((time > 0.0) & (time < 4.0)).astype(float)
    late = SOLID.retardation_time
    crept = np.polynomial.polynomial.polyval(1.0 - 0.15 * np.exp(-time / late), terms).T
    whole = pressed[-1].touches
    last = replace(
        pressed[-1], touches=tuple(replace(t, traction=0.1 * t.traction) for t in whole)
    ).capacitance(places, PATCH.pad_diameter)
    left = 1.5 * last * np.exp(-(time[:, None] - 4.0) / late)
    rows = np.where(force[:, None] > 0.0, crept, np.where(time[:, None] > 4.0, left, 0.0))
    noise = np.random.default_rng(7).normal(0.0, SIGMA, rows.shape)
    return time, force, rows + noise


LAYERS = sf.Layer(), sf.Layer(relaxation=SOLID)
FEW = [*range(0, 30), *range(60, 200, 20), *range(200, 231)]


def stamps_of(time):
    return NS + np.rint((time + 1.0) * 1e9).astype(np.int64)


def test_force_is_right_from_the_touch_on_and_nothing_is_left_of_it() -> None:
    time, _, read = (each[FEW] for each in held_press())
    off, ghosts = [], []
    for layer in LAYERS:
        rec = sf.Reconstructor(PATCH, layer, noise_std=SIGMA)
        est = rec(read, stamp_ns=stamps_of(time))
        found = np.array(est.normal_force)
        off.append(np.median(found[(time > 0.1) & (time < 0.6)]) - 1.0)
        ghosts.append((found[time > 4.09] > 0.0).mean())
    assert -0.2 < off[0] < -0.08
    assert abs(off[1]) < 0.04
    assert ghosts[0] > 0.5
    assert ghosts[1] == 0.0


def test_without_stamps_a_reading_has_stood_for_long() -> None:
    read = held_press()[2][150]
    rec = sf.Reconstructor(PATCH, LAYERS[1], noise_std=SIGMA)
    plain = sf.Reconstructor(PATCH, LAYERS[0], noise_std=SIGMA / 0.85)
    assert float(rec(read).normal_force) == float(plain(read).normal_force)
    assert rec.noise_std == pytest.approx(np.full(72, SIGMA))


def test_every_door_answers_alike(tmp_path: Path) -> None:
    """One reading after the other, rows, an engine, stored results, and another process."""
    time, _, read = (each[:24] for each in held_press())
    stamps, layer = stamps_of(time), LAYERS[1]
    rec = sf.Reconstructor(PATCH, layer, noise_std=SIGMA, solver=sf.GaussianField())
    whole = np.array(rec(read, stamp_ns=stamps).normal_force)
    rec.reset()
    each = [float(rec(row, stamp_ns=at).normal_force) for row, at in zip(read, stamps, strict=True)]
    assert each == pytest.approx(whole)
    rec.reset()
    sf.save_results(tmp_path / "a.skinfield", rec, read, stamps)
    stored = sf.open_results(tmp_path / "a.skinfield")
    assert stored.normal_force.values == pytest.approx(whole)
    assert any("creep" in note for note in stored.attrs["notes"])
    engine = sf.Engine(PATCH, layer, noise_std=SIGMA, solver=sf.GaussianField(), budget=1.0)
    plain = sf.Reconstructor(PATCH, noise_std=SIGMA / 0.85, solver=sf.GaussianField())
    free = CreepCompensation.of(SOLID, 72, sf.Capacitance())
    for row, at in zip(read, stamps, strict=True):
        found = engine({PATCH.name: row}, stamp_ns=int(at))[PATCH.name].readings
        assert found == pytest.approx(free.next_of(row, int(at)), abs=1e-12)
    again = plain(free.taken(read, np.ones(read.shape, bool), stamps + 10 * NS))
    assert again.pressure.shape[0] == 24


def test_a_live_skin_is_freed_from_creep_before_drift_is_learnt() -> None:
    """By the same steps as a recording; what it reads first has stood."""
    read = np.vstack([held_press()[2][4:20], held_press()[2][199:220]])
    counts = np.rint(REST + GAIN * read)
    values = []
    for layer in LAYERS:
        live = cycle_of(settings(layer=layer, solver=sf.GaussianField(), rungs=(10,)))
        values.append(np.array([slot.values for slot in answered(live, counts)]))
    stamps = NOW + np.arange(len(counts)) * STEP
    free = CreepCompensation([SOLID], np.array([0, 72]), sf.Capacitance(), standing=True)
    expected = free.taken(values[0].astype(float), np.ones(values[0].shape, bool), stamps)
    assert values[1] == pytest.approx(expected, abs=1e-6)
    assert values[1][8:16].max() > 1.1 * values[0][8:16].max()


def test_a_relaxation_is_what_it_says() -> None:
    with pytest.raises(InputError, match="relaxation"):
        sf.Layer(relaxation=0.85)  # type: ignore[arg-type]
    assert "creep 15.0% in 1.00 s" in repr(LAYERS[1])
    assert "creep" not in repr(LAYERS[0])
