"""Shares of light touches that are found, by method, place and force."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.light_touch.trials import (
    BOUND,
    KINDS,
    LOOKED,
    MATCH,
    OURS,
    QUANTITIES,
    Touch,
    detector,
    idle,
    limit,
    noisy,
    statistics,
)
from skinfield.experiments.scoring.statistics import Statistic, roc, threshold, wilson
from skinfield.experiments.settings import Settings

LIGHT = ((0.2, 1), (0.1, LOOKED), (0.2, LOOKED))  # N and readings, of the ROC curves
FORCES = (0.05, 0.1, 0.2, 0.4, 0.7, 1.0)  # N
FEW = (0.1, 0.2)  # N, in smoke
POINTS = 60  # of a ROC curve


@dataclass(frozen=True)
class Share:
    """Touches found at the settings' rate of false alarms; of the limit there is no count."""

    method: str
    touch: Touch
    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Found:
    """All statistics of one run, each made when it is asked for."""

    settings: Settings

    @cached_property
    def quiet(self) -> dict[str, dict[str, Floats]]:
        """Statistics (T,) of idle readings by quantity and method."""
        return {
            quantity: self._said(idle(self.settings, quantity), quantity) for quantity in QUANTITIES
        }

    @cached_property
    def pressed(self) -> dict[Touch, dict[str, Floats]]:
        """Statistics (P,) of pressed readings by touch and method."""
        return {
            touch: self._said(noisy(touch, self.settings, seed), touch.quantity)
            for seed, touch in self.touches()
        }

    def _said(self, readings: Floats, quantity: str) -> dict[str, Floats]:
        return {name: each(readings) for name, each in self._methods[quantity].items()}

    @cached_property
    def _methods(self) -> dict[str, dict[str, Statistic]]:
        return {quantity: statistics(self.settings, quantity) for quantity in QUANTITIES}

    @property
    def forces(self) -> tuple[float, ...]:
        """That are tried, N."""
        return FEW if self.settings.size.name == "smoke" else FORCES

    def touches(self) -> Iterator[tuple[int, Touch]]:
        """Every quantity, kind of place and force, with a seed of its own."""
        every = [(q, place, force) for q in QUANTITIES for place in KINDS for force in self.forces]
        for seed, (quantity, place, force) in enumerate(every):
            yield seed, Touch(quantity, place, force)

    def level(self, quantity: str, method: str) -> float:
        """Threshold: ours states its own, the others' is measured on idle readings."""
        if method in (OURS, MATCH):
            return detector(self.settings, quantity, method == MATCH).threshold
        return threshold(self.quiet[quantity][method], self.settings.false_alarms)

    @cached_property
    def shares(self) -> tuple[Share, ...]:
        """Of every method and touch, and the limit of each touch."""
        out = []
        for seed, touch in self.touches():
            for name, values in self.pressed[touch].items():
                hits = int((values > self.level(touch.quantity, name)).sum())
                out.append(Share(name, touch, hits / len(values), *wilson(hits, len(values))))
            alarms = np.array([self.settings.false_alarms])
            best = float(limit(touch, self.settings, seed, alarms)[0])
            out.append(Share(BOUND, touch, best, best, best))
        return tuple(out)

    def share(self, method: str, touch: Touch) -> Share:
        """One of `shares`."""
        return next(each for each in self.shares if (each.method, each.touch) == (method, touch))

    @property
    def alarms(self) -> Floats:
        """False alarms at which ROC curves are drawn."""
        return np.geomspace(max(1e-4, 4 / self.settings.size.quiet), 1.0, POINTS)

    def rocs(self, touch: Touch, averaged: int) -> dict[str, Floats]:
        """Share found at `alarms` in so many readings by method, the limit last."""
        seed = next(seed for seed, each in self.touches() if each == touch)
        quiet, pressed = self.quiet[touch.quantity], self.pressed[touch]
        if averaged != LOOKED:
            pressed = self._said(noisy(touch, self.settings, seed, averaged), touch.quantity)
        curves = {name: roc(quiet[name], pressed[name], self.alarms) for name in pressed}
        inside = np.minimum(self.alarms, 1 - 1e-12)
        return curves | {BOUND: limit(touch, self.settings, seed, inside, averaged)}

    def false_alarms(self) -> list[tuple[str, str, float, int, int]]:
        """Quantity, method, stated rate, alarms and idle readings: of thresholds from the draws."""
        out = []
        for quantity in QUANTITIES:
            for method in (OURS, MATCH):
                sampled = detector(self.settings, quantity, method == MATCH).false_alarms
                values = self.quiet[quantity][method]
                for rate in (1e-2, 1e-3, 1e-4):
                    alarms = int((values > sampled.threshold(rate)).sum())
                    out.append((quantity, method, rate, alarms, len(values)))
        return out
