"""Ring of fitted contacts beside a live skin's own: fields, reader, best contacts of both."""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError
from skinfield.estimate.live_contacts import CONTACT
from skinfield.files.mcap.schema import FitLayout, FitSizes
from skinfield.loop.slots import SlotViews, empty_arrays
from skinfield.loop.snapshot import Snapshot
from skinfield.loop.status_text import FIELD as NOTES
from skinfield.loop.status_text import read_notes
from skinfield.reconstruct.engine.state import Answer
from skinfield.ring import Field, Ring, RingReader, State

Array = NDArray[Any]
VERSION = 2
SUFFIX = ".fit"
SLOTS = 16
LOG_BYTES = 1 << 12  # nothing is logged
COUNTERS = ("fits", "unhelpful", "cpu_ns")  # of its status, beside words: what it does now
SHAPES = ("other", "sphere", "flat", "line")  # `shape` of a form is an index into this


class Fitted(IntEnum):
    """How a patch was answered."""

    NOTHING = 0  # not yet, or not any more: nothing touches it
    DONE = 1  # contacts that explain the reading; perhaps none
    UNHELPFUL = 2  # no few contacts explain the reading: the engine's answer is the better one


PATCH = np.dtype(
    [
        ("state", "<i4"),  # of `Fitted`
        ("contacts", "<i4"),
        ("readings", "<i4"),  # that were averaged, as nothing moved
        ("touched", "<i4"),  # whether the engine saw a touch in the newest of them
        ("stamp_ns", "<i8"),  # of the newest of them, since the epoch
        ("cycle", "<i8"),  # of the engine, in which it was answered
        ("took_ns", "<i8"),
        ("force", "<f8"),  # N, of all contacts
        ("engine_contacts", "<i8"),  # that the engine saw then, with the place of the strongest (m)
        ("engine_force", "<f8"),  # and the force of all of them (N)
        ("engine_x", "<f8"),
        ("engine_y", "<f8"),
    ]
)
FORM = np.dtype([("shape", "<i4"), ("spare", "<i4"), ("radius", "<f8")])  # m, of the touch
LAYOUT = FitLayout(PATCH, CONTACT, FORM)  # of what a recording keeps of it


def fit_name(name: str) -> str:
    """Name of the ring that belongs to the live skin `name`."""
    return f"{name}{SUFFIX}"


def is_fit(name: str) -> bool:
    """Whether a ring of this name holds fitted contacts, and is no skin of its own."""
    return name.endswith(SUFFIX)


def write_engine(told: Array, contacts: Array) -> None:
    """Note in a row of `PATCH` what the engine sees: contacts of one patch, the strongest first."""
    told["engine_contacts"] = len(contacts)
    told["engine_force"] = contacts["normal_force"].sum()
    if len(contacts):
        told["engine_x"], told["engine_y"] = contacts["x"][0], contacts["y"][0]


def slot_fields(patches: int, nodes: int, rows: int) -> list[Field]:
    """Arrays of a slot: `nodes` of the finest grid of a patch, `rows` contacts at most."""
    return [
        Field("told_ns", "<i8", (1,)),
        Field("patches", "<u1", (patches * PATCH.itemsize,)),
        Field("contacts", "<u1", (patches * rows * CONTACT.itemsize,)),
        Field("forms", "<u1", (patches * rows * FORM.itemsize,)),
        Field("pressure", "<f4", (patches, nodes)),
    ]


def create_fit_ring(name: str, patches: Sequence[str], nodes: int, rows: int) -> Ring:
    """The ring of a fit of the live skin `name`, which runs from now on.

    Raises
    ------
    InputError
        If another process fits this skin already.
    """
    status = [*(Field(each, "<i8", (1,)) for each in COUNTERS), NOTES]
    description = {"skinfield_fit": VERSION, "name": name, "patches": list(patches)}
    fields = slot_fields(len(patches), nodes, rows)
    ring = Ring.create(fit_name(name), fields, status, description, SLOTS, LOG_BYTES)
    ring.set_state(State.RUNNING)
    return ring


