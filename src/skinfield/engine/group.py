"""Patches of one kind: one prepared plan, and room for the answers of each."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skinfield.engine.interning import Kind
from skinfield.engine.products import SharedProduct, Singles
from skinfield.engine.searching import ReducedSearch, SearchOperator, is_search
from skinfield.engine.stamped_product import product_of
from skinfield.errors import Floats, InputError
from skinfield.pipeline.ladder_missing import FilledReadings
from skinfield.pipeline.ladder_rungs import Rungs

SHARED = object()  # in place of the search that a patch used last: its dual was copied


@dataclass(eq=False)
class Group:
    """Prepared answers of P patches of one kind on R rungs.

    Parameters
    ----------
    index : int
        Among the groups.
    first : int
        Row of its first patch among all patches.
    kind : Kind
    rungs : Rungs

    Attributes
    ----------
    products : R of SharedProduct
        From whitened readings to the linear answer.
    fields : R arrays (P, K) float32, Pa
        Linear answers.
    thresholds : R floats
        Of idle tests; none where linear.
    tolerances : R floats
        Gaps at which searches end by themselves.
    searches : R lists of P SearchOperator
    feasible : R arrays (P, K), Pa
        Their answers.
    rows_of_feasible : R lists of P arrays (K,)
        Each patch's part of them.
    duals : (P, L) array
        Where the last search of each patch ended, if it left taxels out.
    filler : FilledReadings
        Of whitened readings.
    """

    index: int
    first: int
    kind: Kind
    rungs: Rungs
    products: list[SharedProduct] = field(init=False)
    fields: list[Singles] = field(init=False)
    thresholds: list[float] = field(init=False)
    tolerances: list[float] = field(init=False)
    searches: list[list[SearchOperator]] = field(init=False)
    feasible: list[Floats] = field(init=False)
    rows_of_feasible: list[list[Floats]] = field(init=False)
    duals: Floats = field(init=False)

    def __post_init__(self) -> None:
        steps, count, noise = self.rungs.steps, len(self.kind.patches), self.kind.noise_std
        self.products = [product_of(step.matrix * noise, step.grid) for step in steps]
        self.fields = [np.zeros((count, len(step.grid)), np.float32) for step in steps]
        self.thresholds, self.tolerances, self.searches, self.feasible = [], [], [], []
        for step in steps:
            if step.operator is None:
                continue
            if not is_search(step.operator):
                raise InputError(
                    f"the solver's {type(step.operator).__name__} can neither be cut short nor "
                    "tell its gap, expected an operator such as that of NonNegative()"
                )
            self.thresholds.append(step.operator.problem.threshold)
            self.tolerances.append(step.operator.problem.tolerance)
            twins = [step.operator, *(step.operator.twin() for _ in range(count - 1))]
            self.searches.append(twins)
            self.feasible.append(np.zeros((count, len(step.grid))))
        self.rows_of_feasible = [list(fields) for fields in self.feasible]
        self.duals = np.zeros((count, len(noise)))
        self._last: list[Any] = [None] * count
        self.filler = FilledReadings(self.rungs.weights * np.outer(noise, noise))
        self._reduced = [ReducedSearch(twins[0], len(noise)) for twins in self.searches]

    @property
    def count(self) -> int:
        """Number of patches."""
        return len(self.kind.patches)

    @property
    def rows(self) -> slice:
        """Its patches among all."""
        return slice(self.first, self.first + self.count)

    def answer_all(self, rung: int, white: Singles) -> None:
        """Linear answers of all patches from whitened readings (P, L)."""
        self.products[rung].apply(white, self.fields[rung])

    def answer_one(self, rung: int, place: int, white: Singles) -> None:
        """Linear answer of one patch, its readings among those (P, L) of all."""
        here = slice(place, place + 1)
        self.products[rung].apply(white[here], self.fields[rung][here])

    def search_of(self, rung: int, place: int, valid: NDArray[np.bool_] | None) -> SearchOperator:
        """Search of a patch, which goes on where the patch's last one ended.

        If not all taxels are valid, it is one that all patches share.
        """
        last = self._last[place]
        if valid is None:
            operator = self.searches[rung][place]
            if last is operator:
                return self.searches[rung][place]
        else:
            operator = self._reduced[rung].mask(valid)
        if last is not None:
            operator.start_from(self.duals[place] if last is SHARED else last.dual)
        self._last[place] = operator
        return operator

    def remember(self, place: int, shared: SearchOperator) -> None:
        """Keep where a patch's search ended that another patch will use next."""
        np.copyto(self.duals[place], shared.dual)
        self._last[place] = SHARED

    def reset(self) -> None:
        """Forget the readings before."""
        for twins in self.searches:
            for each in twins:
                each.reset()
        self._last = [None] * self.count
