"""The whole skin: all patches of a cycle within one budget of time."""

import time
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.contacts import ContactFinder
from skinfield.engine.again import done_again, told_by
from skinfield.engine.answers import estimate_of, grid_of
from skinfield.engine.clockwork import NS
from skinfield.engine.cost import CostModel
from skinfield.engine.estimates import Estimates
from skinfield.engine.intake import Readings
from skinfield.engine.interning import check_names, one_skin
from skinfield.engine.linear_stages import answer_linearly, finest_for_all, refine_linearly
from skinfield.engine.making import clockwork_of, groups_of
from skinfield.engine.measure import run_in
from skinfield.engine.report import CycleReport, Snapshot
from skinfield.engine.results import Results
from skinfield.engine.search_stages import begin_search, spend
from skinfield.engine.shadow import Shadow
from skinfield.errors import Floats, Ints, check_offers, check_positive
from skinfield.fields import Estimate
from skinfield.inverse import NonNegative, Solver
from skinfield.layout import Patch, Skin
from skinfield.mechanics import BondedLayer, Layer, Mechanics
from skinfield.observation import Capacitance, Quantity

RETURN, BEYOND = 0, 1  # what is learnt beside the steps: the way back, and how late a cycle ends
MOST_KEPT = 0.1  # of the budget, for each of these
ENDLESS = 1e6  # s: no cycle takes longer, and its end fits into 64 bits of ns
FOR_ALL = "seconds for all patches of a cycle"
KEPT = 4096  # grids of patches that were asked for


