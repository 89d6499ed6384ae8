"""Multigrid reconstruction: one patch at several resolutions, from coarse to fine."""

import time
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic import BondedLayer, Capacitance, Layer, Mechanics, Quantity, check_skin
from skinfield.errors import Floats, InputError, check_offers, check_positive
from skinfield.estimate import ContactFinder, Estimate
from skinfield.reconstruct.multigrid_levels import averaged, prepare_rungs
from skinfield.reconstruct.plan import estimate_of_solution, until
from skinfield.reconstruct.reconstructor import checked_readings
from skinfield.skin import Grid, Patch
from skinfield.solve import GaussianField, Operator, Solution, Solver

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
        Default `GaussianField()`.
    noise_std : float or (L,) array, in the quantity's unit, optional
        Default the quantity's `typical_noise`.
    finder : ContactFinder, optional

    Raises
    ------
    InputError
        For arguments that do not fit.

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
        steps = self.prepared.steps
        self._steps = {each.nodes: each for each in steps}
        self._step = steps[-1]
        self._data: dict[int, Any] = {each.nodes: each.operator.data() for each in steps}
        self._before: Any = None  # memory of the last answer
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
        np.copyto(out, self._solve(self._step.operator, readings, deadline_ns).pressure)

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
        step, good, end = self._step, mask[0], until(deadline, start)
        operator = step.operator
        if not good.all():
            operator = self._without(good.tobytes(), step.nodes)
        solution = self._solve(operator, table[0], end).keep()
        now = time.perf_counter_ns()
        missing = () if good.all() else (f"{int((~good).sum())} taxels left out",)
        return estimate_of_solution(
            *(solution, good, step.grid, step.deformation, self.finder),
            latency=(now - start) * 1e-9,
            stamp_ns=stamp_ns,
            deadline_met=end is None or now <= end,
            notes=(*missing, *solution.notes),
        )

    def reset(self) -> None:
        """Forget the reading before, from which a search starts."""
        self._before = None
        for data in self._data.values():
            data.reset()

    def _solve(self, operator: Operator, readings: Floats, end: int | None) -> Solution:
        """Answer on the present rung; after another one, from where that ended."""
        data, before = self._data[self._step.nodes], self._before
        if before is not None and data is not before:
            data.start_from(before)
        self._before = data
        return operator.solve(readings, data, end)

    def _prepared_without(self, key: bytes, nodes: int) -> Operator:
        """A rung's operator without taxels, by the bytes of a mask (L,) of the valid ones."""
        step, valid = self._steps[nodes], np.frombuffer(key, np.bool_)
        if self.prepared.linear:
            return averaged(self.prepared.start.without(valid), step.grid)
        return step.operator.without(valid)
