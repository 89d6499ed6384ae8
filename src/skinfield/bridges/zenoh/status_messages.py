"""Status messages of the zenoh bridge: what a live skin sends of itself, and their check."""

import math
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.bridges.zenoh.messages import Calibration, described, fingerprint_of, strict_json
from skinfield.bridges.zenoh.session import Part
from skinfield.errors import InputError
from skinfield.files.layouts.load import save_layout
from skinfield.loop.client import Live
from skinfield.loop.model_config import configuration_of
from skinfield.loop.snapshot import Snapshot
from skinfield.loop.status import Observer
from skinfield.reconstruct.engine.state import Answer
from skinfield.skin import Patch, Skin

STATES = ("starting", "calibrating", "running", "stopped", "failed")
ANSWERS = tuple(each.name.lower() for each in Answer)
TIMES = ("wake", "acquired", "ready", "latency", "cycle")
TOTALS = ("cycles", "late", "overrun", "skipped")
QUANTILES = ("p50", "p99", "p999", "max", "mean", "count")
DEEP, LONG, MANY = 8, 10_000, 200_000  # levels, characters of a text, values in all
BIG = 1 << 62


def blank_status(name: str, skin: Skin) -> dict[str, Any]:
    """Of an engine that said nothing yet."""
    return {
        "name": name,
        "state": "starting",
        "pid": 0,
        "generation": 0,
        "seconds": 0.0,
        "rate": 0.0,
        "sources": {},
        "sources_lately": {},
        "patches": [_patch({"name": patch.name}) for patch in skin],
        "contacts": [],
        "notes": {},
        "beside": {},
        "memory": {},
        "tuning": {},
        "since_start": _timing({}),
        "lately": _timing({}),
        "lost": 0,
        "tares": 0,
    }


def checked_status(plain: Mapping[str, Any], skin: Skin) -> dict[str, Any]:
    """The status with every member that `Status.as_dict` has, each of its kind.

    Raises
    ------
    InputError
        If a member cannot be: another state, a patch that the skin has not, a count below zero,
        text or nesting without end.
    """
    _Limits().check(plain, 0)
    names = [patch.name for patch in skin]
    state = plain.get("state")
    if state not in STATES:
        raise InputError(f"state is {state!r:.40}, expected one of {', '.join(STATES)}")
    patches = [_patch(_object(each)) for each in _list(plain.get("patches"))]
    if [each["name"] for each in patches] not in ([], names):
        raise InputError("patches of a status are others than those of the skin")
    contacts = [_object(each) for each in _list(plain.get("contacts"))]
    return {
        "name": str(plain.get("name")),
        "state": state,
        "pid": _count(plain.get("pid")),
        "generation": _count(plain.get("generation")),
        "seconds": _number(plain.get("seconds")),
        "rate": _number(plain.get("rate")),
        "sources": _sources(plain.get("sources")),
        "sources_lately": _sources(plain.get("sources_lately")),
        "patches": patches or [_patch({"name": name}) for name in names],
        "contacts": [_contact(each) for each in contacts if each.get("patch") in names],
        "notes": dict(_object(plain.get("notes"))),
        "beside": dict(_object(plain.get("beside"))),
        "memory": {},
        "tuning": dict(_object(plain.get("tuning"))),
        "since_start": _timing(_object(plain.get("since_start"))),
        "lately": _timing(_object(plain.get("lately"))),
        "lost": _count(plain.get("lost")),
        "tares": _count(plain.get("tares")),
    }


class _Limits:
    """Counts values, so that what came can be shown and sent on without care."""

    def __init__(self) -> None:
        self.values = 0

    def check(self, plain: Any, depth: int) -> None:
        self.values += 1
        if depth > DEEP or self.values > MANY:
            raise InputError(f"a status has over {MANY} values, or more than {DEEP} levels")
        if isinstance(plain, str):
            if len(plain) > LONG:
                raise InputError(f"a text of a status has {len(plain)} characters, at most {LONG}")
        elif isinstance(plain, int) and not isinstance(plain, bool):
            if abs(plain) > BIG:
                raise InputError("a number of a status is beyond all that is counted")
        elif isinstance(plain, float):
            if not math.isfinite(plain):
                raise InputError("a number of a status is not finite")
        elif isinstance(plain, dict):
            for key, value in plain.items():
                self.check(key, depth + 1)
                self.check(value, depth + 1)
        elif isinstance(plain, list):
            for value in plain:
                self.check(value, depth + 1)


def _object(plain: Any) -> dict[str, Any]:
    if plain is None:
        return {}
    if not isinstance(plain, dict):
        raise InputError(f"a part of a status is {plain!r:.40}, expected an object")
    return plain


def _list(plain: Any) -> list[Any]:
    if not isinstance(plain, list):
        raise InputError(f"a part of a status is {plain!r:.40}, expected a list")
    return plain


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"a number of a status is {value!r:.40}, expected one")
    return float(value)


def _perhaps(value: Any) -> float | None:
    return None if value is None else _number(value)


def _count(value: Any) -> int:
    if value is None:
        return 0
    if type(value) is not int or value < 0:
        raise InputError(f"a count of a status is {value!r:.40}, expected 0 or more")
    return value


def _numbers(value: Any) -> list[float]:
    found = [_number(each) for each in _list(value)]
    if len(found) != 3:
        raise InputError(f"a vector of a status has {len(found)} numbers, expected 3")
    return found


