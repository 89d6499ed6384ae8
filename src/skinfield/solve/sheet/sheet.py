"""Sheet of thousands to millions of taxels: arguments, and conjugate gradients that solve it."""

import time
from functools import cache, cached_property
from time import perf_counter_ns
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import (
    BaseStress,
    BondedLayer,
    LatticeConvolution,
    Layer,
    Mechanics,
    Physics,
    Quantity,
    check_skin,
    displacement_kernel,
)
from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_count,
    check_offers,
    check_positive,
    check_range,
    check_shape,
)
from skinfield.estimate import ContactFinder, Estimate
from skinfield.skin import Patch
from skinfield.solve.linear import GaussianField, Tikhonov, taxel_distance
from skinfield.solve.repair import repaired
from skinfield.solve.sheet.contacts import WindowNoise, contacts_on, highest_std
from skinfield.solve.sheet.plan import TOO_DENSE, Gram, SheetPlan, parts_of

NOISE = 1e-20, 1e12  # in any unit of a reading
LARGEST = 1e12  # deviations of the noise: their squares add up in single precision


def checked_noise(noise_std: ArrayLike, taxels: int) -> Floats:
    """One standard deviation per taxel, (L,)."""
    noise = as_floats("noise_std", noise_std)
    if noise.ndim == 0:
        noise = np.broadcast_to(noise, (taxels,))
    check_shape("noise_std", noise, (taxels,), "one number, or one per taxel")
    for index in np.flatnonzero(~((noise >= NOISE[0]) & (noise <= NOISE[1])))[:1]:
        check_range(f"noise_std[{index}]", float(noise[index]), *NOISE, "no reading is exact")
    return noise


def check_like(name: str, array: NDArray[Any], precision: type[Any]) -> None:
    """Raise InputError unless an array is one that the kernels take as it is."""
    if array.dtype != precision or not array.flags.c_contiguous:
        raise InputError(
            f"{name} is of {array.dtype}, expected {np.dtype(precision)} in C order: what the "
            "sheet computes in is its precision"
        )


def check_readings(readings: Floats, noise_std: Floats, lowest: float) -> None:
    """Raise InputError for a reading that no skin gives; NaN stands for none."""
    for index in np.flatnonzero(np.abs(readings) > LARGEST * noise_std)[:1]:
        raise InputError(
            f"readings[{index}] is {readings[index]}, expected at most {LARGEST:g} times its "
            f"noise_std of {noise_std[index]:g}, or NaN for a taxel that did not answer"
        )
    for index in np.flatnonzero(readings <= lowest)[:1]:
        raise InputError(
            f"readings[{index}] is {readings[index]}, expected above {lowest:g}: no skin reads "
            "that; mark such taxels with NaN, and check the gain"
        )


FORGET = 16  # steps in which a slow one is forgotten
LARGEST_SQUARE = 1e34  # square of the whitened readings: products of single precision end at 3e38


