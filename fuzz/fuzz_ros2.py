"""Names of patches in ROS 2, and settings of its bridge: any bytes."""

import json
from contextlib import suppress

from skinfield.bridges.ros2.publisher import RosSettings
from skinfield.errors import InputError
from skinfield.files.ros.names import LONGEST, is_topic, token_of, tokens_of
from skinfield.settings import from_plain

SEEDS = [
    b'{"robot": "arm", "domain": 3, "rates": {"taxels": 5}, "session": {"listen": ["a:1"]}}',
    "left palm/左手/2nd".encode(),
]


def one_input(data: bytes) -> None:
    """Read the bytes as each of them."""
    text = data.decode(errors="replace")
    token = token_of(text)
    assert is_topic(f"/{token}")
    assert len(token) <= LONGEST
    parts = tokens_of(text.split("/"))
    assert len(set(parts)) == len(parts)
    assert all(is_topic(f"/skin/{part}/taxels") for part in parts)
    with suppress(ValueError, RecursionError, InputError):
        plain = json.loads(data)
        if isinstance(plain, dict):
            assert is_topic(from_plain(RosSettings, plain).prefix)
