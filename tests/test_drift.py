"""Drift of rest, followed beside what touches."""

from typing import Any

import numpy as np
import pytest
from live_skins import REST, cycle_of, pressed_counts, settings
from test_live_update import answered

import skinfield as sf
from skinfield.signal.drift import FOLLOWED, JUMP, USUAL, Drift

NOISE, RATE = 2e-3, 50.0
STEP_NS = int(1e9 / RATE)
PATCH = sf.layouts.hexagon72()
PLANE = np.asarray(PATCH.plane)
LAYER = sf.Layer()


def drift_of(taxels: int = 72) -> Drift:
    """Of the patch's first taxels."""
    return Drift(np.full(taxels, NOISE))


def follow(drift: Drift, readings: np.ndarray, pattern: np.ndarray | None = None) -> np.ndarray:
    """Readings (T, L) less their rest; with a contact that reads a pattern, if any."""
    every, left = np.ones(readings.shape[1], np.bool_), np.zeros_like(readings)
    for k, reading in enumerate(readings):
        stamp = int(drift._stamps[0]) + STEP_NS
        known: tuple[Any, ...] = ()
        if pattern is not None:
            known = pattern if pattern.ndim == 1 else pattern[k], 0.01, 1
        left[k] = drift.take(reading, stamp)
        drift.learn(every, stamp, *known)
    return left


def walk(rng: np.random.Generator, readings: int, rms: float) -> np.ndarray:
    """Random walks (T, L) that are this far off at the end, root mean square."""
    return np.cumsum(rng.normal(0.0, rms / np.sqrt(readings), (readings, len(PATCH))), axis=0)


def test_the_gain_becomes_that_of_a_steady_kalman_filter() -> None:
    drift = drift_of(1)
    follow(drift, np.zeros((4000, 1)))
    walk_variance = (USUAL / FOLLOWED * NOISE) ** 2
    before = 0.5 * (walk_variance + np.sqrt(walk_variance**2 + 4 * walk_variance * NOISE**2))
    after = before * NOISE**2 / (before + NOISE**2)  # of the Riccati equation
    assert drift.variance[0] == pytest.approx(after, rel=1e-3)


