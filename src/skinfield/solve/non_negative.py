"""Non-negative least squares on a grid: the solver, its problem and its operator."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, InputError, check_positive, check_range, check_shape
from skinfield.estimate import ModelError, PressureNoise, PressurePosterior
from skinfield.skin import Grid
from skinfield.solve.dual.problem import (
    COUNTS,
    DROPPED,
    DUAL,
    GAP,
    IDLE,
    NORM,
    OBJECTIVE,
    SHARED,
    STARTED,
    STEPS,
    UNSOLVED,
    DualProblem,
    Memory,
)
from skinfield.solve.linear import (
    COMMON,
    NON_NEGATIVE,
    GaussianField,
    Tikhonov,
    check_common,
    convolved,
    sees_sum,
    taxel_distance,
)
from skinfield.solve.operator import InverseOperator
from skinfield.solve.tiles import SIDE, Tiles

LANES = 64  # bytes: rows are filled up to whole vector registers
ROUNDING = {4: 5e-7, 8: 1e-15}  # of |r| |b|, by bytes of a number: of what a dual value may be off
TILE_CUT = 5e-3  # of a taxel's column that stamps may lack: bounded, and computed where it matters
SPARSE = 0.4  # share of the whole matrix up to which a pass by stamps is quicker
LARGE = 50_000  # numbers of a whole matrix that is as quick, and soon read where caches are cold
MODEL_ERROR = 0.01  # of the highest reading, where the sum of the pressure is not seen


def problem_of(
    solver: "NonNegative", model: ObservationModel, rows: Floats, bump: Floats
) -> DualProblem:
    """Problem of a solver for a model.

    Parameters
    ----------
    solver : NonNegative
    model : ObservationModel
    rows : (K, L) array
        What each node's bump does to the taxels, in units of their noise.
    bump : (2 n + 1, 2 n + 1) array, Pa
    """
    from scipy.special import ndtri

    from skinfield.solve.dual.kernel import whiten_rows

    chances = max(int(np.count_nonzero(rows.any(axis=1))), 1)
    threshold = float(-ndtri(solver.false_alarm_rate / chances))
    kind = np.dtype(solver.precision)
    lanes = LANES // kind.itemsize
    grid, noise_std = model.grid, model.noise_std
    taxels, nodes, typical = len(noise_std), np.zeros((3, len(rows)), kind), np.median(noise_std)
    filled = np.zeros((len(rows), -(-taxels // lanes) * lanes), dtype=kind)
    root, none = np.zeros((2, filled.shape[1])), np.zeros(len(rows))
    whitening, offset = 1.0 / noise_std, solver.common_mode * typical / noise_std
    known = none, offset, whitening, filled, root[0], nodes[NORM], nodes[SHARED]
    whiten_rows(np.ascontiguousarray(rows), root[1], *known)
    stamps = np.zeros((0, SIDE**2), kind)
    places = np.zeros(0, np.int32)
    if min(grid.shape) >= SIDE and rows.size > LARGE:
        tiles = Tiles.of(rows, grid.shape, cut=TILE_CUT, dtype=kind)
        if tiles.share < SPARSE:
            stamps = tiles.values.copy()  # else read-only
            nodes[DROPPED] = tiles.dropped * (1 + 1e-6)
            places = np.concatenate([tiles.taxels, tiles.firsts, tiles.cells])
    penalty, rounding = solver.shrinkage * threshold, ROUNDING[kind.itemsize]
    settings = threshold, penalty, solver.tolerance, rounding, solver.most_iterations
    misfit = solver.model_error
    if misfit is None:
        misfit = 0.0 if sees_sum(model.matrix) else MODEL_ERROR
    return DualProblem(
        rows=filled,
        nodes=nodes,
        whitening=whitening,
        offset=offset,
        root=root[0],
        bump=np.ascontiguousarray(bump, dtype=kind),
        stamps=stamps,
        places=places,
        numbers=np.array([*settings, *grid.shape, misfit / typical], dtype=np.float64),
    )


LAPS = 6  # of the run in, after which the times of steps are known
Backing = Callable[[], tuple[InverseOperator, PressureNoise]]


def backing_of(prepare: Callable[[], InverseOperator], noise_std: Floats) -> Backing:
    """The field without the constraint, and how the readings' noise (L,) moves it.

    Contacts and their uncertainty go by it. It is prepared when it is first asked for, as the
    search itself does not need it.
    """

    @cache
    def linear() -> tuple[InverseOperator, PressureNoise]:
        operator = prepare()
        return operator, PressureNoise(operator.matrix * noise_std)

    return linear


@dataclass(eq=False)
class NonNegativeOperator:
    """Prepared search, with what it needs to start from the reading before.

    One reading at a time: it works in its own arrays. Patches of equal geometry share what is
    prepared by `twin`.

    Parameters
    ----------
    problem : DualProblem
        Arrays of the compiled search.
    backing : Backing
        See `backing_of`. The constraint only narrows a posterior, so that one's is too wide rather
        than too narrow where the model is right.
    model_error : ModelError
        That a contact has without noise.

    Attributes
    ----------
    deadline_met : bool
        Whether the last answer was there in time.
    """

    problem: DualProblem
    backing: Backing
    model_error: ModelError
    deadline_met: bool = field(default=True, init=False)

    def __post_init__(self) -> None:
        from skinfield.solve.dual.search import answer

        nodes, width = self.problem.rows.shape
        self._answer, self._memory = answer, Memory.of(nodes, width, self.problem.rows.dtype)
        self._memory.measures[: OBJECTIVE + 1] = np.nan
        self._readings = np.zeros(self.taxels)

    @property
    def taxels(self) -> int:
        """Number of readings, L."""
        return len(self.problem.whitening)

    @property
    def pressure_std(self) -> Floats:
        """Posterior deviation of the linear field without the constraint, (K,) Pa."""
        return self.backing()[0].pressure_std

    @property
    def posterior(self) -> PressurePosterior | None:
        """Posterior of the linear field without the constraint."""
        return self.backing()[0].posterior

    @property
    def noise(self) -> PressureNoise:
        """How noise moves the linear field: a stand-in, from which contacts must stand out."""
        return self.backing()[1]

    @property
    def gap(self) -> float:
        """Share of its objective, 0 to 1, by which the last answer is above the minimum at most.

        It is proved, by a dual value; of an idle patch by its test.
        """
        return float(self._memory.measures[GAP])

    @property
    def objective(self) -> float:
        """Objective of the last answer."""
        return float(self._memory.measures[OBJECTIVE])

    @property
    def idle(self) -> bool:
        """Whether the last reading was proved to hold no contact."""
        return bool(self._memory.lists[COUNTS, IDLE])

    @property
    def iterations(self) -> int:
        """Newton steps that the last reading took."""
        return int(self._memory.lists[COUNTS, STEPS])

    @property
    def dual(self) -> NDArray[Any]:
        """Multipliers r of the last answer, (L,), in whitened units: the grid is not in them."""
        return self._memory.taxels[DUAL, : self.taxels]

    def start_from(self, dual: Floats) -> None:
        """Begin the next reading from another operator's `dual` (L,), such as a coarser grid's."""
        check_shape("dual", dual, (self.taxels,), "one per taxel")
        self.dual[:] = dual
        self._memory.lists[COUNTS, STARTED] = 1

    def reset(self) -> None:
        """Forget the reading before."""
        self._memory.lists[COUNTS], self._memory.taxels[DUAL] = 0, 0.0
        self._memory.measures[: OBJECTIVE + 1], self._memory.measures[UNSOLVED] = np.nan, 0.0

    def twin(self) -> "NonNegativeOperator":
        """Share all that is prepared, with a memory of its own: for a patch of equal geometry."""
        return self._with(self.problem)

    def without(self, valid: NDArray[np.bool_]) -> "NonNegativeOperator":
        """Leave out taxels, by a mask (L,) of those to use.

        It still takes all L readings; those left out may be anything, NaN as well. The bumps keep
        their size, where a fresh `prepare` would have the same power spread over fewer taxels.
        """
        check_shape("valid", valid, (self.taxels,), "one per taxel")
        part, whole = self.problem.copy(), self.backing
        part.leave_out(self.problem, valid)

        def shorter() -> InverseOperator:
            linear = whole()[0].without(valid)  # a low-rank update, some milliseconds
            assert linear is not None  # as the operator is of all taxels, and Bayesian
            return linear

        return self._with(part, backing_of(shorter, 1.0 / self.problem.whitening[valid]))

    def leave_out(self, whole: "NonNegativeOperator", valid: NDArray[np.bool_]) -> None:
        """Become `whole.without(valid)` in place, from any other operator of `whole.without`.

        It takes a few passes over one matrix and no memory: for taxels that fail while readings
        come in. The uncertainty that it states stays what it was.
        """
        self.problem.leave_out(whole.problem, valid)
        self.reset()

    def apply(self, readings: Floats, out: Floats, deadline_ns: int | None = None) -> None:
        """Write into `out` (K,), Pa, the pressure of linearised `readings` (L,).

        At `deadline_ns` of `time.perf_counter_ns` it holds the best pressure so far, which is
        nowhere negative and explains the readings no worse than 0; no step is begun that would
        take longer than is left, going by those before.
        """
        self._readings[:] = readings
        limit = 0 if deadline_ns is None else max(deadline_ns, 1)
        self._answer(self.problem, self._memory, self._readings, out, limit)
        self.deadline_met = deadline_ns is None or time.perf_counter_ns() <= deadline_ns

    def run_in(self) -> None:
        """Compile, and learn how long steps take, so that the first reading is in time."""
        out = np.empty(len(self.problem.norms))
        white = self.problem.whitening
        strongest = int(np.argmax(self.problem.norms))
        clear = self.problem.rows[strongest, : self.taxels].astype(np.float64)
        clear *= 4.0 * self.problem.threshold / max(float(np.linalg.norm(clear)), 1e-300)
        paces = []
        for lap in range(LAPS):
            self._memory.measures[:] = 0.0
            bend = 1.0 + 0.1 * lap * np.cos(np.arange(self.taxels))
            self.apply(clear * bend / white, out)
            paces.append(self._memory.measures.copy())
        self._memory.measures[:] = np.median(paces, axis=0)
        self.reset()

    def _with(self, problem: DualProblem, backing: Backing | None = None) -> "NonNegativeOperator":
        other = NonNegativeOperator(problem, backing or self.backing, self.model_error)
        other._memory.measures[OBJECTIVE + 1 :] = self._memory.measures[OBJECTIVE + 1 :]
        return other


VANISHED = 20.0  # length scales at which the correlation is below 1e-13
CUT = 1e-3  # of a bump's peak: what is less is no part of it
LONGEST = 100  # cells that a length scale may span: its table is a square of 40 times as many


def bump_of(grid: Grid, length: float) -> Floats:
    r"""Bump whose sums, each of an independent random amount, are a Matérn-3/2 field.

    The spectrum of the covariance is that of the bump squared. On the plane the root of
    Matérn-3/2, of a spectrum like :math:`(\kappa^2 + k^2)^{-5/2}`, is the Matérn function of order
    1/4 (Rasmussen and Williams, Gaussian Processes for Machine Learning, section 4.2), which is
    positive; what the lattice leaves below 0, and below a thousandth of the peak, is cut off.

    Parameters
    ----------
    grid : Grid
    length : float, m
        Scale of the covariance; 0 for cells that are independent.

    Returns
    -------
    (2 n + 1, 2 n + 1) array
        By the offset in rows and columns; its squares sum to 1.

    Raises
    ------
    InputError
        For a length of more than 100 cells.
    """
    from scipy import fft

    if length == 0.0:
        return np.ones((1, 1))
    if length > LONGEST * grid.pitch:
        raise InputError(
            f"length_scale is {length * 1e3:g} mm on nodes {grid.pitch * 1e3:g} mm apart, "
            f"expected at most {LONGEST * grid.pitch * 1e3:g} mm: give a coarser grid"
        )
    count = fft.next_fast_len(int(2 * np.ceil(VANISHED * length / grid.pitch)) + 32)
    offset = np.minimum(np.arange(count), count - np.arange(count)) * grid.pitch
    scaled = np.sqrt(3.0) * np.hypot(offset[:, None], offset) / length
    spectrum = np.maximum(fft.fft2((1 + scaled) * np.exp(-scaled)).real, 0.0)
    root = fft.ifft2(np.sqrt(spectrum)).real
    seen = np.flatnonzero(root[0, : count // 2] > CUT * root[0, 0])
    reach = min(int(seen[-1]), max(grid.shape) - 1)
    table = np.roll(root, (reach, reach), (0, 1))[: 2 * reach + 1, : 2 * reach + 1]
    table = np.where(table > CUT * root[0, 0], table, 0.0)
    return np.asarray(table / np.sqrt(np.square(table).sum()))


def seen_through(bump: Floats, rows: Floats, grid: Grid) -> Floats:
    """What each node's bump does to the taxels, from what each node's own pressure does: (L, K).

    A bump near the border loses what would stand beyond it.
    """
    height, width = grid.shape
    reach = len(bump) // 2
    table = np.zeros((2 * height - 1, 2 * width - 1))
    down, aside = min(reach, height - 1), min(reach, width - 1)
    part = bump[reach - down : reach + down + 1, reach - aside : reach + aside + 1]
    table[height - 1 - down : height + down, width - 1 - aside : width + aside] = part
    return convolved(rows, table, grid)


PITCHES = 0.3  # of the taxels, per length scale: longer than a linear field's, which may ring


@dataclass(frozen=True, kw_only=True)
class NonNegative:
    r"""The most probable sum of smooth bumps, none of which pulls.

    For extended shapes, such as bars, rings and feet, and wherever the sum of the field counts: on
    a capacitive, incompressible skin a linear solver's field sums to 0, this one's does not. Each
    answer carries a bound of what more time could gain, and there is one at any deadline.

    Parameters
    ----------
    snr : float, dimensionless
        As that of `GaussianField`: amplitude of the expected readings over their noise.
    length_scale : float, m, optional
        Of the Matérn-3/2 covariance of the pressure. Default 0.3 of the distance of neighbouring
        taxels; 0 for cells that are independent, the least squares with a penalty on the squared
        pressure and on its sum.
    false_alarm_rate : float
        Readings of an idle patch that may be answered by anything but 0 everywhere, at most.
    shrinkage : float
        Penalty on the pressure as part of what would keep the idle patch at 0 by itself. 1 makes
        the test of `false_alarm_rate` the very condition that 0 is the minimum; less loses less of
        the force.
    tolerance : float, dimensionless
        The search ends where the objective is known to be at most this share of it above the
        minimum.
    most_iterations : int
        End it anyway after so many Newton steps.
    precision : numpy.float32 or numpy.float64
        Of the search. Rounding, of 1e-6 of the objective or so in float32, is part of the gap.
    common_mode : float
        Standard deviation of an offset that all taxels share, such as a drift, in those of the
        noise; it is integrated out. 0 for none.
    model_error : float, optional
        What no pressure on the nodes explains, such as the gap's shape under a contact: part of the
        highest reading, which all noise grows by where something is felt. Default 0.01; 0
        where the sum of the pressure is seen.

    Notes
    -----
    The pressure is p = G z, where G are bumps that are nowhere negative (a root of the Matérn
    covariance; see `bumps`) and z their amounts. With the whitened readings b = W y and B = W A G,
    where Wᵀ W is the inverse covariance of noise and offset,

    .. math:: \min_{z \ge 0} \; P(z) = \tfrac12 |B z - b|^2 + \tfrac12 |z|^2 + \mu^T z,
              \qquad \mu_k = s z_* |B_k|,

    with s `shrinkage` and z* such that :math:`K (1 - \Phi(z_*))` is the false-alarm rate: on noise
    alone :math:`B_k^T b / |B_k|` is a standard normal number at each of the K nodes, so their
    largest exceeds z* at most at that rate (Boole's inequality). Readings that do not exceed it are
    those of an idle patch: of these the problem is the one with s = 1, whose minimum is z = 0 if
    and only if they do not exceed it, so that p = 0 is its exact answer, with a gap of 0. Once
    something is felt, the whole threshold would take too much of its force, and s is `shrinkage`.
    The bumps are scaled so that the prior's readings have, over the taxels, `snr` times the noise's
    power: tr(B B') = L snr².

    It is solved in its dual, with an unknown r per taxel, however many nodes there are:

    .. math:: \max_r \; D(r) = b^T r - \tfrac12 |r|^2 - \tfrac12 |z(r)|^2, \quad
              z(r) = \max(0, B^T r - \mu), \quad \nabla D = b - r - B\, z(r).

    Any r gives amounts z(r) that are feasible, and no answer's objective is below D(r): the gap
    P - D is a proof, which one product with B' costs. Each step is a semismooth Newton step
    (Hintermüller, Ito and Kunisch, SIAM J. Optim. 13, 2002) to where D is highest along it, with a
    system of as many equations as there are pressed nodes or taxels, whichever is less; only nodes
    near to being pressed are looked at, until all are at last. The search starts from the dual of
    the reading before, if something there still stands out of the noise; else from where D is
    highest on the way from 0 to b.

    As P is at least as curved as the posterior, :math:`|w^T (p - p^*)|^2 \le 2 (P - D)\, w^T S w`
    for any weights w, a force or a moment, with S the covariance without the constraint.
    """

    snr: float = 15.0
    length_scale: float | None = None
    false_alarm_rate: float = 1e-3
    shrinkage: float = 0.5
    tolerance: float = 1e-4
    most_iterations: int = 100
    precision: type[np.floating[Any]] = np.float32
    common_mode: float = COMMON
    model_error: float | None = None

    def __post_init__(self) -> None:
        check_positive("snr", self.snr, "the prior's variance is proportional to snr**2")
        if self.length_scale is not None and self.length_scale != 0.0:
            check_positive("length_scale", self.length_scale, "in metres, or 0")
        check_range("false_alarm_rate", self.false_alarm_rate, 1e-12, 0.5, "a share of readings")
        check_range("shrinkage", self.shrinkage, 0.0, 1.0, "part of the detection threshold")
        check_range("tolerance", self.tolerance, 1e-12, 1.0, "a share of the objective")
        check_common(self.common_mode)
        if self.model_error is not None:
            check_range("model_error", self.model_error, 0.0, 1.0, "part of the highest reading")
        if self.most_iterations < 1:
            raise InputError(f"most_iterations is {self.most_iterations}, expected 1 or more")
        if self.precision not in (np.float32, np.float64):
            raise InputError(
                f"precision is {self.precision!r}, expected numpy.float32 or numpy.float64"
            )

    def prepare(self, model: ObservationModel) -> NonNegativeOperator:
        """Whiten the taxels, look through the bumps and set the threshold, once."""
        length = self._length(model)
        bump = bump_of(model.grid, length)
        seen = seen_through(bump, model.matrix / model.noise_std[:, None], model.grid)
        power = float(np.square(seen).sum())
        if not power > 0.0:
            raise InputError("no taxel sees any node: the matrix is 0; check grid and layout")
        scale = np.sqrt(self.snr**2 * len(seen) / power)
        problem = problem_of(self, model, seen.T * scale, bump * scale)
        linear = self.unconstrained(length)
        backing = backing_of(lambda: linear.prepare(model), model.noise_std)
        operator = NonNegativeOperator(problem, backing, NON_NEGATIVE.of(model))
        operator.run_in()
        return operator

    def unconstrained(self, length: float | None = None) -> GaussianField | Tikhonov:
        """Its prior without the constraint, a linear solver; with a length scale of its model."""
        length, common = self.length_scale if length is None else length, None
        if self.common_mode == 0.0:
            common = 0.0
        if length == 0.0:
            return Tikhonov(snr=self.snr, common_mode=common)
        return GaussianField(snr=self.snr, length_scale=length, common_mode=common)

    def _length(self, model: ObservationModel) -> float:
        if self.length_scale is None:
            return PITCHES * taxel_distance(model.taxels, model.grid.pitch)
        return self.length_scale
