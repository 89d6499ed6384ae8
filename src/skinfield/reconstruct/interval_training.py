"""Training of intervals: from simulated presses, how far contacts are from the truth."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import BaseStress, BondedLayer, Capacitance, Gap, Layer, Mechanics, Quantity
from skinfield.errors import Floats, InputError
from skinfield.estimate import Contact, Estimate
from skinfield.reconstruct.intervals import (
    LEAST,
    Group,
    Intervals,
    Ratio,
    features_of,
    relative_deviation,
)
from skinfield.simulate import Bar, Cone, Cylinder, Sphere, press
from skinfield.simulate.pressing.press import Readings, readings_anywhere
from skinfield.skin import Patch

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
READ = {Capacitance: "capacitance", BaseStress: "stress", Gap: "gap"}
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
    name = next((name for kind, name in READ.items() if isinstance(quantity, kind)), None)
    if name is None:
        raise InputError(
            f"quantity is {quantity!r}, expected Capacitance(), BaseStress() or Gap(): the "
            "simulator knows what those taxels read"
        )
    pad = patch.pad_diameter
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
    each = list(zip(solved, places, turns, strict=True))
    return Rehearsal(
        readings=np.array(
            [one.readings((patch.plane - place) @ turn) for one, place, turn in each]
        ),
        places=np.array([turn @ one.place + place for one, place, turn in each]),
        forces=np.array([one.force for one in solved]),
        areas=np.array([one.area for one in solved]),
        angles=angles,
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
    from skinfield.skin.geometry import inside_hull

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


GATE = 8e-3  # m: farther away, a contact is not that of the press
TRAINING = 1 / 3  # of the presses; the others make the quantiles
GROUPS = 3
FLOORS = np.concatenate([[0.0], np.geomspace(1e-3, 3.0, 48)])  # relative deviations that are tried
PITCHES = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 48)])  # the same for places
AGREED = 1e-3  # of ln(true / stated), below which an error counts in full in the fit of the centre


@dataclass(frozen=True, eq=False)
class Lesson:
    """What was stated of N presses that were found, and what was true.

    Attributes
    ----------
    stated : (N,) array, N
        Force.
    deviation : (N,) array
        Stated relative deviation of the force.
    blocks : (N, 2, 2) array, m²
        Stated covariance of the place.
    force, area : (N,) arrays
        ln(true / stated).
    place : (N, 2) array, m
        True less stated.
    """

    stated: Floats
    deviation: Floats
    blocks: Floats
    force: Floats
    area: Floats
    place: Floats

    @property
    def features(self) -> Floats:
        """See `features_of`, (N, 3)."""
        return features_of(self.deviation, self.stated)

    def __len__(self) -> int:
        return len(self.force)

    def part(self, rows: NDArray[Any]) -> "Lesson":
        """Some of the presses, by a mask or a slice."""
        return Lesson(*(values[rows] for values in vars(self).values()))


def learn(
    solve: Callable[[Floats], Estimate],
    patch: Patch,
    rehearsal: Rehearsal,
    noise: Floats,
    solver: str,
    quantity: str,
    seed: int = 0,
) -> Intervals:
    """Learn intervals.

    Parameters
    ----------
    solve : function of readings (L,)
        Estimate from one reading, without any before.
    patch : Patch
    rehearsal : Rehearsal
    noise : (L,) array, in the quantity's unit
        Standard deviation of one reading.
    solver, quantity : str
        To be kept with the intervals.
    seed : int
        Of the noise.

    Raises
    ------
    InputError
        If so few presses are found that there is no 90 % interval.
    """
    rng = np.random.default_rng([seed, 2])
    readings = rehearsal.readings + noise * rng.standard_normal(rehearsal.readings.shape)
    lesson = _lesson(solve, patch, rehearsal, readings)
    needed = int(np.ceil(LEAST / (1 - TRAINING))) + 1
    if len(lesson) < needed:
        raise InputError(
            f"presses is {len(readings)}, of which {len(lesson)} were found, expected {needed} or "
            "more: give more presses, or less noise"
        )
    split = int(len(lesson) * TRAINING)
    training, rest = lesson.part(np.arange(split)), lesson.part(np.arange(split, len(lesson)))
    force, area = _ratio(training, training.force), _ratio(training, training.area)
    floor = _place_floor(training, patch.pitch)
    edges = _edges(rest.deviation)
    which = np.searchsorted(edges, rest.deviation)
    parts = [rest.part(which == group) for group in range(len(edges) + 1)]
    return Intervals(
        solver=solver,
        quantity=quantity,
        taxels=len(patch),
        noise_std=float(noise.mean()),
        presses=len(readings),
        detected=len(lesson),
        force=force,
        area=area,
        place_floor=floor,
        edges=edges,
        groups=tuple(_group(part, force, area, floor) for part in parts),
    )


def _lesson(
    solve: Callable[[Floats], Estimate], patch: Patch, rehearsal: Rehearsal, readings: Floats
) -> Lesson:
    positions = patch.surface.position_from_plane(rehearsal.places)
    frames = patch.surface.frame_from_plane(rehearsal.places)
    rows = []
    for row, reading in enumerate(readings):
        contact = nearest(solve(reading).contacts, positions[row])
        if contact is None:
            continue
        rows.append(
            (
                contact.normal_force,
                relative_deviation(contact),
                contact.covariance[:2, :2],
                np.log(rehearsal.forces[row] / contact.normal_force),
                np.log(rehearsal.areas[row] / contact.area),
                (positions[row] - contact.position) @ frames[row][:, :2],
            )
        )
    columns = zip(*rows, strict=True) if rows else [()] * 6
    return Lesson(*(np.array(column) for column in columns))


def nearest(contacts: tuple[Contact, ...], position: Floats) -> Contact | None:
    """Contact nearest to the true position (3,) m, if it is within the gate and presses."""
    pressing = [each for each in contacts if each.normal_force > 0.0 and each.area > 0.0]
    apart = [float(np.linalg.norm(each.position - position)) for each in pressing]
    return pressing[int(np.argmin(apart))] if apart and min(apart) <= GATE else None


def _ratio(lesson: Lesson, errors: Floats) -> Ratio:
    """Centre by a regression that outliers do not rule; the floor that gives short intervals."""
    from scipy.optimize import least_squares

    start = np.array([np.median(errors), 0.0, 0.0])
    size = max(float(np.median(np.abs(errors - start[0]))), AGREED)

    def wrong(weights: Floats) -> Floats:
        return np.asarray((errors - lesson.features @ weights) / size)

    centre = least_squares(wrong, start, loss="soft_l1").x
    missing = errors - lesson.features @ centre
    costs = []
    for floor in FLOORS:
        sizes = np.hypot(lesson.deviation, floor)
        low, high = np.quantile(missing / sizes, [0.05, 0.95])
        costs.append(np.log(sizes).mean() + np.log(max(high - low, 1e-12)))
    return Ratio(centre=centre, floor=float(FLOORS[int(np.argmin(costs))]))


def _place_floor(lesson: Lesson, pitch: float) -> float:
    costs = []
    for floor in PITCHES * pitch:
        blocks = lesson.blocks + max(floor, 1e-9) ** 2 * np.eye(2)
        reach = np.quantile(_metric(lesson.place, blocks), 0.9)
        costs.append(np.log(np.linalg.det(blocks)).mean() / 4 + np.log(max(reach, 1e-12)))
    return float(max(PITCHES[int(np.argmin(costs))] * pitch, 1e-9))


def _metric(errors: Floats, blocks: Floats) -> Floats:
    """Root of e^T C^-1 e for errors (N, 2) and covariances (N, 2, 2)."""
    solved = np.linalg.solve(blocks, errors[:, :, None])[:, :, 0]
    return np.asarray(np.sqrt(np.maximum((errors * solved).sum(axis=1), 0.0)))


def _edges(deviation: Floats) -> Floats:
    """Where groups are cut, so that each has enough presses: many may be equally sure."""
    kept: list[float] = []
    below = 0
    for share in np.arange(1, GROUPS) / GROUPS:
        edge = float(np.quantile(deviation, share)) * (1 + 1e-9)
        here = int((deviation <= edge).sum())
        if here - below >= LEAST and len(deviation) - here >= LEAST:
            kept.append(edge)
            below = here
    return np.array(kept)


def _group(lesson: Lesson, force: Ratio, area: Ratio, floor: float) -> Group:
    force_size = np.hypot(lesson.deviation, force.floor)
    area_size = np.hypot(lesson.deviation, area.floor)
    blocks = lesson.blocks + floor**2 * np.eye(2)
    width = np.sqrt(np.trace(blocks, axis1=1, axis2=2) / 2)
    return Group(
        force=np.sort((lesson.force - lesson.features @ force.centre) / force_size),
        area=np.sort((lesson.area - lesson.features @ area.centre) / area_size),
        force_size=np.sort(np.abs(np.expm1(lesson.force)) / force_size),
        place=np.sort(_metric(lesson.place, blocks)),
        distance=np.sort(np.linalg.norm(lesson.place, axis=1) / width),
    )
