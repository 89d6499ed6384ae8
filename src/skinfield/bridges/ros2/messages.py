"""From what a running skin says to messages of ROS 2, each reading once."""

from collections.abc import Collection, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.bridges.ros2.diagnostics import diagnostics_of
from skinfield.engine.state import Answer
from skinfield.layout import Skin
from skinfield.live.best import best_contacts
from skinfield.live.fit_reader import FitReader
from skinfield.live.snapshot import Snapshot
from skinfield.live.status import Status
from skinfield.sinks.ros.kinds import (
    CLOUD,
    CONTACTS,
    DIAGNOSTICS,
    FRAMES,
    WRENCH_STAMPED,
    Kinds,
)
from skinfield.sinks.ros.messages import WHATS, Outgoing, SkinMessages, of_contacts
from skinfield.sinks.ros.names import Topics

SAID = (*WHATS, "taxels", "diagnostics")


class Channel(NamedTuple):
    """A topic, its kind of messages, and which of `SAID` they are."""

    topic: str
    kind: str
    what: str

    @property
    def depth(self) -> int:
        """Messages to keep for who is slow; frames of all contacts are of one topic."""
        return 100 if self.what == "frames" else 10


class Speaker:
    """Makes the messages of snapshots; a patch's reading is told once.

    Parameters
    ----------
    skin : Skin
    kinds : Kinds
    topics : Topics, optional
        Default those of the skin below `/skin`.
    """

    def __init__(self, skin: Skin, kinds: Kinds, topics: Topics | None = None) -> None:
        self.make = SkinMessages(skin, kinds, topics)
        self._told = {what: np.zeros(len(skin), np.int64) for what in SAID}

    @property
    def topics(self) -> Topics:
        """Names of all topics."""
        return self.make.topics

    def channels(self) -> Iterator[Channel]:
        """All that there are."""
        yield Channel(self.topics.contacts, CONTACTS, "contacts")
        yield Channel(self.topics.frames, FRAMES, "frames")
        yield Channel(self.topics.diagnostics, DIAGNOSTICS, "diagnostics")
        for place in range(len(self.make.skin)):
            for what, kind in (
                ("taxels", CLOUD),
                ("wrench", WRENCH_STAMPED),
                ("contact_wrench", WRENCH_STAMPED),
            ):
                yield Channel(self.topics.of_patch(place, what), kind, what)

    def news(self, snapshot: Snapshot, what: str) -> NDArray[np.bool_]:
        """Patches with an answer to a reading of which that was not said yet, (P,)."""
        there, stamps = (
            snapshot.patches["answer"] != int(Answer.MISSING),
            snapshot.patches["stamp_ns"],
        )
        # another stamp, not a later one: the computer's clock may be set back
        return np.asarray(there & (stamps > 0) & (stamps != self._told[what]))

    def of_snapshot(
        self, snapshot: Snapshot, wanted: Collection[str], fit: FitReader | None = None
    ) -> Iterator[Outgoing]:
        """What a cycle says; of `SAID` but for the diagnostics.

        A patch without an answer, or without a reading since it was last asked for, says nothing.
        Contacts are those of the fit beside the engine where it has recent ones.
        """
        stamps = snapshot.patches["stamp_ns"]
        there = snapshot.patches["answer"] != int(Answer.MISSING)
        rows, by = best_contacts(snapshot, fit)
        answered = there[rows["patch"]]
        contacts = rows[answered]
        fitted = (np.array(by, "U8")[answered] == "fit").tolist()
        for what in wanted:
            fresh = self.news(snapshot, what)
            self._told[what] = np.where(fresh, stamps, self._told[what])
            if what == "taxels":
                yield from self._taxels(snapshot, np.flatnonzero(fresh).tolist())
            elif what in WHATS:
                told = fresh.tolist()
                stamped = stamps.tolist()
                yield from of_contacts(self.make, stamped, contacts, told, (what,), fitted)

    def of_status(self, status: Status, stamp_ns: int) -> Outgoing:
        """The health, at a time."""
        header = self.make.header(stamp_ns, "")
        message = diagnostics_of(status, header, self.make.kinds)
        return Outgoing(self.topics.diagnostics, DIAGNOSTICS, stamp_ns, message)

    def _taxels(self, snapshot: Snapshot, places: list[int]) -> Iterator[Outgoing]:
        for place in places:
            values, valid, _ = snapshot.taxels(self.make.skin[place].name)
            stamp_ns = int(snapshot.patches["stamp_ns"][place])
            yield self.make.taxels(place, stamp_ns, np.where(valid, values, np.nan))
