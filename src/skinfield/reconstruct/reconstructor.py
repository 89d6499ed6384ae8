"""Reconstruction of one patch: from readings to fields and contacts, wherever a taxel sees."""

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import (
    Capacitance,
    Deformation,
    Layer,
    Mechanics,
    ObservationModel,
    Quantity,
    on_surface,
)
from skinfield.errors import (
    Floats,
    InputError,
    Ints,
    as_floats,
    as_stamps,
    check_positive,
    check_shape,
)
from skinfield.estimate import ContactFinder, Estimate
from skinfield.estimate.live_contacts import CONTACT
from skinfield.reconstruct.patch_model import PatchModel, check_parts
from skinfield.reconstruct.plan import LinearFields, Plan
from skinfield.signal.creep import CreepCompensation
from skinfield.skin import Grid, Patch, Skin
from skinfield.solve import Auto, Solver

SIGHT = 5.0  # thicknesses beyond a pad's rim at which a press is no longer seen


def support_of(grid: Grid, layer: Layer) -> tuple[Grid, Ints]:
    """Lattice that carries pressure under every taxel, and the grid's nodes in it.

    A window that leaves taxels out would have to explain their readings by pressure inside it.
    The answer is wanted in the window, but pressure is sought wherever a taxel sees.

    Returns
    -------
    support : Grid
        The grid itself where its cells hold all taxels.
    nodes : (K,) int array
        Where the grid's nodes stand in the support.

    Raises
    ------
    InputError
        If no taxel sees any of the grid's nodes.
    """
    _check_sight(grid, layer)
    taxels = grid.patch.plane
    last = grid.plane[-1]
    margin = grid.pitch * (0.5 + 1e-9)  # a cell holds what lies within half a pitch of its node
    before = np.ceil(np.maximum(grid.origin - margin - taxels.min(axis=0), 0.0) / grid.pitch)
    after = np.ceil(np.maximum(taxels.max(axis=0) - margin - last, 0.0) / grid.pitch)
    left, low = before.astype(int).tolist()
    right, high = after.astype(int).tolist()
    if not any((left, low, right, high)):
        return grid, np.arange(len(grid))
    rows, columns = grid.shape
    shape = (low + rows + high, left + columns + right)
    origin = grid.origin - np.array([left, low]) * grid.pitch
    row, column = np.divmod(np.arange(len(grid)), columns)
    return replace(grid, shape=shape, origin=origin), (row + low) * shape[1] + column + left


def _check_sight(grid: Grid, layer: Layer) -> None:
    from scipy.spatial import cKDTree

    patch = grid.patch
    nearest = float(np.min(cKDTree(patch.plane).query(grid.plane)[0]))
    sight = patch.pad_diameter / 2 + SIGHT * layer.thickness + grid.pitch
    if nearest > sight:
        raise InputError(
            f"the grid's nearest node is {nearest * 1e3:.1f} mm from any taxel of {patch.name!r}, "
            f"expected within {sight * 1e3:.1f} mm: nothing is measured there; move the window"
        )


