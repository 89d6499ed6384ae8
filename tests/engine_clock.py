"""Engines by a clock that is told what searches take."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

import skinfield as sf
from skinfield.skin import generators

NOISE = 0.002
PATCH = generators.icub_triangle()


class Clock:
    """Time that passes when something says so, and a little whenever one looks."""

    def __init__(self, look: int = 100) -> None:
        self.now, self.look = 0, look

    def __call__(self) -> int:
        self.now += self.look
        return self.now


@dataclass(frozen=True)
class Told:
    """Solver whose search takes the time that it is told, and gains nothing before that."""

    clock: Clock
    seconds: dict[int, float]
    slower: dict[str, float] = field(default_factory=lambda: {"factor": 1.0})

    def prepare(self, model: Any) -> "ToldOperator":
        linear = sf.GaussianField().prepare(model)
        rows = (model.matrix / model.noise_std[:, None]).T
        norms = np.linalg.norm(rows, axis=1)
        problem = SimpleNamespace(
            rows=rows,
            unshared=rows,
            offset=np.zeros(rows.shape[1]),
            norms=norms,
            whitening=1.0 / model.noise_std,
            threshold=5.0,
            tolerance=1e-3,
        )
        return ToldOperator(self, model.grid.shape[0], problem, linear)


class ToldOperator:
    def __init__(self, told: Told, nodes: int, problem: Any, linear: Any) -> None:
        self.told, self.nodes, self.problem, self.linear = told, nodes, problem, linear
        self.gap, self.objective, self.iterations = 1.0, 1.0, 0
        self.dual = np.zeros(len(problem.whitening))
        self.started: list[float] = []
        self.pressure_std, self.posterior = linear.pressure_std, linear.posterior
        self.model_error = linear.model_error
        self.noise = sf.estimate.PressureNoise(linear.matrix * NOISE)

    def apply(self, readings: Any, out: Any, deadline_ns: int | None = None) -> None:
        clock = self.told.clock
        needed = round(1e9 * self.told.seconds[self.nodes] * self.told.slower["factor"])
        in_time = deadline_ns is None or clock.now + needed <= deadline_ns
        clock.now = clock.now + needed if in_time else max(clock.now, int(deadline_ns or 0))
        self.gap, self.iterations = (1e-4, 3) if in_time else (0.5, 1)
        out[:] = 1.0
        problem = self.problem
        self.idle = bool((problem.rows @ readings <= 5.0 * NOISE * problem.norms).all())
        self.dual[:] = readings

    def start_from(self, dual: Any) -> None:
        self.started.append(float(dual[0]))

    def twin(self) -> "ToldOperator":
        return ToldOperator(self.told, self.nodes, self.problem, self.linear)

    def without(self, valid: Any) -> "ToldOperator":
        arrays = {name: np.array(value) for name, value in vars(self.problem).items()}
        return ToldOperator(self.told, self.nodes, SimpleNamespace(**arrays), self.linear)

    def leave_out(self, whole: Any, valid: Any) -> None: ...

    def reset(self) -> None:
        self.dual[:] = 0.0


COSTS = {4: 20e-6, 8: 60e-6, 16: 200e-6}


def engine_of(patches: int, budget: float, costs: dict[int, float] = COSTS) -> sf.Engine:
    clock = Clock()
    skin = sf.Skin(tuple(replace(PATCH, name=f"p{i}") for i in range(patches)))
    solver = Told(clock, costs)
    rungs = tuple(costs)
    return sf.Engine(skin, budget=budget, rungs=rungs, solver=solver, noise_std=NOISE, clock=clock)


def readings_of(engine: sf.Engine, hot: set[int], strength: float = 40.0) -> dict[str, Any]:
    touch = np.zeros(len(PATCH))
    touch[0] = strength * NOISE
    return {name: touch * (i in hot) for i, name in enumerate(engine.names)}
