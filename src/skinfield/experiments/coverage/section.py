"""Coverage in the report: a table, and a diagram of observed against stated shares."""

from collections.abc import Sequence

import numpy as np

from skinfield.experiments.coverage.plan import LEVELS, CoveragePlan, coverage_plan
from skinfield.experiments.coverage.trials import coverage_parts
from skinfield.experiments.scoring.rows import Row
from skinfield.experiments.scoring.statistics import wilson
from skinfield.experiments.section import Cell, Missing, Part, Picture, Section, Table
from skinfield.experiments.settings import Settings
from skinfield.experiments.words import png_of, share_in_words
from skinfield.figures.coverage import Held, ReliabilityPanel, draw_reliability

OF = (("force", "force"), ("place", "place"))
WAYS = (("calibrated", "calibrated"), ("stated", "as stated without calibration"))
HONEST = (0.85, 0.95)


def coverage_parts_of(settings: Settings) -> list[Part]:
    """One per quantity."""
    return coverage_parts(coverage_plan(settings.size.name, settings.seed))


def coverage(settings: Settings, results: Sequence[list[Row] | None]) -> Section | Missing:
    """The section from the rows of its parts."""
    rows = [row for part in results for row in part or () if row["found"]]
    if not rows:
        return Missing("coverage: none of its parts could be computed")
    return section_of(coverage_plan(settings.size.name, settings.seed), rows)


def section_of(plan: CoveragePlan, rows: Sequence[Row]) -> Section:
    """The section of some rows."""
    return Section(
        name="coverage",
        title="Intervals: do they hold the truth as often as they say?",
        claim="",
        sentences=tuple(_sentences(rows, plan.presses, plan.trials)),
        pictures=(
            Picture("reliability", _caption(rows), png_of(draw_reliability(panels(rows), LEVELS))),
        ),
        tables=(_table(rows), _everything(rows)),
    )


def pooled(rows: Sequence[Row], key: str) -> tuple[float, tuple[float, float]]:
    """Share over some rows with its 95 % interval."""
    hits, trials = (int(sum(row[name] for row in rows)) for name in (key, "found"))
    return hits / trials, wilson(hits, trials)


def _way(rows: Sequence[Row], way: str) -> list[Row]:
    return [row for row in rows if row["intervals"] == way]


def _sentences(rows: Sequence[Row], presses: int, trials: int) -> list[str]:
    learnt, stated = _way(rows, "calibrated"), _way(rows, "stated")
    words = [
        f"Intervals are learnt from {presses} simulated presses and tried on {trials} others, by "
        "bodies of other sizes and shapes, at other places, loads and noise; each is read alone. "
        "Counted are the presses of which a contact is found within 8 mm.",
    ]
    for name, word in OF:
        share, interval = pooled(learnt, f"{name}_90")
        before, around = pooled(stated, f"{name}_90")
        words.append(
            f"Over all, calibrated 90 % intervals of the {word} hold "
            f"{share_in_words(share, interval)} of the truths; those that solvers state without "
            f"calibration {share_in_words(before, around)}."
        )
    cells = [(row, f"{name}_90") for row in learnt for name, _ in OF]
    inside = sum(HONEST[0] <= row[key] / row["found"] <= HONEST[1] for row, key in cells)
    worst, key = min(cells, key=lambda cell: cell[0][cell[1]] / cell[0]["found"])
    least = worst[key] / worst["found"]
    words.append(
        f"Of the {len(cells)} calibrated rows of the table, {inside} hold between 85 and 95 %; the "
        f"lowest is the {key[:5]} of {worst['solver']} ({worst['quantity']}, {worst['noise']:g} of "
        f"the typical noise) with {share_in_words(least, wilson(worst[key], worst['found']))}."
    )
    return words


def panels(rows: Sequence[Row]) -> list[list[ReliabilityPanel]]:
    """Force and place above each other; quantities and ways beside each other, noises pooled."""
    quantities = list(dict.fromkeys(row["quantity"] for row in rows))
    return [
        [
            ReliabilityPanel(
                f"{word}, {quantity}",
                title,
                [
                    _held([r for r in mine if r["solver"] == solver], name, solver)
                    for solver in dict.fromkeys(row["solver"] for row in mine)
                ],
            )
            for quantity in quantities
            for way, title in WAYS
            if (mine := [r for r in _way(rows, way) if r["quantity"] == quantity])
        ]
        for name, word in OF
    ]


def _held(rows: Sequence[Row], name: str, solver: str) -> Held:
    found = [pooled(rows, f"{name}_{100 * level:g}") for level in LEVELS]
    shares = np.array([share for share, _ in found])
    low, high = np.array([ends for _, ends in found]).T
    return Held(solver, shares, low, high)


def _caption(rows: Sequence[Row]) -> str:
    noises = sorted({row["noise"] for row in rows})
    return (
        "Share of the truths inside intervals, against what they say; bars are 95 % binomial "
        "intervals, the grey band is 5 % to each side. Pooled over noises of "
        f"{', '.join(f'{noise:g}' for noise in noises)} of the typical one."
    )


def _table(rows: Sequence[Row]) -> Table:
    body = []
    for row in rows:
        found = row["found"]
        cells: list[Cell] = [row["quantity"], row["noise"], row["solver"], row["intervals"]]
        cells.append(100 * found / row["trials"])
        for name, _ in OF:
            cells += [
                share_in_words(row[key] / found, wilson(row[key], found)).replace(" %", "")
                for key in (f"{name}_90", f"{name}_by_covariance")
            ]
        cells += [100 * row["force_std"], row["place_std_mm"]]
        cells += [100 * row["force_width"], row["place_radius_mm"]]
        body.append(tuple(cells))
    columns = (
        "reads",
        "noise (of the typical)",
        "solver",
        "intervals",
        "found (%)",
        "force in its 90 % interval (%)",
        "force in 1.645 deviations (%)",
        "place in its 90 % circle (%)",
        "place in its 90 % ellipse (%)",
        "deviation of the force (% of it)",
        "deviation of the place (mm)",
        "width of the force's 90 % interval (% of the truth)",
        "radius of the 90 % circle (mm)",
    )
    caption = (
        "Shares of truths inside, with 95 % binomial intervals, and how wide the intervals are: "
        "medians over the presses found."
    )
    return Table("coverage", caption, columns, tuple(body))


def _everything(rows: Sequence[Row]) -> Table:
    keys = tuple(rows[0])
    cells = tuple(tuple(row[key] for key in keys) for row in rows)
    return Table("all", "Every row, with the counts at each level.", keys, cells, shown=False)