class Reconstructor:
    """Prepared reconstruction of one patch, or of a whole skin; call it with readings.

    Of a `Skin`, of grids from coarse to fine such as (10, 20, 40), or with a `budget`, it is an
    `Engine`, whose parameters hold then: it answers all patches within one budget of time.

    Parameters
    ----------
    patch : Patch
    layer : Layer, optional
        Default `Layer()`: 2 mm of incompressible silicone of 150 kPa. Where it creeps
        (`relaxation`), readings with stamps are freed from what is left of those before: hand them
        in by one thread, in order, from when nothing pressed. Those without stamps are taken to
        have stood for long.
    grid : Grid, optional
        Where the answer is wanted. Default 40 x 40 nodes over the patch. Pressure outside of a
        window is sought as well, so that the window need not explain it.
    mechanics : Mechanics, optional
        Default `BondedLayer()`; `HalfSpace()` as in the paper.
    quantity : Quantity, optional
        What a reading is: `Capacitance()` (default), `BaseStress()` or `Gap()`.
    solver : Solver, optional
        What readings are explained by. Default `Auto()`: few contacts or a field, by evidence.
    noise_std : float or (L,) array, in the quantity's unit, optional
        Standard deviation of one reading. Default the quantity's `typical_noise`. What is solved
        for has more where the layer creeps; see `signal.creep`.
    finder : ContactFinder, optional
        How pressure becomes contacts.
    precision : numpy.float64 or numpy.float32
        Of the prepared matrix; float32 halves the time per reading.
    calibration : Calibration or TouchCalibration, optional
        As `skinfield.load_calibration` reads it. Readings are then counts, or whatever it was made
        from; noise, and by touches layer and mechanics, are those of the calibration.
    relative : bool, optional
        Whether forces hold up to one factor only, as gain or modulus are assumed; estimates say so.
        Default what a calibration by touches says, else False.

    Raises
    ------
    InputError
        For an argument that is something else, or that no skin can have.
    """

    def __new__(
        cls, patch: Any, layer: Any = None, grid: Any = None, **settings: Any
    ) -> "Reconstructor":
        """Make an engine where one is meant, see above."""
        if not isinstance(patch, Skin) and "budget" not in settings and not _are_rungs(grid):
            return super().__new__(cls)
        from skinfield.reconstruct.engine import Engine

        if grid is not None:
            settings["rungs"] = grid
        return Engine(patch, layer, **settings)  # type: ignore[return-value]

    def __init__(
        self,
        patch: Patch,
        layer: Layer | None = None,
        grid: Grid | None = None,
        *,
        mechanics: Mechanics | None = None,
        quantity: Quantity | None = None,
        solver: Solver | None = None,
        noise_std: ArrayLike | None = None,
        finder: ContactFinder | None = None,
        precision: type[np.floating[Any]] = np.float64,
        calibration: Any = None,
        relative: bool | None = None,
    ) -> None:
        self.patch = patch
        self.quantity = Capacitance() if quantity is None else quantity
        own = PatchModel.of(patch, calibration, self.quantity, layer, mechanics, relative)
        self.layer, self.mechanics, self.relative = own.layer, own.mechanics, own.relative
        self.solver: Solver = Auto() if solver is None else solver
        self.finder = ContactFinder() if finder is None else finder
        check_parts(self.solver, self.finder, grid)
        self.calibration, self._readings_from = own.calibration, own.readings
        grid = Grid.square(patch) if grid is None else grid.on(patch)
        self.grid = on_surface(grid, self.layer, self.mechanics)
        self.precision = precision
        self._creep = CreepCompensation.of(self.layer.relaxation, len(patch), self.quantity)
        noise = own.noise_std if noise_std is None else noise_std
        if self._creep.active:
            noise = as_floats("noise_std", noise) * self._creep.noise_factor
        support, nodes = support_of(self.grid, self.layer)
        self.model = ObservationModel.of(
            patch, self.layer, support, self.mechanics, self.quantity, noise
        )
        self.noise_std = self.model.noise_std / self._creep.noise_factor
        self.deformation = Deformation(support, self.layer, self.mechanics)
        alive = getattr(own.calibration, "alive", None)  # of counts
        parts = self.deformation, nodes, self.grid, self.finder, precision, alive
        self.plans = Plan(self.solver.prepare(self.model), *parts)
        self.plans.relative = self.relative
        self._linear = np.empty(len(patch), precision)
        self._run_in()

    @property
    def plan(self) -> LinearFields:
        """What is prepared for all taxels, of a linear solver."""
        linear = self.plans.linear
        if linear is None:
            raise InputError(
                f"{type(self.solver).__name__} is not linear, so it has no matrix: call the "
                "reconstructor with readings, or make it with solver=GaussianField()"
            )
        return linear

    @property
    def operator(self) -> NDArray[Any]:
        """The prepared matrix (4 K, L): pressure, then displacement x, y, z; all taxels valid."""
        return self.plan.fields

    def apply(self, readings: NDArray[Any], out: NDArray[Any]) -> None:
        """Write pressure and displacement of one reading into `out`; allocates nothing.

        Parameters
        ----------
        readings : (L,) array of `precision`, in the quantity's unit
            All taxels valid: nothing is checked here.
        out : (4 K,) array of `precision`
            Pressure (K) Pa, then displacement x, y, z (K each) m.
        """
        np.dot(self.plan.fields, self.quantity.linearise(readings, self._linear), out=out)

    def __call__(
        self,
        readings: ArrayLike,
        *,
        valid: ArrayLike | None = None,
        stamp_ns: ArrayLike = 0,
        deadline: float | None = None,
    ) -> Estimate:
        """Reconstruct one reading or a run of them.

        Parameters
        ----------
        readings : (L,) or (T, L) array, in the quantity's unit
            NaN marks a taxel that did not answer: it is left out, as if it were not there.
        valid : (L,) or (T, L) bool array, optional
            False for further taxels to leave out.
        stamp_ns : int or (T,) array, ns
        deadline : float, s, optional
            For each reading: an iterative solver then stops with its best answer so far.

        Returns
        -------
        Estimate
            With a leading axis T where the readings had one.

        Raises
        ------
        InputError
            For a wrong number of taxels, an infinite reading, or none that is valid.
        """
        start = time.perf_counter_ns()
        if self._readings_from is not None:
            readings = self._readings_from(as_floats("readings", readings))
        table, mask = checked_readings(readings, valid, self.patch, self.quantity)
        if deadline is not None:
            check_positive("deadline", deadline, "seconds for each reading")
        answer, stamps = self.plans.answer, as_stamps("stamp_ns", stamp_ns)
        if stamps.shape not in ((), (len(table),)):
            raise InputError(f"stamp_ns has shape {stamps.shape}, expected one, or ({len(table)},)")
        if self._creep.active:
            table = self._creep.taken(table, mask, np.broadcast_to(stamps, len(table)))
        if np.ndim(readings) == 1:
            return answer(table[0], mask[0], stamps.ravel()[0], start, deadline)
        rows = zip(table, mask, np.broadcast_to(stamps, len(table)), strict=True)
        each = [answer(*row, time.perf_counter_ns(), deadline) for row in rows]
        spent = (time.perf_counter_ns() - start) * 1e-9
        return Estimate.joined(each, stamp_ns=stamps, latency=spent)

    def rows(self, most: int = 8) -> NDArray[np.void]:
        """Room for so many contacts, for `into`: an array of `estimate.live_contacts.CONTACT`."""
        return np.zeros(most, CONTACT)

    def into(
        self,
        readings: Floats,
        out: NDArray[np.void],
        *,
        stamp_ns: int = 0,
        deadline: float | None = None,
    ) -> int:
        """Write the contacts of one reading into rows; allocates nothing.

        For loops: nothing is checked, and contacts go on from those of the call before.

        Parameters
        ----------
        readings : (L,) float64 array, in the quantity's unit
            All taxels valid. With a calibration, counts; these are converted anew at each call.
        out : structured array of `CONTACT`, such as `rows()`
            Receives the contacts by falling force; those after the last keep what they had.
        stamp_ns : int, ns
            By which contacts are known again.
        deadline : float, s, optional

        Returns
        -------
        int
            How many contacts there are, which may be more than rows.
        """
        if self._readings_from is not None:
            readings = self._readings_from(readings)
        if self._creep.active:
            readings = self._creep.next_of(readings, stamp_ns)
        return self.plans.write(readings, out, stamp_ns, deadline)

    def reset(self) -> None:
        """Forget the readings before: contacts and drift, from which solvers start, and creep.

        To be called between recordings.
        """
        self.plans.reset()
        self._creep.reset()

    def __repr__(self) -> str:
        rows, columns = self.grid.shape
        what = f"{type(self.solver).__name__}, {columns} x {rows} nodes"
        return f"Reconstructor({self.patch.name!r}, {what}, {self.layer!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies, and what another process gets, are prepared anew and have seen no reading."""
        names = (
            "mechanics",
            "quantity",
            "solver",
            "finder",
            "precision",
            "calibration",
            "relative",
            "noise_std",
        )
        settings = {name: getattr(self, name) for name in names}
        return partial(Reconstructor, **settings), (self.patch, self.layer, self.grid)

    def _run_in(self) -> None:
        """Load what is compiled, so that the first reading is as fast as the next."""
        zero, every = np.zeros(len(self.patch)), np.ones(len(self.patch), np.bool_)
        self.plans.answer(zero, every, np.int64(0), time.perf_counter_ns(), None)
        self.reset()
        self.plans.run_in()


