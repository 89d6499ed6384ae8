"""Orders of the page, checked: they come over a socket."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from skinfield.errors import InputError
from skinfield.viewer.desk import Press
from skinfield.viewer.stage import Stage

LONGEST = 200  # characters
FAR = 1e3  # m
Given = Mapping[str, Any]


def text(given: Given, key: str) -> str:
    """A text of an order; raises InputError."""
    value = given.get(key)
    if not isinstance(value, str) or not 0 < len(value) <= LONGEST:
        raise InputError(f"{key} is {value!r:.80}, expected text")
    return value


def flag(given: Given, key: str) -> bool:
    """Yes or no; raises InputError."""
    value = given.get(key)
    if not isinstance(value, bool):
        raise InputError(f"{key} is {value!r:.80}, expected true or false")
    return value


def number(given: Given, key: str, low: float, high: float, what: str) -> float:
    """A number between two bounds; raises InputError."""
    value = given.get(key)
    good = isinstance(value, int | float) and not isinstance(value, bool)
    if not good or not low <= value <= high:  # type: ignore[operator]
        raise InputError(f"{key} is {value!r:.80}, expected {low:g} to {high:g}: {what}")
    return float(value)  # type: ignore[arg-type]


def press_of(given: Given, stage: Stage, browser: int) -> Press:
    """A press at a place of the picture; raises InputError."""
    standing = stage[given.get("patch")]
    place = given.get("position")
    good = isinstance(place, list) and len(place) == 3
    if not good or not all(_is_place(each) for each in place):  # type: ignore[union-attr]
        raise InputError(f"position is {place!r:.80}, expected three numbers in metres")
    x, y = standing.plane_of(np.array(place, float))
    force = None if "force" not in given else number(given, "force", 0.0, 100.0, "newtons")
    radius = None if "radius" not in given else number(given, "radius", 1e-4, 0.1, "metres")
    shape = text(given, "shape") if "shape" in given else "ball"
    name = f"{browser}-{text(given, 'id')}"[:40]
    return Press(name, standing.patch.name, x, y, force, radius, shape)


def _is_place(value: Any) -> bool:
    real = isinstance(value, int | float) and not isinstance(value, bool)
    return real and math.isfinite(value) and abs(value) < FAR
