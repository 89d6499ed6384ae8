"""What a recording of a live skin holds, and the layout of its binary messages.

Sinks write it and sources read it. All numbers are little-endian; stamps are ns.

A message of `/skin/blocks` is 8 bytes, the position of what follows in the ring's log (int64,
bytes since the ring was made), then blocks as `acquisition.block` describes them, unchanged.

A message of `/skin/cycles` is one cycle of the engine: a head as `CYCLE_HEAD`, then the script
(int64, rows by columns), the contacts and the patches, both rows of a layout that the channel's
metadata states (`CycleLayout.metadata`).
"""

import json
from base64 import b64decode, b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntFlag
from struct import Struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, Ints

VERSION = 1
PROFILE = "skinfield"
BLOCKS = "/skin/blocks"
CYCLES = "/skin/cycles"
TIMING = "/skin/timing"
EVENTS = "/skin/events"
LAYOUT = "layout.npz"  # names of attachments
CALIBRATION = "calibration/{patch}.npz"
CONFIGURATION = "configuration.json"
DESCRIPTION = "ring.json"
TARE = "tare-{number}.npz"  # calibration (L, 4), noise_std (L,), stale_ns: as the engine took it
POSITION = Struct("<q")  # before the blocks of a message
CYCLE_HEAD = Struct("<HHI7q6IQ")
MOST = 1 << 20  # rows of one kind in one cycle: whatever says more is damaged
Rows = NDArray[np.void]


class CycleFlag(IntFlag):
    """What is special about a cycle."""

    KEY = 1  # the engine was reset before it: a replay can start here
    LATE = 2  # its answer was ready after its deadline
    OVERRUN = 4  # its answer was ready after the next one was due
    RESTARTED = 8  # the first of a new engine process


@dataclass(frozen=True)
class Enclosed:
    """A small file within a recording.

    Attributes
    ----------
    name : str
        `LAYOUT`, `CONFIGURATION`, `DESCRIPTION`, or as `CALIBRATION` for a patch.
    media_type : str
    data : bytes
    """

    name: str
    media_type: str
    data: bytes

    def as_json(self) -> dict[str, str]:
        """For a description that is JSON; `from_json` gives the same back."""
        text = b64encode(self.data).decode()
        return {"name": self.name, "media_type": self.media_type, "base64": text}

    @classmethod
    def from_json(cls, value: Any) -> "Enclosed":
        """What `as_json` made; raises InputError for anything else."""
        try:
            data = b64decode(value["base64"], validate=True)
            return cls(str(value["name"]), str(value["media_type"]), data)
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"enclosed is {value!r:.80}, expected name, media_type and base64: {error}"
            ) from error


@dataclass(frozen=True, eq=False)
class Cycle:
    """One cycle of the engine.

    Attributes
    ----------
    number : int
    flags : CycleFlag
    due_ns, wake_ns, acquired_ns, done_ns : int, ns
        When it should have begun, began, had its readings, and was answered; monotonic clock.
    wall_ns : int, ns
        When it began, since the epoch.
    log_position : int, bytes
        Of the ring's log: all blocks before it were applied when the engine answered.
    script : (S, W) int64 array
        What the cycle decided by time; see the engine.
    contacts, patches : (N,) and (P,) structured arrays
        Of the fields of the recording's `CycleLayout`.
    """

    number: int
    flags: CycleFlag
    due_ns: int
    wake_ns: int
    acquired_ns: int
    done_ns: int
    wall_ns: int
    log_position: int
    script: Ints
    contacts: Rows
    patches: Rows


