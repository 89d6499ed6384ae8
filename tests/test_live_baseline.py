"""Baselines of virtual skins whose truth is known, and forces that come of them."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from live_skins import LAYER, settings

import skinfield as sf
from skinfield.emulator import VirtualSettings
from skinfield.emulator.electronics import Converters, manufacture
from skinfield.emulator.packet import REST
from skinfield.errors import InputError
from skinfield.loop.baseline import BaselineCollector, TareBaseline
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.slots import CycleSlot
from skinfield.loop.update import Updater, lowest_change
from skinfield.record.drain import calibration_of
from skinfield.signal import (
    Blocks,
    Calibration,
    Channels,
    CySkinCount,
    ICubByte,
    Kind,
    PlainCount,
    Port,
)
from skinfield.simulate import Sphere, press

PATCH = sf.layouts.hexagon72()
STEP_NS = 10_000_000  # a hundred readings a second
ON, BETWEEN = (0.0, 7.5e-3), (4.5e-3, 14.3e-3)  # m: on a taxel, and 2.7 mm from the nearest
UNTOUCHED = np.zeros(len(PATCH))
PATIENCE = 1050  # readings, of a tare of a second


@cache
def pressed(x: float, y: float) -> np.ndarray:
    """ΔC/C₀ of a newton of a finger."""
    body = Sphere(radius=10e-3, force=1.0, position=(x, y))
    return press(LAYER, [body], 40e-3, 0.5e-3).readings(
        PATCH.plane, PATCH.pad_diameter, "capacitance"
    )


class Skin:
    """Electronics of the virtual skin, and the engine's own code behind them."""

    def __init__(self, hardware: str, noise: float, seed: int = 0) -> None:
        made = VirtualSettings(hardware=hardware, noise_scale=noise, seed=seed)
        bytewise = hardware == "icub"
        board = ICubByte() if bytewise else None
        self.settings = settings(skin=PATCH, board=board, tare_seconds=1.0)
        self.kind = Kind.BYTES if bytewise else Kind.SHORTS
        rest, high = (240.0, 255.0) if bytewise else (REST, 65535.0)
        self.converters = Converters(
            manufacture(sf.Skin((PATCH,)), made), made, np.full(len(PATCH), rest), (0.0, high)
        )
        self.model_config = ModelConfig.of(self.settings, (Port("port", len(PATCH)),))
        self.channels, self.now = Channels(len(PATCH)), 10**18
        self._updater: Updater | None = None

    def feed(self, change: np.ndarray) -> None:
        self.now += STEP_NS
        self.converters.change[:] = change
        self.converters.convert(0.0)
        blocks = Blocks(1 << 12)
        blocks.put(self.now, 0, self.converters.counts, self.kind)
        self.channels.apply(blocks)

    def tare(self, touches: np.ndarray, readings: int) -> tuple[TareBaseline, int]:
        """Touched for so many readings, then let go; and how many it took."""
        tare = BaselineCollector(self.settings, self.model_config.binding)
        for number in range(1, 5000):
            self.feed(touches if number <= readings else UNTOUCHED)
            if tare.take(self.channels, self.now):
                return tare.finish(), number
        raise AssertionError("the baseline does not end")

    def forces(self, baseline: TareBaseline, change: np.ndarray, count: int = 10) -> np.ndarray:
        """Of all contacts, N, in each of some readings."""
        if self._updater is None:
            self._updater = Updater(self.model_config, baseline)
        updater = self._updater
        slot, found = CycleSlot.empty(updater.sizes), []
        for number in range(count):
            self.feed(change)
            updater.answer(self.channels, self.now, slot, reset=number == 0, budget=1.0)
            found.append(slot.used_contacts()["normal_force"].sum())
        return np.array(found)


@pytest.mark.parametrize(
    ("hardware", "noise"),
    [("icub", 0.0), ("icub", 0.1), ("icub", 0.3), ("packet", 0.1), ("packet", 0.3)],
)
def test_a_newton_is_about_one_whatever_the_noise(hardware: str, noise: float) -> None:
    skin = Skin(hardware, noise)
    baseline, taken = skin.tare(UNTOUCHED, 0)
    assert taken <= 110
    rest = 240.0 if hardware == "icub" else REST
    off = np.abs(baseline.calibration[:, 0] - rest)
    assert (off < 0.05 + 0.5 * skin.converters.white).all()
    assert (baseline.calibration[:, 3] == 1.0).all()  # quiet taxels are no dead ones
    assert (baseline.calibration[:, 2] >= 0.999 * 12**-0.5).all()  # what rounding gives
    assert np.median(skin.forces(baseline, UNTOUCHED)) == 0.0
    assert np.median(skin.forces(baseline, pressed(*ON))) == pytest.approx(1.0, rel=0.5)
    assert np.median(skin.forces(baseline, pressed(*BETWEEN))) < 1.5


@pytest.mark.parametrize(("readings", "noise"), [(60, 0.3), (97, 0.1), (400, 0.1)])
def test_a_baseline_waits_until_the_skin_is_let_go(readings: int, noise: float) -> None:
    skin = Skin("icub", noise, seed=readings)
    baseline, taken = skin.tare(pressed(*ON), readings)
    assert taken < max(2 * readings, 100) + 150
    assert np.abs(baseline.calibration[:, 0] - 240.0).max() < 2.0
    assert np.count_nonzero(skin.forces(baseline, UNTOUCHED)) <= 1  # a false alarm does not last
    assert np.median(skin.forces(baseline, pressed(*ON))) == pytest.approx(1.0, rel=0.5)


