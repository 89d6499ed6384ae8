"""Scenes of presses over time, by name or of files; bodies that press, and places on a skin."""

import json
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from skinfield.errors import FileError, InputError, check_choice, check_positive, check_range
from skinfield.simulate import Cylinder, Sphere
from skinfield.skin import Patch, Skin

SHAPES = ("ball", "flat")
FINGER = 10e-3  # m: about that of a fingertip
EDGE = 0.5e-3  # m: rounding of a flat end, at most
LARGEST = 30e-3  # m
STEP = 0.1e-3  # m: radii are rounded to it, so that a dragged slider makes no thousand tables

FARTHEST = 10.0  # m: no skin is larger
PLACE_KEYS = ("x", "y", "taxel", "face", "weights")
SCENES = ("idle", "press", "slide", "two-balls", "tap", "random")
RANDOM_SECONDS = 600.0  # after which the random scene begins again
RANDOM_FORCES = (0.2, 3.0)  # N
OFFSET = (-2e-3, 2e-3)  # m: from the taxel, in x and y
RAMP = 0.1  # s of pressing and of lifting off
LATEST = 1e7  # s
PRESS_KEYS = {
    "patch", "shape", "radius_mm", "force_n", "x_mm", "y_mm", "taxel", "face", "weights", "start_s",
    "seconds", "ramp_s", "path",
}  # fmt: skip
POINT_KEYS = {"time_s", "x_mm", "y_mm", "taxel", "face", "weights", "force_n"}


@dataclass(frozen=True)
class Tool:
    """What presses.

    Parameters
    ----------
    radius : float, m
        0.5 to 30 mm; rounded to 0.1 mm. The default is about a fingertip's.
    shape : "ball" or "flat"
        A sphere, or the flat end of a cylinder with a rounded edge.
    """

    radius: float = FINGER
    shape: str = "ball"

    def __post_init__(self) -> None:
        check_choice("shape", self.shape, SHAPES, "what presses")
        check_positive("radius", self.radius, "of the body, in metres: 4 mm is 4e-3")
        check_range("radius", self.radius, 0.5e-3, LARGEST, "of the body, in metres")
        object.__setattr__(self, "radius", round(round(float(self.radius) / STEP) * STEP, 6))

    def body(self, **load: float) -> Any:
        """As an indenter of `skinfield.simulate`, with a `force` or a `depth`."""
        if self.shape == "ball":
            return Sphere(radius=self.radius, **load)  # type: ignore[arg-type]
        edge = min(EDGE, self.radius / 2.0)
        return Cylinder(radius=self.radius, edge_radius=edge, **load)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Point:
    """Where and how hard a track presses at a moment.

    Parameters
    ----------
    time : float, s
        Since the scene began.
    x, y : float, m
        In the patch's plane.
    force : float, N
        0: lifted off.
    """

    time: float
    x: float
    y: float
    force: float


@dataclass(frozen=True)
class Track:
    """One body on one patch: straight lines between points in time.

    Parameters
    ----------
    patch : int
    tool : Tool
    points : tuple of Point
        In the order of time; before the first and behind the last nothing presses.
    """

    patch: int
    tool: Tool
    points: tuple[Point, ...]

    def __post_init__(self) -> None:
        if len(self.points) < 2:
            raise InputError(f"points has {len(self.points)}, expected two or more")
        for before, after in pairwise(self.points):
            if not before.time <= after.time:
                raise InputError(f"time {after.time} follows {before.time}, expected none earlier")

    @property
    def highest(self) -> float:
        """Largest force, N."""
        return max(point.force for point in self.points)

    def at(self, time: float) -> tuple[float, float, float] | None:
        """Place, m, and force, N, at a time; None where nothing presses."""
        points = self.points
        if not points[0].time <= time <= points[-1].time:
            return None
        for before, after in pairwise(points):
            if time <= after.time:
                span = after.time - before.time
                part = (time - before.time) / span if span > 0.0 else 1.0
                force = before.force + part * (after.force - before.force)
                if force <= 0.0:
                    return None
                x = before.x + part * (after.x - before.x)
                return x, before.y + part * (after.y - before.y), force
        return None


@dataclass(frozen=True)
class Scene:
    """Tracks, once or over and over.

    Parameters
    ----------
    name : str
    tracks : tuple of Track
    period : float, s
        After which it begins again; infinite: it is played once.
    """

    name: str
    tracks: tuple[Track, ...] = ()
    period: float = field(default=float("inf"))

    def __post_init__(self) -> None:
        if self.period != float("inf"):
            check_positive("period", self.period, "of the scene, in seconds")

    @property
    def tools(self) -> dict[tuple[int, Tool], float]:
        """Largest force, N, of each tool on each patch."""
        found: dict[tuple[int, Tool], float] = {}
        for track in self.tracks:
            key = (track.patch, track.tool)
            found[key] = max(found.get(key, 0.0), track.highest)
        return found


