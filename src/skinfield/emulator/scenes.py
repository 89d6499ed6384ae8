"""Scenes of presses over time, by name or of files; bodies that press, and places on a skin."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, NamedTuple, cast

import numpy as np

from skinfield.errors import FileError, Floats, InputError, check_choice, check_count, check_range
from skinfield.settings import Range, Section, text_of_file, value_from_json, value_from_toml
from skinfield.simulate import Cylinder, Finger, HeightMap, Sphere
from skinfield.simulate.habits import HABITS, REAL
from skinfield.skin import Patch, Skin

SOFT = dict(zip(("finger", "oval", "lobes"), HABITS[REAL].fingers, strict=True))
STAMPS = {  # flat faces, whose border has these corners, in half heights: strokes are half of one
    "L": ((-0.75, -1), (0.75, -1), (0.75, -0.5), (-0.25, -0.5), (-0.25, 1), (-0.75, 1)),
    "T": (
        (-0.25, -1), (0.25, -1), (0.25, 0.5), (0.75, 0.5), (0.75, 1), (-0.75, 1), (-0.75, 0.5),
        (-0.25, 0.5),
    ),
}  # fmt: skip
PUSHED = ("ball", "flat")  # that can be pushed along the skin
FRICTION = 0.5  # of the force into the skin: up to there they stick
PIXELS = 80  # of a stamp's height
SHAPES = ("ball", "flat", *SOFT, *STAMPS)
FINGER = 10e-3  # m: about that of a fingertip
EDGE = 0.5e-3  # m: rounding of a flat end, at most
LARGEST = 30e-3  # m
STEP = 0.1e-3  # m: radii are rounded to it, so that a dragged slider makes no thousand tables

FARTHEST = 10.0  # m: no skin is larger
SCENES = ("idle", "press", "slide", "two-balls", "tap", "random")
RANDOM_SECONDS = 600.0  # after which the random scene begins again
RANDOM_FORCES = (0.2, 3.0)  # N
OFFSET = (-2e-3, 2e-3)  # m: from the taxel, in x and y
LATEST = 1e7  # s
Metres = Annotated[
    float | None, Range(-FARTHEST, FARTHEST, "metres in the patch's plane, or give a taxel")
]
Millimetres = Annotated[float | None, Range(-1e4, 1e4, "millimetres in the patch's plane")]
Seconds = Annotated[float | None, Range(0.0, LATEST, "seconds since the scene began")]
THIRDS = (1 / 3, 1 / 3, 1 / 3)


@dataclass(frozen=True)
class SceneTool:
    """What presses.

    Parameters
    ----------
    radius : float, m
        0.5 to 30 mm; rounded to 0.1 mm. The default is about a fingertip's. Half the height of a
        letter.
    shape : "ball", "flat", "finger", "oval", "lobes", "L" or "T"
        A sphere, or the flat end of a cylinder with a rounded edge; or one of the soft fingers of
        real habits, round, oval or with two lobes along the patch's x, as large as the radius is to
        10 mm; or a stamp, upright along the patch's y.
    pushed : bool
        Whether what is meant is what a push along the skin adds to its press.
    """

    radius: float = FINGER
    shape: str = "ball"
    pushed: bool = False

    def __post_init__(self) -> None:
        check_choice("shape", self.shape, SHAPES, "what presses")
        check_range("radius", self.radius, 0.5e-3, LARGEST, "of the body in metres: 4 mm is 4e-3")
        object.__setattr__(self, "radius", round(round(float(self.radius) / STEP) * STEP, 6))

    @property
    def is_soft(self) -> bool:
        """Whether it yields: a finger."""
        return self.shape in SOFT

    @property
    def border(self) -> Floats:
        """Corners of a stamp's face, closed, (N, 2) m about its middle; of others there is none."""
        corners = STAMPS.get(self.shape, ())
        return self.radius * np.array([*corners, *corners[:1]], float).reshape(-1, 2)

    @property
    def parts(self) -> tuple[tuple[float, float], ...]:
        """Where along x, m, its `body` presses, with which part of the force each.

        An oval is three round ones in a row.
        """
        if not self.is_soft:
            return ((0.0, 1.0),)
        finger, size = SOFT[self.shape], self.radius / FINGER
        half = ((finger.length or finger.width) - finger.width) / 2.0
        row = (-half, 0.0, half) if half > 0.0 else (0.0,)
        lobes = zip(finger.along, finger.shares, strict=True)
        return tuple((size * (x + dx), part / len(row)) for x, part in lobes for dx in row)

    def body(self, **load: float) -> Any:
        """As an indenter of `skinfield.simulate`, with a `force` or a `depth`."""
        if self.is_soft:
            return Finger(width=SOFT[self.shape].width * self.radius / FINGER, **load)  # type: ignore[arg-type]
        if self.shape in STAMPS:
            return self._stamp(**load)
        if self.shape == "ball":
            return Sphere(radius=self.radius, **load)  # type: ignore[arg-type]
        edge = min(EDGE, self.radius / 2.0)
        return Cylinder(radius=self.radius, edge_radius=edge, **load)  # type: ignore[arg-type]

    def _stamp(self, **load: float) -> HeightMap:
        """Flat where a line to the right crosses the border an odd number of times."""
        pixel = 2.0 * self.radius / PIXELS
        axis = (np.arange(PIXELS) - (PIXELS - 1) / 2.0) * pixel
        x, y = np.meshgrid(axis, axis)
        inside = np.zeros(x.shape, np.bool_)
        for (ax, ay), (bx, by) in pairwise(self.border.tolist()):
            if ay != by:
                inside ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) * (bx - ax) / (by - ay))
        return HeightMap(heights=np.where(inside, 0.0, np.nan), pixel=pixel, **load)  # type: ignore[arg-type]


