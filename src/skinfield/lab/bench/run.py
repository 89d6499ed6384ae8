"""Benchmark run: cost of a reading on several grids, and error against time."""

import gc
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from itertools import cycle
from typing import Any

import numpy as np

from skinfield.errors import Floats
from skinfield.lab.bench.machine import Watch, laps, spread, this_machine, undisturbed, warnings
from skinfield.lab.bench.scene import (
    FIT_DEADLINES,
    GAPS,
    LEAD,
    BenchScene,
    BenchSize,
    Contender,
    Laps,
    gaussian,
    iterative,
    make_scene,
    model_of,
    paper_prepared,
    run_chain,
)
from skinfield.lab.cases import TrueContact
from skinfield.lab.paper import LAYER, paper_patch, reconstruct_as_paper, stress_matrix
from skinfield.lab.score import matched
from skinfield.skin import Grid
from skinfield.solve import ContactFit, NonNegative

CONVERGED = NonNegative(tolerance=1e-9, precision=np.float64)  # what others are compared with
LONG = NonNegative(tolerance=2e-6)  # goes on while there is time
FIT = ContactFit()
PAPER, INVERSION = "paper", "paper, inversion alone"
PREPARED, FIELD = "paper's inverse, prepared", "GaussianField, prepared"
PAPER_REST_MS = {20: 0.4, 40: 1.4}  # as the paper states: all of it but the inversion
STARTS = ("warm", "cold")
US, MM = 1e6, 1e3  # per s, per m
FORMAT = 1
Row = dict[str, Any]  # with the unit in each key's name, as JSON has it
Show = Callable[[str, int, int], None]
Lap = Callable[[int], tuple[Floats, list[float]]]  # of a round: seconds, gaps
Method = tuple[str, Lap, float | None]  # name, laps, and the gap that is certified, if any


def quietly(what: str, ended: int, of: int) -> None:
    """Show nothing of the progress."""


def grid_rows(
    size: BenchSize, methods_on: Callable[[int], Iterable[Method]], show: Show = quietly
) -> list[Row]:
    """Time of every method on every grid, in turns."""
    methods: list[tuple[Row, Lap, float | None]] = []
    for ended, nodes in enumerate(size.grids):
        show(f"preparing {nodes} x {nodes}", ended, len(size.grids))
        methods += [
            ({"nodes": nodes, "name": name}, lap, target) for name, lap, target in methods_on(nodes)
        ]
    for _, lap, _ in methods:
        show("warming up", 0, 1)
        lap(-1)
    rounds: list[list[tuple[Floats, list[float]]]] = [[] for _ in methods]
    for turn in range(size.rounds):
        for (head, lap, _), taken in zip(methods, rounds, strict=True):
            show(f"{head['name']}, {head['nodes']} x {head['nodes']}", turn, size.rounds)
            with undisturbed():
                taken.append(lap(turn))
    rows = []
    for (head, _, target), taken in zip(methods, rounds, strict=True):
        gaps = [gap for _, each in taken for gap in each]
        share = None if target is None else float(np.mean(np.array(gaps) <= target))
        seconds = spread(np.concatenate([each for each, _ in taken]), US)
        rows.append(head | {"seconds_us": seconds, "certified": share})
    return rows


def _methods(size: BenchSize, scene: BenchScene, nodes: int) -> Iterator[Method]:
    yield from methods_of_paper(size, scene.readings, nodes)
    made = gaussian(FIELD, nodes)
    yield FIELD, _counted(lambda: made.answer(scene.readings[LEAD], None), size.laps), None
    model = model_of(nodes)
    for gap in GAPS:
        name = f"NonNegative to {gap:.0e}".replace("e-0", "e-")
        found = iterative(name, model, NonNegative(tolerance=gap))
        for start in STARTS:
            yield f"{name}, {start}", _chained(found, scene, size.steps, None, start), gap
    fit = iterative("ContactFit", model, FIT)
    for deadline in (*FIT_DEADLINES, None):
        within = "" if deadline is None else f" within {1e3 * deadline:g} ms"
        yield fit.name + within, _chained(fit, scene, size.steps, deadline, "warm"), None


