"""What moves over the skin: places and forces through time, and what the taxels read of it.

The layer has no border, so a press that is moved gives the readings of taxels that are moved the
other way. Readings of several balls are added up: 12 mm apart that is true to a part in a hundred
of the highest reading, and 5 mm apart to a few, as each ball then feels the other's dent.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.paper.presses import paper_patch
from skinfield.mechanics import Layer
from skinfield.simulate import Press, Sphere, press_ladder
from skinfield.simulate.pressing.anywhere import readings_anywhere

BALL = 6e-3  # m: radius
EXTENT = 16e-3  # m: side of the square in which it touches, up to FORCES' last
SPEED, LENGTH = 40e-3, 40e-3  # m/s and m: of a slide
REST = 0.4  # s: at both ends of a motion
APART, CLOSEST = 12e-3, 5e-3  # m: between two that pass each other, and between two that meet
FORCES = (0.1, 0.25, 0.5, 0.8, 1.1, 1.5, 2.0)  # N: solved; what lies between is interpolated
FAR = np.arange(0.0, 45e-3, 0.25e-3)  # m from the ball


@dataclass(frozen=True, eq=False)
class Scene:
    """Balls that touch the skin.

    Parameters
    ----------
    name : str
    places : (T, B, 2) array, m
        On the patch's plane.
    forces : (T, B) array, N
        0 where a ball does not touch.
    """

    name: str
    places: Floats
    forces: Floats

    @property
    def touches(self) -> Any:
        """Where a ball touches, (T, B) bool."""
        return self.forces > 0.0


def scenes(rate: float, seed: int) -> tuple[Scene, ...]:
    """All of them, at random places and directions.

    Parameters
    ----------
    rate : float, 1/s
        Readings per second.
    seed : int
    """
    made = (_slide(rate), _roll(rate), _cross(rate), _meet(rate), _taps(rate), _idle(rate))
    rng = np.random.default_rng([seed, 70])
    return tuple(_posed(scene, rng) for scene in made)


def _posed(scene: Scene, rng: np.random.Generator) -> Scene:
    """Turned by any angle about the patch's middle, and moved by up to 3 mm."""
    angle, shift = rng.uniform(0.0, 2 * np.pi), rng.uniform(-3e-3, 3e-3, 2)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return Scene(scene.name, scene.places @ turn + shift, scene.forces)


def _ways(*ways: Floats) -> Floats:
    """Ways along x (T,) and y as a number, as (T, B, 2)."""
    return np.stack([np.broadcast_to(way, (len(ways[0]), 2)) for way in ways], axis=1)


def _path(rate: float, length: float) -> Floats:
    """Rest, `length` m at SPEED, rest: coordinate (T,) m, about 0."""
    time = np.arange(0.0, 2 * REST + length / SPEED, 1 / rate)
    return np.clip((time - REST) * SPEED, 0.0, length) - length / 2


def _slide(rate: float) -> Scene:
    x = _path(rate, LENGTH)
    return Scene("slide", _ways(np.column_stack([x, 0 * x])), np.full((len(x), 1), 1.5))


def _roll(rate: float) -> Scene:
    """To and fro over 14 mm within 2 s, three times, while the force goes from 0.8 to 1.8 N."""
    time = np.arange(0.0, 6.0, 1 / rate)
    x = 7e-3 * np.sin(np.pi * time)
    force = 1.3 + 0.5 * np.sin(2.4 * np.pi * time)
    return Scene("roll", _ways(np.column_stack([x, 0 * x])), force[:, None])


def _cross(rate: float) -> Scene:
    """Two that pass each other side by side, 12 mm apart where they are nearest."""
    x, half = _path(rate, 30e-3), APART / 2
    ways = np.column_stack([x, 0 * x - half]), np.column_stack([-x, 0 * x + half])
    return Scene("cross", _ways(*ways), np.broadcast_to([1.5, 1.0], (len(x), 2)))


def _meet(rate: float) -> Scene:
    """Two that come as near as 5 mm and part as they came, each at 20 mm/s."""
    time = np.arange(0.0, 2 * REST + 1.2, 1 / rate)
    half = np.abs(np.clip(time - REST - 0.6, -0.6, 0.6)) * SPEED / 2 + CLOSEST / 2
    ways = np.column_stack([-half, 0 * half]), np.column_stack([half, 0 * half])
    return Scene("meet", _ways(*ways), np.broadcast_to([1.5, 1.0], (len(half), 2)))


def _taps(rate: float) -> Scene:
    """Five at one place, 8 mm from the middle: each a ball of its own, for 0.2 s every 0.5 s."""
    time = np.arange(0.0, 2.6, 1 / rate)
    since = time[:, None] - 0.1 - 0.5 * np.arange(5)
    force = np.where((since > 0) & (since < 0.2), 1.5 * np.sin(np.pi * since / 0.2), 0.0)
    place = np.broadcast_to([8e-3, 0.0], (len(time), 5, 2))
    return Scene("taps", place, np.where(force > 0.05, force, 0.0))


def _idle(rate: float) -> Scene:
    steps = int(4 * rate)
    return Scene("idle", np.zeros((steps, 1, 2)), np.zeros((steps, 1)))


@lru_cache(maxsize=4)
def _presses(layer: Layer, cell: float) -> list[Press]:
    return press_ladder(layer, Sphere(radius=BALL), FORCES, EXTENT, cell)


@lru_cache(maxsize=8)
def _table(layer: Layer, cell: float, quantity: str) -> Any:
    """What a taxel reads of a ball, as a function of force N and distance m."""
    from scipy.interpolate import RectBivariateSpline

    patch = paper_patch()
    points = np.column_stack([FAR, 0 * FAR])
    rows = [np.zeros(len(FAR))]
    for solved in _presses(layer, cell):
        rows.append(readings_anywhere(solved, patch.pad_diameter, quantity)(points))
    return RectBivariateSpline([0.0, *FORCES], FAR, np.array(rows))


def exact_readings(scene: Scene, layer: Layer, cell: float, quantity: str) -> Floats:
    """What the taxels read, (T, L), without noise."""
    table, plane = _table(layer, cell, quantity), paper_patch().plane
    total = np.zeros((len(scene.places), len(plane)))
    for ball in range(scene.forces.shape[1]):
        away = np.linalg.norm(plane[None] - scene.places[:, ball, None], axis=2)
        force = np.broadcast_to(scene.forces[:, ball, None], away.shape)
        total += table.ev(force, np.minimum(away, FAR[-1]))
    return total
