"""Engine of the whole skin: all patches of a cycle within one budget of time."""

import time
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import Capacitance, Layer, Mechanics, Quantity
from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_count,
    check_positive,
)
from skinfield.estimate import ContactFinder
from skinfield.plot import duration, plural
from skinfield.reconstruct.engine.intake import EngineReadings, Readings
from skinfield.reconstruct.engine.patch_kinds import (
    PatchGroup,
    check_names,
    kinds_of,
    layer_of,
    one_skin,
)
from skinfield.reconstruct.engine.report import CycleReport
from skinfield.reconstruct.engine.results import Estimates, PatchResults, estimate_of, grid_on
from skinfield.reconstruct.engine.stages import answer_linearly, spend
from skinfield.reconstruct.engine.state import NS
from skinfield.reconstruct.engine.workspace import Clockwork
from skinfield.reconstruct.multigrid import prepare_rungs
from skinfield.reconstruct.patch_model import PatchModel, calibrations_of, check_parts
from skinfield.signal.creep import CreepCompensation
from skinfield.skin import Patch, Skin
from skinfield.solve import Auto, Solver
from skinfield.solve.atoms.fitter import STOPPED
from skinfield.solve.operator import DeadlineMargin

MOST_KEPT = 0.2  # of the budget, for what remains to be done after the last step
ENDLESS = 1e6  # s: no cycle takes longer, and its end fits into 64 bits of ns
FOR_ALL = "seconds for all patches of a cycle"
KEPT = 4096  # grids of patches that were asked for


