"""One reading has the same contacts through every door, bit for bit."""

import json
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from command_line import result_of, run
from live_skins import settings
from page_sources import unpacked

import skinfield as sf
from skinfield.bridges.ros2.messages import Speaker
from skinfield.bridges.zenoh.messages import PLAIN, contact_plain, strict_json
from skinfield.cli import options
from skinfield.cli.report import plain_contacts
from skinfield.cli.run import DIGITS, sum_up_contacts
from skinfield.estimate.contact_table import rows_from_estimate
from skinfield.estimate.row_contacts import contacts_of_rows
from skinfield.files import save_recording
from skinfield.files.mcap.live import LiveRecording
from skinfield.files.results import read_results
from skinfield.files.ros.bag import RosbagKinds
from skinfield.loop import status
from skinfield.loop.engine_process import EngineProcess
from skinfield.loop.slots import CycleSlot
from skinfield.page.scene_layout import SceneLayout
from skinfield.page.source import EngineView, LiveSource
from skinfield.page.updates import Updates
from skinfield.record.recorder import Recorder, forget_state
from skinfield.ring import Ring, RingReader, State
from skinfield.signal import Kind, Port, counters
from skinfield.skin.reading import Recording

PATCH, LAYER, NOISE = sf.layouts.icub_triangle(), sf.Layer(), 0.002
GRID = sf.Grid.square(PATCH, nodes=12)
STATED = ("position", "force", "covariance", "area_std", "axes", "outline", "cells")
WORDS = ("--skin", "icub_triangle", "--grid", 12, "--noise", NOISE, "--profile", "silicone-2mm")


@pytest.fixture(scope="module")
def readings():
    """Six of one press, the first as `skinfield demo` makes it."""
    ball = sf.simulate.Sphere(position=(1e-3, 2e-3), force=1.0, radius=4e-3)
    extent = 2 * float(np.abs(PATCH.plane).max()) + 12e-3
    true = sf.simulate.press(LAYER, [ball], extent=extent, cell=min(0.4e-3, extent / 40))
    clean, rng = true.capacitance(PATCH.plane, PATCH.pad_diameter), np.random.default_rng(0)
    return clean + np.stack([rng.normal(scale=NOISE, size=len(PATCH)) for _ in range(6)])


@pytest.fixture(scope="module")
def rec():
    return sf.Reconstructor(PATCH, LAYER, GRID, noise_std=NOISE)


def rows(estimate):
    return [row[3:-1] for row in rows_from_estimate(estimate, 0, 0)]  # but for the scale


def test_one_name_is_the_default_of_library_and_commands(rec):
    assert rec.solver == options.solver_of(options.USUAL_SOLVER) == sf.Auto()


def test_runs_are_their_readings_one_after_the_other(rec, readings):
    rec.reset()
    each = [rec(reading) for reading in readings]
    rec.reset()
    together = rec(readings)
    assert together.solver == ("ContactFit",) * 6
    assert not together.is_field.any()
    assert rows(together) == [row for one in each for row in rows(one)]
    assert together.normal_force.tolist() == [
        sum(contact.normal_force for contact in found) for found in together.contacts
    ]
    rec.reset()
    out = rec.rows()
    for one, other, reading in zip(together, each, readings, strict=True):
        assert rec.into(reading, out) == len(one.contacts) == 1
        np.testing.assert_array_equal(one.contacts[0].covariance, other.contacts[0].covariance)
        (row,) = contacts_of_rows(out[:1], GRID, one.pressure)
        for name in STATED:
            np.testing.assert_array_equal(getattr(row, name), getattr(one.contacts[0], name))
    skin = sf.Skin((PATCH, replace(PATCH, name="next")))
    engine = sf.Engine(skin, LAYER, rungs=(12,), solver=sf.Auto(), noise_std=NOISE)
    rec.reset()
    first = rec(readings[0]).contacts[0]
    for patch in engine([readings[0]] * 2, budget=10.0).values():
        for name in STATED:
            np.testing.assert_array_equal(
                getattr(patch.contacts[0], name), getattr(first, name), name
            )


