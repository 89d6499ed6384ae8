"""Settings of a running engine, in the units of the page."""

import math
from typing import Any

from skinfield.errors import InputError
from skinfield.live.client import Live

MILLI, MICRO = 1e-3, 1e-6
UNITS = {
    "deadline_us": ("deadline", MICRO),
    "smoothing_ms": ("smoothing", MILLI),
    "threshold_N": ("threshold", 1.0),
}
TUNED = ("resolution", "focus", *UNITS)


def tuning_told(live: Live) -> dict[str, Any]:
    """What is in force, what it may be, and in `off` why something cannot be changed."""
    plain = live.limits.as_dict(live.tuning)
    told: dict[str, Any] = {"resolution": plain["resolution"], "off": plain["off"]}
    for name, (setting, unit) in UNITS.items():
        entry = plain[setting]
        low, high = entry["range"]
        told[name] = {
            "value": round(entry["value"] / unit, 6),
            "range": [round(low / unit, 6), round(high / unit, 6)],
        }
    focus = plain["focus"]["value"]
    if focus is not None:
        names = [patch.name for patch in live.skin]
        focus = {**focus, "patch": names.index(focus["patch"])}
    return {**told, "focus": focus}


def tune(live: Live, what: str, value: Any) -> None:
    """Change one of `TUNED`.

    Raises
    ------
    InputError
        For what the engine cannot be.
    """
    changes: dict[str, Any]
    if what in UNITS:
        name, unit = UNITS[what]
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{what} is {value!r:.80}, expected a number")
        changes = {name: _within(live, name, value * unit)}
    elif what in ("resolution", "focus"):
        changes = {what: value}
    else:
        raise InputError(f"what is {what[:40]!r}, expected solver or one of {', '.join(TUNED)}")
    live.tune(**changes)


def _within(live: Live, name: str, value: float) -> float:
    """A value in SI; a limit of the page is the engine's, whose last bit is lost in its unit."""
    for limit in live.limits.as_dict(live.tuning)[name]["range"]:
        if math.isclose(value, limit, rel_tol=1e-6):
            return float(limit)
    return value
