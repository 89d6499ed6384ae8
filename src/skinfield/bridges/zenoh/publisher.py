"""Publishes a live skin over zenoh, from a process of its own: a reader of the ring like any."""

import secrets
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from skinfield.bridges.child import say_ready
from skinfield.bridges.zenoh.keys import Part
from skinfield.bridges.zenoh.messages import EstimateHead, newest_stamp
from skinfield.bridges.zenoh.outlets import Outlets
from skinfield.bridges.zenoh.session import ZenohSettings, open_session
from skinfield.bridges.zenoh.told import Told, layout_text
from skinfield.errors import InputError, check_positive, check_type
from skinfield.live.best import best_contacts
from skinfield.live.client import Live, NotRunning, connect
from skinfield.live.fit_reader import FitReader
from skinfield.live.slots import Head, Slot
from skinfield.live.snapshot import Snapshot
from skinfield.ring import State
from skinfield.ring.slot import Slot as Copy

SLICE = 0.1  # s at most without a look whether to stop
STATUS = 0.5  # s between what is said of the state
QUIET = 0.25  # s after which a cycle goes out though it has no new reading
BACK = 20  # cycles that are looked through for one with a new reading
TAKEN = 12.0  # s until a name is free of which the computer went away without a word
HERE = 2.0  # s to wait for the ring at first
ANEW = 30.0  # s to wait for a ring whose engine is started anew
RATE = 100.0  # estimates per second at most


@dataclass(frozen=True, kw_only=True)
class PublisherSettings:
    """What is published, and how often.

    Parameters
    ----------
    robot : str
        First name in the keys.
    session : ZenohSettings
    rate : float, 1/s
        Of estimates and raw readings at most; the newest wins. Contacts have no limit.
    """

    robot: str = "robot"
    session: ZenohSettings = field(default_factory=ZenohSettings)
    rate: float = RATE

    def __post_init__(self) -> None:
        check_type("robot", self.robot, str, "a name in keys")
        check_positive("rate", self.rate, "estimates per second")

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "PublisherSettings":
        """Of what `skinfield run` hands over.

        Raises
        ------
        InputError
            For what it never does.
        """
        strange = sorted(set(plain) - {"robot", "session", "rate"})
        if strange:
            raise InputError(f"settings have {strange[0]!r}, expected robot, session, rate")
        values = dict(plain)
        if "session" in values:
            values["session"] = ZenohSettings.from_plain(values["session"])
        return cls(**values)


