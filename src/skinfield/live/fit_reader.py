"""Fitted contacts of a live skin, as another program reads them."""

import time
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.contacts.live import CONTACT
from skinfield.errors import InputError
from skinfield.live.fit_ring import VERSION, FitSlot, fit_name, slot_fields, status_fields
from skinfield.live.notes import read_notes
from skinfield.ring import Field, RingReader

AGAIN = 0.5  # s between looks for a ring that is not there


class FitReader:
    """Reads what the fit beside a live skin publishes; there need not be one, or not yet.

    Nothing here raises because the fit is missing, was started anew, or has ended: then there is
    no answer of it. For one thread at a time.

    Parameters
    ----------
    name : str
        Of the live skin.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self._reader: RingReader | None = None
        self._looked = -AGAIN
        self._newest: FitSlot | None = None
        self._number = 0  # of the answer that `following` gave last

    def _open(self) -> RingReader | None:
        """The ring as it is now; looked for twice a second while there is none."""
        now = time.monotonic()
        if now - self._looked < AGAIN:
            return self._reader
        self._looked = now
        if self._reader is not None and self._reader.alive and not self._reader.replaced():
            return self._reader
        self.close()
        try:
            reader = RingReader(fit_name(self.name))
        except InputError:  # FileError is one: there is none, or it is being made
            return None
        if not reader.alive or not _is_of_a_fit(reader):
            reader.close()
            return None
        self._reader = reader
        self._room = reader.slot()
        self._names = tuple(map(str, reader.description["patches"]))
        self._number = max(reader.number - reader.slots // 2, 0)  # the oldest may go at any time
        return reader

    @property
    def names(self) -> tuple[str, ...] | None:
        """Of the patches of the skin that is fitted; None where there is no fit."""
        return None if self._open() is None else self._names

    def latest(self) -> FitSlot | None:
        """The newest answers of all patches, until the next call; None where there are none."""
        reader = self._open()
        if reader is None:
            return None
        if reader.number != (self._room.number if self._newest is not None else 0):
            try:
                copied = reader.latest(self._room)
            except InputError:  # overtaken, or damaged: the next call tries again
                return self._newest
            self._newest = None if copied is None else FitSlot.of(copied.arrays)
        return self._newest

    def following(self) -> Iterator[tuple[int, FitSlot | None]]:
        """Numbers and answers since the last call, each of them until the next one.

        It begins with some that are still there. None for an answer that was overwritten before it
        was read, or is damaged.
        """
        reader = self._open()
        if reader is None:
            return
        newest = reader.number
        if newest < self._number:
            self._number = 0
        oldest = newest - reader.slots
        if self._number < oldest:  # of many one word is enough
            self._number = oldest
            yield oldest, None
        while self._number < newest:
            self._number += 1
            copied = reader.get(self._number, self._room)
            yield self._number, None if copied is None else FitSlot.of(copied.arrays)

    def pressure(self, patch: int) -> NDArray[np.float32] | None:
        """Pressure (K,), Pa, of a patch by its number on the finest grid; None if not fitted.

        Of the answer that the newest `latest` gave; a copy.
        """
        return None if self._newest is None else self._newest.pressure_of(patch)

    def status(self) -> dict[str, Any]:
        """What the fit does: `phase`, notes, counts; empty where there is none."""
        reader = self._open()
        if reader is None:
            return {}
        view = reader.status_view
        counts = {key: int(view[key][0]) for key in ("fits", "unhelpful", "cpu_ns")}
        return {**(read_notes(view["notes"]) or {}), **counts, "pid": reader.pid}

    def close(self) -> None:
        """Let go of the ring."""
        if self._reader is not None:
            self._reader.close()
        self._reader, self._newest = None, None


def _is_of_a_fit(reader: RingReader) -> bool:
    """Whether a ring is laid out as those of this program's fits are."""
    said, fields = reader.description, {each.name: each for each in reader.slot_fields}
    names, pressure = said.get("patches"), fields.get("pressure")
    if said.get("skinfield_fit") != VERSION or not isinstance(names, list) or pressure is None:
        return False
    if "contacts" not in fields or len(pressure.shape) != 2 or len(names) != pressure.shape[0]:
        return False
    bytes_each = CONTACT.itemsize * max(len(names), 1)
    rows, nodes = int(np.prod(fields["contacts"].shape)) // bytes_each, pressure.shape[1]
    return _alike(reader.slot_fields, slot_fields(len(names), nodes, rows)) and _alike(
        reader.status_fields, status_fields()
    )


def _alike(found: Sequence[Field], expected: Sequence[Field]) -> bool:
    """Whether fields are the same, however their types are written."""
    plain = [[(e.name, np.dtype(e.dtype), e.shape) for e in each] for each in (found, expected)]
    return plain[0] == plain[1]