@dataclass(frozen=True, eq=False)
class FitSlot(SlotViews):
    """Views into one slot, or into a copy of it.

    Attributes
    ----------
    told_ns : (1,) int64 array, ns
        When it was published, since the epoch.
    patches : (P,) array of PATCH
    contacts : (P, R) array of CONTACT
    forms : (P, R) array of FORM
        What presses, of each contact.
    pressure : (P, K) float32 array, Pa
        On the finest grid; of patches that are not answered what it was.
    """

    told_ns: Array
    patches: Array
    contacts: Array
    forms: Array
    pressure: Array

    @classmethod
    def of(cls, arrays: Mapping[str, Array]) -> "FitSlot":
        """Name the parts of a slot's arrays."""
        patches = arrays["patches"].view(PATCH)
        contacts = arrays["contacts"].view(CONTACT).reshape(len(patches), -1)
        forms = arrays["forms"].view(FORM).reshape(len(patches), -1)
        return cls(arrays["told_ns"], patches, contacts, forms, arrays["pressure"])

    @classmethod
    def empty(cls, patches: int, nodes: int, rows: int) -> "FitSlot":
        """A slot in memory of its own."""
        return cls.of(empty_arrays(slot_fields(patches, nodes, rows)))

    @property
    def sizes(self) -> FitSizes:
        """Patches, nodes and rows of contacts that it has room for."""
        patches, nodes = self.pressure.shape
        return FitSizes(patches, nodes, self.contacts.shape[1])

    def pressure_of(self, patch: int) -> NDArray[np.float32] | None:
        """Pressure (K,), Pa, of a patch by its number on the finest grid: a copy.

        None if it is not fitted.
        """
        if self.patches["state"][patch] != Fitted.DONE:
            return None
        return np.array(self.pressure[patch])


AGAIN = 0.5  # s between looks for a ring that is not there


class FitReader:
    """Reads what the fit beside a live skin publishes; there need not be one, or not yet.

    Nothing here raises because the fit is missing, was started anew, or has ended: then there is
    no answer of it. For one thread at a time.

    Parameters
    ----------
    name : str
        Of the live skin.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self._reader: RingReader | None = None
        self._looked = -AGAIN
        self._newest: FitSlot | None = None
        self._number = 0  # of the answer that `following` gave last

    def _open(self) -> RingReader | None:
        """The ring as it is now; looked for twice a second while there is none."""
        now = time.monotonic()
        if now - self._looked < AGAIN:
            return self._reader
        self._looked = now
        if self._reader is not None and self._reader.alive and not self._reader.replaced():
            return self._reader
        self.close()
        try:
            reader = RingReader(fit_name(self.name))
        except InputError:  # FileError is one: there is none, or it is being made
            return None
        if not reader.alive or reader.description.get("skinfield_fit") != VERSION:
            reader.close()
            return None
        self._reader = reader
        self._room = reader.slot()
        self._names = tuple(map(str, reader.description["patches"]))
        self._number = max(reader.number - reader.slots // 2, 0)  # the oldest may go at any time
        return reader

    @property
    def names(self) -> tuple[str, ...] | None:
        """Of the patches of the skin that is fitted; None where there is no fit."""
        return None if self._open() is None else self._names

    def latest(self) -> FitSlot | None:
        """The newest answers of all patches, until the next call; None where there are none."""
        reader = self._open()
        if reader is None:
            return None
        if reader.number != (self._room.number if self._newest is not None else 0):
            try:
                copied = reader.latest(self._room)
            except InputError:  # overtaken, or damaged: the next call tries again
                return self._newest
            self._newest = None if copied is None else FitSlot.of(copied.arrays)
        return self._newest

    def following(self) -> Iterator[tuple[int, FitSlot | None]]:
        """Numbers and answers since the last call, each of them until the next one.

        It begins with some that are still there. None for an answer that was overwritten before it
        was read, or is damaged.
        """
        reader = self._open()
        if reader is None:
            return
        newest = reader.number
        if newest < self._number:
            self._number = 0
        oldest = newest - reader.slots
        if self._number < oldest:  # of many one word is enough
            self._number = oldest
            yield oldest, None
        while self._number < newest:
            self._number += 1
            copied = reader.get(self._number, self._room)
            yield self._number, None if copied is None else FitSlot.of(copied.arrays)

    def pressure(self, patch: int) -> NDArray[np.float32] | None:
        """Pressure (K,), Pa, of a patch by its number on the finest grid; None if not fitted.

        Of the answer that the newest `latest` gave; a copy.
        """
        return None if self._newest is None else self._newest.pressure_of(patch)

    def status(self) -> dict[str, Any]:
        """What the fit does: `phase`, notes, counts; empty where there is none."""
        reader = self._open()
        if reader is None:
            return {}
        view = reader.status_view
        counts = {key: int(view[key][0]) for key in COUNTERS}
        return {**(read_notes(view["notes"]) or {}), **counts, "pid": reader.pid}

    def close(self) -> None:
        """Let go of the ring."""
        if self._reader is not None:
            self._reader.close()
        self._reader, self._newest = None, None


NEAR = 10e-3  # m from a contact of the engine, whose place is less sure
RECENT_NS = 400_000_000  # that a fit may be behind the reading, or before it
RESTING_NS = 2_000_000_000  # the same, of a touch that rests
SAME_PLACE, SAME_FORCE = 4e-3, 0.5  # m; part of the larger: what the engine takes for the same
Rows = NDArray[np.void]


def best_contacts(snapshot: Snapshot, fit: FitReader | None) -> tuple[Rows, list[str]]:
    """Contacts of a snapshot, with those of the fit's newest answer in their place: `best_of`."""
    return best_of(snapshot, None if fit is None else fit.latest())


