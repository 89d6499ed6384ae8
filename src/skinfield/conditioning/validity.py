"""Which counts of one reading can be used."""

import numpy as np
from numpy.typing import ArrayLike

from skinfield.conditioning.convention import Bools, Convention
from skinfield.errors import InputError, as_floats


def valid_from_counts(
    counts: ArrayLike,
    convention: Convention | None = None,
    *,
    taxels: int | None = None,
    alive: Bools | None = None,
) -> Bools:
    """Validity of each count of a reading (L,) or of readings (T, L), same shape.

    Invalid are NaN and infinities, values that the convention cannot send, values at its clamp
    (the load is off the scale in this reading; the taxel lives), and taxels that are not alive.
    An invalid taxel is to be left out, or to be NaN for a filter, never to be set to zero.

    Parameters
    ----------
    counts : array, counts
    convention : Convention, optional
        Knows range and clamps.
    taxels : int, optional
        Expected length of the last axis; default that of `alive`, if given.
    alive : (L,) bool array, optional
        As a calibration has it.

    Raises
    ------
    InputError
        If the length is another, or no count is a number.
    """
    array = as_floats("counts", counts)
    width = taxels if taxels is not None else None if alive is None else len(alive)
    if array.ndim not in (1, 2) or (width is not None and array.shape[-1] != width):
        raise InputError(
            f"counts has shape {array.shape}, expected "
            f"({'taxels' if width is None else width},) or (readings, "
            f"{'taxels' if width is None else width}): one column per taxel"
        )
    valid = np.isfinite(array)
    if not valid.any():
        raise InputError(
            f"counts of shape {array.shape} hold no number, expected a reading: "
            "the board does not answer, or this is another port"
        )
    if convention is not None:
        valid &= (array >= convention.lowest) & (array <= convention.highest)
        valid &= ~convention.saturated(array)
    if alive is not None:
        valid &= alive
    return valid
