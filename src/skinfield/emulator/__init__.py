"""Emulator: boards in software, on a real bus, with bytes as real ones send."""

from typing import Any

from skinfield.emulator.settings import Fault as Fault
from skinfield.emulator.settings import TemperatureSettings as TemperatureSettings
from skinfield.emulator.settings import VirtualSettings as VirtualSettings
from skinfield.emulator.settings import Wires as Wires
from skinfield.emulator.settings import fault_from_text as fault_from_text
from skinfield.emulator.settings import temperature_from_text as temperature_from_text


def __getattr__(name: str) -> Any:
    """Load the virtual skin, and all that simulates, when it is named: help needs none of it."""
    if name != "VirtualSkin":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from skinfield.emulator.skin import VirtualSkin

    return VirtualSkin
