"""What an engine asks of an iterative solver."""

from typing import Protocol, Self, TypeGuard

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats
from skinfield.inverse import FieldOperator

NEEDED = ("gap", "iterations", "deadline_met", "dual", "twin", "reset", "without", "strength")


class SearchOperator(FieldOperator, Protocol):
    """Prepared search for a field, that can be cut short and knows how far it came.

    Attributes
    ----------
    gap : float
        Relative duality gap of the last answer.
    iterations : int
    deadline_met : bool
        Whether the last search came to its own end before its deadline.
    dual : (L,) array
        Where the next search starts; it means the same on every grid.
    signatures : (K, L) array
        Whitened readings per unit on a cell.
    strength : (K,) array
        Their norms.
    threshold : float
        Standard deviations: if no cell's matched readings exceed it, the answer is 0.
    """

    gap: float
    iterations: int
    deadline_met: bool
    dual: Floats

    @property
    def signatures(self) -> Floats:
        """See above."""
        ...

    @property
    def strength(self) -> Floats:
        """See above."""
        ...

    @property
    def threshold(self) -> float:
        """See above."""
        ...

    def twin(self) -> Self:
        """Search of its own for another patch, with the same prepared arrays."""
        ...

    def reset(self) -> None:
        """Forget the reading before."""
        ...

    def without(self, valid: NDArray[np.bool_]) -> Self:
        """Search that leaves taxels out."""
        ...


def is_search(operator: object) -> TypeGuard[SearchOperator]:
    """Whether an operator offers all that."""
    return all(hasattr(operator, name) for name in NEEDED)


def idle_test_of(operator: SearchOperator) -> Floats:
    """Matrix (K, L) whose products with whitened readings are at most `threshold` when idle."""
    strength = operator.strength
    scale = np.divide(1.0, strength, out=np.zeros_like(strength), where=strength > 0)
    return operator.signatures * scale[:, None]
