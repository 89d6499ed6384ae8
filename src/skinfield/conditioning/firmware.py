"""The iCub's correction of warmth, as its boards compute it."""

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, as_floats

GAINS = (70, 96, 83, 38, 38, 70, 0, 45, 77, 164, 0, 77)
"""Of the firmware, skin type 0, per channel of a triangle: 128ths of the drift of its pad."""
GAINS_V2 = (58, 91, 39, 23, 35, 90, 0, 38, 68, 115, 0, 86)
"""Of the firmware, skin type 8: pads of the second generation."""
PAD, UNUSED = 6, 10
"""Channels of the pad that the firmware goes by, and of the one that it does not."""


def firmware_drift(
    pad_difference: ArrayLike, gains: ArrayLike = GAINS, *, negated_first: bool = False
) -> Floats:
    """What the firmware takes off a taxel for the warmth of its pad, converter counts; bit-exact.

    ± ((|T - T_b| >> 2) · gain) >> 5, with the sign of T - T_b.

    Parameters
    ----------
    pad_difference : array, converter counts
        T - T_b of the pad, whole numbers.
    gains : array of int
        Broadcast against it.
    negated_first : bool
        Shift the negated product, as the mtb4 boards do, instead of negating the shifted one, as
        the mtb3 boards do: rounds negative drifts the other way.
    """
    pad = as_floats("pad_difference", pad_difference)
    product = np.floor(np.abs(pad) / 4.0) * np.asarray(gains)
    sign = np.where(pad < 0, -1.0, 1.0)
    if negated_first:
        return np.asarray(np.floor(sign * product / 32.0))
    return np.asarray(sign * np.floor(product / 32.0))