class Point(NamedTuple):
    """Where and how hard a track presses at a moment.

    Attributes
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
class BodyPath:
    """One body on one patch: straight lines between points in time.

    Parameters
    ----------
    patch : int
    tool : SceneTool
    points : tuple of Point
        In the order of time; before the first and behind the last nothing presses.
    """

    patch: int
    tool: SceneTool
    points: tuple[Point, ...]

    def __post_init__(self) -> None:
        if len(self.points) < 2:
            raise InputError(f"points has {len(self.points)}, expected two or more")
        for before, after in pairwise(self.points):
            if not before.time <= after.time:
                raise InputError(f"time {after.time} follows {before.time}, expected none earlier")

    def at(self, time: float) -> tuple[float, float, float] | None:
        """Place, m, and force, N, at a time; None where nothing presses."""
        times, *columns = zip(*self.points, strict=True)
        if not times[0] <= time <= times[-1]:
            return None
        x, y, force = (float(np.interp(time, times, column)) for column in columns)
        return (x, y, force) if force > 0.0 else None


@dataclass(frozen=True)
class Scene:
    """Tracks, once or over and over.

    Parameters
    ----------
    name : str
    tracks : tuple of BodyPath
    period : float, s
        After which it begins again; infinite: it is played once.
    """

    name: str
    tracks: tuple[BodyPath, ...] = ()
    period: float = math.inf

    @property
    def tools(self) -> dict[tuple[int, SceneTool], float]:
        """Largest force, N, of each tool on each patch."""
        found: dict[tuple[int, SceneTool], float] = {}
        for track in self.tracks:
            key, highest = (track.patch, track.tool), max(point.force for point in track.points)
            found[key] = max(found.get(key, 0.0), highest)
        return found


@dataclass
class CurrentPress:
    """One press as it is now: at x, y, m, of a patch's plane, with a force, N.

    `contact_radius`, m, is known once its table is; `shear` is the force along x and y, N.
    """

    id: str
    patch: int
    tool: SceneTool
    x: float
    y: float
    force: float
    contact_radius: float = 0.0
    shear: tuple[float, float] = (0.0, 0.0)

    def check_shear(self) -> None:
        """Raise InputError for a push that slides, or of a body that is not pushed here."""
        size = math.hypot(*self.shear)
        if size > 0.0 and self.tool.shape not in PUSHED:
            raise InputError(
                f"shear is {self.shear} of a {self.tool.shape}, expected none: only "
                f"{' and '.join(PUSHED)} are pushed along the skin here"
            )
        if not size <= FRICTION * self.force * (1.0 + 1e-9):
            raise InputError(
                f"shear is {size:.3g} N beside {self.force:g} N, expected at most {FRICTION:g} "
                "times the force into the skin: beyond that it slides"
            )


def patch_index(skin: Skin, key: str | int | None) -> int:
    """Index of a patch from its name or number; 0 for None."""
    patch = skin[0 if key is None else key]
    return next(i for i, each in enumerate(skin.patches) if each is patch)


@dataclass(frozen=True, kw_only=True)
class Place(Section):
    """Place on a patch: a point of its plane, a taxel, or a point of a triangle.

    Parameters
    ----------
    x, y : float, m
    taxel : int
        Row of the patch.
    face : int
        Of the patch's triangles.
    weights : three floats
        Of its corners.
    """

    x: Metres = None
    y: Metres = None
    taxel: int | None = None
    face: int | None = None
    weights: tuple[float, float, float] = THIRDS

    def on(self, patch: Patch) -> tuple[float, float]:
        """Point of the patch's plane, m.

        Raises
        ------
        InputError
            If it is nowhere on this patch.
        """
        if self.face is not None:
            weights = np.array(self.weights)
            if not (weights >= 0).all() or not 0 < weights.sum() < math.inf:
                raise self.wrong("weights", "three numbers from 0, of the corners")
            check_count("face", self.face, 0, len(patch.triangles) - 1, "of the patch")
            x, y = weights / weights.sum() @ patch.plane[patch.triangles[self.face]]
        elif self.taxel is not None:
            check_count("taxel", self.taxel, 0, len(patch) - 1, "a row of the patch")
            x, y = patch.plane[self.taxel]
        elif self.x is None or self.y is None:
            missing = "x" if self.x is None else "y"
            raise self.wrong(missing, "a number: metres in the patch's plane, or a taxel")
        else:
            x, y = self.x, self.y
        return float(x), float(y)


@dataclass(frozen=True, kw_only=True)
class PathPoint(Section):
    """Point of a path in a scene's file; what it does not say is as at the point before."""

    time_s: Seconds = None
    x_mm: Millimetres = None
    y_mm: Millimetres = None
    taxel: int | None = None
    face: int | None = None
    weights: tuple[float, float, float] | None = None
    force_n: Annotated[float | None, Range(0.0, 1e4, "newtons")] = None

    def after(self, before: "PathPoint") -> "PathPoint":
        """A point with what this one does not say."""
        if self.x_mm is not None or self.y_mm is not None:
            before = replace(before, taxel=None, face=None)
        mine = {key: value for key, value in vars(self).items() if value is not None}
        return replace(before, **mine)

    def on(self, patch: Patch) -> tuple[float, float]:
        """Place on a patch, m."""
        x, y = (None if each is None else 1e-3 * each for each in (self.x_mm, self.y_mm))
        its = {"x": x, "y": y, "taxel": self.taxel, "face": self.face}
        return Place(**its, weights=self.weights or THIRDS).on(patch)  # type: ignore[arg-type]


