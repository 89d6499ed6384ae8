"""The ring in which fitted contacts are published beside a live skin's own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition.recorded_fit import FitLayout, FitSizes
from skinfield.contacts.live import CONTACT
from skinfield.live.notes import FIELD as NOTES
from skinfield.ring import Field

Array = NDArray[Any]
VERSION = 2
SUFFIX = ".fit"
SLOTS = 16
LOG_BYTES = 1 << 12  # nothing is logged
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


def status_fields() -> list[Field]:
    """Counters, and words: what it does now."""
    return [
        Field("fits", "<i8", (1,)),
        Field("unhelpful", "<i8", (1,)),
        Field("cpu_ns", "<i8", (1,)),
        NOTES,
    ]


def describe(name: str, patches: Sequence[str]) -> dict[str, object]:
    """What readers must know."""
    return {
        "skinfield_fit": VERSION,
        "name": name,
        "patches": list(patches),
        "states": [each.name.lower() for each in Fitted],
        "shapes": list(SHAPES),
        "patch_row": PATCH.descr,
        "contact_row": CONTACT.descr,
        "form_row": FORM.descr,
    }


@dataclass(frozen=True, eq=False)
class FitSlot:
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
        fields = slot_fields(patches, nodes, rows)
        return cls.of({f.name: np.zeros(f.shape, np.dtype(f.dtype)) for f in fields})

    def copy_from(self, other: "FitSlot") -> None:
        """Take over all that another holds."""
        for part in fields(self):
            np.copyto(getattr(self, part.name), getattr(other, part.name))

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
