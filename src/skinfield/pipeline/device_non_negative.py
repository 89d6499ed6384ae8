"""Non-negative pressure of many readings at once, on any device, each with its certificate."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_count, check_range, check_shape
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.device_product import chunk_of
from skinfield.pipeline.device_search import DualSearch

if TYPE_CHECKING:
    from skinfield.inverse.non_negative_operator import NonNegativeOperator

ARRAYS = 6  # of (readings, nodes) that a step holds at once, about


@dataclass(frozen=True, eq=False)
class BulkAnswer:
    """Pressures of T readings.

    Attributes
    ----------
    pressure : (T, K) array, Pa
        Nowhere negative.
    gap : (T,) array
        Share of its objective by which each may be above the minimum, at most: proved.
    objective : (T,) array, dimensionless
        Of each, as `NonNegative` has it.
    iterations : (T,) int array
    idle : (T,) bool array
        Readings that hold no contact, at the solver's false-alarm rate; their pressure is 0.
    """

    pressure: NDArray[Any]
    gap: Floats
    objective: Floats
    iterations: NDArray[np.int64]
    idle: NDArray[np.bool_]


class BulkNonNegative:
    r"""`NonNegative` for many readings at once.

    The problem is that of the solver (see `NonNegative`), in its dual:

    .. math:: \max_r \; b^T r - \tfrac12 |r|^2 - \tfrac12 |z|^2, \quad
              z = \max(0, B^T r - \mu), \quad \text{slope } g = b - r - B z.

    Each step is one of conjugate gradients (Polak and Ribière; Nocedal and Wright, Numerical
    Optimization, section 5.2), preconditioned by :math:`M = (1 + B B^T)^{-1}`: two products with B
    for all readings together. The length is that of a Newton step for the nodes that are pressed.
    Where some of these steps lead down they are taken back, and the next ones are searched along.
    Of these r and z the primal value less the dual one is :math:`|g|^2 / 2`: the certificate costs
    nothing.

    Parameters
    ----------
    operator : NonNegativeOperator
        Prepared by the solver.
    backend : ArrayBackend
    tolerance : float, optional
        Gap at which a reading is done. Default the solver's.
    most_iterations : int
        End it anyway; the gap then says how far it came.
    precision : numpy.float32 or numpy.float64
        Of the search. Its rounding is part of the gap.
    chunk : int, optional
        Readings at once. Default by the free memory of the device.
    """

    def __init__(
        self,
        operator: "NonNegativeOperator",
        backend: ArrayBackend,
        tolerance: float | None = None,
        most_iterations: int = 1000,
        precision: type[np.floating[Any]] = np.float32,
        chunk: int | None = None,
    ) -> None:
        problem = operator.problem
        tolerance = problem.tolerance if tolerance is None else tolerance
        check_range("tolerance", tolerance, 1e-12, 1.0, "a share of the objective")
        check_count("most_iterations", most_iterations, 1, 1 << 24, "steps of the search")
        self.backend, self.dtype = backend, np.dtype(precision)
        self.taxels, self.shape = operator.taxels, (problem.height, problem.width)
        rows = problem.rows[:, : self.taxels].astype(np.float64)
        nodes = len(rows)
        size = (ARRAYS * nodes + 8 * self.taxels) * self.dtype.itemsize
        self.chunk = chunk_of(backend, size) if chunk is None else chunk
        check_count("chunk", self.chunk, 1, 1 << 24, "readings at once")
        significant = problem.threshold * problem.norms.astype(np.float64)
        self._whitening, self._bump = problem.whitening, problem.bump.astype(np.float64)
        penalty, kind = problem.penalty, self.dtype
        self._search = DualSearch(backend, kind, rows, penalty, tolerance, most_iterations)
        with backend.computing():
            self._significant = self._search.send(significant)

    def __call__(self, readings: NDArray[Any]) -> BulkAnswer:
        """Solve.

        Parameters
        ----------
        readings : (T, L) array
            Linearised.

        Returns
        -------
        BulkAnswer

        Raises
        ------
        InputError
            For a reading that is not finite: this search has all taxels.
        """
        check_shape("readings", readings, (None, self.taxels), "one number per taxel")
        if not np.isfinite(readings).all():
            row, taxel = np.argwhere(~np.isfinite(readings))[0]
            raise InputError(
                f"readings[{row}, {taxel}] is {readings[row, taxel]}, expected a finite number: "
                "readings that lack taxels are for the reconstructor"
            )
        count, nodes = len(readings), self.shape[0] * self.shape[1]
        out = BulkAnswer(
            np.zeros((count, nodes), self.dtype),
            np.zeros(count),
            np.zeros(count),
            np.zeros(count, np.int64),
            np.zeros(count, np.bool_),
        )
        with self.backend.computing():
            for first in range(0, count, self.chunk):
                part = slice(first, first + self.chunk)
                self._solve(readings[part] * self._whitening, part, out)
        return out

    def _solve(self, white: Floats, part: slice, out: BulkAnswer) -> None:
        """Write the answers of whitened readings (n, L)."""
        xp, search, fetch = self.backend.namespace, self._search, self.backend.fetch
        found = xp.matmul(search.send(white), search.columns) > self._significant
        pressed = np.flatnonzero(fetch(xp.any(found, axis=1)))
        nothing = 0.5 * np.square(white).sum(axis=1)
        out.idle[part], out.objective[part] = True, nothing
        if not len(pressed):
            return
        dual = np.zeros((len(pressed), self.taxels), self.dtype)
        steps = np.zeros(len(pressed), np.int64)
        search.run(white[pressed], dual, steps)
        over, slope, value = search.at(search.send(white[pressed]), search.send(dual))
        gap = fetch(search.gap(search.send(white[pressed]), slope, value))
        objective = fetch(value).astype(np.float64)
        pressure = fetch(self._spread(xp.clip(over, min=0.0))).reshape(len(pressed), -1)
        worse = objective > nothing[pressed]  # of a search that ended early
        best = np.where(worse, nothing[pressed], objective)
        gap = np.where(worse, (best - (1.0 - gap) * objective) / best, gap)
        rows = part.start + pressed
        out.idle[rows], out.gap[rows] = False, np.minimum(gap, 1.0)
        out.objective[rows], out.iterations[rows] = best, steps
        out.pressure[rows] = np.where(worse[:, None], 0.0, pressure)

    def _spread(self, amounts: Any) -> Any:
        """Pressure (n, rows, columns) of amounts (n, K) of bumps."""
        xp, (rows, columns) = self.backend.namespace, self.shape
        count, reach = amounts.shape[0], len(self._bump) // 2
        down, aside = min(reach, rows - 1), min(reach, columns - 1)
        size = (count, rows + 2 * down, columns + 2 * aside)
        padded = xp.zeros(size, dtype=amounts.dtype, device=self.backend.device)
        padded[:, down : down + rows, aside : aside + columns] = xp.reshape(
            amounts, (count, rows, columns)
        )
        total = xp.zeros_like(xp.reshape(amounts, (count, rows, columns)))
        for i in range(-down, down + 1):
            for j in range(-aside, aside + 1):
                weight = float(self._bump[reach + i, reach + j])
                if weight > 0.0:
                    window = padded[:, down - i : down - i + rows, aside - j : aside - j + columns]
                    total = total + weight * window
        return total
