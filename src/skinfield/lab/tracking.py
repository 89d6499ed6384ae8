"""Tracking benchmark: scenes of moving contacts, and which ball each contact belongs to."""

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import BaseStress, Capacitance, Layer, Quantity
from skinfield.errors import Floats
from skinfield.estimate import Contact, Estimate, TrackedContact, Tracker
from skinfield.lab.paper import paper_patch
from skinfield.lab.report import Settings
from skinfield.reconstruct import Reconstructor
from skinfield.simulate import Press, Sphere, press_ladder
from skinfield.simulate.pressing.press import readings_anywhere
from skinfield.skin import Grid
from skinfield.solve import ContactFit, GaussianField, Solver

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


QUANTITIES: dict[str, tuple[Quantity, float]] = {  # with the noise of one reading
    "capacitance": (Capacitance(), 0.002),
    "stress": (BaseStress(), 400.0),
}
SOLVERS: dict[str, Callable[[], Solver]] = {
    "ContactFit": ContactFit,
    "GaussianField": GaussianField,
}
TRACKER, NEAREST, ANEW = "Tracker", "nearest one before", "a new number each reading"
NEAR = 5e-3  # m: within which the nearest one before is taken for the same
GATE = 8e-3  # m: farther from every ball, a contact is false

Numbered = Sequence[tuple[int, Contact]]


@dataclass(frozen=True, eq=False)
class Hit:
    """A contact that belongs to a ball.

    Parameters
    ----------
    index : int
        Of the reading.
    ball, number : int
    contact : Contact
    off : (2,) array, m
        From the ball to the contact.
    force : float, N
        True.
    """

    index: int
    ball: int
    number: int
    contact: Contact
    off: Floats
    force: float


@dataclass
class Numbering:
    """What is known of one way to number contacts, reading by reading."""

    hits: list[Hit] = field(default_factory=list)
    others: list[tuple[int, int, Contact]] = field(default_factory=list)
    last: dict[int, int] = field(default_factory=dict)
    missed: int = 0
    readings: int = 0

    def add(
        self,
        balls: NDArray[np.int64],
        places: Floats,
        forces: Floats,
        gate: float,
        found: Sequence[tuple[int, Contact]],
    ) -> None:
        """Take up a reading: balls (B,) at places (B, 2) m, and contacts with their numbers.

        A ball keeps the number that it had while that contact is nearer than `gate` m; the others
        go with at most one contact each, as many as there are, and then the nearest.
        """
        index, self.readings = self.readings, self.readings + 1
        taken: set[int] = set()
        if len(balls) and found:
            seen = np.array([contact.position[:2] for _, contact in found])
            away = np.linalg.norm(places[:, None] - seen[None], axis=2)
            for row, column in self._pairs(balls, away, [number for number, _ in found], gate):
                number, contact = found[column]
                off, force, ball = seen[column] - places[row], float(forces[row]), int(balls[row])
                self.hits.append(Hit(index, ball, number, contact, off, force))
                self.last[ball] = number
                taken.add(column)
        self.missed += len(balls) - len(taken)
        for at, (number, contact) in enumerate(found):
            if at not in taken:
                self.others.append((index, number, contact))

    def _pairs(
        self, balls: NDArray[np.int64], away: Floats, numbers: Sequence[int], gate: float
    ) -> list[tuple[int, int]]:
        from scipy.optimize import linear_sum_assignment

        beyond = gate * (min(away.shape) + 2)
        cost = np.where(away <= gate, away, beyond)
        for row, ball in enumerate(balls.tolist()):
            last = self.last.get(ball)
            if last in numbers and away[row, numbers.index(last)] <= gate:
                cost[row, numbers.index(last)] = -beyond  # whatever else is nearer
        rows, columns = linear_sum_assignment(cost)
        pairs = zip(rows.tolist(), columns.tolist(), strict=True)
        return [(row, column) for row, column in pairs if away[row, column] <= gate]

    def as_lines(self) -> dict[str, list[list[float]]]:
        """For each number its readings: index, x and y in mm, force in N."""
        lines: dict[str, list[list[float]]] = defaultdict(list)
        every = [(hit.index, hit.number, hit.contact) for hit in self.hits]
        for index, number, contact in sorted([*every, *self.others], key=lambda one: one[0]):
            x, y = (1e3 * contact.position[:2]).round(3).tolist()
            lines[str(number)].append([index, x, y, round(contact.normal_force, 4)])
        return dict(lines)


@dataclass(frozen=True)
class Switches:
    """Counts of one run, after CLEAR MOT (Bernardin and Stiefelhagen 2008).

    Parameters
    ----------
    switches : int
        Readings in which a ball has another number than when it was seen last.
    whole : int
        Balls that have one number from the first to the last.
    missed, false : int
        Balls without a contact, and contacts without a ball, summed over the readings.
    coasting : int
        Contacts without a ball that are foretold and not seen; they are not among the false.
    """

    switches: int
    whole: int
    missed: int
    false: int
    coasting: int

    @classmethod
    def of(cls, numbering: Numbering) -> "Switches":
        """Count them."""
        numbers: dict[int, list[int]] = defaultdict(list)
        for hit in numbering.hits:
            numbers[hit.ball].append(hit.number)
        changes = {ball: sum(a != b for a, b in pairwise(each)) for ball, each in numbers.items()}
        whole = sum(count == 0 for count in changes.values())
        others = [contact for *_, contact in numbering.others]
        coasting = sum(isinstance(one, TrackedContact) and one.is_coasting for one in others)
        switches = sum(changes.values())
        return cls(switches, whole, numbering.missed, len(others) - coasting, coasting)


