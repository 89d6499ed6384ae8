"""Messages of ROS 2 of a known skin: what they say, their bytes, when they go, and the node."""

import ast
import logging
import struct
import sys
from array import array
from collections import Counter
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live_skins import wait_for
from ros2_ring import MOVE, TURN, TwoPatches, contact, two_patches
from rosbags.interfaces import Nodetype

from skinfield.bridges.ros2 import messages
from skinfield.bridges.ros2 import node as ros_node
from skinfield.bridges.ros2.messages import LOOKS, SAID, Speaker, Talker
from skinfield.errors import InputError
from skinfield.files.ros import RosbagKinds
from skinfield.files.ros.kinds import CONTACTS
from skinfield.files.ros.messages import axes_at, quaternion
from skinfield.loop.client import Live, NotRunning
from skinfield.loop.status import Observer
from skinfield.ring import State

BOTH = [contact(0, 7, 2.0, (0.01, 0.0, 0.0)), contact(1, 9, 1.0, (0.005, 0.005, 0.0))]
STAMP = 1_700_000_000_000_000_123
FIRST = contact(0, 7, 2.0, (0.01, 0.0, 0.0), (0.6, 0.0, 0.8))
SECOND = contact(1, 9, 1.5, (0.005, 0.005, 0.0))
WHAT = ("contacts", "frames", "contact_wrench", "wrench", "taxels")


@pytest.fixture
def engine():
    with TwoPatches() as made:
        yield made


@pytest.fixture
def live(engine):
    with Live(engine.ring.name) as found:
        yield found


@pytest.fixture
def speaker(engine, live):
    engine.cycle([FIRST, SECOND], (STAMP, STAMP + 5), invalid=(2,))
    return Speaker(live.skin, RosbagKinds())


def said(live, speaker, what):
    return {out.topic: out.message for out in speaker.of_snapshot(live.latest(), (what,))}


def xyz(message):
    return [message.x, message.y, message.z]


def test_contacts(live, speaker):
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
    shape = ("shape", "flat"), ("radius", 4e-3), ("maybe", True)
    for name, value in (*known, *shape, ("peak_pressure", 4e4), ("age", 0.5), ("speed", 1e-3)):
        assert getattr(first, name) == value
    assert (second.header.frame_id, second.header.stamp.nanosec) == ("2nd-finger", 128)
    np.testing.assert_allclose(xyz(second.position), [0.005, 0.005, 0.0])


def test_frames_and_wrenches_agree(live, speaker):
    """A contact's force, brought from its own frame to the link's, is the contacts' one."""
    (frames,) = said(live, speaker, "frames").values()
    wrenches = said(live, speaker, "contact_wrench")
    totals = said(live, speaker, "wrench")
    move = frames.transforms[0]
    assert (move.header.frame_id, move.child_frame_id) == ("l_hand", "left_palm_contact_7")
    np.testing.assert_allclose(xyz(move.transform.translation), [0.1, 0.21, 0.3])
    turn = move.transform.rotation
    wrench = wrenches["/skin/left_palm/contact_wrench"]
    assert wrench.header.frame_id == "left_palm_contact_7"
    assert xyz(wrench.wrench.force) == [0.0, 0.0, -2.0]
    v, w = np.array(xyz(turn)), turn.w
    force = np.array(xyz(wrench.wrench.force))
    turned = force + 2 * np.cross(v, np.cross(v, force) + w * force)
    np.testing.assert_allclose(turned, [0.0, -1.2, -1.6], atol=1e-12)
    total = totals["/skin/left_palm/wrench"]
    assert total.header.frame_id == "l_hand"
    np.testing.assert_allclose(xyz(total.wrench.force), turned, atol=1e-12)
    torque = np.cross([0.1, 0.21, 0.3], turned)
    np.testing.assert_allclose(xyz(total.wrench.torque), torque, atol=1e-12)
    assert xyz(totals["/skin/patch_2nd_finger/wrench"].wrench.force) == [0.0, 0.0, -1.5]


def test_taxels(engine, live, speaker):
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


def test_a_reading_is_told_once(engine, live, speaker):
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


def test_a_patch_without_an_answer_says_nothing(engine, live, speaker):
    engine.cycle([FIRST, SECOND], (STAMP + 9, STAMP + 9), answers=(0, 2))
    out = list(speaker.of_snapshot(live.latest(), WHAT))
    assert not [each for each in out if "left_palm" in each.topic]
    assert [each.id for each in out[0].message.contacts] == [9]


