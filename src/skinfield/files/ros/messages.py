"""Messages of ROS 2 that say what a skin feels.

Forces are those on the skin: a contact's points into it, against the outward normal.
"""

from collections.abc import Collection, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from skinfield.errors import Floats
from skinfield.estimate.row_contacts import force_of, shape_name
from skinfield.estimate.wrench import moments_about_origin
from skinfield.files.ros import kinds as K
from skinfield.files.ros.kinds import Kinds
from skinfield.files.ros.names import Topics, frame_of
from skinfield.skin import Patch, Skin

FLOAT32 = 7  # of sensor_msgs/PointField
PLACE = ("x", "y", "z")
WHATS = ("contacts", "frames", "contact_wrench", "wrench")  # said of the contacts of one cycle


class Outgoing(NamedTuple):
    """A message, its topic and kind, and the time of what it says."""

    topic: str
    kind: str
    stamp_ns: int
    message: Any


class Placed(NamedTuple):
    """A row of contacts, place and force in the frame of its link, and the time it was read."""

    patch: int
    stamp_ns: int
    row: Any
    position: Floats
    normal: Floats
    force: Floats


class SkinMessages:
    """Makes the messages of one skin.

    Parameters
    ----------
    skin : Skin
    kinds : Kinds
        Classes of the messages.
    topics : Topics, optional
        Default those of the skin below `/skin`.
    """

    def __init__(self, skin: Skin, kinds: Kinds, topics: Topics | None = None) -> None:
        self.skin, self.kinds = skin, kinds
        self.topics = Topics.of(skin) if topics is None else topics
        self._frames = [frame_of(patch) for patch in skin]
        self._poses = [patch.link_from_patch for patch in skin]
        self._clouds = [_cloud_of(patch) for patch in skin]
        self._sides = [_side_of(patch) for patch in skin]

    def header(self, stamp_ns: int, frame: str) -> Any:
        """Header of a message."""
        seconds, rest = divmod(stamp_ns, 10**9)
        stamp = self.kinds.make(K.TIME, sec=seconds, nanosec=rest)
        return self.kinds.make(K.HEADER, stamp=stamp, frame_id=frame)

    def taxels(
        self, place: int, stamp_ns: int, values: NDArray[Any], what: str = "taxels"
    ) -> Outgoing:
        """Places of a patch's taxels (m) and what they read; NaN where that is not valid.

        Parameters
        ----------
        place : int
            Of the patch.
        stamp_ns : int, ns
        values : (L,) array
        what : str
            End of the topic; the fourth field is `value` for "taxels", else named as this.
        """
        points = self._clouds[place]
        points[:, 3] = values
        fourth = "value" if what == "taxels" else what
        fields = [
            self.kinds.make(K.FIELD, name=name, offset=4 * at, datatype=FLOAT32, count=1)
            for at, name in enumerate((*PLACE, fourth))
        ]
        message = self.kinds.make(
            K.CLOUD,
            header=self.header(stamp_ns, self._frames[place]),
            height=1,
            width=len(points),
            fields=fields,
            is_bigendian=False,
            point_step=16,
            row_step=points.nbytes,
            data=self.kinds.octets(points.tobytes()),
            is_dense=not bool(np.isnan(points[:, 3]).any()),
        )
        return Outgoing(self.topics.of_patch(place, what), K.CLOUD, stamp_ns, message)

    def of_contacts(
        self,
        stamps_ns: Sequence[int],
        contacts: NDArray[Any],
        fresh: Sequence[bool],
        wanted: Collection[str] = WHATS,
    ) -> Iterator[Outgoing]:
        """What is said of the contacts of one cycle.

        Parameters
        ----------
        stamps_ns : sequence of int, ns
            Of each patch's newest reading.
        contacts : structured (N,) array
            With `patch`, `position`, `normal` and so on.
        fresh : sequence of bool
            Whether each patch was read since the last time: nothing is said twice of a reading, but
            for `contacts`, which holds those of all patches.
        wanted : collection of str
            Of `WHATS`.
        """
        placed, newest = [], max(stamps_ns, default=0)
        for row in contacts:
            patch = int(row["patch"])
            pose = self._poses[patch]
            position = pose[:3, :3] @ row["position"] + pose[:3, 3]
            normal, force = pose[:3, :3] @ row["normal"], pose[:3, :3] @ force_of(row)
            placed.append(Placed(patch, stamps_ns[patch], row, position, normal, force))
        news = [each for each in placed if fresh[each.patch]]
        if "contacts" in wanted and any(fresh):
            message = self.kinds.make(
                K.CONTACTS,
                header=self.header(newest, ""),
                contacts=[self._contact(each) for each in placed],
            )
            yield Outgoing(self.topics.contacts, K.CONTACTS, newest, message)
        if "frames" in wanted and news:
            message = self.kinds.make(K.FRAMES, transforms=[self._move(each) for each in news])
            yield Outgoing(self.topics.frames, K.FRAMES, newest, message)
        if "contact_wrench" in wanted:  # in the contact's own frame, whose z is out of the skin
            for each in news:
                frame = self.topics.contact_frame(each.patch, int(each.row["track"]))
                force = each.force @ axes_at(each.normal, self._sides[each.patch])
                stamped = each.patch, each.stamp_ns, frame
                yield self._wrench_stamped("contact_wrench", *stamped, force, np.zeros(3))
        if "wrench" in wanted:  # the sum of a patch's, with the moment about the link's origin
            for place in np.flatnonzero(fresh).tolist():
                its = [each for each in news if each.patch == place]
                places = [each.position for each in its]
                wrench = moments_about_origin(places, [each.force for each in its])
                stamped = place, stamps_ns[place], self._frames[place]
                yield self._wrench_stamped("wrench", *stamped, wrench[:3], wrench[3:])

    def _contact(self, contact: Placed) -> Any:
        row, track = contact.row, int(contact.row["track"])
        same = ("normal_force", "force_std", "area", "radius", "peak_pressure", "age", "speed")
        return self.kinds.make(
            K.CONTACT,
            header=self.header(contact.stamp_ns, self._frames[contact.patch]),
            id=track,
            patch=self.skin[contact.patch].name,
            contact_frame=self.topics.contact_frame(contact.patch, track),
            position=self._of(K.POINT, contact.position),
            normal=self._of(K.VECTOR, contact.normal),
            wrench=self._wrench(contact.force, np.zeros(3)),
            position_std=float(row["place_std"]),
            shape=shape_name(row),
            maybe=bool(row["maybe"] > 1),
            **{name: float(row[name]) for name in same},
        )

    def _move(self, contact: Placed) -> Any:
        x, y, z, w = quaternion(axes_at(contact.normal, self._sides[contact.patch]))
        return self.kinds.make(
            K.MOVE_STAMPED,
            header=self.header(contact.stamp_ns, self._frames[contact.patch]),
            child_frame_id=self.topics.contact_frame(contact.patch, int(contact.row["track"])),
            transform=self.kinds.make(
                K.MOVE,
                translation=self._of(K.VECTOR, contact.position),
                rotation=self.kinds.make(K.TURN, x=x, y=y, z=z, w=w),
            ),
        )

    def _wrench_stamped(
        self, what: str, place: int, stamp_ns: int, frame: str, force: Floats, torque: Floats
    ) -> Outgoing:
        header, wrench = self.header(stamp_ns, frame), self._wrench(force, torque)
        message = self.kinds.make(K.WRENCH_STAMPED, header=header, wrench=wrench)
        return Outgoing(self.topics.of_patch(place, what), K.WRENCH_STAMPED, stamp_ns, message)

    def _wrench(self, force: Floats, torque: Floats) -> Any:
        return self.kinds.make(
            K.WRENCH, force=self._of(K.VECTOR, force), torque=self._of(K.VECTOR, torque)
        )

    def _of(self, kind: str, values: Floats) -> Any:
        plain = (values + 0.0).tolist()  # -0.0 is 0.0
        return self.kinds.make(kind, **dict(zip(PLACE, plain, strict=True)))


def _cloud_of(patch: Patch) -> NDArray[np.float32]:
    pose = patch.link_from_patch
    points = np.zeros((len(patch), 4), "<f4")
    points[:, :3] = patch.positions @ pose[:3, :3].T + pose[:3, 3]
    return points


def _side_of(patch: Patch) -> Floats:
    """The link's axis that lies most along the patch: x of its contacts' frames leans on it."""
    normals = patch.normals @ patch.link_from_patch[:3, :3].T
    return np.asarray(np.eye(3)[np.argmin(np.abs(normals).mean(axis=0))])


def axes_at(normal: Floats, side: Floats) -> Floats:
    """Right-handed axes as columns: z along the normal, x as near as can be to `side`."""
    x = side - (side @ normal) * normal
    if x @ x < 1e-6:  # the normal is along it: another axis
        other = np.roll(side, 1)
        x = other - (other @ normal) * normal
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(normal, x), normal], axis=1)


def quaternion(axes: Floats) -> tuple[float, float, float, float]:
    """Unit quaternion x, y, z, w of a rotation matrix, w not below 0."""
    x, y, z, w = Rotation.from_matrix(axes).as_quat(canonical=True).tolist()
    return x, y, z, w
