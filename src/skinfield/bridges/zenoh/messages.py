"""Messages of the zenoh bridge: estimates, descriptions, calibrations and contacts as bytes."""

import hashlib
import struct
from collections.abc import Mapping
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

import msgspec
import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, InputError
from skinfield.loop import Answer
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.slots import CONTACT, Sizes, Slot
from skinfield.reconstruct.serialisation import plain_from_value, value_from_plain
from skinfield.ring import Field
from skinfield.ring.layout import LINE, Placed, place
from skinfield.ring.reader import Slot as Copy
from skinfield.skin import Skin

VERSION = 1
MAGIC = b"SKE1"
MOST_JSON = 1 << 26  # bytes of a description; most of it is the layout
MOST_STATUS = 1 << 20  # bytes of what comes again and again
MOST_SLOT = 1 << 28  # bytes of an estimate
MOST_NODES, MOST_ROWS, MOST_PATCHES = 1024, 4096, 1 << 14
_HEAD = struct.Struct("<4sIQqqQQ16s")
Array = NDArray[Any]
Whole = Annotated[int, Meta(ge=0, lt=1 << 62)]
Far = Annotated[float, Meta(ge=-1e3, le=1e3)]  # m or N
Large = Annotated[float, Meta(ge=-1e12, le=1e12)]
T = TypeVar("T")


class EstimateHead(NamedTuple):
    """Attachment of an estimate, of the contacts and of raw readings: 64 bytes, little-endian.

    Attributes
    ----------
    generation : int
        Of the engine's process: one more after each restart.
    number : int
        Of the cycle.
    stamp_ns : int, ns
        Of the newest reading in it, since the epoch, by the clock of the engine's computer.
    sent_ns : int, ns
        When it was sent, by the same clock.
    tares : int
        Baselines taken so far.
    instance : int
        Chosen by chance by each publisher when it starts.
    fingerprint : bytes
        Of the description which this fits, see `fingerprint_of`.
    """

    generation: int
    number: int
    stamp_ns: int
    sent_ns: int
    tares: int
    instance: int
    fingerprint: bytes

    def packed(self) -> bytes:
        """As an attachment."""
        return _HEAD.pack(MAGIC, *self)

    @classmethod
    def of(cls, data: bytes) -> "EstimateHead":
        """Undo `packed`.

        Raises
        ------
        InputError
            For anything else.
        """
        if len(data) != _HEAD.size or data[:4] != MAGIC:
            raise InputError(
                f"attachment is {data[:8]!r}, {len(data)} bytes, expected {_HEAD.size} that begin "
                f"with {MAGIC!r}"
            )
        return cls(*_HEAD.unpack(data)[1:])


def newest_stamp(slot: Slot) -> int:
    """Of the newest reading in a cycle, ns since the epoch; 0 where none came yet."""
    return int(slot.patches["stamp_ns"].max(initial=0))


def strict_json(plain: Any) -> bytes:
    """JSON as others read it: what is not finite becomes null."""
    return msgspec.json.encode(plain)


def decoded(kind: type[T], data: bytes, most: int) -> T:
    """A message from others, with every member of its kind.

    Raises
    ------
    InputError
        If it is something else, or longer than `most` bytes.
    """
    if len(data) > most:
        raise InputError(f"a message has {len(data)} bytes, expected at most {most}")
    try:
        return msgspec.json.decode(data, type=kind)
    except (msgspec.DecodeError, RecursionError, ValueError) as error:
        raise InputError(
            f"a message is {data[:40]!r}, expected what skinfield sends: {error}; is the same "
            "skinfield on all computers?"
        ) from error


def fingerprint_of(description: bytes) -> bytes:
    """The first 16 bytes of SHA-256 of a description as it was sent."""
    return hashlib.sha256(description).digest()[:16]


def described(robot: str, part: str, ring: Mapping[str, Any], fields: tuple[Field, ...]) -> bytes:
    """The description that others ask for: that of the ring, and what a slot holds.

    Not how the boards are connected: that is nobody's business elsewhere.
    """
    placed, size = place("slot", fields, LINE)
    return strict_json(
        {
            "skinfield_zenoh": VERSION,
            "robot": robot,
            "part": part,
            "slot_bytes": size,
            "slot": [
                {
                    "name": each.field.name,
                    "dtype": each.field.dtype,
                    "shape": list(each.field.shape),
                    "offset": each.offset,
                }
                for each in placed
            ],
            "ring": {key: value for key, value in ring.items() if key != "source_settings"},
        }
    )


