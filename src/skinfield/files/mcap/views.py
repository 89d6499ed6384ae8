"""ROS 2 channels of a recording: taxels and forces that other programs show without skinfield."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.files.ros.kinds import CLOUD, WRENCH_STAMPED, RosbagKinds
from skinfield.files.ros.messages import SkinMessages
from skinfield.skin import Skin


class ViewChannel(NamedTuple):
    """A channel to be made: topic, message encoding, and schema (name, encoding, text)."""

    topic: str
    encoding: str
    schema: tuple[str, str, bytes]


class ViewMessage(NamedTuple):
    """A message of the channel `topic`."""

    topic: str
    time_ns: int
    data: bytes


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

    profile = "ros2"  # of the file, for readers of bags

    def __init__(self, skin: Skin) -> None:
        self._kinds = RosbagKinds()
        self._make = SkinMessages(skin, self._kinds)
        self._ends = np.cumsum([len(patch) for patch in skin])

    def channels(self) -> Iterator[ViewChannel]:
        """All that will have messages."""
        for place in range(len(self._ends)):
            for what, kind in (("taxels", CLOUD), ("wrench", WRENCH_STAMPED)):
                schema = (kind, "ros2msg", self._kinds.text_of(kind).encode())
                yield ViewChannel(self._make.topics.of_patch(place, what), "cdr", schema)

    def messages(
        self,
        time_ns: int,
        values: NDArray[np.float32],
        valid: NDArray[np.uint8],
        contacts: NDArray[np.void],
    ) -> Iterator[ViewMessage]:
        """What the channels say of one cycle.

        Parameters
        ----------
        time_ns : int, ns
        values, valid : (L,) arrays
            Of all taxels, in the quantity's unit.
        contacts : structured (N,) array
            With `patch`, `position`, `normal` and `normal_force` in the frames of the patches.
        """
        placed = self._make.placed(contacts)
        shown = np.split(np.where(valid > 0, values, np.nan), self._ends[:-1])
        for place, its in enumerate(shown):
            for out in (
                self._make.taxels(place, time_ns, its),
                self._make.net_wrench(place, time_ns, placed),
            ):
                yield ViewMessage(out.topic, time_ns, self._kinds.bytes_of(out.kind, out.message))
