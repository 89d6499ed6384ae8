"""Repair of lost taxels: against what they read, and against the mean of their neighbours."""

from typing import Any

import numpy as np
import pytest
from live_skins import cycle_of, settings
from page_sources import StillSource, unpacked

import skinfield as sf
from skinfield.elastic import BaseStress, Capacitance
from skinfield.errors import Floats
from skinfield.lab.case_sets import ball
from skinfield.lab.cases import Case
from skinfield.loop import Answer
from skinfield.loop.model_config import Models
from skinfield.loop.slots import CycleSlot
from skinfield.loop.snapshot import Snapshot
from skinfield.page.scene_layout import SceneLayout
from skinfield.page.source import EngineView
from skinfield.page.updates import DEAD, FULL, Updates
from skinfield.simulate import press
from skinfield.simulate.rig import Pose
from skinfield.solve.repair import error_part, repaired

PATCH = sf.layouts.hexagon72()
LAYER, NOISE = sf.Layer(2e-3, 100e3, 0.5), 0.002
APART = np.linalg.norm(PATCH.plane[:, None] - PATCH.plane, axis=-1)
PITCH = float(np.median(np.sort(APART, axis=1)[:, 1]))


@pytest.fixture(scope="module")
def pressed() -> Floats:
    """Readings (T, L) of one ball and of two at some places, by a finer grid, with noise."""
    rng, rows = np.random.default_rng(3), []
    for bodies in ([ball(12, 1.0)], [ball(6, 0.6, -6), ball(12, 1.5, 6)]):
        solved = press(LAYER, bodies, 36e-3, 0.5e-3)
        for _ in range(5):
            x, y = rng.uniform(-8e-3, 8e-3, 2)
            pose = Pose(float(x), float(y), float(rng.uniform(0.0, 6.0)))
            case = Case.from_press("balls", solved, PATCH, "capacitance", pose, NOISE)
            rows.append(case.readings + rng.normal(0.0, NOISE, len(PATCH)))
    return np.array(rows)


def knocked_out(rec: sf.Reconstructor, pressed: Floats, every: int) -> Any:
    """What lost taxels read, their repair, its deviation, and the mean of their neighbours."""
    rows = []
    for reading in pressed:
        for lost in range(0, len(PATCH), every):
            near = (APART[lost] < 1.3 * PITCH) & (APART[lost] > 0.0)
            if np.abs(reading[near]).max() < 5 * NOISE:
                continue
            rec.reset()
            estimate = rec(np.where(APART[lost] > 0.0, reading, np.nan))
            one = estimate.readings[lost], estimate.readings_std[lost]
            rows.append((reading[lost], *one, reading[near].mean()))
    return np.array(rows).T


@pytest.mark.parametrize(
    ("solver", "every", "better"),
    [(sf.GaussianField(), 1, 0.95), (sf.ContactFit(check_mechanics=False), 1, 0.6)],
    ids=["field", "contacts"],
)
def test_sigma_holds_beside_contacts(
    solver: Any, every: int, better: float, pressed: Floats
) -> None:
    """Where most is at stake; the mean of the neighbours is further off."""
    rec = sf.Reconstructor(PATCH, LAYER, solver=solver, noise_std=NOISE)
    truth, value, std, mean = knocked_out(rec, pressed, every)
    off = np.abs(value - truth)
    assert len(truth) > 40
    assert 0.6 < np.mean(off < std) < 0.95
    assert 0.88 < np.mean(off < 2 * std) < 1.0
    assert np.median(off) < better * np.median(np.abs(mean - truth))


@pytest.mark.parametrize("radius", [8e-3, 10e-3, 16e-3])
def test_a_peak_that_one_taxel_sees_is_what_the_contact_says(radius: float) -> None:
    """Its neighbours read little, less than 0: the ring around the ball tells its force."""
    body = sf.simulate.Sphere(radius=radius, position=(6e-3, -4e-3), force=2.0)
    pressed = sf.simulate.press(sf.Layer(), [body])
    reading = np.asarray(pressed.capacitance(PATCH.plane, PATCH.pad_diameter))
    lost = int(np.argmax(reading))
    assert np.delete(reading, lost).max() < 1e-3 < 0.15 < reading[lost]
    rec = sf.Reconstructor(PATCH, sf.Layer(), noise_std=NOISE)
    whole = rec(reading)
    rec.reset()
    part = rec(np.where(np.arange(len(PATCH)) == lost, np.nan, reading))
    off, std = part.readings[lost] - reading[lost], part.readings_std[lost]
    assert abs(off) < min(1.5 * std, 0.3 * reading[lost])
    assert std < reading[lost]
    (one,), (other,) = part.contacts, whole.contacts
    assert one.force_std > other.force_std
    assert abs(one.normal_force - other.normal_force) < one.force_std
    assert abs(one.normal_force - 2.0) < 1.5 * one.force_std