@dataclass(frozen=True, kw_only=True)
class PressEntry(PathPoint):
    """Press in a scene's file; see docs/how-to/virtual-skin.md."""

    patch: str | int | None = None
    shape: str = "ball"
    radius_mm: float = FINGER * 1e3
    start_s: Seconds = 0.0
    seconds: Annotated[float, Range(1e-3, LATEST, "for how long")] = 1.0
    ramp_s: Annotated[float, Range(0.0, LATEST, "of pressing")] = 0.1
    path: tuple[PathPoint, ...] = ()

    def track(self, skin: Skin) -> BodyPath:
        """What presses when and where."""
        place = patch_index(skin, self.patch)
        patch, tool = skin.patches[place], SceneTool(1e-3 * self.radius_mm, self.shape)
        if not self.path:
            force = 1.0 if self.force_n is None else self.force_n
            return _held(place, tool, self.on(patch), force, self.start_s or 0.0, self.seconds,
                         min(self.ramp_s, self.seconds / 2.0))  # fmt: skip
        points, now = list[Point](), cast(PathPoint, self)
        for each in self.path:
            now = each.after(now)
            if now.time_s is None:
                raise now.wrong("time_s", "seconds since the scene began")
            points.append(
                Point(now.time_s, *now.on(patch), 1.0 if now.force_n is None else now.force_n)
            )
        return BodyPath(place, tool, tuple(points))


