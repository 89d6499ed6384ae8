"""Messages of a known skin, against values worked out by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ros2_ring import MOVE, TURN, TwoPatches, contact, two_patches
from scipy.spatial.transform import Rotation

from skinfield.bridges.ros2.messages import SAID, Speaker
from skinfield.files.ros import RosbagKinds
from skinfield.files.ros.messages import axes_at, quaternion
from skinfield.loop.client import Live
from skinfield.loop.fit_ring import FitSlot, Fitted
from skinfield.loop.status import Observer
from skinfield.ring import State

STAMP = 1_700_000_000_000_000_123
FIRST = contact(0, 7, 2.0, (0.01, 0.0, 0.0), (0.6, 0.0, 0.8))
SECOND = contact(1, 9, 1.5, (0.005, 0.005, 0.0))
WHAT = ("contacts", "frames", "contact_wrench", "wrench", "taxels")


@pytest.fixture
def running():
    with TwoPatches() as engine:
        engine.cycle([FIRST, SECOND], (STAMP, STAMP + 5), invalid=(2,))
        with Live(engine.ring.name) as live:
            yield engine, live, Speaker(live.skin, RosbagKinds())


def said(live, speaker, what):
    return {out.topic: out.message for out in speaker.of_snapshot(live.latest(), (what,))}


def xyz(message):
    return [message.x, message.y, message.z]


def test_contacts(running):
    _, live, speaker = running
    (array,) = said(live, speaker, "contacts").values()
    first, second = array.contacts
    assert (array.header.stamp.sec, array.header.stamp.nanosec) == (1_700_000_000, 128)
    assert (first.header.stamp.nanosec, first.header.frame_id) == (123, "l_hand")
    assert (first.id, first.patch, first.contact_frame) == (7, "left palm", "left_palm_contact_7")
    np.testing.assert_allclose(xyz(first.position), [0.1, 0.21, 0.3])  # turned and moved
    np.testing.assert_allclose(xyz(first.normal), [0.0, 0.6, 0.8], atol=1e-15)
    np.testing.assert_allclose(xyz(first.wrench.force), [0.0, -1.2, -1.6], atol=1e-15)
    assert xyz(first.wrench.torque) == [0.0, 0.0, 0.0]
    known = ("normal_force", 2.0), ("force_std", 0.1), ("position_std", 2e-4), ("area", 3e-5)
    for name, value in (*known, ("peak_pressure", 4e4), ("age", 0.5), ("speed", 1e-3)):
        assert getattr(first, name) == value
    assert (second.header.frame_id, second.header.stamp.nanosec) == ("2nd-finger", 128)
    np.testing.assert_allclose(xyz(second.position), [0.005, 0.005, 0.0])


def test_frames_and_wrenches_agree(running):
    """A contact's force, brought from its own frame to the link's, is the contacts' one."""
    _, live, speaker = running
    (frames,) = said(live, speaker, "frames").values()
    wrench = said(live, speaker, "contact_wrench")["/skin/left_palm/contact_wrench"]
    totals = said(live, speaker, "wrench")
    move = frames.transforms[0]
    assert (move.header.frame_id, move.child_frame_id) == ("l_hand", "left_palm_contact_7")
    np.testing.assert_allclose(xyz(move.transform.translation), [0.1, 0.21, 0.3])
    turn = move.transform.rotation
    assert wrench.header.frame_id == "left_palm_contact_7"
    assert xyz(wrench.wrench.force) == [0.0, 0.0, -2.0]
    turned = Rotation.from_quat([*xyz(turn), turn.w]).apply(xyz(wrench.wrench.force))
    np.testing.assert_allclose(turned, [0.0, -1.2, -1.6], atol=1e-12)
    total = totals["/skin/left_palm/wrench"]
    assert total.header.frame_id == "l_hand"
    np.testing.assert_allclose(xyz(total.wrench.force), turned, atol=1e-12)
    torque = np.cross([0.1, 0.21, 0.3], turned)
    np.testing.assert_allclose(xyz(total.wrench.torque), torque, atol=1e-12)
    assert xyz(totals["/skin/patch_2nd_finger/wrench"].wrench.force) == [0.0, 0.0, -1.5]


def test_taxels(running):
    engine, live, speaker = running
    clouds = said(live, speaker, "taxels")
    cloud = clouds["/skin/left_palm/taxels"]
    points = np.frombuffer(cloud.data.tobytes(), "<f4").reshape(6, 4)
    places = engine.skin[0].positions @ TURN.T + MOVE
    np.testing.assert_allclose(points[:, :3], places, rtol=1e-6)
    np.testing.assert_array_equal(points[:, 3], [0, 1, np.nan, 3, 4, 5])
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "value"]
    assert [field.offset for field in cloud.fields] == [0, 4, 8, 12]
    assert (cloud.point_step, cloud.row_step, cloud.width, cloud.height) == (16, 96, 6, 1)
    assert not cloud.is_dense
    assert clouds["/skin/patch_2nd_finger/taxels"].is_dense


