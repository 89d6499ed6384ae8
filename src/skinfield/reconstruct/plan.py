"""Linear plan of a patch: everything that needs no reading, folded into one matrix."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import Deformation, ObservationModel, Quantity
from skinfield.errors import Floats, Ints
from skinfield.estimate import (
    Contact,
    ContactFinder,
    ModelError,
    PressureError,
    PressureNoise,
    PressurePosterior,
)
from skinfield.estimate.finder import EXACT
from skinfield.skin import Grid
from skinfield.solve import GaussianModel, InverseOperator, TaxelSets

CHUNK = 512  # readings per matrix product: the outputs stay in cache
SETS = 16  # at once: their deviations stay in cache
CALLS_KEPT = 16  # whose sets of taxels stay prepared
MOST = 1e6  # s: a deadline that is as good as none
EARLIER, LATER = 0.998, 1.1  # changes of a margin: at rest one call of fifty is late
NEAR = 3  # times the margin: an answer that is earlier by more tells nothing of lateness
PAUSE = 20_000  # ns late: the machine did something else, which no margin prevents


def until(deadline: float | None, start: int) -> int | None:
    """Time, ns, at which a deadline ends, in seconds from the start."""
    return None if deadline is None else start + int(min(deadline, MOST) * 1e9)


@dataclass
class DeadlineMargin:
    """Learns from how late answers were.

    Attributes
    ----------
    margin_ns : int, ns
    least, most : int, ns
        Between which it stays.
    """

    margin_ns: int = 10_000
    least: int = 2_000
    most: int = 50_000

    def before(self, end: int | None) -> int | None:
        """When a solver should end so that all is done at `end` of `time.perf_counter_ns`."""
        return None if end is None else end - self.margin_ns

    def learn(self, start: int, end: int) -> bool:
        """Take note that all is done now; whether that is in time.

        Of an end so near to the start that nothing was left for the solver nothing is learnt.
        """
        now = time.perf_counter_ns()
        tells = -NEAR * self.margin_ns < now - end < max(PAUSE, 2 * self.margin_ns)
        if tells and end - self.margin_ns > start:
            change = EARLIER if now <= end else LATER
            self.margin_ns = int(min(max(change * self.margin_ns, self.least), self.most))
        return now <= end


@dataclass(frozen=True, eq=False)
class PatchAnswer:
    """One reading's pressure, and how to compute the rest when it is asked for.

    Attributes
    ----------
    pressure : (K,) array, Pa
    rest : mapping of names to functions
        Of the other attributes of an `Estimate`, but for the traction.
    gap : float
    iterations : int
    notes : tuple of str
    margin : DeadlineMargin, optional
        Which learns how late this was; none where it could not have been any earlier.
    """

    pressure: Floats
    rest: dict[str, Callable[[], Any]]
    gap: float = 0.0
    iterations: int = 0
    notes: tuple[str, ...] = ()
    margin: DeadlineMargin | None = None

    def met(self, start: int, end: int | None) -> bool:
        """Whether all that is done now, begun at `start`, is there in time."""
        if end is None:
            return True
        if self.margin is None:
            return time.perf_counter_ns() <= end
        return self.margin.learn(start, end)


@dataclass(frozen=True, eq=False)
class ResultArrays:
    """Where T readings' answers are written.

    Attributes
    ----------
    fields : (T, 4 K) array
        Pressure (K) Pa, then displacement x, y, z (K each) m.
    pressure_std : (T, K) array, Pa
    residual : (T, L) array, in the quantity's unit
    contacts : list of T tuples of Contact
    notes : list of str
    gap : (T,) array
        NaN where nothing is proved.
    iterations : (T,) int array
    in_time : (T,) bool array
    """

    fields: Floats
    pressure_std: Floats
    residual: Floats
    contacts: list[tuple[Contact, ...]]
    notes: list[str]
    gap: Floats
    iterations: Ints
    in_time: NDArray[np.bool_]

    @classmethod
    def empty(cls, readings: int, taxels: int, nodes: int) -> "ResultArrays":
        """Room for some readings."""
        return cls(
            np.empty((readings, 4 * nodes)),
            np.empty((readings, nodes)),
            np.full((readings, taxels), np.nan),
            [()] * readings,
            [],
            np.zeros(readings),
            np.zeros(readings, dtype=np.int64),
            np.ones(readings, dtype=np.bool_),
        )

    def take(self, row: int, answer: PatchAnswer) -> None:
        """Write one reading's answer."""
        nodes, rest = len(answer.pressure), answer.rest
        self.fields[row, :nodes] = answer.pressure
        self.fields[row, nodes:] = rest["displacement"]().T.ravel()
        self.pressure_std[row] = rest["pressure_std"]()
        self.residual[row] = rest["residual"]()
        self.contacts[row] = rest["contacts"]()
        self.gap[row], self.iterations[row] = answer.gap, answer.iterations
        self.notes.extend(note for note in answer.notes if note not in self.notes)


