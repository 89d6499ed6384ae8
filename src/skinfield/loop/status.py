"""Status of a running skin: state, times, sources, patches, as plain numbers."""

import json
import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError
from skinfield.estimate.row_contacts import shape_name
from skinfield.files.pending import plain_json
from skinfield.loop.model_config import configuration_of, state_of, tuning_of
from skinfield.loop.realtime.system import values_of
from skinfield.loop.realtime.timing import Timing
from skinfield.loop.runtime_parameters import Limits
from skinfield.loop.slots import CycleHead, CycleSlot
from skinfield.loop.status_text import read_notes
from skinfield.reconstruct.engine.report import WORDS
from skinfield.reconstruct.engine.state import Answer
from skinfield.ring import RingReader
from skinfield.ring.files import sidecar
from skinfield.signal import Count

SILENT = 3.0  # s without a word of a recorder, after which something is wrong
Array = NDArray[Any]


class RingCounters(NamedTuple):
    """Counters of a ring at one time, to tell what happened between two of them."""

    time: float
    number: int
    times: Array
    totals: Array
    sources: Array


@dataclass(frozen=True, eq=False)
class LiveStatus:
    """A look at a running skin.

    Attributes
    ----------
    name : str
    state : str
        "starting", "calibrating", "running", "stopped" or "failed".
    pid, generation : int
        Of the engine's process; how many there were on this ring.
    since : Timing
        Since the engine's start.
    lately : Timing
        Since an earlier look: the one before, or that of a second ago, as the `Observer` has it.
    seconds : float, s
        Between both looks.
    rate : float, 1/s
        Cycles lately.
    sources : dict of str to dict of str to int
        What each source counted, by its kind.
    sources_lately : dict of str to dict of str to int
        The same, since the earlier look.
    patches : list of dict
        Name, answer ("missing", "idle", "linear", "field" or "contacts"), age (s), stale (whether
        the age is more than is usual), force (N), contacts, readings (that were averaged), invalid.
    contacts : list of dict
    notes : dict
        What the engine says in words: phase, what was granted, how the baseline was taken.
    sidecars : dict
        Of the supervisor and the recorder, where there are any.
    memory : dict
        Of the engine's process: resident bytes.
    relative : bool
        Whether forces hold up to one factor only.
    tuning : dict
        What can be changed, as `Limits.as_dict` tells it, and the solver; empty of another ring.
    """

    name: str
    state: str
    since: Timing
    lately: Timing
    seconds: float
    rate: float
    patches: list[dict[str, Any]]
    contacts: list[dict[str, Any]]
    notes: dict[str, Any]
    pid: int = 0
    generation: int = 1
    sources: dict[str, dict[str, int]] = field(default_factory=dict)
    sources_lately: dict[str, dict[str, int]] = field(default_factory=dict)
    sidecars: dict[str, Any] = field(default_factory=dict)
    memory: dict[str, int] = field(default_factory=dict)
    tuning: dict[str, Any] = field(default_factory=dict)
    relative: bool = False

    @property
    def sentences(self) -> list[str]:
        """What the engine says of the readings of each patch, such as that its model is wrong."""
        said = self.notes.get("readings", {})
        return [f"{patch}: {text}" for patch, texts in said.items() for text in texts]

    @property
    def lost(self) -> int:
        """Messages that are known to be missing, over all sources."""
        return sum(each["lost"] + each["overflowed"] for each in self.sources.values())

    def as_dict(self) -> dict[str, Any]:
        """For JSON; times in µs."""
        plain = dict(vars(self))
        plain["since_start"], plain["lately"] = plain.pop("since").as_dict(), self.lately.as_dict()
        return plain | {"beside": plain.pop("sidecars"), "lost": self.lost}


