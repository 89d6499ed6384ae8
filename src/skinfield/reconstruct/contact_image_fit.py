"""Fit of one body's pressure, in the body's own frame, to readings of it in many places."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skinfield.elastic import Capacitance, ObservationModel, Physics
from skinfield.elastic.hankel import RadialKernel, electrostatic, jinc
from skinfield.elastic.lattice import LatticeConvolution, cached_indentation_kernel
from skinfield.errors import Floats
from skinfield.reconstruct.contact_images_kernel import (
    ONWARDS,
    Batch,
    Lattice,
    Prior,
    Singles,
    farthest,
    fill,
    follow,
    look,
    sweep,
    visit,
)
from skinfield.skin import Grid, Patch

STEP = 0.02e-3  # m, between the distances of a table
FAR = 0.02  # m beyond the taxels, up to which a cell may be
FAINT = 2e-3  # of a taxel's highest response: it sees no cell that is farther
FIELD_REACH = 6.0  # thicknesses beyond a pad's rim, where its field has ended
CELL = 0.8e-3  # m: of the weights below
TOTAL, COMPACT, LOW, EDGES, SMOOTH = 0.015, 0.06, 0.3, 0.05, 0.05  # per reading: see `Prior`
COMPACT_GIVEN = 0.09  # where poses are given
FIRST_EDGES = 0.5  # and once
STROKE = 16e-6  # m²: pressed evenly by 1, the unit of pressure, it gives the highest reading
MODEL_ERROR = 0.01  # of the highest reading, beside the noise
DEEPEST = 0.4  # strain of which the series is taken at most
FORCE, FORCE_GIVEN = 0.05, 0.15  # of a reading's force about that before; where poses are given
FIRST_SWEEPS, SWEEPS, STEPS = 100, 6, 1
STRIDES = (
    7,
    11,
    13,
    1,
)  # readings from one that is visited anew to the next: the first that goes round
WHOLE = 4  # readings, of which one looks at all cells
PRESSED = 0.05  # of the highest pressure: a cell that has more is of the body
NARROW = 2  # cells from the body to the border of its lattice
LOST = 2.0  # misfit of a pose that is another one
EARLY = 16  # a body of fewer readings is fitted so many times as there are fewer


@dataclass(frozen=True, eq=False)
class Response:
    r"""What taxels read of a cell, and what a body's own strain adds to that.

    A gap reads more than its mean strain: the terms :math:`v\,\mathcal D v` and
    :math:`v\,\mathcal D(v\,\mathcal D v) - v^2(kh)^2v/2` of `skinfield.elastic.electrostatics`,
    by Fourier series on twice the lattice. They follow from the pressure as it is known so far.

    Attributes
    ----------
    model : ObservationModel
        With its physics.
    cell : float, m
    """

    model: ObservationModel
    cell: float

    @property
    def physics(self) -> Physics:
        """What taxels are made of and read."""
        assert self.model.physics is not None
        return self.model.physics.flat

    @property
    def order(self) -> int:
        """Of the series in the strain."""
        quantity = self.physics.quantity
        return (quantity.order or 3) if isinstance(quantity, Capacitance) else 1

    @cached_property
    def first(self) -> Floats:
        """Readings per Pa on a cell at distances `STEP` apart, and 0 at the end: (M,)."""
        physics = self.physics
        grid = Grid(Patch(np.zeros((1, 2))), (1, 1), self.cell, np.zeros(2))

        def at(distances: Floats) -> Floats:
            places = np.column_stack([distances, np.zeros_like(distances)])
            made_of = physics.mechanics, physics.layer, grid, places, physics.pad_diameter
            return physics.quantity.matrix(*made_of)[:, 0]

        coarse = 50 * STEP
        distance = np.arange(0.0, float(np.ptp(self.model.taxels, axis=0).max()) + FAR, coarse)
        seen = np.abs(at(distance))
        reach = distance[np.flatnonzero(seen > FAINT * seen.max())[-1]] + coarse
        return _ended(at(np.arange(0.0, reach + STEP, STEP)))

    @cached_property
    def second(self) -> Floats:
        """Readings of a unit of charge on a cell, as `first`."""
        if self.order == 1:
            return np.zeros(4)
        thickness = self.physics.layer.thickness
        pad = self.physics.pad_diameter / 2 / thickness
        distance = np.arange(0.0, pad + FIELD_REACH, STEP / thickness)
        kernel = RadialKernel(
            lambda alpha: electrostatic(alpha) * jinc(alpha, pad) * alpha / (2 * np.pi),
            0, 46.0, float(distance[-1]) + pad, pad,
        )  # fmt: skip
        return _ended(kernel(distance) * (self.cell / thickness) ** 2)

    def strain_on(self, side: int) -> LatticeConvolution:
        """Strain (side, side) of the gap by pressures (side, side) Pa, single precision."""
        physics, cell, last = self.physics, self.cell, side - 1
        made_of = physics.mechanics, physics.layer, cell, cell, last, last
        kernel = cached_indentation_kernel(*made_of) / physics.layer.thickness
        return LatticeConvolution(kernel.astype(np.float32))

    def waves(self, size: int) -> tuple[Singles, Singles]:
        """Multipliers kh coth kh and (kh)² of the Fourier series on (size, size) cells."""
        along = np.fft.rfftfreq(size, self.cell), np.fft.fftfreq(size, self.cell)[:, None]
        kh = 2 * np.pi * np.hypot(*along) * self.physics.layer.thickness
        steep = kh / np.tanh(np.maximum(kh, 1e-9)) + (kh < 1e-9)
        return steep.astype(np.float32), (kh**2).astype(np.float32)


def _ended(table: Floats) -> Floats:
    """Table that goes to 0 where it is faint for good."""
    last = int(np.flatnonzero(np.abs(table) > FAINT * np.abs(table).max())[-1])
    table = table[: last + 4].copy()
    table[-2:] = 0.0
    return table


@dataclass(frozen=True)
class Snapshot:
    """Fit at one instant: all that its covariance follows from.

    Attributes
    ----------
    poses : (N, 3) array, m, m, rad
    scales : (N,) array
    white : (N, L) array, 1 over the unit of the reading
    pressure : (J,) array, in `unit`
    unit : float, Pa
    scale : float
        Of the last reading.
    """

    poses: Floats
    scales: Floats
    white: Floats
    pressure: Floats
    unit: float
    scale: float


class ImageFit:
    """Pressure of one body on a lattice of its own, by readings in up to N poses.

    Parameters
    ----------
    response : Response
    centre : (2,) array, m
        Of the lattice in the body's frame.
    side : int
        Cells along x and along y.
    most : int
        Readings that are kept; of more, the last ones.
    step, bend : (m, rad)
        Of an unknown motion: from one reading to the next, and what differs from one step to the
        next.
    known : bool
        Whether poses are given.

    Attributes
    ----------
    count : int
        Readings so far.
    misfit : float
        Mean square of what is left of the last reading, over its noise.
    unit : float, Pa
        Of the pressure.
    """

    def __init__(
        self,
        response: Response,
        centre: Floats,
        side: int,
        most: int,
        step: tuple[float, float],
        bend: tuple[float, float],
        known: bool,
    ) -> None:
        self.response, self.centre, self.side, self.known = response, centre, side, known
        self.cell, taxels = response.cell, response.model.taxels
        x, y = np.meshgrid(*self.cells)
        from scipy.fft import next_fast_len

        single: Any = np.float32
        self._lattice = Lattice(
            x.ravel().astype(single), y.ravel().astype(single), side,
            np.ascontiguousarray(taxels, dtype=np.float64),
            response.first.astype(single), response.second.astype(single), STEP,
        )  # fmt: skip
        area, width = (self.cell / CELL) ** 2, self.cell / CELL
        compact = COMPACT_GIVEN if known else COMPACT
        self._weights = TOTAL * area, compact * area, EDGES * width, FIRST_EDGES * width
        self._steps = np.array([step[0], step[0], step[1]]), np.array([bend[0], bend[0], bend[1]])
        self._strain = response.strain_on(side)
        self._waves = response.waves(next_fast_len(2 * side, real=True))
        self._batch = _empty(side**2, most, len(taxels))
        self._stride = next(each for each in STRIDES if most % each or each == 1)
        self.count, self.misfit, self.unit = 0, np.nan, 1.0

    @property
    def in_use(self) -> int:
        """Readings that the pressure follows from."""
        return min(self.count, len(self._batch.raw))

    @property
    def pressure(self) -> Floats:
        """(side, side) Pa, under the force of the last reading."""
        square = self._batch.pressure.reshape(self.side, self.side)
        return square.astype(np.float64) * (self.unit * self.scale)

    @property
    def scale(self) -> float:
        """Force of the last reading over the mean of those that are kept."""
        t = self._newest
        return float(self._batch.scales[t] + self._batch.grown[t])

    @property
    def pose(self) -> Floats:
        """(x, y, turn) of the body's frame in the plane at the last reading, m, m, rad."""
        return np.asarray(self._batch.poses[self._newest] + self._batch.moved[self._newest])

    @property
    def poses(self) -> Floats:
        """Of the readings that are kept, the first of them first: (N, 3)."""
        order = np.arange(self.count - self.in_use, self.count) % len(self._batch.raw)
        return np.asarray((self._batch.poses + self._batch.moved)[order])

    @property
    def _newest(self) -> int:
        return (self.count - 1) % len(self._batch.raw)

    def _prior(self) -> Prior:
        total, compact, edges, once = self._weights
        kept = self.in_use
        force = FORCE_GIVEN if self.known else FORCE
        weights = total * kept, compact * kept, LOW, edges * kept + once, SMOOTH
        return Prior(*weights, *self._steps, force)

    @property
    def cells(self) -> tuple[Floats, Floats]:
        """Of the columns along x, and of the rows along y, in the body's frame: (side,) m each."""
        axis = (np.arange(self.side) - (self.side - 1) / 2) * self.cell
        return self.centre[0] + axis, self.centre[1] + axis

    def update(
        self, readings: Floats, valid: Any, pose: Floats | None, hint: Floats | None = None
    ) -> None:
        """Take in one more reading.

        Parameters
        ----------
        readings : (L,) array, in the quantity's unit
            Of this body alone.
        valid : (L,) bool array
        pose : (3,) array, m, m, rad, optional
            Of the body, at its first reading and where it is known.
        hint : (2,) array, m, optional
            How far its contact has come since the reading before: for where the pose that its
            motion foretells does not fit.
        """
        batch, first = self._batch, self.count == 0
        t, before = self.count % len(batch.raw), self.scale if self.count else 1.0
        start = self._foretold() if pose is None else pose
        last = None if first else self.pose
        self.count += 1
        highest = float(np.abs(readings[valid]).max())
        batch.raw[t] = np.where(valid, readings, 0.0)
        noise = np.hypot(self.response.model.noise_std, MODEL_ERROR * highest)
        batch.white[t] = valid / noise
        batch.poses[t], batch.moved[t], batch.known[t] = start, 0.0, first or self.known
        batch.scales[t], batch.grown[t] = before, 0.0
        if first:
            self._begin(highest)
        else:
            again = None if hint is None or last is None else last + np.array([*hint, 0.0])
            self._go_on(t, again)
        self._normalise()
        self._centre_on_body()

    def _foretold(self) -> Floats:
        """Where the motion goes on to."""
        poses = self.poses[-2:]
        return np.asarray(poses[-1] + ONWARDS * (poses[-1] - poses[0]))

    def _begin(self, highest: float) -> None:
        """Fit the first reading: linear at first, then with what its own pressure adds."""
        batch, prior = self._batch, self._prior()
        table = self.response.first
        self.unit = highest / (table[0] / self.cell**2 * STROKE)
        self._lattice.first[:] = table * self.unit
        linear, raw = np.empty(len(batch.raw[0])), batch.raw[0].copy()
        batch.raw[0] = self.response.physics.quantity.linearise(raw, linear)
        visit(self._lattice, batch, 0, 1, prior, 0)
        self._sweep(prior, 3 * FIRST_SWEEPS)
        batch.raw[0] = raw
        for _ in range(3):
            self._add_charge()
            self.misfit = visit(self._lattice, batch, 0, 1, prior, 0)
            self._sweep(prior, FIRST_SWEEPS)

    def _go_on(self, t: int, other_start: Floats | None) -> None:
        batch, prior = self._batch, self._prior()
        self._add_charge()
        scale = float(batch.scales[t])
        self.misfit = visit(self._lattice, batch, t, self.count, prior, STEPS)
        if other_start is not None and self.misfit > LOST:
            found = batch.poses[t].copy(), float(batch.scales[t]), self.misfit
            batch.poses[t], batch.scales[t] = other_start, scale
            self.misfit = visit(self._lattice, batch, t, self.count, prior, 2 * STEPS)
            if self.misfit > found[2]:
                batch.poses[t], batch.scales[t] = found[:2]
                self.misfit = visit(self._lattice, batch, t, self.count, prior, 0)
        for again in range(max(1, EARLY // self.count)):
            if again:
                self._add_charge()
            for other in (farthest(batch, self.in_use), self.count * self._stride % self.in_use):
                visit(self._lattice, batch, other, self.count, prior, 0)
            self._sweep(prior, SWEEPS)
            follow(batch, self.count, prior, 1 if self.known else 4)

    def _add_charge(self) -> None:
        """Write the pressure, and the charge beyond first order that follows from it, to fields."""
        from scipy import fft

        fields, side, (steep, square) = self._batch.fields, self.side, self._waves
        fields[0] = self._batch.pressure
        if self.response.order == 1:
            return
        size = len(steep)

        def times(spectrum: Any, waves: Singles) -> Any:
            return fft.irfft2(spectrum * waves, (size, size))[:side, :side]

        pressure = self._batch.pressure.reshape(side, side) * np.float32(self.unit)
        strain = np.clip(self._strain(pressure), -DEEPEST, DEEPEST)
        spectrum = fft.rfft2(strain, (size, size))
        second = strain * times(spectrum, steep)
        fields[1] = second.ravel()
        if self.response.order == 3:
            third = strain * times(fft.rfft2(second, (size, size)), steep)
            third -= 0.5 * strain * strain * times(spectrum, square)
            fields[2] = third.ravel()

    def _sweep(self, prior: Prior, sweeps: int) -> None:
        batch, whole = self._batch, self.count % WHOLE == 0 or self.count < EARLY
        scales = batch.scales.astype(np.float32)
        which = self.side, batch.rows, batch.rest, scales, batch.pressure, self.in_use
        sweep(*which, prior, sweeps, whole)

    def _normalise(self) -> None:
        """Have the mean of the scales be 1: they and the pressure are known as a product alone."""
        batch, kept = self._batch, self.in_use
        mean = float((batch.scales + batch.grown)[:kept].mean())
        batch.scales[:kept] /= mean
        batch.grown[:kept] /= mean
        batch.spread[:kept, 0] /= mean
        batch.pressure[:] *= np.float32(mean)

    def _centre_on_body(self) -> None:
        """Move the lattice, by whole cells, where the body has come to its border."""
        square = self._batch.pressure.reshape(self.side, self.side)
        pressed = square > PRESSED * square.max()
        moves = [0, 0]
        for axis in range(2):
            places = np.flatnonzero(pressed.any(axis=axis))
            before, after = (places[0], self.side - 1 - places[-1]) if len(places) else (9, 9)
            if min(before, after) < NARROW and max(before, after) > 2 * NARROW:
                moves[axis] = int(before - after) // 2
        if not any(moves):
            return
        across, up = moves
        self.centre = self.centre + np.array(moves) * self.cell
        self._lattice.x[:] += np.float32(across * self.cell)
        self._lattice.y[:] += np.float32(up * self.cell)
        moved = np.roll(square, (-up, -across), axis=(0, 1))
        moved[self.side - up if up > 0 else 0 : None if up > 0 else -up] = 0.0
        moved[:, self.side - across if across > 0 else 0 : None if across > 0 else -across] = 0.0
        self._batch.pressure[:] = moved.ravel()
        self._add_charge()
        for t in range(self.in_use):
            visit(self._lattice, self._batch, t, self.count, self._prior(), 0)

    def predicted(self) -> Floats:
        """What the taxels read of the body, (L,), in the quantity's unit."""
        self._batch.fields[0] = self._batch.pressure
        count = self._batch.raw.shape[1]
        out, slopes = np.zeros((3, count)), np.zeros((3, 3, count))
        look(self._lattice, self.pose, self._batch.fields, out, slopes)
        s = self.scale
        return np.asarray(s * (out[0] + s * (out[1] + s * out[2])))

    def snapshot(self) -> Snapshot:
        """Copy of what the covariance follows from."""
        batch, kept = self._batch, self.in_use
        poses, scales = batch.poses + batch.moved, batch.scales + batch.grown
        return Snapshot(
            poses[:kept], scales[:kept], batch.white[:kept].copy(),
            batch.pressure.astype(np.float64), self.unit, self.scale,
        )  # fmt: skip

    def deviation(self, at: Snapshot) -> Floats:
        """One standard deviation (side, side) Pa of the pressure, as if none could pull.

        Of the Gaussian that has the objective's curvature where it is lowest (Laplace's method).
        """
        cells = self.side**2
        rows, curvature = np.empty((cells, at.white.shape[1]), np.float32), np.zeros((cells, cells))
        for pose, scale, white in zip(at.poses, at.scales, at.white, strict=True):
            fill(self._lattice, pose, white * scale, rows)
            curvature += rows @ rows.T
        curvature += self._bending(at)
        spread = np.sqrt(np.diag(np.linalg.inv(curvature))).reshape(self.side, self.side)
        return np.asarray(spread * (at.unit * at.scale))

    def _bending(self, at: Snapshot) -> Floats:
        """Curvature (J, J) of the total variation."""
        side, kept = self.side, len(at.poses)
        _, _, edges, once = self._weights
        square = np.pad(at.pressure.reshape(side, side), ((0, 1), (0, 1)))
        across, up = np.diff(square, axis=1)[:-1], np.diff(square, axis=0)[:, :-1]
        weight = (edges * kept + once) / np.sqrt(across**2 + up**2 + SMOOTH**2)
        index = np.arange(side**2).reshape(side, side)
        out = np.diag(2.0 * weight.ravel())
        for one, other, share in (
            (index[:, :-1], index[:, 1:], weight[:, :-1]), (index[:-1], index[1:], weight[:-1]),
        ):  # fmt: skip
            a, b, w = one.ravel(), other.ravel(), share.ravel()
            out[b, b] += w
            out[a, b] -= w
            out[b, a] -= w
        return out


def _empty(cells: int, most: int, taxels: int) -> Batch:
    single: Any = np.float32
    return Batch(
        np.zeros((most, taxels)), np.zeros((most, taxels)), np.zeros((most, 3)),
        np.zeros((most, 3)), np.ones(most), np.zeros(most), np.zeros(most, np.bool_),
        np.zeros((cells, most, taxels), single), np.zeros((most, taxels), single),
        np.zeros((most, taxels), single), np.zeros((most, 4, taxels)),
        np.zeros((most, 4, taxels), single), np.zeros((most, 4), single), np.zeros((most, 4)),
        np.zeros((most, 4)), np.zeros((3, cells)), np.zeros(cells, single),
    )  # fmt: skip
