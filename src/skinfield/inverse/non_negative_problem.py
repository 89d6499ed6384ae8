"""Arrays of the compiled search for a non-negative field."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats
from skinfield.inverse.stamps import SIDE, Stamps
from skinfield.layout import Grid

if TYPE_CHECKING:
    from skinfield.inverse.dual.arrays import Problem
    from skinfield.inverse.non_negative import NonNegative

LANES = 64  # bytes: rows are filled up to whole vector registers
ROUNDING = {4: 5e-7, 8: 1e-15}  # of |r| |b|, by bytes of a number: of what a dual value may be off
CUT = 5e-3  # of a taxel's column that stamps may lack: bounded, and computed where it matters
SPARSE = 0.4  # share of the whole matrix up to which a pass by stamps is quicker
LARGE = 50_000  # numbers of a whole matrix that is as quick, and soon read where caches are cold


def problem_of(
    solver: "NonNegative", grid: Grid, rows: Floats, bump: Floats, whitening: Floats
) -> "Problem":
    """Problem of a solver on a grid.

    Parameters
    ----------
    solver : NonNegative
    grid : Grid
    rows : (K, L) array
        What each node's bump does to the whitened taxels.
    bump : (2 n + 1, 2 n + 1) array, Pa
    whitening : (L,) array, per unit of the reading
    """
    from scipy.special import ndtri

    from skinfield.inverse.dual.arrays import Problem
    from skinfield.inverse.dual.values import MARGIN

    nodes, taxels = rows.shape
    norms = np.linalg.norm(rows, axis=1)
    chances = max(int(np.count_nonzero(norms)), 1)
    threshold = float(-ndtri(solver.false_alarm_rate / chances))
    kind = np.dtype(solver.precision)
    lanes = LANES // kind.itemsize
    filled = np.zeros((nodes, -(-taxels // lanes) * lanes), dtype=kind)
    filled[:, :taxels] = rows
    return Problem(
        rows=filled,
        norms=norms.astype(kind),
        penalty=(solver.shrinkage * threshold * norms).astype(kind),
        bump=np.ascontiguousarray(bump, dtype=kind),
        whitening=np.ascontiguousarray(whitening, dtype=np.float64),
        **_stamps(rows, grid, kind),
        allowed=np.ones(nodes, dtype=np.bool_),
        threshold=threshold,
        least=solver.shrinkage * threshold - MARGIN,
        tolerance=solver.tolerance,
        rounding=ROUNDING[kind.itemsize],
        most=solver.most_iterations,
        height=grid.shape[0],
        width=grid.shape[1],
    )


def _stamps(rows: Floats, grid: Grid, kind: np.dtype[Any]) -> dict[str, Any]:
    """What a pass over all nodes may use in place of all rows; none where that does not pay."""
    if min(grid.shape) >= SIDE and rows.size > LARGE:
        stamps = Stamps.of(rows, grid, cut=CUT, dtype=kind)
        if stamps.share < SPARSE:
            return {
                "stamps": stamps.values.copy(),  # else read-only: another type to compile for
                "taxels": stamps.taxels,
                "firsts": stamps.firsts,
                "cells": stamps.cells,
                "dropped": stamps.dropped.astype(kind) * (1 + 1e-6),
            }
    none = np.zeros(0, dtype=np.int32)
    return {
        "stamps": np.zeros((0, SIDE**2), dtype=kind),
        "taxels": none,
        "firsts": none,
        "cells": none,
        "dropped": np.zeros(0, dtype=kind),
    }
