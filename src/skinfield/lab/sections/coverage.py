"""Coverage of intervals: do they hold the truth as often as they say.

They are learnt from some simulated presses and tried on others, by bodies of other sizes and
shapes, at other places, loads and noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from skinfield.elastic import BondedLayer, Layer
from skinfield.errors import Floats, check_choice
from skinfield.estimate import Contact
from skinfield.lab.cases import quantity_by_name
from skinfield.lab.paper import paper_patch
from skinfield.lab.plots import LIMIT, Curve, Panel, Scale, draw_panels
from skinfield.lab.report import (
    PAPER_LAYER,
    SIZES,
    Cell,
    Missing,
    Part,
    Picture,
    Section,
    Settings,
    Table,
    share_in_words,
)
from skinfield.lab.score import Row, where, wilson
from skinfield.reconstruct import Reconstructor
from skinfield.reconstruct.interval_training import BODIES, Rehearsal, nearest, rehearse
from skinfield.simulate import Bar, Cone, Cylinder, Sphere
from skinfield.skin import Grid, Patch
from skinfield.solve import ContactFit, GaussianField, Inverse, PseudoInverse, Solver, Tikhonov

LEVELS = (0.5, 0.68, 0.9, 0.95)
OTHERS: tuple[Any, ...] = (  # none of those that intervals are learnt from
    Sphere(radius=4e-3),
    Sphere(radius=6.5e-3),
    Sphere(radius=10e-3),
    Cylinder(radius=3e-3, edge_radius=0.3e-3),
    Cone(radius=7e-3, half_angle=float(np.radians(70.0))),
    Bar(length=7e-3, width=4e-3, edge_radius=1e-3),
)
APART = 1_000  # between the seeds of what is learnt from and of what is tried on
OF = ("force", "place")
WAYS = (("calibrated", "calibrated"), ("stated", "as stated without calibration"))
HONEST = (0.85, 0.95)
WIDTHS = ("force_std", "place_std_mm", "force_width", "place_radius_mm")
Pair = tuple[Contact, Floats, float]  # what is stated, and the true place (2,) m and force N


SOLVERS: tuple[tuple[str, Solver], ...] = (
    ("PseudoInverse, resampled (paper)", PseudoInverse(resample=True)),
    ("Inverse, resampled (paper)", Inverse()),
    ("Tikhonov", Tikhonov()),
    ("GaussianField", GaussianField()),
    ("ContactFit", ContactFit()),
)


@dataclass(frozen=True, kw_only=True)
class CoveragePlan:
    """One table.

    Parameters
    ----------
    solvers : tuple of (name, Solver)
    quantities : tuple of str
        Of "stress" and "capacitance".
    noises : tuple of float
        Of the quantity's typical noise.
    presses : int
        From which intervals are learnt.
    trials : int
        Presses by other bodies and with other seeds, on which they are tried.
    known, others : tuple of indenters
        Bodies of the former and of the latter.
    nodes : int
        On a side of the estimate's grid.
    layer : Layer
    seed : int
    """

    solvers: tuple[tuple[str, Solver], ...] = SOLVERS
    quantities: tuple[str, ...] = ("stress", "capacitance")
    noises: tuple[float, ...] = (0.05, 1.0, 2.5)
    presses: int = 300
    trials: int = 250
    known: tuple[Any, ...] = BODIES
    others: tuple[Any, ...] = OTHERS
    nodes: int = 30
    layer: Layer = PAPER_LAYER
    seed: int = 0

    @property
    def patch(self) -> Patch:
        """The hexagon of 72 taxels."""
        return paper_patch()


def coverage_plan(size: str, seed: int = 0) -> CoveragePlan:
    """The table of a size: "smoke", "short" or "full".

    Raises
    ------
    InputError
        For another size.
    """
    check_choice("size", size, SIZES, "how much is computed")
    if size == "smoke":
        return CoveragePlan(
            solvers=SOLVERS[3:4],
            quantities=("stress",),
            noises=(1.0,),
            presses=100,
            trials=30,
            known=BODIES[1:2],
            others=OTHERS[1:2],
            nodes=20,
            seed=seed,
        )
    if size == "short":
        return CoveragePlan(presses=150, trials=150, seed=seed)
    return CoveragePlan(presses=1000, trials=1500, seed=seed)


def rows_of_quantity(plan: CoveragePlan, quantity: str) -> list[Row]:
    """One row per noise, solver and way of stating intervals."""
    return [row for noise in plan.noises for row in rows_of(plan, quantity, noise)]


def rows_of(plan: CoveragePlan, quantity: str, noise: float) -> list[Row]:
    """One row per solver and way of stating intervals."""
    made = rehearsal_of(plan, quantity)
    noise_std = noise * quantity_by_name(quantity).typical_noise
    rng = np.random.default_rng([plan.seed + APART, 3])
    readings = made.readings + noise_std * rng.standard_normal(made.readings.shape)
    rows = []
    for name, solver in plan.solvers:
        plain = Reconstructor(
            plan.patch,
            plan.layer,
            Grid.square(plan.patch, nodes=plan.nodes),
            quantity=quantity_by_name(quantity),
            solver=solver,
            noise_std=noise_std,
        )
        learnt = plain.calibrated(plan.presses, plan.seed, plan.known).intervals
        raw = _nearest_contacts(plain.with_intervals(None), plan, made, readings)
        # A linear solver's contacts state a model error, which is left out where they learn.
        fitted = isinstance(solver, ContactFit)
        pairs = {"stated": raw if fitted else _nearest_contacts(plain, plan, made, readings)}
        if learnt is not None:
            pairs["calibrated"] = [
                (learnt((contact,))[0], place, force) for contact, place, force in raw
            ]
        head: Row = {
            "quantity": quantity,
            "noise": noise,
            "noise_std": noise_std,
            "solver": name,
            "trials": len(readings),
        }
        rows += [head | {"intervals": way} | _counts(each) for way, each in pairs.items()]
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


def _nearest_contacts(
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


def _counts(pairs: Sequence[Pair]) -> Row:
    """Counts of truths inside at each level, and median widths."""
    row: Row = {"found": len(pairs)}
    for level in LEVELS:
        inside = [
            (
                low <= force <= high,
                np.hypot(*(place - contact.position[:2])) <= contact.place_radius(level),
            )
            for contact, place, force in pairs
            for low, high in (contact.force_interval(level),)
        ]
        name = f"{100 * level:g}"
        counts = np.array(inside).reshape(-1, 2).sum(axis=0).tolist()
        row |= dict(zip((f"force_{name}", f"place_{name}"), counts, strict=True))
    widths = [
        (
            contact.force_std / contact.normal_force,
            1e3 * contact.place_std,
            float(np.ptp(contact.force_interval(0.9))) / force,
            1e3 * contact.place_radius(0.9),
        )
        for contact, _, force in pairs
    ]
    medians = np.median(widths, axis=0).tolist() if widths else [np.nan] * len(WIDTHS)
    return row | dict(zip(WIDTHS, medians, strict=True))


def coverage_parts(settings: Settings) -> list[Part]:
    """One per quantity: its noises share the presses that are solved."""
    plan = coverage_plan(settings.size.name, settings.seed)
    return [Part(quantity, rows_of_quantity, (plan, quantity)) for quantity in plan.quantities]


def coverage(settings: Settings, results: Sequence[list[Row] | None]) -> Section | Missing:
    """The section from the rows of its parts."""
    rows = [row for part in results for row in part or () if row["found"]]
    if not rows:
        return Missing("coverage: none of its parts could be computed")
    return section_of(coverage_plan(settings.size.name, settings.seed), rows)


def section_of(plan: CoveragePlan, rows: Sequence[Row]) -> Section:
    """The section of some rows: a table, and a diagram of observed against stated shares."""
    noises = sorted({row["noise"] for row in rows})
    caption = (
        "Share of the truths inside intervals, against what they say; bands are 95 % binomial "
        "intervals, on the dashed line it is as often as they say. Pooled over noises of "
        f"{', '.join(f'{noise:g}' for noise in noises)} of the typical one."
    )
    everything = Table.of("all", "Every row, with the counts at each level.", rows, on_page=False)
    return Section(
        name="coverage",
        title="Intervals: do they hold the truth as often as they say?",
        claim="",
        sentences=tuple(_sentences(rows, plan.presses, plan.trials)),
        pictures=(Picture.of("reliability", caption, draw_panels(panels(rows))),),
        tables=(_table(rows), everything),
    )


def pooled(rows: Sequence[Row], key: str) -> tuple[float, tuple[float, float]]:
    """Share over some rows with its 95 % interval."""
    hits, trials = (int(sum(row[name] for row in rows)) for name in (key, "found"))
    return hits / trials, wilson(hits, trials)


def _sentences(rows: Sequence[Row], presses: int, trials: int) -> list[str]:
    learnt, stated = (where(rows, intervals=way) for way in ("calibrated", "stated"))
    words = [
        f"Intervals are learnt from {presses} simulated presses and tried on {trials} others, by "
        "bodies of other sizes and shapes, at other places, loads and noise; each is read alone. "
        "Counted are the presses of which a contact is found within 8 mm.",
    ]
    for name in OF:
        words.append(
            f"Over all, calibrated 90 % intervals of the {name} hold "
            f"{share_in_words(*pooled(learnt, f'{name}_90'))} of the truths; those that solvers "
            f"state without calibration {share_in_words(*pooled(stated, f'{name}_90'))}."
        )
    cells = [(row, f"{name}_90") for row in learnt for name in OF]
    inside = sum(HONEST[0] <= row[key] / row["found"] <= HONEST[1] for row, key in cells)
    worst, key = min(cells, key=lambda cell: cell[0][cell[1]] / cell[0]["found"])
    words.append(
        f"Of the {len(cells)} calibrated rows of the table, {inside} hold between 85 and 95 %; the "
        f"lowest is the {key[:5]} of {worst['solver']} ({worst['quantity']}, {worst['noise']:g} of "
        f"the typical noise) with {share_in_words(*pooled([worst], key))}."
    )
    return words


def panels(rows: Sequence[Row]) -> list[list[Panel]]:
    """Force and place above each other; quantities and ways beside each other, noises pooled."""
    nominal = 100 * np.array(LEVELS)
    scale = Scale(
        x="stated level (%)", y="truths inside (%)", y_limits=(0.0, 103.0),
        x_limits=(45.0, 100.0), x_ticks=tuple(nominal.tolist()), marks=True,
    )  # fmt: skip
    honest = Curve("as often as stated", nominal, nominal, look=LIMIT)
    quantities = dict.fromkeys(row["quantity"] for row in rows)
    return [
        [
            Panel(f"{name}, {quantity}", title, (honest, *_curves(mine, name)), scale)
            for quantity in quantities
            for way, title in WAYS
            if (mine := where(rows, intervals=way, quantity=quantity))
        ]
        for name in OF
    ]


def _curves(rows: Sequence[Row], name: str) -> list[Curve]:
    curves = []
    for solver in dict.fromkeys(row["solver"] for row in rows):
        mine = where(rows, solver=solver)
        each = [pooled(mine, f"{name}_{100 * level:g}") for level in LEVELS]
        low, high = 100 * np.array([ends for _, ends in each]).T
        shares = 100 * np.array([share for share, _ in each])
        curves.append(Curve(solver, 100 * np.array(LEVELS), shares, low, high))
    return curves


def _table(rows: Sequence[Row]) -> Table:
    body = []
    for row in rows:
        force, place = (
            share_in_words(*pooled([row], f"{name}_90")).replace(" %", "") for name in OF
        )
        cells: dict[str, Cell] = {
            "reads": row["quantity"],
            "noise (of the typical)": row["noise"],
            "solver": row["solver"],
            "intervals": row["intervals"],
            "found (%)": 100 * row["found"] / row["trials"],
            "force in its 90 % interval (%)": force,
            "place in its 90 % circle (%)": place,
            "deviation of the force (% of it)": 100 * row["force_std"],
            "deviation of the place (mm)": row["place_std_mm"],
            "width of the force's 90 % interval (% of the truth)": 100 * row["force_width"],
            "radius of the 90 % circle (mm)": row["place_radius_mm"],
        }
        body.append(cells)
    caption = (
        "Shares of truths inside, with 95 % binomial intervals, and how wide the intervals are: "
        "medians over the presses found."
    )
    return Table.of("coverage", caption, body)