def _are_rungs(grid: object) -> bool:
    """Whether these are numbers of nodes, of grids from coarse to fine."""
    return isinstance(grid, Sequence) and not isinstance(grid, str)


def checked_readings(
    readings: ArrayLike, valid: ArrayLike | None, patch: Patch, quantity: Quantity
) -> tuple[Floats, NDArray[np.bool_]]:
    """Readings (T, L), and which of them to use (T, L), or InputError for what no skin reads."""
    table = np.atleast_2d(as_floats("readings", readings))
    check_shape("readings", table, (None, len(patch)), f"one per taxel of {patch.name!r}")
    if not len(table):
        raise InputError("readings is empty, expected one reading or more")
    lowest, highest = quantity.lowest, quantity.highest
    if valid is None and table.min() > lowest and table.max() < highest:  # nor is any NaN
        every = np.empty(table.shape, np.bool_)
        every.fill(True)
        return table, every
    if np.isinf(table).any():
        row, taxel = np.argwhere(np.isinf(table))[0]
        raise InputError(
            f"readings[{row}, {taxel}] is {table[row, taxel]}, expected finite numbers: "
            "mark a taxel that did not answer with NaN"
        )
    impossible = np.argwhere((table <= lowest) | (table >= highest))
    if len(impossible):
        row, taxel = impossible[0]
        raise InputError(
            f"readings[{row}, {taxel}] is {table[row, taxel]}, expected between "
            f"{lowest:g} and {highest:g} ({len(impossible)} are not): no skin reads that; mark "
            "such taxels with NaN, and check the gain; counts need a calibration"
        )
    mask = ~np.isnan(table)
    if valid is not None:
        given = np.atleast_2d(np.asarray(valid, dtype=np.bool_))
        if given.shape not in (mask.shape, (1, mask.shape[1])):
            raise InputError(
                f"valid has shape {np.shape(valid)}, expected {mask.shape[1:]} or "
                f"{mask.shape}: one per taxel, or one per reading and taxel"
            )
        mask &= given
    empty = np.flatnonzero(~mask.any(axis=1))
    if len(empty):
        raise InputError(
            f"readings[{empty[0]}] has no valid taxel ({len(empty)} of {len(table)} readings), "
            "expected at least one: drop such readings"
        )
    return table, mask
