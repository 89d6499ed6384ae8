"""Publisher over zenoh: what a running skin sends, and answers queries with."""

import secrets
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

from skinfield.bridges.child import say_ready
from skinfield.bridges.settings import BridgeSettings
from skinfield.bridges.zenoh.messages import (
    EstimateHead,
    RemoteCalibration,
    contact_plain,
    contacts_of,
    described,
    fingerprint_of,
    layout_text,
    status_and_health,
)
from skinfield.bridges.zenoh.session import Keys, load_zenoh, open_session, zenoh_session
from skinfield.errors import InputError
from skinfield.loop import State
from skinfield.loop.client import Live, NotRunning, connect
from skinfield.loop.model_config import configuration_of
from skinfield.loop.slots import CycleHead, SlotLayout
from skinfield.loop.snapshot import Snapshot
from skinfield.loop.status import Observer

JSON, BYTES = "application/json", "application/octet-stream"
WHOLE = {  # what is published of an engine: kind of bytes, and priority
    "contacts": (JSON, "INTERACTIVE_HIGH"),
    "estimate": (BYTES, "DATA"),
    "raw": (BYTES, "DATA"),
    "status": (JSON, "DATA_LOW"),
    "health": (JSON, "DATA_LOW"),
}
OF_PATCH = ("contacts", "raw")


class Outlets:
    """Publishers of one engine; nothing is made for keys that nobody reads.

    All drop what cannot be sent at once: each message is whole, so the next makes up for it, and a
    reader that hangs holds up nobody.
    """

    def __init__(self, session: Any, part: Keys, patches: Sequence[str]) -> None:
        self._session, self._part = session, part
        self._token: Any = None
        self._answers: list[Any] = []
        self._publishers: dict[tuple[str, int | None], Any] = {
            (what, None): self._declare(part.key(what), what) for what in WHOLE
        }
        for place, name in enumerate(patches):
            for what in OF_PATCH:
                made = self._declare(part.patch_key(name, what), what)
                self._publishers[what, place] = made

    def _declare(self, key: str, what: str) -> Any:
        zenoh = load_zenoh()
        encoding, priority = WHOLE[what]
        return self._session.declare_publisher(
            key,
            encoding=encoding,
            congestion_control=zenoh.CongestionControl.DROP,
            priority=getattr(zenoh.Priority, priority),
            express=True,  # sent at once, not gathered with others
        )

    def wanted(self, what: str, patch: int | None = None) -> bool:
        """Whether somebody reads this."""
        return bool(self._publishers[what, patch].matching_status.matching)

    def put(
        self, what: str, data: bytes, head: bytes | None = None, patch: int | None = None
    ) -> None:
        """Send."""
        self._publishers[what, patch].put(data, attachment=head)

    def live(self, alive: bool) -> None:
        """Show that the engine lives, or take that back."""
        if alive and self._token is None:
            self._token = self._session.liveliness().declare_token(self._part.key("alive"))
        elif not alive and self._token is not None:
            self._token.undeclare()
            self._token = None

    def answer(self, what: str, make: Callable[[], bytes]) -> None:
        """Answer queries of the key that ends so, in a thread of zenoh."""
        key = self._part.key(what)
        encoding = "application/toml" if what.endswith("layout") else JSON

        def reply(query: Any) -> None:
            with query:
                try:
                    query.reply(key, make(), encoding=encoding)
                except Exception as error:  # whatever it is, who asked must not wait for ever
                    query.reply_err(str(error).encode())

        self._answers.append(self._session.declare_queryable(key, reply))

    def close(self) -> None:
        """Take everything back."""
        zenoh = load_zenoh()
        self.live(False)
        with suppress(zenoh.ZError):  # of a session that is closed already
            for each in (*self._answers, *self._publishers.values()):
                each.undeclare()


SLICE = 0.1  # s at most without a look whether to stop
RECENT = 1.0  # s that the status calls the last
STATUS = 0.5  # s between what is said of the state
QUIET = 0.25  # s after which a cycle goes out though it has no new reading
TAKEN = 12.0  # s until a name is free of which the computer went away without a word
HERE = 10.0  # s to wait for the ring
RATE = 100.0  # estimates per second at most


