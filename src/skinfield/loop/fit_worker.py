"""Fit of one patch's contacts by `ContactFit` from averaged readings, with numbers that last."""

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic import ObservationModel
from skinfield.errors import Floats
from skinfield.estimate import Contact
from skinfield.estimate.live_contacts import CONTACT, KNOWN, Habits
from skinfield.loop.fit_ring import FORM, NEAR, SHAPES, Fitted
from skinfield.loop.model_config import ModelConfig
from skinfield.loop.stationary_mean import Mean, StationaryMean
from skinfield.skin import Grid, Patch
from skinfield.solve import ContactFit, Fit
from skinfield.solve.atoms.fitter import ContactFitter

FIRST = 1_000_000  # number of the first contact that only the fit knows
HABITS = Habits(hold=0.5)
Rows = NDArray[np.void]


class FitTracks:
    """Contacts of one patch, fit after fit.

    A contact that goes on keeps its number. A new one takes that of the engine's nearest contact
    that no other has; where there is none, a number of its own.

    Parameters
    ----------
    numbers : iterator of int
        For contacts that the engine has none for, of all patches: far above those of the engine,
        which count from 1.
    """

    def __init__(self, numbers: Iterator[int]) -> None:
        self._numbers = numbers
        self._known: Rows = np.zeros(0, KNOWN)

    def number(self, rows: Rows, engine: Rows, stamp_ns: int) -> None:
        """Write `track`, `age` and `speed` into the rows of a fit.

        Parameters
        ----------
        rows, engine : arrays of CONTACT
            Of this patch alone.
        stamp_ns : int, ns
            Of the reading.
        """
        since = (stamp_ns - self._known["last_ns"]) * 1e-9
        there = (since >= 0.0) & (since <= HABITS.hold)
        known, since = self._known[there], since[there]
        before = pairs(rows, known, HABITS.reach + HABITS.speed * since)
        free = engine[~np.isin(engine["track"], known["track"][list(before.values())])]
        fresh = [at for at in range(len(rows)) if at not in before]
        found = pairs(rows[fresh], free, np.full(len(free), NEAR))
        self._known = np.zeros(len(rows), KNOWN)
        for at, (row, now) in enumerate(zip(rows, self._known, strict=True)):
            now["first_ns"] = stamp_ns
            if at in before:
                self._known[at] = known[before[at]]
                part = 1.0 / (since[before[at]] + HABITS.smoothing)
                for axis in "xy":  # as the engine does
                    moved = row[axis] - now[axis] - now[f"v{axis}"] * since[before[at]]
                    now[f"v{axis}"] += part * moved
            elif (place := fresh.index(at)) in found:
                own = free[found[place]]
                now["track"] = own["track"]
                now["first_ns"] -= int(max(float(own["age"]), 0.0) * 1e9)
            else:
                now["track"] = next(self._numbers)
            now["x"], now["y"], now["last_ns"] = row["x"], row["y"], stamp_ns
            row["track"], row["speed"] = now["track"], np.hypot(now["vx"], now["vy"])
            row["age"] = (stamp_ns - now["first_ns"]) * 1e-9


def pairs(rows: Rows, others: Rows, reach: NDArray[np.float64]) -> dict[int, int]:
    """Pairs of rows (N,) and others (M,) by `x`, `y`, nearest first, each within its reach (M,)."""
    apart = np.hypot(*(rows[axis][:, None] - others[axis][None] for axis in ("x", "y")))
    apart[apart > reach] = np.inf
    found: dict[int, int] = {}
    while apart.size and np.isfinite(apart.min()):
        row, other = np.unravel_index(int(np.argmin(apart)), apart.shape)
        found[int(row)] = int(other)
        apart[row], apart[:, other] = np.inf, np.inf
    return found


BASELINE = 100.0  # readings that a baseline is the mean of, about
HARMONICS = 20  # of what rounding does to a mean
ROUGH = 0.02  # of the highest reading: model error of boards that are not calibrated
FALSE_ALARMS = 1e-8  # of one reading; there are many, and averages overlap
TOUCHED = 1e-3  # the same, where the engine sees a touch
FITTING = ContactFit(false_alarm_rate=FALSE_ALARMS)
AGAIN = 1.5  # times the readings of the last fit, from which another is worth its while
REST_NS = 250_000_000  # between fits of a touch that rests, once no more readings are averaged
IDLE_NS = 200_000_000  # between fits of a patch that nothing touches, as the engine says
ANEW = 8  # readings from which one more fit may take its time, and starts from nothing
ENOUGH = 16  # readings by which a touch that the engine sees, and the fit does not, is none
SURE = 6.0  # standard deviations of the force of a contact that the engine does not see
LONGEST_NS = 500_000_000  # of one fit
PAUSES = {Fitted.DONE: 1, Fitted.NOTHING: 1, Fitted.UNHELPFUL: 9}  # times its work
STEPS = 3  # from a place on the skin to one in its plane
Shape = tuple[object, ...]


