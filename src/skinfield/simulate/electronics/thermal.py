"""Temperature: its effect on readings."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, as_floats
from skinfield.settings import Positive, Range, Section
from skinfield.simulate.electronics.delivery import Wiring

ROOM = 298.15
"""K, 25 °C."""


@dataclass(frozen=True, kw_only=True)
class ThermalDrift(Section):
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

    per_kelvin: Annotated[float, Range(-1e9, 1e9, "counts per kelvin; 0 is off")] = 0.0
    converter_spread: Annotated[float, Range(0.0, 1e9, "counts per kelvin; 0 is off")] = 0.0
    taxel_spread: Annotated[float, Range(0.0, 1e9, "counts per kelvin; 0 is off")] = 0.0
    time_constant: Annotated[float, Range(0.0, 1e9, "seconds; 0 is no lag")] = 0.0
    reference: Annotated[float, Positive("in kelvin: 25 °C is 298.15")] = ROOM

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