class _PlacedField(Struct):
    name: str
    offset: int
    dtype: str


class _Ring(Struct):
    model_config: str


class _Description(Struct):
    """What `described` makes, as far as it is read."""

    skinfield_zenoh: int
    slot_bytes: int
    slot: list[_PlacedField]
    ring: _Ring


class Plan(NamedTuple):
    """How estimates of one engine are read, from its description.

    Attributes
    ----------
    model_config : ModelConfig
    fingerprint : bytes
    fields : tuple of Placed
        Of a slot.
    slot_bytes : int
    """

    model_config: ModelConfig
    fingerprint: bytes
    fields: tuple[Placed, ...]
    slot_bytes: int

    @classmethod
    def of(cls, data: bytes) -> "Plan":
        """Of a description that came from elsewhere.

        Raises
        ------
        InputError
            If it makes no sense, or is of another version.
        """
        message = decoded(_Description, data, MOST_JSON)
        if message.skinfield_zenoh != VERSION:
            raise InputError(
                f"the description is of version {message.skinfield_zenoh}, expected {VERSION}: the "
                "same skinfield on all computers"
            )
        model_config = ModelConfig.from_json(message.ring.model_config)
        fields, size = place("slot", _sizes(model_config).fields(), LINE)
        own = [_PlacedField(each.field.name, each.offset, each.field.dtype) for each in fields]
        if message.slot_bytes != size or message.slot != own:
            raise InputError(
                f"slots have {message.slot_bytes} bytes, expected {size} of "
                f"{', '.join(each.name for each in own)}: is it another skinfield?"
            )
        return cls(model_config, fingerprint_of(data), fields, size)

    def slot(self, data: bytes) -> Slot:
        """The slot of these octets, checked.

        Raises
        ------
        InputError
            If they are no cycle of this engine.
        """
        if len(data) != self.slot_bytes:
            raise InputError(f"an estimate has {len(data)} bytes, expected {self.slot_bytes}")
        copy = Copy(self.fields, self.slot_bytes)
        copy.octets[:] = np.frombuffer(data, np.uint8)
        slot = Slot.of(copy.arrays)
        check_slot(slot, self.model_config)
        return slot

    def empty(self) -> Slot:
        """A slot in which every patch is missing."""
        return Slot.of(Copy(self.fields, self.slot_bytes).arrays)


def _sizes(model_config: ModelConfig) -> Sizes:
    """Sizes of a configuration's slots, within reason: whoever sent it may have meant ill."""
    rungs, rows = model_config.rungs, model_config.rows
    good = isinstance(rungs, tuple) and rungs and all(type(each) is int for each in rungs)
    if not good or not 2 <= min(rungs) <= max(rungs) <= MOST_NODES or len(rungs) > 64:
        raise FileError(f"rungs are {rungs!r:.80}, expected 2 to {MOST_NODES} nodes on a side")
    if type(rows) is not int or not 1 <= rows <= MOST_ROWS:
        raise FileError(f"rows is {rows!r:.40}, expected 1 to {MOST_ROWS}")
    patches = len(model_config.skin)
    taxels = sum(len(patch) for patch in model_config.skin)
    if patches > MOST_PATCHES or 4 * patches * max(rungs) ** 2 + 32 * taxels > MOST_SLOT:
        raise FileError(f"the skin has {patches} patches and {taxels} taxels, expected fewer")
    return Sizes.of(model_config.skin, rungs, rows)


def check_slot(slot: Slot, model_config: ModelConfig) -> None:
    """Raise InputError unless what a slot says can be: numbers of patches, grids and contacts."""
    patches, rows = slot.patches, slot.contacts.shape[1]
    answers = patches["answer"]
    _check("answers", (answers >= 0) & (answers < len(Answer)))
    _check("grids", np.isin(patches["rung"], (0, *model_config.rungs)))
    _check("counts of contacts", (patches["contacts"] >= 0) & (patches["contacts"] <= rows))
    _check("stamps", (patches["stamp_ns"] >= 0) & (patches["stamp_ns"] < 1 << 62))
    _check("forces", np.isfinite(patches["force"]))
    _check("head", (slot.head >= -(1 << 62)) & (slot.head < 1 << 62))
    _check("validity", slot.valid <= 1)
    _check("pressure", np.isfinite(slot.pressure))
    _check("readings", np.isfinite(slot.values))
    used = slot.used_contacts()
    _check("patches of contacts", (used["patch"] >= 0) & (used["patch"] < len(patches)))
    for name in ("position", "normal", "x", "y", "normal_force"):
        _check(f"{name} of contacts", np.isfinite(used[name]))


