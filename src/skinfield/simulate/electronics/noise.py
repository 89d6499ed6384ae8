"""Noise of readings: white with jumps, common to a converter, flicker, and a walk."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from skinfield.errors import Floats
from skinfield.settings import Range, Section
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
