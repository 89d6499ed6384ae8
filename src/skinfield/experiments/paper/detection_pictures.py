"""Pictures of detection: example fields, ROC curves, rates against grid and averaging."""

from collections.abc import Sequence

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.paper.methods import FIELD, PAPER, PAPER_ON_LAYER
from skinfield.experiments.paper.presses import BALL, LOADS, PLACES, paper_patch, readings, sites
from skinfield.experiments.paper.rates import KNOWN, RAW, Detector, Rate, Trial, noisy
from skinfield.experiments.scoring.statistics import roc, wilson
from skinfield.experiments.section import Picture
from skinfield.experiments.settings import Settings
from skinfield.experiments.words import png_of
from skinfield.figures.panels import Line, Panel, Scale, draw_panels
from skinfield.figures.paper import FieldPanel, draw_fields

POINTS = 60  # of a ROC curve


def picture_of_examples(settings: Settings) -> Picture:
    """The paper's Figures 6 and 7: one noisy reading each, seen by three methods."""
    patch, layer = paper_patch(), settings.layer
    columns = [(PAPER, 20), (PAPER, 40), (FIELD, 40)]
    prepared = [method.prepared(patch, layer, n, settings.stress_noise) for method, n in columns]
    panels = []
    for force, place in ((0.2, PLACES[0]), (0.5, PLACES[0]), (0.5, PLACES[2])):
        sited = sites(patch)[place]
        where = sited[np.linalg.norm(sited - [6e-3, 8e-3], axis=1).argmin()]
        clean = readings(BALL, patch, layer, force, settings.size.cell, where[None], "stress")
        solved = BALL.pressed(layer, force, settings.size.cell)
        if clean is None or solved is None:
            raise AssertionError("0.5 N on the half-sphere does not sink")
        radius = float(np.sqrt(solved.contact_area / np.pi))
        rng = np.random.default_rng([settings.seed, 6])
        reading = clean[0] + rng.normal(scale=settings.stress_noise, size=len(patch))
        row = []
        for (method, nodes), reconstruct in zip(columns, prepared, strict=True):
            cells = reconstruct(reading).pressure * 1e-3
            who = "paper" if method is PAPER else "ours"
            title = f"{force:g} N {place}: {who}, {nodes} × {nodes}"
            row.append(FieldPanel(title, reconstruct.grid, cells, [(*where, radius)]))
        panels.append(row)
    caption = (
        "One reading each with the same noise, 1.2 cm half-sphere; the black circle is the true "
        "contact. Grey circles are the pads."
    )
    return Picture("examples", caption, png_of(draw_fields(panels, "pressure (kPa)")))


def picture_of_rocs(
    detectors: Sequence[Detector], quiet: dict[str, Floats], settings: Settings
) -> Picture:
    """Share found against share of false alarms."""
    wanted = (
        f"{PAPER.name}, 20 × 20",
        f"{PAPER.name}, 40 × 40",
        f"{PAPER_ON_LAYER.name}, 20 × 20",
        f"{FIELD.name}, 40 × 40",
        RAW,
        KNOWN,
    )
    chosen = [each for each in detectors if each.label in wanted]
    alarms = np.geomspace(max(1e-4, 4 / settings.size.quiet), 1.0, POINTS)
    panels = []
    for seed, force in ((61, 0.2), (62, 0.5)):
        for place in PLACES:
            pressed = noisy(Trial(BALL, place, force, "stress"), settings, seed)
            if pressed is None:
                raise AssertionError("0.5 N on the half-sphere does not sink")
            lines = [
                Line(each.label, alarms, roc(quiet[each.label], each.statistic(pressed), alarms))
                for each in chosen
            ]
            panels.append(Panel(f"{force:g} N", place, tuple(lines)))
    scale = Scale(
        x="false alarms per idle reading",
        y="share of presses found",
        log_x=True,
        x_limits=(float(alarms[0]), 1.0),
        y_limits=(-0.02, 1.02),
        marks=False,
    )
    caption = (
        f"Receiver operating characteristics over {settings.size.presses} presses of the 1.2 cm "
        f"half-sphere and {settings.size.quiet} idle readings, one reading each. Where a curve is "
        "not to be seen, another lies on it."
    )
    return Picture("roc", caption, png_of(draw_panels(panels, scale)))


def picture_of_grids(rates: Sequence[Rate], settings: Settings) -> Picture:
    """Share found against load: the paper's method on each grid, and ours."""
    shown = [(PAPER.name, nodes) for nodes in settings.size.grids] + [(FIELD.name, 40)]
    panels = []
    for place in PLACES:
        lines = []
        for name, nodes in shown:
            mine = [
                rate
                for rate in rates
                if (rate.detector, rate.nodes) == (name, nodes)
                and (rate.trial.place, rate.trial.tip.name) == (place, BALL.name)
            ]
            x = np.array([rate.trial.force for rate in mine])
            ends = np.array([wilson(rate.hits, rate.presses) for rate in mine]).T
            share = np.array([rate.share for rate in mine])
            lines.append(Line(f"{name}, {nodes} × {nodes}", x, share, ends[0], ends[1]))
        panels.append(Panel("1.2 cm half-sphere", place, tuple(lines)))
    scale = Scale(
        x="load (N)", y="share of presses found", log_x=True, y_limits=(-0.02, 1.02), x_ticks=LOADS
    )
    caption = (
        f"Share of presses found at {settings.false_alarms:g} false alarms per idle reading; bands "
        "are 95 % intervals. The load lies on a logarithmic axis."
    )
    return Picture("grids", caption, png_of(draw_panels(panels, scale)))


def picture_of_averages(
    counts: Sequence[int], averages: dict[str, dict[str, Floats]], settings: Settings
) -> Picture:
    """Share found at 0.2 N against the number of readings averaged."""
    trials, x = settings.size.presses, np.array(counts, dtype=float)
    panels = []
    for place, shares in averages.items():
        lines = []
        for label, share in shares.items():
            low, high = np.array([wilson(round(s * trials), trials) for s in share]).T
            lines.append(Line(label, x, share, low, high))
        panels.append(Panel("0.2 N", place, tuple(lines)))
    scale = Scale(
        x="readings averaged",
        y="share of presses found",
        log_x=True,
        y_limits=(-0.02, 1.02),
        x_ticks=tuple(x[::3]),
    )
    caption = (
        "Presses of 0.2 N found when readings with independent noise are averaged, at "
        f"{settings.false_alarms:g} false alarms; bands are 95 % intervals."
    )
    return Picture("averaging", caption, png_of(draw_panels(panels, scale)))
