"""Counts as a recording that cannot be told from a board's."""

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import check_shape
from skinfield.reading import Recording
from skinfield.simulate.electronics.array import TaxelArray
from skinfield.simulate.electronics.delivery import Sampling


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
        One column per taxel, by uid; the rows that were delivered.
    """
    counts = array.counts(change, temperature, rng)
    check_shape("change", counts, (len(sampling), len(array)), "one row per cycle of sampling")
    kept = sampling.delivered
    return Recording(
        sampling.stamp_ns[kept],
        counts[kept],
        array.patch.uid.copy(),
        array.electronics.board.unit,
        source,
    )
