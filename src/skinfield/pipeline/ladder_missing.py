"""Taxels that did not answer, within the time of a cycle: what the others let expect of them."""

from collections import OrderedDict

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints

KEPT = 64  # sets of missing taxels whose maps stay at hand
Map = tuple[Ints, Ints, Floats]


class MissingTaxels:
    r"""Readings in place of missing ones, with which the linear answer is that of the valid taxels.

    Parameters
    ----------
    weights : (L, L) array
        Inverse covariance :math:`S^{-1}` of the readings that prior and noise let expect.

    Notes
    -----
    A Bayesian linear answer is :math:`p = Q A^T w` with :math:`w = S^{-1} y`. With

    .. math:: y_I = -\left((S^{-1})_{II}\right)^{-1} (S^{-1})_{IV} \, y_V

    the weights of the missing taxels I vanish, and those of the valid ones V become
    :math:`(S_{VV})^{-1} y_V` (inverse of a partitioned matrix): exactly the answer of an operator
    that was prepared without I. It is the mean of :math:`y_I` given :math:`y_V`.
    """

    def __init__(self, weights: Floats) -> None:
        self.weights = weights
        self._maps: OrderedDict[bytes, Map] = OrderedDict()

    def fill(self, readings: NDArray[np.floating], valid: NDArray[np.bool_]) -> None:
        """Overwrite what is not `valid` (L,) in `readings` (L,); at least one must be."""
        key = valid.tobytes()
        if key not in self._maps:
            if len(self._maps) >= KEPT:
                self._maps.popitem(last=False)
            self._maps[key] = self._map(valid)
        missing, given, expected = self._maps[key]
        self._maps.move_to_end(key)
        readings[missing] = expected @ readings[given]

    def _map(self, valid: NDArray[np.bool_]) -> Map:
        missing: Ints = np.flatnonzero(~valid).astype(np.int64)
        given: Ints = np.flatnonzero(valid).astype(np.int64)
        rows = self.weights[missing]
        return missing, given, np.asarray(-np.linalg.solve(rows[:, missing], rows[:, given]))
