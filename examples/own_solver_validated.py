"""A solver of one's own, scored on cases with known truth beside one that is built in."""

from dataclasses import dataclass

import numpy as np

import skinfield as sf
from skinfield.experiments.cases.standard import standard_cases
from skinfield.experiments.scoring.summary import summarise
from skinfield.experiments.scoring.validation import Entrant
from skinfield.inverse import InverseOperator
from skinfield.observation import ObservationModel


@dataclass(frozen=True, kw_only=True)
class EachAlone:
    """Each taxel explained by the least pressure that does it, as if no other taxel read that.

    Parameters
    ----------
    share : float
        Of its reading that a taxel claims: neighbours feel the same press.
    """

    share: float = 0.8

    def prepare(self, model: ObservationModel) -> InverseOperator:
        """Transpose once."""
        matrix = self.share * model.matrix.T / np.sum(model.matrix**2, axis=1)
        return InverseOperator(matrix, np.sqrt(matrix**2 @ model.noise_std**2))


cases = list(standard_cases(sf.layouts.hexagon72(), count=4, quantity="stress"))
for solver in (sf.Tikhonov(), EachAlone()):
    entrant = Entrant(solver=solver, nodes=20)
    summary = summarise([score for case in cases for score in entrant.scores(case)])
    place, force = summary.measures["place_error_m"].median, summary.measures["force_error"].median
    print(
        f"{type(solver).__name__}: {summary.missed.value:.0%} missed, "
        f"force off by {force.value:.0%} [{force.low:.0%}, {force.high:.0%}], "
        f"place off by {place.value * 1e3:.2f} mm"
    )
