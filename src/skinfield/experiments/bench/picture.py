"""Figures of a benchmark: what a reading costs, and error against time."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from skinfield.experiments.bench.anytime import Point
from skinfield.experiments.bench.grids import FIELD, PAPER, PAPER_REST_MS, PREPARED, GridTime
from skinfield.experiments.bench.run import Bench
from skinfield.figures.bench import Curve, View, draw_bench

if TYPE_CHECKING:
    from skinfield.figures.png import Figure

THE_PAPER = "the paper's algorithm, each reading"
LINEAR, FIELD_SOLVER, FIT = "linear, prepared once", "NonNegative", "ContactFit"
METHODS = {PAPER: THE_PAPER, "GaussianField": LINEAR}  # other solvers by their own name
ORDER = (THE_PAPER, LINEAR, FIELD_SOLVER, FIT)
COSTS = (  # rows of the left panel: name, method, kind
    (PAPER, THE_PAPER, "solid"),
    (FIELD, LINEAR, "solid"),
    ("NonNegative to 1e-4, warm", FIELD_SOLVER, "solid"),
    ("NonNegative to 1e-2, warm", FIELD_SOLVER, "dashed"),
    ("ContactFit", FIT, "solid"),
)
BY_THEN = "p90"  # nine of ten answers are there by then, and as close as that
Value = Callable[[Point], float | None]


def picture(bench: Bench) -> "Figure":
    """Draw Figure 9 anew, and error to the converged answer against time."""
    left = View(
        "What a reading costs",
        "median; bars: mean ± standard deviation, as in the paper's Figure 9",
        tuple(_costs(bench)),
        x="nodes",
        y="time per reading",
        x_is="nodes",
    )
    right = View(
        "How close, by when",
        f"{bench.nodes} × {bench.nodes} nodes, two fingers move; nine of ten answers are this good "
        "by then",
        tuple(_curves(bench, _error)),
        x="time from the reading to the answer",
        y="error of the pressure to the converged one",
        y_is="share",
        floor=True,
    )
    kinds = (
        ("dashed", "a: gap 1 %, not 0.01 %; b: cold"),
        ("hollow", "the paper's own, all but the inversion"),
    )
    return draw_bench(left, right, ORDER, foot=machine_line(bench), kinds=kinds)


def picture_of_truth(bench: Bench) -> "Figure":
    """Draw error of place and of force to the truth against time."""
    left, right = (
        View(
            title,
            f"two fingers move, {bench.nodes} × {bench.nodes} nodes; medians",
            tuple(_curves(bench, value)),
            x="time from the reading to the answer",
            y=label,
            y_is=unit,
        )
        for title, label, unit, value in (
            ("Place", "distance of a contact to its finger", "length", _place),
            ("Force", "error of the sum of all contacts", "share", _force),
        )
    )
    return draw_bench(left, right, ORDER, foot=machine_line(bench), kinds=(("dashed", "cold"),))


def machine_line(bench: Bench) -> str:
    """Processor and versions, in a line."""
    machine = bench.machine
    packages = ", ".join(f"{name} {machine.packages[name]}" for name in ("numpy", "numba"))
    busy = "; other programs were running" if bench.warnings else ""
    return f"{machine.processor}, {machine.python}, {packages}, {bench.when[:10]}{busy}"


def _costs(bench: Bench) -> list[Curve]:
    curves = []
    for name, method, kind in COSTS:
        rows = [row for row in bench.grids if row.name == name]
        nodes = np.array([float(row.nodes) for row in rows])
        middle, mean, std = (
            np.array([row.seconds[key] for row in rows]) for key in ("p50", "mean", "std")
        )
        low = np.maximum(mean - std, [row.seconds["min"] for row in rows])
        ends = (np.minimum(low, middle), np.maximum(mean + std, middle))
        curves.append(Curve(method, nodes, middle, kind, *(ends if name == PAPER else ())))
    stated = [nodes for nodes in PAPER_REST_MS if any(row.nodes == nodes for row in bench.grids)]
    rest = np.array([1e-3 * PAPER_REST_MS[nodes] for nodes in stated])
    return [*curves, Curve(THE_PAPER, np.array(stated, dtype=float), rest, "hollow")]


def _curves(bench: Bench, value: Value) -> list[Curve]:
    """A curve per solver and start; a deadline at which there is no value has no mark."""
    curves = []
    for name in dict.fromkeys(point.solver for point in bench.points):
        for start, kind in (("warm", "solid"), ("cold", "dashed")):
            found = [p for p in bench.points if (p.solver, p.start) == (name, start)]
            pairs = [
                (point.usual_seconds[BY_THEN], y)
                for point in found
                if point.usual_seconds is not None and (y := value(point)) is not None
            ]
            if pairs:
                x, y = np.array(pairs).T
                single = "solid" if len(found) == 1 else kind
                curves.append(Curve(METHODS.get(name, name), x, y, single))
    return curves


def _error(point: Point) -> float | None:
    return None if point.usual_errors is None else point.usual_errors[BY_THEN]


def _place(point: Point) -> float | None:
    return point.place_median


def _force(point: Point) -> float | None:
    return None if point.force is None else point.force["p50"]


def prepared_gain(grids: tuple[GridTime, ...], nodes: int) -> float:
    """How many times the paper's algorithm takes the prepared operator's time, by medians."""
    times = {row.name: row.seconds["p50"] for row in grids if row.nodes == nodes}
    return times[PAPER] / times[PREPARED]
