"""From which distance on two balls are seen as two."""

from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.cases.case import Case, truth_of_press
from skinfield.experiments.cases.posed import Pose, posed
from skinfield.experiments.cases.standard import AROUND, INSET
from skinfield.experiments.scoring.matching import matched
from skinfield.experiments.scoring.validation import Entrant
from skinfield.experiments.trust.attempts import entrant_of
from skinfield.experiments.trust.plan import Level, TrustPlan
from skinfield.layout import Patch
from skinfield.simulate import Press, Sphere, press

RADIUS, FORCE = 3e-3, 1.0  # m, N: of each ball


def two_point_rows(plan: TrustPlan, distance: float) -> dict[str, Any]:
    """How many of two balls at a distance in m are found as two, one row per level and method.

    Found as two: exactly two contacts, each nearer than half the distance to its own ball. All
    methods see the same presses, at random places and angles, with the same noise.
    """
    balls = [
        Sphere(radius=RADIUS, force=FORCE, position=(side * distance / 2, 0.0)) for side in (-1, 1)
    ]
    solved = press(plan.layer, balls, distance + 2 * AROUND, plan.cell)
    poses = _poses(plan, distance)
    rows = []
    for quantity in dict.fromkeys(level.quantity for level in plan.pairs):
        cases = _cases(solved, poses, plan.patch, quantity)
        for level in [level for level in plan.pairs if level.quantity == quantity]:
            noise = np.random.default_rng([plan.seed, int(distance * 1e6), 1]).standard_normal(
                (len(cases), len(plan.patch))
            )
            for method in plan.methods:
                entrant = entrant_of(method, plan.gate)
                found = _found(entrant, level, cases, noise, distance / 2)
                rows.append(
                    {"distance_mm": 1e3 * distance, "quantity": quantity, "noise": level.noise}
                    | {"method": method.name, "trials": len(cases), "found": found}
                )
    return {"pairs": rows}


def _poses(plan: TrustPlan, distance: float) -> list[Pose]:
    """Random places of the middle, such that both balls stay in the middle of the patch."""
    rng = np.random.default_rng([plan.seed, int(distance * 1e6)])
    plane = plan.patch.plane
    middle, half = (plane.max(axis=0) + plane.min(axis=0)) / 2, np.ptp(plane, axis=0) / 4 * INSET
    places = middle + rng.uniform(-half, half, (plan.trials, 2))
    angles = rng.uniform(0.0, np.pi, plan.trials)
    return [
        Pose(float(x), float(y), float(angle)) for (x, y), angle in zip(places, angles, strict=True)
    ]


def _cases(solved: Press, poses: list[Pose], patch: Patch, quantity: str) -> list[Case]:
    """Exact readings at all poses from one field: a pad more costs next to nothing."""
    pads = np.concatenate([pose.back(patch.plane) for pose in poses])
    readings = solved.readings(pads, patch.pad_diameter, quantity).reshape(len(poses), -1)
    truth = truth_of_press(solved)
    return [
        Case(
            name="two balls",
            patch=patch,
            layer=solved.layer,
            quantity=quantity,
            readings=reading,
            noise_std=np.ones(len(patch)),
            truth=posed(truth, pose),
        )
        for reading, pose in zip(readings, poses, strict=True)
    ]


def _found(entrant: Entrant, level: Level, cases: list[Case], noise: Floats, gate: float) -> int:
    reconstruct = entrant.reconstructor(cases[0].told(level.told))
    hits = 0
    for case, white in zip(cases, noise, strict=True):
        reconstruct.reset()
        estimate = reconstruct(case.readings + level.noise * white)
        matches, missed, false = matched(case.patch, case.truth.contacts, estimate.contacts, gate)
        hits += len(matches) == 2 and not missed and not false
    return hits