def test_commands_give_what_a_reconstructor_gives(rec, readings, tmp_path, monkeypatch):
    rec.reset()
    expected = rec(readings)
    monkeypatch.chdir(tmp_path)
    said = result_of("demo", *WORDS, "--press", "1,2,1,4")
    assert (said["solver"], len(said["contacts"])) == ("ContactFit", 1)
    assert said["contacts"] == json.loads(json.dumps(plain_contacts(expected.contacts[0])))
    stamps = np.arange(6) * 20_000_000
    save_recording(Recording(stamps, readings, unit="dC/C0"), tmp_path / "press.npz")
    run("reconstruct", "press.npz", *WORDS, "-o", "press.skinfield")
    results = read_results("press.skinfield")
    np.testing.assert_array_equal(results.values(0, 6), readings)
    assert rows(results.estimates(0, 6)) == rows(expected)
    assert rows(results.estimate(4)) == rows(expected[4])
    table = sf.load_contacts("press.skinfield").to_pylist()
    assert [tuple(row.values())[3:-1] for row in table] == rows(expected)
    assert sf.open_results("press.skinfield").normal_force.values.tolist() == (
        expected.normal_force.tolist()
    )


def test_a_field_that_answers_is_summed_and_says_why():
    patch = sf.layouts.hexagon72()
    rec = sf.Reconstructor(patch, sf.Layer(poisson_ratio=0.3), noise_std=NOISE)
    wave = 2 * np.pi * rec.model.grid.plane / 30e-3
    broad = rec.model.matrix @ (1.0 + 0.5 * np.sin(wave).prod(axis=1))
    est = rec(0.15 * broad / broad.max())
    assert (est.solver, est.is_field) == ("NonNegative", True)
    assert est.notes == ("more probable than few contacts: a field answers",)
    assert est.normal_force == est.pressure.sum() * est.grid.cell_area


class Handed:
    """Source, and its stream, of the row of ΔC/C₀ that was put into `row`, once each."""

    def __init__(self):
        self.row, self.up, self.counters = None, True, counters()
        self.ports = (Port("handed", len(PATCH), "dC/C0"),)

    def open(self):
        return self

    def poll(self, blocks, channel, now_ns):
        row, self.row = self.row, None
        if row is not None:
            blocks.put(now_ns, channel, row, Kind.FLOATS)
        return int(row is not None)

    def filenos(self):
        return ()

    def close(self):
        pass


class Loop:
    """The engine of a live skin, cycle by cycle, with all the time that an answer takes."""

    def __init__(self):
        self.source, rng = Handed(), np.random.default_rng(4)
        more = {"tare_seconds": 0.1, "stale_after": 600.0, "budget": AMPLE, "rungs": (12,)}
        made = {"skin": PATCH, "layer": LAYER, "sources": (self.source,), "board": None}
        self.process = EngineProcess(settings(**made, **more))
        self.name = self.process.settings.name
        self.stamps = []  # of each cycle until all is ready
        with RingReader(self.name) as reader:
            slot = reader.slot()
            while self.process.updater is None or self.process.better or self.process.began:
                self.cycle(rng.normal(scale=NOISE, size=len(PATCH)))
                cycle = CycleSlot.of(reader.latest(slot).arrays)
                self.stamps.append(int(cycle.patches["stamp_ns"][0]))
                time.sleep(1e-3)
        self.process.ring.set_state(State.RUNNING)
        self.noise_std = self.process.ring.status["noise_std"].copy()

    def cycle(self, reading):
        self.source.row = reading.astype(np.float32)
        self.process.one(time.monotonic_ns(), time.monotonic_ns())


AMPLE = 600.0  # s


@pytest.fixture(scope="module")
def loop():
    made = Loop()
    yield made
    made.process.close()
    Ring.remove(made.name)
    forget_state(made.name)


