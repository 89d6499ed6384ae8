"""Touches that began one, two, ... readings ago: templates over several lengths of time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.detection.bank import Bank, spread_of
from skinfield.detection.statistics import Matches
from skinfield.errors import Floats


@dataclass(frozen=True, eq=False)
class Lookback:
    """A bank for sums of the last readings, over some lengths.

    The prior's mean force falls with the root of the length, as the lightest touch does that so
    many readings can show: so a detector's threshold does not depend on how many there are.

    Attributes
    ----------
    bank : Bank
    lengths : tuple of int
        Numbers of readings, rising.
    strength : float
        Mean force of the prior, in standard deviations of the force of the touch that is seen best.
    """

    bank: Bank
    lengths: tuple[int, ...]
    strength: float

    @cached_property
    def _one(self) -> Floats:
        """g² (J,) of one reading of all taxels."""
        return self.bank.information(np.ones(len(self.bank.noise.std), dtype=np.bool_))

    @cached_property
    def rate(self) -> Floats:
        """Of the force's prior by length and template, (W * J,) 1/N."""
        best = float(np.sqrt(self._one.max()))
        by_length = np.sqrt(self.lengths) * best / self.strength
        return np.repeat(by_length, len(self._one))

    @cached_property
    def spread(self) -> Floats:
        """1/g by length and template where all taxels answer, (W * J,) N."""
        one = spread_of(self._one)
        return np.concatenate([one / np.sqrt(length) for length in self.lengths])

    def matches(self, sums: Floats, spread: Floats | None = None) -> Matches:
        """Of sums (N, W, L) of whitened readings over each length."""
        score = self.bank.score(sums.reshape(-1, sums.shape[-1])).reshape(len(sums), -1)
        return Matches(score, self.spread if spread is None else spread, self.rate)
