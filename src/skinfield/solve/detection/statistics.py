"""Detection statistics: a number per reading from the matches of templates over some time."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import erfc
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.solve.detection.dictionary import DetectorTemplates, spread_of

LOW, HIGH, STEPS = -16.0, 2.0, 256  # range of the table, and its entries per unit
TOP = 25.0  # matches up to here are summed as they are; above, all are scaled down


@dataclass(frozen=True, eq=False)
class Matches:
    r"""How well J templates match, and what is expected of each.

    With a template t (reading per newton), noise of covariance :math:`\Sigma` and a reading y, the
    logarithm of the likelihood of a force F over that of none is
    :math:`F d - F^2 g^2/2` with :math:`d = t^T \Sigma^{-1} y` and :math:`g^2 = t^T \Sigma^{-1} t`.

    Attributes
    ----------
    score : (N, J) array, 1/N
        d of N readings.
    spread : (J,) array, N
        1/g: standard deviation of the force by this template alone. 0 for one that is not seen.
    rate : (J,) array, 1/N
        Of the exponential prior of the force: its mean is 1/rate.
    """

    score: Floats
    spread: Floats
    rate: Floats


class Statistic(Protocol):
    """What is compared with a threshold; the larger, the rather a touch."""

    def __call__(self, matches: Matches) -> Floats:
        """Statistic (N,) of N readings."""
        ...


@dataclass(frozen=True)
class MarginalLikelihood:
    r"""Logarithm of the marginal likelihood ratio of a touch over none (a Bayes factor).

    The mean over places, sizes and lengths, all equally probable before, of the likelihood ratio
    integrated over the force with its exponential prior of rate :math:`\lambda`:

    .. math:: B = \frac1J \sum_j \lambda_j s_j\, R(d_j s_j - \lambda_j s_j), \qquad
              R(z) = \sqrt{2\pi}\, e^{z^2/2}\, \Phi(z), \quad s_j = 1/g_j.

    By the lemma of Neyman and Pearson no test finds more of the touches of the prior.
    """

    def __call__(self, matches: Matches) -> Floats:
        """See `Statistic`."""
        return log_evidence(matches)[0]


@dataclass(frozen=True)
class LargestMatch:
    r"""The best match of all, :math:`\max_j d_j/g_j`: the generalised likelihood ratio's root.

    In standard deviations of the noise. It needs no prior of the force, and finds touches in ill
    seen places better than `MarginalLikelihood` at the cost of those in well seen ones.
    """

    def __call__(self, matches: Matches) -> Floats:
        """See `Statistic`."""
        return np.asarray((matches.score * matches.spread).max(axis=1))


def log_evidence(matches: Matches) -> tuple[Floats, Floats]:
    """Logarithm (N,) of the mean likelihood ratio, and what its last row is made of.

    Returns
    -------
    evidence : (N,) array
    share : (J,) array
        Of each template in the last row's evidence; the shares add up to 1.
    """
    rows, entries = matches.score.shape
    evidence, share = np.empty(rows), np.empty(entries)
    compiled(_marginal)(matches.score, matches.spread, matches.rate, _table(), evidence, share)
    return evidence, share


@cache
def _table() -> Floats:
    """R(z) from LOW to HIGH; linear between the entries it is good to 2e-5."""
    from scipy.special import erfcx

    z = np.linspace(LOW, HIGH, int((HIGH - LOW) * STEPS) + 1)
    return np.asarray(np.sqrt(np.pi / 2) * erfcx(-z / np.sqrt(2)))


def _marginal(
    score: Floats,
    spread: Floats,
    rate: Floats,
    table: Floats,
    evidence: Floats,
    share: Floats,
) -> None:
    """Fill `evidence` row by row, `share` with what the last row had."""
    entries = score.shape[1]
    for row in range(score.shape[0]):
        top = 0.0
        for j in range(entries):
            top = max(top, (score[row, j] - rate[j]) * spread[j])
        shift = 0.5 * (top**2 - TOP**2) if top > TOP else 0.0
        down = np.exp(-shift)
        total = 0.0
        for j in range(entries):
            z = (score[row, j] - rate[j]) * spread[j]
            if z > HIGH:
                below = 1.0 - 0.5 * erfc(z * 0.7071067811865476)
                ratio = 2.5066282746310002 * np.exp(0.5 * z * z - shift) * below
            else:
                if z > LOW:
                    place = (z - LOW) * STEPS
                    first = min(int(place), len(table) - 2)
                    mills = table[first] + (place - first) * (table[first + 1] - table[first])
                else:
                    square = 1.0 / (z * z)
                    mills = (1.0 - square * (1.0 - 3.0 * square)) / -z
                ratio = mills * down
            share[j] = ratio * rate[j] * spread[j] if spread[j] > 0.0 else down
            total += share[j]
        evidence[row] = np.log(total / entries) + shift
    share /= total


@cache
def compiled(function: Callable[..., None]) -> Any:
    """A function as machine code, made when it is first called: it runs over every template."""
    from skinfield.compiled import njit

    return njit(function)


@dataclass(frozen=True, eq=False)
class Lookback:
    """A bank for sums of the last readings, over some lengths.

    The prior's mean force falls with the root of the length, as the lightest touch does that so
    many readings can show: so a detector's threshold does not depend on how many there are.

    Attributes
    ----------
    bank : DetectorTemplates
    lengths : tuple of int
        Numbers of readings, rising.
    strength : float
        Mean force of the prior, in standard deviations of the force of the touch that is seen best.
    """

    bank: DetectorTemplates
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

    def spread_where(self, valid: NDArray[np.bool_], used: Sequence[int]) -> Floats | None:
        """1/g by length and template, of readings (T, L), newest first, that lack values.

        `used` (W,) readings count for each length; None where all are there.
        """
        if used[-1] == self.lengths[-1] and valid.all():
            return None
        parts, total, first = [], np.zeros(len(self.bank.scaled)), 0
        for length, weight in zip(used, self.weight(used), strict=True):
            for mask, count in Counter(row.tobytes() for row in valid[first:length]).items():
                total = total + count * self.bank.information(np.frombuffer(mask, dtype=bool))
            first = length
            parts.append(spread_of(total * weight))
        return np.concatenate(parts)

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
        score = (sums.reshape(-1, sums.shape[-1]) @ self.bank.scaled.T).reshape(*sums.shape[:2], -1)
        if self.bank.noise.correlation > 0:
            score *= weight[:, None]
        spread = self.spread if spread is None else spread
        return Matches(score.reshape(len(sums), -1), spread, self.rate)
