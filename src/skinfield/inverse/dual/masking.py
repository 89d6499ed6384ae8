"""A search's arrays without some taxels, written in place. Compiled."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def mask_taxels(
    whole: NDArray[Any],
    whole_norms: NDArray[Any],
    whole_penalty: NDArray[Any],
    valid: NDArray[np.bool_],
    rows: NDArray[Any],
    norms: NDArray[Any],
    penalty: NDArray[Any],
) -> None:
    """Copy `whole` (K, W) into `rows` with zeros for taxels that are not `valid` (L,).

    Lengths of the rows, and penalties in proportion to them, follow.
    """
    for node in range(len(whole)):
        square = 0.0
        for taxel in range(len(valid)):
            value = whole[node, taxel] if valid[taxel] else whole.dtype.type(0.0)
            rows[node, taxel] = value
            square += np.float64(value) * value
        norms[node] = np.sqrt(square)
        before = whole_norms[node]
        penalty[node] = whole_penalty[node] * (norms[node] / before) if before > 0.0 else 0.0
