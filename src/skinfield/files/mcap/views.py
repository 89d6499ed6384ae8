"""Views of a recording: channels that Foxglove and ROS 2 show without knowing skinfield."""

import json
from base64 import b64encode
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.files.ros.kinds import CLOUD, WRENCH_STAMPED, RosbagKinds
from skinfield.files.ros.messages import SkinMessages
from skinfield.skin import Patch, Skin

FLOAT32 = 7  # of foxglove.PackedElementField
COLUMNS = ("x", "y", "z", "value")
METRES_PER_NEWTON = 0.01  # length of an arrow
LIFETIME = 0.5  # s that an arrow stays when nothing more comes
COLOUR = {"r": 0.85, "g": 0.2, "b": 0.1, "a": 1.0}
NO_TURN = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


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


@dataclass(frozen=True, eq=False)
class PatchView:
    """One patch at one instant, in the frame of its link.

    Attributes
    ----------
    patch : Patch
    values : (L,) array
        What the taxels read, in the quantity's unit.
    valid : (L,) bool array
    positions, forces : (N, 3) arrays, m and N
        Of the contacts.
    areas : (N,) array, m²
    tracks : (N,) array
    """

    patch: Patch
    values: NDArray[np.float32]
    valid: NDArray[np.bool_]
    positions: Floats
    forces: Floats
    areas: Floats
    tracks: NDArray[np.int64]


class Views(Protocol):
    """A kind of readable channels: `RosViews`, `FoxgloveViews`."""

    @property
    def profile(self) -> str:
        """Profile that the file must state for its readers; empty if any will do."""
        ...

    def channels(self) -> Iterable[ViewChannel]:
        """All that will have messages."""
        ...

    def messages(self, time_ns: int, patches: Iterable[PatchView]) -> Iterable[ViewMessage]:
        """What the channels say of one instant."""
        ...


class Places(NamedTuple):
    """Of a patch's taxels in the frame of its link, and that frame's name.

    Attributes
    ----------
    frame : str
    positions : (L, 3) array, m
    """

    frame: str
    positions: Floats


def places_of(skin: Skin) -> dict[str, Places]:
    """Places of all patches, by name."""
    return {
        patch.name: Places(patch.link or patch.name, in_link(patch, patch.positions))
        for patch in skin
    }


def in_link(patch: Patch, positions: Floats) -> Floats:
    """Points (N, 3) of the patch's frame in that of its link."""
    pose = patch.link_from_patch
    return np.asarray(positions @ pose[:3, :3].T + pose[:3, 3])


def turned_to_link(patch: Patch, vectors: Floats) -> Floats:
    """Directions (N, 3) of the patch's frame in that of its link."""
    return np.asarray(vectors @ patch.link_from_patch[:3, :3].T)


def topic_of(patch: str, what: str) -> str:
    """Topic of a patch; letters that ROS does not allow in names become underscores."""
    plain = "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in patch)
    return f"/skin/{plain}/{what}"


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


class FoxgloveViews:
    """For each patch `/skin/<patch>/points` and `/skin/<patch>/contacts`.

    `points` is a `foxglove.PointCloud` with x, y, z in m and `value`, NaN where a taxel is not
    valid; `contacts` a `foxglove.SceneUpdate` with an arrow for each contact, along the force and
    1 cm long for each newton. Both in the frame of the link.

    Parameters
    ----------
    skin : Skin
    """

    profile = ""

    def __init__(self, skin: Skin) -> None:
        self._places = places_of(skin)

    def channels(self) -> Iterator[ViewChannel]:
        """See `Views`."""
        for patch in self._places:
            for what, name, schema in (
                ("points", "foxglove.PointCloud", POINT_CLOUD),
                ("contacts", "foxglove.SceneUpdate", SCENE_UPDATE),
            ):
                text = json.dumps(schema).encode()
                yield ViewChannel(topic_of(patch, what), "json", (name, "jsonschema", text))

    def messages(self, time_ns: int, patches: Iterable[PatchView]) -> Iterator[ViewMessage]:
        """See `Views`."""
        for view in patches:
            for what, message in (
                ("points", self._cloud(time_ns, view)),
                ("contacts", self._scene(time_ns, view)),
            ):
                data = json.dumps(message, separators=(",", ":")).encode()
                yield ViewMessage(topic_of(view.patch.name, what), time_ns, data)

    def _cloud(self, time_ns: int, view: PatchView) -> dict[str, Any]:
        place = self._places[view.patch.name]
        points = np.empty((len(place.positions), len(COLUMNS)), "<f4")
        points[:, :3] = place.positions
        points[:, 3] = np.where(view.valid, view.values, np.nan)
        return {
            "timestamp": _time(time_ns),
            "frame_id": place.frame,
            "pose": {"position": _vector(np.zeros(3)), "orientation": NO_TURN},
            "point_stride": 4 * len(COLUMNS),
            "fields": [
                {"name": name, "offset": 4 * i, "type": FLOAT32} for i, name in enumerate(COLUMNS)
            ],
            "data": b64encode(points.tobytes()).decode(),
        }

    def _scene(self, time_ns: int, view: PatchView) -> dict[str, Any]:
        arrows = [
            _arrow(position, force)
            for position, force in zip(view.positions, view.forces, strict=True)
        ]
        entity = {
            "timestamp": _time(time_ns),
            "frame_id": self._places[view.patch.name].frame,
            "id": view.patch.name,
            "lifetime": {"sec": 0, "nsec": int(LIFETIME * 1e9)},
            "frame_locked": True,
            "metadata": [{"key": "tracks", "value": " ".join(map(str, view.tracks.tolist()))}],
            "arrows": arrows,
            "cubes": [], "spheres": [], "cylinders": [], "lines": [], "triangles": [],
            "texts": [], "models": [],
        }  # fmt: skip
        return {"deletions": [], "entities": [entity]}


