"""Simulated presses with their truth, to learn from how far a reconstruction can be trusted."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.layout import Patch
from skinfield.mechanics import BondedLayer, Layer, Mechanics
from skinfield.observation import BaseStress, Capacitance, Gap, Quantity
from skinfield.simulate import Bar, Cone, Cylinder, Sphere, press
from skinfield.simulate.pressing.anywhere import Readings, readings_anywhere

BODIES: tuple[Any, ...] = (
    Sphere(radius=3e-3),
    Sphere(radius=5e-3),
    Sphere(radius=8e-3),
    Sphere(radius=13e-3),
    Cylinder(radius=2e-3),
    Cylinder(radius=4.5e-3, edge_radius=0.5e-3),
    Cone(radius=7e-3, half_angle=np.radians(75.0)),
    Bar(length=9e-3, width=2.5e-3, edge_radius=0.5e-3),
)
LOADS = (0.1, 3.0)  # N
STEPS = 5  # loads of each body
DEEPEST = 0.7  # thicknesses: beyond, linear elasticity is no truth
CELL = 0.5e-3  # m: of the truth's grid; contacts are solved on finer squares
SPACING = 0.75e-3  # m: of the table of a press that is not round
EXTENT = 30e-3  # m: side of the square in which bodies touch
TRIES = 10_000  # places drawn at most for each press


@dataclass(frozen=True, eq=False)
class Solved:
    """One body under one load, pressed at the origin."""

    readings: Readings
    place: Floats
    force: float
    area: float


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """Presses of a patch one at a time.

    Attributes
    ----------
    readings : (N, L) array, in the quantity's unit
        Without noise.
    places : (N, 2) array, m
        Centre of pressure in the patch's plane.
    forces : (N,) array, N
    areas : (N,) array, m²
        That touch.
    angles : (N,) array, rad
        By which the bodies are turned.
    """

    readings: Floats
    places: Floats
    forces: Floats
    areas: Floats
    angles: Floats


def rehearse(
    patch: Patch,
    layer: Layer,
    mechanics: Mechanics,
    quantity: Quantity,
    presses: int,
    seed: int = 0,
    bodies: Sequence[Any] = BODIES,
) -> Rehearsal:
    """Press bodies on a patch at random places, a pitch or more inside the taxels' hull.

    A press is solved at the origin for each body and a few loads, log-uniform from 0.1 to 3 N as
    far as the layer bears it, and carried over the patch by moving and turning the taxels.

    Parameters
    ----------
    patch : Patch
    layer : Layer
    mechanics : Mechanics
        How the elastomer is held. What is no `BondedLayer` is a solver's assumption about one.
    quantity : Quantity
        `Capacitance`, `BaseStress` or `Gap`.
    presses : int
    seed : int
    bodies : sequence of Indenter
        At the origin, without a load of their own.

    Raises
    ------
    InputError
        For a quantity that the simulator does not know, or bodies that all sink through the layer.
    """
    name, pad = _spelt(quantity), patch.pad_diameter
    pad = pad if getattr(quantity, "pad_averaged", True) else 0.0
    truth = mechanics if isinstance(mechanics, BondedLayer) else BondedLayer()
    rng = np.random.default_rng([seed, 1])
    solved = [
        each
        for body in bodies
        for load in _loads(rng)
        if (each := _solved(body, load, layer, truth, pad, name)) is not None
    ]
    if not solved:
        raise InputError(f"bodies all sink through {layer}, expected some that it bears")
    order = np.resize(rng.permutation(len(solved)), presses)
    places = _places(rng, patch, presses)
    return _carried(rng, patch, [solved[index] for index in order], places)


def _carried(
    rng: np.random.Generator, patch: Patch, solved: Sequence[Solved], places: Floats
) -> Rehearsal:
    angles = rng.uniform(0.0, 2 * np.pi, len(solved))
    cos, sin = np.cos(angles), np.sin(angles)
    turns = np.stack([np.stack([cos, -sin], axis=-1), np.stack([sin, cos], axis=-1)], axis=-2)
    rows = [
        each.readings((patch.plane - place) @ turn)
        for each, place, turn in zip(solved, places, turns, strict=True)
    ]
    centres = [
        turn @ each.place + place for each, place, turn in zip(solved, places, turns, strict=True)
    ]
    forces = np.array([each.force for each in solved])
    areas = np.array([each.area for each in solved])
    return Rehearsal(np.array(rows), np.array(centres), forces, areas, angles)


def _spelt(quantity: Quantity) -> str:
    for kind, name in ((Capacitance, "capacitance"), (BaseStress, "stress"), (Gap, "gap")):
        if isinstance(quantity, kind):
            return name
    raise InputError(
        f"quantity is {quantity!r}, expected Capacitance(), BaseStress() or Gap(): the simulator "
        "knows what those taxels read"
    )


def _loads(rng: np.random.Generator) -> Floats:
    """Log-uniform, one in each equal part of the range."""
    share = (np.arange(STEPS) + rng.uniform(size=STEPS)) / STEPS
    return np.asarray(LOADS[0] * (LOADS[1] / LOADS[0]) ** share)


@lru_cache(maxsize=256)
def _solved(
    body: Any, load: float, layer: Layer, mechanics: Mechanics, pad: float, quantity: str
) -> Solved | None:
    """None where the body sinks deeper than linear elasticity holds."""
    try:
        found = press(layer, [replace(body, force=float(load))], EXTENT, CELL, mechanics)
    except InputError as error:
        if "sink" not in str(error):
            raise
        return None
    if found.approach[0] > DEEPEST * layer.thickness:
        return None
    about_x, about_y, _ = found.moments[0]  # of a push: (-y, x) times the force
    place = np.array([about_y, -about_x]) / found.force
    anywhere = readings_anywhere(found, pad, quantity, SPACING)
    return Solved(anywhere, place, found.force, found.contact_area)


def _places(rng: np.random.Generator, patch: Patch, count: int) -> Floats:
    """Uniform over the places whose surroundings, a pitch wide, lie in the taxels' hull."""
    from skinfield.layout.hull import inside_hull

    low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
    around = patch.pitch * np.array([(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)])
    found: list[Floats] = []
    for _ in range(max(TRIES // 100, 1)):
        drawn = rng.uniform(low, high, (count, 2))
        inside = inside_hull(patch.plane, (drawn[:, None] + around).reshape(-1, 2))
        found += list(drawn[inside.reshape(count, -1).all(axis=1)])
        if len(found) >= count:
            return np.array(found[:count])
    taxels = patch.plane[rng.integers(len(patch), size=count)]  # too small to have an inside
    return taxels + patch.pitch / 2 * rng.uniform(-1.0, 1.0, (count, 2))
