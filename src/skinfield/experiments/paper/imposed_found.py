"""What each method makes of readings of an imposed deformation, beside the truth."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.paper.imposed_truth import (
    ADJACENT,
    HALF_SPACE,
    LAYER,
    OWN_GRID,
    SEPARATE,
    Truth,
    truth_of,
    truth_on_own_grid,
)
from skinfield.experiments.paper.methods import (
    FIELD,
    FIELD_HALF_SPACE,
    PAPER,
    PAPER_EXACT,
    PAPER_GENERAL,
    PAPER_ON_LAYER,
    Method,
)
from skinfield.experiments.paper.presses import paper_patch
from skinfield.experiments.settings import Settings
from skinfield.fields import Estimate
from skinfield.layout import Grid

GRIDS = (20, 30, 40)
NOISE = 10.0  # Pa: nothing is added; below it the contact finder sees no contact
METHODS = {
    LAYER: (PAPER, PAPER_EXACT, PAPER_GENERAL, PAPER_ON_LAYER, FIELD_HALF_SPACE, FIELD),
    HALF_SPACE: (PAPER, PAPER_EXACT, FIELD_HALF_SPACE),
    OWN_GRID: (PAPER,),
}
REACH = {ADJACENT: 11e-3, SEPARATE: 7e-3}  # m: around the middle, or around each disc
CLOSE = 2.75e-3  # m: half a pitch; a contact this near is the disc's


@dataclass(frozen=True, eq=False)
class Found:
    """One reconstruction beside its truth.

    Attributes
    ----------
    peaks : (3,) array, m
        Highest indentation within half a pitch of each disc.
    widths, true_widths : (2,) array, m
        Full width at half maximum of pressure and of indentation, on this grid.
    force : float
        Sum of the pressure over the true force.
    deformation_error : float
        Relative L2, at the nodes among the taxels.
    contacts, matched : int
        Found, and how many discs have one of their own.
    """

    truth: Truth
    method: Method
    nodes: int
    estimate: Estimate
    peaks: Floats
    widths: Floats
    true_widths: Floats
    force: float
    deformation_error: float
    contacts: int
    matched: int

    @property
    def separated(self) -> bool:
        """Whether there are three contacts, one on each disc."""
        return self.contacts == self.matched == 3


def all_found(settings: Settings) -> list[Found]:
    """Every method on every grid, for both cases and all ways of making the readings."""
    patch, layer = paper_patch(), settings.layer
    truths = [
        truth_of(world, case, settings)
        for world in (LAYER, HALF_SPACE)
        for case in (ADJACENT, SEPARATE)
    ]
    found = []
    for method in METHODS[LAYER]:
        for nodes in GRIDS:
            if settings.size.name == "smoke" and method is PAPER_GENERAL and nodes > 20:
                continue  # singular values of thousand rows take seconds
            reconstruct = method.prepared(patch, layer, nodes, NOISE)
            mine = [truth for truth in truths if method in METHODS[truth.world]]
            if method in METHODS[OWN_GRID]:
                cases = (ADJACENT, SEPARATE)
                mine += [truth_on_own_grid(reconstruct, case, layer) for case in cases]
            found += [judged(t, method, nodes, reconstruct(t.readings)) for t in mine]
    return found


def judged(truth: Truth, method: Method, nodes: int, estimate: Estimate) -> Found:
    """Compare an estimate with its truth."""
    grid = estimate.grid
    pressure, indentation = truth.on(grid)
    middle = truth.places.mean(axis=0, keepdims=True)
    around = middle if truth.case == ADJACENT else truth.places
    reach = REACH[truth.case]

    def widths(*fields: Floats) -> Floats:
        each = [[half_width(grid, field, place, reach) for place in around] for field in fields]
        return np.asarray(np.mean(each, axis=1))

    covered = grid.covered
    away = np.linalg.norm(grid.plane[:, None] - truth.places[None], axis=2)
    sunk = estimate.indentation
    missed = np.linalg.norm((sunk - indentation)[covered]) / np.linalg.norm(indentation[covered])
    centres = np.array([c.position[:2] for c in estimate.contacts]).reshape(-1, 2)
    apart = np.linalg.norm(centres[:, None] - truth.places[None], axis=2)
    return Found(
        truth,
        method,
        nodes,
        estimate,
        np.array([sunk[near].max() for near in (away < CLOSE).T]),
        widths(estimate.pressure, sunk),
        widths(pressure, indentation),
        float(estimate.normal_force) / truth.force,
        float(missed),
        len(estimate.contacts),
        int((apart < CLOSE).any(axis=0).sum()) if len(centres) else 0,
    )


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
