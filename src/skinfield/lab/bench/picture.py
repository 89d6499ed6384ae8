"""Figure of a benchmark: cost of a reading, and error against time."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.lab.bench.run import FIELD, PAPER
from skinfield.lab.plots import Curve, Panel, Scale, draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure


FLOOR = 0.1  # %: errors below count as none, and are drawn here
THE_PAPER = "the paper's algorithm, each reading"
LINEAR = "linear, prepared once"
METHODS = {PAPER: THE_PAPER, "GaussianField": LINEAR}  # other solvers by their own name
COSTS = (  # rows of the left panel: name, and what the legend calls it
    (PAPER, THE_PAPER),
    (FIELD, LINEAR),
    ("NonNegative to 1e-4, warm", "NonNegative"),
    ("NonNegative to 1e-2, warm", "NonNegative to 1 %"),
    ("ContactFit", "ContactFit"),
)
BY_THEN = "p90"  # nine of ten answers are there by then, and as close as that
TIME = "time from the reading to the answer (ms)"
HIGH = 3.0  # inches: of a panel
Bench = dict[str, Any]  # of `run_bench`


def picture(bench: Bench) -> "Figure":
    """Draw Figure 9 anew, and error to the converged answer against time."""
    nodes = tuple(float(n) for n in dict.fromkeys(row["nodes"] for row in bench["grids"]))
    left = Panel(
        "What a reading costs",
        "median; bands: mean ± standard deviation, as in the paper's Figure 9",
        tuple(_costs(bench)),
        Scale(
            x="nodes on a side", y="time per reading (ms)", log_x=True, log_y=True, x_ticks=nodes,
            marks=True,
        ),
    )  # fmt: skip
    right = Panel(
        "How close, by when",
        f"{bench['nodes']} × {bench['nodes']} nodes, two fingers move; nine of ten by then",
        tuple(_curves(bench)),
        Scale(
            x=TIME, y=f"error to the converged one (%; {FLOOR:g}: none)", log_x=True,
            log_y=True, y_limits=(FLOOR / 1.5, None), marks=True,
        ),
    )  # fmt: skip
    return draw_panels([[left, right]], HIGH, machine_line(bench))


def machine_line(bench: Bench) -> str:
    """Processor and versions, in a line."""
    machine = bench["machine"]
    packages = ", ".join(f"{name} {machine['packages'][name]}" for name in ("numpy", "numba"))
    busy = "; other programs were running" if bench["warnings"] else ""
    return f"{machine['processor']}, {machine['python']}, {packages}, {bench['when'][:10]}{busy}"


def _costs(bench: Bench) -> list[Curve]:
    curves = []
    for name, method in COSTS:
        rows = [row for row in bench["grids"] if row["name"] == name]
        nodes = np.array([float(row["nodes"]) for row in rows])
        middle, mean, std, least = (
            1e-3 * np.array([row["seconds_us"][key] for row in rows])
            for key in ("p50", "mean", "std", "min")
        )
        ends = (np.minimum(np.maximum(mean - std, least), middle), np.maximum(mean + std, middle))
        curves.append(Curve(method, nodes, middle, *(ends if name == PAPER else ())))
    return curves


def _curves(bench: Bench) -> list[Curve]:
    """Error to the converged answer, a curve per solver and start."""
    curves = []
    for name, start in dict.fromkeys((row["solver"], row["start"]) for row in bench["points"]):
        pairs = [
            (1e-3 * point["usual_seconds_us"][BY_THEN],
             max(100 * point["usual_errors"][BY_THEN], FLOOR))
            for point in bench["points"]
            if (point["solver"], point["start"]) == (name, start) and point["usual_errors"]
        ]  # fmt: skip
        if pairs:
            x, y = np.array(pairs).T
            words = ", cold" if start == "cold" and name != PAPER else ""
            curves.append(Curve(METHODS.get(name, name) + words, x, y))
    return curves
