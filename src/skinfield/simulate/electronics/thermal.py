"""Temperature: its effect on readings, the iCub's thermal pads, and the boards' correction."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import Floats, InputError, as_floats, check_positive, check_range
from skinfield.signal.boards import GAINS, PAD, UNUSED, firmware_drift
from skinfield.simulate.electronics.delivery import INPUTS, Wiring

ROOM = 298.15
"""K, 25 °C."""


@dataclass(frozen=True, kw_only=True)
class ThermalDrift:
    """Counts that follow the temperature, with a lag.

    Parameters
    ----------
    per_kelvin : float, counts/K
        Of all taxels. 0: none.
    converter_spread : float, counts/K
        Standard deviation of what the taxels of one converter have more or less, together.
    taxel_spread : float, counts/K
        Standard deviation of what each taxel has more or less.
    time_constant : float, s
        Of the skin behind the temperature of its surroundings; 0 for none.
    reference : float, K
        Temperature at which the baseline was taken.
    """

    per_kelvin: float = 0.0
    converter_spread: float = 0.0
    taxel_spread: float = 0.0
    time_constant: float = 0.0
    reference: float = ROOM

    def __post_init__(self) -> None:
        check_range("per_kelvin", self.per_kelvin, -1e9, 1e9, "counts per kelvin; 0 is off")
        for name in ("converter_spread", "taxel_spread"):
            check_range(name, getattr(self, name), 0.0, 1e9, "counts per kelvin; 0 is off")
        check_range("time_constant", self.time_constant, 0.0, 1e9, "seconds; 0 is no lag")
        check_positive("reference", self.reference, "in kelvin: 25 °C is 298.15")

    def draw(self, wiring: Wiring, rng: np.random.Generator) -> Floats:
        """Drift of each taxel, (L,) counts/K."""
        together = rng.standard_normal(wiring.converters)[wiring.converter]
        alone = rng.standard_normal(len(wiring.converter))
        return np.asarray(
            self.per_kelvin + self.converter_spread * together + self.taxel_spread * alone
        )

    def warmth(self, temperature: ArrayLike, rate: float) -> Floats:
        """How much warmer than at the reference the skin is, (T,) K.

        Parameters
        ----------
        temperature : (T,) array, K
            Of the surroundings, at readings of `rate`, 1/s. The skin starts at the first one.
        """
        from skinfield.elastic.viscoelastic import lagged

        temperature = as_floats("temperature", temperature)
        time = np.arange(len(temperature)) / rate
        return lagged(time, temperature, self.time_constant, start=temperature[0]) - self.reference


@dataclass(frozen=True, kw_only=True)
class ThermalPads:
    """Thermal drift by the pattern of the firmware's gains, and the firmware's correction of it.

    What remains is rounding, the noise of the pad, and the faults of a pad, which shift every
    taxel of a triangle. A mismatch of taxel and gain is `ThermalDrift`, added to this.

    Parameters
    ----------
    per_kelvin : float, converter counts/K
        Of the pad. Assumed.
    noise : float, converter counts
        Standard deviation of a reading of the pad. The pads of a real foot had 0.5 to 0.7 counts
        at a shift of 2, steps included.
    failed : float
        Probability that a pad has a fault. 0: none.
    failed_by : float, converter counts
        What a pad with a fault reads too little.
    gains : tuple of 12 int
    negated_first : bool
        See `firmware_drift`.
    """

    per_kelvin: float = 10.0
    noise: float = 2.0
    failed: float = 0.0
    failed_by: float = 200.0
    gains: tuple[int, ...] = GAINS
    negated_first: bool = False

    def __post_init__(self) -> None:
        check_range("per_kelvin", self.per_kelvin, -1e4, 1e4, "converter counts per kelvin")
        check_range("noise", self.noise, 0.0, 1e4, "converter counts; 0 is off")
        check_range("failed", self.failed, 0.0, 1.0, "a probability; 0 is off")
        check_range("failed_by", self.failed_by, -1e5, 1e5, "converter counts")
        if len(self.gains) != INPUTS:
            raise InputError(
                f"gains has {len(self.gains)} entries, expected {INPUTS}: one per channel"
            )

    def check_wiring(self, wiring: Wiring) -> None:
        """Raise InputError if a taxel is where a thermal pad has to be."""
        taken = np.flatnonzero((wiring.stage == PAD) | (wiring.stage == UNUSED))
        if len(taken):
            raise InputError(
                f"taxel {taken[0]} is at channel {wiring.stage[taken[0]]} of its triangle, "
                f"expected thermal pads at {PAD} and {UNUSED}: use a patch of ten-pad triangles, "
                "or no thermal pads"
            )

    def draw(self, wiring: Wiring, rng: np.random.Generator) -> Floats:
        """Error of the pad of each converter, (converters,) converter counts."""
        bad = rng.random(wiring.converters) < self.failed
        return np.where(bad, -float(self.failed_by), 0.0)

    def remainder(
        self, warmth: Floats, error: Floats, wiring: Wiring, rng: np.random.Generator
    ) -> Floats:
        """Drift less correction, (T, L) converter counts.

        Parameters
        ----------
        warmth : (T,) array, K
            Above the reference.
        error : (converters,) array, converter counts
            Of the pads, from `draw`.
        """
        gains = np.array(self.gains, dtype=np.float64)[wiring.stage]
        drift = self.per_kelvin * warmth[:, None]
        noise = self.noise * rng.standard_normal((len(warmth), wiring.converters))
        pads: NDArray[np.float64] = np.rint(drift + error + noise)[:, wiring.converter]
        taken = firmware_drift(pads, gains, negated_first=self.negated_first)
        return np.asarray(drift * gains / 128.0 - taken)
