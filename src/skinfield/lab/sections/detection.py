"""Detection in noise, Figures 6 and 7: trials, statistics with a threshold, shares detected."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skinfield.errors import Floats
from skinfield.lab.paper import (
    BALL,
    FALSE_ALARMS,
    FIELD,
    NOISES,
    PAPER,
    PLACES,
    RATE,
    paper_patch,
    readings,
    sites,
)
from skinfield.lab.plots import Curve, FieldPanel, Panel, Scale, draw_fields, draw_panels
from skinfield.lab.report import Chapter, Claim, Effort, Picture, Table, verdict_of
from skinfield.lab.score import wilson
from skinfield.reconstruct import Reconstructor
from skinfield.skin import Grid
from skinfield.skin.geometry import inside_hull

CHUNK = 4096  # readings at once: the fields of a chunk stay within 50 MB
TEMPLATE_PITCH = 1e-3  # m: between the places that the matched filter tries
Statistic = Callable[[Floats], Floats]


def field_peak(reconstruct: Reconstructor, in_deviations: bool = False) -> Statistic:
    """The highest cell of the reconstructed field: what the paper's figures show.

    Parameters
    ----------
    reconstruct : Reconstructor
    in_deviations : bool
        In standard deviations of each cell's noise, as `ContactFinder` compares it; else in Pa.
    """
    std = reconstruct.plan.noise.std
    felt = std > 0  # a node outside the taxels' hull has no pressure at all
    pressure = np.asarray(reconstruct.operator[: len(std)][felt], dtype=np.float64)
    weights = np.ascontiguousarray((pressure / std[felt, None] if in_deviations else pressure).T)

    def highest(readings: Floats) -> Floats:
        linear = reconstruct.quantity.linearise(readings, np.empty_like(readings))
        return np.asarray((linear @ weights).max(axis=1))

    return in_chunks(highest)


def in_chunks(statistic: Statistic) -> Statistic:
    """The same statistic (T,) of readings (T, L), some thousand readings at once."""
    return lambda readings: np.concatenate(
        [statistic(readings[first : first + CHUNK]) for first in range(0, len(readings), CHUNK)]
    )


def highest_taxel(readings: Floats) -> Floats:
    """No reconstruction at all: the highest reading, (T,)."""
    return np.asarray(readings.max(axis=1))


def matched_filter(templates: Floats) -> Statistic:
    """The shape of the press is known, (P, L) at many places; its place and load are not."""
    unit = templates / np.linalg.norm(templates, axis=1, keepdims=True)
    return in_chunks(lambda readings: np.asarray((readings @ unit.T).max(axis=1)))


def threshold(quiet: Floats, false_alarms: float) -> float:
    """What the statistic of idle readings (T,) exceeds at the given rate."""
    return float(np.quantile(quiet, 1.0 - false_alarms, method="higher"))


def roc(quiet: Floats, pressed: Floats, rates: Floats) -> Floats:
    """Share of pressed readings (T,) that are found at each rate of false alarms."""
    levels = np.quantile(quiet, 1.0 - rates, method="higher")
    return np.asarray((pressed[:, None] > levels).mean(axis=0))


def alarm_rates(settings: Effort, points: int = 60) -> Floats:
    """Rates of false alarms at which ROC curves are drawn, as low as the idle readings allow."""
    return np.geomspace(max(1e-4, 4 / settings.quiet), 1.0, points)


@dataclass(frozen=True)
class Trial:
    """A load in N of the paper's 1.2 cm half-sphere at a kind of place, and what taxels read."""

    place: str
    force: float
    quantity: str = "stress"

    def __str__(self) -> str:
        return f"{self.force:g} N {self.place}"

    @property
    def places(self) -> Floats:
        """Where it may be, (P, 2) m."""
        return sites()[self.place]

    def clean(self, settings: Effort, count: int, *stream: int) -> Floats:
        """Readings (count, L) without noise, at random places of the kind.

        Parameters
        ----------
        settings : Effort
        count : int
        *stream : int
            Of the random numbers, after the settings' seed.
        """
        places, rng = self.places, np.random.default_rng([settings.seed, *stream])
        at = places[rng.integers(len(places), size=count)]
        cell = settings.cell
        return readings(BALL, self.force, cell, at, self.quantity)


