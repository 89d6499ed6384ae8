"""What a cycle did, step by step."""

from typing import NamedTuple

from skinfield.engine.state import Step
from skinfield.errors import Floats, Ints

Logged = tuple[int, int, int, int, int, int, float] | tuple[Ints, Floats]


class Done(NamedTuple):
    """One step that was taken.

    Attributes
    ----------
    step : int
        Of `Step`; see `kind`.
    group : int
    patch : int
        Row of the patch; -1 for a step of all patches of a kind.
    rung : int
    start, end : int, ns
        Of the engine's clock.
    predicted : float, s
    """

    step: int
    group: int
    patch: int
    rung: int
    start: int
    end: int
    predicted: float

    @property
    def kind(self) -> Step:
        """What kind of step it was."""
        return Step(self.step)