@dataclass
class Touch:
    """One press as it is now.

    Attributes
    ----------
    id : str
    patch : int
    tool : Tool
    x, y : float, m
    force : float, N
    """

    id: str
    patch: int
    tool: Tool
    x: float
    y: float
    force: float


def patch_index(skin: Skin, key: Any) -> int:
    """Index of a patch from its name or number; 0 for None."""
    if key is None:
        return 0
    if isinstance(key, bool) or not isinstance(key, int | str):
        raise InputError(f"patch is {key!r:.60}, expected its name, or its number from 0")
    patch = skin[key]
    return next(i for i, each in enumerate(skin.patches) if each is patch)


def number(
    fields: Mapping[str, Any], key: str, default: float | None, low: float, high: float, why: str
) -> float:
    """Finite number of a command.

    Raises
    ------
    InputError
        If there is none where one is needed, or it is out of range.
    """
    value = fields.get(key, default)
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    if not plain or not low <= value <= high:
        raise InputError(
            f"{key} is {value!r:.60}, expected a number from {low:g} to {high:g}: {why}"
        )
    return float(value)


def whole(fields: Mapping[str, Any], key: str, count: int, why: str) -> int:
    """Whole number of a command, from 0 to `count` - 1."""
    value = fields.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < count:
        raise InputError(
            f"{key} is {value!r}, expected a whole number from 0 to {count - 1}: {why}"
        )
    return value


def place_of(patch: Patch, fields: Mapping[str, Any]) -> tuple[float, float]:
    """Point of the patch's plane, m, from `x` and `y`, or `taxel`, or `face` and `weights`.

    Raises
    ------
    InputError
        If none of them is given, or not as it must be.
    """
    if "face" in fields:
        corners = patch.plane[patch.triangles[whole(fields, "face", len(patch.triangles), "of it")]]
        x, y = _weights(fields.get("weights", (1 / 3, 1 / 3, 1 / 3))) @ corners
    elif "taxel" in fields:
        x, y = patch.plane[whole(fields, "taxel", len(patch), "a row of the patch")]
    else:
        x = number(fields, "x", None, -FARTHEST, FARTHEST, "metres in the patch's plane")
        y = number(fields, "y", None, -FARTHEST, FARTHEST, "metres in the patch's plane")
    return float(x), float(y)


def _weights(fields: Any) -> Any:
    try:
        weights = np.array([float(each) for each in fields])
    except (TypeError, ValueError, OverflowError):
        weights = np.zeros(0)
    if weights.shape != (3,) or not (weights >= 0).all() or not 0 < weights.sum() < math.inf:
        raise InputError(
            f"weights is {fields!r:.60}, expected three numbers from 0, of the corners"
        )
    return weights / weights.sum()


def scene_by_name(name: str, skin: Skin, seed: int) -> Scene:
    """One of `SCENES`, fitted to the skin: in the middle of its patches.

    Raises
    ------
    InputError
        For another name.
    """
    check_choice("scene", name, SCENES, "or give a file that ends in .toml or .json")
    if name == "idle":
        return Scene(name)
    if name == "random":
        return _random(skin, np.random.default_rng(seed))
    make = {"press": _press, "slide": _slide, "two-balls": _two_balls, "tap": _tap}[name]
    tracks, period = make(skin.patches[0])
    return Scene(name, tracks, period)


def middle_of(patch: Patch) -> tuple[float, float]:
    """Place of the taxel nearest to the middle of all, m."""
    x, y = np.median(patch.plane, axis=0)
    return taxel_near(patch, float(x), float(y))


def taxel_near(patch: Patch, x: float, y: float) -> tuple[float, float]:
    """Place of the taxel nearest to a point of the plane, m."""
    near = patch.plane[np.argmin(np.hypot(*(patch.plane - [x, y]).T))]
    return float(near[0]), float(near[1])


def _press_and_lift(patch: int, tool: Tool, x: float, y: float, force: float, start: float,
          seconds: float, ramp: float = RAMP) -> Track:  # fmt: skip
    """Pressed at one place: up, held, and down again."""
    times = (start, start + ramp, start + seconds - ramp, start + seconds)
    forces = (0.0, force, force, 0.0)
    points = (Point(t, x, y, f) for t, f in zip(times, forces, strict=True))
    return Track(patch, tool, tuple(points))


def _press(patch: Patch) -> tuple[tuple[Track, ...], float]:
    x, y = middle_of(patch)
    return (_press_and_lift(0, Tool(), x, y, 1.0, 1.0, 3.0),), 5.0


def _tap(patch: Patch) -> tuple[tuple[Track, ...], float]:
    x, y = middle_of(patch)
    return (_press_and_lift(0, Tool(), x, y, 0.8, 0.5, 0.08, 0.02),), 1.0