@pytest.fixture(scope="module")
def moving():
    """Readings of a ball that moves by 2 mm each, and between two of them is lifted."""
    balls = [
        sf.simulate.Sphere(position=(1e-3 * x, 2e-3), force=f, radius=4e-3)
        for x, f in ((-3.0, 0.5), (-1.0, 1.0), (1.0, 2.0), (3.0, 3.0))
    ]
    rng = np.random.default_rng(5)
    made = []
    for ball in balls:
        true = sf.simulate.press(LAYER, [ball], extent=45e-3, cell=0.5e-3)
        clean = true.capacitance(PATCH.plane, PATCH.pad_diameter)
        made.append((clean + rng.normal(scale=NOISE, size=len(PATCH))).astype(np.float32))
    return made


@pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
def test_once_answered_a_patch_stays_so_while_a_better_solver_takes_over(loop):
    answered = np.trim_zeros(loop.stamps, "f")
    assert (np.diff(answered) >= 0).all()
    assert loop.process.updater.model_config.solver == sf.Auto()


@pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
def test_a_live_skin_gives_what_a_reconstructor_gives(loop, moving, tmp_path):
    rec = sf.Reconstructor(PATCH, LAYER, GRID, noise_std=loop.noise_std)
    out, expected, path = rec.rows(), [], tmp_path / "touch.mcap"
    speaker, untouched = Speaker(sf.Skin((PATCH,)), RosbagKinds()), np.zeros(len(PATCH))
    recorder = Recorder(loop.name, path)
    with sf.connect(loop.name) as live:
        source = LiveSource(loop.name)
        for reading in moving:
            loop.cycle(untouched)
            loop.process.reset = True  # each is answered as a first one
            loop.cycle(reading)
            found = live.latest()
            rec.reset()
            assert rec.into(reading.astype(float), out, deadline=AMPLE) == 1
            assert (found.patches["answer"], found.patches["readings"]) == (4, 1)
            (row,) = found.contacts
            expected.append(row)
            for name in ROWS:
                np.testing.assert_array_equal(row[name], out[0][name], name)
            (contact,) = found[PATCH.name].contacts
            (same,) = contacts_of_rows(out[:1], GRID, found[PATCH.name].pressure)
            for name in STATED:
                np.testing.assert_array_equal(getattr(contact, name), getattr(same, name), name)
            assert found[PATCH.name].normal_force == found.force == row["normal_force"]
            (plain,) = status.plain_contacts([PATCH.name], found.contacts)
            assert_same(plain, row, [name for name in ROWS if name != "shape"])
            assert_same(json.loads(strict_json(contact_plain(row, [PATCH]))), row, PLAIN)
            update = Updates(SceneLayout([source])).make(1, [EngineView(found)], [])[-1]
            (drawn,) = unpacked(update)[0]["contacts"]
            assert_same(drawn, row, ("x", "y", "force_std", "place_std", "area", "radius"))
            assert drawn["force"] == row["normal_force"]
            (spoken,) = speaker.of_snapshot(found, ("contacts",))
            assert_same(vars(spoken.message.contacts[0]), row, SPOKEN)
            known = {}
            sum_up_contacts(known, found.contacts, [PATCH.name], 0.0, found.solvers)
            (summed,) = known.values()
            assert summed["solver"] == found[PATCH.name].solver
            assert summed["force_n"] == round(float(row["normal_force"]), DIGITS)
            recorder.step()
        source.close()
    recorder.close()
    recorded = [each for each in LiveRecording.open(path).cycles() if len(each.contacts)]
    assert [each.contacts.tobytes() for each in recorded] == [row.tobytes() for row in expected]


def assert_same(plain, row, names):
    """Values of a message, which JSON or a bus carries, are those of a row."""
    for name in names:
        np.testing.assert_array_equal(plain[name], row[name], name)


SPOKEN = ("normal_force", "force_std", "area", "radius", "peak_pressure")
ROWS = ("x", "y", "position", "normal", "normal_force", "covariance", "force_std", "place_std")
ROWS += ("area", "area_std", "peak_pressure", "moments", "shape", "radius", "maybe")