class Engine:
    """All patches of a skin, reading after reading, within one budget of time.

    Each cycle every patch first gets an idle test, and a coarse linear answer if it is touched.
    What is left of the budget goes to searches of the touched patches, by turns, what was searched
    longest ago first. No search is begun that would not fit, but for that of a contact that waited
    too long.

    Parameters
    ----------
    skin : Skin or Patch
    layer : Layer, or mapping from names of patches to Layer, optional
        Default `Layer()` over all. What a patch reads is freed from what creep has left, by the
        stamps of cycles; `run`, which takes none, leaves that to its caller.
    budget : float, s
        Of one cycle, for all patches together.
    rungs : sequence of int
        Nodes along the sides of the grids, from coarse to fine.
    mechanics : Mechanics, optional
        Default `BondedLayer()`.
    quantity : Quantity, optional
        What a reading is. Default `Capacitance()`.
    solver : Solver, optional
        Default `Auto()`; a linear one answers all patches by matrix products.
    noise_std : float or (L,) array, or mapping from names of patches to such, optional
        In the quantity's unit. Default the quantity's `typical_noise`.
    finder : ContactFinder, optional
    calibration : Calibration or TouchCalibration, or mapping from names of patches to such
        As `skinfield.load_calibration` reads it. Readings of these patches are then counts, or
        whatever it was made from; noise, and by touches layer and mechanics, are those of it.
    relative : bool, optional
        Whether forces hold up to one factor only; estimates say so. Default what calibrations by
        touches say, else False.
    clock : function that returns ns, optional
        By which time is told. Default `time.perf_counter_ns`, which the solvers go by.

    Raises
    ------
    InputError
        For arguments that do not fit, and for a solver that has neither a linear operator nor a
        test of idle patches.

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
        calibration: Any = None,
        relative: bool | None = None,
        clock: Callable[[], int] = time.perf_counter_ns,
        progress: Callable[[int, int], None] = lambda ready, patches: None,
    ) -> None:
        check_positive("budget", budget, FOR_ALL)
        self._settings = {
            "layer": layer, "budget": budget, "rungs": rungs, "mechanics": mechanics,
            "quantity": quantity, "solver": solver, "noise_std": noise_std, "finder": finder,
            "calibration": calibration, "relative": relative, "clock": clock,
        }  # fmt: skip
        self.skin, self.budget, self.rungs = one_skin(skin), float(budget), tuple(rungs)
        self.quantity = Capacitance() if quantity is None else quantity
        own = self._by_calibration(calibration, layer, mechanics, relative)
        self.mechanics = next(iter(own.values())).mechanics
        self.relative = any(each.relative for each in own.values())
        if calibration is not None:
            layer = layer or {name: each.layer for name, each in own.items()}
            if noise_std is None or isinstance(noise_std, Mapping):
                usual = {name: each.noise_std for name, each in own.items()}
                noise_std = {**usual, **(noise_std or {})}
        self.solver: Solver = Auto() if solver is None else solver
        self.finder = ContactFinder() if finder is None else finder
        check_parts(self.solver, self.finder, None)
        self.names = tuple(patch.name for patch in self.skin)
        for name, given in (("layer", layer), ("noise_std", noise_std)):
            if isinstance(given, Mapping):
                check_names(name, given, self.names)
        self.cycle = 0
        self.groups = self._prepared(layer, noise_std, progress)
        self._work = self._clockwork(clock)
        self._ordered = tuple(self._work.intake.names)
        solids = [layer_of(patch, layer).relaxation for patch in self.skin]
        starts = np.cumsum([0, *(len(patch) for patch in self.skin)])
        self._creep = CreepCompensation(solids, starts, self.quantity)
        self._margin = DeadlineMargin()
        self.results = PatchResults(self._work, [self._ordered.index(name) for name in self.names])
        self.spent = self.first = 0.0
        places = self._work.places
        self._grid_of = lru_cache(KEPT)(lambda patch, rung: grid_on(*places[patch], rung))
        self._counted: dict[str, Callable[[Floats], Floats]] = {}
        self._run_in()
        self._counted = {name: each.readings for name, each in own.items() if each.readings}

    def __repr__(self) -> str:
        patches, name = plural(len(self.skin), "patch", "patches"), self.skin.name
        budget, solver = duration(self.budget), type(self.solver).__name__
        return f"Engine({name!r}, {patches}, {solver}, within {budget})"

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies, and what another process gets, are prepared anew and have seen no reading."""
        return partial(Engine, **self._settings), (self.skin,)

    def _by_calibration(
        self,
        calibration: Any,
        layer: Layer | Mapping[str, Layer] | None,
        mechanics: Mechanics | None,
        relative: bool | None,
    ) -> dict[str, PatchModel]:
        """Model of each patch by its name; raises InputError where their mechanics differ."""
        known, made = calibrations_of(self.skin, calibration), {}
        for patch in self.skin:
            its = layer.get(patch.name) if isinstance(layer, Mapping) else layer
            physics = self.quantity, its, mechanics, relative
            made[patch.name] = PatchModel.of(patch, known.get(patch.name), *physics)
        kinds = {repr(each.mechanics): name for name, each in made.items()}
        if len(kinds) > 1:
            raise InputError(
                f"mechanics of {' and '.join(kinds.values())} differ by their calibrations "
                f"({', '.join(kinds)}), expected one for all patches: hand in mechanics="
            )
        return made

    def _read(self, readings: Readings) -> Readings:
        """Readings of what was recorded, where patches have a calibration."""
        if not self._counted:
            return readings

        def of(name: str, row: ArrayLike | None) -> Any:
            counted = self._counted.get(name)
            if counted is None or row is None:
                return row
            return counted(as_floats(f"readings[{name!r}]", row))

        if isinstance(readings, Mapping):
            return {name: of(name, row) for name, row in readings.items()}
        if len(readings) != len(self.names):
            return readings  # which is refused
        return [of(name, row) for name, row in zip(self.names, readings, strict=True)]

    def _prepared(
        self,
        layer: Layer | Mapping[str, Layer] | None,
        noise_std: ArrayLike | Mapping[str, ArrayLike] | None,
        progress: Callable[[int, int], None],
    ) -> list[PatchGroup]:
        """Prepare each kind of patch once.

        `progress` is called before each with the patches that are ready, and how many there are.
        """
        typical = self.quantity.typical_noise
        noise = typical if noise_std is None else noise_std
        physics = self.mechanics, self.quantity
        groups: list[PatchGroup] = []
        first = 0
        for index, kind in enumerate(kinds_of(self.skin, layer, noise, typical)):
            progress(first, len(self.skin))
            patch = kind.patches[0]
            rungs = prepare_rungs(
                patch, kind.layer, self.rungs, *physics, self.solver, kind.noise_std
            )
            groups.append(PatchGroup(index, first, kind, rungs))
            first += len(kind.patches)
        return groups

    def _clockwork(self, clock: Callable[[], int]) -> Clockwork:
        """Arrays of all patches, those of one kind side by side."""
        patches = [patch for group in self.groups for patch in group.kind.patches]
        noise = [np.tile(group.kind.noise_std, group.count) for group in self.groups]
        order = [self.names.index(patch.name) for patch in patches]
        intake = EngineReadings(patches, order, self.quantity, np.concatenate(noise))
        return Clockwork(self.groups, intake, clock)

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
            In the quantity's unit; with a calibration, counts. NaN, and numbers that no skin reads,
            mark taxels that did not answer. A patch without a reading (not in the mapping, or None)
            is reported as missing.
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
        work, cycle = self._work, self.cycle + 1
        work.intake.take(self._read(readings), valid)
        if self._creep.active:
            work.intake.undo_creep(self._creep, stamp_ns)
        left = self._run(start)
        report = CycleReport.of(
            work,
            self._ordered,
            self.rungs,
            left,
            budget=self._granted,
            spent=self.spent,
            first=self.first,
            started=start,
            overrun=self.spent > self._granted,
        )
        return Estimates(
            {patch.name: patch.link for patch in self.skin},
            lambda name: estimate_of(
                *(work, self.finder, self._ordered.index(name), self._grid_of),
                *(stamp_ns, report, self.relative),
            ),
            lambda: self.cycle == cycle,
            report,
        )

    def run(
        self,
        readings: Floats,
        valid: NDArray[np.bool_] | None = None,
        deviation: Floats | None = None,
        *,
        budget: float | None = None,
    ) -> None:
        """Answer one cycle into `results` alone: for loops that allocate nothing.

        Parameters
        ----------
        readings : (N,) float64 array
            Of all taxels, patch by patch in the skin's order; with a calibration, counts, which
            are converted anew at each call. NaN, and numbers that no skin reads,
            mark taxels that did not answer; a patch without any other is missing.
        valid : (N,) bool array, optional
            False for further taxels to leave out.
        deviation : (N,) float64 array, optional
            Standard deviation of each reading, as of means of several, for solvers that find
            contacts. Default the engine's `noise_std`, by which all else goes.
        budget : float, s, optional

        Raises
        ------
        InputError
            For arrays of another shape or type.
        """
        start = self._begin(budget)
        if self._counted and len(readings) == len(self._work.intake.given):
            ends = np.cumsum([len(patch) for patch in self.skin])[:-1]
            rows = self._read(np.split(readings, ends))
            readings = np.concatenate([np.asarray(row) for row in rows])
        self._work.intake.take_flat(readings, valid, deviation)
        self._run(start)

    def go_on(self, *, budget: float | None = None) -> bool:
        """Search further in the last readings; returns whether any patch was left to search.

        Those are patches that something touches, and whose search was not begun, or not ended, for
        want of time. All others are missing from the `results`.

        Parameters
        ----------
        budget : float, s, optional
        """
        work = self._work
        if not work.waits():
            return False
        self._run(self._begin(budget))
        return True

    @property
    def notes(self) -> dict[str, list[str]]:
        """What searches said of the readings of each patch, by its name, where it lasts."""
        return {
            patch.name: texts
            for group in self.groups
            for patch, data in zip(group.kind.patches, group.last, strict=True)
            if data is not None
            and (texts := [each for each in data.solution.notes if not each.startswith(STOPPED)])
        }

    def _begin(self, budget: float | None) -> int:
        """Set the end of a cycle; returns its start, ns."""
        work, start = self._work, self._work.clock()
        check_positive("budget", given := self.budget if budget is None else budget, FOR_ALL)
        self._granted = given = float(given)
        whole = int(min(given, ENDLESS) / NS)
        work.end = start + whole - min(self._margin.margin_ns, int(MOST_KEPT * whole))
        return start

    def _run(self, start: int) -> float:
        """Answer what was taken in, and learn how late a cycle ends.

        Returns the time that was left after the last step, s.
        """
        work = self._work
        work.open()
        if work.linear:
            answer_linearly(work)
            first = work.clock()
        else:
            work.test_idle()
            first = work.clock()
            spend(work)
        left, solved = work.left, work.clock()
        work.close()
        self.cycle += 1
        self.results.update()
        end = work.clock()
        self._margin.learn(start + int(min(self._granted, ENDLESS) / NS), solved, end)
        self.spent, self.first = (end - start) * NS, (first - start) * NS
        return left

    @property
    def searches(self) -> bool:
        """Whether touched patches are searched by turns, rather than answered by a matrix."""
        return not self._work.linear

    @property
    def finds_contacts(self) -> bool:
        """Whether the solver finds contacts by itself."""
        return self._work.finds_contacts

    def reset(self) -> None:
        """Forget the readings before, from which searches start, and what they left."""
        self._work.reset()
        self._creep.reset()

    def _run_in(self) -> None:
        """Load what is compiled and time linear answers, so that the first cycle is as the next."""
        measure(self._work)
        touch = rehearsed_cycle(self._work)
        for _ in range(3):
            self(touch, budget=60.0)
        self.run(np.zeros(len(self._work.intake.given)), budget=60.0)
        self.reset()
        self.cycle = 0


