"""Block-sparse products and idle tests of a whole skin, compiled."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.errors import Ints
from skinfield.solve.tiles_kernel import TOGETHER, apply_tiles

FAST = {"reassoc", "contract", "arcp", "nsz"}  # sums in any order; infinities stay what they are

TILE, TILES, PITCH, SIZE, WIDTH, COUNT, TAXEL, CELL, BOUND, FIRST = range(10)  # of `table`
Ints32 = NDArray[np.int32]
Numbers = NDArray[Any]


@njit
def products(
    values: Numbers,
    taxels: Ints32,
    firsts: Ints32,
    cells: Ints32,
    table: Ints,
    white: Numbers,
    out: Numbers,
) -> None:
    """Write the products of whitened readings (N,) of all patches into `out` (M,).

    `table` (G, 10) says of each kind of patch: its first tile and how many, cells of a row, taxels
    and cells of a patch, patches, where its readings begin in `white`, its fields in `out`, its
    bounds in those of an idle test, and its patches among all.
    """
    for kind in range(len(table)):
        row = table[kind]
        tile, tiles, size, width, count = row[TILE], row[TILES], row[SIZE], row[WIDTH], row[COUNT]
        taxel, cell = row[TAXEL], row[CELL]
        apply_tiles(
            values,
            taxels,
            firsts[tile : tile + tiles + 1],
            cells[tile : tile + tiles],
            row[PITCH],
            white[taxel : taxel + count * size].reshape((count, size)),
            out[cell : cell + count * width].reshape((count, width)),
        )


@njit
def idle_patches(
    values: Numbers,
    taxels: Ints32,
    firsts: Ints32,
    cells: Ints32,
    table: Ints,
    dropped: Numbers,
    thresholds: Numbers,
    white: Numbers,
    scores: Numbers,
    idle: NDArray[np.bool_],
) -> None:
    """Write into `idle` (P,) of which patches no product exceeds its kind's threshold.

    Each product may be too small by its entry of `dropped` times the norm of the readings, which is
    added. `scores` is room for the fields of the patches that are computed together.
    """
    for kind in range(len(table)):
        row = table[kind]
        tile, tiles, size, width, count = row[TILE], row[TILES], row[SIZE], row[WIDTH], row[COUNT]
        given = white[row[TAXEL] : row[TAXEL] + count * size].reshape((count, size))
        lacking = dropped[row[BOUND] : row[BOUND] + width]
        for start in range(0, count, TOGETHER):
            now = min(TOGETHER, count - start)  # scores stay in the first cache
            room = scores[: now * width].reshape((now, width))
            apply_tiles(
                values,
                taxels,
                firsts[tile : tile + tiles + 1],
                cells[tile : tile + tiles],
                row[PITCH],
                given[start : start + now],
                room,
            )
            for patch in range(now):
                above = count_above(room[patch], lacking, given[start + patch], thresholds[kind])
                idle[row[FIRST] + start + patch] = above == 0


@njit(fastmath=FAST)
def idle_without(
    rows: Numbers,
    shared: Numbers,
    root: Numbers,
    offset: Numbers,
    valid: NDArray[np.bool_],
    white: Numbers,
    threshold: float,
) -> bool:
    """Whether no row of the valid taxels alone sees more than the threshold.

    The first four are of a `DualProblem`: rows B - (B s) s', B s, s, and an offset o that taxels
    share. `white` b (L,) are readings in units of their noise. A row sees B C b / (B C B')^1/2, all
    of the valid part, where C = 1 - o o' / (1 + |o|^2) is the inverse covariance.
    """
    power, along = 1.0, 0.0
    for taxel in range(len(white)):
        if valid[taxel]:
            power += offset[taxel] * offset[taxel]
            along += offset[taxel] * white[taxel]
    for node in range(len(rows)):
        seen, square, common = 0.0, 0.0, 0.0
        row, level = rows[node], shared[node]
        for taxel in range(len(white)):
            value = row[taxel] + level * root[taxel] if valid[taxel] else 0.0
            seen += value * white[taxel]
            square += value * value
            common += value * offset[taxel]
        square = max(square - common * common / power, 0.0)
        if not seen - common * along / power <= threshold * np.sqrt(square):
            return False
    return True


@njit
def without_offset(white: Numbers, weights: Numbers, offset: Numbers, out: Numbers) -> None:
    """Write into `out` readings (P, L) without what each patch's weights (L,) say of an offset."""
    for patch in range(len(white)):
        total = 0.0
        for taxel in range(len(weights)):
            total += weights[taxel] * white[patch, taxel]
        for taxel in range(len(weights)):
            out[patch, taxel] = white[patch, taxel] - total * offset[taxel]


@inner
def count_above(scores: Numbers, lacking: Numbers, readings: Numbers, threshold: float) -> int:
    """Number of products that may be above the threshold; what is no number counts as such."""
    square = 0.0
    for value in readings:
        square += value * value
    norm, limit = scores.dtype.type(np.sqrt(square)), scores.dtype.type(threshold)
    above = 0
    for cell in range(len(scores)):
        above += not (scores[cell] + lacking[cell] * norm <= limit)
    return above
