"""Data sources of the page: an engine of this machine, and its cycles with the best contacts."""

import threading
import time
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.loop import State
from skinfield.loop.client import Live
from skinfield.loop.fit_ring import FitReader, FitSlot, best_of, recent_patches
from skinfield.loop.snapshot import Snapshot
from skinfield.loop.status import Observer
from skinfield.skin import Skin


class DataSource(Protocol):
    """One engine as the page sees it; all methods may be called from any thread, one at a time."""

    @property
    def name(self) -> str:
        """Of the engine; among the sources of one page no other has it."""
        ...

    @property
    def skin(self) -> Skin:
        """All its patches."""
        ...

    def latest(self) -> Snapshot | None:
        """The newest cycle, or None if there is none yet; returns at once."""
        ...

    def status(self) -> dict[str, Any]:
        """What `Status.as_dict` tells; `state` is "failed" where the engine is gone."""
        ...

    def close(self) -> None:
        """Let go of it."""
        ...


Array = NDArray[Any]

RECENT = 1.0  # s that the status calls the last
OLD = 0.5  # s since the newest reading: contacts of it are not of now


class LiveSource:
    """See `DataSource`.

    Parameters
    ----------
    name : str
        Of the ring.

    Raises
    ------
    InputError
        If there is none of that name.
    """

    def __init__(self, name: str) -> None:
        self.live = Live(name)
        self._observer = Observer(self.live.reader, window=RECENT)
        self._fit = FitReader(name)
        self._lock = threading.Lock()
        self._newest: Snapshot | None = None

    @property
    def name(self) -> str:
        """Of the ring."""
        return self.live.name

    @property
    def skin(self) -> Skin:
        """All its patches."""
        return self.live.skin

    def latest(self) -> Snapshot | None:
        """The newest cycle, of those with a new reading if any: the same until there is another."""
        with self._lock:
            found = self.live.next_answered()
            if found is not None:
                self._newest = found
            return self._newest

    @property
    def old(self) -> bool:
        """Whether what is `latest` is not of now: the engine has ended, or no readings arrive."""
        newest = self._newest
        if newest is None or self.live.state != State.RUNNING:
            return True
        return time.time_ns() - newest.stamp_ns > OLD * 1e9

    def view(self, fitted: bool) -> "EngineView":
        """The newest cycle, with the contacts of the fit beside it if that is wanted."""
        snapshot = self.latest()
        with self._lock:
            found = self._fit.latest() if fitted else None
            return merged_view(snapshot, found)._replace(old=self.old)

    @property
    def fit_is_ready(self) -> bool:
        """Whether the fit beside the engine is there, and has prepared what it needs."""
        with self._lock:
            return bool(self._fit.status().get("phase") == "ready")

    @property
    def replaced(self) -> bool:
        """Whether another skin runs under its name by now."""
        return bool(self.live.reader.replaced())

    def status(self) -> dict[str, Any]:
        """What there is now, and happened in the last second; with what the fit beside it does."""
        with self._lock:
            return self._observer.look().as_dict() | {"fit": self._fit.status()}

    def close(self) -> None:
        """Let go of the ring."""
        with self._lock:
            self._fit.close()
            self.live.close()


class EngineView(NamedTuple):
    """One engine at the time of an update.

    Attributes
    ----------
    snapshot : Snapshot or None
    contacts : structured (N,) array
    by : sequence of str
        Who found each: "engine" or "fit".
    fit : mapping from names of patches to (K,) arrays, Pa, or None
        Pressures of the fit on the finest grid, of patches that it answers for now.
    old : bool
        Whether the cycle is not of now any more: its engine has ended, or no readings arrive.
    """

    snapshot: Snapshot | None
    contacts: Array
    by: Sequence[str]
    fit: Mapping[str, Array] | None = None
    old: bool = False


def plain_view(snapshot: Snapshot | None) -> EngineView:
    """A cycle as the engine answered it."""
    rows = np.zeros(0) if snapshot is None else snapshot.contacts
    return EngineView(snapshot, rows, ["engine"] * len(rows))


def merged_view(snapshot: Snapshot | None, found: FitSlot | None) -> EngineView:
    """A cycle with what the fit had found by then; the same live and of a recording."""
    if snapshot is None or found is None or len(found.patches) != len(snapshot.patches):
        return plain_view(snapshot)  # no fit, or one of another skin
    rows, by = best_of(snapshot, found)
    recent = recent_patches(snapshot, found)
    fields = {
        patch.name: pressure
        for place, patch in enumerate(snapshot.model_config.skin)
        if recent[place] and (pressure := found.pressure_of(place)) is not None
    }
    return EngineView(snapshot, rows, by, fields)
