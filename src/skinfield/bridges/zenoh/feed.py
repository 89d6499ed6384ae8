"""One engine elsewhere, as its estimates come in over zenoh."""

import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.bridges.zenoh.arrived import Arrived, Counts, Delay
from skinfield.bridges.zenoh.calibration import Calibration
from skinfield.bridges.zenoh.checked import blank_status, checked_status
from skinfield.bridges.zenoh.fitted import RECENT_NS, Contacts, contacts_from
from skinfield.bridges.zenoh.keys import Part
from skinfield.bridges.zenoh.messages import (
    MOST_SLOT,
    MOST_STATUS,
    EstimateHead,
    Plan,
    object_of,
)
from skinfield.errors import InputError, check_positive
from skinfield.layout import Skin
from skinfield.live.estimates import Models
from skinfield.live.recipe import Recipe
from skinfield.live.snapshot import Snapshot

GONE = 1.0  # s without a word
EARLIER = "uncertainties are still those of an earlier baseline or solver"
GONE_NOTE = "nothing comes from it any more"


class ZenohFeed:
    """One engine elsewhere; a `Feed` as the page takes them. Made by `ZenohFeeds`.

    Parameters
    ----------
    part : Part
    plan : Plan
        Of its description.
    calibration : Calibration

    Attributes
    ----------
    part : Part
    plan : Plan
    counts : Counts
    refusal : str
        Why a message was refused, of the last one that was.
    alive : bool
        Whether its sign of life is there.
    outdated : bool
        Whether it sends what its description does not fit any more.
    """

    def __init__(self, part: Part, plan: Plan, calibration: Calibration) -> None:
        self.part, self.plan = part, plan
        self.counts, self.refusal = Counts(), ""
        self.alive, self.outdated = True, False
        self._news = threading.Condition()
        self.take_calibration(calibration)
        self._wanted = self._known
        self._arrived: Arrived | None = None
        self._contacts: Contacts | None = None
        self._status: dict[str, Any] | None = None
        self._heard = time.monotonic()
        self._delay = Delay()
        self._made: tuple[Arrived, Snapshot] | None = None
        self._absent: tuple[int, Snapshot] | None = None
        self._last_number = 0

    @property
    def name(self) -> str:
        """ROBOT/PART."""
        return str(self.part)

    @property
    def recipe(self) -> Recipe:
        """What its answers follow from."""
        return self._models.recipe

    @property
    def skin(self) -> Skin:
        """All its patches."""
        return self.recipe.skin

    @property
    def gone(self) -> bool:
        """Whether its sign of life is missing, or nothing came for a second."""
        return not self.alive or time.monotonic() - self._heard > GONE

    # what comes, in threads of zenoh

    def take_estimate(self, attachment: bytes, payload: Any) -> None:
        """Keep an estimate until somebody wants it, or a newer one is there."""
        now, monotonic = time.time_ns(), time.monotonic()
        try:
            head = EstimateHead.of(attachment)
            size = len(payload)
            if head.fingerprint != self.plan.fingerprint:
                self.counts.other += 1
                self.outdated = True
                return
            if size != self.plan.slot_bytes or size > MOST_SLOT:
                raise InputError(f"an estimate has {size} bytes, expected {self.plan.slot_bytes}")
        except InputError as error:
            self.refuse(error)
            return
        with self._news:
            excess = self._delay.excess((now - head.sent_ns) * 1e-9, monotonic)
            self._arrived = Arrived(head, payload, now, monotonic, excess)
            self._heard, self._wanted = monotonic, (head.tares, head.generation)
            self.counts.received += 1
            self.counts.octets += size
            self._news.notify_all()

    def take_status(self, data: bytes) -> None:
        """Keep what it says of itself."""
        try:
            status = checked_status(object_of(data, MOST_STATUS), self.skin)
        except InputError as error:
            self.refuse(error)
            return
        with self._news:
            self._status, self._heard = status, time.monotonic()

    def take_contacts(self, data: bytes) -> None:
        """Keep the contacts that it tells, which may be of its fit."""
        try:
            self._contacts = contacts_from(data, self.skin)
        except InputError as error:
            self.refuse(error)

    def take_calibration(self, calibration: Calibration) -> None:
        """Take another noise of the taxels, or another solver."""
        recipe = self.plan.recipe
        if calibration.solver is not None:
            recipe = replace(recipe, solver=calibration.solver)
        with self._news:
            self._models = Models(recipe, calibration.noise_std)
            self._known = calibration.tares, calibration.generation

    def refuse(self, error: InputError) -> None:
        """Count a message that makes no sense."""
        self.counts.refused += 1
        self.refusal = str(error)

    @property
    def needs_calibration(self) -> bool:
        """Whether estimates come of another baseline or process than is known."""
        return self._wanted != self._known

    # what is wanted of it

    def latest(self) -> Snapshot | None:
        """The newest cycle, at once: the same until there is another, None before the first.

        Of an engine that is gone, one in which every patch is missing.
        """
        with self._news:
            arrived, made = self._arrived, self._made
            gone = self.gone
        if gone and self._last_number:
            return self._missing()
        if arrived is None:
            return None if made is None else made[1]
        if made is not None and made[0] is arrived:
            return made[1]
        try:
            slot = self.plan.slot(arrived.payload.to_bytes())
        except InputError as error:
            self.refuse(error)
            with self._news:
                if self._arrived is arrived:
                    self._arrived = None
            return None if made is None else made[1]
        snapshot = Snapshot(slot, arrived.head.number, self._models, self._wall_ns(arrived))
        self._made, self._absent = (arrived, snapshot), None
        self._last_number = arrived.head.number
        return snapshot

    def _wall_ns(self, arrived: Arrived) -> int:
        """Now, by the clock of the engine's computer: as it was sent, and how long ago that is."""
        since = time.monotonic() - arrived.monotonic + arrived.excess
        return arrived.head.sent_ns + int(since * 1e9)

    def _missing(self) -> Snapshot:
        """A cycle without answers, in place of old ones; its number is 0."""
        if self._absent is None or self._absent[0] != self._last_number:
            slot = self.plan.empty()
            if self._made is not None:
                arrived, last = self._made
                slot.patches["stamp_ns"] = last.patches["stamp_ns"]
                slot.counts[:] = np.nan
                wall = self._wall_ns(arrived)
            else:
                wall = time.time_ns()
            self._absent = self._last_number, Snapshot(slot, 0, self._models, wall)
        return self._absent[1]

    def best(self, snapshot: Snapshot) -> tuple[NDArray[Any], list[str]]:
        """Contacts (N,) of a snapshot, those of the engine's fit where it has one.

        Returns
        -------
        (N,) array of CONTACT
        list of str
            Of each row who says it: "fit" or "engine".
        """
        told, own = self._contacts, snapshot.contacts
        if (
            told is None
            or not snapshot.number
            or abs(told.stamp_ns - snapshot.stamp_ns) > RECENT_NS
        ):
            return own, ["engine"] * len(own)
        return told.rows, told.by

    def next(self, timeout: float) -> Snapshot | None:
        """Wait for a cycle that was not fetched yet; None if none came in time."""
        check_positive("timeout", timeout, "seconds to wait")
        end = time.monotonic() + timeout
        with self._news:
            while self._arrived is None or (
                self._made is not None and self._made[0] is self._arrived
            ):
                left = end - time.monotonic()
                if left <= 0:
                    return None
                self._news.wait(left)
        return self.latest()

    def __iter__(self) -> Iterator[Snapshot]:
        """Cycles as they come; a slow loop gets the newest and misses some."""
        while True:
            found = self.next(GONE)
            if found is not None:
                yield found

    def status(self) -> dict[str, Any]:
        """What `Status.as_dict` tells; `state` is "failed" where it is gone."""
        with self._news:
            told = blank_status(self.name, self.skin) if self._status is None else self._status
            told = told | {"name": self.name, "notes": dict(told["notes"])}
        if self.gone:
            told |= {"state": "failed", "rate": 0.0, "contacts": []}
            told["patches"] = [
                row | {"answer": "missing", "stale": True, "force": 0.0, "contacts": 0}
                for row in told["patches"]
            ]
            told["notes"]["remote"] = GONE_NOTE
        elif self.needs_calibration:
            told["notes"]["remote"] = EARLIER
        if self.counts.refused:
            told["notes"]["refused"] = f"{self.counts.refused} messages, the last: {self.refusal}"
        return told

    def close(self) -> None:
        """Nothing: `ZenohFeeds` lets go of all."""
