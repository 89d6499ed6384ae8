"""Search for multipliers of many non-negative problems at once, on any device."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.pipeline.array_backend import ArrayBackend

EVERY = 8  # steps between two looks at which readings are done: each waits for the device
CROWDED = 0.3  # of the readings at work, beyond which those that are done are left out
CAREFUL, MOST_LOOKS = 3, 48  # for a step's length after steps that led down, and again and again
TINY = 1e-30  # in place of 0 where a reading is solved exactly
ROUNDING = {4: 4e-6, 8: 1e-14}  # of its parts' size, by bytes: what the slope may be off


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


class DualSearch:
    """Maximises the dual value of `BulkNonNegative`, for readings that share all but themselves.

    Parameters
    ----------
    backend : ArrayBackend
    dtype : dtype
        Of the search.
    rows : (K, L) array
        B', of whitened readings.
    penalty : (K,) array
        Of the amounts.
    tolerance : float
        Relative gap at which a reading is done.
    most : int
        Steps.
    """

    def __init__(
        self,
        backend: ArrayBackend,
        dtype: np.dtype[Any],
        rows: Floats,
        penalty: NDArray[Any],
        tolerance: float,
        most: int,
    ) -> None:
        self.backend, self.dtype, self.tolerance, self.most = backend, dtype, tolerance, most
        with backend.computing():
            self.rows, self.columns = self.send(rows), self.send(rows.T)
            self.metric = self.send(np.linalg.inv(rows.T @ rows + np.eye(rows.shape[1])))
            self.penalty = self.send(penalty)

    def send(self, values: NDArray[Any]) -> Any:
        """Array of the device, of the search's precision."""
        return self.backend.send(np.ascontiguousarray(values, dtype=self.dtype))

    def run(self, white: Floats, dual: NDArray[Any], steps: NDArray[np.int64]) -> None:
        """Write the multipliers (n, L) that solve readings (n, L), and after which step they do."""
        xp, left = self.backend.namespace, np.arange(len(white))
        target = self.send(white)
        state = self._begin(target)
        safe, reached, looks = state.dual, np.full(len(white), -np.inf), 0
        for step in range(0, self.most + EVERY, EVERY):
            state, value = self._looked(target, state)
            gap = self.backend.fetch(self.gap(target, state.slope, value))
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
            lower = self.dual_values(state.slope, value)
            fell = lower < reached
            if fell.any():
                back = self.backend.send(fell[:, None])
                state = state._replace(dual=xp.where(back, safe, state.dual))
                state, value = self._looked(target, state)
                state = state._replace(heading=xp.where(back, state.turned, state.heading))
            safe, reached = state.dual, self.dual_values(state.slope, value)
            looks = min(max(CAREFUL, 2 * looks), MOST_LOOKS) if fell.any() else 0
            for _ in range(EVERY):
                state = self._step(target, state, looks)

    def _looked(self, target: Any, state: State) -> tuple[State, Any]:
        """The state without the rounding of many steps, and primal values (n,)."""
        over, slope, value = self.at(target, state.dual)
        turned = self.backend.namespace.matmul(slope, self.metric)
        return state._replace(over=over, slope=slope, turned=turned), value

    def dual_values(self, slope: Any, value: Any) -> Floats:
        """What no answer's objective is below, (n,), from slopes (n, L) and primal values (n,)."""
        square = _dots(self.backend.namespace, slope, slope)[:, 0]
        return np.asarray(self.backend.fetch(value - 0.5 * square), dtype=np.float64)

    def _begin(self, target: Any) -> State:
        """Start where the linear answer is, which is the solution if all nodes are pressed."""
        xp = self.backend.namespace
        dual = xp.matmul(target, self.metric)
        over, slope, _ = self.at(target, dual)
        turned = xp.matmul(slope, self.metric)
        return State(dual, over, slope, turned, turned)

    def _step(self, target: Any, state: State, looks: int) -> State:
        """One step of all readings (n, L), whose length is looked for so many times again."""
        xp, heading = self.backend.namespace, state.heading
        moved = xp.matmul(heading, self.columns)
        length = self._length(target, state, moved, looks)
        dual, over = state.dual + length * heading, state.over + length * moved
        slope = target - dual - xp.matmul(xp.clip(over, min=0.0), self.rows)
        turned = xp.matmul(slope, self.metric)
        gained = _dots(xp, turned - state.turned, slope)
        share = xp.clip(gained / (_dots(xp, state.slope, state.turned) + TINY), min=0.0)
        ahead = turned + share * heading
        uphill = _dots(xp, slope, ahead) > 0.0
        return State(dual, over, slope, turned, xp.where(uphill, ahead, turned))

    def _length(self, target: Any, state: State, moved: Any, looks: int) -> Any:
        """Where the dual value is highest along the heading, by Newton's method: (n, 1).

        Its slope along a line falls, so each look is between two where it rises and falls.
        """
        xp, heading = self.backend.namespace, state.heading
        flat, none = xp.zeros_like(moved), xp.zeros_like(heading[:, :1])
        square = _dots(xp, heading, heading) + TINY
        bent = xp.where(state.over > 0.0, moved, flat)
        length = _dots(xp, state.slope, heading) / (square + _dots(xp, bent, bent))
        start, low, high = _dots(xp, heading, target - state.dual), none, none + xp.inf
        for _ in range(looks):
            over = state.over + length * moved
            bent = xp.where(over > 0.0, moved, flat)
            rise = start - length * square - _dots(xp, bent, over)
            low, high = xp.where(rise > 0.0, length, low), xp.where(rise > 0.0, high, length)
            further = length + rise / (square + _dots(xp, bent, bent))
            inside = (further >= low) & (further <= high)
            length = xp.where(inside, further, 0.5 * (low + high))
        return length

    def at(self, target: Any, dual: Any) -> tuple[Any, Any, Any]:
        """What nodes exceed (n, K), slope of the dual value (n, L), primal value (n,)."""
        xp = self.backend.namespace
        over = xp.matmul(dual, self.columns) - self.penalty
        amounts = xp.clip(over, min=0.0)
        missed = target - xp.matmul(amounts, self.rows)
        cost = xp.sum(amounts * (0.5 * amounts + self.penalty), axis=1)
        return over, missed - dual, 0.5 * xp.sum(missed * missed, axis=1) + cost

    def gap(self, target: Any, slope: Any, value: Any) -> Any:
        """Relative gap (n,), with what rounding may hide of the slope's three parts."""
        xp = self.backend.namespace
        size = xp.sqrt(xp.sum(target * target, axis=1)) + xp.sqrt(2.0 * value)
        length = xp.sqrt(xp.sum(slope * slope, axis=1)) + ROUNDING[self.dtype.itemsize] * size
        return 0.5 * length * length / value


def _dots(xp: Any, first: Any, second: Any) -> Any:
    """Products of the rows of two arrays (n, m): (n, 1)."""
    return xp.sum(first * second, axis=1, keepdims=True)
