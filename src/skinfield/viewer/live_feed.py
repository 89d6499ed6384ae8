"""A running skin of this machine, as the page sees it."""

import threading
from typing import Any

from skinfield.layout import Skin
from skinfield.live.client import Live
from skinfield.live.fit_reader import FitReader
from skinfield.live.recipe import Recipe
from skinfield.live.snapshot import Snapshot
from skinfield.live.status import Observer

RECENT = 1.0  # s that the status calls the last


class LiveFeed:
    """See `Feed`.

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

    @property
    def recipe(self) -> Recipe:
        """What its answers follow from."""
        return self.live.recipe

    def latest(self) -> Snapshot | None:
        """The newest cycle, of those with a new reading if any: the same until there is another."""
        with self._lock:
            found = self.live.next_answered()
            if found is not None:
                self._newest = found
            return self._newest

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
