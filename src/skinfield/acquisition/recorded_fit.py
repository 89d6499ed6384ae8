"""What a recording holds of a contact fit beside the engine: one message for each of its answers.

A message of `/skin/fit` tells all that the fit knew of the skin at one time, so that the newest one
before any moment is enough. It has a head as `FIT_HEAD`, then of each patch of which it knows
something the place in the skin and how many nodes have pressure (uint32 each), then rows of
patches, contacts and forms of a layout that the channel's metadata states, then the nodes (uint32)
and their pressure (float32, Pa) of one patch after the other. Patches that are not in it are left
to the engine; a message without any ends what was before. All numbers are little-endian.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from struct import Struct
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition.recorded import Rows, fields_of, fields_text, is_plain
from skinfield.errors import InputError

VERSION = 1
FITS = "/skin/fit"
FIT_HEAD = Struct("<HHIqqIIIIIIII")
MOST_PATCHES, MOST_NODES, MOST_ROWS = 1 << 16, 1 << 20, 1 << 10  # whatever says more is damaged
Words = NDArray[np.uint32]


class FitSizes(NamedTuple):
    """Of the skin that a fit is for.

    Attributes
    ----------
    patches : int
    nodes : int
        Of the finest grid of a patch.
    rows : int
        Contacts of a patch, at most.
    """

    patches: int
    nodes: int
    rows: int


@dataclass(frozen=True, eq=False)
class FitRecord:
    """What a fit had found of a whole skin.

    Attributes
    ----------
    time_ns : int, ns
        When it published that, since the epoch.
    number : int
        Of the answer, which each fit counts from 1; 0 where there is no fit any more.
    sizes : FitSizes
    places : (Q,) uint32 array
        Patches that it says something of, rising.
    pressed : (Q,) uint32 array
        How many nodes of each have pressure.
    patches : (Q,) structured array
        With a field `contacts`: how many each has.
    contacts, forms : (N,) structured arrays
        Patch after patch.
    nodes : (M,) uint32 array
        With pressure, patch after patch.
    pressure : (M,) float32 array, Pa
        Of these.
    """

    time_ns: int
    number: int
    sizes: FitSizes
    places: Words
    pressed: Words
    patches: Rows
    contacts: Rows
    forms: Rows
    nodes: Words
    pressure: NDArray[np.float32]


@dataclass(frozen=True)
class FitLayout:
    """Fields of the rows within a fit's record.

    Parameters
    ----------
    patch, contact, form : dtype
        Structured, of plain numbers and arrays of them, without gaps; `patch` with the integer
        field `contacts`.
    """

    patch: np.dtype[Any]
    contact: np.dtype[Any]
    form: np.dtype[Any]

    def __post_init__(self) -> None:
        for name, rows in vars(self).items():
            if not is_plain(rows):
                raise InputError(f"{name} is {rows}, expected a structured dtype of plain numbers")
        counted = "contacts" in (self.patch.names or ()) and self.patch["contacts"].kind in "iu"
        if not counted:
            raise InputError(f"patch is {self.patch}, expected an integer field `contacts` in it")

    def encode(self, record: FitRecord) -> bytes:
        """Bytes of a record; `decode` gives the same back.

        Raises
        ------
        InputError
            If its rows are of other fields, or its parts do not go together.
        """
        rows = (record.patches, record.contacts, record.forms)
        kinds = (self.patch, self.contact, self.form)
        if tuple(part.dtype for part in rows) != kinds:
            raise InputError(
                f"rows are {[part.dtype for part in rows]}, expected {list(kinds)}: those that the "
                "recording began with"
            )
        _check(record)
        head = FIT_HEAD.pack(
            VERSION,
            FIT_HEAD.size,
            record.sizes.patches,
            record.time_ns,
            record.number,
            record.sizes.nodes,
            record.sizes.rows,
            len(record.patches),
            self.patch.itemsize,
            len(record.contacts),
            self.contact.itemsize,
            self.form.itemsize,
            len(record.nodes),
        )
        words = (np.asarray(each, "<u4") for each in (record.places, record.pressed))
        field = (np.asarray(record.nodes, "<u4"), np.asarray(record.pressure, "<f4"))
        return b"".join((head, *(each.tobytes() for each in (*words, *rows, *field))))

    def decode(self, data: bytes | memoryview) -> FitRecord:
        """Record of a message.

        Raises
        ------
        InputError
            If it is of another version or layout, its length is not what its head says, or its
            parts do not go together.
        """
        if len(data) < FIT_HEAD.size:
            raise InputError(
                f"a fit's record has {len(data)} bytes, expected {FIT_HEAD.size} or more"
            )
        numbers: tuple[int, ...] = FIT_HEAD.unpack_from(data)
        version, head, whole, time_ns, number, grid, most = numbers[:7]
        patches, patch_bytes, contacts, contact_bytes, form_bytes, nodes = numbers[7:]
        if version != VERSION:
            raise InputError(
                f"a fit's record is of version {version}, expected {VERSION}: it is damaged, or "
                "of a newer program"
            )
        said = (patch_bytes, contact_bytes, form_bytes)
        stated = (self.patch.itemsize, self.contact.itemsize, self.form.itemsize)
        if said != stated:
            raise InputError(
                f"rows of a fit's record have {said} bytes, expected {stated} as the recording "
                "states"
            )
        size = head + patches * (8 + patch_bytes) + contacts * (contact_bytes + form_bytes)
        size += 8 * nodes
        if head < FIT_HEAD.size or size != len(data):
            raise InputError(
                f"a fit's record has {len(data)} bytes, expected {size} as its head says: it is "
                "damaged"
            )
        cut = _Cutter(data, head)
        places, pressed = cut.next("<u4", patches), cut.next("<u4", patches)
        rows = cut.next(self.patch, patches)
        found = cut.next(self.contact, contacts), cut.next(self.form, contacts)
        record = FitRecord(
            time_ns, number, FitSizes(whole, grid, most), places, pressed, rows, *found,
            cut.next("<u4", nodes), cut.next("<f4", nodes),
        )  # fmt: skip
        _check(record)
        return record

    def metadata(self) -> dict[str, str]:
        """For the channel: fields as JSON, ``[[name, type], ...]`` or ``[name, type, shape]``."""
        return {name: fields_text(rows) for name, rows in vars(self).items()}

    @classmethod
    def from_metadata(cls, metadata: Mapping[str, str]) -> "FitLayout":
        """Layout that a channel states.

        Raises
        ------
        InputError
            If it states none that can be used.
        """
        try:
            return cls(*(fields_of(metadata[name]) for name in ("patch", "contact", "form")))
        except (KeyError, TypeError, ValueError, RecursionError) as error:
            raise InputError(
                f"the channel {FITS} states {dict(metadata)!r:.200}, expected the fields of patch, "
                f"contact and form as JSON: {error}"
            ) from error


class _Cutter:
    """Arrays of a message, one after the other."""

    def __init__(self, data: bytes | memoryview, at: int) -> None:
        self._data, self._at = data, at

    def next(self, kind: Any, count: int) -> NDArray[Any]:
        found = np.frombuffer(self._data, kind, count, self._at)
        self._at += found.nbytes
        return found


def _check(record: FitRecord) -> None:
    """Raise InputError unless the parts of a record go together."""
    sizes, places, counts = record.sizes, record.places, record.patches["contacts"]
    limits = (MOST_PATCHES, MOST_NODES, MOST_ROWS)
    if any(not 0 < size <= most for size, most in zip(sizes, limits, strict=True)):
        raise InputError(
            f"a fit's record is of {sizes.patches} patches with {sizes.nodes} nodes and "
            f"{sizes.rows} contacts each, expected 1 to {limits}: it is damaged"
        )
    rising = (np.diff(places.astype(np.int64)) > 0).all() and (places < sizes.patches).all()
    if not rising or len(places) != len(record.patches):
        raise InputError(
            f"a fit's record tells of the patches {places[:8].tolist()}, expected rising numbers "
            f"below {sizes.patches}: it is damaged"
        )
    there = len(record.contacts), len(record.forms)
    total = int(counts.sum(dtype=np.int64))
    if ((counts < 0) | (counts > sizes.rows)).any() or there != (total, total):
        raise InputError(
            f"a fit's record has {there} contacts and forms, expected as many as its patches "
            f"({counts[:8].tolist()}), each with {sizes.rows} at most: it is damaged"
        )
    pressed = int(record.pressed.sum(dtype=np.int64))
    known = (record.nodes < sizes.nodes).all() and len(record.pressed) == len(places)
    if not known or not len(record.nodes) == len(record.pressure) == pressed:
        raise InputError(
            f"a fit's record has pressure on {len(record.nodes)} nodes, expected {pressed} below "
            f"{sizes.nodes} as its patches say: it is damaged"
        )
