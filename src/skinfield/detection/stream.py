"""Detection in live readings: sums over several lengths of time, at a constant cost per reading."""

from typing import TYPE_CHECKING

import numpy as np

from skinfield.detection.bank import spread_of
from skinfield.detection.detection import Detection
from skinfield.detection.false_alarms import FalseAlarms
from skinfield.detection.lookback import Lookback
from skinfield.detection.posterior import detection
from skinfield.errors import Floats, InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from skinfield.detection.detector import Detector


def halved(readings: int) -> tuple[int, ...]:
    """Lengths from 1 up to `readings`, each about half of the next."""
    lengths = []
    while readings >= 1:
        lengths.append(readings)
        readings //= 2
    return tuple(lengths[::-1])


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
        matches = self.lookback.matches(sums[None], self._spread(used), used)
        return detection(
            self.lookback,
            matches,
            self.detector.positions,
            float(self.detector.statistic(matches)[0]),
            self.threshold,
            self.detector.touch_rate,
            self.detector.patch.pitch,
            self._valid[: self._held],
        )

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

    def _spread(self, used: list[int]) -> Floats | None:
        """1/g by length and template; None where every length is full and every taxel answered."""
        if used[-1] == self.lengths[-1] and self._valid.all():
            return None
        bank = self.lookback.bank
        parts, total, done = [], np.zeros(len(bank.scaled)), 0
        for length, weight in zip(used, self.lookback.weight(used), strict=True):
            for row in range(done, length):
                total = total + bank.information(self._valid[row])
            done = length
            parts.append(spread_of(total * weight))
        return np.concatenate(parts)
