"""The converter of the paper's module: farads to counts and back."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skinfield.conditioning.convention import Bools
from skinfield.errors import Floats, InputError, as_floats, check_positive, check_range


@dataclass(frozen=True, kw_only=True)
class CapacitanceConverter:
    """A linear capacitance-to-digital converter with a range, a step and a clamp at both ends.

    The default is the paper's: 4 to 30 pF in steps of 0.32 pF. Those figures cannot describe the
    change of the paper's own pad: a 4 mm pad over 2 mm of silicone has 0.167 pF in all, half a
    step, so its pressure would have to more than double its capacitance to move one count
    (`relative_step` says so in numbers). Real boards resolve femtofarads. Give the real step
    where it is known, and the capacitance of tracks and neighbours that the pad rides on.

    Parameters
    ----------
    low, high : float, F
        Input capacitance at the first and the last count.
    step : float, F
        Change of the input that moves one count.
    parasitic : float, F
        Input capacitance that is not the pad's, and does not change with pressure.
    """

    low: float = 4e-12
    high: float = 30e-12
    step: float = 0.32e-12
    parasitic: float = 10e-12

    def __post_init__(self) -> None:
        check_positive("step", self.step, "in farads, 0.32 pF is 0.32e-12")
        check_range("parasitic", self.parasitic, 0.0, 1e-6, "in farads, 10 pF is 10e-12")
        if not 0.0 <= self.low < self.low + self.step <= self.high < 1e-6:
            raise InputError(
                f"low is {self.low!r} F and high {self.high!r} F, expected 0 <= low < high with at "
                f"least one step of {self.step!r} F between them: give farads, 4 pF is 4e-12"
            )

    @property
    def lowest(self) -> float:
        """First count."""
        return 0.0

    @property
    def highest(self) -> float:
        """Last count: whole steps between `low` and `high`."""
        return float(np.floor((self.high - self.low) / self.step + 1e-9))

    @property
    def rest(self) -> float:
        """NaN: it depends on the pad and on its calibration."""
        return float("nan")

    @property
    def direction(self) -> int:
        """+1: pressure raises the capacitance and the count."""
        return 1

    def saturated(self, counts: Floats) -> Bools:
        """Where a count is the first or the last."""
        return np.asarray((counts <= self.lowest) | (counts >= self.highest))

    def counts_from_capacitance(self, capacitance: ArrayLike) -> Floats:
        """Counts, whole numbers, of pads of `capacitance`, F; clamped to the range.

        NaN stays NaN. Ask `saturated(counts)` where the clamp was met.
        """
        total = as_floats("capacitance", capacitance) + self.parasitic
        return np.clip(np.rint((total - self.low) / self.step), self.lowest, self.highest)

    def capacitance_from_counts(self, counts: ArrayLike) -> Floats:
        """Capacitance of the pads, F, from counts: the middle of the step, ± half a step.

        At a clamp it is only a bound: ask `saturated(counts)`.
        """
        return as_floats("counts", counts) * self.step + self.low - self.parasitic

    def gain(self, rest_capacitance: float) -> float:
        """Counts per unit of ΔC/C₀ of a pad of `rest_capacitance`, F."""
        check_positive("rest_capacitance", rest_capacitance, "C₀ of the pad in farads")
        return rest_capacitance / self.step

    def relative_step(self, rest_capacitance: float) -> float:
        """Change of ΔC/C₀ that moves one count, for a pad of `rest_capacitance`, F."""
        return 1.0 / self.gain(rest_capacitance)