@dataclass(frozen=True)
class CycleLayout:
    """Fields of the rows within a cycle's record.

    Parameters
    ----------
    contact, patch : dtype
        Structured, of plain numbers and arrays of them, without gaps.
    """

    contact: np.dtype[Any]
    patch: np.dtype[Any]

    def __post_init__(self) -> None:
        for name, rows in (("contact", self.contact), ("patch", self.patch)):
            if not is_plain(rows):
                raise InputError(f"{name} is {rows}, expected a structured dtype of plain numbers")

    def encode(self, cycle: Cycle) -> bytes:
        """Record of a cycle; `decode` gives the same back.

        Raises
        ------
        InputError
            If its rows are of other fields, or its script is not (S, W).
        """
        if cycle.contacts.dtype != self.contact or cycle.patches.dtype != self.patch:
            raise InputError(
                f"rows are {cycle.contacts.dtype} and {cycle.patches.dtype}, expected "
                f"{self.contact} and {self.patch}: those that the recording began with"
            )
        if cycle.script.ndim != 2 or cycle.script.dtype != np.int64:
            raise InputError(
                f"script is {cycle.script.dtype} {cycle.script.shape}, expected int64 (S, W)"
            )
        head = CYCLE_HEAD.pack(
            VERSION,
            CYCLE_HEAD.size,
            int(cycle.flags),
            cycle.number,
            cycle.due_ns,
            cycle.wake_ns,
            cycle.acquired_ns,
            cycle.done_ns,
            cycle.wall_ns,
            cycle.log_position,
            *cycle.script.shape,
            len(cycle.contacts),
            self.contact.itemsize,
            len(cycle.patches),
            self.patch.itemsize,
            0,
        )
        parts = (cycle.script, cycle.contacts, cycle.patches)
        return b"".join((head, *(part.tobytes() for part in parts)))

    def decode(self, data: bytes | memoryview) -> Cycle:
        """Cycle of a record.

        Raises
        ------
        InputError
            If it is of another version or layout, or its length is not what its head says.
        """
        if len(data) < CYCLE_HEAD.size:
            raise InputError(
                f"a cycle's record has {len(data)} bytes, expected {CYCLE_HEAD.size} or more"
            )
        numbers: tuple[int, ...] = CYCLE_HEAD.unpack_from(data)
        version, head, flags = numbers[:3]
        times = numbers[3:10]
        rows, columns, contacts, contact_bytes, patches, patch_bytes, _ = numbers[10:]
        if version != VERSION:
            raise InputError(
                f"a cycle's record is of version {version}, expected {VERSION}: it is damaged, or "
                "of a newer program"
            )
        if (contact_bytes, patch_bytes) != (self.contact.itemsize, self.patch.itemsize):
            raise InputError(
                f"rows of a cycle have {contact_bytes} and {patch_bytes} bytes, expected "
                f"{self.contact.itemsize} and {self.patch.itemsize} as the recording states"
            )
        sizes = (8 * rows * columns, contacts * contact_bytes, patches * patch_bytes)
        if max(rows, columns, contacts, patches) > MOST or head + sum(sizes) != len(data):
            raise InputError(
                f"a cycle's record has {len(data)} bytes, expected {head + sum(sizes)} as its head "
                "says: it is damaged"
            )
        at = head
        script = np.frombuffer(data, "<i8", rows * columns, at).reshape(rows, columns)
        at += sizes[0]
        contact_rows = np.frombuffer(data, self.contact, contacts, at)
        patch_rows = np.frombuffer(data, self.patch, patches, at + sizes[1])
        number, due, wake, acquired, done, wall, position = times
        return Cycle(
            number, CycleFlag(flags), due, wake, acquired, done, wall, position,
            script, contact_rows, patch_rows,
        )  # fmt: skip

    def metadata(self) -> dict[str, str]:
        """For the channel: fields as JSON, ``[[name, type], ...]`` or ``[name, type, shape]``."""
        return {"contact": fields_text(self.contact), "patch": fields_text(self.patch)}

    @classmethod
    def from_metadata(cls, metadata: Mapping[str, str]) -> "CycleLayout":
        """Layout that a channel states.

        Raises
        ------
        InputError
            If it states none that can be used.
        """
        try:
            return cls(*(fields_of(metadata[name]) for name in ("contact", "patch")))
        except (KeyError, TypeError, ValueError, RecursionError) as error:
            raise InputError(
                f"the channel states {dict(metadata)!r:.200}, expected the fields of contact and "
                f"patch as JSON: {error}"
            ) from error


def fields_text(rows: np.dtype[Any]) -> str:
    """Fields of rows as JSON, for a channel's metadata."""
    return json.dumps([list(field) for field in rows.descr])


def fields_of(text: str) -> np.dtype[Any]:
    """What `fields_text` made; raises ValueError and TypeError for anything else."""
    fields = []
    for name, kind, *shape in json.loads(text):
        if not isinstance(kind, str) or np.dtype(kind).kind not in "iuf" or len(shape) > 1:
            raise ValueError(f"field {name!r} is {kind!r}, expected a plain number")
        sizes = tuple(int(size) for size in shape[0]) if shape else ()
        if any(not 0 < size <= 64 for size in sizes) or len(sizes) > 2:
            raise ValueError(f"field {name!r} has shape {sizes}, expected a small one")
        fields.append((str(name), kind, sizes))
    return np.dtype(fields)


def is_plain(rows: np.dtype[Any]) -> bool:
    """Whether rows are structured, of plain numbers without gaps."""
    return (
        rows.names is not None
        and all(name and rows[name].base.kind in "iuf" for name in rows.names)
        and sum(rows[name].itemsize for name in rows.names) == rows.itemsize
    )
