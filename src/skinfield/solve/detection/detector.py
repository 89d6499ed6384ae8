"""Detector of touches on a patch: one reading, a recording, or readings one after the other."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import BondedLayer, Capacitance, Layer, Mechanics, Quantity, check_skin
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
from skinfield.estimate.ranking import first_largest
from skinfield.skin import Patch
from skinfield.solve.detection.detection import Detection, FalseAlarms
from skinfield.solve.detection.dictionary import DetectorTemplates, ReadingNoise, round_touches
from skinfield.solve.detection.statistics import (
    Lookback,
    MarginalLikelihood,
    Matches,
    Statistic,
    log_evidence,
)

# What templates leave out: touches that are deep, or of other sizes. About the root mean square
# error of balls of 6 to 20 mm that press with 0.5 and 1.5 N, which noise does not explain.
PLACE_ERROR = 0.25  # of the distance of two taxels


def halved(readings: int) -> tuple[int, ...]:
    """Lengths from 1 up to `readings`, each about half of the next."""
    return tuple(readings >> step for step in reversed(range(readings.bit_length())))


class DetectorStream:
    """Looks back over several lengths of time with every reading; made by `Detector.stream`.

    The lengths are part of what is averaged, so there is one statistic and one threshold: the
    stated rate of false alarms holds per reading, for all lengths together.

    Attributes
    ----------
    detector : Detector
    lengths : tuple of int
        Readings that are summed.
    window : float, s
        Age at which a reading is forgotten.
    threshold : float
    """

    def __init__(self, detector: "Detector", lengths: tuple[int, ...], window: float) -> None:
        self.detector, self.lengths, self.window = detector, lengths, window
        self.lookback = Lookback(detector.lookback.bank, lengths, detector.lookback.strength)
        self.false_alarms = FalseAlarms.sampled(self.lookback, detector.statistic, detector.seed)
        self.threshold = self.false_alarms.threshold(detector.false_alarm_rate)
        longest, taxels = lengths[-1], len(detector.patch)
        self._whitened = np.zeros((longest, taxels))  # newest first
        self._valid = np.zeros((longest, taxels), dtype=np.bool_)
        self._stamps = np.zeros(longest, dtype=np.int64)
        self._held = 0

    def reset(self) -> None:
        """Forget all readings."""
        self._held = 0

    def update(self, reading: "ArrayLike", stamp_ns: int) -> Detection:
        """Take a reading and test all lengths that end with it.

        Parameters
        ----------
        reading : (L,) array, in the quantity's unit
            NaN marks a taxel that did not answer.
        stamp_ns : int, ns
            After that of the reading before. Readings older than `window` are forgotten.

        Raises
        ------
        InputError
            For a reading that `Detector` would refuse, or a time that does not go on.
        """
        self._take(reading, int(stamp_ns))
        used = [min(length, self._held) for length in self.lengths]
        sums = np.stack([self._whitened[:n].sum(axis=0) for n in used])
        valid = self._valid[: self._held]
        matches = self.lookback.matches(sums[None], self.lookback.spread_where(valid, used), used)
        return self.detector.detection(self.lookback, matches, self.threshold, valid)

    def _take(self, reading: "ArrayLike", stamp_ns: int) -> None:
        table = self.detector.checked(reading)
        if len(table) != 1:
            raise InputError(f"reading has {len(table)} rows, expected one reading per update")
        if self._held and stamp_ns <= self._stamps[0]:
            raise InputError(
                f"stamp_ns is {stamp_ns}, expected above {self._stamps[0]}, that of the reading "
                "before: give readings in order, or call reset() first"
            )
        for ring in (self._whitened, self._valid, self._stamps):
            ring[1:] = ring[:-1]
        self._whitened[0] = self.lookback.bank.whitened(table[0])
        self._valid[0], self._stamps[0] = ~np.isnan(table[0]), stamp_ns
        held = min(self._held + 1, len(self._stamps))
        young = self._stamps[:held] > stamp_ns - self.window * 1e9
        self._held = int(young.sum())


MOST_HELD = 20_000  # readings that a stream looks back over: each update moves them all


class Detector:
    r"""Prepared test of a patch's readings for a light touch; call it with readings.

    Small round touches at every place are compared with the readings, and their likelihoods over
    that of noise alone are averaged: over place, size, and a force that is not negative. The
    threshold is found once, by `detection.false_alarms`, and holds for any number of readings.

    Parameters
    ----------
    patch : Patch
    layer : Layer, optional
        Default `Layer()`.
    mechanics : Mechanics, optional
        Default `BondedLayer()`.
    quantity : Quantity, optional
        What a reading is. Default `Capacitance()`. Only its linear part counts: touches are light.
    noise_std : float or (L,) array, in the quantity's unit, optional
        Standard deviation of one reading, of Gaussian noise. Default the quantity's
        `typical_noise`.
    false_alarm_rate : float
        Share of calls on an idle patch that may say "detected".
    common_mode : bool or float, in the quantity's unit
        An offset that all taxels of a reading share, as a supply's noise or a drift makes it.
        True: any offset is taken out first, whatever its course in time. A number: its standard
        deviation, of offsets that are independent from reading to reading. Left out where there is
        one, false alarms are more than stated.
    correlation : float
        Of a taxel's noise in one reading with that in the next, as filters leave it: it falls as a
        power of the readings between. Default 0, white noise. It matters where readings are taken
        together; stated too low, false alarms are more than stated.
    statistic : Statistic, optional
        What is compared with the threshold. Default `MarginalLikelihood()`; `LargestMatch()` finds
        somewhat more between taxels and less over them.
    strength : float
        Mean of the force before any reading (its prior is exponential), in standard deviations of
        the force of the best seen touch. Near the lightest that can be found, the test finds most.
    touch_rate : float
        Share of calls with a touch, before any reading: for `Detection.probability` alone.
    radii : sequence of float, m, optional
        Of the touches. Default 0.5, 1 and 1.75 thicknesses.
    spacing : float, m, optional
        Between places. Default a quarter of pad radius and thickness together.
    seed : int
        Of the draws that find the threshold.

    Raises
    ------
    InputError
        For a value that no detector can have.

    Notes
    -----
    Readings are relative to rest: a baseline is taken off before. Taxels that do not answer only
    take evidence away, so fewer false alarms than stated come of them.
    """

    def __init__(
        self,
        patch: Patch,
        layer: Layer | None = None,
        *,
        mechanics: Mechanics | None = None,
        quantity: Quantity | None = None,
        noise_std: ArrayLike | None = None,
        false_alarm_rate: float = 1e-3,
        common_mode: bool | float = False,
        correlation: float = 0.0,
        statistic: Statistic | None = None,
        strength: float = 7.0,
        touch_rate: float = 0.01,
        radii: Sequence[float] | None = None,
        spacing: float | None = None,
        seed: int = 0,
    ) -> None:
        check_range("false_alarm_rate", false_alarm_rate, 1e-9, 0.5, "of an idle patch's calls")
        check_range("touch_rate", touch_rate, 1e-12, 1 - 1e-12, "of calls with a touch")
        check_positive("strength", strength, "the force that is expected, in deviations of noise")
        self.patch = patch
        self.layer = Layer() if layer is None else layer
        self.mechanics = BondedLayer() if mechanics is None else mechanics
        self.quantity = Capacitance() if quantity is None else quantity
        self.statistic = MarginalLikelihood() if statistic is None else statistic
        check_skin(patch, self.layer, self.mechanics, self.quantity)
        why = "one of MarginalLikelihood() and LargestMatch()"
        check_offers("statistic", self.statistic, ("__call__",), why)
        self.false_alarm_rate, self.touch_rate, self.seed = false_alarm_rate, touch_rate, seed
        noise = self.quantity.typical_noise if noise_std is None else noise_std
        self.noise = ReadingNoise.of(noise, common_mode, correlation, len(patch))
        self.templates = round_touches(
            patch, self.layer, self.mechanics, self.quantity, radii, spacing
        )
        self.positions = patch.surface.position_from_plane(self.templates.places)
        self.positions.setflags(write=False)
        self.lookback = Lookback(DetectorTemplates.of(self.templates, self.noise), (1,), strength)
        self.false_alarms = FalseAlarms.sampled(self.lookback, self.statistic, seed)
        self.threshold = self.false_alarms.threshold(false_alarm_rate)

    def __call__(self, readings: ArrayLike) -> Detection:
        """Test one reading, or several of one touch together.

        Parameters
        ----------
        readings : (L,) or (T, L) array, in the quantity's unit
            NaN marks a taxel that did not answer in that reading.

        Raises
        ------
        InputError
            For a wrong number of taxels, an infinite or impossible value, or none at all.
        """
        table = self.checked(readings)
        valid = ~np.isnan(table)
        if not valid.any():
            raise InputError(
                f"readings of shape {table.shape} are all NaN, expected at least one value: no "
                "taxel answered, which is no evidence of anything"
            )
        lookback = replace(self.lookback, lengths=(len(table),))
        sums = lookback.bank.whitened(table).sum(axis=0)
        matches = lookback.matches(sums[None, None], lookback.spread_where(valid, lookback.lengths))
        return self.detection(lookback, matches, self.threshold, valid)

    def detection(
        self, lookback: Lookback, matches: Matches, threshold: float, valid: NDArray[np.bool_]
    ) -> Detection:
        """What one row of matches says; `valid` (T, L) are the values that are there."""
        templates, statistic = self.templates, float(self.statistic(matches)[0])
        evidence, share = log_evidence(matches)
        by_length = share.reshape(len(lookback.lengths), -1).sum(axis=1)
        by_place = share.reshape(-1, len(self.positions)).sum(axis=0)
        best = first_largest(by_place)
        square = np.square(templates.places - templates.places[best]).sum(axis=1)
        apart = by_place @ square + templates.spacing**2 / 6
        odds = np.log(self.touch_rate / (1.0 - self.touch_rate)) + evidence[0]
        return Detection(
            statistic=statistic,
            threshold=threshold,
            detected=statistic > threshold,
            probability=float(1.0 / (1.0 + np.exp(-np.clip(odds, -700.0, 700.0)))),
            position=self.positions[best],
            position_std=float(np.sqrt(apart + (PLACE_ERROR * self.patch.pitch) ** 2)),
            readings=min(lookback.lengths[first_largest(by_length)], len(valid)),
            left_out=int(valid.size - np.count_nonzero(valid)),
        )

    def statistics(self, readings: ArrayLike, count: int = 1) -> Floats:
        """Statistic (N,) of N decisions at once, each of the mean of some readings.

        Parameters
        ----------
        readings : (N, L) array, in the quantity's unit
            No value may be NaN.
        count : int
            Readings that each row is the mean of.
        """
        table = self.checked(readings)
        if np.isnan(table).any():
            raise InputError("readings hold NaN, expected values: test such readings one by one")
        check_range("count", count, 1, 1_000_000_000, "readings that a row is the mean of")
        lookback = replace(self.lookback, lengths=(count,))
        out = np.empty(len(table))
        for first in range(0, len(table), 512):
            sums = count * lookback.bank.whitened(table[first : first + 512])
            out[first : first + 512] = self.statistic(lookback.matches(sums[:, None]))
        return out

    def stream(
        self, window: float = 0.3, rate: float = 50.0, lengths: Sequence[int] | None = None
    ) -> DetectorStream:
        """Detector of live readings that looks back over several lengths at once.

        Parameters
        ----------
        window : float, s
            The longest time over which readings are integrated; older ones are forgotten.
        rate : float, 1/s
            Readings per second.
        lengths : sequence of int, optional
            Numbers of readings that are tried. Default those of `window`, halved down to 1: 15, 7,
            3, 1 for 0.3 s at 50 Hz.

        Raises
        ------
        InputError
            For no reading, or for more than 20 000 to look back over.
        """
        check_positive("window", window, "in seconds")
        check_positive("rate", rate, "readings per second")
        if lengths is None:
            if window * rate > MOST_HELD:
                raise InputError(
                    f"window is {window!r} s, which is {window * rate:.3g} readings at a rate of "
                    f"{rate!r}, expected at most {MOST_HELD}: give a shorter one"
                )
            chosen = halved(round(window * rate))
        else:
            for length in lengths:
                check_count("lengths", length, 1, MOST_HELD, "readings that are looked back over")
            chosen = tuple(sorted(set(lengths)))
        if not chosen:
            raise InputError(
                f"lengths is {lengths!r} with a window of {window * rate:g} readings, expected "
                "whole numbers from 1: give a longer window"
            )
        return DetectorStream(self, chosen, window)

    def checked(self, readings: ArrayLike) -> Floats:
        """Readings as a table (T, L), NaN allowed."""
        table = np.atleast_2d(as_floats("readings", readings))
        why = f"one per taxel of {self.patch.name!r}"
        check_shape("readings", table, (None, len(self.patch)), why)
        bad = np.argwhere(np.isinf(table) | (table <= self.quantity.lowest))
        if len(bad):
            row, taxel = bad[0]
            raise InputError(
                f"readings[{row}, {taxel}] is {table[row, taxel]}, expected a finite number above "
                f"{self.quantity.lowest:g}: mark a taxel that did not answer with NaN"
            )
        if not len(table):
            raise InputError("readings is empty, expected one reading or more")
        return table
