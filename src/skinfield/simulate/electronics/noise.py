"""Noise and temperature of readings: white with jumps, flicker, a walk; drift by warmth."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, as_floats
from skinfield.settings import Positive, Range, Section
from skinfield.simulate.electronics.delivery import Wiring

OFF_AT_0 = Range(0.0, 1e9, "a standard deviation; 0 is off")
BLOCK = 32
"""Taxels whose spectra are in memory at once."""
TAIL = 2.5
"""Degrees of freedom of the Student's t that jumps are drawn from."""


@dataclass(frozen=True, kw_only=True)
class Noise(Section):
    """What readings of an untouched skin do. Each is off at 0.

    Parameters
    ----------
    white : float, counts
        Standard deviation of a reading, of the median taxel; independent from reading to reading.
    spread : float
        Of the logarithm of `white` from taxel to taxel.
    limit : float
        Times `white`, which the noise of no taxel passes; 0: there is no limit.
    jumps : float
        Share of the white values that Student's t of 2.5 degrees of freedom draws, times `white`,
        in place of a normal distribution.
    common : float, counts
        Standard deviation of white noise that all taxels of one converter share.
    flicker : float, counts
        Bias instability B of 1/f noise of each taxel: power spectral density B²/(πf), one-sided,
        and an Allan deviation of B √(2 ln 2 / π), the same at every averaging time.
    walk : float, counts/√s
        Random walk K of each taxel: its standard deviation after t is K √t, its Allan deviation
        K √(τ/3).

    Notes
    -----
    White noise σ at a rate r has an Allan deviation of σ / √(r τ). The three names are those of
    IEEE Std 952.
    """

    white: Annotated[float, OFF_AT_0] = 0.0
    spread: Annotated[float, OFF_AT_0] = 0.0
    limit: Annotated[float, OFF_AT_0] = 0.0
    jumps: Annotated[float, Range(0.0, 1.0, "a share of the values; 0 is off")] = 0.0
    common: Annotated[float, OFF_AT_0] = 0.0
    flicker: Annotated[float, OFF_AT_0] = 0.0
    walk: Annotated[float, OFF_AT_0] = 0.0

    def draw(self, taxels: int, rng: np.random.Generator) -> Floats:
        """White noise of each taxel, (L,) counts."""
        times = np.exp(self.spread * rng.standard_normal(taxels))
        return np.asarray(self.white * np.minimum(times, self.limit or np.inf))

    def sample(
        self, white: Floats, wiring: Wiring, readings: int, rate: float, rng: np.random.Generator
    ) -> Floats:
        """Noise of `readings` at `rate`, 1/s, (T, L) counts, given `white` of each taxel (L,)."""
        shape = (readings, len(white))
        parts = rng.spawn(5)  # so that one kind switched off leaves the others as they were
        noise = np.zeros(shape)
        if white.any():
            noise += white * self.deviates(shape, parts[0], parts[4])
        if self.common:
            shared = parts[1].standard_normal((readings, wiring.converters))
            noise += self.common * shared[:, wiring.converter]
        if self.flicker:
            noise += self.flicker * unit_flicker(shape, parts[2])
        if self.walk:
            steps = parts[3].standard_normal(shape)
            steps[0] = 0.0
            noise += self.walk / math.sqrt(rate) * np.cumsum(steps, axis=0)
        return noise

    def deviates(
        self,
        shape: int | tuple[int, ...],
        normal: np.random.Generator,
        jumping: np.random.Generator,
    ) -> Floats:
        """White noise of `white` = 1: normal, and a normal one over √(χ²/k) where it jumps."""
        values = normal.standard_normal(shape)
        if self.jumps:
            jump = jumping.random(shape) < self.jumps
            values[jump] /= np.sqrt(jumping.chisquare(TAIL, int(jump.sum())) / TAIL)
        return values


def unit_flicker(shape: tuple[int, int], rng: np.random.Generator) -> Floats:
    """1/f noise (T, L) of power spectral density 1/(πf), one-sided, whatever the rate.

    White noise of twice the length is shaped in the frequency domain, and half of it kept, so that
    the end does not join the start. Below one cycle per twice the length there is nothing.
    """
    length = 2 * max(shape[0], 2)
    cycles = np.arange(length // 2 + 1) / length  # per sample
    # White noise of variance 1 has a one-sided density of 2 per cycle per sample.
    weight = np.zeros((len(cycles), 1))
    weight[1:, 0] = np.sqrt(1.0 / (np.pi * cycles[1:]) / 2.0)
    out = np.empty(shape)
    for first in range(0, shape[1], BLOCK):
        part = out[:, first : first + BLOCK]
        spectrum = np.fft.rfft(rng.standard_normal((length, part.shape[1])), axis=0)
        part[:] = np.fft.irfft(weight * spectrum, n=length, axis=0)[: shape[0]]
    return out


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
