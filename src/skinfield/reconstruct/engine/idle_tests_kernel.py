"""Idle tests of patches by tiles, compiled; and readings without an offset."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.compiled import inner, njit
from skinfield.solve.tiles_kernel import TOGETHER, apply_tiles

Ints32 = NDArray[np.int32]
Numbers = NDArray[Any]


@njit
def idle_patches(
    values: Numbers,
    taxels: Ints32,
    firsts: Ints32,
    cells: Ints32,
    pitch: int,
    dropped: Numbers,
    threshold: float,
    white: Numbers,
    scores: Numbers,
    idle: NDArray[np.bool_],
) -> None:
    """Write into `idle` (P,) of which patches no product of tiles exceeds the threshold.

    The first five are those of `Tiles`, `white` (P, L) are readings. Each product may be too small
    by its entry of `dropped` times the norm of the readings, which is added. `scores` is room for
    the fields of the patches that are computed together.
    """
    for start in range(0, len(white), TOGETHER):
        now = min(TOGETHER, len(white) - start)  # scores stay in the first cache
        room = scores[:now]
        apply_tiles(values, taxels, firsts, cells, pitch, white[start : start + now], room)
        for patch in range(now):
            above = count_above(room[patch], dropped, white[start + patch], threshold)
            idle[start + patch] = above == 0


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
