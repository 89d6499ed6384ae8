"""Data source over zenoh: one engine elsewhere, as its estimates come in."""

import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.bridges.zenoh.messages import (
    MOST_SLOT,
    RECENT_NS,
    Calibration,
    Contacts,
    EstimateHead,
    Plan,
    contacts_from,
)
from skinfield.bridges.zenoh.session import Part
from skinfield.bridges.zenoh.status_messages import blank_status, status_from
from skinfield.errors import InputError, check_positive
from skinfield.loop.model_config import ModelConfig, Models
from skinfield.loop.snapshot import Snapshot
from skinfield.skin import Skin

DRIFT = 1e-4  # between two computers' clocks


@dataclass
class Counts:
    """What came of an engine, and what did not.

    Attributes
    ----------
    received : int
        Estimates.
    octets : int, bytes
        In them.
    refused : int
        Messages that made no sense.
    """

    received: int = 0
    octets: int = 0
    refused: int = 0


@dataclass(frozen=True, eq=False)
class ReceivedEstimate:
    """An estimate as it came: nothing of it is looked at before somebody wants it."""

    head: EstimateHead
    payload: Any
    monotonic: float
    excess: float  # s that it took longer than the fastest lately


class Delay:
    """How much longer a message took than the fastest: clocks that differ drop out."""

    def __init__(self) -> None:
        self._least: tuple[float, float] | None = None  # s of delay, and when that was seen

    def excess(self, delay: float, now: float) -> float:
        """How much longer a message took, s.

        Parameters
        ----------
        delay : float, s
            From sent to received, each by its own clock.
        now : float, s
            Of the monotonic clock here.
        """
        least = self._least
        if least is None or delay <= least[0] + DRIFT * (now - least[1]):
            self._least = delay, now
            return 0.0
        return delay - least[0]


GONE = 1.0  # s without a word
EARLIER = "uncertainties are still those of an earlier baseline or solver"
GONE_NOTE = "nothing comes from it any more"


class ZenohSource:
    """One engine elsewhere; a `Feed` as the page takes them. Made by `ZenohSources`.

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
        self._received: ReceivedEstimate | None = None
        self._contacts: Contacts | None = None
        self._status: dict[str, Any] | None = None
        self._heard = time.monotonic()
        self._delay = Delay()
        self._made: tuple[ReceivedEstimate, Snapshot] | None = None
        self._absent: tuple[int, Snapshot] | None = None
        self._last_number = 0

    @property
    def name(self) -> str:
        """ROBOT/PART."""
        return str(self.part)

    @property
    def model_config(self) -> ModelConfig:
        """What its answers follow from."""
        return self._models.model_config

    @property
    def skin(self) -> Skin:
        """All its patches."""
        return self.model_config.skin

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
                self.outdated = True
                return
            if size != self.plan.slot_bytes or size > MOST_SLOT:
                raise InputError(f"an estimate has {size} bytes, expected {self.plan.slot_bytes}")
        except InputError as error:
            self.refuse(error)
            return
        with self._news:
            excess = self._delay.excess((now - head.sent_ns) * 1e-9, monotonic)
            self._received = ReceivedEstimate(head, payload, monotonic, excess)
            self._heard, self._wanted = monotonic, (head.tares, head.generation)
            self.counts.received += 1
            self.counts.octets += size
            self._news.notify_all()

    def take_status(self, data: bytes) -> None:
        """Keep what it says of itself."""
        try:
            status = status_from(data, self.skin)
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
        model_config = self.plan.model_config
        if calibration.solver is not None:
            model_config = replace(model_config, solver=calibration.solver)
        with self._news:
            self._models = Models(model_config, calibration.noise_std)
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
            received, made = self._received, self._made
            gone = self.gone
        if gone and self._last_number:
            return self._missing()
        if received is None:
            return None if made is None else made[1]
        if made is not None and made[0] is received:
            return made[1]
        try:
            slot = self.plan.slot(received.payload.to_bytes())
        except InputError as error:
            self.refuse(error)
            with self._news:
                if self._received is received:
                    self._received = None
            return None if made is None else made[1]
        snapshot = Snapshot(slot, received.head.number, self._models, self._wall_ns(received))
        self._made, self._absent = (received, snapshot), None
        self._last_number = received.head.number
        return snapshot

    def _wall_ns(self, received: ReceivedEstimate) -> int:
        """Now, by the clock of the engine's computer: as it was sent, and how long ago that is."""
        since = time.monotonic() - received.monotonic + received.excess
        return received.head.sent_ns + int(since * 1e9)

    def _missing(self) -> Snapshot:
        """A cycle without answers, in place of old ones; its number is 0."""
        if self._absent is None or self._absent[0] != self._last_number:
            slot = self.plan.empty()
            if self._made is not None:
                received, last = self._made
                slot.patches["stamp_ns"] = last.patches["stamp_ns"]
                slot.counts[:] = np.nan
                wall = self._wall_ns(received)
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
        contacts, own = self._contacts, snapshot.contacts
        if (
            contacts is None
            or not snapshot.number
            or abs(contacts.stamp_ns - snapshot.stamp_ns) > RECENT_NS
        ):
            return own, ["engine"] * len(own)
        return contacts.rows, contacts.by

    def next(self, timeout: float) -> Snapshot | None:
        """Wait for a cycle that was not fetched yet; None if none came in time."""
        check_positive("timeout", timeout, "seconds to wait")
        end = time.monotonic() + timeout
        with self._news:
            while self._received is None or (
                self._made is not None and self._made[0] is self._received
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
            status = blank_status(self.name, self.skin) if self._status is None else self._status
            status = status | {"name": self.name, "notes": dict(status["notes"])}
        if self.gone:
            status |= {"state": "failed", "rate": 0.0, "contacts": []}
            status["patches"] = [
                row | {"answer": "missing", "stale": True, "force": 0.0, "contacts": 0}
                for row in status["patches"]
            ]
            status["notes"]["remote"] = GONE_NOTE
        elif self.needs_calibration:
            status["notes"]["remote"] = EARLIER
        if self.counts.refused:
            status["notes"]["refused"] = f"{self.counts.refused} messages, the last: {self.refusal}"
        return status

    def close(self) -> None:
        """Nothing: `ZenohSources` lets go of all."""
