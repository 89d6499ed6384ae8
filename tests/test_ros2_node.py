"""The node for rclpy, with a stand-in for rclpy."""

import ast
import sys
import time
from pathlib import Path

import pytest
from ros2_ring import TwoPatches, contact
from stand_in_rclpy import message_modules, put_in, rclpy_modules

from skinfield.bridges.ros2 import node as ros_node
from skinfield.errors import InputError

TOUCH = [contact(0, 7, 2.0, (0.01, 0.0, 0.0)), contact(1, 9, 1.0, (0.005, 0.005, 0.0))]
PATIENCE = 60.0  # s


@pytest.fixture
def engine():
    with TwoPatches() as made:
        yield made


def spun(monkeypatch, engine, wanted: int, leave_out=(), parameters=None):
    """The node, after its timer published on as many topics."""
    nodes = []

    def spin(node):
        ((_, step),) = node.timers
        end = time.monotonic() + PATIENCE
        while len({topic for topic, _ in node.sent}) < wanted:
            assert time.monotonic() < end
            engine.cycle(TOUCH)
            step()
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