@pytest.mark.parametrize("quantity", [Capacitance(), BaseStress()])
def test_what_was_measured_stays_and_nothing_depends_on_what_was_not(quantity: Any) -> None:
    rec = sf.Reconstructor(PATCH, quantity=quantity, solver=sf.GaussianField())
    given = np.random.default_rng(1).normal(0.0, 3.0, (3, 72)) * rec.model.noise_std
    valid = np.ones((3, 72), np.bool_)
    valid[:, 5] = valid[1, 30:34] = False
    other = np.where(valid, given, 40.0 * rec.model.noise_std)
    estimate, again = rec(given, valid=valid), rec(other, valid=valid)
    assert estimate.readings[valid].tobytes() == given[valid].tobytes()
    assert estimate.readings.tobytes() == again.readings.tobytes()
    assert (
        estimate.readings_std[valid] == np.broadcast_to(rec.model.noise_std, (3, 72))[valid]
    ).all()
    assert (estimate.readings_std[~valid] > rec.model.noise_std[0]).all()
    assert np.array_equal(estimate[1].readings, estimate.readings[1])


def test_a_drift_is_part_of_what_a_lost_taxel_reads() -> None:
    """It rests where it did: the others are at 0."""
    rec = sf.Reconstructor(PATCH, noise_std=0.002)
    rng, valid = np.random.default_rng(2), np.arange(72) != 40
    rest = np.where(valid, 0.0, 0.006)
    for step in range(400):
        last = rest * min(step / 300, 1.0) + rng.normal(0.0, 0.002, 72)
        estimate = rec(last, valid=None if step < 390 else valid, stamp_ns=step * 100_000_000)
    assert estimate.readings[40] == pytest.approx(0.006, abs=0.0025)
    assert 0.0019 < estimate.readings_std[40] < 0.004


def test_readings_of_a_linear_sensor_and_back() -> None:
    readings = np.linspace(-0.5, 10.0, 8)
    for order in (None, 1):
        quantity = Capacitance(order=order)
        linear = quantity.linearise(readings, np.empty(8))
        assert quantity.from_linear(np.array(linear)) == pytest.approx(readings)


def test_an_answer_that_leaves_nothing_to_test_it_is_believed_least() -> None:
    read, noise = np.array([0.3, 0.2, 0.1, 0.1, 0.0, 0.0]), np.full(6, 1e-3)
    few, most = error_part(read, read, noise, 1), error_part(read, read, noise, 3)
    assert 0.05**2 < few < most < 1.0 == error_part(read, read, noise, 4)
    assert error_part(read, 0.0 * read, noise, 0) == pytest.approx(1.0, rel=1e-3)
    assert error_part(0.0 * read, 0.0 * read, noise, 0) == 0.0  # nothing is touched


def test_far_from_all_that_answers_the_whole_patch_says_what_may_be() -> None:
    places, read = np.array([[0.0, 0], [1, 0], [2, 0], [30, 0]]), np.array([0.4, 0.2, 0.0, 9.0])
    valid, noise = np.arange(4) < 3, np.full(4, 1e-3)
    value, std = repaired(read, valid, noise, places, np.zeros(4))
    assert value[:3].tolist() == [0.4, 0.2, 0.0]
    assert std[3] > 0.1 > abs(value[3])
    (one, lost), (_, wide) = repaired(read[:2], valid[[0, 3]], noise[:2], places[:2], np.zeros(2))
    assert (one, abs(lost) <= 0.4, wide > 0.1) == (0.4, True, True)


def test_a_live_reader_has_repaired_readings_and_prepares_only_for_lost_ones() -> None:
    cycle = cycle_of(settings(), 0.004)
    slot = CycleSlot.empty(cycle.sizes)
    slot.patches["answer"], slot.patches["rung"] = int(Answer.CONTACTS), 20
    slot.values[:], slot.valid[:] = 0.02, 1
    models = Models(cycle.model_config, np.full(len(PATCH), 0.004))
    whole = Snapshot(slot, 1, models, 10**18)[PATCH.name]
    assert (whole.readings == np.float32(0.02)).all()
    assert (whole.readings_std == 0.004).all()
    assert not models.prepared
    slot.values[7], slot.valid[7] = 0.0, 0
    part = Snapshot(slot, 2, models, 10**18)[PATCH.name]
    assert part.readings[7] == pytest.approx(0.02, rel=0.35)
    assert 0.004 < part.readings_std[7] < 0.02
    assert models.prepared


def test_the_page_gets_what_a_lost_taxel_would_read() -> None:
    source = StillSource()
    source.read(1.0)
    snapshot = source.latest()
    assert snapshot is not None
    lost = int(np.argmax(snapshot.slot.values))
    snapshot.slot.valid[lost], snapshot.patches["invalid"] = 0, 1
    snapshot.prepare()
    updates = Updates(SceneLayout([source]))
    updates.quantity = "taxels"
    head, arrays = unpacked(updates.make(1, [EngineView(snapshot)], [])[-1])
    (fields,) = head["patches"]
    assert arrays[fields["taxels"]][lost] == DEAD
    value = abs(snapshot["hexagon72"].readings[lost])
    assert arrays[fields["repaired"]][lost] == int(value / fields["taxels_full"] * FULL) < FULL
