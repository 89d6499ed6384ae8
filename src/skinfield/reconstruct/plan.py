"""Prepared reconstruction of a patch: everything that needs no reading, by kind of solver."""

import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol

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
from skinfield.solve.gaussian_model import SetError

CHUNK = 512  # readings per matrix product: the outputs stay in cache
SETS = 16  # at once: their deviations stay in cache
CALLS_KEPT = 16  # whose sets of taxels stay prepared


class Prepared:
    """Sets of valid taxels with what each reading of them needs.

    Attributes
    ----------
    sets : TaxelSets
        P of them.
    errors : list of P pairs of SetError
        Of the posterior, and by the readings' noise alone.
    """

    def __init__(self, sets: TaxelSets) -> None:
        self.sets = sets

    @cached_property
    def errors(self) -> list[tuple[SetError, SetError]]:
        """Of the sets, one after the other: computed when contacts are first asked for."""
        return self.sets.errors()


@dataclass(frozen=True, eq=False)
class MissingTaxels:
    """Answers a linear plan's readings of which some taxels are not valid.

    Attributes
    ----------
    model : GaussianModel
        On the plan's nodes.
    """

    model: GaussianModel
    _cache: OrderedDict[bytes, Prepared] = field(default_factory=OrderedDict)

    def solve(
        self,
        plan: "LinearPlan",
        readings: Floats,
        valid: NDArray[np.bool_],
        rows: Ints,
        out: "Results",
    ) -> None:
        """Write the answers of `readings` (R, L), where `valid` (R, L), into `rows` of `out`."""
        patterns, which = distinct(valid)
        order = np.argsort(which, kind="stable")
        which = which[order]
        for first in range(0, len(patterns), SETS):
            start, end = np.searchsorted(which, [first, first + SETS])
            prepared = self.prepared(patterns[first : first + SETS])
            for begin in range(start, end, CHUNK):
                chunk = order[begin : min(begin + CHUNK, end)]
                table = np.where(valid[chunk], readings[chunk], 0.0)
                part = which[begin : begin + len(chunk)] - first
                _solve(plan, prepared, table, part, rows[chunk], out)

    def prepared(self, patterns: NDArray[np.bool_]) -> Prepared:
        """Sets of valid taxels (P, L), of which those of the last calls are kept."""
        key = np.packbits(patterns, axis=1).tobytes()
        if key not in self._cache:
            prepared = Prepared(self.model.sets(patterns))
            if len(patterns) == SETS:  # of many, that will hardly come again
                return prepared
            if len(self._cache) >= CALLS_KEPT:
                self._cache.popitem(last=False)
            self._cache[key] = prepared
        self._cache.move_to_end(key)
        return self._cache[key]


def distinct(valid: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], Ints]:
    """Different rows of a mask (R, L), and which of them each row is (R,)."""
    packed = np.packbits(valid, axis=1)
    keys = packed.view(np.dtype((np.void, packed.shape[1]))).ravel()  # rows are compared as bytes
    _, first, which = np.unique(keys, return_index=True, return_inverse=True)
    return valid[first], which


def _solve(
    plan: "LinearPlan", known: Prepared, table: Floats, which: Ints, rows: Ints, out: "Results"
) -> None:
    """Fill in what is missing, so that one product serves all; contacts one by one."""
    setting, nodes, sets = plan.setting, len(plan.setting.grid), known.sets
    linear = setting.quantity.linearise(table, np.empty_like(table))
    filled = sets.filled(linear, which)
    out.gap[rows] = 0.0
    out.fields[rows] = (plan.operator @ filled.T.astype(setting.precision)).T
    left = linear - filled @ plan.explained.T
    out.residual[rows] = np.where(sets.valid[which], left, np.nan)
    for row, place in zip(rows, which, strict=True):
        posterior, noise = known.errors[place]
        out.pressure_std[row] = posterior.std
        out.contacts[row] = plan.contacts(out.fields[row, :nodes], noise, posterior)


MOST = 1e6  # s: a deadline that is as good as none


@dataclass(frozen=True, eq=False)
class Results:
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
    def empty(cls, readings: int, taxels: int, nodes: int) -> "Results":
        """Room for some readings."""
        return cls(
            np.empty((readings, 4 * nodes)),
            np.empty((readings, nodes)),
            np.full((readings, taxels), np.nan),
            [()] * readings,
            [],
            np.full(readings, np.nan),
            np.zeros(readings, dtype=np.int64),
            np.ones(readings, dtype=np.bool_),
        )


@dataclass(frozen=True, eq=False)
class Answer:
    """One reading's pressure, and how to compute the rest when it is asked for.

    Attributes
    ----------
    pressure : (K,) array, Pa
    rest : mapping of names to functions
        Of the other attributes of an `Estimate`.
    gap : float
    iterations : int
    """

    pressure: Floats
    rest: dict[str, Callable[[], Any]] = field(default_factory=dict)
    gap: float = 0.0
    iterations: int = 0


