"""A filter run over many readings: recordings, and what a step becomes."""

import numpy as np
from numpy.typing import ArrayLike

from skinfield.conditioning.filters.protocol import Filter
from skinfield.errors import Floats, as_floats, check_positive, check_shape

_RUN_IN = 4000


def filtered(settings: Filter, counts: ArrayLike, rate: float) -> Floats:
    """All readings (T, L) of a recording through a fresh filter, as streaming would.

    Parameters
    ----------
    settings : Filter
    counts : (T, L) array
        NaN where a taxel is invalid.
    rate : float, 1/s
    """
    counts = as_floats("counts", counts)
    check_shape("counts", counts, (None, None), "one row per reading, one column per taxel")
    state, out = settings.prepare(counts.shape[1], rate), np.empty(counts.shape)
    for reading, row in zip(counts, out, strict=True):
        state.apply(reading, row)
    return out


def step_response(settings: Filter, rate: float, seconds: float, *, taxels: int = 1) -> Floats:
    """Output for readings that go from 0 to 1 and stay, (N, taxels), from the first 1 on.

    The filter has run in on zeros before. `taxels` is their number where the settings hold a
    noise per taxel.
    """
    check_positive("rate", rate, "readings per second")
    check_positive("seconds", seconds, "how much of the response to return")
    readings = max(1, round(seconds * rate))
    counts = np.concatenate([np.zeros((_RUN_IN, taxels)), np.ones((readings, taxels))])
    return filtered(settings, counts, rate)[_RUN_IN:]


def rise_time(settings: Filter, rate: float, *, taxels: int = 1, within: float = 10.0) -> float:
    """Seconds from a step until half of it has come through, of the slowest taxel.

    Infinite if that takes more than `within` seconds.
    """
    reached = step_response(settings, rate, within, taxels=taxels) >= 0.5
    if not reached.any(axis=0).all():
        return float("inf")
    return float(np.max(np.argmax(reached, axis=0)) / rate)
