"""Tracking benchmark: scenes of moving contacts, and which ball each contact belongs to."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from skinfield.elastic import BaseStress, Capacitance, Layer, Quantity
from skinfield.errors import Floats
from skinfield.estimate import Contact, Estimate, TrackedContact, Tracker
from skinfield.lab.paper import paper_patch
from skinfield.lab.report import Settings
from skinfield.reconstruct import Reconstructor
from skinfield.simulate import Sphere, press_ladder
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


@lru_cache(maxsize=8)
def _table(layer: Layer, cell: float, quantity: str) -> Any:
    """What a taxel reads of a ball, as a function of force N and distance m."""
    from scipy.interpolate import RectBivariateSpline

    patch = paper_patch()
    points = np.column_stack([FAR, 0 * FAR])
    rows = [np.zeros(len(FAR))]
    for solved in press_ladder(layer, Sphere(radius=BALL), FORCES, EXTENT, cell):
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
SOLVERS: dict[str, Solver] = {"ContactFit": ContactFit(), "GaussianField": GaussianField()}
TRACKER, NEAREST = "Tracker", "nearest one before"
NEAR = 5e-3  # m: within which the nearest one before is taken for the same
GATE = 8e-3  # m: farther from every ball, a contact is false

Numbered = Sequence[tuple[int, Contact]]


@dataclass(eq=False)
class Numbering:
    """What is known of one way to number contacts, reading by reading.

    Attributes
    ----------
    hits : list of (reading, ball, number, contact, (2,) m from the ball to the contact)
        Contacts that belong to a ball.
    others : list of (reading, number, contact)
        Contacts that belong to none.
    missed : int
        Balls without a contact, summed over the readings.
    """

    hits: list[tuple[int, int, int, Contact, Floats]] = field(default_factory=list)
    others: list[tuple[int, int, Contact]] = field(default_factory=list)
    missed: int = 0
    _last: dict[int, int] = field(default_factory=dict)
    _readings: int = 0

    def add(self, balls: Sequence[int], places: Floats, found: Numbered) -> None:
        """Take up a reading: balls at places (B, 2) m, and contacts with their numbers.

        A ball keeps the number that it had while that contact is nearer than `GATE`; the others
        go with at most one contact each, as many as there are, and then the nearest.
        """
        index, self._readings = self._readings, self._readings + 1
        taken: set[int] = set()
        if len(balls) and found:
            seen = np.array([contact.position[:2] for _, contact in found])
            away = np.linalg.norm(places[:, None] - seen[None], axis=2)
            for row, at in self._pairs(balls, away, [number for number, _ in found]):
                number, contact = found[at]
                self.hits.append((index, balls[row], number, contact, seen[at] - places[row]))
                self._last[balls[row]] = number
                taken.add(at)
        self.missed += len(balls) - len(taken)
        self.others += [(index, *each) for at, each in enumerate(found) if at not in taken]

    def _pairs(
        self, balls: Sequence[int], away: Floats, numbers: Sequence[int]
    ) -> list[tuple[int, int]]:
        from scipy.optimize import linear_sum_assignment

        beyond = GATE * (min(away.shape) + 2)
        cost = np.where(away <= GATE, away, beyond)
        for row, ball in enumerate(balls):
            last = self._last.get(ball)
            if last in numbers and away[row, numbers.index(last)] <= GATE:
                cost[row, numbers.index(last)] = -beyond  # whatever else is nearer
        rows, columns = linear_sum_assignment(cost)
        pairs = zip(rows.tolist(), columns.tolist(), strict=True)
        return [(row, column) for row, column in pairs if away[row, column] <= GATE]

    def counts(self) -> dict[str, int]:
        """After CLEAR MOT (Bernardin and Stiefelhagen 2008), summed over the readings.

        ``switches`` are readings in which a ball has another number than when it was seen last,
        ``whole`` balls have one number from the first to the last. Contacts without a ball are
        ``false``, or ``coasting`` where they are foretold and not seen.
        """
        numbers: dict[int, list[int]] = defaultdict(list)
        for _, ball, number, *_ in self.hits:
            numbers[ball].append(number)
        changes = [sum(a != b for a, b in pairwise(each)) for each in numbers.values()]
        coasting = sum(isinstance(c, TrackedContact) and c.is_coasting for *_, c in self.others)
        return {
            "switches": sum(changes),
            "whole": changes.count(0),
            "missed": self.missed,
            "false": len(self.others) - coasting,
            "coasting": coasting,
        }

    def lines(self) -> dict[str, list[list[float]]]:
        """For each number its readings: index, x and y in mm, force in N."""
        out: dict[str, list[list[float]]] = defaultdict(list)
        every = [(index, number, contact) for index, _, number, contact, _ in self.hits]
        for index, number, contact in sorted([*every, *self.others], key=lambda one: one[0]):
            x, y = (1e3 * contact.position[:2]).round(3).tolist()
            out[str(number)].append([index, x, y, round(contact.normal_force, 4)])
        return dict(out)


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
        solver=SOLVERS[solver],
        noise_std=noise,
    )
    about = {"quantity": quantity, "solver": solver}
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
    ways = {TRACKER: Numbering(), NEAREST: Numbering()}
    events: list[dict[str, Any]] = []
    for index, estimate in enumerate(estimates):
        tracked = tracker(estimate)
        events += [
            {"kind": one.kind, "time": one.time, "ids": list(one.ids)} for one in tracker.events
        ]
        balls = np.flatnonzero(scene.touches[index]).tolist()
        places = scene.places[index, balls]
        numbered = [(-1 if one.track_id is None else one.track_id, one) for one in tracked]
        ways[TRACKER].add(balls, places, numbered)
        ways[NEAREST].add(balls, places, nearest(estimate))
    kinds = [event["kind"] for event in events]
    told = {kind: kinds.count(kind) for kind in dict.fromkeys(kinds)}
    rows = [_row(name, each, scene, period) for name, each in ways.items()]
    rows[0]["events"] = told
    return rows, {
        "truth": scene.places.tolist(),
        "tracks": ways[TRACKER].lines(),
        "raw": ways[NEAREST].lines(),
        "events": events,
        "period": period,
    }


def _row(name: str, numbering: Numbering, scene: Scene, period: float) -> dict[str, Any]:
    """Counts, and lists of errors: rows of several runs are added up."""
    errors: dict[str, list[float]] = {
        key: [] for key in ("place_mm", "force_N", "speed_mm_s", "nees", "nees_speed")
    }
    speeds = np.gradient(scene.places, period, axis=0)
    for index, ball, _, contact, off in numbering.hits:
        errors["place_mm"].append(1e3 * float(np.hypot(*off)))
        errors["force_N"].append(contact.normal_force - float(scene.forces[index, ball]))
        if isinstance(contact, TrackedContact):
            slow = contact.velocity[:2] - speeds[index, ball]
            spread = contact.velocity_covariance
            errors["speed_mm_s"].append(1e3 * float(np.hypot(*slow)))
            errors["nees"].append(float(off @ np.linalg.solve(contact.covariance[:2, :2], off)))
            errors["nees_speed"].append(float(slow @ np.linalg.solve(spread, slow)))
    return {
        "method": name,
        "touch_s": float(scene.touches.sum()) * period,
        "readings": len(scene.places),
        "contacts": int(scene.touches.any(axis=0).sum()),
        **numbering.counts(),
        **{key: np.round(values, 4).tolist() for key, values in errors.items()},
        "events": {},
    }


def added(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Rows of several runs as one: numbers and lists are summed, events by kind."""
    total = dict(rows[0])
    for row in rows[1:]:
        for key, value in row.items():
            if isinstance(value, dict):
                kinds = dict.fromkeys([*total[key], *value])
                total[key] = {k: total[key].get(k, 0) + value.get(k, 0) for k in kinds}
            elif not isinstance(value, str):
                total[key] = total[key] + value
    return total
