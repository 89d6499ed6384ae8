"""One patch at several resolutions, of which any can be the next reading's."""

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.contacts import ContactFinder
from skinfield.errors import Floats, InputError, check_offers, check_positive
from skinfield.fields import Estimate
from skinfield.inverse import GaussianField, Solver
from skinfield.layout import Grid, Patch
from skinfield.mechanics import BondedLayer, Layer, Mechanics
from skinfield.observation import Capacitance, Quantity, check_skin
from skinfield.pipeline.arguments import checked_readings
from skinfield.pipeline.ladder_estimate import Linear, Rest, rest_of_search
from skinfield.pipeline.ladder_focus import Window, box_of_contact
from skinfield.pipeline.ladder_missing import ValidSets
from skinfield.pipeline.ladder_rungs import Rung, prepare_rungs
from skinfield.pipeline.ladder_walk import Walk, offered
from skinfield.pipeline.plan import MOST

EDGE = 0.2  # of the highest pressure: where a contact that is looked at ends


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
        self._rows: Floats | None = None  # of a linear answer in the window
        self._operator = self._step.operator
        self._walk = Walk()
        self._linear = np.zeros(len(patch))
        self._sets = ValidSets(self.prepared, self.solver)
        self._last: tuple[Grid, Floats] | None = None

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
        self._window = self._rows = None

    def _at(self, nodes: int) -> Rung:
        step = self._steps.get(nodes)
        if step is None:
            raise InputError(f"rung is {nodes!r}, expected one of {self.rungs}")
        return step

    @property
    def grid(self) -> Grid:
        """Nodes of the next answer."""
        if self._window is not None and self._rows is not None:
            return self._window.grid
        return self._step.grid

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
        self._window = window
        if self._operator is None:
            self._rows = np.ascontiguousarray(self._step.matrix[window.nodes])
            return
        seldom = round(self._step.nodes / before)
        self._operator = offered(self._operator, "within")(window.candidates(seldom))

    def focus_on_contact(self, margin: float, rung: int | None = None) -> bool:
        """Focus on what pressed in the last answer; False, and no change, if nothing did.

        Parameters
        ----------
        margin : float, m
            Around the cells that exceed a fifth of the highest pressure.
        rung : int, optional
            Density inside. Default the finest.
        """
        check_positive("margin", margin, "metres around the contact")
        if self._last is None:
            raise InputError("nothing was answered yet, expected a reading before the focus on it")
        box = box_of_contact(*self._last, EDGE)
        if box is None:
            return False
        self.focus(box[0] - margin, box[1] + margin, rung)
        return True

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
            np.dot(self._step.matrix if self._rows is None else self._rows, linear, out=out)
        else:
            self._walk.apply(self._operator, linear, out, deadline_ns)

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
        rest = self._answer(linear, good, end)
        self._last = rest.grid, rest.pressure
        now = time.perf_counter_ns()
        notes = () if good.all() else (f"{int((~good).sum())} taxels left out",)
        return rest.estimate(
            latency=(now - start) * 1e-9,
            stamp_ns=stamp_ns,
            gap=0.0 if self._operator is None else self._walk.gap,
            iterations=self._walk.iterations,
            deadline_met=end is None or now <= end,
            notes=notes,
        )

    def reset(self) -> None:
        """Forget the reading before, from which a search starts."""
        self._walk.forget()
        for step in self.prepared.steps:
            reset = getattr(step.operator, "reset", None)
            if reset is not None:
                reset()

    def _answer(self, linear: Floats, valid: NDArray[np.bool_], end: int | None) -> Rest:
        """Pressure of linearised readings, 0 where they are not valid, and what follows from it."""
        step, operator = self._step, self._operator
        if operator is None:
            known = None if valid.all() else self._sets.of(valid)
            window = None if self._rows is None else self._window
            answered = Linear(self.prepared, step, window, self._rows, known)
            return answered.rest(linear, valid, self.finder)
        if not valid.all():
            operator = offered(operator, "without")(valid)
            step = replace(step, operator=operator)
        out = np.empty(len(step.grid))
        self._walk.apply(operator, linear, out, end)
        return rest_of_search(step, out, linear, valid, self.finder)
