"""What every filter offers."""

from typing import Protocol

from skinfield.errors import Floats


class FilterState(Protocol):
    """A prepared filter of L taxels, with its memory."""

    def apply(self, reading: Floats, out: Floats) -> None:
        """Write into `out` (L,) the filtered `reading` (L,). Allocates nothing.

        NaN marks a taxel that is invalid in this reading: it comes out as NaN and spoils nothing
        of what was remembered. `reading` and `out` may be the same array.
        """
        ...

    def reset(self) -> None:
        """Forget all readings."""
        ...


class Filter(Protocol):
    """Settings of a filter. Delay and noise hold once it has run in."""

    def prepare(self, taxels: int, rate: float) -> FilterState:
        """State for `taxels` taxels and `rate` readings per second."""
        ...

    def delay(self, rate: float) -> float:
        """Seconds by which the output lags behind a steady ramp."""
        ...

    def noise_factor(self, rate: float) -> float:
        """Standard deviation of the output over that of the input, for independent readings.

        A port that repeats each value n times gives noise that is not independent: less of it is
        taken away, about as much as at rate / n where the settings are times, and next to nothing
        by a median of fewer than 2n readings.
        """
        ...
