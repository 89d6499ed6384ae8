"""Status messages of the zenoh bridge: what a live skin sends of itself, and their check."""

import tempfile
from pathlib import Path
from typing import Any, Literal

import msgspec
from msgspec import Struct, field

from skinfield.bridges.zenoh.messages import (
    MOST_STATUS,
    PLAIN,
    ContactMessage,
    Whole,
    decoded,
    strict_json,
)
from skinfield.errors import InputError
from skinfield.files.layouts.load import save_layout
from skinfield.loop.realtime.timing import TIMES, TOTALS
from skinfield.loop.snapshot import Snapshot
from skinfield.skin import Patch, Skin

BLANK_TIMING = dict.fromkeys(TOTALS, 0) | {f"{name}_us": None for name in TIMES}


class PatchStatus(Struct):
    """Of one patch, as `Status.patches` has it."""

    name: str
    answer: Literal["missing", "idle", "linear", "feasible"] = "missing"
    age: float | None = None
    stale: bool = False
    force: float = 0.0
    contacts: Whole = 0
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
    since_start: dict[str, Any] = field(default_factory=BLANK_TIMING.copy)
    lately: dict[str, Any] = field(default_factory=BLANK_TIMING.copy)
    lost: Whole = 0
    tares: Whole = 0


def blank_status(name: str, skin: Skin) -> dict[str, Any]:
    """Of an engine that said nothing yet."""
    patches = [PatchStatus(patch.name) for patch in skin]
    return _plain(StatusMessage(name, patches=patches))


def status_from(data: bytes, skin: Skin) -> dict[str, Any]:
    """The status of an engine with this skin, with every member that `Status.as_dict` has.

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
    return _plain(status)


def _plain(status: StatusMessage) -> dict[str, Any]:
    found: dict[str, Any] = msgspec.to_builtins(status)
    return found


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
        {"number": snapshot.number, "stamp_ns": snapshot.stamp_ns, "contacts": plain}
    )


def contact_plain(row: Any, patches: list[Patch], by: str) -> dict[str, Any]:
    """A contact in plain values, SI units; force is a vector in the patch's frame."""
    plain = {name: row[name].tolist() for name in PLAIN}
    patch = patches[int(row["patch"])]
    force = (-row["normal_force"] * row["normal"]).tolist()  # onto the skin, against its normal
    return plain | {"patch": patch.name, "link": patch.link, "force": force, "by": by}


def layout_text(skin: Skin | Patch) -> bytes:
    """A layout as skinfield writes it to a TOML file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.toml"
        save_layout(skin, path)
        return path.read_bytes()
