"""How often presses of the paper's indenters are told from noise, by detector, place and load."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.paper.methods import (
    FIELD,
    FIELD_CHANGE,
    FIELD_HALF_SPACE,
    PAPER,
    PAPER_GENERAL,
    PAPER_ON_LAYER,
    Method,
)
from skinfield.experiments.paper.presses import (
    BALL,
    LOADS,
    PLACES,
    TIPS,
    Tip,
    paper_patch,
    readings,
    sites,
)
from skinfield.experiments.scoring.statistics import (
    FieldPeak,
    KnownShape,
    Statistic,
    highest_taxel,
    threshold,
    wilson,
)
from skinfield.experiments.settings import Settings
from skinfield.layout import Grid
from skinfield.layout.hull import inside_hull

TEMPLATE_PITCH = 1e-3  # m: between the places that the matched filter tries
RAW, KNOWN = "highest taxel", "matched filter (shape known)"


@dataclass(frozen=True, eq=False)
class Detector:
    """A statistic of readings, on a grid of `nodes` x `nodes` (0: on none)."""

    name: str
    nodes: int
    quantity: str
    statistic: Statistic

    @property
    def label(self) -> str:
        """Name with its grid."""
        return f"{self.name}, {self.nodes} × {self.nodes}" if self.nodes else self.name


@dataclass(frozen=True)
class Trial:
    """An indenter, a kind of place, a load in N, and what taxels read."""

    tip: Tip
    place: str
    force: float
    quantity: str

    def clean(self, settings: Settings, count: int, seed: int) -> Floats | None:
        """Readings (count, L) without noise, at random places of the kind; None if it sinks."""
        patch, size = paper_patch(), settings.size
        places = sites(patch)[self.place]
        rng = np.random.default_rng([settings.seed, seed])
        chosen = places[rng.integers(len(places), size=count)]
        return readings(
            self.tip, patch, settings.layer, self.force, size.cell, chosen, self.quantity
        )


@dataclass(frozen=True)
class Rate:
    """Presses found at the rate of false alarms of the settings."""

    detector: str
    nodes: int
    trial: Trial
    hits: int
    presses: int

    @property
    def share(self) -> float:
        """Of the presses that were found."""
        return self.hits / self.presses

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the share."""
        return wilson(self.hits, self.presses)


def noise_of(settings: Settings, quantity: str) -> float:
    """Standard deviation of one reading, in the quantity's unit."""
    return settings.change_noise if quantity == "capacitance" else settings.stress_noise


def known_shape(settings: Settings, quantity: str) -> KnownShape:
    """Matched filter for the 1.2 cm half-sphere at 0.5 N, everywhere inside the taxels' hull."""
    patch = paper_patch()
    low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
    places = Grid.window(patch, low, high, TEMPLATE_PITCH).plane
    places = places[inside_hull(patch.plane, places)]
    cell = settings.size.cell
    templates = readings(BALL, patch, settings.layer, 0.5, cell, places, quantity)
    if templates is None:
        raise AssertionError("0.5 N on the half-sphere does not sink")
    return KnownShape(templates)


def detectors(settings: Settings) -> list[Detector]:
    """All that are compared: the paper's on every grid, ours on the same, and two without."""
    grids = settings.size.grids
    wanted: list[tuple[Method, tuple[int, ...], bool]] = [
        (PAPER, grids, False),
        (PAPER_GENERAL, grids[1:2], False),
        (PAPER_ON_LAYER, grids[1:2], False),
        (FIELD_HALF_SPACE, grids[-1:], True),
        (FIELD, grids, True),
        (FIELD_CHANGE, grids[-1:], True),
    ]
    found = [
        _field_detector(method, nodes, settings, in_deviations)
        for method, several, in_deviations in wanted
        for nodes in several
    ]
    for quantity in ("stress", "capacitance"):
        extra = ", capacitance" if quantity == "capacitance" else ""
        found.append(Detector(RAW + extra, 0, quantity, highest_taxel))
        found.append(Detector(KNOWN + extra, 0, quantity, known_shape(settings, quantity)))
    return found


def _field_detector(
    method: Method, nodes: int, settings: Settings, in_deviations: bool
) -> Detector:
    quantity = "capacitance" if method is FIELD_CHANGE else "stress"
    noise = noise_of(settings, quantity)
    reconstruct = method.prepared(paper_patch(), settings.layer, nodes, noise)
    return Detector(method.name, nodes, quantity, FieldPeak(reconstruct, in_deviations))


def quiet_readings(settings: Settings, quantity: str) -> Floats:
    """Readings (T, L) of an idle patch."""
    rng = np.random.default_rng([settings.seed, 1])
    shape = (settings.size.quiet, len(paper_patch()))
    return rng.normal(scale=noise_of(settings, quantity), size=shape)


def quiet_statistics(found: Sequence[Detector], settings: Settings) -> dict[str, Floats]:
    """What each detector says of an idle patch, (T,) by its label."""
    quiet = {name: quiet_readings(settings, name) for name in ("stress", "capacitance")}
    return {each.label: each.statistic(quiet[each.quantity]) for each in found}


def noisy(trial: Trial, settings: Settings, seed: int, averaged: int = 1) -> Floats | None:
    """Readings (P, L) of a trial, each the mean of `averaged` readings with independent noise."""
    clean = trial.clean(settings, settings.size.presses, seed)
    if clean is None:
        return None
    rng = np.random.default_rng([settings.seed, seed, averaged])
    spread = noise_of(settings, trial.quantity) / np.sqrt(averaged)
    return clean + rng.normal(scale=spread, size=clean.shape)


def trials(quantity: str, settings: Settings) -> Iterator[tuple[int, Trial]]:
    """Every indenter, kind of place and load, with a seed of its own; in smoke one indenter."""
    kinds = [(tip, place, force) for tip in TIPS for place in PLACES for force in LOADS]
    for seed, (tip, place, force) in enumerate(kinds, start=100):
        if tip is BALL or settings.size.name != "smoke":
            yield seed, Trial(tip, place, force, quantity)


def rates(found: Sequence[Detector], quiet: dict[str, Floats], settings: Settings) -> list[Rate]:
    """Rates of every detector in every trial that linear elasticity can carry."""
    levels = {label: threshold(values, settings.false_alarms) for label, values in quiet.items()}
    results = []
    for quantity in ("stress", "capacitance"):
        for seed, trial in trials(quantity, settings):
            pressed = noisy(trial, settings, seed)
            if pressed is None:
                continue
            for each in found:
                if each.quantity == quantity:
                    hits = int((each.statistic(pressed) > levels[each.label]).sum())
                    results.append(Rate(each.name, each.nodes, trial, hits, len(pressed)))
    return results


def averaged_shares(
    found: Sequence[Detector],
    quiet: dict[str, Floats],
    settings: Settings,
    trial: Trial,
    counts: Sequence[int],
) -> dict[str, Floats]:
    """Share of presses found when so many readings are averaged, (N,) by the detector's label.

    Every statistic here is proportional to its readings' scale, so the threshold falls as the
    noise does, with the square root of the count.
    """
    shares: dict[str, list[float]] = {each.label: [] for each in found}
    for count in counts:
        pressed = noisy(trial, settings, 7, averaged=count)
        if pressed is None:
            raise AssertionError(f"{trial} sinks through the layer")
        for each in found:
            level = threshold(quiet[each.label], settings.false_alarms) / np.sqrt(count)
            shares[each.label].append(float((each.statistic(pressed) > level).mean()))
    return {label: np.array(values) for label, values in shares.items()}
