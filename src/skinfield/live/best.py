"""The best contacts that are known: those of the fit where it has kept up, else the engine's."""

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts.live import CONTACT
from skinfield.engine.state import Answer
from skinfield.live.fit_reader import FitReader
from skinfield.live.fit_ring import FitSlot, Fitted
from skinfield.live.fit_tracks import NEAR
from skinfield.live.snapshot import Snapshot

RECENT_NS = 400_000_000  # that a fit may be behind the reading, or before it
RESTING_NS = 2_000_000_000  # the same, of a touch that rests
SAME_PLACE, SAME_FORCE = 4e-3, 0.5  # m; part of the larger: what the engine takes for the same
Rows = NDArray[np.void]


def best_contacts(snapshot: Snapshot, fit: FitReader | None) -> tuple[Rows, list[str]]:
    """Contacts of a snapshot, with those of the fit's newest answer in their place: `best_of`."""
    return best_of(snapshot, None if fit is None else fit.latest())


def best_of(snapshot: Snapshot, found: FitSlot | None) -> tuple[Rows, list[str]]:
    """Contacts of a snapshot, with those of a fit in their place where it is recent.

    Of a patch that the fit answered within 0.4 s of the snapshot's reading, the fit's contacts
    count, and those of the engine that began since, 10 mm away or more. They end with the touch:
    where the engine sees nothing any more of what it saw then, neither does this. While the engine
    sees what it saw then, at about the same place and about as strong, the fit may be up to 2 s
    behind: a busy machine.

    Parameters
    ----------
    snapshot : Snapshot
    found : FitSlot or None
        What the fit had found by then. None, or one of another skin: all is as the engine says.

    Returns
    -------
    (N,) array of CONTACT
        Patch after patch.
    list of str
        Of each row who says it: "fit" or "engine".
    """
    engine = snapshot.contacts
    if found is None or len(found.patches) != len(snapshot.patches):
        return engine, ["engine"] * len(engine)
    recent = recent_patches(snapshot, found)
    rows: list[Rows] = []
    by: list[str] = []
    for patch in range(len(snapshot.patches)):
        own = engine[engine["patch"] == patch]
        if recent[patch]:
            told = found.patches[patch]
            fitted = found.contacts[patch][: int(told["contacts"])]
            since = (int(snapshot.patches["stamp_ns"][patch]) - int(told["stamp_ns"])) * 1e-9
            own = own[(own["age"] < since) & _apart(own, fitted)]
            rows.append(fitted)
            by += ["fit"] * len(fitted)
        rows.append(own)
        by += ["engine"] * len(own)
    return np.concatenate(rows) if rows else np.zeros(0, CONTACT), by


def _apart(own: Rows, fitted: Rows) -> NDArray[np.bool_]:
    """Which of the engine's contacts are none of those that were fitted under another number."""
    off = [own[axis][:, None] - fitted[axis][None] for axis in ("x", "y")]
    near = (np.hypot(*off) < NEAR).any(axis=1)
    return np.asarray(~near & ~np.isin(own["track"], fitted["track"]))


def recent_patches(snapshot: Snapshot, found: FitSlot) -> NDArray[np.bool_]:
    """Which patches (P,) the fit answers for the reading of a snapshot."""
    now, told = snapshot.patches, found.patches
    apart = np.abs(now["stamp_ns"] - told["stamp_ns"])
    answered = now["answer"] != int(Answer.MISSING)
    touched = (now["answer"] >= int(Answer.LINEAR)) | (now["contacts"] > 0)
    there = touched | (told["touched"] == 0)
    young = apart <= RECENT_NS
    for patch in np.flatnonzero(~young & (apart <= RESTING_NS)):
        own = snapshot.contacts[snapshot.contacts["patch"] == patch]
        young[patch] = len(own) > 0 and _same(told[patch], own)
    recent = (told["state"] == int(Fitted.DONE)) & young & answered & there
    return np.asarray(recent, dtype=np.bool_)


def _same(told: np.void, own: Rows) -> bool:
    """Whether the engine sees on a patch what it saw when the fit answered."""
    force, before = float(own["normal_force"].sum()), float(told["engine_force"])
    moved = np.hypot(own["x"][0] - told["engine_x"], own["y"][0] - told["engine_y"])
    as_strong = abs(force - before) <= SAME_FORCE * max(force, before)
    return bool(len(own) == told["engine_contacts"] and moved <= SAME_PLACE and as_strong)
