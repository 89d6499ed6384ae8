"""Orders of the page for skins elsewhere: none, but the best contacts that they tell are shown."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from skinfield.bridges.zenoh.feed import ZenohFeed
from skinfield.viewer.desk import Desk
from skinfield.viewer.feed import Feed
from skinfield.viewer.updates import Seen, seen_plainly

NOBODY = "no skin was heard of yet: does one run with --zenoh, where this machine reaches it?"


class Found(Protocol):
    """What was found elsewhere; see `ZenohFeeds`."""

    @property
    def notes(self) -> Mapping[str, str]:
        """Why an engine that can be seen is not shown, by its name."""

    def feeds(self) -> Sequence[Feed]:
        """Engines that are shown."""


class RemoteDesk(Desk):
    """See `Desk`.

    Parameters
    ----------
    found : ZenohFeeds
    """

    def __init__(self, found: Found) -> None:
        super().__init__()
        self._found = found
        self._told: dict[str, str] = {}

    def notices(self) -> list[tuple[str, str]]:
        """See `Desk`; and why an engine that can be seen is not shown, once."""
        notes = dict(self._found.notes)
        for name, why in notes.items():
            if self._told.get(name) != why:
                self.say("warn", f"{name} is not shown: {why}")
        self._told = notes
        return super().notices()

    def controls(self) -> dict[str, Any]:
        """See `Desk`; why nothing is shown is told as long as that is so."""
        told = super().controls()
        if not self._found.feeds():
            notes = dict(self._found.notes)
            whys = [f"{name} is not shown: {why}" for name, why in notes.items()]
            told["busy"] = "; ".join(whys) or NOBODY
        return told

    def seen(self, feeds: Sequence[Feed]) -> list[Seen]:
        """See `Desk`."""
        return [_seen(feed) for feed in feeds]


def _seen(feed: Feed) -> Seen:
    snapshot = feed.latest()
    if snapshot is None or not isinstance(feed, ZenohFeed):
        return seen_plainly(snapshot)
    return Seen(snapshot, *feed.best(snapshot))
