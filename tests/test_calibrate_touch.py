"""Calibration by touch: balls pressed by the simulator on skins that are not the nominal ones."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import skinfield as sf
from skinfield.errors import InputError
from skinfield.simulate import Sphere, press

PATCH = sf.layouts.hexagon72()
NOISE = 0.0005
LAYER = sf.Layer(thickness=2.3e-3, young_modulus=180e3, poisson_ratio=0.47)
COVERED = sf.Layer(thickness=2.5e-3, young_modulus=150e3, poisson_ratio=0.5)


def pressed(
    layer: sf.Layer, covered: bool, kind: str, presses: int, seed: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Readings (T, L) of balls anywhere on the patch, their forces, and gains spread by 10 %."""
    rng = np.random.default_rng(seed)
    far = np.linspace(0.0, 66e-3, 331)
    mechanics = sf.BondedLayer(inextensible_cover=covered)
    balls, forces = [], []
    for _ in range(8):
        radius, force = np.exp(rng.uniform(np.log([3e-3, 0.3]), np.log([12e-3, 3.0])))
        made = press(
            layer, [Sphere(radius=radius, force=force)], 20e-3, 0.4e-3, mechanics=mechanics
        )
        line = made.readings(np.column_stack([far, 0.0 * far]), PATCH.pad_diameter, kind)
        balls.append(CubicSpline(far, line))
        forces.append(force)
    place = PATCH.plane[rng.integers(len(PATCH), size=presses)]
    place = place + rng.normal(scale=2e-3, size=place.shape)
    which = rng.integers(len(balls), size=presses)
    away = np.linalg.norm(PATCH.plane[None] - place[:, None], axis=2)
    gain = np.exp(rng.normal(scale=0.1, size=len(PATCH)))
    gain /= np.exp(np.log(gain).mean())
    readings = gain * np.array([balls[k](each) for k, each in zip(which, away, strict=True)])
    return readings, np.array(forces)[which], gain


def noisy(readings: np.ndarray, seed: int) -> np.ndarray:
    return readings + np.random.default_rng(seed).normal(scale=NOISE, size=readings.shape)


@pytest.fixture(scope="module")
def recording():
    """Idle readings, single presses, and some of two balls at once."""
    readings, force, gain = pressed(LAYER, False, "capacitance", 100, 5)
    idle = np.zeros((60, len(PATCH)))
    two = readings[:6] + readings[20:26]
    forces = np.concatenate([np.full(60, np.nan), force, np.full(6, np.nan)])
    return noisy(np.concatenate([idle, readings, two]), 6), forces, gain


@pytest.fixture(scope="module")
def scaled(recording):
    """By noise that idle readings show, and twenty known forces."""
    readings, forces, _ = recording
    known = np.full(len(readings), np.nan)
    known[70:90] = forces[70:90]
    return sf.calibrate.touch(PATCH, readings, known=known)


def test_layer_and_gains_are_found(recording, scaled):
    _, _, gain = recording
    off = np.log(scaled.gain / gain)
    assert scaled.thickness == pytest.approx(LAYER.thickness, rel=0.03)
    assert scaled.poisson_ratio == pytest.approx(LAYER.poisson_ratio, abs=0.004)
    assert abs(scaled.thickness - LAYER.thickness) < 4.0 * scaled.thickness_std
    assert not scaled.covered
    assert np.std(off) < 0.7 * np.std(np.log(gain))
    assert np.mean(np.abs(off) < 2.0 * scaled.gain_std / scaled.gain) > 0.85
    assert np.log(scaled.gain).mean() == pytest.approx(0.0, abs=1e-6)


def test_idle_readings_tell_the_noise_and_two_balls_are_left_out(scaled):
    assert np.median(scaled.noise_std * scaled.gain) == pytest.approx(NOISE, rel=0.2)
    assert scaled.presses >= 80
    assert 3 <= scaled.left_out <= 20


def test_known_forces_give_the_modulus(scaled):
    assert not scaled.relative
    assert scaled.layer.young_modulus == pytest.approx(LAYER.young_modulus, rel=0.05)
    assert "kPa" in scaled.verdict


def test_a_reconstructor_takes_it(scaled):
    reconstructor = sf.Reconstructor(PATCH, calibration=scaled, solver=sf.GaussianField())
    assert reconstructor.layer == scaled.layer
    assert np.allclose(reconstructor.model.noise_std, scaled.noise_std)


def test_cover_and_incompressible_layer_of_a_linear_quantity():
    readings, _, gain = pressed(COVERED, True, "gap", 80, 8)
    found = sf.calibrate.touch(PATCH, noisy(readings, 9), quantity=sf.Gap(), noise_std=NOISE)
    assert found.covered
    assert found.mechanics == sf.BondedLayer(inextensible_cover=True)
    assert found.thickness == pytest.approx(COVERED.thickness, rel=0.05)
    assert found.poisson_ratio == pytest.approx(0.5, abs=0.003)
    assert np.std(np.log(found.gain / gain)) < 0.9 * np.std(np.log(gain))
    assert found.relative
    assert "relative" in found.verdict


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"readings": np.zeros((50, 72))}, "0 presses"),
        ({"readings": np.zeros((50, 71))}, "one per taxel"),
        ({"noise_std": 0.0}, "more than 0"),
        ({"known": np.zeros(3)}, "one per reading"),
        ({"known": np.full(50, -1.0)}, "force of 0 or less"),
    ],
)
def test_what_cannot_be_is_refused(change, words):
    arguments = {"readings": np.ones((50, 72)), "noise_std": NOISE} | change
    with pytest.raises(InputError, match=words):
        sf.calibrate.touch(PATCH, **arguments)
