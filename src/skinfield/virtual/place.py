"""Places on a skin, from names and numbers of a command."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from skinfield.errors import InputError
from skinfield.layout import Patch, Skin

FARTHEST = 10.0  # m: no skin is larger
PLACE_KEYS = ("x", "y", "taxel", "face", "weights")


def patch_index(skin: Skin, key: Any) -> int:
    """Index of a patch from its name or number; 0 for None."""
    if key is None:
        return 0
    if isinstance(key, bool) or not isinstance(key, int | str):
        raise InputError(f"patch is {key!r:.60}, expected its name, or its number from 0")
    patch = skin[key]
    return next(i for i, each in enumerate(skin.patches) if each is patch)


def number(
    given: Mapping[str, Any], key: str, default: float | None, low: float, high: float, why: str
) -> float:
    """Finite number of a command.

    Raises
    ------
    InputError
        If there is none where one is needed, or it is out of range.
    """
    value = given.get(key, default)
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    if not plain or not low <= value <= high:
        raise InputError(
            f"{key} is {value!r:.60}, expected a number from {low:g} to {high:g}: {why}"
        )
    return float(value)


def whole(given: Mapping[str, Any], key: str, count: int, why: str) -> int:
    """Whole number of a command, from 0 to `count` - 1."""
    value = given.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < count:
        raise InputError(
            f"{key} is {value!r}, expected a whole number from 0 to {count - 1}: {why}"
        )
    return value


def place_of(patch: Patch, given: Mapping[str, Any]) -> tuple[float, float]:
    """Point of the patch's plane, m, from `x` and `y`, or `taxel`, or `face` and `weights`.

    Raises
    ------
    InputError
        If none of them is given, or not as it must be.
    """
    if "face" in given:
        corners = patch.plane[patch.triangles[whole(given, "face", len(patch.triangles), "of it")]]
        x, y = _weights(given.get("weights", (1 / 3, 1 / 3, 1 / 3))) @ corners
    elif "taxel" in given:
        x, y = patch.plane[whole(given, "taxel", len(patch), "a row of the patch")]
    else:
        x = number(given, "x", None, -FARTHEST, FARTHEST, "metres in the patch's plane")
        y = number(given, "y", None, -FARTHEST, FARTHEST, "metres in the patch's plane")
    return float(x), float(y)


def _weights(given: Any) -> Any:
    try:
        weights = np.array([float(each) for each in given])
    except (TypeError, ValueError, OverflowError):
        weights = np.zeros(0)
    if weights.shape != (3,) or not (weights >= 0).all() or not 0 < weights.sum() < math.inf:
        raise InputError(f"weights is {given!r:.60}, expected three numbers from 0, of the corners")
    return weights / weights.sum()