def _check(what: str, good: Array) -> None:
    if not good.all():
        raise InputError(f"{what} of an estimate cannot be, expected those of a live skin")


class Calibration(Struct, frozen=True, eq=False):
    """What changes while a ring stays, and decides what follows from a pressure.

    Attributes
    ----------
    tares : int
        Baselines taken so far.
    generation : int
        Of the engine's process.
    solver : Solver or None
        None: that of the model configuration.
    noise_std : (L,) array
        In the quantity's unit.
    """

    tares: int
    generation: int
    solver: Any
    noise_std: Floats

    def packed(self) -> bytes:
        """As JSON."""
        solver = None if self.solver is None else plain_from_value("solver", self.solver)
        plain = {"tares": self.tares, "generation": self.generation, "solver": solver}
        return strict_json(plain | {"noise_std": self.noise_std.tolist()})

    @classmethod
    def of(cls, data: bytes, taxels: int) -> "Calibration":
        """Undo `packed`, of a skin with so many taxels.

        Raises
        ------
        InputError
            If it makes no sense.
        """
        message = decoded(_Calibration, data, MOST_JSON)
        if len(message.noise_std) != taxels:
            raise InputError(f"a calibration has no noise of {taxels} taxels, expected that")
        solver = value_from_plain("solver", message.solver)
        good = isinstance(message.solver, dict) and callable(getattr(solver, "prepare", None))
        if not good and message.solver is not None:
            raise InputError(f"a solver is {message.solver!r:.60}, expected one of skinfield's")
        noise_std = np.array(message.noise_std, np.float64)
        return cls(message.tares, message.generation, solver, noise_std)


class _Calibration(Struct):
    tares: Whole
    generation: Whole
    solver: Any
    noise_std: list[Annotated[float, Meta(ge=0.0, lt=1e30)]]


RECENT_NS = 250_000_000  # that contacts may be of another time than an estimate
MOST = 4096  # contacts


class ContactMessage(Struct):
    """A contact in plain values, SI units; None where something is not known."""

    track: Whole
    patch: str
    position: tuple[Far, Far, Far]
    normal: tuple[Far, Far, Far]
    x: Far
    y: Far
    normal_force: Far
    moments: tuple[Large | None, Large | None, Large | None] = (None, None, None)
    force_std: Large | None = None
    place_std: Large | None = None
    area: Large | None = None
    peak_pressure: Large | None = None
    age: Large | None = None
    speed: Large | None = None
    by: Literal["engine", "fit"] = "engine"


class _Contacts(Struct):
    stamp_ns: Whole
    contacts: Annotated[list[ContactMessage], Meta(max_length=MOST)]


class Contacts(NamedTuple):
    """Contacts of one cycle.

    Attributes
    ----------
    stamp_ns : int, ns
    rows : (N,) array of CONTACT
        In the order in which they came; NaN where something is not known.
    by : list of str
        Who found each: "engine" or "fit".
    """

    stamp_ns: int
    rows: NDArray[Any]
    by: list[str]


PLAIN = tuple(name for name in ContactMessage.__struct_fields__ if name not in ("patch", "by"))


def contacts_from(data: bytes, skin: Skin) -> Contacts:
    """Read the `contacts` of an engine with this skin.

    Raises
    ------
    InputError
        If they make no sense.
    """
    message = decoded(_Contacts, data, MOST_STATUS)
    places = {patch.name: place for place, patch in enumerate(skin)}
    rows = np.zeros(len(message.contacts), CONTACT)
    for row, each in zip(rows, message.contacts, strict=True):
        if each.patch not in places:
            raise InputError(f"a contact is on patch {each.patch!r:.40}, expected one of the skin")
        row["patch"] = places[each.patch]
        for name in PLAIN:
            row[name] = np.array(getattr(each, name), row[name].dtype)
    return Contacts(message.stamp_ns, rows, [str(each.by) for each in message.contacts])
