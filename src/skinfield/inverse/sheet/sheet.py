"""One sheet of very many taxels: a regularised pressure at a cost that grows with their number."""

import time
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_positive,
    check_shape,
)
from skinfield.inverse.gaussian_field import GaussianField
from skinfield.inverse.sheet.conjugate import Conjugate
from skinfield.inverse.sheet.deform import SheetDeformation
from skinfield.inverse.sheet.estimate import SheetEstimate
from skinfield.inverse.sheet.gram import parts_of
from skinfield.inverse.sheet.plan import SheetPlan
from skinfield.inverse.tikhonov import Tikhonov
from skinfield.mechanics import BondedLayer, Layer, Mechanics
from skinfield.observation import BaseStress, Quantity


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
        self.tolerance, self.most_iterations = tolerance, most_iterations
        self.precision = precision
        places = _places(positions)
        noise = self.quantity.typical_noise if noise_std is None else noise_std
        self.noise_std = _noise(noise, len(places))
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
        self._weights = np.zeros(len(places), dtype=precision)
        self._spread = parts_of(self.plan.spread, precision)
        self._read = parts_of(self.plan.read, precision)

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

    @cached_property
    def deformation(self) -> SheetDeformation:
        """From pressure to displacement."""
        return SheetDeformation(self.mechanics, self.layer, self.pitch)

    def reset(self) -> None:
        """Forget the reading before, from which the next one starts."""
        self._conjugate.reset()

    def apply(self, readings: NDArray[Any], out: NDArray[Any]) -> None:
        """Write the pressure (rows, columns) Pa of linearised readings (L,). No allocation.

        Both arrays of the sheet's precision, `out` in C order; NaN leaves a taxel out.
        """
        from skinfield.inverse.sheet.kernels import add_stamps, give_out

        check_shape("readings", readings, (len(self),), "one per taxel")
        check_shape("out", out, self.shape, "one per cell, sheet.shape")
        _check_like("readings", readings, self.precision)
        _check_like("out", out, self.precision)
        plan, conjugate = self.plan, self._conjugate
        conjugate.solve(readings, self.tolerance, self.most_iterations)
        give_out(conjugate.answer, plan.gain, self._weights)
        table, sign, work = self._spread
        columns = self.shape[1]
        add_stamps(
            self._weights, plan.spread_corner, plan.offset, table, sign, work, columns, out.ravel()
        )

    def __call__(self, readings: ArrayLike) -> SheetEstimate:
        """Reconstruct one reading (L,) in the quantity's unit; NaN leaves a taxel out."""
        begin = time.perf_counter()
        given = as_floats("readings", readings)
        check_shape("readings", given, (len(self),), "one per taxel, in the order of positions")
        _check_not_infinite(given)
        linear = self.quantity.linearise(given, np.empty_like(given))
        pressure = np.empty(self.shape, dtype=self.precision)
        self.apply(linear.astype(self.precision), pressure)
        latency = time.perf_counter() - begin
        weights = np.empty_like(self._weights)
        weights[self.plan.placing.order] = self._weights / self.plan.variance
        return SheetEstimate(
            self, linear, pressure, weights, self.iterations, self.relative_residual, latency
        )

    def predict(self, pressure: NDArray[Any]) -> Floats:
        """What the taxels read (L,) of a pressure (rows, columns) Pa: the linear map A."""
        from skinfield.inverse.sheet.kernels import read_stamps

        check_shape("pressure", pressure, self.shape, "one per cell, sheet.shape")
        table, sign, work = self._read
        sorted_out = np.empty(len(self), dtype=self.precision)
        field = np.ascontiguousarray(pressure, dtype=self.precision).ravel()
        plan, columns = self.plan, self.shape[1]
        corner = plan.placing.corner(plan.read.reach, columns)
        read_stamps(field, corner, plan.offset, table, sign, work, columns, sorted_out)
        out = np.empty(len(self))
        out[plan.placing.order] = sorted_out
        return out


def _places(positions: ArrayLike) -> Floats:
    places = as_floats("positions", positions)
    check_shape("positions", places, (None, 2), "x and y of each taxel in the plane, in metres")
    if not len(places):
        raise InputError("positions has no taxel, expected at least one")
    check_finite("positions", places, "a taxel without a place reads nothing that is known")
    return places


def _noise(noise_std: ArrayLike, taxels: int) -> Floats:
    noise = as_floats("noise_std", noise_std)
    if noise.ndim == 0:
        noise = np.full(taxels, float(noise))
    check_shape("noise_std", noise, (taxels,), "one number, or one per taxel")
    for index in np.flatnonzero(~(np.isfinite(noise) & (noise > 0.0)))[:1]:
        check_positive(f"noise_std[{index}]", float(noise[index]), "no reading is exact")
    return noise


def _check_like(name: str, array: NDArray[Any], precision: type) -> None:
    if array.dtype != precision or not array.flags.c_contiguous:
        raise InputError(
            f"{name} is of {array.dtype}, expected {np.dtype(precision)} in C order: what the "
            "sheet computes in is its precision"
        )


def _check_not_infinite(readings: Floats) -> None:
    bad = np.flatnonzero(np.isinf(readings))
    if len(bad):
        raise InputError(
            f"readings[{bad[0]}] is {readings[bad[0]]}, expected a finite number, or NaN for a "
            "taxel that did not answer"
        )
