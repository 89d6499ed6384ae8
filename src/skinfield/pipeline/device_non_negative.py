"""Non-negative pressure of many readings at once, on any device, each with its certificate."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_count, check_range, check_shape
from skinfield.pipeline.array_backend import ArrayBackend
from skinfield.pipeline.device_product import chunk_of

if TYPE_CHECKING:
    from skinfield.inverse.non_negative_operator import NonNegativeOperator

ARRAYS = 6  # of (readings, nodes) that a step holds at once, about
EVERY = 8  # steps between two looks at which readings are done: each waits for the device
CROWDED = 0.3  # of the readings at work, beyond which those that are done are left out
TINY = 1e-30  # in place of 0 where a reading is solved exactly
ROUNDING = {4: 4e-6, 8: 1e-14}  # of its parts' size, by bytes: what the slope may be off


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


class State(NamedTuple):
    """Where the search is: arrays of the device, a row per reading.

    Attributes
    ----------
    dual : (n, L) array
    over : (n, K) array
        What each node's correlation exceeds its penalty by.
    slope, turned, heading : (n, L) arrays
        Of the dual value; M times it; and of the next step.
    """

    dual: Any
    over: Any
    slope: Any
    turned: Any
    heading: Any


class BulkNonNegative:
    r"""`NonNegative` for many readings at once.

    The problem is that of the solver (see `NonNegative`), in its dual:

    .. math:: \max_r \; b^T r - \tfrac12 |r|^2 - \tfrac12 |z|^2, \quad
              z = \max(0, B^T r - \mu), \quad \text{slope } g = b - r - B z.

    Each step is one of conjugate gradients (Polak and Ribière; Nocedal and Wright, Numerical
    Optimization, section 5.2), preconditioned by :math:`M = (1 + B B^T)^{-1}`: two products with B
    for all readings together. The length is that of a Newton step for the nodes that are pressed.
    Where this comes no nearer, the steps become M g, which always do, as :math:`1 + B B^T` bounds
    the curvature whatever is pressed. Of these r and z the primal value less the dual one is
    :math:`|g|^2 / 2`: the certificate costs nothing.

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
        self.tolerance = problem.tolerance if tolerance is None else tolerance
        check_range("tolerance", self.tolerance, 1e-12, 1.0, "a share of the objective")
        check_count("most_iterations", most_iterations, 1, 1 << 24, "steps of the search")
        self.backend, self.most, self.dtype = backend, most_iterations, np.dtype(precision)
        self.taxels, self.shape = operator.taxels, (problem.height, problem.width)
        rows = problem.rows[:, : self.taxels].astype(np.float64)
        nodes = len(rows)
        size = (ARRAYS * nodes + 8 * self.taxels) * self.dtype.itemsize
        self.chunk = chunk_of(backend, size) if chunk is None else chunk
        check_count("chunk", self.chunk, 1, 1 << 24, "readings at once")
        metric = np.linalg.inv(rows.T @ rows + np.eye(self.taxels))
        significant = problem.threshold * problem.norms.astype(np.float64)
        self._whitening, self._bump = problem.whitening, problem.bump.astype(np.float64)
        with backend.computing():
            self._rows, self._columns = self._send(rows), self._send(rows.T)
            self._metric, self._penalty = self._send(metric), self._send(problem.penalty)
            self._significant = self._send(significant)

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
        count, nodes = len(readings), self._rows.shape[0]
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
        xp, target = self.backend.namespace, self._send(white)
        over = xp.any(xp.matmul(target, self._columns) > self._significant, axis=1)
        pressed = np.flatnonzero(self.backend.fetch(over))
        out.idle[part], out.objective[part] = True, 0.5 * np.square(white).sum(axis=1)
        out.idle[part][pressed] = False
        if not len(pressed):
            return
        dual = np.zeros((len(pressed), self.taxels), self.dtype)
        steps = np.zeros(len(pressed), np.int64)
        self._search(white[pressed], dual, steps)
        target, multipliers = self._send(white[pressed]), self._send(dual)
        over, slope, value = self._at(target, multipliers)
        gap = self.backend.fetch(self._gap(target, slope, value))
        out.gap[part][pressed] = np.minimum(gap, 1.0)
        out.objective[part][pressed] = self.backend.fetch(value)
        out.iterations[part][pressed] = steps
        pressure = self.backend.fetch(self._spread(xp.clip(over, min=0.0)))
        out.pressure[part][pressed] = pressure.reshape(len(pressed), -1)

    def _search(self, white: Floats, dual: NDArray[Any], steps: NDArray[np.int64]) -> None:
        """Write the multipliers (n, L) that solve readings (n, L), and after which step they do."""
        xp, left = self.backend.namespace, np.arange(len(white))
        target = self._send(white)
        state = self._begin(target)
        safe, reached = state.dual, np.full(len(white), -np.inf)
        for step in range(0, self.most + EVERY, EVERY):
            state, value = self._looked(target, state)
            gap = self.backend.fetch(self._gap(target, state.slope, value))
            ended = (gap <= self.tolerance) | (step >= self.most)
            if ended.mean() > CROWDED:
                dual[left[ended]] = self.backend.fetch(state.dual)[ended]
                steps[left[ended]] = step
                if ended.all():
                    return
                kept = self.backend.send(np.flatnonzero(~ended))
                state = State(*(xp.take(each, kept, axis=0) for each in state))
                target, safe, value = (xp.take(x, kept, axis=0) for x in (target, safe, value))
                left, reached = left[~ended], reached[~ended]
            lower = self._dual_value(state.slope, value)
            worse = self.backend.send((lower < reached)[:, None])
            if (lower < reached).any():
                state = state._replace(dual=xp.where(worse, safe, state.dual))
                state, value = self._looked(target, state)
            safe, reached = state.dual, self._dual_value(state.slope, value)
            for _ in range(EVERY):
                state = self._step(target, state, worse)

    def _looked(self, target: Any, state: State) -> tuple[State, Any]:
        """The state without the rounding of many steps, and primal values (n,)."""
        over, slope, value = self._at(target, state.dual)
        turned = self.backend.namespace.matmul(slope, self._metric)
        return state._replace(over=over, slope=slope, turned=turned), value

    def _dual_value(self, slope: Any, value: Any) -> Floats:
        square = _dots(self.backend.namespace, slope, slope)[:, 0]
        return np.asarray(self.backend.fetch(value - 0.5 * square), dtype=np.float64)

    def _begin(self, target: Any) -> State:
        """Start where the linear answer is, which is the solution if all nodes are pressed."""
        xp = self.backend.namespace
        dual = xp.matmul(target, self._metric)
        over, slope, _ = self._at(target, dual)
        turned = xp.matmul(slope, self._metric)
        return State(dual, over, slope, turned, turned)

    def _step(self, target: Any, state: State, careful: Any) -> State:
        """One step of all readings (n, L); where `careful` (n, 1), one that can only gain."""
        xp, heading = self.backend.namespace, state.heading
        none = xp.zeros_like(heading[:, :1])
        heading = xp.where(careful, state.turned, heading)
        moved = xp.matmul(heading, self._columns)
        bent = xp.where(state.over > 0.0, moved, xp.zeros_like(moved))
        curve = _dots(xp, heading, heading) + _dots(xp, bent, bent)
        length = _dots(xp, state.slope, heading) / (curve + TINY)
        length = xp.where(careful, none + 1.0, length)
        dual, over = state.dual + length * heading, state.over + length * moved
        amounts = xp.clip(over, min=0.0)
        slope = target - dual - xp.matmul(amounts, self._rows)
        turned = xp.matmul(slope, self._metric)
        gained = _dots(xp, turned - state.turned, slope)
        share = xp.clip(gained / (_dots(xp, state.slope, state.turned) + TINY), min=0.0)
        ahead = turned + share * heading
        uphill = _dots(xp, slope, ahead) > 0.0
        return State(dual, over, slope, turned, xp.where(uphill, ahead, turned))

    def _at(self, target: Any, dual: Any) -> tuple[Any, Any, Any]:
        """What nodes exceed (n, K), slope of the dual value (n, L), primal value (n,)."""
        xp = self.backend.namespace
        over = xp.matmul(dual, self._columns) - self._penalty
        amounts = xp.clip(over, min=0.0)
        missed = target - xp.matmul(amounts, self._rows)
        cost = xp.sum(amounts * (0.5 * amounts + self._penalty), axis=1)
        return over, missed - dual, 0.5 * xp.sum(missed * missed, axis=1) + cost

    def _gap(self, target: Any, slope: Any, value: Any) -> Any:
        """Relative gap (n,), with what rounding may hide of the slope's three parts."""
        xp = self.backend.namespace
        size = xp.sqrt(xp.sum(target * target, axis=1)) + xp.sqrt(2.0 * value)
        length = xp.sqrt(xp.sum(slope * slope, axis=1)) + ROUNDING[self.dtype.itemsize] * size
        return 0.5 * length * length / value

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

    def _send(self, values: NDArray[Any]) -> Any:
        return self.backend.send(np.ascontiguousarray(values, dtype=self.dtype))


def _dots(xp: Any, first: Any, second: Any) -> Any:
    """Products of the rows of two arrays (n, m): (n, 1)."""
    return xp.sum(first * second, axis=1, keepdims=True)
