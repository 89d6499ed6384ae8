"""Grid resolution, Figure 8: one press on coarse and fine grids, and whether smoother is truer."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skinfield.errors import Floats
from skinfield.estimate import Estimate
from skinfield.lab.paper import BALL, FIELD, NOISES, PAPER, PLACES, Method, readings, sites
from skinfield.lab.plots import Curve, FieldPanel, Panel, Scale, draw_fields, draw_panels
from skinfield.lab.report import Cell, Chapter, Claim, Effort, Picture, Table, verdict_of
from skinfield.skin import Grid

FORCE, PLACE = 1.8, PLACES[2]  # N, of Figure 8
AROUND = 8e-3  # m: of the press, in which a field is looked at
MEASURES = (  # of `Score.values`: title, note, factor
    ("Roughness", "second differences over peak", 1.0),
    ("Force found (%)", "within 8 mm of the press", 100.0),
    ("Error of place (mm)", "of the strongest contact", 1e3),
)
CLAIM = (
    "Between three taxels, 1.8 N: the surface is smoother the finer the grid; on 40 × 40 nodes "
    "with 72 taxels it is oversampled, yet mimics the elastomer."
)


class Score(NamedTuple):
    """Of one method on one grid, over many noisy presses."""

    method: Method
    nodes: int
    values: Floats  # (T, 3), see `_of_one`

    @property
    def medians(self) -> Floats:
        """Of roughness, force in % and place in mm."""
        return np.nanmedian(self.values, axis=0) * [factor for *_, factor in MEASURES]


def resolutions(settings: Effort) -> Chapter:
    """Four grids side by side, with smoothness, force and place over many presses."""
    places, noisy = _pressed(settings)
    paper, ours = (
        [_scored(method, nodes, settings, places, noisy) for nodes in settings.grids]
        for method in (PAPER, FIELD)
    )
    rough = [float(score.medians[0]) for score in paper]
    falls = all(after < before for before, after in pairwise(rough))
    caption = f"{FORCE:g} N {PLACE} taxels, over {len(places)} presses."
    return Chapter(
        title="Figure 8: one press on four grids",
        claim=CLAIM,
        sentences=(
            f"{len(places)} presses of {FORCE:g} N with the 1.2 cm half-sphere, each between three "
            f"taxels, one reading each with {NOISES['stress'] / 1e3:g} kPa of noise. "
            "Roughness is the root mean square of the second differences from cell to cell "
            f"within {AROUND * 1e3:g} mm of the press, over the highest pressure there. Smoother "
            "need not be truer: force and place say how true.",
        ),
        pictures=(_picture_of_fields(settings, places, noisy), _picture_of_scores([paper, ours])),
        tables=(Table("scores", caption, [_row(score) for score in (*paper, *ours)]),),
        verdicts=(
            Claim(
                "8",
                "the finer the grid, the smoother the surface",
                f"roughness {', '.join(f'{one:.2f}' for one in rough)} on grids from coarse to "
                "fine",
                verdict_of(falls, rough[-1] < rough[0]),
            ),
        ),
    )


def _pressed(settings: Effort) -> tuple[Floats, Floats]:
    """Places (T, 2) m, the first in the picture, and noisy readings (T, L)."""
    count = min(settings.presses, 1000)
    rng = np.random.default_rng([settings.seed, 8])
    sited = sites()[PLACE]
    first = np.linalg.norm(sited - [6e-3, 8e-3], axis=1).argmin()
    places = sited[np.append(first, rng.integers(len(sited), size=count - 1))]
    cell = settings.cell
    clean = readings(BALL, FORCE, cell, places, "stress")
    return places, clean + rng.normal(scale=NOISES["stress"], size=clean.shape)


def _scored(method: Method, nodes: int, settings: Effort, places: Floats, noisy: Floats) -> Score:
    reconstruct = method.prepared(nodes, NOISES["stress"])
    estimate = reconstruct(noisy)
    each = [_of_one(estimate, row, place) for row, place in enumerate(places)]
    return Score(method, nodes, np.array(each))


def _of_one(estimate: Estimate, row: int, place: Floats) -> tuple[float, float, float]:
    """Roughness, part of the force found around the place, and distance of the contact in m."""
    grid, pressure = estimate.grid, estimate.pressure[row]
    near = np.linalg.norm(grid.plane - place, axis=1) < AROUND
    force = float(pressure[near].sum()) * grid.cell_area / FORCE
    contacts = estimate.contacts[row]
    off = np.linalg.norm(contacts[0].position[:2] - place) if contacts else np.nan
    return roughness(grid, pressure, near), force, float(off)


def roughness(grid: Grid, pressure: Floats, near: Floats) -> float:
    """Root mean square of second differences at the nodes `near` (K,), over the peak there."""
    picture, inside = pressure.reshape(grid.shape), near.reshape(grid.shape)
    along = np.diff(picture, 2, axis=1)[inside[:, 1:-1]]
    across = np.diff(picture, 2, axis=0)[inside[1:-1]]
    bends = np.concatenate([along, across])
    return float(np.sqrt(np.mean(bends**2)) / np.abs(pressure[near]).max())


def _picture_of_fields(settings: Effort, places: Floats, noisy: Floats) -> Picture:
    truth = [(*places[0], BALL.contact_radius(FORCE, settings.cell))]
    rows = []
    for method, who in ((PAPER, "paper"), (FIELD, "ours")):
        row = []
        for nodes in settings.grids:
            estimate = method.prepared(nodes, NOISES["stress"])(noisy[0])
            title = f"{who}, {nodes} × {nodes}"
            row.append(FieldPanel(title, estimate.grid, estimate.pressure * 1e-3, truth))
        rows.append(row)
    caption = (
        f"The same reading of {FORCE:g} N {PLACE} taxels on four grids; the black circle is the "
        "true contact."
    )
    return Picture.of("fields", caption, draw_fields(rows, "pressure (kPa)"))


def _picture_of_scores(scores: list[list[Score]]) -> Picture:
    """Medians and quartiles of each method's scores, from coarse to fine."""
    ticks = tuple(float(score.nodes) for score in scores[0])
    scale = Scale(x="nodes on a side", y="", y_limits=(0.0, None), x_ticks=ticks, marks=True)
    panels = []
    for index, (title, note, factor) in enumerate(MEASURES):
        curves = []
        for mine in scores:
            each = [np.nanpercentile(score.values[:, index], (25, 50, 75)) for score in mine]
            low, middle, high = factor * np.array(each).T
            curves.append(Curve(mine[0].method.name, np.array(ticks), middle, low, high))
        panels.append(Panel(title, note, tuple(curves), scale))
    caption = "Medians over all presses; bands hold the middle half of them."
    return Picture.of("scores", caption, draw_panels([panels]))


def _row(score: Score) -> dict[str, Cell]:
    rough, force, place = score.medians.tolist()
    low, high = 100 * np.percentile(score.values[:, 1], (25, 75))
    return {
        "method": score.method.name,
        "nodes on a side": score.nodes,
        "roughness, median": rough,
        "force found, median (%)": force,
        "force found, quartiles (%)": f"{low:.0f} to {high:.0f}",
        "place, median (mm)": place,
        "place, 90th percentile (mm)": 1e3 * float(np.nanpercentile(score.values[:, 2], 90)),
    }
