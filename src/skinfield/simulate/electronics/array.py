"""Taxel array as made: gain, baseline, drift, noise and defect of each taxel; known electronics."""

import math
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import (
    Floats,
    InputError,
    as_floats,
    check_finite,
    check_shape,
)
from skinfield.settings import Positive, Range, Section
from skinfield.signal import Calibration
from skinfield.simulate.electronics.board import Board, CySkinBoard, ICubBoard, LinearBoard
from skinfield.simulate.electronics.delivery import CrossTalk, Delivery, Sampling, Wiring, wiring
from skinfield.simulate.electronics.noise import Noise, ThermalDrift
from skinfield.skin import Patch
from skinfield.skin.reading import Recording

FORGOTTEN = 0.02  # of the highest change: below it the loop is closed, and the next one begins


@dataclass(frozen=True, kw_only=True)
class Hysteresis(Section):
    """A taxel that is let go shows more than one that is pressed as hard for the first time.

    Parameters
    ----------
    width : float
        Of the loop at its widest, half-way, as a part of the highest change in it. 0: none.

    Notes
    -----
    The branch of release is a parabola over that of load: with the highest change p of the loop, a
    change x shows as x + 4 w x (1 - |x|/|p|), w the width. Both ends are those of the branch of
    load, as in cycles of filled rubber (Mullins, Rubber Chem. Technol. 42, 1969). The form is
    assumed; the width is what data sheets state.
    """

    width: Annotated[float, Range(0.0, 0.25, "a part of the highest change; 0 is off")] = 0.0

    def applied(self, change: Floats) -> Floats:
        """What taxels show, (T, L), of changes (T, L) one after the other, from rest."""
        if not self.width:
            return change
        peak = np.zeros(change.shape[1])
        return np.stack([self.step(row, peak) for row in change])

    def step(self, change: Floats, peak: Floats) -> Floats:
        """What taxels show of a change (L,), given the highest size `peak` (L,), which it updates.

        `peak` is 0 at rest.
        """
        size = np.abs(change)
        np.copyto(peak, size, where=(size > peak) | (size < FORGOTTEN * peak))
        part = np.divide(size, peak, out=np.ones_like(size), where=peak > 0)
        return np.asarray(change * (1.0 + 4.0 * self.width * (1.0 - part)))


class Defect(IntEnum):
    """What a taxel does instead of feeling."""

    NONE = 0
    ABSENT = 1
    """Never answers: NaN."""
    DEAD = 2
    """Sends its count at rest, for ever."""
    STUCK = 3
    """Keeps one count from some moment on."""
    FLICKERING = 4
    """A loose joint: loses its capacitance for moments."""
    SATURATED = 5
    """A short: at the clamp of full load, for ever."""


Kinds = NDArray[np.int8]


SPREAD = Range(0.0, 3.0, "of a logarithm; 0.1 is about 10 %")
CHANCE = Range(0.0, 1.0, "a probability; 0 is off")


@dataclass(frozen=True, kw_only=True)
class Defects(Section):
    """How likely each defect is, per taxel. 0: none.

    Parameters
    ----------
    absent, dead, stuck, flickering, saturated : float
        Probability that a taxel is so; in sum at most 1.
    stuck_within : float, s
        A stuck taxel stops at a moment between the start of a recording and this.
    open_time, closed_time : float, s
        Mean time that a loose joint is open, and closed. Assumed.
    """

    absent: Annotated[float, CHANCE] = 0.0
    dead: Annotated[float, CHANCE] = 0.0
    stuck: Annotated[float, CHANCE] = 0.0
    flickering: Annotated[float, CHANCE] = 0.0
    saturated: Annotated[float, CHANCE] = 0.0
    stuck_within: Annotated[float, Positive("in seconds")] = 10.0
    open_time: Annotated[float, Positive("in seconds")] = 0.2
    closed_time: Annotated[float, Positive("in seconds")] = 0.5

    def check(self) -> None:
        """See `Section`."""
        if sum(self._likely) > 1.0 + 1e-12:
            raise InputError(
                f"probabilities sum to {sum(self._likely):g}, expected at most 1: a taxel has "
                "one defect or none"
            )

    @property
    def _likely(self) -> tuple[float, ...]:
        return (self.absent, self.dead, self.stuck, self.flickering, self.saturated)

    def draw(self, taxels: int, rng: np.random.Generator) -> Kinds:
        """Defect of each taxel, (L,) of `Defect`."""
        kind = np.searchsorted(np.cumsum(self._likely), rng.random(taxels), side="right") + 1
        return np.where(kind > len(self._likely), Defect.NONE, kind).astype(np.int8)

    def open(self, readings: int, taxels: int, rate: float, rng: np.random.Generator) -> Floats:
        """Where loose joints are open, (T, L) of 0 and 1: a two-state Markov chain in time.

        With rates a of opening and b of closing, the state after a period is open with the
        stationary probability a/(a + b), plus what is left of the present one, exp(-(a + b)/r).
        """
        opening, closing = 1.0 / self.closed_time, 1.0 / self.open_time
        share = opening / (opening + closing)
        keep = np.exp(-(opening + closing) / rate)
        draws = rng.random((readings, taxels))
        state = np.empty((readings, taxels))
        state[0] = draws[0] < share
        for reading in range(1, readings):
            state[reading] = draws[reading] < share + (state[reading - 1] - share) * keep
        return state


