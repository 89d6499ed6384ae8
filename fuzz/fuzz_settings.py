"""Settings as TOML and JSON, orders to an engine, names of ROS 2: read, or refused."""

import json
from contextlib import suppress

import skinfield as sf
from skinfield.bridges.ros2.publisher import RosSettings
from skinfield.cli.settings import Settings, settings_from_toml, toml_from_settings
from skinfield.errors import InputError
from skinfield.files.ros.names import LONGEST, is_topic, token_of, tokens_of
from skinfield.loop.control import order_of
from skinfield.loop.model_config import Configuration
from skinfield.loop.runtime_parameters import Limits, Tuning
from skinfield.settings import from_plain, json_from_value, value_from_json

LIMITS = Limits(rungs=(10, 20), longest=9e-4, patches=("palm", "thumb"))
SEEDS = [
    b'[skin]\nlayout = "hexagon72"\nthickness_mm = 2.5\n[loop]\nrate_hz = 500\nevents = true\n',
    b'[source]\nhardware = "icub"\nchannel = ["can0"]\noptions = ["shift=1"]\n',
    b'[bridges]\nros2 = true\nros_rate = ["wrench=500"]\n[page]\nport = 0\n',
    json_from_value(Settings()).encode(),
    json.dumps(Configuration(1, sf.NonNegative(), Tuning()).as_dict()).encode(),
    b'{"do": "set", "set": {"resolution": 20, "deadline": 3e-4, "threshold": 0.2}}',
    b'{"do": "set", "set": {"focus": {"patch": "palm", "low": [0, 0], "high": [1, 1e-3]}}}',
    b'{"do": "set", "set": {"smoothing": NaN, "resolution": "auto", "focus": null}}',
    b'{"do": ["tare"], "set": {"": 1e999}}',
    b'{"robot": "arm", "domain": 3, "rates": {"taxels": 5}, "session": {"listen": ["a:1"]}}',
    "left palm/左手/2nd".encode(),
]


def one_input(data: bytes) -> None:
    """Read the bytes as each of them; what is read is written and read again."""
    with suppress(InputError):
        settings = settings_from_toml(data.decode(errors="replace"))
        assert settings_from_toml(toml_from_settings(settings)) == settings
    changes = order_of(data)[1].get("set")  # whatever the bytes are
    with suppress(InputError):
        settings = value_from_json(Settings, data)
        assert value_from_json(Settings, json_from_value(settings)) == settings
    with suppress(InputError):
        if isinstance(changes, dict):
            tuning = LIMITS.check(Tuning().changed(changes))
            assert Tuning().changed(json.loads(json.dumps(tuning.as_dict()))) == tuning
    names(data.decode(errors="replace"))
    with suppress(InputError, ValueError, RecursionError):  # refused; no JSON
        plain = json.loads(data)
        if isinstance(plain, dict):
            with suppress(InputError):
                assert is_topic(from_plain(RosSettings, plain).prefix)
        Configuration.from_dict(plain)


def names(text: str) -> None:
    """A text as the name of a patch, and of several, of which topics are made."""
    token, parts = token_of(text), tokens_of(text.split("/"))
    assert is_topic(f"/{token}")
    assert len(token) <= LONGEST
    assert len(set(parts)) == len(parts)
    assert all(is_topic(f"/skin/{part}/taxels") for part in parts)
