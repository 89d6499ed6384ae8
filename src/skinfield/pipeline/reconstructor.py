"""One patch: from readings to fields and contacts."""

import time
from collections import OrderedDict
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.contacts import ContactFinder
from skinfield.errors import Floats, InputError, as_floats, check_shape
from skinfield.fields import Contact, Estimate
from skinfield.inverse import GaussianField, Solver
from skinfield.layout import Grid, Patch
from skinfield.mechanics import BondedLayer, Layer, Mechanics
from skinfield.observation import Capacitance, Deformation, ObservationModel, Quantity
from skinfield.pipeline.plan import Plan, make_plan
from skinfield.pipeline.support import support_of

PLANS_KEPT = 16  # sets of valid taxels whose matrices stay prepared
CHUNK = 512  # readings per matrix product: the outputs stay in cache


class Reconstructor:
    """Prepared reconstruction of one patch; call it with readings.

    Parameters
    ----------
    patch : Patch
    layer : Layer, optional
        Default `Layer()`: 2 mm of incompressible silicone of 150 kPa.
    grid : Grid, optional
        Where the answer is wanted. Default 40 x 40 nodes over the patch. Pressure outside of a
        window is sought as well, so that the window need not explain it.
    mechanics : Mechanics, optional
        Default `BondedLayer()`; `HalfSpace()` as in the paper.
    quantity : Quantity, optional
        What a reading is: `Capacitance()` (default), `BaseStress()` or `Gap()`.
    solver : Solver, optional
        How readings become pressure. Default `GaussianField()`.
    noise_std : float or (L,) array, in the quantity's unit, optional
        Standard deviation of one reading. Default the quantity's `typical_noise`.
    finder : ContactFinder, optional
        How pressure becomes contacts.
    precision : numpy.float64 or numpy.float32
        Of the prepared matrix; float32 halves the time per reading.
    """

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
    ) -> None:
        self.patch = patch
        self.layer = Layer() if layer is None else layer
        self.grid = Grid.square(patch) if grid is None else grid.on(patch)
        self.mechanics = BondedLayer() if mechanics is None else mechanics
        self.quantity = Capacitance() if quantity is None else quantity
        self.solver = GaussianField() if solver is None else solver
        self.finder = ContactFinder() if finder is None else finder
        self.precision = precision
        noise = self.quantity.typical_noise if noise_std is None else noise_std
        support, self._nodes = support_of(self.grid, self.layer)
        self.model = ObservationModel.of(
            patch, self.layer, support, self.mechanics, self.quantity, noise
        )
        self.deformation = Deformation(support, self.layer, self.mechanics)
        self._plans: OrderedDict[bytes, Plan] = OrderedDict()
        self.plan = self._plan_for(np.ones(len(patch), np.bool_))
        self._operator = self.plan.operator
        self._linear = np.empty(len(patch), precision)
        self._run_in()

    @property
    def operator(self) -> NDArray[Any]:
        """The prepared matrix (4 K, L): pressure, then displacement x, y, z; all taxels valid."""
        return self.plan.operator

    def apply(self, readings: NDArray[Any], out: NDArray[Any]) -> None:
        """Write pressure and displacement of one reading into `out`; allocates nothing.

        Parameters
        ----------
        readings : (L,) array of `precision`, in the quantity's unit
            All taxels valid: nothing is checked here.
        out : (4 K,) array of `precision`
            Pressure (K) Pa, then displacement x, y, z (K each) m.
        """
        np.dot(self._operator, self.quantity.linearise(readings, self._linear), out=out)

    def __call__(
        self,
        readings: ArrayLike,
        *,
        valid: ArrayLike | None = None,
        stamp_ns: ArrayLike = 0,
    ) -> Estimate:
        """Reconstruct one reading or a run of them.

        Parameters
        ----------
        readings : (L,) or (T, L) array, in the quantity's unit
            NaN marks a taxel that did not answer: it is left out, as if it were not there.
        valid : (L,) or (T, L) bool array, optional
            False for further taxels to leave out.
        stamp_ns : int or (T,) array, ns

        Returns
        -------
        Estimate
            With a leading axis T where the readings had one.

        Raises
        ------
        InputError
            For a wrong number of taxels, an infinite reading, or none that is valid.
        """
        start = time.perf_counter()
        table, mask = self._checked(readings, valid)
        stamps = np.asarray(stamp_ns, dtype=np.int64)
        if stamps.shape not in ((), (len(table),)):
            raise InputError(f"stamp_ns has shape {stamps.shape}, expected one, or ({len(table)},)")
        nodes = len(self.grid)
        fields = np.empty((len(table), 4 * nodes))
        residual = np.full(table.shape, np.nan)
        std = np.empty((len(table), nodes))
        contacts: list[tuple[Contact, ...]] = [()] * len(table)
        patterns, which = np.unique(mask, axis=0, return_inverse=True)
        for index, pattern in enumerate(patterns):
            plan = self._plan_for(pattern)
            rows = np.flatnonzero(which.ravel() == index)
            std[rows] = plan.pressure_std
            for first in range(0, len(rows), CHUNK):
                part = rows[first : first + CHUNK]
                residual[np.ix_(part, pattern)] = self._run(plan, table, part, fields)
            for row in rows:
                contacts[row] = self.finder(self.grid, fields[row, :nodes], plan.noise)
        pressure = fields[:, :nodes]
        estimate = Estimate(
            grid=self.grid,
            pressure=pressure,
            traction=-pressure[:, :, None] * self.grid.normals,
            displacement=np.moveaxis(fields[:, nodes:].reshape(len(table), 3, nodes), 1, 2),
            pressure_std=std,
            contacts=tuple(contacts),
            residual=residual,
            valid=mask,
            stamp_ns=stamps,
            latency=time.perf_counter() - start,
        )
        return estimate[0] if np.ndim(readings) == 1 else estimate

    def _run(self, plan: Plan, table: Floats, rows: NDArray[np.int64], fields: Floats) -> Floats:
        """Fill the rows of `fields`; return their residuals (rows, valid taxels)."""
        readings = table[np.ix_(rows, plan.valid)]
        linear = self.quantity.linearise(readings, np.empty_like(readings))
        fields[rows] = (plan.operator @ linear.T.astype(self.precision)).T
        return np.asarray(linear - linear @ plan.explained.T)

    def _run_in(self) -> None:
        """Load what is compiled, so that the first reading is as fast as the next."""
        self(np.zeros(len(self.patch)))
        peak = np.zeros(len(self.grid))
        peak[0] = 1e3 * max(float(self.plan.noise.std.max()), 1.0)
        self.finder(self.grid, peak, self.plan.noise)

    def _checked(
        self, readings: ArrayLike, valid: ArrayLike | None
    ) -> tuple[Floats, NDArray[np.bool_]]:
        table = np.atleast_2d(as_floats("readings", readings))
        check_shape(
            "readings", table, (None, len(self.patch)), f"one per taxel of {self.patch.name!r}"
        )
        if np.isinf(table).any():
            row, taxel = np.argwhere(np.isinf(table))[0]
            raise InputError(
                f"readings[{row}, {taxel}] is {table[row, taxel]}, expected finite numbers: "
                "mark a taxel that did not answer with NaN"
            )
        impossible = np.argwhere(table <= self.quantity.lowest)
        if len(impossible):
            row, taxel = impossible[0]
            raise InputError(
                f"readings[{row}, {taxel}] is {table[row, taxel]}, expected above "
                f"{self.quantity.lowest:g} ({len(impossible)} are not): no skin reads that; mark "
                "such taxels with NaN, and check the gain"
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

    def _plan_for(self, valid: NDArray[np.bool_]) -> Plan:
        key = np.packbits(valid).tobytes()
        if key not in self._plans:
            if len(self._plans) >= PLANS_KEPT:
                self._plans.popitem(last=False)
            self._plans[key] = make_plan(
                self.model, self.deformation, self.solver, valid, self._nodes, self.precision
            )
        self._plans.move_to_end(key)
        return self._plans[key]