class Publisher:
    """Publishes what one ring holds.

    Parameters
    ----------
    session : zenoh.Session
    live : Live
    part : Part
    rate : float, 1/s
        See `PublisherSettings`.
    """

    def __init__(self, session: Any, live: Live, part: Part, rate: float = RATE) -> None:
        self._live, self._reader = live, live.reader
        self._told, self._fit = Told(live, part), FitReader(live.name)
        self._patches = range(len(live.skin))
        self._starts = live.models.starts
        self._outlets = Outlets(session, part, [patch.name for patch in live.skin])
        self._part, self._every = part, 1.0 / rate
        self._instance = secrets.randbits(64)
        self._taken, self._spare = (self._room() for _ in range(2))
        self._seen = 0
        self._owed = False  # whether what was taken is held back for the rate's sake
        self._next = self._status = self._sent = 0.0

    def _room(self) -> tuple[Copy, Slot]:
        copy = self._reader.slot()
        return copy, Slot.of(copy.arrays)

    @contextmanager
    def there(self) -> Iterator[None]:
        """Answer queries, and show that the engine lives."""
        told, part = self._told, self._part
        answers = {
            "description": lambda: told.description,
            "layout": lambda: told.layout,
            "calibration": told.calibration,
            "status": told.newest_status,
            "health": told.health,
        }
        for patch in self._live.skin:
            key = part.patch_key(patch.name, "layout").removeprefix(part.key(""))
            answers[key] = partial(layout_text, patch)
        try:
            with self._outlets.answering(answers):
                self._tell(time.monotonic())
                yield
        finally:
            self._outlets.close()
            self._fit.close()

    def step(self) -> None:
        """Wait for a cycle, and send what is due."""
        now = time.monotonic()
        due = min(self._next if self._owed else now + SLICE, self._status)
        number = self._reader.wait(self._seen, min(max(due - now, 0.0), SLICE))
        now = time.monotonic()
        if now >= self._status:
            self._tell(now)
        if number > self._seen and self._take(number, now):
            self._owed = True
            self._send_contacts()
        if self._owed and now >= self._next:
            self._owed, self._sent = False, now
            self._next = max(self._next + self._every, now)
            self._send_estimate()

    def _tell(self, now: float) -> None:
        self._status = now + STATUS
        self._outlets.live(self._reader.alive and self._reader.state < State.STOPPED)
        self._outlets.put("status", self._told.status())
        self._outlets.put("health", self._told.health())

    def _take(self, number: int, now: float) -> bool:
        """Take the newest cycle with a new reading; another only if none went out for long."""
        quiet = now - self._sent > QUIET
        first, self._seen = max(self._seen, number - BACK), number
        for each in range(number, first, -1):
            copy, slot = self._spare
            if self._reader.get(each, copy) is None:
                return False  # this process was held up: a newer one is coming
            if slot.head[Head.FRESH] or (quiet and each == number):
                self._taken, self._spare = self._spare, self._taken
                return True
        return False

    def _head(self) -> bytes:
        copy, slot = self._taken
        return EstimateHead(
            generation=copy.generation,
            number=copy.number,
            stamp_ns=newest_stamp(slot),
            sent_ns=time.time_ns(),
            tares=int(self._reader.status_view["tares"][0]),
            instance=self._instance,
            fingerprint=self._told.fingerprint,
        ).packed()

    def _send_contacts(self) -> None:
        several = [p for p in self._patches if self._outlets.wanted("contacts", p)]
        if not several and not self._outlets.wanted("contacts"):
            return
        copy, slot = self._taken
        snapshot = Snapshot(slot, copy.number, self._live.models, time.time_ns())
        rows, by = best_contacts(snapshot, self._fit)
        head = self._head()
        self._outlets.put("contacts", self._told.contacts(snapshot, rows, by), head)
        for patch in several:
            self._outlets.put(
                "contacts", self._told.contacts(snapshot, rows, by, patch), head, patch
            )

    def _send_estimate(self) -> None:
        head = self._head()
        if self._outlets.wanted("estimate"):
            self._outlets.put("estimate", self._taken[0].octets.tobytes(), head)
        counts = self._taken[1].counts
        if self._outlets.wanted("raw"):
            self._outlets.put("raw", counts.tobytes(), head)
        for patch in self._patches:
            if self._outlets.wanted("raw", patch):
                its = slice(self._starts[patch], self._starts[patch + 1])
                self._outlets.put("raw", counts[its].tobytes(), head, patch)


def check_free(session: Any, part: Part) -> None:
    """Raise InputError if another engine already publishes under these names."""
    end = time.monotonic() + TAKEN
    while any(reply.ok for reply in session.liveliness().get(part.key("alive"), timeout=1.0)):
        if time.monotonic() > end:
            raise InputError(
                f"{part} is published already, expected a name of its own for each engine: "
                "give another --name or --robot"
            )
        time.sleep(0.2)


def serve(name: str, plain: Mapping[str, Any], stop: threading.Event) -> None:
    """Publish the ring `name` until told to stop; a ring that takes its place is taken up.

    Raises
    ------
    InputError
        If zenoh cannot start, or there is no such skin.
    """
    settings = PublisherSettings.from_plain(plain)
    part = Part(settings.robot, name)
    with open_session(settings.session) as session:
        live, ready = connect(name, timeout=HERE), False
        check_free(session, part)
        while True:
            with live:
                publisher = Publisher(session, live, part, settings.rate)
                with publisher.there():
                    if not ready:
                        say_ready(key=part.key("**"), id=str(session.info.zid()))
                        ready = True
                    while not stop.is_set() and not live.reader.replaced():
                        publisher.step()
            if stop.is_set():
                return
            live = _anew(name, stop)


def _anew(name: str, stop: threading.Event) -> Live:
    """The ring that took the place of another."""
    end = time.monotonic() + ANEW
    while True:
        try:
            return connect(name, timeout=SLICE)
        except NotRunning:
            if stop.is_set() or time.monotonic() > end:
                raise
