"""Statistics that say "contact" when they exceed a threshold, and how often they do."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats
from skinfield.pipeline import Reconstructor

CHUNK = 4096  # readings at once: the fields of a chunk stay within 50 MB


@dataclass(frozen=True, eq=False)
class FieldPeak:
    """The highest cell of the reconstructed field: what the paper's figures show.

    Parameters
    ----------
    reconstruct : Reconstructor
    in_deviations : bool
        In standard deviations of each cell's noise, as `ContactFinder` compares it; else in Pa.
    """

    reconstruct: Reconstructor
    in_deviations: bool = False

    @cached_property
    def _weights(self) -> Floats:
        """From linearised readings to what is compared, (L, cells)."""
        nodes = len(self.reconstruct.grid)
        pressure = np.asarray(self.reconstruct.operator[:nodes], dtype=np.float64)
        std = self.reconstruct.plan.noise.std
        felt = std > 0  # a node outside the taxels' hull has no pressure at all
        scale = std[felt] if self.in_deviations else np.ones(int(felt.sum()))
        return np.ascontiguousarray((pressure[felt] / scale[:, None]).T)

    def __call__(self, readings: Floats) -> Floats:
        """Statistic (T,) of readings (T, L)."""
        out = np.empty(len(readings))
        for first in range(0, len(readings), CHUNK):
            part = readings[first : first + CHUNK]
            linear = self.reconstruct.quantity.linearise(part, np.empty_like(part))
            out[first : first + CHUNK] = (linear @ self._weights).max(axis=1)
        return out


def highest_taxel(readings: Floats) -> Floats:
    """No reconstruction at all: the highest reading, (T,)."""
    return np.asarray(readings.max(axis=1))


@dataclass(frozen=True, eq=False)
class KnownShape:
    """Matched filter: the shape of the press is known, its place and load are not.

    Parameters
    ----------
    templates : (P, L) array
        Readings of such a press at many places.
    """

    templates: Floats

    def __call__(self, readings: Floats) -> Floats:
        """Statistic (T,) of readings (T, L)."""
        unit = self.templates / np.linalg.norm(self.templates, axis=1, keepdims=True)
        parts = [
            (readings[first : first + CHUNK] @ unit.T).max(axis=1)
            for first in range(0, len(readings), CHUNK)
        ]
        return np.concatenate(parts)


Statistic = Callable[[Floats], Floats]


def wilson(hits: int, trials: int, sigmas: float = 1.96) -> tuple[float, float]:
    """Interval of a rate from hits in trials (Wilson 1927); 95 % by default."""
    rate, square = hits / trials, sigmas**2 / trials
    middle = (rate + square / 2) / (1 + square)
    half = sigmas / (1 + square) * np.sqrt(rate * (1 - rate) / trials + square / (4 * trials))
    return max(float(middle - half), 0.0), min(float(middle + half), 1.0)


def threshold(quiet: Floats, false_alarms: float) -> float:
    """What the statistic of idle readings (T,) exceeds at the given rate."""
    return float(np.quantile(quiet, 1.0 - false_alarms, method="higher"))


def roc(quiet: Floats, pressed: Floats, rates: Floats) -> Floats:
    """Share of pressed readings (T,) that are found at each rate of false alarms."""
    levels = np.quantile(quiet, 1.0 - rates, method="higher")
    return np.asarray((pressed[:, None] > levels).mean(axis=0))
