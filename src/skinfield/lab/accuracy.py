"""Accuracy benchmark: solvers on random presses at several noises, beside the Cramér-Rao bound.

Presses that no solver was tuned on are read, scored and timed; readings of noise alone count
false contacts.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from skinfield.design import SkinDesign, Touch
from skinfield.design.design import respond
from skinfield.elastic.axisymmetric import Paraboloid, indent_by_force
from skinfield.errors import Floats, InputError, SkinfieldError
from skinfield.lab.case_sets import AS_STATED, CELL, SILICONE, WORLDS, random_press
from skinfield.lab.cases import NOTHING, QUANTITIES, Case, TrueContact, Truth
from skinfield.lab.runner import Task, run
from skinfield.lab.score import Row, quantiles, rate_row, summarise, where
from skinfield.lab.validation import Entrant, NoiseLevel, noise_seed, rows_of_case
from skinfield.simulate import Sphere
from skinfield.skin import Patch
from skinfield.skin.generators import by_name

NOISES = {  # standard deviations of one reading, Pa and ΔC/C₀; 0 is exact
    "stress": (0.0, 380.0, 1e3, 3.8e3),
    "capacitance": (0.0, 0.002, 0.005, 0.02),
}
KNOWN, UNKNOWN = "bound, size known", "bound, size unknown"
PRIORS = {KNOWN: None, UNKNOWN: 0.6}  # standard deviation of ln radius, if it is not known
DRAWS = 64  # of errors at the bound, per press
SHARE = 10  # presses in one part of the work


@dataclass(frozen=True, kw_only=True)
class AccuracyPlan:
    """A campaign of random presses.

    Parameters
    ----------
    entrants : tuple of Entrant
    levels : tuple of NoiseLevel
    layout : str
        Of a generator, see `skinfield.skin.generators`.
    presses : int
    idle : int
        Readings of the skin at rest per level.
    cell : float, m
        Of the truth's grid.
    seed : int
    worlds : tuple of str
        Of `case_sets.WORLDS`: what skin and touch truly are. Without any they are as stated.
    group : "single", "several" or "extended", optional
        Of the presses. Default each in its turn.
    """

    entrants: tuple[Entrant, ...]
    levels: tuple[NoiseLevel, ...]
    layout: str = "icub_hexagon"
    presses: int = 200
    idle: int = 5000
    cell: float = CELL
    seed: int = 0
    worlds: tuple[str, ...] = ()
    group: str | None = None

    @property
    def patch(self) -> Patch:
        """The skin's layout."""
        return by_name(self.layout)


@dataclass(frozen=True, eq=False)
class Findings:
    """What came out.

    Attributes
    ----------
    rows : list of dict
        One per press, level and entrant, see `rows_of_case`; with the world where one was named.
    bound : list of dict
        Errors of estimates at the Cramér-Rao bound, for presses by balls.
    idle : list of dict
        Contacts in noise alone, one row per level and entrant.
    """

    rows: Sequence[Row]
    bound: Sequence[Row] = ()
    idle: Sequence[Row] = ()


def rows_of_presses(
    folder: Path, plan: AccuracyPlan, first: int, last: int, name: str | None = None
) -> dict[str, list[Row]]:
    """Rows of the presses from `first` up to `last` in a world.

    And of the bound, where balls press and all is as stated.
    """
    patch, world = plan.patch, AS_STATED if name is None else WORLDS[name]
    rows: list[Row] = []
    bound: list[Row] = []
    for index in range(first, last):
        pressed = random_press(patch, index, plan.seed, SILICONE, plan.cell, world, plan.group)
        about: Row = {} if name is None else {"world": name}
        about |= {"group": pressed.group}
        for quantity in dict.fromkeys(level.quantity for level in plan.levels):
            levels = [level for level in plan.levels if level.quantity == quantity]
            case = Case.from_press(pressed.name, pressed.press, patch, quantity, pressed.pose)
            case = world.case(pressed, SILICONE, case)
            made = rows_of_case(case, levels, plan.entrants, noise_seed(plan.seed, index))
            rows += [about | row for row in made]
        balls = [body for body in pressed.press.indenters if isinstance(body, Sphere)]
        if world == AS_STATED and len(balls) == len(pressed.press.indenters):
            rng = np.random.default_rng([plan.seed, index, 1])
            about |= {"case": pressed.name}
            bound += [about | row for row in bound_rows(plan, balls, case.truth, rng)]
    return {"rows": rows, "bound": bound}


def bound_rows(
    plan: AccuracyPlan,
    balls: Sequence[Sphere],
    truth: Truth,
    rng: np.random.Generator,
    draws: int = DRAWS,
) -> list[Row]:
    """Errors at the Cramér-Rao bound of a press by balls, for each noise above 0.

    They are Gaussian with the bound's covariance, with the balls' sizes known and unknown: what an
    unbiased and efficient estimator of place and force would score. Several balls are taken to act
    each by itself: they are 10 mm or more apart, five thicknesses. None for touches that are beyond
    what a design can be asked.
    """
    rows: list[Row] = []
    forces = np.array([contact.force for contact in truth.contacts])
    white = rng.standard_normal((draws, len(forces), 3))
    for level in (level for level in plan.levels if level.noise > 0):
        quantity = QUANTITIES[level.quantity]
        design = SkinDesign(
            patch=plan.patch, layer=SILICONE, quantity=quantity, noise_std=level.noise
        )
        try:
            grams = [
                _information(design, ball.radius, contact)
                for ball, contact in zip(balls, truth.contacts, strict=True)
            ]
        except InputError:
            continue
        for name, prior in PRIORS.items():
            roots = [_root_of_bound(gram, prior) for gram in grams]
            drawn = np.einsum("cij,dcj->dci", np.array(roots), white)
            place = 1e3 * np.hypot(drawn[..., 0], drawn[..., 1]).mean(axis=1)
            total = np.abs(drawn[..., 2] @ forces) / forces.sum()
            single = np.abs(drawn[..., 2]).mean(axis=1)
            head = {"quantity": level.quantity, "noise": level.noise, "method": name}
            keys = ("place_error_mm", "force_error", "contact_force_error")
            rows += [
                head | dict(zip(keys, map(float, each), strict=True))
                for each in zip(place, total, single, strict=True)
            ]
    return rows


