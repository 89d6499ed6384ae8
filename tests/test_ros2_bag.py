"""Bags of ROS 2 made of recordings, read back by rosbags."""

import numpy as np
import pytest
from command_line import refused, run
from recorder_ring import recorder_of
from ros2_ring import MOVE, TURN, TwoPatches, contact, two_patches
from rosbags.highlevel import AnyReader

from skinfield.errors import FileError, SkinfieldError
from skinfield.files.ros import BagExport

CYCLES = 12
TAXELS = "sensor_msgs/msg/PointCloud2"
WRENCH = "geometry_msgs/msg/WrenchStamped"
OF_PATCH = {"counts": TAXELS, "taxels": TAXELS, "wrench": WRENCH}
KINDS = {
    f"/skin/{patch}/{what}": kind
    for patch in ("left_palm", "patch_2nd_finger")
    for what, kind in OF_PATCH.items()
} | {
    "/skin/left_palm/contact_wrench": WRENCH,
    "/skin/contacts": "skinfield_msgs/msg/ContactArray",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/rosout": "rcl_interfaces/msg/Log",
}


def counts_of(cycle: int):
    return np.arange(10) + 100 * cycle


def touch_of(cycle: int):
    """On the palm, from the third cycle on."""
    return [contact(0, 7, 0.5 * cycle, (0.01, 1e-3 * cycle, 0.0))] if cycle >= 2 else []


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("bag") / "a.mcap"
    with TwoPatches() as engine:
        recorder = recorder_of(engine, path, view_rate=1000.0)
        for cycle in range(CYCLES):
            engine.cycle(touch_of(cycle), counts=counts_of(cycle))
            recorder.step()
        recorder.close()
    return path


@pytest.fixture(scope="module")
def bags(recorded):
    found = [recorded.with_name(form) for form in ("rosbag2", "rosbag2-sqlite")]
    for bag in found:
        run("export", recorded, "--format", bag.name, "-o", bag)
    return found


def rows(bag):
    with AnyReader([bag]) as reader:  # with the types that the bag encloses
        return [
            (each.topic, stamp, bytes(data), reader.deserialize(data, each.msgtype))
            for each, stamp, data in reader.messages()
        ]


def test_both_kinds_hold_the_same(bags):
    first, second = (sorted(rows(bag), key=lambda row: row[:3]) for bag in bags)
    assert [row[:3] for row in first] == [row[:3] for row in second]
    for bag, ending in zip(bags, (".mcap", ".db3"), strict=True):
        assert {path.suffix for path in bag.iterdir()} == {".yaml", ending}
    with AnyReader([bags[0]]) as reader:
        assert {each.topic: each.msgtype for each in reader.connections} == KINDS
        for each in reader.connections:
            assert each.digest == reader.typestore.hash_rihs01(each.msgtype)
            assert each.digest.startswith("RIHS01_")


def test_what_it_says(bags):
    """Counts of each scan, contacts of each cycle, the force, where the contact's frame is."""
    of = {}
    for topic, stamp, _, message in rows(bags[0]):
        of.setdefault(topic, []).append((stamp, message))
    clouds = [np.frombuffer(m.data.tobytes(), "<f4").reshape(-1, 4)
              for _, m in of["/skin/left_palm/counts"]]  # fmt: skip
    np.testing.assert_array_equal([c[:, 3] for c in clouds], [counts_of(c)[:6] for c in range(12)])
    assert [f.name for f in of["/skin/left_palm/counts"][0][1].fields] == ["x", "y", "z", "counts"]
    arrays = of["/skin/contacts"]
    assert [len(m.contacts) for _, m in arrays] == 2 * [0] + 10 * [1]
    forces = [m.contacts[0].normal_force for _, m in arrays[2:]]
    assert forces == [0.5 * cycle for cycle in range(2, CYCLES)]
    total = [m.wrench.force.z for _, m in of["/skin/left_palm/wrench"]]
    np.testing.assert_allclose(total, [0.0, 0.0, *(-force for force in forces)])
    for cycle, (stamp, message) in enumerate(of["/tf"], 2):
        (move,) = message.transforms
        where = TURN @ [0.01, 1e-3 * cycle, 0.0] + MOVE
        place = move.transform.translation
        np.testing.assert_allclose([place.x, place.y, place.z], where)
        assert stamp == move.header.stamp.sec * 10**9 + move.header.stamp.nanosec
    assert len(of["/skin/left_palm/taxels"]) >= 2
    assert [m.name for _, m in of["/rosout"]] == [
            "recording_started", "settings", "recording_ended"
        ]  # fmt: skip


def test_it_says_that_forces_are_relative(bags):
    for bag in bags:
        assert "skinfield_forces: relative" in (bag / "metadata.yaml").read_text()


def test_one_patch(recorded):
    bag = recorded.with_name("one")
    run("export", recorded, "--format", "rosbag2", "-o", bag, "--patch", "2nd-finger")
    found = rows(bag)
    topics = {topic for topic, *_ in found}
    its = {f"/skin/patch_2nd_finger/{what}" for what in OF_PATCH}
    assert topics == its | {"/skin/contacts", "/rosout"}
    assert not any(m.contacts for topic, *_, m in found if topic == "/skin/contacts")


def test_nothing_is_left_of_half_a_bag(bags, recorded, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    words = ("export", recorded, "--format", "rosbag2", "-o")
    assert "expected" in refused(*words, bags[0])  # a name that is taken
    assert rows(bags[0])
    monkeypatch.setattr("rosbags.rosbag2.Writer.write", full)
    assert "No space left" in refused(*words, tmp_path / "bag")
    assert list(tmp_path.iterdir()) == []


def test_where_no_bag_can_be(tmp_path, recorded):
    patches = two_patches()
    with pytest.raises(FileError, match="no folder"):
        BagExport(tmp_path / "no" / "bag", patches)
    with pytest.raises(SkinfieldError, match="prefix is"):
        BagExport(tmp_path / "bag", patches, prefix="skin")
    assert list(tmp_path.iterdir()) == []
