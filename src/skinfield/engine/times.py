"""What steps take, as far as it is known."""

import numpy as np

from skinfield.engine.cost import CostModel
from skinfield.engine.state import PRODUCT, TEST, Step
from skinfield.errors import Floats

GUESS = 20e-6  # s: of every step, until it is measured
NS = 1e-9
TYPICAL = 0.6  # quantile of a step's time that is about its mean, as few are much slower
AFTER = 2e-6  # s: what is done about a search after it, until it is measured
KINDS = len(Step)


class Times:
    """Predictions of each kind of step, for each kind of patch, on each rung.

    Parameters
    ----------
    groups, rungs : int
        How many.
    together : bool
        Whether linear answers of all patches are one step, as idle tests are.

    Attributes
    ----------
    both : (2, G, kinds, R) array, s
        `costs` and what is typical.
    costs : (G, kinds of steps, R) array, s
        Of a step for all patches in the first row, the others 0.
    model, typical : CostModel
        That they are predicted by.
    moves : (2, 3) array
        Of both.
    after : CostModel
        Of what is done about a search after it.
    relaxing : pair of arrays
        Predictions and where they started.
    """

    def __init__(self, groups: int, rungs: int, together: bool) -> None:
        self.both = np.full((2, groups, KINDS, rungs), GUESS)
        bases = self.both.reshape(2, -1).copy()
        self.costs, typical = self.both
        self.rungs = rungs
        self.model = CostModel(self.costs.reshape(-1))
        self.typical = CostModel(typical.reshape(-1), quantile=TYPICAL)
        self.model.base, self.typical.base = bases
        self.relaxing = self.both.reshape(-1), bases.reshape(-1)
        self.moves = np.array([self.model.moves, self.typical.moves])
        self.after = CostModel(np.array([AFTER]))
        self.costs[1:, TEST] = 0.0
        if together:
            self.costs[1:, PRODUCT] = 0.0

    def which(self, step: int, group: int, rung: int) -> int:
        """Place of a step in the cost model."""
        return (group * KINDS + step) * self.rungs + rung

    def start(self, which: int, laps: Floats) -> None:
        """Start predictions of a step from measured laps, s."""
        self.model.start(which, laps)
        self.typical.start(which, laps)

    def observe(self, which: int, seconds: float) -> None:
        """Learn from a step."""
        self.model.observe(which, seconds)
        self.typical.observe(which, seconds)

    def start_as(self, other: "Times") -> None:
        """Begin with the predictions of another."""
        for mine, its in zip(self.relaxing, other.relaxing, strict=True):
            mine[:] = its
