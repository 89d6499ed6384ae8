"""Search operator: what an engine asks of an iterative solver."""

from typing import Any, Protocol, Self, TypeGuard

import numpy as np
from numpy.typing import NDArray

from skinfield.solve import FieldOperator

STATED = ("gap", "objective", "iterations", "dual")
OFFERED = ("start_from", "twin", "reset", "without", "leave_out")


class Whitened(Protocol):
    """Prepared arrays of a search.

    Attributes
    ----------
    rows : (K, L or more) array
        What each cell's bump does to the taxels, in units of their noise; zeros beyond L.
    norms : (K,) array
        Length of each row.
    threshold : float
        Standard deviations: if no cell's matched readings exceed it, the answer is 0.
    tolerance : float
        Relative gap at which a search ends by itself.
    """

    rows: NDArray[Any]
    norms: NDArray[Any]
    threshold: float
    tolerance: float


class SearchOperator(FieldOperator, Protocol):
    """Prepared search for a field, that can be cut short and knows how far it came.

    Attributes
    ----------
    problem : Whitened
    gap : float
        Relative duality gap of the last answer.
    objective : float
        Of the last answer.
    iterations : int
    dual : (L,) array
        Where the last search ended; it means the same on every grid.
    """

    @property
    def problem(self) -> Whitened:
        """See above."""
        ...

    @property
    def gap(self) -> float:
        """See above."""
        ...

    @property
    def objective(self) -> float:
        """See above."""
        ...

    @property
    def iterations(self) -> int:
        """See above."""
        ...

    @property
    def dual(self) -> NDArray[Any]:
        """See above."""
        ...

    def start_from(self, dual: NDArray[Any]) -> None:
        """Start the next search from the `dual` of another."""
        ...

    def twin(self) -> Self:
        """Search of its own for another patch, with the same prepared arrays."""
        ...

    def reset(self) -> None:
        """Forget the reading before."""
        ...

    def without(self, valid: NDArray[np.bool_]) -> Self:
        """Search that leaves taxels out, with arrays of its own."""
        ...

    def leave_out(self, whole: Any, valid: NDArray[np.bool_]) -> None:
        """Become `whole.without(valid)` in place."""
        ...


def is_search(operator: object) -> TypeGuard[SearchOperator]:
    """Whether an operator offers all that."""
    return all(hasattr(operator, name) for name in STATED + OFFERED)


def idle_test_of(operator: SearchOperator, taxels: int) -> NDArray[Any]:
    """Matrix (K, L) whose products with whitened readings are at most `threshold` when idle."""
    norms = operator.problem.norms
    scale = np.divide(1.0, norms, out=np.zeros_like(norms), where=norms > 0)
    return np.asarray(operator.problem.rows[:, :taxels] * scale[:, None])


class ReducedSearch:
    """One search that leaves out whichever taxels are missing, for all patches of a kind in turn.

    What a search without some taxels needs is written anew where the missing ones change, which
    takes a few passes over one matrix and no memory.

    Parameters
    ----------
    whole : SearchOperator
        Of all taxels.
    taxels : int

    Attributes
    ----------
    search : SearchOperator
        With what was masked last.
    """

    def __init__(self, whole: SearchOperator, taxels: int) -> None:
        self._whole = whole
        self.search = whole.without(np.ones(taxels, np.bool_))
        self.mask(np.ones(taxels, np.bool_))  # loads what is compiled

    def mask(self, valid: NDArray[np.bool_]) -> SearchOperator:
        """Leave out what is not `valid` (L,)."""
        self.search.leave_out(self._whole, valid)
        return self.search