class ZenohPublisher:
    """Publishes what one ring holds.

    Parameters
    ----------
    session : zenoh.Session
    live : Live
    part : Keys
    rate : float, 1/s
        Of estimates and raw readings at most; the newest wins. Contacts have no limit.
    """

    def __init__(self, session: Any, live: Live, part: Keys, rate: float = RATE) -> None:
        self._live, self._reader = live, live.reader
        self._observer = Observer(live.reader, window=RECENT)
        layout = SlotLayout.of(live.reader.slot_fields)
        self._description = described(part.robot, part.name, live.reader.description, layout)
        self._fingerprint = fingerprint_of(self._description)
        self._patches = range(len(live.skin))
        self._starts = live.models.starts
        self._outlets = Outlets(session, part, [patch.name for patch in live.skin])
        self._part, self._every = part, 1.0 / rate
        self._instance = secrets.randbits(64)
        self._taken: Snapshot | None = None
        self._octets = live.octets
        self._said = b"", b""  # status and health
        self._seen = 0
        self._owed = False  # whether what was taken is held back for the rate's sake
        self._next = self._status = self._sent = 0.0

    @contextmanager
    def there(self) -> Iterator[None]:
        """Answer queries, and show that the engine lives."""
        part, skin = self._part, self._live.skin
        answers: dict[str, Callable[[], bytes]] = {
            "description": lambda: self._description,
            "layout": partial(layout_text, skin),
            "calibration": self._calibration,
            "status": lambda: self._said[0],
            "health": lambda: self._said[1],
        }
        for patch in skin:
            key = part.patch_key(patch.name, "layout").removeprefix(part.key(""))
            answers[key] = partial(layout_text, patch)
        try:
            self._tell(time.monotonic())
            for what, answer in answers.items():
                self._outlets.answer(what, answer)
            yield
        finally:
            self._outlets.close()

    def step(self) -> None:
        """Wait for a cycle, and send what is due."""
        now = time.monotonic()
        due = min(self._next if self._owed else now + SLICE, self._status)
        self._reader.wait(self._seen, min(max(due - now, 0.0), SLICE))
        now = time.monotonic()
        if now >= self._status:
            self._tell(now)
        if (found := self._live.next_answered()) is not None:
            self._seen = found.number
            if found.fresh or now - self._sent > QUIET:
                self._taken, self._octets, self._owed = found, self._live.octets, True
                self._send_contacts(found)
        if self._taken is not None and self._owed and now >= self._next:
            self._owed, self._sent = False, now
            self._next = max(self._next + self._every, now)
            self._send_estimate(self._taken)

    def _tell(self, now: float) -> None:
        self._status = now + STATUS
        self._outlets.live(self._reader.alive and self._reader.state < State.STOPPED)
        self._said = status_and_health(self._observer.look().as_dict(), self._live.tares)
        for what, data in zip(("status", "health"), self._said, strict=True):
            self._outlets.put(what, data)

    def _calibration(self) -> bytes:
        """Noise of all taxels and solver, by which a reader makes uncertainties."""
        known = configuration_of(self._reader)
        if known is None:
            raise InputError("the engine's settings are being written, expected them soon")
        return RemoteCalibration(self._live.tares, known, self._live.models.noise_std).packed()

    def _head(self, cycle: Snapshot) -> bytes:
        return EstimateHead(
            generation=int(cycle.slot.head[CycleHead.GENERATION]),
            number=cycle.number,
            stamp_ns=cycle.stamp_ns,
            sent_ns=time.time_ns(),
            tares=self._live.tares,
            instance=self._instance,
            fingerprint=self._fingerprint,
        ).packed()

    def _send_contacts(self, cycle: Snapshot) -> None:
        several = [p for p in self._patches if self._outlets.wanted("contacts", p)]
        if not several and not self._outlets.wanted("contacts"):
            return
        head, skin = self._head(cycle), list(self._live.skin)
        plain = [contact_plain(row, skin) for row in cycle.contacts]
        self._outlets.put("contacts", contacts_of(cycle, plain), head)
        for patch in several:
            its = [each for each in plain if each["patch"] == skin[patch].name]
            self._outlets.put("contacts", contacts_of(cycle, its), head, patch)

    def _send_estimate(self, cycle: Snapshot) -> None:
        head, counts = self._head(cycle), cycle.readings
        if self._outlets.wanted("estimate"):
            self._outlets.put("estimate", self._octets.tobytes(), head)
        if self._outlets.wanted("raw"):
            self._outlets.put("raw", counts.tobytes(), head)
        for patch in self._patches:
            if self._outlets.wanted("raw", patch):
                its = slice(self._starts[patch], self._starts[patch + 1])
                self._outlets.put("raw", counts[its].tobytes(), head, patch)


def check_free(session: Any, part: Keys) -> None:
    """Raise InputError if another engine already publishes under these names."""
    end = time.monotonic() + TAKEN
    while any(reply.ok for reply in session.liveliness().get(part.key("alive"), timeout=1.0)):
        if time.monotonic() > end:
            raise InputError(
                f"{part} is published already, expected a name of its own for each engine: "
                "give another --name or --robot-name"
            )
        time.sleep(0.2)


def serve(name: str, settings: BridgeSettings, stop: threading.Event) -> None:
    """Publish a running skin until told to stop; see `skinfield.bridges.child`.

    Raises
    ------
    InputError
        If zenoh cannot start, or there is no such skin.
    """
    part = Keys(settings.robot, name)
    with open_session(zenoh_session(settings)) as session, connect(name, timeout=HERE) as live:
        check_free(session, part)
        publisher = ZenohPublisher(session, live, part)
        with publisher.there():
            say_ready(key=part.key("**"), id=str(session.info.zid()))
            while not stop.is_set():
                publisher.step()
                if live.reader.replaced():
                    raise NotRunning(f"{name!r} was started anew: the bridge begins anew, too")
