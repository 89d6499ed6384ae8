"""Readings as they came from the skin, before any meaning."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, InputError, check_shape
from skinfield.plot import Pictured, Place, drawing, number, plural

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


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Pictured):
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

    def __repr__(self) -> str:
        return f"Recording({self._size()}, {self._length()}, unit {self.unit!r})"

    def _size(self) -> str:
        channels = plural(self.counts.shape[1], "channel")
        return f"{plural(len(self), 'reading')} of {channels}"

    def _length(self) -> str:
        seconds = float(self.time[-1]) if len(self) else 0.0
        return f"{number(seconds)} s at {number(self.rate)} Hz"

    def plot(self, ax: Place = None, *, channels: Sequence[int] | None = None) -> Any:
        """Draw readings over time: those that move most, or chosen ones.

        Of more than 4000 readings the lowest and the highest of each run are drawn.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            To draw in. Default those of a new figure.
        channels : sequence of int, optional
            Columns of `counts`. Default the six that move most.

        Returns
        -------
        matplotlib Axes
            Time in s, readings in `unit`.

        Raises
        ------
        InputError
            For a column that is not there, if `ax` is something else, or Matplotlib is not
            installed.
        """
        return drawing("skinfield.skin.plot:plot_recording")(self, ax, channels)

    def _facts(self) -> Mapping[str, str]:
        known = np.isfinite(self.counts).mean() if self.counts.size else 1.0
        missing = f"{number(100.0 * float(1.0 - known), 2)} %"
        return {
            "Recording": self.source or "–",
            "readings": self._size(),
            "length": self._length(),
            "unit": f"{self.unit}: {UNITS.get(self.unit, 'of another sensor')}",
            "missing": missing,
            "columns": "uids" if self.uid is not None else "channels",
            **({"left out": f"{self.skipped} lines or records"} if self.skipped else {}),
            **({"notes": "; ".join(self.notes)} if self.notes else {}),
        }

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
