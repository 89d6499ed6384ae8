"""Light touch: the detector beside the paper's method and beside what no test can beat."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from skinfield.elastic import BaseStress, Capacitance, Quantity
from skinfield.errors import Floats
from skinfield.lab.paper import PAPER, PLACES, paper_patch
from skinfield.lab.plots import Panel, Scale, draw_panels
from skinfield.lab.report import Picture, Section, Settings, Table, listed
from skinfield.lab.score import wilson
from skinfield.lab.sections.detection import (
    ANYWHERE,
    Share,
    Statistic,
    Trial,
    alarm_rates,
    field_peak,
    highest_taxel,
    idle_readings,
    interval_curve,
    noise_of,
    noisy,
    roc,
    roc_panel,
    threshold,
)
from skinfield.plot.style import plural
from skinfield.solve.detection import Detector, DetectorStream, LargestMatch, MarginalLikelihood

CLAIM = "With 0.2 N over a taxel the contact cannot be isolated from noise, whatever the grid."
KINDS = (*PLACES, ANYWHERE)
LOOKED = 15  # readings: 0.3 s at 50 Hz
QUANTITIES: dict[str, Quantity] = {"stress": BaseStress(), "capacitance": Capacitance()}
OURS, MATCH, TAXEL = "detector: marginal likelihood", "detector: largest match", "highest taxel"
PAPERS = f"{PAPER.name}, 20 × 20"
BOUND = "place and shape known: the limit"
METHODS = (PAPERS, TAXEL, MATCH, OURS, BOUND)
SMOKE_SPACING = 2.5e-3  # m: a few hundred places instead of thousands
ROCS = ((0.2, 1), (0.1, LOOKED), (0.2, LOOKED))  # N and readings
FORCES, FEW = (0.05, 0.1, 0.2, 0.4, 0.7, 1.0), (0.1, 0.2)  # N; in smoke
WATCHED = ((0.1, PLACES[0]), (0.2, PLACES[0]), (0.4, PLACES[1]), (0.4, PLACES[2]))  # live
BEFORE, AFTER = LOOKED - 1, 2 * LOOKED  # readings around the moment of touch
LIVE_TRIALS = {"smoke": 12, "short": 300, "full": 2000}
CHUNK = 50  # touches at once
IDLE_SHARE = 4  # idle readings of the settings, per idle window of a stream


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


def limit(
    trial: Trial, settings: Settings, seed: int, alarms: Floats, averaged: int = LOOKED
) -> Floats:
    """Share (A,) that a matched filter finds which is told place and shape, at false alarms (A,).

    By Neyman and Pearson nothing finds more, and as nobody knows the place, all find less.
    """
    from scipy.special import ndtr, ndtri

    pressed = trial.clean(settings, settings.size.presses, 40, seed)
    clear = np.sqrt(averaged) * np.linalg.norm(pressed, axis=1)
    clear /= noise_of(settings, trial.quantity)
    return np.asarray(ndtr(clear[:, None] + ndtri(alarms)).mean(axis=0))


@dataclass(frozen=True, eq=False)
class LightTouch:
    """All statistics of one run, each made when it is asked for."""

    settings: Settings

    @cached_property
    def _methods(self) -> dict[str, dict[str, Statistic]]:
        """All that are compared, by quantity and name; readings scaled to the noise of one."""
        settings = self.settings
        methods: dict[str, dict[str, Statistic]] = {
            quantity: {
                TAXEL: highest_taxel,
                MATCH: detector(settings, quantity, True).statistics,
                OURS: detector(settings, quantity, False).statistics,
            }
            for quantity in QUANTITIES
        }
        prepared = PAPER.prepared(paper_patch(), settings.layer, 20, settings.stress_noise)
        methods["stress"][PAPERS] = field_peak(prepared)
        return methods

    def _statistics(self, readings: Floats, quantity: str) -> dict[str, Floats]:
        return {name: each(readings) for name, each in self._methods[quantity].items()}

    def _pressed(self, trial: Trial, seed: int, averaged: int) -> dict[str, Floats]:
        drawn = noisy(trial, self.settings, (40, seed), (41, seed), averaged)
        return self._statistics(drawn * np.sqrt(averaged), trial.quantity)

    @cached_property
    def quiet(self) -> dict[str, dict[str, Floats]]:
        """Statistics (T,) of idle readings by quantity and method."""
        return {q: self._statistics(idle_readings(self.settings, q, 42), q) for q in QUANTITIES}

    @cached_property
    def pressed(self) -> dict[Trial, dict[str, Floats]]:
        """Statistics (P,) of pressed readings by touch and method."""
        return {trial: self._pressed(trial, seed, LOOKED) for seed, trial in self.touches()}

    @property
    def forces(self) -> tuple[float, ...]:
        """That are tried, N."""
        return FEW if self.settings.size.name == "smoke" else FORCES

    def touches(self) -> Iterator[tuple[int, Trial]]:
        """Every quantity, kind of place and force, with a seed of its own."""
        every = [(place, force, q) for q in QUANTITIES for place in KINDS for force in self.forces]
        return enumerate(Trial(*each) for each in every)

    def level(self, quantity: str, method: str) -> float:
        """Threshold: ours states its own, the others' is measured on idle readings."""
        if method in (OURS, MATCH):
            return detector(self.settings, quantity, method == MATCH).threshold
        return threshold(self.quiet[quantity][method], self.settings.false_alarms)

    @cached_property
    def shares(self) -> dict[tuple[str, Trial], Share]:
        """Of every method and touch, and the limit of each touch."""
        out = []
        for seed, trial in self.touches():
            for name, values in self.pressed[trial].items():
                hits = int((values > self.level(trial.quantity, name)).sum())
                out.append(Share.of(name, trial, hits, len(values)))
            alarms = np.array([self.settings.false_alarms])
            best = float(limit(trial, self.settings, seed, alarms)[0])
            out.append(Share(BOUND, trial, best, (best, best)))
        return {(each.method, each.trial): each for each in out}

    def rocs(self, trial: Trial, averaged: int, alarms: Floats) -> dict[str, Floats]:
        """Share found at false alarms (A,) in so many readings by method, the limit last."""
        seed = next(seed for seed, each in self.touches() if each == trial)
        quiet, pressed = self.quiet[trial.quantity], self.pressed[trial]
        if averaged != LOOKED:
            pressed = self._pressed(trial, seed, averaged)
        curves = {name: roc(quiet[name], pressed[name], alarms) for name in pressed}
        inside = np.minimum(alarms, 1 - 1e-12)
        return curves | {BOUND: limit(trial, self.settings, seed, inside, averaged)}


