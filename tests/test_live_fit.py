"""The fit beside the engine, on a ring that is filled here."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import numpy as np
import pytest
from live_skins import LAYER, settings, wait_for
from numpy.typing import NDArray

import skinfield as sf
from skinfield.acquisition import Port
from skinfield.conditioning import Convention, CySkinCount, ICubByte, PlainCount
from skinfield.live.best import best_contacts
from skinfield.live.client import Live, chosen
from skinfield.live.fit import SkinFit, clips_at_rest
from skinfield.live.fit_reader import FitReader
from skinfield.live.fit_ring import Fitted, fit_name
from skinfield.live.recipe import Recipe
from skinfield.live.ring_fields import open_ring
from skinfield.live.slots import Head, Slot
from skinfield.ring import Ring, RingReader
from skinfield.simulate import Sphere, press
from skinfield.viewer.live_feed import LiveFeed

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")

PATCH = sf.layouts.hexagon72()
NOISE, STEP_NS = 0.002, 10_000_000
PLACE, DEAD = (-4e-3, 6.3e-3), 11  # m, between taxels; a taxel far from there
LONG = 600.0  # s: a fresh clone compiles first
Floats = NDArray[np.float64]


@pytest.fixture(scope="module", name="ring")
def _ring() -> Iterator[Ring]:
    made = settings()
    found, _ = open_ring(made, Recipe.of(made, (Port("ticking", len(PATCH), "dC/C0"),)))
    try:
        with found:
            tare(found)
            yield found
    finally:
        Ring.remove(made.name)


def tare(ring: Ring, noise: float = NOISE) -> None:
    ring.status["calibration"][:] = 0.0, 1.0, noise, 1.0
    ring.status["noise_std"][:] = noise
    ring.status["tares"][0] += 1


def pressed(*bodies: Sphere) -> Floats:
    """ΔC/C₀ of a press, on cells that the fit does not share."""
    made = press(LAYER, list(bodies), 40e-3, 0.5e-3)
    return made.readings(PATCH.plane, PATCH.pad_diameter, "capacitance")


def play(ring: Ring, level: Floats, count: int, *, answer: int = 3, seen: float = 1.6) -> None:
    """Cycles with readings of this, in which the engine sees one contact of a force `seen`."""
    rng = np.random.default_rng(count)
    for _ in range(count):
        slot = Slot.of(ring.begin())
        slot.head[Head.FRESH] = 1
        slot.patches["fresh"], slot.patches["answer"] = len(PATCH), answer
        slot.patches["stamp_ns"] = (1000 + ring.number) * STEP_NS
        slot.patches["contacts"] = answer > 1
        row = slot.contacts[0][0]
        row["track"], row["x"], row["y"], row["normal_force"] = 4, *PLACE, seen
        row["age"], row["position"] = 1.0, (*PLACE, 0.0)
        slot.values[:] = level + rng.normal(0.0, NOISE, len(PATCH))
        slot.valid[:] = 1
        slot.values[DEAD], slot.valid[DEAD] = 0.3, 0
        ring.publish()


@pytest.fixture(scope="module", name="fit")
def _fit(ring: Ring) -> Iterator[SkinFit]:
    with RingReader(ring.name) as reader, SkinFit(ring.name, reader) as made:
        play(ring, np.zeros(len(PATCH)), 1, answer=1)
        made.look()
        wait_for(lambda: not busy(made), LONG)
        yield made


def busy(fit: SkinFit) -> bool:
    fit.tell()
    with_name = FitReader(fit.ring.name.removesuffix(".fit"))
    try:
        return bool(with_name.status()["phase"] != "ready")
    finally:
        with_name.close()


def answered(ring: Ring) -> tuple[np.ndarray, list[str], FitReader]:
    reader = FitReader(ring.name)
    with Live(ring.name) as live:
        rows, by = best_contacts(live.latest(), reader)
    return rows, by, reader


def test_force_and_place_are_true_where_the_engine_is_far_off(ring: Ring, fit: SkinFit) -> None:
    play(ring, pressed(Sphere(radius=10e-3, force=1.0, position=PLACE)), 40)
    wait_for(fit.look)
    rows, by, reader = answered(ring)
    assert by == ["fit"]
    assert rows["normal_force"][0] == pytest.approx(1.0, abs=0.15)
    assert np.hypot(*(rows["position"][0][:2] - PLACE)) < 0.5e-3
    assert (rows["x"][0], rows["y"][0]) == pytest.approx(rows["position"][0][:2])
    assert rows["track"][0] == 4
    assert rows["age"][0] == pytest.approx(1.0)
    found = reader.latest()
    assert found is not None
    assert 40 <= found.patches["readings"][0] <= 42  # with one or two of before, perhaps
    pressure = reader.pressure(0)
    assert pressure is not None
    assert pressure.sum() * sf.Grid.square(PATCH, 20).cell_area == pytest.approx(
        rows["normal_force"][0], rel=1e-3
    )
    reader.close()


def test_it_ends_with_the_touch(ring: Ring, fit: SkinFit) -> None:
    play(ring, np.zeros(len(PATCH)), 3, answer=1)
    rows, _, reader = answered(ring)  # before the fit has looked
    reader.close()
    assert len(rows) == 0
    play(ring, np.zeros(len(PATCH)), 30, answer=1)
    wait_for(fit.look)
    rows, _, reader = answered(ring)
    assert len(rows) == 0
    assert reader.pressure(0) is None
    reader.close()


def test_what_the_engine_takes_for_a_touch_is_none(ring: Ring, fit: SkinFit) -> None:
    play(ring, np.zeros(len(PATCH)), 40, seen=0.2)
    wait_for(fit.look)
    rows, _, reader = answered(ring)
    reader.close()
    assert len(rows) == 0


def test_what_no_few_contacts_explain_is_left_to_the_engine(ring: Ring, fit: SkinFit) -> None:
    rough = np.random.default_rng(7).normal(0.0, 0.05, len(PATCH))
    play(ring, rough, 20)
    wait_for(fit.look)
    rows, by, reader = answered(ring)
    fit.tell()
    assert by == ["engine"]
    assert rows["normal_force"][0] == 1.6
    assert reader.pressure(0) is None
    assert reader.status()["left_to_engine"] == [PATCH.name]
    found = reader.latest()
    assert found is not None
    assert found.patches["state"][0] == int(Fitted.UNHELPFUL)
    reader.close()


def test_the_page_tells_what_the_fit_does(ring: Ring, fit: SkinFit) -> None:
    fit.tell()
    feed = LiveFeed(ring.name)
    told = feed.status()["fit"]
    feed.close()
    assert told["phase"] == "ready"
    assert told["failed"] == ""
    assert told["fits"] == fit.ring.status["fits"][0]


def test_a_new_baseline_is_taken_over(ring: Ring, fit: SkinFit) -> None:
    tare(ring)
    play(ring, pressed(Sphere(radius=10e-3, force=2.0, position=PLACE)), 20)
    wait_for(fit.look)
    before = answered(ring)[0]["force_std"][0]
    tare(ring, 3.0 * NOISE)
    play(ring, pressed(Sphere(radius=10e-3, force=2.0, position=PLACE)), 20)
    wait_for(fit.look)
    after = answered(ring)[0]["force_std"][0]
    tare(ring)
    assert after > before


def test_boards_that_clip_at_rest_are_left_to_the_engine() -> None:
    made = settings(board=CySkinCount())
    ring, _ = open_ring(made, Recipe.of(made, (Port("ticking", len(PATCH)),)))
    try:
        with ring, RingReader(made.name) as source, SkinFit(made.name, source) as own:
            assert not own.look()  # before there is a baseline
            tare(ring)
            play(ring, np.maximum(pressed(Sphere(radius=10e-3, force=1.0, position=PLACE)), 0), 20)
            assert own.look()
            assert not own.look()
            own.tell()
            rows, by, reader = answered(ring)
            assert (by, rows["normal_force"][0]) == (["engine"], 1.6)
            assert reader.status()["left_to_engine"] == [PATCH.name]
            reader.close()
    finally:
        Ring.remove(made.name)


@pytest.mark.parametrize(
    ("board", "clips"),
    [(CySkinCount(), True), (ICubByte(), False), (PlainCount(), False), (None, False)],
)
def test_which_boards_clip_at_rest(board: Convention | None, clips: bool) -> None:
    assert clips_at_rest(board) == clips


def test_a_skin_is_told_from_its_fit(ring: Ring, fit: SkinFit) -> None:
    names = [each.name for each in Ring.names() if each.alive]
    assert fit_name(ring.name) in names
    if len(names) == 2:  # no other test runs a skin now
        assert chosen(None) == ring.name


def test_the_process_ends_when_it_is_told_to_and_takes_its_ring_away() -> None:
    made = settings()
    ring, _ = open_ring(made, Recipe.of(made, (Port("ticking", len(PATCH)),)))
    command = [sys.executable, "-m", "skinfield.live.fit_process", made.name]
    try:
        with ring:
            child = subprocess.Popen([*command, "--parent", str(os.getpid())])
            try:
                reader = FitReader(made.name)
                told = wait_for(lambda: reader.status() or None, LONG)
                assert told["phase"] in ("preparing", "ready")
                assert told["pid"] == child.pid
                reader.close()
                child.send_signal(signal.SIGTERM)
                assert child.wait(LONG) == 0
            finally:
                child.kill()
                child.wait()
        assert fit_name(made.name) not in [each.name for each in Ring.names()]
    finally:
        Ring.remove(made.name)