@dataclass(frozen=True, kw_only=True)
class SceneFile(Section):
    """A scene's file; see docs/how-to/virtual-skin.md."""

    repeat_s: Annotated[float | None, Range(1e-3, LATEST, "seconds")] = None
    press: tuple[PressEntry, ...] = ()

    def scene(self, name: str, skin: Skin) -> Scene:
        """The scene on a skin."""
        tracks = []
        for index, entry in enumerate(self.press):
            try:
                tracks.append(entry.track(skin))
            except InputError as error:
                raise InputError(f"press[{index}]: {error}") from error
        return Scene(name, tuple(tracks), self.repeat_s or math.inf)


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
    patch = skin.patches[0]
    x, y = _taxel_near(patch, *np.median(patch.plane, axis=0))
    if name == "press":
        return Scene(name, (_held(0, SceneTool(), (x, y), 1.0, 1.0, 3.0),), 5.0)
    if name == "tap":
        return Scene(name, (_held(0, SceneTool(), (x, y), 0.8, 0.5, 0.08, 0.02),), 1.0)
    width = float(np.ptp(patch.plane[:, 0]))
    if name == "slide":
        there = ((0.5, -1, 0.0), (0.8, -1, 1.0), (4.8, 1, 1.0), (8.8, -1, 1.0), (9.1, -1, 0.0))
        points = (Point(time, x + 0.3 * width * side, y, force) for time, side, force in there)
        return Scene(name, (BodyPath(0, SceneTool(), tuple(points)),), 10.0)
    half = max(0.25 * width, 10e-3)
    one = _held(0, SceneTool(), _taxel_near(patch, x - half, y), 1.0, 0.5, 4.0)
    other = _held(0, SceneTool(), _taxel_near(patch, x + half, y), 0.6, 1.5, 4.0)
    return Scene(name, (one, other), 6.5)


def with_fingers(scene: Scene, seed: int) -> Scene:
    """The same scene by soft fingers of several kinds in the place of its bodies."""
    rng, kinds = np.random.default_rng([seed, 6]), list(SOFT)
    tracks = [
        replace(each, tool=SceneTool(each.tool.radius, kinds[rng.integers(len(kinds))]))
        for each in scene.tracks
    ]
    return replace(scene, tracks=tuple(tracks))


def _taxel_near(patch: Patch, x: float, y: float) -> tuple[float, float]:
    """Place of the taxel nearest to a point of the plane, m."""
    near = patch.plane[np.argmin(np.hypot(*(patch.plane - [x, y]).T))]
    return float(near[0]), float(near[1])


def _held(patch: int, tool: SceneTool, place: tuple[float, float], force: float, start: float,
          seconds: float, ramp: float = 0.1) -> BodyPath:  # fmt: skip
    """Pressed at one place: up, held, and down again."""
    times = (start, start + ramp, start + seconds - ramp, start + seconds)
    forces = (0.0, force, force, 0.0)
    points = (Point(t, *place, f) for t, f in zip(times, forces, strict=True))
    return BodyPath(patch, tool, tuple(points))


def _random(skin: Skin, rng: np.random.Generator) -> Scene:
    """Presses one after the other at random taxels, every fourth beside a second one."""
    tools, tracks = (SceneTool(), SceneTool(6e-3)), list[BodyPath]()
    time, taxels = 0.5, np.array([len(patch) for patch in skin])
    while time < RANDOM_SECONDS - 6.0:
        seconds = 0.4 + rng.exponential(1.2)
        for late in (0.0, 0.1)[: 2 if rng.random() < 0.25 else 1]:
            patch = int(rng.choice(len(taxels), p=taxels / taxels.sum()))
            tool = tools[rng.integers(len(tools))]
            x, y = skin.patches[patch].plane[rng.integers(taxels[patch])] + rng.uniform(*OFFSET, 2)
            force = math.exp(rng.uniform(*np.log(RANDOM_FORCES)))
            place = float(x), float(y)
            tracks.append(_held(patch, tool, place, force, time + late, seconds))
        time += seconds + 0.2 + rng.exponential(0.4)
    return Scene("random", tuple(tracks), RANDOM_SECONDS)


def scene_from_text(text: str, skin: Skin, seed: int) -> Scene:
    """A scene that is there by its name, or one from a ``.toml`` or ``.json`` file.

    A file holds a list `press`, and `repeat_s` if it is played over and over.

    Raises
    ------
    InputError, FileError
        If there is none, or the file cannot be used; the message names the entry.
    """
    path = Path(text)
    kind = path.suffix.lower()
    if text in SCENES or kind not in (".toml", ".json"):
        return scene_by_name(text, skin, seed)
    content = text_of_file(text)
    try:
        if kind == ".json":
            file = value_from_json(SceneFile, content)
        else:
            file = value_from_toml(SceneFile, content, text)
        return file.scene(path.stem, skin)
    except FileError:
        raise
    except InputError as error:
        raise FileError(f"{text}: {error}") from error
