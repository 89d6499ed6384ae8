"""Health of a running skin as `diagnostic_msgs/DiagnosticArray`."""

from collections.abc import Iterator, Mapping
from enum import IntEnum
from typing import Any

from skinfield.live.status import Status
from skinfield.sinks.ros.kinds import DIAGNOSTIC, DIAGNOSTICS, KEY_VALUE, Kinds

LATE_SHARE = 0.01  # of the estimates lately, above which it is told as a fault


class Level(IntEnum):
    """Of `diagnostic_msgs/DiagnosticStatus`."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


STATES = {
    "running": Level.OK,
    "starting": Level.WARN,
    "calibrating": Level.WARN,
    "stopped": Level.STALE,
    "failed": Level.ERROR,
}


def diagnostics_of(status: Status, header: Any, kinds: Kinds) -> Any:
    """One status of the engine, one of each source, one of each patch, one of the recorder."""
    rows = [_engine(status), *_sources(status), *_patches(status), *_recorder(status)]
    told = [
        kinds.make(
            DIAGNOSTIC,
            level=kinds.octet(int(level)),
            name=f"skinfield {status.name}: {name}",
            message=message,
            hardware_id=status.name,
            values=[
                kinds.make(KEY_VALUE, key=key, value=_text(value)) for key, value in values.items()
            ],
        )
        for level, name, message, values in rows
    ]
    return kinds.make(DIAGNOSTICS, header=header, status=told)


Row = tuple[Level, str, str, Mapping[str, Any]]


def _engine(status: Status) -> Row:
    level, lately = STATES.get(status.state, Level.ERROR), status.lately
    message = status.state
    if level == Level.OK and lately.late > LATE_SHARE * max(lately.cycles, 1):
        level, message = Level.WARN, f"running, {lately.late} of {lately.cycles} estimates late"
    latency = {} if lately.latency is None else lately.latency.as_micros()
    times = {f"latency {name} (us)": latency[name] for name in ("p50", "p99", "max") if latency}
    return (
        level,
        "engine",
        message,
        {
            "rate (1/s)": status.rate,
            "late": status.since.late,
            "late lately": lately.late,
            "skipped": status.since.skipped,
            **times,
            "restarts": max(status.generation - 1, 0),
            "resident (bytes)": status.memory.get("resident", 0),
        },
    )


def _sources(status: Status) -> Iterator[Row]:
    for name, counts in status.sources.items():
        lately = status.sources_lately.get(name, {})
        missing = sum(lately.get(what, 0) for what in ("lost", "overflowed"))
        if missing:
            yield Level.WARN, f"source {name}", f"{missing} messages lost lately", counts
        else:
            yield Level.OK, f"source {name}", "nothing lost lately", counts


def _patches(status: Status) -> Iterator[Row]:
    for patch in status.patches:
        values = {
            "answer": patch["answer"],
            "age (s)": patch["age"],
            "force (N)": patch["force"],
            "contacts": patch["contacts"],
            "taxels left out": patch["invalid"],
            "grid": patch["rung"],
        }
        if patch["age"] is None:
            level, message = Level.STALE, "no reading came yet"
        elif patch["stale"]:
            level, message = Level.STALE, f"the newest reading is {patch['age']:.3g} s old"
        elif patch["answer"] == "missing":
            level, message = Level.ERROR, "no answer: too few taxels are valid"
        elif patch["invalid"]:
            level, message = Level.WARN, f"{patch['invalid']} taxels left out"
        else:
            level, message = Level.OK, f"{patch['contacts']} contacts"
        yield level, f"patch {patch['name']}", message, values


def _recorder(status: Status) -> Iterator[Row]:
    told = status.beside.get("recorder")
    if not isinstance(told, dict):
        return
    lost = sum(int(told.get(f"{why}_bytes", 0)) for why in ("overrun", "dropped"))
    plain = {key: value for key, value in told.items() if isinstance(value, int | float | str)}
    if told.get("silent"):
        yield Level.ERROR, "recorder", "says nothing any more", plain
    elif lost:
        yield Level.WARN, "recorder", f"{lost} bytes lost", plain
    else:
        yield Level.OK, "recorder", "finished" if told.get("finished") else "records", plain


def _text(value: Any) -> str:
    if value is None:
        return "none"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
