"""Make the picture of detect-light-touch.md, and print the numbers that it quotes.

python docs/figures/light_touch.py [smoke|short|full]
"""

import sys
import time
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from pathlib import Path

import click
import numpy as np
from looks import dashed

import skinfield as sf
from skinfield.elastic import BaseStress, Capacitance, Quantity
from skinfield.errors import Floats
from skinfield.lab.paper import FALSE_ALARMS, LAYER, NOISES, PAPER, PLACES, RATE, paper_patch
from skinfield.lab.plots import Curve, draw_panels
from skinfield.lab.report import SHORT, SIZES, Effort, Picture
from skinfield.lab.sections.detection import (
    Statistic,
    Trial,
    Values,
    alarm_rates,
    field_peak,
    highest_taxel,
    idle_readings,
    noisy,
    places_inside,
    roc_panel,
    shares_of,
    threshold,
)
from skinfield.plot import plural
from skinfield.solve.detection import Detector, LargestMatch, MarginalLikelihood

IMAGES = Path(__file__).parents[1] / "images"
NOISE, COUNT = 3.8e3, 40_000  # Pa; idle decisions


ANYWHERE, ANYWHERE_PITCH = "anywhere", 0.3e-3  # m
KINDS = (*PLACES, ANYWHERE)
LOOKED = 15  # readings: 0.3 s at 50 Hz
QUANTITIES: dict[str, Quantity] = {"stress": BaseStress(), "capacitance": Capacitance()}
OURS, MATCH, TAXEL = "detector: marginal likelihood", "detector: largest match", "highest taxel"
PAPERS = f"{PAPER.name}, 20 × 20"
BOUND = "place and shape known: the limit"
METHODS = (PAPERS, TAXEL, MATCH, OURS)
SMOKE_SPACING = 2.5e-3  # m: a few hundred places instead of thousands
ROCS = ((0.2, 1), (0.1, LOOKED), (0.2, LOOKED))  # N and readings
FORCES, FEW = (0.05, 0.1, 0.2, 0.4, 0.7, 1.0), (0.1, 0.2)  # N; in smoke


@lru_cache(maxsize=1)
def _anywhere() -> Floats:
    return places_inside(ANYWHERE_PITCH)


class Touch(Trial):
    """A load at a kind of place, or anywhere inside the taxels' hull."""

    @property
    def places(self) -> Floats:
        """Where it may be, (P, 2) m."""
        return _anywhere() if self.place == ANYWHERE else super().places


@lru_cache(maxsize=8)
def detector(settings: Effort, quantity: str, method: str) -> Detector:
    """Ours, for the paper's patch."""
    return Detector(
        paper_patch(),
        LAYER,
        quantity=QUANTITIES[quantity],
        noise_std=NOISES[quantity],
        false_alarm_rate=FALSE_ALARMS,
        statistic=LargestMatch() if method == MATCH else MarginalLikelihood(),
        spacing=SMOKE_SPACING if settings.name == "smoke" else None,
        seed=settings.seed,
    )


def limit(trial: Trial, settings: Effort, seed: int, alarms: Floats, averaged: int) -> Floats:
    """Share (A,) that a matched filter finds which is told place and shape, at false alarms (A,).

    By Neyman and Pearson nothing finds more, and as nobody knows the place, all find less.
    """
    from scipy.special import ndtr, ndtri

    pressed = trial.clean(settings, settings.presses, 40, seed)
    clear = np.sqrt(averaged) * np.linalg.norm(pressed, axis=1)
    clear /= NOISES[trial.quantity]
    inside = np.minimum(alarms, 1 - 1e-12)
    return np.asarray(ndtr(clear[:, None] + ndtri(inside)).mean(axis=0))


