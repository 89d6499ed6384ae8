"""Non-negative least squares on a grid: the solver, its problem and its operator."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats, InputError, check_positive, check_range, check_shape
from skinfield.estimate import ModelError, PressureError
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
    TYPICAL,
    UNSOLVED,
    DualProblem,
    Memory,
    whitened,
)
from skinfield.solve.linear import (
    NON_NEGATIVE,
    GaussianField,
    Tikhonov,
    check_common,
    convolved,
    sees_sum,
    shared_offset,
    taxel_distance,
)
from skinfield.solve.operator import (
    Data,
    DeadlineMargin,
    FieldOperator,
    LinearOperator,
    Solution,
)
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

    chances = max(int(np.count_nonzero(rows.any(axis=1))), 1)
    threshold = float(-ndtri(solver.false_alarm_rate / chances))
    kind = np.dtype(solver.precision)
    lanes = LANES // kind.itemsize
    grid, noise_std = model.grid, model.noise_std
    taxels, nodes, typical = len(noise_std), np.zeros((3, len(rows)), kind), np.median(noise_std)
    width = (0, -taxels % lanes)
    offset = np.pad(shared_offset(solver.common_mode, model), width)
    filled, root, nodes[NORM], nodes[SHARED] = whitened(np.pad(rows, ((0, 0), width)), offset)
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
        rows=filled.astype(kind),
        nodes=nodes,
        whitening=1.0 / noise_std,
        offset=offset,
        root=root,
        bump=np.ascontiguousarray(bump, dtype=kind),
        stamps=stamps,
        places=places,
        numbers=np.array([*settings, *grid.shape, misfit / typical], dtype=np.float64),
    )


LAPS = 6  # of the run in, after which the times of steps are known


class DualData(Data):
    """Scratch memory of a search, and where the last one ended: the next starts there.

    Parameters
    ----------
    operator : NonNegativeOperator
    """

    def __init__(self, operator: "NonNegativeOperator") -> None:
        from skinfield.solve.dual.search import answer

        nodes, width = operator.problem.rows.shape
        super().__init__(operator, nodes, DeadlineMargin())
        self.answer: Any = answer
        self.memory = Memory.of(nodes, width, operator.problem.rows.dtype)
        self.memory.measures[:] = operator.paces
        self.problem = operator.problem
        self.reset()

    @property
    def searched(self) -> bool:
        """Whether any step was taken."""
        return self.solution.steps > 0

    @property
    def idle(self) -> bool:
        """Whether the last reading was proved to hold no contact."""
        return bool(self.memory.lists[COUNTS, IDLE])

    @property
    def dual(self) -> NDArray[Any]:
        """Multipliers r of the last answer, (L,), in whitened units: the grid is not in them."""
        return self.memory.taxels[DUAL, : len(self.problem.whitening)]

    def start_from(self, other: "Data | Floats") -> None:
        """Begin the next reading from another operator's multipliers, as of a coarser grid."""
        dual = other.dual if isinstance(other, DualData) else np.asarray(other)
        check_shape("dual", dual, self.dual.shape, "one per taxel")
        self.dual[:] = dual
        self.memory.lists[COUNTS, STARTED] = 1

    def reset(self) -> None:
        """Forget the reading before."""
        self.memory.lists[COUNTS], self.memory.taxels[DUAL] = 0, 0.0
        self.memory.measures[: OBJECTIVE + 1], self.memory.measures[UNSOLVED] = np.nan, 0.0
        self.solution.gap = self.solution.objective = np.nan
        self.solution.steps = 0

    def go_on_with(self, problem: DualProblem) -> None:
        """Search another problem from now on, with other taxels left out, from the same start."""
        if problem is not self.problem:
            self.problem = problem
            self.memory.lists[COUNTS], self.memory.lists[COUNTS, STARTED] = 0, 1


