"""What the control socket understands."""

import math
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from skinfield.errors import InputError
from skinfield.virtual.fault_clock import fault_to_start
from skinfield.virtual.faults import FOREVER, Fault, fault_from_text
from skinfield.virtual.place import number

if TYPE_CHECKING:
    from skinfield.virtual.skin import VirtualSkin

LINES = 100  # of truth in one answer, at most
LONGEST_TEXT = 200


def commands_of(skin: "VirtualSkin") -> Mapping[str, Callable[[Mapping[str, Any]], dict[str, Any]]]:
    """Functions by the value of `do`; each takes the command's object and gives the answer's."""

    def stop(_: Mapping[str, Any]) -> dict[str, Any]:
        skin.stop()
        return {}

    return {
        "press": skin.world.press,
        "move": skin.world.move,
        "release": skin.world.release,
        "fault": lambda given: _fault(skin, given),
        "clear": lambda given: _clear(skin, given),
        "wires": skin.set_wires,
        "scene": lambda given: _scene(skin, given),
        "counts": lambda _: skin.counts(),
        "truth": lambda given: _truth(skin, given),
        "describe": lambda _: skin.description(),
        "quit": stop,
    }


def _text(given: Mapping[str, Any], key: str) -> str:
    value = given.get(key)
    if not isinstance(value, str) or not 0 < len(value) <= LONGEST_TEXT:
        raise InputError(f"{key} is {value!r:.80}, expected text")
    return value


def _fault(skin: "VirtualSkin", given: Mapping[str, Any]) -> dict[str, Any]:
    """``{"do": "fault", "fault": "unplug 3+5s"}``, or `kind`, `what`, `after` and `seconds`."""
    if "fault" in given:
        fault = fault_from_text(_text(given, "fault"))
    else:
        lasting = FOREVER
        if given.get("seconds") is not None:
            lasting = number(given, "seconds", None, 1e-3, 1e9, "for how long")
        after = number(given, "after", 0.0, 0.0, 1e9, "seconds from now")
        what = str(given.get("what", "0"))
        fault = Fault(_text(given, "kind"), what, after, lasting)
    now_ns = time.time_ns()
    fault = fault_to_start(fault, skin.time(now_ns))
    skin.faults.add(fault)
    if skin.stream_ns:
        skin.faults.advance(skin.time(now_ns), now_ns, skin.warmth(now_ns))
    until = fault.end if math.isfinite(fault.end) else None
    return {"kind": fault.kind, "what": fault.what, "start": fault.start, "end": until}


def _clear(skin: "VirtualSkin", given: Mapping[str, Any]) -> dict[str, Any]:
    kind = _text(given, "kind") if given.get("kind") is not None else None
    now_ns = time.time_ns()
    return {"cleared": skin.faults.clear(kind, now_ns, skin.warmth(now_ns))}


def _scene(skin: "VirtualSkin", given: Mapping[str, Any]) -> dict[str, Any]:
    skin.play(_text(given, "scene"))
    return {"scene": skin.world.scene.name}


def _truth(skin: "VirtualSkin", given: Mapping[str, Any]) -> dict[str, Any]:
    """Lines from `after` on; the newest alone without it."""
    made = skin.truth.made
    after = int(number(given, "after", max(made - 1, 0), 0, 1e15, "number of a line"))
    lines = skin.truth.after(after, LINES)
    while lines and sum(len(line["presses"]) for line in lines) > LINES:
        lines = lines[: len(lines) // 2] or lines[:1]
        if len(lines) == 1:
            break
    told = {"lines": lines, "made": made, "stamp_ns": time.time_ns()}
    return {**told, "waits": skin.world.waits, "notes": skin.world.notes}
