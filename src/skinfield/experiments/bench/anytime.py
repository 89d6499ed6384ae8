"""Error against time: chains of readings at a ladder of deadlines."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.bench import contenders
from skinfield.experiments.bench.chain import Chain, run_chain
from skinfield.experiments.bench.clock import Spread, spread, undisturbed
from skinfield.experiments.bench.contenders import CONVERGED, LONG, Contender
from skinfield.experiments.bench.scene import LEAD, Scene
from skinfield.experiments.bench.settings import BenchSettings
from skinfield.experiments.bench.truth import Miss, miss

STARTS = ("warm", "cold")
Show = Callable[[str, int, int], None]


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
    told : float or None
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
    told: float | None
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
    told: list[bool] = field(default_factory=list)
    iterations: list[int] = field(default_factory=list)
    misses: list[Miss] = field(default_factory=list)

    def take(self, chain: Chain, scene: Scene, settings: BenchSettings) -> None:
        """Add a chain; contacts are judged in the first alone."""
        answers = chain.answers
        self.seconds.append(chain.seconds)
        pressure = np.array([answer.pressure for answer in answers])
        self.off.append(np.linalg.norm(pressure - self.reference, axis=1))
        self.gaps += [answer.gap for answer in answers]
        self.told += [answer.met for answer in answers if answer.met is not None]
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
            told=float(np.mean(self.told)) if self.told else None,
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
    model = contenders.model_of(settings, nodes)
    show("preparing", 0, 3)
    linear = [
        contenders.gaussian("GaussianField", settings, nodes),
        contenders.paper_prepared("paper", settings, nodes),
    ]
    tracks = [_Track(each, "warm", None, _converged(each, scene, "cold")) for each in linear]
    show("preparing", 1, 3)
    field_solver = contenders.non_negative("NonNegative", model, LONG)
    exact = _converged(contenders.non_negative("converged", model, CONVERGED), scene, "cold")
    tracks += _laddered(field_solver, ladder, dict.fromkeys(STARTS, exact))
    show("preparing", 2, 3)
    fit = contenders.contact_fit("ContactFit", model)
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
