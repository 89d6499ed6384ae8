"""Pictures of light touch: ROC curves, shares against force, and against time."""

from collections.abc import Sequence

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.light_touch.live import Live
from skinfield.experiments.light_touch.rates import LIGHT, Found
from skinfield.experiments.light_touch.trials import (
    BOUND,
    KINDS,
    LOOKED,
    MATCH,
    OURS,
    PAPERS,
    QUANTITIES,
    TAXEL,
    Touch,
    noise_of,
)
from skinfield.experiments.scoring.statistics import wilson
from skinfield.experiments.section import Picture
from skinfield.experiments.words import png_of
from skinfield.figures.detection import Curve, CurvePanel, draw_curves
from skinfield.figures.style import plural

SHOWN = (PAPERS, TAXEL, MATCH, OURS, BOUND)  # the paper's other form lies on its first


def _curve(name: str, x: Floats, y: Floats, low: Floats | None, high: Floats | None) -> Curve:
    return Curve(name, x, y, low, high, reference=name == BOUND)


def picture_of_rocs(found: Found) -> Picture:
    """Stress: share found against false alarms."""
    rows = []
    for force, averaged in LIGHT:
        row = []
        for place in KINDS:
            curves = found.rocs(Touch("stress", place, force), averaged)
            lines = [_curve(name, found.alarms, curves[name], None, None) for name in SHOWN]
            title, note = f"{force:g} N {place}", plural(averaged, "reading")
            row.append(CurvePanel(title, note, tuple(lines), found.settings.false_alarms))
        rows.append(row)
    figure = draw_curves(
        rows,
        x="false alarms per decision",
        y="share of touches found",
        x_limits=(float(found.alarms[0]), 1.0),
        x_ticks=tuple(tick for tick in (1e-4, 1e-3, 1e-2, 0.1) if tick >= found.alarms[0]),
    )
    settings = found.settings
    caption = (
        "Receiver operating characteristics with a noise of "
        f"{noise_of(settings, 'stress') / 1e3:g} kPa in each reading: above a "
        f"single one, below {LOOKED} together, {LOOKED / settings.rate:g} s at {settings.rate:g} "
        f"Hz. {settings.size.presses} presses of a 12 mm ball per panel, {settings.size.quiet} "
        "idle ones. Dashed: a matched filter that is told place and shape; dotted: "
        f"{settings.false_alarms:g} false alarms."
    )
    return Picture("roc", caption, png_of(figure))


def picture_of_forces(found: Found) -> Picture:
    """Share found against force, by what taxels read and place."""
    x, rows = np.array(found.forces), []
    for quantity in QUANTITIES:
        row = []
        for place in KINDS:
            lines = []
            for name in SHOWN:
                shares = [
                    each
                    for each in found.shares
                    if each.method == name
                    and (each.touch.quantity, each.touch.place) == (quantity, place)
                ]
                if shares:
                    value, low, high = np.array([(s.value, s.low, s.high) for s in shares]).T
                    lines.append(_curve(name, x, value, low, high))
            noise = noise_of(found.settings, quantity)
            words = f"σ {noise / 1e3:g} kPa" if quantity == "stress" else f"σ {noise:g} of ΔC/C₀"
            row.append(CurvePanel(place, words, tuple(lines)))
        rows.append(row)
    figure = draw_curves(rows, x="force (N)", y="share of touches found", x_ticks=found.forces)
    caption = (
        f"Share found against force at {found.settings.false_alarms:g} false alarms per decision "
        f"over {LOOKED} readings; above, taxels that read stress, below capacitance. Bands are "
        "95 % intervals."
    )
    return Picture("forces", caption, png_of(figure))


def picture_of_time(runs: Sequence[Live], found: Found) -> Picture:
    """Share found against the time since touch."""
    settings = found.settings
    panels = []
    for live in runs:
        time = (np.arange(len(live.now)) + 1) / settings.rate
        lines = []
        for name, share in (("at this reading", live.now), ("up to this reading", live.once)):
            low, high = np.array([wilson(round(s * live.trials), live.trials) for s in share]).T
            lines.append(Curve(name, time, share, low, high))
        title, window = f"{live.touch.force:g} N {live.touch.place}", LOOKED / settings.rate
        panels.append(CurvePanel(title, "", tuple(lines), window))
    figure = draw_curves(
        [panels], x="time since touch (s)", y="share of touches found", log_x=False
    )
    caption = (
        f"A stream that looks back over 1, 3, 7 and {LOOKED} readings at {settings.rate:g} Hz, at "
        f"{settings.false_alarms:g} false alarms per reading: share of {runs[0].trials} touches "
        f"that are seen, with {settings.stress_noise / 1e3:g} kPa of noise in each reading. "
        "Dotted: the longest length; bands are 95 % intervals."
    )
    return Picture("time", caption, png_of(figure))
