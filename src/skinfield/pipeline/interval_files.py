"""Intervals on disk, as JSON, so that a robot need not learn them at each start."""

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import FileError, Floats, InputError
from skinfield.pipeline.intervals import Group, Intervals, Ratio

FORMAT = "skinfield-intervals"
VERSION = 1
_TEXTS = ("solver", "quantity")
_COUNTS = ("taxels", "presses", "found")
_LONGEST = 100_000_000  # bytes


def save_intervals(intervals: Intervals, path: Path | str) -> None:
    """Write intervals as JSON.

    Raises
    ------
    FileError
        If the file cannot be written.
    """
    content: dict[str, Any] = {"format": FORMAT, "version": VERSION}
    content |= {name: getattr(intervals, name) for name in (*_TEXTS, *_COUNTS)}
    content |= {"noise_std": intervals.noise_std, "place_floor_m": intervals.place_floor}
    for name in ("force", "area"):
        ratio: Ratio = getattr(intervals, name)
        content[name] = {"centre": ratio.centre.tolist(), "floor": ratio.floor}
    content["edges"] = intervals.edges.tolist()
    content["groups"] = [
        {part.name: getattr(group, part.name).tolist() for part in fields(group)}
        for group in intervals.groups
    ]
    try:
        Path(path).write_text(json.dumps(content), encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror or error}") from error


def load_intervals(path: Path | str) -> Intervals:
    """Read intervals that `save_intervals` wrote.

    Raises
    ------
    FileError
        If the file is missing, of another format or version, or broken.
    """
    try:
        if Path(path).stat().st_size > _LONGEST:
            raise FileError(f"{path} has more than {_LONGEST:_} bytes, expected intervals")
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise FileError(f"{path} is no text, expected JSON of save_intervals: {error}") from error
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{path} is no JSON, expected that of save_intervals: {error}") from error
    head = (content.get("format"), content.get("version")) if isinstance(content, dict) else None
    if head != (FORMAT, VERSION):
        raise FileError(f"{path} has head {head!r}, expected {(FORMAT, VERSION)!r}: save it anew")
    try:
        return _intervals(content)
    except InputError as error:
        raise FileError(f"{path}: {error}") from error


def _intervals(content: dict[str, Any]) -> Intervals:
    groups = _entry(content, "groups", list)
    if not groups:
        raise InputError("groups is empty, expected at least one")
    return Intervals(
        **{name: _entry(content, name, str) for name in _TEXTS},
        **{name: _entry(content, name, int) for name in _COUNTS},
        noise_std=_number(content, "noise_std"),
        force=_ratio(content, "force"),
        area=_ratio(content, "area"),
        place_floor=_number(content, "place_floor_m"),
        edges=_numbers(content, "edges"),
        groups=tuple(_group(number, each) for number, each in enumerate(groups)),
    )


def _group(number: int, content: Any) -> Group:
    if not isinstance(content, dict):
        raise InputError(f"groups[{number}] is {type(content).__name__}, expected an object")
    return Group(**{part.name: _numbers(content, part.name) for part in fields(Group)})


def _ratio(content: dict[str, Any], name: str) -> Ratio:
    inner = _entry(content, name, dict)
    return Ratio(centre=_numbers(inner, "centre"), floor=_number(inner, "floor"))


def _entry(content: dict[str, Any], name: str, kind: type) -> Any:
    value = content.get(name)
    if not isinstance(value, kind) or isinstance(value, bool):
        raise InputError(f"{name} is {str(value)[:40]!r}, expected {kind.__name__}")
    return value


def _number(content: dict[str, Any], name: str) -> float:
    value = content.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{name} is {str(value)[:40]!r}, expected a number")
    return float(_floats(name, [value])[0])


def _numbers(content: dict[str, Any], name: str) -> Floats:
    values = _entry(content, name, list)
    if not all(isinstance(each, int | float) and not isinstance(each, bool) for each in values):
        raise InputError(f"{name} holds what is no number, expected numbers alone")
    return _floats(name, values)


def _floats(name: str, values: list[int | float]) -> Floats:
    try:
        return np.array(values, dtype=np.float64)
    except OverflowError as error:
        raise InputError(f"{name} holds a number that no float can: {error}") from error