def test_nothing_touches(engine, live, speaker):
    engine.cycle([], (STAMP + 9, 0))
    out = {o.topic: o.message for o in speaker.of_snapshot(live.latest(), WHAT)}
    assert set(out) == {"/skin/contacts", "/skin/left_palm/wrench", "/skin/left_palm/taxels"}
    assert out["/skin/contacts"].contacts == []
    assert xyz(out["/skin/left_palm/wrench"].wrench.force) == [0.0, 0.0, 0.0]


class Cdr:
    """Reads CDR by hand: little-endian, each number at a multiple of its size."""

    def __init__(self, data: bytes) -> None:
        assert data[:4] == bytes([0, 1, 0, 0])
        self.data, self.at = data[4:], 0

    def take(self, form: str):
        size = struct.calcsize(form)
        self.at += -self.at % size
        (value,) = struct.unpack_from("<" + form, self.data, self.at)
        self.at += size
        return value

    def text(self) -> str:
        size = self.take("I")
        self.at += size
        assert self.data[self.at - 1] == 0
        return self.data[self.at - size : self.at - 1].decode()


def test_bytes_of_contacts(live, speaker):
    """Field by field in the order of the .msg files, by a reader that shares nothing."""
    kinds = RosbagKinds()
    (array,) = said(live, speaker, "contacts").values()
    cdr = Cdr(kinds.bytes_of(CONTACTS, array))
    assert (cdr.take("i"), cdr.take("I"), cdr.text(), cdr.take("I")) == (1_700_000_000, 128, "", 2)
    assert (cdr.take("i"), cdr.take("I"), cdr.text()) == (1_700_000_000, 123, "l_hand")
    assert (cdr.take("q"), cdr.text(), cdr.text()) == (7, "left palm", "left_palm_contact_7")
    numbers = [cdr.take("d") for _ in range(3 + 3 + 6 + 7)]
    wanted = [0.1, 0.21, 0.3, 0, 0.6, 0.8, 0, -1.2, -1.6, 0, 0, 0]
    np.testing.assert_allclose(numbers[:12], wanted, atol=1e-15)
    assert numbers[12:] == [2.0, 0.1, 2e-4, 3e-5, 4e4, 0.5, 1e-3]
    assert (cdr.text(), cdr.take("d"), cdr.take("?")) == ("flat", 4e-3, True)


def test_diagnostics(engine, live, speaker):

    def levels():
        out = speaker.of_status(Observer(live.reader).look(), STAMP)
        assert out.message.header.stamp.nanosec == 123
        kinds = RosbagKinds()
        back = kinds.store.deserialize_cdr(kinds.bytes_of(out.kind, out.message), out.kind)
        assert [each.level for each in back.status] == [each.level for each in out.message.status]
        return {each.name.partition(": ")[2]: each for each in out.message.status}

    told = levels()
    assert told["engine"].level == 0
    assert told["engine"].hardware_id == engine.ring.name
    assert told["patch left palm"].level == 1
    assert told["patch left palm"].message == "1 taxels left out"
    values = {each.key: each.value for each in told["patch left palm"].values}
    assert values["taxels left out"] == "1"
    assert values["force (relative)"] == "2"
    assert {each.key: each.value for each in told["engine"].values}["forces"] == "relative"
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
    *v, w = quaternion(axes)
    for column, unit in zip(axes.T, np.eye(3), strict=True):
        turned = unit + 2 * np.cross(v, np.cross(v, unit) + w * unit)
        np.testing.assert_allclose(turned, column, atol=1e-9)


def talker_of(live, rates, heard):
    return Talker(live, Speaker(live.skin, RosbagKinds()), rates, heard.append)


