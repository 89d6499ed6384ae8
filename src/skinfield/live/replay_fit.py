"""What the fit beside the engine had found at any time of a recording."""

import numpy as np

from skinfield.acquisition.recorded_fit import FitRecord
from skinfield.errors import FileError
from skinfield.live.fit_ring import LAYOUT, FitSlot
from skinfield.live.replay import Replay
from skinfield.sources.recordings.mcap_fits import FitTimes, fit_layout_of

FAR = 1e15  # that no place (m), force (N) or pressure (Pa) comes near


class ReplayFit:
    """Answers of the fit of a recording, for one thread at a time.

    The engine is answered again without them: what cannot be read of them is told in the
    recording's `damage`, and its own contacts are left.

    Parameters
    ----------
    replay : Replay
    """

    def __init__(self, replay: Replay) -> None:
        self._recording = replay.recording
        recipe = replay.recipe
        self._skin = len(recipe.skin), max(recipe.rungs) ** 2
        self._times: FitTimes | None = None
        self._newest: tuple[FitRecord, FitSlot | None] | None = None
        try:
            layout = fit_layout_of(self._recording)
            if layout is not None and layout != LAYOUT:
                raise FileError("the rows of the contact fit are of another version, and left out")
            self._times = FitTimes(self._recording, replay.moments)
        except FileError as error:
            self._recording.note(0, str(error))

    def at(self, time_ns: int) -> FitSlot | None:
        """What the fit had found by a time, ns since the epoch, as `FitReader.latest` gave it then.

        None where there was no fit, or it knew of no touch.
        """
        try:
            record = None if self._times is None else self._times.before(time_ns)
        except FileError as error:
            self._recording.note(0, str(error))
            return None
        if record is None:
            return None
        if self._newest is None or self._newest[0] is not record:
            self._newest = record, self._slot_of(record)
        return self._newest[1]

    def _slot_of(self, record: FitRecord) -> FitSlot | None:
        patches, nodes, _ = record.sizes
        if not len(record.places):
            return None
        if (patches, nodes) != self._skin:
            self._recording.note(
                0, f"a contact fit of {patches} patches with {nodes} nodes each, expected "
                f"{self._skin[0]} with {self._skin[1]}: it is damaged, or of another skin",
            )  # fmt: skip
            return None
        if not is_sound(record):
            self._recording.note(
                0, f"answer {record.number} of the contact fit has contacts of other patches or "
                f"numbers that cannot be, expected finite ones below {FAR:g}: it is damaged",
            )  # fmt: skip
            return None
        return slot_of(record)


def is_sound(record: FitRecord) -> bool:
    """Whether numbers of an answer can be shown: finite, within reach, each on its own patch."""
    rows = record.contacts
    shown = [rows[name].ravel() for name in ("position", "normal", "x", "y", "normal_force")]
    own = rows["patch"] == np.repeat(record.places, record.patches["contacts"])
    numbers = np.concatenate([*shown, record.pressure])
    return bool(own.all() and (np.abs(numbers) < FAR).all())  # false for NaN too


def slot_of(record: FitRecord) -> FitSlot:
    """The answer as it was in the fit's ring; of patches that it says nothing of, nothing."""
    slot, places = FitSlot.empty(*record.sizes), record.places.astype(np.int64)
    slot.told_ns[0] = record.time_ns
    slot.patches[places] = record.patches
    used = np.arange(record.sizes.rows) < record.patches["contacts"][:, None]
    patch, row = np.nonzero(used)
    slot.contacts[places[patch], row] = record.contacts
    slot.forms[places[patch], row] = record.forms
    slot.pressure[np.repeat(places, record.pressed), record.nodes] = record.pressure
    return slot
