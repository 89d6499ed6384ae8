"""Slot of a live skin's ring: one cycle, with everything that a reader may want of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from skinfield.estimate.live_contacts import CONTACT as CONTACT
from skinfield.files.mcap.schema import Cycle as Recorded
from skinfield.files.mcap.schema import CycleFlag, CycleLayout
from skinfield.reconstruct.engine.state import Answer
from skinfield.ring import Field
from skinfield.ring.layout import LINE, Span, place
from skinfield.ring.reader import Slot as Copy
from skinfield.skin import Skin

Array = NDArray[Any]


class CycleHead(IntEnum):
    """Numbers of a cycle; the index into the slot's `head`."""

    FLAGS = 0  # of `CycleFlag`
    DUE_NS = 1  # by the monotonic clock: when it should have begun
    WAKE_NS = 2  # when it began
    ACQUIRED_NS = 3  # when all readings that waited were taken in
    READY_NS = 4  # when the answer was complete, before it was published
    WALL_NS = 5  # since the epoch, when it began
    LOG_POSITION = 6  # bytes of the log that were applied before it was answered
    MESSAGES = 7  # taken in
    FRESH = 8  # patches with a new reading
    CONTACTS = 9  # on all patches, of the newest answers
    BUDGET_NS = 10  # that the reconstruction had; 0 of a replay
    GENERATION = 11  # of the engine's process, as the ring counts them: 1 for the first


PATCH = np.dtype(
    [
        ("answer", "<i4"),  # an `Answer`: 0 missing, 1 idle, 2 linear, 3 a field, 4 contacts
        ("rung", "<i4"),  # nodes along the sides of the grid; 0: none
        ("fresh", "<i4"),  # taxels read since the cycle before; 0: the answer is an earlier one
        ("invalid", "<i4"),  # taxels that were left out
        ("iterations", "<i4"),
        ("contacts", "<i4"),
        ("gap", "<f8"),  # relative duality gap; NaN: not known
        ("stamp_ns", "<i8"),  # of the newest reading in it, since the epoch; 0: none yet
        ("answered_ns", "<i8"),  # since the epoch: of the cycle in which it was answered
        ("force", "<f8"),  # N, along the normals, of all contacts
        ("peak_pressure", "<f8"),  # Pa
        ("tracks", "<i8"),  # contacts numbered so far, on the whole skin
        ("readings", "<i8"),  # that were averaged, as nothing moved; 1: the newest alone
    ]
)


LAYOUT = CycleLayout(CONTACT, PATCH)  # of what a recording keeps of a cycle


@dataclass(frozen=True)
class Sizes:
    """What decides the layout of a slot.

    Attributes
    ----------
    patches, taxels, nodes : int
        Of the skin; the last of the finest grid of a patch.
    rows : int
        Contacts per patch, at most.
    """

    patches: int
    taxels: int
    nodes: int
    rows: int

    @classmethod
    def of(cls, skin: Skin, rungs: Sequence[int], rows: int) -> "Sizes":
        """Sizes of a skin's slots."""
        return cls(len(skin), sum(map(len, skin)), max(rungs) ** 2, rows)

    def fields(self) -> list[Field]:
        """Arrays of a slot; records are bytes, see `PATCH` and `CONTACT`."""
        return [
            Field("head", "<i8", (len(CycleHead),)),
            Field("patches", "<u1", (self.patches * PATCH.itemsize,)),
            Field("contacts", "<u1", (self.patches * self.rows * CONTACT.itemsize,)),
            Field("counts", "<f4", (self.taxels,)),
            Field("values", "<f4", (self.taxels,)),
            Field("valid", "<u1", (self.taxels,)),
            Field("pressure", "<f4", (self.patches, self.nodes)),
        ]


def empty_arrays(fields: Sequence[Field]) -> dict[str, Array]:
    """Arrays of a slot in memory of its own, by their names."""
    return {each.name: np.zeros(each.shape, np.dtype(each.dtype)) for each in fields}


