"""Any solver on any cases."""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.experiments.cases.case import Case, quantity_by_name
from skinfield.experiments.scoring.matching import GATE
from skinfield.experiments.scoring.score import Judge, Score
from skinfield.fields import Contact
from skinfield.inverse import Solver
from skinfield.layout import Grid
from skinfield.mechanics import Mechanics
from skinfield.pipeline import Reconstructor

KEPT = 8  # reconstructions that stay prepared: cases of one skin share theirs
PLACE_90, FORCE_90 = 4.605, 2.706  # squared deviations that hold 90 %: of two numbers, and of one


@dataclass(frozen=True)
class Attempt:
    """What a solver made of one reading, and how long that took.

    Attributes
    ----------
    score : Score
    cold, warm : float, s
        For a reading after nothing; and for another one of the same press right after it.
    place_held, force_held : int
        Matched contacts whose stated 90 % region holds the true place, and force.
    """

    score: Score
    cold: float
    warm: float
    place_held: int
    force_held: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Entrant:
    """A solver with what it assumes, ready for any case.

    Parameters
    ----------
    solver : Solver
    mechanics : Mechanics, optional
        Model of the elastomer. Default what the case says that the skin is.
    nodes : int
        On a side of the grid.
    gate : float, m
        Up to which contacts may belong together.
    """

    solver: Solver
    mechanics: Mechanics | None = None
    nodes: int = 40
    gate: float = GATE
    _prepared: dict[tuple[object, ...], Reconstructor] = field(default_factory=dict, init=False)

    def scores(self, case: Case) -> list[Score]:
        """Scores of all readings of a case.

        The entrant is told the layer, the quantity and the noise that the case states.
        """
        reconstruct = self.reconstructor(case)
        judge = Judge(case, reconstruct.grid, self.gate)
        return [judge(estimate) for estimate in reconstruct(case.draws)]

    def attempt(self, case: Case) -> Attempt:
        """Take up the first two readings of a case, one by one; the first is scored.

        Raises
        ------
        InputError
            For a case of fewer readings.
        """
        if len(case.draws) < 2:
            raise InputError(
                f"case {case.name!r} has one reading, expected two: the second is warm"
            )
        reconstruct = self.reconstructor(case)
        reconstruct.reset()
        start = time.perf_counter()
        estimate = reconstruct(case.draws[0])
        between = time.perf_counter()
        reconstruct(case.draws[1])
        end = time.perf_counter()
        score = Judge(case, reconstruct.grid, self.gate)(estimate)
        held = [_held(estimate.contacts[match.found], case, match.true) for match in score.matches]
        return Attempt(
            score, between - start, end - between, sum(p for p, _ in held), sum(f for _, f in held)
        )

    def false_contacts(self, case: Case, draws: int, seed: int) -> list[int]:
        """Contacts found in each of some readings of the case's skin at rest, with its noise."""
        idle = np.random.default_rng(seed).standard_normal((draws, len(case.patch)))
        reconstruct = self.reconstructor(case)
        reconstruct.reset()
        return [len(found) for found in reconstruct(idle * case.noise_std).contacts]

    def reconstructor(self, case: Case) -> Reconstructor:
        """Reconstruction of the case's skin, told its noise; kept for the next such case."""
        mechanics = case.mechanics if self.mechanics is None else self.mechanics
        patch = case.patch
        arrays: tuple[Floats, ...] = (patch.positions, patch.normals, case.noise_std)
        key = (
            *(array.tobytes() for array in arrays),
            patch.pad_diameter,
            case.layer,
            case.quantity,
            mechanics,
        )
        if key not in self._prepared:
            if len(self._prepared) >= KEPT:
                self._prepared.pop(next(iter(self._prepared)))
            self._prepared[key] = Reconstructor(
                patch,
                case.layer,
                Grid.square(patch, nodes=self.nodes),
                mechanics=mechanics,
                quantity=quantity_by_name(case.quantity),
                solver=self.solver,
                noise_std=case.noise_std,
            )
        return self._prepared[key]


def _held(found: Contact, case: Case, true: int) -> tuple[bool, bool]:
    """Whether the regions that hold 90 %, as the contact states them, hold place and force."""
    contact = case.truth.contacts[true]
    place = case.patch.surface.position_from_plane(np.array([contact.position]))[0]
    apart = (found.position - place)[:2]  # of a flat patch
    spread = found.covariance[:2, :2]
    if not np.isfinite(found.covariance).all() or np.linalg.det(spread) <= 0.0:
        return False, False
    square = float(apart @ np.linalg.solve(spread, apart))
    force = (found.normal_force - contact.force) ** 2 / float(found.covariance[2, 2])
    return square <= PLACE_90, force <= FORCE_90


def validated(entrant: Entrant, cases: Iterable[Case]) -> Iterator[tuple[Case, list[Score]]]:
    """Score cases one after another."""
    for case in cases:
        yield case, entrant.scores(case)


def row_of_case(case: Case, scores: list[Score]) -> dict[str, object]:
    """One case as columns: medians over its readings, lengths in mm."""

    def median(values: list[float]) -> float:
        known = [value for value in values if np.isfinite(value)]
        return float(np.median(known)) if known else float("nan")

    return {
        "case": case.name,
        "quantity": case.quantity,
        "readings": len(scores),
        "contacts": len(case.truth.contacts),
        "true_force_N": case.truth.force,
        "force_error": median([score.force_error for score in scores]),
        "field_force_error": median([score.field_force_error for score in scores]),
        "place_error_mm": median([score.place_error * 1e3 for score in scores]),
        "contact_force_error": median([score.contact_force_error for score in scores]),
        "peak_error": median([score.peak_error for score in scores]),
        "pressure_error": median([score.pressure_error for score in scores]),
        "blurred_pressure_error": median([score.blurred_pressure_error for score in scores]),
        "deformation_error": median([score.deformation_error for score in scores]),
        "area_error": median([score.area_error for score in scores]),
        "missed": sum(score.missed for score in scores) / len(scores),
        "false": sum(score.false for score in scores) / len(scores),
    }
