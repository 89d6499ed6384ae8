"""Light touch: the detector beside the paper's method and beside what no test can beat."""

from functools import cached_property, lru_cache

import numpy as np

from skinfield.elastic import BaseStress, Capacitance, Quantity
from skinfield.errors import Floats
from skinfield.lab.paper import PAPER, PLACES, paper_patch
from skinfield.lab.plots import LIMIT, Curve, draw_panels
from skinfield.lab.report import Picture, Section, Settings, Table
from skinfield.lab.score import wilson
from skinfield.lab.sections.detection import (
    ANYWHERE,
    Campaign,
    Share,
    Statistic,
    Trial,
    Values,
    alarm_rates,
    field_peak,
    highest_taxel,
    noise_of,
)
from skinfield.plot.style import plural
from skinfield.solve.detection import Detector, LargestMatch, MarginalLikelihood

CLAIM = "With 0.2 N over a taxel the contact cannot be isolated from noise, whatever the grid."
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


@lru_cache(maxsize=8)
def detector(settings: Settings, quantity: str, method: str) -> Detector:
    """Ours, for the paper's patch."""
    return Detector(
        paper_patch(),
        settings.layer,
        quantity=QUANTITIES[quantity],
        noise_std=noise_of(settings, quantity),
        false_alarm_rate=settings.false_alarms,
        statistic=LargestMatch() if method == MATCH else MarginalLikelihood(),
        spacing=SMOKE_SPACING if settings.size.name == "smoke" else None,
        seed=settings.seed,
    )


def limit(trial: Trial, settings: Settings, seed: int, alarms: Floats, averaged: int) -> Floats:
    """Share (A,) that a matched filter finds which is told place and shape, at false alarms (A,).

    By Neyman and Pearson nothing finds more, and as nobody knows the place, all find less.
    """
    from scipy.special import ndtr, ndtri

    pressed = trial.clean(settings, settings.size.presses, 40, seed)
    clear = np.sqrt(averaged) * np.linalg.norm(pressed, axis=1)
    clear /= noise_of(settings, trial.quantity)
    inside = np.minimum(alarms, 1 - 1e-12)
    return np.asarray(ndtr(clear[:, None] + ndtri(inside)).mean(axis=0))


class LightTouch(Campaign):
    """The detectors beside the paper's method and the highest taxel."""

    @classmethod
    def of(cls, settings: Settings) -> "LightTouch":
        """With all of its methods."""
        made = {
            (q, name): detector(settings, q, name) for q in QUANTITIES for name in (OURS, MATCH)
        }
        methods: dict[str, dict[str, Statistic]] = {q: {TAXEL: highest_taxel} for q in QUANTITIES}
        for (quantity, name), each in made.items():
            methods[quantity][name] = each.statistics
        prepared = PAPER.prepared(paper_patch(), settings.layer, 20, settings.stress_noise)
        methods["stress"][PAPERS] = field_peak(prepared)
        return cls(settings, methods, 42, {key: each.threshold for key, each in made.items()})

    @cached_property
    def trials(self) -> dict[Trial, int]:
        """Every quantity, kind of place and force, with a seed of its own."""
        forces = FEW if self.settings.size.name == "smoke" else FORCES
        every = [Trial(place, force, q) for q in QUANTITIES for place in KINDS for force in forces]
        return {trial: seed for seed, trial in enumerate(every)}

    @cached_property
    def touches(self) -> dict[Trial, Values]:
        """Statistics (P,) of `LOOKED` readings together."""
        return {trial: self.touched(trial, LOOKED) for trial in self.trials}

    def touched(self, trial: Trial, averaged: int) -> Values:
        """Statistics (P,) of so many readings together."""
        seed = self.trials[trial]
        return self.pressed(trial, (40, seed), (41, seed), averaged)

    def bound(self, trial: Trial) -> Share:
        """What nobody finds more of."""
        alarms = np.array([self.settings.false_alarms])
        best = float(limit(trial, self.settings, self.trials[trial], alarms, LOOKED)[0])
        return Share(BOUND, trial, best, (best, best))