@dataclass(frozen=True, eq=False)
class NonNegativeOperator(FieldOperator):
    """Prepared search, which starts from the reading before where its `data` has one.

    Attributes
    ----------
    solver : NonNegative
    model : ObservationModel
    problem : DualProblem
        Arrays of the compiled search.
    backing : function that returns LinearOperator
        The field without the constraint, by which contacts and their uncertainty go; prepared when
        it is first asked for, as the search itself does not need it. The constraint only narrows a
        posterior, so that one's is too wide rather than too narrow where the model is right.
    model_error : ModelError
        That a contact has without noise.
    paces : (9,) array
        `measures` with which memory begins: how long steps take.
    valid : (L,) bool array, optional
        Taxels that are used. Default all.
    """

    solver: "NonNegative"
    model: ObservationModel
    problem: DualProblem
    backing: Callable[[], LinearOperator]
    model_error: ModelError
    paces: Floats
    valid: NDArray[np.bool_] | None = None
    linear = None  # no matrix

    @property
    def posterior(self) -> PressureError | None:
        """Posterior of the linear field without the constraint."""
        return self.backing().posterior

    @property
    def noise(self) -> PressureError:
        """How noise moves the linear field: a stand-in, from which contacts must stand out."""
        return self.backing().noise

    def data(self) -> DualData:
        """Make its scratch memory."""
        return DualData(self)

    def solve(self, readings: Floats, data: DualData, deadline_ns: int | None = None) -> Solution:
        """See `Operator.solve`.

        At the deadline it holds the best pressure so far, which is nowhere negative and explains
        the readings no worse than 0; no step is begun that would take longer than is left, going by
        those before. The gap is proved, by a dual value; of an idle patch by its test.
        """
        solution, memory = data.linearise(self, readings, self.valid), data.memory
        data.go_on_with(self.problem)
        limit = 0 if deadline_ns is None else max(deadline_ns, 1)
        data.answer(self.problem, memory, solution.readings, solution.pressure, limit)
        solution.gap = float(memory.measures[GAP])
        solution.objective = float(memory.measures[OBJECTIVE])
        solution.steps = int(memory.lists[COUNTS, STEPS])
        solution.in_time = deadline_ns is None or time.perf_counter_ns() <= deadline_ns
        return solution

    def predicted(self, solution: Solution) -> Floats:
        """See `Operator.predicted`."""
        return np.asarray(self.model.matrix @ solution.pressure)

    def pressure_std(self, solution: Solution | None = None) -> Floats:
        """Posterior deviation of the linear field without the constraint, (K,) Pa."""
        return self.backing().pressure_std()

    def without(self, valid: NDArray[np.bool_]) -> "NonNegativeOperator":
        """Leave out taxels, by a mask (L,) of those to use.

        It still takes all L readings; those left out may be anything, NaN as well. The bumps keep
        their size, where a fresh `prepare` would have the same power spread over fewer taxels.
        """
        check_shape("valid", valid, self.model.noise_std.shape, "one per taxel")
        part, whole = self.problem.without(valid), self.backing
        backing = cache(lambda: whole().without(valid))
        return replace(self, problem=part, backing=backing, valid=np.array(valid, dtype=np.bool_))

    def run_in(self) -> "NonNegativeOperator":
        """Compile, and learn how long steps take, so that the first reading is in time."""
        data, problem = self.data(), self.problem
        strongest = int(np.argmax(problem.norms))
        data.solution.readings[:] = problem.rows[strongest, : len(problem.whitening)]
        clear = data.solution.readings
        clear *= 4.0 * problem.threshold / max(float(np.linalg.norm(clear)), 1e-300)
        clear /= problem.whitening
        problem.without(np.ones(len(clear), np.bool_))
        paces = []
        for lap in range(LAPS):
            data.memory.measures[:] = 0.0
            bend = 1.0 + 0.1 * lap * np.cos(np.arange(len(clear)))
            data.answer(problem, data.memory, clear * bend, data.solution.pressure, 0)
            paces.append(data.memory.measures.copy())
        return replace(self, paces=np.median(paces, axis=0))


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
    common_mode : float, optional
        As that of `GaussianField`.
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
    common_mode: float | None = None
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
        backing = cache(lambda: linear.prepare(model))
        error, paces = NON_NEGATIVE.of(model), np.zeros(TYPICAL + 3)
        return NonNegativeOperator(self, model, problem, backing, error, paces).run_in()

    def unconstrained(self, length: float | None = None) -> GaussianField | Tikhonov:
        """Its prior without the constraint, a linear solver; with a length scale of its model."""
        length = self.length_scale if length is None else length
        if length == 0.0:
            return Tikhonov(snr=self.snr, common_mode=self.common_mode)
        return GaussianField(snr=self.snr, length_scale=length, common_mode=self.common_mode)

    def _length(self, model: ObservationModel) -> float:
        if self.length_scale is None:
            return PITCHES * taxel_distance(model.taxels, model.grid.pitch)
        return self.length_scale