def added(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Rows of several runs as one: numbers are summed, lists joined, events summed by kind."""
    total: dict[str, Any] = {}
    for key, first in rows[0].items():
        if isinstance(first, str):
            total[key] = first
        elif isinstance(first, list):
            total[key] = [value for row in rows for value in row[key]]
        elif isinstance(first, dict):
            total[key] = {kind: sum(row[key][kind] for row in rows) for kind in first}
        else:
            total[key] = sum(row[key] for row in rows)
    return total


@dataclass
class Nearest:
    """Numbers go to the nearest contact of the reading before, the strongest first; no filter."""

    next_number: int = 0
    before: Numbered = ()

    def __call__(self, estimate: Estimate) -> Numbered:
        """Contacts with their numbers."""
        free, found = list(self.before), []
        for contact in estimate.contacts:
            away = [float(np.linalg.norm(one.position - contact.position)) for _, one in free]
            if away and min(away) <= NEAR:
                number, _ = free.pop(int(np.argmin(away)))
            else:
                number, self.next_number = self.next_number, self.next_number + 1
            found.append((number, contact))
        self.before = found
        return found


def run_of(settings: Settings, quantity: str, solver: str, repeat: int) -> dict[str, Any]:
    """All scenes once with one solver: rows of counts and errors, and tracks for pictures."""
    kind, noise = QUANTITIES[quantity]
    patch = paper_patch()
    reconstruct = Reconstructor(
        patch,
        settings.layer,
        Grid.square(patch, nodes=20),
        quantity=kind,
        solver=SOLVERS[solver](),
        noise_std=noise,
    )
    about = {"quantity": quantity, "solver": solver, "repeat": repeat}
    rows: list[dict[str, Any]] = []
    pictures = []
    for number, scene in enumerate(scenes(settings.rate, settings.seed + repeat)):
        rng = np.random.default_rng([settings.seed + repeat, 71, number])
        exact = exact_readings(scene, settings.layer, settings.size.cell, quantity)
        reconstruct.reset()
        estimates = [reconstruct(each + rng.normal(scale=noise, size=len(patch))) for each in exact]
        made, picture = _followed(scene, estimates, 1 / settings.rate)
        rows += [about | {"scene": scene.name} | row for row in made]
        pictures.append(about | {"scene": scene.name} | picture)
    return {"rows": rows, "pictures": pictures if repeat == 0 else []}


def _followed(
    scene: Scene, estimates: Sequence[Estimate], period: float
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Rows of each way to number contacts, and what the tracker has for a picture."""
    tracker, nearest = Tracker(period=period), Nearest()
    ways = {name: Numbering() for name in (TRACKER, NEAREST, ANEW)}
    events: list[dict[str, Any]] = []
    anew = 0
    for index, estimate in enumerate(estimates):
        tracked = tracker(estimate)
        events += [
            {"kind": one.kind, "time": one.time, "ids": list(one.ids)} for one in tracker.events
        ]
        balls = np.flatnonzero(scene.touches[index])
        places, forces = scene.places[index, balls], scene.forces[index, balls]
        now = balls, places, forces, GATE
        ways[TRACKER].add(*now, [(_number(one), one) for one in tracked])
        ways[NEAREST].add(*now, nearest(estimate))
        numbered = list(enumerate(estimate.contacts, start=anew))
        anew += len(numbered)
        ways[ANEW].add(*now, numbered)
    speeds = np.gradient(scene.places, period, axis=0)
    return (
        [_row(name, each, scene, speeds, events, period) for name, each in ways.items()],
        {
            "truth": scene.places.tolist(),
            "touches": scene.touches.tolist(),
            "tracks": ways[TRACKER].as_lines(),
            "raw": ways[ANEW].as_lines(),
            "events": events,
            "period": period,
        },
    )


def _number(contact: Contact) -> int:
    return -1 if contact.track_id is None else contact.track_id


def _row(
    name: str,
    numbering: Numbering,
    scene: Scene,
    speeds: Floats,
    events: list[dict[str, Any]],
    period: float,
) -> dict[str, Any]:
    """Counts and summed squares: rows of several runs are added up."""
    counted = Switches.of(numbering)
    row: dict[str, Any] = {
        "method": name,
        "touch_s": float(scene.touches.sum()) * period,
        "readings": len(scene.places),
        "contacts": int(scene.touches.any(axis=0).sum()),
        **vars(counted),
        "place_mm": [],
        "force_N": [],
        "speed_mm_s": [],
        "nees": [],
        "nees_speed": [],
    }
    for hit in numbering.hits:
        contact, off = hit.contact, hit.off
        row["place_mm"].append(round(1e3 * float(np.hypot(*off)), 4))
        row["force_N"].append(round(contact.normal_force - hit.force, 4))
        if isinstance(contact, TrackedContact):
            plane = contact.covariance[:2, :2]
            row["nees"].append(round(float(off @ np.linalg.solve(plane, off)), 3))
            slow = contact.velocity[:2] - speeds[hit.index, hit.ball]
            row["speed_mm_s"].append(round(1e3 * float(np.hypot(*slow)), 3))
            spread = contact.velocity_covariance
            row["nees_speed"].append(round(float(slow @ np.linalg.solve(spread, slow)), 3))
    if name == TRACKER:
        row["events"] = {
            kind: sum(event["kind"] == kind for event in events)
            for kind in ("made", "moved", "merged", "split", "lost")
        }
    return row
