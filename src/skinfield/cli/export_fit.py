"""Contacts of a fit in an export: one table, each answer of a patch once."""

from typing import Any, Self

import numpy as np

from skinfield.errors import FileError


class FitRows:
    """From messages of a fit to rows of a table; made by `FitRows.of`.

    A row is a contact: `wall_ns`, when the fit published it; of its patch's answer the engine's
    `cycle`, `stamp_ns` of the newest reading in it and `readings`, how many it is the mean of; and
    all fields of a contact and of its form.
    """

    def __init__(self, recording: Any, layout: Any) -> None:
        self._recording, self._layout = recording, layout
        patch, contact, form = layout.patch.names, layout.contact.names, layout.form.names
        self._of_patch = [name for name in ("cycle", "stamp_ns", "readings") if name in patch]
        taken = {"wall_ns", *self._of_patch}
        self._of_contact = [name for name in contact if name not in taken]
        taken |= set(self._of_contact)
        self._of_form = [name for name in form if name not in taken and name != "spare"]
        self.fields = np.dtype(
            [("wall_ns", "<i8")]
            + [(name, layout.patch[name]) for name in self._of_patch]
            + [(name, layout.contact[name]) for name in self._of_contact]
            + [(name, layout.form[name]) for name in self._of_form]
        )
        self._told: dict[int, bytes] = {}

    @classmethod
    def of(cls, recording: Any) -> Self | None:
        """Of a recording; None where it has no channel of fits, or none that can be read."""
        from skinfield.sources.recordings.mcap_fits import fit_layout_of

        try:
            layout = fit_layout_of(recording)
        except FileError as error:  # the rest is whole
            recording.note(0, str(error))
            return None
        return None if layout is None else cls(recording, layout)

    def rows_of(self, at: int, data: bytes) -> Any:
        """What a message at byte `at` says that was not said before."""
        from skinfield.sources.recordings.mcap_fits import fit_of

        found = fit_of(self._recording, self._layout, at, data)
        if found is None:
            return np.zeros(0, self.fields)
        told = {int(p): row.tobytes() for p, row in zip(found.places, found.patches, strict=True)}
        fresh = np.array([self._told.get(place) != row for place, row in told.items()], bool)
        self._told = told
        counts = found.patches["contacts"]
        new = np.repeat(fresh, counts)
        rows = np.zeros(int(new.sum()), self.fields)
        rows["wall_ns"] = found.time_ns
        for name in self._of_patch:
            rows[name] = np.repeat(found.patches[name], counts)[new]
        for name in self._of_contact:
            rows[name] = found.contacts[name][new]
        for name in self._of_form:
            rows[name] = found.forms[name][new]
        return rows