class SlotViews:
    """Dataclass of views into a slot."""

    def copy_from(self, other: Self) -> None:
        """Take over all that another holds."""
        for name, array in vars(self).items():
            np.copyto(array, getattr(other, name))


@dataclass(frozen=True, eq=False)
class CycleSlot(SlotViews):
    """Views into one slot, or into a copy of it.

    Attributes
    ----------
    head : (len(Head),) int64 array
    patches : (P,) array of PATCH
    contacts : (P, R) array of CONTACT
        As many of each row as the patch's `contacts` says.
    counts : (L,) float32 array
        The newest, in the unit of the ports; NaN where nothing came.
    values : (L,) float32 array
        What the taxels read, in the quantity's unit; 0 where not valid.
    valid : (L,) uint8 array
    pressure : (P, K) float32 array, Pa
        As many of each row as the patch's grid has nodes; an idle or missing patch has none.
    contact_words : (P, R words) int64 array
        The memory of `contacts`.
    """

    head: Array
    patches: Array
    contacts: Array
    counts: Array
    values: Array
    valid: Array
    pressure: Array
    contact_words: Array

    @classmethod
    def of(cls, arrays: Mapping[str, Array]) -> "CycleSlot":
        """Name the parts of a slot's arrays."""
        patches = arrays["patches"].view(PATCH)
        contacts = arrays["contacts"].view(CONTACT).reshape(len(patches), -1)
        names = ("head", "counts", "values", "valid", "pressure")
        plain = {name: arrays[name] for name in names}
        words = arrays["contacts"].view(np.int64).reshape(len(patches), -1)
        return cls(patches=patches, contacts=contacts, contact_words=words, **plain)

    @classmethod
    def empty(cls, sizes: Sizes) -> "CycleSlot":
        """A slot in memory of its own."""
        return cls.of(empty_arrays(sizes.fields()))

    def used_contacts(self) -> Array:
        """Rows of the contacts that there are, patch after patch: a copy."""
        counts = np.minimum(self.patches["contacts"], self.contacts.shape[1])
        used: Array = self.contacts[np.arange(self.contacts.shape[1]) < counts[:, None]]
        return used

    def recorded(self, number: int) -> Recorded:
        """The cycle as a recording keeps it."""
        flags, due, wake, acquired, ready, wall, position = self.head[: CycleHead.MESSAGES].tolist()
        times = due, wake, acquired, ready, wall
        rows = self.used_contacts(), self.patches.copy()
        return Recorded(number, CycleFlag(flags), *times, position, *rows)


class SlotLayout(NamedTuple):
    """Places of the arrays in the bytes of a slot, and how many bytes it has."""

    fields: tuple[Span, ...]
    size: int

    @classmethod
    def of(cls, fields: Sequence[Field]) -> "SlotLayout":
        """Of a slot with these arrays, in their order."""
        return cls(*place("slot", fields, LINE))

    def slot(self, octets: bytes | None = None) -> CycleSlot:
        """A slot in memory of its own, of the bytes of another; else of zeros."""
        copy = Copy(self.fields, self.size)
        if octets is not None:
            copy.octets[:] = np.frombuffer(octets, np.uint8)
        return CycleSlot.of(copy.arrays)


def say_nothing(slot: CycleSlot, tracks: int) -> None:
    """Say, while an engine starts, that all patches are missing; contacts go on from `tracks`."""
    slot.patches[:] = np.zeros((), slot.patches.dtype)
    slot.patches["answer"] = int(Answer.MISSING)
    slot.patches["gap"] = np.nan
    slot.patches["tracks"] = tracks
    slot.head[CycleHead.FLAGS] = slot.head[CycleHead.FRESH] = slot.head[CycleHead.CONTACTS] = 0
    slot.values[:] = 0.0
    slot.valid[:] = 0
