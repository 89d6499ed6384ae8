"""Settings as TOML and as JSON: read, or refused; what is read is written and read again."""

from skinfield.errors import InputError
from skinfield.settings import (
    Settings,
    json_from_value,
    settings_from_toml,
    toml_from_settings,
    value_from_json,
)

SEEDS = [
    b'[skin]\nlayout = "hexagon72"\nthickness_mm = 2.5\n[loop]\nrate_hz = 500\nevents = true\n',
    b'[source]\nhardware = "icub"\nchannel = ["can0"]\noptions = ["shift=1"]\n',
    b'[bridges]\nros2 = true\nros_rate = ["wrench=500"]\n[page]\nport = 0\n',
    json_from_value(Settings()).encode(),
]


def one_input(data: bytes) -> None:
    """Read the bytes as both."""
    try:
        settings = settings_from_toml(data.decode(errors="replace"))
    except InputError:
        pass
    else:
        assert settings_from_toml(toml_from_settings(settings)) == settings
    try:
        settings = value_from_json(Settings, data)
    except InputError:
        pass
    else:
        assert value_from_json(Settings, json_from_value(settings)) == settings