def _information(design: SkinDesign, radius: float, contact: TrueContact) -> Floats:
    """Fisher information (4, 4) of x m, y m, ln force and ln radius of a ball.

    Its contact's radius is a function of the force times the ball's radius alone, as that of every
    paraboloid on a linear layer is.
    """
    body, parts = Paraboloid(radius=radius), (0.95, 1.0, 1.05)
    light, touch, heavy = (
        indent_by_force(design.layer, body, contact.force * part).contact_radius for part in parts
    )
    change = np.eye(4, 5, 1)
    change[3, 4] = 0.0
    change[2:, 4] = np.log(heavy / light) / np.log(parts[2] / parts[0])
    at = np.array([contact.position])
    gram = respond(design, Touch(contact.force, touch), at).gram[0]
    return np.asarray(change @ gram @ change.T)


def _root_of_bound(gram: Floats, prior: float | None) -> Floats:
    """Root (3, 3) of the least covariance of x m, y m and ln force, from the information (4, 4)."""
    known = np.diag([0.0, 0.0, 0.0, 0.0 if prior is None else prior**-2])
    information = gram[:3, :3] if prior is None else gram + known
    scale = 1 / np.sqrt(np.diag(information))
    covariance = np.linalg.inv(information * np.outer(scale, scale)) * np.outer(scale, scale)
    return np.asarray(np.linalg.cholesky(covariance[:3, :3]))


def idle_rows(folder: Path, plan: AccuracyPlan, level: NoiseLevel) -> dict[str, list[Row]]:
    """How often each entrant sees contacts in noise alone."""
    patch = plan.patch
    quiet = Case(
        name="idle",
        patch=patch,
        layer=SILICONE,
        quantity=level.quantity,
        readings=np.zeros(len(patch)),
        noise_std=np.full(len(patch), level.stated),
        truth=NOTHING,
    )
    rows = []
    for entrant in plan.entrants:
        seen = entrant.false_contacts(quiet, plan.idle, plan.seed)
        rows.append(
            {"quantity": level.quantity, "noise": level.noise, "method": entrant.name}
            | {"idle": len(seen), "seen": sum(count > 0 for count in seen), "false": sum(seen)}
        )
    return {"idle": rows}


def computed(
    plan: AccuracyPlan,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Findings:
    """Run all parts of a campaign in so many processes.

    Raises
    ------
    SkinfieldError
        Where a part fails: with the last line of its traceback.
    """
    results = {}
    tasks = [  # independent, and they leave no files
        Task(f"presses-{k:04d}-{w}", rows_of_presses, (plan, k, min(k + SHARE, plan.presses), w))
        for w in plan.worlds or (None,)
        for k in range(0, plan.presses, SHARE)
    ]
    tasks += [
        Task(f"idle-{level}".replace(" ", "-"), idle_rows, (plan, level))
        for level in plan.levels
        if level.noise > 0
    ]
    progress(0, len(tasks))
    with TemporaryDirectory(prefix="skinfield-") as folder:
        for done, outcome in enumerate(run(tasks, folder, workers=workers), start=1):
            if outcome.failure:
                reason = outcome.failure.strip().splitlines()[-1]
                raise SkinfieldError(f"{outcome.name} fails: {reason}")
            results[outcome.name] = outcome.result
            progress(done, len(tasks))
    parts = [results[task.name] for task in tasks]
    kinds = ("rows", "bound", "idle")
    return Findings(*([row for part in parts for row in part.get(kind, ())] for kind in kinds))


def accuracy_rows(findings: Findings, resamples: int = 999, seed: int = 0) -> list[Row]:
    """One row per world, quantity, noise and entrant, with the bounds after the entrants.

    Beside what `summarise` makes, ``place_held`` and ``force_held`` are the shares of the contacts
    found whose stated 90 % regions hold the truth, and ``idle_false_per_reading`` is the mean of
    noise alone. The bounds are of presses by balls alone, and lack what they do not say.
    """
    out: list[Row] = []
    rows = findings.rows
    keys = ("world", "quantity", "noise") if rows and "world" in rows[0] else ("quantity", "noise")
    for values in dict.fromkeys(tuple(row[key] for key in keys) for row in rows):
        for name in (*dict.fromkeys(row["method"] for row in rows), *PRIORS):
            head: Row = dict(zip(keys, values, strict=True)) | {"method": name}
            mine = where(findings.bound if name in PRIORS else rows, **head)
            if not mine:
                continue
            numbers = head | {"presses": len({row["case"] for row in mine})}
            if name in PRIORS:  # many draws each, so no interval
                out.append(numbers | quantiles(mine))
                continue
            numbers |= summarise(mine, resamples, seed)
            matches = sum(row["matched"] for row in mine)
            for key in ("place_held", "force_held"):
                numbers |= rate_row(key, sum(row[key] for row in mine), matches)
            still = {key: value for key, value in head.items() if key != "world"}
            idle = where(findings.idle, **still)
            readings = sum(row["idle"] for row in idle)
            if readings:
                alarms = sum(row["false"] for row in idle)
                numbers |= {"idle_readings": readings, "idle_false_per_reading": alarms / readings}
            out.append(numbers)
    return out
