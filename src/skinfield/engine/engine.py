"""The whole skin: all patches of a cycle within one budget of time."""

import time
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from skinfield.contacts import ContactFinder
from skinfield.engine.answers import estimate_of, grid_on
from skinfield.engine.clockwork import NS, Clockwork
from skinfield.engine.cost import CostModel
from skinfield.engine.estimates import Estimates
from skinfield.engine.group import Group
from skinfield.engine.intake import Intake, Readings
from skinfield.engine.interning import check_names, kinds_of, one_skin
from skinfield.engine.linear_stages import answer_linearly, refine_linearly
from skinfield.engine.measure import measure, rehearsed_cycle
from skinfield.engine.report import CycleReport, Snapshot
from skinfield.engine.search_stages import begin_search, spend
from skinfield.errors import Ints, check_offers, check_positive
from skinfield.fields import Estimate
from skinfield.inverse import NonNegative, Solver
from skinfield.layout import Grid, Patch, Skin
from skinfield.mechanics import BondedLayer, Layer, Mechanics
from skinfield.observation import Capacitance, Quantity, check_skin
from skinfield.pipeline.ladder_rungs import prepare_rungs

RETURN, BEYOND = 0, 1  # what is learnt beside the steps: the way back, and how late a cycle ends
MOST_KEPT = 0.1  # of the budget, for each of these
ENDLESS = 1e6  # s: no cycle takes longer, and its end fits into 64 bits of ns
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
        check_positive("budget", budget, "seconds for all patches of a cycle")
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
        self.groups = self._groups(layer, noise_std)
        self._work = self._clockwork(clock)
        self._around = CostModel(np.array([20e-6, 5e-6]))
        self._grid_of = lru_cache(KEPT)(self._new_grid)
        self._run_in()

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
        work, around = self._work, self._around
        start = work.clock()
        budget = self.budget if budget is None else self._checked(budget)
        reserve = sum(min(around.predict(k), MOST_KEPT * budget) for k in (RETURN, BEYOND))
        work.end = start + int((min(budget, ENDLESS) - reserve) / NS)
        work.begin(readings, valid)
        if work.linear:
            answer_linearly(work)
            first = work.clock()
            hot = refine_linearly(work)
        else:
            begin_search(work)
            first = work.clock()
            hot = spend(work)
        report = self._close(hot, budget, start, first)
        return Estimates(self, self.cycle, report, stamp_ns)

    def _close(self, hot: Ints, budget: float, start: int, first: int) -> CycleReport:
        """End a cycle: remember who was served, learn how long the end takes, and report."""
        work, around = self._work, self._around
        before, left = work.clock(), work.left
        work.state.finish(hot)
        self.cycle += 1
        snapshot = Snapshot.of(work, left, self.rungs)
        end = work.clock()
        around.observe(RETURN, (end - before) * NS)
        around.observe(BEYOND, max(-left, 0.0))
        around.relax()
        work.model.relax()
        work.typical.relax()
        spent = (end - start) * NS
        return CycleReport(
            budget=budget,
            spent=spent,
            first=(first - start) * NS,
            started=start,
            overrun=spent > budget,
            names=self._ordered,
            _log=tuple(work.log),
            _snapshot=snapshot,
        )

    def estimate_of(self, name: str, stamp_ns: int, report: CycleReport) -> Estimate:
        """Estimate of one patch from the last cycle, whose report this is."""
        patch = self._ordered.index(name)
        return estimate_of(self._work, self.finder, patch, self._grid_of, stamp_ns, report)

    def reset(self) -> None:
        """Forget the readings before, from which searches start; costs stay known."""
        self._work.reset()

    def _checked(self, budget: float) -> float:
        check_positive("budget", budget, "seconds for all patches of a cycle")
        return float(budget)

    def _groups(
        self,
        layer: Layer | Mapping[str, Layer] | None,
        noise_std: ArrayLike | Mapping[str, ArrayLike] | None,
    ) -> list[Group]:
        """Prepare each kind of patch once."""
        typical = self.quantity.typical_noise
        noise = typical if noise_std is None else noise_std
        groups, first = [], 0
        for index, kind in enumerate(kinds_of(self.skin, layer, noise, typical)):
            patch = kind.patches[0]
            check_skin(patch, kind.layer, self.mechanics, self.quantity)
            rungs = prepare_rungs(
                patch,
                kind.layer,
                self.rungs,
                self.mechanics,
                self.quantity,
                self.solver,
                kind.noise_std,
            )
            groups.append(Group(index, first, kind, rungs))
            first += len(kind.patches)
        return groups

    def _clockwork(self, clock: Callable[[], int]) -> Clockwork:
        patches = [patch for group in self.groups for patch in group.kind.patches]
        self._ordered = tuple(patch.name for patch in patches)
        noise = [np.tile(group.kind.noise_std, group.count) for group in self.groups]
        order = [self.names.index(name) for name in self._ordered]
        intake = Intake(patches, order, self.quantity, np.concatenate(noise))
        return Clockwork(self.groups, intake, clock)

    def _new_grid(self, patch: int, rung: int) -> Grid:
        group = self.groups[self._work.state.group[patch]]
        return grid_on(group, patch - group.first, rung)

    def _run_in(self) -> None:
        """Load what is compiled and time every step, so that the first cycle is as the next."""
        measure(self._work)
        touch = rehearsed_cycle(self._work)
        for _ in range(3):
            self(touch, budget=60.0)
        self.reset()
        self.cycle = 0
