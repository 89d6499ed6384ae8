"""Measurement noise as the Kalman filters take it: one figure, or one per taxel."""

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats


def noise_of_taxels(noise_std: ArrayLike) -> Floats:
    """Checked noise: a number or (L,), above zero; NaN for a taxel that is not alive.

    Raises
    ------
    InputError
        If a value is zero, negative or infinite, or none is a number.
    """
    noise = np.array(as_floats("noise_std", noise_std))
    bad = ~((noise > 0) & np.isfinite(noise) | np.isnan(noise))
    if noise.ndim > 1 or bad.any() or np.isnan(noise).all():
        raise InputError(
            f"noise_std is {noise_std!r}, expected one number above 0 or one per taxel, such as "
            "calibration.noise_std: the filter weighs every reading by it"
        )
    noise.setflags(write=False)
    return noise


def variance_of_taxels(noise: Floats, taxels: int) -> Floats:
    """Variance of each of `taxels` taxels, (L,)."""
    if noise.ndim == 1 and len(noise) != taxels:
        raise InputError(
            f"noise_std has {len(noise)} values, expected 1 or {taxels}: one per taxel"
        )
    return np.array(np.broadcast_to(noise**2, (taxels,)))
