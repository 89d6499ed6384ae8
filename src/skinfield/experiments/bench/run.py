"""One run from nothing to numbers."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from skinfield.experiments.bench.anytime import Point, anytime
from skinfield.experiments.bench.calls import Call, whole_calls
from skinfield.experiments.bench.clock import settled
from skinfield.experiments.bench.grids import PAPER, GridTime, grid_times
from skinfield.experiments.bench.machine import Company, Machine, Watch, this_machine
from skinfield.experiments.bench.scene import make_scene
from skinfield.experiments.bench.settings import BenchSettings

Show = Callable[[str, int, int], None]


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
