"""Imposed deformation, Figures 3 to 5: 0.2 mm on three taxels, reconstructed without noise."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skinfield.errors import Floats
from skinfield.estimate import Estimate
from skinfield.lab.paper import FIELD, LAYER, PAIR, PAPER, Method, paper_patch
from skinfield.lab.plots import FieldPanel, draw_fields
from skinfield.lab.report import (
    Chapter,
    Claim,
    Effort,
    Picture,
    Table,
    listed,
    spread_in_words,
    verdict_of,
)
from skinfield.lab.score import Row
from skinfield.simulate import Cylinder, press
from skinfield.skin import Grid, Patch

DEPTH = 0.2e-3  # m
EXTENT = 46e-3  # m: side of the square that holds all discs
INNER_TRIO = (0.0, 10.7e-3)  # m: near the middle of the three adjacent taxels
APART = 15e-3  # m: of the separate taxels from the middle
ADJACENT, SEPARATE = "three adjacent taxels", "three separate taxels"
CELL = 0.5e-3  # m; the contact is solved on finer squares
PARTS = 5  # to a side of a cell, when its force is shared among others
GRIDS = (20, 30, 40)
NOISE = 10.0  # Pa: nothing is added; below it the contact finder sees no contact
REACH = {ADJACENT: 11e-3, SEPARATE: 7e-3}  # m: around the middle, or around each disc
CLOSE = 2.75e-3  # m: half a pitch; a contact this near is the disc's
WINDOW = {ADJACENT: 15e-3, SEPARATE: 25e-3}  # m, to each side of the middle
FIGURE = {ADJACENT: "Figure 4", SEPARATE: "Figure 5"}
RIGHT = 0.15  # of 0.2 mm: a peak within it counts as right
CLAIM = (
    "A deformation of 0.2 mm on three adjacent taxels is reconstructed with its peak around 0.2 mm "
    "on 20 × 20, 30 × 30 and 40 × 40 nodes; the force is smoothed, the more the denser the grid. "
    "On three separate taxels the three peaks are centred around 0.2 mm and stay distinct."
)


@dataclass(frozen=True, eq=False)
class Imposed:
    """What is imposed, and what the taxels read of it without noise.

    Attributes
    ----------
    case : str
    places : (3, 2) array, m
        Of the discs, which are as wide as pads.
    grid : Grid
        Fine cells.
    pressure, indentation : (K,) arrays, Pa and m
    readings : (L,) array, Pa
    """

    case: str
    places: Floats
    grid: Grid
    pressure: Floats
    indentation: Floats
    readings: Floats

    @property
    def force(self) -> float:
        """Total, N."""
        return float(self.pressure.sum() * self.grid.cell_area)

    def on(self, grid: Grid) -> tuple[Floats, Floats]:
        """Mean pressure over the cells (K,) Pa of another grid, and indentation at its nodes.

        The discs must lie inside the other grid.
        """
        from scipy.ndimage import map_coordinates

        pressed = self.pressure != 0
        steps = (np.arange(PARTS) - (PARTS - 1) / 2) / PARTS * self.grid.pitch
        within = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        points = self.grid.plane[pressed][:, None] + within
        nodes = np.round((points - grid.origin) / grid.pitch).astype(int)
        index = nodes[..., 1] * grid.shape[1] + nodes[..., 0]
        part = np.repeat(self.pressure[pressed] * self.grid.cell_area / PARTS**2, PARTS**2)
        forces = np.bincount(index.ravel(), part, len(grid))
        where = ((grid.plane - self.grid.origin) / self.grid.pitch).T[::-1]
        picture = self.indentation.reshape(self.grid.shape)
        return forces / grid.cell_area, map_coordinates(picture, where, order=1)


def discs_of(patch: Patch) -> dict[str, Floats]:
    """Centres (3, 2) m of the taxels that are pressed."""
    plane = patch.plane
    trios = plane[patch.triangles]
    sides = np.linalg.norm(trios - np.roll(trios, 1, axis=1), axis=2)
    trios = trios[(sides < PAIR).all(axis=1)]
    middle = np.linalg.norm(trios.mean(axis=1) - INNER_TRIO, axis=1).argmin()
    bearings = np.radians([90.0, 210.0, 330.0])
    ideal = APART * np.column_stack([np.cos(bearings), np.sin(bearings)])
    chosen = np.linalg.norm(plane[None] - ideal[:, None], axis=2).argmin(axis=1)
    return {ADJACENT: trios[middle], SEPARATE: plane[chosen]}


def truth_of(case: str) -> Imposed:
    """Press flat discs as wide as pads 0.2 mm into the layer, all at once, and read the patch."""
    patch = paper_patch()
    places = discs_of(patch)[case]
    discs = [
        Cylinder(radius=patch.pad_diameter / 2, position=(x, y), depth=DEPTH)
        for x, y in places.tolist()
    ]
    solved = press(LAYER, discs, EXTENT, CELL)
    grid = Grid(patch, solved.grid.shape, solved.grid.pitch, solved.grid.origin)
    inwards = -solved.displacement[:, 2]
    readings = solved.base_stress(patch.plane, patch.pad_diameter)
    return Imposed(case, places, grid, solved.pressure, inwards, readings)


class Rebuilt(NamedTuple):
    """One reconstruction beside its truth."""

    truth: Imposed
    estimate: Estimate
    peaks: Floats  # (3,) m, the highest indentation within half a pitch of each disc
    row: Row  # of the table

    @property
    def claimed(self) -> list[float]:
        """The peaks in m that the paper speaks of: of the whole, or of each separate disc."""
        return [self.peaks.max()] if self.truth.case == ADJACENT else self.peaks.tolist()


def all_findings() -> list[Rebuilt]:
    """Both methods on every grid, for both cases."""
    truths = [truth_of(case) for case in (ADJACENT, SEPARATE)]
    findings = []
    for method in (PAPER, FIELD):
        for nodes in GRIDS:
            reconstruct = method.prepared(nodes, NOISE)
            findings += [judged(t, method, nodes, reconstruct(t.readings)) for t in truths]
    return findings


def judged(truth: Imposed, method: Method, nodes: int, estimate: Estimate) -> Rebuilt:
    """Compare an estimate with its truth: in mm, %, and relative L2 at nodes among the taxels."""
    grid, sunk = estimate.grid, estimate.indentation
    pressure, indentation = truth.on(grid)
    around = truth.places
    if truth.case == ADJACENT:
        around = around.mean(axis=0, keepdims=True)

    def width(field: Floats) -> float:
        each = [half_width(grid, field, place, REACH[truth.case]) for place in around]
        return 1e3 * float(np.mean(each))

    covered = grid.covered
    near = np.linalg.norm(grid.plane - truth.places[:, None], axis=2) < CLOSE
    peaks = np.array([sunk[some].max() for some in near])
    missed = np.linalg.norm((sunk - indentation)[covered]) / np.linalg.norm(indentation[covered])
    centres = np.array([c.position[:2] for c in estimate.contacts]).reshape(-1, 2)
    apart = np.linalg.norm(centres - truth.places[:, None], axis=2)
    row = {
        "imposed on": truth.case,
        "method": method.name,
        "nodes on a side": nodes,
        "peaks (mm)": f"{1e3 * peaks.min():.2f} to {1e3 * peaks.max():.2f}",
        "width of pressure (mm)": width(estimate.pressure),
        "true": width(pressure),
        "width of deformation (mm)": width(sunk),
        "true width": width(indentation),
        "force found (%)": 100 * float(estimate.normal_force) / truth.force,
        "deformation, relative L2 (%)": 100 * float(missed),
        "contacts": len(estimate.contacts),
        "discs with a contact": int((apart < CLOSE).any(axis=1).sum()),
    }
    return Rebuilt(truth, estimate, peaks, row)


def half_width(grid: Grid, values: Floats, place: Floats, reach: float) -> float:
    """Full width at half maximum in m: of the disc as large as the area above half the peak.

    Parameters
    ----------
    place : (2,) array, m
    reach : float, m
        Around it, in which peak and area are looked for, by bilinear interpolation.
    """
    from scipy.ndimage import map_coordinates

    line = np.arange(-reach, reach, 0.1e-3)
    x, y = np.meshgrid(line, line)
    inside = np.hypot(x, y) < reach
    points = place + np.column_stack([x[inside], y[inside]])
    where = ((points - grid.origin) / grid.pitch).T[::-1]
    local = map_coordinates(values.reshape(grid.shape), where, order=1)
    area = np.count_nonzero(local > local.max() / 2) * (line[1] - line[0]) ** 2
    return float(2 * np.sqrt(area / np.pi))


def imposed(settings: Effort) -> Chapter:
    """Peaks, widths and number of contacts."""
    findings = all_findings()

    def of(case: str, method: Method = PAPER) -> list[Rebuilt]:
        wanted = {"imposed on": case, "method": method.name}
        return [each for each in findings if wanted.items() <= each.row.items()]

    wide, apart = of(ADJACENT), of(SEPARATE)
    measured = {case: _peaks(of(case)) for case in (ADJACENT, SEPARATE)}
    caption = (
        "Widths are full widths at half maximum; the true ones are of the truth brought onto the "
        "same nodes."
    )
    return Chapter(
        title="Figures 3 to 5: a deformation imposed on three taxels",
        claim=CLAIM,
        sentences=(
            f"Three flat discs as wide as a pad are pushed {DEPTH * 1e3:g} mm deep; nothing is "
            "added to the readings of the pads, which are their mean stress on the bonded layer.",
            "Peak deformation found by the paper's method on three separate taxels: "
            f"{measured[SEPARATE]}; ours {_peaks(of(SEPARATE, FIELD))}.",
        ),
        pictures=tuple(
            picture_of_fields(findings, case, name)
            for case in (ADJACENT, SEPARATE)
            for name in ("deformation", "pressure")
        ),
        tables=(Table("layer", caption, [each.row for each in findings]),),
        verdicts=_verdicts(wide, apart, measured),
    )


def _verdicts(
    wide: list[Rebuilt], apart: list[Rebuilt], measured: dict[str, str]
) -> tuple[Claim, ...]:
    """What the paper says of taxels side by side, and apart, held against the findings."""
    widths, true = (
        [each.row[name] for each in wide] for name in ("width of pressure (mm)", "true")
    )
    blur = [width / least for width, least in zip(widths, true, strict=True)]
    contacts = [(each.row["contacts"], each.row["discs with a contact"]) for each in apart]
    distinct = [pair == (3, 3) for pair in contacts]
    return (
        Claim(
            "4", "the peak of the deformation is around 0.2 mm", measured[ADJACENT], _holds(wide)
        ),
        Claim(
            "4",
            "the force is smoothed, the more the denser the grid",
            f"width {_tenths(widths)} mm where the same nodes can show {_tenths(true)} mm: "
            f"{_tenths(blur)} times",
            verdict_of(min(blur) > 1 and blur[-1] > blur[0]),
        ),
        Claim("5", "the three peaks are around 0.2 mm", measured[SEPARATE], _holds(apart)),
        Claim(
            "5",
            "three contacts stay distinct",
            f"{listed([str(count) for count, _ in contacts])} contacts found on "
            f"{listed([str(n) for n in GRIDS])} nodes a side",
            verdict_of(all(distinct), any(distinct)),
        ),
    )


def _peaks(findings: list[Rebuilt]) -> str:
    return spread_in_words([peak for each in findings for peak in each.claimed], "mm", 1e3)


def _tenths(values: list[float]) -> str:
    return listed([f"{value:.1f}" for value in values])


def _holds(findings: list[Rebuilt]) -> str:
    """Verdict on the peaks, within the tolerance."""
    right = [
        f"{each.row['nodes on a side']} × {each.row['nodes on a side']}"
        for each in findings
        if all(abs(peak / DEPTH - 1) < RIGHT for peak in each.claimed)
    ]
    if len(right) == len(GRIDS):
        return "holds"
    within = f"(to {100 * RIGHT:.0f} %)"
    return f"holds only on {listed(right)} {within}" if right else f"does not hold {within}"


def picture_of_fields(findings: Sequence[Rebuilt], case: str, name: str) -> Picture:
    """Deformation or pressure of a case: truth and three grids, paper and ours."""
    drawn = {
        (each.row["method"], each.row["nodes on a side"]): each.estimate
        for each in findings
        if each.truth.case == case
    }
    truth = next(each.truth for each in findings if each.truth.case == case)
    circles = [(x, y, truth.grid.patch.pad_diameter / 2) for x, y in truth.places.tolist()]
    middle = truth.places.mean(axis=0)
    window = np.array([middle - WINDOW[case], middle + WINDOW[case]])
    pressed = name == "pressure"
    label, scale = ("pressure (kPa)", 1e-3) if pressed else ("indentation (mm)", 1e3)
    exact = truth.indentation
    if pressed:  # a flat disc's has no bound at its edge: it is clipped there
        highest = 3 * float(np.median(truth.pressure[truth.pressure > 0]))
        exact = np.minimum(truth.pressure, highest)
    rows = []
    for method, who in ((PAPER, "paper"), (FIELD, "ours")):
        panels = [FieldPanel("truth", truth.grid, scale * exact, circles)]
        for nodes in GRIDS:
            estimate = drawn[method.name, nodes]
            values = estimate.pressure if pressed else estimate.indentation
            title = f"{who}, {nodes} × {nodes}"
            panels.append(FieldPanel(title, estimate.grid, scale * values, circles))
        rows.append(panels)
    caption = (
        f"{FIGURE[case]}: {DEPTH * 1e3:g} mm imposed on {case} (black circles), "
        f"{name}: truth, and what is reconstructed on three grids."
    )
    short = "adjacent" if case == ADJACENT else "separate"
    return Picture.of(f"{short}-{name}", caption, draw_fields(rows, label, window=window))
