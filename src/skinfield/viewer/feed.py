"""What the page shows: one engine, wherever it runs, or a recording."""

from typing import Any, Protocol

from skinfield.layout import Skin
from skinfield.live.recipe import Recipe
from skinfield.live.snapshot import Snapshot


class Feed(Protocol):
    """One engine as the page sees it; all methods may be called from any thread, one at a time."""

    @property
    def name(self) -> str:
        """Of the engine; among the feeds of one page no other has it."""
        ...

    @property
    def skin(self) -> Skin:
        """All its patches."""
        ...

    @property
    def recipe(self) -> Recipe:
        """What its answers follow from."""
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
