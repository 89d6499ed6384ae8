"""Multigrid reconstruction: one patch at several resolutions, from coarse to fine."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import BondedLayer, Capacitance, Layer, Mechanics, Quantity, check_skin
from skinfield.errors import (
    Floats,
    InputError,
    Ints,
    as_floats,
    check_finite,
    check_offers,
    check_positive,
    check_shape,
)
from skinfield.estimate import (
    Contact,
    ContactFinder,
    Estimate,
    PressureNoise,
)
from skinfield.reconstruct.multigrid_levels import Rung, linear_rung, prepare_rungs
from skinfield.reconstruct.plan import MOST
from skinfield.reconstruct.reconstructor import checked_readings
from skinfield.skin import Grid, Patch
from skinfield.solve import FieldOperator, GaussianField, InverseOperator, Solver
from skinfield.solve.operator import Beliefs


@dataclass(frozen=True, eq=False)
class Window:
    """Rectangle of nodes of a fine grid.

    Attributes
    ----------
    fine : Grid
    rows, columns : slice
        Nodes inside.
    """

    fine: Grid
    rows: slice
    columns: slice

    @classmethod
    def between(cls, fine: Grid, low: ArrayLike, high: ArrayLike) -> "Window":
        """Nodes from `low` to `high` (2,) m of the patch's plane.

        Raises
        ------
        InputError
            If a corner is no place, or the rectangle holds no node.
        """
        corners = []
        for name, values in (("low", low), ("high", high)):
            corner = as_floats(name, values)
            check_shape(name, corner, (2,), "x and y in the patch's plane, in metres")
            check_finite(name, corner, "a corner of what to look at, in metres")
            corners.append(np.clip((corner - fine.origin) / fine.pitch, -1.0, max(fine.shape)))
        first = np.maximum(np.ceil(corners[0] - 1e-9), 0).astype(int)
        last = np.minimum(np.floor(corners[1] + 1e-9), np.array(fine.shape[::-1]) - 1).astype(int)
        if (last < first).any():
            raise InputError(
                f"the window from {np.asarray(low).tolist()} to {np.asarray(high).tolist()} m "
                f"holds no node of the {fine.shape[0]} x {fine.shape[1]} grid, expected low below "
                "high, on the patch, in metres"
            )
        columns, rows = (slice(int(a), int(b) + 1) for a, b in zip(first, last, strict=True))
        return cls(fine, rows, columns)

    @cached_property
    def nodes(self) -> Ints:
        """Of the fine grid, inside, (N,)."""
        every = np.arange(len(self.fine)).reshape(self.fine.shape)
        return np.ascontiguousarray(every[self.rows, self.columns].ravel())

    @cached_property
    def grid(self) -> Grid:
        """These nodes as a grid."""
        shape = self.rows.stop - self.rows.start, self.columns.stop - self.columns.start
        corner = np.array([self.columns.start, self.rows.start])
        return Grid(
            self.fine.patch, shape, self.fine.pitch, self.fine.origin + corner * self.fine.pitch
        )

    def candidates(self, around: int) -> NDArray[np.bool_]:
        """All nodes inside, and outside one of `around` x `around`: (K,) of the fine grid."""
        rows, columns = self.fine.shape
        seldom = max(around, 1)
        start = seldom // 2
        mask = np.zeros((rows, columns), np.bool_)
        mask[start::seldom, start::seldom] = True
        mask[self.rows, self.columns] = True
        return mask.ravel()


def offered(operator: FieldOperator, method: str) -> Any:
    """A method of an operator, or InputError if it has none."""
    found = getattr(operator, method, None)
    if found is None:
        raise InputError(
            f"the solver's {type(operator).__name__} has no {method!r}, expected an operator such "
            "as that of NonNegative(): for others, prepare a Reconstructor of what is wanted"
        )
    return found


@dataclass(frozen=True, eq=False)
class Rest:
    """What an estimate holds beside its pressure.

    Attributes
    ----------
    grid : Grid
    pressure : (K,) array, Pa
    readings : (L,) array
        Linearised.
    valid : (L,) bool array
    predicted : function that returns (L,) array
        Linearised readings that the answer predicts.
    moved : function that returns (K, 3) array, m
        Displacement.
    beliefs : function that returns Beliefs
    finder : ContactFinder
    """

    grid: Grid
    pressure: Floats
    readings: Floats
    valid: NDArray[np.bool_]
    predicted: Callable[[], Floats]
    moved: Callable[[], Floats]
    beliefs: Callable[[], Beliefs]
    finder: ContactFinder

    def traction(self) -> Floats:
        """Of a pressure along the normals, (K, 3) Pa."""
        return np.asarray(-self.pressure[:, None] * self.grid.normals)

    def contacts(self) -> tuple[Contact, ...]:
        """By falling force."""
        known = self.beliefs()
        return self.finder(
            self.grid, self.pressure, known.noise, known.posterior, known.model_error
        )

    def residual(self) -> Floats:
        """Readings less what the pressure predicts, (L,); NaN for taxels that were left out."""
        return np.asarray(np.where(self.valid, self.readings - self.predicted(), np.nan))

    def estimate(self, **known: Any) -> Estimate:
        """The estimate, prompt."""
        rest = {
            "traction": self.traction,
            "displacement": self.moved,
            "pressure_std": lambda: self.beliefs().pressure_std,
            "contacts": self.contacts,
            "residual": self.residual,
        }
        return Estimate.later(
            rest, grid=self.grid, pressure=self.pressure, valid=self.valid, **known
        )


SETS = 16  # of valid taxels, on one rung each, that stay prepared


class Ladder:
    """Prepared reconstruction of one patch on grids from coarse to fine.

    Parameters
    ----------
    patch : Patch
    layer : Layer, optional
        Default `Layer()`.
    rungs : sequence of int
        Nodes along the sides of the grids, from coarse to fine.
    mechanics : Mechanics, optional
        Default `BondedLayer()`.
    quantity : Quantity, optional
        Default `Capacitance()`.
    solver : Solver, optional
        Linear, or `NonNegative()`. Default `GaussianField()`.
    noise_std : float or (L,) array, in the quantity's unit, optional
        Default the quantity's `typical_noise`.
    finder : ContactFinder, optional

    Raises
    ------
    InputError
        For arguments that do not fit, and for solvers that find contacts by themselves.

    Notes
    -----
    Of a linear solver, only the finest grid is inverted. The answer on a coarser one is that
    answer's average over each coarse cell, so that all rungs state the same force, and its
    uncertainty is exactly that of these averages. A solver that searches is prepared on each grid;
    its dual variables belong to the taxels, so each rung goes on where another one ended.
    """

    def __init__(
        self,
        patch: Patch,
        layer: Layer | None = None,
        rungs: Sequence[int] = (10, 20, 40, 80),
        *,
        mechanics: Mechanics | None = None,
        quantity: Quantity | None = None,
        solver: Solver | None = None,
        noise_std: ArrayLike | None = None,
        finder: ContactFinder | None = None,
    ) -> None:
        self.patch, self.rungs = patch, tuple(rungs)
        self.layer = Layer() if layer is None else layer
        self.mechanics = BondedLayer() if mechanics is None else mechanics
        self.quantity = Capacitance() if quantity is None else quantity
        self.solver = GaussianField() if solver is None else solver
        self.finder = ContactFinder() if finder is None else finder
        check_skin(patch, self.layer, self.mechanics, self.quantity)
        check_offers("solver", self.solver, ("prepare",), "one such as GaussianField()")
        noise = self.quantity.typical_noise if noise_std is None else noise_std
        self.prepared = prepare_rungs(
            patch, self.layer, self.rungs, self.mechanics, self.quantity, self.solver, noise
        )
        self._steps = dict(zip(self.rungs, self.prepared.steps, strict=True))
        self._step = self.prepared.steps[-1]
        self._window: Window | None = None
        self._rows = self._step.matrix  # of a linear answer, in the window
        self._operator = self._step.operator
        self._before: FieldOperator | None = None  # that answered last
        self._linear = np.zeros(len(patch))
        self._without = lru_cache(SETS)(self._prepared_without)

    @property
    def rung(self) -> int:
        """Nodes along the sides of the grid that the next reading is answered on; may be set.

        A change costs nothing: every rung is prepared. It ends a focus.
        """
        return self._step.nodes

    @rung.setter
    def rung(self, nodes: int) -> None:
        self._step = self._at(nodes)
        self._operator = self._step.operator
        self._window, self._rows = None, self._step.matrix

    def _at(self, nodes: int) -> Rung:
        step = self._steps.get(nodes)
        if step is None:
            raise InputError(f"rung is {nodes!r}, expected one of {self.rungs}")
        return step

    @property
    def grid(self) -> Grid:
        """Nodes of the next answer."""
        return self._step.grid if self._window is None else self._window.grid

    def focus(self, low: ArrayLike, high: ArrayLike, rung: int | None = None) -> None:
        """Look closely at a window, until the rung is set or `focus` is called again.

        Parameters
        ----------
        low, high : (2,) arrays, m
            Corners of the window in the patch's plane.
        rung : int, optional
            Density inside. Default the finest.

        Notes
        -----
        Of a linear solver the next answers hold the window alone, and are those of the whole grid.
        A search goes on over the whole patch, or else what presses elsewhere would be taken for a
        pressure in the window; but outside of it, only as many cells as the rung before had are
        candidates. The gap is that to all cells of the fine grid: it tells what that may have cost.
        """
        before, step = self._step.nodes, self._at(self.rungs[-1] if rung is None else rung)
        window = Window.between(step.grid, low, high)  # of a wrong one nothing is changed
        self.rung = step.nodes
        if self._operator is None:
            self._window = window
            self._rows = np.ascontiguousarray(self._step.matrix[window.nodes])
            return
        seldom = round(self._step.nodes / before)
        self._operator = offered(self._operator, "within")(window.candidates(seldom))

    def apply(self, readings: Floats, out: Floats, deadline_ns: int | None = None) -> None:
        """Write into `out` (K,), Pa, the pressure on `grid`; allocates nothing of its own.

        Parameters
        ----------
        readings : (L,) array, in the quantity's unit
            All taxels valid: nothing is checked here.
        out : (K,) array
        deadline_ns : int, optional
            Of `time.perf_counter_ns`, for a solver that searches.
        """
        linear = self.quantity.linearise(readings, self._linear)
        if self._operator is None:
            np.dot(self._rows, linear, out=out)
        else:
            self._search(self._operator, linear, out, deadline_ns)

    def __call__(
        self,
        readings: ArrayLike,
        *,
        valid: ArrayLike | None = None,
        stamp_ns: int = 0,
        deadline: float | None = None,
    ) -> Estimate:
        """Answer one reading on the present rung.

        Parameters
        ----------
        readings : (L,) array, in the quantity's unit
            NaN marks a taxel that did not answer.
        valid : (L,) bool array, optional
            False for further taxels to leave out.
        stamp_ns : int, ns
        deadline : float, s, optional

        Raises
        ------
        InputError
            For a wrong number of taxels, an impossible reading, or none that is valid.
        """
        start = time.perf_counter_ns()
        if deadline is not None:
            check_positive("deadline", deadline, "seconds for the reading")
        table, mask = checked_readings(readings, valid, self.patch, self.quantity)
        if np.ndim(readings) != 1:
            raise InputError(
                f"readings has shape {np.shape(readings)}, expected ({len(self.patch)},): a ladder "
                "answers one reading at a time; a Reconstructor takes many"
            )
        good = mask[0]
        known = np.where(good, table[0], 0.0)
        linear = np.array(self.quantity.linearise(known, np.empty_like(known)))
        end = None if deadline is None else start + int(min(deadline, MOST) * 1e9)
        rest, operator = self._answer(linear, good, end)
        now = time.perf_counter_ns()
        notes = () if good.all() else (f"{int((~good).sum())} taxels left out",)
        return rest.estimate(
            latency=(now - start) * 1e-9,
            stamp_ns=stamp_ns,
            gap=0.0 if operator is None else float(getattr(operator, "gap", float("nan"))),
            iterations=int(getattr(operator, "iterations", 0)),
            deadline_met=end is None or now <= end,
            notes=notes,
        )

    def reset(self) -> None:
        """Forget the reading before, from which a search starts."""
        self._before = None
        for step in self.prepared.steps:
            reset = getattr(step.operator, "reset", None)
            if reset is not None:
                reset()

    def _search(
        self, operator: FieldOperator, linear: Floats, out: Floats, end: int | None
    ) -> None:
        """Answer by an operator; if it is another than before, from that one's dual variables."""
        before = self._before
        if before is not None and operator is not before and hasattr(operator, "start_from"):
            operator.start_from(before.dual)  # type: ignore[attr-defined]
        self._before = operator
        operator.apply(linear, out, end)

    def _answer(
        self, linear: Floats, valid: NDArray[np.bool_], end: int | None
    ) -> tuple[Rest, FieldOperator | None]:
        """What follows from linearised readings, 0 where not valid, and the operator that searched.

        A focus of a linear solver answers its window alone.
        """
        step, explained, window = self._step, self.prepared.explained, self._window
        operator = self._operator
        if operator is not None:
            if not valid.all():
                operator = offered(operator, "without")(valid)
            pressure = np.empty(len(step.grid))
            self._search(operator, linear, pressure, end)
        else:
            rows = self._rows
            if not valid.all():
                step, explained = self._without(valid.tobytes(), step.nodes)
                rows = step.matrix if window is None else step.matrix[window.nodes]
            pressure = np.asarray(rows @ linear)
        model = step.model

        def moved() -> Floats:
            if window is None:
                return step.deformation(pressure)
            return step.deformation(step.matrix @ linear)[window.nodes]

        def beliefs() -> Beliefs:
            if operator is not None or window is None:
                return step if operator is None else operator
            nodes, noise = window.nodes, PressureNoise(step.noise.factor[window.nodes])
            posterior = None if step.posterior is None else step.posterior.on(nodes)
            return replace(step, noise=noise, posterior=posterior)

        rest = Rest(
            grid=step.grid if window is None else window.grid,
            pressure=pressure,
            readings=linear,
            valid=valid,
            predicted=lambda: np.asarray(
                explained @ linear if model is None else model.matrix @ pressure
            ),
            moved=moved,
            beliefs=beliefs,
            finder=self.finder,
        )
        return rest, operator

    def _prepared_without(self, key: bytes, nodes: int) -> tuple[Rung, Floats]:
        """A linear solver's rung had the patch the valid taxels alone; what it predicts, (L, L).

        Of all readings: the others, by the bytes of a mask (L,), are multiplied by 0.
        """
        valid, prepared = np.frombuffer(key, np.bool_), self.prepared
        model = prepared.model.subset(valid)
        start = prepared.start.without(valid)
        if start is None:
            operator = self.solver.prepare(model)
            assert isinstance(operator, InverseOperator)  # as it is of all taxels
            start = operator
        made = linear_rung(nodes, self._at(nodes).deformation, start, model)
        matrix = np.zeros((len(made.grid), len(valid)))
        matrix[:, valid] = made.matrix
        explained = np.zeros((len(valid), len(valid)))
        explained[:, valid] = prepared.model.matrix @ start.matrix
        return replace(made, matrix=matrix), explained