def test_a_reading_is_told_once(running):
    engine, live, speaker = running
    assert len(list(speaker.of_snapshot(live.latest(), WHAT))) == 1 + 1 + 2 + 2 + 2
    assert list(speaker.of_snapshot(live.latest(), WHAT)) == []
    engine.cycle([FIRST, SECOND], (STAMP, STAMP + 9))  # the second patch only
    out = list(speaker.of_snapshot(live.latest(), WHAT))
    topics = [each.topic for each in out]
    finger = "/skin/patch_2nd_finger/"
    assert topics == ["/skin/contacts", "/tf", *(finger + w for w in WHAT[2:])]
    assert len(out[0].message.contacts) == 2
    assert len(out[1].message.transforms) == 1
    engine.cycle([], (STAMP - 10**12, STAMP + 9))  # the clock was set back
    assert {each.topic for each in speaker.of_snapshot(live.latest(), ("wrench",))} == {
        "/skin/left_palm/wrench"
    }


def test_without_an_answer_nothing_is_said_and_without_a_touch_that(running):
    engine, live, speaker = running
    engine.cycle([FIRST, SECOND], (STAMP + 9, STAMP + 9), answers=(0, 2))
    out = list(speaker.of_snapshot(live.latest(), WHAT))
    assert not [each for each in out if "left_palm" in each.topic]
    assert [each.id for each in out[0].message.contacts] == [9]
    engine.cycle([], (STAMP + 19, 0))
    out = {o.topic: o.message for o in speaker.of_snapshot(live.latest(), WHAT)}
    assert set(out) == {"/skin/contacts", "/skin/left_palm/wrench", "/skin/left_palm/taxels"}
    assert out["/skin/contacts"].contacts == []
    assert xyz(out["/skin/left_palm/wrench"].wrench.force) == [0.0, 0.0, 0.0]


def fit_of(row, stamp_ns):
    """A fit beside the engine, with one answer."""
    slot, patch = FitSlot.empty(2, 16, 8), int(row["patch"])
    found = slot.patches[patch]
    found["state"], found["contacts"], found["touched"] = Fitted.DONE, 1, 1
    found["stamp_ns"] = stamp_ns
    slot.contacts[patch, 0] = row
    return SimpleNamespace(latest=lambda: slot)


def test_the_fit_counts_where_it_is_recent(running):
    _, live, speaker = running
    fit = fit_of(contact(0, 7, 2.5, (0.01, 0.0, 0.0)), STAMP)
    out = speaker.of_snapshot(live.latest(), WHAT, fit)
    of = {each.topic: each.message for each in out}
    told = [(c.id, c.normal_force, c.fitted) for c in of["/skin/contacts"].contacts]
    assert told == [(7, 2.5, True), (9, 1.5, False)]
    assert of["/skin/left_palm/wrench"].wrench.force.z == -2.5
    old = fit_of(contact(0, 7, 2.5, (0.01, 0.0, 0.0)), STAMP - 10**10)
    out = Speaker(live.skin, RosbagKinds()).of_snapshot(live.latest(), ("contacts",), old)
    assert [c.fitted for c in next(out).message.contacts] == [False, False]


def test_diagnostics(running):
    engine, live, speaker = running

    def levels():
        out = speaker.of_status(Observer(live.reader).look(), STAMP)
        assert out.message.header.stamp.nanosec == 123
        kinds = RosbagKinds()
        back = kinds.store.deserialize_cdr(kinds.bytes_of(out.kind, out.message), out.kind)
        assert [each.level for each in back.status] == [each.level for each in out.message.status]
        return {each.name.partition(": ")[2]: each for each in out.message.status}

    told = levels()
    palm = told["patch left palm"]
    assert (told["engine"].level, told["engine"].hardware_id) == (0, engine.ring.name)
    assert (palm.level, palm.message) == (1, "1 taxels left out")
    values = {each.key: each.value for each in palm.values}
    assert (values["taxels left out"], values["force (N)"]) == ("1", "2")
    assert told["patch 2nd-finger"].level == 0
    engine.ring.status["stale_ns"][0] = 10**6
    engine.cycle([], (STAMP, 0), answers=(2, 0))
    told = levels()
    assert [told[f"patch {name}"].level for name in ("left palm", "2nd-finger")] == [3, 3]
    engine.ring.set_state(State.FAILED)
    assert levels()["engine"].level == 2


def test_channels():
    channels = list(Speaker(two_patches(), RosbagKinds()).channels())
    assert {each.what for each in channels} == set(SAID)
    assert len({each.topic for each in channels}) == len(channels) == 9


unit = st.tuples(*3 * [st.floats(-1, 1)]).map(np.array).filter(lambda v: v @ v > 1e-3)


@given(unit, st.sampled_from(list(np.eye(3))))
def test_axes_of_any_normal(normal, side):
    """z is the normal, right-handed; the quaternion turns as the matrix does."""
    normal = normal / np.linalg.norm(normal)
    axes = axes_at(normal, side)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-9)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_array_equal(axes[:, 2], normal)
    turned = Rotation.from_quat(quaternion(axes)).as_matrix()
    np.testing.assert_allclose(turned, axes, atol=1e-9)