class Conjugate:
    """Solver of D (W A Q A^T W + I) D u = b, whose diagonal is made 1 by D.

    Every array is made once. A taxel that did not answer is left out by holding its u at 0, which
    takes its row and column out of the matrix.

    Parameters
    ----------
    gram : Gram
        Its values scaled, so that the diagonal is 1.
    order : (L,) int array
        Row of each taxel in the readings.
    scale : (L,) array
        From a reading to b.

    Attributes
    ----------
    answer, valid : (L,) arrays
        u, and 1 for each taxel that answered, else 0.
    room : (L,) array
        For whatever is needed between two readings.
    iterations : int
    relative_residual : float
        As a share of the norm of b.
    step_ns : int
        What a step took lately, at its slowest.
    """

    def __init__(self, gram: Gram, order: NDArray[Any], scale: NDArray[Any]) -> None:
        self.gram, self.order, self.scale = gram, order, scale
        self.iterations, self.step_ns, self.relative_residual = 0, 0, 0.0
        self.valid = np.ones_like(scale)
        self.answer, self._target, self._residual, self._way, self.room = (
            np.zeros_like(scale) for _ in range(5)
        )

    def reset(self) -> None:
        """Forget the reading before."""
        self.answer[:] = 0.0

    def solve(
        self, readings: NDArray[Any], tolerance: float, most: int, deadline_ns: int | None = None
    ) -> None:
        """Find the answer to linearised readings (L,), NaN where a taxel did not answer.

        Stops where the norm of the residual falls to `tolerance` of that of b, or after `most`
        steps, or where another step would end after `deadline_ns` of `time.perf_counter_ns`.
        Starts from the answer before if that is nearer than 0.
        """
        from skinfield.solve.sheet.kernels import descend, take_in, turn

        answer, valid = self.answer, self.valid
        residual, way, moved = self._residual, self._way, self.room
        whole = take_in(readings, self.order, self.scale, self._target, valid, answer)
        if not whole < LARGEST_SQUARE:
            raise InputError(
                f"readings are {np.sqrt(whole):g} deviations of their noise, expected finite ones "
                f"below {np.sqrt(LARGEST_SQUARE):g}: mark taxels that did not answer with NaN"
            )
        square = self._begin(whole)
        self.iterations = 0
        enough = tolerance**2 * whole
        turn(0.0, residual, way, moved)
        while square > enough and self.iterations < most:
            begin = perf_counter_ns()
            if deadline_ns is not None and begin + self.step_ns > deadline_ns:
                break
            curved = self._multiply(way, moved)
            if not curved > 0.0:
                raise InputError(TOO_DENSE)
            before, square = square, descend(square / curved, way, moved, valid, answer, residual)
            turn(square / before, residual, way, moved)
            self.iterations += 1
            spent = perf_counter_ns() - begin
            self.step_ns = max(spent, self.step_ns - self.step_ns // FORGET)
        self.relative_residual = float(np.sqrt(square / whole)) if whole > 0.0 else 0.0

    def _begin(self, whole: float) -> float:
        """Write the first residual; return the square of its norm."""
        residual = self._residual
        if self.answer.any():
            self.room[:] = self.answer
            self._multiply(self.answer, self.room)
            np.subtract(self._target, self.room, out=residual)
            residual *= self.valid
            square = float(residual @ residual)
            if square < whole:
                return square
            self.answer[:] = 0.0
        residual[:] = self._target
        return whole

    def _multiply(self, vector: NDArray[Any], out: NDArray[Any]) -> float:
        """Write M v over v in `out`; return v . M v."""
        from skinfield.solve.sheet.kernels import multiply

        gram = self.gram
        return float(multiply(gram.start, gram.other, gram.value, vector, out))


MOST = 1e6  # s: a deadline that is as good as none
FAINT = 1e-5  # of the largest: what a displacement kernel is cut at
LONGEST = 256  # cells from a load to the end of its displacement
BLOCK = 16  # reaches along a side of cells whose displacement is found together


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
        Its `common_mode` is not used: so many taxels hardly share an offset.
    finder : ContactFinder, optional
        How pressure becomes contacts. Its rate of false alarms is that of the whole sheet.
    tolerance : float
        Residual at which the iterations stop, as a share of the whitened readings.
    most_iterations : int
    cut : float
        Share of its peak below which a response is cut off, and of a taxel's own below which
        another's is.
    precision : numpy.float32 or numpy.float64

    Attributes
    ----------
    patch : Patch
        The taxels.
    grid : Grid
        The K cells.
    deadline_met : bool
        Whether the last pressure was there in time; True where no deadline was set.

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
        finder: ContactFinder | None = None,
        tolerance: float = 1e-3,
        most_iterations: int = 50,
        cut: float = 1e-3,
        precision: type[np.floating[Any]] = np.float32,
    ) -> None:
        self.layer = Layer() if layer is None else layer
        self.quantity: Quantity = BaseStress() if quantity is None else quantity
        self.mechanics: Mechanics = BondedLayer() if mechanics is None else mechanics
        check_range("tolerance", tolerance, 1e-12, 0.5, "a share of the whitened readings")
        check_count("most_iterations", most_iterations, 1, 10_000, "some ten are usual")
        if precision not in (np.float32, np.float64):
            raise InputError(
                f"precision is {precision!r}, expected numpy.float32 or numpy.float64: the first "
                "is faster, the second for comparisons"
            )
        self.tolerance, self.most_iterations = tolerance, most_iterations
        self.precision = precision
        positions = as_floats("positions", positions)
        check_shape("positions", positions, (None, 2), "x and y of each taxel in the plane, in m")
        self.patch = Patch(positions, pad_diameter, name="sheet")
        check_skin(self.patch, self.layer, self.mechanics, self.quantity)
        self.finder = ContactFinder() if finder is None else finder
        check_offers("finder", self.finder, ("__call__", "sigmas"), "one such as ContactFinder()")
        noise = self.quantity.typical_noise if noise_std is None else noise_std
        self.noise_std = checked_noise(noise, len(self.patch))
        solver = GaussianField() if solver is None else solver
        physics = Physics(self.layer, self.mechanics, self.quantity, pad_diameter)
        self.plan = SheetPlan(self.patch, self.noise_std, physics, solver, pitch, cut, precision)
        self.grid = self.plan.lattice
        self._conjugate = Conjugate(self.plan.gram, self.plan.placing.order, self.plan.scale)
        self._stamping_ns, self.deadline_met = 0, True
        self._spread = parts_of(self.plan.stamps.spread, precision)
        self._read = parts_of(self.plan.stamps.read, precision)
        self._rehearse()

    def __len__(self) -> int:
        return len(self.noise_std)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of cells."""
        return self.grid.shape

    @property
    def pitch(self) -> float:
        """Side of a cell, m."""
        return self.grid.pitch

    @property
    def origin(self) -> Floats:
        """Centre of cell (0, 0), (2,) m."""
        return self.grid.origin

    @property
    def iterations(self) -> int:
        """Steps that the last reading took."""
        return self._conjugate.iterations

    @property
    def relative_residual(self) -> float:
        """What they left, as a share of the whitened readings."""
        return self._conjugate.relative_residual

    @cached_property
    def _convolution(self) -> LatticeConvolution:
        """From pressure to displacement on a block of cells and what reaches it on one side."""
        ray = np.arange(LONGEST + 1) * self.pitch
        offsets = np.column_stack([ray, np.zeros_like(ray)])
        moved = self.mechanics.surface_displacement(self.layer, offsets, self.pitch)[:, :, 2]
        size = np.abs(moved).max(axis=1)
        reach = max(int(np.flatnonzero(size > FAINT * size[0])[-1]), 1)
        kernel = displacement_kernel(self.mechanics, self.layer, self.pitch, reach, reach)
        rows, columns = (min(BLOCK * reach, cells + reach) for cells in self.shape)
        return LatticeConvolution(-kernel.astype(np.float32), (rows, columns))  # pushes inwards

    def displacement(self, pressure: NDArray[Any]) -> NDArray[Any]:
        """Displacement of the surface (K, 3) m by a pressure (K,) Pa: along x, along y, outwards.

        In single precision, block by block, so that memory does not grow with the sheet.
        """
        check_shape("pressure", pressure, (len(self.grid),), "one per cell")
        field = np.asarray(pressure, dtype=np.float32).reshape(self.shape)
        out, convolve = np.empty((3, *self.shape), dtype=np.float32), self._convolution
        reach = convolve.reach[0]
        rows, columns = (cells - reach for cells in convolve.shape)
        for row in range(0, self.shape[0], rows):
            for column in range(0, self.shape[1], columns):
                low, left = max(row - reach, 0), max(column - reach, 0)
                part = field[low : row + rows + reach, left : column + columns + reach]
                to = out[:, row : row + rows, column : column + columns]
                moved = convolve(part)[:, row - low :, column - left :]
                to[:] = moved[:, : to.shape[1], : to.shape[2]]
        return out.reshape(3, -1).T

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
        """Write the pressure (K,) Pa of linearised readings (L,) into `out`. No allocation.

        Both arrays of the sheet's precision, `out` in C order; NaN leaves a taxel out.
        `deadline_ns` is a time of `time.perf_counter_ns`; iterations stop early enough to write
        the pressure by then, as far as the times of the readings before tell.
        """
        check_shape("readings", readings, (len(self),), "one per taxel")
        check_shape("out", out, (len(self.grid),), "one per cell of sheet.grid")
        check_like("readings", readings, self.precision)
        check_like("out", out, self.precision)
        self._apply(readings, out, self.most_iterations, deadline_ns)

    def _apply(
        self, readings: NDArray[Any], out: NDArray[Any], most: int, deadline_ns: int | None
    ) -> None:
        from skinfield.solve.sheet.kernels import add_stamps

        plan, conjugate = self.plan, self._conjugate
        last = None if deadline_ns is None else deadline_ns - self._stamping_ns
        conjugate.solve(readings, self.tolerance, most, last)
        begin = time.perf_counter_ns()
        weights = np.multiply(conjugate.answer, plan.gain, out=conjugate.room)
        columns = self.shape[1]
        add_stamps(weights, plan.corner, plan.offset, self._spread, columns, out)
        end = time.perf_counter_ns()
        self._stamping_ns = max(end - begin, self._stamping_ns - self._stamping_ns // FORGET)
        self.deadline_met = deadline_ns is None or end <= deadline_ns

    def _rehearse(self) -> None:
        """Load the machine code and learn what a step and the stamps take."""
        some, out = self.noise_std.astype(self.precision), np.empty(len(self.grid), self.precision)
        for _ in range(2):  # from nothing, then from the reading before
            self._conjugate.step_ns = self._stamping_ns = 0
            self._apply(some, out, 1, None)
        self.reset()

    def __call__(self, readings: ArrayLike, *, deadline: float | None = None) -> Estimate:
        """Reconstruct one reading (L,) in the quantity's unit; NaN leaves a taxel out.

        With a `deadline` in seconds from the call the iterations stop early, see `apply`. All but
        the pressure is computed when it is asked for; `pressure_std` and the contacts' covariance
        are those of the readings' noise.
        """
        begin = time.perf_counter()
        if deadline is not None:
            check_positive("deadline", deadline, "seconds from the call")
        reading = as_floats("readings", readings)
        check_shape("readings", reading, (len(self),), "one per taxel, in the order of positions")
        check_readings(reading, self.noise_std, self.quantity.lowest)
        linear = self.quantity.linearise(reading, np.empty_like(reading))
        pressure = np.empty(len(self.grid), dtype=self.precision)
        until = None if deadline is None else int((begin + min(deadline, MOST)) * 1e9)
        self.apply(linear.astype(self.precision), pressure, until)
        latency = time.perf_counter() - begin
        valid = ~np.isnan(linear)
        noise = WindowNoise.whole(self.plan, valid[self.plan.placing.order])
        read = cache(lambda: self._repaired(np.nan_to_num(reading), valid, pressure))
        rest = {
            "traction": lambda: -pressure[:, None] * self.grid.normals,
            "displacement": lambda: self.displacement(pressure),
            "pressure_std": lambda: noise.std,
            "contacts": lambda: contacts_on(
                self.grid, pressure, self.finder, noise, self.highest_std
            ),
            "residual": lambda: linear - self.predict(pressure),
            "readings": lambda: read()[0],
            "readings_std": lambda: read()[1],
        }
        return Estimate.later(
            rest,
            grid=self.grid,
            pressure=pressure,
            valid=valid,
            latency=latency,
            iterations=self.iterations,
            deadline_met=self.deadline_met,
            solver=type(self).__name__,
        )

    def _repaired(
        self, reading: Floats, valid: NDArray[np.bool_], pressure: NDArray[Any]
    ) -> tuple[Floats, Floats]:
        """Readings and their deviations, (L,); see `repaired`."""
        predicted = self.quantity.from_linear(self.predict(pressure))
        places = self.patch.plane / taxel_distance(self.patch.plane, self.pitch)
        return repaired(reading, valid, self.noise_std, places, predicted)

    def predict(self, pressure: NDArray[Any]) -> Floats:
        """What the taxels read (L,) of a pressure (K,) Pa: the linear map A."""
        from skinfield.solve.sheet.kernels import read_stamps

        check_shape("pressure", pressure, (len(self.grid),), "one per cell of sheet.grid")
        sorted_out = np.empty(len(self), dtype=self.precision)
        field = np.ascontiguousarray(pressure, dtype=self.precision)
        plan, columns = self.plan, self.shape[1]
        corner = plan.placing.corner(plan.stamps.read.reach, columns)
        read_stamps(field, corner, plan.offset, self._read, columns, sorted_out)
        out = np.empty(len(self))
        out[plan.placing.order] = sorted_out
        return out
