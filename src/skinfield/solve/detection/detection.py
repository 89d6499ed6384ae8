r"""Detection of a touch: its posterior, and thresholds by the rate of false alarms.

Thresholds are found by importance sampling. Touches are drawn whose match is about as high as that
of a false alarm. If L(y) is the density of such readings over that of idle ones, then for any
statistic S

.. math:: P_\text{idle}(S > c) = E\left[L(y)^{-1}\, 1(S(y) > c)\right],

and L is a mean over templates, in closed form. False alarms are then common among the draws, each
with the small weight that it has: a rate of 1e-6 needs no more draws than one of 1e-3, and no tail
is extrapolated (Naiman and Priebe 2001, for scan statistics).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.solve.detection.statistics import Lookback, Matches, Statistic, compiled


@dataclass(frozen=True, eq=False, kw_only=True)
class Detection:
    """Whether anything touches, and if so, where; how hard is said by a `Reconstructor`.

    ``statistic, detected = detection`` takes it apart.

    Attributes
    ----------
    statistic : float
        What is compared with `threshold`.
    threshold : float
        Idle readings exceed it at the stated rate of false alarms, or more seldom.
    detected : bool
        Whether they do.
    probability : float
        Of a touch, given the readings and the detector's `touch_rate`.
    position : (3,) array, m
        The most probable of the places that were tried, on the surface, in the patch's frame.
    position_std : float, m
        Root mean square distance of the touch from `position`, if there is one: along the surface,
        over all places and the spacing between them. A quarter of the taxels' distance is in it
        (as a squared deviation) for what no template is like.
    readings : int
        For how many readings the touch has most probably lasted, of the lengths that were tried.
    left_out : int
        Values of single taxels that were NaN.
    """

    statistic: float
    threshold: float
    detected: bool
    probability: float
    position: Floats
    position_std: float
    readings: int
    left_out: int

    def __iter__(self) -> Iterator[float | bool]:
        yield self.statistic
        yield self.detected


DRAWS, LEAST = 4000, 1500  # least: where a patch has so many taxels that draws take long
WORK = 8.5e9  # products of template and reading, for all draws: some seconds
CHUNK = 1_000_000  # scores at once: 8 MB
MEAN, STD = 4.5, 1.2  # of the matches that are drawn: false alarms at rates from 0.1 to 1e-8
IDLE = 0.1  # share of the draws without touch, for rates above
SURE = 2.0  # standard errors that the estimated rate is kept below the stated one


@dataclass(frozen=True, eq=False)
class FalseAlarms:
    """Rates of false alarms by threshold, from a weighted sample.

    Attributes
    ----------
    levels : (N,) array
        Values of the statistic, falling.
    rates : (N,) array
        Share of idle readings whose statistic reaches each level.
    errors : (N,) array
        Standard errors of the rates.
    """

    levels: Floats
    rates: Floats
    errors: Floats

    @classmethod
    def sampled(
        cls, lookback: Lookback, statistic: Statistic, seed: int, draws: int | None = None
    ) -> "FalseAlarms":
        """Draw touches, and weigh them."""
        rng = np.random.default_rng(seed)
        if draws is None:
            each = len(lookback.rate) * len(lookback.bank.noise.std)
            draws = int(np.clip(WORK / each, LEAST, DRAWS))
        levels, weights = np.empty(draws), np.empty(draws)
        chunk = max(1, CHUNK // len(lookback.rate))
        entry, force = _touches(lookback, draws, rng)
        for first in range(0, draws, chunk):
            part = slice(first, first + chunk)
            matches = lookback.matches(_sums(lookback, entry[part], force[part], rng))
            weights[part] = 1.0 / (IDLE + (1.0 - IDLE) * _ratio(matches))
            levels[part] = statistic(matches)
        order = np.argsort(-levels)
        rates = np.cumsum(weights[order]) / draws
        square = np.cumsum(weights[order] ** 2) / draws
        errors = np.sqrt(np.maximum(square - rates**2, 0.0) / draws)
        return cls(levels[order], rates, errors)

    def threshold(self, rate: float) -> float:
        """The lowest level whose rate is, by two standard errors, at most the given one."""
        above = self.rates + SURE * self.errors > rate
        first = int(np.argmax(above)) if above.any() else len(above) - 1
        return float(self.levels[first])


def _touches(
    lookback: Lookback, draws: int, rng: "np.random.Generator"
) -> tuple[NDArray[np.int64], Floats]:
    """Template and length (N,), and force (N,) N: evenly spread; no force for the idle share."""
    seen = np.flatnonzero(lookback.spread > 0)
    even = (np.arange(draws) + rng.random(draws)) / draws
    entry = rng.permutation(seen[(even * len(seen)).astype(np.int64)])
    force = rng.normal(MEAN, STD, draws) * lookback.spread[entry]
    force[rng.permutation(draws) < round(IDLE * draws)] = 0.0
    return entry, force


def _sums(
    lookback: Lookback, entry: NDArray[np.int64], force: Floats, rng: "np.random.Generator"
) -> Floats:
    """Sums (N, W, L) of whitened readings that match, by chance or touch, a template over a length.

    The sums over other lengths follow as far as they are correlated with that one: in white noise
    they are what a touch brings that lasts as long.
    """
    bank, lengths, covariance = lookback.bank, lookback.lengths, lookback.covariance
    length, row = np.divmod(entry, len(bank.scaled))
    touch = force[:, None] * bank.whitened(bank.scaled[row] * bank.noise.std)
    idle = np.stack([bank.idle(len(entry), rng) for _ in lengths], axis=1)
    follow = np.array(lengths) * covariance / np.diag(covariance)  # [v, w]: v, of a touch over w
    out = np.linalg.cholesky(covariance) @ idle + follow.T[length][:, :, None] * touch[:, None]
    return np.asarray(out)


def _ratio(matches: Matches) -> Floats:
    """Density (N,) of readings with the touches that are drawn over that of idle ones."""
    out = np.empty(len(matches.score))
    compiled(_tilt)(matches.score, matches.spread, out)
    return out


def _tilt(score: Floats, spread: Floats, out: Floats) -> None:
    """Mean over templates of E exp(u z - u²/2), where u is normal."""
    wide = 1.0 + STD**2
    for row in range(score.shape[0]):
        total, seen = 0.0, 0
        for j in range(score.shape[1]):
            if spread[j] > 0.0:
                z = score[row, j] * spread[j]
                total += np.exp(((STD * z) ** 2 + MEAN * (2.0 * z - MEAN)) / (2.0 * wide))
                seen += 1
        out[row] = total / (seen * np.sqrt(wide))
