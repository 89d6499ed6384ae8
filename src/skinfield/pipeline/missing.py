"""Readings that lack taxels, each others if need be, by what is prepared for all taxels."""

from collections import OrderedDict
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, Ints
from skinfield.inverse import GaussianModel, TaxelSets
from skinfield.inverse.taxel_sets import SetError

if TYPE_CHECKING:
    from skinfield.pipeline.plan import LinearPlan, Results

CHUNK = 512  # readings per matrix product: the outputs stay in cache
SETS = 16  # at once: their deviations stay in cache
CALLS_KEPT = 16  # whose sets of taxels stay prepared


class Prepared:
    """Sets of valid taxels with what each reading of them needs.

    Attributes
    ----------
    sets : TaxelSets
        P of them.
    errors : list of P pairs of SetError
        Of the posterior, and by the readings' noise alone.
    """

    def __init__(self, sets: TaxelSets) -> None:
        self.sets = sets

    @cached_property
    def errors(self) -> list[tuple[SetError, SetError]]:
        """Of the sets, one after the other: computed when contacts are first asked for."""
        return self.sets.errors()


@dataclass(frozen=True, eq=False)
class MissingTaxels:
    """Answers a linear plan's readings of which some taxels are not valid.

    Attributes
    ----------
    model : GaussianModel
        On the plan's nodes.
    """

    model: GaussianModel
    _kept: OrderedDict[bytes, Prepared] = field(default_factory=OrderedDict)

    def solve(
        self,
        plan: "LinearPlan",
        readings: Floats,
        valid: NDArray[np.bool_],
        rows: Ints,
        out: "Results",
    ) -> None:
        """Write the answers of `readings` (R, L), where `valid` (R, L), into `rows` of `out`."""
        patterns, which = distinct(valid)
        order = np.argsort(which, kind="stable")
        which = which[order]
        for first in range(0, len(patterns), SETS):
            start, end = np.searchsorted(which, [first, first + SETS])
            prepared = self.prepared(patterns[first : first + SETS])
            for begin in range(start, end, CHUNK):
                chunk = order[begin : min(begin + CHUNK, end)]
                table = np.where(valid[chunk], readings[chunk], 0.0)
                part = which[begin : begin + len(chunk)] - first
                _solve(plan, prepared, table, part, rows[chunk], out)

    def prepared(self, patterns: NDArray[np.bool_]) -> Prepared:
        """Sets of valid taxels (P, L), of which those of the last calls are kept."""
        key = np.packbits(patterns, axis=1).tobytes()
        if key not in self._kept:
            prepared = Prepared(self.model.sets(patterns))
            if len(patterns) == SETS:  # of many, that will hardly come again
                return prepared
            if len(self._kept) >= CALLS_KEPT:
                self._kept.popitem(last=False)
            self._kept[key] = prepared
        self._kept.move_to_end(key)
        return self._kept[key]


def distinct(valid: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], Ints]:
    """Different rows of a mask (R, L), and which of them each row is (R,)."""
    packed = np.packbits(valid, axis=1)
    keys = packed.view(np.dtype((np.void, packed.shape[1]))).ravel()  # rows are compared as bytes
    _, first, which = np.unique(keys, return_index=True, return_inverse=True)
    return valid[first], which


def _solve(
    plan: "LinearPlan", known: Prepared, table: Floats, which: Ints, rows: Ints, out: "Results"
) -> None:
    """Fill in what is missing, so that one product serves all; contacts one by one."""
    setting, nodes, sets = plan.setting, len(plan.setting.grid), known.sets
    linear = setting.quantity.linearise(table, np.empty_like(table))
    filled = sets.filled(linear, which)
    out.gap[rows] = 0.0
    out.fields[rows] = (plan.operator @ filled.T.astype(setting.precision)).T
    left = linear - filled @ plan.explained.T
    out.residual[rows] = np.where(sets.valid[which], left, np.nan)
    for row, place in zip(rows, which, strict=True):
        posterior, noise = known.errors[place]
        out.pressure_std[row] = posterior.std
        out.contacts[row] = plan.contacts(out.fields[row, :nodes], noise, posterior)
