"""As much of rclpy as a publishing node needs, with messages that check their fields as its do."""

import logging
import sys
from array import array
from types import ModuleType, SimpleNamespace

from rosbags.interfaces import Nodetype

from skinfield.files.ros import RosbagKinds

NUMBERS = {"float32": float, "float64": float, "bool": bool, "string": str}
PACKAGES = ("builtin_interfaces", "std_msgs", "geometry_msgs", "sensor_msgs", "tf2_msgs",
            "diagnostic_msgs", "skinfield_msgs")  # fmt: skip


def good(node, value, classes) -> bool:
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
    return isinstance(value, list) and all(good(inner, each, classes) for each in value)


def message_class(kind, fields, classes):
    def init(self, **given):
        assert set(given) == {name for name, _ in fields}, kind  # none is forgotten
        for name, node in fields:
            assert good(node, given[name], classes), f"{kind}.{name} = {given[name]!r}"
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


class Node:
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
        nodes.append(Node(name, parameters or {}))
        return nodes[-1]

    module.create_node = create_node
    return found


def put_in(monkeypatch, modules) -> None:
    for package in PACKAGES:
        monkeypatch.setitem(sys.modules, package, modules.get(package))
        monkeypatch.setitem(sys.modules, f"{package}.msg", modules.get(f"{package}.msg"))
    for name in modules:
        monkeypatch.setitem(sys.modules, name, modules[name])
