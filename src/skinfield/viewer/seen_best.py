"""A cycle with the best contacts that are known of it, for the page."""

from skinfield.live.best import best_of, recent_patches
from skinfield.live.fit_ring import FitSlot
from skinfield.live.snapshot import Snapshot
from skinfield.viewer.fields import Fields
from skinfield.viewer.updates import Seen, seen_plainly


def seen_best(snapshot: Snapshot | None, found: FitSlot | None) -> Seen:
    """A cycle with what the fit had found by then; the same live and of a recording.

    Parameters
    ----------
    snapshot : Snapshot or None
    found : FitSlot or None
        None, or one of another skin: all is as the engine says.
    """
    if snapshot is None or found is None or len(found.patches) != len(snapshot.patches):
        return seen_plainly(snapshot)
    rows, by = best_of(snapshot, found)
    recent = recent_patches(snapshot, found)
    fields = {
        patch.name: pressure
        for place, patch in enumerate(snapshot.recipe.skin)
        if recent[place] and (pressure := found.pressure_of(place)) is not None
    }
    return Seen(snapshot, rows, by, Fields(fields))
