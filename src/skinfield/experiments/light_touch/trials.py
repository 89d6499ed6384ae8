"""Light presses by the simulator, noise, and the detectors that look for them."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from skinfield.detection import Detector, LargestMatch, MarginalLikelihood
from skinfield.errors import Floats
from skinfield.experiments.paper.methods import PAPER, PAPER_GENERAL
from skinfield.experiments.paper.presses import BALL, PLACES, paper_patch, readings, sites
from skinfield.experiments.scoring.statistics import FieldPeak, Statistic, highest_taxel
from skinfield.experiments.settings import Settings
from skinfield.layout import Grid
from skinfield.layout.hull import inside_hull
from skinfield.observation import BaseStress, Capacitance, Quantity

ANYWHERE = "anywhere"
KINDS = (*PLACES, ANYWHERE)
LOOKED = 15  # readings: 0.3 s at 50 Hz
QUANTITIES: dict[str, Quantity] = {"stress": BaseStress(), "capacitance": Capacitance()}
OURS, MATCH, TAXEL = "detector: marginal likelihood", "detector: largest match", "highest taxel"
PAPERS = f"{PAPER.name}, 20 × 20"
GENERAL = f"{PAPER_GENERAL.name}, 20 × 20"
BOUND = "place and shape known: the limit"
SMOKE_SPACING = 2.5e-3  # m: a few hundred places instead of thousands


@dataclass(frozen=True)
class Touch:
    """A ball of 12 mm with some force, at places of a kind."""

    quantity: str
    place: str
    force: float


def noise_of(settings: Settings, quantity: str) -> float:
    """Standard deviation of one reading, in the quantity's unit."""
    return settings.change_noise if quantity == "capacitance" else settings.stress_noise


@lru_cache(maxsize=8)
def detector(settings: Settings, quantity: str, largest: bool) -> Detector:
    """Ours, for the paper's patch."""
    return Detector(
        paper_patch(),
        settings.layer,
        quantity=QUANTITIES[quantity],
        noise_std=noise_of(settings, quantity),
        false_alarm_rate=settings.false_alarms,
        statistic=LargestMatch() if largest else MarginalLikelihood(),
        spacing=SMOKE_SPACING if settings.size.name == "smoke" else None,
        seed=settings.seed,
    )


def statistics(settings: Settings, quantity: str) -> dict[str, Statistic]:
    """All that are compared, by name; proportional to nothing but the scale of the noise."""
    found: dict[str, Statistic] = {}
    if quantity == "stress":
        for name, method in ((PAPERS, PAPER), (GENERAL, PAPER_GENERAL)):
            reconstruct = method.prepared(
                paper_patch(), settings.layer, 20, noise_of(settings, quantity)
            )
            found[name] = FieldPeak(reconstruct)
    found[TAXEL] = highest_taxel
    found[MATCH] = detector(settings, quantity, True).statistics
    found[OURS] = detector(settings, quantity, False).statistics
    return found


@lru_cache(maxsize=1)
def _anywhere() -> Floats:
    patch = paper_patch()
    low, high = patch.plane.min(axis=0), patch.plane.max(axis=0)
    places = Grid.window(patch, low, high, 0.3e-3).plane
    return places[inside_hull(patch.plane, places)]


def clean(touch: Touch, settings: Settings, count: int, seed: int) -> Floats:
    """Readings (count, L) without noise, each at a random place of the kind."""
    places = _anywhere() if touch.place == ANYWHERE else sites(paper_patch())[touch.place]
    rng = np.random.default_rng([settings.seed, 40, seed])
    chosen = places[rng.integers(len(places), size=count)]
    found = readings(
        BALL,
        paper_patch(),
        settings.layer,
        touch.force,
        settings.size.cell,
        chosen,
        touch.quantity,
    )
    if found is None:
        raise AssertionError(f"{touch} sinks through the layer")
    return found


def noisy(touch: Touch, settings: Settings, seed: int, averaged: int = LOOKED) -> Floats:
    """Readings (P, L) of presses, each the mean of several with independent noise.

    They are scaled to the noise of one reading, so that thresholds of single readings hold.
    """
    pressed = clean(touch, settings, settings.size.presses, seed) * np.sqrt(averaged)
    rng = np.random.default_rng([settings.seed, 41, seed])
    pressed += rng.normal(scale=noise_of(settings, touch.quantity), size=pressed.shape)
    return np.asarray(pressed)


def idle(settings: Settings, quantity: str) -> Floats:
    """Readings (T, L) of an idle patch."""
    rng = np.random.default_rng([settings.seed, 42])
    scale = noise_of(settings, quantity)
    return rng.normal(scale=scale, size=(settings.size.quiet, len(paper_patch())))


def limit(
    touch: Touch, settings: Settings, seed: int, alarms: Floats, averaged: int = LOOKED
) -> Floats:
    """Share (A,) that a matched filter finds which is told place and shape, at false alarms (A,).

    By Neyman and Pearson nothing finds more, and as nobody knows the place, all find less.
    """
    from scipy.special import ndtr, ndtri

    pressed = clean(touch, settings, settings.size.presses, seed)
    clear = np.sqrt(averaged) * np.linalg.norm(pressed, axis=1)
    clear /= noise_of(settings, touch.quantity)
    return np.asarray(ndtr(clear[:, None] + ndtri(alarms)).mean(axis=0))