def places_inside(pitch: float) -> Floats:
    """Places (P, 2) m inside the taxels' hull."""
    plane = paper_patch().plane
    places = Grid.window(paper_patch(), plane.min(axis=0), plane.max(axis=0), pitch).plane
    return places[inside_hull(plane, places)]


def known_shape(settings: Effort) -> Floats:
    """Readings (P, L) of the 1.2 cm half-sphere at 0.5 N, everywhere inside the taxels' hull."""
    places, cell = places_inside(TEMPLATE_PITCH), settings.cell
    return readings(BALL, 0.5, cell, places, "stress")


def idle_readings(settings: Effort, quantity: str, *stream: int) -> Floats:
    """Readings (T, L) of an idle patch."""
    rng = np.random.default_rng([settings.seed, *stream])
    shape = (settings.quiet, len(paper_patch()))
    return rng.normal(scale=NOISES[quantity], size=shape)


def noisy(
    trial: Trial, settings: Effort, places: tuple[int, ...], noise: tuple[int, ...], averaged: int
) -> Floats:
    """Readings (P, L) of presses, each the mean of `averaged` readings with independent noise.

    Parameters
    ----------
    places, noise : tuples of int
        Streams of the random numbers, after the settings' seed.
    """
    clean = trial.clean(settings, settings.presses, *places)
    rng = np.random.default_rng([settings.seed, *noise])
    spread = NOISES[trial.quantity] / np.sqrt(averaged)
    return clean + rng.normal(scale=spread, size=clean.shape)


@dataclass(frozen=True)
class Share:
    """Part of the presses that a method detects, with its 95 % interval."""

    value: float
    interval: tuple[float, float]

    def __str__(self) -> str:
        low, high = (100 * end for end in self.interval)
        return f"{100 * self.value:.0f} % [{low:.0f}–{high:.0f} %]"


Values = dict[str, Floats]  # of a statistic, by method


def shares_of(levels: Mapping[str, float], values: Values) -> dict[str, Share]:
    """Part of the presses (P,) above the threshold of each method."""
    shares = {}
    for name, each in values.items():
        hits = int((each > levels[name]).sum())
        shares[name] = Share(hits / len(each), wilson(hits, len(each)))
    return shares


def roc_panel(
    title: str, note: str, quiet: Values, pressed: Values, alarms: Floats, *others: Curve
) -> Panel:
    """Share detected by method against false alarms (A,); those of the settings are marked."""
    curves = [Curve(name, alarms, roc(quiet[name], each, alarms)) for name, each in pressed.items()]
    scale = Scale(
        x="false alarms per decision", y="share of presses detected", log_x=True,
        x_limits=(float(alarms[0]), 1.0), y_limits=(-0.03, 1.03),
        x_ticks=tuple(tick for tick in (1e-4, 1e-3, 1e-2, 0.1) if tick >= alarms[0]),
    )  # fmt: skip
    return Panel(title, note, (*curves, *others), scale, FALSE_ALARMS)


RAW, KNOWN = "highest taxel", "matched filter (shape known)"
COARSE, FINE = f"{PAPER.name}, 20 × 20", f"{PAPER.name}, 40 × 40"
OURS = f"{FIELD.name}, 40 × 40"
DRAWN = (COARSE, FINE, OURS, RAW, KNOWN)
COUNTS = (1, 2, 4, 6, 8, 11, 15, 22, 30, 43, 60, 85, 120)  # readings averaged
RELIABLE = 0.99
FORCES = (0.2, 0.5)  # N
CLAIM = (
    "With 0.2 N over a taxel the contact cannot be isolated from noise, whatever the grid; "
    "filtering the readings improves it, but detection of 0.2 N is not reliable. With 0.5 N the "
    "contact is distinct over a taxel, and less clear but still identifiable between three."
)


