"""The campaign as pictures: distributions of errors, and two balls told apart."""

from collections.abc import Sequence

import numpy as np

from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.scoring.statistics import wilson
from skinfield.experiments.section import Picture
from skinfield.experiments.trust.ball_bound import KNOWN, UNKNOWN
from skinfield.experiments.trust.plan import GAUSSIAN, PAPER, TrustPlan
from skinfield.experiments.trust.table import column
from skinfield.experiments.words import png_of
from skinfield.figures.panels import Line, Panel, Scale, draw_panels
from skinfield.figures.trust import DistributionPanel, Errors, draw_distributions

NAMES = {PAPER: "paper's method", GAUSSIAN: "GaussianField", "contact": "ContactFit"}
ERRORS = (  # column, label, factor, ends of the axis
    ("force_error", "error of the force (%)", 100.0, (0.3, 200.0)),
    ("place_error_m", "error of place (mm)", 1e3, (0.01, 8.0)),
)


def noise_in_words(quantity: str, noise: float) -> str:
    """Such as "0.38 kPa"; "exact" for none."""
    if noise == 0.0:
        return "exact"
    return f"{noise / 1e3:g} kPa" if quantity == "stress" else f"{noise:g}"


def name_of(method: str) -> str:
    """What a method is called in words."""
    return NAMES.get(method, method.rpartition(":")[2])


def picture_of_errors(quantity: str, rows: Sequence[Row], bound: Sequence[Row]) -> Picture:
    """Share of readings below each error of force and place, noise by noise."""
    noises = list(dict.fromkeys(row["noise"] for row in rows if row["quantity"] == quantity))
    solvers = list(dict.fromkeys(row["method"] for row in rows))
    balls = {row["case"] for row in bound}
    panels = []
    for key, label, factor, _ in ERRORS:
        line = []
        for noise in noises:
            errors = []
            for name, among in [
                *((solver, rows) for solver in solvers),
                *((limit, bound) for limit in (KNOWN, UNKNOWN)),
            ]:
                wanted = (quantity, noise, name)
                mine = [r for r in among if (r["quantity"], r["noise"], r["method"]) == wanted]
                if balls and mine:
                    mine = [row for row in mine if row["case"] in balls]
                if mine:
                    limit = name in (KNOWN, UNKNOWN)
                    errors.append(Errors(name_of(name), factor * column(mine, key), limit))
            title = ("noise " if noise else "") + noise_in_words(quantity, noise)
            line.append(DistributionPanel(title, label, errors))
        panels.append(line)
    count = len(balls) if balls else len({row["case"] for row in rows})
    caption = (
        f"{quantity.capitalize()} read with the noise named above each panel: share of {count} "
        f"presses{', by balls alone,' if balls else ''} whose error of the force of all contacts "
        "(top) and mean error of place of those found (bottom) is below a value; where nothing is "
        "found there is no place, so that curves of place end below 1."
    )
    if balls:
        caption += (
            " Black: what an unbiased estimate at the Cramér-Rao bound would show, with the "
            "balls' sizes known, and known to a standard deviation of 0.6 in the logarithm."
        )
    figure = draw_distributions(panels, [ends for *_, ends in ERRORS])
    return Picture(f"errors-{quantity}", caption, png_of(figure))


def picture_of_pairs(plan: TrustPlan, pairs: Sequence[Row]) -> Picture:
    """Share of two balls found as two, against their distance."""
    panels = []
    for level in plan.pairs:
        lines = []
        for method in plan.methods:
            wanted = (level.quantity, level.noise, method.name)
            mine = [r for r in pairs if (r["quantity"], r["noise"], r["method"]) == wanted]
            mine.sort(key=lambda row: float(row["distance_mm"]))
            if mine:
                ends = np.array([wilson(row["found"], row["trials"]) for row in mine]).T
                share = np.array([row["found"] / row["trials"] for row in mine])
                x = column(mine, "distance_mm")
                lines.append(Line(name_of(method.name), x, share, ends[0], ends[1]))
        noise = noise_in_words(level.quantity, level.noise)
        panels.append(Panel(level.quantity, f"noise {noise}", tuple(lines)))
    low, high = 1e3 * plan.distances[0] - 0.3, 1e3 * plan.distances[-1] + 0.3
    scale = Scale(
        x="distance (mm)",
        y="share found as two",
        y_limits=(0.0, 1.02),
        x_limits=(low, high),
        x_ticks=tuple(t for t in range(0, 100, 2) if low <= t <= high),
    )
    caption = (
        f"Two balls of 6 mm with 1 N each, {plan.trials} presses at random places and angles per "
        "distance: exactly two contacts found, each nearer than half the distance to its own "
        "ball. Shaded: 95 % intervals (Wilson)."
    )
    return Picture("two-points", caption, png_of(draw_panels(panels, scale)))
