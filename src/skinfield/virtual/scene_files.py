"""Scenes from files."""

import json
import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skinfield.errors import FileError, InputError
from skinfield.layout import Skin
from skinfield.virtual.place import number, patch_index, place_of
from skinfield.virtual.scenes import RAMP, SCENES, scene_by_name
from skinfield.virtual.tool import FINGER, Tool
from skinfield.virtual.touch import Point, Scene, Track

LATEST = 1e7  # s
PRESS_KEYS = {
    "patch", "shape", "radius_mm", "force_n", "x_mm", "y_mm", "taxel", "face", "weights", "start_s",
    "seconds", "ramp_s", "path",
}  # fmt: skip
POINT_KEYS = {"time_s", "x_mm", "y_mm", "taxel", "face", "weights", "force_n"}


def scene_from_text(text: str, skin: Skin, seed: int) -> Scene:
    """A scene that is there by its name, or one from a ``.toml`` or ``.json`` file.

    Raises
    ------
    InputError, FileError
        If there is none, or the file cannot be used.
    """
    if text in SCENES or Path(text).suffix.lower() not in (".toml", ".json"):
        return scene_by_name(text, skin, seed)
    return load_scene(text, skin)


def load_scene(path: str | Path, skin: Skin) -> Scene:
    """Scene from a file: a list `press`, and `repeat_s` if it is played over and over.

    Raises
    ------
    FileError
        If it cannot be read, or an entry cannot be used; the message names it.
    """
    try:
        data = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        raise FileError(f"{path} cannot be read: {error}") from error
    return scene_from_bytes(data, str(path), skin)


def scene_from_bytes(data: bytes, path: str, skin: Skin) -> Scene:
    """As `load_scene`, from what the file holds."""
    try:
        text = data.decode()
        content = json.loads(text) if path.lower().endswith(".json") else tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{path} cannot be read: {error}, expected TOML or JSON") from error
    try:
        return _scene(content, Path(path).stem, skin)
    except InputError as error:
        raise FileError(f"{path}: {error}") from error


def _scene(content: Any, name: str, skin: Skin) -> Scene:
    _check_keys(content, {"repeat_s", "press"}, "the file")
    presses = content.get("press", [])
    if not isinstance(presses, list):
        raise InputError("press is no list, expected [[press]] tables")
    tracks = tuple(_track(each, f"press[{i}]", skin) for i, each in enumerate(presses))
    if "repeat_s" not in content:
        return Scene(name, tracks)
    return Scene(name, tracks, number(content, "repeat_s", None, 1e-3, LATEST, "seconds"))


def _track(given: Any, where: str, skin: Skin) -> Track:
    _check_keys(given, PRESS_KEYS, where)
    try:
        patch = patch_index(skin, given.get("patch"))
        shape = given.get("shape", "ball")
        if not isinstance(shape, str):
            raise InputError(f"shape is {shape!r}, expected 'ball' or 'flat'")
        radius = number(given, "radius_mm", FINGER * 1e3, 0.5, 30.0, "millimetres") * 1e-3
        tool = Tool(radius, shape)
        path = given.get("path")
        if path is not None:
            return Track(patch, tool, _points(path, given, skin, patch))
        return Track(patch, tool, _held(given, skin, patch))
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def _held(given: Mapping[str, Any], skin: Skin, patch: int) -> tuple[Point, ...]:
    """Pressed at one place from `start_s` for `seconds`."""
    x, y = _place(given, skin, patch)
    force = number(given, "force_n", 1.0, 1e-6, 1e4, "newtons")
    start = number(given, "start_s", 0.0, 0.0, LATEST, "seconds since the scene began")
    seconds = number(given, "seconds", 1.0, 1e-3, LATEST, "for how long")
    ramp = min(number(given, "ramp_s", RAMP, 0.0, LATEST, "of pressing"), seconds / 2.0)
    times = (start, start + ramp, start + seconds - ramp, start + seconds)
    forces = (0.0, force, force, 0.0)
    return tuple(Point(t, x, y, f) for t, f in zip(times, forces, strict=True))


def _points(path: Any, given: Mapping[str, Any], skin: Skin, patch: int) -> tuple[Point, ...]:
    """Points of `path`; what one does not say is as at the point before."""
    if not isinstance(path, list) or len(path) > 100_000:
        raise InputError("path is no list, expected points such as {time_s = 0, x_mm = 1, ...}")
    now: dict[str, Any] = {key: given[key] for key in POINT_KEYS & set(given)}
    points = []
    for index, each in enumerate(path):
        _check_keys(each, POINT_KEYS, f"path[{index}]")
        if {"x_mm", "y_mm"} & set(each):
            now = {key: value for key, value in now.items() if key not in ("taxel", "face")}
        now.update(each)
        x, y = _place(now, skin, patch)
        time = number(now, "time_s", None, 0.0, LATEST, "seconds since the scene began")
        points.append(Point(time, x, y, number(now, "force_n", 1.0, 0.0, 1e4, "newtons")))
    return tuple(points)


def _place(given: Mapping[str, Any], skin: Skin, patch: int) -> tuple[float, float]:
    metres: dict[str, Any] = {
        key: given[key] for key in ("taxel", "face", "weights") if key in given
    }
    for key in ("x", "y"):
        if f"{key}_mm" in given:
            millimetres = number(given, f"{key}_mm", None, -1e4, 1e4, "in the patch's plane")
            metres[key] = millimetres * 1e-3
    x, y = place_of(skin.patches[patch], metres)
    return (x, y) if math.isfinite(x + y) else (0.0, 0.0)


def _check_keys(given: Any, known: set[str], where: str) -> None:
    if not isinstance(given, Mapping):
        raise InputError(f"{where} is no table, expected one with {', '.join(sorted(known))}")
    unknown = sorted(set(given) - known)
    if unknown:
        raise InputError(
            f"{where} has {unknown[0]!r:.60}, expected only {', '.join(sorted(known))}"
        )
