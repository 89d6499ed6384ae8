"""Taxels that did not answer: what the others let expect of them."""

from collections import OrderedDict
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.inverse import InverseOperator, Solver, TaxelSets
from skinfield.pipeline.ladder_rungs import Rung, Rungs, linear_rung

KEPT = 64  # sets of missing taxels whose maps stay at hand
SETS = 16  # of valid taxels whose matrices stay at hand
Map = tuple[Ints, Ints, Floats]


class FilledReadings:
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


class ValidTaxels:
    """A ladder's linear answer from some of its taxels, as a solver prepares it for them alone.

    Parameters
    ----------
    rungs : Rungs
    solver : Solver
        Linear.
    valid : (L,) bool array
    """

    def __init__(self, rungs: Rungs, solver: Solver, valid: NDArray[np.bool_]) -> None:
        self.valid, self._rungs, self._solver = valid, rungs, solver
        gaussian = rungs.start.gaussian
        self._set: TaxelSets | None = None if gaussian is None else gaussian.sets(valid[None])
        self._steps: dict[int, Rung] = {}

    def readings(self, linear: Floats) -> Floats:
        """Linearised readings (L,), missing ones 0, as those that `matrix` is for."""
        if self._set is None:
            return linear
        return np.asarray(self._set.filled(linear[None], np.zeros(1, dtype=np.int64))[0])

    def matrix(self, step: Rung) -> Floats:
        """From these to the pressure on a rung, (K, L)."""
        return step.matrix if self._set is not None else self.on(step).matrix

    @cached_property
    def explained(self) -> Floats:
        """From these to what the answer predicts of them, (L, L)."""
        if self._set is not None:
            return self._rungs.explained
        return np.asarray(self._rungs.model.matrix @ self._widened(self._prepared.matrix))

    def on(self, step: Rung) -> Rung:
        """What a rung would be, had the patch the valid taxels alone; 0 for the others."""
        if step.nodes not in self._steps:
            model = self._rungs.model.subset(self.valid)
            made = linear_rung(step.nodes, step.deformation, self._prepared, model)
            self._steps[step.nodes] = replace(made, matrix=self._widened(made.matrix))
        return self._steps[step.nodes]

    @cached_property
    def _prepared(self) -> InverseOperator:
        without = self._rungs.start.without(self.valid)
        if without is not None:
            return without
        operator = self._solver.prepare(self._rungs.model.subset(self.valid))
        assert isinstance(operator, InverseOperator)  # as it is of all taxels
        return operator

    def _widened(self, matrix: Floats) -> Floats:
        wide = np.zeros((len(matrix), len(self.valid)))
        wide[:, self.valid] = matrix
        return wide


class ValidSets:
    """Sets of valid taxels of a linear ladder, of which the last stay prepared."""

    def __init__(self, rungs: Rungs, solver: Solver) -> None:
        self._made_of = rungs, solver
        self._kept: OrderedDict[bytes, ValidTaxels] = OrderedDict()

    def of(self, valid: NDArray[np.bool_]) -> ValidTaxels:
        """Of a mask (L,), with at least one taxel."""
        key = valid.tobytes()
        if key not in self._kept:
            if len(self._kept) >= SETS:
                self._kept.popitem(last=False)
            self._kept[key] = ValidTaxels(*self._made_of, valid.copy())
        self._kept.move_to_end(key)
        return self._kept[key]
