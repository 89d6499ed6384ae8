"""Filters after one another, and none."""

from dataclasses import dataclass

import numpy as np

from skinfield.conditioning.filters.protocol import Filter, FilterState
from skinfield.errors import Floats, InputError, check_positive


@dataclass(frozen=True)
class NoFilter:
    """Passes every reading on."""

    def delay(self, rate: float) -> float:
        """0 s."""
        check_positive("rate", rate, "readings per second")
        return 0.0

    def noise_factor(self, rate: float) -> float:
        """1."""
        check_positive("rate", rate, "readings per second")
        return 1.0

    def prepare(self, taxels: int, rate: float) -> "NoFilterState":
        """A state without memory."""
        check_positive("rate", rate, "readings per second")
        return NoFilterState()


class NoFilterState:
    """No memory."""

    def apply(self, reading: Floats, out: Floats) -> None:
        """Copy `reading` (L,) to `out` (L,)."""
        np.copyto(out, reading)

    def reset(self) -> None:
        """Nothing to forget."""


@dataclass(frozen=True)
class Chain:
    """Filters one after the other, such as a median against outliers and then a smoother.

    Parameters
    ----------
    filters : tuple of Filter
    """

    filters: tuple[Filter, ...]

    def __post_init__(self) -> None:
        if not self.filters:
            raise InputError("filters is empty, expected at least one: NoFilter() does nothing")
        flat: list[Filter] = []
        for each in self.filters:
            flat += each.filters if isinstance(each, Chain) else [each]
        object.__setattr__(self, "filters", tuple(flat))

    def delay(self, rate: float) -> float:
        """Sum of the delays, s."""
        return sum(each.delay(rate) for each in self.filters)

    def noise_factor(self, rate: float) -> float:
        """Measured on white noise, to about 2 %: a filter leaves coloured noise to the next."""
        own = max(np.size(getattr(each, "noise_std", 0.0)) for each in self.filters)
        taxels = own if own > 1 else 200
        memory = int(50 * (1 + self.delay(rate) * rate))
        readings = max(memory, min(200_000 // taxels, 10_000))
        state, out = self.prepare(taxels, rate), np.empty(taxels)
        noise, power = np.random.default_rng(0), np.zeros(taxels)
        for n in range(memory + readings):
            state.apply(noise.standard_normal(taxels), out)
            power += out**2 * (n >= memory)
        return float(np.sqrt(np.nanmax(power) if own > 1 else np.mean(power)) / readings**0.5)

    def prepare(self, taxels: int, rate: float) -> "ChainState":
        """The states of all filters."""
        return ChainState([each.prepare(taxels, rate) for each in self.filters])


class ChainState:
    """The memories of all filters."""

    def __init__(self, states: list[FilterState]) -> None:
        self._states = states

    def apply(self, reading: Floats, out: Floats) -> None:
        """Write the filtered `reading` (L,) into `out` (L,); NaN stays NaN."""
        for state in self._states:
            state.apply(reading, out)
            reading = out

    def reset(self) -> None:
        """Forget all readings."""
        for state in self._states:
            state.reset()
