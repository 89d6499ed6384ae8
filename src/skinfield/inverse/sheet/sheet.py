"""One sheet of very many taxels: a regularised pressure at a cost that grows with their number."""

import time
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, as_floats, check_positive, check_shape
from skinfield.inverse.gaussian_field import GaussianField
from skinfield.inverse.sheet.arguments import (
    check_like,
    check_physics,
    check_readings,
    check_settings,
    checked_noise,
    checked_places,
)
from skinfield.inverse.sheet.conjugate import FORGET, Conjugate
from skinfield.inverse.sheet.deform import SheetDeformation
from skinfield.inverse.sheet.estimate import SheetEstimate
from skinfield.inverse.sheet.gram import parts_of
from skinfield.inverse.sheet.plan import SheetPlan
from skinfield.inverse.sheet.search import highest_std
from skinfield.inverse.tikhonov import Tikhonov
from skinfield.mechanics import BondedLayer, Layer, Mechanics
from skinfield.observation import BaseStress, Quantity

MOST = 1e6  # s: a deadline that is as good as none


class Sheet:
    r"""Thousands to millions of taxels under one flat piece of elastomer.

    Parameters
    ----------
    positions : (L, 2) array, m
        Of the taxels in the plane, in any arrangement.
    layer : Layer, optional
    pitch : float, m
        Side of the cells on which the pressure is given.
    pad_diameter : float, m
        Of a taxel's round pad.
    mechanics : Mechanics, optional
        Default `BondedLayer()`.
    quantity : Quantity, optional
        What a taxel reads; default `BaseStress()`.
    noise_std : float or (L,) array, unit of the reading
        Of one reading; default typical of the quantity.
    solver : GaussianField or Tikhonov, optional
        The prior; default `GaussianField()`, whose smoothness is a quarter of the taxels' distance.
    tolerance : float
        Residual at which the iterations stop, as a share of the whitened readings.
    most_iterations : int
    cut : float
        Share of its peak below which a response is cut off, and of a taxel's own below which
        another's is.
    precision : numpy.float32 or numpy.float64

    Raises
    ------
    InputError
        If a value cannot be used, or a response is too wide for the cells.

    Notes
    -----
    With cells p of the covariance Q and whitening W = diag(1 / noise_std) the posterior mean is

    .. math:: \hat p = Q A^T W z, \qquad (W A Q A^T W + I) z = W y,

    a system in taxels alone, sparse because responses are short, and so well conditioned that
    conjugate gradients need some five steps. Pressure is taken to be possible on every cell that a
    taxel sees, also beyond the outermost ones: the lattice has that margin, and no stamp is cut.
    """

    def __init__(
        self,
        positions: ArrayLike,
        layer: Layer | None = None,
        *,
        pitch: float = 1.5e-3,
        pad_diameter: float = 4e-3,
        mechanics: Mechanics | None = None,
        quantity: Quantity | None = None,
        noise_std: ArrayLike | None = None,
        solver: GaussianField | Tikhonov | None = None,
        tolerance: float = 1e-3,
        most_iterations: int = 50,
        cut: float = 1e-3,
        precision: type[np.floating[Any]] = np.float32,
    ) -> None:
        self.layer = Layer() if layer is None else layer
        self.quantity: Quantity = BaseStress() if quantity is None else quantity
        self.mechanics: Mechanics = BondedLayer() if mechanics is None else mechanics
        check_physics(self.layer, self.mechanics, self.quantity)
        check_settings(tolerance, most_iterations, precision)
        self.tolerance, self.most_iterations = tolerance, most_iterations
        self.precision, self.pad_diameter = precision, pad_diameter
        places = checked_places(positions)
        noise = self.quantity.typical_noise if noise_std is None else noise_std
        self.noise_std = checked_noise(noise, len(places))
        solver = GaussianField() if solver is None else solver
        self.plan = SheetPlan(
            places,
            self.noise_std,
            self.layer,
            self.mechanics,
            self.quantity,
            solver,
            pitch,
            pad_diameter,
            cut,
            precision,
        )
        self._conjugate = Conjugate(self.plan.gram, self.plan.placing.order, self.plan.scale)
        self._stamping_ns, self._deadline_met = 0, True
        self._weights = np.zeros(len(places), dtype=precision)
        self._spread = parts_of(self.plan.stamps.spread, precision)
        self._read = parts_of(self.plan.stamps.read, precision)
        self._rehearse()

    def __len__(self) -> int:
        return len(self.noise_std)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of cells."""
        return self.plan.lattice.shape

    @property
    def pitch(self) -> float:
        """Side of a cell, m."""
        return self.plan.lattice.pitch

    @property
    def origin(self) -> Floats:
        """Centre of cell (0, 0), (2,) m."""
        return self.plan.lattice.origin

    @property
    def iterations(self) -> int:
        """Steps that the last reading took."""
        return self._conjugate.iterations

    @property
    def relative_residual(self) -> float:
        """What they left, as a share of the whitened readings."""
        return self._conjugate.relative_residual

    @property
    def deadline_met(self) -> bool:
        """Whether the last pressure was there in time; True where no deadline was set."""
        return self._deadline_met

    @cached_property
    def deformation(self) -> SheetDeformation:
        """From pressure to displacement."""
        return SheetDeformation(self.mechanics, self.layer, self.pitch, self.shape)

    @cached_property
    def highest_std(self) -> float:
        """Deviation of the pressure by the readings' noise, Pa, that few cells exceed."""
        return highest_std(self.plan)

    def reset(self) -> None:
        """Forget the reading before, from which the next one starts."""
        self._conjugate.reset()

    def apply(
        self, readings: NDArray[Any], out: NDArray[Any], deadline_ns: int | None = None
    ) -> None:
        """Write the pressure (rows, columns) Pa of linearised readings (L,). No allocation.

        Both arrays of the sheet's precision, `out` in C order; NaN leaves a taxel out.
        `deadline_ns` is a time of `time.perf_counter_ns`; iterations stop early enough to write
        the pressure by then, as far as the times of the readings before tell.
        """
        check_shape("readings", readings, (len(self),), "one per taxel")
        check_shape("out", out, self.shape, "one per cell, sheet.shape")
        check_like("readings", readings, self.precision)
        check_like("out", out, self.precision)
        self._apply(readings, out, self.most_iterations, deadline_ns)

    def _apply(
        self, readings: NDArray[Any], out: NDArray[Any], most: int, deadline_ns: int | None
    ) -> None:
        from skinfield.inverse.sheet.kernels import add_stamps, give_out

        plan, conjugate = self.plan, self._conjugate
        last = None if deadline_ns is None else deadline_ns - self._stamping_ns
        conjugate.solve(readings, self.tolerance, most, last)
        begin = time.perf_counter_ns()
        give_out(conjugate.answer, plan.gain, self._weights)
        columns = self.shape[1]
        add_stamps(self._weights, plan.corner, plan.offset, self._spread, columns, out.ravel())
        end = time.perf_counter_ns()
        self._stamping_ns = max(end - begin, self._stamping_ns - self._stamping_ns // FORGET)
        self._deadline_met = deadline_ns is None or end <= deadline_ns

    def _rehearse(self) -> None:
        """Load the machine code and learn what a step and the stamps take."""
        some, out = self.noise_std.astype(self.precision), np.empty(self.shape, self.precision)
        for _ in range(2):  # from nothing, then from the reading before
            self._conjugate.step_ns = self._stamping_ns = 0
            self._apply(some, out, 1, None)
        self.reset()

    def __call__(self, readings: ArrayLike, *, deadline: float | None = None) -> SheetEstimate:
        """Reconstruct one reading (L,) in the quantity's unit; NaN leaves a taxel out.

        With a `deadline` in seconds from the call the iterations stop early, see `apply`.
        """
        begin = time.perf_counter()
        if deadline is not None:
            check_positive("deadline", deadline, "seconds from the call")
        given = as_floats("readings", readings)
        check_shape("readings", given, (len(self),), "one per taxel, in the order of positions")
        check_readings(given, self.noise_std, self.quantity.lowest)
        linear = self.quantity.linearise(given, np.empty_like(given))
        pressure = np.empty(self.shape, dtype=self.precision)
        until = None if deadline is None else int((begin + min(deadline, MOST)) * 1e9)
        self.apply(linear.astype(self.precision), pressure, until)
        latency = time.perf_counter() - begin
        weights = np.empty_like(self._weights)
        weights[self.plan.placing.order] = self._weights / self.plan.variance
        return SheetEstimate(
            self,
            linear,
            pressure,
            weights,
            self.iterations,
            self.relative_residual,
            latency,
            self.deadline_met,
        )

    def predict(self, pressure: NDArray[Any]) -> Floats:
        """What the taxels read (L,) of a pressure (rows, columns) Pa: the linear map A."""
        from skinfield.inverse.sheet.kernels import read_stamps

        check_shape("pressure", pressure, self.shape, "one per cell, sheet.shape")
        sorted_out = np.empty(len(self), dtype=self.precision)
        field = np.ascontiguousarray(pressure, dtype=self.precision).ravel()
        plan, columns = self.plan, self.shape[1]
        corner = plan.placing.corner(plan.stamps.read.reach, columns)
        read_stamps(field, corner, plan.offset, self._read, columns, sorted_out)
        out = np.empty(len(self))
        out[plan.placing.order] = sorted_out
        return out
