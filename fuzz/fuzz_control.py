"""The virtual skin's control socket: any datagram gets an answer, and the skin goes on."""

import json
from typing import Any

from skinfield.emulator import VirtualSettings, VirtualSkin
from skinfield.emulator.transports import answer_to, encoded

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
]
SKIN = VirtualSkin(VirtualSettings(bus="udp", scene="idle", control="", at_once=True))
COMMANDS = SKIN.commands()
STEP_NS = 50_000_000


def nothing(*_: Any) -> None:
    """In place of solving a table in another process."""


SKIN.world._solving._solve = nothing  # type: ignore[method-assign]
NOW = [SKIN.started_ns]


def one_input(data: bytes) -> None:
    """Answer a datagram, let time go on, and see that the answer can be sent."""
    answer = answer_to(data, COMMANDS)
    said = json.loads(encoded(answer))
    assert said["ok"] in (True, False)
    assert said["ok"] or said["error"]
    NOW[0] += STEP_NS
    SKIN.step(NOW[0])
    assert abs(SKIN.hardware.converters.counts).max() < 1 << 16
    SKIN.world.release({})
