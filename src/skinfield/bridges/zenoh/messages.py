"""Messages of the zenoh bridge: estimates, contacts, status and descriptions as bytes."""

import hashlib
import struct
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

import msgspec
import numpy as np
from msgspec import Meta, Struct, field
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, InputError
from skinfield.estimate.row_contacts import force_of, shape_name
from skinfield.files.layouts.load import save_layout
from skinfield.loop import Answer
from skinfield.loop.model_config import Configuration, ModelConfig
from skinfield.loop.realtime.timing import TIMES, TOTALS
from skinfield.loop.slots import CycleSlot, Sizes, SlotLayout
from skinfield.loop.snapshot import Snapshot
from skinfield.skin import Patch, Skin

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


def described(robot: str, part: str, ring: Mapping[str, Any], layout: SlotLayout) -> bytes:
    """The description that others ask for: that of the ring, and what a slot holds.

    Not how the boards are connected: that is nobody's business elsewhere.
    """
    return strict_json(
        {
            "skinfield_zenoh": VERSION,
            "robot": robot,
            "part": part,
            "slot_bytes": layout.size,
            "slot": _placed(layout),
            "ring": {key: value for key, value in ring.items() if key != "source_settings"},
        }
    )


class _PlacedField(Struct):
    name: str
    dtype: str
    shape: tuple[int, ...]
    offset: int


def _placed(layout: SlotLayout) -> list[_PlacedField]:
    return [_PlacedField(*each.field, each.offset) for each in layout.fields]


class _Ring(Struct):
    model_config: str


class _Description(Struct):
    """What `described` makes, as far as it is read."""

    skinfield_zenoh: int
    slot_bytes: int
    slot: list[_PlacedField]
    ring: _Ring


class EstimateForm(NamedTuple):
    """How estimates of one engine are read, from its description.

    Attributes
    ----------
    model_config : ModelConfig
    fingerprint : bytes
    layout : SlotLayout
    """

    model_config: ModelConfig
    fingerprint: bytes
    layout: SlotLayout

    @classmethod
    def of(cls, data: bytes) -> "EstimateForm":
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
        layout = SlotLayout.of(_sizes(model_config).fields())
        own = _placed(layout)
        if message.slot_bytes != layout.size or message.slot != own:
            raise InputError(
                f"slots have {message.slot_bytes} bytes, expected {layout.size} of "
                f"{', '.join(each.name for each in own)}: is it another skinfield?"
            )
        return cls(model_config, fingerprint_of(data), layout)

    def slot(self, data: bytes) -> CycleSlot:
        """The slot of these octets, checked.

        Raises
        ------
        InputError
            If they are no cycle of this engine.
        """
        if len(data) != self.layout.size:
            raise InputError(f"an estimate has {len(data)} bytes, expected {self.layout.size}")
        slot = self.layout.slot(data)
        check_slot(slot, self.model_config)
        return slot


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


def check_slot(slot: CycleSlot, model_config: ModelConfig) -> None:
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


class _Calibration(Struct):
    """What `RemoteCalibration` makes, as far as it is read."""

    tares: Whole
    generation: Whole
    solver: dict[str, Any]
    noise_std: list[Annotated[float, Meta(ge=0.0, lt=1e30)]]
    tuning: dict[str, Any] = {}


class RemoteCalibration(NamedTuple):
    """What changes while a ring stays, and decides what follows from a pressure.

    Attributes
    ----------
    tares : int
        Baselines taken so far.
    configuration : Configuration
    noise_std : (L,) array
        In the quantity's unit.
    """

    tares: int
    configuration: Configuration
    noise_std: Floats

    def packed(self) -> bytes:
        """As JSON."""
        plain = {"tares": self.tares, "noise_std": self.noise_std.tolist()}
        return strict_json(self.configuration.as_dict() | plain)

    @classmethod
    def of(cls, data: bytes, taxels: int) -> "RemoteCalibration":
        """Undo `packed`, of a skin with so many taxels.

        Raises
        ------
        InputError
            If it makes no sense.
        """
        message = decoded(_Calibration, data, MOST_JSON)
        if len(message.noise_std) != taxels:
            raise InputError(f"a calibration has no noise of {taxels} taxels, expected that")
        configuration = Configuration.from_dict(msgspec.structs.asdict(message))
        return cls(message.tares, configuration, np.array(message.noise_std, np.float64))


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
    shape: Literal["other", "sphere", "flat", "line"] = "other"
    radius: Large | None = None
    maybe: int = 0