@dataclass(frozen=True, eq=False)
class Setting:
    """What all plans of a patch share.

    Attributes
    ----------
    model : ObservationModel
        Of the support: wherever pressure may be.
    deformation : Deformation
        Of the support.
    nodes : (K,) int array
        Of the support, where the answer is wanted.
    grid : Grid
        These nodes.
    quantity : Quantity
    finder : ContactFinder
    precision : numpy.float64 or numpy.float32
    model_errors : bool
        Whether contacts state the solver's own model error; not where intervals are learnt.
    """

    model: ObservationModel
    deformation: Deformation
    nodes: Ints
    grid: Grid
    quantity: Quantity
    finder: ContactFinder
    precision: type[np.floating[Any]]
    model_errors: bool = True

    def linearised(self, readings: Floats) -> Floats:
        """Readings (..., L'), linearised into an array of its own."""
        return self.quantity.linearise(readings, np.empty_like(readings))

    def contacts(
        self,
        pressure: Floats,
        noise: PressureError,
        posterior: PressureError | None,
        error: ModelError,
    ) -> tuple[Contact, ...]:
        """Contacts of a pressure (K,), Pa, whose errors are known."""
        stated = error if self.model_errors else EXACT
        return self.finder(self.grid, pressure, noise, posterior, stated)


@dataclass(frozen=True, eq=False)
class LinearPlan:
    """Resampling, inversion and displacement in one matrix.

    Attributes
    ----------
    operator : (4 K, L') array, Fortran order
        From linearised readings to pressure (K), then displacement x (K), y (K), z (K).
    explained : (L', L') array
        From linearised readings to what the pressure predicts of them.
    noise : PressureNoise
    pressure_std : (K,) array, Pa
        As the solver states it.
    posterior : PressurePosterior or None
        Of a Bayesian solver.
    model_error : ModelError
        That the solver states beside.
    valid : (L,) bool array
        Which taxels it uses.
    gaussian : GaussianModel or None
        What answers readings that lack some of all taxels, if the solver is a Bayesian one.
    """

    setting: Setting
    operator: NDArray[Any]
    explained: Floats
    noise: PressureNoise
    pressure_std: Floats
    posterior: PressurePosterior | None
    model_error: ModelError
    valid: NDArray[np.bool_]
    gaussian: GaussianModel | None = None

    def solve(self, readings: Floats, rows: Ints, out: ResultArrays) -> None:
        """Write the answers of `readings` (R, L'), in the quantity's unit, into `rows` of `out`."""
        setting, nodes = self.setting, len(self.setting.grid)
        out.pressure_std[rows] = self.pressure_std
        for first in range(0, len(rows), CHUNK):
            part, linear = rows[first : first + CHUNK], readings[first : first + CHUNK]
            linear = setting.linearised(linear)
            out.fields[part] = (self.operator @ linear.T.astype(setting.precision)).T
            out.residual[np.ix_(part, self.valid)] = linear - linear @ self.explained.T
        for row in rows:
            out.contacts[row] = self.contacts(out.fields[row, :nodes], self.noise, self.posterior)

    def solve_among(
        self, readings: Floats, valid: NDArray[np.bool_], rows: Ints, out: ResultArrays
    ) -> None:
        """Write the answers of `readings` (R, L), where `valid` (R, L), into `rows` of `out`.

        What is missing is filled in, so that one product serves all sets of taxels.
        """
        patterns, which = distinct(valid)
        order = np.argsort(which, kind="stable")
        which = which[order]
        for first in range(0, len(patterns), SETS):
            start, end = np.searchsorted(which, [first, first + SETS])
            known = self.sets(patterns[first : first + SETS])
            for begin in range(start, end, CHUNK):
                chunk = order[begin : min(begin + CHUNK, end)]
                table = np.where(valid[chunk], readings[chunk], 0.0)
                self._solve_sets(
                    known, table, which[begin : begin + len(chunk)] - first, rows[chunk], out
                )

    def _solve_sets(
        self, known: TaxelSets, table: Floats, which: Ints, rows: Ints, out: ResultArrays
    ) -> None:
        nodes, linear = len(self.setting.grid), self.setting.linearised(table)
        filled = known.filled(linear, which)
        out.fields[rows] = (self.operator @ filled.T.astype(self.setting.precision)).T
        left = linear - filled @ self.explained.T
        out.residual[rows] = np.where(known.valid[which], left, np.nan)
        for row, place in zip(rows, which, strict=True):
            posterior, noise = known.errors[place]
            out.pressure_std[row] = posterior.std
            out.contacts[row] = self.contacts(out.fields[row, :nodes], noise, posterior)

    def sets(self, patterns: NDArray[np.bool_]) -> TaxelSets:
        """Sets of valid taxels (P, L), of which those of the last calls are kept."""
        return self._sets(patterns.tobytes())

    @cached_property
    def _sets(self) -> Callable[[bytes], TaxelSets]:
        gaussian, taxels = self.gaussian, len(self.valid)
        assert gaussian is not None  # what it takes to leave taxels out
        return lru_cache(CALLS_KEPT)(
            lambda key: gaussian.sets(np.frombuffer(key, np.bool_).reshape(-1, taxels))
        )

    @cached_property
    def pressing(self) -> NDArray[Any]:
        """The operator's rows of the pressure alone, (K, L'): what has to be there at once."""
        return np.asfortranarray(self.operator[: len(self.setting.grid)])

    def prompt(
        self, reading: Floats, end: int | None, among: NDArray[np.bool_] | None = None
    ) -> PatchAnswer:
        """Answer one reading (L',) at once, whatever the time it should end.

        Of a Bayesian solver's plan of all taxels also one (L,) of which some are valid.
        """
        nodes, valid, one = len(self.setting.grid), self.valid, np.zeros(1, dtype=np.int64)
        if among is None:
            filled = linear = self.setting.linearised(reading)
        else:
            valid, known = among, self.sets(among[None])
            linear = self.setting.linearised(np.where(among, reading, 0.0))
            filled = known.filled(linear[None], one)[0]
        single = filled.astype(self.setting.precision, copy=False)
        pressure = np.asarray(np.dot(self.pressing, single), dtype=np.float64)

        def moved() -> Floats:
            fields = np.dot(self.operator, single)
            return np.asarray(fields[nodes:].reshape(3, nodes).T, dtype=np.float64)

        def contacts() -> tuple[Contact, ...]:
            if among is None:
                return self.contacts(pressure, self.noise, self.posterior)
            posterior, noise = known.errors[0]
            return self.contacts(pressure, noise, posterior)

        return PatchAnswer(
            pressure,
            {
                "displacement": moved,
                "pressure_std": lambda: np.array(
                    self.pressure_std if among is None else known.errors[0][0].std
                ),
                "contacts": contacts,
                "residual": lambda: spread_out(
                    (linear - self.explained @ filled)[valid[self.valid]], valid
                ),
            },
        )

    def contacts(
        self, pressure: Floats, noise: PressureError, posterior: PressureError | None
    ) -> tuple[Contact, ...]:
        """Contacts of a pressure (K,), Pa, whose errors are known."""
        return self.setting.contacts(pressure, noise, posterior, self.model_error)

    def reset(self) -> None:
        """Nothing is kept."""