@pytest.mark.parametrize(
    ("hardware", "fewest", "most"),
    [("icub", 1000, PATIENCE), ("packet", 0, 110)],  # without a rest, a board cannot tell
)
def test_a_touch_that_outlasts_it_leaves_no_phantom(hardware: str, fewest: int, most: int) -> None:
    skin = Skin(hardware, 0.1)
    baseline, taken = skin.tare(pressed(*ON), 5000)
    assert fewest <= taken <= most
    rests = baseline.calibration[:, 0]
    if hardware == "icub":
        assert any("something lies on the skin" in note for note in baseline.notes)
        assert rests.min() < 225.0
    else:
        assert rests.max() > REST + 2000.0
    assert np.median(skin.forces(baseline, pressed(*ON))) == 0.0  # it counts as nothing, as asked
    assert skin.forces(baseline, UNTOUCHED).max() < 0.5  # where the taxel below it would make 15 N
    assert 0.2 < np.median(skin.forces(baseline, pressed(-7.1e-3, -8e-3))) < 1.5  # elsewhere


@pytest.mark.parametrize(
    ("board", "gain", "noise", "expected"),
    [
        (ICubByte(), -171.0, 0.6, -15.0 / 171.0),
        (ICubByte(no_load=235), -171.0, 0.6, -20.0 / 171.0),
        (CySkinCount(), 20e3, 20.0, -np.inf),
        (None, 20e3, 20.0, -0.1),
        (PlainCount(), 20e3, 1000.0, -0.3),
    ],
)
def test_what_no_taxel_reads(board: object, gain: float, noise: float, expected: float) -> None:
    known = np.tile([0.0, gain, noise, 1.0], (5, 1))
    assert lowest_change(board, known) == pytest.approx(expected)  # type: ignore[arg-type]
    assert lowest_change(board, known[:0]) == -np.inf  # type: ignore[arg-type]


def taken(unit: str, counts: np.ndarray, *, anew: bool = False, **changes: object) -> TareBaseline:
    """Baseline of hexagon72 by readings (T, 72) of a port, 10 ms apart."""
    made = settings(skin=PATCH, tare_seconds=1.0, **changes)
    binding = ModelConfig.of(made, (Port("port", len(PATCH), unit),)).binding
    tare, channels, now = BaselineCollector(made, binding, anew=anew), Channels(72), 10**18
    for row in counts:
        now += STEP_NS
        blocks = Blocks(1 << 12)
        blocks.put(now, 0, row, Kind.FLOATS)
        channels.apply(blocks)
        if tare.take(channels, now):
            break
    return tare.finish()


def test_a_calibration_is_live_what_it_is_offline(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    gain = np.exp(0.1 * rng.standard_normal(72))
    known = replace(Calibration.identity(PATCH, noise_std=0.002), gain=gain)
    change = 0.002 * rng.standard_normal((120, 72)).astype(np.float32)
    made = taken("dC/C0", change, calibration={"hexagon72": known}, without=(3, 70))
    assert made.calibration[:, 0] == pytest.approx(0.0)
    np.testing.assert_allclose(np.delete(made.calibration[:, 1], (3, 70)), np.delete(gain, (3, 70)))
    np.testing.assert_allclose(np.delete(made.noise_std, (3, 70)), np.delete(0.002 / gain, (3, 70)))
    assert np.flatnonzero(made.calibration[:, 3] == 0).tolist() == [3, 70]
    status = {"calibration": made.calibration, "noise_std": made.noise_std}
    status |= {name: np.array([1]) for name in ("stale_ns", "tares")}
    model_config = ModelConfig.of(settings(skin=PATCH), (Port("port", len(PATCH), "dC/C0"),))
    enclosed = next(calibration_of(model_config, status))  # in a recording
    (tmp_path / "cal.npz").write_bytes(enclosed.data)
    again = sf.load_calibration(tmp_path / "cal.npz", PATCH)
    np.testing.assert_allclose(again.gain[again.alive], gain[again.alive])
    assert again.unit == "dC/C0"
    plain = taken("dC/C0", change, without=(3, 70))
    assert np.flatnonzero(plain.calibration[:, 3] == 0).tolist() == [3, 70]
    np.testing.assert_allclose(plain.calibration[:, 1], 1.0)


def test_rest_of_a_calibration_stays_until_a_tare_is_ordered() -> None:
    rng = np.random.default_rng(6)
    rest, gain = rng.uniform(225, 235, 72), -171.0 * np.exp(0.1 * rng.standard_normal(72))
    known = Calibration(rest, gain, np.full(72, 0.6), np.ones(72, bool), PATCH.uid)
    counts = np.rint(rest - 3.0 + 0.6 * rng.standard_normal((120, 72))).astype(np.float32)
    counts[:, 9] = rng.integers(180, 255, 120)  # is broken
    how = {"calibration": {"hexagon72": known}, "board": ICubByte()}
    first = taken("count", counts, **how, keep=(9,))
    np.testing.assert_allclose(first.calibration[:, 0], rest)
    assert first.calibration[:, 3].all()
    anew = taken("count", counts, anew=True, **how)
    assert np.flatnonzero(anew.calibration[:, 3] == 0).tolist() == [9]
    moved = np.delete(anew.calibration[:, 0] - rest, 9)
    assert np.abs(moved + 3.0).max() < 0.5
    np.testing.assert_allclose(np.delete(anew.calibration[:, 1], 9), np.delete(gain, 9))
    with pytest.raises(InputError, match="both name taxels 9"):
        settings(skin=PATCH, keep=(9,), without=(9,))
