"""Boards: from a level, the count that one without steps and clamps would send, to what is sent."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from skinfield.elastic import Layer
from skinfield.errors import Floats, as_floats, check_positive
from skinfield.signal import CySkinCount, ICubByte

PAD_CAPACITANCE = Layer().rest_capacitance(4e-3)
"""F, of a round 4 mm pad under 2 mm of silicone: 0.167 pF."""
AD7147_FARADS = 16e-12 / 65536
"""F per count of the converter on these boards: 16 bits over about 16 pF, 0.244 fF."""


@dataclass(frozen=True, kw_only=True)
class ICubBoard:
    """One byte per taxel, by the firmware's rule.

    Parameters
    ----------
    convention : ICubByte
        Its `no_load` and `shift`; 240 and 2 are the settings on robots.
    rest_capacitance : float, F
        C₀ of a pad; default that of a 4 mm pad under 2 mm of silicone.
    farads_per_count : float, F
        Of the converter, before the shift. The default is that of the AD7147.
    """

    convention: ICubByte = field(default_factory=ICubByte)
    rest_capacitance: float = PAD_CAPACITANCE
    farads_per_count: float = AD7147_FARADS

    unit = "count"
    step = 1.0

    @property
    def size(self) -> int:
        """Converter's counts per count that is sent."""
        return 1 << self.convention.shift

    @property
    def rest(self) -> float:
        """Level of an unloaded taxel: amid the differences that are sent as `no_load`."""
        return self.convention.no_load + (self.size - 1) / (2.0 * self.size)

    @property
    def gain(self) -> float:
        """Counts per unit of ΔC/C₀, negative, of a taxel of nominal gain."""
        return self.convention.gain(self.rest_capacitance, self.farads_per_count)

    def counts_from_level(self, level: Floats) -> Floats:
        """What is sent: the converter rounds, the board shifts and clamps. NaN stays NaN."""
        difference = np.rint((self.rest - as_floats("level", level)) * self.size)
        return self.convention.counts_from_difference(difference)


@dataclass(frozen=True, kw_only=True)
class CySkinBoard:
    """A 16-bit word per taxel, clipped at 0.

    Parameters
    ----------
    convention : CySkinCount
    gain : float, counts per unit of ΔC/C₀
        Assumed: presses of up to about 20 000 counts are on record, and firm ones change C₀ by
        some 0.7.
    """

    convention: CySkinCount = field(default_factory=CySkinCount)
    gain: float = 30e3

    unit = "count"
    rest = 0.0  # the board takes the baseline off
    step = 1.0

    def __post_init__(self) -> None:
        check_positive("gain", self.gain, "counts per unit of ΔC/C₀; pressure raises the count")

    def counts_from_level(self, level: Floats) -> Floats:
        """What is sent; NaN stays NaN."""
        return self.convention.counts_from_difference(level)


@dataclass(frozen=True, kw_only=True)
class LinearBoard:
    """No steps and no clamps: readings are ΔC/C₀ as they are."""

    convention = None
    unit = "dC/C0"
    rest = 0.0
    gain = 1.0
    step = 0.0

    def counts_from_level(self, level: ArrayLike) -> Floats:
        """What is sent; NaN stays NaN."""
        return as_floats("level", level)


Board = ICubBoard | CySkinBoard | LinearBoard
"""Convention of its counts, their unit, level at rest and gain (counts per unit of ΔC/C₀), step."""
