"""Layout of the messages of a live skin's recording: readings, cycles and pressure fields.

Sinks write it and sources read it. All numbers are little-endian; stamps are ns.

A message of `/skin/blocks` is 8 bytes, the position of what follows in the ring's log (int64, bytes
since the ring was made), then blocks as `signal.block` describes them, unchanged.

The others begin with a head of the version of this layout (1), its own bytes, and more; the letters
are those of Python's struct.

A message of `/skin/cycles` is one cycle of the engine. Head `<HHI7q6IQ`: version, bytes of the
head, flags (2 late, 4 overrun, 8 first of a new engine process); number, due_ns, wake_ns,
acquired_ns, done_ns (all by the monotonic clock), wall_ns (since the epoch), bytes of the ring's
log of which the blocks were applied; rows and columns of int64 numbers behind the head (0 but in
older files), contacts, bytes of a contact, patches, bytes of a patch; 0. Then contacts and patches,
both rows of a layout that the channel's metadata states, as JSON (`CycleLayout.metadata`).

A message of `/skin/fields` is what a cycle read and answered beside that. Head `<HHIqqIIII`:
version, bytes of the head, patches; when the cycle began, ns since the epoch; its number; taxels,
nodes of the finest grid of a patch, nodes with pressure in this message, 0. Then of each patch the
nodes along the sides of its grid and how many of its nodes have pressure (uint32 each), the nodes
(uint32) and their pressure (float32, Pa) of one patch after the other, and of all taxels counts and
values (float32), and whether they are valid (uint8). Some are written each second, of cycles with
new readings: the newest one before any moment holds.

Older files have a topic `/skin/fit` of contacts that a second process fitted, and rows of contacts
without `shape`, `maybe` and `radius`, of patches without `readings`: the topic is passed over, and
what the rows lack is not known (`ADDED`).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntFlag
from struct import Struct
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError

VERSION = 1
PROFILE = "skinfield"
BLOCKS = "/skin/blocks"
CYCLES = "/skin/cycles"
FIELDS = "/skin/fields"
TIMING = "/skin/timing"
EVENTS = "/skin/events"
LAYOUT = "layout.npz"  # names of attachments
CALIBRATION = "calibration/{patch}.npz"
CONFIGURATION = "configuration.json"
DESCRIPTION = "ring.json"
TARE = "tare-{number}.npz"  # calibration (L, 4), noise_std (L,), stale_ns: as the engine took it
POSITION = Struct("<q")  # before the blocks of a message
CYCLE_HEAD = Struct("<HHI7q6IQ")
FIELD_HEAD = Struct("<HHIqqIIII")
MOST_NODES = 1 << 20  # whatever says more is damaged
MOST_BYTES = 1 << 16  # of a row, likewise
Rows = NDArray[np.void]
Words = NDArray[np.uint32]
Singles = NDArray[np.float32]


class CycleFlag(IntFlag):
    """What is special about a cycle."""

    LATE = 2  # its answer was ready after its deadline
    OVERRUN = 4  # its answer was ready after the next one was due
    RESTARTED = 8  # the first of a new engine process


class Enclosed(NamedTuple):
    """A small file within a recording, with a name such as `LAYOUT`, and its media type."""

    name: str
    media_type: str
    data: bytes


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
    contacts: Rows
    patches: Rows


ADDED: Mapping[str, Sequence[tuple[str, str, float]]] = {  # what older rows lack, and is then taken
    "contact": (
        ("shape", "<i4", 0),
        ("maybe", "<i4", 0),
        ("radius", "<f8", np.nan),
        ("covariance", "(6,)<f8", np.nan),
        ("area_std", "<f8", np.nan),
        ("shear", "(3,)<f8", 0.0),
        ("shear_covariance", "(3,)<f8", np.nan),
    ),
    "patch": (("readings", "<i8", 1),),
}


@dataclass(frozen=True)
class CycleLayout:
    """Fields of the rows within a cycle's record.

    Parameters
    ----------
    contact, patch : dtype
        Structured, of plain numbers without gaps.
    """

    contact: np.dtype[Any]
    patch: np.dtype[Any]

    def __post_init__(self) -> None:
        for name, rows in vars(self).items():
            if not _is_plain(rows):
                raise InputError(f"{name} is {rows}, expected a structured dtype of plain numbers")

    def metadata(self) -> dict[str, str]:
        """For the channel: fields as JSON, ``[[name, type], ...]`` or ``[name, type, shape]``."""
        return {
            name: json.dumps([list(field) for field in rows.descr])
            for name, rows in vars(self).items()
        }

    @classmethod
    def from_metadata(cls, metadata: Mapping[str, str]) -> Self:
        """Layout that a channel states.

        Raises
        ------
        InputError
            If it states none that can be used.
        """
        try:
            return cls(_dtype_of(metadata["contact"]), _dtype_of(metadata["patch"]))
        except Exception as error:  # NumPy has many for what is no type
            raise InputError(
                f"the channel states {dict(metadata)!r:.200}, expected the fields of "
                f"contact, patch as JSON: {error}"
            ) from error

    def completed(self) -> Self:
        """With the fields of `ADDED` that it lacks, as older recordings do."""
        return replace(
            self, **{name: _completed(rows, ADDED[name]) for name, rows in vars(self).items()}
        )

    def extend(self, cycle: Cycle) -> Cycle:
        """The cycle with rows of this layout, which is `completed` of theirs."""
        contacts = _extended(cycle.contacts, self.contact, ADDED["contact"])
        return replace(
            cycle, contacts=contacts, patches=_extended(cycle.patches, self.patch, ADDED["patch"])
        )

    def encode(self, cycle: Cycle) -> bytes:
        """Record of a cycle; `decode` gives the same back.

        Raises
        ------
        InputError
            If its rows are of other fields.
        """
        found, expected = (cycle.contacts.dtype, cycle.patches.dtype), (self.contact, self.patch)
        if found != expected:
            raise InputError(
                f"rows are {found}, expected {expected}: those that the recording began with"
            )
        head = CYCLE_HEAD.pack(
            VERSION, CYCLE_HEAD.size, int(cycle.flags), cycle.number, cycle.due_ns, cycle.wake_ns,
            cycle.acquired_ns, cycle.done_ns, cycle.wall_ns, cycle.log_position, 0, 0,
            len(cycle.contacts), self.contact.itemsize, len(cycle.patches), self.patch.itemsize, 0,
        )  # fmt: skip
        return b"".join((head, cycle.contacts.tobytes(), cycle.patches.tobytes()))

    def decode(self, data: bytes | memoryview) -> Cycle:
        """Cycle of a record; rows and columns of numbers between head and rows are passed over.

        Raises
        ------
        InputError
            If it is of another version or layout, or its length is not what its head says.
        """
        size, flags, *numbers = _head_of("cycle", CYCLE_HEAD, data)
        rows, columns, contacts, contact_bytes, patches, patch_bytes, _ = numbers[7:]
        expected = self.contact.itemsize, self.patch.itemsize
        if (contact_bytes, patch_bytes) != expected:
            raise InputError(
                f"rows of a record have {(contact_bytes, patch_bytes)} bytes, expected {expected} "
                "as the recording states"
            )
        parts = ("<i8", rows * columns), (self.contact, contacts), (self.patch, patches)
        _, *found = _parts("cycle", data, size, *parts)
        number, due, wake, acquired, done, wall, position = numbers[:7]
        return Cycle(
            number, CycleFlag(flags), due, wake, acquired, done, wall, position, *found
        )  # fmt: skip


def _completed(kind: np.dtype[Any], added: Sequence[tuple[str, str, float]]) -> np.dtype[Any]:
    lacking = [(name, its) for name, its, _ in added if name not in (kind.names or ())]
    return np.dtype([*kind.descr, *lacking]) if lacking else kind


def _extended(rows: Rows, kind: np.dtype[Any], added: Sequence[tuple[str, str, float]]) -> Rows:
    if rows.dtype == kind:
        return rows
    made = np.zeros(len(rows), kind)
    for name in rows.dtype.names or ():
        made[name] = rows[name]
    for name, _, value in added:
        if name not in (rows.dtype.names or ()):
            made[name] = value
    return made


def _dtype_of(text: str) -> np.dtype[Any]:
    """Of a channel's metadata; raises whatever NumPy does if it is none."""
    return np.dtype(
        [(str(name), str(kind), *map(tuple, shape)) for name, kind, *shape in json.loads(text)]
    )


