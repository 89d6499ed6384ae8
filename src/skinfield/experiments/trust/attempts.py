"""What every method makes of every press at every noise, one row each."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.experiments.cases.case import Case
from skinfield.experiments.cases.truth import Truth
from skinfield.experiments.cases.unseen import unseen_press
from skinfield.experiments.scoring.matching import GATE
from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.scoring.validation import Attempt, Entrant
from skinfield.experiments.trust.plan import Level, Method, TrustPlan

RUNS = 2  # readings of each press: a cold one, which is scored, and a warm one


@lru_cache(maxsize=32)
def entrant_of(method: Method, gate: float) -> Entrant:
    """One per process, so that what it prepares is prepared once."""
    return method.entrant(gate)


def noise_seed(seed: int, index: int) -> int:
    """Of the noise of a press of a campaign: another one for each."""
    return seed * 1_000_003 + index


def rows_of_presses(plan: TrustPlan, first: int, last: int) -> dict[str, Any]:
    """Rows of the presses from `first` up to `last`, and the balls in them for the bound."""
    rows: list[Row] = []
    balls = []
    patch = plan.patch
    for index in range(first, last):
        press = unseen_press(patch, index, plan.seed, plan.layer, plan.cell)
        bodies = [(body.kind, getattr(body, "radius", 0.0)) for body in press.press.indenters]
        if all(kind == "ball" for kind, _ in bodies):
            balls += [
                {"case": press.name, "x": c.position[0], "y": c.position[1], "radius": radius}
                | {"force": c.force}
                for (_, radius), c in zip(bodies, press.truth.contacts, strict=True)
            ]
        for quantity in plan.quantities:
            levels = [level for level in plan.levels if level.quantity == quantity]
            case = press.case(patch, quantity)
            about = {"case": press.name, "group": press.group}
            made = rows_of_case(case, levels, plan.methods, noise_seed(plan.seed, index), plan.gate)
            rows += [about | row for row in made]
    return {"rows": rows, "balls": balls}


def rows_of_case(
    case: Case,
    levels: Sequence[Level],
    methods: Sequence[Method],
    seed: int,
    gate: float = GATE,
) -> Iterator[Row]:
    """Rows of one case of exact readings, level by level and method by method.

    All methods see the same noise, which grows from level to level.
    """
    for level in levels:
        drawn = noisy(case, level, seed)
        for method in methods:
            attempt = entrant_of(method, gate).attempt(drawn)
            yield {"quantity": level.quantity, "noise": level.noise, "method": method.name} | _row(
                attempt
            )


def noisy(case: Case, level: Level, seed: int) -> Case:
    """Two readings of an exact case at a level; of exact ones the solver is told the floor."""
    if level.noise > 0:
        return case.with_noise(seed, RUNS, level.noise)
    return replace(case.told(level.told), readings=np.repeat(case.draws, RUNS, axis=0), noisy=True)


def _row(attempt: Attempt) -> Row:
    """Errors without sign, as parts of the truth where no unit is named."""
    score = attempt.score
    return {
        "true_force_N": score.true_force,
        "contacts": score.true_contacts,
        "matched": len(score.matches),
        "missed": score.missed,
        "false": score.false,
        "force_error": abs(score.force_error),
        "place_error_m": score.place_error,
        "contact_force_error": score.contact_force_error,
        "blurred_pressure_error": score.blurred_pressure_error,
        "deformation_error": score.deformation_error,
        "cold_s": attempt.cold,
        "warm_s": attempt.warm,
        "place_held": attempt.place_held,
        "force_held": attempt.force_held,
    }


def idle_rows(plan: TrustPlan, level: Level) -> dict[str, Any]:
    """How often each method sees contacts in noise alone."""
    patch = plan.patch
    quiet = Case(
        name="idle",
        patch=patch,
        layer=plan.layer,
        quantity=level.quantity,
        readings=np.zeros(len(patch)),
        noise_std=np.full(len(patch), level.told),
        truth=Truth(
            cell=plan.cell,
            plane=np.empty((0, 2)),
            pressure=np.empty(0),
            displacement=np.empty((0, 3)),
            contacts=(),
        ),
    )
    rows = []
    for method in plan.methods:
        found = entrant_of(method, plan.gate).false_contacts(quiet, plan.idle, plan.seed)
        rows.append(
            {"quantity": level.quantity, "noise": level.noise, "method": method.name}
            | {"idle": len(found), "seen": sum(count > 0 for count in found), "false": sum(found)}
        )
    return {"idle": rows}
