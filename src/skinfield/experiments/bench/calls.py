"""Whole calls of a `Reconstructor`, with what its estimates say of themselves."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.bench.clock import Spread, spread, undisturbed
from skinfield.experiments.bench.scene import LEAD, Scene
from skinfield.experiments.bench.settings import BenchSettings
from skinfield.inverse import ContactFit, GaussianField, NonNegative, Solver
from skinfield.layout import Grid
from skinfield.pipeline import Reconstructor

SOLVERS: dict[str, Solver] = {
    "GaussianField": GaussianField(),
    "NonNegative": NonNegative(),
    "ContactFit": ContactFit(),
}
Show = Callable[[str, int, int], None]


@dataclass(frozen=True, kw_only=True)
class Call:
    """`rec(readings, deadline=...)` of one solver at one deadline, warm.

    Attributes
    ----------
    solver : str
    deadline : float or None, s
    seconds : Spread
        By the clock outside of the call.
    latency : Spread or None
        As `Estimate.latency` says.
    gap : Spread or None
        As `Estimate.gap` says.
    told : float
        Share of the estimates whose `deadline_met` is true.
    late : Spread or None, s
        By how much calls ended after the deadline, by the clock outside; 0 where before.
    """

    solver: str
    deadline: float | None
    seconds: Spread | None
    latency: Spread | None
    gap: Spread | None
    told: float
    late: Spread | None


@dataclass(eq=False)
class _Calls:
    solver: str
    rec: Reconstructor
    deadline: float | None
    rows: list[tuple[float, float, float, bool]]  # seconds, latency, gap, met

    def take(self, readings: Floats) -> None:
        """Call for all readings in order; the first do not count."""
        self.rec.reset()
        for index, reading in enumerate(readings):
            start = time.perf_counter_ns()
            estimate = self.rec(reading, deadline=self.deadline)
            spent = (time.perf_counter_ns() - start) * 1e-9
            if index >= LEAD:
                said = (estimate.latency, float(estimate.gap), bool(estimate.deadline_met))
                self.rows.append((spent, *said))

    def result(self) -> Call:
        seconds, latency, gap, told = np.array(self.rows, dtype=np.float64).T
        late = None if self.deadline is None else spread(np.maximum(seconds - self.deadline, 0))
        return Call(
            solver=self.solver,
            deadline=self.deadline,
            seconds=spread(seconds),
            latency=spread(latency),
            gap=spread(gap),
            told=float(told.mean()),
            late=late,
        )


def whole_calls(settings: BenchSettings, scene: Scene, show: Show) -> list[Call]:
    """Call every solver at every deadline, in turns, in another order each round."""
    todo = []
    for done, (name, solver) in enumerate(SOLVERS.items()):
        show("preparing reconstructors", done, len(SOLVERS))
        rec = Reconstructor(
            settings.patch,
            settings.layer,
            Grid.square(settings.patch, nodes=settings.size.nodes),
            quantity=settings.quantity,
            solver=solver,
            noise_std=settings.noise,
        )
        ladder = () if isinstance(solver, GaussianField) else settings.size.deadlines
        todo += [_Calls(name, rec, deadline, []) for deadline in (*ladder, None)]
    rng, rounds = np.random.default_rng(settings.seed), settings.size.rounds
    for turn in range(rounds):
        for done, which in enumerate(rng.permutation(len(todo))):
            show(f"calls, round {turn + 1} of {rounds}", done, len(todo))
            with undisturbed():
                todo[which].take(scene.part(turn, settings.size.steps))
    return [each.result() for each in todo]
