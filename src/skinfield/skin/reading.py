"""Readings as they came from the skin, before any meaning."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_shape

UNITS = {  # of a skin's readings, as files and recordings name them
    "count": "raw output of the converter",
    "dC/C0": "relative change of capacitance",
    "Pa": "stress at the base, positive in compression",
    "1": "mean indentation over the elastomer's thickness",
}


@dataclass(frozen=True, eq=False)
class Reading:
    """One patch at one instant.

    Attributes
    ----------
    stamp_ns : int, ns
        Since the epoch, by the clock of the source.
    counts : (L,) float64 array, counts
    valid : (L,) bool array
        False where the source says that the taxel did not answer.
    """

    stamp_ns: int
    counts: Floats
    valid: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Recording:
    """Readings of one port over time.

    Attributes
    ----------
    stamp_ns : (T,) int64 array, ns
    counts : (T, C) float64 array
        In `unit`; NaN where nothing was recorded.
    uid : (C,) uint64 array or None
        Of each column, where the file says it; else columns are channels.
    unit : str
        One of `UNITS` for a skin; of another sensor, what its file says ("N, N m").
    source : str
        File or port that it came from.
    notes : tuple of str
        What was skipped or repaired while reading, in sentences.
    skipped : int
        Lines or records that could not be read.
    """

    stamp_ns: NDArray[np.int64]
    counts: Floats
    uid: NDArray[np.uint64] | None = None
    unit: str = "count"
    source: str = ""
    notes: tuple[str, ...] = field(default=())
    skipped: int = 0

    def __post_init__(self) -> None:
        if self.counts.ndim != 2:
            raise InputError(f"counts has shape {self.counts.shape}, expected (readings, channels)")
        check_shape("stamp_ns", self.stamp_ns, (len(self.counts),), "one stamp per reading")
        if self.uid is not None:
            check_shape("uid", self.uid, (self.counts.shape[1],), "one uid per column of counts")

    def __len__(self) -> int:
        return len(self.counts)

    @property
    def time(self) -> Floats:
        """Seconds since the first reading, (T,)."""
        return np.asarray((self.stamp_ns - self.stamp_ns[:1]) * 1e-9, dtype=np.float64)

    @property
    def rate(self) -> float:
        """Median readings per second; NaN for fewer than two readings."""
        steps = np.diff(self.stamp_ns)
        return (
            float(1e9 / np.median(steps)) if len(steps) and np.median(steps) > 0 else float("nan")
        )