def methods_of_paper(size: BenchSize, readings: Floats, nodes: int) -> Iterator[Method]:
    """The paper's algorithm for every reading (T, L), its inversion alone, and prepared once."""
    patch = paper_patch()
    grid = Grid.square(patch, nodes=nodes)
    plane, area = grid.plane, grid.cell_area
    matrix = stress_matrix(plane[:, None] - plane[None], LAYER.thickness)
    count = -(-size.paper_laps // size.rounds)
    turns, made = cycle(readings), paper_prepared(PREPARED, nodes)

    def whole() -> object:
        return reconstruct_as_paper(next(turns), patch.plane, plane, LAYER, area)

    yield PAPER, _counted(whole, count), None
    yield INVERSION, _counted(lambda: np.linalg.inv(matrix), count), None
    yield PREPARED, _counted(lambda: made.answer(readings[-1], None), size.laps), None


def _counted(work: Callable[[], object], count: int) -> Lap:
    """Laps of what has no gap; one alone to warm up."""
    return lambda turn: (laps(work, 1 if turn < 0 else count), [])


def _chained(
    made: Contender, scene: BenchScene, steps: int, deadline: float | None, start: str
) -> Lap:
    """Readings in order, others in each round."""

    def lap(turn: int) -> tuple[Floats, list[float]]:
        chain = run_chain(made, scene.part(turn, steps), deadline, cold=start == "cold")
        return chain.seconds, [answer.gap for answer in chain.answers]

    return lap


@dataclass(eq=False)
class ContenderRun:
    """A contender at one deadline, with the chains so far.

    Parameters
    ----------
    contender : Contender
    start : str
        "warm" from the reading before, "cold" from nothing.
    deadline : float, s, or None
    reference : (T, K) array, Pa
        What the solver converges to.
    """

    contender: Contender
    start: str
    deadline: float | None
    reference: Floats
    chains: list[Laps] = field(default_factory=list)

    def run(self, readings: Floats) -> None:
        """Answer readings in order."""
        cold = self.start == "cold"
        with undisturbed():
            chain = run_chain(self.contender, readings, self.deadline, cold=cold)
        self.chains.append(chain)

    def point(self, scene: BenchScene) -> Row:
        """Times, and errors to the converged pressure and to the truth, of the first chain."""
        seconds = np.array([chain.seconds for chain in self.chains])  # (rounds, T)
        found = np.array([[a.pressure for a in chain.answers] for chain in self.chains])
        off = np.linalg.norm(found - self.reference, axis=2)  # (rounds, T)
        norm = np.linalg.norm(self.reference, axis=1)
        misses = [
            miss(scene.places[index], scene.forces[index], answer.contacts())
            for index, answer in enumerate(self.chains[0].answers, start=LEAD)
        ]
        force, places, missed = zip(*misses, strict=True)
        distances = [distance for each in places for distance in each]
        return {
            "solver": self.contender.name,
            "start": self.start,
            "deadline_us": None if self.deadline is None else float(f"{self.deadline * US:.6g}"),
            "seconds_us": spread(seconds, US),
            "usual_seconds_us": spread(np.median(seconds, axis=0), US),
            "gap": spread([answer.gap for chain in self.chains for answer in chain.answers]),
            "errors": spread(off / norm),
            "usual_errors": spread(np.median(off / norm, axis=0)),
            "force": spread(force),
            "place_median_mm": median_of_all(distances, sum(missed), MM),
            "missed": float(np.mean(missed)),
        }


def miss(
    places: Floats, forces: Floats, contacts: Sequence[Any]
) -> tuple[float, tuple[float, ...], int]:
    """Errors of contacts on the paper's patch, of fingers at places (F, 2) m with forces (F,) N.

    Returns
    -------
    force : float
        Of the sum over all contacts, without sign, part of the true one.
    place : tuple of float, m
        Distance of each finger that was found.
    missed : int
        Fingers that were not found.
    """
    true = [
        TrueContact((float(x), float(y)), float(force))
        for (x, y), force in zip(places, forces, strict=True)
    ]
    matches, missed, _ = matched(paper_patch(), true, contacts)
    total, found = float(forces.sum()), sum(contact.normal_force for contact in contacts)
    return abs(found / total - 1), tuple(m.distance for m in matches), missed


def median_of_all(found: Sequence[float], missed: int, scale: float = 1.0) -> float | None:
    """Median of numbers and of so many that are infinite; None if it is infinite."""
    middle = float(np.median([*found, *[np.inf] * missed]))
    return scale * middle if np.isfinite(middle) else None


def anytime(size: BenchSize, seed: int, scene: BenchScene, show: Show) -> list[Row]:
    """Every solver at every deadline, in turns of a random order, beside what it converges to."""
    nodes, ladder = size.nodes, (*size.deadlines, None)
    model = model_of(nodes)

    def converged(contender: Contender, start: str) -> Floats:
        chain = run_chain(contender, scene.readings, None, cold=start == "cold")
        return np.array([answer.pressure for answer in chain.answers])

    show("preparing", 0, 3)
    linear = gaussian("GaussianField", nodes), paper_prepared(PAPER, nodes)
    tracks = [ContenderRun(each, "warm", None, converged(each, "cold")) for each in linear]
    show("preparing", 1, 3)
    exact = converged(iterative("converged", model, CONVERGED), "cold")
    field_solver = iterative("NonNegative", model, LONG)
    tracks += [
        ContenderRun(field_solver, s, deadline, exact) for s in STARTS for deadline in ladder
    ]
    show("preparing", 2, 3)
    fit = iterative("ContactFit", model, FIT)
    own = {start: converged(fit, start) for start in STARTS}
    tracks += [ContenderRun(fit, s, deadline, own[s]) for s in STARTS for deadline in ladder]
    rng, rounds = np.random.default_rng(seed), size.rounds
    for turn in range(rounds):
        for ended, which in enumerate(rng.permutation(len(tracks))):
            show(f"any-time, round {turn + 1} of {rounds}", ended, len(tracks))
            tracks[which].run(scene.readings)
    return [track.point(scene) for track in tracks]


def run_bench(size: BenchSize, seed: int = 0, show: Show = quietly) -> dict[str, Any]:
    """Press, prepare and time everything; nothing else should run meanwhile.

    Parameters
    ----------
    size : BenchSize
    seed : int
        Of the noise and of the order in which contenders take turns.
    show : function of (what, ended, of)
        Called as it goes on.

    Returns
    -------
    dict
        Numbers, texts, lists and objects alone; times in µs and places in mm, as their keys say.
    """
    when = datetime.now(UTC).isoformat(timespec="seconds")
    machine = this_machine()
    scene = make_scene(size, seed, lambda ended, of: show("pressing two fingers", ended, of))
    gc.collect()
    gc.freeze()  # each `undisturbed` collects, which takes long with all that is there by now
    try:
        watch = Watch()
        grids = grid_rows(size, lambda nodes: _methods(size, scene, nodes), show)
        points = anytime(size, seed, scene, show)
        company = watch.company()
    finally:
        gc.unfreeze()
    return {
        "format": FORMAT,
        "size": size.name,
        "seed": seed,
        "when": when,
        "machine": machine,
        "company": company,
        "warnings": warnings(company, machine["cores"]),
        "nodes": size.nodes,
        "readings": len(scene),
        "grids": grids,
        "points": as_printed(points, grids, size.nodes),
    }


def as_printed(points: list[Row], grids: list[Row], nodes: int) -> list[Row]:
    """Points where the paper's has the time of its algorithm, all of it for every reading.

    Its answers are those of the same inverse prepared once, but for taxels on one circle, between
    which there are two Delaunay triangulations.
    """
    times = {each["nodes"]: each["seconds_us"] for each in grids if each["name"] == PAPER}
    whole = {"start": "cold", **dict.fromkeys(("seconds_us", "usual_seconds_us"), times[nodes])}
    return [point | whole if point["solver"] == PAPER else point for point in points]


def prepared_gain(grids: Sequence[Row], nodes: int) -> float:
    """How many times the paper's algorithm takes the prepared operator's time, by medians."""
    times = {row["name"]: row["seconds_us"]["p50"] for row in grids if row["nodes"] == nodes}
    return float(times[PAPER] / times[PREPARED])