@dataclass(frozen=True, eq=False)
class Methods:
    """The paper's method on every grid, ours on the same, and two without."""

    settings: Effort

    @cached_property
    def methods(self) -> dict[str, Statistic]:
        """Statistics by name, each proportional to the scale of its readings."""
        fields = {
            f"{method.name}, {nodes} × {nodes}": field_peak(
                method.prepared(nodes, NOISES["stress"]), in_deviations=method is FIELD
            )
            for method in (PAPER, FIELD)
            for nodes in self.settings.grids
        }
        return fields | {RAW: highest_taxel, KNOWN: matched_filter(known_shape(self.settings))}

    @cached_property
    def quiet(self) -> Values:
        """Statistics (T,) of idle readings."""
        idle = idle_readings(self.settings, "stress", 1)
        return {name: each(idle) for name, each in self.methods.items()}

    @cached_property
    def levels(self) -> dict[str, float]:
        """Thresholds at the rate of false alarms."""
        return {name: threshold(each, FALSE_ALARMS) for name, each in self.quiet.items()}

    def pressed(
        self, trial: Trial, places: tuple[int, ...], noise: tuple[int, ...], averaged: int = 1
    ) -> Values:
        """Statistics (P,) of `noisy` presses, scaled to the noise of one reading."""
        readings = noisy(trial, self.settings, places, noise, averaged) * np.sqrt(averaged)
        return {name: each(readings) for name, each in self.methods.items()}

    @cached_property
    def trials(self) -> dict[Trial, Values]:
        """Statistics (P,) of single readings."""
        trials = [Trial(place, force) for force in FORCES for place in PLACES]
        return {
            trial: self.pressed(trial, (seed,), (seed, 1))
            for seed, trial in enumerate(trials, start=100)
        }

    @cached_property
    def every(self) -> dict[tuple[str, Trial], Share]:
        """Share of every method in every trial."""
        return {
            (name, trial): share
            for trial, each in self.trials.items()
            for name, share in shares_of(self.levels, each).items()
        }

    @cached_property
    def averages(self) -> dict[str, dict[str, Floats]]:
        """Share found at 0.2 N by place and method, over `COUNTS`."""
        averages = {}
        for place in PLACES:
            trial = Trial(place, 0.2)
            every = [self.pressed(trial, (7,), (7, n), n) for n in COUNTS]
            found = [shares_of(self.levels, each) for each in every]
            averages[place] = {
                name: np.array([each[name].value for each in found])
                for name in (COARSE, OURS, RAW, KNOWN)
            }
        return averages


def detection(settings: Effort) -> Chapter:
    """Rates of detection by method, grid, indenter, place and load."""
    made = Methods(settings)
    needed = [
        f"{place} {', '.join(_needed(shares[name]) for name in (COARSE, OURS, KNOWN))}"
        for place, shares in made.averages.items()
    ]
    caption = (
        "Share of presses found with the 1.2 cm half-sphere, one reading each, at "
        f"{FALSE_ALARMS:g} false alarms per idle reading, with 95 % intervals "
        "(Wilson). Pads read their mean stress."
    )
    every = [
        {"method": name, "place": trial.place, "force (N)": trial.force, "share": share.value}
        | dict(zip(("from", "to"), share.interval, strict=True))
        for (name, trial), share in made.every.items()
    ]
    rows = [
        {"method": name}
        | {f"{t.place}, {t.force:g} N": str(made.every[name, t]) for t in made.trials}
        for name in made.methods
    ]
    return Chapter(
        title="Figures 6 and 7: contact or noise",
        claim=CLAIM,
        sentences=(
            f"{settings.presses} noisy presses per place and load; thresholds are set "
            f"on {settings.quiet} idle readings so that one in "
            f"{1 / FALSE_ALARMS:.0f} gives a false alarm. The noise of a reading is "
            f"{NOISES['stress'] / 1e3:g} kPa: chosen because there the paper's own method "
            "misses 0.2 N and finds 0.5 N over a taxel, so that agreement in these two is no "
            "evidence; all other rates are.",
            "Averaging works as long as the noise is independent from reading to reading: for "
            f"{100 * RELIABLE:.0f} % at 0.2 N it takes so many readings ({RATE:g} per "
            "second) with the paper's method, ours, and a matched filter that knows the shape: "
            f"{'; '.join(needed)}.",
        ),
        pictures=(
            _picture_of_examples(settings),
            _picture_of_rocs(made),
            _picture_of_averages(made),
        ),
        tables=(
            Table("half-sphere", caption, rows),
            Table("all", "Every share.", every, on_page=False),
        ),
        verdicts=tuple(_verdicts(made)),
    )


def _needed(shares: Floats) -> str:
    """Fewest readings to average for a reliable detection."""
    enough = np.flatnonzero(shares >= RELIABLE)
    return str(COUNTS[enough[0]]) if len(enough) else f"more than {COUNTS[-1]}"


