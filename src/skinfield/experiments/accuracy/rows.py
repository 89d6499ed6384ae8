"""The accuracy table: what each solver makes of the paper's presses, against the simulated truth.

Every press is solved once per indenter and load, at the origin; it is carried over the patch by
moving the taxels. All solvers see the same readings with the same noise.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any
from zlib import crc32

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.experiments.accuracy.plan import ANYWHERE, AccuracyPlan, noise_per_count
from skinfield.experiments.cases.case import Case, quantity_by_name, truth_of_press
from skinfield.experiments.cases.posed import Pose, posed
from skinfield.experiments.paper.presses import INNER, Tip, paper_patch, sites
from skinfield.experiments.scoring.bound import Bound, Family, contact_bounds
from skinfield.experiments.scoring.radial_readings import readings_anywhere
from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.scoring.score import Judge, Score
from skinfield.experiments.scoring.summary import summarise
from skinfield.experiments.scoring.table_rows import flat
from skinfield.layout import Grid
from skinfield.pipeline import Reconstructor

SURROUND = 12e-3  # m of skin beside the tip in which the deformation is compared
FORCE_STEP = 0.05  # of the load, each way, for the bound
SINKS = "sinks through the layer in linear elasticity"
Task = tuple[str, Callable[..., list[Row]], tuple[Any, ...]]


def accuracy_tasks(plan: AccuracyPlan) -> list[Task]:
    """Name, function and arguments of independent parts, one per indenter and load.

    The rows of all parts together, in this order, are the table. Everything can be pickled if the
    plan's solvers can.
    """
    return [
        (f"{tip.name} {load:g} N", accuracy_rows, (plan, tip, load))
        for tip in plan.tips
        for load in plan.loads
    ]


def accuracy_table(
    plan: AccuracyPlan, progress: Callable[[str, int, int], None] | None = None
) -> list[Row]:
    """Rows of the whole table, computed one after another.

    Parameters
    ----------
    plan : AccuracyPlan
    progress : function of name, done and total, optional
    """
    tasks, rows = accuracy_tasks(plan), []
    for done, (name, function, arguments) in enumerate(tasks, start=1):
        rows += function(*arguments)
        if progress is not None:
            progress(name, done, len(tasks))
    return rows


def accuracy_rows(plan: AccuracyPlan, tip: Tip, load: float) -> list[Row]:
    """Rows of one indenter and load, over quantities, noises, models, solvers and places.

    Returns
    -------
    list of dict
        Flat, the unit in each key's name. ``_median``, ``_low`` and ``_high`` are the median over
        the presses and its 95 % bootstrap interval, ``_p90`` the 90th percentile; errors are parts
        of the truth where no unit is named. ``bound_place_mm`` and ``bound_force`` are medians of
        the Cramér-Rao bound for the same presses and noise, as root mean squares. ``note`` says why
        there are no numbers.
    """
    wide = replace(tip, extent=tip.extent + SURROUND)
    solved = wide.pressed(plan.layer, load, plan.cell)
    if solved is None:
        return [_head(plan, tip, load) | {"note": SINKS}]
    truth = truth_of_press(solved)
    places = pose_places(plan, tip, load)
    rows: list[Row] = []
    for quantity in plan.quantities:
        family = _family(plan, tip, load, quantity)
        if family is None:
            return [_head(plan, tip, load) | {"note": SINKS}]
        plane = paper_patch().plane
        cases = [
            Case(
                name=place,
                patch=paper_patch(),
                layer=plan.layer,
                quantity=quantity,
                readings=family.base(plane - where),
                noise_std=np.ones(len(plane)),  # each noise of the plan is set further below
                truth=posed(truth, Pose(*where)),
            )
            for place, group in places.items()
            for where in group
        ]
        bounds = contact_bounds(family, plane, np.concatenate(list(places.values())), 1.0)
        rows += _rows_of_quantity(plan, tip, load, quantity, cases, bounds)
    return rows


def pose_places(plan: AccuracyPlan, tip: Tip, load: float) -> dict[str, Floats]:
    """Places (poses, 2) m of the presses, by kind of place; the same for every solver."""
    rng = _random(plan, tip, load, "places")
    chosen: dict[str, Floats] = {}
    for place in plan.places:
        if place == ANYWHERE:
            distance = INNER * np.sqrt(rng.uniform(size=plan.poses))
            angle = rng.uniform(0.0, 2 * np.pi, plan.poses)
            chosen[place] = distance[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        else:
            known = sites(paper_patch())[place]
            chosen[place] = known[rng.integers(len(known), size=plan.poses)]
    return chosen


def _random(plan: AccuracyPlan, tip: Tip, load: float, of: str) -> np.random.Generator:
    """Random numbers of an indenter and load, the same whatever else the plan holds."""
    return np.random.default_rng([plan.seed, crc32(f"{tip.name} {load:g} {of}".encode())])


def _family(plan: AccuracyPlan, tip: Tip, load: float, quantity: str) -> Family | None:
    pad = paper_patch().pad_diameter
    loads = (load, load * (1 - FORCE_STEP), load * (1 + FORCE_STEP))
    solved = [tip.pressed(plan.layer, each, plan.cell) for each in loads]
    known = [readings_anywhere(each, pad, quantity) for each in solved if each is not None]
    if len(known) < len(loads):
        return None
    return Family(base=known[0], lighter=known[1], heavier=known[2], force_step=FORCE_STEP)


@dataclass(frozen=True, eq=False)
class _Group:
    """Presses of one kind of place: their rows among all presses."""

    place: str
    rows: slice


def _groups(plan: AccuracyPlan) -> Iterator[_Group]:
    for index, place in enumerate(plan.places):
        yield _Group(place, slice(index * plan.poses, (index + 1) * plan.poses))


def _rows_of_quantity(
    plan: AccuracyPlan, tip: Tip, load: float, quantity: str, cases: list[Case], bounds: list[Bound]
) -> list[Row]:
    grid = Grid.square(paper_patch(), nodes=plan.nodes)
    judges = [Judge(case, grid) for case in cases]
    exact = np.stack([case.readings for case in cases])
    noise = _random(plan, tip, load, "noise").standard_normal(exact.shape)
    unit = noise_per_count(plan.layer, plan.cell)[quantity]
    rows = []
    for counts in plan.noise_counts:
        readings = exact + noise * (counts * unit)
        for model in range(len(plan.models)):
            for solver in range(len(plan.solvers)):
                head = _head(plan, tip, load) | {
                    "solver": plan.solvers[solver].name,
                    "model": plan.models[model].name,
                    "quantity": quantity,
                    "noise_counts": counts,
                    "noise_std": counts * unit,
                    "noise_unit": quantity_by_name(quantity).unit,
                }
                try:
                    reconstruct = _prepared(plan, solver, model, quantity, counts * unit)
                except InputError as error:
                    rows.append(head | {"note": str(error)})
                    continue
                scores = _scores(reconstruct, readings, judges)
                for group in _groups(plan):
                    summary = summarise(scores[group.rows], plan.resamples, plan.seed)
                    limit = _limit(bounds[group.rows], counts * unit)
                    rows.append(head | {"place": group.place} | flat(summary) | limit)
    return rows


def _scores(reconstruct: Reconstructor, readings: Floats, judges: list[Judge]) -> list[Score]:
    estimates = reconstruct(readings)
    return [judge(estimate) for judge, estimate in zip(judges, estimates, strict=True)]


@lru_cache(maxsize=256)
def _prepared(
    plan: AccuracyPlan, solver: int, model: int, quantity: str, noise_std: float
) -> Reconstructor:
    """Prepared once per process, as it does not depend on indenter and load."""
    return Reconstructor(
        paper_patch(),
        plan.layer,
        Grid.square(paper_patch(), nodes=plan.nodes),
        mechanics=plan.models[model].mechanics,
        quantity=quantity_by_name(quantity),
        solver=plan.solvers[solver].solver,
        noise_std=noise_std,
    )


def _head(plan: AccuracyPlan, tip: Tip, load: float) -> Row:
    """First columns, in the order of the table; what is not set later is the same for all."""
    return {
        "solver": "all",
        "model": "all",
        "quantity": "all",
        "indenter": tip.name,
        "place": "all",
        "load_N": load,
        "noise_counts": None,
        "noise_std": None,
        "noise_unit": "",
        "grid": f"{plan.nodes} x {plan.nodes}",
        "note": "",
    }


def _limit(bounds: list[Bound], noise_std: float) -> Row:
    """The bound is in proportion to the noise: it was computed for a noise of 1."""
    return {
        "bound_place_mm": float(np.median([bound.place for bound in bounds])) * noise_std * 1e3,
        "bound_force": float(np.median([bound.force for bound in bounds])) * noise_std,
    }