def _slide(patch: Patch) -> tuple[tuple[Track, ...], float]:
    x, y = middle_of(patch)
    half = 0.3 * float(np.ptp(patch.plane[:, 0]))
    there = [
        Point(0.5, x - half, y, 0.0),
        Point(0.8, x - half, y, 1.0),
        Point(4.8, x + half, y, 1.0),
    ]
    back = [Point(8.8, x - half, y, 1.0), Point(9.1, x - half, y, 0.0)]
    return (Track(0, Tool(), (*there, *back)),), 10.0


def _two_balls(patch: Patch) -> tuple[tuple[Track, ...], float]:
    x, y = middle_of(patch)
    half = max(0.25 * float(np.ptp(patch.plane[:, 0])), 10e-3)
    one = _press_and_lift(0, Tool(), *taxel_near(patch, x - half, y), 1.0, 0.5, 4.0)
    other = _press_and_lift(0, Tool(), *taxel_near(patch, x + half, y), 0.6, 1.5, 4.0)
    return (one, other), 6.5


def _random(skin: Skin, rng: np.random.Generator) -> Scene:
    """Presses one after the other at random taxels, every fourth beside a second one."""
    tools, tracks = (Tool(), Tool(6e-3)), list[Track]()
    time, taxels = 0.5, np.array([len(patch) for patch in skin])
    while time < RANDOM_SECONDS - 6.0:
        seconds = 0.4 + rng.exponential(1.2)
        for late in (0.0, 0.1)[: 2 if rng.random() < 0.25 else 1]:
            patch = int(rng.choice(len(taxels), p=taxels / taxels.sum()))
            tool = tools[rng.integers(len(tools))]
            x, y = skin.patches[patch].plane[rng.integers(taxels[patch])] + rng.uniform(*OFFSET, 2)
            force = math.exp(rng.uniform(*np.log(RANDOM_FORCES)))
            tracks.append(
                _press_and_lift(patch, tool, float(x), float(y), force, time + late, seconds)
            )
        time += seconds + 0.2 + rng.exponential(0.4)
    return Scene("random", tuple(tracks), RANDOM_SECONDS)


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


def _track(fields: Any, where: str, skin: Skin) -> Track:
    _check_keys(fields, PRESS_KEYS, where)
    try:
        patch = patch_index(skin, fields.get("patch"))
        shape = fields.get("shape", "ball")
        if not isinstance(shape, str):
            raise InputError(f"shape is {shape!r}, expected 'ball' or 'flat'")
        radius = number(fields, "radius_mm", FINGER * 1e3, 0.5, 30.0, "millimetres") * 1e-3
        tool = Tool(radius, shape)
        path = fields.get("path")
        if path is not None:
            return Track(patch, tool, _points(path, fields, skin, patch))
        return Track(patch, tool, _points_at_one_place(fields, skin, patch))
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def _points_at_one_place(fields: Mapping[str, Any], skin: Skin, patch: int) -> tuple[Point, ...]:
    """Pressed at one place from `start_s` for `seconds`."""
    x, y = _place(fields, skin, patch)
    force = number(fields, "force_n", 1.0, 1e-6, 1e4, "newtons")
    start = number(fields, "start_s", 0.0, 0.0, LATEST, "seconds since the scene began")
    seconds = number(fields, "seconds", 1.0, 1e-3, LATEST, "for how long")
    ramp = min(number(fields, "ramp_s", RAMP, 0.0, LATEST, "of pressing"), seconds / 2.0)
    return _press_and_lift(patch, Tool(), x, y, force, start, seconds, ramp).points


def _points(path: Any, fields: Mapping[str, Any], skin: Skin, patch: int) -> tuple[Point, ...]:
    """Points of `path`; what one does not say is as at the point before."""
    if not isinstance(path, list) or len(path) > 100_000:
        raise InputError("path is no list, expected points such as {time_s = 0, x_mm = 1, ...}")
    now: dict[str, Any] = {key: fields[key] for key in POINT_KEYS & set(fields)}
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


def _place(fields: Mapping[str, Any], skin: Skin, patch: int) -> tuple[float, float]:
    metres: dict[str, Any] = {
        key: fields[key] for key in ("taxel", "face", "weights") if key in fields
    }
    for key in ("x", "y"):
        if f"{key}_mm" in fields:
            millimetres = number(fields, f"{key}_mm", None, -1e4, 1e4, "in the patch's plane")
            metres[key] = millimetres * 1e-3
    x, y = place_of(skin.patches[patch], metres)
    return (x, y) if math.isfinite(x + y) else (0.0, 0.0)


def _check_keys(fields: Any, known: set[str], where: str) -> None:
    if not isinstance(fields, Mapping):
        raise InputError(f"{where} is no table, expected one with {', '.join(sorted(known))}")
    unknown = sorted(set(fields) - known)
    if unknown:
        raise InputError(
            f"{where} has {unknown[0]!r:.60}, expected only {', '.join(sorted(known))}"
        )
