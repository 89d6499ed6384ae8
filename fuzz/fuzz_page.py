"""Requests and commands to the page's port: answered, or refused in words."""

import asyncio
import contextlib
import json
import sys
from pathlib import Path

from websockets.datastructures import Headers
from websockets.http11 import Request

from skinfield.errors import InputError
from skinfield.page.controller import Controller
from skinfield.page.page_state import PageState
from skinfield.page.scene_layout import SceneLayout
from skinfield.page.server import HttpApi
from skinfield.page.session import flag, number, press_of, text
from skinfield.page.settings import PageSettings

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from page_sources import StillSource

LAYOUT = SceneLayout((StillSource(),))
API = HttpApi(PageState(lambda: (), Controller()), PageSettings())
LOOP = asyncio.new_event_loop()
SEEDS = [
    b"GET //[ localhost",
    b"GET /api/status?token=%ff [::1]:8700 http://localhost",
    b"POST /socket localhost",
    b'{"id": "a", "patch": 0, "position": [0.01, 0, 0], "force": 1, "radius": 0.004}',
    b'{"id": "a", "patch": 0, "position": [1e308, -1e308, 1e400], "shape": "ball"}',
    b'{"what": "seek", "value": NaN, "on": true, "do": [[]]}',
]


def one_input(data: bytes) -> None:
    """Take bytes as a request, and as a command."""
    answer_request(data)
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
        lambda: press_of(given, LAYOUT, 1),
    ):
        with contextlib.suppress(InputError):
            check()


def answer_request(data: bytes) -> None:
    """Take bytes as method, address, host and origin of a request; no failure of the server."""
    words = data.decode("latin-1").split(" ")
    method, path, host, origin = (words + [""] * 4)[:4]
    headers = Headers({"Host": host} | ({"Origin": origin} if origin else {}))
    request = Request(path, headers, method)
    response = LOOP.run_until_complete(API.answer(None, request))  # type: ignore[arg-type]
    assert response is None or response.status_code < 500
