"""Taxels and contacts as Foxglove's own messages, in JSON: its 3D panel draws them."""

import json
from base64 import b64encode
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.layout import Skin
from skinfield.sinks.mcap.views import PatchView, ViewChannel, ViewMessage, places_of, topic_of

FLOAT32 = 7  # of foxglove.PackedElementField
FIELDS = ("x", "y", "z", "value")
METRES_PER_NEWTON = 0.01  # length of an arrow
KEPT_S = 0.5  # s that an arrow stays when nothing more comes
COLOUR = {"r": 0.85, "g": 0.2, "b": 0.1, "a": 1.0}
NO_TURN = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


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
        points = np.empty((len(place.positions), len(FIELDS)), "<f4")
        points[:, :3] = place.positions
        points[:, 3] = np.where(view.valid, view.values, np.nan)
        return {
            "timestamp": _time(time_ns),
            "frame_id": place.frame,
            "pose": {"position": _vector(np.zeros(3)), "orientation": NO_TURN},
            "point_stride": 4 * len(FIELDS),
            "fields": [
                {"name": name, "offset": 4 * i, "type": FLOAT32} for i, name in enumerate(FIELDS)
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
            "lifetime": {"sec": 0, "nsec": int(KEPT_S * 1e9)},
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
