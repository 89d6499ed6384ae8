"""Taxels and forces as messages of ROS 2, in CDR: any reader of ROS 2 bags shows them."""

from collections.abc import Iterable, Iterator

import numpy as np

from skinfield.layout import Skin
from skinfield.sinks.mcap.views import PatchView, ViewChannel, ViewMessage
from skinfield.sinks.ros.kinds import CLOUD, WRENCH_STAMPED, RosbagKinds
from skinfield.sinks.ros.messages import SkinMessages


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
        self._kinds = RosbagKinds()
        self._make = SkinMessages(skin, self._kinds)
        self._place = {patch.name: place for place, patch in enumerate(skin)}

    def channels(self) -> Iterator[ViewChannel]:
        """See `Views`."""
        for place in self._place.values():
            for what, kind in (("taxels", CLOUD), ("wrench", WRENCH_STAMPED)):
                schema = (kind, "ros2msg", self._kinds.text_of(kind).encode())
                yield ViewChannel(self._make.topics.of_patch(place, what), "cdr", schema)

    def messages(self, time_ns: int, patches: Iterable[PatchView]) -> Iterator[ViewMessage]:
        """See `Views`."""
        for view in patches:
            place = self._place[view.patch.name]
            values = np.where(view.valid, view.values, np.nan)
            for out in (
                self._make.taxels(place, time_ns, values),
                self._make.wrench(place, time_ns, view.positions, view.forces),
            ):
                yield ViewMessage(out.topic, time_ns, self._kinds.bytes_of(out.kind, out.message))