def deviation_of(mean: Mean, noise: Floats, rounding: Floats) -> Floats:
    """Deviation (L,) of an average less the baseline; infinite where a taxel is not valid.

    Parameters
    ----------
    mean : Mean
    noise : (L,) array, in the quantity's unit
        Of one reading.
    rounding : (L,) array
        What rounding leaves of an average, however long.
    """
    squares = noise**2 * (1.0 / mean.readings + 1.0 / BASELINE) + rounding**2
    return np.where(mean.valid, np.sqrt(squares), np.inf)


def rounding_of(calibration: Floats, noise_std: Floats) -> Floats:
    """What rounding to whole counts leaves of an average (L,), in the unit of `noise_std` (L,).

    Of a count with normal noise of s before it is rounded, the mean is off by the sawtooth's
    Fourier series, each term damped by the noise: up to exp(-2 pi² k² s²) / (pi k), k = 1, 2, ...
    What is told is the mean square over all levels, 1/12 of a count without noise.

    Parameters
    ----------
    calibration : (L, 4) array
        As a tare has it: `calibration[:, 2]` is the noise in counts, rounding included.
    """
    counts = np.maximum(calibration[:, 2], 1e-9)
    before = np.maximum(counts**2 - 1.0 / 12.0, 0.0)
    term = np.arange(1.0, HARMONICS + 1.0)[:, None]
    squares = np.exp(-4.0 * np.pi**2 * term**2 * before) / (2.0 * np.pi**2 * term**2)
    off = np.sqrt(squares.sum(axis=0))
    return np.asarray(off / np.maximum(counts, np.sqrt(1.0 / 12.0)) * noise_std)


def fitter_of(patch: Patch, model_config: ModelConfig) -> ContactFitter:
    """The fit of a patch on its finest grid; takes seconds, and compiles the first time."""
    quantity = model_config.quantity
    model = ObservationModel.of(
        patch,
        model_config.layer,
        Grid.square(patch, max(model_config.rungs)),
        model_config.mechanics,
        quantity,
        quantity.typical_noise,
    )
    fitter = ContactFitter(FITTING, model)
    fitter.run_in()
    return fitter


def shape_of(patch: Patch) -> Shape:
    """Equal for patches that one prepared fit is good for."""
    return (
        patch.plane.tobytes(),
        patch.positions.tobytes(),
        patch.normals.tobytes(),
        patch.pad_diameter,
    )