PLAIN = tuple(
    name for name in ContactMessage.__struct_fields__ if name not in ("patch", "shape", "maybe")
)
BLANK_TIMING = dict.fromkeys(TOTALS, 0) | {f"{name}_us": None for name in TIMES}


class PatchStatus(Struct):
    """Of one patch, as `Status.patches` has it."""

    name: str
    answer: Literal["missing", "idle", "linear", "field", "contacts"] = "missing"
    age: float | None = None
    stale: bool = False
    force: float = 0.0
    contacts: Whole = 0
    readings: Whole = 1
    invalid: Whole = 0
    rung: Whole = 0
    gap: float | None = None


class StatusMessage(Struct):
    """As `Status.as_dict` has it, and how many baselines were taken."""

    name: str
    state: Literal["starting", "calibrating", "running", "stopped", "failed"] = "starting"
    pid: Whole = 0
    generation: Whole = 0
    seconds: float = 0.0
    rate: float = 0.0
    sources: dict[str, dict[str, int]] = {}
    sources_lately: dict[str, dict[str, int]] = {}
    patches: list[PatchStatus] = []
    contacts: list[ContactMessage] = []
    notes: dict[str, Any] = {}
    sidecars: dict[str, Any] = field(default_factory=dict, name="beside")
    memory: dict[str, Whole] = {}
    tuning: dict[str, Any] = {}
    relative: bool = True  # older ones do not say it
    since_start: dict[str, Any] = field(default_factory=BLANK_TIMING.copy)
    lately: dict[str, Any] = field(default_factory=BLANK_TIMING.copy)
    lost: Whole = 0
    tares: Whole = 0


def status_from(data: bytes, skin: Skin) -> dict[str, Any]:
    """The status of an engine with this skin, with every member that `Status.as_dict` has.

    What the message does not say is as of an engine that said nothing yet.

    Raises
    ------
    InputError
        If a member cannot be: another state, a patch that the skin has not, a count below zero,
        text or nesting without end.
    """
    status = decoded(StatusMessage, data, MOST_STATUS)
    names = [patch.name for patch in skin]
    if [each.name for each in status.patches] not in ([], names):
        raise InputError(
            f"patches of a status are {[each.name for each in status.patches]!r:.80}, expected "
            f"those of the skin: {', '.join(names)}"
        )
    status.patches = status.patches or [PatchStatus(name) for name in names]
    status.contacts = [each for each in status.contacts if each.patch in names]
    plain: dict[str, Any] = msgspec.to_builtins(status)
    return plain


def status_and_health(plain: dict[str, Any], tares: int) -> tuple[bytes, bytes]:
    """What `skinfield status --json` tells, and counters of what goes wrong.

    Parameters
    ----------
    plain : dict
        As `Status.as_dict` has it.
    tares : int
        How many baselines were taken.
    """
    recorder = (plain.get("beside") or {}).get("recorder")
    if isinstance(recorder, dict):  # where it writes to is nobody's business elsewhere
        recorder.pop("path", None)
    patches, totals = plain["patches"], plain["since_start"]
    health = {
        "state": plain["state"],
        "rate": plain["rate"],
        **{name: totals[name] for name in ("cycles", "late", "skipped")},
        "lost": plain["lost"],
        "sources": plain["sources"],
        "invalid": {each["name"]: each["invalid"] for each in patches if each["invalid"]},
        "stale": [each["name"] for each in patches if each["stale"]],
        "missing": [each["name"] for each in patches if each["answer"] == "missing"],
        "tares": tares,
        "restarts": plain["generation"] - 1,
    }
    return strict_json(plain | {"tares": tares}), strict_json(health)


def contacts_of(snapshot: Snapshot, plain: list[dict[str, Any]]) -> bytes:
    """Contacts of a cycle, each as `contact_plain` makes it."""
    return strict_json(
        {
            "number": snapshot.number,
            "stamp_ns": snapshot.stamp_ns,
            "relative": snapshot.model_config.relative,
            "contacts": plain,
        }
    )


def contact_plain(row: Any, patches: list[Patch]) -> dict[str, Any]:
    """A contact in plain values, SI units; force is a vector in the patch's frame."""
    plain = {name: row[name].tolist() for name in PLAIN}
    plain |= {"shape": shape_name(row), "maybe": int(row["maybe"])}
    patch = patches[int(row["patch"])]
    force = force_of(row).tolist()  # onto the skin, against its normal and along it
    return plain | {"patch": patch.name, "link": patch.link, "force": force}


def layout_text(skin: Skin | Patch) -> bytes:
    """A layout as skinfield writes it to a TOML file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.toml"
        save_layout(skin, path)
        return path.read_bytes()
