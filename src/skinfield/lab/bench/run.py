"""Benchmark run: error against time at a ladder of deadlines, costs, and their JSON."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.estimate import Contact
from skinfield.lab.bench.costs import (
    CONVERGED,
    LONG,
    PAPER,
    Call,
    Chain,
    Contender,
    GridTime,
    Show,
    contact_fit,
    gaussian,
    grid_times,
    model_of,
    non_negative,
    paper_prepared,
    run_chain,
    whole_calls,
)
from skinfield.lab.bench.machine import (
    Company,
    Machine,
    Spread,
    Watch,
    settled,
    spread,
    this_machine,
    undisturbed,
)
from skinfield.lab.bench.scene import LEAD, BenchSettings, Scene, make_scene
from skinfield.lab.cases import TrueContact
from skinfield.lab.score import matched
from skinfield.skin import Patch


@dataclass(frozen=True)
class Miss:
    """Errors of the contacts of one reading.

    Attributes
    ----------
    force : float
        Of the sum over all contacts, without sign, part of the true one.
    place : tuple of float, m
        Distance of each finger that was found.
    missed, extra : int
        Fingers that were not found, contacts that are none.
    """

    force: float
    place: tuple[float, ...]
    missed: int
    extra: int


def miss(patch: Patch, places: Floats, forces: Floats, contacts: Sequence[Contact]) -> Miss:
    """Compare contacts with fingers at places (F, 2) m with forces (F,) N."""
    true = [
        TrueContact((float(x), float(y)), float(force))
        for (x, y), force in zip(places, forces, strict=True)
    ]
    matches, missed, extra = matched(patch, true, contacts)
    total, found = float(forces.sum()), sum(contact.normal_force for contact in contacts)
    return Miss(abs(found / total - 1), tuple(m.distance for m in matches), missed, extra)


STARTS = ("warm", "cold")


@dataclass(frozen=True, kw_only=True)
class Point:
    """A contender at one deadline.

    Attributes
    ----------
    solver : str
    start : str
        "warm" from the reading before, "cold" from nothing.
    deadline : float or None, s
    seconds, late : Spread
        Of the calls; and by how much they ended after the deadline, 0 where before.
    usual_seconds : Spread
        Of the readings, each with its median over the rounds: less of what else the machine did.
    met : float or None
        Share of the calls that ended before the deadline.
    reported : float or None
        Share of which the solver itself says that the deadline did not cut it short.
    error : float
        Root of the sum of squares, over all readings and nodes, of the pressure less the
        converged one, part of that of the converged one.
    errors, usual_errors, gap : Spread or None
        The same call by call; reading by reading, by its median; the certified relative gap.
    iterations : Spread or None
    force, place : Spread or None
        Error of the sum of all contacts' forces, part of the true one; distance to the fingers
        that were found, m.
    place_median : float or None, m
        Of all fingers, where one that was not found is infinitely far; None if most were not.
    missed, extra : float
        Fingers not found and contacts that are none, per reading.
    """

    solver: str
    start: str
    deadline: float | None
    seconds: Spread | None
    usual_seconds: Spread | None
    late: Spread | None
    met: float | None
    reported: float | None
    error: float
    errors: Spread | None
    usual_errors: Spread | None
    gap: Spread | None
    iterations: Spread | None
    force: Spread | None
    place: Spread | None
    place_median: float | None
    missed: float
    extra: float


@dataclass(eq=False)
class _Track:
    """A contender at one deadline, with what came so far."""

    contender: Contender
    start: str
    deadline: float | None
    reference: Floats  # (T, K) converged pressure
    seconds: list[Floats] = field(default_factory=list)
    off: list[Floats] = field(default_factory=list)  # (T,) norms of the difference
    gaps: list[float] = field(default_factory=list)
    reported: list[bool] = field(default_factory=list)
    iterations: list[int] = field(default_factory=list)
    misses: list[Miss] = field(default_factory=list)

    def take(self, chain: Chain, scene: Scene, settings: BenchSettings) -> None:
        """Add a chain; contacts are judged in the first alone."""
        answers = chain.answers
        self.seconds.append(chain.seconds)
        pressure = np.array([answer.pressure for answer in answers])
        self.off.append(np.linalg.norm(pressure - self.reference, axis=1))
        self.gaps += [answer.gap for answer in answers]
        self.reported += [answer.met for answer in answers if answer.met is not None]
        self.iterations += [a.iterations for a in answers if a.iterations is not None]
        if self.misses:
            return
        for index, answer in enumerate(answers, start=LEAD):
            found = answer.contacts
            found = self.contender.contacts(answer.pressure) if found is None else found
            places, forces = scene.places[index], scene.forces[index]
            self.misses.append(miss(settings.patch, places, forces, found))

    def point(self) -> Point:
        """What all chains come to."""
        seconds, off = np.array(self.seconds), np.array(self.off)  # (rounds, T)
        norm = np.linalg.norm(self.reference, axis=1)
        late = None if self.deadline is None else np.maximum(seconds - self.deadline, 0.0)
        distances = [distance for each in self.misses for distance in each.place]
        return Point(
            solver=self.contender.name,
            start=self.start,
            deadline=self.deadline,
            seconds=spread(seconds),
            usual_seconds=spread(np.median(seconds, axis=0)),
            late=None if late is None else spread(late),
            met=None if late is None else float(np.mean(late == 0.0)),
            reported=float(np.mean(self.reported)) if self.reported else None,
            error=float(np.sqrt(np.square(off).sum() / (len(off) * np.square(norm).sum()))),
            errors=spread(off / norm),
            usual_errors=spread(np.median(off / norm, axis=0)),
            gap=spread(self.gaps),
            iterations=spread(self.iterations),
            force=spread([each.force for each in self.misses]),
            place=spread(distances),
            place_median=median_of_all(distances, sum(each.missed for each in self.misses)),
            missed=float(np.mean([each.missed for each in self.misses])),
            extra=float(np.mean([each.extra for each in self.misses])),
        )


def median_of_all(found: list[float], missed: int) -> float | None:
    """Median of numbers and of so many that are infinite; None if it is infinite."""
    middle = float(np.median([*found, *[np.inf] * missed]))
    return middle if np.isfinite(middle) else None


def anytime(settings: BenchSettings, scene: Scene, show: Show) -> list[Point]:
    """Run all contenders at all deadlines, in turns, in another order each round."""
    tracks = _tracks(settings, scene, show)
    rng, rounds = np.random.default_rng(settings.seed), settings.size.rounds
    for turn in range(rounds):
        for done, which in enumerate(rng.permutation(len(tracks))):
            track = tracks[which]
            show(f"any-time, round {turn + 1} of {rounds}", done, len(tracks))
            with undisturbed():
                cold = track.start == "cold"
                chain = run_chain(track.contender, scene.readings, track.deadline, cold=cold)
            track.take(chain, scene, settings)
    return [track.point() for track in tracks]


def _tracks(settings: BenchSettings, scene: Scene, show: Show) -> list[_Track]:
    """Prepare all contenders and what they converge to."""
    nodes, ladder = settings.size.nodes, (*settings.size.deadlines, None)
    model = model_of(settings, nodes)
    show("preparing", 0, 3)
    linear = [
        gaussian("GaussianField", settings, nodes),
        paper_prepared("paper", settings, nodes),
    ]
    tracks = [_Track(each, "warm", None, _converged(each, scene, "cold")) for each in linear]
    show("preparing", 1, 3)
    field_solver = non_negative("NonNegative", model, LONG)
    exact = _converged(non_negative("converged", model, CONVERGED), scene, "cold")
    tracks += _laddered(field_solver, ladder, dict.fromkeys(STARTS, exact))
    show("preparing", 2, 3)
    fit = contact_fit("ContactFit", model)
    own = {start: _converged(fit, scene, start) for start in STARTS}
    return tracks + _laddered(fit, ladder, own)


def _laddered(
    contender: Contender, ladder: Sequence[float | None], reference: dict[str, Floats]
) -> list[_Track]:
    return [
        _Track(contender, start, deadline, reference[start])
        for start in STARTS
        for deadline in ladder
    ]


def _converged(contender: Contender, scene: Scene, start: str) -> Floats:
    """Pressure (T, K) without a deadline."""
    chain = run_chain(contender, scene.readings, None, cold=start == "cold")
    return np.array([answer.pressure for answer in chain.answers])


def say_nothing(what: str, done: int, of: int) -> None:
    """Progress that nobody wants to see."""


@dataclass(frozen=True, kw_only=True)
class Bench:
    """All that was measured.

    Attributes
    ----------
    size : str
    seed : int
    when : str
        UTC, when it began.
    machine : Machine
    company : Company
        Who else used the processor while times were taken.
    warnings : tuple of str
    nodes : int
        On a side, of the any-time curves and the calls.
    readings : int
        Of the moving press.
    grids : tuple of GridTime
    points : tuple of Point
    calls : tuple of Call
    """

    size: str
    seed: int
    when: str
    machine: Machine
    company: Company
    warnings: tuple[str, ...]
    nodes: int
    readings: int
    grids: tuple[GridTime, ...]
    points: tuple[Point, ...]
    calls: tuple[Call, ...]


def run_bench(settings: BenchSettings, show: Show = say_nothing) -> Bench:
    """Press, prepare and time everything; nothing else should run meanwhile.

    Parameters
    ----------
    settings : BenchSettings
    show : function of (what, done, of)
        Called as it goes on.
    """
    when = datetime.now(UTC).isoformat(timespec="seconds")
    machine = this_machine()
    scene = make_scene(settings, lambda done, of: show("pressing two fingers", done, of))
    with settled():
        watch = Watch()
        grids = grid_times(settings, scene, show)
        points = anytime(settings, scene, show)
        calls = whole_calls(settings, scene, show)
        company = watch.company()
    return Bench(
        size=settings.size.name,
        seed=settings.seed,
        when=when,
        machine=machine,
        company=company,
        warnings=company.warnings(machine.cores),
        nodes=settings.size.nodes,
        readings=len(scene),
        grids=tuple(grids),
        points=tuple(as_printed(points, grids, settings.size.nodes)),
        calls=tuple(calls),
    )


def as_printed(points: list[Point], grids: list[GridTime], nodes: int) -> list[Point]:
    """Points where the paper's has the time of its algorithm, all of it for every reading.

    Its answers are those of the same inverse prepared once, but for taxels on one circle, between
    which there are two Delaunay triangulations.
    """
    times = {each.nodes: each.seconds for each in grids if each.name == PAPER}
    return [
        replace(point, seconds=times[nodes], usual_seconds=times[nodes], start="cold")
        if point.solver == PAPER
        else point
        for point in points
    ]


FORMAT = 1
UNITS = {
    **dict.fromkeys(("seconds", "usual_seconds", "late", "latency", "deadline"), "us"),
    **dict.fromkeys(("place", "place_median"), "mm"),
}
FACTORS = {"us": 1e6, "mm": 1e3}


def bench_as_json(bench: Bench) -> dict[str, Any]:
    """Numbers, texts, lists and objects alone; times in µs and places in mm, as their keys say."""
    return {"format": FORMAT, **_converted(asdict(bench))}


def _converted(value: Any) -> Any:
    if isinstance(value, dict):
        return dict(_converted_item(key, each) for key, each in value.items())
    if isinstance(value, list | tuple):
        return [_converted(each) for each in value]
    return value


def _converted_item(key: str, value: Any) -> tuple[str, Any]:
    """A key with its unit, and what it holds in that unit."""
    unit = UNITS.get(key)
    if unit is None:
        return key, _converted(value)
    return f"{key}_{unit}", _scaled(value, FACTORS[unit])


def _scaled(value: Any, factor: float) -> Any:
    """Six digits: more is noise."""
    if isinstance(value, dict):  # a spread
        return {
            name: each if name == "count" else _scaled(each, factor) for name, each in value.items()
        }
    return None if value is None else float(f"{value * factor:.6g}")
