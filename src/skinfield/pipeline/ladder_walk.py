"""Searches on several rungs as one: each goes on where the last one ended."""

from typing import Any

from skinfield.errors import Floats, InputError
from skinfield.inverse import FieldOperator


class Walk:
    """Who answered last, and what is known of that answer.

    Attributes
    ----------
    gap : float
        Relative duality gap; NaN where the solver states none.
    iterations : int
    """

    def __init__(self) -> None:
        self._last: FieldOperator | None = None
        self.gap, self.iterations = float("nan"), 0

    def apply(self, operator: FieldOperator, linear: Floats, out: Floats, end: int | None) -> None:
        """Answer by an operator; if it is another than before, from that one's dual variables."""
        last = self._last
        if last is not None and operator is not last and hasattr(operator, "start_from"):
            operator.start_from(last.dual)  # type: ignore[attr-defined]
        self._last = operator
        operator.apply(linear, out, end)
        self.gap = float(getattr(operator, "gap", float("nan")))
        self.iterations = int(getattr(operator, "iterations", 0))

    def forget(self) -> None:
        """Start the next answer from nothing that another rung found."""
        self._last = None


def offered(operator: FieldOperator, method: str) -> Any:
    """A method of an operator, or InputError if it has none."""
    found = getattr(operator, method, None)
    if found is None:
        raise InputError(
            f"the solver's {type(operator).__name__} has no {method!r}, expected an operator such "
            "as that of NonNegative(): for others, prepare a Reconstructor of what is wanted"
        )
    return found