def _verdicts(made: Methods) -> list[Claim]:
    light, firm, between = (
        made.every[COARSE, Trial(place, force)]
        for place, force in ((PLACES[0], 0.2), (PLACES[0], 0.5), (PLACES[2], 0.5))
    )
    words = [_needed(made.averages[place][COARSE]) for place in PLACES[:2]]
    chosen = "holds (the noise was chosen so)"
    return [
        Claim(
            "6",
            "0.2 N over a taxel cannot be told from noise",
            f"found {light}",
            chosen if light.interval[1] < 0.5 else "does not hold",
        ),
        Claim(
            "6",
            "filtered, 0.2 N is better but not reliable",
            f"over a taxel {100 * RELIABLE:.0f} % with {words[0]} readings averaged, between two "
            f"with {words[1]}",
            "holds" if words[0].startswith("more") else "holds only between taxels",
        ),
        Claim(
            "7",
            "0.5 N over a taxel is distinct from noise",
            f"found {firm}",
            chosen if firm.interval[0] > 0.5 else "does not hold",
        ),
        Claim(
            "7",
            "0.5 N between three taxels is less clear but identifiable",
            f"found {between} at the same noise",
            verdict_of(between.interval[0] > 0.5),
        ),
    ]


def _picture_of_examples(settings: Effort) -> Picture:
    """The paper's Figures 6 and 7: one noisy reading each, seen by three methods."""
    patch, cell = paper_patch(), settings.cell
    columns = [(PAPER, 20), (PAPER, 40), (FIELD, 40)]
    prepared = [method.prepared(n, NOISES["stress"]) for method, n in columns]
    panels = []
    for force, place in ((0.2, PLACES[0]), (0.5, PLACES[0]), (0.5, PLACES[2])):
        sited = sites()[place]
        where = sited[np.linalg.norm(sited - [6e-3, 8e-3], axis=1).argmin()]
        clean = readings(BALL, force, cell, where[None], "stress")
        rng = np.random.default_rng([settings.seed, 6])
        reading = clean[0] + rng.normal(scale=NOISES["stress"], size=len(patch))
        circle = (*where, BALL.contact_radius(force, cell))
        row = []
        for (method, nodes), reconstruct in zip(columns, prepared, strict=True):
            who = "paper" if method is PAPER else "ours"
            title = f"{force:g} N {place}: {who}, {nodes} × {nodes}"
            kpa = reconstruct(reading).pressure * 1e-3
            row.append(FieldPanel(title, reconstruct.grid, kpa, [circle]))
        panels.append(row)
    caption = (
        "One reading each with the same noise, 1.2 cm half-sphere; the black circle is the true "
        "contact. Grey circles are the pads."
    )
    return Picture.of("examples", caption, draw_fields(panels, "pressure (kPa)"))


def _picture_of_rocs(made: Methods) -> Picture:
    """Share detected against share of false alarms."""
    settings, alarms = made.settings, alarm_rates(made.settings)
    panels = [
        roc_panel(
            str(trial), "one reading", made.quiet, {name: each[name] for name in DRAWN}, alarms
        )
        for trial, each in made.trials.items()
    ]
    caption = (
        f"Receiver operating characteristics over {settings.presses} presses of the 1.2 cm "
        f"half-sphere and {settings.quiet} idle readings, one reading each. Where a curve is "
        "not to be seen, another lies on it."
    )
    return Picture.of("roc", caption, draw_panels([panels[:3], panels[3:]]))


def _picture_of_averages(made: Methods) -> Picture:
    """Share found at 0.2 N against the number of readings averaged."""
    x, presses = np.array(COUNTS, dtype=float), made.settings.presses
    scale = Scale(
        x="readings averaged", y="share of presses found", log_x=True, y_limits=(-0.02, 1.02),
        x_ticks=tuple(x[::3]), marks=True,
    )  # fmt: skip
    panels = []
    for place, shares in made.averages.items():
        ends = {
            name: np.array([wilson(round(one * presses), presses) for one in share]).T
            for name, share in shares.items()
        }
        curves = tuple(Curve(name, x, share, *ends[name]) for name, share in shares.items())
        panels.append(Panel("0.2 N", place, curves, scale))
    caption = (
        "Presses of 0.2 N found when readings with independent noise are averaged, at "
        f"{FALSE_ALARMS:g} false alarms; bands are 95 % intervals."
    )
    return Picture.of("averaging", caption, draw_panels([panels]))