@dataclass(frozen=True, eq=False)
class LightTouch:
    """The detectors beside the paper's method and the highest taxel, by quantity."""

    settings: Effort

    @cached_property
    def methods(self) -> dict[str, dict[str, Statistic]]:
        """Statistics by name, each proportional to the scale of its readings."""
        methods: dict[str, dict[str, Statistic]] = {
            q: {TAXEL: highest_taxel}
            | {name: detector(self.settings, q, name).statistics for name in (OURS, MATCH)}
            for q in QUANTITIES
        }
        methods["stress"][PAPERS] = field_peak(PAPER.prepared(20, NOISES["stress"]))
        return methods

    @cached_property
    def quiet(self) -> dict[str, Values]:
        """Statistics (T,) of idle readings."""
        return {q: self._values(q, idle_readings(self.settings, q, 42)) for q in QUANTITIES}

    def _values(self, quantity: str, readings: Floats) -> Values:
        return {name: each(readings) for name, each in self.methods[quantity].items()}

    @cached_property
    def levels(self) -> dict[str, dict[str, float]]:
        """Thresholds: a detector states its own."""
        levels = {
            q: {name: threshold(each, FALSE_ALARMS) for name, each in quiet.items()}
            for q, quiet in self.quiet.items()
        }
        for quantity, each in levels.items():
            each |= {n: detector(self.settings, quantity, n).threshold for n in (OURS, MATCH)}
        return levels

    @cached_property
    def trials(self) -> dict[Trial, int]:
        """Every quantity, kind of place and force, with a seed of its own."""
        forces = FEW if self.settings.name == "smoke" else FORCES
        every = [Touch(place, force, q) for q in QUANTITIES for place in KINDS for force in forces]
        return {trial: seed for seed, trial in enumerate(every)}

    @cached_property
    def touches(self) -> dict[Trial, Values]:
        """Statistics (P,) of `LOOKED` readings together."""
        return {trial: self.touched(trial, LOOKED) for trial in self.trials}

    def touched(self, trial: Trial, averaged: int) -> Values:
        """Statistics (P,) of so many readings together."""
        seed = self.trials[trial]
        readings = noisy(trial, self.settings, (40, seed), (41, seed), averaged)
        return self._values(trial.quantity, readings * np.sqrt(averaged))

    def bound(self, trial: Trial) -> float:
        """Share that nobody finds more of."""
        alarms = np.array([FALSE_ALARMS])
        return float(limit(trial, self.settings, self.trials[trial], alarms, LOOKED)[0])


def rates(size: str) -> None:
    """Draw ROC curves, and print shares of light touches found, and rates of false alarms."""
    settings = SIZES[size]
    made = LightTouch(settings)
    (IMAGES / "light-touch-roc.png").write_bytes(_picture_of_rocs(made).png)
    click.echo(f"share found (%) over {LOOKED} readings at {FALSE_ALARMS:g}")
    for trial, values in made.touches.items():
        levels = made.levels[trial.quantity]
        shares = {name: each.value for name, each in shares_of(levels, values).items()}
        shares[BOUND] = made.bound(trial)
        found = ", ".join(f"{name} {100 * value:.1f}" for name, value in shares.items())
        click.echo(f"  {trial.quantity}, {trial.force:g} N {trial.place}: {found}")
    click.echo("\nfalse alarms on idle readings that no threshold was set on")
    for quantity, method in product(QUANTITIES, (OURS, MATCH)):
        sampled = detector(settings, quantity, method).false_alarms
        for stated in (1e-2, 1e-3, 1e-4):
            alarms = made.quiet[quantity][method] > sampled.threshold(stated)
            click.echo(f"  {quantity}, {method}: stated {stated:g}, found {alarms.mean():.2g}")


def _picture_of_rocs(made: LightTouch) -> Picture:
    """Stress: share found against false alarms."""
    settings, alarms = made.settings, alarm_rates(made.settings)
    rows = []
    for force, averaged in ROCS:
        row = []
        for trial in (Touch(place, force) for place in KINDS):
            values = made.touches[trial] if averaged == LOOKED else made.touched(trial, averaged)
            best = limit(trial, settings, made.trials[trial], alarms, averaged)
            chosen, curve = {name: values[name] for name in METHODS}, Curve(BOUND, alarms, best)
            note, quiet = plural(averaged, "reading"), made.quiet["stress"]
            row.append(roc_panel(str(trial), note, quiet, chosen, alarms, curve))
        rows.append(row)
    caption = (
        "Receiver operating characteristics with a noise of "
        f"{NOISES['stress'] / 1e3:g} kPa in each reading: above a "
        f"single one, below {LOOKED} together, {LOOKED / RATE:g} s at {RATE:g} "
        f"Hz. {settings.presses} presses of a 12 mm ball per panel, {settings.quiet} "
        "idle ones. Dashed: a matched filter that is told place and shape; dotted: "
        f"{FALSE_ALARMS:g} false alarms."
    )
    figure = draw_panels(rows, panel_height=2.1)
    dashed(figure, BOUND)
    return Picture.of("roc", caption, figure)