@lru_cache(maxsize=4)
def _stream(settings: Settings, quantity: str) -> DetectorStream:
    return detector(settings, quantity, False).stream(LOOKED / settings.rate, settings.rate)


def watched(trial: Trial, settings: Settings, seed: int) -> Floats:
    """Whether each touch (N,) is seen at each reading since it began, (N, T).

    A stream looks back with every reading, over touches that begin after `BEFORE` idle ones.
    """
    count, stream = LIVE_TRIALS[settings.size.name], _stream(settings, trial.quantity)
    pressed = trial.clean(settings, count, 40, seed)
    rng = np.random.default_rng([settings.seed, 43, seed])
    scale = noise_of(settings, trial.quantity)
    seen = []
    for first in range(0, count, CHUNK):
        part = pressed[first : first + CHUNK]
        series = rng.normal(scale=scale, size=(len(part), BEFORE + AFTER, part.shape[1]))
        series[:, BEFORE:] += part[:, None]
        seen.append(_alarms_of(stream, series))
    return np.concatenate(seen)


def idle_alarms(settings: Settings, quantity: str) -> tuple[int, int]:
    """Alarms, and of how many windows of an idle patch; windows that do not overlap."""
    stream, count = _stream(settings, quantity), settings.size.quiet // IDLE_SHARE
    rng = np.random.default_rng([settings.seed, 44])
    scale, taxels = noise_of(settings, quantity), len(stream.detector.patch)
    alarms = 0
    for first in range(0, count, CHUNK):
        shape = (min(CHUNK, count - first), stream.lengths[-1], taxels)
        alarms += int(_alarms_of(stream, rng.normal(scale=scale, size=shape)).sum())
    return alarms, count


def _alarms_of(stream: DetectorStream, readings: Floats) -> Floats:
    """What `DetectorStream.update` says of N series (N, T, L) from the first full window on."""
    whitened = stream.lookback.bank.whitened(readings)
    start = np.zeros_like(whitened[:, :1])
    total = np.concatenate([start, whitened.cumsum(axis=1)], axis=1)
    longest = stream.lengths[-1]
    columns = []
    for end in range(longest, total.shape[1]):
        sums = np.stack([total[:, end] - total[:, end - n] for n in stream.lengths], axis=1)
        statistic = stream.detector.statistic(stream.lookback.matches(sums))
        columns.append(statistic > stream.threshold)
    return np.stack(columns, axis=1)


def light_touch(settings: Settings) -> Section:
    """Shares of light touches found, the rate of false alarms, and the time that it takes."""
    made = LightTouch(settings)
    tried = WATCHED[: 2 if settings.size.name == "smoke" else None]
    trials = [Trial(place, force) for force, place in tried]
    runs = {trial: watched(trial, settings, seed) for seed, trial in enumerate(trials)}
    return Section(
        name="light-touch",
        title="Light touch",
        claim=CLAIM,
        sentences=tuple(_sentences(made, runs)),
        pictures=(_picture_of_rocs(made), _picture_of_time(runs, made)),
        tables=(
            _light(made),
            _alarms(made),
            Table.of("all", "Every share.", [e.row() for e in made.shares.values()], on_page=False),
        ),
    )


