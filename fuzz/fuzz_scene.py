"""Scenes and faults from texts: any bytes are one, or an error in words."""

import math

from skinfield.emulator import fault_from_text, temperature_from_text
from skinfield.emulator.scenes import scene_from_bytes
from skinfield.errors import FileError, InputError
from skinfield.skin import Skin
from skinfield.skin.generators import by_name

SKIN = Skin((by_name("icub_triangle"),))
SEEDS = [
    b"repeat_s = 5\n[[press]]\ntaxel = 5\nforce_n = 0.5\nstart_s = 1\nseconds = 2\nramp_s = 0.1\n",
    b'[[press]]\nshape = "flat"\nradius_mm = 3\nx_mm = 1\npath = [{time_s = 0, y_mm = 2}]\n',
    b'{"press": [{"face": 1, "weights": [1, 0, 1], "path": [{"time_s": 0}, {"time_s": 1}]}]}',
    b"unplug 1.3@10s+5s",
    b"stuck palm/3-7@2min",
    b"25..35@600s",
    b"25~3@300s",
]


def one_input(data: bytes) -> None:
    """The bytes as a scene of both kinds, as a fault, and as a temperature."""
    for name in ("scene.toml", "scene.json"):
        try:
            scene = scene_from_bytes(data, name, SKIN)
        except FileError:
            continue
        for track in scene.tracks:
            for point in track.points:
                assert math.isfinite(point.x + point.y + point.force + point.time)
            track.at(1.0)
    text = data.decode("utf-8", "replace")
    for read in (fault_from_text, temperature_from_text):
        try:
            read(text)
        except InputError:
            continue
