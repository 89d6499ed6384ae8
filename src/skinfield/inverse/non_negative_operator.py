"""Search for the pressure of a `NonNegative` field, reading by reading."""

import time
from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import Floats
from skinfield.fields import ModelError, PressureNoise, PressurePosterior
from skinfield.inverse.non_negative_prior import Precision

ROOM = 128  # free nodes at first
PACE = 0.5  # ns per product, until it is measured
SLOWER = 1.2  # by which a step may raise the pace
LEAST_WORK = 100_000.0  # products: what a step takes beside its factor
PARTS = (0.05, 1.0)  # of the steepest node: as steep ones are freed with it; in haste none
ROUNDING = 1e-15  # of the objective: less than that is nothing gained


@dataclass(eq=False)
class NonNegativeOperator:
    """Prepared search, with what it needs to start from the reading before.

    One reading at a time: it works in its own arrays.

    Parameters
    ----------
    signatures : (K, L) array, 1/Pa
        Whitened readings per pressure on a node.
    whitening : (L,) array, per unit of the reading
    strength : (K,) array, 1/Pa
        Norm of each signature.
    threshold : float, dimensionless
        Standard deviations that the most significant node must exceed.
    penalty : (K,) array, 1/Pa
        On the pressure of each node.
    precision : Precision
        Of the prior.
    shape : (rows, columns)
        Of the grid.
    noise : PressureNoise
        Of the linear field without the constraint: a stand-in by which contacts are told.
    posterior : PressurePosterior
        Covariance of that field, given the readings. The constraint only narrows a posterior, so
        this one is too wide rather than too narrow where the model is right.
    tolerance, most_iterations
        Of the solver.
    model_error : ModelError
        That a contact has without noise.

    Attributes
    ----------
    iterations : int
        Steps that the last reading took.
    gap : float, dimensionless
        How far the last answer's objective is above the minimum, at most.
    objective : float, dimensionless
        That of the last answer, less that of 0 everywhere: never above 0.
    """

    signatures: Floats
    whitening: Floats
    strength: Floats
    threshold: float
    penalty: Floats
    precision: Precision
    shape: tuple[int, int]
    noise: PressureNoise
    posterior: PressurePosterior
    tolerance: float
    most_iterations: int
    model_error: ModelError
    iterations: int = field(default=0, init=False)
    gap: float = field(default=0.0, init=False)
    objective: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        nodes, taxels = self.signatures.shape
        self._steepness = 1 / np.sqrt(self.strength**2 + self.precision.of_node)
        self._pressure, self._slope, self._correlated = np.zeros((3, nodes))
        self._target, self._predicted = np.zeros((2, taxels))
        self._chosen = np.zeros(nodes, dtype=np.bool_)
        self._free, self._count = np.zeros(nodes, dtype=np.int64), 0
        self._make_room(min(ROOM, nodes))
        self._carefully = self._settled = False
        self._listed, self._work, self._pace = 0, 0.0, PACE

    @property
    def pressure_std(self) -> Floats:
        """Posterior deviation of the linear field without the constraint, (K,) Pa."""
        return self.posterior.std

    def reset(self) -> None:
        """Forget the reading before."""
        self._pressure[:] = 0.0

    def apply(self, readings: Floats, out: Floats, deadline_ns: int | None = None) -> None:
        """Write into `out` (K,), Pa, the pressure of linearised `readings` (L,).

        At `deadline_ns` of `time.perf_counter_ns` it holds the best pressure so far, which is
        nowhere negative and explains the readings no worse than 0; no step is begun that would
        take longer than is left, going by the pace of the one before.
        """
        from skinfield.inverse import non_negative_kernel as kernel

        self.iterations, self.gap, self.objective = 0, 0.0, 0.0
        np.multiply(readings, self.whitening, out=self._target)
        kernel.correlate(self.signatures, self._target, self._correlated)
        if kernel.highest_ratio(self._correlated, self.strength) <= self.threshold:
            self._pressure[:] = 0.0
        else:
            self._search(deadline_ns)
        out[:] = self._pressure

    def run_in(self) -> None:
        """Load what is compiled, so that the first reading is as fast as the next."""
        from skinfield.inverse import non_negative_kernel as kernel

        strongest = int(np.argmax(self.strength))
        clear = 2.0 * self.threshold / max(self.strength[strongest], 1e-300)
        self.apply(clear * self.signatures[strongest] / self.whitening, self._slope.copy())
        self.reset()
        chosen, slope, pressure = self._chosen.copy(), self._slope, self._pressure
        kernel.choose_few(slope, pressure, self._steepness, False, chosen)
        kernel.move_straight(self._lower, slope, self._free, 0, self._step, self._moved, pressure)
        self.iterations, self.gap, self.objective = 0, 0.0, 0.0

    def _search(self, deadline_ns: int | None) -> None:
        self._evaluate()
        if self.objective > 0.0:  # the reading before tells less than nothing of this one
            self._pressure[:] = 0.0
            self._evaluate()
        self._carefully, self._settled = False, not self._pressure.any()
        enough = 0.5 * self.tolerance**2
        while self.gap > enough and self.iterations < self.most_iterations:
            if not self._advance(deadline_ns):
                return
            self._evaluate()
            self.iterations += 1

    def _evaluate(self) -> None:
        """Slope, objective and gap at the pressure."""
        from skinfield.inverse import non_negative_kernel as kernel

        curved = kernel.slope_of(
            self.signatures,
            self._correlated,
            self.penalty,
            self.precision.table,
            self.shape,
            self._pressure,
            self._predicted,
            self._slope,
        )
        self.objective = float(self._pressure @ self._slope) - 0.5 * curved
        self.gap = kernel.gap_of(
            self._slope, self._pressure, self.pressure_std, self.precision.largest_variance
        )

    def _advance(self, deadline_ns: int | None) -> bool:
        """Take one step; whether there was time for it and anything to gain beyond rounding."""
        from skinfield.inverse import non_negative_kernel as kernel

        slope, pressure, chosen = self._slope, self._pressure, self._chosen
        one_more = self._settled
        if self._carefully:
            kernel.choose_few(slope, pressure, self._steepness, one_more, chosen)
            if not self._in_time(deadline_ns):
                return False
        else:
            for part in PARTS:
                kernel.choose_many(slope, pressure, self._steepness, self.shape, part, chosen)
                if self._in_time(deadline_ns):
                    break
            else:
                return False
        if not self._solve():
            return False
        go = kernel.move_straight if self._carefully else kernel.move_clipped
        change, self._settled = go(
            self._lower, slope, self._free, self._count, self._step, self._moved, pressure
        )
        gained = bool(change < ROUNDING * self.objective)
        if self._carefully:
            self._carefully = not (self._settled and one_more)
            return gained or (self._settled and not one_more)
        if change == 0.0:
            self._carefully, self._settled = True, one_more
        return gained or self._carefully

    def _in_time(self, deadline_ns: int | None) -> bool:
        """List the chosen nodes; whether there is time to solve for them."""
        from skinfield.inverse import non_negative_kernel as kernel

        count, done = kernel.list_chosen(self._chosen, self._free, self._count)
        if count > len(self._lower):
            self._make_room(min(2 * count, len(self._pressure)))
            done = 0
        self._count, self._listed = done, count  # so many rows of the factor hold
        taxels = self.signatures.shape[1]
        self._work = (count**2 - done**2) * taxels / 2 + (count**3 - done**3) / 6 + LEAST_WORK
        if deadline_ns is None:
            return True
        return time.perf_counter_ns() + self._pace * self._work < deadline_ns

    def _solve(self) -> bool:
        """Newton's step of the listed nodes."""
        from skinfield.inverse import non_negative_kernel as kernel

        start, free, done, count = time.perf_counter_ns(), self._free, self._count, self._listed
        lower, table, width = self._lower, self.precision.table, self.shape[1]
        if not kernel.factor(self.signatures, table, width, free, done, count, lower):
            return False
        self._count = count
        kernel.newton_step(lower, self._slope, free, count, self._step)
        pace = (time.perf_counter_ns() - start) / self._work
        self._pace = min(pace, SLOWER * self._pace)  # a step that was interrupted tells little
        return True

    def _make_room(self, nodes: int) -> None:
        """For so many free nodes: kept, so that no later reading allocates it."""
        self._lower = np.zeros((nodes, nodes))
        self._step, self._moved = np.zeros((2, nodes))