def _patch(row: Mapping[str, Any]) -> dict[str, Any]:
    answer = row.get("answer", "missing")
    if not isinstance(row.get("name"), str) or answer not in ANSWERS:
        raise InputError("a patch of a status has no name or no known answer, expected both")
    return {
        "name": row["name"],
        "answer": answer,
        "age": _perhaps(row.get("age")),
        "stale": row.get("stale") is True,
        "force": _perhaps(row.get("force")) or 0.0,
        "contacts": _count(row.get("contacts")),
        "invalid": _count(row.get("invalid")),
        "rung": _count(row.get("rung")),
        "gap": _perhaps(row.get("gap")),
    }


def _contact(row: Mapping[str, Any]) -> dict[str, Any]:
    names = (
        *("x", "y", "normal_force", "force_std", "place_std", "area", "peak_pressure"),
        *("age", "speed"),
    )
    vectors = {name: _numbers(row.get(name)) for name in ("position", "normal")}
    plain = {name: _perhaps(row.get(name)) for name in names}
    return {"track": _count(row.get("track")), "patch": row["patch"]} | vectors | plain


def _sources(plain: Any) -> dict[str, dict[str, int]]:
    return {
        str(name): {key: _whole(value) for key, value in _object(counts).items()}
        for name, counts in _object(plain).items()
    }


def _whole(value: Any) -> int:
    if type(value) is not int:
        raise InputError(f"a counter of a status is {value!r:.40}, expected a whole number")
    return value


def _timing(plain: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {name: _count(plain.get(name)) for name in TOTALS}
    for name in TIMES:
        times = plain.get(f"{name}_us")
        found[f"{name}_us"] = None if times is None else _quantiles(_object(times))
    return found


def _quantiles(plain: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _perhaps(plain.get(name)) or 0.0 for name in QUANTILES}


RECENT = 1.0  # s that the status calls the last
PLAIN = (  # fields of a contact that go out as they are, in SI units
    "track", "position", "normal", "x", "y", "normal_force", "force_std", "place_std", "area",
    "peak_pressure", "moments", "age", "speed",
)  # fmt: skip


class StatusEncoder:
    """Makes what is sent about one ring.

    Parameters
    ----------
    live : Live
    part : Part

    Attributes
    ----------
    description : bytes
        See `messages.described`.
    fingerprint : bytes
    layout : bytes
        The skin as skinfield's own layout in TOML.
    """

    def __init__(self, live: Live, part: Part) -> None:
        reader = live.reader
        self._live, self._reader = live, reader
        self._observer = Observer(reader, window=RECENT)
        self._patches = list(live.skin)
        self.description = described(part.robot, part.name, reader.description, reader.slot_fields)
        self.fingerprint = fingerprint_of(self.description)
        self.layout = layout_text(live.skin)
        self._look()

    def _look(self) -> None:
        """Look at the state once for both, status and health."""
        plain = self._observer.look().as_dict()
        recorder = (plain.get("beside") or {}).get("recorder")
        if isinstance(recorder, dict):  # where it writes to is nobody's business elsewhere
            recorder.pop("path", None)
        tares = int(self._reader.status_view["tares"][0])
        self._status = strict_json(plain | {"tares": tares})
        patches = plain["patches"]
        self._health = strict_json(
            {
                "state": plain["state"],
                "rate": plain["rate"],
                "cycles": plain["since_start"]["cycles"],
                "late": plain["since_start"]["late"],
                "skipped": plain["since_start"]["skipped"],
                "lost": plain["lost"],
                "sources": plain["sources"],
                "invalid": {each["name"]: each["invalid"] for each in patches if each["invalid"]},
                "stale": [each["name"] for each in patches if each["stale"]],
                "missing": [each["name"] for each in patches if each["answer"] == "missing"],
                "tares": tares,
                "restarts": plain["generation"] - 1,
            }
        )

    def status(self) -> bytes:
        """What `skinfield status --json` tells, now."""
        self._look()
        return self._status

    def health(self) -> bytes:
        """Counters of what goes wrong, of the moment of `status`."""
        return self._health

    def newest_status(self) -> bytes:
        """The status that was made last."""
        return self._status

    def calibration(self) -> bytes:
        """Noise of all taxels and solver, by which a reader makes uncertainties."""
        reader, told = self._reader, configuration_of(self._reader)
        return Calibration(
            tares=int(reader.status_view["tares"][0]),
            generation=reader.generation if told is None else told.generation,
            solver=None if told is None else told.solver,
            noise_std=np.asarray(self._live.models.noise_std),
        ).packed()

    def contacts(
        self, snapshot: Snapshot, rows: NDArray[Any], by: list[str], patch: int | None = None
    ) -> bytes:
        """Contacts of a cycle, on all patches or on one.

        Parameters
        ----------
        snapshot : Snapshot
        rows : (N,) array of CONTACT
        by : list of str
            Who found each: "engine" or "fit".
        patch : int, optional
            Those of this one alone.
        """
        return strict_json(
            {
                "number": snapshot.number,
                "stamp_ns": snapshot.stamp_ns,
                "contacts": [
                    contact_plain(row, self._patches, who)
                    for row, who in zip(rows, by, strict=True)
                    if patch is None or int(row["patch"]) == patch
                ],
            }
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