def light_touch(settings: Settings) -> Section:
    """Shares of light touches found, and the rate of false alarms."""
    made = LightTouch.of(settings)
    every: dict[tuple[str, Trial], Share] = {}
    for trial, values in made.touches.items():
        every |= made.shares(trial, values) | {(BOUND, trial): made.bound(trial)}
    rows = [
        {"reads": trial.quantity, "force (N)": trial.force, "place": trial.place}
        | {
            f"{name} (%)": f"{100 * every[name, trial].value:.1f}"
            for name in (*METHODS, BOUND)
            if (name, trial) in every
        }
        for trial in sorted(made.trials, key=lambda each: (-len(each.quantity), each.force))
        if trial.force in (0.1, 0.2, 0.4)
    ]
    caption = (
        f"Share found (%) over {LOOKED} readings at {settings.false_alarms:g} false alarms "
        "per decision."
    )
    return Section(
        name="light-touch",
        title="Light touch",
        claim=CLAIM,
        sentences=(
            f"{LOOKED} readings of each touch ({LOOKED / settings.rate:g} s), with a noise of "
            f"{settings.stress_noise / 1e3:g} kPa or {settings.change_noise:g} of ΔC/C₀ in each. "
            "The detector looks everywhere; the paper's method and the highest taxel see the mean. "
            "The last column is a filter that is told place and shape: the difference to it is the "
            "price of looking everywhere.",
        ),
        pictures=(_picture_of_rocs(made),),
        tables=(
            Table.of("light", caption, rows),
            _alarms(made),
            Table.of("all", "Every share.", [e.row() for e in every.values()], on_page=False),
        ),
    )


def _alarms(made: LightTouch) -> Table:
    rows = []
    for quantity, method in made.levels:
        sampled = detector(made.settings, quantity, method).false_alarms
        values = made.quiet[quantity][method]
        for stated in (1e-2, 1e-3, 1e-4):
            alarms, of = int((values > sampled.threshold(stated)).sum()), len(values)
            low, high = wilson(alarms, of)
            rows.append(
                {"reads": quantity, "method": method, "stated rate": stated, "alarms": alarms,
                 "of": of, "rate": alarms / of, "from": low, "to": high}
            )  # fmt: skip
    caption = (
        "False alarms on idle readings that no threshold was set on, with 95 % intervals. Each "
        "threshold is set so that its rate is, with some certainty, below the stated one."
    )
    return Table.of("false-alarms", caption, rows)


def _picture_of_rocs(made: LightTouch) -> Picture:
    """Stress: share found against false alarms."""
    settings, alarms = made.settings, alarm_rates(made.settings)
    rows = []
    for force, averaged in ROCS:
        row = []
        for trial in (Trial(place, force) for place in KINDS):
            values = made.touches[trial] if averaged == LOOKED else made.touched(trial, averaged)
            best = limit(trial, settings, made.trials[trial], alarms, averaged)
            curve = Curve(BOUND, alarms, best, look=LIMIT)
            chosen = {name: values[name] for name in METHODS}
            row.append(made.roc_panel(trial, plural(averaged, "reading"), chosen, curve))
        rows.append(row)
    caption = (
        "Receiver operating characteristics with a noise of "
        f"{noise_of(settings, 'stress') / 1e3:g} kPa in each reading: above a "
        f"single one, below {LOOKED} together, {LOOKED / settings.rate:g} s at {settings.rate:g} "
        f"Hz. {settings.size.presses} presses of a 12 mm ball per panel, {settings.size.quiet} "
        "idle ones. Dashed: a matched filter that is told place and shape; dotted: "
        f"{settings.false_alarms:g} false alarms."
    )
    return Picture.of("roc", caption, draw_panels(rows, panel_height=2.1))
