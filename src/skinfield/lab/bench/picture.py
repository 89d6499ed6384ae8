"""Figure of a benchmark: cost of a reading, and error against time, to the truth too."""

from collections.abc import Callable
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
TIME = "from reading to answer (ms)"
HIGH = 3.0  # inches: of a panel
Bench = dict[str, Any]  # of `run_bench`


def picture(bench: Bench) -> "Figure":
    """Draw Figure 9 anew, and errors to the converged answer and to the truth against time."""
    nodes = tuple(float(n) for n in dict.fromkeys(row["nodes"] for row in bench["grids"]))
    left = Panel(
        "What a reading costs",
        "median; band: mean ± standard deviation",
        tuple(_costs(bench)),
        Scale(
            x="nodes on a side", y="time per reading (ms)", log_x=True, log_y=True, x_ticks=nodes,
            marks=True,
        ),
    )  # fmt: skip
    size = f"{bench['nodes']} × {bench['nodes']} nodes, two fingers move"
    own = Panel(
        "How near its own end",
        f"fields; {size}; nine of ten by then",
        tuple(_curves(bench, _off_its_end)),
        Scale(
            x=TIME, y=f"pressure off that of no deadline (%; {FLOOR:g}: none)", log_x=True,
            log_y=True, y_limits=(FLOOR / 1.5, 150.0), marks=True,
        ),
    )  # fmt: skip
    true = Panel(
        "How near the truth",
        "total force of the contacts; median by then",
        tuple(_curves(bench, lambda point: point["force"].get("p50"))),
        Scale(x=TIME, y="force off the true one (%)", log_x=True, y_limits=(0, 105), marks=True),
    )  # fmt: skip
    return draw_panels([[left, own, true]], HIGH, machine_line(bench))


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


def _off_its_end(point: dict[str, Any]) -> float | None:
    """Of a field; a fit of contacts may end with other shapes, as good, by another deadline."""
    return None if point["solver"] == "ContactFit" else point["usual_errors"].get(BY_THEN)


def _curves(bench: Bench, error_of: Callable[[dict[str, Any]], float | None]) -> list[Curve]:
    """An error against time, a curve per solver and start; a row without one has no point."""
    curves = []
    for name, start in dict.fromkeys((row["solver"], row["start"]) for row in bench["points"]):
        pairs = sorted(
            (1e-3 * point["usual_seconds_us"][BY_THEN], max(100 * error, FLOOR))
            for point in bench["points"]
            if (point["solver"], point["start"]) == (name, start)
            and (error := error_of(point)) is not None
        )
        if pairs:
            x, y = np.array(pairs).T
            words = ", cold" if start == "cold" and name != PAPER else ""
            curves.append(Curve(METHODS.get(name, name) + words, x, y))
    return curves
