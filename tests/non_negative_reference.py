"""The problem of `NonNegative` as dense algebra from its docstring, and its minimum by scipy."""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import nnls
from scipy.special import ndtri

from skinfield.elastic import BaseStress, BondedLayer, Capacitance, Layer, ObservationModel
from skinfield.errors import Floats
from skinfield.skin import Grid
from skinfield.solve import NonNegative
from skinfield.solve.contract import square_patch
from skinfield.solve.dual.problem import AMOUNT, COUNTS, PRESSED, PRESSING
from skinfield.solve.linear import taxel_distance
from skinfield.solve.non_negative import MODEL_ERROR, DualData, NonNegativeOperator, bump_of

Either = BaseStress | Capacitance


@lru_cache(maxsize=8)
def small_model(nodes: int = 13, side: int = 5, quantity: Either | None = None) -> ObservationModel:
    """A regular array under the default layer."""
    patch = square_patch(side=side)
    quantity = BaseStress() if quantity is None else quantity
    noise = 20.0 if isinstance(quantity, BaseStress) else 0.002
    grid = Grid.square(patch, nodes=nodes)
    return ObservationModel.of(patch, Layer(), grid, BondedLayer(), quantity, noise)


def random_model(rng: np.random.Generator, shape: tuple[int, int], taxels: int) -> ObservationModel:
    """Any matrix at all on a small lattice, in a unit of its own per taxel."""
    unit = 10.0 ** rng.uniform(-4, 3, taxels)
    return made_model(rng.normal(size=(taxels, shape[0] * shape[1])) * unit[:, None], shape, unit)


def made_model(
    matrix: Floats, shape: tuple[int, int], noise: Floats | float = 1.0
) -> ObservationModel:
    """Model of a given matrix (L, K)."""
    return ObservationModel(
        matrix=matrix,
        noise_std=np.broadcast_to(noise, len(matrix)).astype(float),
        taxels=np.random.default_rng(0).uniform(0, 0.01, (len(matrix), 2)),
        grid=Grid(square_patch(side=3), shape, 2e-3, np.zeros(2)),
        virtual_matrix=lambda points: np.zeros((len(points), shape[0] * shape[1])),
    )


def pressed(model: ObservationModel, rng: np.random.Generator, places: int = 3) -> Floats:
    """Readings (L,) of some patches of pressure of many times the noise, with noise."""
    truth = np.zeros(model.grid.shape)
    for _ in range(places):
        row, column = (int(rng.integers(0, n)) for n in truth.shape)
        truth[row : row + 3, column : column + 4] = rng.uniform(0.3, 1.0)
    clean = model.matrix @ truth.ravel()
    clean *= 50.0 / max(np.abs(clean / model.noise_std).max(), 1e-300)
    return np.asarray(clean + rng.normal(size=len(clean)) * model.noise_std)


def bumps(model: ObservationModel, length: float | None) -> Floats:
    """G (K, K): column k is the bump at node k, cut at the border."""
    if length is None:
        length = 0.3 * taxel_distance(model.taxels, model.grid.pitch)
    table = bump_of(model.grid, length)
    reach = len(table) // 2
    row, column = np.divmod(np.arange(len(model.grid)), model.grid.shape[1])
    down, aside = row[:, None] - row, column[:, None] - column
    near = (np.abs(down) <= reach) & (np.abs(aside) <= reach)
    dense = np.zeros(down.shape)
    dense[near] = table[down[near] + reach, aside[near] + reach]
    return dense


@dataclass(frozen=True, eq=False)
class Dense:
    """B (L, K), G (K, K), mu (K,) and W (L, L); the model's error per highest reading."""

    seen: Floats
    bumps: Floats
    penalty: Floats
    threshold: float
    white: Floats
    misfit: float

    @classmethod
    def of(cls, solver: NonNegative, model: ObservationModel) -> "Dense":
        """From the formulas of the docstring and nothing else."""
        return _dense(replace(solver, tolerance=1.0, precision=np.float32), model)

    @cached_property
    def lower(self) -> Floats:
        """Cholesky factor of the curvature."""
        return np.linalg.cholesky(self.seen.T @ self.seen + np.eye(len(self.penalty)))

    @cached_property
    def spread(self) -> float:
        """Norm of `bumps`."""
        return float(np.linalg.norm(self.bumps, 2))

    def left(self, valid: NDArray[np.bool_]) -> "Dense":
        """Without some of the taxels, the bumps as they are."""
        noise = np.linalg.inv(self.white.T @ self.white)[np.ix_(valid, valid)]
        white = np.linalg.inv(np.linalg.cholesky(noise))
        seen = white @ np.linalg.solve(self.white, self.seen)[valid]
        lost = np.linalg.norm(seen, axis=0) / np.linalg.norm(self.seen, axis=0)
        return replace(self, seen=seen, penalty=self.penalty * lost, white=white)

    def scale(self, readings: Floats) -> float:
        """Noise with the model's error, as part of the noise."""
        return float(np.hypot(1.0, self.misfit * np.abs(readings).max()))

    def target(self, readings: Floats) -> Floats:
        """b (L,)."""
        return np.asarray(self.white @ readings / self.scale(readings))

    def score(self, readings: Floats) -> Floats:
        """How many standard deviations each node's match has, (K,)."""
        norms = np.linalg.norm(self.seen, axis=0)
        match = self.seen.T @ (self.white @ readings)
        return np.divide(match, norms, out=np.zeros_like(match), where=norms > 0)

    def objective(self, amounts: Floats, readings: Floats) -> float:
        """P(z)."""
        missing = self.seen @ amounts - self.target(readings)
        return float(0.5 * missing @ missing + 0.5 * amounts @ amounts + self.penalty @ amounts)

    def minimum(self, readings: Floats) -> Floats:
        """The amounts z (K,) where P is least: NNLS of |B z - b|^2 + |z + mu|^2."""
        rows = np.concatenate([self.seen, np.eye(len(self.penalty))])
        target = np.concatenate([self.target(readings), -self.penalty])
        return np.asarray(nnls(rows, target, maxiter=100 * len(self.penalty))[0])

    def minimum_by_squares(self, readings: Floats) -> Floats:
        """The same from the Cholesky factor of the curvature, for larger grids."""
        slope = self.seen.T @ self.target(readings) - self.penalty
        target = solve_triangular(self.lower, slope, lower=True)
        return np.asarray(nnls(self.lower.T, target, maxiter=100 * len(slope))[0])