OVERLOAD = 1e9  # counts: beyond the clamp of any board
NOISELESS = 1e-6  # of ΔC/C₀: stands for no noise, which a calibration cannot hold


@dataclass(frozen=True, kw_only=True, eq=False)
class TaxelArray:
    """One draw of a patch's electronics; see `Electronics.manufacture`.

    Attributes
    ----------
    electronics : Electronics
    patch : Patch
    gain : (L,) array, counts per unit of ΔC/C₀
        Sign included.
    baseline : (L,) array, counts
        Level of the unloaded taxel at the reference temperature.
    drift : (L,) array, counts/K
    white_noise : (L,) array, counts
        Standard deviation.
    defect : (L,) int8 array
        Of `Defect`.
    stops_after : (L,) array, s
        From when on a stuck taxel is stuck.
    """

    electronics: "Electronics"
    patch: Patch
    gain: Floats
    baseline: Floats
    drift: Floats
    white_noise: Floats
    defect: Kinds
    stops_after: Floats

    def __len__(self) -> int:
        return len(self.patch)

    @cached_property
    def wiring(self) -> Wiring:
        """Converter and stage of each taxel."""
        return wiring(self.patch)

    @cached_property
    def calibration(self) -> Calibration:
        """The true one: gain, baseline, and the noise of a reading from one to the next.

        That is white and common noise and the board's steps; drift, flicker and walk are not in
        it. Taxels with a defect are not alive.
        """
        settings = self.electronics
        steps = settings.board.step / math.sqrt(12.0) if settings.quantised else 0.0
        noise = np.sqrt(self.white_noise**2 + settings.noise.common**2 + steps**2)
        return Calibration(
            self.baseline,
            self.gain,
            np.maximum(noise, NOISELESS * np.abs(self.gain)),
            self.defect == Defect.NONE,
            self.patch.uid,
            patch_name=self.patch.name,
            unit="count" if settings.board.unit == "count" else "1",
            basis="the truth of simulated electronics",
        )

    def sample_times(
        self, duration: float, rng: np.random.Generator, *, start_ns: int = 0
    ) -> Sampling:
        """When the taxels are converted and their readings stamped.

        Parameters
        ----------
        duration : float, s
        rng : numpy Generator
        start_ns : int, ns
            Stamp of the start of the recording.
        """
        return self.electronics.delivery.sampling(self.wiring, duration, rng, start_ns)

    def counts(
        self, change: ArrayLike, temperature: ArrayLike | None, rng: np.random.Generator
    ) -> Floats:
        """Counts (T, L) of one recording; NaN where a taxel does not answer.

        Parameters
        ----------
        change : (T, L) array
            ΔC/C₀ of each taxel when it is converted, `Sampling.instants`.
        temperature : (T,) array, K, or None
            Of the surroundings; None: that of the reference.
        rng : numpy Generator
            Noise, flicker and losses have a stream each.

        Raises
        ------
        InputError
            If a shape is another, or a number is not finite.
        """
        change = as_floats("change", change)
        check_shape("change", change, (None, len(self)), "ΔC/C₀, one row per reading")
        if not len(change):
            raise InputError(f"change has shape {change.shape}, expected at least one reading")
        check_finite("change", change, "what a taxel feels is known, even if it does not answer")
        noise, joints, losses = rng.spawn(3)
        rate = self.electronics.delivery.rate
        remembered = self.electronics.hysteresis.applied(change)
        felt = self.electronics.cross_talk.seen_by_taxels(remembered, self.wiring)
        level = self.baseline + self.gain * felt
        level = level + self._warmth(len(change), temperature) * self.drift
        level += self.electronics.noise.sample(
            self.white_noise, self.wiring, len(level), rate, noise
        )
        counts = self._spoiled(level, joints)
        return self.electronics.delivery.lose(counts, self.wiring, losses)

    def _warmth(self, readings: int, temperature: ArrayLike | None) -> Floats:
        """How much warmer than at the reference the skin is, (T, 1) K."""
        if temperature is None:
            return np.zeros((readings, 1))
        temperature = as_floats("temperature", temperature)
        check_shape("temperature", temperature, (readings,), "one per reading, in kelvin")
        check_finite("temperature", temperature, "the surroundings have one at any time")
        drift, rate = self.electronics.drift, self.electronics.delivery.rate
        return drift.warmth(temperature, rate)[:, None]

    def _spoiled(self, level: Floats, rng: np.random.Generator) -> Floats:
        """Counts as sent, (T, L), the defects included."""
        settings = self.electronics
        direction, rate = math.copysign(1.0, settings.board.gain), settings.delivery.rate
        clamps = settings.quantised and settings.board.step > 0
        full = OVERLOAD if clamps else 4.0 * abs(settings.board.gain)
        loose = np.flatnonzero(self.defect == Defect.FLICKERING)
        if len(loose):
            open_ = settings.defects.open(len(level), len(loose), rate, rng)
            level[:, loose] -= self.gain[loose] * open_  # all of its capacitance
        level[:, self.defect == Defect.DEAD] = settings.board.rest
        level[:, self.defect == Defect.SATURATED] = settings.board.rest + direction * full
        counts = settings.board.counts_from_level(level) if settings.quantised else level
        for taxel in np.flatnonzero(self.defect == Defect.STUCK):
            stop = math.ceil(self.stops_after[taxel] * rate)
            counts[stop:, taxel] = counts[min(stop, len(counts) - 1), taxel]
        counts[:, self.defect == Defect.ABSENT] = np.nan
        return counts


