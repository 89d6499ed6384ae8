"""Smooth pressure that is nowhere negative."""

import time
from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import Floats, InputError, check_positive, check_range
from skinfield.fields import ModelError, PressureNoise, PressurePosterior
from skinfield.inverse.gaussian_field import GaussianField, taxel_distance
from skinfield.inverse.model_errors import NON_NEGATIVE
from skinfield.inverse.non_negative_prior import Precision, matern_precision
from skinfield.observation import ObservationModel

PITCHES = 0.4  # of the taxels, per length scale: longer than a linear field's, which may ring
ROOM = 128  # free nodes at first
ROUNDING = 1e-15  # of the objective: less than that is nothing gained


@dataclass(frozen=True, kw_only=True)
class NonNegative:
    r"""The most probable field of a Gaussian prior that is nowhere negative.

    For extended shapes, such as bars, rings and feet, and wherever the sum of the field counts: on
    a capacitive, incompressible skin a linear solver's field sums to 0, this one's does not.

    Parameters
    ----------
    snr : float, dimensionless
        As that of `GaussianField`: amplitude of the expected readings over their noise.
    length_scale : float, m, optional
        Of the Matérn-3/2 covariance. Default 0.4 of the distance of neighbouring taxels.
    false_alarm_rate : float
        Readings of an idle patch that may be answered by anything but 0 everywhere, at most.
    shrinkage : float
        Penalty on the pressure as part of what would keep the idle patch at 0 by itself. 1 makes
        the test of `false_alarm_rate` the very condition that 0 is the minimum; less loses less of
        the force.
    tolerance : float, dimensionless
        The search ends where any weighted sum of the pressure, a force or a moment, is known to
        lie within `tolerance` of its posterior's standard deviations of the exact minimum's.
    most_iterations : int
        End it anyway after so many steps; `gap` of the operator tells how far it came.

    Notes
    -----
    With the whitened readings b = W y, signatures B = W A and the covariance Q of `GaussianField`

    .. math:: \min_{p \ge 0} \; f(p) = \tfrac12 |B p - b|^2 + \tfrac12 p^T Q^{-1} p + \mu^T p,
              \qquad \mu_i = s z |B_i|,

    with :math:`Q^{-1}` that of a field without end which is 0 beyond the grid, s `shrinkage` and z
    such that :math:`K (1 - \Phi(z))` is the false-alarm rate: on noise alone
    :math:`B_i^T b / |B_i|` is a standard normal number at each of the K nodes, so their largest
    exceeds z at most at that rate (Boole's inequality). Readings that do not exceed it are answered
    by p = 0. The penalty goes by node, as the same :math:`\mu` for all would take half of the
    force between taxels.

    Each step chooses free nodes, all with pressure and the steepest of the others, solves for them
    exactly (Cholesky) and goes there, clipped at 0, if f falls by enough (projected Newton,
    Bertsekas 1982). Where it does not, nodes are exchanged one by one until a step succeeds (Lawson
    and Hanson 1974), so that f never rises and the search ends. With the slope r at any p >= 0,
    its parts :math:`r^\pm` and S the covariance of the posterior without the constraint, the
    multipliers :math:`r^+` are feasible in the dual problem, whose value is below the minimum:

    .. math:: f(p) - f(p^*) \le p^T r^+ + \tfrac12 (r^-)^T S r^- =: \mathrm{gap}, \quad
              |w^T (p - p^*)| \le \sqrt{2\,\mathrm{gap}\; w^T S w}.

    In place of S stand its bounds by `pressure_std` and by the largest eigenvalue of Q, whichever
    is less, so the gap that is reported is an upper bound as well.
    """

    snr: float = 20.0
    length_scale: float | None = None
    false_alarm_rate: float = 1e-3
    shrinkage: float = 0.3
    tolerance: float = 1e-3
    most_iterations: int = 100

    def __post_init__(self) -> None:
        GaussianField(snr=self.snr, length_scale=self.length_scale)  # checks both
        check_range("false_alarm_rate", self.false_alarm_rate, 1e-12, 0.5, "a share of readings")
        check_range("shrinkage", self.shrinkage, 0.0, 1.0, "part of the detection threshold")
        check_positive("tolerance", self.tolerance, "in standard deviations of the posterior")
        if self.most_iterations < 1:
            raise InputError(f"most_iterations is {self.most_iterations}, expected 1 or more")

    def prepare(self, model: ObservationModel) -> "NonNegativeOperator":
        """Whiten the taxels, invert the prior and set the threshold, once."""
        from scipy.special import ndtri

        length = self.length_scale or PITCHES * taxel_distance(model.taxels, model.grid.pitch)
        linear = GaussianField(snr=self.snr, length_scale=length).prepare(model)
        posterior = linear.posterior
        assert posterior is not None  # a GaussianField has one
        signatures = np.ascontiguousarray((model.matrix / model.noise_std[:, None]).T)
        strength = np.sqrt(np.einsum("kl,kl->k", signatures, signatures))
        chances = max(int(np.count_nonzero(strength)), 1)
        threshold = float(-ndtri(self.false_alarm_rate / chances))
        return NonNegativeOperator(
            solver=self,
            signatures=signatures,
            whitening=1.0 / model.noise_std,
            strength=strength,
            threshold=threshold,
            precision=matern_precision(model.grid, length, float(posterior.prior[0, 0])),
            shape=model.grid.shape,
            noise=PressureNoise(linear.matrix * model.noise_std),
            posterior=posterior,
            model_error=NON_NEGATIVE.of(model),
        )


