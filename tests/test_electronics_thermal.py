"""Warmth: drift with a lag, and the iCub's thermal pads, down to the firmware's bits."""

from dataclasses import replace

import numpy as np
import pytest

from skinfield.errors import InputError
from skinfield.signal import ICubByte
from skinfield.signal.boards import firmware_drift
from skinfield.simulate.electronics import (
    CySkinBoard,
    Delivery,
    Electronics,
    ICubBoard,
    Noise,
    ThermalDrift,
    ThermalPads,
)
from skinfield.skin import Patch, generators
from skinfield.skin.generators import TEN_PAD_TRIANGLE

HEXAGON = generators.icub_hexagon()
TEN_PADS = generators.triangle_lattice(6, template=TEN_PAD_TRIANGLE)
MANY = Patch(np.random.default_rng(0).uniform(0, 1, (2400, 2)))


def rng(seed=0):
    return np.random.default_rng(seed)


def test_warmth_drifts_each_taxel_at_its_own_rate():
    drift = ThermalDrift(per_kelvin=0.5, converter_spread=0.2, taxel_spread=0.1)
    array = Electronics(quantised=False, drift=drift).manufacture(MANY, rng())
    temperature = 298.15 + np.array([0.0, 1.0, 10.0])
    counts = array.counts(np.zeros((3, 2400)), temperature, rng())
    rates = counts[1] - counts[0]
    assert counts[2] - counts[0] == pytest.approx(10 * rates, abs=1e-9)
    together = rates.reshape(-1, 12)
    assert rates.mean() == pytest.approx(0.5, abs=0.05)
    assert together.std(axis=1, ddof=1).mean() == pytest.approx(0.1, rel=0.05)
    assert together.mean(axis=1).std() == pytest.approx(0.2, rel=0.15)
    assert array.counts(np.zeros((1, 2400)), None, rng()) == pytest.approx(counts[:1], abs=1e-9)


def test_the_skin_lags_behind_its_surroundings():
    drift = ThermalDrift(per_kelvin=1.0, time_constant=30.0)
    made = Electronics(quantised=False, drift=drift, delivery=Delivery(rate=10.0))
    array = made.manufacture(HEXAGON, rng())
    temperature = np.full(1001, 308.15)
    temperature[0] = 298.15  # in balance with it at the start
    away = array.counts(np.zeros((1001, 72)), temperature, rng()) - array.baseline
    assert away[0] == pytest.approx(0.0, abs=1e-9)
    time = np.arange(1001) / 10.0
    assert away[:, 5] == pytest.approx(10.0 * (1.0 - np.exp(-time / 30.0)), abs=0.02)


def test_the_firmware_s_correction_is_bit_exact():
    taken = firmware_drift(np.full(12, -200.0))
    byte = ICubByte().counts_from_difference(np.where(np.arange(12) == 6, -200.0, 0.0) - taken)
    assert bytes(byte.astype(np.uint8)) == bytes.fromhex("d5cbd0e2e2d5ff dfd2b0f0d2")
    other = firmware_drift(np.full(12, -200.0), negated_first=True)
    assert (taken - other).tolist() == [1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0]
    assert (firmware_drift(200.0) == -firmware_drift(-200.0)).all()


def test_thermal_pads_leave_a_small_remainder_of_the_drift():
    made = Electronics(quantised=False, thermal_pads=ThermalPads(noise=0.0))
    array = made.manufacture(TEN_PADS, rng())
    temperature = 298.15 + np.linspace(-20, 20, 401)
    counts = array.counts(np.zeros((401, 60)), temperature, rng(1)) - array.baseline
    whole = 10.0 * 20 * 164 / 128 / 4  # of the strongest taxel without correction
    assert np.abs(counts).max() < 0.03 * whole
    raw = replace(made, thermal_pads=None, drift=ThermalDrift(per_kelvin=1.0))
    counts = raw.manufacture(TEN_PADS, rng()).counts(np.zeros((401, 60)), temperature, rng(1))
    assert np.abs(counts - 240.375).max() == pytest.approx(20.0)


def test_a_failed_pad_fakes_contact_on_its_triangle_alone():
    pads = ThermalPads(failed=0.3, noise=0.0)
    made = Electronics(thermal_pads=pads, noise=Noise(white=1.0))
    array = made.manufacture(TEN_PADS, rng(3))
    counts = array.counts(np.zeros((200, 60)), None, rng(1)).mean(axis=0)
    failed = array.pad_error[array.wiring.converter] < 0
    assert 0 < failed.sum() < 60
    assert (240.5 - counts[failed] > 7).all()
    assert (240.5 - counts[failed]).max() == pytest.approx(64.0, abs=1.0)  # the gain of 164
    assert np.abs(240.375 - counts[~failed]).max() < 0.5


def test_thermal_pads_need_their_board_and_their_triangles():
    with pytest.raises(InputError, match="expected an ICubBoard"):
        Electronics(board=CySkinBoard(), thermal_pads=ThermalPads())
    with pytest.raises(InputError, match="taxel 6 is at channel 6 of its triangle"):
        Electronics(board=ICubBoard(), thermal_pads=ThermalPads()).manufacture(HEXAGON, rng())
    with pytest.raises(InputError, match="gains has 3 entries"):
        ThermalPads(gains=(1, 2, 3))