class Plan(Protocol):
    """Prepared reconstruction from the taxels that are valid."""

    def solve(self, readings: Floats, rows: Ints, out: Results, deadline: float | None) -> None:
        """Write the answers of `readings` (R, L'), in the quantity's unit, into `rows` of `out`.

        `deadline` is in seconds for each reading.
        """
        ...

    def reset(self) -> None:
        """Forget the readings before."""
        ...

    def within(self, setting: "Setting") -> "Plan":
        """The same in another setting of the same patch."""
        ...


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
    missing : MissingTaxels or None
        What answers readings that lack further taxels, if the solver is a Bayesian one.
    """

    setting: Setting
    operator: NDArray[Any]
    explained: Floats
    noise: PressureNoise
    pressure_std: Floats
    posterior: PressurePosterior | None
    model_error: ModelError
    valid: NDArray[np.bool_]
    missing: MissingTaxels | None = None

    def solve(self, readings: Floats, rows: Ints, out: Results, deadline: float | None) -> None:
        """See `Plan.solve`: one matrix product, whatever the deadline."""
        setting, nodes = self.setting, len(self.setting.grid)
        out.gap[rows] = 0.0
        out.pressure_std[rows] = self.pressure_std
        for first in range(0, len(rows), CHUNK):
            part, chunk = rows[first : first + CHUNK], readings[first : first + CHUNK]
            linear = setting.quantity.linearise(chunk, np.empty_like(chunk))
            out.fields[part] = (self.operator @ linear.T.astype(setting.precision)).T
            out.residual[np.ix_(part, self.valid)] = linear - linear @ self.explained.T
        for row in rows:
            out.contacts[row] = self.contacts(out.fields[row, :nodes], self.noise, self.posterior)

    @cached_property
    def pressing(self) -> NDArray[Any]:
        """The operator's rows of the pressure alone, (K, L'): what has to be there at once."""
        return np.asfortranarray(self.operator[: len(self.setting.grid)])

    def _moved(self, linear: Floats) -> Floats:
        """Displacement (K, 3) of linearised readings of all its taxels."""
        nodes = len(self.setting.grid)
        fields = np.dot(self.operator, linear.astype(self.setting.precision))
        return np.asarray(fields[nodes:].reshape(3, nodes).T, dtype=np.float64)

    def _pressed(self, linear: Floats) -> Floats:
        found = np.dot(self.pressing, linear.astype(self.setting.precision, copy=False))
        return np.asarray(found, dtype=np.float64)

    def prompt(self, reading: Floats, end: int | None) -> Answer:
        """Answer one reading (L',) at once, whatever the time it should end."""
        linear = self.setting.quantity.linearise(reading, np.empty_like(reading))
        pressure = self._pressed(linear)
        return Answer(
            pressure,
            {
                "displacement": lambda: self._moved(linear),
                "pressure_std": lambda: self.pressure_std.copy(),
                "contacts": lambda: self.contacts(pressure, self.noise, self.posterior),
                "residual": lambda: spread_out(linear - self.explained @ linear, self.valid),
            },
        )

    def prompt_among(self, reading: Floats, valid: NDArray[np.bool_]) -> Answer | None:
        """Answer one reading (L,) of which some taxels are `valid`; None for most solvers."""
        if self.missing is None:
            return None
        known, one = self.missing.prepared(valid[None]), np.zeros(1, dtype=np.int64)
        there = np.where(valid, reading, 0.0)
        linear = self.setting.quantity.linearise(there, np.empty_like(there))
        filled = known.sets.filled(linear[None], one)[0]
        pressure = self._pressed(filled)
        return Answer(
            pressure,
            {
                "displacement": lambda: self._moved(filled),
                "pressure_std": lambda: known.errors[0][0].std.copy(),
                "contacts": lambda: self.contacts(pressure, *reversed(known.errors[0])),
                "residual": lambda: spread_out((linear - self.explained @ filled)[valid], valid),
            },
        )

    def contacts(
        self, pressure: Floats, noise: PressureError, posterior: PressureError | None
    ) -> tuple[Contact, ...]:
        """Contacts of a pressure (K,), Pa, whose errors are known."""
        error = self.model_error if self.setting.model_errors else EXACT
        return self.setting.finder(self.setting.grid, pressure, noise, posterior, error)

    def reset(self) -> None:
        """Nothing is kept."""

    def within(self, setting: Setting) -> "LinearPlan":
        """See `Plan.within`."""
        return replace(self, setting=setting)


def linear_plan(
    setting: Setting,
    model: ObservationModel,
    inverse: InverseOperator,
    valid: NDArray[np.bool_],
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
        missing=None if gaussian is None else MissingTaxels(gaussian.on(nodes)),
    )


def until(deadline: float | None) -> int | None:
    """Time of `time.perf_counter_ns` at which a deadline in seconds from now ends."""
    return None if deadline is None else time.perf_counter_ns() + int(min(deadline, MOST) * 1e9)


def spread_out(values: Floats, valid: NDArray[np.bool_]) -> Floats:
    """Values (L',) of valid taxels among all (L,), the others NaN."""
    out = np.full(len(valid), np.nan)
    out[valid] = values
    return out
