"""Orders from the page's socket: any text is an order that is checked, or refused in words."""

import contextlib
import json
import sys
from pathlib import Path

from skinfield.errors import InputError
from skinfield.viewer.orders import flag, number, press_of, text
from skinfield.viewer.stage import Stage
from skinfield.viewer.wire import unpacked

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from page_feeds import StillFeed

STAGE = Stage((StillFeed(),))
SEEDS = [
    b'{"id": "a", "patch": 0, "position": [0.01, 0, 0], "force": 1, "radius": 0.004}',
    b'{"id": "a", "patch": 0, "position": [1e308, -1e308, 1e400], "shape": "ball"}',
    b'{"what": "seek", "value": NaN, "on": true, "do": [[]]}',
    b'SKF1\x20\x00\x00\x00{"arrays":[{"type":"u8","at":-1,"length":9e9,"name":""}]}',
]


def one_input(data: bytes) -> None:
    """Take bytes as a message of either side."""
    with contextlib.suppress(ValueError, RecursionError):
        unpacked(data)
    try:
        given = json.loads(data)
    except (ValueError, RecursionError):
        return
    if not isinstance(given, dict):
        return
    for check in (
        lambda: text(given, "id"),
        lambda: flag(given, "on"),
        lambda: number(given, "value", 0.0, 10.0, "seconds"),
        lambda: press_of(given, STAGE, 1),
    ):
        with contextlib.suppress(InputError):
            check()
