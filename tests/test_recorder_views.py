"""Channels for other programs, read by those programs' own packages."""

import base64
import json
import uuid

import numpy as np
import pytest
from mcap.reader import make_reader
from recorder_ring import FakeEngine
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from skinfield.layout import Patch, Skin
from skinfield.live.recorder import Recorder
from skinfield.live.recorder_settings import RecorderSettings
from skinfield.live.recorder_state import forget_state
from skinfield.sinks.mcap import FoxgloveViews, RosViews
from skinfield.sinks.mcap.views import PatchView
from skinfield.sinks.mcap.views_foxglove import _turn_from_x
from skinfield.sources.recordings.mcap_live import LiveRecording
from skinfield.sources.recordings.mcap_steps import Steps

FORCE = np.array([[0.0, 0.0, -2.0], [1.0, 0.0, 0.0]])
PLACE = np.array([[0.1, 0.0, 0.0], [0.0, 0.2, 0.0]])


def view_of(patch: Patch) -> PatchView:
    values = np.arange(len(patch), dtype=np.float32)
    valid = values != 1
    return PatchView(patch, values, valid, PLACE, FORCE, np.ones(2), np.array([7, 8]))


@pytest.fixture(scope="module", params=[(RosViews,), (FoxgloveViews,)], ids=["ros", "foxglove"])
def recorded(request, tmp_path_factory):
    name = f"view{uuid.uuid4().hex[:12]}"
    path = tmp_path_factory.mktemp("views") / "a.mcap"
    engine = FakeEngine(name)
    how = RecorderSettings(name=name, path=path, views=request.param, view_rate=1000.0)
    recorder = Recorder(how)
    for _ in range(30):
        engine.cycle()
        recorder.step()
    recorder.close()
    engine.close()
    forget_state(name)
    return path, engine


@pytest.mark.parametrize("recorded", [(RosViews,)], indirect=True)
def test_rosbags_reads_them(recorded):
    path, engine = recorded
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        kinds = {each.topic: each.msgtype for each in reader.connections}
        assert kinds["/skin/arm/taxels"] == "sensor_msgs/msg/PointCloud2"
        its = [each for each in reader.connections if each.topic == "/skin/arm/taxels"]
        for connection, _, data in reader.messages(connections=its):
            cloud = reader.deserialize(data, connection.msgtype)
            points = cloud.data.view("<f4").reshape(cloud.width, 4)
            np.testing.assert_allclose(points[:, :3], engine.skin[0].positions, atol=1e-7)
            assert cloud.header.frame_id == "arm"
        wrenches = [each for each in reader.connections if each.topic == "/skin/arm/wrench"]
        read = [reader.deserialize(data, c.msgtype) for c, _, data in reader.messages(wrenches)]
        assert len(read) >= 2


@pytest.mark.parametrize("recorded", [(FoxgloveViews,)], indirect=True)
def test_mcap_reads_the_others(recorded):
    path, engine = recorded
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        schemas = {s.name for s, _, _ in reader.iter_messages()}
        assert {"foxglove.PointCloud", "foxglove.SceneUpdate"} <= schemas
        for schema, _, message in reader.iter_messages(topics=["/skin/arm/points"]):
            assert schema.encoding == "jsonschema"
            cloud = json.loads(message.data)
            points = np.frombuffer(base64.b64decode(cloud["data"]), "<f4").reshape(-1, 4)
            np.testing.assert_allclose(points[:, :3], engine.skin[0].positions, atol=1e-7)
            stamp = cloud["timestamp"]["sec"] * 10**9 + cloud["timestamp"]["nsec"]
            assert stamp == message.log_time


def test_the_recording_is_as_without(recorded):
    path, engine = recorded
    found = LiveRecording.open(path)
    assert [step.data for step in Steps(found)] == engine.written


def test_wrench_and_arrows():
    """Two forces on a link that is turned: their sum, their moment, arrows along them."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]], [1.0, 2.0, 3.0]
    patch = Patch(np.eye(3)[:, :2] * 0.01, name="palm 1", link="hand", link_from_patch=pose)
    skin = Skin((patch,))
    store = get_typestore(Stores.ROS2_HUMBLE)
    messages = {m.topic: m for m in RosViews(skin).messages(1_500_000_000, [view_of(patch)])}
    wrench = store.deserialize_cdr(
        messages["/skin/palm_1/wrench"].data, "geometry_msgs/msg/WrenchStamped"
    )
    force, torque = wrench.wrench.force, wrench.wrench.torque
    assert [force.x, force.y, force.z] == [1.0, 0.0, -2.0]
    np.testing.assert_allclose([torque.x, torque.y, torque.z], [0.0, 0.2, -0.2])
    assert (wrench.header.stamp.sec, wrench.header.stamp.nanosec) == (1, 500_000_000)
    assert wrench.header.frame_id == "hand"
    cloud = store.deserialize_cdr(
        messages["/skin/palm_1/taxels"].data, "sensor_msgs/msg/PointCloud2"
    )
    points = cloud.data.view("<f4").reshape(-1, 4)
    np.testing.assert_allclose(points[0, :3], [1.0, 2.01, 3.0])
    assert np.isnan(points[:, 3]).tolist() == [False, True, False]
    assert not cloud.is_dense
    scene = {m.topic: m for m in FoxgloveViews(skin).messages(1, [view_of(patch)])}
    (entity,) = json.loads(scene["/skin/palm_1/contacts"].data)["entities"]
    first, second = entity["arrows"]
    assert first["shaft_length"] + first["head_length"] == pytest.approx(0.02)
    assert first["pose"]["position"] == {"x": 0.1, "y": 0.0, "z": 0.02}
    assert second["pose"]["orientation"] == {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    assert entity["metadata"] == [{"key": "tracks", "value": "7 8"}]


@pytest.mark.parametrize("direction", [*np.eye(3), *-np.eye(3), np.array([1.0, 2.0, -3.0])])
def test_an_arrow_points_along_its_force(direction):
    turn = _turn_from_x(direction)
    w, v = turn["w"], np.array([turn["x"], turn["y"], turn["z"]])
    x = np.array([1.0, 0.0, 0.0])
    turned = x + 2 * np.cross(v, np.cross(v, x) + w * x)
    np.testing.assert_allclose(turned, direction / np.linalg.norm(direction), atol=1e-12)