@dataclass(eq=False)
class NonNegativeOperator:
    """Prepared search, with what it needs to start from the reading before.

    One reading at a time: it works in its own arrays.

    Parameters
    ----------
    solver : NonNegative
    signatures : (K, L) array, 1/Pa
        Whitened readings per pressure on a node.
    whitening : (L,) array, per unit of the reading
    strength : (K,) array, 1/Pa
        Norm of each signature.
    threshold : float, dimensionless
        Standard deviations that the most significant node must exceed.
    precision : Precision
        Of the prior.
    shape : (rows, columns)
        Of the grid.
    noise : PressureNoise
        Of the linear field without the constraint: a stand-in by which contacts are told.
    posterior : PressurePosterior
        Covariance of that field, given the readings. The constraint only narrows a posterior, so
        this one is too wide rather than too narrow where the model is right.
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

    solver: NonNegative
    signatures: Floats
    whitening: Floats
    strength: Floats
    threshold: float
    precision: Precision
    shape: tuple[int, int]
    noise: PressureNoise
    posterior: PressurePosterior
    model_error: ModelError
    iterations: int = field(default=0, init=False)
    gap: float = field(default=0.0, init=False)
    objective: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        nodes, taxels = self.signatures.shape
        self.penalty = self.solver.shrinkage * self.threshold * self.strength
        self._steepness = 1 / np.sqrt(self.strength**2 + self.precision.of_node)
        self._pressure, self._slope, self._correlated = np.zeros((3, nodes))
        self._target, self._predicted = np.zeros((2, taxels))
        self._chosen = np.zeros(nodes, dtype=np.bool_)
        self._free, self._count = np.zeros(nodes, dtype=np.int64), 0
        self._make_room(min(ROOM, nodes))
        self._carefully = self._settled = False

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
        nowhere negative and explains the readings better than 0; no step is begun that would
        take longer than is left, as far as the one before tells.
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

    def _search(self, deadline_ns: int | None) -> None:
        self._evaluate()
        if self.objective > 0.0:  # the reading before tells less than nothing of this one
            self._pressure[:] = 0.0
            self._evaluate()
        self._carefully, self._settled = False, not self._pressure.any()
        lasted = 0
        while self.iterations < self.solver.most_iterations:
            start = time.perf_counter_ns()
            done = 2.0 * self.gap <= self.solver.tolerance**2
            if done or (deadline_ns is not None and start + lasted > deadline_ns):
                return
            if not self._advance():
                return
            self._evaluate()
            self.iterations += 1
            lasted = time.perf_counter_ns() - start

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

    def _advance(self) -> bool:
        """Take one step; whether there was anything to gain beyond rounding."""
        from skinfield.inverse import non_negative_kernel as kernel

        slope, pressure, chosen = self._slope, self._pressure, self._chosen
        one_more = self._settled
        if self._carefully:
            kernel.choose_few(slope, pressure, self._steepness, one_more, chosen)
        else:
            kernel.choose_many(slope, pressure, self._steepness, self.shape, chosen)
        if not self._solve_for_chosen():
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

    def _solve_for_chosen(self) -> bool:
        """Newton's step of the chosen nodes."""
        from skinfield.inverse import non_negative_kernel as kernel

        self._count, done = kernel.list_chosen(self._chosen, self._free, self._count)
        free, count, width = self._free, self._count, self.shape[1]
        if count > len(self._lower):
            self._make_room(min(2 * count, len(self._pressure)))
            done = 0
        lower, table = self._lower, self.precision.table
        if not kernel.factor(self.signatures, table, width, free, done, count, lower):
            self._count = 0  # the factor's rows are not those of the list
            return False
        kernel.newton_step(lower, self._slope, free, count, self._step)
        return True

    def _make_room(self, nodes: int) -> None:
        """For so many free nodes: kept, so that no later reading allocates it."""
        self._lower = np.zeros((nodes, nodes))
        self._step, self._moved = np.zeros((2, nodes))
