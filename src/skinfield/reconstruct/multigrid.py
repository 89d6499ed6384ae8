"""Multigrid reconstruction: one patch at several resolutions, from coarse to fine."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import BondedLayer, Capacitance, Layer, Mechanics, Quantity, check_skin
from skinfield.errors import Floats, InputError, check_offers, check_positive
from skinfield.estimate import Contact, ContactFinder, Estimate
from skinfield.reconstruct.multigrid_levels import Rung, linear_rung, prepare_rungs
from skinfield.reconstruct.plan import until
from skinfield.reconstruct.reconstructor import checked_readings
from skinfield.skin import Grid, Patch
from skinfield.solve import FieldOperator, GaussianField, InverseOperator, Solver
from skinfield.solve.operator import Beliefs


def estimate_of_pressure(
    grid: Grid,
    pressure: Floats,
    *,
    readings: Floats,
    valid: NDArray[np.bool_],
    predicted: Callable[[], Floats],
    moved: Callable[[], Floats],
    beliefs: Callable[[], Beliefs],
    finder: ContactFinder,
    **known: Any,
) -> Estimate:
    """Estimate of a pressure (K,), Pa; what else it holds is worked out when asked for.

    Parameters
    ----------
    readings : (L,) array
        Linearised.
    valid : (L,) bool array
    predicted : function that returns (L,) array
        Linearised readings that the answer predicts.
    moved : function that returns (K, 3) array, m
        Displacement.
    beliefs : function that returns Beliefs
    finder : ContactFinder
    **known
        Further attributes of the estimate.
    """

    def contacts() -> tuple[Contact, ...]:
        its = beliefs()
        return finder(grid, pressure, its.noise, its.posterior, its.model_error)

    rest: dict[str, Callable[[], Any]] = {
        "traction": lambda: -pressure[:, None] * grid.normals,
        "displacement": moved,
        "pressure_std": lambda: beliefs().pressure_std,
        "contacts": contacts,
        "residual": lambda: np.where(valid, readings - predicted(), np.nan),
    }
    return Estimate.later(rest, grid=grid, pressure=pressure, valid=valid, **known)


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
        self._before: FieldOperator | None = None  # that answered last
        self._linear = np.zeros(len(patch))
        self._without = lru_cache(SETS)(self._prepared_without)

    @property
    def rung(self) -> int:
        """Nodes along the sides of the grid that the next reading is answered on; may be set.

        A change costs nothing: every rung is prepared.
        """
        return self._step.nodes

    @rung.setter
    def rung(self, nodes: int) -> None:
        if nodes not in self._steps:
            raise InputError(f"rung is {nodes!r}, expected one of {self.rungs}")
        self._step = self._steps[nodes]

    @property
    def grid(self) -> Grid:
        """Nodes of the next answer."""
        return self._step.grid

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
        linear, step = self.quantity.linearise(readings, self._linear), self._step
        if step.operator is None:
            np.dot(step.matrix, linear, out=out)
        else:
            self._search(step.operator, linear, out, deadline_ns)

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
        end = until(deadline, start)
        answer, operator = self._answer(linear, good, end)
        now = time.perf_counter_ns()
        notes = () if good.all() else (f"{int((~good).sum())} taxels left out",)
        return answer(
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
    ) -> tuple[Callable[..., Estimate], FieldOperator | None]:
        """What makes the estimate of linearised readings, 0 where not valid; who searched."""
        step, explained = self._step, self.prepared.explained
        operator = step.operator
        if operator is None:
            if not valid.all():
                step, explained = self._without(valid.tobytes(), step.nodes)
            pressure = np.asarray(step.matrix @ linear)
        else:
            if not valid.all():
                without = getattr(operator, "without", None)
                if without is None:
                    raise InputError(
                        f"the solver's {type(operator).__name__} cannot leave out taxels, expected "
                        "one such as that of NonNegative(): prepare a Reconstructor of the others"
                    )
                operator = without(valid)
            pressure = np.empty(len(step.grid))
            self._search(operator, linear, pressure, end)
        model, beliefs = step.model, step if operator is None else operator
        answer = partial(
            estimate_of_pressure,
            step.grid,
            pressure,
            readings=linear,
            valid=valid,
            predicted=lambda: np.asarray(
                explained @ linear if model is None else model.matrix @ pressure
            ),
            moved=lambda: step.deformation(pressure),
            beliefs=lambda: beliefs,
            finder=self.finder,
        )
        return answer, operator

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
        made = linear_rung(nodes, self._steps[nodes].deformation, start, model)
        matrix = np.zeros((len(made.grid), len(valid)))
        matrix[:, valid] = made.matrix
        explained = np.zeros((len(valid), len(valid)))
        explained[:, valid] = prepared.model.matrix @ start.matrix
        return replace(made, matrix=matrix), explained