def _is_plain(rows: np.dtype[Any]) -> bool:
    """Whether rows are structured, of some plain numbers without gaps."""
    return (
        rows.names is not None
        and all(name and rows[name].base.kind in "iuf" for name in rows.names)
        and 0 < sum(rows[name].itemsize for name in rows.names) == rows.itemsize < MOST_BYTES
    )


def _head_of(what: str, head: Struct, data: bytes | memoryview) -> tuple[int, ...]:
    """Numbers of a record's head behind its version; raises InputError."""
    if len(data) < head.size:
        raise InputError(f"a {what}'s record has {len(data)} bytes, expected {head.size} or more")
    version, size, *numbers = head.unpack_from(data)
    if version != VERSION or size < head.size:
        raise InputError(
            f"a {what}'s record is of version {version} with a head of {size} bytes, expected "
            f"{VERSION} and {head.size} or more: it is damaged, or of a newer program"
        )
    return (size, *numbers)


def _parts(
    what: str, data: bytes | memoryview, at: int, *parts: tuple[Any, int]
) -> list[NDArray[Any]]:
    """Arrays of a record from byte `at` on, by their types and lengths; raises InputError."""
    sizes = [np.dtype(kind).itemsize * count for kind, count in parts]
    if len(data) != at + sum(sizes):
        raise InputError(
            f"a {what}'s record has {len(data)} bytes, expected {at + sum(sizes)} as its head "
            "says: it is damaged"
        )
    found = []
    for (kind, count), size in zip(parts, sizes, strict=True):
        found.append(np.frombuffer(data, kind, count, at))
        at += size
    return found