def distinct(valid: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], Ints]:
    """Different rows of a mask (R, L), and which of them each row is (R,)."""
    packed = np.packbits(valid, axis=1)
    keys = packed.view(np.dtype((np.void, packed.shape[1]))).ravel()  # rows are compared as bytes
    _, first, which = np.unique(keys, return_index=True, return_inverse=True)
    return valid[first], which


def linear_plan(
    setting: Setting, model: ObservationModel, inverse: InverseOperator, valid: NDArray[np.bool_]
) -> LinearPlan:
    """Fold resampling, inversion and displacement into one matrix."""
    nodes, gaussian = setting.nodes, inverse.gaussian if valid.all() else None
    displacement = setting.deformation(inverse.matrix.T)[:, nodes]  # (L', K, 3)
    pressure = inverse.matrix[nodes]
    blocks = [pressure, *np.moveaxis(displacement, (2, 1, 0), (0, 1, 2))]
    return LinearPlan(
        setting=setting,
        operator=np.asfortranarray(np.concatenate(blocks), dtype=setting.precision),
        explained=model.matrix @ inverse.matrix,
        noise=PressureNoise(pressure * model.noise_std),
        pressure_std=inverse.pressure_std[nodes],
        posterior=None if inverse.posterior is None else inverse.posterior.on(nodes),
        model_error=inverse.model_error,
        valid=valid,
        gaussian=None if gaussian is None else gaussian.on(nodes),
    )


def spread_out(values: Floats, valid: NDArray[np.bool_]) -> Floats:
    """Values (L',) of valid taxels among all (L,), the others NaN."""
    out = np.full(len(valid), np.nan)
    out[valid] = values
    return out