class Observer:
    """Looks at a ring again and again.

    Parameters
    ----------
    reader : RingReader
        Of a live skin.
    window : float, s
        Each look tells what happened since the newest look that is at least as old as this, or
        since the first one; 0: since the look before.
    """

    def __init__(self, reader: RingReader, window: float = 0.0) -> None:
        if "skinfield_live" not in reader.description:
            raise InputError(f"ring {reader.name!r} is of something else, expected a live skin's")
        self._reader, self._window = reader, window
        self._slot = reader.slot()
        self._moments = deque([self._moment()])

    def _moment(self) -> RingCounters:
        status = self._reader.status_view
        return RingCounters(
            time.monotonic(),
            self._reader.number,
            status["times"].copy(),
            status["totals"].copy(),
            status["sources"].copy(),
        )

    def _earlier(self, now: RingCounters) -> RingCounters:
        """The moment from which on things count as recent."""
        moments = self._moments
        if (now.totals < moments[-1].totals).any():  # of another ring under the same name
            moments.clear()
            nothing = now.times * 0, now.totals * 0, now.sources
            moments.append(RingCounters(now.time, now.number, *nothing))
        while len(moments) > 1 and moments[1].time <= now.time - self._window:
            moments.popleft()
        earlier = moments[0]
        moments.append(now)
        return earlier

    def look(self) -> LiveStatus:
        """What there is now, and what happened since the last look."""
        reader, now = self._reader, self._moment()
        before, told = self._earlier(now), reader.description
        copied, patches, contacts = reader.latest(self._slot), [], []
        if copied is not None:
            slot, names = CycleSlot.of(copied.arrays), told["patches"]
            wall = max(int(slot.head[CycleHead.WALL_NS]), time.time_ns())  # old slots: old readings
            stale = int(reader.status_view["stale_ns"][0])
            patches = patch_rows(names, slot.patches, wall, stale)
            contacts = plain_contacts(names, slot.used_contacts())
        seconds = max(now.time - before.time, 1e-9)
        return LiveStatus(
            name=reader.name,
            state=state_of(reader).name.lower(),
            pid=reader.pid,
            generation=reader.generation,
            since=Timing.of(now.times, now.totals),
            lately=Timing.of(now.times, now.totals, (before.times, before.totals)),
            seconds=seconds,
            rate=(now.number - before.number) / seconds,
            sources=_sources(told["sources"], now.sources),
            sources_lately=_sources(told["sources"], now.sources - before.sources),
            patches=patches,
            contacts=contacts,
            notes=read_notes(reader.status_view["notes"]) or {},
            sidecars={what: _sidecar(reader.name, what) for what in ("supervisor", "recorder")},
            memory=_memory(reader.pid),
            tuning=_tuning(reader),
            relative=bool(told.get("relative", True)),  # older ones do not say it
        )


def _sources(names: list[str], counted: Array) -> dict[str, dict[str, int]]:
    found = {}
    for place, name in enumerate(names):
        label = name if names.count(name) == 1 else f"{name} {place + 1}"
        found[label] = {each.name.lower(): int(counted[place, each]) for each in Count}
    return found


def patch_rows(
    names: list[str], patches: Array, wall_ns: int, stale_ns: int = 0
) -> list[dict[str, Any]]:
    """Rows of PATCH as plain values, at a time; `stale_ns`: an unusual age, 0 where not known."""
    return [
        {
            "name": name,
            "answer": WORDS[Answer(int(row["answer"]))],
            "age": (wall_ns - int(row["stamp_ns"])) * 1e-9 if row["stamp_ns"] else None,
            "stale": bool(0 < stale_ns < wall_ns - row["stamp_ns"]),
            "force": float(row["force"]),
            "contacts": int(row["contacts"]),
            "readings": int(row["readings"]),
            "invalid": int(row["invalid"]),
            "rung": int(row["rung"]),
            "gap": None if np.isnan(row["gap"]) else float(row["gap"]),
        }
        for name, row in zip(names, patches, strict=True)
    ]


def plain_contacts(patches: list[str], contacts: Array) -> list[dict[str, Any]]:
    """Rows of contacts as JSON has them, None for what is not finite, with their patches' names."""
    rows = []
    for row in contacts:
        plain = plain_json({name: row[name] for name in row.dtype.names}, "contact")
        own = {"patch": patches[int(row["patch"])], "shape": shape_name(row)}
        rows.append(plain | own | {"maybe": int(row["maybe"])})
    return rows


def _sidecar(name: str, what: str) -> Any:
    try:
        told = json.loads(sidecar(name, what).read_text())
    except (OSError, ValueError):
        return None
    if isinstance(told, dict) and "told_ns" in told:  # every second, as long as it lives
        age = (time.time_ns() - int(told["told_ns"])) * 1e-9
        told["silent"] = bool(age > SILENT and not told.get("finished"))
    return told


def _tuning(reader: RingReader) -> dict[str, Any]:
    """What is in force, and what it may be."""
    known, limits = configuration_of(reader), Limits.of(reader.description)
    solver = None if known is None else type(known.solver).__name__
    return limits.as_dict(tuning_of(reader)) | {"solver": {"value": solver}}


def _memory(pid: int) -> dict[str, int]:
    """Resident bytes of a process, where the system tells."""
    resident = values_of(f"/proc/{pid}/status").get("VmRSS")  # such as "1234 kB"
    return {"resident": int(resident.split()[0]) * 1024} if resident else {}
