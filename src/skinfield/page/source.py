"""Data sources of the page: an engine of this machine, and its newest cycle."""

import threading
import time
from typing import Any, NamedTuple, Protocol

from skinfield.loop import State
from skinfield.loop.client import Live
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


RECENT = 1.0  # s that the status calls the last
OLD = 0.5  # s since the newest reading, at least: contacts of it are not of now


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
        return time.time_ns() - newest.stamp_ns > self.fades * 1e9

    @property
    def fades(self) -> float:
        """Age from which on a reading is not of now, s: more where readings come seldom."""
        return max(OLD, float(self.live.reader.status_view["stale_ns"][0]) * 1e-9)

    @property
    def replaced(self) -> bool:
        """Whether another skin runs under its name by now."""
        return bool(self.live.reader.replaced())

    def status(self) -> dict[str, Any]:
        """What there is now, and happened in the last second."""
        with self._lock:
            return self._observer.look().as_dict()

    def close(self) -> None:
        """Let go of the ring."""
        with self._lock:
            self.live.close()


class EngineView(NamedTuple):
    """One engine at the time of an update.

    Attributes
    ----------
    snapshot : Snapshot or None
    old : bool
        Whether the cycle is not of now any more: its engine has ended, or no readings arrive.
    lives : bool
        Whether time passes for it; not in a recording.
    fades : float, s
        Age from which on a reading is not of now.
    """

    snapshot: Snapshot | None
    old: bool = False
    lives: bool = False
    fades: float = OLD

    @property
    def since(self) -> float:
        """Seconds since the snapshot was fetched, by which its ages have grown."""
        if self.snapshot is None or not self.lives:
            return 0.0
        return time.monotonic() - self.snapshot.fetched
