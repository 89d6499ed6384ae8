"""How far an estimate is from the truth of a case."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats, InputError, check_positive
from skinfield.experiments.cases.case import Case
from skinfield.experiments.cases.truth import Truth
from skinfield.experiments.scoring.matching import GATE, Match, matched
from skinfield.experiments.scoring.resampling import Lattice, Spread
from skinfield.fields import Contact, Estimate
from skinfield.layout import Grid

NAN = float("nan")


@dataclass(frozen=True, kw_only=True)
class Score:
    """Errors of one estimate. What cannot be said is NaN, as the place of a missed contact.

    Attributes
    ----------
    case : str
    true_force : float, N
        Of all true contacts.
    contacts_force, field_force : float, N
        Of all contacts that were found, and of the whole pressure field.
    matches : tuple of Match
        True contacts with the found ones that belong to them.
    true_contacts, missed, false : int
        Contacts there are; without a found one within the gate; found without a true one.
    peak_error : float
        Of the highest pressure on the lattice, signed, part of the true.
    pressure_error, blurred_pressure_error : float
        Norm of the difference over the norm of the truth; as it is on the lattice, and after a
        Gaussian of 2 mm standard deviation.
    deformation_error : float
        The same for the displacement into the skin, at the truth's nodes on the grid.
    area_error : float
        Of the area of all contacts, signed, part of the true.
    """

    case: str
    true_force: float
    contacts_force: float
    field_force: float
    matches: tuple[Match, ...]
    true_contacts: int
    missed: int
    false: int
    peak_error: float
    pressure_error: float
    blurred_pressure_error: float
    deformation_error: float
    area_error: float

    @property
    def force_error(self) -> float:
        """Of the force of all contacts, signed, part of the true; -1 where all are missed."""
        return _relative(self.contacts_force, self.true_force)

    @property
    def field_force_error(self) -> float:
        """Of the force of the whole field, signed, part of the true."""
        return _relative(self.field_force, self.true_force)

    @property
    def place_error(self) -> float:
        """Mean distance of matched contacts, m; NaN where none is matched."""
        return _mean([match.distance for match in self.matches])

    @property
    def contact_force_error(self) -> float:
        """Mean of the absolute relative errors of matched contacts; NaN where none is matched."""
        return _mean([abs(match.force_error) for match in self.matches])


@dataclass(frozen=True, eq=False)
class Judge:
    """The truth of a case, prepared for estimates on one grid: many solvers, many readings.

    Parameters
    ----------
    case : Case
    grid : Grid
        Of the estimates, on the case's patch or an equal one.
    gate : float, m
        A found contact farther than this from a true one does not belong to it.
    """

    case: Case
    grid: Grid
    gate: float = GATE

    def __post_init__(self) -> None:
        check_positive("gate", self.gate, "distance up to which contacts may belong together, m")
        taxels = len(self.grid.patch)
        if taxels != len(self.case.patch):
            raise InputError(
                f"the grid lies on a patch of {taxels} taxels, expected one of "
                f"{len(self.case.patch)}, as the case {self.case.name!r} has"
            )

    @cached_property
    def spread(self) -> Spread:
        """From the grid to a lattice over grid and truth."""
        truth, half = self.case.truth, self.grid.pitch / 2
        low, high = self.grid.plane.min(axis=0) - half, self.grid.plane.max(axis=0) + half
        loaded = truth.plane[truth.pressure != 0]
        if len(loaded):
            low = np.minimum(low, loaded.min(axis=0) - truth.cell / 2)
            high = np.maximum(high, loaded.max(axis=0) + truth.cell / 2)
        return Spread.of(self.grid, Lattice.around(low, high))

    @cached_property
    def pressure(self) -> tuple[Floats, Floats]:
        """True pressure on the lattice, Pa: as it is, and blurred."""
        truth, lattice = self.case.truth, self.spread.lattice
        loaded = truth.pressure != 0
        raw = lattice.deposit(truth.plane[loaded], truth.pressure[loaded], truth.cell)
        return raw, lattice.blurred(raw)

    @cached_property
    def indentation(self) -> tuple[Floats, Floats, Floats]:
        """Nodes (N, 4) of the grid around each of N true nodes, their weights, the true value m."""
        return around_truth(self.case.truth, self.grid)

    def __call__(self, estimate: Estimate, contacts: Sequence[Contact] | None = None) -> Score:
        """Score one estimate; `contacts` stand in for those of the estimate."""
        if estimate.is_batch:
            raise InputError("the estimate is of several readings, expected one: index it")
        found = estimate.contacts if contacts is None else contacts
        truth = self.case.truth
        matches, missed, false = matched(self.case.patch, truth.contacts, found, self.gate)
        sharp = self.spread(estimate.pressure)
        exact, exact_blurred = self.pressure
        known = len(truth.plane) > 0
        return Score(
            case=self.case.name,
            true_force=truth.force,
            contacts_force=float(sum(contact.normal_force for contact in found)),
            field_force=float(estimate.normal_force),
            matches=matches,
            true_contacts=len(truth.contacts),
            missed=missed,
            false=false,
            peak_error=_relative(float(sharp.max()), float(exact.max())) if known else NAN,
            pressure_error=_distance(sharp, exact),
            blurred_pressure_error=_distance(self.spread(estimate.pressure, True), exact_blurred),
            deformation_error=self._deformation_error(estimate.indentation),
            area_error=_relative(float(sum(c.area for c in found)), truth.contact_area),
        )

    def _deformation_error(self, indentation: Floats) -> float:
        nodes, weights, exact = self.indentation
        return _distance(np.einsum("nk,nk->n", indentation[nodes.astype(np.int64)], weights), exact)


def score(
    case: Case,
    estimate: Estimate,
    contacts: Sequence[Contact] | None = None,
    gate: float = GATE,
) -> Score:
    """Score one estimate against the truth of its case.

    Truth and estimate are brought onto one lattice of 0.5 mm: each cell's force is shared among
    the four nearest points in bilinear proportion, which keeps the force and its place. The
    indentation is compared at the truth's nodes, where the estimate's is interpolated.

    Parameters
    ----------
    case : Case
    estimate : Estimate
        Of one reading.
    contacts : sequence of Contact, optional
        Default those of the estimate.
    gate : float, m
        True and found contacts belong together by the assignment of the smallest sum of distances,
        each below this.

    See Also
    --------
    Judge : the same for many estimates on one grid.
    """
    return Judge(case, estimate.grid, gate)(estimate, contacts)


def around_truth(truth: Truth, grid: Grid) -> tuple[Floats, Floats, Floats]:
    """Where the true indentation is known on the grid: nodes (N, 4), weights (N, 4), values m."""
    place = (truth.plane - grid.origin) / grid.pitch
    rows, columns = grid.shape
    last = np.array([columns - 1, rows - 1])
    known = np.isfinite(truth.displacement[:, 2])
    known &= ((place >= 0) & (place <= last)).all(axis=1)
    place = place[known]
    corner = np.minimum(np.floor(place), np.maximum(last - 1, 0)).astype(np.int64)
    x, y = (place - corner).T
    right, up = (min(1, columns - 1), columns * min(1, rows - 1))
    first = corner[:, 1] * columns + corner[:, 0]
    nodes = np.stack([first, first + right, first + up, first + right + up], axis=1)
    weights = np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=1)
    return nodes, weights, -truth.displacement[known, 2]


def _relative(found: float, true: float) -> float:
    return found / true - 1 if true > 0 else NAN


def _distance(found: Floats, true: Floats) -> float:
    norm = float(np.linalg.norm(true))
    return float(np.linalg.norm(found - true)) / norm if norm > 0 else NAN


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else NAN
