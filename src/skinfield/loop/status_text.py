"""Text in the ring's status: what an engine has to say beside numbers."""

import json
from collections.abc import Mapping
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from skinfield.compile_progress import words
from skinfield.ring import Field

ROOM = 1 << 16  # bytes
HEAD = 8  # bytes: length and checksum, each 4
FIELD = Field("notes", "<u1", (ROOM,))

Octets = NDArray[np.uint8]


def write_notes(room: Octets, notes: Mapping[str, Any]) -> None:
    """Write notes as JSON; lists are cut where they would not fit, and say so."""
    text = json.dumps(notes).encode()
    if len(text) > len(room) - HEAD:
        short = {k: v[:20] if isinstance(v, list | str) else v for k, v in notes.items()}
        text = json.dumps(short | {"cut": "there was more than fits"}).encode()
        text = text if len(text) <= len(room) - HEAD else b'{"cut": "there was more than fits"}'
    room[:HEAD].view("<u4")[0] = 0  # so that nobody takes old text for new
    room[HEAD : HEAD + len(text)] = np.frombuffer(text, np.uint8)
    room[:HEAD].view("<u4")[1] = crc32(text)
    room[:HEAD].view("<u4")[0] = len(text)


def start_in_words(notes: Mapping[str, Any]) -> str:
    """What an engine does before it answers as it will, from its notes; empty once it does."""
    phase, progress = notes.get("phase", ""), notes.get("progress") or {}
    if phase == "running" and progress:
        doing = start_in_words({**notes, "phase": "preparing"})
        return f"linear answers until contacts are ready: {doing}"
    if phase == "taring":
        return "taking its baseline: leave the skin untouched"
    if phase not in ("loading", "preparing"):
        return ""
    if progress.get("compiled", 1.0) < 1.0:
        return words(progress["compile_left_s"])
    if "patches" not in progress:
        return "loading its code"
    text = f"preparing patch {int(progress['patches']) + 1} of {int(progress['of'])}"
    left = progress.get("left_s", 0.0)
    return f"{text}, about {left:.0f} s more" if left >= 1.0 else text


def preparing_of(notes: Mapping[str, Any]) -> dict[str, Any] | None:
    """What an engine prepares, for a bar: `what`, share `done` from 0 to 1, `seconds_left`.

    `what` is "compiling" or "preparing"; the seconds are None where they are not known. None where
    nothing that takes long is being done.
    """
    progress = notes.get("progress") or {}
    if progress.get("compiled", 1.0) < 1.0:
        done, left = progress["compiled"], progress["compile_left_s"]
        return {"what": "compiling", "done": done, "seconds_left": left}
    if progress.get("of") and notes.get("phase") in ("loading", "preparing", "running"):
        done = progress["patches"] / progress["of"]
        return {"what": "preparing", "done": done, "seconds_left": progress.get("left_s")}
    return None


def read_notes(room: Octets) -> dict[str, Any] | None:
    """Notes; None while they are being written, or where there are none."""
    length, checksum = room[:HEAD].view("<u4").tolist()
    if not 0 < length <= len(room) - HEAD:
        return None
    text = room[HEAD : HEAD + length].tobytes()
    if crc32(text) != checksum:
        return None
    found = json.loads(text)
    return found if isinstance(found, dict) else None
