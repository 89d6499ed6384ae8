"""Draw the errors that `skinfield validate --unseen` finds, for docs/explanation/paper.md.

python docs/figures/accuracy.py [PRESSES] [PROCESSES]
"""

import sys
from pathlib import Path

import numpy as np
from looks import dashed
from matplotlib.figure import Figure

from skinfield.errors import Floats
from skinfield.lab.accuracy import NOISES, PRIORS, AccuracyPlan, Findings, computed
from skinfield.lab.plots import Curve, Panel, Scale, draw_panels
from skinfield.lab.score import column, where
from skinfield.lab.validation import AUTO, GAUSSIAN, PAPER, NoiseLevel, known_entrants
from skinfield.plot import save

IMAGES = Path(__file__).parents[1] / "images"
NAMES = {PAPER: "paper's method", GAUSSIAN: "GaussianField", AUTO: "Auto"}
ERRORS = (  # column, label, factor, ends of the axis
    ("force_error", "error of the force (%)", 100.0, (0.3, 200.0)),
    ("place_error_mm", "error of place (mm)", 1.0, (0.01, 8.0)),
)


def noise_in_words(quantity: str, noise: float) -> str:
    """Such as "0.38 kPa"; "exact" for none."""
    if noise == 0.0:
        return "exact"
    return f"{noise / 1e3:g} kPa" if quantity == "stress" else f"{noise:g}"


def name_of(method: str) -> str:
    """What an entrant is called in words."""
    return NAMES.get(method, method.rpartition(":")[2])


def distribution(name: str, values: Floats, ends: tuple[float, float]) -> Curve:
    """Share of values (N,) below each error, from one end to the other; NaN counts as above all."""
    known = np.sort(values[np.isfinite(values)])
    share = np.arange(1, len(known) + 1) / max(len(values), 1)
    x = np.concatenate([[ends[0] / 10], known, [ends[1] * 10]])
    y = np.concatenate([[0.0], share, share[-1:] if len(share) else [0.0]])
    return Curve(name, np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1])


def picture_of_errors(quantity: str, findings: Findings) -> Figure:
    """Share of readings below each error of force and place, noise by noise."""
    rows, balls = findings.rows, {row["case"] for row in findings.bound}
    noises = list(dict.fromkeys(row["noise"] for row in where(rows, quantity=quantity)))
    solvers = list(dict.fromkeys(row["method"] for row in rows))
    panels = []
    for key, label, factor, ends in ERRORS:
        scale = Scale(
            x=label, y="share of readings", log_x=True, x_limits=ends, y_limits=(0.0, 1.02)
        )
        line = []
        for noise in noises:
            curves = []
            for name in (*solvers, *PRIORS):
                mine = where(
                    findings.bound if name in PRIORS else rows,
                    quantity=quantity, noise=noise, method=name,
                )  # fmt: skip
                mine = [row for row in mine if not balls or row["case"] in balls]
                if mine:
                    errors = factor * np.abs(column(mine, key))
                    curves.append(distribution(name_of(name), errors, ends))
            title = ("noise " if noise else "") + noise_in_words(quantity, noise)
            line.append(Panel(title, "", tuple(curves), scale))
        panels.append(line)
    figure = draw_panels(panels)
    dashed(figure, *PRIORS)
    return figure


if __name__ == "__main__":
    presses, workers = (*map(int, sys.argv[1:]), *(200, 1)[len(sys.argv) - 1 :])
    levels = tuple(NoiseLevel("capacitance", noise) for noise in NOISES["capacitance"])
    found = computed(
        AccuracyPlan(entrants=known_entrants(), levels=levels, presses=presses), workers
    )
    save(picture_of_errors("capacitance", found), IMAGES / "experiments-unseen-capacitance.png")
