"""Classes of ROS 2 messages: those of rosbags here, those of rclpy where ROS runs."""

from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from skinfield.errors import SkinfieldError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

CLOUD = "sensor_msgs/msg/PointCloud2"
FIELD = "sensor_msgs/msg/PointField"
WRENCH_STAMPED = "geometry_msgs/msg/WrenchStamped"
WRENCH = "geometry_msgs/msg/Wrench"
VECTOR = "geometry_msgs/msg/Vector3"
POINT = "geometry_msgs/msg/Point"
TURN = "geometry_msgs/msg/Quaternion"
MOVE = "geometry_msgs/msg/Transform"
MOVE_STAMPED = "geometry_msgs/msg/TransformStamped"
FRAMES = "tf2_msgs/msg/TFMessage"
HEADER = "std_msgs/msg/Header"
TIME = "builtin_interfaces/msg/Time"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
DIAGNOSTIC = "diagnostic_msgs/msg/DiagnosticStatus"
KEY_VALUE = "diagnostic_msgs/msg/KeyValue"
CONTACT = "skinfield_msgs/msg/Contact"
CONTACTS = "skinfield_msgs/msg/ContactArray"
OWN = (CONTACT, CONTACTS)


class Kinds(Protocol):
    """Makes messages: `RosbagKinds`, and `RclpyKinds` within a node of ROS."""

    def make(self, kind: str, **fields: Any) -> Any:
        """A message of a kind such as `std_msgs/msg/Header`, with all of its fields."""
        ...

    def octets(self, data: bytes) -> Any:
        """Value of a field `uint8[]`."""
        ...

    def octet(self, value: int) -> Any:
        """Value of a field `byte`."""
        ...


def interface_package() -> Traversable:
    """Folder of the ROS 2 package `skinfield_msgs`, ready for colcon."""
    return files("skinfield.files.ros") / "skinfield_msgs"


def definition_of(kind: str) -> str:
    """Text of one of `OWN`, as in its .msg file."""
    return (interface_package() / "msg" / f"{kind.rpartition('/')[2]}.msg").read_text()


class RosbagKinds:
    """Messages as rosbags has them, their bytes, definitions and hashes; needs no ROS.

    Raises
    ------
    SkinfieldError
        If rosbags is not installed.
    """

    def __init__(self) -> None:
        try:
            from rosbags.typesys import Stores, get_types_from_msg, get_typestore
        except ImportError as error:
            raise SkinfieldError(
                "messages of ROS need rosbags, which is not installed: "
                "pip install 'skinfield[ros]', or leave ROS out"
            ) from error
        self.store: Typestore = get_typestore(Stores.ROS2_JAZZY)
        self._hashes: dict[str, str] = {}
        for kind in OWN:
            self.store.register(get_types_from_msg(definition_of(kind), kind))

    def make(self, kind: str, **fields: Any) -> Any:
        """See `Kinds`."""
        return self.store.types[kind](**fields)

    def octets(self, data: bytes) -> Any:
        """See `Kinds`."""
        return np.frombuffer(data, np.uint8)

    def octet(self, value: int) -> int:
        """See `Kinds`."""
        return value

    def bytes_of(self, kind: str, message: Any) -> bytes:
        """A message in CDR, little-endian, with the four bytes that say so."""
        return bytes(self.store.serialize_cdr(message, kind))

    def text_of(self, kind: str) -> str:
        """Definition with those of all kinds within, as bags enclose it."""
        return str(self.store.generate_msgdef(kind, ros_version=2)[0])

    def hash_of(self, kind: str) -> str:
        """Hash of the definition by REP 2016: RIHS01_ and 64 digits."""
        if kind not in self._hashes:
            self._hashes[kind] = str(self.store.hash_rihs01(kind))
        return self._hashes[kind]
