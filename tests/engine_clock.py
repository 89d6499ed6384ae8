"""Engines by a clock that is told what searches take."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

import skinfield as sf
from skinfield.skin import generators
from skinfield.solve.operator import Data, FieldOperator, Solution

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
    """Solver whose search takes the time that it is told, over cycles where it must."""

    clock: Clock
    seconds: dict[int, float]
    slower: dict[str, float] = field(default_factory=lambda: {"factor": 1.0})

    def prepare(self, model: Any) -> "ToldOperator":
        return ToldOperator(self, model)


class ToldData(Data):
    def __init__(self, operator: "ToldOperator") -> None:
        super().__init__(operator, len(operator.model.grid))
        self.first, self.started, self.spent = 0.0, list[float](), 0

    def start_from(self, other: Any) -> None:
        self.started.append(other.first)


class ToldOperator(FieldOperator):
    linear = None

    def __init__(self, told: Told, model: Any) -> None:
        self.solver, self.model, self.field = told, model, sf.GaussianField().prepare(model)
        rows = (model.matrix / model.noise_std[:, None]).T
        norms = np.linalg.norm(rows, axis=1)
        self.problem = SimpleNamespace(
            rows=rows,
            unshared=rows,
            offset=np.zeros(rows.shape[1]),
            root=np.zeros(rows.shape[1]),
            shared=np.zeros(len(rows)),
            norms=norms,
            threshold=5.0,
            tolerance=1e-3,
        )
        self.posterior, self.noise = self.field.posterior, self.field.noise
        self.model_error, self.pressure_std = self.field.model_error, self.field.pressure_std

    def data(self) -> ToldData:
        return ToldData(self)

    def solve(self, readings: Any, data: Any, deadline_ns: int | None = None) -> Solution:
        clock, nodes = self.solver.clock, self.model.grid.shape[0]
        needed = round(1e9 * self.solver.seconds[nodes] * self.solver.slower["factor"])
        needed = max(needed - data.spent, 0)
        in_time = deadline_ns is None or clock.now + needed <= deadline_ns
        took = needed if in_time else max(int(deadline_ns or 0) - clock.now, 0)
        clock.now, data.spent = clock.now + took, 0 if in_time else data.spent + took
        solution: Solution = data.solution
        solution.gap, solution.steps, solution.objective = (
            *((1e-4, 3) if in_time else (0.5, 1)),
            1.0,
        )
        solution.pressure[:], data.first = 1.0, float(readings[0])
        return solution

    def predicted(self, solution: Solution) -> Any:
        return self.model.matrix @ solution.pressure

    def without(self, valid: Any) -> "ToldOperator":
        return self


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