def prefer(engine: "Engine", finest: int | None = None, first: int | None = None) -> None:
    """Say how the next cycles spend their time.

    Idle tests are made on the finest rung all the same: no touch goes unnoticed.

    Parameters
    ----------
    engine : Engine
    finest : int, optional
        Rung beyond which no patch is answered, counted from the coarsest. Default the finest.
    first : int, optional
        Patch, in the skin's order, that is served before all others, and on any rung.

    Raises
    ------
    InputError
        If there is no such rung or patch.
    """
    work = engine._work
    top = work.rungs - 1
    if finest is not None:
        check_count("finest", finest, 0, top, "rung, counted from the coarsest")
        top = finest
    row = -1
    if first is not None:
        check_count("first", first, 0, len(engine.names) - 1, "patch, in the skin's order")
        row = engine.results.row_of(first)
    work.prefer(top, row)


LAPS = 9  # of each kind of patch; the first one, which loads what is compiled, does not count
RADIUS = 1.0  # of a rehearsed touch, pitches of the taxels
STRONG = 20.0  # standard deviations of the noise that it reads


def measure(work: Clockwork) -> None:
    """Measure what coarse linear answers take, which are left time for in the end."""
    work.intake.white[:] = 0.0
    for group in work.groups:
        laps, white = [], work.white[group.index]
        for _ in range(LAPS + 1):
            start = work.clock()
            group.answer_all(0, white)
            laps.append(work.since(start))
        work.costs[group.index] = np.median(laps[1:])  # the machine may do something else meanwhile


def rehearsed_cycle(work: Clockwork) -> dict[str, Floats]:
    """Readings of a touch on the first patch of each kind, by the names of patches."""
    rng, names = np.random.default_rng(1), work.intake.names
    readings = {}
    for group in work.groups:
        for place in range(group.count):
            touch = np.zeros(len(group.kind.noise_std))
            if place == 0 and not work.linear:
                touch = rehearsed(group, work.rungs - 1, rng)
            readings[names[group.first + place]] = touch
    return readings


def rehearsed(group: PatchGroup, rung: int, rng: "np.random.Generator") -> Floats:
    """Readings (L,) of a round touch at a random taxel, without noise."""
    step = group.rungs.steps[rung]
    model = step.operator.model
    centre = model.taxels[rng.integers(len(model.taxels))]
    distance = np.linalg.norm(step.grid.plane - centre, axis=1)
    reach = max(RADIUS * step.grid.patch.pitch, 0.75 * step.grid.pitch)
    readings = model.matrix @ (distance <= reach).astype(np.float64)
    highest = float(np.abs(readings / model.noise_std).max())
    return np.asarray(readings * (STRONG / max(highest, 1e-300)))
