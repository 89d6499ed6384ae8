"""How often intervals hold the truth of presses that they were not learnt from."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.cases.case import quantity_by_name
from skinfield.experiments.coverage.plan import LEVELS, CoveragePlan, Entry
from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.section import Part
from skinfield.fields import Contact
from skinfield.layout import Grid
from skinfield.mechanics import BondedLayer
from skinfield.pipeline import Reconstructor
from skinfield.pipeline.learnt import nearest
from skinfield.pipeline.rehearsal import Rehearsal, rehearse

EXACT = 1e-9  # m: a place that is said to be surer is taken to be so sure
APART = 1_000  # between the seeds of what is learnt from and of what is tried on


def coverage_parts(plan: CoveragePlan) -> list[Part]:
    """One per quantity: its noises share the presses that are solved."""
    return [Part(quantity, rows_of_quantity, (plan, quantity)) for quantity in plan.quantities]


def rows_of_quantity(plan: CoveragePlan, quantity: str) -> list[Row]:
    """One row per noise, solver and way of stating intervals."""
    return [row for noise in plan.noises for row in rows_of(plan, quantity, noise)]


def rows_of(plan: CoveragePlan, quantity: str, noise: float) -> list[Row]:
    """One row per solver and way of stating intervals."""
    made = rehearsal_of(plan, quantity)
    told = noise * quantity_by_name(quantity).typical_noise
    rng = np.random.default_rng([plan.seed + APART, 3])
    readings = made.readings + told * rng.standard_normal(made.readings.shape)
    rows = []
    for entry in plan.solvers:
        plain = _prepared(plan, entry, quantity, told)
        learnt = plain.calibrated(plan.presses, plan.seed, plan.known).intervals
        raw = _found(plain.with_intervals(None), plan, made, readings)
        stated = _found(plain, plan, made, readings) if entry.linear else raw
        held = {"stated": stated}
        if learnt is not None:
            held["calibrated"] = [
                (learnt((contact,))[0], place, force) for contact, place, force in raw
            ]
        head: Row = {
            "quantity": quantity,
            "noise": noise,
            "noise_std": told,
            "solver": entry.name,
            "trials": len(readings),
        }
        rows += [head | {"intervals": name} | _held(pairs) for name, pairs in held.items()]
    return rows


@lru_cache(maxsize=4)
def rehearsal_of(plan: CoveragePlan, quantity: str) -> Rehearsal:
    """Presses that nothing was learnt from, without noise."""
    return rehearse(
        plan.patch,
        plan.layer,
        BondedLayer(),
        quantity_by_name(quantity),
        plan.trials,
        plan.seed + APART,
        plan.others,
    )


def _prepared(plan: CoveragePlan, entry: Entry, quantity: str, told: float) -> Reconstructor:
    return Reconstructor(
        plan.patch,
        plan.layer,
        Grid.square(plan.patch, nodes=plan.nodes),
        quantity=quantity_by_name(quantity),
        solver=entry.solver,
        noise_std=told,
    )


Pair = tuple[Contact, Floats, float]  # what is said, and the true place (2,) m and force N


def _found(
    reconstruct: Reconstructor, plan: CoveragePlan, made: Rehearsal, readings: Floats
) -> list[Pair]:
    positions = plan.patch.surface.position_from_plane(made.places)
    pairs = []
    for row, reading in enumerate(readings):
        reconstruct.reset()  # each press by itself
        contact = nearest(reconstruct(reading).contacts, positions[row])
        if contact is not None:
            pairs.append((contact, made.places[row], float(made.forces[row])))
    return pairs


def _held(pairs: Sequence[Pair]) -> Row:
    """Counts of truths inside at each level, inside by the covariance, and widths."""
    row: Row = {"found": len(pairs)}
    for level in LEVELS:
        name = f"{100 * level:g}"
        row[f"force_{name}"] = sum(
            low <= force <= high
            for (low, high), force in ((c.force_interval(level), f) for c, _, f in pairs)
        )
        row[f"place_{name}"] = sum(
            float(np.hypot(*(place - contact.position[:2]))) <= contact.place_radius(level)
            for contact, place, _ in pairs
        )
    row["force_by_covariance"] = sum(
        abs(force - contact.normal_force) <= 1.645 * contact.force_std
        for contact, _, force in pairs
    )
    row["place_by_covariance"] = sum(_in_ellipse(contact, place) for contact, place, _ in pairs)
    return row | _widths(pairs)


def _in_ellipse(contact: Contact, place: Floats) -> bool:
    away = place - contact.position[:2]
    block = contact.covariance[:2, :2] + EXACT**2 * np.eye(2)
    return bool(away @ np.linalg.solve(block, away) <= 4.605)


def _widths(pairs: Sequence[Pair]) -> Row:
    def median(values: Sequence[Any]) -> float:
        return float(np.median(values)) if len(values) else float("nan")

    ends = [contact.force_interval(0.9) for contact, _, _ in pairs]
    forces = [force for _, _, force in pairs]
    return {
        "force_std": median([c.force_std / c.normal_force for c, _, _ in pairs]),
        "place_std_mm": median([1e3 * c.place_std for c, _, _ in pairs]),
        "force_width": median([(b - a) / f for (a, b), f in zip(ends, forces, strict=True)]),
        "place_radius_mm": median([1e3 * c.place_radius(0.9) for c, _, _ in pairs]),
    }