class Engine:
    """All patches of a skin, reading after reading, within one budget of time.

    Each cycle every patch first gets an idle test, and a coarse linear answer if it is touched.
    What is left of the budget goes to the contacts, as iterations and as resolution, wherever they
    gain most for their time. Times are predicted, and no step is begun that would not fit, but for
    a contact that waited too long.

    Parameters
    ----------
    skin : Skin or Patch
    layer : Layer, or mapping from names of patches to Layer, optional
        Default `Layer()` over all.
    budget : float, s
        Of one cycle, for all patches together.
    rungs : sequence of int
        Nodes along the sides of the grids, from coarse to fine.
    mechanics : Mechanics, optional
        Default `BondedLayer()`.
    quantity : Quantity, optional
        What a reading is. Default `Capacitance()`.
    solver : Solver, optional
        Default `NonNegative()`; a linear one answers all patches by matrix products.
    noise_std : float or (L,) array, or mapping from names of patches to such, optional
        In the quantity's unit. Default the quantity's `typical_noise`.
    finder : ContactFinder, optional
    clock : function that returns ns, optional
        By which time is told. Default `time.perf_counter_ns`, which the solvers go by.

    Raises
    ------
    InputError
        For arguments that do not fit, and for a solver that has neither a linear operator nor a
        search that can be cut short, such as `ContactFit`.

    Notes
    -----
    Patches of equal geometry, layer and noise share one plan, and are evaluated as one matrix
    product. An engine works in its own arrays: one thread at a time.
    """

    def __init__(
        self,
        skin: Skin | Patch,
        layer: Layer | Mapping[str, Layer] | None = None,
        *,
        budget: float = 500e-6,
        rungs: Sequence[int] = (10, 20, 40),
        mechanics: Mechanics | None = None,
        quantity: Quantity | None = None,
        solver: Solver | None = None,
        noise_std: ArrayLike | Mapping[str, ArrayLike] | None = None,
        finder: ContactFinder | None = None,
        clock: Callable[[], int] = time.perf_counter_ns,
    ) -> None:
        check_positive("budget", budget, FOR_ALL)
        self.skin, self.budget, self.rungs = one_skin(skin), float(budget), tuple(rungs)
        self.mechanics = BondedLayer() if mechanics is None else mechanics
        self.quantity = Capacitance() if quantity is None else quantity
        self.solver = NonNegative() if solver is None else solver
        self.finder = ContactFinder() if finder is None else finder
        check_offers("solver", self.solver, ("prepare",), "one such as NonNegative()")
        check_offers("finder", self.finder, ("__call__",), "one such as ContactFinder()")
        for name, given in (("layer", layer), ("noise_std", noise_std)):
            if isinstance(given, Mapping):
                check_names(name, given, self.skin)
        self.names = tuple(patch.name for patch in self.skin)
        self.cycle = 0
        self.groups = groups_of(
            self.skin, layer, noise_std, self.rungs, self.mechanics, self.quantity, self.solver
        )
        self._work = clockwork_of(self.groups, self.skin, self.quantity, clock)
        self._ordered = tuple(self._work.intake.names)
        self._around = CostModel(np.array([20e-6, 5e-6]))
        self.results = Results(self._work, [self._ordered.index(name) for name in self.names])
        self.spent = self.first = 0.0
        self._grid_of = lru_cache(KEPT)(partial(grid_of, self._work))
        self._shadow: Shadow | None = None
        run_in(self)

    def __call__(
        self,
        readings: Readings,
        *,
        valid: Mapping[str, ArrayLike] | None = None,
        stamp_ns: int = 0,
        budget: float | None = None,
    ) -> Estimates:
        """Answer one cycle.

        Parameters
        ----------
        readings : mapping from names of patches to (L,) array, or sequence in the skin's order
            In the quantity's unit. NaN, and numbers that no skin reads, mark taxels that did not
            answer. A patch without a reading (not in the mapping, or None) is reported as missing.
        valid : mapping from names of patches to (L,) bool array, optional
            False for further taxels to leave out.
        stamp_ns : int, ns
        budget : float, s, optional
            Of this cycle in place of the engine's own.

        Returns
        -------
        Estimates
            Mapping from names to `Estimate`, with the `report` of the cycle.

        Raises
        ------
        InputError
            For another number of taxels, or a name that no patch has.
        """
        start = self._begin(budget)
        self._work.logging = True
        self._work.begin(readings, valid)
        hot, first = self._answer()
        return Estimates(self, self.cycle + 1, self._close(hot, start, first), stamp_ns)

    def run(
        self,
        readings: Floats,
        valid: NDArray[np.bool_] | None = None,
        *,
        budget: float | None = None,
        script: ArrayLike | None = None,
    ) -> None:
        """Answer one cycle into `results` alone: for loops that allocate nothing.

        Parameters
        ----------
        readings : (N,) float64 array
            Of all taxels, patch by patch in the skin's order. NaN, and numbers that no skin reads,
            mark taxels that did not answer; a patch without any other is missing.
        valid : (N,) bool array, optional
            False for further taxels to leave out.
        budget : float, s, optional
        script : (S, 5) int64 array, optional
            Of a cycle that is to be done again, see `again`; the budget then plays no part.

        Raises
        ------
        InputError
            For arrays of another shape or type, and as `again`.
        """
        start = self._begin(budget)
        told = None if script is None else told_by(script, self._work)
        self._work.logging = False
        self._work.begin_flat(readings, valid)
        hot, first = self._answer() if told is None else (done_again(self._work, told), start)
        self._finish(hot, start, first)

    def again(
        self,
        readings: Readings,
        *,
        valid: Mapping[str, ArrayLike] | None = None,
        stamp_ns: int = 0,
        script: ArrayLike,
    ) -> Estimates:
        """Answer one cycle as an engine did before, whatever time it takes now.

        From a `reset` on, cycle by cycle, the answers are the same bit for bit: on this machine, or
        one with a processor of the same kind, and with the same libraries.

        Parameters
        ----------
        readings, valid, stamp_ns
            As they were then.
        script : (S, 5) int64 array
            What `script` was after that cycle.

        Returns
        -------
        Estimates

        Raises
        ------
        InputError
            For a script that no such engine writes, or of a search that ends otherwise.
        """
        start = self._begin(None)
        told = told_by(script, self._work)
        self._work.logging = True
        self._work.begin(readings, valid)
        hot = done_again(self._work, told)
        return Estimates(self, self.cycle + 1, self._close(hot, start, start), stamp_ns)

    @property
    def script(self) -> Ints:
        """What of the last cycle depended on time, (S, 5): a view, see `again` and `Script`."""
        return self._work.script.rows

    def _begin(self, budget: float | None) -> int:
        """Set the end of a cycle; returns its start, ns."""
        work, around = self._work, self._around
        start = work.clock()
        check_positive("budget", given := self.budget if budget is None else budget, FOR_ALL)
        self._granted = given = float(given)
        most = MOST_KEPT * given
        reserve = min(around.predict(RETURN), most) + min(around.predict(BEYOND), most)
        work.end = start + int((min(given, ENDLESS) - reserve) / NS)
        return start

    def _answer(self) -> tuple[Ints, int]:
        """Patches with a contact, and when every patch had its first answer, ns."""
        work = self._work
        if work.linear:
            answer_linearly(work, rung := finest_for_all(work))
            first = work.clock()
            return refine_linearly(work, rung), first
        hot, first = begin_search(work), work.clock()
        return spend(work, hot), first

    def _close(self, hot: Ints, start: int, first: int) -> CycleReport:
        """End a cycle and report."""
        snapshot = self._finish(hot, start, first, report=True)
        assert snapshot is not None
        return CycleReport(
            budget=self._granted,
            spent=self.spent,
            first=(first - start) * NS,
            started=start,
            overrun=self.spent > self._granted,
            names=self._ordered,
            _log=tuple(self._work.log),
            _snapshot=snapshot,
        )

    def _finish(self, hot: Ints, start: int, first: int, report: bool = False) -> Snapshot | None:
        """Remember who was served, and learn how long the end of a cycle takes."""
        work, around = self._work, self._around
        before, left = work.clock(), work.left
        work.close(hot, around)
        self.cycle += 1
        self.results.update()
        snapshot = Snapshot.of(work, left, self.rungs) if report else None
        end = work.clock()
        around.observe(RETURN, (end - before) * NS)
        around.observe(BEYOND, max(-left, 0.0))
        self.spent, self.first = (end - start) * NS, (first - start) * NS
        return snapshot

    def estimate_of(self, name: str, stamp_ns: int, report: CycleReport) -> Estimate:
        """Estimate of one patch from the last cycle, whose report this is."""
        patch = self._ordered.index(name)
        return estimate_of(self._work, self.finder, patch, self._grid_of, stamp_ns, report)

    def rehearse(self, budget: float | None = None) -> None:
        """Answer a rehearsed touch elsewhere: nothing changes, and the next cycle is quick.

        What a processor has not used for some milliseconds it fetches anew, which may take longer
        than a cycle. For loops with more time than readings; the first call prepares it.
        """
        self._shadow = Shadow(self) if self._shadow is None else self._shadow
        self._shadow.run(budget)

    def reset(self) -> None:
        """Forget the readings before, from which searches start; costs stay known."""
        self._work.reset()
