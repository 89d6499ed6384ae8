"""Timing model of a cycle's steps: measured at start-up, corrected by every step that is taken."""

import numpy as np

from skinfield.errors import Floats
from skinfield.reconstruct.engine.state import PRODUCT, TEST, Step

FORGET = 0.99  # of a prediction above its start, per cycle
LEAST = 1e-7  # s: the clock's own step


class CostModel:
    r"""A high quantile of the time of each kind of step, followed online.

    Parameters
    ----------
    steps : (N,) array, s
        Times to start from, one for each kind of step; changed in place.
    quantile : float
        Part of the steps that should take less than what is predicted.
    pace : float
        How fast predictions follow.

    Attributes
    ----------
    base : (N,) array, s
        To which predictions come back.
    moves : (3,) tuple
        Factors of a prediction that was too low or too high, and the least one, s.

    Notes
    -----
    After a step that took x where q was predicted

    .. math:: \log q \leftarrow \log q + \eta \, (\alpha - [x \le q])

    with the quantile :math:`\alpha` and the pace :math:`\eta`: stochastic approximation of a
    quantile (Robbins and Monro 1951), on the logarithm, so that it needs no scale. At rest a
    part :math:`\alpha` of the steps takes less. One step that the system interrupted, however long,
    moves it no more than any other. What was predicted too high to be done at all would stay so for
    ever: `close_cycle` of `cycle_kernel` lets it come back to where it started, in some hundred
    cycles.
    """

    def __init__(self, steps: Floats, quantile: float = 0.9, pace: float = 0.1) -> None:
        self.steps, self.base, self.quantile = steps, steps.copy(), quantile
        up, down = np.exp(pace * quantile), np.exp(-pace * (1.0 - quantile))
        self.moves = float(up), float(down), LEAST

    def predict(self, step: int) -> float:
        """Time that a step of this kind will hardly exceed, s."""
        return float(self.steps[step])

    def observe(self, step: int, seconds: float) -> None:
        """Correct by a step that was taken to its end."""
        steps, (up, down, least) = self.steps, self.moves
        steps[step] = max(steps[step] * (up if seconds > steps[step] else down), least)

    def start(self, step: int, laps: Floats) -> None:
        """Start from measured laps, s: their quantile, at most twice the median."""
        high = float(np.quantile(laps, self.quantile))
        self.steps[step] = max(min(high, 2.0 * float(np.median(laps))), LEAST)
        self.base[step] = self.steps[step]


GUESS = 20e-6  # s: of every step, until it is measured
NS = 1e-9
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
    costs : (G, kinds of steps, R) array, s
        Of a step for all patches in the first row, the others 0.
    model : CostModel
        That they are predicted by.
    """

    def __init__(self, groups: int, rungs: int, together: bool) -> None:
        self.costs, self.rungs = np.full((groups, KINDS, rungs), GUESS), rungs
        self.model = CostModel(self.costs.reshape(-1))
        self.costs[1:, TEST] = 0.0
        if together:
            self.costs[1:, PRODUCT] = 0.0

    def which(self, step: int, group: int, rung: int) -> int:
        """Place of a step in the cost model."""
        return (group * KINDS + step) * self.rungs + rung
