"""Recording of simulated counts, as a board's."""

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import InputError, check_shape
from skinfield.simulate.electronics.array import TaxelArray
from skinfield.simulate.electronics.delivery import Sampling
from skinfield.skin.reading import Recording


def recording(
    array: TaxelArray,
    sampling: Sampling,
    change: ArrayLike,
    temperature: ArrayLike | None,
    rng: np.random.Generator,
    *,
    source: str = "simulated",
) -> Recording:
    """Recording of the taxels of `array`.

    Parameters
    ----------
    array : TaxelArray
    sampling : Sampling
        From `array.sample_times`.
    change : (T, L) array
        ΔC/C₀ at `sampling.instants`.
    temperature : (T,) array, K, or None
    rng : numpy Generator
    source : str
        What the recording says about where it is from.

    Returns
    -------
    Recording
        One column per taxel, by uid; one row per reading that was logged.

    Raises
    ------
    InputError
        If every reading was lost on the way, or `change` has not a row per cycle.
    """
    counts = array.counts(change, temperature, rng)
    check_shape("change", counts, (len(sampling), len(array)), "one row per cycle of sampling")
    rows, stamps = sampling.logged
    if not len(rows):
        raise InputError(
            f"delivered is False for all {len(sampling)} readings, expected some: record longer, "
            "or lower lost_readings"
        )
    return Recording(
        stamps,
        counts[rows],
        array.patch.uid.copy(),
        array.electronics.board.unit,
        source,
    )