def traps() -> None:
    """Print what noise that is not as stated does to the rate of false alarms, 1e-3."""
    patch, rng = sf.layouts.hexagon72(), np.random.default_rng(3)
    quantity = sf.BaseStress()
    plain, free, half = (
        sf.Detector(patch, LAYER, quantity=quantity, noise_std=NOISE, common_mode=mode)
        for mode in (False, True, NOISE / 2)
    )
    white = rng.normal(scale=NOISE, size=(COUNT, 72))
    offset = rng.normal(scale=NOISE, size=(COUNT, 1))

    def alarms(detector: sf.Detector, readings: Floats, count: int = 1) -> float:
        found = detector.statistics(readings, count) > detector.threshold
        return float(found.mean())

    click.echo("\nfalse alarms per 1000, and 0.1 N over a taxel found in 15 readings")
    light = Trial("over a taxel", 0.1).clean(SHORT, 4000, 40, 9)
    pressed = light + rng.normal(scale=NOISE / np.sqrt(15), size=light.shape)
    for name, detector in (("as stated", plain), ("offset unknown", free), ("half", half)):
        for share in (0.0, 0.25, 0.5, 1.0):
            rate = 1e3 * alarms(detector, white + share * offset)
            click.echo(f"  {name}: offset of {share:g} noises: {rate:.2f}")
        click.echo(f"  {name}: found {alarms(detector, pressed, 15):.1%}")
    for wrong in (0.9, 1.1, 1.2):
        click.echo(f"  noise {wrong:g} of the stated: {1e3 * alarms(plain, wrong * white):.2f}")
    for kept in (0.2, 0.5):  # of a reading's noise in the next, in 15 readings
        series = rng.normal(scale=NOISE, size=(COUNT, 72))
        total = series.copy()
        for _ in range(14):
            fresh = rng.normal(scale=NOISE * np.sqrt(1 - kept**2), size=(COUNT, 72))
            series = kept * series + fresh
            total += series
        told = sf.Detector(
            patch, LAYER, quantity=quantity, noise_std=NOISE, correlation=kept
        )  # fmt: skip
        rates = [1e3 * alarms(detector, total / 15, 15) for detector in (plain, told)]
        click.echo(f"  correlation {kept:g} in time: {rates[0]:.2f}, told of it {rates[1]:.2f}")
        pressed = light + (total / 15)[: len(light)]
        click.echo(f"    and found {alarms(told, pressed, 15):.1%}")


def times() -> None:
    """Print seconds to make a detector and a stream, and per reading."""
    patch, noise = sf.layouts.hexagon72(), np.random.default_rng(0).normal(size=(15, 72)) * NOISE
    for _ in range(2):  # the first loads what is compiled
        start = time.perf_counter()
        detector = sf.Detector(patch, LAYER, quantity=sf.BaseStress(), noise_std=NOISE)
        made = time.perf_counter()
        stream = detector.stream()
        streamed = time.perf_counter()
    click.echo(f"\n{len(detector.templates.readings)} templates")
    click.echo(f"made in {made - start:.2f} s, its stream in {streamed - made:.2f} s")
    laps = {"call": [], "update": []}  # type: dict[str, list[float]]
    for index in range(300):
        first = time.perf_counter()
        detector(noise)
        second = time.perf_counter()
        stream.update(noise[index % 15], index * 20_000_000)
        laps["call"].append(second - first)
        laps["update"].append(time.perf_counter() - second)
    for name, values in laps.items():
        click.echo(f"{name}: {np.median(values) * 1e3:.2f} ms, 99 %: "
                   f"{np.quantile(values, 0.99) * 1e3:.2f} ms")  # fmt: skip


if __name__ == "__main__":
    times()
    traps()
    rates(*(sys.argv[1:] or ["short"]))
