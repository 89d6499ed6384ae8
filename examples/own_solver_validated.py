"""A solver of one's own, scored on cases with known truth beside one that is built in."""

from dataclasses import dataclass

import numpy as np

import skinfield as sf
from skinfield.elastic import ObservationModel
from skinfield.lab.case_sets import standard_cases
from skinfield.lab.score import summarise
from skinfield.lab.validation import Entrant
from skinfield.solve import LinearOperator


@dataclass(frozen=True, kw_only=True)
class EachAlone:
    """Each taxel explained by the least pressure that does it, as if no other taxel read that.

    Parameters
    ----------
    share : float
        Of its reading that a taxel claims: neighbours feel the same press.
    """

    share: float = 0.8

    def prepare(self, model: ObservationModel) -> LinearOperator:
        """Transpose once."""
        matrix = self.share * model.matrix.T / np.sum(model.matrix**2, axis=1)
        return LinearOperator(self, model, matrix, np.sqrt(matrix**2 @ model.noise_std**2))


cases = list(standard_cases(sf.layouts.hexagon72(), count=4, quantity="stress"))
for solver in (sf.Tikhonov(), EachAlone()):
    entrant = Entrant(solver=solver, nodes=20)
    found = summarise([row for case in cases for row in entrant.rows(case)])
    force, low, high = (found[f"force_error_{end}"] for end in ("median", "low", "high"))
    print(
        f"{type(solver).__name__}: {found['missed']:.0%} missed, "
        f"force off by {force:.0%} [{low:.0%}, {high:.0%}], "
        f"place off by {found['place_error_mm_median']:.2f} mm"
    )
