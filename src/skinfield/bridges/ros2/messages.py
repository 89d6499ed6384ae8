"""ROS 2 messages of a running skin, its diagnostics among them, and when each is sent."""

import time
from collections.abc import Callable, Collection, Iterator, Mapping
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.estimate.contact_table import RELATIVE, scale_of
from skinfield.files.ros.kinds import (
    CLOUD,
    CONTACTS,
    DIAGNOSTIC,
    DIAGNOSTICS,
    FRAMES,
    KEY_VALUE,
    WRENCH_STAMPED,
    Kinds,
)
from skinfield.files.ros.messages import WHATS, Outgoing, SkinMessages
from skinfield.files.ros.names import Topics
from skinfield.loop import Answer, State
from skinfield.loop.client import Live, NotRunning
from skinfield.loop.snapshot import Snapshot
from skinfield.loop.status import LiveStatus, Observer
from skinfield.skin import Skin

LATE_SHARE = 0.01  # of the estimates lately, above which it is told as a fault


class Level(IntEnum):
    """Of `diagnostic_msgs/DiagnosticStatus`."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


STATES = {
    "running": Level.OK,
    "starting": Level.WARN,
    "calibrating": Level.WARN,
    "stopped": Level.STALE,
    "failed": Level.ERROR,
}


def diagnostics_of(status: LiveStatus, header: Any, kinds: Kinds) -> Any:
    """One status of the engine, one of each source, one of each patch, one of the recorder."""
    rows = [_engine(status), *_sources(status), *_patches(status), *_recorder(status)]
    told = [
        kinds.make(
            DIAGNOSTIC,
            level=kinds.octet(int(level)),
            name=f"skinfield {status.name}: {name}",
            message=message,
            hardware_id=status.name,
            values=[
                kinds.make(KEY_VALUE, key=key, value=_text(value)) for key, value in values.items()
            ],
        )
        for level, name, message, values in rows
    ]
    return kinds.make(DIAGNOSTICS, header=header, status=told)


Row = tuple[Level, str, str, Mapping[str, Any]]


def _engine(status: LiveStatus) -> Row:
    level, lately = STATES.get(status.state, Level.ERROR), status.lately
    message = status.state
    if level == Level.OK and lately.late > LATE_SHARE * max(lately.cycles, 1):
        level, message = Level.WARN, f"running, {lately.late} of {lately.cycles} estimates late"
    latency = {} if lately.latency is None else lately.latency.as_micros()
    times = {f"latency {name} (us)": latency[name] for name in ("p50", "p99", "max") if latency}
    return (
        level,
        "engine",
        message,
        {
            "forces": scale_of(status.relative),
            "rate (1/s)": status.rate,
            "late": status.since.late,
            "late lately": lately.late,
            "skipped": status.since.skipped,
            **times,
            "restarts": max(status.generation - 1, 0),
            "resident (bytes)": status.memory.get("resident", 0),
        },
    )


def _sources(status: LiveStatus) -> Iterator[Row]:
    for name, counts in status.sources.items():
        lately = status.sources_lately.get(name, {})
        missing = sum(lately.get(what, 0) for what in ("lost", "overflowed"))
        if missing:
            yield Level.WARN, f"source {name}", f"{missing} messages lost lately", counts
        else:
            yield Level.OK, f"source {name}", "nothing lost lately", counts


def _patches(status: LiveStatus) -> Iterator[Row]:
    for patch in status.patches:
        values = {
            "answer": patch["answer"],
            "age (s)": patch["age"],
            f"force ({RELATIVE if status.relative else 'N'})": patch["force"],
            "contacts": patch["contacts"],
            "taxels left out": patch["invalid"],
            "grid": patch["rung"],
        }
        if patch["age"] is None:
            level, message = Level.STALE, "no reading came yet"
        elif patch["stale"]:
            level, message = Level.STALE, f"the newest reading is {patch['age']:.3g} s old"
        elif patch["answer"] == "missing":
            level, message = Level.ERROR, "no answer: too few taxels are valid"
        elif patch["invalid"]:
            level, message = Level.WARN, f"{patch['invalid']} taxels left out"
        else:
            level, message = Level.OK, f"{patch['contacts']} contacts"
        yield level, f"patch {patch['name']}", message, values


def _recorder(status: LiveStatus) -> Iterator[Row]:
    told = status.sidecars.get("recorder")
    if not isinstance(told, dict):
        return
    lost = sum(int(told.get(f"{why}_bytes", 0)) for why in ("overrun", "dropped"))
    plain = {key: value for key, value in told.items() if isinstance(value, int | float | str)}
    if told.get("silent"):
        yield Level.ERROR, "recorder", "says nothing any more", plain
    elif lost:
        yield Level.WARN, "recorder", f"{lost} bytes lost", plain
    else:
        yield Level.OK, "recorder", "finished" if told.get("finished") else "records", plain


def _text(value: Any) -> str:
    if value is None:
        return "none"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


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

    def of_snapshot(self, snapshot: Snapshot, wanted: Collection[str]) -> Iterator[Outgoing]:
        """What a cycle says; of `SAID` but for the diagnostics.

        A patch without an answer, or without a reading since it was last asked for, says nothing.
        """
        stamps = snapshot.patches["stamp_ns"]
        there = snapshot.patches["answer"] != int(Answer.MISSING)
        contacts = snapshot.contacts[there[snapshot.contacts["patch"]]]
        for what in wanted:
            fresh = self.news(snapshot, what)
            self._told[what] = np.where(fresh, stamps, self._told[what])
            if what == "taxels":
                yield from self._taxels(snapshot, np.flatnonzero(fresh).tolist())
            elif what in WHATS:
                told = fresh.tolist()
                stamped = stamps.tolist()
                yield from self.make.of_contacts(stamped, contacts, told, (what,))

    def of_status(self, status: LiveStatus, stamp_ns: int) -> Outgoing:
        """The health, at a time."""
        header = self.make.header(stamp_ns, "")
        message = diagnostics_of(status, header, self.make.kinds)
        return Outgoing(self.topics.diagnostics, DIAGNOSTICS, stamp_ns, message)

    def _taxels(self, snapshot: Snapshot, places: list[int]) -> Iterator[Outgoing]:
        for place in places:
            values, valid, _ = snapshot.taxels(self.make.skin[place].name)
            stamp_ns = int(snapshot.patches["stamp_ns"][place])
            yield self.make.taxels(place, stamp_ns, np.where(valid, values, np.nan))


LOOKS = 0.05  # s between looks whether to stop


class Talker:
    """Sends the messages of a running skin, each at its pace and each reading once.

    Parameters
    ----------
    live : Live
    speaker : Speaker
    rates : mapping of str to float, 1/s
        Of `SAID`; 0: never.
    send : function (Outgoing)
    """

    def __init__(
        self,
        live: Live,
        speaker: Speaker,
        rates: Mapping[str, float],
        send: Callable[[Outgoing], None],
    ) -> None:
        self._live, self._speaker, self._send = live, speaker, send
        self._every = {what: 1.0 / rate for what, rate in rates.items() if rate > 0}
        self._next = dict.fromkeys(self._every, 0.0)
        self._health = Observer(live.reader, window=1.0)
        self._newest: Snapshot | None = None

    def wait(self) -> float:
        """Seconds until something is due, at most `LOOKS`."""
        now = time.monotonic()
        return min(max(min(self._next.values(), default=now + LOOKS) - now, 0.0), LOOKS)

    def _mark(self, what: str, now: float) -> None:
        """It was done: the next is due on the beat, but what was missed is not made up for."""
        every, when = self._every[what], self._next[what]
        self._next[what] = (when if now < when + every else now) + every

    def step(self, timeout: float = 0.0) -> None:
        """Send what is due, as far as there is a new reading.

        Parameters
        ----------
        timeout : float, s
            How long to wait for one.

        Raises
        ------
        NotRunning
            If another skin took the name.
        """
        now = time.monotonic()
        due = [what for what, when in self._next.items() if when <= now]
        if "diagnostics" in due:
            if self._live.reader.replaced():
                raise NotRunning(f"{self._live.name!r} was started anew: connect again")
            self._send(self._speaker.of_status(self._health.look(), time.time_ns()))
            self._mark("diagnostics", now)
        wanted = [what for what in due if what != "diagnostics"]
        if self._live.state != State.RUNNING:
            for what in wanted:
                self._mark(what, now)
        elif wanted:
            self._look(0.0)
            left = self._say(wanted)
            if left and timeout > 0 and self._look(timeout):
                self._say(left)

    def _look(self, timeout: float) -> bool:
        """Wait for a reading that is newer than the last one."""
        end = time.monotonic() + timeout
        while True:
            found = self._live.next_answered()
            if found is not None and found.fresh:
                self._newest = found
                return True
            left = end - time.monotonic()
            if left <= 0.0:
                return False
            self._live.reader.wait(self._live.reader.number, left)

    def _say(self, wanted: list[str]) -> list[str]:
        """Send what is new of `wanted`; the rest."""
        if self._newest is None:
            return wanted
        left = []
        for what in wanted:
            if not self._speaker.news(self._newest, what).any():
                left.append(what)
                continue
            for out in self._speaker.of_snapshot(self._newest, (what,)):
                self._send(out)
            self._mark(what, time.monotonic())
        return left
