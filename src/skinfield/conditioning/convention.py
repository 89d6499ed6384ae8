"""What counts mean before any taxel is calibrated."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats

Bools = NDArray[np.bool_]


class Convention(Protocol):
    """How a maker's board codes what a taxel feels. `ICubByte`, `CySkinCount`, one's own."""

    @property
    def lowest(self) -> float:
        """Least count that can be sent."""
        ...

    @property
    def highest(self) -> float:
        """Largest count that can be sent."""
        ...

    @property
    def rest(self) -> float:
        """Count of an unloaded taxel by convention; NaN where there is none."""
        ...

    @property
    def direction(self) -> int:
        """Sign of the change of a count under pressure: -1 or +1."""
        ...

    def saturated(self, counts: Floats) -> Bools:
        """Where a count is at a clamp and says only that the load is off the scale."""
        ...
