"""What each kind of step takes: measured at start-up, corrected by every step that is taken."""

from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import Floats, check_range

FORGET = 0.99  # of a prediction above its start, per cycle
LEAST = 1e-7  # s: the clock's own step


@dataclass(eq=False)
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

    Notes
    -----
    After a step that took x where q was predicted

    .. math:: \log q \leftarrow \log q + \eta \, (\alpha - [x \le q])

    with the quantile :math:`\alpha` and the pace :math:`\eta`: stochastic approximation of a
    quantile (Robbins and Monro 1951), on the logarithm, so that it needs no scale. At rest a
    part :math:`\alpha` of the steps takes less. One step that the system interrupted, however long,
    moves it no more than any other. What was predicted too high to be done at all would stay so for
    ever: `relax` lets it come back to where it started, in some hundred cycles.
    """

    steps: Floats
    quantile: float = 0.9
    pace: float = 0.1
    base: Floats = field(init=False)
    _up: float = field(init=False, default=1.0)
    _down: float = field(init=False, default=1.0)

    def __post_init__(self) -> None:
        check_range("quantile", self.quantile, 0.5, 0.999, "steps that take less than predicted")
        check_range("pace", self.pace, 1e-4, 1.0, "of the correction in one step")
        self.base = self.steps.copy()
        self._up = float(np.exp(self.pace * self.quantile))
        self._down = float(np.exp(-self.pace * (1.0 - self.quantile)))

    @property
    def moves(self) -> tuple[float, float, float]:
        """Factors of a prediction that was too low or too high, and the least one, s."""
        return self._up, self._down, LEAST

    def predict(self, step: int) -> float:
        """Time that a step of this kind will hardly exceed, s."""
        return float(self.steps[step])

    def observe(self, step: int, seconds: float) -> None:
        """Correct by a step that was taken to its end."""
        steps = self.steps
        slower = seconds > steps[step]
        steps[step] = max(steps[step] * (self._up if slower else self._down), LEAST)

    def at_least(self, step: int, seconds: float) -> None:
        """Correct by a step that was cut off after `seconds`: it would have taken longer."""
        if seconds >= self.steps[step]:
            self.observe(step, np.inf)

    def relax(self) -> None:
        """Let predictions that are above their start come down a little, once a cycle."""
        steps = self.steps
        np.minimum(steps, np.maximum(FORGET * steps, self.base), out=steps)

    def start(self, step: int, laps: Floats) -> None:
        """Start from measured laps, s: their quantile, at most twice the median."""
        high = float(np.quantile(laps, self.quantile))
        self.steps[step] = max(min(high, 2.0 * float(np.median(laps))), LEAST)
        self.base[step] = self.steps[step]
