"""Any solver on any cases."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.cases.case import Case, quantity_by_name
from skinfield.experiments.scoring.matching import GATE
from skinfield.experiments.scoring.score import Judge, Score
from skinfield.inverse import Solver
from skinfield.layout import Grid
from skinfield.mechanics import Mechanics
from skinfield.pipeline import Reconstructor

KEPT = 8  # reconstructions that stay prepared: cases of one skin share theirs


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
        reconstruct = self._reconstructor(case)
        judge = Judge(case, reconstruct.grid, self.gate)
        return [judge(estimate) for estimate in reconstruct(case.draws)]

    def _reconstructor(self, case: Case) -> Reconstructor:
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
