"""Counts to what a reconstruction takes, each reading by itself."""

from dataclasses import dataclass

import numpy as np

from skinfield.conditioning import (
    Calibration,
    Convention,
    strain_from_relative_capacitance,
    valid_from_counts,
)
from skinfield.errors import Floats, InputError
from skinfield.mechanics import Layer
from skinfield.observation import BaseStress, Capacitance, Gap, Quantity


@dataclass(frozen=True, eq=False)
class Conditioner:
    """What turns recorded numbers into readings in a quantity's unit.

    Attributes
    ----------
    quantity : Quantity
    layer : Layer
    calibration : Calibration, optional
        Of counts; without it the numbers are in the quantity's unit already.
    board : Convention, optional
        That sent the counts.
    """

    quantity: Quantity
    layer: Layer
    calibration: Calibration | None = None
    board: Convention | None = None

    def __call__(self, counts: Floats) -> Floats:
        """Readings (T, L) from counts (T, L); NaN where invalid."""
        return self.counted(counts)[0]

    def counted(self, counts: Floats) -> tuple[Floats, int]:
        """Readings, and how many of them are too low for any skin: those are invalid, too."""
        values = self._values(counts)
        impossible = values <= self.quantity.lowest
        count = int(impossible.sum())
        return (np.where(impossible, np.nan, values) if count else values), count

    def _values(self, counts: Floats) -> Floats:
        if self.calibration is None:
            return counts
        if not np.isfinite(counts).any():
            return np.full(counts.shape, np.nan)
        change = self.calibration.relative_capacitance_from_counts(counts)
        valid = valid_from_counts(counts, self.board, alive=self.calibration.alive)
        return self.in_quantity(np.where(valid, change, np.nan))

    def in_quantity(self, change: Floats) -> Floats:
        """ΔC/C₀ as the quantity, each taxel by itself."""
        if isinstance(self.quantity, Capacitance):
            return change
        strain = strain_from_relative_capacitance(change)
        if isinstance(self.quantity, Gap):
            return strain
        return strain * self.layer.young_modulus

    def noise_in_quantity(self, noise: Floats) -> Floats:
        """Noise of ΔC/C₀ as that of the quantity, for small readings."""
        if isinstance(self.quantity, BaseStress):
            return noise * self.layer.young_modulus
        if isinstance(self.quantity, Capacitance | Gap):
            return noise
        raise InputError(
            f"quantity is {type(self.quantity).__name__}, expected Capacitance(), Gap() or "
            "BaseStress(): give a recording in the quantity's own unit"
        )