def best_of(snapshot: Snapshot, found: FitSlot | None) -> tuple[Rows, list[str]]:
    """Contacts of a snapshot, with those of a fit in their place where it is recent.

    Of a patch that the fit answered within 0.4 s of the snapshot's reading, the fit's contacts
    count, and those of the engine that began since, 10 mm away or more. They end with the touch:
    where the engine sees nothing any more of what it saw then, neither does this. While the engine
    sees what it saw then, at about the same place and about as strong, the fit may be up to 2 s
    behind: a busy machine.

    Parameters
    ----------
    snapshot : Snapshot
    found : FitSlot or None
        What the fit had found by then. None, or one of another skin: all is as the engine says.

    Returns
    -------
    (N,) array of CONTACT
        Patch after patch.
    list of str
        Of each row who says it: "fit" or "engine".
    """
    engine = snapshot.contacts
    if found is None or len(found.patches) != len(snapshot.patches):
        return engine, ["engine"] * len(engine)
    recent = recent_patches(snapshot, found)
    rows: list[Rows] = []
    by: list[str] = []
    for patch in range(len(snapshot.patches)):
        own = engine[engine["patch"] == patch]
        if recent[patch]:
            told = found.patches[patch]
            fitted = found.contacts[patch][: int(told["contacts"])]
            since = (int(snapshot.patches["stamp_ns"][patch]) - int(told["stamp_ns"])) * 1e-9
            own = own[(own["age"] < since) & _apart(own, fitted)]
            rows.append(fitted)
            by += ["fit"] * len(fitted)
        rows.append(own)
        by += ["engine"] * len(own)
    return np.concatenate(rows) if rows else np.zeros(0, CONTACT), by


def _apart(own: Rows, fitted: Rows) -> NDArray[np.bool_]:
    """Which of the engine's contacts are none of those that were fitted under another number."""
    off = [own[axis][:, None] - fitted[axis][None] for axis in ("x", "y")]
    near = (np.hypot(*off) < NEAR).any(axis=1)
    return np.asarray(~near & ~np.isin(own["track"], fitted["track"]))


def recent_patches(snapshot: Snapshot, found: FitSlot) -> NDArray[np.bool_]:
    """Which patches (P,) the fit answers for the reading of a snapshot."""
    now, told = snapshot.patches, found.patches
    apart = np.abs(now["stamp_ns"] - told["stamp_ns"])
    answered = now["answer"] != int(Answer.MISSING)
    touched = (now["answer"] >= int(Answer.LINEAR)) | (now["contacts"] > 0)
    there = touched | (told["touched"] == 0)
    young = apart <= RECENT_NS
    for patch in np.flatnonzero(~young & (apart <= RESTING_NS)):
        own = snapshot.contacts[snapshot.contacts["patch"] == patch]
        young[patch] = len(own) > 0 and _same(told[patch], own)
    recent = (told["state"] == int(Fitted.DONE)) & young & answered & there
    return np.asarray(recent, dtype=np.bool_)


def _same(told: np.void, own: Rows) -> bool:
    """Whether the engine sees on a patch what it saw when the fit answered."""
    force, before = float(own["normal_force"].sum()), float(told["engine_force"])
    moved = np.hypot(own["x"][0] - told["engine_x"], own["y"][0] - told["engine_y"])
    as_strong = abs(force - before) <= SAME_FORCE * max(force, before)
    return bool(len(own) == told["engine_contacts"] and moved <= SAME_PLACE and as_strong)
