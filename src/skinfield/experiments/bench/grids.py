"""The paper's Figure 9 on this machine, and what else a reading costs on the same grids."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import cycle

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.bench import contenders
from skinfield.experiments.bench.chain import run_chain
from skinfield.experiments.bench.clock import Spread, laps, spread, undisturbed
from skinfield.experiments.bench.contenders import Contender
from skinfield.experiments.bench.scene import LEAD, Scene
from skinfield.experiments.bench.settings import FIT_DEADLINES, GAPS, BenchSettings
from skinfield.experiments.paper.algorithm import reconstruct_as_paper, stress_matrix
from skinfield.inverse import NonNegative
from skinfield.layout import Grid

PAPER, INVERSION = "paper", "paper, inversion alone"
PREPARED, FIELD = "paper's inverse, prepared", "GaussianField, prepared"
WARM_UP = -1  # the round that does not count
PAPER_REST_MS = {20: 0.4, 40: 1.4}  # as the paper states: all of it but the inversion
Show = Callable[[str, int, int], None]


@dataclass(frozen=True)
class GridTime:
    """Time per reading of one method on one grid.

    Attributes
    ----------
    nodes : int
        On a side.
    name : str
    seconds : Spread
    certified : float or None
        Share of the readings whose gap was certified as asked; None where none was.
    """

    nodes: int
    name: str
    seconds: Spread
    certified: float | None = None


@dataclass(eq=False)
class _Row:
    """A method on a grid, with the laps so far."""

    nodes: int
    name: str
    lap: Callable[[int], tuple[Floats, list[float]]]  # of a round: seconds, gaps
    target: float | None = None
    seconds: list[Floats] = field(default_factory=list)
    gaps: list[float] = field(default_factory=list)

    def take(self, turn: int) -> None:
        seconds, gaps = self.lap(turn)
        self.seconds.append(seconds)
        self.gaps.extend(gaps)

    def result(self) -> GridTime:
        found = spread(np.concatenate(self.seconds))
        assert found is not None, "a round has laps"
        share = None
        if self.target is not None:
            share = float(np.mean(np.array(self.gaps) <= self.target))
        return GridTime(self.nodes, self.name, found, share)


def grid_times(settings: BenchSettings, scene: Scene, show: Show) -> list[GridTime]:
    """Time every method on every grid, in turns."""
    size = settings.size
    rows: list[_Row] = []
    for done, nodes in enumerate(size.grids):
        show(f"preparing {nodes} x {nodes}", done, len(size.grids))
        rows.extend(_rows(settings, scene, nodes))
    for row in rows:
        show("warming up", 0, 1)
        row.lap(WARM_UP)
    for turn in range(size.rounds):
        for row in rows:
            show(f"{row.name}, {row.nodes} x {row.nodes}", turn, size.rounds)
            with undisturbed():
                row.take(turn)
    return [row.result() for row in rows]


def _rows(settings: BenchSettings, scene: Scene, nodes: int) -> Iterator[_Row]:
    yield from _paper_rows(settings, scene, nodes)
    for made in (
        contenders.paper_prepared(PREPARED, settings, nodes),
        contenders.gaussian(FIELD, settings, nodes),
    ):
        yield _Row(nodes, made.name, _repeated(made, scene, settings.size.laps))
    model, steps = contenders.model_of(settings, nodes), settings.size.steps
    for gap in GAPS:
        name = f"NonNegative to {gap:.0e}".replace("e-0", "e-")
        found = contenders.non_negative(name, model, NonNegative(tolerance=gap))
        for start in ("warm", "cold"):
            lap = _chained(found, scene, steps, None, cold=start == "cold")
            yield _Row(nodes, f"{found.name}, {start}", lap, target=gap)
    fit = contenders.contact_fit("ContactFit", model)
    for deadline in (*FIT_DEADLINES, None):
        within = "" if deadline is None else f" within {1e3 * deadline:g} ms"
        yield _Row(nodes, fit.name + within, _chained(fit, scene, steps, deadline, cold=False))


def _paper_rows(settings: BenchSettings, scene: Scene, nodes: int) -> Iterator[_Row]:
    """The algorithm as printed, all of it for every reading, and its inversion alone."""
    patch, layer = settings.patch, settings.layer
    grid = Grid.square(patch, nodes=nodes)
    plane, area = grid.plane, grid.cell_area
    matrix = stress_matrix(plane[:, None] - plane[None], layer.thickness)
    count = -(-settings.size.paper_laps // settings.size.rounds)
    readings = cycle(scene.readings)

    def whole() -> object:
        return reconstruct_as_paper(next(readings), patch.plane, plane, layer, area)

    def invert() -> object:
        return np.linalg.inv(matrix)

    for name, work in ((PAPER, whole), (INVERSION, invert)):
        yield _Row(nodes, name, _counted(work, count))


def _counted(work: Callable[[], object], count: int) -> Callable[[int], tuple[Floats, list[float]]]:
    """Laps of what has no gap; one alone to warm up."""
    return lambda turn: (laps(work, 1 if turn == WARM_UP else count), [])


def _repeated(
    made: Contender, scene: Scene, count: int
) -> Callable[[int], tuple[Floats, list[float]]]:
    """Laps of a method that takes equally long for every reading."""
    reading = scene.readings[LEAD]
    return _counted(lambda: made.answer(reading, None), count)


def _chained(
    made: Contender, scene: Scene, steps: int, deadline: float | None, *, cold: bool
) -> Callable[[int], tuple[Floats, list[float]]]:
    """Readings in order, others in each round."""

    def lap(turn: int) -> tuple[Floats, list[float]]:
        chain = run_chain(made, scene.part(turn, steps), deadline, cold=cold)
        return chain.seconds, [answer.gap for answer in chain.answers]

    return lap