def test_a_walk_is_followed_and_noise_alone_moves_little() -> None:
    rng, readings = np.random.default_rng(1), int(60 * RATE)
    noise = rng.normal(0.0, NOISE, (readings, len(PATCH)))
    walked = walk(rng, readings, NOISE)
    left = follow(drift_of(), walked + noise)[readings // 2 :]
    assert (left - noise[readings // 2 :]).std() == pytest.approx(0.2 * NOISE, rel=0.4)
    quiet = drift_of()
    follow(quiet, noise)
    assert 0.01 < quiet.rest.std() / NOISE < 0.1


def test_a_jump_moves_the_rest_by_no_more_than_its_limit() -> None:
    drift, other = drift_of(), drift_of()
    follow(drift, np.zeros((500, 72)))
    follow(other, np.zeros((500, 72)))
    follow(drift, np.full((1, 72), 1.0))
    follow(other, np.full((1, 72), JUMP * NOISE))
    assert 0.0 < drift.rest[0] < 1.05 * other.rest[0] < 0.1 * NOISE


def pattern() -> np.ndarray:
    """What a ball of 1 N reads."""
    ball = sf.simulate.Sphere(radius=6e-3, position=(-16e-3, 8e-3), force=1.0)
    return np.asarray(sf.simulate.press(LAYER, [ball]).capacitance(PLANE, PATCH.pad_diameter))


def test_what_rests_stays_while_taxels_drift() -> None:
    rng, readings, touch = np.random.default_rng(2), int(300 * RATE), pattern()
    ramp = np.linspace(0, 1, readings)[:, None] * rng.normal(0.0, 5e-3, len(PATCH))
    noise = rng.normal(0.0, NOISE, ramp.shape)
    drift = drift_of()
    left = follow(drift, touch + ramp + noise, touch)[-200:].mean(axis=0)
    assert left @ touch / (touch @ touch) == pytest.approx(1.0, abs=0.03)
    assert np.abs(left - touch).max() < NOISE < 0.2 * np.abs(ramp[-1]).max()


def test_rests_are_known_no_worse_while_something_is_held() -> None:
    rng, touch, drift = np.random.default_rng(4), pattern(), drift_of()
    noise = rng.normal(0.0, NOISE, (int(60 * RATE), len(PATCH)))
    idle = int(20 * RATE)
    follow(drift, noise[:idle])
    follow(drift, touch + noise[idle:], touch)
    assert drift.rest[touch < 0.5 * NOISE].std() < 0.12 * NOISE
    assert np.abs(drift.rest).max() < 0.4 * NOISE


def test_a_taxel_that_was_not_read_at_first_is_held_as_it_reads_later() -> None:
    rng, touch, drift = np.random.default_rng(6), np.full(72, 30 * NOISE), drift_of()
    noise, valid = rng.normal(0.0, NOISE, (300, 72)), np.ones((300, 72), np.bool_)
    valid[101:125, 3] = False  # of the 25 that tell what is held
    valid[101:140, 4] = False
    follow(drift, noise[:100])
    for k in range(100, 300):
        stamp = int(drift._stamps[0]) + STEP_NS
        drift.take(touch + noise[k], stamp)
        drift.learn(valid[k], stamp, touch, 0.01, 1)
    held = drift._state[2]
    assert np.abs(held[3:5] / touch[3:5] - 1.0).max() < 0.02
    assert np.abs(drift.rest[3:5]).max() < 0.4 * NOISE


def test_a_reading_is_learnt_from_once() -> None:
    drift, every, rng = drift_of(), np.ones(72, np.bool_), np.random.default_rng(5)
    follow(drift, rng.normal(0.0, NOISE, (100, 72)))
    stamp, reading = int(drift._stamps[0]) + STEP_NS, np.full(72, NOISE)
    drift.take(reading, stamp)
    drift.learn(every, stamp)
    once = drift.rest.copy()
    for _ in range(3):
        drift.take(reading, stamp)
        drift.learn(every, stamp)
    np.testing.assert_array_equal(drift.rest, once)


def test_a_touch_that_grows_or_moves_is_no_drift() -> None:
    rng, touch = np.random.default_rng(3), pattern()
    drift, readings = drift_of(), int(20 * RATE)
    noise = rng.normal(0.0, NOISE, (readings, len(PATCH)))
    follow(drift, touch + noise, touch)
    growing = np.linspace(1, 2, readings)[:, None] * touch
    grown = follow(drift, growing + noise, growing)[-50:]
    assert grown.mean(axis=0) @ touch / (touch @ touch) == pytest.approx(1.975, abs=0.06)
    moved = np.roll(touch, 6)  # another module reads it
    left = follow(drift, moved + noise, moved)[-50:].mean(axis=0)
    assert left @ moved / (moved @ moved) == pytest.approx(1.0, abs=0.06)


def test_an_older_stamp_begins_anew() -> None:
    drift = drift_of()
    follow(drift, np.full((500, 72), NOISE))
    assert drift.rest.all()
    drift.take(np.zeros(72), 1)
    assert not drift.rest.any()


def test_an_idle_skin_that_drifts_is_silent_and_both_doors_agree() -> None:
    rng, readings = np.random.default_rng(4), int(30 * RATE)
    rec = sf.Reconstructor(PATCH, LAYER, noise_std=NOISE)
    walked = walk(rng, readings, NOISE) + rng.normal(0.0, NOISE, (readings, len(PATCH)))
    stamps = (np.arange(readings) + 1) * STEP_NS
    found = [len(each) for each in rec(walked, stamp_ns=stamps).contacts]
    assert np.mean(found) < 3e-3
    rows = rec.rows()
    other = [rec.into(row, rows, stamp_ns=int(t)) for row, t in zip(walked, stamps, strict=True)]
    assert found == other


@pytest.mark.parametrize("most", [0.06, -0.06])
def test_a_board_that_warms_makes_no_contact(most: float) -> None:
    """By several hundredths of C₀ in 40 s, on all taxels alike."""
    rng, rec = np.random.default_rng(7), sf.Reconstructor(PATCH, LAYER, noise_std=NOISE)
    rows, found, seconds = rec.rows(), [], np.arange(1, int(40 * RATE) + 1) / RATE
    for at in seconds:
        reading = most * -np.expm1(-at / 40.0) + rng.normal(0.0, NOISE, len(PATCH))
        found.append(rec.into(reading, rows, stamp_ns=int(at * 1e9)))
    assert np.mean(found) < 3e-3
    assert not any(found[-500:])


def test_patches_that_nothing_touches_are_followed_alike_together_and_alone() -> None:
    rng = np.random.default_rng(5)
    noise = np.full(72, NOISE)
    starts = np.array([0, 30, 72])
    together, every = Drift(noise, starts), np.ones(72, np.bool_)
    alone = Drift(noise[:30]), Drift(noise[30:])
    for k in range(200):
        reading, stamp = rng.normal(NOISE, NOISE, 72), (k + 1) * STEP_NS
        together.take(reading)
        together.learn_idle(every, np.array([True, k % 2 == 0]), np.array([stamp, stamp]))
        for patch, each in enumerate(alone):
            its = slice(*starts[patch : patch + 2])
            if patch == 0 or k % 2 == 0:
                each.take(reading[its], stamp)
                each.learn(every[its], stamp)
    assert together.rest == pytest.approx(np.concatenate([each.rest for each in alone]))
    assert together.rest.mean() > 0.1 * NOISE


def test_a_live_skin_that_drifts_is_silent_and_keeps_what_rests_on_it() -> None:
    updater = cycle_of(settings())
    rng, readings = np.random.default_rng(6), 3000  # 30 s at 100 Hz
    drift = np.linspace(0.0, 1.0, readings)[:, None] * rng.normal(0.0, 1.0, 72)  # bytes
    counts = REST + drift + rng.normal(0.0, 0.6, drift.shape)
    idle = [slot.patches["contacts"][0] for slot in answered(updater, np.rint(counts))]
    assert np.mean(idle) < 0.01
    counts += pressed_counts(1.0) - REST
    held = answered(updater, np.rint(counts))
    force = np.array([slot.contacts[0, :8]["normal_force"].sum() for slot in held])
    number = np.array([slot.patches["contacts"][0] for slot in held])
    assert np.mean(number == 1) > 0.95
    assert np.median(force[-200:]) == pytest.approx(np.median(force[100:300]), rel=0.05)


def test_a_press_between_taxels_is_no_drift_though_it_is_found_in_nine_readings_of_ten() -> None:
    ball = sf.simulate.Sphere(radius=6e-3, position=(2e-3, 1e-3), force=1.0)  # 5 mm from any taxel
    pressed = sf.simulate.press(LAYER, [ball]).capacitance(PATCH.positions, PATCH.pad_diameter)
    assert np.abs(pressed).max() < 5 * NOISE
    rec, rng = sf.Reconstructor(PATCH, LAYER, noise_std=NOISE), np.random.default_rng(1)
    out, forces = rec.rows(), np.zeros(1500)
    for at in range(-100, len(forces)):
        reading = rng.normal(0.0, NOISE, len(PATCH)) + (pressed if at >= 0 else 0.0)
        found = rec.into(reading, out, stamp_ns=(at + 101) * 20_000_000)
        if at >= 0:
            forces[at] = out["normal_force"][:found].sum()
    assert np.abs(forces.reshape(3, -1).mean(axis=1) - 1.0).max() < 0.15
