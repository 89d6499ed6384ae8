"""Fit beside the engine: averages, numbers of contacts, and all of it on a ring filled here."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from itertools import count
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest
from live_skins import LAYER, settings, skin_ring, wait_for
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from recorder_ring import contact
from scipy.special import ndtr

import skinfield as sf
from skinfield.estimate.live_contacts import CONTACT
from skinfield.loop.client import Live, chosen
from skinfield.loop.fit_process import SkinFit, clips_at_rest
from skinfield.loop.fit_ring import (
    FitReader,
    FitSlot,
    Fitted,
    best_contacts,
    best_of,
    fit_name,
    is_fit,
    write_engine,
)
from skinfield.loop.fit_worker import FIRST, FitTracks, deviation_of, rounding_of
from skinfield.loop.slots import PATCH, CycleHead, CycleSlot
from skinfield.loop.stationary_mean import GAP_NS, MOST, Mean, StationaryMean
from skinfield.page.source import LiveSource
from skinfield.ring import Ring, RingReader
from skinfield.signal import Convention, CySkinCount, ICubByte, PlainCount
from skinfield.simulate import Sphere, press

TAXELS, PERIOD_NS = 20, 10_000_000
NOISES = np.full(TAXELS, 0.002)
ALL = np.ones(TAXELS)
PRESSED = np.zeros(TAXELS)
PRESSED[:3] = 0.03, 0.02, 0.01
FAINT = np.where(np.arange(TAXELS) < 8, 3.0 * NOISES, 0.0)  # no taxel stands out of one reading


def readings(level: np.ndarray, count: int, seed: int) -> np.ndarray:
    return level + np.random.default_rng(seed).normal(0.0, 0.002, (count, TAXELS))


def fed(stationary: StationaryMean, rows: np.ndarray, start: int = 0) -> int:
    for number, row in enumerate(rows, start):
        stationary.take(row, ALL, (number + 1) * PERIOD_NS)
    return start + len(rows)


def mean_of(stationary: StationaryMean) -> Mean:
    found = stationary.mean(NOISES)
    assert found is not None
    return found


@pytest.mark.parametrize("count", [1, 2, 7, 32, 100, 500])
def test_what_rests_is_averaged(count: int) -> None:
    stationary, rows = StationaryMean(TAXELS), readings(PRESSED, count, 1)
    assert stationary.mean(NOISES) is None  # before the first reading
    fed(stationary, rows)
    found = mean_of(stationary)
    assert found.readings == min(count, MOST)
    assert found.stamp_ns == count * PERIOD_NS
    assert_allclose(found.values, rows[-MOST:].mean(axis=0), atol=1e-12)


@pytest.mark.parametrize(
    ("touch", "after"), [*((PRESSED, after) for after in (1, 2, 3, 5, 11, 40)), (FAINT, 24)]
)
def test_an_average_ends_where_the_touch_began(touch: np.ndarray, after: int) -> None:
    stationary = StationaryMean(TAXELS)
    start = fed(stationary, readings(np.zeros(TAXELS), 64, 3))
    fed(stationary, readings(touch, after, 4), start)
    assert mean_of(stationary).readings == after


def test_readings_before_a_gap_do_not_count() -> None:
    stationary = StationaryMean(TAXELS)
    start = fed(stationary, readings(PRESSED, 20, 5))
    stationary.take(PRESSED, ALL, start * PERIOD_NS + GAP_NS + PERIOD_NS)
    assert mean_of(stationary).readings == 1


def test_a_taxel_that_is_left_out_now_and_then_is_the_mean_of_its_own() -> None:
    stationary, rows = StationaryMean(TAXELS), readings(PRESSED, 8, 6)
    for number, row in enumerate(rows):
        valid = ALL.copy()
        valid[4] = number % 2
        valid[5] = 0.0
        stationary.take(np.where(valid > 0, row, np.nan), valid, (number + 1) * PERIOD_NS)
    found = mean_of(stationary)
    assert found.readings == 8
    assert found.values[4] == pytest.approx(rows[1::2, 4].mean())
    assert found.valid[4]
    assert not found.valid[5]
    assert found.values[5] == 0.0
    assert np.isinf(deviation_of(found, NOISES, 0.0 * NOISES)[5])


@pytest.mark.parametrize("noise", [0.0, 0.2, 0.35, 0.5, 1.0])
def test_rounding_of_averages_against_the_expected_value_of_a_rounded_count(noise: float) -> None:
    places, counts = np.linspace(-0.5, 0.5, 201), np.arange(-8, 9)
    if noise:
        edges = ndtr((counts + 0.5 - places[:, None]) / noise)
        chance = np.diff(edges, axis=1, prepend=0.0)
    else:
        chance = (np.rint(places)[:, None] == counts).astype(float)
    off = chance @ counts - places
    total = np.full((1, 4), np.hypot(noise, 12**-0.5))
    found = rounding_of(total, np.array([total[0, 2]]))[0]
    worst = np.sqrt((off**2).mean())
    assert found == pytest.approx(worst, abs=0.02 * worst + 1e-6)


def together(*rows: Any) -> Any:
    return np.concatenate([np.zeros(0, CONTACT), *rows])


def test_numbers_are_those_of_the_engine_and_last() -> None:
    tracks, stamp = FitTracks(count(FIRST)), 5_000_000_000
    rows = together(contact(0.0, 0.0), contact(0.02, 0.0))
    engine = together(contact(0.019, 0.002, track=7, age=0.5), contact(0.001, 0.0, track=4))
    tracks.number(rows, engine, stamp)
    assert_array_equal(rows["track"], [4, 7])
    assert_allclose(rows["age"], [0.0, 0.5])
    later = together(contact(0.0202, 0.0), contact(0.0, 0.001))
    tracks.number(later, together(contact(0.0, 0.0, track=9)), stamp + 20_000_000)
    assert_array_equal(later["track"], [7, 4])  # though the engine calls it 9 by now
    assert_allclose(later["age"], [0.52, 0.02])
    assert later["speed"][1] > later["speed"][0] > 0.0


def test_what_the_engine_does_not_see_has_a_number_of_its_own() -> None:
    numbers = count(FIRST)
    first, second = FitTracks(numbers), FitTracks(numbers)
    rows = together(contact(0.0, 0.0), contact(0.03, 0.0))
    first.number(rows, together(contact(0.015, 0.0, track=3)), 1_000_000_000)
    assert_array_equal(rows["track"], [FIRST, FIRST + 1])  # 15 mm away is another one
    again = together(contact(0.0, 0.0))
    second.number(again, together(), 1_000_000_000)
    assert again["track"][0] == FIRST + 2
    first.number(again, together(), 3_000_000_000)
    assert again["track"][0] == FIRST + 3  # after so long it is a new one


def snapshot(stamp_ns: int, contacts: Any, answer: int = 3) -> Any:
    patches = np.zeros(2, PATCH)
    patches["stamp_ns"], patches["answer"] = stamp_ns, answer
    patches["contacts"] = [(contacts["patch"] == n).sum() for n in range(2)]
    return SimpleNamespace(patches=patches, contacts=contacts)


def slot_of(stamp_ns: int, contacts: Any, touched: int = 1) -> FitSlot:
    slot = FitSlot.empty(2, 9, 4)
    slot.patches["state"][0] = int(Fitted.DONE)
    slot.patches["stamp_ns"], slot.patches["touched"] = stamp_ns, touched
    slot.patches["contacts"][0] = len(contacts)
    slot.contacts[0][: len(contacts)] = contacts
    slot.pressure[0] = 5.0
    return slot


def test_the_fits_contacts_count_where_it_has_kept_up() -> None:
    other = contact(0.0, 0.0, 2.0, track=5, patch=1)
    engine = together(contact(0.0, 0.0, 1.6, track=4, age=1.0), other)
    fit = slot_of(10**9, contact(0.001, 0.0, 1.0, track=4))
    rows, by = best_of(snapshot(10**9 + PERIOD_NS, engine), fit)
    assert_array_equal(rows["normal_force"], [1.0, 2.0])
    assert by == ["fit", "engine"]
    assert_array_equal(fit.pressure_of(0), np.full(9, 5.0))
    assert fit.pressure_of(1) is None


def test_a_contact_that_began_since_is_the_engines() -> None:
    engine = together(
        contact(0.0, 0.0, 1.6, track=4, age=1.0),
        contact(0.01, 0.0, 0.3, track=8, age=1.0),  # of before: the fit does not have it
        contact(0.03, 0.0, 0.5, track=9, age=0.01),
        contact(0.003, 0.0, 0.5, track=10, age=0.01),  # the same as 4, by another number
    )
    fit = slot_of(10**9, contact(0.001, 0.0, 1.0, track=4))
    rows, by = best_of(snapshot(10**9 + 2 * PERIOD_NS, engine), fit)
    assert_array_equal(rows["track"], [4, 9])
    assert by == ["fit", "engine"]


@pytest.mark.parametrize(
    "why", ["no fit", "old", "old and moved", "very old", "lifted", "unhelpful"]
)
def test_else_the_engines_count(why: str) -> None:
    engine = together(contact(0.0, 0.0, 1.6, track=4, age=1.0))
    slot, answer = slot_of(10**9, contact(0.001, 0.0, 1.0, track=4)), 3
    late = 10**9 if why in ("old", "old and moved") else 3 * 10**9 if why == "very old" else 0
    if why != "old":
        write_engine(slot.patches[0], contact(0.0, 0.0, 1.6))
    if why == "old and moved":
        engine["x"] += 5e-3
    if why == "lifted":
        engine, answer = engine[:0], 1
    if why == "unhelpful":
        slot.patches["state"] = int(Fitted.UNHELPFUL)
    fit = None if why == "no fit" else slot
    rows, by = best_of(snapshot(10**9 + late, engine, answer), fit)
    assert_array_equal(rows, engine)
    assert by == ["engine"] * len(engine)


def test_a_fit_may_be_late_while_the_touch_rests() -> None:
    engine = together(contact(0.0005, 0.0, 1.5, track=4, age=1.0))
    slot = slot_of(10**9, contact(0.001, 0.0, 1.0, track=4))
    write_engine(slot.patches[0], contact(0.0, 0.0, 1.6))
    rows, by = best_of(snapshot(2 * 10**9, engine), slot)
    assert_array_equal(rows["normal_force"], [1.0])
    assert by == ["fit"]


def test_what_only_the_fit_sees_is_shown_while_the_engine_sees_nothing() -> None:
    fit = slot_of(10**9, contact(0.001, 0.0, 0.2, track=FIRST), touched=0)
    rows, by = best_of(snapshot(10**9, together(), answer=1), fit)
    assert_array_equal(rows["normal_force"], [0.2])
    assert by == ["fit"]


def test_a_fit_that_is_not_there_says_nothing() -> None:
    with closing(FitReader("no-such-skin")) as reader:
        assert reader.latest() is None
        assert reader.status() == {}
    assert is_fit(fit_name("skin"))
    assert not is_fit("skin")


pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")

HEXAGON = sf.layouts.hexagon72()
NOISE, STEP_NS = 0.002, 10_000_000
PLACE, DEAD = (-4e-3, 6.3e-3), 11  # m, between taxels; a taxel far from there
LONG = 600.0  # s: a fresh clone compiles first
Floats = NDArray[np.float64]


@pytest.fixture(scope="module", name="ring")
def _ring() -> Iterator[Ring]:
    with skin_ring(unit="dC/C0") as found:
        tare(found)
        yield found


def tare(ring: Ring, noise: float = NOISE) -> None:
    ring.status["calibration"][:] = 0.0, 1.0, noise, 1.0
    ring.status["noise_std"][:] = noise
    ring.status["tares"][0] += 1


def pressed(*bodies: Sphere) -> Floats:
    """ΔC/C₀ of a press, on cells that the fit does not share."""
    made = press(LAYER, list(bodies), 40e-3, 0.5e-3)
    return made.readings(HEXAGON.plane, HEXAGON.pad_diameter, "capacitance")


def play(ring: Ring, level: Floats, count: int, *, answer: int = 3, seen: float = 1.6) -> None:
    """Cycles with readings of this, in which the engine sees one contact of a force `seen`."""
    rng = np.random.default_rng(count)
    for _ in range(count):
        slot = CycleSlot.of(ring.begin())
        slot.head[CycleHead.FRESH] = 1
        slot.patches["fresh"], slot.patches["answer"] = len(HEXAGON), answer
        slot.patches["stamp_ns"] = (1000 + ring.number) * STEP_NS
        slot.patches["contacts"] = answer > 1
        row = slot.contacts[0][0]
        row["track"], row["x"], row["y"], row["normal_force"] = 4, *PLACE, seen
        row["age"], row["position"] = 1.0, (*PLACE, 0.0)
        slot.values[:] = level + rng.normal(0.0, NOISE, len(HEXAGON))
        slot.valid[:] = 1
        slot.values[DEAD], slot.valid[DEAD] = 0.3, 0
        ring.publish()


@pytest.fixture(scope="module", name="fit")
def _fit(ring: Ring) -> Iterator[SkinFit]:
    with RingReader(ring.name) as reader, SkinFit(ring.name, reader) as made:
        play(ring, np.zeros(len(HEXAGON)), 1, answer=1)
        made.look()
        wait_for(lambda: not busy(made), LONG)
        yield made


def busy(fit: SkinFit) -> bool:
    fit.tell()
    with closing(FitReader(fit.ring.name.removesuffix(".fit"))) as reader:
        return bool(reader.status()["phase"] != "ready")


class Answered(NamedTuple):
    """What the fit, and engine and fit together, answer now."""

    rows: Any
    by: list[str]
    pressure: Any
    patches: Any
    status: dict[str, Any]


def answered(ring: Ring) -> Answered:
    with closing(FitReader(ring.name)) as reader, Live(ring.name) as live:
        rows, by = best_contacts(live.latest(), reader)
        newest = reader.latest()
        patches = None if newest is None else newest.patches.copy()
        return Answered(rows, by, reader.pressure(0), patches, reader.status())


def test_force_and_place_are_true_where_the_engine_is_far_off(ring: Ring, fit: SkinFit) -> None:
    play(ring, pressed(Sphere(radius=10e-3, force=1.0, position=PLACE)), 40)
    wait_for(fit.look)
    rows, by, pressure, patches, _ = answered(ring)
    assert by == ["fit"]
    assert rows["normal_force"][0] == pytest.approx(1.0, abs=0.15)
    assert np.hypot(*(rows["position"][0][:2] - PLACE)) < 0.5e-3
    assert (rows["x"][0], rows["y"][0]) == pytest.approx(rows["position"][0][:2])
    assert rows["track"][0] == 4
    assert rows["age"][0] == pytest.approx(1.0)
    assert 40 <= patches["readings"][0] <= 42  # with one or two of before, perhaps
    assert pressure.sum() * sf.Grid.square(HEXAGON, 20).cell_area == pytest.approx(
        rows["normal_force"][0], rel=1e-3
    )


def test_it_ends_with_the_touch(ring: Ring, fit: SkinFit) -> None:
    play(ring, np.zeros(len(HEXAGON)), 3, answer=1)
    assert len(answered(ring).rows) == 0  # before the fit has looked
    play(ring, np.zeros(len(HEXAGON)), 30, answer=1)
    wait_for(fit.look)
    found = answered(ring)
    assert len(found.rows) == 0
    assert found.pressure is None


def test_what_the_engine_takes_for_a_touch_is_none(ring: Ring, fit: SkinFit) -> None:
    play(ring, np.zeros(len(HEXAGON)), 40, seen=0.2)
    wait_for(fit.look)
    assert len(answered(ring).rows) == 0


def test_what_no_few_contacts_explain_is_left_to_the_engine(ring: Ring, fit: SkinFit) -> None:
    rough = np.random.default_rng(7).normal(0.0, 0.05, len(HEXAGON))
    play(ring, rough, 20)
    wait_for(fit.look)
    fit.tell()
    found = answered(ring)
    assert found.by == ["engine"]
    assert found.rows["normal_force"][0] == 1.6
    assert found.pressure is None
    assert found.status["left_to_engine"] == [HEXAGON.name]
    assert found.patches["state"][0] == int(Fitted.UNHELPFUL)


def test_the_page_tells_what_the_fit_does(ring: Ring, fit: SkinFit) -> None:
    fit.tell()
    with closing(LiveSource(ring.name)) as feed:
        told = feed.status()["fit"]
    assert told["phase"] == "ready"
    assert told["failed"] == ""
    assert told["fits"] == fit.ring.status["fits"][0]


def test_a_new_baseline_is_taken_over(ring: Ring, fit: SkinFit) -> None:
    tare(ring)
    play(ring, pressed(Sphere(radius=10e-3, force=2.0, position=PLACE)), 20)
    wait_for(fit.look)
    before = answered(ring).rows["force_std"][0]
    tare(ring, 3.0 * NOISE)
    play(ring, pressed(Sphere(radius=10e-3, force=2.0, position=PLACE)), 20)
    wait_for(fit.look)
    after = answered(ring).rows["force_std"][0]
    tare(ring)
    assert after > before


def test_boards_that_clip_at_rest_are_left_to_the_engine() -> None:
    press_now = np.maximum(pressed(Sphere(radius=10e-3, force=1.0, position=PLACE)), 0)
    with (
        skin_ring(settings(board=CySkinCount())) as ring,
        RingReader(ring.name) as source,
        SkinFit(ring.name, source) as own,
    ):
        assert not own.look()  # before there is a baseline
        tare(ring)
        play(ring, press_now, 20)
        assert own.look()
        assert not own.look()
        own.tell()
        found = answered(ring)
        assert (found.by, found.rows["normal_force"][0]) == (["engine"], 1.6)
        assert found.status["left_to_engine"] == [HEXAGON.name]


@pytest.mark.parametrize(
    ("board", "clips"),
    [(CySkinCount(), True), (ICubByte(), False), (PlainCount(), False), (None, False)],
)
def test_which_boards_clip_at_rest(board: Convention | None, clips: bool) -> None:
    assert clips_at_rest(board) == clips


def test_a_skin_is_told_from_its_fit(
    ring: Ring, fit: SkinFit, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = (ring.name, fit_name(ring.name))
    own = [each for each in Ring.names() if each.name in both]  # other tests run skins, too
    assert len(own) == 2
    monkeypatch.setattr(Ring, "names", lambda: own)
    assert chosen(None) == ring.name


def test_the_process_ends_when_it_is_told_to_and_takes_its_ring_away() -> None:
    with skin_ring() as ring, closing(FitReader(ring.name)) as reader:
        command = [sys.executable, "-m", "skinfield.loop.fit_process", ring.name]
        child = subprocess.Popen([*command, "--parent", str(os.getpid())])
        try:
            told = wait_for(lambda: reader.status() or None, LONG)
            assert told["phase"] in ("preparing", "ready")
            assert told["pid"] == child.pid
            child.send_signal(signal.SIGTERM)
            assert child.wait(LONG) == 0
        finally:
            child.kill()
            child.wait()
        assert fit_name(ring.name) not in [each.name for each in Ring.names()]
