"""One patch: from readings to fields and contacts."""

import time
from collections import OrderedDict
from dataclasses import dataclass, field
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

PLANS_KEPT = 16  # sets of valid taxels whose matrices stay prepared
CHUNK = 512  # readings per matrix product: the outputs stay in cache


@dataclass(eq=False)
class Reconstructor:
    """Prepared reconstruction of one patch; call it with readings.

    Parameters
    ----------
    patch : Patch
    layer : Layer
    grid : Grid, optional
        Where the answer is wanted. Default 40 x 40 nodes over the patch.
    mechanics : Mechanics
        `BondedLayer()`, or `HalfSpace()` as in the paper.
    quantity : Quantity
        What a reading is: `Capacitance()`, `BaseStress()` or `Gap()`.
    solver : Solver
        How readings become pressure.
    noise_std : float or (L,) array, in the quantity's unit, optional
        Standard deviation of one reading. Default the quantity's `typical_noise`.
    finder : ContactFinder
        How pressure becomes contacts.
    precision : numpy.float64 or numpy.float32
        Of the prepared matrix; float32 halves the time per reading.
    """

    patch: Patch
    layer: Layer = field(default_factory=Layer)
    grid: Grid | None = None  # type: ignore[assignment]
    mechanics: Mechanics = field(default_factory=BondedLayer)
    quantity: Quantity = field(default_factory=Capacitance)
    solver: Solver = field(default_factory=GaussianField)
    noise_std: ArrayLike | None = None
    finder: ContactFinder = field(default_factory=ContactFinder)
    precision: type[np.floating[Any]] = np.float64

    def __post_init__(self) -> None:
        self.grid: Grid = Grid.square(self.patch) if self.grid is None else self.grid
        if self.grid.patch is not self.patch:
            raise InputError(
                f"grid lies on patch {self.grid.patch.name!r}, expected {self.patch.name!r}: "
                "make the grid from the patch that is reconstructed"
            )
        noise = self.quantity.typical_noise if self.noise_std is None else self.noise_std
        self.model = ObservationModel.of(
            self.patch, self.layer, self.grid, self.mechanics, self.quantity, noise
        )
        self.deformation = Deformation(self.grid, self.layer, self.mechanics)
        self._plans: OrderedDict[bytes, Plan] = OrderedDict()
        self.plan = self._plan_for(np.ones(len(self.patch), np.bool_))
        self._linear = np.empty(len(self.patch), self.precision)

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
        self.quantity.linearise(readings, self._linear)
        np.dot(self.plan.operator, self._linear, out=out)

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
        pressure = np.empty((len(table), len(self.grid)))
        displacement = np.empty((len(table), len(self.grid), 3))
        residual = np.full(table.shape, np.nan)
        contacts: list[tuple[Contact, ...]] = [()] * len(table)
        std = self.plan.pressure_std
        patterns, which = np.unique(mask, axis=0, return_inverse=True)
        for index, pattern in enumerate(patterns):
            plan = self._plan_for(pattern)
            std = plan.pressure_std
            rows = np.flatnonzero(which.ravel() == index)
            for first in range(0, len(rows), CHUNK):
                part = rows[first : first + CHUNK]
                linear = np.empty((len(part), int(pattern.sum())))
                self.quantity.linearise(table[part][:, pattern], linear)
                fields = (plan.operator @ linear.T.astype(self.precision)).T
                pressure[part] = fields[:, : len(self.grid)]
                displacement[part] = np.moveaxis(
                    fields[:, len(self.grid) :].reshape(len(part), 3, -1), 1, 2
                )
                residual[np.ix_(part, np.flatnonzero(pattern))] = (
                    linear - pressure[part] @ plan.predict.T
                )
            for row in rows:
                contacts[row] = self.finder(self.grid, pressure[row], plan.noise)
        single = np.ndim(readings) == 1
        traction = -pressure[:, :, None] * self.grid.normals
        estimate = Estimate(
            grid=self.grid,
            pressure=pressure,
            traction=traction,
            displacement=displacement,
            pressure_std=std,
            contacts=tuple(contacts),
            residual=residual,
            valid=mask.all(axis=0) if not single else mask[0],
            stamp_ns=np.asarray(stamp_ns, dtype=np.int64),
            latency=time.perf_counter() - start,
        )
        return estimate[0] if single else estimate

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
        mask = ~np.isnan(table)
        if valid is not None:
            mask &= np.asarray(valid, dtype=np.bool_)
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
                self.model, self.deformation, self.solver, valid, self.precision
            )
        self._plans.move_to_end(key)
        return self._plans[key]
