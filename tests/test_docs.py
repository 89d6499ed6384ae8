"""Pages of the interface list every public name, and nothing that is not there."""

import importlib
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import skinfield as sf

API = Path(__file__).resolve().parents[1] / "docs" / "api"
TABLE = re.compile(r"currentmodule:: (\S+)\n(.*?)(?=\n\.\. current|\Z)", re.DOTALL)


def listed() -> dict[str, Any]:
    """What the tables of docs/api name, by full name."""
    found = {}
    for page in API.glob("*.rst"):
        for room, table in TABLE.findall(page.read_text(encoding="utf-8")):
            module = sf.layouts if room == "skinfield.layouts" else importlib.import_module(room)
            for name in re.findall(r"^   (\w+)$", table, re.MULTILINE):
                found[f"{room}.{name}"] = getattr(module, name)  # raises where there is none
    return found


@pytest.mark.parametrize("room", ["skinfield", "skinfield.calibrate", "skinfield.simulate"])
def test_every_public_name_is_documented(room: str) -> None:
    module = importlib.import_module(room)
    known = {id(value) for value in listed().values()}
    for name in dir(module):
        value = getattr(module, name)
        if not name.startswith("_") and not isinstance(value, ModuleType):
            assert id(value) in known, f"docs/api lists no {room}.{name}: add it where users look"