class PatchFit:
    """Contacts of one patch, reading after reading.

    Parameters
    ----------
    patch : int
        Its number.
    shape : Patch
    tracks : FitTracks

    Attributes
    ----------
    stationary : StationaryMean
    state : Fitted
    rows : (N,) array of CONTACT
    forms : (N,) array of FORM
    pressure : (K,) array, Pa, or None
    mean : Mean or None
        That was fitted, or agrees with what was.
    took_ns : int, ns
    """

    def __init__(self, patch: int, shape: Patch, tracks: FitTracks) -> None:
        self.patch, self._shape, self._tracks = patch, shape, tracks
        self.stationary = StationaryMean(len(shape))
        self.state = Fitted.NOTHING
        self.rows: Rows = np.zeros(0, CONTACT)
        self.forms: Rows = np.zeros(0, FORM)
        self.pressure: Floats | None = None
        self.mean: Mean | None = None
        self.took_ns = 0
        self._noise = self._rounding = np.zeros(len(shape))
        self._fine: ContactFitter | None = None
        self._rough: ContactFitter | None = None
        self._was_rough = False
        self._fitted = 0  # readings of the last fit
        self._fitted_ns = 0  # stamp of it
        self._not_before = 0  # of the performance counter

    @property
    def ready(self) -> bool:
        """Whether a fit was given."""
        return self._fine is not None

    def take_fitter(self, fitter: ContactFitter) -> None:
        """Take a fit that was prepared for this geometry; others may have the same one."""
        self._fine = fitter.with_settings(FITTING)
        self._rough = fitter.with_settings(replace(FITTING, model_error=ROUGH))

    def calibrate(self, noise: Floats, rounding: Floats) -> None:
        """Go by this noise, see `deviation_of`, and forget all answers."""
        self._noise, self._rounding = noise, rounding
        self.reset()

    def reset(self) -> None:
        """Forget all answers; readings and numbers are kept."""
        self.state, self.mean, self._fitted, self._not_before = Fitted.NOTHING, None, 0, 0
        self.rows, self.forms, self.pressure = self.rows[:0], self.forms[:0], None

    def update(self, engine: Rows, touched: bool) -> bool:
        """Answer the newest readings, if that is worth its while; whether anything is new.

        Parameters
        ----------
        engine : array of CONTACT
            That the engine sees on this patch.
        touched : bool
            Whether it sees anything.
        """
        if self._fine is None or self.stationary.stamp_ns == self._fitted_ns:
            return False
        if time.perf_counter_ns() < self._not_before:
            return False  # what nothing explains takes long: it shall not take all the time
        mean = self.stationary.mean(self._noise)
        if mean is None or not mean.valid.any():
            return False
        if not self._due(mean, touched):
            grew = self.mean is not None and mean.stamp_ns > self.mean.stamp_ns
            self.mean = mean if self.mean is not None else None
            return grew and self.state == Fitted.DONE
        began, busy = time.perf_counter_ns(), time.thread_time_ns()
        fit = self._fit(mean, TOUCHED if touched else FALSE_ALARMS)
        before = self.state
        self._take(fit, mean, engine, touched)
        self.mean, self._fitted, self._fitted_ns = mean, mean.readings, mean.stamp_ns
        now = time.perf_counter_ns()
        self.took_ns = now - began
        self._not_before = now + PAUSES[self.state] * (time.thread_time_ns() - busy)
        return self.state != Fitted.NOTHING or before != self.state

    def _due(self, mean: Mean, touched: bool) -> bool:
        """Whether these readings tell more than those of the last fit, or something else."""
        since = mean.stamp_ns - self._fitted_ns
        if not touched and not len(self.rows):
            return since >= IDLE_NS
        moved = mean.readings < self._fitted
        return moved or mean.readings >= AGAIN * self._fitted or since >= REST_NS

    def _fit(self, mean: Mean, rate: float) -> Fit:
        """The fit with the usual model error, else with that of boards without calibration."""
        noise = deviation_of(mean, self._noise, self._rounding)
        assert self._fine is not None  # it is ready
        assert self._rough is not None
        order = (self._rough, self._fine) if self._was_rough else (self._fine, self._rough)
        for fitter in order:
            fitter.take_noise(noise)
            fitter.take_rate(rate)
            if mean.readings >= ANEW:
                fitter.reset()
            until = time.perf_counter_ns() + LONGEST_NS
            fit = fitter.fit(mean.values, until)
            self._was_rough = fitter is self._rough
            if fit.explained:
                break
        return fit

    def _take(self, fit: Fit, mean: Mean, engine: Rows, touched: bool) -> None:
        if not fit.explained:
            self.reset()
            self.state = Fitted.UNHELPFUL
            return
        contacts = [each for each in fit.contacts if self._believed(each, engine)]
        if not contacts and (not touched or mean.readings < ENOUGH):
            self.reset()
            return
        self.state = Fitted.DONE
        self.pressure = fit.pressure
        self.rows = np.zeros(len(contacts), CONTACT)
        self.forms = np.zeros(len(contacts), FORM)
        for row, form, contact in zip(self.rows, self.forms, contacts, strict=True):
            self._write(contact, fit.pressure, row)
            form["shape"], form["radius"] = SHAPES.index(contact.shape), contact.radius
        self._tracks.number(self.rows, engine, mean.stamp_ns)

    def _believed(self, contact: Contact, engine: Rows) -> bool:
        """Whether the engine sees a contact as well, or it is sure by itself."""
        near = np.linalg.norm(engine["position"] - contact.position, axis=1) < NEAR
        return bool(near.any()) or contact.normal_force > SURE * contact.force_std

    def _write(self, contact: Contact, pressure: Floats, row: np.void) -> None:
        assert self._fine is not None  # it is ready
        grid = self._fine.model.grid
        row["patch"], row["cells"] = self.patch, len(contact.cells)
        row["position"], row["normal"] = contact.position, contact.normal
        row["x"], row["y"] = place_in_plane(self._shape, grid, contact.position)
        row["normal_force"], row["force_std"] = contact.normal_force, contact.force_std
        row["place_std"] = np.sqrt(0.5 * np.trace(contact.covariance[:2, :2]))
        row["area"], row["peak_pressure"] = contact.area, contact.peak_pressure
        row["moments"] = moments_of(grid, pressure, contact.cells)


def place_in_plane(patch: Patch, grid: Grid, position: Floats) -> Floats:
    """Place (2,) in the plane of a patch of a position (3,) on it, m."""
    nearest = int(np.argmin(((grid.positions - position) ** 2).sum(axis=1)))
    place = np.array(grid.plane[nearest])
    for _ in range(STEPS):  # along the tangents, which are nearly the plane's own axes
        off = position - patch.surface.position_from_plane(place[None])[0]
        place += off @ patch.surface.frame_from_plane(place[None])[0][:, :2]
    return place


def moments_of(grid: Grid, pressure: Floats, cells: NDArray[np.int64]) -> Floats:
    """Second moments xx, yy, xy (3,) of the pressure about its centre, m²."""
    weight, plane = pressure[cells], grid.plane[cells]
    total = float(weight.sum())
    own = grid.pitch**2 / 12.0  # of a cell
    if total <= 0.0:
        return np.array([own, own, 0.0])
    off = plane - (weight @ plane) / total
    xx, yy, xy = (weight @ (off[:, [0, 1, 0]] * off[:, [0, 1, 1]])) / total
    return np.array([xx + own, yy + own, xy])
