"""Rows of an update: numbers of a cycle, and contacts."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from skinfield.acquisition.recorded import CycleFlag
from skinfield.errors import Floats
from skinfield.live.slots import Head
from skinfield.live.snapshot import Snapshot

NEAR = 1.5e-3  # m: from the place of a contact to that of its outline


def newest_of(snapshots: Sequence[Snapshot]) -> dict[str, Any]:
    """Numbers of the cycle with the newest reading."""
    if not snapshots:
        return {"cycle": 0, "stamp_ns": 0, "age_s": None, "fresh": False, "late": False}
    newest = max(snapshots, key=lambda each: each.stamp_ns)
    head = newest.slot.head
    ready = (int(head[Head.READY_NS]) - int(head[Head.WAKE_NS])) * 1e-3
    published = int(head[Head.WALL_NS]) + int(head[Head.READY_NS]) - int(head[Head.WAKE_NS])
    latency = (published - newest.stamp_ns) * 1e-3 if newest.stamp_ns else None
    return {
        "cycle": newest.number,
        "stamp_ns": newest.stamp_ns,
        "age_s": finite(newest.age),
        "fresh": newest.fresh,
        "late": bool(int(head[Head.FLAGS]) & CycleFlag.LATE),
        "ready_us": ready,
        "latency_us": latency,
    }


def contact_of(row: Any, number: int, by: str) -> dict[str, Any]:
    """A contact of patch `number`, found by the engine or the fit, without what is drawn."""
    return {
        "track": int(row["track"]),
        "patch": number,
        "by": by,
        "x": float(row["x"]),
        "y": float(row["y"]),
        "force": float(row["normal_force"]),
        "force_std": finite(row["force_std"]),
        "place_std": finite(row["place_std"]),
        "area": finite(row["area"]),
        "peak": finite(row["peak_pressure"]),
        "age_s": finite(row["age"]),
        "speed": finite(row["speed"]),
    }


def outline_near(contacts: Any, position: Floats) -> Floats | None:
    """Border of the contact that stands there."""
    for each in contacts:
        if float(np.linalg.norm(each.position - position)) < NEAR:
            border: Floats = each.outline
            return border if len(border) else None
    return None


def finite(value: Any) -> float | None:
    """A number for JSON; None for what is none."""
    found = float(value)
    return found if math.isfinite(found) else None


def plain(values: Floats) -> list[float]:
    """Numbers for JSON."""
    return [float(each) for each in values]
