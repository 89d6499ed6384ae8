"""Messages of ROS 2 that say what a skin feels.

Forces are those on the skin: a contact's points into it, against the outward normal.
"""

from collections.abc import Collection, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from skinfield.errors import Floats
from skinfield.files.ros import kinds as K
from skinfield.files.ros.kinds import Kinds
from skinfield.files.ros.names import Topics, frame_of
from skinfield.skin import Patch, Skin

FLOAT32 = 7  # of sensor_msgs/PointField
PLACE = ("x", "y", "z")


class Outgoing(NamedTuple):
    """A message, its topic and kind, and the time of what it says."""

    topic: str
    kind: str
    stamp_ns: int
    message: Any


class Placed(NamedTuple):
    """A row of contacts in the frame of its link."""

    patch: int
    row: Any
    position: Floats
    normal: Floats
    fitted: bool


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

    def placed(self, contacts: NDArray[Any], fitted: Sequence[bool] = ()) -> list[Placed]:
        """Contacts in the frames of their links; rows with `patch`, `position`, `normal` ..."""
        found = []
        for row, by_fit in zip(contacts, fitted or [False] * len(contacts), strict=True):
            place = int(row["patch"])
            pose = self._poses[place]
            position = pose[:3, :3] @ row["position"] + pose[:3, 3]
            found.append(Placed(place, row, position, pose[:3, :3] @ row["normal"], bool(by_fit)))
        return found

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

    def net_wrench(self, place: int, stamp_ns: int, contacts: Sequence[Placed]) -> Outgoing:
        """Sum of the forces of a patch's contacts, and their moment about the link's origin."""
        force, torque = np.zeros(3), np.zeros(3)
        for each in contacts:
            if each.patch == place:
                its = -each.row["normal_force"] * each.normal
                force += its
                torque += np.cross(each.position, its)
        message = self._wrench_stamped(stamp_ns, self._frames[place], force, torque)
        topic = self.topics.of_patch(place, "wrench")
        return Outgoing(topic, K.WRENCH_STAMPED, stamp_ns, message)

    def contact_wrench(self, stamp_ns: int, contact: Placed) -> Outgoing:
        """Force of one contact in its own frame, whose z is out of the skin."""
        frame = self.topics.contact_frame(contact.patch, int(contact.row["track"]))
        force = np.array([0.0, 0.0, -float(contact.row["normal_force"])])
        message = self._wrench_stamped(stamp_ns, frame, force, np.zeros(3))
        topic = self.topics.of_patch(contact.patch, "contact_wrench")
        return Outgoing(topic, K.WRENCH_STAMPED, stamp_ns, message)

    def frames(self, stamps_ns: Sequence[int], contacts: Sequence[Placed]) -> Outgoing:
        """Frames of contacts in those of their links; stamps of all patches."""
        moves = [self._move(stamps_ns[each.patch], each) for each in contacts]
        message = self.kinds.make(K.FRAMES, transforms=moves)
        return Outgoing(self.topics.frames, K.FRAMES, max(stamps_ns, default=0), message)

    def contacts(self, stamps_ns: Sequence[int], contacts: Sequence[Placed]) -> Outgoing:
        """All contacts; stamps of all patches."""
        newest = max(stamps_ns, default=0)
        message = self.kinds.make(
            K.CONTACTS,
            header=self.header(newest, ""),
            contacts=[self._contact(stamps_ns[each.patch], each) for each in contacts],
        )
        return Outgoing(self.topics.contacts, K.CONTACTS, newest, message)

    def _contact(self, stamp_ns: int, contact: Placed) -> Any:
        row, force = contact.row, -contact.row["normal_force"] * contact.normal
        track = int(row["track"])
        return self.kinds.make(
            K.CONTACT,
            header=self.header(stamp_ns, self._frames[contact.patch]),
            id=track,
            patch=self.skin[contact.patch].name,
            contact_frame=self.topics.contact_frame(contact.patch, track),
            position=self._of(K.POINT, contact.position),
            normal=self._of(K.VECTOR, contact.normal),
            wrench=self._wrench(force, np.zeros(3)),
            normal_force=float(row["normal_force"]),
            force_std=float(row["force_std"]),
            position_std=float(row["place_std"]),
            area=float(row["area"]),
            peak_pressure=float(row["peak_pressure"]),
            age=float(row["age"]),
            speed=float(row["speed"]),
            fitted=contact.fitted,
        )

    def _move(self, stamp_ns: int, contact: Placed) -> Any:
        x, y, z, w = quaternion(axes_at(contact.normal, self._sides[contact.patch]))
        return self.kinds.make(
            K.MOVE_STAMPED,
            header=self.header(stamp_ns, self._frames[contact.patch]),
            child_frame_id=self.topics.contact_frame(contact.patch, int(contact.row["track"])),
            transform=self.kinds.make(
                K.MOVE,
                translation=self._of(K.VECTOR, contact.position),
                rotation=self.kinds.make(K.TURN, x=x, y=y, z=z, w=w),
            ),
        )

    def _wrench_stamped(self, stamp_ns: int, frame: str, force: Floats, torque: Floats) -> Any:
        return self.kinds.make(
            K.WRENCH_STAMPED,
            header=self.header(stamp_ns, frame),
            wrench=self._wrench(force, torque),
        )

    def _wrench(self, force: Floats, torque: Floats) -> Any:
        return self.kinds.make(
            K.WRENCH, force=self._of(K.VECTOR, force), torque=self._of(K.VECTOR, torque)
        )

    def _of(self, kind: str, values: Floats) -> Any:
        plain = (values + 0.0).tolist()  # -0.0 is 0.0
        return self.kinds.make(kind, **dict(zip(PLACE, plain, strict=True)))


WHATS = ("contacts", "frames", "contact_wrench", "wrench")  # said of the contacts of one cycle


def of_contacts(
    make: SkinMessages,
    stamps_ns: Sequence[int],
    contacts: NDArray[Any],
    fresh: Sequence[bool],
    wanted: Collection[str] = WHATS,
    fitted: Sequence[bool] = (),
) -> Iterator[Outgoing]:
    """What is said of the contacts of one cycle.

    Parameters
    ----------
    make : SkinMessages
    stamps_ns : sequence of int, ns
        Of each patch's newest reading.
    contacts : structured (N,) array
    fresh : sequence of bool
        Whether each patch was read since the last time: nothing is said twice of a reading, but
        for `contacts`, which holds those of all patches.
    wanted : collection of str
        Of `WHATS`.
    fitted : sequence of bool
        Whether each contact is of the contact fit; default none.
    """
    placed = make.placed(contacts, fitted)
    if "contacts" in wanted and any(fresh):
        yield make.contacts(stamps_ns, placed)
    news = [each for each in placed if fresh[each.patch]]
    if "frames" in wanted and news:
        yield make.frames(stamps_ns, news)
    if "contact_wrench" in wanted:
        for each in news:
            yield make.contact_wrench(stamps_ns[each.patch], each)
    if "wrench" in wanted:
        for place in np.flatnonzero(fresh).tolist():
            yield make.net_wrench(place, stamps_ns[place], news)


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
