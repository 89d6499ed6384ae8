"""Messages of the zenoh bridge: estimates, descriptions, calibrations and contacts as bytes."""

import hashlib
import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, InputError
from skinfield.estimate.live_contacts import CONTACT
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.slots import Sizes, Slot
from skinfield.reconstruct.engine.state import Answer
from skinfield.reconstruct.serialisation import plain_from_value, value_from_plain
from skinfield.ring import Field
from skinfield.ring.layout import LINE, Placed, place
from skinfield.ring.reader import Slot as Copy
from skinfield.skin import Skin
from skinfield.solve import Solver

VERSION = 1
MAGIC = b"SKE1"
MOST_JSON = 1 << 26  # bytes of a description; most of it is the layout
MOST_STATUS = 1 << 20  # bytes of what comes again and again
MOST_SLOT = 1 << 28  # bytes of an estimate
MOST_NODES, MOST_ROWS, MOST_PATCHES = 1024, 4096, 1 << 14
_HEAD = struct.Struct("<4sIQqqQQ16s")
Array = NDArray[Any]


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
    try:
        return json.dumps(plain, allow_nan=False).encode()
    except ValueError:
        return json.dumps(_finite(plain), allow_nan=False).encode()


def _finite(plain: Any) -> Any:
    if isinstance(plain, float):
        return plain if math.isfinite(plain) else None
    if isinstance(plain, Mapping):
        return {key: _finite(value) for key, value in plain.items()}
    if isinstance(plain, list | tuple):
        return [_finite(value) for value in plain]
    return plain


def object_of(data: bytes, most: int) -> dict[str, Any]:
    """A JSON object from others.

    Raises
    ------
    InputError
        If it is none, or longer than `most` bytes.
    """
    if len(data) > most:
        raise InputError(f"a message has {len(data)} bytes, expected at most {most}")
    try:
        plain = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError(f"a message is {data[:40]!r}..., expected JSON: {error}") from error
    if not isinstance(plain, dict):
        raise InputError(f"a message is {data[:40]!r}..., expected a JSON object")
    return plain


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


@dataclass(frozen=True, eq=False)
class Plan:
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
        plain = object_of(data, MOST_JSON)
        if plain.get("skinfield_zenoh") != VERSION:
            raise InputError(
                f"the description is of version {plain.get('skinfield_zenoh')!r:.40}, expected "
                f"{VERSION}: the same skinfield on all computers"
            )
        ring = plain.get("ring")
        text = ring.get("model_config") if isinstance(ring, dict) else None
        if not isinstance(text, str):
            raise InputError("the description has no model_config, expected that of a live skin")
        model_config = ModelConfig.from_json(text)
        fields, size = place("slot", _sizes(model_config).fields(), LINE)
        told = [[each.field.name, each.offset, each.field.dtype] for each in fields]
        if plain.get("slot_bytes") != size or _places(plain.get("slot")) != told:
            raise InputError(
                f"slots have {plain.get('slot_bytes')!r:.40} bytes, expected {size} of "
                f"{', '.join(each.field.name for each in fields)}: is it another skinfield?"
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


def _places(plain: Any) -> Any:
    if not isinstance(plain, list) or not all(isinstance(each, dict) for each in plain):
        return None
    return [[each.get(what) for what in ("name", "offset", "dtype")] for each in plain]


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


class Calibration(NamedTuple):
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
    solver: Solver | None
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
        plain = object_of(data, MOST_JSON)
        tares, generation = _count(plain.get("tares")), _count(plain.get("generation"))
        values = plain.get("noise_std")
        if not isinstance(values, list) or len(values) != taxels or not _all_noise(values):
            raise InputError(f"a calibration has no noise of {taxels} taxels, expected that")
        solver = value_from_plain("solver", plain.get("solver"))
        if solver is not None and not (isinstance(plain["solver"], dict) and _solves(solver)):
            raise InputError(f"a solver is {plain['solver']!r:.60}, expected one of skinfield's")
        return cls(tares, generation, solver, np.array(values, np.float64))


def _solves(solver: object) -> bool:
    return callable(getattr(solver, "prepare", None))


def _count(value: Any) -> int:
    if type(value) is not int or not 0 <= value < 1 << 62:
        raise InputError(f"a calibration counts {value!r:.40}, expected a whole number from 0")
    return value


def _all_noise(values: list[Any]) -> bool:
    return all(type(each) in (int, float) and 0 <= each < 1e30 for each in values)


RECENT_NS = 250_000_000  # that contacts may be of another time than an estimate
FINDERS = ("engine", "fit")
VECTORS = ("position", "normal")
SURE = ("x", "y", "normal_force")  # what every contact has; the rest may be unknown
PERHAPS = ("force_std", "place_std", "area", "peak_pressure", "age", "speed")
MOST = 4096  # contacts
FAR, LARGE = 1e3, 1e12  # m or N, and anything


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


def contacts_from(data: bytes, skin: Skin) -> Contacts:
    """Read the `contacts` of an engine with this skin.

    Raises
    ------
    InputError
        If they make no sense.
    """
    plain = object_of(data, MOST_STATUS)
    stamp, told = plain.get("stamp_ns"), plain.get("contacts")
    if type(stamp) is not int or not 0 <= stamp < 1 << 62:
        raise InputError(f"stamp_ns of contacts is {stamp!r:.40}, expected ns since the epoch")
    if not isinstance(told, list) or len(told) > MOST or not all(type(x) is dict for x in told):
        raise InputError(f"contacts are no list of at most {MOST} objects, expected that")
    places = {patch.name: place for place, patch in enumerate(skin)}
    rows, by = np.zeros(len(told), CONTACT), []
    for row, each in zip(rows, told, strict=True):
        _fill(row, each, places)
        if each.get("by") not in FINDERS:
            raise InputError(f"a contact is by {each.get('by')!r:.40}, expected engine or fit")
        by.append(str(each["by"]))
    return Contacts(stamp, rows, by)


def _fill(row: Any, plain: Mapping[str, Any], places: Mapping[str, int]) -> None:
    patch, track = plain.get("patch"), plain.get("track")
    if not isinstance(patch, str) or patch not in places:
        raise InputError(f"a contact is on patch {patch!r:.40}, expected one of the skin")
    if type(track) is not int or not 0 <= track < 1 << 62:
        raise InputError(f"a contact is numbered {track!r:.40}, expected a whole number")
    row["patch"], row["track"] = places[patch], track
    for name in VECTORS:
        values = plain.get(name)
        if not isinstance(values, list) or len(values) != 3:
            raise InputError(f"{name} of a contact is {values!r:.40}, expected three numbers")
        row[name] = [_number(name, each, FAR) for each in values]
    moments = plain.get("moments")
    if not isinstance(moments, list) or len(moments) != 3:
        raise InputError(f"moments of a contact are {moments!r:.40}, expected three numbers")
    row["moments"] = [_perhaps("moments", each) for each in moments]
    for name in SURE:
        row[name] = _number(name, plain.get(name), FAR)
    for name in PERHAPS:
        row[name] = _perhaps(name, plain.get(name))


def _number(name: str, value: Any, most: float) -> float:
    good = type(value) in (int, float) and abs(value) <= most
    if not good:
        raise InputError(f"{name} of a contact is {value!r:.40}, expected at most {most:g}")
    return float(value)


def _perhaps(name: str, value: Any) -> float:
    return math.nan if value is None else _number(name, value, LARGE)
