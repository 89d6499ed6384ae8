"""Touches that began one, two, ... readings ago: templates over several lengths of time."""

from collections.abc import Sequence
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

    def weight(self, lengths: Sequence[int]) -> Floats:
        """Of sums of readings (W,): length over the variance of the sum, 1 for white noise."""
        count = np.array(lengths)
        return np.asarray(count / self.bank.noise.growth(count))

    @cached_property
    def worth(self) -> Floats:
        """How many independent readings each length is worth, (W,)."""
        return np.array(self.lengths) * self.weight(self.lengths)

    @cached_property
    def covariance(self) -> Floats:
        """Of the sums over each length (W, W), in variances of one reading; all end together."""
        grown, count = self.bank.noise.growth, np.array(self.lengths)
        apart = np.abs(count[:, None] - count)
        return (grown(count)[:, None] + grown(count) - grown(apart)) / 2.0

    @cached_property
    def rate(self) -> Floats:
        """Of the force's prior by length and template, (W * J,) 1/N."""
        best = float(np.sqrt(self._one.max()))
        by_length = np.sqrt(self.worth) * best / self.strength
        return np.repeat(by_length, len(self._one))

    @cached_property
    def spread(self) -> Floats:
        """1/g by length and template where all taxels answer, (W * J,) N."""
        one = spread_of(self._one)
        return np.concatenate([one / np.sqrt(worth) for worth in self.worth])

    def matches(
        self, sums: Floats, spread: Floats | None = None, used: Sequence[int] | None = None
    ) -> Matches:
        """Of sums (N, W, L) of whitened readings over each length.

        Parameters
        ----------
        sums : (N, W, L) array
        spread : (W * J,) array, N, optional
            1/g where taxels are missing, or readings.
        used : sequence of int, optional
            Readings that each sum has. Default the lengths.
        """
        weight = self.weight(self.lengths if used is None else used)
        score = self.bank.score(sums.reshape(-1, sums.shape[-1])).reshape(*sums.shape[:2], -1)
        if self.bank.noise.correlation > 0:
            score *= weight[:, None]
        spread = self.spread if spread is None else spread
        return Matches(score.reshape(len(sums), -1), spread, self.rate)
