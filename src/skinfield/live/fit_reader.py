"""Fitted contacts of a live skin, as another program reads them."""

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError
from skinfield.live.fit_ring import FitSlot, Fitted, fit_name
from skinfield.live.notes import read_notes
from skinfield.ring import RingReader

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
        if not reader.alive or "skinfield_fit" not in reader.description:
            reader.close()
            return None
        self._reader = reader
        self._room = reader.slot()
        return reader

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

    def pressure(self, patch: int) -> NDArray[np.float32] | None:
        """Pressure (K,), Pa, of a patch by its number on the finest grid; None if not fitted.

        Of the answer that the newest `latest` gave; a copy.
        """
        found = self._newest
        if found is None or found.patches["state"][patch] != Fitted.DONE:
            return None
        return np.array(found.pressure[patch])

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
