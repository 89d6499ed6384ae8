"""Notes of engines for those who look at the page: what somebody can do something about."""

import time
from collections.abc import Mapping
from typing import Any

RECENT = 60.0  # s for which it is told that an engine failed
LATE = 0.01  # of the cycles late lately, from which on it matters that real time was refused
TOLD = ("failed", "hung")  # events of the supervisor
NOT_TOLD = "too rarely to tell a dead one from a quiet one"  # of taxels that nothing is wrong with


def viewer_notes(status: Mapping[str, Any], simulated: bool) -> list[str]:
    """What `Status.as_dict` tells that a viewer can act on, in sentences.

    The rest is told by `skinfield status`.

    Parameters
    ----------
    status : mapping
        Of one engine.
    simulated : bool
        Whether its skin is virtual: made without a baseline that could be better.
    """
    notes = status.get("notes") or {}
    if isinstance(notes, list):  # of an engine that cannot be asked
        return [str(each) for each in notes]
    supervisor = (status.get("beside") or {}).get("supervisor") or {}
    since = time.time_ns() - RECENT * 1e9
    said = [
        f"the engine {text}"
        for stamp, what, text in supervisor.get("events", [])
        if what in TOLD and stamp >= since
    ][-3:]
    said += [str(notes[name]) for name in ("failed", "remote", "pace") if notes.get(name)]
    said += [*str(notes.get("replay", "")).split("; ")[1:], *notes.get("damage", [])]
    readings = (notes.get("readings") or {}).items()
    said += [f"{patch}: {text}" for patch, texts in readings for text in texts]
    made = tuple(f"{patch['name']}:" for patch in status.get("patches", []) if simulated)
    tare = [text for text in notes.get("tare") or [] if NOT_TOLD not in text]
    said += [text for text in tare if not text.startswith(made)]
    lately = status.get("lately") or {}
    if lately.get("late", 0) > LATE * max(lately.get("cycles", 0), 1):
        said += (notes.get("granted") or {}).get("refused") or []
    return list(dict.fromkeys(said))
