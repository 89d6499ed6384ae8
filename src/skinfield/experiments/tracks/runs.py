"""Scenes as solvers and trackers see them: rows of what came out, reading by reading."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skinfield.contacts import TrackedContact, Tracker
from skinfield.errors import Floats
from skinfield.experiments.paper.presses import paper_patch
from skinfield.experiments.settings import Settings
from skinfield.experiments.tracks.scenes import Scene, exact_readings, scenes
from skinfield.experiments.tracks.switches import Steps, Switches
from skinfield.fields import Contact, Estimate
from skinfield.inverse import ContactFit, GaussianField, Solver
from skinfield.layout import Grid
from skinfield.observation import BaseStress, Capacitance, Quantity
from skinfield.pipeline import Reconstructor

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
    steps = {name: Steps() for name in (TRACKER, NEAREST, ANEW)}
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
        steps[TRACKER].add(*now, [(_number(one), one) for one in tracked])
        steps[NEAREST].add(*now, nearest(estimate))
        numbered = list(enumerate(estimate.contacts, start=anew))
        anew += len(numbered)
        steps[ANEW].add(*now, numbered)
    speeds = np.gradient(scene.places, period, axis=0)
    return (
        [_row(name, each, scene, speeds, events, period) for name, each in steps.items()],
        {
            "truth": scene.places.tolist(),
            "touches": scene.touches.tolist(),
            "tracks": steps[TRACKER].as_lines(),
            "raw": steps[ANEW].as_lines(),
            "events": events,
            "period": period,
        },
    )


def _number(contact: Contact) -> int:
    return -1 if contact.track_id is None else contact.track_id


def _row(
    name: str,
    steps: Steps,
    scene: Scene,
    speeds: Floats,
    events: list[dict[str, Any]],
    period: float,
) -> dict[str, Any]:
    """Counts and summed squares: rows of several runs are added up."""
    counted = Switches.of(steps)
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
    for hit in steps.hits:
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
