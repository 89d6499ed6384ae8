"""Virtual skin: any bytes as a datagram of control, a scene, a fault, or what a host sends."""

import json
import math
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from skinfield.emulator import (
    VirtualSettings,
    VirtualSkin,
    fault_from_text,
    temperature_from_text,
)
from skinfield.emulator.scenes import scene_from_text
from skinfield.emulator.transports import Request, answer_to, encoded
from skinfield.errors import FileError, InputError
from skinfield.skin import Skin
from skinfield.skin.generators import by_name

SEEDS = [
    b'{"do": "press", "x": 0.01, "y": 0, "force": 1, "radius": 0.004, "shape": "ball", "id": "a"}',
    b'{"do": "press", "face": 3, "weights": [0.2, 0.3, 0.5], "patch": "hexagon72"}',
    b'{"do": "move", "id": "a", "taxel": 7, "force": 0.5}',
    b'{"do": "release", "id": null, "tag": [1, {"b": "\\ud800"}]}',
    b'{"do": "fault", "fault": "unplug 3@1s+5s"}',
    b'{"do": "fault", "kind": "dead", "what": "3-7", "after": 1e3, "seconds": 5}',
    b'{"do": "wires", "lose": 0.01, "swap": 1e400}',
    b'{"do": "clear", "kind": "dead"}',
    b'{"do": "scene", "scene": "slide"}',
    b'{"do": "truth", "after": 0}',
    b'{"do": "counts", "tag": NaN}',
    b'{"do": "describe"}',
    b"repeat_s = 5\n[[press]]\ntaxel = 5\nforce_n = 0.5\nstart_s = 1\nseconds = 2\nramp_s = 0.1\n",
    b'[[press]]\nshape = "flat"\nradius_mm = 3\nx_mm = 1\npath = [{time_s = 0, y_mm = 2}]\n',
    b'{"press": [{"face": 1, "weights": [1, 0, 1], "path": [{"time_s": 0}, {"time_s": 1}]}]}',
    b"unplug 1.3@10s+5s",
    b"stuck palm/3-7@2min",
    b"25..35@600s",
    b"25~3@300s",
    bytes.fromhex("0102044d0005f0 01020750000f02010022 0102020700"),
    b"\x01\x05\x05\x37\x01\x01\x00\x00" + b"\x01\x05\x04\x3b\x01\x00\x00",
    b"SF\x01\x20\x01\x00\x00\x00" + bytes(18),
]
PLAIN = {"bus": "udp", "scene": "idle", "control": ""}
SKIN = VirtualSkin(VirtualSettings(at_once=True, **PLAIN))
COMMANDS = SKIN.commands()
TRIANGLE = Skin((by_name("icub_triangle"),))
SMALL = PLAIN | {"skin": "icub_triangle"}
HOSTED = [VirtualSkin(VirtualSettings(hardware=name, **SMALL)) for name in ("icub", "cyskin")]
DEVICE = VirtualSkin(VirtualSettings(hardware="packet", channels=("listen",), **SMALL))
STEP_NS = 50_000_000


def nothing(*_: Any) -> None:
    """In place of solving a table in another process."""


SKIN.world._solving._solve = nothing  # type: ignore[method-assign]
NOW = [SKIN.started_ns]


def one_input(data: bytes) -> None:
    """Take the bytes as each of them."""
    control(data)
    texts(data)
    host(data)


def control(data: bytes) -> None:
    """Answer a datagram, let time go on, and see that the answer can be sent."""
    answer = answer_to(data, COMMANDS)
    said = json.loads(encoded(answer))
    assert said["ok"] in (True, False)
    assert said["ok"] or said["error"]
    NOW[0] += STEP_NS
    SKIN.step(NOW[0])
    assert abs(SKIN.hardware.converters.counts).max() < 1 << 16
    SKIN.world.release(Request())


def texts(data: bytes) -> None:
    """A scene of both kinds, a fault, and a temperature."""
    text = data.decode("utf-8", "replace")
    for name in ("scene.toml", "scene.json"):
        with TemporaryDirectory() as folder, suppress(FileError):
            path = Path(folder, name)
            path.write_bytes(data)
            for track in scene_from_text(str(path), TRIANGLE, 0).tracks:
                for point in track.points:
                    assert math.isfinite(point.x + point.y + point.force + point.time)
                track.at(1.0)
    for read in (fault_from_text, temperature_from_text):
        with suppress(InputError):
            read(text)


def host(data: bytes) -> None:
    """Three bytes of identifier and length and then data, on and on; and as one stream."""
    now_ns = 10**18  # it stands still, so that a schedule that was made stays in time
    for skin in HOSTED:
        at = 0
        while at + 3 <= len(data):
            length = min(data[at + 2], 8)
            identifier = data[at] | (data[at + 1] & 7) << 8
            skin.hardware._obey(0, identifier, data[at + 3 : at + 3 + length], 0.0)  # type: ignore[attr-defined]
            at += 3 + length
        skin.hardware.reschedule(now_ns)
        assert skin.hardware.schedule.next_ns > now_ns - 10**9
    devices = DEVICE.hardware
    link = devices._wire  # type: ignore[attr-defined]
    link.receive = lambda: data
    devices.listen(now_ns, 0.0)
    del link.receive