@lru_cache(maxsize=16)
def _dense(solver: NonNegative, model: ObservationModel) -> Dense:
    spread = bumps(model, solver.length_scale)
    noise = model.noise_std
    seen = model.matrix / noise[:, None] @ spread
    spread = spread * solver.snr * np.sqrt(len(seen) / np.trace(seen @ seen.T))
    sees_sum = np.abs(model.matrix.sum(axis=1)).sum() > 0.5 * np.abs(model.matrix).sum()
    common = (0.0 if sees_sum else 5.0) if solver.common_mode is None else solver.common_mode
    offset = common * np.median(noise) / noise
    square = offset @ offset + 1e-300  # white' white is the inverse covariance, noise and offset
    less = (1.0 - 1.0 / np.sqrt(1.0 + square)) / square
    white = (np.eye(len(noise)) - less * np.outer(offset, offset)) / noise
    seen = white @ model.matrix @ spread
    norms = np.linalg.norm(seen, axis=0)
    threshold = float(-ndtri(solver.false_alarm_rate / np.count_nonzero(norms)))
    penalty = solver.shrinkage * threshold * norms
    misfit = 0.0 if sees_sum else MODEL_ERROR
    misfit = misfit if solver.model_error is None else solver.model_error
    return Dense(seen, spread, penalty, threshold, white, misfit / np.median(noise))


class Search:
    """A prepared search with a memory of its own, of readings that are linear already."""

    def __init__(self, operator: NonNegativeOperator) -> None:
        self.operator, self.problem, self.data = operator, operator.problem, operator.data()

    def __getattr__(self, name: str) -> Any:
        """Of the operator, else of its memory or of the last solution."""
        places = (self.operator, self.data, self.data.solution)
        return getattr(next(each for each in places if hasattr(each, name)), name)

    def without(self, valid: Any) -> "Search":
        """Another without some taxels."""
        return Search(self.operator.without(valid))

    def apply(self, readings: Floats, out: Floats, deadline: int | None = None) -> None:
        """Write the pressure of readings (L,) into `out` (K,)."""
        np.copyto(out, self.operator.solve(readings, self.data, deadline).pressure)


def search_of(solver: NonNegative, model: ObservationModel) -> Search:
    """Prepare a search."""
    return Search(solver.prepare(replace(model, physics=None)))


def amounts_of(operator: Search) -> Floats:
    """z (K,) of the last answer."""
    data: DualData = operator.data
    count = data.memory.lists[COUNTS, PRESSING]
    found = np.zeros(len(operator.problem.rows))
    found[data.memory.lists[PRESSED, :count]] = data.memory.nodes[AMOUNT, :count]
    return found


def solve(operator: Search, readings: Floats, deadline: int | None = None) -> Floats:
    """Pressure (K,) of one reading."""
    return operator.operator.solve(readings, operator.data, deadline).pressure.copy()


def solved(operator: Search, readings: Floats) -> Floats:
    """As `solve`, from nothing."""
    operator.reset()
    return solve(operator, readings)


def assert_proved(
    operator: Search, dense: Dense, readings: Floats, pressure: Floats, gap: float
) -> None:
    """The last answer is the minimum, as near as its gap says, which is at most `gap`.

    P is at least as curved as |z|^2 / 2, so |z - z*|^2 <= 2 (P - P*).
    """
    least = dense.minimum_by_squares(readings)
    value = dense.objective(least, readings)
    amounts = amounts_of(operator)
    rounding = 1e-13 if operator.problem.rows.itemsize == 8 else 1e-6
    reached = dense.objective(amounts, readings)
    assert np.isclose(operator.objective, reached, rtol=20 * rounding)
    assert 0.0 <= operator.gap <= gap
    assert reached - value <= (operator.gap + rounding) * reached
    radius, scale = np.sqrt(2 * (operator.gap + rounding) * reached), dense.scale(readings)
    assert np.linalg.norm(amounts - least) <= radius
    assert np.linalg.norm(pressure / scale - dense.bumps @ least) <= radius * dense.spread
    assert pressure.min() >= 0.0