def _arrow(position: Floats, force: Floats) -> dict[str, Any]:
    """An arrow that ends where the force acts."""
    length = METRES_PER_NEWTON * float(np.linalg.norm(force))
    start = position - METRES_PER_NEWTON * force
    return {
        "pose": {"position": _vector(start), "orientation": _turn_from_x(force)},
        "shaft_length": 0.7 * length,
        "shaft_diameter": 0.001,
        "head_length": 0.3 * length,
        "head_diameter": 0.002,
        "color": COLOUR,
    }


def _turn_from_x(direction: Floats) -> dict[str, float]:
    """Quaternion that turns the x axis into a direction."""
    length = float(np.linalg.norm(direction))
    x, y, z = direction / length if length > 0 else (1.0, 0.0, 0.0)
    if x < -0.999999:
        return {"x": 0.0, "y": 0.0, "z": 1.0, "w": 0.0}
    half = np.array([1.0 + x, 0.0, -z, y])
    w, qx, qy, qz = (half / np.linalg.norm(half)).tolist()
    return {"x": qx, "y": qy, "z": qz, "w": w}


def _time(time_ns: int) -> dict[str, int]:
    seconds, rest = divmod(time_ns, 10**9)
    return {"sec": seconds, "nsec": rest}


def _vector(values: Floats) -> dict[str, float]:
    x, y, z = values.tolist()
    return {"x": x, "y": y, "z": z}


def _object(title: str, **properties: Any) -> dict[str, Any]:
    return {"title": title, "type": "object", "properties": properties}


def _list(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


NUMBER, WHOLE, TEXT = {"type": "number"}, {"type": "integer"}, {"type": "string"}
VECTOR = _object("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER)
TURN = _object("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
POSE = _object("foxglove.Pose", position=VECTOR, orientation=TURN)
STAMP = _object("time", sec=WHOLE, nsec=WHOLE)
SHAPE = {"type": "object"}
POINT_CLOUD = _object(
    "foxglove.PointCloud",
    timestamp=STAMP,
    frame_id=TEXT,
    pose=POSE,
    point_stride=WHOLE,
    fields=_list(_object("foxglove.PackedElementField", name=TEXT, offset=WHOLE, type=WHOLE)),
    data={"type": "string", "contentEncoding": "base64"},
)
ARROW = _object(
    "foxglove.ArrowPrimitive",
    pose=POSE,
    shaft_length=NUMBER,
    shaft_diameter=NUMBER,
    head_length=NUMBER,
    head_diameter=NUMBER,
    color=_object("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER),
)
ENTITY = _object(
    "foxglove.SceneEntity",
    timestamp=STAMP,
    frame_id=TEXT,
    id=TEXT,
    lifetime=_object("duration", sec=WHOLE, nsec=WHOLE),
    frame_locked={"type": "boolean"},
    metadata=_list(_object("foxglove.KeyValuePair", key=TEXT, value=TEXT)),
    arrows=_list(ARROW),
    **{
        name: _list(SHAPE)
        for name in ("cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")
    },
)
SCENE_UPDATE = _object("foxglove.SceneUpdate", deletions=_list(SHAPE), entities=_list(ENTITY))