def test_each_reading_once(engine, live):
    """Two cycles of three have no new reading; of the palm there is one each time."""
    heard = []
    talker = talker_of(live, {"wrench": 1e4, "contacts": 1e4, "taxels": 1e-3}, heard)
    for number in range(30):
        engine.cycle(BOTH[:1], (STAMP + number // 3, STAMP))
        talker.step(LOOKS if number % 2 else 0.0)
    for _ in range(3):
        talker.step(0.0)
    counts = Counter(out.topic for out in heard)
    assert counts["/skin/left_palm/taxels"] == 1
    assert counts["/skin/patch_2nd_finger/wrench"] == 1
    palm = [out.stamp_ns - STAMP for out in heard if out.topic == "/skin/left_palm/wrench"]
    assert palm == sorted(set(palm))
    assert palm[-1] == 9
    assert len(palm) == counts["/skin/contacts"]


def test_without_answers_only_the_health_is_told(engine, live):
    heard = []
    talker = talker_of(live, {"wrench": 1e4, "diagnostics": 1e4}, heard)
    engine.cycle(BOTH[:1])
    engine.ring.set_state(State.FAILED)
    for _ in range(3):
        talker.step(0.0)
    assert {out.topic for out in heard} == {"/diagnostics"}
    assert heard[-1].message.status[0].level == 2


def test_it_goes_on_after_a_crash_of_the_engine(engine, live):
    heard = []
    talker = talker_of(live, {"wrench": 1e4, "diagnostics": 1e4}, heard)
    engine.cycle(BOTH[:1], (STAMP, STAMP))
    talker.step(LOOKS)
    engine.reopen()
    engine.cycle(BOTH[:1], (STAMP + 1, STAMP + 1))
    talker.step(LOOKS)
    palm = [out.stamp_ns - STAMP for out in heard if out.topic == "/skin/left_palm/wrench"]
    assert palm == [0, 1]
    told = [out.message.status[0] for out in heard if out.topic == "/diagnostics"]
    assert [{v.key: v.value for v in row.values}["restarts"] for row in told] == ["0", "1"]


def test_another_skin_of_that_name(engine, live):
    talker = talker_of(live, {"diagnostics": 1e4}, [])
    talker.step()
    name = engine.ring.name
    engine.close()
    other = TwoPatches(name)
    try:
        with pytest.raises(NotRunning, match="connect again"):
            talker.step()
    finally:
        engine.ring = other.ring  # closed by the fixture


@given(st.lists(st.floats(1e-4, 0.5), min_size=1, max_size=60), st.floats(0.5, 500.0))
def test_pace(steps, rate):
    """Never more than the rate over any time, but for one more; nothing due is forgotten."""
    live = SimpleNamespace(
        reader=SimpleNamespace(replaced=lambda: False), name="n", state=State.STOPPED
    )
    now, done = [100.0], []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(messages, "Observer", lambda *_, **__: SimpleNamespace(look=lambda: None))
        patch.setattr(messages.time, "monotonic", lambda: now[0])
        speaker = SimpleNamespace(of_status=lambda *_: now[0])
        talker = Talker(live, speaker, {"diagnostics": rate, "wrench": 0.0}, done.append)
        for step in steps:
            assert 0.0 <= talker.wait() <= LOOKS
            talker.step()
            assert now[0] < done[-1] + 1.0 / rate + 1e-9
            now[0] += step
    times = np.array(done)
    for first in range(len(times)):
        passed = times[first:] - times[first]
        assert (np.arange(len(passed)) <= passed * rate + 1 + 1e-6).all()


NUMBERS = {"float32": float, "float64": float, "bool": bool, "string": str}
PACKAGES = ("builtin_interfaces", "std_msgs", "geometry_msgs", "sensor_msgs", "tf2_msgs",
            "diagnostic_msgs", "skinfield_msgs")  # fmt: skip


def fits(node, value, classes) -> bool:
    """Whether rclpy's generated classes take a value for a field of some type."""
    kind, about = node
    if kind == Nodetype.BASE:
        if about[0] in ("byte", "octet"):
            return isinstance(value, bytes) and len(value) == 1
        return isinstance(value, NUMBERS.get(about[0], int))
    if kind == Nodetype.NAME:
        return isinstance(value, classes[about])
    inner = about[0]
    if inner[0] == Nodetype.BASE and inner[1][0] == "uint8":
        return isinstance(value, array) and value.typecode == "B"
    return isinstance(value, list) and all(fits(inner, each, classes) for each in value)


def message_class(kind, fields, classes):
    def init(self, **given):
        assert set(given) == {name for name, _ in fields}, kind  # none is forgotten
        for name, node in fields:
            assert fits(node, given[name], classes), f"{kind}.{name} = {given[name]!r}"
            setattr(self, name, given[name])

    return type(kind.rpartition("/")[2], (), {"__init__": init})


def message_modules(leave_out=()) -> dict[str, ModuleType]:
    store, classes, found = RosbagKinds().store, {}, {}
    for kind, (_, fields) in store.fielddefs.items():
        classes[kind] = message_class(kind, fields, classes)
    for package in PACKAGES:
        if package not in leave_out:
            module = ModuleType(f"{package}.msg")
            for kind, made in classes.items():
                if kind.startswith(f"{package}/"):
                    setattr(module, kind.rpartition("/")[2], made)
            found[package], found[f"{package}.msg"] = ModuleType(package), module
    return found


class StandIn:
    """Keeps what is published."""

    def __init__(self, name, parameters):
        self.name, self.parameters = name, parameters
        self.sent, self.made, self.timers, self.gone = [], {}, [], False

    def declare_parameter(self, name, usual):
        return SimpleNamespace(value=self.parameters.get(name, usual))

    def create_publisher(self, kind, topic, depth):
        def publish(message):
            assert type(message) is kind
            self.sent.append((topic, message))

        self.made[topic] = (kind.__name__, depth)
        return SimpleNamespace(publish=publish)

    def create_timer(self, seconds, call):
        self.timers.append((seconds, call))

    def get_logger(self):
        return logging.getLogger("stand-in")

    def destroy_node(self):
        self.gone = True


def rclpy_modules(nodes, spin, parameters=None) -> dict[str, ModuleType]:
    """`spin` is called with the node; nodes that are made are put into `nodes`."""
    names = ("rclpy", "rclpy.utilities", "rclpy.executors")
    found = {name: ModuleType(name) for name in names}
    module = found["rclpy"]
    module.init = lambda args=None: None
    module.try_shutdown = lambda: None
    module.spin = spin
    found["rclpy.utilities"].remove_ros_args = lambda args: args
    found["rclpy.executors"].ExternalShutdownException = type("Ended", (Exception,), {})

    def create_node(name):
        nodes.append(StandIn(name, parameters or {}))
        return nodes[-1]

    module.create_node = create_node
    return found


def put_in(monkeypatch, modules) -> None:
    absent = {f"{package}{part}": None for package in PACKAGES for part in ("", ".msg")}
    for name, module in (absent | modules).items():
        monkeypatch.setitem(sys.modules, name, module)


def spun(monkeypatch, engine, wanted: int, leave_out=(), parameters=None):
    """The node, after its timer published on as many topics."""
    nodes = []

    def spin(node):
        ((_, step),) = node.timers

        def enough() -> bool:
            engine.cycle(BOTH)
            step()
            return len({topic for topic, _ in node.sent}) >= wanted

        wait_for(enough)
        raise KeyboardInterrupt

    modules = message_modules(leave_out) | rclpy_modules(nodes, spin, parameters)
    put_in(monkeypatch, modules)
    ros_node.main(["node", engine.ring.name])
    (node,) = nodes
    return node


def test_it_publishes_all(monkeypatch, engine):
    node = spun(monkeypatch, engine, 9)
    assert node.name == "skinfield_" + engine.ring.name.replace("-", "_")
    assert node.gone
    ((seconds, _),) = node.timers
    assert seconds == pytest.approx(0.01)
    assert node.made["/tf"] == ("TFMessage", 100)
    assert node.made["/skin/contacts"] == ("ContactArray", 10)
    sent = dict(node.sent)
    assert set(sent) == set(node.made)
    assert [each.id for each in sent["/skin/contacts"].contacts] == [7, 9]
    assert sent["/skin/left_palm/contact_wrench"].wrench.force.z == -2.0
    assert sent["/skin/left_palm/contact_wrench"].header.frame_id == "left_palm_contact_7"
    assert sent["/tf"].transforms[0].child_frame_id == "left_palm_contact_7"
    assert sent["/skin/left_palm/taxels"].width == 6
    assert len(sent["/skin/left_palm/taxels"].data) == 96
    assert sent["/diagnostics"].status[0].level == b"\0"
    assert sent["/diagnostics"].status[0].message == "running"


def test_without_skinfield_msgs_all_else_is_published(monkeypatch, engine, caplog):
    node = spun(monkeypatch, engine, 8, ("skinfield_msgs",), {"robot": "left"})
    assert set(dict(node.sent)) == set(node.made)
    assert "/left/skin/left_palm/wrench" in node.made
    assert "/left/skin/contacts is not published" in caplog.text


def test_without_ros_it_says_so(monkeypatch, engine):
    put_in(monkeypatch, rclpy_modules([], lambda node: None))
    with pytest.raises(InputError, match="a sourced ROS 2"):
        ros_node.main(["node", engine.ring.name])


def test_importing_it_needs_no_rclpy():
    tree = ast.parse(Path(ros_node.__file__).read_text())
    assert not [node for node in tree.body if "rclpy" in ast.dump(node) and hasattr(node, "names")]
    assert "rclpy" not in sys.modules
