"""A source without hardware: readings that were computed before."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.acquisition import Port
from skinfield.errors import InputError, as_floats, check_positive
from skinfield.sources.live.table import TableStream


@dataclass(frozen=True, eq=False)
class SimulationSource:
    """Delivers the rows of a table at a steady rate, as one port.

    Parameters
    ----------
    counts : (T, C) array
        NaN where a taxel does not answer.
    rate : float, 1/s
    name : str
        Of the port.
    unit : str
        One of `skinfield.reading.UNITS`.
    loop : bool
        Whether it begins anew behind the last row.
    """

    counts: ArrayLike
    rate: float = 50.0
    name: str = "skin"
    unit: str = "count"
    loop: bool = True

    def __post_init__(self) -> None:
        check_positive("rate", self.rate, "readings per second")
        counts = as_floats("counts", self.counts)
        if counts.ndim != 2 or not counts.size:
            raise InputError(f"counts has shape {counts.shape}, expected (readings, channels)")
        object.__setattr__(self, "counts", counts)

    def open(self) -> TableStream:
        """Begin; the first reading is there at the first poll."""
        counts = np.asarray(self.counts, np.float64)
        step = round(1e9 / self.rate)
        after = np.arange(len(counts), dtype=np.int64) * step
        port = Port(self.name, counts.shape[1], self.unit)
        return TableStream((port,), counts, after, loop=self.loop, pause_ns=step)
