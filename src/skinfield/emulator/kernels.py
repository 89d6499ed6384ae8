"""Kernels of the virtual skin: what taxels read of presses, and their counts."""

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import njit
from skinfield.errors import Floats, Ints

Shorts = NDArray[np.uint16]


@njit
def add_press(
    change: Floats,
    plane: Floats,
    first: int,
    last: int,
    table: Floats,
    spacing: float,
    row: float,
    x: float,
    y: float,
) -> None:
    """Add one press to the readings of taxels `first` to `last`, linear between a table's entries.

    Parameters
    ----------
    change : (L,) array
        ΔC/C₀, added to in place.
    plane : (L, 2) array, m
        Of each taxel in its patch's plane.
    first, last : int
        The patch's taxels; `last` is not among them.
    table : (F, D) array
    spacing : float, m
        Between the table's distances.
    row : float
        Of the table, 0 to F - 1.
    x, y : float, m
        Of the press.
    """
    lower = min(int(row), table.shape[0] - 2)
    part = row - lower
    reach = (table.shape[1] - 1) * spacing
    for taxel in range(first, last):
        dx, dy = plane[taxel, 0] - x, plane[taxel, 1] - y
        if abs(dx) >= reach or abs(dy) >= reach:
            continue
        column = np.sqrt(dx * dx + dy * dy) / spacing
        at = int(column)
        if at + 1 >= table.shape[1]:
            continue
        rest = column - at
        near = (1.0 - part) * table[lower, at] + part * table[lower + 1, at]
        far = (1.0 - part) * table[lower, at + 1] + part * table[lower + 1, at + 1]
        change[taxel] += (1.0 - rest) * near + rest * far


@njit
def convert(
    change: Floats,
    level: Floats,
    gain: Floats,
    drift: Floats,
    warmth: float,
    white: Floats,
    common: float,
    converter: Ints,
    normal: Floats,
    start: int,
    shared: int,
    held: Floats,
    low: float,
    high: float,
    out: Floats,
) -> None:
    """Whole counts of all channels: level + gain · ΔC/C₀ + drift + noise, rounded and clamped.

    Parameters
    ----------
    change, level, gain, drift, white : (L,) arrays
    warmth : float, K
        Above the temperature at which `level` is exact.
    common : float, counts
        Standard deviation of the noise that the channels of one converter share.
    converter : (L,) int64 array
    normal : (N,) array
        Normal deviates, of which a reading takes a stretch; N is at least L + `start` and the
        largest converter + `shared`.
    held : (L,) array
        NaN, or the count that a channel sends whatever it feels.
    low, high : float
        Clamps.
    out : (L,) array
    """
    for i in range(len(out)):
        if not np.isnan(held[i]):
            out[i] = held[i]
            continue
        value = level[i] + gain[i] * change[i] + drift[i] * warmth + white[i] * normal[start + i]
        if common > 0.0:
            value += common * normal[shared + converter[i]]
        out[i] = min(max(np.rint(value), low), high)


@njit
def scatter(values: Floats, slot: Ints, out: Shorts) -> None:
    """Write whole numbers to their places: `out[slot[i]] = values[i]`, none where a slot is < 0."""
    for i in range(len(values)):
        if slot[i] >= 0:
            out[slot[i]] = np.uint16(values[i])