def recording(
    array: TaxelArray,
    sampling: Sampling,
    change: ArrayLike,
    temperature: ArrayLike | None,
    rng: np.random.Generator,
    *,
    source: str = "simulated",
) -> Recording:
    """Recording of the taxels of `array`.

    Parameters
    ----------
    array : TaxelArray
    sampling : Sampling
        From `array.sample_times`.
    change : (T, L) array
        ΔC/C₀ at `sampling.instants`.
    temperature : (T,) array, K, or None
    rng : numpy Generator
    source : str
        What the recording says about where it is from.

    Returns
    -------
    Recording
        One column per taxel, by uid; one row per reading that was logged.

    Raises
    ------
    InputError
        If every reading was lost on the way, or `change` has not a row per cycle.
    """
    counts = array.counts(change, temperature, rng)
    check_shape("change", counts, (len(sampling), len(array)), "one row per cycle of sampling")
    rows, stamps = sampling.logged
    if not len(rows):
        raise InputError(
            f"delivered is False for all {len(sampling)} readings, expected some: record longer, "
            "or lower lost_readings"
        )
    return Recording(
        stamps, counts[rows], array.patch.uid.copy(), array.electronics.board.unit, source
    )


@dataclass(frozen=True, kw_only=True)
class Electronics(Section):
    """From the change of capacitance to counts in time. Everything but the board is off at first.

    Parameters
    ----------
    board : Board
        What counts mean.
    quantised : bool
        Steps and clamps of the board; False leaves levels as they are.
    gain_spread : float
        Standard deviation of the logarithm of a taxel's gain over the nominal one.
    converter_gain_spread : float
        The same, of a factor that the taxels of one converter share.
    baseline_spread : float, counts
        Standard deviation of the baselines around the board's rest.
    tared : bool
        The board takes one reading as its base when it starts, so that each taxel rests off by the
        noise of that one.
    hysteresis : Hysteresis
    cross_talk : CrossTalk
    drift : ThermalDrift
    noise : Noise
    defects : Defects
    delivery : Delivery
    """

    board: Board = field(default_factory=ICubBoard)
    quantised: bool = True
    gain_spread: Annotated[float, SPREAD] = 0.0
    converter_gain_spread: Annotated[float, SPREAD] = 0.0
    baseline_spread: Annotated[float, Range(0.0, 1e9, "in counts; 0 is off")] = 0.0
    tared: bool = False
    hysteresis: Hysteresis = field(default_factory=Hysteresis)
    cross_talk: CrossTalk = field(default_factory=CrossTalk)
    drift: ThermalDrift = field(default_factory=ThermalDrift)
    noise: Noise = field(default_factory=Noise)
    defects: Defects = field(default_factory=Defects)
    delivery: Delivery = field(default_factory=Delivery)

    def manufacture(self, patch: Patch, rng: np.random.Generator) -> TaxelArray:
        """Draw the taxels of a patch.

        Each property has its own stream of random numbers, so that one that is switched off, or
        set otherwise, leaves the others as they were.
        """
        wired, taxels = wiring(patch), len(patch)
        gains, bases, drifts, noises, defects, stops, tares = rng.spawn(7)
        shared = gains.standard_normal(wired.converters)[wired.converter]
        own = gains.standard_normal(taxels)
        spread = self.converter_gain_spread * shared + self.gain_spread * own
        white = self.noise.draw(taxels, noises)
        baseline = self.board.rest + self.baseline_spread * bases.standard_normal(taxels)
        if self.tared:
            baseline = baseline - white * tares.standard_normal(taxels)
        return TaxelArray(
            electronics=self,
            patch=patch,
            gain=self.board.gain * np.exp(spread),
            baseline=baseline,
            drift=self.drift.draw(wired, drifts),
            white_noise=white,
            defect=self.defects.draw(taxels, defects),
            stops_after=self.defects.stuck_within * stops.random(taxels),
        )


