"""Scenes that are there from the beginning."""

import math

import numpy as np

from skinfield.errors import check_choice
from skinfield.layout import Patch, Skin
from skinfield.virtual.tool import Tool
from skinfield.virtual.touch import Point, Scene, Track

SCENES = ("idle", "press", "slide", "two-balls", "tap", "random")
RANDOM_SECONDS = 600.0  # after which the random scene begins again
RANDOM_TOOLS = (Tool(), Tool(6e-3))
RANDOM_FORCES = (0.2, 3.0)  # N
BESIDE = (-2e-3, 2e-3)  # m: from the taxel, in x and y
RAMP = 0.1  # s of pressing and of lifting off


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


def _held(patch: int, tool: Tool, x: float, y: float, force: float, start: float,
          seconds: float, ramp: float = RAMP) -> Track:  # fmt: skip
    """Pressed at one place: up, held, and down again."""
    times = (start, start + ramp, start + seconds - ramp, start + seconds)
    forces = (0.0, force, force, 0.0)
    points = (Point(t, x, y, f) for t, f in zip(times, forces, strict=True))
    return Track(patch, tool, tuple(points))


def _press(patch: Patch) -> tuple[tuple[Track, ...], float]:
    x, y = middle_of(patch)
    return (_held(0, Tool(), x, y, 1.0, 1.0, 3.0),), 5.0


def _tap(patch: Patch) -> tuple[tuple[Track, ...], float]:
    x, y = middle_of(patch)
    return (_held(0, Tool(), x, y, 0.8, 0.5, 0.08, 0.02),), 1.0


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
    one = _held(0, Tool(), *taxel_near(patch, x - half, y), 1.0, 0.5, 4.0)
    other = _held(0, Tool(), *taxel_near(patch, x + half, y), 0.6, 1.5, 4.0)
    return (one, other), 6.5


def _random(skin: Skin, rng: np.random.Generator) -> Scene:
    """Presses one after the other at random taxels, every fourth beside a second one."""
    tracks: list[Track] = []
    time, taxels = 0.5, np.array([len(patch) for patch in skin])
    while time < RANDOM_SECONDS - 6.0:
        seconds = 0.4 + rng.exponential(1.2)
        for late in (0.0, 0.1)[: 2 if rng.random() < 0.25 else 1]:
            patch = int(rng.choice(len(taxels), p=taxels / taxels.sum()))
            tool = RANDOM_TOOLS[rng.integers(len(RANDOM_TOOLS))]
            x, y = skin.patches[patch].plane[rng.integers(taxels[patch])] + rng.uniform(*BESIDE, 2)
            force = math.exp(rng.uniform(*np.log(RANDOM_FORCES)))
            tracks.append(_held(patch, tool, float(x), float(y), force, time + late, seconds))
        time += seconds + 0.2 + rng.exponential(0.4)
    return Scene("random", tuple(tracks), RANDOM_SECONDS)
