"""What a reconstructor is made of and called with, checked before it is used."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_offers, check_shape, check_type
from skinfield.layout import Grid, Patch
from skinfield.observation import Quantity
from skinfield.pipeline.intervals import Intervals


def check_parts(solver: object, finder: object, grid: object, intervals: object) -> None:
    """Raise InputError, with what to hand in, for a part that is something else."""
    why = "a solver such as GaussianField() or ContactFit()"
    check_offers("solver", solver, ("prepare",), why)
    check_offers("finder", finder, ("__call__",), "one such as ContactFinder()")
    if grid is not None:
        check_type("grid", grid, Grid, "such as Grid.square(patch, nodes=40)")
    if intervals is not None:
        check_type("intervals", intervals, Intervals, "those of a calibrated reconstructor")


def checked_readings(
    readings: ArrayLike, valid: ArrayLike | None, patch: Patch, quantity: Quantity
) -> tuple[Floats, NDArray[np.bool_]]:
    """Readings (T, L), and which of them to use (T, L), or InputError for what no skin reads."""
    table = np.atleast_2d(as_floats("readings", readings))
    check_shape("readings", table, (None, len(patch)), f"one per taxel of {patch.name!r}")
    if not len(table):
        raise InputError("readings is empty, expected one reading or more")
    if valid is None and np.isfinite(table).all() and (table > quantity.lowest).all():
        return table, np.ones(table.shape, dtype=np.bool_)
    if np.isinf(table).any():
        row, taxel = np.argwhere(np.isinf(table))[0]
        raise InputError(
            f"readings[{row}, {taxel}] is {table[row, taxel]}, expected finite numbers: "
            "mark a taxel that did not answer with NaN"
        )
    impossible = np.argwhere(table <= quantity.lowest)
    if len(impossible):
        row, taxel = impossible[0]
        raise InputError(
            f"readings[{row}, {taxel}] is {table[row, taxel]}, expected above "
            f"{quantity.lowest:g} ({len(impossible)} are not): no skin reads that; mark "
            "such taxels with NaN, and check the gain"
        )
    mask = ~np.isnan(table)
    if valid is not None:
        given = np.atleast_2d(np.asarray(valid, dtype=np.bool_))
        if given.shape not in (mask.shape, (1, mask.shape[1])):
            raise InputError(
                f"valid has shape {np.shape(valid)}, expected {mask.shape[1:]} or "
                f"{mask.shape}: one per taxel, or one per reading and taxel"
            )
        mask &= given
    empty = np.flatnonzero(~mask.any(axis=1))
    if len(empty):
        raise InputError(
            f"readings[{empty[0]}] has no valid taxel ({len(empty)} of {len(table)} readings), "
            "expected at least one: drop such readings"
        )
    return table, mask
