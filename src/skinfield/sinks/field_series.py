"""The arrays of a file of fields: names, shapes, units."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.fields import Estimate
from skinfield.layout import Grid

Arrays = dict[str, NDArray[Any]]
SERIES = {  # arrays with an axis of readings: type, axes after it, unit, meaning
    "stamp_ns": ("i8", (), "ns", "time of the reading, since the epoch of its source"),
    "pressure": ("f4", ("row", "column"), "Pa", "normal traction, positive in compression"),
    "pressure_std": ("f4", ("row", "column"), "Pa", "one standard deviation of the pressure"),
    "displacement": ("f4", ("row", "column", "axis"), "m", "of the surface, in the patch's frame"),
}
FIXED = {  # arrays that all readings share
    "position": ("f8", ("row", "column", "axis"), "m", "of the nodes, in the patch's frame"),
}
CHUNK_BYTES = 4 << 20  # of all fields together
FORMAT = "skinfield fields 1"


def readings_per_chunk(grid: Grid) -> int:
    """Readings whose fields fill `CHUNK_BYTES`."""
    return max(1, CHUNK_BYTES // (len(grid) * 20))


def series_of(estimate: Estimate) -> Arrays:
    """Arrays of `SERIES`, each with a leading axis of readings."""
    shape = (-1, *estimate.grid.shape)
    count = len(estimate) if estimate.is_batch else 1
    return {
        "stamp_ns": np.broadcast_to(np.asarray(estimate.stamp_ns, np.int64), count),
        "pressure": estimate.pressure.reshape(shape).astype(np.float32),
        "pressure_std": np.broadcast_to(
            estimate.pressure_std.reshape(shape).astype(np.float32), (count, *estimate.grid.shape)
        ),
        "displacement": estimate.displacement.reshape(*shape, 3).astype(np.float32),
    }


def fixed_of(grid: Grid) -> Arrays:
    """Arrays of `FIXED`."""
    return {"position": grid.positions.reshape(*grid.shape, 3)}


def attributes_of(grid: Grid) -> dict[str, Any]:
    """What is said of the whole file."""
    return {
        "format": FORMAT,
        "patch": grid.patch.name,
        "pitch_m": grid.pitch,
        "cell_area_m2": grid.cell_area,
    }
