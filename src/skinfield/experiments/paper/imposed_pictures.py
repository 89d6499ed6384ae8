"""Pictures of the imposed deformation: fields beside the truth, and the peaks."""

from collections.abc import Sequence

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.paper.imposed_found import GRIDS, Found
from skinfield.experiments.paper.imposed_truth import (
    ADJACENT,
    DEPTH,
    HALF_SPACE,
    LAYER,
    OWN_GRID,
    SEPARATE,
    Truth,
)
from skinfield.experiments.paper.methods import FIELD, PAPER
from skinfield.experiments.section import Picture
from skinfield.experiments.words import png_of
from skinfield.figures.panels import draw_bars
from skinfield.figures.paper import FieldPanel, draw_fields

SHOWN = {ADJACENT: 15e-3, SEPARATE: 25e-3}  # m, to each side of the middle
FIGURE = {ADJACENT: "Figure 4", SEPARATE: "Figure 5"}


def picture_of_fields(found: Sequence[Found], case: str) -> tuple[Picture, Picture]:
    """Deformation and pressure of a case on the layer: truth and three grids, paper and ours."""
    shown = {
        (each.method.name, each.nodes): each
        for each in found
        if (each.truth.world, each.truth.case) == (LAYER, case)
    }
    truth = next(iter(shown.values())).truth
    circles = [(x, y, truth.grid.patch.pad_diameter / 2) for x, y in truth.places.tolist()]
    middle = truth.places.mean(axis=0)
    window = np.array([middle - SHOWN[case], middle + SHOWN[case]])
    pictures = []
    for name, label, scale in (
        ("deformation", "indentation (mm)", 1e3),
        ("pressure", "pressure (kPa)", 1e-3),
    ):
        rows = []
        for method, who in ((PAPER, "paper"), (FIELD, "ours")):
            panels = [FieldPanel("truth", truth.grid, scale * _true(truth, name), circles)]
            for nodes in GRIDS:
                estimate = shown[method.name, nodes].estimate
                values = estimate.pressure if name == "pressure" else estimate.indentation
                title = f"{who}, {nodes} × {nodes}"
                panels.append(FieldPanel(title, estimate.grid, scale * values, circles))
            rows.append(panels)
        caption = (
            f"{FIGURE[case]}: {DEPTH * 1e3:g} mm imposed on {case} (black circles) of the layer, "
            f"{name}: truth, and what is reconstructed on three grids."
        )
        short = "adjacent" if case == ADJACENT else "separate"
        pictures.append(
            Picture(f"{short}-{name}", caption, png_of(draw_fields(rows, label, window=window)))
        )
    return pictures[0], pictures[1]


def _true(truth: Truth, name: str) -> Floats:
    """Of the finest cells; the pressure's edges are clipped, as a flat disc's has no bound."""
    if name == "deformation":
        return truth.indentation
    pressed = truth.pressure[truth.pressure > 0]
    return np.minimum(truth.pressure, 3 * float(np.median(pressed)))


def picture_of_peaks(found: Sequence[Found]) -> Picture:
    """Mean peak of the three discs, by method and way of making the readings."""
    wanted = [
        (LAYER, PAPER, "paper"),
        (HALF_SPACE, PAPER, "paper"),
        (OWN_GRID, PAPER, "paper"),
        (LAYER, FIELD, "ours"),
    ]
    groups, heights = [], []
    for case in (ADJACENT, SEPARATE):
        for world, method, who in wanted:
            mine = [
                each
                for each in found
                if (each.truth.world, each.truth.case) == (world, case) and each.method is method
            ]
            groups.append(f"{who},\n{world}\n{case.split()[1]}")
            heights.append([1e3 * float(each.peaks.mean()) for each in mine])
    series = [
        (f"{nodes} × {nodes}", np.array([row[index] for row in heights]))
        for index, nodes in enumerate(GRIDS)
    ]
    figure = draw_bars(
        groups,
        series,
        label="peak deformation (mm)",
        title="Peak deformation reconstructed",
        note="mean of the three discs; second line: how the readings were made",
        line=(1e3 * DEPTH, "imposed"),
    )
    caption = (
        f"Peak of the reconstructed deformation where {DEPTH * 1e3:g} mm are imposed, by method "
        "and by the mechanics that made the readings."
    )
    return Picture("peaks", caption, png_of(figure))