def icub_electronics() -> Electronics:
    """Electronics of a board like the iCub's: bytes, 20 readings a second.

    Sources of the figures are in `docs/explanation/electronics.md`.
    """
    return Electronics(
        board=ICubBoard(),
        gain_spread=0.05,
        converter_gain_spread=0.1,
        baseline_spread=1.0,
        cross_talk=CrossTalk(neighbours=0.01),
        drift=ThermalDrift(
            per_kelvin=0.3, converter_spread=0.1, taxel_spread=0.1, time_constant=120.0
        ),
        noise=Noise(white=3.1, spread=0.5, flicker=0.3, walk=0.02),
        delivery=Delivery(
            rate=20.0,
            conversion_time=0.7e-3,
            free_running=True,
            delay=10e-3,
            jitter=0.03e-3,
            lost_readings=1e-3,
        ),
    )


def cyskin_electronics() -> Electronics:
    """Electronics of a board like CySkin's: 16-bit words clipped at 0, 20 readings a second.

    Sources of the figures are in `docs/explanation/electronics.md`.
    """
    return Electronics(
        board=CySkinBoard(),
        gain_spread=0.05,
        converter_gain_spread=0.1,
        cross_talk=CrossTalk(neighbours=0.01),
        drift=ThermalDrift(
            per_kelvin=-50.0, converter_spread=17.0, taxel_spread=17.0, time_constant=120.0
        ),
        noise=Noise(white=85.0, spread=0.3, flicker=10.0, walk=2.0),
        delivery=Delivery(
            rate=20.0, conversion_time=0.7e-3, free_running=True, delay=10e-3, jitter=1e-3
        ),
    )


def ideal_electronics(rate: float = 20.0) -> Electronics:
    """No electronics: readings are ΔC/C₀ itself, `rate` times a second."""
    return Electronics(board=LinearBoard(), quantised=False, delivery=Delivery(rate=rate))