@dataclass(frozen=True, eq=False)
class FieldRecord:
    """What a cycle read and answered beside contacts and patches; made by `decode`.

    Attributes
    ----------
    time_ns : int, ns
        When the cycle began, since the epoch.
    number : int
        Of the cycle.
    grid : int
        Nodes of the finest grid of a patch.
    sides : (P,) uint32 array
        Nodes along the sides of each patch's grid; 0: none.
    pressed : (P,) uint32 array
        How many nodes of each have pressure.
    nodes : (M,) uint32 array
        With pressure, patch after patch.
    pressure : (M,) float32 array, Pa
        Of these.
    counts, values : (L,) float32 arrays
        Of all taxels: in the unit of the ports, and in the quantity's.
    valid : (L,) uint8 array
    """

    time_ns: int
    number: int
    grid: int
    sides: Words
    pressed: Words
    nodes: Words
    pressure: Singles
    counts: Singles
    values: Singles
    valid: NDArray[np.uint8]

    @classmethod
    def of(
        cls,
        number: int,
        time_ns: int,
        sides: NDArray[Any],
        pressure: Singles,
        taxels: tuple[Singles, Singles, NDArray[np.uint8]],
    ) -> "FieldRecord":
        """Of the pressure (P, K) of a slot, of which a patch's grid has the first side² nodes.

        Parameters
        ----------
        number : int
        time_ns : int, ns
        sides : (P,) int array
        pressure : (P, K) float32 array, Pa
        taxels : tuple of (L,) arrays
            Counts, values, valid.
        """
        inside = np.arange(pressure.shape[1]) < np.asarray(sides)[:, None] ** 2
        patch, nodes = np.nonzero(inside & (pressure != 0))
        return cls(
            time_ns,
            number,
            pressure.shape[1],
            np.asarray(sides, np.uint32),
            np.bincount(patch, minlength=len(sides)).astype(np.uint32),
            nodes.astype(np.uint32),
            pressure[patch, nodes],
            *taxels,
        )

    def encode(self) -> bytes:
        """Bytes of a record; `decode` gives the same back."""
        numbers = self.time_ns, self.number, len(self.counts), self.grid, len(self.nodes), 0
        head = FIELD_HEAD.pack(VERSION, FIELD_HEAD.size, len(self.sides), *numbers)
        parts = self.sides, self.pressed, self.nodes, self.pressure, self.counts, self.values
        kinds = ("<u4",) * 3 + ("<f4",) * 3
        rows = (np.asarray(part, kind) for part, kind in zip(parts, kinds, strict=True))
        return b"".join((head, *(each.tobytes() for each in (*rows, self.valid))))

    @classmethod
    def decode(cls, data: bytes | memoryview) -> "FieldRecord":
        """Record of a message.

        Raises
        ------
        InputError
            If it is of another version, its length is not what its head says, or its parts do not
            go together.
        """
        head, patches, time_ns, number, taxels, grid, nodes, _ = _head_of("field", FIELD_HEAD, data)
        words, fields = (("<u4", patches), ("<u4", patches), ("<u4", nodes)), ("<f4", taxels)
        parts = _parts("field", data, head, *words, ("<f4", nodes), fields, fields, ("u1", taxels))
        record = cls(time_ns, number, grid, *parts)
        limits = record.sides.astype(np.int64) ** 2
        pressed = record.pressed.astype(np.int64)
        if (
            grid > MOST_NODES
            or pressed.sum() != nodes
            or not ((limits >= 0) & (limits <= grid)).all()
            or (record.nodes >= np.repeat(limits, pressed)).any()
        ):
            raise InputError(
                f"a field's record has pressure on {nodes} nodes, expected {pressed.sum()} within "
                f"grids of {grid} nodes at most: it is damaged"
            )
        return record

    def pressure_into(self, out: Singles) -> None:
        """Write the pressure (P, K) of all nodes, 0 where there is none."""
        out[:] = 0.0
        out[np.repeat(np.arange(len(self.sides)), self.pressed), self.nodes] = self.pressure
