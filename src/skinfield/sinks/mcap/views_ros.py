"""Taxels and forces as messages of ROS 2, in CDR: any reader of ROS 2 bags shows them."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from skinfield.errors import SkinfieldError
from skinfield.layout import Skin
from skinfield.sinks.mcap.views import PatchView, ViewChannel, ViewMessage, places_of, topic_of

CLOUD, WRENCH = "sensor_msgs/msg/PointCloud2", "geometry_msgs/msg/WrenchStamped"
FLOAT32 = 7  # sensor_msgs/PointField
FIELDS = ("x", "y", "z", "value")


class RosViews:
    """For each patch `/skin/<patch>/taxels` and `/skin/<patch>/wrench`.

    `taxels` is a `sensor_msgs/PointCloud2` with x, y, z in m and `value`, NaN where a taxel is not
    valid; `wrench` a `geometry_msgs/WrenchStamped`, the sum of the patch's contacts in N, and their
    moment about the origin of the link in N m. Both in the frame of the link.

    Parameters
    ----------
    skin : Skin

    Raises
    ------
    SkinfieldError
        If rosbags is not installed.
    """

    profile = "ros2"

    def __init__(self, skin: Skin) -> None:
        try:
            from rosbags.typesys import Stores, get_typestore
        except ImportError as error:
            raise SkinfieldError(
                "channels of ROS need rosbags, which is not installed: "
                "pip install 'skinfield[ros]', or leave --ros out"
            ) from error
        self._store = get_typestore(Stores.ROS2_HUMBLE)
        self._places = places_of(skin)
        self._types = self._store.types
        self._fields = [
            self._types["sensor_msgs/msg/PointField"](name, 4 * place, FLOAT32, 1)
            for place, name in enumerate(FIELDS)
        ]

    def channels(self) -> Iterator[ViewChannel]:
        """See `Views`."""
        for patch in self._places:
            for what, kind in (("taxels", CLOUD), ("wrench", WRENCH)):
                text, _ = self._store.generate_msgdef(kind, ros_version=2)
                schema = (kind, "ros2msg", text.encode())
                yield ViewChannel(topic_of(patch, what), "cdr", schema)

    def messages(self, time_ns: int, patches: Iterable[PatchView]) -> Iterator[ViewMessage]:
        """See `Views`."""
        for view in patches:
            name = view.patch.name
            header = self._header(time_ns, name)
            for what, kind, message in (
                ("taxels", CLOUD, self._cloud(header, view)),
                ("wrench", WRENCH, self._wrench(header, view)),
            ):
                data = bytes(self._store.serialize_cdr(message, kind))
                yield ViewMessage(topic_of(name, what), time_ns, data)

    def _header(self, time_ns: int, patch: str) -> Any:
        stamp = self._types["builtin_interfaces/msg/Time"](*divmod(time_ns, 10**9))
        return self._types["std_msgs/msg/Header"](stamp, self._places[patch].frame)

    def _cloud(self, header: Any, view: PatchView) -> Any:
        positions = self._places[view.patch.name].positions
        points = np.empty((len(positions), len(FIELDS)), "<f4")
        points[:, :3] = positions
        points[:, 3] = np.where(view.valid, view.values, np.nan)
        return self._types[CLOUD](
            header=header,
            height=1,
            width=len(points),
            fields=self._fields,
            is_bigendian=False,
            point_step=4 * len(FIELDS),
            row_step=points.nbytes,
            data=np.frombuffer(points.tobytes(), np.uint8),
            is_dense=bool(view.valid.all()),
        )

    def _wrench(self, header: Any, view: PatchView) -> Any:
        force = view.forces.sum(axis=0)
        torque = np.cross(view.positions, view.forces).sum(axis=0)
        vector = self._types["geometry_msgs/msg/Vector3"]
        wrench = self._types["geometry_msgs/msg/Wrench"](
            vector(*force.tolist()), vector(*torque.tolist())
        )
        return self._types[WRENCH](header, wrench)