def _sentences(made: LightTouch, runs: Mapping[Trial, Floats]) -> list[str]:
    settings = made.settings

    def share(method: str, force: float, place: str = PLACES[0], reads: str = "stress") -> Share:
        return made.shares[method, Trial(place, force, reads)]

    def percent(method: str, force: float, place: str = PLACES[0], reads: str = "stress") -> str:
        return f"{100 * share(method, force, place, reads).value:.0f} %"

    seconds, two, seen = LOOKED / settings.rate, PLACES[1], next(iter(runs.values()))
    reached = [f"{share(OURS, force)} of {force:g} N" for force in (0.2, 0.1)]
    return [
        f"Over a taxel, in {LOOKED} readings ({seconds:g} s) of {settings.stress_noise / 1e3:g} "
        f"kPa noise each and at {settings.false_alarms:g} false alarms per decision, the detector "
        f"finds {listed(reached)}. On means of the same readings the paper's method finds "
        f"{percent(PAPERS, 0.1)} of 0.1 N, and the highest taxel {percent(TAXEL, 0.1)}: over a "
        "taxel a light touch is a matter of that taxel alone.",
        f"Between two taxels the marginal likelihood finds {percent(OURS, 0.2, two)} of 0.2 N, the "
        f"largest match {percent(MATCH, 0.2, two)}, the highest taxel {percent(TAXEL, 0.2, two)}, "
        f"the paper's method {percent(PAPERS, 0.2, two)}; a filter that is told place and shape "
        f"{percent(BOUND, 0.2, two)}. The difference is the price of looking everywhere.",
        f"Where taxels read ΔC/C₀ with a noise of {settings.change_noise:g}, the detector finds "
        f"{share(OURS, 0.1, reads='capacitance')} of 0.1 N over a taxel; told place and shape it "
        f"would be {percent(BOUND, 0.1, reads='capacitance')}.",
        "A stream that looks back over several lengths with every reading sees "
        f"{100 * seen[:, :LOOKED].any(axis=1).mean():.0f} % of 0.1 N over a taxel within "
        f"{seconds:g} s.",
    ]


def _light(made: LightTouch) -> Table:
    rows = [
        {"reads": quantity, "force (N)": force, "place": place}
        | {
            f"{name} (%)": f"{100 * made.shares[name, trial].value:.1f}"
            for name in METHODS
            if (name, (trial := Trial(place, force, quantity))) in made.shares
        }
        for quantity in QUANTITIES
        for force in made.forces
        if force in (0.1, 0.2, 0.4)
        for place in KINDS
    ]
    caption = (
        f"Share found (%) over {LOOKED} readings at {made.settings.false_alarms:g} false alarms "
        "per decision."
    )
    return Table.of("light", caption, rows)


def _alarms(made: LightTouch) -> Table:
    settings = made.settings
    counts = []
    for quantity in QUANTITIES:
        for method in (OURS, MATCH):
            sampled = detector(settings, quantity, method == MATCH).false_alarms
            values = made.quiet[quantity][method]
            for rate in (1e-2, 1e-3, 1e-4):
                alarms = int((values > sampled.threshold(rate)).sum())
                counts.append((quantity, method, rate, alarms, len(values)))
    counts.append(("stress", "stream", settings.false_alarms, *idle_alarms(settings, "stress")))
    rows = [
        {"reads": quantity, "method": method, "stated rate": stated, "alarms": alarms, "of": of}
        | {"rate": alarms / of}
        | dict(zip(("from", "to"), wilson(alarms, of), strict=True))
        for quantity, method, stated, alarms, of in counts
    ]
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
        note, row = plural(averaged, "reading"), []
        for place in KINDS:
            trial = Trial(place, force)
            shares = made.rocs(trial, averaged, alarms)
            chosen = {name: shares[name] for name in METHODS}
            row.append(
                roc_panel(trial, note, alarms, chosen, limit=BOUND, rate=settings.false_alarms)
            )
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


def _picture_of_time(runs: Mapping[Trial, Floats], made: LightTouch) -> Picture:
    """Share found against the time since touch."""
    settings = made.settings
    scale = Scale(x="time since touch (s)", y="share of touches found", y_limits=(-0.03, 1.03))
    panels = []
    for trial, seen in runs.items():
        count, readings = seen.shape
        time = (np.arange(readings) + 1) / settings.rate
        once = np.logical_or.accumulate(seen, axis=1)
        curves = (
            interval_curve("at this reading", time, seen.mean(axis=0), count),
            interval_curve("up to this reading", time, once.mean(axis=0), count),
        )
        title = f"{trial.force:g} N {trial.place}"
        panels.append(Panel(title, "", curves, scale, LOOKED / settings.rate))
    caption = (
        f"A stream that looks back over 1, 3, 7 and {LOOKED} readings at {settings.rate:g} Hz, at "
        f"{settings.false_alarms:g} false alarms per reading: share of {count} touches "
        f"that are seen, with {settings.stress_noise / 1e3:g} kPa of noise in each reading. "
        "Dotted: the longest length; bands are 95 % intervals."
    )
    return Picture.of("time", caption, draw_panels([panels]))
