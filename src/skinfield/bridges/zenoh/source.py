"""Data source over zenoh: one engine elsewhere, as its estimates come in."""

import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skinfield.bridges.zenoh.messages import (
    EstimateForm,
    EstimateHead,
    RemoteCalibration,
    status_from,
)
from skinfield.bridges.zenoh.session import Keys
from skinfield.errors import InputError, check_positive
from skinfield.loop.model_config import ModelConfig, Models
from skinfield.loop.slots import CycleSlot
from skinfield.loop.snapshot import Snapshot
from skinfield.skin import Skin

DRIFT = 1e-4  # between two computers' clocks


@dataclass(frozen=True, eq=False)
class ReceivedEstimate:
    """An estimate as it came."""

    head: EstimateHead
    slot: CycleSlot
    monotonic: float
    excess: float  # s that it took longer than the fastest lately

    @property
    def wall_ns(self) -> int:
        """Now, by the clock of the engine's computer: as it was sent, and how long ago that is."""
        since = time.monotonic() - self.monotonic + self.excess
        return self.head.sent_ns + int(since * 1e9)


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
    part : Keys
    plan : EstimateForm
        Of its description.
    calibration : RemoteCalibration
    status : bytes
        What it said of itself last.

    Attributes
    ----------
    part : Keys
    plan : EstimateForm
    refused : int
        Messages that made no sense.
    refusal : str
        Why the last of them was refused.
    alive : bool
        Whether its sign of life is there.
    outdated : bool
        Whether it sends what its description does not fit any more.
    """

    def __init__(
        self, part: Keys, plan: EstimateForm, calibration: RemoteCalibration, status: bytes
    ) -> None:
        self.part, self.plan = part, plan
        self.refused, self.refusal = 0, ""
        self.alive, self.outdated = True, False
        self._news = threading.Condition()
        self.take_calibration(calibration)
        self._wanted = self._known
        self._received: ReceivedEstimate | None = None
        self._snapshot: Snapshot | None = None  # of what was received, once it was fetched
        self._status = status_from(status, self.skin)
        self._heard = time.monotonic()
        self._delay = Delay()

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

    def take_estimate(self, attachment: bytes, payload: bytes) -> None:
        """Keep an estimate until a newer one is there."""
        now, monotonic = time.time_ns(), time.monotonic()
        try:
            head = EstimateHead.of(attachment)
            if head.fingerprint != self.plan.fingerprint:
                self.outdated = True
                return
            slot = self.plan.slot(payload)
        except InputError as error:
            self.refuse(error)
            return
        with self._news:
            excess = self._delay.excess((now - head.sent_ns) * 1e-9, monotonic)
            self._received = ReceivedEstimate(head, slot, monotonic, excess)
            self._snapshot = None
            self._heard, self._wanted = monotonic, (head.tares, head.generation)
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

    def take_calibration(self, calibration: RemoteCalibration) -> None:
        """Take another noise of the taxels, or another solver."""
        configuration = calibration.configuration
        model_config = replace(self.plan.model_config, solver=configuration.solver)
        with self._news:
            self._models = Models(model_config, calibration.noise_std)
            self._known = calibration.tares, configuration.generation

    def refuse(self, error: InputError) -> None:
        """Count a message that makes no sense."""
        self.refused += 1
        self.refusal = str(error)

    @property
    def needs_calibration(self) -> bool:
        """Whether estimates come of another baseline or process than is known."""
        return self._wanted != self._known

    # what is wanted of it

    def latest(self) -> Snapshot | None:
        """The newest cycle, at once: the same until there is another, None before the first.

        Of an engine that is gone, one in which every patch is missing: its number is 0.
        """
        with self._news:
            received = self._received
            if received is None:
                return None
            if self.gone:
                slot = self.plan.layout.slot()
                slot.patches["stamp_ns"] = received.slot.patches["stamp_ns"]
                slot.counts[:] = np.nan
                return Snapshot(slot, 0, self._models, received.wall_ns)
            if self._snapshot is None:
                cycle = received.slot, received.head.number
                self._snapshot = Snapshot(*cycle, self._models, received.wall_ns)
            return self._snapshot

    def next(self, timeout: float) -> Snapshot | None:
        """Wait for a cycle that was not fetched yet; None if none came in time."""
        check_positive("timeout", timeout, "seconds to wait")
        with self._news:
            there = self._news.wait_for(self._has_news, timeout)
        return self.latest() if there else None

    def _has_news(self) -> bool:
        return self._received is not None and self._snapshot is None and not self.gone

    def __iter__(self) -> Iterator[Snapshot]:
        """Cycles as they come; a slow loop gets the newest and misses some."""
        while True:
            found = self.next(GONE)
            if found is not None:
                yield found

    def status(self) -> dict[str, Any]:
        """What `Status.as_dict` tells; `state` is "failed" where it is gone."""
        status = self._status | {"name": self.name, "notes": dict(self._status["notes"])}
        if self.gone:
            status |= {"state": "failed", "rate": 0.0, "contacts": []}
            status["patches"] = [
                row | {"answer": "missing", "stale": True, "force": 0.0, "contacts": 0}
                for row in status["patches"]
            ]
            status["notes"]["remote"] = GONE_NOTE
        elif self.needs_calibration:
            status["notes"]["remote"] = EARLIER
        if self.refused:
            status["notes"]["refused"] = f"{self.refused} messages, the last: {self.refusal}"
        return status

    def close(self) -> None:
        """Nothing: `ZenohSources` lets go of all."""
